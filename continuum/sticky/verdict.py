"""One answer from one prediction: sticky, not sticky, or undecided, with the votes of the theories and the reasons.

Each theory that is in its range votes, with the probability that its measured record supports
(:mod:`continuum.sticky.record`).  A faulty map is held against the same map with its faults mended: where the two
differ, or where a fault has no remedy and the margin is not wide, the answer is that there is none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from continuum.sticky.criteria import CRITERIA, Estimate, RoughContact, verdicts
from continuum.sticky.prediction import Prediction
from continuum.sticky.record import Support, Surface, support

Answer = Literal["sticky", "not sticky", "undecided"]

SURE = 0.9
"""Probability from which a theory says something."""
WIDE = 10.0
"""Margin, or its inverse, beyond which a fault without remedy changes no verdict: moments of synthetic maps with such
faults are off by factors of up to 4, and the margin goes with their powers of up to 5/3."""


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
    """The vote of every criterion that the contact allows, in the order of :data:`continuum.sticky.criteria.CRITERIA`.

    Parameters
    ----------
    without : see :func:`continuum.sticky.record.support`.
    """
    asked = ((one, CRITERIA[one.key]) for one in verdicts(contact))
    return tuple(Vote(one, support(entry, contact, without) if entry.sufficient else None) for one, entry in asked)


def judge(prediction: Prediction) -> Verdict:
    """The verdict on a contact, faults of its maps included."""
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
    if len(said) != 1:
        return Verdict("undecided", probability, why)
    return Verdict(said.pop(), probability, why)
