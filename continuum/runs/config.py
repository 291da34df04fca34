"""The input file of a continuum run, table by table.

Lengths are in a0, pressures in E* (see :mod:`continuum`).  The base classes and the loader, which
``atomistic`` shares, are those of :mod:`continuum.files.tables`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from continuum.files.arrays import HDF5_SUFFIXES
from continuum.files.tables import (
    Document,
    InputFile,
    Positive,
    Table,
    check,
    identity,
    load,
    refuse,
    resolved,
)
from continuum.files.toml import ConfigError, Fault, find
from continuum.runs.schedule import Control, LoadingTable, RetractionTable

__all__ = [
    "ConfigError",
    "Control",
    "CrystalTable",
    "Document",
    "ExponentialWall",
    "Fault",
    "FileSurface",
    "GridTable",
    "HalfSpaceTable",
    "InputFile",
    "InversePowersWall",
    "LayerTable",
    "LoadingTable",
    "MeanMode",
    "OutputTable",
    "Positive",
    "RetractionTable",
    "RigidWall",
    "RunConfig",
    "SelfAffineSurface",
    "SineSurface",
    "SolverTable",
    "SphereSurface",
    "SplineWall",
    "Table",
    "TableWall",
    "check",
    "find",
    "identity",
    "load",
    "refuse",
    "resolved",
]

_LARGEST_N = 65536
_LARGEST_RANGE = 3.0
_ROUNDING = 1e-12  # a value written in decimal may miss its bound by this fraction


def _pair(kind: type[int] | type[float], low: float, high: float, allowed: str) -> Callable[[Any], Any]:
    """Validator: one number, meant for both directions, or two, along x and y."""

    def pair(value: Any) -> Any:
        values = value if isinstance(value, (tuple, list)) else (value, value)
        kinds = (int,) if kind is int else (int, float)
        sound = len(values) == 2 and all(type(v) in kinds and low <= v <= high for v in values)
        if not sound:
            raise PydanticCustomError("pair", "{allowed}", {"allowed": allowed})
        return tuple(kind(v) for v in values)

    return BeforeValidator(pair)  # type: ignore[return-value]


def _mean_mode(value: Any) -> Any:
    if value in ("clamped", "free"):
        return value
    if type(value) in (int, float) and 0 <= value < float("inf"):
        return float(value)
    raise PydanticCustomError("mean_mode", '"clamped", "free", or a number >= 0')


MeanMode = Annotated[float | Literal["clamped", "free"], BeforeValidator(_mean_mode)]
_Unit = Annotated[float, Field(gt=0, lt=1)]
_Count = Annotated[int, Field(ge=1, le=10**9)]


class GridTable(Table):
    """[grid]: the points of the surface, one or k x k for each surface atom."""

    not_identity: ClassVar[frozenset[str]] = frozenset({"threads"})

    n: Annotated[
        tuple[int, int],
        _pair(int, 2, _LARGEST_N, f"a whole number from 2 to {_LARGEST_N}, or two of them [nx, ny]"),
    ]
    """points along x and y"""
    period: Annotated[
        tuple[float, float] | None,
        _pair(float, 1, _LARGEST_N, f"a whole number of a0 from 1 to {_LARGEST_N}, or two [Lx, Ly]"),
    ] = None
    """period along x and y, in a0; n if not given"""
    threads: Annotated[int, Field(ge=1, le=1024)] = 1
    """threads of a Fourier transform; they do not change results"""

    @property
    def lengths(self) -> tuple[float, float]:
        """Periods, in a0."""
        return self.period or (float(self.n[0]), float(self.n[1]))

    @property
    def spacing(self) -> float:
        """The larger of the two spacings, in a0."""
        return max(length / n for length, n in zip(self.lengths, self.n, strict=True))

    @check
    def _whole_atoms(self) -> Iterator[Fault]:
        if any(length != round(length) for length in self.lengths):
            cause = "the surface is a crystal: a period holds whole atoms"
            yield Fault(("period",), "a whole number of a0", cause)
        elif any(n % length for n, length in zip(self.n, self.lengths, strict=True)):
            cause = "n is meant to be the period, or k times the period for k x k points per atom"
            period = " and ".join(f"{length:g}" for length in dict.fromkeys(self.lengths))
            yield Fault(("n",), f"a multiple of the period, {period}: spacing a0, a0/2, ...", cause)

    def plain(self, *, identity: bool = False) -> dict[str, Any]:
        """Keys and values as JSON has them, with the period as it is used."""
        return {**super().plain(identity=identity), "period": list(self.lengths)}


class SelfAffineSurface(Table):
    """[surface] of kind "self-affine": the paper's random surface."""

    kind: Literal["self-affine"]
    hurst: _Unit
    """H, the Hurst exponent"""
    rms_slope: Positive
    """h'rms"""
    lambda_s: Positive
    """shortest wavelength, in a0"""
    lambda_L: Positive
    """roll-off wavelength, in a0"""
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    """seed of the random numbers"""
    rescale: bool = True
    """whether the realisation has exactly that rms slope, or scatters about it"""

    @check
    def _ordered(self) -> Iterator[Fault]:
        if self.lambda_s >= self.lambda_L:
            yield Fault(("lambda_s",), f"below lambda_L = {self.lambda_L:g}", "the two are exchanged")


class SineSurface(Table):
    """[surface] of kind "sine"."""

    kind: Literal["sine"]
    amplitude: Positive
    """half the height from valley to crest, in a0"""
    waves: Annotated[
        tuple[int, int],
        _pair(int, 0, _LARGEST_N, "two whole numbers [mx, my], zero or more"),
    ]
    """waves per period along x and y"""

    @check
    def _some_wave(self) -> Iterator[Fault]:
        if self.waves == (0, 0):
            yield Fault(("waves",), "at least one wave along x or y")


class SphereSurface(Table):
    """[surface] of kind "sphere"."""

    kind: Literal["sphere"]
    radius: Positive
    """radius of the sphere, in a0"""


class FileSurface(Table):
    """[surface] of kind "file": heights of your own."""

    kind: Literal["file"]
    path: InputFile
    """heights in a0, one number per point of the grid: .npy, .h5/.hdf5, or text with one row per x"""
    dataset: str | None = None
    """name of the dataset in an HDF5 file"""

    @check
    def _dataset(self) -> Iterator[Fault]:
        hdf5 = self.path.suffix.lower() in HDF5_SUFFIXES
        if hdf5 and self.dataset is None:
            yield Fault(("dataset",), "the name of a dataset, which an HDF5 file needs")
        if not hdf5 and self.dataset is not None:
            yield Fault(("dataset",), f"only with an HDF5 file ({', '.join(sorted(HDF5_SUFFIXES))})")


class SplineWall(Table):
    """[wall] of law "lennard-jones-spline", the paper's, Eq. (potential)."""

    law: Literal["lennard-jones-spline"]
    adhesion_length: Annotated[float, Field(ge=0)] | None = None
    """l_a = w/E*, in a0 (the paper's: 0.0005, 0.005, 0.05); instead of range"""
    range: Annotated[float, Field(ge=0)] | None = None
    """distance over which the wall attracts, in a0; 0 for no adhesion; instead of adhesion_length"""
    core: _Unit = 0.7
    """gap below which the law is only continued, in a0"""

    @check
    def _one_strength(self) -> Iterator[Fault]:
        if (self.adhesion_length is None) == (self.range is None):
            cause = "both are given" if self.range is not None else "neither is given; range = 0 is no adhesion"
            yield Fault(("adhesion_length",), "exactly one of adhesion_length and range", cause)

    @check
    def _within_elasticity(self) -> Iterator[Fault]:
        # Largest tension (2/27) E* r/a0: at 3 a0 it is 0.22 E*, the ideal strength of a crystal, far beyond
        # where linear elasticity says anything.
        cause = "given in other units than a0, or range and adhesion_length exchanged"
        if self.range is not None and self.range > _LARGEST_RANGE:
            limit = f"at most {_LARGEST_RANGE:g} a0: beyond, the tension exceeds 0.2 E*, the strength of crystals"
            yield Fault(("range",), limit, cause)
        largest = _LARGEST_RANGE**2 / 24
        if self.adhesion_length is not None and self.adhesion_length > largest:
            limit = f"at most {largest:g} a0, a range of {_LARGEST_RANGE:g} a0: see range"
            yield Fault(("adhesion_length",), limit, cause)


class TableWall(Table):
    """[wall] of law "table"."""

    law: Literal["table"]
    path: InputFile
    """text, two columns: gap in a0 (increasing) and traction in E* (compression positive, zero at the end)"""


class InversePowersWall(Table):
    """[wall] of law "lennard-jones-9-3" or "lennard-jones-12-6", not truncated."""

    law: Literal["lennard-jones-9-3", "lennard-jones-12-6"]
    adhesion_length: Annotated[float, Field(gt=0, le=_LARGEST_RANGE**2 / 24)]
    """l_a = w/E*, in a0; the stiffness of the law follows from it"""
    core: _Unit = 0.7
    """gap below which the law is only continued, in a0"""


class ExponentialWall(Table):
    """[wall] of law "exponential": attraction on a stiff core."""

    law: Literal["exponential"]
    surface_energy: Positive
    """gamma, in E* a0"""
    decay_length: Positive
    """rho, in a0"""
    core_stiffness: Positive
    """K, in E*/a0"""


class RigidWall(Table):
    """[wall] of law "hard": non-overlap, no adhesion."""

    law: Literal["hard"]


class HalfSpaceTable(Table):
    """[substrate] of response "half-space"."""

    response: Literal["half-space"]
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""


class LayerTable(Table):
    """[substrate] of response "layer", bonded to a rigid base."""

    response: Literal["layer"]
    depth: Positive
    """thickness, in a0"""
    poisson: Annotated[float, Field(gt=-1, le=0.5)]
    """Poisson's ratio"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""


class CrystalTable(Table):
    """[substrate] of response "crystal": cubic, (100) surface, the grid's axes along <110>."""

    response: Literal["crystal"]
    c11: Positive
    """elastic constant, in E*"""
    c12: float
    """elastic constant, in E*"""
    c44: Positive
    """elastic constant, in E*"""
    depth: Positive | None = None
    """of a layer bonded to a rigid base, in a0; a half-space if not given"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    @check
    def _stable(self) -> Iterator[Fault]:
        if not (self.c11 > abs(self.c12) and self.c11 + 2 * self.c12 > 0):
            yield Fault(("c12",), "C11 > |C12| and C11 + 2 C12 > 0, or the crystal is not stable")


class SolverTable(Table):
    """[solver]: when a point counts as solved, and how to get there."""

    tolerance: _Unit = 1e-6
    """largest root-mean-square residual traction, relative to h'rms E*"""
    max_iterations: _Count = 5000
    """after which a point counts as not converged"""
    shift: Annotated[float, Field(gt=0, le=100)] = 0.01
    """c0 of the preconditioner 1/(K + c0), in E*/a0; 0.001 - 0.03 are equally good"""


class OutputTable(Table):
    """[output]: what is stored beside areas, loads and contact maps."""

    fields: bool = False
    """whether to store heights and gaps in full, in single precision"""


class RunConfig(Document):
    """The input of ``continuum run``."""

    result_schema: ClassVar[str] = "stickiness/continuum-run"
    result_version: ClassVar[int] = 2
    not_identity: ClassVar[frozenset[str]] = frozenset({"output"})

    grid: GridTable
    """points and period"""
    surface: Annotated[SelfAffineSurface | SineSurface | SphereSurface | FileSurface, Field(discriminator="kind")]
    """heights of the rigid wall"""
    wall: Annotated[
        SplineWall | InversePowersWall | ExponentialWall | TableWall | RigidWall, Field(discriminator="law")
    ]
    """law between wall and surface"""
    substrate: Annotated[HalfSpaceTable | LayerTable | CrystalTable, Field(discriminator="response")]
    """elastic response"""
    loading: LoadingTable
    """path of loading"""
    solver: SolverTable = SolverTable()
    """tolerance and iterations"""
    output: OutputTable = OutputTable()
    """what is stored"""

    @check
    def _resolved(self) -> Iterator[Fault]:
        surface, spacing = self.surface, self.grid.spacing
        if isinstance(surface, SelfAffineSurface) and surface.lambda_s < 2 * spacing * (1 - _ROUNDING):
            cause = "too coarse a grid: raise grid.n at the same period, or lambda_s"
            yield Fault(("surface", "lambda_s"), f"at least two spacings, {2 * spacing:g} a0", cause)
        if isinstance(surface, SineSurface):
            limits = [n // 2 for n in self.grid.n]
            if any(waves > limit for waves, limit in zip(surface.waves, limits, strict=True)):
                cause = "the grid cannot show shorter waves: raise grid.n"
                yield Fault(("surface", "waves"), f"at most half the points, {limits}", cause)

    @check
    def _fits_the_period(self) -> Iterator[Fault]:
        period = min(self.grid.lengths)
        if isinstance(self.surface, SelfAffineSurface) and self.surface.lambda_L > period:
            cause = "too small a period: raise grid.period (or grid.n), or lower lambda_L"
            yield Fault(("surface", "lambda_L"), f"at most the period, {period:g} a0", cause)

    @check
    def _load_to_carry(self) -> Iterator[Fault]:
        cause = "a substrate whose mean is free carries no load at any separation"
        for key, part in ((("loading",), self.loading), (("loading", "retraction"), self.loading.retraction)):
            if part is not None and part.control == "separation" and self.substrate.mean == "free":
                yield Fault((*key, "control"), 'another control than "separation" where substrate.mean = "free"', cause)
