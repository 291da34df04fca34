"""Numbers and variables as LAMMPS reads them."""

from collections.abc import Iterable, Sequence


def formatted(value: float) -> str:
    """A number with all its digits, which is read back as the same float."""
    return repr(float(value)).removesuffix(".0")


def listing(values: Sequence[float] | Sequence[str]) -> str:
    """Numbers or words of an index variable, one on each line."""
    texts = (value if isinstance(value, str) else formatted(value) for value in values)
    return " &\n                ".join(texts)


def vector(values: Iterable[float]) -> str:
    """Numbers of a vector-style variable, five on each line, which LAMMPS reads once."""
    numbers = [formatted(value) for value in values]
    return "[" + ",&\n".join(",".join(numbers[i : i + 5]) for i in range(0, len(numbers), 5)) + "]"


def atom_variable(name: str, formula: str) -> str:
    """A line that defines an atom-style variable; the formula has no blanks, so that ``${...}`` in it is replaced."""
    return f"variable        {name} atom {formula}"
