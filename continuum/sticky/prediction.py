"""The prediction for one contact: roughness, estimates of every theory, faults of the maps, solution, warnings.

All numbers are in one consistent system of units: SI if they come from a file.  It combines the equations of
:mod:`continuum.theory.paper` with the verdicts and ranges of :mod:`continuum.sticky.criteria`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from continuum.arguments import ArgumentError, instance, number
from continuum.sticky.continuation import Continuation, continuation_of
from continuum.sticky.criteria import AREA, Estimate, RoughContact, every_estimate
from continuum.sticky.doubts import prediction_doubts
from continuum.sticky.materials import Interface
from continuum.sticky.probe import ProbePullOff, probe_doubts, probe_pull_off
from continuum.sticky.search import find_threshold
from continuum.sticky.threshold import Basis, MapThreshold, bounds
from continuum.sticky.verdict import Verdict, verdict_of
from continuum.theory import paper
from continuum.topography.faults import Findings, MapFault, find_faults
from continuum.topography.map import Topography, opposed
from continuum.topography.roughness import Cut, Fit, Roughness, fit_self_affine, roughness_of, spectrum, together

if TYPE_CHECKING:
    from continuum.sheet import Sheet


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
    warnings: tuple[str, ...]
    """Warnings, in words."""
    findings: tuple[Findings, ...] = field(default=(), repr=False)
    """Faults of each map."""
    continuation: Continuation | None = field(default=None, repr=False)
    """The contact with unmeasured waves from a continued spectrum; None if nothing is missing or known of them."""
    mended: Prediction | None = field(default=None, repr=False)
    """The prediction with faults corrected that have a remedy; None if there are none."""
    threshold: MapThreshold | None = field(default=None, repr=False)
    """The work of adhesion above which the contact of the map, with its faults corrected, is sticky; None where that
    was not asked for."""
    threshold_as_measured: MapThreshold | None = field(default=None, repr=False)
    """The same of the map as measured, if it has faults that were corrected."""

    @cached_property
    def verdict(self) -> Verdict:
        """Sticky, not sticky, or undecided, with the reason."""
        return verdict_of(self)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Warnings of the prediction and of its threshold."""
        solved = () if self.threshold is None else self.threshold.warnings
        probe = [] if self.probe is None else probe_doubts(self.contact, self.probe)
        return tuple(dict.fromkeys((*self.warnings, *solved, *probe)))

    @property
    def probe(self) -> ProbePullOff | None:
        """The pull-off force of the probe as an interval; None if no probe was given."""
        if self.interface.probe is None:
            return None
        found = self.threshold
        known = found is not None and found.source is not Basis.BOUNDS and self.verdict.answer == "not sticky"
        touched = found.area_rep + found.area_att if found is not None and known else None
        return probe_pull_off(self.contact, self.interface.probe, touched)

    @property
    def no_map(self) -> str:
        """Why there is no map that could be pressed, in words; empty if there is one."""
        if any(one.lines or one.measurements for one in self.topographies):
            return "the measurement is not a map"
        spacings = [one.grid.spacing for one in self.topographies]
        same = all(np.allclose(one, spacings[0], rtol=1e-6, atol=0) for one in spacings)
        return "" if same else "the two maps have different pixels"

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

    def solved(
        self, threads: int = 1, search: bool | None = None, told: Callable[[str], None] = lambda text: None
    ) -> Prediction:
        """The prediction with the threshold of its map, with faults corrected and as measured.

        Parameters
        ----------
        threads : threads of the solver.
        search : whether the threshold is searched for, with adhesion.  None to search where the state without adhesion
            does not decide, and a minute is expected to do.
        told : called with a text before each part of the work.

        Raises
        ------
        TopographyError
            If the map cannot be pressed.
        """
        if self.no_map:
            return replace(self, threshold=bounds((self.mended or self).contact, self.no_map))

        def of(found: Prediction) -> MapThreshold:
            return find_threshold(found.facing, found.interface, found.contact, threads, search, told)

        measured = None if self.mended is None else of(self)
        return replace(self, threshold=of(self.mended or self), threshold_as_measured=measured)

    @property
    def facing(self) -> Topography:
        """The map of the contact, or both maps face to face."""
        return self.topographies[0] if len(self.topographies) == 1 else opposed(*self.topographies)

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
    return Prediction(
        tuple(topographies),
        roughness,
        fits,
        interface,
        contact,
        estimates,
        tuple(warnings),
        findings,
        continuation_of(topographies, analysed, smallest, tip),
    )
