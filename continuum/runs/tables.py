"""Tables of an input that build what they describe: grid, substrate, solver; and types that all tables share.

Lengths are in a0, pressures in E* (see :mod:`continuum`).  The base classes and the loader are those of
:mod:`continuum.files.tables`; ``atomistic`` has the same tables where it describes the same things.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field
from pydantic_core import PydanticCustomError

from continuum.files.tables import Positive, Table, constraint
from continuum.files.toml import Fault
from continuum.model.cubic import CubicConstants, contact_modulus
from continuum.model.grid import LARGEST_N, Grid
from continuum.model.substrates import OTHER_MEAN, CubicLayer, HalfSpace, Layer, Substrate
from continuum.solve.backend import BACK_ENDS
from continuum.solve.solution import LOOSEST, Settings


def both_directions(kind: type[int] | type[float], low: float, high: float, allowed: str) -> BeforeValidator:
    """Validator: one number, meant for both directions, or two, along x and y."""

    def both(value: Any) -> Any:
        values = value if isinstance(value, (tuple, list)) else (value, value)
        kinds = (int,) if kind is int else (int, float)
        sound = len(values) == 2 and all(type(v) in kinds and low <= v <= high for v in values)
        if not sound:
            raise PydanticCustomError("pair", "{allowed}", {"allowed": allowed})
        return tuple(kind(v) for v in values)

    return BeforeValidator(both)


def _mean_mode(value: Any) -> Any:
    if value in ("clamped", "free"):
        return value
    if type(value) in (int, float) and 0 <= value < float("inf"):
        return float(value)
    raise PydanticCustomError("mean_mode", '"clamped", "free", or a number >= 0')


def _device(value: str) -> str:
    if value not in BACK_ENDS:
        allowed = " or ".join(f'"{name}"' for name in BACK_ENDS)
        raise PydanticCustomError("device", "{allowed}", {"allowed": allowed})
    return value


MeanMode = Annotated[float | Literal["clamped", "free"], BeforeValidator(_mean_mode)]
Fraction = Annotated[float, Field(gt=0, lt=1)]
"""Between 0 and 1."""
_Count = Annotated[int, Field(ge=1, le=10**9)]


class GridTable(Table):
    """[grid]: the points of the surface, one or k x k for each surface atom."""

    n: Annotated[
        tuple[int, int],
        both_directions(int, 2, LARGEST_N, f"a whole number from 2 to {LARGEST_N}, or two of them [nx, ny]"),
    ]
    """points along x and y"""
    period: Annotated[
        tuple[float, float] | None,
        both_directions(float, 1, LARGEST_N, f"a whole number of a0 from 1 to {LARGEST_N}, or two [Lx, Ly]"),
    ] = None
    """period along x and y, in a0; n if not given"""

    @property
    def lengths(self) -> tuple[float, float]:
        """Periods, in a0."""
        return self.period or (float(self.n[0]), float(self.n[1]))

    @property
    def spacing(self) -> float:
        """The larger of the two spacings, in a0."""
        return max(length / n for length, n in zip(self.lengths, self.n, strict=True))

    @constraint
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

    def build(self) -> Grid:
        """The grid."""
        return Grid(self.n, self.lengths)


class HalfSpaceTable(Table):
    """[substrate] of response "half-space"."""

    response: Literal["half-space"]
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    def build(self) -> Substrate:
        """The response."""
        return HalfSpace(self.mean)


class LayerTable(Table):
    """[substrate] of response "layer", bonded to a rigid base."""

    response: Literal["layer"]
    depth: Positive
    """thickness, in a0"""
    poisson: Annotated[float, Field(gt=-1, le=0.5)]
    """Poisson's ratio"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    def build(self) -> Substrate:
        """The response."""
        return Layer(self.depth, self.poisson, self.mean)


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

    @constraint
    def _stable(self) -> Iterator[Fault]:
        if not (self.c11 > abs(self.c12) and self.c11 + 2 * self.c12 > 0):
            yield Fault(("c12",), "C11 > |C12| and C11 + 2 C12 > 0, or the crystal is not stable")
            return
        modulus = contact_modulus(CubicConstants(self.c11, self.c12, self.c44))
        if not 1 / OTHER_MEAN <= modulus <= OTHER_MEAN:
            cause = f"constants in another unit than E*: divide all three by {modulus:.6g}"
            yield Fault(("c11",), f"constants of a contact modulus of about 1, not {modulus:.6g}", cause)

    def build(self) -> Substrate:
        """The response."""
        return CubicLayer(self.depth or np.inf, CubicConstants(self.c11, self.c12, self.c44), self.mean)


class ToleranceTable(Table):
    """When a point counts as solved."""

    tolerance: Annotated[float, Field(gt=0, le=LOOSEST)] = 1e-6
    """largest root-mean-square residual traction, relative to h'rms E*; 0.01 leaves errors of a few percent"""

    def build(self, scale: float) -> Settings:
        """Settings for tolerances relative to a traction, that of ``ContactProblem.traction_scale``."""
        return Settings(self.tolerance * scale)


class SolverTable(ToleranceTable):
    """[solver]: when a point counts as solved, how to get there, and on what."""

    not_identity: ClassVar[frozenset[str]] = frozenset({"threads"})

    max_iterations: _Count = 5000
    """after which a point counts as not converged"""
    shift: Annotated[float, Field(gt=0, le=100)] = 0.01
    """c0 of the preconditioner 1/(K + c0), in E*/a0; 0.001 - 0.03 are equally good"""
    threads: Annotated[int, Field(ge=1, le=1024)] = 1
    """threads of the solver; they do not change results"""
    stability: bool = False
    """whether to look for the lowest eigenvalue of the Hessian of each point under a law, a hundred pairs or two: a
    saddle then counts as not converged"""
    device: Annotated[str, AfterValidator(_device)] = "cpu"
    """what the solver runs on: "cpu", or "cuda" for an NVIDIA GPU, which is experimental: its results were checked in a
    simulator, its speed on no GPU yet; results of two devices agree but for rounding, and are kept apart"""

    def build(self, scale: float) -> Settings:
        """The same with the other settings."""
        names = ("max_iterations", "shift", "threads", "stability", "device")
        return replace(super().build(scale), **{name: getattr(self, name) for name in names})


SubstrateTable = Annotated[HalfSpaceTable | LayerTable | CrystalTable, Field(discriminator="response")]
"""[substrate]: elastic response."""
