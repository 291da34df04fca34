"""The answer of a prediction in at most ten lines, and on an axis: what would change it, and what to do about faults.

The verdict as a colour, and w with its threshold on an axis: what the page of the browser and the report show.
"""

from functools import partial

import numpy as np

from continuum.inputs import units
from continuum.maps.faults import NOT_GAUSSIAN
from continuum.maps.verdict import criteria
from continuum.maps.verdict.adhesion import CurvePoint, ProbePullOff
from continuum.maps.verdict.criteria import Answer
from continuum.maps.verdict.prediction import PredictionNumbers
from continuum.maps.verdict.threshold import Basis, MapThreshold
from continuum.model.fourier import Real
from continuum.show.prediction_data import remedy_options

length = partial(units.readable, quantity="length", digits=3)
pressure = partial(units.readable, quantity="pressure", digits=3)
per_area = partial(units.readable, quantity="energy_per_area", digits=3)
force = partial(units.readable, quantity="force", digits=3)
"""Lengths, pressures, energies per area and forces as statements and tables have them."""
HOW = {
    Basis.STATE: "from one state without adhesion",
    Basis.SEARCH: "by a search with adhesion",
    Basis.BOUNDS: "as bounds only, from the spectrum",
}
"""Phrases for the method that found a threshold."""
WIDE = 2.0
"""Error, as a factor, above which it is printed as a factor instead of per cent."""


def statements(prediction: PredictionNumbers) -> list[str]:
    """The answer, one line each without a full stop: at most nine, as the terminal adds where the files are.

    They are: sticky or not, and how sure; w and its threshold; that of the surface; what would change the answer; the
    pull-off stress; area and gap at a load, and the pull-off force of a probe, if they are asked for; faults of the
    maps with what to do.
    """
    probe, threshold = prediction.probe, prediction.threshold
    found = [_answer(prediction)]
    if threshold is not None and threshold.work > 0:
        found += [_threshold(prediction, threshold), _surface(prediction, threshold), _change(prediction, threshold)]
    found += [_held(prediction), _loaded(prediction), "" if probe is None else _probe(prediction, probe)]
    found.append(_faults(prediction))
    return [line for line in found if line]


def _answer(prediction: PredictionNumbers) -> str:
    """Sticky or not, the factor to the threshold, and how well that is known."""
    verdict, threshold = prediction.verdict, prediction.threshold
    answer, why = verdict.answer[0].upper() + verdict.answer[1:], verdict.why
    if verdict.answer == "undecided" or verdict.factor is None or threshold is None:
        return f"{answer}: {why}" if why else answer
    because = f" ({why})" if why else ""
    if threshold.source is Basis.BOUNDS:
        return f"{answer}: w is {_bounded(verdict.answer == 'sticky', prediction, threshold)}{because}"
    return f"{answer}: w is {times(verdict.factor)} times the threshold, {_error(threshold)}{because}"


def _bounded(sticky: bool, prediction: PredictionNumbers, threshold: MapThreshold) -> str:
    """The least or the largest factor to a threshold of which only bounds are known."""
    work = prediction.contact.work_of_adhesion
    if sticky:
        return f"at least {times(work / threshold.high)} times the threshold"
    return f"at most {times(work / threshold.low)} times the threshold"


def _error(threshold: MapThreshold) -> str:
    """Uncertainty of a threshold, in per cent or as a factor."""
    if not threshold.low > 0:
        return f"which is at most {per_area(threshold.high)}"
    if np.isinf(threshold.high):
        return f"which is at least {per_area(threshold.low)}"
    most = max(threshold.high / threshold.work, threshold.work / threshold.low)
    return f"which is known to {f'{100 * (most - 1):.0f} %' if most < WIDE else f'a factor of {times(most)}'}"


def _threshold(prediction: PredictionNumbers, threshold: MapThreshold) -> str:
    low, high = (per_area(one) if np.isfinite(one) else "any" for one in (threshold.low, threshold.high))
    interval = f"{low.split()[0]} to {high}" if low.split()[1:] == high.split()[1:] else f"{low} to {high}"
    bounds = threshold.source is Basis.BOUNDS
    between = interval if bounds else f"= {per_area(threshold.work)} ({interval})"
    # The first line of an undecided answer has the reasons already.
    why = "" if not bounds or prediction.verdict.answer == "undecided" else f": {'; '.join(threshold.why)}"
    work = per_area(prediction.contact.work_of_adhesion)
    return f"w = {work}, threshold w_c {between} {HOW[threshold.source]}{why}"


def _surface(prediction: PredictionNumbers, threshold: MapThreshold) -> str:
    """Statement about the surface from which the map was cut."""
    if threshold.source is Basis.BOUNDS:
        return ""
    if np.isnan(threshold.sampling):
        return "The map spans fewer than four roll-off lengths: this holds for this spot only, not for its surface"
    low, high = threshold.of_surface
    said = threshold.surface_sticky(prediction.contact.work_of_adhesion)
    answer = "undecided" if prediction.verdict.answer == "undecided" else criteria.ANSWERS[said]
    return f"For the whole surface around this spot w_c is {per_area(low)} to {per_area(high)}: {answer}"


def _change(prediction: PredictionNumbers, threshold: MapThreshold) -> str:
    """Single changes that would change the answer, by the estimate of the threshold."""
    contact = prediction.contact
    w, answer = contact.work_of_adhesion, prediction.verdict.answer
    if answer == "undecided":
        if threshold.sticky(w) is not None:
            return ""
        ends = [f"not sticky with w below {per_area(threshold.low)}"] if threshold.low > 0 else []
        ends += [f"sticky with w above {per_area(threshold.high)}"] if np.isfinite(threshold.high) else []
        return f"It would be {', '.join(ends)}"
    if threshold.source is Basis.BOUNDS:
        other = f"not be sticky with w below {per_area(threshold.low)}"
        if answer == "not sticky":
            other = f"be sticky with w above {per_area(threshold.high)}"
        between = f"{per_area(threshold.low)} and {per_area(threshold.high)}"
        known = threshold.low > 0 if answer == "sticky" else np.isfinite(threshold.high)
        return f"It would {other}; between {between} it is undecided" if known else ""
    more, less = ("below", "above") if answer == "sticky" else ("above", "below")
    reach, heights = _range_and_heights(threshold, w, contact.range)
    modulus = contact.contact_modulus * w / threshold.work
    alone = [f"w {more} {per_area(threshold.work)}", f"E* {less} {pressure(modulus)}"]
    if reach is not None:
        alone.append(f"a range {'above' if reach > contact.range else 'below'} {length(reach)}")
    if heights is not None:
        alone.append(f"heights and slopes {times(heights)} times as large")
    it = "By the estimate it" if threshold.high > WIDE**2 * threshold.low else "It"
    listed = " or ".join(alone) if len(alone) < 3 else f"{', '.join(alone[:-1])}, or {alone[-1]}"
    return f"{it} would {'not ' if answer == 'sticky' else ''}be sticky with {listed}"


def _held(prediction: PredictionNumbers) -> str:
    """Pull-off stress, and contact area and gap without load."""
    found, threshold = prediction.adhesion, prediction.threshold
    if found is None:
        known = threshold is not None and threshold.adhesion is not None
        return (
            "Pull-off stress: not known, as adhesion changes the gaps by more than the series describes"
            if known
            else ""
        )
    pull = found.pull_off
    at = f"at {per_cent(pull.area)} contact" if pull.area else "before it touches"
    said = f"Pull-off stress: {'at least ' if pull.doubt else ''}{pressure(-pull.pressure)}, {at}"
    return said + ("" if found.unloaded is None else f"; without load {_state(found.unloaded)}")


def _loaded(prediction: PredictionNumbers) -> str:
    """Area and gap at the given load."""
    found, given = prediction.adhesion, prediction.pressure
    if found is None or given is None:
        return ""
    if found.loaded is None:
        return f"At {pressure(given)} area and gap are not known: they lie beyond the states that were computed"
    alone = "" if found.alone is None else f" (without adhesion {_state(found.alone)})"
    return f"At {pressure(given)} {_state(found.loaded)}{alone}"


def _state(point: CurvePoint) -> str:
    """Area and mean gap of a state."""
    return f"{per_cent(point.area)} touch at a mean gap of {length(point.gap)}"


def per_cent(value: float) -> str:
    """A part of an area in per cent."""
    return f"{100 * value:.2g} %"


def _range_and_heights(threshold: MapThreshold, work: float, reach: float) -> tuple[float | None, float | None]:
    """The range of attraction, and the factor of all heights, with which the threshold would be this work.

    Heights s times as large have, in linear elasticity, s² times the threshold at 1/s of the range.  None where no
    range at which the threshold is known has it.
    """
    points = [one for one in threshold.curve if one.known]
    x = np.log([one.range / reach for one in points])
    level = np.log([one.work / work for one in points])
    ranges, heights = _zeros(x, level), -_zeros(x, level - 2 * x)
    found = (float(np.exp(each[np.abs(each).argmin()])) if each.size else None for each in (ranges, heights))
    ratio, factor = found
    return None if ratio is None else reach * ratio, factor


def _zeros(x: Real, y: Real) -> Real:
    """Positions between points where y changes its sign."""
    i = np.flatnonzero(y[:-1] * y[1:] < 0)
    found: Real = x[i] - y[i] * (x[i + 1] - x[i]) / (y[i + 1] - y[i])
    return found


def times(ratio: float) -> str:
    """A factor with two significant digits, near one with three, without an exponent."""
    digits = 3 if 0.8 < ratio < 1.25 else 2
    return f"{float(f'{ratio:.{digits}g}'):.12g}" if ratio >= 1e-4 else f"{ratio:.2g}"


def _faults(prediction: PredictionNumbers) -> str:
    """The first fault in full, the others by name, what corrects them, and the threshold with them.

    What only theories cannot judge, as heights that are not Gaussian, is no fault of a map that is pressed.
    """
    told = [
        one
        for one in prediction.faults
        if one.remedy or one.of_the_heights or (one.excludes and one.kind != NOT_GAUSSIAN)
    ]
    if not told:
        return ""
    first, *others = told
    found = first.text + "".join(f"; {kind}" for kind in dict.fromkeys(fault.kind for fault in others))
    remedies = " ".join(dict.fromkeys(remedy_options(fault) for fault in told if fault.remedy))
    measured = prediction.threshold_as_measured
    correct = f": correct with {remedies}" if remedies else ""
    return f"Faulty map: {found}{correct}" + (f"; as measured w_c = {per_area(measured.work)}" if measured else "")


def _probe(prediction: PredictionNumbers, probe: ProbePullOff) -> str:
    start = f"Pull-off force of a probe of radius {length(probe.radius)}: "
    if probe.by_curve is not None:
        adhesion = prediction.adhesion
        more = adhesion is not None and adhesion.pull_off.doubt
        return start + f"{'at least ' if more else ''}{force(probe.by_curve)}"
    if probe.least is not None:
        interval = " to ".join(dict.fromkeys((force(probe.least), force(probe.most))))
        return start + interval + ("" if probe.rim is None else f"; before full contact below {force(probe.rim)}")
    return start + (f"at most {force(probe.most)}" if probe.rim is None else f"below {force(probe.rim)}")


COLOURS: dict[Answer, str] = {"sticky": "#a84800", "not sticky": "#005a92", "undecided": "#5c5c5c"}
"""Colour of each verdict, under white letters."""
_PARTS = "#5d9fc9", "#c4c4c4", "#d98e4f"
"""Colours of the axis, under black letters: not sticky, undecided, sticky."""
_LEFT, _WIDTH = 20.0, 440.0
_BESIDE = 90.0
"""Distance of two labels below which one stands above the other."""


def verdict_axis(prediction: PredictionNumbers) -> str:
    """SVG of w and w_c in mJ/m² on a logarithmic axis, whose parts are not sticky, undecided and sticky.

    Empty without a threshold.
    """
    found, work = prediction.threshold, 1e3 * prediction.contact.work_of_adhesion
    if found is None or not found.work > 0 or not work > 0:
        return ""
    threshold, low, high = (1e3 * one for one in (found.work, found.low, found.high))
    ends = min(work, low or threshold) / 2, max(work, high if np.isfinite(high) else threshold) * 2

    def at(value: float) -> float:
        share = np.log(np.clip(value, *ends) / ends[0]) / np.log(ends[1] / ends[0])
        return _LEFT + float(share) * _WIDTH

    right, here, there = _LEFT + _WIDTH, at(work), at(threshold)
    edges = _LEFT, at(low), max(at(high), at(low) + 1), right
    bars = "".join(
        f'<rect x="{start:.1f}" y="40" width="{max(end - start, 0):.1f}" height="16" fill="{colour}"/>'
        for start, end, colour in zip(edges[:-1], edges[1:], _PARTS, strict=True)
    )
    ticks = "".join(f'<text x="{at(value):.1f}" y="74">{value:g}</text>' for value in _ticks(*ends))
    above = 14 if abs(here - there) < _BESIDE else 28
    return (
        f'<svg viewBox="0 0 480 96" role="img" text-anchor="middle" font-size="14" '
        f'aria-label="w = {work:.3g}, w_c = {threshold:.3g} mJ/m²">{bars}'
        f'<line x1="{there:.1f}" x2="{there:.1f}" y1="34" y2="62" stroke="#000" stroke-width="2"/>'
        f'<text x="{there:.1f}" y="{above}">w_c {threshold:.3g}</text>'
        f'<path d="M{here:.1f} 48l-7 -14h14z"/><text x="{here:.1f}" y="28" font-weight="700">w {work:.3g}</text>{ticks}'
        '<text x="240" y="92">work of adhesion (mJ/m²): not sticky, undecided, sticky</text></svg>'
    )


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers on a logarithmic axis: 1, 2 and 5 of each decade, or 1 alone if there are many decades."""
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    every = max(1, len(decades) // 8)
    digits = (1, 2, 5) if high < 300 * low else (1,)
    values = [digit * 10.0**decade for decade in decades[::every] for digit in digits]
    return [value for value in values if low <= value <= high]
