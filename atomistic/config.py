"""The input files of a cross-validation and of a deck, table by table.  Lengths are in a0, pressures in E*."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, ConfigDict, Field, ValidationInfo
from pydantic_core import PydanticCustomError

from atomistic.crystal.interatomic import LennardJones, Potential, Springs
from atomistic.crystal.potentials import EmbeddedAtom, PotentialError, find_potential
from continuum.files.tables import Document, Fault, Positive, Table, check
from continuum.runs.surfaces import SelfAffineSurface, SelfAffineTable, SineSurface, SurfaceTable
from continuum.runs.tables import ToleranceTable, Unit
from continuum.runs.walls import LARGEST_RANGE, SplineWall, WallTable

__all__ = [
    "AtomsSolverTable",
    "BoundTable",
    "CaseTable",
    "DeckConfig",
    "ElasticConfig",
    "EmbeddedAtomTable",
    "ExponentTable",
    "Interatomic",
    "LennardJonesTable",
    "SlabTable",
    "SpringsTable",
    "SurfacesTable",
    "ValidateConfig",
]

_Slopes = Annotated[tuple[Annotated[float, Field(gt=0, le=1)], ...], Field(min_length=1)]

Compared = Literal["load", "gross_load", "displacement", "area_rep", "area_att"]


class SpringsTable(Table):
    """Springs between nearest neighbours, the model of the paper."""

    kind: Literal["springs"]
    """interatomic model"""

    def potential(self) -> Potential:
        """Springs of the mean contact modulus 1."""
        return Springs()


class LennardJonesTable(Table):
    """Lennard-Jones, cut so that force and energy end continuously."""

    kind: Literal["lennard-jones"]
    """interatomic model"""
    cutoff: float = 2.5
    """in sigma"""
    truncation: Literal["smooth/linear", "smooth", "mdf"] = "smooth/linear"
    """how it ends: LAMMPS' lj/smooth/linear, lj/smooth or lj/mdf"""
    inner: float | None = None
    """where "smooth" or "mdf" begins to end it, in sigma"""

    @check
    def _has_a_meaning(self) -> Iterator[Fault]:
        try:
            self.potential()
        except ValueError as error:
            key = "inner" if "inner" in str(error) else "cutoff"
            yield Fault((key,), str(error), "a length in other units than sigma, or a key of another truncation")

    def potential(self) -> Potential:
        """As a potential."""
        return LennardJones(self.cutoff, self.truncation, self.inner)


def _potential_file(value: object, info: ValidationInfo) -> Path:
    if isinstance(value, Path) and value.is_file():
        return value
    if not isinstance(value, str):
        raise PydanticCustomError("file_name", "the name of a potential file, in quotes")
    try:
        return find_potential(value, Path(str((info.context or {}).get("folder", "."))))
    except PotentialError as error:
        raise PydanticCustomError("missing_potential", "{error}", {"error": str(error)}) from error


class EmbeddedAtomTable(Table):
    """Embedded atoms, from a file of LAMMPS' pair_style eam, eam/alloy or eam/fs."""

    kind: Literal["eam"]
    """interatomic model"""
    file: Annotated[Path, BeforeValidator(_potential_file)]
    """relative to the folder of this input, or the bare name of a potential that comes with LAMMPS"""
    element: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9]{0,7}$")] | None = None
    """chemical symbol; may be left out where the file holds one only"""

    @check
    def _holds_the_element(self) -> Iterator[Fault]:
        try:
            self.potential()
        except PotentialError as error:
            yield Fault(("element",) if "holds the elements" in str(error) else ("file",), str(error))

    def potential(self) -> Potential:
        """As a potential; reads the file."""
        return EmbeddedAtom.read(self.file, self.element)


Interatomic = Annotated[SpringsTable | LennardJonesTable | EmbeddedAtomTable, Field(discriminator="kind")]


class ElasticConfig(Document):
    """Input of ``atomistic elastic``: the interatomic model of any input; all other tables are passed over."""

    model_config = ConfigDict(extra="ignore")

    result_schema: ClassVar[str] = "stickiness/elastic"
    result_version: ClassVar[int] = 1

    interatomic: Interatomic
    """interatomic model"""


class SlabTable(Table):
    """The atoms."""

    n: Annotated[int, Field(ge=8, le=512)]
    """surface atoms along x and along y; the period is n a0"""
    depth: Annotated[float, Field(ge=2, le=512)]
    """from the surface plane to the frozen base, in a0, rounded to whole layers"""


class SurfacesTable(SelfAffineTable):
    """The rough walls: self-affine, rescaled to each slope of a case."""

    seeds: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(min_length=1)]
    """one surface for each"""

    def with_wavelengths(self, lambda_s: float, lambda_L: float) -> SelfAffineTable:
        """The same spectrum between other wavelengths."""
        return self.model_copy(update={"lambda_s": lambda_s, "lambda_L": lambda_L})


class BoundTable(Table):
    """A bound on the difference of two rungs: coefficient times rms_slope to a power."""

    quantity: Compared
    """what differs between lattice response and atoms: "load" relative to N_rep, "gross_load" relative to
    N_rep + N_att, "displacement" (largest, in a0), areas relative to A0"""
    coefficient: Positive
    """bound = coefficient x rms_slope^power"""
    power: Annotated[float, Field(ge=0, le=4)] = 0.0
    """0 for a bound that does not depend on the slope"""
    areas: tuple[Unit, ...] = ()
    """areas of the case that it holds for; all if left out"""
    reason: Annotated[str, Field(min_length=10)]
    """why the bound is what it is, in words"""


class ExponentTable(Table):
    """A scaling law: the difference of two rungs grows as rms_slope to a power."""

    quantity: Literal["load", "displacement"]
    """what differs"""
    expected: Positive
    """exponent that the theory gives"""
    tolerance: Positive
    """by how much the fitted exponent may differ"""
    slopes: Annotated[tuple[Positive, ...], Field(min_length=2)]
    """slopes of the case that the fit uses"""
    reason: Annotated[str, Field(min_length=10)]
    """why the exponent is what it is, in words"""


class CaseTable(Table):
    """One wall law, pressed at several slopes to several areas."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,40}$")]
    """letters, digits, - and _"""
    adhesion_length: Annotated[float, Field(ge=0)]
    """l_a = w/E*, in a0; 0 is the purely repulsive wall"""
    lambda_s: Positive | None = None
    """shortest wavelength of this case, in a0; that of [surface] if left out"""
    lambda_L: Positive | None = None
    """roll-off wavelength of this case, in a0; that of [surface] if left out"""
    rms_slopes: _Slopes
    """h'_rms of each run"""
    areas: Annotated[tuple[Unit, ...], Field(min_length=1)]
    """repulsive area fractions at which the rungs are compared"""
    branches: Annotated[tuple[Literal["approach", "retract"], ...], Field(min_length=1)] = ("approach",)
    """branches of the loading path on which states are taken"""
    jump: bool = False
    """whether to take the states beside the jump-in, too: before and after it, and the retraction past it"""
    tolerance: tuple[BoundTable, ...] = ()
    exponent: tuple[ExponentTable, ...] = ()

    @check
    def _the_range_is_atomic(self) -> Iterator[Fault]:
        largest = LARGEST_RANGE**2 / 24
        if self.adhesion_length > largest:
            yield Fault(
                ("adhesion_length",),
                f"at most {largest:g}: beyond a range of sqrt(24 l_a) = {LARGEST_RANGE:g} a0 "
                "the tension exceeds the strength of crystals",
                "an adhesion length in other units than a0",
            )

    @check
    def _bounds_speak_of_what_is_run(self) -> Iterator[Fault]:
        for i, tolerance in enumerate(self.tolerance):
            for area in set(tolerance.areas) - set(self.areas):
                allowed = f"areas of this case, {self.areas}"
                yield Fault(("tolerance", i, "areas"), allowed, f"{area} is not run")
        for i, exponent in enumerate(self.exponent):
            for slope in set(exponent.slopes) - set(self.rms_slopes):
                allowed = f"slopes of this case, {self.rms_slopes}"
                yield Fault(("exponent", i, "slopes"), allowed, f"{slope} is not run")


class AtomsSolverTable(ToleranceTable):
    """When an equilibrium is one."""

    tolerance: Unit = 1e-9
    """largest rms residual of the continuum rungs, relative to rms_slope E*"""
    force_tolerance: Annotated[float, Field(gt=0, le=1e-8)] = 1e-8
    """largest force left on an atom, relative to rms_slope E* a0²"""


class ValidateConfig(Document):
    """Input of ``atomistic validate``."""

    result_schema: ClassVar[str] = "stickiness/validation"
    result_version: ClassVar[int] = 4

    interatomic: Interatomic
    """what holds the atoms together"""
    slab: SlabTable
    surface: SurfacesTable
    case: Annotated[tuple[CaseTable, ...], Field(min_length=1)]
    solver: AtomsSolverTable = AtomsSolverTable()

    @check
    def _fits(self) -> Iterator[Fault]:
        yield from _misfits(self.slab, self.surface)
        for i, case in enumerate(self.case):
            shortest, longest = self.wavelengths(case)
            if case.lambda_L is not None and not shortest <= longest <= self.slab.n:
                yield Fault(
                    ("case", i, "lambda_L"), f"from lambda_s = {shortest} to the period, slab.n = {self.slab.n}"
                )
            elif case.lambda_s is not None and not 2 <= shortest <= longest:
                yield Fault(("case", i, "lambda_s"), f"from 2, two spacings of atoms, to lambda_L = {longest}")

    def wavelengths(self, case: CaseTable) -> tuple[float, float]:
        """λ_s and λ_L of a case, in a0."""
        return case.lambda_s or self.surface.lambda_s, case.lambda_L or self.surface.lambda_L

    @check
    def _names_are_distinct(self) -> Iterator[Fault]:
        names = [case.name for case in self.case]
        for i, name in enumerate(names):
            if name in names[:i]:
                yield Fault(("case", i, "name"), "a name of its own", "a case copied and not renamed")


class DeckConfig(Document):
    """Input of ``atomistic deck``."""

    result_schema: ClassVar[str] = "stickiness/deck"
    result_version: ClassVar[int] = 2

    interatomic: Interatomic
    """what holds the atoms together"""
    slab: SlabTable
    surface: SurfaceTable
    """heights of the rigid wall above each surface atom"""
    wall: WallTable
    """law between wall and surface"""
    separation: float
    """height of the wall's mean plane above the undeformed surface, in a0"""
    solver: AtomsSolverTable = AtomsSolverTable()

    @check
    def _fits(self) -> Iterator[Fault]:
        if isinstance(self.surface, SelfAffineTable):
            yield from _misfits(self.slab, self.surface)
        if isinstance(self.surface, SineSurface) and max(self.surface.waves) > self.slab.n // 2:
            yield Fault(("surface", "waves"), f"at most half the surface atoms of a side, {self.slab.n // 2}")

    @check
    def _native(self) -> Iterator[Fault]:
        if not isinstance(self.wall, SplineWall):
            yield Fault(("wall", "law"), '"lennard-jones-spline", the law that a deck has formulas for')


def _misfits(slab: SlabTable, surface: SelfAffineTable) -> Iterator[Fault]:
    """Wavelengths that the surface atoms cannot show or the period cannot hold."""
    if surface.lambda_s < 2:
        yield Fault(("surface", "lambda_s"), "at least 2, two spacings of atoms", "a length in other units")
    if surface.lambda_L > slab.n:
        yield Fault(("surface", "lambda_L"), f"at most the period, slab.n = {slab.n}")
    if surface.lambda_L < surface.lambda_s and not isinstance(surface, SelfAffineSurface):  # which looks by itself
        yield Fault(("surface", "lambda_L"), f"at least surface.lambda_s = {surface.lambda_s}")
