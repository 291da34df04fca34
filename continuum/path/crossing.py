"""Where a quantity crosses a value along a key, from trials at some places of it: all searches for one ask this.

A threshold of stickiness is the work of adhesion at which the load changes its sign, and its trials are states
(:mod:`continuum.path.threshold_search`); the search of a sweep goes along any key for any column of its table, and its
trials are systems (:mod:`continuum.store.sweeps.bisection`).  The next trial follows from the bracket alone, so that a
search goes on from its trials as if it had never stopped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

ONE_SIDED, EDGE = 3, 0.02
"""Trials in a row on one side after which a bracket is halved, and the part of it that a secant leaves at its ends.

Secants alone stay on one side of steep areas: 14 solves instead of 7.
"""


@dataclass(frozen=True)
class Bracket:
    """The state of a search: places on a key between which a quantity crosses a value."""

    lower: float = math.nan
    """Place of the last trial below the crossing; NaN if there is none."""
    upper: float = math.nan
    at_lower: float = math.nan
    """The quantity at the lower end; NaN if it is not known."""
    at_upper: float = math.nan
    trials: int = 0
    """Number of trials so far."""
    next: float | None = None
    """Next place to try; None if the search has ended."""
    value: float = math.nan
    """Interpolated place of the crossing; NaN if unknown."""
    reason: str = ""
    """Why the search has ended without a crossing; empty if it has not."""
    crosses: float = 0.0
    """The value that is crossed."""
    rising: bool = True
    """Whether the quantity rises along the key."""
    log: bool = False
    """Whether the bracket is halved, and read in between, in the logarithm of the key."""
    run: int = 0
    """Trials in a row on the side of the last one: above the crossing, or negative below."""

    @property
    def again(self) -> int:
        """Trials after the first one on the only side of the crossing that has any."""
        one = math.isnan(self.at_lower) != math.isnan(self.at_upper)
        return max(abs(self.run) - 1, 0) if one else 0

    @property
    def known(self) -> bool:
        """Whether the quantity is known at both ends."""
        return not (math.isnan(self.at_lower) or math.isnan(self.at_upper))

    @property
    def crossed(self) -> bool:
        """Whether the quantity crosses the value between the ends."""
        low, high = self.at_lower - self.crosses, self.at_upper - self.crosses
        return self.known and low != high and min(low, high) <= 0 <= max(low, high)

    @property
    def width(self) -> float:
        """Distance of the ends; NaN with one of them only."""
        return self.upper - self.lower

    @property
    def middle(self) -> float:
        if self.log:
            return math.sqrt(self.lower) * math.sqrt(self.upper)
        return self.lower / 2 + self.upper / 2

    @property
    def root(self) -> float:
        """Where the quantity crosses the value, if it is linear in the key, or in its logarithm."""
        if self.at_lower == self.crosses:  # and perhaps at the upper end
            return self.lower
        share = (self.crosses - self.at_lower) / (self.at_upper - self.at_lower)
        if self.log:
            return float(self.lower * (self.upper / self.lower) ** share)
        return self.lower + share * (self.upper - self.lower)

    def add(self, place: float, at: float) -> Bracket:
        """The bracket after a further trial, which is the end on its side of the crossing.

        Of two trials in the wrong order, as of a quantity that is not known exactly, the older one is no end any more.
        """
        trials = self.trials + 1
        if at >= self.crosses if self.rising else at <= self.crosses:
            found = replace(self, upper=place, at_upper=at, trials=trials, run=max(self.run, 0) + 1)
            return found.without(upper=False) if self.lower > place else found
        found = replace(self, lower=place, at_lower=at, trials=trials, run=min(self.run, 0) - 1)
        return found.without(upper=True) if self.upper < place else found

    def without(self, *, upper: bool) -> Bracket:
        """The bracket without its upper end, or its lower one."""
        if upper:
            return replace(self, upper=math.nan, at_upper=math.nan)
        return replace(self, lower=math.nan, at_lower=math.nan)

    def inside(self, *, halve: bool = False) -> float:
        """A place between both ends to close in on the crossing.

        By the secant, in which an end that has stayed counts half as much each time (the Illinois method: Dowell and
        Jarratt, BIT 11, 168 (1971)); the middle where that is asked for, or has stayed on one side for long.
        """
        if halve or abs(self.run) > ONE_SIDED:
            return self.middle
        low, high = self.at_lower - self.crosses, self.at_upper - self.crosses
        kept = 0.5 ** (abs(self.run) - 1)
        low, high = (low * kept, high) if self.run > 0 else (low, high * kept)
        share = low / (low - high) if low != high else 0.5
        return self.lower + min(max(share, EDGE), 1 - EDGE) * self.width

    def closing(self, width: float) -> float:
        """A place beyond :attr:`root`, by a third of a width, so that a trial there leaves a bracket of that width.

        Never nearer to an end than a tenth of the way: a step that gains nothing is not made twice.
        """
        root, third, edge = self.root, width / 3, self.width / 10
        place = root + third if root + third - self.lower <= width else root - third
        return min(max(place, self.lower + edge), self.upper - edge)
