"""Estimate the cost of a validation and of a deck from their inputs.

The counts and times in ``cost.toml`` were fitted to the inputs of the project, within a factor of two, on a core of an
AMD EPYC (docs/benchmarks.md).  They are not scaled to this machine, as the time of forces does not follow that of a
transform.
"""

import tomllib
from dataclasses import dataclass
from importlib import resources

import numpy as np

from atomistic.crystal.crystal import LAYER_SPACING, Slab
from atomistic.crystal.faces import PIECE, cell_of
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder.comparison import paths_of
from atomistic.lammps.law import felt, in_formula, law_of_atoms
from atomistic.lammps.shape import has_formula
from atomistic.relax.specimen import BYTES, BYTES_PER_ATOM
from continuum.model.grid import Grid

_SEEN = tomllib.loads(resources.files("atomistic.ladder").joinpath("cost.toml").read_text(encoding="utf-8"))

LARGE = 100_000
"""Number of atoms from which on writing a deck takes a second or more: its cost and progress are told."""


@dataclass(frozen=True)
class AtomsCost:
    """Cost of an input, within a factor of about two."""

    atoms: int
    """Approximate number of atoms: the range of forces is known only once the crystal has been measured."""
    equilibria: int
    """Number of equilibria of atoms, or of time windows."""
    evaluations: int
    """Number of force evaluations."""
    seconds: float
    """Core-seconds."""
    memory: int
    """Peak memory of a process, in bytes."""


def _atoms(points: tuple[int, int], depth: float, reach: int) -> int:
    return points[0] * points[1] * Slab.of_depth(Grid.square(8), depth, reach).layers


def _atoms_below(config: DeckConfig) -> int:
    """Number of atoms of a slab other than fcc(100), whose a0 follows from the volume that its potential names."""
    table = config.crystal
    if table.given is not None:
        return len(table.given)
    cell, potential = cell_of(table.lattice, table.face), config.interatomic.potential()
    reach = potential.force_range / np.cbrt((potential.guess or potential.cutoff**3 / 8) / cell.volume)
    wide = np.array(config.grid.lengths)
    piece = cell.slab(tuple(np.minimum(wide, PIECE)), config.slab.depth, float(reach), table.skin)
    return round(piece.size * float(np.prod(wide / piece.lengths)))


def told_of_writing(config: DeckConfig) -> str:
    """Time and memory that a large deck takes to be made and written; empty for a small one."""
    given = config.crystal.given
    # The density of fcc, before any crystal has been measured.
    atoms = np.sqrt(2) * np.prod(config.grid.lengths) * config.slab.depth if given is None else len(given)
    if atoms < LARGE:
        return ""
    seconds, memory = _SEEN["written"] * atoms, BYTES + _SEEN["bytes_written"] * atoms
    return f"about {atoms:.2g} atoms: {seconds:.2g} core-seconds and {memory / 1e9:.2g} GB to write them"


def cost_of_validation(config: ValidateConfig) -> AtomsCost:
    """Cost of ``atomistic validate``."""
    seen = _SEEN[config.interatomic.kind]
    atoms = _atoms(config.slab.points, config.slab.depth, seen["layers"])
    paths = paths_of(config)
    # Around a jump-in: before and after it, on both branches.
    states = sum(4 if path.jump else len(path.areas) * len(path.branches) for path in paths)
    relaxed = [seen]
    if config.interatomic.kind != "springs":  # springs under the same wall give the geometric part of a difference
        relaxed.append(_SEEN["springs"])
    each = sum(kind["equilibrium"] for kind in relaxed)
    evaluations = states * sum(kind["evaluations"] for kind in relaxed)
    seconds = states * atoms * each + len(paths) * _SEEN["path"] * config.slab.n**2
    return AtomsCost(atoms, states, evaluations, seconds, int(BYTES + BYTES_PER_ATOM * atoms))


def reached(config: DeckConfig, atoms: int) -> int:
    """Number of atoms, of all, that the law of a deck reaches in contact: the uppermost layers, more for 9-3."""
    surface, law = config.grid.shape[0] * config.grid.shape[1], law_of_atoms(config.wall, LAYER_SPACING)
    return round(min(atoms, surface * (1 + (felt(law) - law.zero_gap) // LAYER_SPACING)))


def _of_wall(config: DeckConfig, atoms: int) -> float:
    """Core-seconds of the wall in each evaluation of the forces."""
    if config.wall_force != "formulas":
        return float(_SEEN[config.wall_force] * config.grid.shape[0] * config.grid.shape[1])
    each = _SEEN["formula"]
    if config.follows == "atom":
        each += _SEEN["following" if has_formula(config.surface) else "map"]
    once = 0.0 if in_formula(law_of_atoms(config.wall, LAYER_SPACING)) else _SEEN["pieces"]
    return float(each * reached(config, atoms) + once)


def cost_of_deck(config: DeckConfig) -> AtomsCost:
    """Cost of running the deck of ``atomistic deck`` in LAMMPS."""
    seen = _SEEN[config.interatomic.kind]
    points = config.grid.shape
    atoms = _atoms(points, config.slab.depth, seen["layers"]) if config.crystal.own else _atoms_below(config)
    steps = config.steps()
    if steps.motion is not None:
        durations = steps.motion.windows[-1]
        count = tried = len(durations)
        evaluations = round(sum(durations) / _SEEN["time_step"])
    else:
        count = len(steps.values)
        tried = count * (_SEEN["to_a_pressure"] if steps.control == "mean-pressure" else 1)
        evaluations = round(tried * _SEEN["per_side"] * max(*points, config.slab.depth))
    seconds = evaluations * (seen["evaluation"] * atoms + _of_wall(config, atoms)) + (1 + tried / 4) * _SEEN["start"]
    return AtomsCost(atoms, count, evaluations, seconds, int(BYTES + BYTES_PER_ATOM * atoms))
