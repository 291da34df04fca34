"""What is done to a slab under a wall: the steps of a deck, each one equilibrium that starts from the one before."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from atomistic.crystal.interatomic import Model
from atomistic.lammps.language import formatted, listing

LOAD_TOLERANCE = 1e-6
"""Largest difference of a load from that of a given mean pressure, relative to it."""


class Protocol:
    """What a deck follows instead of one equilibrium: its steps, and the script that leads through them."""

    script: ClassVar[str]
    """Its template is ``templates/contact.SCRIPT``."""
    included: ClassVar[str] = "in.relax"
    """Script that each step includes."""
    separations: tuple[float, ...]
    """Separation of the wall's zero from the surface at rest, in a0: where each step begins."""

    @property
    def steps(self) -> int:
        return len(self.separations)

    def each_step(self) -> Sequence[tuple[object, ...]]:
        """The numbers of each step by which it differs from another one of the same protocol."""
        return [(separation,) for separation in self.separations]

    def from_separation(self, separation: float) -> Self:
        """The same from another separation, where it finds its own; as it is where they are given."""
        return self

    def about(self) -> Mapping[str, float]:
        """What ``deck.json`` says of it beside the number of steps."""
        return {}

    def placeholders(self, model: Model, mobile: int, surface_atoms: int) -> dict[str, str]:
        """What its scripts hold beside the numbers of all decks, for so many mobile layers of so many atoms."""
        return {}

    def misfit(self, mobile: int, *, stays: bool) -> tuple[str, object, str] | None:
        """What of it a slab of so many mobile layers cannot do, or a wall that ``stays`` with the atoms.

        Name and value of the argument, and what is allowed; None if it fits.
        """
        return None


@dataclass(frozen=True)
class Separations(Protocol):
    """The wall at one separation after the other: a staircase, approach and retraction.

    Parameters
    ----------
    separations : of the wall's zero from the surface at rest, in a0, in the order in which they are visited.

    Raises ValueError if there is none, or one is no finite number.
    """

    script = "separations"
    separations: tuple[float, ...]

    def __post_init__(self) -> None:
        finite_numbers(self, "separations")


@dataclass(frozen=True)
class MeanPressures(Protocol):
    """One mean pressure after the other, which LAMMPS meets by moving the wall.

    Parameters
    ----------
    pressures : load over A0, in E*, compression positive; not zero.
    separations : where each is looked for first, in a0.
    stiffness : of the slab as a whole, mean pressure per displacement of its surface, in E*/a0: the first move.

    Raises ValueError if a number is not allowed, or there is not one separation for each pressure.
    """

    script = "pressures"
    pressures: tuple[float, ...]
    separations: tuple[float, ...]
    stiffness: float

    def __post_init__(self) -> None:
        finite_numbers(self, "pressures")
        finite_numbers(self, "separations")
        if len(self.pressures) != len(self.separations):
            msg = f"{len(self.pressures)} pressures cannot be looked for from {len(self.separations)} separations"
            raise ValueError(msg)
        if 0 in self.pressures:
            raise ValueError("a mean pressure is met to a fraction of itself: it cannot be zero")
        if not (np.isfinite(self.stiffness) and self.stiffness > 0):
            raise ValueError(f"the stiffness of a slab is a positive finite number, got {self.stiffness}")

    def from_separation(self, separation: float) -> Self:
        return replace(self, separations=(separation,) * self.steps)

    def each_step(self) -> Sequence[tuple[object, ...]]:
        return [(*numbers, self.stiffness) for numbers in zip(self.pressures, self.separations, strict=True)]

    def placeholders(self, model: Model, mobile: int, surface_atoms: int) -> dict[str, str]:
        return {
            "pressures": listing(self.pressures),
            "load_tolerance": f"{LOAD_TOLERANCE:g}",
            "stiffness": formatted(self.stiffness * surface_atoms),
            "largest_move": "0.2",
        }


def finite_numbers(protocol: Protocol, name: str) -> None:
    """Require finite numbers of this name, at least one, and make them a tuple."""
    values = tuple(float(value) for value in getattr(protocol, name))
    if not values or not np.isfinite(values).all():
        raise ValueError(f"{name} of a protocol are finite numbers, at least one; got {values}")
    object.__setattr__(protocol, name, values)
