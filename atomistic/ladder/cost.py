"""What a validation and a deck will take, from their inputs alone.

The counts and times are those of the inputs of the project, which they meet to a factor of two, on a core of an AMD
EPYC (docs/benchmarks.md).  They are not scaled to this machine: forces do not go with the time of a transform.
"""

from __future__ import annotations

from dataclasses import dataclass

from atomistic.config.deck import DeckConfig
from atomistic.config.validate import ValidateConfig
from atomistic.crystal.crystal import Slab
from atomistic.ladder.comparison import paths_of
from atomistic.relax.specimen import BYTES, BYTES_PER_ATOM
from continuum.model.grid import Grid

# By kind of interatomic model: core-seconds per atom of an evaluation of the forces, and of an equilibrium by the
# iteration that the lattice preconditions; layers that forces reach; evaluations of such an equilibrium.  From
# docs/benchmarks.md, and from the decks of inputs/lammps.
_KINDS = {
    "springs": (2.1e-7, 2e-5, 1, 10),
    "lennard-jones": (5e-7, 3.2e-5, 3, 18),
    "eam": (1.2e-6, 3.2e-5, 6, 15),
    "pair-style": (4e-6, 1.5e-4, 6, 15),
}
_PER_SIDE = 14  # evaluations of LAMMPS' minimisers per atom along the longest side of the slab
_TO_A_PRESSURE = 4  # separations that are tried until a pressure is met
_TIME_STEP = 0.037  # of a motion, in a0 (m/(E* a0³))^(1/2): a thirtieth of the shortest period
_PATH = 2e-3  # core-seconds of the path on the lattice, and of the other rungs beside it, per surface atom
_START = 0.3  # core-seconds to start LAMMPS and to write and read its files; a quarter of it for each further step


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
    _, each, reach, per = _KINDS[config.interatomic.kind]
    atoms = _atoms(config.slab.n, config.slab.depth, reach)
    paths = paths_of(config)
    # Beside a jump-in: before and after it, on both branches.
    states = sum(4 if path.jump else len(path.areas) * len(path.branches) for path in paths)
    if config.interatomic.kind != "springs":  # springs under the same wall tell how much of a difference is geometry
        each, per = each + _KINDS["springs"][1], per + _KINDS["springs"][3]
    seconds = states * atoms * each + len(paths) * _PATH * config.slab.n**2
    return AtomsCost(atoms, states, states * per, seconds, int(BYTES + BYTES_PER_ATOM * atoms))


def cost_of_deck(config: DeckConfig) -> AtomsCost:
    """Cost of running the deck of ``atomistic deck`` in LAMMPS."""
    evaluation, _, reach, _ = _KINDS[config.interatomic.kind]
    atoms = _atoms(config.slab.n, config.slab.depth, reach)
    protocol = config.protocol
    windows = None if protocol is None else protocol.windows()
    if windows is not None:
        durations = windows.duration
        evaluations, tried = round(sum(durations) / _TIME_STEP), len(durations)
        seconds = evaluations * evaluation * atoms + (1 + tried / 4) * _START
        return AtomsCost(atoms, tried, evaluations, seconds, int(BYTES + BYTES_PER_ATOM * atoms))
    steps = 1 if protocol is None else len(protocol.steps().values)
    tried = steps * (_TO_A_PRESSURE if config.steps().control == "mean-pressure" else 1)
    evaluations = round(tried * _PER_SIDE * max(config.slab.n, config.slab.depth))
    seconds = evaluations * evaluation * atoms + (1 + tried / 4) * _START
    return AtomsCost(atoms, steps, evaluations, seconds, int(BYTES + BYTES_PER_ATOM * atoms))
