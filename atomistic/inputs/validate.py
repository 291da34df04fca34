"""The input file of a cross-validation, table by table.  Lengths are in a0, pressures in E*."""

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from atomistic.inputs.crystal import AtomsSolverTable, CrystalTable, Interatomic, SlabTable
from continuum.inputs.keys import Fraction, Positive
from continuum.inputs.tables import Fault, Table, constraint
from continuum.inputs.toml import Document
from continuum.model.surface import SelfAffineSpectrum
from continuum.model.walls.spline import AdhesionLength

_Slopes = Annotated[tuple[Annotated[float, Field(gt=0, le=1)], ...], Field(min_length=1)]

Compared = Literal["load", "gross_load", "displacement", "area_rep", "area_att"]
Step = Literal["depth", "anisotropy", "discreteness", "layers", "nonlinearity", "total"]


class SurfacesTable(SelfAffineSpectrum):
    """The rough walls: self-affine, rescaled to each slope of a case."""

    seeds: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(min_length=1)]
    """one surface for each"""


class BoundTable(Table):
    """A bound on the difference of two rungs: coefficient times rms_slope to a power."""

    newer: ClassVar[frozenset[str]] = frozenset({"step"})

    step: Step = "nonlinearity"
    """step of the ladder that is bounded: "nonlinearity" is lattice response against atoms, "layers" the law at the
    surface against its parts on every layer that it reaches, "total" half-space against atoms"""
    quantity: Compared
    """difference that is bounded: "load" relative to N_rep, "gross_load" relative to N_rep + N_att, "displacement"
    (largest, in a0), areas relative to A0"""
    coefficient: Positive
    """bound = coefficient x rms_slope^power, in the unit of the quantity"""
    power: Annotated[float, Field(ge=0, le=4)] = 0.0
    """exponent of rms_slope: 0 for a bound that does not depend on it"""
    areas: tuple[Fraction, ...] = ()
    """areas of the case, as fractions of A0, for which it holds; all if left out"""
    reason: Annotated[str, Field(min_length=10)]
    """reason for the bound"""


class ExponentTable(Table):
    """A scaling law: the difference of two rungs grows as rms_slope to a power."""

    quantity: Literal["load", "displacement"]
    """what differs"""
    expected: Positive
    """exponent that the theory gives"""
    tolerance: Positive
    """allowed deviation of the fitted exponent"""
    slopes: Annotated[tuple[Positive, ...], Field(min_length=2)]
    """slopes of the case that the fit uses"""
    reason: Annotated[str, Field(min_length=10)]
    """reason for the exponent"""


class CaseTable(Table):
    """One wall law, pressed at several slopes to several areas."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,40}$")]
    """letters, digits, - and _"""
    adhesion_length: AdhesionLength
    """l_a = w/E*, in a0; 0 is the purely repulsive wall"""
    lambda_s: Positive | None = None
    """shortest wavelength of this case, in a0; that of [surface] if left out"""
    lambda_L: Positive | None = None
    """roll-off wavelength of this case, in a0; that of [surface] if left out"""
    rms_slopes: _Slopes
    """h'_rms, the rms slope, of each run"""
    areas: Annotated[tuple[Fraction, ...], Field(min_length=1)]
    """repulsive area fractions at which the rungs are compared"""
    branches: Annotated[tuple[Literal["approach", "retract"], ...], Field(min_length=1)] = ("approach",)
    """branches of the loading path on which states are taken"""
    jump: bool = False
    """whether to include the states around the jump-in: before and after it, and the retraction past it"""
    tolerance: tuple[BoundTable, ...] = ()
    exponent: tuple[ExponentTable, ...] = ()

    @constraint
    def _bounds_speak_of_what_is_run(self) -> Iterator[Fault]:
        for i, tolerance in enumerate(self.tolerance):
            for area in set(tolerance.areas) - set(self.areas):
                allowed = f"areas of this case, {self.areas}"
                yield Fault(("tolerance", i, "areas"), allowed, f"{area} is not run")
        for i, exponent in enumerate(self.exponent):
            for slope in set(exponent.slopes) - set(self.rms_slopes):
                allowed = f"slopes of this case, {self.rms_slopes}"
                yield Fault(("exponent", i, "slopes"), allowed, f"{slope} is not run")


class ValidateConfig(Document):
    """Input of ``atomistic validate``."""

    result_schema: ClassVar[str] = "stickiness/validation"
    result_version: ClassVar[int] = 5

    interatomic: Interatomic
    """what holds the atoms together"""
    crystal: CrystalTable = CrystalTable()
    """fcc(100), which alone is compared with the continuum rung by rung"""
    slab: SlabTable
    surface: SurfacesTable
    case: Annotated[tuple[CaseTable, ...], Field(min_length=1)]
    solver: AtomsSolverTable = AtomsSolverTable()

    newer: ClassVar[frozenset[str]] = frozenset({"crystal"})

    @constraint
    def _is_of_one_crystal(self) -> Iterator[Fault]:
        if not self.crystal.own:
            yield Fault(
                ("crystal",), "fcc(100), of which each atom is a point of the grid; `atomistic deck` takes others"
            )

    @constraint
    def _fits(self) -> Iterator[Fault]:
        yield from self.surface.too_short(self.slab.points, self.slab.lengths)
        yield from self.surface.too_long(self.slab.points, self.slab.lengths)
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

    @constraint
    def _names_are_distinct(self) -> Iterator[Fault]:
        names = [case.name for case in self.case]
        for i, name in enumerate(names):
            if name in names[:i]:
                yield Fault(("case", i, "name"), "a name of its own", "a case copied and not renamed")
