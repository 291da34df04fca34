"""Any other ``pair_style`` of the installed LAMMPS without charges, so that it injects no commands into a script.

A style is a name, and all arguments are words of letters, digits and ``_ . + - * / =`` only, which can neither end a
line nor begin a variable.  The content of files is stored with the model, under names of ours.
"""

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import takewhile
from pathlib import Path
from typing import Any, Literal

from atomistic.crystal.crystal import standard_mass
from atomistic.crystal.interatomic import BondlessPotential, check_masses, check_others
from atomistic.crystal.potentials import content_of
from continuum.inputs import possible
from continuum.inputs.arguments import ArgumentError, file_name, flag, number

REFUSED_STYLES = re.compile(r"python|none|zero|list|srp.*|kim|quip|hybrid/(?!overlay$).*")
"""Refused styles: those that run code from a file, read other paths, describe no crystal, or weigh several styles by
variables.  Those that ``hybrid`` and ``hybrid/overlay`` combine are words that follow, of which none may be refused."""
_MLIAP = re.compile(r"mliap(/.*)?")
_PYTHON = frozenset({"mliappy", "unified"})
"""Words by which ``mliap`` loads a model of Python, a pickle, which runs code as it is read."""
_PICKLE = re.compile(rb"\x80[\x02-\x05]")
_STYLE = re.compile(r"[a-z][a-z0-9/_+-]{0,63}")
_WORD = re.compile(r"[A-Za-z0-9_.+*/=-]{1,100}")
_ELEMENT = re.compile(r"[A-Z][a-z]?")


@dataclass(frozen=True)
class PairStyle(BondlessPotential):
    """Elements in any ``pair_style`` without charges, in LAMMPS' units ``metal``: eV and Å.

    Parameters
    ----------
    style : name, as LAMMPS has it.
    element : chemical symbol.
    mass : of an atom, in u.
    cutoff : of the formulas, in Å.
    lattice_constant : of the fcc crystal, to a tenth, in Å: it is measured from there.
    arguments : words that follow the name.
    coefficients : words of each ``pair_coeff``, "*" "*" among them.  Here and in the arguments, a word that is the name
        of one of the files, or a path that ends with it, stands for that file.
    contents : files by name.
    others : symbols, and masses in u, of further elements of an alloy.
    many_body : whether atoms feel changes at their neighbours, so that forces reach twice the cut-off.

    Raises
    ------
    ArgumentError
        If a name, a word or a style is refused, or a number is out of range.
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
    others: tuple[tuple[str, float], ...] = ()

    units: Literal["metal"] = field(default="metal", init=False)

    def __post_init__(self) -> None:
        style = self.style
        if not isinstance(style, str) or not _STYLE.fullmatch(style) or REFUSED_STYLES.fullmatch(style):
            allowed = (
                "the name of a pair_style that reads no code and no other paths, and that makes a crystal by itself"
            )
            raise ArgumentError("style", style, f"{allowed}; hybrid/overlay adds several")
        check_others(self.others)
        for element in self.elements:
            if not isinstance(element, str) or not _ELEMENT.fullmatch(element):
                raise ArgumentError("element", element, 'a chemical symbol, as "Cu"')
        number("cutoff", self.cutoff, above=0, below=1000)
        number("lattice_constant", self.lattice_constant)
        possible.given("lattice_constant", self.lattice_constant, "spacing", "A")
        check_masses(self)
        flag("many_body", self.many_body)
        contents = self.contents
        sound = isinstance(contents, Mapping) and all(
            isinstance(name, str) and isinstance(content, bytes) for name, content in contents.items()
        )
        if not sound:
            raise ArgumentError("contents", contents, "files by name, as PairStyle.read_files gives them")
        combined = style.startswith("hybrid")
        _check_words("arguments", self.arguments, self.contents, combined)
        if combined and (bad := [*filter(REFUSED_STYLES.fullmatch, self.arguments)]):
            raise ArgumentError("arguments", self.arguments, f"styles that are allowed by themselves: {bad[0]} is not")
        if any(map(_MLIAP.fullmatch, (style, *self.arguments))) and (bad := sorted(_PYTHON & {*self.arguments})):
            allowed = (
                f"linear, quadratic and nn as models of mliap: {bad[0]} is Python's, which runs code as it is read"
            )
            raise ArgumentError("arguments", self.arguments, allowed)
        if pickled := [name for name, content in contents.items() if _PICKLE.match(content)]:
            raise ArgumentError("contents", pickled[0], "files of numbers and text: a pickle runs code as it is read")
        lines = self.coefficients
        if not isinstance(lines, Sequence) or isinstance(lines, str | bytes) or not lines or not all(lines):
            raise ArgumentError("coefficients", lines, 'words of one pair_coeff or more, as (("*", "*"),)')
        for words in lines:
            _check_words("coefficients", words, self.contents, combined)
            _check_elements(words, self.elements)
        object.__setattr__(self, "arguments", tuple(self.arguments))
        object.__setattr__(self, "coefficients", tuple(map(tuple, lines)))

    @staticmethod
    def read_files(paths: Sequence[str | Path]) -> dict[str, bytes]:
        """Contents of files by their names.

        Raises
        ------
        ArgumentError
            If they are not names of files, or two files have the same name.
        PotentialError
            If one cannot be read or is too large.
        """
        if not isinstance(paths, Sequence) or isinstance(paths, str | bytes):
            raise ArgumentError("paths", paths, "a list of files")
        found: dict[str, bytes] = {}
        for given in paths:
            path = file_name("paths", given)
            content = content_of(path)
            if path.name in found:
                raise ArgumentError("paths", paths, f"files of different names, not two of the name {path.name}")
            found[path.name] = content
        return found

    @property
    def guess(self) -> float:
        """Volume per atom of the fcc crystal, roughly, in Å³."""
        return self.lattice_constant**3 / 4

    @property
    def force_range(self) -> float:
        """Largest distance at which a displaced atom changes forces, in Å."""
        return (2 if self.many_body else 1) * self.cutoff

    @cached_property
    def _names(self) -> dict[str, str]:
        return {name: f"potential.{i}" for i, name in enumerate(sorted(self.contents), 1)}

    @property
    def files(self) -> Mapping[str, bytes]:
        return {self._names[name]: content for name, content in self.contents.items()}

    @property
    def names(self) -> Mapping[str, str]:
        return {ours: "".join(filter(str.isprintable, name))[:80] for name, ours in self._names.items()}

    @cached_property
    def identity(self) -> dict[str, str | float]:
        """Identity of the potential: settings, and files by their content."""
        digests = {name: hashlib.sha256(content).hexdigest() for name, content in self.files.items()}
        return {
            "kind": "pair-style", "commands": self.interactions(), "element": self.element, "mass": self.mass,
            "cutoff": self.cutoff, "many_body": float(self.many_body), **digests, **dict(self.others),
        }  # fmt: skip

    @property
    def reference(self) -> str:
        files = ", ".join(
            f"{self.names[self._names[name]]} (sha256 {hashlib.sha256(content).hexdigest()[:12]})"
            for name, content in self.contents.items()
        )
        return f"{' '.join(self.elements)}, pair_style {self.style}{f', {files}' if files else ''}"

    def interactions(self) -> str:
        """LAMMPS commands that define the forces."""
        lines = [
            ("pair_style     ", self.style, *self.arguments),
            *(("pair_coeff     ", *w) for w in self.coefficients),
        ]
        return "\n".join(" ".join(self._names.get(_name(word), word) for word in words) for words in lines)


def _check_elements(words: Sequence[str], elements: tuple[str, ...]) -> None:
    """Check the elements at the end of a ``pair_coeff * *``, one for each type of atoms, of styles that map elements.

    LAMMPS would run another element under the name and the mass of the one that was asked for.
    """
    if tuple(words[:2]) == ("*", "*"):
        mapped = takewhile(lambda word: word == "NULL" or standard_mass(word), reversed(words[2:]))
        if last := [*mapped][::-1]:  # before those of the types, meam names those of its library
            possible.elements("coefficients", last[-len(elements) :], elements)


def _name(word: str) -> str:
    return word.rpartition("/")[2]


def _check_words(name: str, words: Any, files: Mapping[str, bytes], combined: bool) -> None:
    """Check a list of words; names of the model's files are allowed, and those of styles if several are combined."""
    if not isinstance(words, Sequence) or isinstance(words, str | bytes):
        raise ArgumentError(name, words, "a list of words")
    for word in words:
        if not isinstance(word, str):
            raise ArgumentError(name, word, 'words, in quotes, numbers, too: "2.5"')
        if _name(word) in files:
            continue
        if not _WORD.fullmatch(word):
            raise ArgumentError(name, word, "words of letters, digits and _ . + - * =")
        # A path would read a file that is not stored with the model.  LAMMPS is asked whether it has such a style.
        if "/" in word and not (combined and _STYLE.fullmatch(word)):
            raise ArgumentError(name, word, "not a path: list the file under files")
