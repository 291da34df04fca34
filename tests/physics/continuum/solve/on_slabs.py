"""States on several devices, printed as JSON: ``python -m tests.physics.continuum.solve.on_slabs SHARDS WALL...``."""

import json
import sys
from collections.abc import Sequence
from functools import partial

import numpy as np

from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.model.walls.inverse_powers import LennardJones126
from continuum.solve.backend import back_end
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver

POINTS = 128


def states(device: str, shards: int, walls: Sequence[str]) -> dict[str, list[float]]:
    """Iterations, FFT pairs, relative load, elastic energy and closed points of states."""
    grid = Grid.square(POINTS)
    heights = SelfAffine(0.8, 0.1, 16.0, POINTS / 4).synthesise(grid, np.random.default_rng(1))
    vars(back_end(device, shards))["SMALLEST"] = POINTS // 2  # one coarser grid
    solver = Solver(grid, HalfSpace("clamped").stiffness(grid), device=device, shards=shards)
    held = {"lift": -0.3 * float(heights.min()), "mean_stiffness": np.inf}
    settings = Settings(1e-9)
    soft, stiff = LennardJonesSpline(adhesion_length=0.005).law, LennardJones126(adhesion_length=0.02).law
    solved = {
        "law": partial(solver.minimise, soft, heights, None, settings, **held | {"lift": held["lift"] + 1}),
        "stiff": partial(solver.minimise, stiff, heights, heights + 2.0, settings, **held | {"lift": held["lift"] + 1}),
        "hard": partial(solver.constrain, heights, None, settings, **held),
    }
    found = {}
    for name in walls:
        state = solved[name]().require()
        load = float(state.traction.mean()) / float(np.abs(state.traction).mean())
        energy = solver.elastic_energy(heights, state)
        found[name] = [state.iterations, state.fft_pairs, load, energy, int((state.gap == 0).sum())]
    return found


if __name__ == "__main__":
    print(json.dumps(states("jax", int(sys.argv[1]), sys.argv[2:])))  # noqa: T201
