"""From a configuration to the contact problem that it describes, and what solving it will cost."""

from __future__ import annotations

import os
from dataclasses import dataclass, field

import numpy as np

from continuum.files.arrays import read_numbers, read_text
from continuum.model.cubic import CubicConstants
from continuum.model.grid import Grid, Real
from continuum.model.problem import ContactProblem
from continuum.model.resolution import unresolved
from continuum.model.substrates import CubicLayer, HalfSpace, Layer, Substrate
from continuum.model.surface import Moments, SelfAffine, moments, sine, sphere
from continuum.model.tabulated_wall import TabulatedWall
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline, Wall
from continuum.runs.config import (
    CrystalTable,
    ExponentialWall,
    Fault,
    FileSurface,
    InversePowersWall,
    LayerTable,
    RigidWall,
    RunConfig,
    SelfAffineSurface,
    SineSurface,
    SphereSurface,
    SplineWall,
    TableWall,
    refuse,
)
from continuum.solve.smooth import Settings

__all__ = ["Cost", "System", "build", "estimate", "wall_of"]

# Peak memory of a run in bytes: the libraries, and per grid point; seen: 83 with a law (4096²), 110 with a hard wall.
_BYTES, _BYTES_PER_POINT = 2.5e8, 115
# FFT pairs of one point to a residual of 1e-6 h'rms E*, warm, up to 1024², with and without adhesion; larger
# grids and points near an instability take up to three times as many (docs/solver.md).
_PAIRS_REPULSIVE, _PAIRS_ADHESIVE = 35, 80
_SEARCH = 2  # further points that the search for a repulsive area takes
_DECADES = 6.0  # for which these hold; pairs grow linearly with the decades of tolerance


@dataclass(frozen=True)
class Cost:
    """What a run will take, to within a factor of about three."""

    memory: int
    """Peak, in bytes."""
    points: int
    """Points of the path."""
    fft_pairs: int
    """Forward and inverse transforms of all points, halved."""


@dataclass(frozen=True, eq=False)
class System:
    """A contact problem with what belongs to it."""

    config: RunConfig
    problem: ContactProblem = field(repr=False)
    realised: Moments
    """Moments of the heights as they are."""
    expected: Moments | None
    """Moments of the ensemble that they were drawn from; None if they were not drawn."""
    settings: Settings
    warnings: tuple[str, ...] = ()
    """What the grid does not resolve."""

    @property
    def grid(self) -> Grid:
        """The grid of the problem."""
        return self.problem.grid


def estimate(config: RunConfig) -> Cost:
    """Memory and transforms of a run, from its configuration alone."""
    nx, ny = config.grid.n
    size, points = nx * ny, config.loading.points
    # Contact maps take two bits per point, fields four bytes, and a rewrite holds them twice.
    kept = points * size * 2 * (0.25 + (4 if config.output.fields else 0))
    wall = config.wall
    plain = isinstance(wall, SplineWall) and not (wall.range or wall.adhesion_length)
    adhesive = not (plain or isinstance(wall, RigidWall))
    pairs = _PAIRS_ADHESIVE if adhesive else _PAIRS_REPULSIVE
    decades = -float(np.log10(config.solver.tolerance))
    per_point = min(pairs * max(decades, 1.0) / _DECADES, config.solver.max_iterations + 3)
    searches = sum(len(targets) for control, targets in config.loading.legs if control == "repulsive-area")
    solves = points + _SEARCH * searches
    return Cost(int(_BYTES + size * _BYTES_PER_POINT + kept), points, round(per_point * solves))


def build(config: RunConfig) -> System:
    """The contact problem of a configuration.

    Raises
    ------
    ConfigError
        If the run does not fit into memory, or a file does not hold what it should.
    """
    needed, available = estimate(config).memory, _physical_memory()
    if needed > available:
        cause = "too many points of the grid, or of the path with output.fields"
        limit = f"a run that needs at most the {available / 1e9:.3g} GB of this machine, not {needed / 1e9:.3g}"
        raise refuse(config, Fault(("grid", "n"), limit, cause))
    grid = Grid(config.grid.n, config.grid.lengths, config.grid.threads)

    faults: list[Fault] = []
    heights = expected = wall = None
    try:
        heights, expected = _heights(config, grid)
    except (ValueError, OSError) as error:
        faults.append(Fault(("surface", _place(config.surface)), _usable(error)))
    try:
        wall = wall_of(config)
    except (ValueError, OSError) as error:
        faults.append(Fault(("wall", _place(config.wall)), _usable(error)))
    if heights is None or wall is None:
        raise refuse(config, *faults)

    realised = moments(grid, heights)
    if not 0 < realised.rms_slope < np.inf:
        what = f"heights with a finite slope, which the tolerance refers to, not {realised.rms_slope:g}"
        raise refuse(config, Fault(("surface", _place(config.surface)), what, "a flat or enormous surface"))
    solver = config.solver
    settings = Settings(solver.tolerance * realised.rms_slope, solver.max_iterations, solver.shift)
    problem = ContactProblem(grid, wall, heights, _response(config))
    _check_mean_gaps(config, problem)
    shortest = config.surface.lambda_s if isinstance(config.surface, SelfAffineSurface) else None
    warned = tuple(unresolved(problem, realised.rms_slope, shortest))
    return System(config, problem, realised, expected, settings, warned)


def _check_mean_gaps(config: RunConfig, problem: ContactProblem) -> None:
    """Refuse targets that no state has, where the wall bounds the gap."""
    held = {"mean-gap": problem.wall.bound}
    if np.isinf(problem.mean_stiffness):
        held["separation"] = problem.wall.bound - problem.mean_height
    for place, (control, targets) in zip(("loading", "loading.retraction"), config.loading.legs, strict=False):
        if control in held and min(targets) <= held[control]:
            expected = f"values above {held[control]:g} a0, a positive mean gap"
            cause = "no state: a hard wall leaves no surface at a mean gap of zero or less"
            raise refuse(config, Fault((*place.split("."), "targets"), expected, cause))


def _physical_memory() -> float:
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return float("inf")


def _place(table: object) -> str:
    return "path" if isinstance(table, (FileSurface, TableWall)) else "law" if _is_wall(table) else "kind"


def _is_wall(table: object) -> bool:
    return isinstance(table, SplineWall)


def _usable(error: Exception) -> str:
    return f"what can be used; here: {error}"


def _response(config: RunConfig) -> Substrate:
    substrate = config.substrate
    if isinstance(substrate, LayerTable):
        return Layer(substrate.depth, substrate.poisson, substrate.mean)
    if isinstance(substrate, CrystalTable):
        constants = CubicConstants(substrate.c11, substrate.c12, substrate.c44)
        return CubicLayer(substrate.depth or np.inf, constants, substrate.mean)
    return HalfSpace(substrate.mean)


def wall_of(config: RunConfig) -> Wall:
    """The wall law of a configuration.

    Raises
    ------
    ValueError, OSError
        If it is a table that cannot be used.
    """
    table = config.wall
    if isinstance(table, TableWall):
        columns = read_text(table.path)
        if columns.shape[1] != 2:
            msg = f"{table.path} has {columns.shape[1]} columns, a wall has 2: gap and traction"
            raise ValueError(msg)
        return TabulatedWall(columns[:, 0], columns[:, 1])
    if isinstance(table, RigidWall):
        return HardWall()
    if isinstance(table, InversePowersWall):
        powers = (9, 3) if table.law == "lennard-jones-9-3" else (12, 6)
        return InversePowers(powers, table.adhesion_length * powers[0] * powers[1], table.core)
    if isinstance(table, ExponentialWall):
        return Exponential(table.surface_energy, table.decay_length, table.core_stiffness)
    if table.range is not None:
        return LennardJonesSpline(table.range, core=table.core)
    spline = LennardJonesSpline(adhesion_length=table.adhesion_length or 0.0)
    return LennardJonesSpline(spline.range, core=table.core)


def _heights(config: RunConfig, grid: Grid) -> tuple[Real, Moments | None]:
    surface = config.surface
    if isinstance(surface, SelfAffineSurface):
        spectrum = SelfAffine(surface.hurst, surface.rms_slope, surface.lambda_s, surface.lambda_L, surface.rescale)
        return spectrum.synthesise(grid, np.random.default_rng(surface.seed)), spectrum.expected_moments(grid)
    if isinstance(surface, SineSurface):
        return sine(grid, surface.amplitude, surface.waves), None
    if isinstance(surface, SphereSurface):
        return sphere(grid, surface.radius), None
    heights = read_numbers(surface.path, surface.dataset, grid.shape)
    missing = np.count_nonzero(~np.isfinite(heights))
    if missing:
        msg = f"{missing} of the {heights.size} heights in {surface.path} are not finite numbers"
        raise ValueError(msg)
    return heights, None
