"""The record of the criteria: the probability of stickiness at a given margin, from surfaces like the one judged.

It has two parts, both in units of pixels and E* = 1.  That of whole maps (``record.csv``, made by
``tests/studies/record.py``) holds Gaussian surfaces of two kinds: with the work of adhesion at which the load at 1 %
repulsive area changes its sign on approach, and with one work of adhesion and the sign found there.  That of summits
(``summits.csv``, made by ``tests/studies/classes.py``) holds Gaussian, worn, honed, pitted, beaded and other surfaces
with the work at which they turn; its moments are those of the upper twentieth of the points.

An exact criterion has a margin of 1 at the turn.  The probability that a contact with a given margin is sticky is the
share of surfaces that turned at a smaller one; the mean margin of several theories has a record in the same way.

Elasticity is linear and slopes are small: heights stretched by s, with a range s times as long and s² times the work,
have the same contact.  A contact is therefore characterised by the range of attraction over h_rms and over δh =
h'²/h''.  Surfaces are similar if both are within a factor of :data:`SIMILAR` of those of the contact.
"""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Literal

import numpy as np
from scipy.optimize import bisect

from continuum.model.fourier import Real
from continuum.sticky.criteria import Criterion, RoughContact

Part = Literal["map", "summits"]
"""The points whose roughness is judged."""
_FILES: dict[Part, str] = {"map": "record.csv", "summits": "summits.csv"}
_COLUMNS = ("rms_height", "rms_slope", "rms_curvature", "work", "range", "conformal_energy")
SIMILAR = 3.0
FEWEST = 10
"""Smallest number of similar surfaces; with fewer, the whole record is used."""
ELSEWHERE = 3.0
"""Factor by which a margin is then moved towards the turn: theories drift by as much over the ranges of the record."""
_FAR = 30.0  # beyond the logarithm of any margin
Left = Callable[["Surface"], bool]
"""Function that is True for surfaces to leave out, so that the record can be tested on unseen surfaces."""


@dataclass(frozen=True)
class Surface:
    """One surface of the record with a work of adhesion."""

    contact: RoughContact
    sticky: bool | None
    """Whether it was sticky at this work of adhesion; None if the load changes its sign there."""
    kind: str = ""
    """Class of the surface, in the record of summits."""


@dataclass(frozen=True)
class Support:
    """The probability of stickiness at a margin."""

    probability: float
    """Probability that the contact is sticky."""
    count: int
    """Number of surfaces used at this margin."""
    similar: bool
    """Whether they are similar to the contact; otherwise they are the whole record."""


Supports = Callable[[float], Support]


def _ratios(contact: RoughContact) -> tuple[float, float]:
    """The range over the height and over the change of height in the contact."""
    change = contact.rms_slope**2 / contact.rms_curvature
    return contact.range / contact.rms_height, contact.range / change


@cache
def recorded(part: Part = "map") -> tuple[Surface, ...]:
    """The surfaces of the record."""
    text = resources.files("continuum.sticky").joinpath(_FILES[part]).read_text()
    found = []
    for row in csv.DictReader(text.splitlines()):
        height, slope, curvature, work, reach, energy = (float(row[name]) for name in _COLUMNS)
        roll_off = float(row["lambda_L"]) if "lambda_L" in row else None
        contact = RoughContact(height, slope, curvature, work, reach, conformal_energy=energy, roll_off=roll_off)
        found.append(Surface(contact, {"yes": True, "no": False}.get(row.get("sticky", "")), row.get("class", "")))
    return tuple(found)


@cache
def _kinds(part: Part) -> tuple[Real, Real]:
    """Logarithms of the ratios of each surface, and 1 if it was sticky, -1 if not, 0 at the turn."""
    surfaces = recorded(part)
    ratios = np.log([_ratios(surface.contact) for surface in surfaces])
    return ratios, np.array([{None: 0.0, True: 1.0, False: -1.0}[surface.sticky] for surface in surfaces])


@cache
def _margins(criteria: tuple[Criterion, ...], part: Part) -> Real:
    """Logarithm of the mean margin on each surface."""
    return np.array([mean_margin(criteria, surface.contact) for surface in recorded(part)])


def mean_margin(criteria: tuple[Criterion, ...], contact: RoughContact) -> float:
    """Logarithm of the geometric mean of the margins of criteria."""
    return float(np.mean([np.log(criterion(contact).margin or np.nan) for criterion in criteria]))


def support(
    criteria: tuple[Criterion, ...], contact: RoughContact, without: Left | None = None, part: Part = "map"
) -> Support:
    """Probability that a contact is sticky, from the mean margin of criteria on it and on the surfaces of the record.

    The criteria are one or several of :data:`continuum.sticky.criteria.CRITERIA`.
    """
    return _supports(criteria, contact, without, part)(mean_margin(criteria, contact))


def turning_margin(
    criteria: tuple[Criterion, ...], contact: RoughContact, probability: float = 0.5, part: Part = "map"
) -> float:
    """Mean margin at which criteria support a probability that a contact like this is sticky."""
    supported = _supports(criteria, contact, None, part)
    # A hundredth is finer than the differences between surfaces of the record.
    found = bisect(lambda margin: supported(margin).probability - probability, -_FAR, _FAR, xtol=0.01)
    return float(np.exp(found))


def _supports(criteria: tuple[Criterion, ...], contact: RoughContact, without: Left | None, part: Part) -> Supports:
    """The record for a contact, as a function of the logarithm of the mean margin."""
    margins, (ratios, kind) = _margins(criteria, part), _kinds(part)
    heard = np.array([without is None or not without(surface) for surface in recorded(part)])
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
    """Number of surfaces that were sticky at a margin, and number of surfaces for which this is known."""
    turned = margins[kind == 0] < margin
    yes, no = margins[kind == 1] <= margin, margins[kind == -1] >= margin
    return int(turned.sum() + yes.sum()), int(turned.size + yes.sum() + no.sum())
