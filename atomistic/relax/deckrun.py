"""A whole run of a deck: the numbers of its steps, their storage, and the comparison with the continuum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from atomistic.lammps.directory import finished_steps, read_heights, read_wall
from atomistic.lammps.protocol import AVERAGES, ENERGIES, LOAD_TOLERANCE
from atomistic.lammps.result import (
    FORCES,
    DeckDescription,
    DeckError,
    DeckResult,
    DeckStatus,
    read_description,
    read_result,
)
from atomistic.lammps.trace import EnergyBalance, WindowMean, errors_of_one_state
from continuum.inputs.arguments import choice, field_of
from continuum.measure.contact import Totals, contact_map, quantity, shared
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Substrate, TabulatedSubstrate
from continuum.model.surface import moments
from continuum.model.walls import Wall
from continuum.path import loading
from continuum.solve.solution import Settings
from continuum.store import datasets as store
from continuum.store.datasets import Dataset, columns
from continuum.store.output import folder
from continuum.store.provenance import provenance

SCHEMA, VERSION = "stickiness/deck-run", 2
TOTALS = ("load", "load_rep", "lateral_x", "lateral_y", "wall_energy", "total_energy")
"""Quantities of all atoms, which are stored over A0."""


@dataclass(frozen=True, kw_only=True)
class DeckStep(Totals):
    """One equilibrium of a run, or the means of one time window of a motion, with their standard errors.

    Names and units are those of a continuum run.  The total energy excludes kinetic energy; an equilibrium has no
    temperature, and its standard errors are zero.
    """

    separation: float = quantity("a0", "height of the wall's zero above the surface at rest")
    offset_x: float = quantity("a0", "displacement of the wall along x")
    offset_y: float = quantity("a0", "displacement of the wall along y")
    mean_gap: float = quantity("a0", "mean gap")
    lateral_x: float = quantity("E*", "force of the wall on the atoms along x over A0")
    lateral_y: float = quantity("E*", "force of the wall on the atoms along y over A0")
    total_energy: float = quantity("E* a0", "energy of atoms and wall per area")
    temperature: float = quantity("E* a0^3", "k_B T of the mobile atoms")
    separation_error: float = quantity("a0", "standard error of the separation")
    load_error: float = quantity("E*", "standard error of N/A0")
    lateral_x_error: float = quantity("E*", "standard error of the force along x")
    lateral_y_error: float = quantity("E*", "standard error of the force along y")
    area_rep_error: float = quantity("1", "standard error of A_rep/A0")
    area_att_error: float = quantity("1", "standard error of A_att/A0")
    mean_gap_error: float = quantity("a0", "standard error of the mean gap")
    temperature_error: float = quantity("E* a0^3", "standard error of k_B T")
    work_along: float = quantity("E* a0", "work of the sliding wall on the atoms over A0")
    work_up: float = quantity("E* a0", "work of the wall on the atoms by its vertical motion, over A0")
    taken_by_wall: float = quantity("E* a0", "energy over A0 that the wall absorbed beyond the work of its load")
    heat: float = quantity("E* a0", "heat from the thermostat over A0")
    inner_energy: float = quantity("E* a0", "energy of atoms and wall over A0 at the end, kinetic energy included")
    largest_force: float = quantity("E* a0^2", "largest force left on an atom")
    evaluations: int = quantity("1", "evaluations of the forces")
    start_force: float = quantity("E* a0^2", "largest force on an atom at the start of the step; NaN if not measured")
    moved: float = quantity("a0", "largest displacement of an atom in the step; NaN if not measured")
    slipped: int = quantity("1", "atoms whose nearest neighbours changed")
    faulted: int = quantity("1", "atoms in stacking faults, hcp by common neighbour analysis; -1 if not analysed")
    status: str = quantity("", "equilibrium, or the reason why not")
    direction: float = 0.0
    """Direction of sliding where it is no axis, from x to y, in degrees."""

    @property
    def _way(self) -> Real:
        return np.array([np.cos(np.deg2rad(self.direction)), np.sin(np.deg2rad(self.direction))])

    @property
    def offset_s(self) -> float:
        """Offset of the wall in the direction of sliding, in a0."""
        return float(self._way @ (self.offset_x, self.offset_y))

    @property
    def lateral_s(self) -> float:
        """Force of the wall on the atoms in the direction of sliding, over A0, in E*."""
        return float(self._way @ (self.lateral_x, self.lateral_y))

    @property
    def lateral_s_error(self) -> float:
        """Standard error of the lateral force, from the errors along x and y as if they were one."""
        return float(np.abs(self._way) @ (self.lateral_x_error, self.lateral_y_error))

    @classmethod
    def of(cls, result: DeckResult, direction: float = 0.0) -> DeckStep:
        """The numbers of a state, or of a window."""
        found = dict[str, float]()
        for name in AVERAGES:
            at_end = getattr(result, FORCES.get(name, name), 0.0)  # an equilibrium has no temperature
            mean, error = result.averages.get(name, (at_end, 0.0))
            size = result.slab.grid.area if name in TOTALS else 1
            found |= {name: mean / size, f"{name}_error": error / size}
        unknown = np.nan if result.averages else 0.0  # of a window by an earlier deck, and of an equilibrium
        found |= {name: result.energies.get(name, unknown) / result.slab.grid.area for name in ENERGIES}
        return cls(
            load_att=found["load_rep"] - found["load"],
            smallest_gap=result.smallest_gap,
            largest_force=result.largest_force,
            evaluations=result.evaluations,
            start_force=result.start_force,
            moved=result.moved,
            slipped=int(np.count_nonzero(result.slipped)),
            faulted=result.faulted,
            status=result.status.name,
            direction=direction,
            **{name: value for name, value in found.items() if name in cls.__dataclass_fields__},
        )


@dataclass(frozen=True, kw_only=True)
class ContinuumStep(Totals):
    """The continuum at the mean gap of a step: the same wall on the linear response of the slab at rest."""

    same: float = quantity("1", "points with the same contact (repulsive, attracted or none) as the atoms")
    converged: bool


@dataclass(frozen=True)
class FirstYield:
    """Onset of other neighbours: half way between two equilibria, with half their distance as error."""

    separation: tuple[float, float]
    """In a0."""
    load: tuple[float, float]
    """N/A0, in E*."""
    pressure: tuple[float, float]
    """Mean contact pressure N_rep/A_rep, in E*."""


@dataclass(frozen=True)
class Imprint:
    """Imprint that stays when the wall is off the surface again."""

    displaced: int
    """Atoms further than half of a0 from where they were at rest."""
    depth: float
    """Depth of the deepest surface atom below the surface at rest, in a0."""
    recovered: float
    """Part of the work of the wall on its way down that it got back, by trapezoids over the way with fewer steps."""


@dataclass(frozen=True, eq=False)
class DeckSteps:
    """Numbers of a deck run: every finished step, and the last state of the atoms."""

    directory: Path
    description: DeckDescription = field(repr=False)
    wall: Wall
    """Law of the wall."""
    heights: Real = field(repr=False)
    """Heights of the wall at the points of the grid of the slab, in a0: above the lattice sites of fcc(100)."""
    steps: tuple[DeckStep, ...]
    gaps: Real = field(repr=False)
    """Gap at each surface atom, shape ``(steps, *slab.shape)``, in a0."""
    last: DeckResult = field(repr=False)
    slips: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 0, 0), np.int64), repr=False)
    """Atoms below each surface atom, itself included, with other nearest neighbours than before, shape as ``gaps``."""
    stiffness: Real | None = field(default=None, repr=False)
    """K_q of the slab at rest, in E*/a0, for the continuum; an isotropic half-space of nu = 1/2 if None."""
    traces: tuple[Mapping[str, Real], ...] = field(default=(), repr=False)
    """Samples of each window of a motion, as :attr:`DeckResult.trace`."""

    @classmethod
    def read(cls, directory: Path) -> Self:
        """Every finished step of a run.

        Raises
        ------
        DeckError
            If there is none, or one is damaged.
        """
        description = read_description(directory)
        steps, gaps, slips, traces = [], [], [], list[Mapping[str, Real]]()
        result = None
        for step in finished_steps(directory):
            result = read_result(directory, step)
            steps.append(DeckStep.of(result, description.along or 0.0))
            gaps.append(result.gap)
            slips.append(result.slab.below(result.slipped))
            traces += [result.trace] if result.trace else []
        last = result or read_result(directory)  # which raises the reason
        try:
            wall, heights = read_wall(directory), read_heights(directory / "slab.data")
            path = directory / "stiffness.npy"
            stiffness = field_of("stiffness", np.load(path), last.slab.grid.shape_q) if path.is_file() else None
        except (OSError, ValueError, TypeError, KeyError, AttributeError, EOFError) as error:
            raise DeckError(f"the deck in {directory} is damaged: {error}; write it again") from error
        # All windows after hold are at one temperature, and heat flows slowly through the layers of the thermostat.
        warm = steps[description.hold :]
        errors = errors_of_one_state(
            *(np.array([getattr(step, f"temperature{e}") for step in warm]) for e in ("", "_error"))
        )
        steps[description.hold :] = [
            replace(step, temperature_error=float(e)) for step, e in zip(warm, errors, strict=True)
        ]
        return cls(
            directory, description, wall, heights, tuple(steps), np.array(gaps), last, np.array(slips), stiffness,
            tuple(traces),
        )  # fmt: skip

    @property
    def expected(self) -> int:
        """Number of steps of the protocol."""
        return max(self.description.steps, 1)

    @property
    def finished(self) -> bool:
        """True if all steps are finished."""
        return len(self.steps) == self.expected

    @property
    def averaged(self) -> tuple[DeckStep, ...]:
        """Windows to average in a motion: those in which the wall slides, else those in which it rests after hold."""
        return self.steps[slice(*self._averaged)]

    @property
    def _averaged(self) -> Sequence[int]:
        about = self.description
        rest = about.hold + about.dwell
        return about.averaged or ((rest, len(self.steps)) if self.slides else (about.hold, rest))

    @property
    def trace(self) -> Mapping[str, Real]:
        """Samples of all windows of a motion one after the other, by name, each of shape (samples,).

        Names and units are those of :class:`DeckStep`, with ``lateral_s`` and ``offset_s`` along a direction of
        sliding, and the ``window`` of each sample, from 1.  Empty of equilibria, and of a deck of an earlier version.
        """
        if not self.traces:
            return {}
        area = self.last.slab.grid.area
        found = {
            name: np.concatenate([each[name] for each in self.traces]) for name in self.traces[0] if name != "step"
        }
        found |= {name: found[name] / area for name in TOTALS}
        way = np.deg2rad(self.description.along or 0.0)
        for name in ("lateral", "offset"):
            found[f"{name}_s"] = np.cos(way) * found[f"{name}_x"] + np.sin(way) * found[f"{name}_y"]
        counts = [len(each["step"]) for each in self.traces]
        found["window"] = np.repeat(np.arange(len(self.steps) - len(counts), len(self.steps)) + 1, counts)
        return found

    @property
    def slides(self) -> str:
        """Along which axis the wall slides, "x" or "y", "s" of another direction; empty if it does not."""
        if self.description.along is not None:
            return "s"
        return next((name for name in "xy" if any(getattr(step, f"offset_{name}") for step in self.steps)), "")

    @property
    def yielded(self) -> int | None:
        """First step in which atoms have other neighbours than at rest, from 0; None without any.

        It is plastic only if they keep them when they are :attr:`unloaded`.
        """
        return next((i for i, step in enumerate(self.steps) if step.status == DeckStatus.YIELDED.name), None)

    @property
    def first_yield(self) -> FirstYield | None:
        """Separation, load and contact pressure at :attr:`yielded`; None without, or not after two states in contact.

        The crystal held the state before it.  What the next one would have been without slip is continued from the two
        before in a straight line, over what was prescribed: the separation, or the load.
        """
        i = self.yielded
        if i is None or i < 2 or self.last.averages:
            return None
        a, b, c = self.steps[i - 2 : i + 1]
        x = [step.load if self.last.target_force else step.separation for step in (a, b, c)]
        if x[0] == x[1] or not all(step.area_rep and DeckStatus[step.status].ok for step in (a, b)):
            return None
        half = 0.5 * (x[2] - x[1]) / (x[1] - x[0])

        def between(before: float, held: float) -> tuple[float, float]:
            further = half * (held - before)
            return held + further, abs(further)

        pressures = (step.load_rep / step.area_rep for step in (a, b))
        return FirstYield(between(a.separation, b.separation), between(a.load, b.load), between(*pressures))

    @property
    def imprint(self) -> Imprint | None:
        """Imprint at the end of a staircase down and up; None if its first or last state bears a load."""
        load, s = (np.array([getattr(step, name) for step in self.steps]) for name in ("load", "separation"))
        lowest = int(np.argmin(s))
        down, up = np.s_[lowest::-1], np.s_[lowest:]  # each from the lowest step on
        free = max(load[0], load[-1]) <= LOAD_TOLERANCE * load.max()
        one_way = lowest and lowest < len(s) - 1 and all((np.diff(s[way]) > 0).all() for way in (down, up))
        if self.last.averages or not (free and one_way and load.max() > 0):
            return None
        # At the same separations, so that coarse steps err alike on both ways.
        at = min(s[down], s[up], key=len)
        taken, given = (float(np.trapezoid(np.interp(at, s[way], load[way]), at)) for way in (down, up))
        moved, slab = self.last.displacements.reshape(-1, 3), self.last.slab
        rise = self.description.surface - np.median(slab.positions.reshape(-1, 3)[: slab.surface_atoms, 2])
        depth = float(rise - moved[: slab.surface_atoms, 2].min())
        return Imprint(int(np.count_nonzero(np.linalg.norm(moved, axis=1) > 0.5)), depth, given / taken)

    @property
    def unloaded(self) -> int | None:
        """Step after :attr:`yielded`, from 0, in which the withdrawn wall bears least; None if none is unloaded.

        That is one whose load is no larger than the crystal bore before it slipped, to the tolerance of a load.
        """
        i = self.yielded
        if i is None or self.slides:
            return None
        borne = max(self.steps[i - 1].load, 0.0) if i else 0.0
        later = [
            j for j in range(i + 1, len(self.steps)) if self.steps[j].separation > self.steps[i].separation
            and self.steps[j].load <= borne * (1 + LOAD_TOLERANCE)
        ]  # fmt: skip
        return min(later, key=lambda j: abs(self.steps[j].load), default=None)

    @property
    def plastic(self) -> bool | None:
        """True if atoms still have other neighbours when they are :attr:`unloaded`; None if that is not known.

        Slip that is left under a load may still spring back.
        """
        if self.yielded is None:
            return False
        if self.unloaded is None:
            return None
        step, largest = self.steps[self.unloaded], max(step.load for step in self.steps)
        return None if step.slipped and step.load > LOAD_TOLERANCE * largest else step.slipped > 0

    def mean(self, name: str) -> WindowMean:
        """Mean of a quantity of :class:`DeckStep` that has a standard error, over the windows :attr:`averaged`.

        Raises
        ------
        ArgumentError, DeckError
            If there is no such quantity, or no such window.
        """
        names = [
            "lateral_s",
            *(column.name.removesuffix("_error") for column in fields(DeckStep) if column.name.endswith("_error")),
        ]
        choice("name", name, names)
        if not self.averaged:
            raise DeckError(f"{self.directory}: no window with a resting (dwell) or sliding wall is finished")
        return WindowMean.of(*(np.array([getattr(step, n) for step in self.averaged]) for n in (name, f"{name}_error")))

    @property
    def friction(self) -> WindowMean | None:
        """Friction coefficient and its standard error: mean friction over mean load while the wall slides.

        None if the wall does not slide, or the load is not above zero by more than three standard errors.
        See :meth:`WindowMean.of_ratio`.
        """
        if not (self.slides and self.averaged and (load := self.mean("load")).mean > 3 * load.error):
            return None
        names = (f"lateral_{self.slides}", f"lateral_{self.slides}_error", "load", "load_error")
        return WindowMean.of_ratio(*(np.array([getattr(step, name) for step in self.averaged]) for name in names))

    @property
    def balance(self) -> EnergyBalance | None:
        """Energy that atoms and wall got over the windows :attr:`averaged`; None without any, or of an earlier deck."""
        count, first = len(self.averaged), self._averaged[0]
        if not (count and first):
            return None  # without a state before them
        numbers = np.array([[getattr(step, name) for name in ENERGIES] for step in self.averaged])
        kept = float(numbers[-1, -1] - self.steps[first - 1].inner_energy)
        along, up, taken, heat, _ = map(float, numbers.sum(axis=0))
        error = float(np.sqrt(count) * numbers[:, 2].std(ddof=1)) if count > 1 else np.inf
        return EnergyBalance(along, up + taken, taken, error, heat, kept) if np.isfinite(kept) else None

    @property
    def converged(self) -> bool:
        """True if there are finished steps, and each is an equilibrium, or an averaged window of a motion."""
        return bool(self.steps) and all(DeckStatus[step.status].ok for step in self.steps)

    @property
    def response(self) -> str:
        """The continuum that it is compared with, in words."""
        if self.stiffness is None:
            return "an isotropic half-space of nu = 1/2"
        slab = self.last.slab
        return (
            "the slab's own linear response at rest" if slab.one_to_one else f"the half-space below {slab.name} at rest"
        )

    @property
    def incomparable(self) -> str:
        """Reason why the deck cannot be compared with the continuum, in a sentence; empty if it can."""
        if self.slides:
            return "The wall slides, which the continuum cannot model: there is no comparison."
        return ""

    def compare(self) -> tuple[ContinuumStep, ...]:
        """The continuum at the mean gap of each step, along the same path as the atoms.

        Raises
        ------
        DeckError
            If it is :attr:`incomparable`.
        """
        if self.incomparable:
            raise DeckError(f"{self.directory}: {self.incomparable}")
        return self._continuum

    @cached_property
    def _continuum(self) -> tuple[ContinuumStep, ...]:
        slab, heights = self.last.slab, self.heights
        substrate: Substrate = HalfSpace()
        if self.stiffness is not None:
            substrate = TabulatedSubstrate(self.stiffness, slab.grid.lengths, self.response)
        problem = ContactProblem(slab.grid, self.wall, heights, substrate)
        settings = Settings(1e-9 * (moments(slab.grid, heights).rms_slope or 1.0))
        states = loading.follow(problem, "mean-gap", [step.mean_gap for step in self.steps], settings)
        found = []
        for state, gap in zip(states, self.gaps, strict=True):
            same = float(np.mean(contact_map(self.wall, state.gap) == contact_map(self.wall, slab.on_grid(gap))))
            found.append(ContinuumStep(**shared(Totals, state), same=same, converged=state.converged))
        return tuple(found)

    def store(self, path: Path, beside: tuple[ContinuumStep, ...] = ()) -> Path:
        """Store the run as ``NAME.h5``; returns it.

        Raises
        ------
        OutputError
            If another file has that name, or it cannot be written.
        """
        folder(path.parent)
        store.earlier(path, SCHEMA, VERSION, self.description.identity, force=True)
        datasets = columns(self.steps, "step")
        datasets["step"] = Dataset(np.arange(1, len(self.steps) + 1), ("step",), "1", "step of the protocol")
        axes = self.last.slab.axes
        datasets["gap"] = Dataset(self.gaps, ("step", *axes), "a0", "gap at each surface atom")
        kinds = np.array([contact_map(self.wall, gap) for gap in self.gaps], dtype=np.uint8)
        datasets["contact"] = Dataset(kinds, ("step", *axes), "1", "2 repulsive, 1 attracted, 0 out of range")
        datasets["slipped"] = Dataset(self.slips, ("step", *axes), "1", "atoms below each site with other neighbours")
        datasets["height"] = Dataset(self.heights, ("x", "y"), "a0", "height of the wall at each point of the grid")
        if beside:
            datasets |= {f"continuum/{name}": column for name, column in columns(beside, "step").items()}
        real = self.description.real_units
        sizes = {} if real is None else {f"real_units/{name}": value for name, value in asdict(real).items() if value}
        attributes = {
            "schema": SCHEMA,
            "schema_version": VERSION,
            "identity": self.description.identity,
            "finished": self.finished,
            "model": self.description.model,
            "element": self.description.element,
            "wall": repr(dict(self.description.wall)),
            "lammps_version": self.last.lammps_version,
            **sizes,
            **provenance(),
        }
        store.write(path, datasets, attributes)
        return path
