"""How often each criterion was right: its margins on surfaces whose contacts were computed.

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

import numpy as np

from continuum.sticky.criteria import Criterion, RoughContact

SIMILAR = 3.0
FEWEST = 10
"""Surfaces below which they are too few, and those of the whole record are asked."""
ELSEWHERE = 3.0
"""Factor by which a margin is then taken nearer to the turn: theories drift by as much over the record's ranges."""


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
