"""The prediction for one contact: roughness, estimates of every theory, faults of the maps, solution, warnings.

All numbers are in one consistent system of units: SI if they come from a file.  It combines the equations of
:mod:`continuum.theory.paper` with the verdicts and ranges of :mod:`continuum.sticky.criteria`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from continuum.arguments import ArgumentError, instance, number
from continuum.sticky.continuation import Continuation, continuation_of
from continuum.sticky.criteria import ANSWERS, AREA, Answer, Estimate, RoughContact, every_estimate, verdicts
from continuum.sticky.doubts import prediction_doubts
from continuum.sticky.materials import Interface
from continuum.sticky.probe import ProbePullOff, probe_doubts, probe_pull_off
from continuum.theory import paper
from continuum.topography.faults import NOT_GAUSSIAN, Findings, MapFault, find_faults
from continuum.topography.map import Topography, opposed
from continuum.topography.roughness import Cut, Fit, Roughness, fit_self_affine, roughness_of, spectrum, together
from continuum.topography.summits import summit_ratios

if TYPE_CHECKING:
    from continuum.show.sheet import Sheet
    from continuum.sticky.simulate import Simulation
    from continuum.sticky.solved_turn import SolvedTurn


SMALL = 512**2
"""Largest number of points of a map that is solved by default: seconds to minutes on one core."""
WIDE = 10.0
"""Factor in the work of adhesion, toward the turn, over which a verdict must hold if a fault has no remedy or slopes
are not small: moments of synthetic maps with such faults are off by factors of up to 4, and the margin depends on
powers of them of up to 5/3."""
NOTHING = 1e-9
"""Part of a moment below which it consists of rounding errors."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """The results for one contact."""

    topographies: tuple[Topography, ...] = field(repr=False)
    """The maps of one or two rough bodies."""
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
    """Warnings, in words."""
    findings: tuple[Findings, ...] = field(default=(), repr=False)
    """Faults of each map."""
    summits: RoughContact | None = field(default=None, repr=False)
    """The contact with the roughness of the upper twentieth of the map; None for two bodies."""
    continuation: Continuation | None = field(default=None, repr=False)
    """The contact with unmeasured waves from a continued spectrum; None if nothing is missing or known of them."""
    mended: Prediction | None = field(default=None, repr=False)
    """The prediction with faults corrected that have a remedy; None if there are none."""
    simulation: Simulation | None = field(default=None, repr=False)
    """The solved contact of the map, with its faults corrected, at the given work of adhesion, if it was computed."""
    turn: SolvedTurn | None = field(default=None, repr=False)
    """The solved work of adhesion at which the contact of the map, with its faults corrected, becomes sticky, if it was
    computed."""
    measured_turn: SolvedTurn | None = field(default=None, repr=False)
    """The same of the map as measured, if it has faults that were corrected; compared with ``turn``."""
    unsolved: str = ""
    """Why the contact was not solved, if that was tried or the map is too large to be solved by default."""

    @property
    def doubts(self) -> tuple[str, ...]:
        """Warnings of the prediction and of its solution, or the reason why there is none."""
        solved = [text for one in (self.turn, self.simulation) if one is not None for text in one.warnings]
        missing = [f"not solved: {self.unsolved}"] if self.unsolved else []
        probe = [] if self.probe is None else probe_doubts(self.contact, self.probe)
        return tuple(dict.fromkeys((*self.warnings, *solved, *probe, *missing)))

    @property
    def solved_sticky(self) -> bool | None:
        """Whether the solver finds it sticky; None if it was not solved, or the solution or a fault leaves it open."""
        found = self._corrected_sticky
        return None if found is None or self.open_by_faults else found

    @property
    def _corrected_sticky(self) -> bool | None:
        """What the solver finds on the map with its faults corrected."""
        state = None if self.simulation is None else self.simulation.sticky
        if self.turn is None:
            return state
        by_turn = self.turn.sticky(self.contact.work_of_adhesion)
        return by_turn if by_turn is None or state is None else state

    @property
    def open_by_faults(self) -> tuple[MapFault, ...]:
        """Faults that leave open what the solver found.

        These are an impossible size; corrected ones, if the map as measured has another answer; and others of the
        heights, if the answer does not hold at :data:`WIDE` times more or less work, toward the turn.
        """
        work, found = self.contact.work_of_adhesion, self._corrected_sticky
        impossible = tuple(fault for fault in self.excluding if fault.kind != NOT_GAUSSIAN)
        if impossible or found is None:
            return impossible
        if self.mended is not None and (self.measured_turn is None or self.measured_turn.sticky(work) is not found):
            return tuple(fault for fault in self.faults if fault.remedy)
        nearer = work / WIDE if found else WIDE * work
        if self.turn is not None and self.turn.sticky(nearer) is found:
            return ()
        return tuple(fault for fault in self.faults if fault.of_the_heights and not fault.remedy)

    @property
    def solved_answer(self) -> Answer | None:
        """The answer of the solver; None if nothing was solved."""
        return None if self.turn is None and self.simulation is None else ANSWERS[self.solved_sticky]

    @property
    def probe(self) -> ProbePullOff | None:
        """The pull-off force of the probe as an interval; None if no probe was given."""
        if self.interface.probe is None:
            return None
        touched = None
        if self.solved_sticky is False and self.turn is not None:
            touched = self.turn.area_rep + self.turn.area_att
        return probe_pull_off(self.contact, self.interface.probe, touched)

    @property
    def too_much(self) -> str:
        """Why the map is not solved by default, in words; empty if it is."""
        if any(one.lines or one.measurements for one in self.topographies):
            return "the measurement is not a map"
        if excluded := [fault.kind for fault in self.excluding if fault.kind != NOT_GAUSSIAN]:
            return f"{excluded[0]} of the map"
        if len({one.grid.spacing for one in self.topographies}) > 1:
            return "the two maps have different pixels"
        points = min(one.heights.size for one in self.topographies)
        return f"{points} points are more than {SMALL}" if points > SMALL else ""

    @property
    def faults(self) -> tuple[MapFault, ...]:
        return tuple(fault for found in self.findings for fault in found.faults)

    @property
    def excluding(self) -> tuple[MapFault, ...]:
        """Faults that exclude theories of moments."""
        return tuple(fault for fault in self.faults if fault.excludes)

    @property
    def verdicts(self) -> tuple[Estimate, ...]:
        """The criteria of stickiness."""
        return tuple(estimate for estimate in self.estimates if estimate.margin is not None)

    @property
    def paper(self) -> Estimate:
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
        """Load per area at a repulsive area of 1 %, by the paper; negative loads are tensions."""
        contact = self.contact
        return AREA * paper.repulsive_pressure(contact.rms_slope, self.kappa, contact.contact_modulus)

    @property
    def distinct(self) -> list[int]:
        """Indices of the criteria with different margins: asperity theories share one."""
        margins = [estimate.margin for estimate in self.verdicts]
        return [i for i, margin in enumerate(margins) if margin not in margins[:i]]

    @property
    def facing(self) -> Topography:
        """The map of the contact, with its faults corrected, or both maps face to face, if possible."""
        return _face_to_face((self.mended or self).topographies)

    def solved(self, threads: int = 1, state: bool = True, *, limited: bool = False) -> Prediction:
        """The prediction with the solved contact of its map, or with the reason why it cannot be solved.

        A map with faults is solved with them corrected; its turn also as measured, for comparison.

        Parameters
        ----------
        threads : threads of the solver.
        state : whether the contact is also solved at the given work, which often takes longer than its
            turn.
        limited : whether a turn that takes ten times as long as on most maps is given up.

        Raises
        ------
        TopographyError
            If two maps cannot be combined.
        """
        from continuum.solve.solution import NotConvergedError  # imported late, as it is compiled and not always needed
        from continuum.sticky.simulate import UnresolvedError, simulate
        from continuum.sticky.solved_turn import solve_turn

        facing, found, missing = self.facing, self, []
        try:
            found = replace(found, turn=solve_turn(facing, self.interface, threads, limited=limited))
        except (UnresolvedError, NotConvergedError) as error:
            missing.append(f"its turn: {error}")
        if self.mended is not None:
            try:
                measured = solve_turn(_face_to_face(self.topographies), self.interface, threads, limited=limited)
                found = replace(found, measured_turn=measured)
            except (UnresolvedError, NotConvergedError) as error:
                missing.append(f"its turn as measured: {error}")
        try:
            found = replace(found, simulation=simulate(facing, self.interface, threads)) if state else found
        except (UnresolvedError, NotConvergedError) as error:
            missing.append(f"its state at this w: {error}")
        return replace(found, unsolved="; ".join(missing))

    @property
    def sentence(self) -> str:
        from continuum.show.prediction import prediction_sentence

        return prediction_sentence(self)

    def sheets(self) -> list[Sheet]:
        """Tables of surface, contact, verdicts and numbers."""
        from continuum.show.prediction import prediction_sheets

        return prediction_sheets(self)

    def json(self) -> str:
        """All results, with the whole spectrum, in SI units."""
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


def _face_to_face(maps: Sequence[Topography]) -> Topography:
    return maps[0] if len(maps) == 1 else opposed(*maps)


def rough_contact(cut: Cut, interface: Interface, roll_off: float | None = None) -> RoughContact:
    """Roughness and interface for the criteria; with λ_L if it is known."""
    return RoughContact(
        *cut.moments,
        interface.work_of_adhesion,
        interface.range,
        interface.contact_modulus,
        conformal_energy=None if interface.coating else cut.conformal_energy * interface.contact_modulus,
        spacing=interface.spacing,
        roll_off=roll_off,
        coated=interface.coating is not None,
    )


def summit_contact(topography: Topography, contact: RoughContact) -> RoughContact | None:
    """A contact with the roughness of the summits; None if they are flat."""
    ratios = summit_ratios(topography)
    return None if min(ratios) < NOTHING else replace(contact.rougher(*ratios), roll_off=None)


def prediction_of(
    topographies: Sequence[Topography],
    interface: Interface,
    smallest: float | None = None,
    tip: float | None = None,
) -> Prediction:
    """Analyse one topography, or two that face each other, without detrending them.

    Parameters
    ----------
    smallest : wavelength to which the spectrum is continued; None for two atoms, or if their spacing is unknown two
        ranges of attraction.
    tip : radius of the tip that measured the maps; None if unknown.
    """
    instance("interface", interface, Interface)
    for name, length in (("smallest", smallest), ("tip", tip)):
        if length is not None:
            number(name, length, above=0)
    if not isinstance(topographies, Sequence) or not 1 <= len(topographies) <= 2:
        raise ArgumentError(
            "topographies", topographies, "one or two, in a list: a contact has one or two rough surfaces"
        )
    for one in topographies:
        instance("topographies", one, Topography)
    findings = tuple(find_faults(topography) for topography in topographies)
    smallest = 2 * (interface.spacing or interface.range) if smallest is None else smallest
    predicted = partial(_predicted, interface=interface, findings=findings, smallest=smallest, tip=tip)
    found = predicted(topographies)
    better = [looked.mended or topography for topography, looked in zip(topographies, findings, strict=True)]
    if all(one is other for one, other in zip(better, topographies, strict=True)):
        return found
    return replace(found, mended=predicted(better))


def _predicted(
    topographies: Sequence[Topography],
    interface: Interface,
    findings: tuple[Findings, ...],
    smallest: float,
    tip: float | None,
) -> Prediction:
    analysed = [roughness_of(topography) for topography in topographies]
    roughness = analysed[0] if len(analysed) == 1 else together(*analysed)
    # A spectrum from bands of lines has reliable moments, but no reliable exponent.
    fits = tuple(None if one.lines or one.measurements else fit_self_affine(*spectrum(one)) for one in topographies)
    # The longer waves of two bodies determine the heights; without roll-off λ_L is at least the size of the map.
    roll_off = max(
        (fit.roll_off if fit is not None and fit.roll_off else topography.extent)
        for topography, fit in zip(topographies, fits, strict=True)
    )
    contact = rough_contact(roughness.whole, interface, roll_off)
    estimates = every_estimate(contact)
    warnings = prediction_doubts(topographies, analysed, fits, roughness, contact)
    warnings += [f"{estimates[0].name} is out of its range: {why}" for why in estimates[0].why]
    shortest = max(topography.cutoff or 0.0 for topography in topographies)
    cuts = [roughness.cut(wavelength) for wavelength in roughness.wavelengths if wavelength >= shortest]
    least = NOTHING * np.array(roughness.whole.moments)
    return Prediction(
        tuple(topographies),
        roughness,
        fits,
        interface,
        contact,
        estimates,
        tuple((cut, verdicts(rough_contact(cut, interface, roll_off))) for cut in cuts if np.all(cut.moments > least)),
        tuple(warnings),
        findings,
        summit_contact(topographies[0], contact) if len(topographies) == 1 else None,
        continuation_of(topographies, analysed, smallest, tip),
    )
