"""What a validation and a deck will take, from their inputs alone.

The counts and times, in ``cost.toml``, are those of the inputs of the project, which they meet to a factor of two, on a
core of an AMD EPYC (docs/benchmarks.md).  They are not scaled to this machine: forces do not go with the time of a
transform.
"""

import tomllib
from dataclasses import dataclass
from importlib import resources

from atomistic.config.deck import DeckConfig
from atomistic.config.validate import ValidateConfig
from atomistic.crystal.crystal import Slab
from atomistic.ladder.comparison import paths_of
from atomistic.lammps.shape import has_formula
from atomistic.relax.specimen import BYTES, BYTES_PER_ATOM
from continuum.model.grid import Grid

_SEEN = tomllib.loads(resources.files("atomistic.ladder").joinpath("cost.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class AtomsCost:
    """What an input will take, to within a factor of about two."""

    atoms: int
    """Atoms of the slab, roughly: how far forces reach is known when the crystal has been measured."""
    equilibria: int
    """Equilibria of atoms, or windows of time."""
    evaluations: int
    """Evaluations of all forces."""
    seconds: float
    """Core-seconds."""
    memory: int
    """Peak of a process, in bytes."""


def _atoms(n: int, depth: float, reach: int) -> int:
    return n * n * Slab.of_depth(Grid.square(n), depth, reach).layers


def cost_of_validation(config: ValidateConfig) -> AtomsCost:
    """Cost of ``atomistic validate``."""
    seen = _SEEN[config.interatomic.kind]
    atoms = _atoms(config.slab.n, config.slab.depth, seen["layers"])
    paths = paths_of(config)
    # Beside a jump-in: before and after it, on both branches.
    states = sum(4 if path.jump else len(path.areas) * len(path.branches) for path in paths)
    relaxed = [seen]
    if config.interatomic.kind != "springs":  # springs under the same wall tell how much of a difference is geometry
        relaxed.append(_SEEN["springs"])
    each = sum(kind["equilibrium"] for kind in relaxed)
    evaluations = states * sum(kind["evaluations"] for kind in relaxed)
    seconds = states * atoms * each + len(paths) * _SEEN["path"] * config.slab.n**2
    return AtomsCost(atoms, states, evaluations, seconds, int(BYTES + BYTES_PER_ATOM * atoms))


def cost_of_deck(config: DeckConfig) -> AtomsCost:
    """Cost of running the deck of ``atomistic deck`` in LAMMPS."""
    seen = _SEEN[config.interatomic.kind]
    atoms = _atoms(config.slab.n, config.slab.depth, seen["layers"])
    protocol = config.protocol
    windows = None if protocol is None else protocol.windows()
    if windows is not None:
        steps = tried = len(windows.duration)
        evaluations = round(sum(windows.duration) / _SEEN["time_step"])
    else:
        steps = 1 if protocol is None else len(protocol.steps().values)
        tried = steps * (_SEEN["to_a_pressure"] if config.steps().control == "mean-pressure" else 1)
        evaluations = round(tried * _SEEN["per_side"] * max(config.slab.n, config.slab.depth))
    wall = _SEEN["table" if config.wall.law == "table" else "formula"]
    if config.follows == "atom":
        wall += _SEEN["following" if has_formula(config.surface) else "map"]
    if config.wall_force != "formulas":
        wall = _SEEN[config.wall_force]
    seconds = evaluations * (seen["evaluation"] * atoms + wall * config.slab.n**2) + (1 + tried / 4) * _SEEN["start"]
    return AtomsCost(atoms, steps, evaluations, seconds, int(BYTES + BYTES_PER_ATOM * atoms))
