"""Tables common to inputs: [interatomic], what holds the atoms together, [slab], and tolerances."""

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, ValidationInfo
from pydantic_core import PydanticCustomError

from atomistic.crystal.faces import cell_of, read_atoms, rectangular, size_of_atoms
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.model import Potential
from atomistic.crystal.potentials import EmbeddedAtom, PairStyle, PotentialError, find_potential
from continuum.inputs import possible
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.keys import ForBoth, Fraction, InputFile, Positive
from continuum.inputs.tables import Fault, Table, constraint
from continuum.inputs.toml import Document
from continuum.store.runs.config import ToleranceTable

SHALLOWEST, DEEPEST = 2.0, 512.0
"""Depth of a slab, in a0."""


class Interatomic(Table):
    """[interatomic]: what holds the atoms together."""

    kind_key: ClassVar[str] = "kind"

    kind: str

    @property
    def crystal_name(self) -> str:
        """Name of the crystal in the ensemble of validations."""
        return self.kind

    def potential(self) -> Potential:
        """The interatomic model; reads the files that it needs."""
        raise NotImplementedError


class SpringsTable(Interatomic):
    """Springs between nearest neighbours, the model of the paper."""

    kind: Literal["springs"]
    """interatomic model"""

    def potential(self) -> Potential:
        return Springs()


class LennardJonesTable(Interatomic):
    """Lennard-Jones, truncated so that force and energy are continuous."""

    kind: Literal["lennard-jones"]
    """interatomic model"""
    cutoff: float = 2.5
    """in sigma"""
    truncation: Literal["smooth/linear", "smooth", "mdf"] = "smooth/linear"
    """truncation: LAMMPS' lj/smooth/linear, lj/smooth or lj/mdf"""
    inner: float | None = None
    """distance from which on "smooth" or "mdf" lowers it to zero, in sigma"""

    @constraint
    def _has_a_meaning(self) -> Iterator[Fault]:
        try:
            self.potential()
        except ArgumentError as error:
            cause = "a length in other units than sigma, or a key of another truncation"
            yield Fault((error.name,), f"{error.allowed}, in sigma", cause)

    def potential(self) -> Potential:
        return LennardJones(**self.keywords())


def _potential_file(value: object, info: ValidationInfo) -> Path:
    if isinstance(value, Path) and value.is_file():
        return value
    if not isinstance(value, str):
        raise PydanticCustomError("file_name", "the name of a potential file, in quotes")
    try:
        return find_potential(value, Path(str((info.context or {}).get("folder", "."))))
    except (PotentialError, ArgumentError) as error:
        raise PydanticCustomError("missing_potential", "{error}", {"error": str(error)}) from error


def _with_named(files: tuple[Path, ...], info: ValidationInfo) -> tuple[Path, ...]:
    """The files, and those whose names are words of the other keys."""
    keys = info.data or {}  # of files alone, as where a value is asked for by itself, no other key is known
    lines = [keys.get("arguments", ()), *keys.get("coefficients", ())]
    for word in dict.fromkeys(word for line in lines for word in line if word != keys.get("element")):
        try:
            found = _potential_file(word, info)
        except PydanticCustomError:  # most words are none
            continue
        if found.name not in [file.name for file in files]:
            files = (*files, found)
    return files


_Symbol = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9]{0,7}$")]


class EmbeddedAtomTable(Interatomic):
    """Embedded atoms, from a file of LAMMPS' pair_style eam, eam/alloy or eam/fs."""

    kind: Literal["eam"]
    """interatomic model"""
    file: Annotated[Path, BeforeValidator(_potential_file)]
    """file, relative to the folder of this input, or the bare name of a potential that comes with LAMMPS"""
    element: _Symbol | Annotated[tuple[_Symbol, ...], Field(min_length=1)] | None = None
    """chemical symbol, or several of an alloy in a list; may be left out if the file has only one"""

    @constraint
    def _holds_the_element(self) -> Iterator[Fault]:
        try:
            self.potential()
        except PotentialError as error:
            yield Fault(("element",) if "holds the elements" in str(error) else ("file",), str(error))

    @property
    def crystal_name(self) -> str:
        return self.file.name

    def potential(self) -> Potential:
        return EmbeddedAtom.read(self.file, self.element)


_Words = tuple[str, ...]


class PairStyleTable(Interatomic):
    """Any other pair_style of the installed LAMMPS, in units metal, given as words."""

    kind: Literal["pair-style"]
    """interatomic model"""
    style: str
    """name of the pair_style"""
    element: str | Annotated[tuple[str, ...], Field(min_length=1)]
    """chemical symbol, or several of an alloy in a list"""
    mass: Positive | Annotated[tuple[Positive, ...], Field(min_length=1)]
    """mass of an atom, in u; in a list with several elements"""
    cutoff: Positive
    """cut-off of the formulas, in Å"""
    lattice_constant: Positive
    """lattice constant of the fcc crystal to a tenth, in Å, from which the measurement starts; of other crystals that
    of an fcc crystal of the same density, to a third"""
    arguments: _Words = ()
    """arguments after the name of the style"""
    coefficients: Annotated[tuple[_Words, ...], Field(min_length=1)] = (("*", "*"),)
    """arguments of each pair_coeff, as [["*", "*", "AlCu.adp", "Cu"]]"""
    files: Annotated[
        tuple[Annotated[Path, BeforeValidator(_potential_file)], ...],
        Field(max_length=10, validate_default=True),
        AfterValidator(_with_named),
    ] = ()
    """further files that LAMMPS reads with these: all that arguments and coefficients name travel with the deck,
    relative to the folder of this input, or by the bare name of one that comes with LAMMPS"""
    many_body: bool = True
    """whether the force on an atom depends on the neighbours of its neighbours: forces then reach twice the cut-off"""

    @constraint
    def _has_a_meaning(self) -> Iterator[Fault]:
        if len(_listed(self.mass)) != len(_listed(self.element)):
            yield Fault(("mass",), "as many masses as elements")
            return
        try:
            self.potential()
        except ArgumentError as error:
            name = "files" if error.name in ("paths", "contents") else error.name
            yield Fault((name,), error.allowed)
        except PotentialError as error:
            yield Fault(("files",), str(error))

    def potential(self) -> Potential:
        keys = self.keywords()
        species = zip(_listed(keys.pop("element")), _listed(keys.pop("mass")), strict=True)
        (element, mass), *others = species
        files = PairStyle.read_files(keys.pop("files"))
        return PairStyle(contents=files, element=element, mass=mass, others=tuple(others), **keys)


def _listed(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


class CrystalTable(Table):
    """[crystal]: the atoms of a deck, if they are not fcc(100): a structure and a face, or a file."""

    lattice: Literal["fcc", "bcc", "diamond", "hcp", "L1_2", "B2", "zincblende"] = "fcc"
    """structure; of the last three, compounds of two elements, the first is that of the corners of the cube"""
    face: Annotated[str, Field(pattern=r"^([0-9]{3}|0001)$")] = "100"
    """Miller indices of the surface, as "111"; "0001" of hcp"""
    atoms: InputFile | None = None
    """instead of these, a slab from a file that ASE reads, in a rectangular or hexagonal period along x and y, in Å"""
    a0: str | None = None
    """a0 of the atoms of a file, as "2.49Å"; left out, the centre of the first peak of their distances"""
    modulus: Positive | str | None = None
    """E* of the atoms of a file, as "130GPa", the unit of pressures; or in the unit of the potential"""
    skin: Positive | None = None
    """depth below the highest atom to which atoms count as the surface and share its area, in a0; left out, the
    surface is what a probe of the size of an atom touches from above"""

    @property
    def own(self) -> bool:
        """True if it is fcc(100), each surface atom of which is a point of a grid."""
        return self.atoms is None and (self.lattice, self.face) == ("fcc", "100")

    @cached_property
    def given(self) -> Any:
        """The atoms of the file, in a rectangular period; None without."""
        return None if self.atoms is None else rectangular(read_atoms(self.atoms))

    @property
    def spacing(self) -> float | None:
        """a0 of given atoms, in Å; None if it follows from their distances."""
        return None if self.a0 is None else possible.given("a0", self.a0, "spacing", "A")

    @constraint
    def faults(self) -> Iterator[Fault]:
        """Faults of the table."""
        if (self.atoms is None) != (self.modulus is None):
            yield Fault(("modulus",), "E* of the atoms of a file, and only of these; that of a crystal is measured")
        try:
            if isinstance(self.modulus, str):
                possible.from_text(self.modulus, "modulus")
        except ValueError as error:
            yield Fault(("modulus",), str(error))
        if self.a0 is not None and self.atoms is None:
            yield Fault(("a0",), "left out: only atoms of a file have an a0 that can be given")
        if self.atoms is None and self.own:  # `cell_of` would import ASE's builders into every program
            return
        crystal = (self.lattice, self.face)  # if one is faulty, no more is to be said
        try:
            if self.atoms is None:
                cell_of(*crystal)
            else:
                size_of_atoms(self.given, self.spacing)
        except ArgumentError as error:
            yield Fault((error.name,), error.allowed)
        except Exception as error:  # whatever a reader of ASE raises
            yield Fault(("atoms",), f"a file of atoms that ASE reads ({type(error).__name__}: {error})")

    def width(self, n: tuple[int, int]) -> tuple[float, float]:
        """Periods of a slab of about n a0, in whole cells of the crystal, in a0."""
        if self.own:
            return float(n[0]), float(n[1])
        if self.given is not None:
            return size_of_atoms(self.given, self.spacing)[1]
        periods = cell_of(self.lattice, self.face).periods
        x, y = (max(1, round(m / length)) * float(length) for m, length in zip(n, periods[:2], strict=True))
        return x, y


_Atoms = Annotated[int, Field(ge=8, le=512)]


class SlabTable(Table):
    """The atoms."""

    n: _Atoms
    """surface atoms along x and along y; the period is n a0"""
    depth: Annotated[float, Field(ge=SHALLOWEST, le=DEEPEST)]
    """from the surface plane to the frozen base, in a0, rounded to whole layers"""

    @property
    def points(self) -> tuple[int, int]:
        return self.n, self.n

    @property
    def lengths(self) -> tuple[float, float]:
        return float(self.n), float(self.n)


_Wide = Annotated[int, Field(ge=8, le=8192)]


class DeckSlabTable(Table):
    """The atoms of a deck."""

    n: Annotated[tuple[_Wide, _Wide], ForBoth] = (0, 0)
    """surface atoms along x and y, or one number for both; the period is n a0, of other crystals than fcc(100) the
    nearest whole number of their cells; left out with atoms of a file, which have their own"""
    depth: Annotated[float, Field(ge=SHALLOWEST, le=DEEPEST)]
    """from the surface plane to the frozen base, in a0, rounded to whole layers"""

    @property
    def points(self) -> tuple[int, int]:
        return self.n

    @property
    def lengths(self) -> tuple[float, float]:
        return float(self.n[0]), float(self.n[1])


class AtomsSolverTable(ToleranceTable):
    """[solver]: tolerances of equilibria."""

    tolerance: Fraction = 1e-9
    """largest rms residual of the continuum rungs, relative to rms_slope E*"""
    force_tolerance: Annotated[float, Field(gt=0, le=1e-8)] = 1e-8
    """largest force left on an atom, relative to rms_slope E* a0²"""


class DeckSolverTable(AtomsSolverTable):
    """[solver] of a deck: tolerances of equilibria and of a tabulated wall."""

    wall_tolerance: Annotated[float, Field(ge=1e-10, le=1e-2)] = 1e-5
    """of the tractions of a wall that is a table, relative to its largest tension, or to the traction where that is
    larger; other laws are formulas, and exact"""


class ElasticConfig(Document):
    """Input of ``atomistic elastic``: the interatomic model of any input; all other tables are ignored."""

    model_config = ConfigDict(extra="ignore")

    interatomic: Interatomic
    """interatomic model"""
    crystal: CrystalTable = CrystalTable()
    """the crystal, if it is not fcc(100)"""
