"""One answer from one prediction: sticky, not sticky, or undecided, with its probability and the reasons.

Theories that are in their range are heard as one: of those that share a parameter the first, and of all the geometric
mean of their margins.  A faulty map is held against the same map with its faults mended: where the two differ, or where
a fault has no remedy and the verdict is not firm, the answer is that there is none; nor is there one on a map unlike
those of the record, nor where waves that were not measured would change it (:mod:`continuum.sticky.continuation`).

What every margin is worth the record says (:mod:`continuum.sticky.record`).  A map whose summits are not those of a
Gaussian surface is judged by its summits, with a record of their own, and only where that has surfaces like it.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from continuum import units
from continuum.sticky.criteria import CRITERIA, LARGEST_SLOPE, Answer, Criterion, Estimate, RoughContact, verdicts
from continuum.sticky.prediction import Prediction, summit_contact
from continuum.sticky.record import Left, Part, Support, mean_margin, support, turning_margin
from continuum.topography.faults import NOT_GAUSSIAN

_length = partial(units.readable, quantity="length", digits=3)
SURE = 0.9
"""Probability from which a theory says something."""
WIDE = 10.0
"""Factor of the work of adhesion, toward the turn, over which a verdict holds where a fault has no remedy or slopes are
not small: moments of synthetic maps with such faults are off by factors of up to 4, and the margin goes with their
powers of up to 5/3."""
_STEPS = 24
"""Wavelengths between the shortest measured one and the smallest at which an answer is looked at."""
STEEPEST = 1.0
"""rms slope beyond which nothing is said.  What small slopes leave out is a part h'² of the elastic energy: up to here
it does not reach WIDE."""


@dataclass(frozen=True)
class Vote:
    """What one theory says, and how far its record supports that."""

    estimate: Estimate
    support: Support | None
    """None for a necessary condition, which has no record."""

    @property
    def answer(self) -> Answer:
        """Undecided where the support lies between 1 - :data:`SURE` and SURE."""
        if self.support is None:
            return "undecided" if self.estimate.sticky else "not sticky"
        return answer_at(self.support.probability)

    @property
    def counts(self) -> bool:
        """Whether the theory is in its range, and no mere necessary condition."""
        return self.estimate.valid and self.support is not None


def answer_at(probability: float) -> Answer:
    """The answer that a probability to be sticky allows: undecided between 1 - :data:`SURE` and SURE."""
    return "sticky" if probability >= SURE else "not sticky" if probability <= 1 - SURE else "undecided"


@dataclass(frozen=True)
class Verdict:
    """What is said of a contact."""

    answer: Answer
    probability: float | None = None
    """Probability that it is sticky, which decides; None where something else does."""
    why: tuple[str, ...] = ()
    """Reasons, most important first."""
    turn: float | None = None
    """Work of adhesion at which the probability passes one half, of what was measured; None without such a one."""


@dataclass(frozen=True)
class MissingWaves:
    """What waves that were not measured do to an answer."""

    verdict: Verdict
    """With the spectrum continued to the smallest wavelength."""
    changes: float | None
    """Wavelength from which on the answer is another; None where it stays."""


def votes(contact: RoughContact, without: Left | None = None) -> tuple[Vote, ...]:
    """What the record says of every criterion that the contact allows, in the order of :data:`CRITERIA`, as votes."""
    asked = ((one, CRITERIA[one.key]) for one in verdicts(contact))
    return tuple(Vote(one, support((entry,), contact, without) if entry.sufficient else None) for one, entry in asked)


def judge(prediction: Prediction, without: Left | None = None) -> Verdict:
    """The verdict on a contact, faults of its maps and what was not measured included."""
    found = _judge_measured(prediction, without)
    beyond = unmeasured(prediction, found.answer, without)
    if beyond is None or beyond.changes is None:
        return found
    return Verdict("undecided", None, (changed_by_waves(prediction, found.answer, beyond),), found.turn)


def unmeasured(
    prediction: Prediction, answer: Answer | None = None, without: Left | None = None
) -> MissingWaves | None:
    """What waves do to an answer that were not measured; None where there are none, or it is undecided without.

    Parameters
    ----------
    answer : of what was measured, by the theories if None.
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
    """Why an answer does not hold with waves that were not measured, and what to measure."""
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
    """Factor of w at the turn, by the theories, with waves that were not measured; None where it is not known."""
    known, beyond = _judge_measured(prediction, None).turn, continued_verdict(prediction).turn
    return None if known is None or beyond is None else beyond / known


def continued_verdict(prediction: Prediction) -> Verdict:
    """The verdict of the theories with the spectrum continued to the smallest wavelength, where waves are missing."""
    waves = prediction.continuation
    return _judge_measured(prediction if waves is None else _continued(prediction, waves.smallest), None)


def answer_of(prediction: Prediction) -> Answer:
    """The answer: the solver's where it has one, else the theories'; undecided where waves not measured change it.

    What the solver found is of what was measured: its turn is moved by the factor by which that of the theories moves.
    """
    answer, turn = prediction.solved_answer, prediction.turn
    if answer is None:
        return judge(prediction).answer
    if answer == "undecided" or prediction.continuation is None:
        return answer
    shift, known = turn_shift(prediction), _judge_measured(prediction, None)
    if turn is not None and shift is not None:
        holds = turn.sticky(prediction.contact.work_of_adhesion / shift) is (answer == "sticky")
    else:  # theories that are silent on what was measured say nothing of the rest, either
        silent = known.answer == "undecided" and known.turn is None
        holds = silent or continued_verdict(prediction).answer == answer
    return answer if holds else "undecided"


def _continued(prediction: Prediction, wavelength: float) -> Prediction:
    """The prediction with the roughness of all waves above a wavelength, measured or continued."""
    waves, mended = prediction.continuation, prediction.mended
    if mended is not None:
        prediction = replace(prediction, mended=_continued(mended, wavelength))
    if waves is None:
        return prediction
    contact = waves.contact(prediction.contact, wavelength)
    summits = None if prediction.summits is None else summit_contact(prediction.topographies[0], contact)
    return replace(prediction, contact=contact, summits=summits, continuation=None)


def _judge_measured(prediction: Prediction, without: Left | None) -> Verdict:
    """The verdict on the waves that a prediction has, faults of its maps included."""
    if prediction.excluding:
        return _summits(prediction, without)
    plain = judge_contact(prediction.contact, without)
    if prediction.mended is not None:
        better = judge_contact(prediction.mended.contact, without)
        if better.answer != plain.answer:
            reasons = f" ({'; '.join(better.why)})" if better.answer == "undecided" and better.why else ""
            why = f"as measured the map is {plain.answer}, with its faults mended {better.answer}{reasons}"
            return Verdict("undecided", None, (why,))
    hopeless = [fault.kind for fault in prediction.faults if not fault.remedy]
    if hopeless:
        contact = (prediction.mended or prediction).contact
        return _firm(plain, contact, f"{' and '.join(hopeless)}, without remedy", without)
    return plain


def _summits(prediction: Prediction, without: Left | None) -> Verdict:
    """The verdict by the roughness of what touches, where that of the map says nothing."""
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
    """The verdict of all theories in their range, heard together.

    Surfaces that are somewhat steep are judged as if they were less so, which to linear elasticity is the same contact,
    and more firmly.

    Parameters
    ----------
    part : whose roughness the contact has, and of which the record is: of the map, or of the summits.
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
    """The contact that theories are asked about: one that is too steep for them, with smaller heights, else as it is.

    To linear elasticity, and so for slopes of up to :data:`STEEPEST`, the two are the same contact.
    """
    slope = contact.rms_slope
    return _stretched(contact, LARGEST_SLOPE * (1 - 1e-9) / slope) if LARGEST_SLOPE < slope <= STEEPEST else contact


def _heard(contact: RoughContact, without: Left | None) -> Verdict:
    heard = [vote for vote in votes(contact, without) if vote.counts]
    if not heard:
        return Verdict("undecided", None, ("no theory is in its range",))
    said = {
        answer: f"{answer}: {', '.join(vote.estimate.name for vote in heard if vote.answer == answer)}"
        for answer in ("sticky", "not sticky")
        if any(vote.answer == answer for vote in heard)
    }
    if len(said) > 1:
        return Verdict("undecided", None, (f"theories contradict one another: {'; '.join(said.values())}",))
    # Those of one parameter are one theory, asked at two limits.
    distinct = {vote.estimate.symbol: CRITERIA[vote.estimate.key] for vote in reversed(heard)}
    names = ", ".join(vote.estimate.name for vote in heard)
    return _together(tuple(reversed(distinct.values())), contact, names, without, "map")


def _heard_of_summits(contact: RoughContact, without: Left | None) -> Verdict:
    """By the energy that it takes to flatten the summits: no other parameter turns at one value on all surfaces."""
    criterion = CRITERIA["half-conformal-energy"]
    if not criterion.possible(contact):
        return Verdict("undecided", None, (f"of the summits, the {criterion.needs.replace('_', ' ')} is not known",))
    found = criterion(contact)
    if not found.valid:
        return Verdict("undecided", None, (f"of the summits, {'; '.join(found.why)}",))
    if not support((criterion,), contact, without, "summits").similar:
        return Verdict("undecided", None, ("no surfaces of the record have such summits",))
    return _together((criterion,), contact, "energy that flattens the summits", without, "summits")


def _together(
    criteria: tuple[Criterion, ...], contact: RoughContact, names: str, without: Left | None, part: Part
) -> Verdict:
    found = support(criteria, contact, without, part)
    margins = turning_margin(criteria, contact, part=part), np.exp(mean_margin(criteria, contact))
    alike = "similar surfaces" if found.similar else "surfaces, none of them similar"
    why = (f"{names}, by {found.count} {alike}",)
    turn = float(contact.work_of_adhesion * margins[0] / margins[1])
    return Verdict(answer_at(found.probability), found.probability, why, turn)


def _stretched(contact: RoughContact, factor: float) -> RoughContact:
    """The same contact with heights, and the range, stretched: work and energy go with the square."""
    return replace(
        contact.rougher(factor, factor, factor),
        range=factor * contact.range,
        work_of_adhesion=factor**2 * contact.work_of_adhesion,
    )


def _firm(
    found: Verdict, contact: RoughContact, cause: str, without: Left | None = None, part: Part = "map"
) -> Verdict:
    """A verdict that is the same at :data:`WIDE` times more or less work of adhesion, toward the turn; else none."""
    if found.answer == "undecided":
        return found
    factor = WIDE if found.answer == "not sticky" else 1 / WIDE
    nearer = judge_contact(replace(contact, work_of_adhesion=factor * contact.work_of_adhesion), without, part)
    if nearer.answer == found.answer:
        return found
    why = f"{cause}: a verdict would have to hold at {factor:g} times the work of adhesion, too"
    return Verdict("undecided", None, (why,))
