"""States of a deck at rest, relaxed by the package before LAMMPS runs the deck, which then only confirms them.

A wall of the lattice sites above fcc(100) is relaxed with the response of its lattice
(:func:`atomistic.relax.relax.iterate`), any other with a response that is measured
(:class:`atomistic.atoms.relaxation.GreensRelaxation`).  The crystal's forces are LAMMPS', those of the wall the law of
:mod:`continuum`; of a wall of atoms, all forces are LAMMPS'.
"""

import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from math import ceil
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal, cast

import numpy as np
from ase import Atoms
from ase.calculators.calculator import Calculator, all_changes
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms

from atomistic.atoms.relaxation import GreensRelaxation
from atomistic.atoms.response import SlabResponse
from atomistic.atoms.wall import RoughWall
from atomistic.crystal.crystal import Slab, distortion, slipped
from atomistic.crystal.model import AnyModel, check_model
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import Progress
from atomistic.lammps.protocol import LOAD_TOLERANCE
from atomistic.lammps.result import LARGEST_DISTORTION
from atomistic.lammps.session import Cell, LammpsHandle, Session
from atomistic.lammps.shape import HeightSpline, WallHeight, heights_of_shape
from atomistic.relax.relax import iterate
from atomistic.relax.specimen import Specimen
from continuum.inputs.arguments import ArgumentError
from continuum.model.fourier import Real

_MOST = 200
"""Largest number of evaluations of a state."""
_MOVES, _FARTHEST = 40, 0.2
"""Number of moves of the wall in search of a load, and the largest, in a0, as those of the deck."""


@dataclass(frozen=True, eq=False)
class _State:
    """A state at a separation, relaxed or not."""

    separation: float
    displacements: Real
    pressure: float
    """Mean traction, in E*."""
    evaluations: int
    converged: bool


_Relax = Callable[[float, Real], _State]
"""The state at a separation, from given displacements."""


def with_starts(deck: Deck, progress: Progress | None = None) -> Deck:
    """The deck with relaxed starts of its steps, up to the first that is no equilibrium of the crystal as it was.

    Parameters
    ----------
    deck : one equilibrium, or a protocol of several.
    progress : called after each state with the number of relaxed ones and of all.

    Raises LammpsError if LAMMPS fails.
    """
    protocol = deck.protocol
    steps, found = 1 if protocol is None else protocol.steps, list[_State]()
    with ExitStack() as still_open:
        sites = deck.slab.one_to_one and deck.shape is None
        relax = _by_lattice(deck) if sites else _by_atoms(deck, still_open)
        for state in _followed(deck, relax):
            if not (state.converged and _as_it_was(deck, state.displacements)):
                break
            found.append(state)
            if progress is not None:
                progress(len(found), steps)
    note = (
        f"Starts: {len(found)} of {steps} states were relaxed before LAMMPS, with "
        f"{sum(state.evaluations for state in found)} evaluations of the forces."
    )
    if protocol is not None:
        met = tuple(state.separation for state in found)
        protocol = replace(protocol, separations=(*met, *protocol.separations[len(met) :]))  # type: ignore[type-var]
    first = deck.separation if protocol is None else protocol.separations[0]
    starts = tuple(state.displacements for state in found)
    return replace(deck, protocol=protocol, separation=first, starts=starts, notes=(*deck.notes, note))


def _followed(deck: Deck, relax: _Relax) -> Iterator[_State]:
    """The states of the steps, each relaxed from the one before."""
    protocol, at = deck.protocol, deck.start
    for step, separation in enumerate([deck.separation] if protocol is None else protocol.separations):
        sought = None if protocol is None else protocol.sought(step)
        state = relax(separation, at) if sought is None else _under(relax, *sought, separation, at)
        yield state
        at = state.displacements


def _under(relax: _Relax, pressure: float, stiffness: float, separation: float, start: Real) -> _State:
    """The state under a mean pressure: the wall is moved by the secant rule, as the deck itself moves it."""
    before, evaluations = None, 0
    for _ in range(_MOVES):
        state = relax(separation, start)
        evaluations += state.evaluations
        miss = state.pressure - pressure
        met = abs(miss) <= LOAD_TOLERANCE / 2 * abs(pressure)
        if met or not state.converged:
            break
        slope = -stiffness
        if before is not None and state.separation != before.separation:
            slope = min((state.pressure - before.pressure) / (state.separation - before.separation), 0.0) or slope
        before, start = state, state.displacements
        separation += float(np.clip(-miss / slope, -_FARTHEST, _FARTHEST))
    return replace(state, evaluations=evaluations, converged=state.converged and met)


def _as_it_was(deck: Deck, displacements: Real) -> bool:
    """True if atoms have the neighbours that they have at rest."""
    changed = deck.model.atom_style != "bond" and slipped(deck.slab, displacements).any()
    return not changed and distortion(deck.slab, displacements) < LARGEST_DISTORTION


def _by_lattice(deck: Deck) -> _Relax:
    specimen = Specimen.of_slab(cast(Slab, deck.slab), check_model("model", deck.model))
    alone = replace(deck, protocol=None, wall_force="formulas")

    def relax(separation: float, start: Real) -> _State:
        here = replace(alone, separation=separation, displacements=start)
        found = iterate(here, specimen.session, specimen.response, _MOST)
        gap = separation + deck.heights - found.displacements[0, ..., 2]
        pressure = float(deck.law.evaluate(gap).traction.mean())
        return _State(separation, found.displacements, pressure, found.evaluations, found.converged)

    return relax


def _by_atoms(deck: Deck, still_open: ExitStack) -> _Relax:
    slab = deck.slab
    # Lengths are in a0 and energies in E* a0³; numbers of elements only tell them apart.
    rest = Atoms(
        slab.types + 1, positions=deck.rest.reshape(-1, 3), cell=(*slab.grid.lengths, slab.depth),
        pbc=(True, True, False), constraint=FixAtoms(indices=np.arange(slab.mobile_atoms, slab.size)),
    )  # fmt: skip
    crystal = _Crystal(deck.model, still_open)
    crystal.calculate(rest)  # bonds are those of the slab at rest
    try:
        response = SlabResponse.measure(rest, crystal)
        measuring = [ceil(response.cost)]
    except ArgumentError:
        response, measuring = None, []  # of a slab that does not repeat, which the relaxation leaves to ASE's
    act = _smooth(deck, rest, crystal) if deck.crystal is None else _Walled(deck, still_open).at

    def relax(separation: float, start: Real) -> _State:
        atoms = rest.copy()
        atoms.positions += start.reshape(-1, 3)
        atoms.calc, pressure = act(separation)
        relaxation = GreensRelaxation(atoms, logfile=None, response=response, at_rest=rest)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it goes on by another method, and what that reaches is looked at
            try:
                converged = relaxation.run(deck.tolerance * slab.area / 2, _MOST)  # type: ignore[no-untyped-call]
            except RuntimeError:  # atoms are lost, or a search along a line has failed
                converged = False
        moved = (atoms.positions - rest.positions).reshape(deck.start.shape)
        evaluations = relaxation.nsteps + 1 + (measuring.pop() if measuring else 0)
        return _State(separation, moved, pressure(), evaluations, bool(converged))

    return relax


_Act = Callable[[float], tuple[Any, Callable[[], float]]]
"""All forces under the wall at a separation, and its mean traction, in E*, once they are evaluated."""


def _smooth(deck: Deck, rest: Atoms, crystal: Calculator) -> _Act:
    slab = deck.slab
    follows: Literal["atoms", "sites"] = "sites" if deck.shape is None else "atoms"
    profile: Any = SimpleNamespace(period=slab.grid.lengths)
    if deck.shape is None:
        profile.evaluate = lambda x, y: WallHeight(deck.above[: x.size], np.zeros_like(x), np.zeros_like(y))
    else:
        shape = deck.shape
        if deck.wall_force == "plugin":  # which has a map of the shape
            heights = heights_of_shape(shape, slab.grid)
            x, y = (length / n for length, n in zip(slab.grid.lengths, heights.shape, strict=True))
            shape = HeightSpline(heights, (x, y))
        profile.evaluate = shape.evaluate
    surface = np.arange(slab.surface_atoms)

    def act(separation: float) -> tuple[Any, Callable[[], float]]:
        wall = RoughWall(profile, rest, separation, deck.wall, follows=follows, surface=surface)
        return SumCalculator([crystal, wall]), lambda: -float(wall.results["forces"][:, 2].sum()) / slab.grid.area

    return act


class _Forces(Calculator):
    """Forces by LAMMPS as a calculator of ASE, in a0 and E*."""

    implemented_properties = ["energy", "free_energy", "forces"]  # noqa: RUF012 - as ASE declares it

    def evaluated(self, atoms: Atoms) -> tuple[float, Real]:
        """Energy and forces of the atoms."""
        raise NotImplementedError

    def calculate(
        self,
        atoms: Atoms | None = None,
        properties: Sequence[str] = ("energy",),
        system_changes: Sequence[str] = all_changes,
    ) -> None:
        super().calculate(atoms, properties, system_changes)  # type: ignore[no-untyped-call]
        assert self.atoms is not None
        energy, forces = self.evaluated(self.atoms)
        self.results = {"energy": energy, "free_energy": energy, "forces": forces}


class _Crystal(_Forces):
    """A crystal, of any number of its atoms."""

    def __init__(self, model: AnyModel, still_open: ExitStack) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self._model, self._open, self._cells = model, still_open, dict[tuple[bytes, bytes], Cell]()

    def evaluated(self, atoms: Atoms) -> tuple[float, Real]:
        positions, model = atoms.positions * self._model.length, self._model
        periods = np.diag(np.array(atoms.cell)) * model.length
        # The mean cell of an alloy may be repeated to the size of its slab: then only the elements tell the two apart.
        key = atoms.numbers.tobytes(), periods.tobytes()
        if key not in self._cells:
            cell = Cell(model, positions, periods, surface=True, types=atoms.numbers - 1)
            self._cells[key] = self._open.enter_context(cell)
        energy, forces = self._cells[key].evaluate(positions)
        return energy / model.energy, forces * (model.length / model.energy)


class _Walled(_Forces):
    """A crystal and the atoms of a wall, with the scripts of a deck."""

    def __init__(self, deck: Deck, still_open: ExitStack) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        folder = still_open.enter_context(tempfile.TemporaryDirectory())
        self._session = still_open.enter_context(Session(write_deck(Path(folder), replace(deck, protocol=None))))
        self._session.command(f"variable separation equal {deck.separation:.17g}", "include in.wall")
        count = deck.slab.surface_atoms
        self._session.command(f"variable mean_traction equal c_load/{count}")

    def at(self, separation: float) -> tuple[Any, Callable[[], float]]:
        self._session.command(f"variable separation equal {separation:.17g}", "include in.place")
        self.reset()  # type: ignore[no-untyped-call]
        return self, lambda: self._session.variable("mean_traction")

    def evaluated(self, atoms: Atoms) -> tuple[float, Real]:
        length, unit = self._session.length, self._session.energy
        with_wall = self._session.positions()
        with_wall[: len(atoms)] = atoms.positions * length
        energy, forces = LammpsHandle.evaluate(self._session, with_wall)
        return energy / unit, forces[: len(atoms)] * (length / unit)
