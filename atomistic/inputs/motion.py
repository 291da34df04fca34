"""Protocols with a wall that moves at constant velocity above atoms at a temperature: approach, retraction, sliding."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from atomistic.lammps.protocol import Motion
from continuum.inputs.keys import Positive
from continuum.inputs.tables import Fault, Table, constraint
from continuum.inputs.units import Units, parse

LARGEST = 10_000
"""Windows of a protocol."""
LARGEST_PRESSURE = 1.0
"""Largest mean pressure or tension, in E*, beyond which the crystal fails."""
SHORTEST, LONGEST = 1.0, 1e7
"""Duration of a window, in a0 (m/(E* a0³))^(1/2).  The shortest period of a lattice vibration is about 1: shorter
windows are not averages.  The longest, some 1e8 time steps, is half a microsecond of copper."""
HOTTEST = 0.015
"""k_B T, in E* a0³.  Fcc crystals melt at 0.006 (Lennard-Jones, aluminium) to 0.011 (platinum), and can be superheated
by at most a third."""
FASTEST = 0.3
"""Velocity of the wall, in (E* a0³/m)^(1/2).  The slowest shear waves of fcc crystals run at 0.29 (platinum) to 0.46
(aluminium): atoms cannot follow a faster wall."""


class Steps(NamedTuple):
    """The steps of a deck, from an input or a call."""

    control: Literal["separation", "mean-pressure"]
    values: tuple[float, ...]
    """Separation or pressure of each step, in a0 or E*."""
    single: bool = False
    """True if it is one equilibrium without a protocol."""
    motion: MotionTable | None = None
    """The wall that moves above warm atoms; the values are then its separations or pressures."""


class ProtocolTable(Table):
    """[protocol]: the steps of a deck."""

    kind_key: ClassVar[str] = "kind"
    slides: ClassVar[bool] = False
    """True if the wall slides, which needs follows = "atom"."""

    def steps(self) -> Steps:
        raise NotImplementedError


def beyond_strength(key: str, *pressures: float) -> Iterator[Fault]:
    """Faults of mean pressures beyond the strength of crystals, under a key of [protocol]."""
    if not max(map(abs, pressures)) <= LARGEST_PRESSURE:
        allowed = f"from -{LARGEST_PRESSURE:g} to {LARGEST_PRESSURE:g} E*, the strength of crystals"
        yield Fault((key,), allowed, "a pressure in other units: E* of copper is 135 GPa")


def thermal_energy(temperature: float | str, scale: Units | None) -> float:
    """k_B T in E* a0³ of a temperature in this unit, or in kelvin, for a crystal that has a length scale."""
    if isinstance(temperature, str):
        assert scale is not None
        return kelvin(temperature) / scale.si("temperature")
    return temperature


def kelvin(text: str) -> float:
    """A temperature like ``"300K"``, in kelvin.

    Raises ValueError if it is not a temperature.
    """
    value = parse(text, "temperature", signed=True)
    if value < 0:
        raise ValueError(f"{text!r} is not a temperature: it is below 0 K")
    return value


class MotionTable(ProtocolTable):
    """A wall that moves at constant velocity above atoms at a temperature."""

    temperature: float | str
    """k_B T in E* a0³, at most 0.015; or in kelvin, as "300K", for a crystal that has a size"""
    window: Annotated[float, Field(ge=SHORTEST, le=LONGEST)]
    """time over which load and areas are averaged, in a0 (m/(E* a0³))^(1/2)"""
    hold: Annotated[int, Field(ge=1, le=LARGEST)] = 1
    """first windows, in which the thermostat acts on all mobile layers, so that the slab comes to rest"""
    dwell: Annotated[int, Field(ge=0, le=LARGEST)] = 0
    """following windows in which the wall rests; they are averaged, and contacts age in them"""
    thermostat_layers: Annotated[int, Field(ge=1)] = 2
    """layers above the frozen base on which a Langevin thermostat acts once the slab is at rest"""
    damping: Annotated[float, Field(ge=0.1, le=1e4)] = 2.0
    """time constant of the thermostat, in the unit of window"""
    seed: Annotated[int, Field(ge=1, le=1_000_000)] = 1
    """seed of the initial velocities and of the thermostat"""

    @constraint
    def _warm(self) -> Iterator[Fault]:
        try:
            value = kelvin(self.temperature) if isinstance(self.temperature, str) else self.temperature
            if not (np.isfinite(value) and value >= 0):
                yield Fault(("temperature",), "k_B T, zero or more")
        except ValueError as error:
            yield Fault(("temperature",), str(error))

    if TYPE_CHECKING:
        velocity: float

    @property
    def reversals(self) -> list[tuple[float, float]]:
        """Separations and offsets between which the wall moves, in a0; where one comes twice it rests for a window."""
        raise NotImplementedError

    def steps(self) -> Steps:
        return Steps("separation", self.windows[0], motion=self)

    def motion(self, temperature: float, timestep: float, hold_damping: float) -> Motion:
        """The motion at k_B T in E* a0³, with a largest time step and a damping in the windows of hold."""
        return Motion(
            *self.windows, temperature, self.thermostat_layers, self.damping, self.seed, timestep,
            hold=self.hold, hold_damping=hold_damping,
        )  # fmt: skip

    @cached_property
    def windows(self) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
        """Legs from reversal to reversal, each in whole windows of about the duration wanted.

        Separations and offsets at the beginning of the first window and at the end of each, and durations.
        """
        reversals, rest = self.reversals, self.hold + self.dwell
        places, duration = [reversals[0]] * (rest + 1), [self.window] * rest
        for (d0, o0), (d1, o1) in pairwise(reversals):
            time = float(np.hypot(d1 - d0, o1 - o0)) / self.velocity or self.window  # a place twice: at rest there
            count = max(1, round(time / self.window))
            places += [(d0 + (d1 - d0) * i / count, o0 + (o1 - o0) * i / count) for i in range(1, count + 1)]
            duration += [time / count] * count
        separations, offsets = zip(*places, strict=True)
        return separations, offsets, tuple(duration)


class VelocityTable(MotionTable):
    """[protocol] of kind "velocity": approach and retraction at constant velocity, at a temperature."""

    kind: Literal["velocity"]
    separations: Annotated[tuple[float, ...], Field(min_length=1, max_length=1000)]
    """separations where the wall starts and reverses, in a0; a single one for a wall at rest, with dwell"""
    velocity: Positive = 0.01
    """velocity of the wall, in (E* a0³/m)^(1/2), at most 0.3"""

    @constraint
    def _moves(self) -> Iterator[Fault]:
        way = float(np.abs(np.diff(self.separations)).sum())
        if len(self.separations) == 1 and not self.dwell:
            allowed = "two or more, or dwell of at least 1, as windows of hold are not averaged"
            yield Fault(("separations",), allowed)
        if any(a == b for a, b in pairwise(self.separations)):
            yield Fault(("separations",), "another one each time", "a wall at rest: dwell")
        elif way / self.velocity / self.window > LARGEST:
            yield Fault(("window",), f"at most {LARGEST} windows on the way along the separations at this velocity")
        elif self.velocity <= FASTEST and any(
            abs(b - a) / self.velocity < SHORTEST for a, b in pairwise(self.separations)
        ):
            yield Fault(("separations",), f"apart by at least velocity x {SHORTEST:g}, the shortest window")

    @property
    def reversals(self) -> list[tuple[float, float]]:
        return [(d, 0.0) for d in self.separations]


class SlidingTable(MotionTable):
    """[protocol] of kind "sliding": the wall slides at constant velocity, with follows = "atom"."""

    kind: Literal["sliding"]
    slides: ClassVar[bool] = True
    separation: float | None = None
    """constant height of the plane h = 0 of the wall above the surface at rest, in a0"""
    pressure: float | None = None
    """constant mean pressure instead, in E*, compression positive, from -1 to 1"""
    distance: Positive
    """sliding distance, in a0"""
    velocity: Positive
    """velocity of the wall, in (E* a0³/m)^(1/2), at most 0.3"""
    along: Literal["x", "y"] | float = "x"
    """direction in which it slides: an axis, or the angle from x to y, in degrees"""

    @constraint
    def _lasts(self) -> Iterator[Fault]:
        if self.distance / self.velocity / self.window > LARGEST:
            yield Fault(("window",), f"at most {LARGEST} windows over the distance at this velocity")
        elif self.velocity <= FASTEST and self.distance / self.velocity < SHORTEST:
            yield Fault(("distance",), f"at least velocity x {SHORTEST:g}, the shortest window")

    @constraint
    def _keeps_height_or_load(self) -> Iterator[Fault]:
        if (self.separation is None) == (self.pressure is None):
            cause = "neither is given" if self.pressure is None else "both are given: the height follows from the load"
            yield Fault(("separation",), "exactly one of separation and pressure", cause)
        if self.pressure is not None:
            yield from beyond_strength("pressure", self.pressure)

    @property
    def reversals(self) -> list[tuple[float, float]]:
        height = self.separation or 0.0  # of a wall that keeps a pressure the lattice solution finds it
        return [(height, 0.0), (height, self.distance)]

    def steps(self) -> Steps:
        return super().steps() if self.pressure is None else Steps("mean-pressure", (self.pressure,), motion=self)

    def motion(self, temperature: float, timestep: float, hold_damping: float) -> Motion:
        found = super().motion(temperature, timestep, hold_damping)
        return replace(found, along=self.along, pressure=self.pressure)
