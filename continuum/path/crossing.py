"""Where a quantity crosses a value along a key, from trials at some places of it: all searches for one ask this.

A threshold of stickiness is the work of adhesion at which the load changes its sign, and its trials are states
(:mod:`continuum.path.threshold_search`); the search of a sweep goes along any key for any column of its table, and its
trials are systems (:mod:`continuum.sweeps.bisection`).  The next trial follows from the bracket alone, so that a search
goes on from its trials as if it had never stopped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace


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
    again: int = 0
    """Trials after the first one on the only side of the crossing that has any."""

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
            again = self.again + 1 if math.isnan(self.at_lower) and not math.isnan(self.at_upper) else 0
            found = replace(self, upper=place, at_upper=at, trials=trials, again=again)
            return replace(found, lower=math.nan, at_lower=math.nan) if self.lower > place else found
        again = self.again + 1 if math.isnan(self.at_upper) and not math.isnan(self.at_lower) else 0
        found = replace(self, lower=place, at_lower=at, trials=trials, again=again)
        return replace(found, upper=math.nan, at_upper=math.nan) if self.upper < place else found

    def closing(self, width: float) -> float:
        """A place beyond :attr:`root`, by a third of a width, so that a trial there leaves a bracket of that width.

        Never nearer to an end than a tenth of the way: a step that gains nothing is not made twice.
        """
        root, third, edge = self.root, width / 3, self.width / 10
        place = root + third if root + third - self.lower <= width else root - third
        return min(max(place, self.lower + edge), self.upper - edge)
