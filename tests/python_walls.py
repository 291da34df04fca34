"""Walls that Python evaluates at each step of LAMMPS: what native walls are held against."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from atomistic.lammps.session import Session
from continuum.model.fourier import Real
from continuum.model.walls import Wall


class WallSession(Session):
    """LAMMPS on the atoms of a deck, with forces of Python's on the surface instead of the wall of the deck."""

    _failure: BaseException | None = None

    def run(self, script: str) -> None:
        super().run(script)
        self._raise_failure()

    def command(self, *lines: str) -> None:
        for line in lines:
            super().command(line)
            self._raise_failure()

    def apply(self, forces: Callable[[Real], tuple[Real, float]]) -> None:
        """Let vertical forces act on the surface atoms, in every evaluation from now on.

        Parameters
        ----------
        forces : given the height of each surface atom above the surface at rest, shape (nx, ny), in a0, the force on
            it, positive upwards, same shape, in E* a0², and the energy of all, in E* a0³.
        """
        shape = self.slab.shape
        count = shape[0] * shape[1]

        def callback(_: Any, step: int, local: int, tag: NDArray[np.int64], x: Real, f: Real) -> None:
            try:
                mine = np.flatnonzero(tag <= count)
                site = tag[mine] - 1
                z = np.empty(count)
                z[site] = x[mine, 2] / self.length
                force, energy = forces(z.reshape(shape) - self._rest[0, ..., 2])
                f[...] = 0.0
                f[mine, 2] = force.reshape(-1)[site] * (self.energy / self.length)
                self._lammps.fix_external_set_energy_global("applied", energy * self.energy)
            except BaseException as error:
                self._failure = error

        self.command("fix applied surface external pf/callback 1 1")
        self.command("fix_modify applied energy yes")
        self._lammps.set_fix_external_callback("applied", callback, None)

    def apply_wall(self, wall: Wall, heights: Real, separation: float) -> None:
        """Let any wall law act on the surface atoms; heights, shape (nx, ny), and separation are in a0."""
        if heights.shape != self.slab.shape:
            raise ValueError(f"heights of shape {heights.shape} do not fit a slab of {self.slab.shape} atoms")

        def force(z: Real) -> tuple[Real, float]:
            law = wall.evaluate(separation + heights - z)
            # A surface atom stands for the area a0².
            return -law.traction, float(np.sum(law.energy))

        self.apply(force)

    def _raise_failure(self) -> None:
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure
