"""The record of the criteria: the probability of stickiness at a given margin, from surfaces like the one judged.

It has two parts, both in units of pixels and E* = 1.  That of whole maps (``record.csv``, made by
``python -m docs.studies.record``) holds Gaussian surfaces of two kinds: with the work of adhesion at which the load at
1 % repulsive area changes its sign on approach, and with one work of adhesion and the sign found there.  That of
summits (``summits.csv``) holds Gaussian, worn, honed, pitted, beaded and other surfaces
with the work at which they become sticky; its moments are those of the upper twentieth of the points.

An exact criterion has a margin of 1 at the threshold.  The probability that a contact with a given margin is sticky is
the share of similar surfaces that became sticky at a smaller one; the mean margin of several theories has a record in
the same way.

Elasticity is linear and slopes are small: heights stretched by s, with a range s times as long and s² times the work,
have the same contact.  A contact is therefore characterised by the numbers of :data:`_NUMBERS`.  The record says
nothing of a contact of which one lies outside of those of the surfaces that became sticky (:func:`outside`).  Surfaces
are similar if their first two numbers are within a factor of :data:`SIMILAR` of those of the contact.
"""

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.maps.verdict.criteria import Criterion, RoughContact
from continuum.model.fourier import Real

Part = Literal["map", "summits"]
"""The points whose roughness is judged."""
_FILES: dict[Part, str] = {"map": "record.csv", "summits": "summits.csv"}
_COLUMNS = ("rms_height", "rms_slope", "rms_curvature", "work", "range", "conformal_energy")
SIMILAR = 3.0
FEWEST = 10
"""Smallest number of similar surfaces that became sticky; with fewer the record says nothing."""
_NUMBERS: Mapping[str, Callable[[RoughContact], float]] = {
    "Δr/h_rms": lambda c: c.range / c.rms_height,
    "Δr h''/h'²": lambda c: c.range * c.rms_curvature / c.rms_slope**2,
    "h_rms h''/h'²": lambda c: c.rms_height * c.rms_curvature / c.rms_slope**2,
    "U/(E* h_rms h')": lambda c: (c.conformal_energy or np.nan) / (c.contact_modulus * c.rms_height * c.rms_slope),
    "λ_L h'/h_rms": lambda c: (c.roll_off or np.nan) * c.rms_slope / c.rms_height,
}
"""Numbers of a contact that stretched heights do not change, NaN where unknown; the last only for criteria of λ_L."""
_FAR = 30.0  # beyond the logarithm of any margin
_ROUNDING = 1e-6  # numbers of a stretched contact differ by it
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
    """Number of similar surfaces of which this is known at this margin."""


Supports = Callable[[float], Support]


def _numbers(contact: RoughContact) -> list[float]:
    return [number(contact) for number in _NUMBERS.values()]


@cache
def recorded(part: Part = "map") -> tuple[Surface, ...]:
    """The surfaces of the record."""
    text = Path(__file__).with_name(_FILES[part]).read_text()
    found = []
    for row in csv.DictReader(text.splitlines()):
        height, slope, curvature, work, reach, energy = (float(row[name]) for name in _COLUMNS)
        roll_off = float(row["lambda_L"]) if "lambda_L" in row else None
        contact = RoughContact(height, slope, curvature, work, reach, conformal_energy=energy, roll_off=roll_off)
        found.append(Surface(contact, {"yes": True, "no": False}.get(row.get("sticky", "")), row.get("class", "")))
    return tuple(found)


@cache
def _kinds(part: Part) -> tuple[Real, Real]:
    """Logarithms of the numbers of each surface, and 1 if it was sticky, -1 if not, 0 at the threshold."""
    surfaces = recorded(part)
    numbers = np.log([_numbers(surface.contact) for surface in surfaces])
    return numbers, np.array([{None: 0.0, True: 1.0, False: -1.0}[surface.sticky] for surface in surfaces])


@cache
def _margins(criteria: tuple[Criterion, ...], part: Part) -> Real:
    """Logarithm of the mean margin on each surface."""
    return np.array([mean_margin(criteria, surface.contact) for surface in recorded(part)])


def mean_margin(criteria: tuple[Criterion, ...], contact: RoughContact) -> float:
    """Logarithm of the geometric mean of the margins of criteria."""
    return float(np.mean([np.log(criterion(contact).margin or np.nan) for criterion in criteria]))


def outside(
    criteria: tuple[Criterion, ...], contact: RoughContact, without: Left | None = None, part: Part = "map"
) -> str:
    """Why the record of criteria says nothing of a contact, in words; empty if it has surfaces like this."""
    numbers, kind = _kinds(part)
    at_threshold = numbers[_heard(without, part) & (kind == 0)]
    known = len(_NUMBERS) - (not any(criterion.needs == "roll_off" for criterion in criteria))
    for name, value, its in zip(list(_NUMBERS)[:known], _numbers(contact), at_threshold.T, strict=False):
        low, high = (float(np.exp(end)) for end in (its.min(initial=_FAR), its.max(initial=-_FAR)))
        if value < low * (1 - _ROUNDING) or value > high * (1 + _ROUNDING):
            return f"{name} = {value:.3g} is not between {low:.3g} and {high:.3g}, as on the surfaces of the record"
    count = int(_near(at_threshold, contact).sum())
    return "" if count >= FEWEST else f"{count} surfaces of the record are similar, fewer than {FEWEST}"


def support(
    criteria: tuple[Criterion, ...], contact: RoughContact, without: Left | None = None, part: Part = "map"
) -> Support | None:
    """Probability that a contact is sticky, from the mean margin of criteria on it and on similar surfaces.

    The criteria are one or several of :data:`continuum.maps.verdict.criteria.CRITERIA`; None if it is :func:`outside`.
    """
    if outside(criteria, contact, without, part):
        return None
    return _supports(criteria, contact, without, part)(mean_margin(criteria, contact))


def threshold_margin(
    criteria: tuple[Criterion, ...], contact: RoughContact, probability: float = 0.5, part: Part = "map"
) -> float:
    """Mean margin at which criteria support a probability that a contact like this is sticky.

    Raises ValueError if the contact is :func:`outside` of their record.
    """
    if why := outside(criteria, contact, None, part):
        raise ValueError(why)
    supported = _supports(criteria, contact, None, part)
    # A hundredth is finer than the differences between surfaces of the record.
    found = scipy.optimize.bisect(lambda margin: supported(margin).probability - probability, -_FAR, _FAR, xtol=0.01)
    return float(np.exp(found))


@lru_cache(maxsize=4)
def _heard(without: Left | None, part: Part) -> NDArray[np.bool_]:
    """Surfaces of the record that are not left out."""
    return np.array([without is None or not without(surface) for surface in recorded(part)])


def _near(numbers: Real, contact: RoughContact) -> NDArray[np.bool_]:
    """Surfaces similar to a contact."""
    return np.asarray(np.all(np.abs(numbers[:, :2] - np.log(_numbers(contact)[:2])) <= np.log(SIMILAR), axis=1))


def _supports(criteria: tuple[Criterion, ...], contact: RoughContact, without: Left | None, part: Part) -> Supports:
    """The similar surfaces of the record, as a function of the logarithm of the mean margin."""
    margins, (numbers, kind) = _margins(criteria, part), _kinds(part)
    near = _heard(without, part) & _near(numbers, contact)

    def at(margin: float) -> Support:
        sticky, count = _count(margins[near], kind[near], margin)
        return Support((sticky + 0.5) / (count + 1), count)

    return at


def _count(margins: Real, kind: Real, margin: float) -> tuple[int, int]:
    """Number of surfaces that were sticky at a margin, and number of surfaces for which this is known."""
    at_threshold = margins[kind == 0] < margin
    yes, no = margins[kind == 1] <= margin, margins[kind == -1] >= margin
    return int(at_threshold.sum() + yes.sum()), int(at_threshold.size + yes.sum() + no.sum())
