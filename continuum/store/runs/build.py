"""Build the contact problem that a configuration describes."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from continuum.inputs.arguments import ArgumentError
from continuum.inputs.tables import Fault, Key, Table
from continuum.inputs.toml import refuse
from continuum.model.problem import ContactProblem, check_slope, doubts
from continuum.model.shared_grid import Company, SharedGrid
from continuum.model.surface import Moments
from continuum.solve.solution import Settings
from continuum.store.granted import granted_memory
from continuum.store.runs.config import RunConfig, cost_of

_Made = TypeVar("_Made")
_STEP = 0.1  # part of the range; steps of a fifth moved 2 of 20 states by up to a third (docs/studies/paths.md)


@dataclass(frozen=True, eq=False)
class RunSetup:
    """A contact problem with its input, moments and solver settings."""

    config: RunConfig
    problem: ContactProblem = field(repr=False)
    expected: Moments | None
    """Moments of the random ensemble; None if the surface is not random."""
    settings: Settings
    warnings: tuple[str, ...] = ()
    """Warnings about resolution."""

    def at_work(self, work: float) -> ContactProblem:
        """The problem of a point: in a search for thresholds each point has its own work of adhesion."""
        if self.config.loading.threshold is None:
            return self.problem
        return replace(self.problem, wall=self.config.wall.at_work(work))


def build(config: RunConfig, company: Company | None = None) -> RunSetup:
    """The contact problem of a configuration; of a company, the slabs of this process.

    Raises ConfigError if the run does not fit into memory, or a file does not hold what it should.
    """
    needed, available = cost_of(config).memory, granted_memory()
    if needed > available:
        cause = "too many points of the grid, or of the path with output.fields"
        limit = f"a run that needs at most the {available / 1e9:.3g} GB of this machine, not {needed / 1e9:.3g}"
        raise refuse(config, Fault(("grid", "n"), limit, cause))
    grid, faults, lower = config.grid.build(), list[Fault](), config.counterface
    if company is not None:
        grid = SharedGrid(grid.shape, grid.lengths, company=company)
    wall = _made(("wall",), config.wall, config.wall.build, faults)
    heights = _made(("surface",), config.surface, lambda: config.surface.build(grid), faults)
    if lower is not None:
        other = _made(("counterface", "surface"), lower.surface, lambda: lower.surface.build(grid), faults)
        heights = None if heights is None or other is None else lower.under(grid, heights, other)
    if heights is None or wall is None:
        raise refuse(config, *faults)

    problem = ContactProblem(grid, wall, heights, config.substrate.build())
    try:
        check_slope(problem.moments.rms_slope)
    except ArgumentError as error:
        raise refuse(config, _unusable(("surface",), config.surface, error)) from None
    _check_mean_gaps(config, problem)
    expected = config.surface.expected(grid)
    if lower is not None:
        expected = lower.expected(grid, expected)
    warned = (*doubts(problem, problem.moments.rms_slope, config.shortest), *_long_steps(config, problem))
    return RunSetup(config, problem, expected, config.solver.build(problem.traction_scale), warned)


def _made(key: Key, table: Table, build: Callable[[], _Made], faults: list[Fault]) -> _Made | None:
    """Build the object of a table; None, with a fault added, if that fails."""
    try:
        return build()
    except (ValueError, OSError) as error:
        faults.append(_unusable(key, table, error))
        return None


def _unusable(key: Key, table: Table, error: Exception) -> Fault:
    """The fault of a table at the key that the error names, else at its main key."""
    if not isinstance(error, ArgumentError):
        return Fault((*key, table.origin), f"valid values; {error}")
    if error.name in type(table).model_fields:
        return Fault((*key, error.name), error.allowed)
    return Fault((*key, table.origin), error.allowed, f"this makes the {str(error).partition(': allowed')[0]}")


def _long_steps(config: RunConfig, problem: ContactProblem) -> Iterator[str]:
    """Warn of retraction steps so long that contacts may be lost which slow retraction keeps."""
    reach = problem.wall.range
    if config.loading.event_resolution is not None or not 0 < reach < np.inf:
        return
    gaps = [targets for control, targets in config.loading.legs if control in ("mean-gap", "separation")]
    longest = max((b - a for targets in gaps for a, b in pairwise(targets)), default=0.0)
    if longest > _STEP * reach * (1 + 1e-9):
        yield (
            f"steps of the way back of {longest:.3g} a0 are longer than a tenth of the range of the attraction, "
            f"{reach:.3g} a0: contacts that slow retraction keeps may be lost; bracket the jumps "
            "(loading.event_resolution), or take shorter steps"
        )


def _check_mean_gaps(config: RunConfig, problem: ContactProblem) -> None:
    """Check that targets are possible if the wall bounds the gap."""
    held = {"mean-gap": problem.wall.bound}
    if np.isinf(problem.mean_stiffness):
        held["separation"] = problem.wall.bound - problem.mean_height
    for place, (control, targets) in zip(("loading", "loading.retraction"), config.loading.legs, strict=False):
        if control in held and min(targets) <= held[control]:
            expected = f"values above {held[control]:g} a0, a positive mean gap"
            cause = "no state: a hard wall leaves no surface at a mean gap of zero or less"
            raise refuse(config, Fault((*place.split("."), "targets"), expected, cause))
