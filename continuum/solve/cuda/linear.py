"""The engine of a coarse step on NVIDIA GPUs: all of it is started at once, and one state is read."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.solve.backend import all_modes
from continuum.solve.cuda.device import Array, pinned, to_device
from continuum.solve.cuda.engine import KERNELS, CudaEngine
from continuum.solve.cuda.relax import MOVED, PAIRS, RUNS, STATE
from continuum.solve.cuda.sums import wait_for


class LinearArrays(NamedTuple):
    """The arrays of one grid, and the engine that they belong to."""

    engine: CudaLinearEngine
    g: Array
    d: Array
    x: Array
    stiffness: Array
    direction: Array


class CudaLinearEngine(CudaEngine):
    """What :class:`continuum.solve.backend.LinearEngine` asks for, in double precision.

    The scalars of a descent stay on the device, so that nothing is waited for between its first launch and its last.
    What is started, and in which order, depends on the grids only.

    Parameters
    ----------
    grid, K, below : as for :class:`CudaEngine`.
    smooth : the engine of the nonlinear problem of the same grid, whose transforms and memory for sums are used.
    """

    _states: Array = None

    def __init__(self, grid: Grid, K: Real, below: Grid | None, smooth: CudaEngine) -> None:
        super().__init__(grid, K, below, smooth)

    def fields(self, spectra: tuple[Array, Array, Array]) -> tuple[Array, Array, Array, Array, Array]:
        return *spectra, self.single_rows(), self.rows()

    def level(self, g: Array, d: Array, x: Array, stiffness: Array, direction: Array) -> LinearArrays:
        return LinearArrays(self, g, d, x, stiffness, direction)

    def relax(
        self, levels: tuple[LinearArrays, ...], depth: int, shift: float, iterations: int, reduction: float
    ) -> tuple[bool, list[int]]:
        if self._states is None:
            self._states = to_device(np.zeros((len(levels), STATE)))
            self._always = to_device(np.eye(1, STATE, RUNS)[0])
            self._read = pinned(len(levels), STATE)
            self._read[:, PAIRS] = 0.0
        how = {"c0": shift, "iterations": iterations, "reduction": reduction}
        _start(levels[:depth], [self._states[k] for k in range(len(levels))], self._always, how)
        before = self._read[:, PAIRS].copy()
        wait_for(self._states, self._read)
        return bool(self._read[0, MOVED]), [2 * int(count) for count in self._read[:, PAIRS] - before]

    def launch(self, name: str, rows: int, **given: Any) -> None:
        """Start a kernel; if it leaves parts of sums they lie in the memory of the engine."""
        kernel = KERNELS[name]
        arguments = [given[key] if key in given else self._own[key] for key in kernel.needs]
        kernel(rows, *arguments, *([self.reduction.parts] if kernel.summed else []))

    def decide(self, name: str, after: str, rows: int, **given: Any) -> None:
        """Start what adds the parts that a kernel over so many rows has left, and sets a state."""
        sums = {"parts": self.reduction.parts, "count": KERNELS[after].blocks(rows), "totals": self.reduction.totals}
        self.launch(name, 1, per_point=self.per_point, **sums, **given)


def _start(levels: tuple[LinearArrays, ...], states: list[Array], above: Array, how: dict[str, Any]) -> None:
    """Start the descent on a grid and, for each of its steps, those on the coarser ones."""
    level, state, coarse = levels[0], states[0], len(levels) > 1
    engine, rows = level.engine, level.engine.grid.shape[0]
    given = {"g": level.g, "d": level.d, "x": level.x, "state": state}
    given |= {} if coarse else all_modes(how["c0"])
    engine.launch("begin", rows, direction=level.direction, above=above, **given)
    for iteration in range(how["iterations"]):
        first = int(iteration == 0)
        if not first:
            engine.transform.forward(engine.w)
        engine.launch("linear_gradient", rows, **given)
        engine.decide(
            "decide_gradient", "linear_gradient", rows,
            state=state, first=first, reduction=how["reduction"], alone=int(not coarse),
        )  # fmt: skip
        if coarse:
            _start_coarser(levels, states, how, given, first=bool(first))
        engine.transform.inverse(engine.w)
        turned = {"d": level.direction, "stiffness": level.stiffness, "state": state}
        engine.launch("linear_turn", rows, **turned)
        engine.decide("decide_turn", "linear_turn", rows, state=state)
    engine.launch("linear_last", rows, **given)


def _start_coarser(
    levels: tuple[LinearArrays, ...], states: list[Array], how: dict[str, Any], given: dict[str, Any], *, first: bool
) -> None:
    """The step of the coarser grid, within one of a grid."""
    level, below = levels[:2]
    engine, state, low = level.engine, states[0], 2 * level.engine.low_part["low_rows"] - 1
    rows = below.engine.grid.shape[0]
    if first:  # the wall stays what it is
        below.engine.launch("sampled", rows, fine=level.stiffness, out=below.stiffness)
    below.engine.launch("linear_restrict", rows, coarse=below.g, fine=level.g, above=state)
    _start(levels[1:], states[1:], state, how)
    given = given | {"c0": how["c0"]}
    engine.launch("linear_low_modes", low, e=below.x, **given)
    engine.decide("decide_low_modes", "linear_low_modes", low, state=state, below=states[1])
    engine.launch("linear_low_gradient", low, **given)
    engine.decide("decide_low_gradient", "linear_low_gradient", low, state=state)
    engine.launch("linear_low_direction", low, **given)
