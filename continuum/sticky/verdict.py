"""One answer from one prediction: sticky, not sticky, or undecided, with the votes of the theories and the reasons.

Each theory that is in its range votes, with the probability that its measured record supports.  A faulty map is held
against the same map with its faults mended: where the two differ, or where a fault has no remedy and the margin is not
wide, the answer is that there is none.

The record (``record.csv``, made by ``tests/studies/record.py``) holds surfaces in reduced units, of two kinds: with the
work of adhesion at which the load at 1 % repulsive area changes its sign on approach, and with one work of adhesion and
the sign found there.  A criterion that were exact would have a margin of 1 on the first.  So the probability that a
contact is sticky, given a margin, is the share of surfaces that turned at a smaller one.

Elasticity is linear and slopes are small: heights stretched by s, with a range s times as long and s² times the work,
have the same contact.  So a contact is told by the range of attraction over h_rms and over δh = h'²/h''.  Surfaces
count where both are within a factor of :data:`SIMILAR` of the contact's.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Literal

import numpy as np

from continuum.sticky.criteria import CRITERIA, Criterion, Estimate, RoughContact, verdicts
from continuum.sticky.prediction import Prediction

SIMILAR = 3.0
FEWEST = 10
"""Surfaces below which they are too few, and those of the whole record are asked."""
ELSEWHERE = 3.0
"""Factor by which a margin is then taken nearer to the turn: theories drift by as much over the record's ranges."""
Answer = Literal["sticky", "not sticky", "undecided"]
SURE = 0.9
"""Probability from which a theory says something."""
WIDE = 10.0
"""Margin, or its inverse, beyond which a fault without remedy changes no verdict: moments of synthetic maps with such
faults are off by factors of up to 4, and the margin goes with their powers of up to 5/3."""


@dataclass(frozen=True)
class Surface:
    """One surface of the record with a work of adhesion."""

    contact: RoughContact
    sticky: bool | None
    """What was found at this work of adhesion; None where it is the one at which the load changes its sign."""

    def similar(self, other: RoughContact) -> bool:
        """Whether the two contacts differ little but for the work of adhesion."""
        pairs = zip(_ratios(self.contact), _ratios(other), strict=True)
        return all(1 / SIMILAR <= mine / its <= SIMILAR for mine, its in pairs)


@dataclass(frozen=True)
class Support:
    """What the record says of a margin."""

    probability: float
    """Probability that the contact is sticky."""
    count: int
    """Surfaces that say something at this margin."""
    similar: bool
    """Whether they are like the contact; else they are all that there are."""


def _ratios(contact: RoughContact) -> tuple[float, float]:
    """The range over the height and over the change of height in the contact."""
    change = contact.rms_slope**2 / contact.rms_curvature
    return contact.range / contact.rms_height, contact.range / change


@cache
def recorded() -> tuple[Surface, ...]:
    """The surfaces of the record."""
    text = resources.files("continuum.sticky").joinpath("record.csv").read_text()
    found = []
    for row in csv.DictReader(text.splitlines()):
        contact = RoughContact(
            float(row["rms_height"]),
            float(row["rms_slope"]),
            float(row["rms_curvature"]),
            float(row["work"]),
            float(row["range"]),
            conformal_energy=float(row["conformal_energy"]),
            roll_off=float(row["lambda_L"]),
        )
        found.append(Surface(contact, {"yes": True, "no": False}.get(row["sticky"])))
    return tuple(found)


@cache
def _margins(criterion: Criterion) -> tuple[float, ...]:
    return tuple(criterion(surface.contact).margin or np.nan for surface in recorded())


def support(criterion: Criterion, contact: RoughContact, without: Callable[[Surface], bool] | None = None) -> Support:
    """Probability that a contact is sticky, from a criterion's margin on it and on the surfaces of the record.

    Parameters
    ----------
    criterion : one of :data:`continuum.sticky.criteria.CRITERIA`.
    without : true of surfaces that are not to count, so that a record is tested on what it has not seen.
    """
    margin = criterion(contact).margin or np.nan
    heard = [
        pair for pair in zip(recorded(), _margins(criterion), strict=True) if without is None or not without(pair[0])
    ]
    near = [pair for pair in heard if pair[0].similar(contact)]
    sticky, count = _count(near, margin)
    if count >= FEWEST:
        return Support((sticky + 0.5) / (count + 1), count, True)
    margin = min(margin * ELSEWHERE, 1.0) if margin < 1 else max(margin / ELSEWHERE, 1.0)
    sticky, count = _count(heard, margin)
    return Support((sticky + 0.5) / (count + 1), count, False)


def _count(surfaces: list[tuple[Surface, float]], margin: float) -> tuple[int, int]:
    """Surfaces that were sticky at a margin, of those that say anything there."""
    sticky = count = 0
    for surface, its in surfaces:
        if surface.sticky is None:
            sticky, count = sticky + (its < margin), count + 1
        elif surface.sticky and margin >= its:
            sticky, count = sticky + 1, count + 1
        elif surface.sticky is False and margin <= its:
            count += 1
    return sticky, count


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
        probability = self.support.probability
        return "sticky" if probability >= SURE else "not sticky" if probability <= 1 - SURE else "undecided"

    @property
    def counts(self) -> bool:
        """Whether the theory is in its range, and no mere necessary condition."""
        return self.estimate.valid and self.support is not None


@dataclass(frozen=True)
class Verdict:
    """What is said of a contact."""

    answer: Answer
    probability: float | None
    """Probability that it is sticky: mean of the theories that are heard; None if there are none."""
    why: tuple[str, ...] = ()
    """Reasons, most important first."""


def votes(contact: RoughContact, without: Callable[[Surface], bool] | None = None) -> tuple[Vote, ...]:
    """The :func:`support` of every criterion that the contact allows, in the order of :data:`CRITERIA`, as votes."""
    asked = ((one, CRITERIA[one.key]) for one in verdicts(contact))
    return tuple(Vote(one, support(entry, contact, without) if entry.sufficient else None) for one, entry in asked)


def judge(prediction: Prediction) -> Verdict:
    """The verdict on a contact, faults of its maps included."""
    excluded = tuple(f"{fault.kind}: {fault.excludes}" for fault in prediction.faults if fault.excludes)
    if excluded:
        return Verdict("undecided", None, excluded)
    plain = count_verdicts(votes(prediction.contact))
    if prediction.mended is not None:
        better = count_verdicts(votes(prediction.mended.contact))
        if better.answer != plain.answer:
            why = f"as measured the map is {plain.answer}, with its faults mended {better.answer}"
            return Verdict("undecided", plain.probability, (why,))
    hopeless = [fault for fault in prediction.faults if not fault.remedy]
    heard = [vote.estimate.margin or 0.0 for vote in votes((prediction.mended or prediction).contact) if vote.counts]
    if hopeless and plain.answer != "undecided" and any(1 / WIDE < margin < WIDE for margin in heard):
        names = " and ".join(fault.kind for fault in hopeless)
        why = f"{names}: no theory was made for it, and a margin is within a factor of {WIDE:g} of the turn"
        return Verdict("undecided", plain.probability, (why, *plain.why))
    return plain


def count_verdicts(cast: tuple[Vote, ...]) -> Verdict:
    """The answer of all theories that are heard and say something, if they say the same."""
    heard = [vote for vote in cast if vote.counts]
    if not heard:
        return Verdict("undecided", None, ("no theory is in its range",))
    probability = float(np.mean([vote.support.probability for vote in heard if vote.support is not None]))
    said = {vote.answer for vote in heard} - {"undecided"}
    parts = [
        f"{answer}: {', '.join(vote.estimate.name for vote in heard if vote.answer == answer)}"
        for answer in ("sticky", "not sticky", "undecided")
        if any(vote.answer == answer for vote in heard)
    ]
    why = ("; ".join(parts),)
    # What is printed decides: some theories may be sure where all together are not.
    sure = {"sticky": probability >= SURE, "not sticky": probability <= 1 - SURE}
    if len(said) != 1 or not sure[answer := said.pop()]:
        return Verdict("undecided", probability, why)
    return Verdict(answer, probability, why)
