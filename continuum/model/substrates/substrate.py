"""Interface of all substrates, the mean mode, and the family of their tables."""

from typing import Annotated, Any, ClassVar, Literal, Protocol

import numpy as np
from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from continuum.arguments import ArgumentError, number
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.tables import TableFamily

MeanMode = float | Literal["clamped", "free"]
"""Stiffness of the mean displacement: a number in E*/a0, "clamped" (infinite) or "free" (zero)."""
_NAMED = {"clamped": np.inf, "free": 0.0}


class Substrate(Protocol):
    """Interface of all substrates."""

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum of the grid, in E*/a0; infinite at q = 0 where the mean is clamped."""


def with_mean(stiffness_q: Real, mean: MeanMode) -> Real:
    """Set the stiffness of the mean mode; the three choices become a number here and nowhere else."""
    stiffness_q[0, 0] = _NAMED[mean] if isinstance(mean, str) else mean
    return stiffness_q


def check_mean(mean: object) -> None:
    """Check that a value is a :data:`MeanMode`."""
    if isinstance(mean, str) and mean in _NAMED:
        return
    try:
        number("mean", mean, least=0)
    except ArgumentError:
        raise ArgumentError("mean", mean, '"clamped", "free", or a number >= 0') from None


def _mean_mode(value: Any) -> Any:
    try:
        check_mean(value)
    except ArgumentError as error:
        raise PydanticCustomError("mean_mode", "{allowed}", {"allowed": error.allowed}) from None
    return value if isinstance(value, str) else float(value)


_MeanMode = Annotated[MeanMode, BeforeValidator(_mean_mode)]


class SubstrateTable(TableFamily):
    """[substrate]: elastic response."""

    kind_key: ClassVar[str] = "response"

    repeats: ClassVar[bool] = True
    """Whether the surface is periodic."""
    response: str

    def without(self, control: str) -> str:
        """Why a control cannot be used with this substrate; empty if it can."""
        return ""

    def build(self) -> Substrate:
        raise NotImplementedError


class PeriodicTable(SubstrateTable):
    """[substrate] of a periodic surface."""

    mean: _MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    def without(self, control: str) -> str:
        if control == "separation" and self.mean == "free":
            return "a substrate with a free mean displacement carries no load at a given separation"
        return ""
