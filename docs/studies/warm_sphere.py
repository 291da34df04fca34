"""A sphere above silver and copper at 300 K: load of the atoms against that of their quasi-harmonic lattice response.

``python -m docs.studies.warm_sphere`` prints the table of docs/studies/warm_sphere.md.  Of the quasi-harmonic theory
the mean traction on a site is that of the wall averaged over the site's thermal motion up and down, a Gaussian of
variance k_B T G_zz(0), with G of the lattice at rest; the mean displacement is the linear response to it.  Cell, base
and the surface from which separations count are those at 300 K, as the deck has them.  Expected, before the first run:
the same load within two standard errors, as elastic constants that soften by some percent change it by less.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import atomistic as a
import continuum as c
from atomistic.front.functions import DeckRun
from atomistic.lammps.trace import WindowMean
from continuum.model.problem import ContactProblem
from continuum.model.substrates import TabulatedSubstrate
from continuum.model.walls import Wall
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from continuum.store.sheet import Sheet
from docs.studies.tables import keep

POTENTIALS = {"silver": "Ag_u3.eam", "copper": "Cu_mishin1.eam.alloy"}
SEPARATION, RADIUS, ADHESION_LENGTH = 1.1, 40.0, 0.005


@dataclass(frozen=True)
class Warm:
    """Load over A0, in E*."""

    atoms: WindowMean
    theory: float
    """Quasi-harmonic, at 300 K."""
    at_rest: float
    """The lattice response at 0 K, at the same separation."""


def averaged(wall: Wall, variance: float) -> c.TabulatedWall:
    """The law whose traction is that of a wall averaged over a Gaussian motion of the surface, as a table."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(40)
    gaps = np.linspace(0.3, wall.zero_gap + wall.range + 6 * np.sqrt(variance), 400)
    shifted = gaps[:, None] + np.sqrt(variance) * nodes
    traction = wall.evaluate(shifted).traction @ weights / np.sqrt(2 * np.pi)
    traction[-1] = 0.0
    return c.TabulatedWall(gaps, traction)


def theory(run: DeckRun, wall: Wall) -> float:
    """Load over A0 of the lattice response at the separation of a run, in E*."""
    grid = run.last.slab.grid
    assert run.stiffness is not None
    substrate = TabulatedSubstrate(run.stiffness, grid.lengths, "the slab")
    problem = ContactProblem(grid, wall, run.heights, substrate)
    return solve(problem, "separation", SEPARATION, Settings(1e-9)).require().load


def variance(run: DeckRun) -> float:
    """Of the thermal motion of a surface atom up and down: k_B T G_zz at the atom itself, in a0²."""
    grid, stiffness = run.last.slab.grid, run.stiffness
    assert stiffness is not None
    return run.description.temperature * float(np.sum(grid.mode_weights / stiffness)) / grid.size


def compare(metal: str, seed: int, n: int, depth: float, dwell: int, folder: Path) -> Warm:
    """Run a deck of a metal, and its theory."""
    wall = c.LennardJonesSpline(adhesion_length=ADHESION_LENGTH)
    contact = c.Contact(c.sphere(c.Grid.square(n), RADIUS), wall)
    protocol = {
        "kind": "velocity", "separations": [SEPARATION], "temperature": "300K", "window": 50.0, "hold": 2,
        "dwell": dwell, "seed": seed,
    }  # fmt: skip
    model = a.EmbeddedAtom.read(a.find_potential(POTENTIALS[metal]))
    directory = a.deck(contact, model, protocol=protocol, depth=depth).write(folder / f"{metal}-{seed}")
    run = a.run_deck(directory)
    return Warm(run.mean("load"), theory(run, averaged(wall, variance(run))), theory(run, wall))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", type=int, default=16, help="atoms a side")
    parser.add_argument("--depth", type=float, default=12.0, help="of the slab, in a0")
    parser.add_argument("--dwell", type=int, default=8, help="windows that are averaged")
    parser.add_argument("--seeds", type=int, default=2)
    given = parser.parse_args()
    heads = ("metal", "seed", "N/A0, atoms (E*)", "theory at 300 K", "theory at 0 K",
             "atoms less theory, standard errors")  # fmt: skip
    rows = []
    for metal in POTENTIALS:
        for seed in range(1, given.seeds + 1):
            with tempfile.TemporaryDirectory() as folder:
                found = compare(metal, seed, given.n, given.depth, given.dwell, Path(folder))
            atoms = found.atoms
            off = f"{(atoms.mean - found.theory) / atoms.error:+.1f} {atoms.doubts}".rstrip()
            rows.append((
                metal, seed, f"{atoms.mean:.5f} ± {atoms.error:.5f}", f"{found.theory:.5f}", f"{found.at_rest:.5f}",
                off,
            ))  # fmt: skip
    keep("warm_sphere", Sheet.of("warm sphere", heads, rows))


if __name__ == "__main__":
    main()
