"""The wall laws of :mod:`continuum.model.laws` on the arrays of a library."""

from __future__ import annotations

from functools import cache, partial
from typing import NamedTuple

from continuum.model import laws
from continuum.model.laws import OnArrays
from continuum.solve.arrays.library import Array, Library


@cache
def _powers(m: int, n: int) -> OnArrays:
    """The formula of two exponents, for which it is compiled."""
    return partial(laws.powers_on_arrays, m=m, n=n)


class DeviceLaw(NamedTuple):
    """A law on a device."""

    parameters: Array
    formula: OnArrays

    @classmethod
    def on(cls, library: Library, law: laws.Law) -> DeviceLaw:
        """A law for the arrays of a library."""
        p, powers = law.parameters, law.kind == laws.INVERSE_POWERS
        return cls(library.put(p), _powers(int(p[2]), int(p[3])) if powers else laws.ON_ARRAYS[law.kind])
