"""What a run of a deck leaves behind: the last state of the atoms, and whether it is an equilibrium."""

from __future__ import annotations

import enum
import json
import math
import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from atomistic.crystal.crystal import Slab
from atomistic.lammps.deck import read_slab
from continuum.model.grid import Real
from continuum.solve.smooth import NotConvergedError

__all__ = ["DeckResult", "DeckStatus", "LammpsError", "read_result", "tail"]


class LammpsError(RuntimeError):
    """LAMMPS could not be loaded or started, or it failed: the message says where and what helps."""


class DeckStatus(enum.Enum):
    """What a run has found.  Each failure names its usual cause and what helps."""

    CONVERGED = "converged"
    FORCES_LEFT = "forces are left: allow more evaluations or time, or start from the lattice solution"
    BELOW_CORE = "the surface went below the core of the wall law, where it is only continued: lower the core"
    DISTORTED = "neighbours have moved apart or past one another: the separation is too small, or the start wrong"

    @property
    def ok(self) -> bool:
        """Whether the state is an equilibrium of the problem as posed."""
        return self is DeckStatus.CONVERGED


@dataclass(frozen=True, eq=False)
class DeckResult:
    """The last state of a run.  Arrays are in the order of :class:`atomistic.crystal.crystal.Slab`."""

    slab: Slab
    separation: float
    """Of the wall's zero from the surface at rest, in a0."""
    load: float
    """Force of the wall on the surface, compression positive, in E* a0²."""
    wall_energy: float
    """In E* a0³."""
    total_energy: float
    """Of atoms and wall, in E* a0³."""
    largest_force: float
    """On a mobile atom, the wall included, in E* a0²."""
    tolerance: float
    """Largest force allowed, in E* a0²."""
    smallest_gap: float
    """In a0."""
    core: float
    """Gap below which the wall law is only continued, in a0."""
    evaluations: int
    """Of the forces."""
    lammps_version: int
    """Date of the release, yyyymmdd."""
    gap: Real = field(repr=False)
    """Height of the wall above each surface atom, shape (nx, ny), in a0."""
    traction: Real = field(repr=False)
    """Of the wall on each surface atom, compression positive, shape (nx, ny), in E*."""
    displacements: Real = field(repr=False)
    """Of all atoms from where the slab is at rest, shape (layers, nx, ny, 3), in a0."""
    forces: Real = field(repr=False)
    """On all atoms, zero in the frozen base, shape (layers, nx, ny, 3), in E* a0²."""

    @cached_property
    def distortion(self) -> float:
        """Largest displacement of an atom relative to a nearest neighbour, in a0.

        It bounds the strain of the springs, and tells a crystal from one that is turned inside out: springs
        have no memory of direction, and a layer pushed through the next is at rest again.
        """
        u, largest = self.displacements, 0.0
        for layer in range(self.slab.mobile):
            here = u[layer]
            beside = [np.roll(here, 1, axis=axis) for axis in (0, 1)]
            # The four atoms below stand at half spacings: of an even layer at -1/2 and +1/2, and so on.
            side = 1 if layer % 2 == 0 else -1
            below = [np.roll(u[layer + 1], (side * i, side * j), axis=(0, 1)) for i in (0, 1) for j in (0, 1)]
            largest = max(largest, *(float(np.max(np.sum((here - v) ** 2, axis=-1))) for v in beside + below))
        return float(np.sqrt(largest))

    @property
    def status(self) -> DeckStatus:
        """Whether this is an equilibrium."""
        if not self.largest_force <= self.tolerance:
            return DeckStatus.FORCES_LEFT
        if self.smallest_gap < self.core:
            return DeckStatus.BELOW_CORE
        if not self.distortion < 0.5:
            return DeckStatus.DISTORTED
        return DeckStatus.CONVERGED

    def require(self) -> DeckResult:
        """The result itself, if it is an equilibrium.

        Raises
        ------
        NotConvergedError
            Otherwise.
        """
        if not self.status.ok:
            msg = (
                f"{self.status.value} (largest force {self.largest_force:.2e} E* a0², tolerance "
                f"{self.tolerance:.2e}, smallest gap {self.smallest_gap:.4f} a0, neighbours displaced "
                f"by up to {self.distortion:.3f} a0, {self.evaluations} evaluations)"
            )
            raise NotConvergedError(msg)
        return self


def read_result(directory: Path) -> DeckResult:
    """What a run of a deck has left in its directory, however it was run.

    Raises
    ------
    LammpsError
        If there is no complete result, or it holds numbers that are not finite.
    """
    directory = Path(directory)
    slab = read_slab(directory / "slab.data")
    try:
        numbers = json.loads((directory / "result.json").read_text(encoding="utf-8"))
        log = (directory / "log.lammps").read_text(encoding="utf-8", errors="replace")
        surface = _read_dump(directory / "surface.dump", slab.ids[0].size)
        state = _read_dump(directory / "state.dump", slab.size)
    except (OSError, ValueError) as error:
        msg = f"{directory} holds no complete result of a run: {error}{tail(directory)}"
        raise LammpsError(msg) from error
    if not (all(map(math.isfinite, numbers.values())) and all(np.isfinite(d).all() for d in (surface, state))):
        msg = f"the result in {directory} holds numbers that are not finite: check separation and start"
        raise LammpsError(msg)
    minimisers = re.findall(r"Iterations, force evaluations = \d+ (\d+)", log)
    evaluations = sum(map(int, minimisers)) + len(re.findall(r"Loop time of .* for 0 steps", log))
    sites = (slab.layers, *slab.shape, 3)
    version = int(numbers.pop("lammps_version"))
    length, force = numbers.pop("length_unit"), numbers.pop("force_unit")
    return DeckResult(
        slab=slab,
        evaluations=evaluations,
        lammps_version=version,
        gap=surface[:, 5].reshape(slab.shape).copy(),
        traction=surface[:, 6].reshape(slab.shape).copy(),
        displacements=state[:, 5:8].reshape(sites) / length,
        forces=state[:, 8:11].reshape(sites) / force,
        **numbers,
    )


def tail(directory: Path, lines: int = 12) -> str:
    """Last lines of the log."""
    try:
        log = (directory / "log.lammps").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
    return "\nLast lines of log.lammps:\n" + "\n".join(log.splitlines()[-lines:])


def _read_dump(path: Path, atoms: int) -> Real:
    """Rows of a dump in the order of the atoms."""
    rows = np.loadtxt(path, skiprows=9, ndmin=2)
    if len(rows) != atoms or not np.array_equal(rows[:, 0], np.arange(1, atoms + 1)):
        msg = f"{path} does not hold the atoms 1 to {atoms} in order"
        raise ValueError(msg)
    return rows
