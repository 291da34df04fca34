"""The verdict on one prediction: sticky, not sticky, or undecided, with the reason.

It is that of the threshold of the map (:mod:`continuum.sticky.threshold`), unless something leaves it open: faults,
with which the map as measured has another answer, or which have no remedy; waves that were not measured; slopes for
which the theory of small slopes does not hold.  Theories of roughness take no part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from continuum import units
from continuum.sticky.criteria import ANSWERS, LARGEST_SLOPE, Answer
from continuum.theory.rough import threshold_share
from continuum.topography.faults import NOT_GAUSSIAN

if TYPE_CHECKING:
    from continuum.sticky.prediction import Prediction

_length = partial(units.readable, quantity="length", digits=3)
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
    """Why it is undecided, or what the answer takes into account, in one sentence."""


def verdict_of(prediction: Prediction) -> Verdict:
    """The verdict on a contact, including faults of its maps and unmeasured waves."""
    found, work = prediction.threshold, prediction.contact.work_of_adhesion
    if found is None:
        return Verdict("undecided", None, "the map was not solved")
    factor = work / found.work if found.work > 0 else None
    if impossible := [f"{one.text}: {one.excludes}" for one in prediction.excluding if one.kind != NOT_GAUSSIAN]:
        return Verdict("undecided", factor, impossible[0])
    sticky = found.sticky(work)
    if sticky is None:
        between = f"w = {_per_area(work)} lies between {_per_area(found.low)} and {_per_area(found.high)}"
        return Verdict("undecided", factor, "; ".join((between, *found.why)))
    why = next((text for leaves_open in _OPEN for text in leaves_open(prediction, sticky)), None)
    return Verdict(ANSWERS[sticky], factor) if why is None else Verdict("undecided", factor, why)


def _steep(prediction: Prediction, sticky: bool) -> Iterator[str]:
    """Slopes for which the elastic energy, and with it the threshold, is off by more than leaves the answer."""
    slope = (prediction.mended or prediction).contact.rms_slope
    if slope > STEEPEST:
        yield f"an rms slope of {slope:.3g} is not small"
    elif slope > LARGEST_SLOPE and not _holds(prediction, sticky, 1 + slope**2):
        yield f"an rms slope of {slope:.3g} is not small: the threshold is open by a factor of {1 + slope**2:.3g}"


def _mended(prediction: Prediction, sticky: bool) -> Iterator[str]:
    """Faults with a remedy, if the map as measured has another answer."""
    measured, found, work = prediction.threshold_as_measured, prediction.threshold, prediction.contact.work_of_adhesion
    if measured is not None and found is not None and measured.sticky(work) is not sticky:
        yield (
            f"as measured the threshold is {_per_area(measured.work)}, with the faults corrected "
            f"{_per_area(found.work)}: the answers differ"
        )


def _hopeless(prediction: Prediction, sticky: bool) -> Iterator[str]:
    """Faults of the heights without remedy, if the answer does not hold far from the threshold."""
    kinds = " and ".join(fault.kind for fault in prediction.faults if fault.of_the_heights and not fault.remedy)
    if kinds and not _holds(prediction, sticky, WIDE):
        toward = "less" if sticky else "more"
        yield f"{kinds}, without remedy: a verdict would have to hold at {WIDE:g} times {toward} w"


def _unmeasured(prediction: Prediction, sticky: bool) -> Iterator[str]:
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


_OPEN: tuple[Callable[[Prediction, bool], Iterator[str]], ...] = (_mended, _hopeless, _steep, _unmeasured)
"""What leaves an answer open, the gravest first."""


def _holds(prediction: Prediction, sticky: bool, factor: float) -> bool:
    """Whether an answer holds with a threshold so many times nearer to, or beyond, the work of adhesion."""
    assert prediction.threshold is not None
    work = prediction.contact.work_of_adhesion
    return prediction.threshold.sticky(work / factor if sticky else work * factor) is sticky


def unmeasured_shift(prediction: Prediction) -> float | None:
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
