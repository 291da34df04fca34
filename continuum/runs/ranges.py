"""Ranges of an input file: ``{from = 0.01, to = 0.16, factor = 2.0}`` for ``[0.01, 0.02, 0.04, 0.08, 0.16]``."""

import math
from collections.abc import Mapping
from typing import Any

MOST = 1_000_000
"""Values of a range, and systems of a sweep, at most."""
_HUGE = 1e150  # numbers whose differences and ratios are numbers, too


def expand_range(given: Any) -> tuple[Any, ...]:
    """The values of a list, or of a range ``{from, to, step | factor | count}``, its end included.

    Raises ValueError if it is neither.
    """
    if isinstance(given, (tuple, list)):
        return tuple(given)
    if not isinstance(given, Mapping):
        raise ValueError(f"not {given!r}")
    steps = [name for name in ("step", "factor", "count") if name in given]
    numbers: list[Any] = [given.get(name) for name in ("from", "to", *steps)]
    if len(steps) != 1 or len(given) != 3 or not all(type(n) in (int, float) and abs(n) < _HUGE for n in numbers):
        raise ValueError("from and to, and one of step, factor and count, all of them numbers")
    first, last, by = numbers
    if steps == ["count"]:
        if type(by) is not int or by < 2:
            raise ValueError("count is a whole number from 2 on")
        return tuple(first + (last - first) * i / (by - 1) for i in range(_enough(by - 1)))
    # Rounded up a little: a decimal step may miss its end by the last digit.
    if steps == ["step"] and by * (last - first) > 0:
        return tuple(first + i * by for i in range(_enough((last - first) / by)))
    if steps == ["factor"] and by > 0 and first * last > 0 and by != 1 and math.log(last / first) / math.log(by) >= 0:
        return tuple(first * by**i for i in range(_enough(math.log(last / first) / math.log(by))))
    raise ValueError("a step or factor that leads from the one to the other")


def _enough(steps: float) -> int:
    """Values for so many steps."""
    if steps >= MOST:
        raise ValueError(f"at most {MOST} values, not {steps + 1:.3g}")
    return int(steps + 1e-9) + 1
