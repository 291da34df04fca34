"""Numbers and variables as LAMMPS reads them."""

from __future__ import annotations

from collections.abc import Sequence


def formatted(value: float) -> str:
    """A number with all its digits: it reads back as the same float."""
    return f"{float(value):.17g}"


def listing(values: Sequence[float]) -> str:
    """Numbers of an index variable, one on each line."""
    return " &\n                ".join(map(formatted, values))


def atom_variable(name: str, formula: str) -> str:
    """A line that defines an atom-style variable; the formula has no blanks, so that ``${...}`` in it is replaced."""
    return f"variable        {name} atom {formula}"
