"""Friction under one normal load by walls of formulas, of the plugin, and of atoms, over the same rough map.

``python -m docs.studies.friction_of_walls`` prints the table of docs/studies/friction_of_walls.md.  Springs under a
self-affine map, with two seeds of the thermal motion.  The means are over whole periods of the lattice, each of so
many windows that the lateral force is also known as a function of where the wall stands above the sites: its registry.
Expected, before the first run: formulas and plugin make one force to rounding, so that their means differ by their
thermal errors alone, three standard errors at most; on both nothing but the map tells one period from the next.  Atoms
of the wall see those of the surface: in a crystal of the same rows, bent along the map, the lateral force comes and
goes with each period; in one of 17 rows over 16 the forces of its atoms cancel.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import atomistic as a
import continuum as c
from atomistic.front import DeckRun
from atomistic.lammps.deck import WallForce
from atomistic.relax.windows import WindowMean
from continuum.model.fourier import Real

PARTS = 8
"""Windows of one period of the lattice."""
WALLS: dict[str, tuple[WallForce, dict[str, object] | None]] = {
    "formulas": ("formulas", None),
    "plugin": ("plugin", None),
    "atoms, bent": ("atoms", {"form": "bent"}),
    "atoms, bent, 17 rows over 16": ("atoms", {"form": "bent", "rows": [17, 0]}),
}
"""How each wall acts, and its crystal."""


@dataclass(frozen=True)
class Slide:
    """Means while a wall slides."""

    load: WindowMean
    """N/A0, in E*."""
    shear: WindowMean
    """Friction over A0, in E*."""
    friction: WindowMean
    """Friction coefficient."""
    registry: float
    """Half of the way of the lateral force over A0 within a period of the lattice, in E*, mean over the periods."""
    registry_error: float
    """What thermal noise alone would make of it, in E*."""
    height: float
    """Mean separation, in a0."""
    sound: bool
    """Whether each window is of a crystal whose neighbours stay neighbours."""


def by_period(run: DeckRun, name: str) -> Real:
    """A mean of each window, or its standard error, shape (periods, PARTS)."""
    return np.array([getattr(step, name) for step in run.averaged]).reshape(-1, PARTS)


def means(run: DeckRun, run_in: int) -> Slide:
    """Means over the periods after those of running in.

    Their errors are the scatter of the periods or those of their windows, whichever is larger.
    """
    load, shear = (by_period(run, name)[run_in:] for name in ("load", "lateral_x"))
    noise = [by_period(run, f"{name}_error")[run_in:] for name in ("load", "lateral_x")]
    errors = [np.sqrt(np.mean(each**2, axis=1) / PARTS) for each in noise]
    periods = load.mean(axis=1), shear.mean(axis=1)
    wave = shear.mean(axis=0)
    return Slide(
        WindowMean.of(periods[0], errors[0]),
        WindowMean.of(periods[1], errors[1]),
        WindowMean.of_ratio(periods[1], errors[1], periods[0], errors[0]),
        float(np.ptp(wave)) / 2,
        float(np.sqrt(np.mean(noise[1] ** 2) / len(load))),
        float(by_period(run, "separation")[run_in:].mean()),
        run.converged,
    )


def slide(wall: str, seed: int, given: argparse.Namespace, folder: Path) -> Slide:
    """Slide one wall over springs."""
    spectrum = c.SelfAffine(0.8, given.slope, given.lambda_s, 16)
    heights = spectrum.synthesise(c.Grid.square(16), np.random.default_rng(3))
    contact = c.Contact(heights, c.LennardJonesSpline(adhesion_length=given.adhesion_length))
    protocol = {
        "kind": "sliding", "pressure": given.pressure, "velocity": given.velocity, "window": 1 / given.velocity / PARTS,
        "distance": float(given.periods + given.run_in), "temperature": given.temperature, "hold": 2 * PARTS,
        "dwell": PARTS, "seed": seed,
    }  # fmt: skip
    wall_force, crystal = WALLS[wall]
    made = a.deck(
        contact, protocol=protocol, depth=8, follows="atom", wall_force=wall_force, wall_crystal=crystal
    )  # fmt: skip
    return means(a.run_deck(made.write(folder / "deck")), given.run_in)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--slope", type=float, default=0.1)
    parser.add_argument("--lambda-s", type=float, default=8.0)
    parser.add_argument("--adhesion-length", type=float, default=0.002)
    parser.add_argument("--pressure", type=float, default=0.007)
    parser.add_argument("--velocity", type=float, default=0.02)
    parser.add_argument("--temperature", type=float, default=0.0018)
    parser.add_argument("--periods", type=int, default=8)
    parser.add_argument("--run-in", type=int, default=0, help="periods before those of the means")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--walls", nargs="+", choices=WALLS, default=list(WALLS))
    given = parser.parse_args()
    write = sys.stdout.write
    write("| wall | seed | load kept (E*) | friction coefficient | shear stress (E*) | registry (E*) | height (a0) |\n")
    write("|---|---|---|---|---|---|---|\n")
    for wall in given.walls:
        for seed in given.seeds:
            with tempfile.TemporaryDirectory() as folder:
                found = slide(wall, seed, given, Path(folder))
            cells = [f"{mean.mean:.5f} ± {mean.error:.5f}" for mean in (found.load, found.friction, found.shear)]
            cells.append(f"{found.registry:.5f} ± {found.registry_error:.5f}")
            cells.append(f"{found.height:.3f}")
            write(f"| {wall} | {seed} | {' | '.join(cells)} |{'' if found.sound else ' distorted'}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
