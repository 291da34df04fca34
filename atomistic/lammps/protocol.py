"""Protocols of decks in LAMMPS' language: equilibria, each started from the one before, and a wall in motion.

A moving wall has atoms at a temperature below it: time steps, a thermostat, averages with their errors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil
from typing import ClassVar, Literal, Self

import numpy as np

from atomistic.crystal.crystal import AnySlab
from atomistic.crystal.model import AnyModel
from atomistic.lammps.language import filled, formatted, listing, read_template
from continuum.model.walls import Wall

LOAD_TOLERANCE = 1e-6
"""Tolerance of the load at a given mean pressure, relative to it."""


class Protocol:
    """The steps of a deck instead of one equilibrium, and the script that runs them.

    Its numbers are those of a table [protocol] (:mod:`atomistic.inputs.motion`), which has their bounds, and of the
    lattice solution.
    """

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

    def sought(self, step: int) -> tuple[float, float] | None:
        """Mean pressure that a step seeks, in E*, and stiffness of the first move, in E*/a0; None of a separation."""
        return None

    def from_separation(self, separation: float) -> Self:
        """The protocol with another start of its search for separations; unchanged if these are given."""
        return self

    def about(self) -> Mapping[str, object]:
        """Entries of the protocol in ``deck.json`` beside the number of steps."""
        return {}

    def placeholders(self, model: AnyModel, slab: AnySlab) -> dict[str, str]:
        """Placeholders of its scripts."""
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
    """

    script = "separations"
    separations: tuple[float, ...]


@dataclass(frozen=True)
class MeanPressures(Protocol):
    """Several mean pressures in order, which LAMMPS reaches by moving the wall.

    Parameters
    ----------
    pressures : load over A0, in E*, compression positive; not zero.
    separations : separation at the start of the search for each, in a0.
    stiffness : of the slab as a whole, mean pressure per displacement of its surface, in E*/a0: the first move.
    """

    script = "pressures"
    pressures: tuple[float, ...]
    separations: tuple[float, ...]
    stiffness: float

    def sought(self, step: int) -> tuple[float, float]:
        return self.pressures[step], self.stiffness

    def from_separation(self, separation: float) -> Self:
        return replace(self, separations=(separation,) * self.steps)

    def each_step(self) -> Sequence[tuple[object, ...]]:
        return [(*numbers, self.stiffness) for numbers in zip(self.pressures, self.separations, strict=True)]

    def placeholders(self, model: AnyModel, slab: AnySlab) -> dict[str, str]:
        return {
            "pressures": listing(self.pressures),
            "load_tolerance": f"{LOAD_TOLERANCE:g}",
            "stiffness": formatted(self.stiffness * slab.surface_atoms),
            "largest_move": "0.2",
        }


AVERAGES = {
    "separation": "v_separation",
    "offset_x": "v_offset_x",
    "offset_y": "v_offset_y",
    "load": "c_load",
    "load_rep": "c_load_rep",
    "lateral_x": "c_lateral_x",
    "lateral_y": "c_lateral_y",
    "area_rep": "v_area_rep",
    "area_att": "v_area_att",
    "wall_energy": "c_wall_energy",
    "total_energy": "v_potential",
    "mean_gap": "c_mean_gap",
    "temperature": "v_temperature",
}
"""Traced quantities and their names in LAMMPS; units as in ``result.json``."""
ENERGIES = ("work_along", "work_up", "taken_by_wall", "heat", "inner_energy")
"""Columns of the energy of a window, in E* a0³.

Work that the wall did as it slid, and as it moved up or down; of the latter, what a wall that keeps a pressure took
beyond the work of that pressure; heat from the thermostat; energy of atoms and wall at the end, with their motion.
"""
BLOCKS = 10
"""Blocks of a time window, from whose means its standard errors come."""
SAMPLED = 10
"""Time steps from one sample of the wall's numbers to the next."""
_PER_PERIOD = 30
"""Time steps of the shortest period: velocity Verlet errs by (π/30)² = 1 % in the kinetic energy of that mode."""
_OTHER_SEED = 5003
"""Added to the seed of the thermostat, it is that of the noise of the wall."""
BOLTZMANN = {"lj": 1.0, "metal": 8.617343e-5}
"""LAMMPS' own, in its units."""


def times_area(slab: AnySlab) -> str:
    """Factor, in LAMMPS' language, by which E* times the area of an atom becomes E* a0²; empty of an area of a0²."""
    return "" if slab.one_to_one else f"*{formatted(slab.area)}"


def time_unit(model: AnyModel) -> float:
    """a0 (m/(E* a0³))^(1/2) in LAMMPS' unit of time."""
    # In units metal, mass velocity² in u (Å/ps)² becomes energy in eV by this factor (LAMMPS' mvv2e).
    mvv2e = 1.0364269e-4 if model.units == "metal" else 1.0
    return float(np.sqrt(mvv2e * model.mass * model.length**2 / model.energy))


def vibration_timestep(model: AnyModel, beside: float = 0.0) -> float:
    """A time step for the stiffest vibration, and a stiffness ``beside`` it, in E* a0; in a0 (m/(E* a0³))^(1/2)."""
    return float(2 * np.pi / np.sqrt(model.stiffest + beside) / _PER_PERIOD)


def largest_timestep(model: AnyModel, wall: Wall) -> float:
    """A time step for the stiffest vibration under a wall that pushes with E*, as much as any contact does.

    In a0 (m/(E* a0³))^(1/2).
    """
    gap = np.linspace(max(wall.core, wall.zero_gap - 1.0), wall.zero_gap + min(wall.range, 2.0), 2001)
    law = wall.evaluate(gap)
    return vibration_timestep(model, max(0.0, float(law.stiffness[law.traction <= 1].max())))


def swing(model: AnyModel, depth: float) -> float:
    """Angular frequency of the slowest vibration of a slab, up and down as a whole, in (E* a0³/m)^(1/2)/a0.

    A quarter of its wave is as long as the slab is deep: ω = π c/(2 depth), with c² = C11 over the density.
    """
    return float(np.pi * np.sqrt(model.normal_stiffness / model.density) / (2 * depth))


def impedance(model: AnyModel) -> float:
    """Pressure of a wave of compression across the slab over the velocity of its atoms, ρ c = √(ρ C11).

    In (E* m/a0³)^(1/2).  A wall that gives way to a pressure p at the velocity p/(ρ c) sends no such wave back where it
    touches all over, and follows a slab within the time that sound takes to cross it (Lysmer and Kuhlemeyer, J. Eng.
    Mech. Div. 95, 859 (1969), the viscous boundary); a softer contact in as much longer a time as it is softer.
    """
    return float(np.sqrt(model.density * model.normal_stiffness))


@dataclass(frozen=True)
class Motion(Protocol):
    """A wall moves at constant velocity above atoms at a temperature; load and areas are averaged over time windows.

    Times are in a0 (m/(E* a0³))^(1/2).

    Parameters
    ----------
    separations : separations at the beginning of the first window and at the end of each, in a0.
    offsets : offsets of the wall along ``along``, likewise.
    durations : duration of each window.
    temperature : k_B T, in E* a0³.
    layers : number of layers above the frozen base on which a Langevin thermostat acts.
    damping : its time constant.
    seed : seed of the initial velocities and of the thermostat.
    timestep : largest time step.
    along : direction of the offsets: an axis, or the angle from x to y, in degrees.
    hold : number of first windows in which the thermostat acts on all mobile layers, so that the slab comes to rest.
    hold_damping : time constant in these windows; ``damping`` if None.
    pressure : constant mean pressure of the wall, in E*, compression positive; the wall starts at the first
        separation, and its velocity follows from the :func:`impedance` of the crystal; None for given separations.
    """

    script, included = "motion", "in.motion"
    separations: tuple[float, ...]
    offsets: tuple[float, ...]
    durations: tuple[float, ...]
    temperature: float
    layers: int
    damping: float
    seed: int
    timestep: float
    along: Literal["x", "y"] | float = "x"
    hold: int = 0
    hold_damping: float | None = None
    pressure: float | None = None

    @property
    def steps(self) -> int:
        return len(self.durations)

    @property
    def dwell(self) -> int:
        """Number of windows after those of ``hold`` in which the wall rests."""
        ends = list(pairwise(zip(self.separations, self.offsets, strict=True)))[self.hold :]
        return next((i for i, (begin, end) in enumerate(ends) if begin != end), len(ends))

    @property
    def averaged(self) -> tuple[int, int]:
        """Windows of the means, the first and the one after the last.

        They are the first in a row after those of ``hold`` in which the wall slides or, if it never does, rests.
        """
        places = pairwise(zip(self.separations, self.offsets, strict=True))
        counts = [b[1] != a[1] if self.slides else b == a for a, b in places]
        first = next((i for i in range(self.hold, self.steps) if counts[i]), self.hold)
        return first, next((i for i in range(first, self.steps) if not counts[i]), self.steps)

    def from_separation(self, separation: float) -> Self:
        return self if self.pressure is None else replace(self, separations=(separation,) * len(self.separations))

    @property
    def slides(self) -> bool:
        return any(self.offsets)

    @property
    def block(self) -> tuple[int, ...]:
        """Time steps of a block of each window: its samples are whole, its time step at most that allowed."""
        return tuple(SAMPLED * max(1, ceil(time / (self.timestep * BLOCKS * SAMPLED))) for time in self.durations)

    @property
    def timesteps(self) -> tuple[float, ...]:
        return tuple(time / (BLOCKS * block) for time, block in zip(self.durations, self.block, strict=True))

    def _damping(self, window: int) -> float:
        return self.hold_damping if window < self.hold and self.hold_damping is not None else self.damping

    def each_step(self) -> Sequence[tuple[object, ...]]:
        places = pairwise(zip(self.separations, self.offsets, strict=True))
        damped = ((i < self.hold, self._damping(i)) for i in range(self.steps))
        found = zip(places, self.durations, self.block, damped, strict=True)
        return list(found) if self.pressure is None else [(*step, self.pressure) for step in found]

    def about(self) -> Mapping[str, object]:
        kept = {} if self.pressure is None else {"pressure": self.pressure}
        kept |= {} if isinstance(self.along, str) else {"along": self.along}
        return {"temperature": self.temperature, "hold": self.hold, "dwell": self.dwell,
                "averaged": self.averaged, **kept}  # fmt: skip

    def placeholders(self, model: AnyModel, slab: AnySlab) -> dict[str, str]:
        unit, boltzmann = time_unit(model), BOLTZMANN[model.units]
        temperature = self.temperature * model.energy / boltzmann
        height = self._height(model, slab)
        stored = ["slid_x", "slid_y", height["up"], "taken_by_wall", "heat", "inner_energy"]
        return {
            "from": listing(self.separations[:-1]),
            "to": listing(self.separations[1:]),
            "slide_from": listing(self.offsets[:-1]),
            "slide_to": listing(self.offsets[1:]),
            **self._ways(),
            "blocks": listing(self.block),
            "timesteps": listing([unit * dt for dt in self.timesteps]),
            "twice_temperature": formatted(2 * temperature),
            "temperature": formatted(temperature),
            "reduced_temperature": f"{self.temperature:.6g}",
            "seed": f"{self.seed:d}",
            "layers": f"{self.layers:d}",
            "hold": f"{self.hold:d}",
            "thermostatted": listing(["mobile" if i < self.hold else "warm" for i in range(self.steps)]),
            "first_warm": f"{slab.mobile_atoms - self.layers * slab.surface_atoms + 1:d}",
            "dampings": listing([unit * self._damping(i) for i in range(self.steps)]),
            "boltzmann": formatted(boltzmann * slab.area),
            "kinetic": formatted(1.5 / slab.area),
            "sampled": f"{SAMPLED:d}",
            "window_blocks": f"{BLOCKS:d}",
            "averaged": " ".join(AVERAGES.values()),
            "names": " ".join(AVERAGES),
            "units_of_trace": "lengths a0, forces E* a0^2, energies E* a0^3"
            + ("" if slab.one_to_one else f"; both times {formatted(slab.area)}, the area of an atom in a0^2"),
            "averages": "".join(
                f'  "{name}": $(v_{name}{times_area(slab) if name in ENERGIES else ""}:%.17g),\n' for name in stored
            ),
            "velocities": " vx vy vz",
            **height,
        }

    def _ways(self) -> dict[str, str]:
        """The offset along x and y, the sliding distance of a window, and the force along it."""
        slid, line = "${slide_from}+v_done*(${slide_to}-(${slide_from}))", "variable        offset_{} equal {}"
        if not isinstance(self.along, str):
            x, y = (formatted(float(f(np.deg2rad(self.along)))) for f in (np.cos, np.sin))
            return {
                "along": f"{self.along:g} degrees from x", "moved": "x",
                "way_x": f"({x})", "way_y": f"({y})",
                "offsets": "\n".join(line.format(name, f"({way})*({slid})") for name, way in (("x", x), ("y", y))),
                "there": f"variable        there string $(v_offset_y:%.17g)\n{line.format('y', '${there}')}\n",
            }  # fmt: skip
        across = "y" if self.along == "x" else "x"
        return {
            "along": self.along, "way_x": f"{self.along == 'x':d}", "way_y": f"{self.along == 'y':d}", "there": "",
            "moved": self.along,
            "offsets": f"{line.format(self.along, slid)}\n{line.format(across, '0.0')}",
        }  # fmt: skip

    def _height(self, model: AnyModel, slab: AnySlab) -> dict[str, str]:
        """Commands for the height of the wall: given, or from the load."""
        if self.pressure is None:
            return {
                "height_of_wall": "variable        separation equal ${from}+v_done*(${to}-(${from}))",
                "follow": "", "unfollow": "", "height_left": "",
                "here": "v_separation", "taken": "0.0", "up": "raised", "way_up": "v_to-v_from",
            }  # fmt: skip
        drag, time = impedance(model) * slab.surface_atoms, time_unit(model)
        values = {
            "rate": 1 / (drag * time),
            "load": self.pressure * slab.surface_atoms,
            "pressure": f"{self.pressure:.6g}",
            "temperature": self.temperature * model.energy / BOLTZMANN[model.units],
            # The drag m/damping of each atom of the base is that of the wall, divided among them.
            "damping": time / (drag * slab.area),
            "seed": self.seed + _OTHER_SEED,
        }
        return {
            "height_of_wall": filled(read_template("height.load"), values).rstrip(),
            "follow": filled(read_template("follow.load"), values),
            "unfollow": "unfix           follow\nunfix           noise\n",
            "height_left": 'print           "${here}" file height${mark}.txt\n',
            "here": "f_follow[2]", "taken": "f_follow[4]", "up": "work_up",
            "way_up": "-v_wanted*(f_follow[2]-v_lifted)-f_follow[4]",
        }  # fmt: skip

    def misfit(self, mobile: int, *, stays: bool) -> tuple[str, object, str] | None:
        if not 1 <= self.layers < mobile:
            return "layers", self.layers, f"from 1 to {mobile - 1}: a thermostat holds fewer layers than move"
        if self.slides and stays:
            return "shape", None, "a shape if the wall slides, as a function of the lattice site cannot"
        return None
