"""What is measured of `atomistic`: equilibrium of atoms under a rough wall, by our iteration and by LAMMPS alone.

Both start from the same deck, which holds the equilibrium of the linear lattice, and end at the same largest force.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from atomistic.crystal.interatomic import LennardJones, Potential, Springs
from atomistic.crystal.potentials import EmbeddedAtom, find_potential
from atomistic.lammps.deck import Deck
from atomistic.relax.relax import lattice_start, relax
from atomistic.relax.specimen import Specimen
from atomistic.response.material import model_of
from continuum.measure.contact import totals_of
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import solve
from continuum.solve.solution import Settings

__all__ = ["CRYSTALS", "equilibrium"]

SLOPE, AREA = 0.1, 0.1
CRYSTALS = ("springs", "Lennard-Jones", "copper")


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
        return {"evaluations": found.evaluations, "cpu": seconds, "load": found.load, "force": found.largest_force}

    result: dict[str, Any] = {"atoms": specimen.slab.size, "ours": timed(response=response)}
    return result | ({"lammps": timed()} if alone else {})
