"""Table [solver] of an input: when an equilibrium is one, and how to get there."""

from dataclasses import replace
from typing import Annotated, ClassVar

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from continuum.solve.backend import BACK_ENDS
from continuum.solve.solution import LOOSEST, Settings
from continuum.tables import Table

_Count = Annotated[int, Field(ge=1, le=10**9)]


def _device(value: str) -> str:
    if value not in BACK_ENDS:
        allowed = " or ".join(f'"{name}"' for name in BACK_ENDS)
        raise PydanticCustomError("device", "{allowed}", {"allowed": allowed})
    return value


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
