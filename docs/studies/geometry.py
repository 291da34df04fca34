"""Perimeter, chord and area of shapes that are known: discs and Hertz contacts, quoted in docs/model.md.

``python -m docs.studies.geometry``: a minute on one core.  Rough contacts are sweeps: inputs/sweep/figure-s2.toml,
figure3.toml, gap-profile.toml and pull-off.toml.
"""

from __future__ import annotations

import sys

import numpy as np

from continuum.measure.outline import areas, outline
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.model.walls import HardWall
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver
from continuum.store.sheet import Sheet


def discs() -> Sheet:
    """Perimeter and chord of discs against exact values."""
    rng, rows = np.random.default_rng(1), []
    for radius in (2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0):
        found = []
        for _ in range(40):
            grid = Grid.square(int(2 * radius) + 9)
            x, y = grid.positions
            middle = grid.lengths[0] / 2 + rng.random(2)
            rim = outline(grid, np.hypot(x - middle[0], y - middle[1]) < radius)
            exact, chord = 2 * np.pi * radius, np.pi * radius / 2
            lengths = [rim.perimeter("paper") / exact, rim.perimeter("exact") / exact, rim.perimeter("edges") / exact]
            found.append([*lengths, rim.chord / chord, rim.area / (np.pi * radius**2)])
        rows.append([f"{radius:g}", *(f"{v:.4f}" for v in np.mean(found, axis=0))])
    return Sheet.of("discs", ["R/a0", "P, 1.1222", "P, 1.1107", "P, edges", "chord", "area"], rows)


def hertz() -> Sheet:
    """Areas of a Hertz contact of a hard wall, by definition, over the exact one; mean and scatter over positions."""
    rng, rows = np.random.default_rng(1), []
    for a in (2.0, 4.0, 8.0, 16.0):
        grid, radius, found = Grid.square(int(12 * a)), 12.5 * a, []
        stiffness_q, (x, y) = HalfSpace("free").stiffness(grid), grid.positions
        for _ in range(16):
            middle = grid.lengths[0] / 2 + rng.random(2)
            heights = ((x - middle[0]) ** 2 + (y - middle[1]) ** 2) / (2 * radius)
            pressure = 4 * a**3 / (3 * radius) / grid.area
            state = Solver(grid, stiffness_q).constrain(heights, None, Settings(1e-7), pressure=pressure)
            got, exact = areas(grid, HardWall(), state.gap), np.pi * a**2 / grid.area
            found.append([got.repulsive, got.corrected, got.interior, got.dilated, got.uncertainty])
        mean, scatter = np.mean(found, axis=0) / exact, np.std(found, axis=0) / exact
        rows.append(
            [f"{a:g}", *(f"{m:.3f} ± {s:.3f}" for m, s in zip(mean[:4], scatter, strict=False)), f"{mean[4]:.3f}"]
        )
    heads = ["a/a0", "cells", "corrected", "interior", "dilated", "stated uncertainty"]
    return Sheet.of("contacts of Hertz", heads, rows)


if __name__ == "__main__":
    for sheet in (discs(), hertz()):
        sys.stdout.write(f"{sheet.markdown()}\n\n")
