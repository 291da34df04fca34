"""The limit of JKR from states without adhesion: `python -m docs.studies.jkr_limit`, four minutes.

Thresholds by search over w_JKR at equal repulsive area: of a cylinder and a sphere whose range alone is changed, and of
rough surfaces with 8 to 32 points to their shortest wave.  Prints the table that docs/studies/jkr_limit.md sums up.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

import continuum as c
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.path.threshold import press_without_adhesion
from continuum.sheet import Sheet
from continuum.solve.solution import NotConvergedError
from continuum.theory.smooth import tabor_parameter
from docs.studies.one_contact import BODIES, CORE
from docs.studies.one_state import HEIGHT, RESOLVED, self_affine

AREAS = 1.4, 1.8, 2.3
"""Areas of the states over the repulsive area asked for: about half of a contact presses as its load vanishes."""
SEEDS, LATER = (21, 22, 23), range(24, 30)


@dataclass(frozen=True, eq=False)
class Case:
    """A contact under attractions of several ranges; lengths in pixels."""

    name: str
    heights: Real
    grid: Grid
    area: float
    core: float
    radius: float
    ranges: tuple[float, ...]


def w_jkr(case: Case) -> float:
    """w_JKR = N0² k'/(2k²) where ``case.area`` still presses, from states of three areas."""
    contact, found = _contact(case, 1.0), []
    for part in AREAS:
        state = press_without_adhesion(contact.problem, part * case.area, contact.settings, case.core)
        stiffness = case.core * state.grid.mean(state.contact * state.opening)
        pressing = np.mean(state.distance + state.load / stiffness * state.opening < 0)
        found.append((state.area_rep, state.load, 1 / stiffness, float(pressing)))
    works = [a[1] * b[1] / 2 * (a[2] - b[2]) / (b[0] - a[0]) for a, b in pairwise(found)]
    parts = [np.sqrt(a[3] * b[3]) for a, b in pairwise(found)]
    power = np.log(works[1] / works[0]) / np.log(parts[1] / parts[0])
    return float(works[0] * (case.area / parts[0]) ** power)


def _contact(case: Case, reach: float) -> c.Contact:
    wall = c.attraction_on_core("spline", 1e-4, reach, case.core)
    return c.Contact(case.heights, wall, c.HalfSpace("clamped"), case.grid.lengths, tolerance=1e-4)


def rows(case: Case) -> Iterator[tuple[object, ...]]:
    """A row for each range under which a threshold is found that the grid resolves."""
    jkr = w_jkr(case)
    for reach in case.ranges:
        contact = _contact(case, reach)
        wall_of = partial(c.attraction_on_core, "spline", effective_range=reach, core_stiffness=case.core)
        state = press_without_adhesion(contact.problem, case.area, contact.settings, case.core)
        one = state.threshold(wall_of)
        start = one.work if np.isfinite(one.work) else one.low if one.low > 0 else one.dmt
        try:
            searched = replace(contact, wall=wall_of(start)).find_threshold(wall_of, area=case.area).require()
        except NotConvergedError as error:
            sys.stderr.write(f"{case.name} {reach:.3g}: {error}\n")
            continue
        w = searched.work
        if w > RESOLVED * reach**2:  # single points snap
            continue
        muller = tabor_parameter(case.radius, w, reach)
        found = (f"{reach:.3g}", f"{muller:.2f}", one.patches, f"{w / one.dmt:.2f}", f"{w / one.work:.2f}",
                 f"{w / jkr:.3f}", "jumps" if searched.jumps else "")  # fmt: skip
        sys.stderr.write(f"{case.name} {found} {time.process_time():.0f} s\n")
        yield (case.name, *found)


def rough(
    seeds: Iterable[int], n: int, hurst: float, waves: tuple[float, float], area: float, deltas: tuple[float, ...]
) -> Iterator[Case]:
    """Self-affine surfaces of an rms height of 1/32 of λ_s; ranges in rms heights."""
    for seed in seeds:
        height, grid = waves[0] / 32, Grid.square(n)
        heights = self_affine(n, hurst, *waves, seed) / HEIGHT * height
        radius = float(np.sqrt(8 / 3)) / c.moments(grid, heights).rms_curvature
        name = f"H {hurst}, λ_s {waves[0]:g}, λ_L {waves[1]:g}, {area:.0%}, {n}², seed {seed}"
        yield Case(name, heights, grid, area, 4 * CORE / waves[0], radius, tuple(one * height for one in deltas))


def cases() -> Iterator[Case]:
    """In the order of the table."""
    for body in (BODIES[0], BODIES[2]):
        reaches = tuple(part * body.inside**2 / body.radius for part in body.ranges[::2])
        yield Case(body.name, body.heights, body.grid, body.area, CORE * 20 / body.inside, body.radius, reaches)
    yield from rough(SEEDS, 128, 0.8, (16.0, 64.0), 0.04, (1.0, 0.5, 0.25))
    yield from rough(SEEDS, 256, 0.8, (32.0, 64.0), 0.04, (1.0, 0.5, 0.25))
    yield from rough(SEEDS, 256, 0.8, (8.0, 64.0), 0.01, (0.4, 0.25))
    yield from rough(SEEDS, 256, 0.3, (16.0, 64.0), 0.02, (0.5, 0.3))
    yield from rough(LATER, 256, 0.8, (8.0, 64.0), 0.01, (0.25, 0.2))
    yield from rough(LATER, 256, 0.3, (16.0, 64.0), 0.02, (0.3, 0.25))
    yield from rough(LATER, 128, 0.8, (16.0, 64.0), 0.04, (0.25, 0.22))


def main() -> None:
    """Print the table."""
    warnings.filterwarnings("ignore", category=UserWarning)
    heads = ("contact", "range", "μ_T", "patches", "threshold over w_DMT", "the estimate", "w_JKR", "")
    table = [row for case in cases() for row in rows(case)]
    sys.stdout.write(Sheet.of("the limit of JKR", heads, table).markdown() + "\n")


if __name__ == "__main__":
    main()
