"""What is done to a slab under a wall: the steps of a deck, each one equilibrium that starts from the one before."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Literal

import numpy as np

BLOCKS = 10
"""Blocks of a time window, from whose means its standard errors come."""
SAMPLED = 10
"""Time steps from one sample of the wall's numbers to the next."""

LOAD_TOLERANCE = 1e-6
"""Largest difference of a load from that of a given mean pressure, relative to it."""


@dataclass(frozen=True)
class Separations:
    """The wall at one separation after the other: a staircase, approach and retraction.

    Parameters
    ----------
    separations : of the wall's zero from the surface at rest, in a0, in the order in which they are visited.

    Raises
    ------
    ValueError
        If there is none, or one is no finite number.
    """

    separations: tuple[float, ...]

    def __post_init__(self) -> None:
        _numbers(self, "separations")

    @property
    def steps(self) -> int:
        return len(self.separations)


@dataclass(frozen=True)
class MeanPressures:
    """One mean pressure after the other, which LAMMPS meets by moving the wall.

    Parameters
    ----------
    pressures : load over A0, in E*, compression positive; not zero.
    separations : where each is looked for first, in a0.
    stiffness : of the slab as a whole, mean pressure per displacement of its surface, in E*/a0: the first move.

    Raises
    ------
    ValueError
        If a number is not allowed, or there is not one separation for each pressure.
    """

    pressures: tuple[float, ...]
    separations: tuple[float, ...]
    stiffness: float

    def __post_init__(self) -> None:
        _numbers(self, "pressures")
        _numbers(self, "separations")
        if len(self.pressures) != len(self.separations):
            msg = f"{len(self.pressures)} pressures cannot be looked for from {len(self.separations)} separations"
            raise ValueError(msg)
        if 0 in self.pressures:
            msg = "a mean pressure is met to a fraction of itself: it cannot be zero"
            raise ValueError(msg)
        if not (np.isfinite(self.stiffness) and self.stiffness > 0):
            msg = f"the stiffness of a slab is a positive finite number, got {self.stiffness}"
            raise ValueError(msg)

    @property
    def steps(self) -> int:
        return len(self.pressures)


@dataclass(frozen=True)
class Motion:
    """The wall moves at constant velocity above warm atoms, whose load and areas are averaged over time windows.

    Times are in a0 (m/(E* a0³))^(1/2).

    Parameters
    ----------
    separations : at the beginning of the first window and at the end of each, in a0.
    offsets : of the wall along ``along``, likewise.
    durations : of each window.
    temperature : k_B T, in E* a0³.
    layers : above the frozen base, that a Langevin thermostat holds.
    damping : its time constant.
    seed : of the first velocities and of the thermostat.
    timestep : at most.
    along : direction of the offsets.

    Raises
    ------
    ValueError
        If a number is not allowed, or there is not one more separation and offset than windows.
    """

    separations: tuple[float, ...]
    offsets: tuple[float, ...]
    durations: tuple[float, ...]
    temperature: float
    layers: int
    damping: float
    seed: int
    timestep: float
    along: Literal["x", "y"] = "x"

    def __post_init__(self) -> None:
        for name in ("separations", "offsets", "durations"):
            _numbers(self, name)
        if not len(self.separations) == len(self.offsets) == len(self.durations) + 1:
            msg = (
                f"{len(self.durations)} windows have one separation and one offset more, got {len(self.separations)} "
                f"and {len(self.offsets)}"
            )
            raise ValueError(msg)
        for name in ("temperature", "damping", "timestep"):
            value = getattr(self, name)
            if not (np.isfinite(value) and (value > 0 or (value == 0 and name == "temperature"))):
                msg = f"the {name} of a motion is a positive finite number, got {value}"
                raise ValueError(msg)
        if min(self.durations) <= 0 or self.layers < 1 or not 1 <= self.seed <= 1_000_000:
            msg = "a motion has windows of positive duration, at least one warm layer, and a seed of 1 to 1000000"
            raise ValueError(msg)

    @property
    def steps(self) -> int:
        """Number of time windows."""
        return len(self.durations)

    @property
    def slides(self) -> bool:
        """Whether the wall moves sideways."""
        return any(self.offsets)

    @property
    def block(self) -> tuple[int, ...]:
        """Time steps of a block of each window: its samples are whole, its time step at most that allowed."""
        return tuple(SAMPLED * max(1, ceil(time / (self.timestep * BLOCKS * SAMPLED))) for time in self.durations)

    @property
    def timesteps(self) -> tuple[float, ...]:
        """Time step in each window."""
        return tuple(time / (BLOCKS * block) for time, block in zip(self.durations, self.block, strict=True))


Protocol = Separations | MeanPressures | Motion
"""What a deck may follow instead of one equilibrium."""


def _numbers(protocol: Protocol, name: str) -> None:
    values = tuple(float(value) for value in getattr(protocol, name))
    if not values or not np.isfinite(values).all():
        msg = f"{name} of a protocol are finite numbers, at least one; got {values}"
        raise ValueError(msg)
    object.__setattr__(protocol, name, values)
