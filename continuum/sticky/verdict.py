"""The verdict on one prediction: sticky, not sticky, or undecided, with its probability and the reasons.

Theories in their range are combined by the geometric mean of their margins; of those that share a parameter the first
is taken.  A faulty map is compared with the corrected map: if the verdicts differ, or if a fault has no remedy and the
verdict is not firm, the answer is undecided.  It is also undecided on a map unlike those of the record, and if waves
that were not measured would change it (:mod:`continuum.sticky.continuation`).

The record gives the probability for each margin (:mod:`continuum.sticky.record`), and only on surfaces that are like
its own: elsewhere a theory does not count.  A map whose summits are not those
of a Gaussian surface is judged by its summits, with their own record, if that has similar surfaces.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from continuum import units
from continuum.sticky.criteria import CRITERIA, LARGEST_SLOPE, Answer, Criterion, Estimate, RoughContact, verdicts
from continuum.sticky.prediction import WIDE, Prediction, summit_contact
from continuum.sticky.record import Left, Part, Support, mean_margin, outside, support, turning_margin
from continuum.topography.faults import NOT_GAUSSIAN

_length = partial(units.readable, quantity="length", digits=3)
SURE = 0.9
"""Probability above which a verdict is given."""
_STEPS = 24
"""Number of wavelengths between the shortest measured one and the smallest at which the answer is computed."""
STEEPEST = 1.0
"""rms slope above which no verdict is given.  The small-slope approximation neglects a part h'² of the elastic energy,
which up to here is less than WIDE."""


@dataclass(frozen=True)
class Vote:
    """The answer of one theory, and the support by its record."""

    estimate: Estimate
    support: Support | None
    """None for a necessary condition, which has no record, and outside of the record."""
    outside: str = ""
    """Why the record says nothing of the contact; empty if it does."""

    @property
    def answer(self) -> Answer:
        """Undecided if the support lies between 1 - :data:`SURE` and SURE."""
        if self.support is None:
            return "undecided" if self.estimate.sticky or self.outside else "not sticky"
        return answer_at(self.support.probability)

    @property
    def counts(self) -> bool:
        """Whether theory and contact are in their ranges, and it is not only a necessary condition."""
        return self.estimate.valid and self.support is not None


def answer_at(probability: float) -> Answer:
    """The answer for a probability of being sticky: undecided between 1 - :data:`SURE` and SURE."""
    return "sticky" if probability >= SURE else "not sticky" if probability <= 1 - SURE else "undecided"


@dataclass(frozen=True)
class Verdict:
    """The verdict on a contact."""

    answer: Answer
    probability: float | None = None
    """Probability that it is sticky, if that decides; else None."""
    why: tuple[str, ...] = ()
    """Reasons, most important first."""
    turn: float | None = None
    """Work of adhesion at which the probability passes one half, for the measured waves; None if there is none."""


@dataclass(frozen=True)
class MissingWaves:
    """Effect of waves that were not measured on an answer."""

    verdict: Verdict
    """Verdict with the spectrum continued to the smallest wavelength."""
    changes: float | None
    """Wavelength at which the answer changes; None if it does not."""


def votes(contact: RoughContact, without: Left | None = None) -> tuple[Vote, ...]:
    """The vote of every criterion that the contact allows, in the order of :data:`CRITERIA`."""

    def vote(estimate: Estimate) -> Vote:
        entry = (CRITERIA[estimate.key],)
        if not entry[0].sufficient:
            return Vote(estimate, None)
        return Vote(estimate, support(entry, contact, without), outside(entry, contact, without))

    return tuple(map(vote, verdicts(contact)))


def judge(prediction: Prediction, without: Left | None = None) -> Verdict:
    """The verdict on a contact, including faults of its maps and unmeasured waves."""
    found = _judge_measured(prediction, without)
    beyond = unmeasured(prediction, found.answer, without)
    if beyond is None or beyond.changes is None:
        return found
    return Verdict("undecided", None, (changed_by_waves(prediction, found.answer, beyond),), found.turn)


def unmeasured(
    prediction: Prediction, answer: Answer | None = None, without: Left | None = None
) -> MissingWaves | None:
    """Effect of unmeasured waves on an answer; None if there are none, or the answer is undecided without them.

    The answer for the measured waves is that of the theories if it is None.
    """
    waves = prediction.continuation
    answer = _judge_measured(prediction, without).answer if answer is None else answer
    if waves is None or answer == "undecided":
        return None

    def with_waves(wavelength: float) -> Verdict:
        return _judge_measured(_continued(prediction, wavelength), without)

    found = with_waves(waves.smallest)
    if found.answer == answer:
        return MissingWaves(found, None)
    steps = np.geomspace(waves.measured, waves.smallest, _STEPS + 1)[1:]
    changes = next((float(one) for one in steps if with_waves(float(one)).answer != answer), waves.smallest)
    return MissingWaves(found, changes)


def changed_by_waves(prediction: Prediction, answer: Answer, beyond: MissingWaves) -> str:
    """Why an answer changes with unmeasured waves, and what to measure."""
    waves = prediction.continuation
    if waves is None or beyond.changes is None:
        return ""
    exponents = " and ".join(f"{hurst:.2g}" for hurst in waves.hursts)
    return (
        f"as measured it is {answer}, with the spectrum continued as q^(-2-2H), H = {exponents}, to "
        f"{_length(waves.smallest)} {beyond.verdict.answer}, from waves of {_length(beyond.changes)} on: "
        f"measure below {_length(waves.measured)}"
    )


def turn_shift(prediction: Prediction) -> float | None:
    """Factor by which unmeasured waves change w at the turn, by the theories; None if unknown."""
    known, beyond = _judge_measured(prediction, None).turn, continued_verdict(prediction).turn
    return None if known is None or beyond is None else beyond / known


def continued_verdict(prediction: Prediction) -> Verdict:
    """The verdict of the theories with the spectrum continued to the smallest wavelength."""
    waves = prediction.continuation
    return _judge_measured(prediction if waves is None else _continued(prediction, waves.smallest), None)


def answer_of(prediction: Prediction) -> Answer:
    """The answer of the solver if it has one, else of the theories; undecided if unmeasured waves change it.

    The solver has the measured waves only: its turn is multiplied by the factor by which that of the theories changes,
    both on the map with its faults corrected.
    """
    answer, turn = prediction.solved_answer, prediction.turn
    if answer is None:
        return judge(prediction).answer
    corrected = prediction.mended or prediction
    if answer == "undecided" or corrected.continuation is None:
        return answer
    shift, known = turn_shift(corrected), _judge_measured(corrected, None)
    if turn is not None and shift is not None:
        holds = turn.sticky(prediction.contact.work_of_adhesion / shift) is (answer == "sticky")
    else:  # theories without an answer for the measured waves have none for the others
        silent = known.answer == "undecided" and known.turn is None
        holds = silent or continued_verdict(corrected).answer == answer
    return answer if holds else "undecided"


def _continued(prediction: Prediction, wavelength: float) -> Prediction:
    """The prediction with all waves above a wavelength, measured or continued."""
    waves, mended = prediction.continuation, prediction.mended
    if mended is not None:
        prediction = replace(prediction, mended=_continued(mended, wavelength))
    if waves is None:
        return prediction
    contact = waves.contact(prediction.contact, wavelength)
    summits = None if prediction.summits is None else summit_contact(prediction.topographies[0], contact)
    return replace(prediction, contact=contact, summits=summits, continuation=None)


def _judge_measured(prediction: Prediction, without: Left | None) -> Verdict:
    """The verdict on the waves of a prediction, including faults of its maps."""
    if prediction.excluding:
        return _summits(prediction, without)
    plain = judge_contact(prediction.contact, without)
    if prediction.mended is not None:
        better = judge_contact(prediction.mended.contact, without)
        if better.answer != plain.answer:
            reasons = f" ({'; '.join(better.why)})" if better.answer == "undecided" and better.why else ""
            why = f"as measured the map is {plain.answer}, with its faults corrected {better.answer}{reasons}"
            return Verdict("undecided", None, (why,))
    hopeless = [fault.kind for fault in prediction.faults if not fault.remedy]
    if hopeless:
        contact = (prediction.mended or prediction).contact
        return _firm(plain, contact, f"{' and '.join(hopeless)}, without remedy", without)
    return plain


def _summits(prediction: Prediction, without: Left | None) -> Verdict:
    """The verdict by the roughness of the summits, if that of the map cannot be used."""
    why = tuple(f"{fault.kind}: {fault.excludes}" for fault in prediction.excluding)
    if prediction.summits is None or any(fault.kind != NOT_GAUSSIAN for fault in prediction.excluding):
        return Verdict("undecided", None, why)
    found = judge_contact(prediction.summits, without, "summits")
    others = [fault.kind for fault in prediction.faults if not (fault.remedy or fault.excludes)]
    if others:
        cause = f"{' and '.join(others)}, without remedy"
        found = _firm(found, prediction.summits, cause, without, "summits")
    return replace(found, why=(*found.why, *why)) if found.answer == "undecided" else found


def judge_contact(contact: RoughContact, without: Left | None = None, part: Part = "map") -> Verdict:
    """The verdict of all theories in their range together.

    Moderately steep surfaces are judged with smaller heights, which in linear elasticity is the same contact, and with
    a stricter margin.  The roughness and the record are those of a ``part``: the points of the map, or of the summits.
    """
    heard = _heard if part == "map" else _heard_of_summits
    flatter, slope = flattened(contact), contact.rms_slope
    if flatter is contact:
        return heard(contact, without)
    found = _firm(heard(flatter, without), flatter, f"h' = {slope:.3g} is not small", without, part)
    if found.probability is None:
        return found
    how = f"judged with smaller heights, as h' = {slope:.3g} is above {LARGEST_SLOPE:g}"
    turn = None if found.turn is None else found.turn * (slope / flatter.rms_slope) ** 2
    return replace(found, turn=turn, why=(*found.why, how))


def flattened(contact: RoughContact) -> RoughContact:
    """The contact for the theories: with smaller heights if it is too steep for them.

    In linear elasticity, for slopes of up to :data:`STEEPEST`, the two are the same contact.
    """
    slope = contact.rms_slope
    if not LARGEST_SLOPE < slope <= STEEPEST:
        return contact
    factor = LARGEST_SLOPE * (1 - 1e-9) / slope
    return replace(
        contact.rougher(factor, factor, factor),
        range=factor * contact.range,
        work_of_adhesion=factor**2 * contact.work_of_adhesion,
    )


def _heard(contact: RoughContact, without: Left | None) -> Verdict:
    cast = votes(contact, without)
    heard = [vote for vote in cast if vote.counts]
    if not heard:
        unlike = dict.fromkeys(vote.outside for vote in cast if vote.estimate.valid and vote.outside)
        return Verdict("undecided", None, tuple(unlike) or ("no theory is in its range",))
    said = {
        answer: f"{answer}: {', '.join(vote.estimate.name for vote in heard if vote.answer == answer)}"
        for answer in ("sticky", "not sticky")
        if any(vote.answer == answer for vote in heard)
    }
    if len(said) > 1:
        return Verdict("undecided", None, (f"theories contradict one another: {'; '.join(said.values())}",))
    # Theories of one parameter are limits of one theory.
    distinct = {vote.estimate.symbol: CRITERIA[vote.estimate.key] for vote in reversed(heard)}
    names = ", ".join(vote.estimate.name for vote in heard)
    return _together(tuple(reversed(distinct.values())), contact, names, without, "map")


def _heard_of_summits(contact: RoughContact, without: Left | None) -> Verdict:
    """The verdict by the energy that flattens the summits: the only number that is the same at all turns."""
    criterion = CRITERIA["half-conformal-energy"]
    if not criterion.possible(contact):
        return Verdict("undecided", None, (f"of the summits, the {criterion.needs.replace('_', ' ')} is not known",))
    found = criterion(contact)
    if not found.valid:
        return Verdict("undecided", None, (f"of the summits, {'; '.join(found.why)}",))
    if unlike := outside((criterion,), contact, without, "summits"):
        return Verdict("undecided", None, (f"no surfaces of the record have such summits: {unlike}",))
    return _together((criterion,), contact, "energy that flattens the summits", without, "summits")


def _together(
    criteria: tuple[Criterion, ...], contact: RoughContact, names: str, without: Left | None, part: Part
) -> Verdict:
    found = support(criteria, contact, without, part)
    if found is None:
        return Verdict("undecided", None, (outside(criteria, contact, without, part),))
    margins = turning_margin(criteria, contact, part=part), np.exp(mean_margin(criteria, contact))
    why = (f"{names}, by {found.count} similar surfaces",)
    turn = float(contact.work_of_adhesion * margins[0] / margins[1])
    return Verdict(answer_at(found.probability), found.probability, why, turn)


def _firm(
    found: Verdict, contact: RoughContact, cause: str, without: Left | None = None, part: Part = "map"
) -> Verdict:
    """The verdict if it holds at :data:`WIDE` times more or less work, toward the turn; else undecided."""
    if found.answer == "undecided":
        return found
    factor = WIDE if found.answer == "not sticky" else 1 / WIDE
    nearer = judge_contact(replace(contact, work_of_adhesion=factor * contact.work_of_adhesion), without, part)
    if nearer.answer == found.answer:
        return found
    why = f"{cause}: a verdict would have to hold at {factor:g} times the work of adhesion, too"
    return Verdict("undecided", None, (why,))
