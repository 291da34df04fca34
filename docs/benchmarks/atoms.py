"""What is measured of `atomistic`: equilibrium of atoms under a rough wall, by our iteration and by LAMMPS alone, and
what a wall costs.

Both start from the same deck, which holds the equilibrium of the linear lattice, and end at the same largest force.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any, Literal

import numpy as np

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.model import Potential
from atomistic.crystal.potentials import EmbeddedAtom, find_potential
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.shape import HeightSpline, Round
from atomistic.relax.relax import lattice_start, relax
from atomistic.relax.specimen import Specimen
from atomistic.response.material import model_of
from continuum.measure.contact import totals_of
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.surface import SelfAffine
from continuum.model.surfaces import sphere
from continuum.model.walls import InversePowers, LennardJonesSpline, Wall
from continuum.model.walls.tabulated import TabulatedWall
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from tests.python_walls import WallSession

__all__ = ["CRYSTALS", "WALLS", "equilibrium", "wall"]

SLOPE, AREA = 0.1, 0.1
CRYSTALS = ("springs", "Lennard-Jones", "copper")
WALLS = (
    "none",
    "spline",
    "9-3",
    "table of 1000 rows",
    "spline, following",
    "spline, any map",
    "spline, plugin",
    "any map, plugin",
    "spline, in Python",
)
"""Whose forces are timed: laws as formulas of LAMMPS, the wall a function of the site unless it says so."""


def _potential(crystal: str) -> Potential:
    if crystal == "springs":
        return Springs()
    return LennardJones() if crystal == "Lennard-Jones" else EmbeddedAtom.read(find_potential("Cu_mishin1.eam.alloy"))


def equilibrium(n: int, crystal: str, adhesion_length: float, alone: bool) -> dict[str, Any]:
    """Evaluations of the forces and CPU seconds to a largest force of 1e-8 h'rms, from deck to certified equilibrium.

    Parameters
    ----------
    n : surface atoms a side; the slab is as deep.
    alone : whether LAMMPS' minimisers go the same way too.
    """
    specimen = Specimen.of_model(model_of(_potential(crystal)), Grid.square(n), float(n))
    response, grid = specimen.response, specimen.slab.grid
    heights = SelfAffine(0.8, SLOPE, 8.0, n / 2).synthesise(grid, np.random.default_rng(2))
    wall = LennardJonesSpline(adhesion_length=adhesion_length)
    problem = ContactProblem(grid, wall, heights, response)
    low, high = 1 - 6 * heights.std(), 1 - heights.min() + wall.range
    for _ in range(14):
        separation = (low + high) / 2
        state = solve(problem, "separation", separation, Settings(1e-9 * SLOPE))
        low, high = (low, separation) if totals_of(grid, wall, state.gap).area_rep < AREA else (separation, high)
    start = lattice_start(response, wall, state.gap)
    deck = Deck(specimen.slab, specimen.model, wall, heights, separation, start, 1e-8 * SLOPE, rise=response.rise)

    def timed(**way: Any) -> dict[str, Any]:
        with tempfile.TemporaryDirectory() as folder:
            began = time.process_time()
            found = relax(deck, Path(folder), **way).require()
            seconds = time.process_time() - began
        return {"evaluations": found.evaluations, "cpu": seconds, "load": found.force, "force": found.largest_force}

    result: dict[str, Any] = {"atoms": specimen.slab.size, "ours": timed(response=response)}
    return result | ({"lammps": timed()} if alone else {})


def wall(n: int, kind: str, evaluations: int = 50, runs: int = 6) -> dict[str, Any]:
    """CPU seconds per evaluation of the forces on springs under a sphere in contact: the least of several runs.

    Parameters
    ----------
    n : surface atoms a side; the slab is as deep.
    kind : one of :data:`WALLS`.
    evaluations : of each run, after some that are not timed.
    runs : the least time is that of the work; the rest is what else the machine does.
    """
    grid = Grid.square(n)
    slab = Slab.of_depth(grid, float(n))
    law: Wall = LennardJonesSpline(adhesion_length=0.005)
    if kind == "9-3":
        law = InversePowers((9, 3), adhesion_length=0.02)
    if kind.startswith("table"):
        gap = np.linspace(0.7, 1.0 + law.range, 1000)
        law = TabulatedWall(gap, np.append(law.evaluate(gap[:-1]).traction, 0.0))
    heights, separation = sphere(grid, 4.0 * n), 0.98
    shapes = {"spline, following": Round(grid.lengths, 4.0 * n), "spline, any map": HeightSpline(heights)}
    shapes["any map, plugin"] = shapes["spline, any map"]
    shape = shapes.get(kind)
    by: Literal["formulas", "plugin"] = "plugin" if kind.endswith("plugin") else "formulas"
    deck = Deck(slab, Springs(), law, heights, separation, shape=shape, wall_force=by)
    with tempfile.TemporaryDirectory() as folder, WallSession(write_deck(Path(folder), deck)) as session:
        if kind == "spline, in Python":
            session.apply_wall(law, heights, separation)
        elif kind != "none":
            session.command(f"variable separation equal {separation}")
            session.run("in.wall")
        session.command("thermo 1000000")
        session.command(f"run {evaluations} post no")
        seconds = []
        for _ in range(runs):
            began = time.process_time()
            session.command(f"run {evaluations} pre no post no")
            seconds.append(time.process_time() - began)
        return {"atoms": slab.size, "cpu": min(seconds) / evaluations}
