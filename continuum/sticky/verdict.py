"""One answer from one prediction: sticky, not sticky, or undecided, with its probability and the reasons.

Theories that are in their range are heard as one: of those that share a parameter the first, and of all the geometric
mean of their margins.  A faulty map is held against the same map with its faults mended: where the two differ, or where
a fault has no remedy and the verdict is not firm, the answer is that there is none; nor is there one on a map unlike
those of the record.

The record (``record.csv``, made by ``tests/studies/record.py``) holds surfaces in reduced units, of two kinds: with the
work of adhesion at which the load at 1 % repulsive area changes its sign on approach, and with one work of adhesion and
the sign found there.  A criterion that were exact would have a margin of 1 on the first.  So the probability that a
contact is sticky, given a margin, is the share of surfaces that turned at a smaller one; and so it is of theories
together, whose mean margin has a record as that of each has.

Elasticity is linear and slopes are small: heights stretched by s, with a range s times as long and s² times the work,
have the same contact.  So a contact is told by the range of attraction over h_rms and over δh = h'²/h''.  Surfaces
count where both are within a factor of :data:`SIMILAR` of the contact's.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Literal

import numpy as np
from scipy.optimize import bisect

from continuum.model.fourier import Real
from continuum.sticky.criteria import CRITERIA, LARGEST_SLOPE, Criterion, Estimate, RoughContact, verdicts
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
"""Factor of the work of adhesion, toward the turn, over which a verdict holds where a fault has no remedy or slopes are
not small: moments of synthetic maps with such faults are off by factors of up to 4, and the margin goes with their
powers of up to 5/3."""
STEEPEST = 1.0
"""rms slope beyond which nothing is said.  What small slopes leave out is a part h'² of the elastic energy: up to here
it does not reach WIDE."""
_FAR = 30.0  # logarithm of a margin that no contact has
Left = Callable[["Surface"], bool]
"""True of surfaces of the record that are not to count, so that it is tested on what it has not seen."""


@dataclass(frozen=True)
class Surface:
    """One surface of the record with a work of adhesion."""

    contact: RoughContact
    sticky: bool | None
    """What was found at this work of adhesion; None where it is the one at which the load changes its sign."""


@dataclass(frozen=True)
class Support:
    """What the record says of a margin."""

    probability: float
    """Probability that the contact is sticky."""
    count: int
    """Surfaces that say something at this margin."""
    similar: bool
    """Whether they are like the contact; else they are all that there are."""


Supports = Callable[[float], Support]


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
def _kinds() -> tuple[Real, Real]:
    """Of each surface the logarithms of its ratios, and 1 where it was sticky, -1 where not, 0 where it turns."""
    surfaces = recorded()
    ratios = np.log([_ratios(surface.contact) for surface in surfaces])
    return ratios, np.array([{None: 0.0, True: 1.0, False: -1.0}[surface.sticky] for surface in surfaces])


@cache
def _margins(criteria: tuple[Criterion, ...]) -> Real:
    """Logarithm of the mean margin on each surface."""
    return np.array([_margin(criteria, surface.contact) for surface in recorded()])


def _margin(criteria: tuple[Criterion, ...], contact: RoughContact) -> float:
    return float(np.mean([np.log(criterion(contact).margin or np.nan) for criterion in criteria]))


def support(criteria: tuple[Criterion, ...], contact: RoughContact, without: Left | None = None) -> Support:
    """Probability that a contact is sticky, from the mean margin of criteria on it and on the surfaces of the record.

    Parameters
    ----------
    criteria : of :data:`continuum.sticky.criteria.CRITERIA`: one, or those that are heard together.
    """
    return _supports(criteria, contact, without)(_margin(criteria, contact))


def turning_margin(criteria: tuple[Criterion, ...], contact: RoughContact, probability: float = 0.5) -> float:
    """Mean margin at which criteria support a probability that a contact like this is sticky."""
    supported = _supports(criteria, contact, None)
    # A hundredth is finer than the steps from one surface of the record to the next.
    found = bisect(lambda margin: supported(margin).probability - probability, -_FAR, _FAR, xtol=0.01)
    return float(np.exp(found))


def _supports(criteria: tuple[Criterion, ...], contact: RoughContact, without: Left | None) -> Supports:
    """What the record says of a contact, as a function of the logarithm of the mean margin."""
    margins, (ratios, kind) = _margins(criteria), _kinds()
    heard = np.array([without is None or not without(surface) for surface in recorded()])
    near = heard & np.all(np.abs(ratios - np.log(_ratios(contact))) <= np.log(SIMILAR), axis=1)

    def at(margin: float) -> Support:
        sticky, count = _count(margins[near], kind[near], margin)
        if count >= FEWEST:
            return Support((sticky + 0.5) / (count + 1), count, True)
        nearer = float(np.sign(margin) * max(abs(margin) - np.log(ELSEWHERE), 0.0))
        sticky, count = _count(margins[heard], kind[heard], nearer)
        return Support((sticky + 0.5) / (count + 1), count, False)

    return at


def _count(margins: Real, kind: Real, margin: float) -> tuple[int, int]:
    """Surfaces that were sticky at a margin, of those that say anything there."""
    turned = margins[kind == 0] < margin
    yes, no = margins[kind == 1] <= margin, margins[kind == -1] >= margin
    return int(turned.sum() + yes.sum()), int(turned.size + yes.sum() + no.sum())


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
        return _answer(self.support.probability)

    @property
    def counts(self) -> bool:
        """Whether the theory is in its range, and no mere necessary condition."""
        return self.estimate.valid and self.support is not None


def _answer(probability: float) -> Answer:
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
    """Work of adhesion at which the probability passes one half; None without a probability."""


def votes(contact: RoughContact, without: Left | None = None) -> tuple[Vote, ...]:
    """The :func:`support` of every criterion that the contact allows, in the order of :data:`CRITERIA`, as votes."""
    asked = ((one, CRITERIA[one.key]) for one in verdicts(contact))
    return tuple(Vote(one, support((entry,), contact, without) if entry.sufficient else None) for one, entry in asked)


def judge(prediction: Prediction) -> Verdict:
    """The verdict on a contact, faults of its maps included."""
    excluded = tuple(f"{fault.kind}: {fault.excludes}" for fault in prediction.faults if fault.excludes)
    if excluded:
        return Verdict("undecided", None, excluded)
    plain = judge_contact(prediction.contact)
    if prediction.mended is not None:
        better = judge_contact(prediction.mended.contact)
        if better.answer != plain.answer:
            why = f"as measured the map is {plain.answer}, with its faults mended {better.answer}"
            return Verdict("undecided", None, (why,))
    hopeless = [fault.kind for fault in prediction.faults if not fault.remedy]
    if hopeless:
        return _firm(plain, (prediction.mended or prediction).contact, f"{' and '.join(hopeless)}, without remedy")
    return plain


def judge_contact(contact: RoughContact, without: Left | None = None) -> Verdict:
    """The verdict of all theories in their range, heard together.

    Surfaces that are somewhat steep are judged as if they were less so, which to linear elasticity is the same contact,
    and more firmly.
    """
    slope = contact.rms_slope
    if LARGEST_SLOPE < slope <= STEEPEST:
        factor = LARGEST_SLOPE * (1 - 1e-9) / slope
        flatter = _stretched(contact, factor)
        found = _firm(_heard(flatter, without), flatter, f"h' = {slope:.3g} is not small", without)
        return replace(found, turn=None if found.turn is None else found.turn / factor**2)
    return _heard(contact, without)


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
    together = tuple(reversed(distinct.values()))
    found = support(together, contact, without)
    turn = contact.work_of_adhesion * turning_margin(together, contact) / np.exp(_margin(together, contact))
    names = ", ".join(vote.estimate.name for vote in heard)
    alike = "similar surfaces" if found.similar else "surfaces, none of them similar"
    why = (f"{names}, by {found.count} {alike}",)
    return Verdict(_answer(found.probability), found.probability, why, float(turn))


def _stretched(contact: RoughContact, factor: float) -> RoughContact:
    """The same contact with heights, and the range, stretched: work and energy go with the square."""
    lengths = ("rms_height", "rms_slope", "rms_curvature", "range")
    energy = contact.conformal_energy
    return replace(
        contact,
        **{name: factor * getattr(contact, name) for name in lengths},
        work_of_adhesion=factor**2 * contact.work_of_adhesion,
        conformal_energy=None if energy is None else factor**2 * energy,
    )


def _firm(found: Verdict, contact: RoughContact, cause: str, without: Left | None = None) -> Verdict:
    """A verdict that is the same at :data:`WIDE` times more or less work of adhesion, toward the turn; else none."""
    if found.answer == "undecided":
        return found
    factor = WIDE if found.answer == "not sticky" else 1 / WIDE
    nearer = judge_contact(replace(contact, work_of_adhesion=factor * contact.work_of_adhesion), without)
    if nearer.answer == found.answer:
        return found
    why = f"{cause}: a verdict would have to hold at {factor:g} times the work of adhesion, too"
    return Verdict("undecided", None, (why,))
