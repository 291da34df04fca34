"""Any other ``pair_style`` of the installed LAMMPS, in a form in which no text of a user becomes a command.

A style is a name, and everything else is a list of words: a word holds letters, digits and ``_ . + - * / =`` only, so
that it can neither end a line nor begin a variable.  Files travel with the model by their content, under names of ours.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

from atomistic.crystal.potentials import PotentialError, content_of

__all__ = ["REFUSED_STYLES", "PairStyle"]

REFUSED_STYLES = re.compile(r"python|none|zero|hybrid.*|list|srp.*|kim|quip")
"""Styles that run programs of a file, read other paths, hold no crystal, or are several."""
_STYLE = re.compile(r"[a-z][a-z0-9/_+-]{0,63}")
_WORD = re.compile(r"[A-Za-z0-9_.+*/=-]{1,100}")
_ELEMENT = re.compile(r"[A-Z][a-z]?")


@dataclass(frozen=True)
class PairStyle:
    """One element in any ``pair_style``, in LAMMPS' units ``metal``: eV and Å.

    Parameters
    ----------
    style : name, as LAMMPS has it.
    element : chemical symbol.
    mass : of an atom, in u.
    cutoff : of the formulas, in Å.
    lattice_constant : of the fcc crystal, to a tenth, in Å: it is measured from there.
    arguments : words that follow the name.
    coefficients : words of each ``pair_coeff``, "*" "*" among them; a word that is the name of one of the files stands
        for that file.
    contents : files by name.
    many_body : whether atoms feel changes at their neighbours, so that forces reach twice the cut-off.

    Raises
    ------
    PotentialError
        If a name or a word is none, or a style is refused.
    """

    style: str
    element: str
    mass: float
    cutoff: float
    lattice_constant: float
    arguments: tuple[str, ...] = ()
    coefficients: tuple[tuple[str, ...], ...] = (("*", "*"),)
    contents: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    many_body: bool = True

    units: Literal["metal"] = field(default="metal", init=False)
    atom_style: Literal["atomic"] = field(default="atomic", init=False)

    def __post_init__(self) -> None:
        """Refuse what is no name, no word, or no number."""
        if not _STYLE.fullmatch(self.style) or REFUSED_STYLES.fullmatch(self.style):
            msg = f"{self.style[:80]!r} is no pair_style that a substrate can be made of"
            raise PotentialError(msg)
        if not _ELEMENT.fullmatch(self.element):
            msg = f"{self.element[:80]!r} is no chemical symbol"
            raise PotentialError(msg)
        for name in ("mass", "cutoff", "lattice_constant"):
            value = getattr(self, name)
            if not 0 < value < 1000:
                msg = f"the {name.replace('_', ' ')} of a pair_style is positive, in u or Å, got {value}"
                raise PotentialError(msg)
        if not self.coefficients or not all(self.coefficients):
            msg = "a pair_style has at least one pair_coeff, each of at least one word"
            raise PotentialError(msg)
        known = set(self.contents)
        for word in (*self.arguments, *(word for line in self.coefficients for word in line if word not in known)):
            # A path would read a file that does not travel with the model.
            if not _WORD.fullmatch(word) or "/" in word:
                cause = "name a file also under files" if "/" in word else "letters, digits and _ . + - * ="
                msg = f"{word[:80]!r} is no word of a pair_style or pair_coeff: {cause}"
                raise PotentialError(msg)

    @staticmethod
    def read_files(paths: tuple[Path, ...]) -> dict[str, bytes]:
        """Contents of files by their names.

        Raises
        ------
        PotentialError
            If one cannot be read or is too large, or two have one name.
        """
        found: dict[str, bytes] = {}
        for path in paths:
            content = content_of(path)
            if path.name in found:
                msg = f"two files have the name {path.name}"
                raise PotentialError(msg)
            found[path.name] = content
        return found

    @property
    def guess(self) -> float:
        """Volume per atom of the fcc crystal, roughly, in Å³."""
        return self.lattice_constant**3 / 4

    @property
    def force_range(self) -> float:
        """How far a displaced atom changes forces, in Å."""
        return (2 if self.many_body else 1) * self.cutoff

    @cached_property
    def _names(self) -> dict[str, str]:
        return {name: f"potential.{i}" for i, name in enumerate(sorted(self.contents), 1)}

    @property
    def files(self) -> Mapping[str, bytes]:
        """Files that :meth:`interactions` reads."""
        return {self._names[name]: content for name, content in self.contents.items()}

    @cached_property
    def identity(self) -> dict[str, str | float]:
        """What results depend on: files count by their content."""
        digests = {name: hashlib.sha256(content).hexdigest() for name, content in self.files.items()}
        return {
            "kind": "pair-style", "commands": self.interactions(), "element": self.element, "mass": self.mass,
            "cutoff": self.cutoff, "many_body": float(self.many_body), **digests,
        }  # fmt: skip

    @property
    def reference(self) -> str:
        """Where the model comes from."""
        files = ", ".join(
            f"{''.join(c for c in name if c.isprintable())[:80]} (sha256 {hashlib.sha256(content).hexdigest()[:12]})"
            for name, content in self.contents.items()
        )
        return f"{self.element}, pair_style {self.style}{f', {files}' if files else ''}"

    def settings(self) -> str:
        """LAMMPS commands that come before the atoms are read."""
        return "atom_style      atomic"

    def interactions(self) -> str:
        """LAMMPS commands that define the forces."""
        lines = [" ".join(["pair_style     ", self.style, *self.arguments])]
        for words in self.coefficients:
            lines.append(" ".join(["pair_coeff     ", *(self._names.get(word, word) for word in words)]))
        return "\n".join(lines)
