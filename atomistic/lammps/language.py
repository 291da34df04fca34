"""LAMMPS' language: numbers and variables as it reads them, and the templates of its scripts."""

import string
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files


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


class _Template(string.Template):
    """Placeholders are @{name}: $ belongs to LAMMPS."""

    delimiter = "@"


@cache
def read_template(name: str) -> str:
    """Text of a file in ``templates/``."""
    return (files("atomistic.lammps") / "templates" / name).read_text(encoding="utf-8")


@cache
def vocabulary() -> dict[str, dict[str, str]]:
    """Words that fill the templates, by the kind of deck."""
    return tomllib.loads(read_template("words.toml"))


def filled(text: str, values: Mapping[str, object]) -> str:
    """A template with its placeholders filled, floats with all their digits; raises KeyError if one is unknown."""
    words = {name: formatted(v) if isinstance(v, float) else str(v) for name, v in values.items()}
    return _Template(text).substitute(words)
