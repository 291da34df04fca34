"""The verdict of all theories together, by the record: what `continuum predict` said before it solved every map.

Theories in their range are combined by the geometric mean of their margins; of those that share a parameter the first
is taken.  The record gives the probability for each margin, and only on surfaces that are like its own: elsewhere a
theory does not count.
"""

from dataclasses import dataclass, replace

import numpy as np

from continuum.maps.verdict.criteria import (
    CRITERIA,
    LARGEST_SLOPE,
    Answer,
    Criterion,
    Estimate,
    RoughContact,
    every_estimate,
)
from continuum.maps.verdict.prediction import STEEPEST, WIDE
from docs.studies.record.votes import Left, Part, Support, mean_margin, outside, support, threshold_margin

NECESSARY = "necessary-adhesion"
"""A necessary condition, which has no record and does not count."""
SURE = 0.9
"""Probability above which a verdict is given."""


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
    threshold: float | None = None
    """Work of adhesion at which the probability passes one half, for the measured waves; None if there is none."""


def votes(contact: RoughContact, without: Left | None = None) -> tuple[Vote, ...]:
    """The vote of every criterion that the contact allows, in the order of :data:`CRITERIA`."""

    def vote(estimate: Estimate) -> Vote:
        entry = (CRITERIA[estimate.key],)
        if estimate.key == NECESSARY:
            return Vote(estimate, None)
        return Vote(estimate, support(entry, contact, without), outside(entry, contact, without))

    return tuple(map(vote, (one for one in every_estimate(contact) if one.margin is not None)))


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
    threshold = None if found.threshold is None else found.threshold * (slope / flatter.rms_slope) ** 2
    return replace(found, threshold=threshold, why=(*found.why, how))


def flattened(contact: RoughContact) -> RoughContact:
    """The contact for the theories: with smaller heights if it is too steep for them.

    In linear elasticity, for slopes of up to :data:`STEEPEST`, the two are the same contact.
    """
    slope = contact.rms_slope
    if not LARGEST_SLOPE < slope <= STEEPEST:
        return contact
    factor = LARGEST_SLOPE * (1 - 1e-9) / slope
    energy = contact.conformal_energy
    return replace(
        contact,
        rms_height=factor * contact.rms_height,
        rms_slope=factor * contact.rms_slope,
        rms_curvature=factor * contact.rms_curvature,
        conformal_energy=None if energy is None else factor * factor * energy,
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
    """The verdict by the energy that flattens the summits: the only number that is the same at all thresholds."""
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
    margins = threshold_margin(criteria, contact, part=part), np.exp(mean_margin(criteria, contact))
    why = (f"{names}, by {found.count} similar surfaces",)
    threshold = float(contact.work_of_adhesion * margins[0] / margins[1])
    return Verdict(answer_at(found.probability), found.probability, why, threshold)


def _firm(
    found: Verdict, contact: RoughContact, cause: str, without: Left | None = None, part: Part = "map"
) -> Verdict:
    """The verdict if it holds at :data:`WIDE` times more or less work, toward the threshold; else undecided."""
    if found.answer == "undecided":
        return found
    factor = WIDE if found.answer == "not sticky" else 1 / WIDE
    nearer = judge_contact(replace(contact, work_of_adhesion=factor * contact.work_of_adhesion), without, part)
    if nearer.answer == found.answer:
        return found
    why = f"{cause}: a verdict would have to hold at {factor:g} times the work of adhesion, too"
    return Verdict("undecided", None, (why,))
