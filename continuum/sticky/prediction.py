"""What can be said about one contact: roughness, estimates of every theory, faults of the maps, the solution.

Everything is in one consistent system of units: SI where it begins with a file.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from continuum.sticky.criteria import AREA, Estimate, RoughContact
from continuum.sticky.materials import Interface
from continuum.theory import paper
from continuum.topography.faults import Findings, MapFault
from continuum.topography.map import Topography, opposed
from continuum.topography.roughness import Cut, Fit, Roughness

if TYPE_CHECKING:
    from continuum.show.sheet import Sheet
    from continuum.sticky.simulate import Simulation


@dataclass(frozen=True, eq=False)
class Prediction:
    """What can be said about one contact."""

    topographies: tuple[Topography, ...] = field(repr=False)
    """One, or two rough bodies."""
    roughness: Roughness = field(repr=False)
    """Roughness of both bodies together."""
    fits: tuple[Fit | None, ...]
    """Self-affine fit of each spectrum."""
    interface: Interface
    contact: RoughContact
    estimates: tuple[Estimate, ...] = field(repr=False)
    """Every criterion and number of :mod:`continuum.sticky.criteria`, the paper's first."""
    cuts: tuple[tuple[Cut, tuple[Estimate, ...]], ...] = field(repr=False)
    """Roughness above each cut-off wavelength, ascending, and the verdicts on it."""
    warnings: tuple[str, ...]
    """What to doubt, in words."""
    findings: tuple[Findings, ...] = field(default=(), repr=False)
    """What is wrong with each map."""
    mended: Prediction | None = field(default=None, repr=False)
    """The same where faults that have a remedy are mended; None where there are none."""
    simulation: Simulation | None = field(default=None, repr=False)
    """The contact of the map itself, where it was solved."""
    unsolved: str = ""
    """Why it could not be solved, where it was tried."""

    @property
    def doubts(self) -> tuple[str, ...]:
        """Warnings of the prediction, of its solution, or why there is none."""
        solved = () if self.simulation is None else self.simulation.warnings
        return (*self.warnings, *solved, *([f"not solved: {self.unsolved}"] if self.unsolved else []))

    @property
    def faults(self) -> tuple[MapFault, ...]:
        """Faults of the maps."""
        return tuple(fault for found in self.findings for fault in found.faults)

    @property
    def verdicts(self) -> tuple[Estimate, ...]:
        """The criteria of stickiness."""
        return tuple(estimate for estimate in self.estimates if estimate.margin is not None)

    @property
    def paper(self) -> Estimate:
        """The paper's criterion."""
        return self.estimates[0]

    def number(self, key: str) -> Estimate:
        """An estimate by the key of its entry in :data:`continuum.sticky.criteria.CRITERIA`."""
        return next(estimate for estimate in self.estimates if estimate.key == key)

    @property
    def kappa(self) -> float:
        """κ of N/A_rep = h' E*/κ; negative where sticky."""
        inverse = self.number("inverse-kappa").value
        return 1 / inverse if inverse else float("inf")

    @property
    def load(self) -> float:
        """Load per area at a repulsive area of 1 %, by the paper; negative: a tension that the contact bears."""
        contact = self.contact
        return AREA * paper.repulsive_pressure(contact.rms_slope, self.kappa, contact.contact_modulus)

    @property
    def distinct(self) -> list[int]:
        """Places of the criteria whose margins differ: asperity theories share one."""
        margins = [estimate.margin for estimate in self.verdicts]
        return [i for i, margin in enumerate(margins) if margin not in margins[:i]]

    @property
    def facing(self) -> Topography:
        """The map of the contact, or its two maps put face to face.

        Raises
        ------
        TopographyError
            If that cannot be done.
        """
        maps = self.topographies
        return maps[0] if len(maps) == 1 else opposed(*maps)

    def solved(self, threads: int = 1) -> Prediction:
        """The prediction with the contact of its map, solved, beside it; or with the reason why it cannot be solved.

        Parameters
        ----------
        threads : of the solver.

        Raises
        ------
        TopographyError
            If two maps cannot be put face to face.
        """
        from continuum.solve.solution import NotConvergedError
        from continuum.sticky.simulate import UnresolvedError, simulate  # compiled, and rarely asked for

        try:
            return replace(self, simulation=simulate(self.facing, self.interface, threads))
        except (UnresolvedError, NotConvergedError) as error:
            return replace(self, unsolved=str(error))

    @property
    def sentence(self) -> str:
        """The answer in one sentence."""
        from continuum.show.prediction import prediction_sentence

        return prediction_sentence(self)

    def sheets(self) -> list[Sheet]:
        """Tables of surface, contact, verdicts and numbers."""
        from continuum.show.prediction import prediction_sheets

        return prediction_sheets(self)

    def json(self) -> str:
        """Everything, with the whole spectrum, in SI units."""
        from continuum.show.prediction_data import as_json

        return as_json(self)

    def row(self) -> dict[str, str | float | None]:
        """One row of a table, in SI units."""
        from continuum.show.prediction_data import row

        return row(self)

    def write(self, folder: str | Path, name: str) -> list[Path]:
        """Write ``NAME.html`` and its figures; returns HTML and PNG files.

        Raises
        ------
        OutputError
            If they cannot be written there.
        """
        from continuum.show.prediction import write_prediction

        return write_prediction(self, Path(folder), name)

    def _repr_html_(self) -> str:
        return f"<p>{self.sentence}</p>{self.sheets()[3]._repr_html_()}"
