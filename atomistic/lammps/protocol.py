"""What is done to a slab under a wall: the steps of a deck, each one equilibrium that starts from the one before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["LOAD_TOLERANCE", "MeanPressures", "Protocol", "Separations"]

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
        """Refuse what has no meaning."""
        _numbers(self, "separations")

    @property
    def steps(self) -> int:
        """Number of equilibria."""
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
        If a number has no meaning, or there is not one separation for each pressure.
    """

    pressures: tuple[float, ...]
    separations: tuple[float, ...]
    stiffness: float

    def __post_init__(self) -> None:
        """Refuse what has no meaning."""
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
        """Number of equilibria."""
        return len(self.pressures)


Protocol = Separations | MeanPressures
"""What a deck may follow instead of one equilibrium."""


def _numbers(protocol: Protocol, name: str) -> None:
    values = tuple(float(value) for value in getattr(protocol, name))
    if not values or not np.isfinite(values).all():
        msg = f"{name} of a protocol are finite numbers, at least one; got {values}"
        raise ValueError(msg)
    object.__setattr__(protocol, name, values)
