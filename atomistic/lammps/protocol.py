"""Protocols of decks: steps that are each an equilibrium started from the one before."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from atomistic.crystal.model import Model
from atomistic.lammps.language import formatted, listing

LOAD_TOLERANCE = 1e-6
"""Tolerance of the load at a given mean pressure, relative to it."""


class Protocol:
    """The steps of a deck instead of one equilibrium, and the script that runs them."""

    script: ClassVar[str]
    """Name of its template, ``templates/contact.SCRIPT``."""
    included: ClassVar[str] = "in.relax"
    """Script that each step includes."""
    separations: tuple[float, ...]
    """Height of the wall's zero above the surface at rest, in a0, at the start of each step."""

    @property
    def steps(self) -> int:
        return len(self.separations)

    def each_step(self) -> Sequence[tuple[object, ...]]:
        """The numbers in which the steps differ."""
        return [(separation,) for separation in self.separations]

    def from_separation(self, separation: float) -> Self:
        """The protocol with another start of its search for separations; unchanged if these are given."""
        return self

    def about(self) -> Mapping[str, float]:
        """Its entries in ``deck.json`` beside the number of steps."""
        return {}

    def placeholders(self, model: Model, mobile: int, surface_atoms: int) -> dict[str, str]:
        """Placeholders of its scripts, for a number of mobile layers and atoms in each."""
        return {}

    def misfit(self, mobile: int, *, stays: bool) -> tuple[str, object, str] | None:
        """Fault of the protocol for a slab of this many mobile layers, or a wall that ``stays`` with the atoms.

        Name and value of the argument, and what is allowed; None without fault.
        """
        return None


@dataclass(frozen=True)
class Separations(Protocol):
    """Several separations in order: a staircase of approach and retraction.

    Parameters
    ----------
    separations : heights of the wall's zero above the surface at rest, in a0, in order.

    Raises ValueError if there is none, or one is not a finite number.
    """

    script = "separations"
    separations: tuple[float, ...]

    def __post_init__(self) -> None:
        finite_numbers(self, "separations")


@dataclass(frozen=True)
class MeanPressures(Protocol):
    """Several mean pressures in order, which LAMMPS reaches by moving the wall.

    Parameters
    ----------
    pressures : load over A0, in E*, compression positive; not zero.
    separations : separation at the start of the search for each, in a0.
    stiffness : of the slab as a whole, mean pressure per displacement of its surface, in E*/a0: the first move.

    Raises ValueError if a number is not allowed, or the number of separations differs from that of pressures.
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
            raise ValueError("a mean pressure cannot be zero, as its tolerance is relative")
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
    """Check that there is at least one number and that all are finite, and return a tuple."""
    values = tuple(float(value) for value in getattr(protocol, name))
    if not values or not np.isfinite(values).all():
        raise ValueError(f"{name} of a protocol are finite numbers, at least one; got {values}")
    object.__setattr__(protocol, name, values)
