"""A search along one key for the place where a column of the table crosses a value, by bisection.

Its bracket is that of every search, :class:`continuum.path.crossing.Bracket`: the next trial follows from the column at
earlier trials only, so that a search continues from its files after any interruption.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from continuum.inputs.tables import Fault
from continuum.inputs.toml import slip
from continuum.path.crossing import Bracket
from continuum.store.sweeps.measured import COLUMNS, SystemTable

KEYS: Mapping[str, str] = {
    "bisect": 'a column of the table, as "load", and at which target of the path, as "load at 1 %"; else at its end',
    "from": "lower end of the values to search",
    "to": "upper end of the values to search, above from",
    "tolerance": "width of the last bracket, from 1e-6 to 0.5, relative to its values; if linear, to the larger end",
    "crosses": "value that the column crosses; 0 if not given",
    "scale": '"log" or "linear": in which the bracket is halved, and read in between; log if not given',
}
"""Keys of a search with their descriptions; the last two are optional."""
_NEEDED = ("bisect", "from", "to", "tolerance")
_SCALES = ("log", "linear")
_COLUMN = re.compile(r"\s*(\w+)(?:\s+at\s+(\S+?)\s*(%?))?\s*")
_FINEST, _COARSEST = 1e-6, 0.5
_HUGE = 1e150  # numbers whose products and differences are numbers, too
_DIGITS = 8  # of a value that is tried: it stands in labels and tables, and is the same on any machine


@dataclass(frozen=True)
class Bisection:
    """A search for the value of a key at which a column crosses a value.

    The ends are solved first; if they bracket the value, the bracket is halved a fixed number of times.
    """

    key: str
    """Dotted key of the input."""
    column: str
    """One of :data:`continuum.store.sweeps.measured.COLUMNS`, or one of one's own."""
    target: float | None
    """Target of the path at which the column is read; None for its last point."""
    crosses: float
    first: float
    last: float
    tolerance: float
    scale: str
    """"log" or "linear"."""

    @classmethod
    def of(cls, key: str, given: Mapping[str, Any]) -> Bisection:
        """The search of a table without :func:`bisection_faults`."""
        found = _COLUMN.fullmatch(given["bisect"])
        assert found is not None
        target = None if found[2] is None else float(found[2]) / (100 if found[3] else 1)
        crosses, first, last, tolerance = (float(given.get(name, 0)) for name in ("crosses", "from", "to", "tolerance"))
        return cls(key, found[1], target, crosses, first, last, tolerance, given.get("scale", "log"))

    @property
    def table(self) -> dict[str, Any]:
        """The table of an input."""
        at = "" if self.target is None else f" at {self.target!r}"
        numbers = {"crosses": self.crosses, "from": self.first, "to": self.last, "tolerance": self.tolerance}
        return {"bisect": f"{self.column}{at}", **numbers, "scale": self.scale}

    @property
    def halvings(self) -> int:
        """Number of halvings, if the ends bracket the value."""
        if self.scale == "log":
            wide = (math.log(self.last) - math.log(self.first)) / math.log1p(self.tolerance)
        else:
            wide = (self.last - self.first) / max(abs(self.first), abs(self.last)) / self.tolerance
        return math.ceil(math.log2(wide) - 1e-9) if wide > 1 else 0

    @property
    def most(self) -> int:
        """Largest number of systems of the search."""
        return 2 + self.halvings

    @property
    def whole(self) -> Bracket:
        """The bracket before its ends are known."""
        return Bracket(self.first, self.last, crosses=self.crosses, log=self.scale == "log")

    def middle(self, bracket: Bracket) -> float:
        """The next trial within a bracket."""
        return float(f"{bracket.middle:.{_DIGITS}g}")

    def is_target(self, value: float) -> bool:
        """Whether the column is read at a point of this target."""
        return self.target is not None and math.isclose(value, self.target, rel_tol=1e-9, abs_tol=1e-12)

    def at(self, numbers: SystemTable) -> float:
        """The column of a system, from all its numbers; NaN where its point has not converged."""
        targets = numbers["target"].tolist()
        steps = [step for step, target in enumerate(targets) if self.target is None or self.is_target(target)]
        step = steps[-1 if self.target is None else 0] if steps else None
        return math.nan if step is None or numbers["converged"][step] != 1 else float(numbers[self.column][step])

    def follow(self, column_at: Callable[[float], float | None]) -> Bracket:
        """The state of the search.

        Parameters
        ----------
        column_at : function that returns the column at a value of the key; None if it is not known, NaN if it has no
            value.
        """
        ends = column_at(self.first), column_at(self.last)
        lower, upper = (math.nan if end is None else end for end in ends)
        bracket = replace(self.whole, at_lower=lower, at_upper=upper, rising=upper > lower)
        name = self.key.rpartition(".")[2]
        for number in range(self.most):
            value = (self.first, self.last)[number] if number < 2 else self.middle(bracket)
            found = ends[number] if number < 2 else column_at(value)
            if found is None:
                return replace(bracket, next=value)
            if math.isnan(found):
                why = "the point did not converge, has none, or is jumped over by a jump across the value"
                return replace(bracket, trials=number + 1, reason=f"no {self.column} at {name} {value:g}: {why}")
            bracket = replace(bracket, trials=number + 1) if number < 2 else bracket.add(value, found)
            if number == 1 and not bracket.crossed:
                said = f"no crossing between {self.first:g} and {self.last:g}"
                return replace(bracket, reason=f"{said}: {self.column} is {lower:.4g} and {upper:.4g}")
        return replace(bracket, value=bracket.root)


def is_bisection(given: Any) -> bool:
    """Whether a value on an axis is a search."""
    if not isinstance(given, Mapping):
        return False
    return "bisect" in given or ("from" in given and not given.keys().isdisjoint(("tolerance", "crosses", "scale")))


def bisection_faults(given: Mapping[str, Any], own: Collection[str] = ()) -> Iterator[Fault]:
    """All that is wrong with the table of a search; ``own`` are the columns of one's own."""
    for name in given.keys() - KEYS.keys():
        yield Fault((name,), "one of the keys " + ", ".join(KEYS), slip(name, KEYS, "misspelt; did you mean {}?"))
    for name in _NEEDED:
        if name not in given:
            yield Fault((name,), f"this key is required ({KEYS[name]})")
    sound = dict[str, float]()
    for name in ("from", "to", "tolerance", "crosses"):
        value: Any = given.get(name)
        if type(value) in (int, float) and abs(value) < _HUGE:
            sound[name] = float(value)
        elif name in given:
            yield Fault((name,), f"a number ({KEYS[name]})", "a number in quotes, or true/false")
    yield from _wrong_column(given.get("bisect", "load"), (*COLUMNS, *own))
    if "tolerance" in sound and not _FINEST <= sound["tolerance"] <= _COARSEST:
        yield Fault(("tolerance",), KEYS["tolerance"])
    scale = given.get("scale", "log")
    if scale not in _SCALES:
        yield Fault(("scale",), '"log" or "linear"', slip(scale, _SCALES, 'a slip; did you mean "{}"?'))
    if scale == "log" and sound.get("from", 1.0) <= 0:
        yield Fault(
            ("from",), 'a number above 0, or scale = "linear"', "zero, or a sign: a logarithm has none of these"
        )
    if {"from", "to"} <= sound.keys() and sound["from"] >= sound["to"]:
        yield Fault(("to",), KEYS["to"], "the ends exchanged")


def _wrong_column(given: Any, columns: Collection[str]) -> Iterator[Fault]:
    found = _COLUMN.fullmatch(given) if isinstance(given, str) else None
    if found is None:
        yield Fault(("bisect",), KEYS["bisect"])
        return
    if found[1] not in columns:
        known = f"the columns are {', '.join(columns)}"
        yield Fault(("bisect",), KEYS["bisect"], slip(found[1], columns, "misspelt; did you mean {}?", known))
    try:
        finite = found[2] is None or math.isfinite(float(found[2]))
    except ValueError:
        finite = False
    if not finite:
        yield Fault(("bisect",), f"a number after at, which is a target of the path, not {found[2]}")
