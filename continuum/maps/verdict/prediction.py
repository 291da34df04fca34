"""The prediction for one contact: roughness, estimates of every theory, faults of the maps, threshold, doubts, verdict.

The verdict is that of the threshold of the map (:mod:`continuum.maps.verdict.threshold`), unless something leaves it
open: faults, with which the map as measured has another answer, or which have no remedy; waves that were not measured;
slopes for which the theory of small slopes does not hold.  Theories of roughness take no part.

All numbers are in one consistent system of units: SI if they come from a file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Self, TypeVar

import numpy as np

from continuum.inputs import units
from continuum.inputs.arguments import ArgumentError, instance, number
from continuum.maps.faults import NOT_GAUSSIAN, Findings, MapFault, find_faults
from continuum.maps.map import Topography, opposed
from continuum.maps.roughness import Cut, Fit, Roughness, fit_self_affine, roughness_of, spectrum, together
from continuum.maps.verdict import criteria
from continuum.maps.verdict.adhesion import ProbePullOff, UnderAdhesion, probe_doubts, probe_pull_off
from continuum.maps.verdict.criteria import AREA, Answer, Estimate, RoughContact
from continuum.maps.verdict.extrapolation import Continuation, continuation_of
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.search import find_threshold
from continuum.maps.verdict.threshold import Basis, MapThreshold, bounds
from continuum.theory import paper
from continuum.theory.rough import threshold_share

_readable = partial(units.readable, quantity="length")
_length = partial(units.readable, quantity="length", digits=3)
RESOLVED = 8.0
"""Smallest d_rep, in pixels, at which slope and curvature are those of the surface, not of the pixel."""
GROWTH = 0.1
"""Share of the rms slope in the shortest octave above which the slope is not that of the surface."""
FEW = 10.0
"""Smallest number of contacts of size d_rep² in 1 % of the map for an average; the paper shows A_rep above 10 λ_s²
only."""
LINE_ERROR = 0.1
"""Error of slope and curvature from one line, measured on synthetic surfaces; it falls with the root of their
number."""
LINES_ERROR = 0.03
"""Error of slope and curvature from many lines: the largest found for thirty lines, beyond which more do not help."""
DISAGREE = 0.15
"""Difference of two estimates of the rms slope above which it is mentioned."""


def _stands_for(topography: Topography) -> Iterator[str]:
    """Warnings about a random surface that represents lines or several measurements, and about a size."""
    yield from (step for step in topography.steps if "would be square" in step)
    if topography.lines:
        error = max(LINE_ERROR / np.sqrt(topography.lines), LINES_ERROR)
        yield (
            f"from {topography.lines} line{'s' if topography.lines > 1 else ''}: isotropy and Gaussian "
            f"heights are assumed, slope and curvature known to {error:.0%}, faults not looked for"
        )
    if topography.measurements:
        agree = next((step for step in topography.steps if "densities differ" in step), "none has waves of another")
        yield (
            f"from {topography.measurements} measurements: isotropy and Gaussian heights are assumed, "
            f"faults looked for in their joined spectrum only; {agree}"
        )


def prediction_doubts(
    topographies: Sequence[Topography],
    analysed: Sequence[Roughness],
    fits: Sequence[Fit | None],
    roughness: Roughness,
    contact: RoughContact,
) -> list[str]:
    """Warnings of a prediction, in words."""
    found = []
    for topography, mine, fit in zip(topographies, analysed, fits, strict=True):
        name = topography.source
        found += [f"{name}: {doubt}" for doubt in _stands_for(topography)]
        ratio = mine.spectral.rms_slope / mine.stencil.rms_slope
        if abs(ratio - 1) > DISAGREE:
            why = "roughness at the pixel" if ratio > 1 else "a map that is rougher at its edges"
            found.append(
                f"{name}: rms slope {mine.spectral.rms_slope:.3g} from the spectrum, {mine.stencil.rms_slope:.3g} from "
                f"neighbouring points: {why}"
            )
        if fit is not None and fit.roll_off is None:
            found.append(f"{name}: no roll-off: h_rms, and criteria that use it, depend on the size of the map")
    pixels = contact.diameter / roughness.pixel
    if pixels < RESOLVED:
        found.append(
            f"resolution: the expected width of a contact, {_length(contact.diameter)}, is {pixels:.2g} pixels; below "
            f"about {RESOLVED:g} the curvature is that of the pixel, not of the surface"
        )
    # Of a map, or of the square that the longest wave of a spectrum spans.
    areas = [one.grid.area if one.bands is None else one.extent**2 for one in topographies]
    contacts = AREA * min(areas) / contact.diameter**2
    if contacts < FEW:
        found.append(
            f"size: {100 * AREA:g} % of the map is as large as {contacts:.2g} contacts of the expected width, "
            f"{_length(contact.diameter)}; below about {FEW:g} single summits decide, not the average that all "
            "theories give"
        )
    whole, octave = roughness.whole.moments, roughness.cut(4 * roughness.pixel).moments
    grown = 1 - octave.rms_slope / whole.rms_slope
    if grown > GROWTH:
        found.append(
            f"resolution: {100 * grown:.0f} % of the rms slope come from wavelengths below 4 pixels "
            f"({_readable(4 * roughness.pixel)}): a finer map would be steeper, and less sticky"
        )
    if len({mine.pixel for mine in analysed}) > 1:
        finest = min(mine.pixel for mine in analysed)
        found.append(f"different pixels: from {_readable(finest)} to {_readable(roughness.pixel)} one map is missing")
    return found


_per_area = partial(units.readable, quantity="energy_per_area", digits=3)
WIDE = 10.0
"""Factor in the work of adhesion, toward the threshold, over which a verdict must hold if a fault has no remedy:
moments of synthetic maps with such faults are off by factors of up to 4, and thresholds depend on powers of them of up
to 5/3."""
STEEPEST = 1.0
"""rms slope above which no verdict is given.  The theory of small slopes neglects a part h'² of the elastic energy."""


@dataclass(frozen=True)
class Verdict:
    """The verdict on a contact."""

    answer: Answer
    factor: float | None = None
    """w over the threshold; None where that is not known."""
    why: str = ""
    """Reason why the verdict is undecided, or what it takes into account, in one sentence."""


@dataclass(frozen=True, eq=False)
class PredictionNumbers:
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
    """Every criterion and number of :mod:`continuum.maps.verdict.criteria`, the paper's first."""
    warnings: tuple[str, ...]
    """Warnings, in words."""
    findings: tuple[Findings, ...] = field(default=(), repr=False)
    """Faults of each map."""
    continuation: Continuation | None = field(default=None, repr=False)
    """The contact with unmeasured waves from a continued spectrum; None if nothing is missing or known of them."""
    mended: PredictionNumbers | None = field(default=None, repr=False)
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
        return tuple(dict.fromkeys((*self.warnings, *_unseen(self), *solved, *probe)))

    @property
    def probe(self) -> ProbePullOff | None:
        """The pull-off force of the probe as an interval; None if no probe was given."""
        if self.interface.probe is None:
            return None
        found = self.threshold
        known = found is not None and found.source is not Basis.BOUNDS and self.verdict.answer == "not sticky"
        touched = found.area_rep + found.area_att if found is not None and known else None
        probe, contact = probe_pull_off(self.contact, self.interface.probe, touched), (self.mended or self).contact
        curve = None if found is None else found.adhesion
        if curve is None:
            return probe
        reach = contact.range + contact.rms_height
        force = curve.force_on_sphere(contact.work_of_adhesion, probe.radius, reach, contact.contact_modulus)
        return replace(probe, by_curve=force)

    @property
    def pressure(self) -> float | None:
        """Mean pressure at which area and gap are asked for, in Pa; None if none is."""
        load, lengths = self.interface.load, self.topographies[0].lengths
        return self.interface.pressure if load is None else load / (lengths[0] * lengths[1])

    @cached_property
    def adhesion(self) -> UnderAdhesion | None:
        """Pull-off stress, and area and gap without load and at the given one; None if not known."""
        curve = None if self.threshold is None else self.threshold.adhesion
        return None if curve is None else curve.at_work(self.contact.work_of_adhesion, self.pressure)

    @property
    def no_map(self) -> str:
        """Reason why there is no map that could be pressed, in words; empty if there is one."""
        if any(one.lines or one.measurements for one in self.topographies):
            return "the measurement is not a map"
        spacings = [one.grid.spacing for one in self.topographies]
        same = all(np.allclose(one, spacings[0], rtol=1e-6, atol=0) for one in spacings)
        return "" if same else "the two maps have different pixels"

    @property
    def faults(self) -> tuple[MapFault, ...]:
        return tuple(fault for found in self.findings for fault in found.faults)

    @property
    def verdicts(self) -> tuple[Estimate, ...]:
        """The criteria of stickiness."""
        return tuple(estimate for estimate in self.estimates if estimate.margin is not None)

    @property
    def paper(self) -> Estimate:
        return self.estimates[0]

    def number(self, key: str) -> Estimate:
        """An estimate by the key of its entry in :data:`continuum.maps.verdict.criteria.CRITERIA`."""
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
        return criteria.AREA * paper.repulsive_pressure(contact.rms_slope, self.kappa, contact.contact_modulus)

    def solved(
        self, threads: int = 1, search: bool | None = None, told: Callable[[str], None] = lambda text: None
    ) -> Self:
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

        def of(found: PredictionNumbers) -> MapThreshold:
            return find_threshold(found.facing, found.interface, found.contact, threads, search, told)

        measured = None if self.mended is None else of(self)
        return replace(self, threshold=of(self.mended or self), threshold_as_measured=measured)

    @property
    def facing(self) -> Topography:
        """The map of the contact, or both maps face to face."""
        return self.topographies[0] if len(self.topographies) == 1 else opposed(*self.topographies)


def rough_contact(cut: Cut, interface: Interface, roll_off: float | None = None) -> RoughContact:
    """Roughness and interface for the criteria; with λ_L if it is known."""
    coated, spacing, modulus = interface.coating is not None, interface.spacing, interface.contact_modulus
    energy = None if coated else cut.conformal_energy * modulus
    given = *cut.moments, interface.work_of_adhesion, interface.range, modulus
    return RoughContact(*given, conformal_energy=energy, spacing=spacing, roll_off=roll_off, coated=coated)


Kind = TypeVar("Kind", bound=PredictionNumbers)


def prediction_of(
    topographies: Sequence[Topography],
    interface: Interface,
    smallest: float | None = None,
    tip: float | None = None,
    kind: type[Kind] = PredictionNumbers,  # type: ignore[assignment]  # https://github.com/python/mypy/issues/3737
) -> Kind:
    """Analyse one topography, or two that face each other, without detrending them.

    Parameters
    ----------
    smallest : wavelength to which the spectrum is continued; None for two atoms, or if their spacing is unknown two
        ranges of attraction.
    tip : radius of the tip that measured the maps; None if unknown.
    kind : class of the result: that of the front door shows itself, too.
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
    predicted = partial(_predicted, interface=interface, findings=findings, smallest=smallest, tip=tip, kind=kind)
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
    kind: type[Kind],
) -> Kind:
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
    estimates = criteria.every_estimate(contact)
    warnings = prediction_doubts(topographies, analysed, fits, roughness, contact)
    found = tuple(topographies), roughness, fits, interface, contact, estimates, tuple(warnings), findings
    return kind(*found, continuation_of(topographies, analysed, smallest, tip))


def verdict_of(prediction: PredictionNumbers) -> Verdict:
    """The verdict on a contact, including faults of its maps and unmeasured waves."""
    found, work = prediction.threshold, prediction.contact.work_of_adhesion
    if found is None:
        return Verdict("undecided", None, "the map was not solved")
    factor = work / found.work if found.work > 0 else None
    # Heights that are not Gaussian mislead theories, but not the state of the map, which decides.
    faults = (one for one in prediction.faults if one.excludes and one.kind != NOT_GAUSSIAN)
    if impossible := next(faults, None):
        return Verdict("undecided", factor, f"{impossible.text}: {impossible.excludes}")
    sticky = found.sticky(work)
    if sticky is None:
        between = f"w = {_per_area(work)} lies between {_per_area(found.low)} and {_per_area(found.high)}"
        return Verdict("undecided", factor, "; ".join((between, *found.why)))
    why = next((text for leaves_open in _OPEN for text in leaves_open(prediction, sticky)), None)
    return Verdict(criteria.ANSWERS[sticky], factor) if why is None else Verdict("undecided", factor, why)


def _unseen(prediction: PredictionNumbers) -> Iterator[str]:
    """Remark on roughness between the pixels: it can only raise the threshold, so it matters unless not sticky."""
    pixel = prediction.roughness.pixel
    if pixel > prediction.contact.range and prediction.verdict.answer != "not sticky":
        yield (
            f"the pixel, {_readable(pixel)}, is larger than the range of adhesion: roughness between the points is "
            "not seen, and can raise the threshold"
        )


def _steep(prediction: PredictionNumbers, sticky: bool) -> Iterator[str]:
    """Slopes for which the elastic energy, and with it the threshold, is off by more than leaves the answer."""
    slope = (prediction.mended or prediction).contact.rms_slope
    if slope > STEEPEST:
        yield f"an rms slope of {slope:.3g} is not small"
    elif slope > criteria.LARGEST_SLOPE and not _holds(prediction, sticky, 1 + slope**2):
        yield f"an rms slope of {slope:.3g} is not small: the threshold is open by a factor of {1 + slope**2:.3g}"


def _mended(prediction: PredictionNumbers, sticky: bool) -> Iterator[str]:
    """Faults with a remedy, if the map as measured has another answer."""
    measured, found, work = prediction.threshold_as_measured, prediction.threshold, prediction.contact.work_of_adhesion
    if measured is not None and found is not None and measured.sticky(work) is not sticky:
        yield (
            f"as measured the threshold is {_per_area(measured.work)}, with the faults corrected "
            f"{_per_area(found.work)}: the answers differ"
        )


def _hopeless(prediction: PredictionNumbers, sticky: bool) -> Iterator[str]:
    """Faults of the heights without remedy, if the answer does not hold far from the threshold."""
    kinds = " and ".join(fault.kind for fault in prediction.faults if fault.of_the_heights and not fault.remedy)
    if kinds and not _holds(prediction, sticky, WIDE):
        toward = "less" if sticky else "more"
        yield f"{kinds}, without remedy: a verdict would have to hold at {WIDE:g} times {toward} w"


def _unmeasured(prediction: PredictionNumbers, sticky: bool) -> Iterator[str]:
    """Waves that were not measured, or not pressed, if they change the answer."""
    waves, shift = (prediction.mended or prediction).continuation, unmeasured_shift(prediction)
    if prediction.threshold is None or shift is None or _holds(prediction, sticky, shift if sticky else 1 / shift):
        return
    missing = f"waves below {_length(prediction.threshold.left_out)} were left out, and with them"
    if waves is not None:
        missing = (
            f"waves below {_length(waves.measured)} were not measured, and with the spectrum continued to "
            f"{_length(waves.smallest)}"
        )
    yield f"{missing} the threshold is {shift:.2g} times as large{': measure them' if waves is not None else ''}"


_OPEN: tuple[Callable[[PredictionNumbers, bool], Iterator[str]], ...] = (_mended, _hopeless, _steep, _unmeasured)
"""Reasons that leave an answer open, the gravest first."""


def _holds(prediction: PredictionNumbers, sticky: bool, factor: float) -> bool:
    """True if an answer holds with a threshold so many times nearer to, or beyond, the work of adhesion."""
    assert prediction.threshold is not None
    work = prediction.contact.work_of_adhesion
    return prediction.threshold.sticky(work / factor if sticky else work * factor) is sticky


def unmeasured_shift(prediction: PredictionNumbers) -> float | None:
    """Factor by which waves that were not measured, or left out, change the threshold, by the law of the spectrum.

    None where nothing is missing, or nothing is known of it.
    """
    corrected = prediction.mended or prediction
    left_out = 0.0 if prediction.threshold is None else prediction.threshold.left_out
    whole = known = corrected.contact
    if corrected.continuation is not None:
        whole = corrected.continuation.contact(known)
    if left_out:
        cut = corrected.roughness.cut(left_out)
        energy = cut.conformal_energy * known.contact_modulus
        known = replace(known, rms_height=cut.moments.rms_height, conformal_energy=energy)
    if whole is known or known.conformal_energy is None or whole.conformal_energy is None:
        return None
    shares = [threshold_share(one.range / one.rms_height) for one in (known, whole)]
    return whole.conformal_energy * shares[1] / (known.conformal_energy * shares[0])
