"""Result of a run of a deck: the last state of the atoms, and whether it is an equilibrium."""

from __future__ import annotations

import enum
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from atomistic.crystal.crystal import AnySlab, distortion, slipped
from atomistic.crystal.potentials import POTENTIAL
from atomistic.lammps.directory import FORMAT, finished_steps, read_slab
from atomistic.lammps.protocol import ENERGIES, LOAD_TOLERANCE
from atomistic.lammps.trace import mean_and_error, trace_of_window
from continuum.inputs.errors import InputError, StickinessError
from continuum.inputs.units import Units
from continuum.measure.contact import quantity
from continuum.model.fourier import Real
from continuum.solve.solution import NotConvergedError

FORCES = {"load": "force", "target_load": "target_force"}
"""Names in ``result.json`` of forces, as a load is per area here."""
_BY_FIELD = {field: name for name, field in FORCES.items()}
HCP = 2
"""LAMMPS' number of an atom with hcp neighbours."""
LARGEST_DISTORTION = 0.5
"""Relative displacement beyond which neighbours have moved apart or past one another, in a0."""


_OURS = re.compile(rf"{re.escape(POTENTIAL)}|potential\.\d+")
"""Files of potentials in a deck."""


class LammpsError(StickinessError, RuntimeError):
    """LAMMPS could not be loaded or started, or it failed: the message has the place and a remedy."""


class DeckError(InputError, LammpsError):
    """A directory has no deck, or no complete result."""


class DeckStatus(enum.Enum):
    """Status of a run; each failure has its usual cause and a remedy."""

    CONVERGED = "converged"
    AVERAGED = "averaged over the window"
    TARGET_MISSED = "the load is not that of the mean pressure: no separation near here has it"
    FORCES_LEFT = "forces are left: allow more evaluations or time, or start from the lattice solution"
    BELOW_CORE = "an atom is below the core of the wall law, where it is only a continuation: lower the core"
    YIELDED = (
        "the crystal has slipped: atoms have other neighbours than at rest; it is plastic if they keep them unloaded"
    )
    DISTORTED = (
        "neighbours have moved apart or past one another: the separation is too small, the start is wrong, or the "
        "surface reconstructs"
    )

    @property
    def ok(self) -> bool:
        """True if the state is an equilibrium of the problem as posed, or one of a motion that was averaged."""
        return self in (DeckStatus.CONVERGED, DeckStatus.AVERAGED)


@dataclass(frozen=True, eq=False)
class DeckResult:
    """The last state of a run.

    Arrays over the surface atoms have the shape ``slab.shape``, those over all atoms ``slab.ids.shape``: of fcc(100)
    (nx, ny) and (layers, nx, ny).
    """

    slab: AnySlab
    heights: Real = field(repr=False)
    """Heights of the wall above each surface atom, shape (nx, ny), in a0."""
    gap: Real = field(repr=False)
    """Height of the wall above each surface atom, shape (nx, ny), in a0."""
    traction: Real = field(repr=False)
    """Traction of the wall on each surface atom, compression positive, shape (nx, ny), in E*."""
    displacements: Real = field(repr=False)
    """Displacements of all atoms from where the slab is at rest, shape (layers, nx, ny, 3), in a0."""
    forces: Real = field(repr=False)
    """Forces on all atoms, zero in the frozen base, shape (layers, nx, ny, 3), in E* a0²."""
    step: int = quantity("1", "step of the protocol, from 1; 0 for a single equilibrium")
    separation: float = quantity("a0", "separation of the wall's zero from the surface at rest")
    offset_x: float = quantity("a0", "position of the wall along x")
    offset_y: float = quantity("a0", "position of the wall along y")
    target_force: float = quantity("E* a0^2", "prescribed force; 0 if none")
    force: float = quantity("E* a0^2", "force of the wall on the surface, compression positive")
    lateral_x: float = quantity("E* a0^2", "force of the wall on the surface along x; 0 if the wall follows the sites")
    lateral_y: float = quantity("E* a0^2", "force of the wall on the surface along y; 0 if the wall follows the sites")
    area_rep: float = quantity("1", "A_rep/A0")
    area_att: float = quantity("1", "A_att/A0")
    wall_energy: float = quantity("E* a0^3", "energy of the wall")
    total_energy: float = quantity("E* a0^3", "energy of atoms and wall")
    largest_force: float = quantity("E* a0^2", "largest force on a mobile atom, the wall included")
    tolerance: float = quantity("E* a0^2", "largest force allowed")
    smallest_gap: float = quantity("a0", "smallest gap of all atoms that move")
    core: float = quantity("a0", "gap below which the wall law is extrapolated")
    evaluations: int = quantity("1", "number of force evaluations")
    lammps_version: int = quantity("", "date of the release, yyyymmdd")
    start_force: float = quantity("E* a0^2", "largest force at the start, of a deck with relaxed starts", np.nan)
    moved: float = quantity("a0", "largest displacement of an atom, of a deck with relaxed starts", np.nan)
    bonded: bool = False
    """True if bonds are fixed, so that neighbours cannot change."""
    structure: NDArray[np.int64] | None = field(default=None, repr=False)
    """Structure by common neighbours, shape (layers, nx, ny): 1 fcc, 2 hcp, 3 bcc, 4 icosahedral, 5 other (D. Faken and
    H. Jónsson, Comput. Mater. Sci. 2, 279 (1994)); None with fixed bonds, or of an earlier deck."""
    tractions: Real | None = field(default=None, repr=False)
    """Traction of the wall on all atoms, shape (layers, nx, ny), in E*; None of an earlier deck."""
    averages: Mapping[str, tuple[float, float]] = field(default_factory=dict, repr=False)
    """Mean over the time window, and its standard error, by name; empty for an equilibrium.

    ``load`` is ``force``, ``load_rep`` its repulsive part, the others as above, ``temperature`` k_B T of all
    mobile atoms in E* a0³.
    """
    trace: Mapping[str, Real] = field(default_factory=dict, repr=False)
    """Samples over the time window, by name, each of shape (samples,), in these units, with the time ``step`` of each;
    empty for an equilibrium, and of an earlier deck."""
    energies: Mapping[str, float] = field(default_factory=dict, repr=False)
    """Energies of the window, in E* a0³, by :data:`atomistic.lammps.protocol.ENERGIES`; empty as above."""

    @property
    def load_rep(self) -> float:
        """Repulsive part of the force of the wall, in E* a0²."""
        on = self.traction if self.tractions is None else self.tractions
        return float(on[on > 0].sum()) * self.slab.area

    @property
    def mean_gap(self) -> float:
        """Mean gap, in a0."""
        return float(self.gap.mean())

    @cached_property
    def distortion(self) -> float:
        """Largest displacement of an atom relative to a nearest neighbour, in a0."""
        return distortion(self.slab, self.displacements)

    @cached_property
    def slipped(self) -> NDArray[np.bool_]:
        """Atoms whose nearest neighbours have changed, shape (layers, nx, ny); none with fixed bonds."""
        if self.bonded:
            return np.zeros(self.slab.ids.shape, np.bool_)
        return slipped(self.slab, self.displacements)

    @property
    def faulted(self) -> int:
        """Number of atoms in stacking faults, hcp among fcc ones; -1 if not analysed, or not an fcc crystal."""
        if self.structure is None or not self.slab.name.startswith("fcc"):
            return 0 if self.bonded else -1
        return int(np.count_nonzero(self.structure == HCP))

    @property
    def status(self) -> DeckStatus:
        # Atoms in motion have forces at any time.
        if not self.averages and not self.largest_force <= self.tolerance:
            return DeckStatus.FORCES_LEFT
        if self.smallest_gap < self.core:
            return DeckStatus.BELOW_CORE
        if self.slipped.any():
            return DeckStatus.YIELDED
        if not self.distortion < LARGEST_DISTORTION:
            return DeckStatus.DISTORTED
        if self.target_force and not abs(self.force - self.target_force) <= LOAD_TOLERANCE * abs(self.target_force):
            return DeckStatus.TARGET_MISSED
        if self.averages:
            return DeckStatus.AVERAGED
        return DeckStatus.CONVERGED

    def require(self) -> DeckResult:
        """Return the result if it is an equilibrium; raises NotConvergedError otherwise."""
        if not self.status.ok:
            raise NotConvergedError(
                f"{self.status.value} (largest force {self.largest_force:.2e} E* a0², tolerance "
                f"{self.tolerance:.2e}, smallest gap {self.smallest_gap:.4f} a0, neighbours displaced "
                f"by up to {self.distortion:.3f} a0, {np.count_nonzero(self.slipped)} atoms with other neighbours, "
                f"{self.evaluations} evaluations)"
            )
        return self


UNITS = {
    **{_BY_FIELD.get(c.name, c.name): str(c.metadata["units"]) for c in fields(DeckResult) if c.metadata.get("units")},
    "length_unit": "LAMMPS' unit of length",
    "force_unit": "LAMMPS' unit of force, of E* times the area of an atom",
    "load_nN": "nN", "mean_pressure_GPa": "GPa", "slid_x": "a0", "slid_y": "a0", "raised": "a0",
    **dict.fromkeys(ENERGIES, "E* a0^3"),
}  # fmt: skip
"""Unit of each key of ``result.json`` that has one."""


@dataclass(frozen=True)
class DeckDescription:
    """Contents of a ``deck.json``."""

    identity: str
    """Hash of all that LAMMPS reads."""
    steps: int
    """Steps of the protocol; 0 for a single equilibrium."""
    wall: Mapping[str, Any]
    """Name and parameters of the law."""
    element: str
    """Chemical symbol, "X" for none."""
    model: str
    """Description of the interatomic model."""
    surface: float
    """Height of the surface at rest above its lattice plane, in a0."""
    notes: tuple[str, ...]
    """Lines about the origin of the heights."""
    length: float
    """Size of a0 in LAMMPS' unit."""
    real_units: Units | None
    """Size of a0 and E*, if the crystal has a length scale."""
    files: Mapping[str, str] = field(default_factory=dict)
    """Names of the files of the potential as they were given, by their names in the deck."""
    bonded: bool = False
    """True if bonds are fixed."""
    relaxed: int = 0
    """Number of first steps whose starts were relaxed before."""
    temperature: float = 0.0
    """k_B T of a motion, in E* a0³; zero of equilibria."""
    hold: int = 0
    """Number of first windows of a motion, in which a thermostat acts on all layers; they are not averaged."""
    dwell: int = 0
    """Number of following windows in which the wall rests."""
    averaged: Sequence[int] = ()
    """First window of the means, and the one after the last; empty in a deck of an earlier version."""
    along: float | None = None
    """Direction of sliding, from x to y, in degrees; None along an axis."""
    pressure: float | None = None
    """Constant mean pressure of a sliding wall, in E*; None at constant separation."""


def read_description(directory: Path) -> DeckDescription:
    """Description of the deck in a directory; raises DeckError if there is none, or it is damaged."""
    directory = Path(directory)
    if not directory.is_dir():
        what = "is a file, not the directory of a deck" if directory.exists() else "is not there"
        raise DeckError(f"{directory} {what}")
    path = directory / "deck.json"
    if not (path.is_file() and (directory / "in.contact").is_file()):
        msg = f"{directory} has no deck (in.contact with deck.json); `atomistic deck` writes one"
        if (directory / "in.wall").is_file():
            msg = f"{directory} is the wall of a script, not a deck: read the trace of its run, wall.trace.txt"
        raise DeckError(msg)
    try:
        numbers = json.loads(path.read_text(encoding="utf-8"))
        if numbers.pop("format") != FORMAT:
            raise ValueError(f"it is not {FORMAT}")
        real, notes = numbers.pop("real_units"), tuple(numbers.pop("notes"))
        known = {column.name: numbers[column.name] for column in fields(DeckDescription) if column.name in numbers}
        return DeckDescription(notes=notes, real_units=None if real is None else Units(**real), **known)
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise DeckError(f"{path} is damaged, or of another version ({error}): write the deck again") from error


def read_result(directory: Path, step: int | None = None) -> DeckResult:
    """Read the result of a step, from 1, or of the last finished step, of a deck in a directory.

    Raises DeckError if there is no complete result, or it has numbers that are not finite.
    """
    directory = Path(directory)
    description = read_description(directory)
    if step is None:
        finished = finished_steps(directory)
        if not finished and not any(directory.glob("log*lammps")):
            raise DeckError(f"{directory} has a deck that has not been run: run `lmp -in in.contact` there first")
        if not finished:
            raise DeckError(
                f"{directory} holds no complete result of a run: it was stopped, or is under way; "
                f"`lmp -in in.contact` there runs it{tail(directory)}"
            )
        step = finished[-1]
    mark = f".{step}" if step else ""
    try:
        slab = read_slab(directory / "slab.data")
        numbers = json.loads((directory / f"result{mark}.json").read_text(encoding="utf-8"))
        log = (directory / f"log{mark}.lammps").read_text(encoding="utf-8", errors="replace")
        surface = _read_dump(directory / f"surface{mark}.dump", slab.surface_atoms)
        state = _read_dump(directory / f"state{mark}.dump", slab.size)
        traced = directory / f"trace{mark}.txt"
        trace = trace_of_window(traced) if "slid_x" in numbers else {}
        return replace(_result(slab, numbers, log, surface, state, trace), bonded=description.bonded)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        msg = f"{directory} holds no complete result of a run: {error}; `lmp -in in.contact` there runs it anew"
        raise DeckError(msg) from error


def _result(
    slab: AnySlab, numbers: dict[str, float], log: str, surface: _Rows, state: _Rows, trace: dict[str, Real]
) -> DeckResult:
    scaled = numbers.pop("units", None) is not None
    known = [values for rows in (surface, state) for values in rows.values()]
    if not all(map(math.isfinite, numbers.values())) or not all(np.isfinite(values).all() for values in known):
        raise ValueError("it has numbers that are not finite: check separation and start")
    minimisers = re.findall(r"Iterations, force evaluations = \d+ (\d+)", log)
    # Earlier decks, and the trace, count forces in E* and energies in E* a0, times the area of a surface atom.
    totals = {**{c.name: c for c in fields(DeckResult) if c.metadata.get("units") in ("E* a0^2", "E* a0^3")},
              **dict.fromkeys(FORCES), **dict.fromkeys(ENERGIES), "load_rep": None}  # fmt: skip
    for name in numbers:
        if not scaled and name.removeprefix("mean_").removeprefix("error_") in totals:
            numbers[name] *= slab.area
    trace = {name: values * slab.area if name in totals else values for name, values in trace.items()}
    averages = {name: mean_and_error(values) for name, values in trace.items() if name != "step"} or {
        name.removeprefix("mean_"): (value, numbers[name.replace("mean_", "error_", 1)])
        for name, value in numbers.items()
        if name.startswith("mean_") and name.replace("mean_", "error_", 1) in numbers
    }
    if trace:
        slid = (averages[f"lateral_{axis}"][0] * numbers[f"slid_{axis}"] for axis in "xy")
        numbers |= {"work_along": sum(slid), "work_up": -averages["load"][0] * numbers.get("raised", 0.0)} | numbers
    loops = [int(steps) for steps in re.findall(r"Loop time of .* for (\d+) steps", log)]
    evaluations = sum(map(int, minimisers)) + loops.count(0) + (sum(loops) if averages else 0)
    sites = (*slab.ids.shape, 3)
    length, force = numbers["length_unit"], numbers["force_unit"]
    vectors = [np.stack([state[name] for name in names], axis=-1) for names in (_DISPLACEMENT, ("fx", "fy", "fz"))]
    step, version = int(numbers.pop("step")), int(numbers.pop("lammps_version"))
    own = {column.name: column.name for column in fields(DeckResult)} | FORCES
    columns: dict[str, Any] = {own[name]: float(value) for name, value in numbers.items() if name in own}
    return DeckResult(
        slab=slab,
        step=step,
        evaluations=evaluations,
        structure=np.rint(state["structure"]).astype(np.int64).reshape(sites[:-1]) if "structure" in state else None,
        averages=averages,
        trace=trace,
        energies={name: numbers[name] for name in ENERGIES if name in numbers},
        lammps_version=version,
        gap=surface["gap"].reshape(slab.shape),
        traction=surface["traction"].reshape(slab.shape),
        heights=surface["wall_height"].reshape(slab.shape),
        tractions=state["traction"].reshape(sites[:-1]) if "traction" in state else None,
        displacements=vectors[0].reshape(sites) / length,
        forces=vectors[1].reshape(sites) / force * slab.area,
        **columns,
    )


def named(text: str, names: Mapping[str, str]) -> str:
    """A message of LAMMPS with the names of the potential's files as they were given."""
    return _OURS.sub(lambda found: names.get(found[0], found[0]), text)


def names_in(directory: Path) -> Mapping[str, str]:
    """Names of the files of the potential of a deck as they were given; none if the deck does not say."""
    try:
        return read_description(directory).files
    except DeckError:
        return {}


def tail(directory: Path) -> str:
    """Last lines of the newest log, with the names of files as they were given."""
    try:
        logs = sorted(Path(directory).glob("log*lammps"), key=lambda path: path.stat().st_mtime)
        log = logs[-1].read_text(encoding="utf-8", errors="replace")
    except (OSError, IndexError):
        return ""
    lines = "\n".join(log.splitlines()[-12:])
    return f"\nLast lines of {logs[-1].name}:\n{named(lines, names_in(directory))}"


_Rows = dict[str, Real]
_DISPLACEMENT = ("Displacement.X", "Displacement.Y", "Displacement.Z")


def _read_dump(path: Path, atoms: int) -> _Rows:
    """Columns of numbers of a dump, by name, in the order of the atoms."""
    with path.open(encoding="utf-8") as file:
        header = [next(file, "") for _ in range(9)]
        if not file.read(1):
            raise ValueError(f"{path} ends before its atoms")
    names = header[8].split()[2:]
    wanted = [i for i, name in enumerate(names) if name != "element"]
    rows = np.loadtxt(path, skiprows=9, ndmin=2, usecols=wanted)
    if len(rows) != atoms or not np.array_equal(rows[:, 0], np.arange(1, atoms + 1)):
        raise ValueError(f"{path} does not hold the atoms 1 to {atoms} in order")
    return {names[i]: rows[:, k].copy() for k, i in enumerate(wanted)}
