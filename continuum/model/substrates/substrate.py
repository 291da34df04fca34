"""Interface of all substrates, the mean mode, and the family of those that an input knows."""

import sys
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Protocol

import numpy as np
from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from continuum.inputs.tables import Description
from continuum.model.fourier import Real
from continuum.model.grid import Grid

_NAMED = {"clamped": np.inf, "free": 0.0}


class Substrate(Protocol):
    """Interface of all substrates."""

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum of the grid, in E*/a0; infinite at q = 0 where the mean is clamped."""


def with_mean(grid: Grid, stiffness_q: Real, mean: float | str) -> Real:
    """Set the stiffness of the mean mode; the three choices become a number here and nowhere else."""
    grid.mean_mode(stiffness_q)[...] = _NAMED[mean] if isinstance(mean, str) else mean
    return stiffness_q


def _mean_mode(value: Any) -> Any:
    named = isinstance(value, str) and value in _NAMED
    if not named and not (type(value) in (int, float) and 0 <= value <= sys.float_info.max):
        raise PydanticCustomError("mean_mode", '"clamped", "free", or a number >= 0')
    return value if named else float(value)


MeanMode = Annotated[float | Literal["clamped", "free"], BeforeValidator(_mean_mode)]
"""Stiffness of the mean displacement: a number in E*/a0, "clamped" (infinite) or "free" (zero)."""


Poisson = Annotated[float, Field(gt=-1, le=0.5)]
"""Poisson's ratio."""


class Response(Description):
    """[substrate]: elastic response."""

    kind_key: ClassVar[str] = "response"
    repeats: ClassVar[bool] = True
    """True if the surface is periodic."""

    def without(self, control: str) -> str:
        """Reason why a control cannot be used with this substrate; empty if it can."""
        return ""

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum of the grid, in E*/a0; infinite at q = 0 where the mean is clamped."""
        raise NotImplementedError

    def build(self) -> Substrate:
        """The substrate that presses: this one, unless a kind describes another."""
        return self


class PeriodicResponse(Response):
    """[substrate] of a periodic surface, which has the field ``mean``, a :data:`MeanMode`."""

    if TYPE_CHECKING:  # a field at its place among those of each kind

        @property
        def mean(self) -> MeanMode: ...

    def without(self, control: str) -> str:
        if control == "separation" and self.mean == "free":
            return "a substrate with a free mean displacement carries no load at a given separation"
        return ""
