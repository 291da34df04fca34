"""The threshold of a map by a search: works of adhesion are tried until the load at 1 % area changes its sign.

This does not need the state at the given work of adhesion, which costs many times more far from the threshold, where
the surface snaps.  The wall is that of :mod:`continuum.maps.verdict.on_grid`; the search begins at the estimate of
:mod:`continuum.maps.verdict.threshold`.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from continuum.maps.map import Topography
from continuum.maps.verdict import on_grid, threshold
from continuum.maps.verdict.criteria import AREA, RoughContact
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.threshold import Basis, MapThreshold, PressedMap
from continuum.model.fourier import Real, columns_forward, columns_inverse, padded, rows_forward, rows_inverse
from continuum.model.grid import Grid
from continuum.model.laws import Law
from continuum.model.walls import Wall
from continuum.path.threshold_search import bracket_threshold
from continuum.solve.solution import NotConvergedError, Settings, Solution
from continuum.solve.solver import Solver
from continuum.theory.rough import threshold_share

WIDTH = 0.1
"""Width of the bracket, relative to the threshold.  The load is interpolated within it: on maps whose pixels snap,
works found with a bracket of 0.02 differed by 3 to 12 % and took two to four times as long."""
PAIRS, PAIRS_PER_SIDE = 300.0, 8.0
"""FFT pairs of a search if the pixels resolve the range, and per point along a side if they do not: 120 to 400, and 7
to 17, on synthetic maps of 64² to 256² points and their mirror images."""
PATIENCE = 10.0
"""Factor to these pairs after which a search that was not asked for is given up: worn maps took up to 40 times as
many."""
BESIDE = 4.0
"""Time of an FFT pair in the solver over that of its transforms alone: 2.3 to 6.5 were measured."""
SHORT = 60.0
"""CPU seconds up to which a search is made by itself."""


class _Patient(Solver):
    """A solver that gives up after a number of FFT pairs, which is the same on every machine."""

    def __init__(self, grid: Grid, stiffness_q: Real, threads: int, pairs: float) -> None:
        super().__init__(grid, stiffness_q, threads)
        self._most = self._left = pairs

    def minimise(self, law: Law, offset: Real, start: Real | None, settings: Settings, **conditions: Any) -> Solution:
        """Minimise with the iterations that are left."""
        if self._left < 1:
            raise NotConvergedError(
                f"the search stopped after {self._most:.0f} pairs of transforms, {PATIENCE:g} times as many as most "
                "maps of this size need; with `solve` there is no such limit"
            )
        most = int(min(settings.max_iterations, self._left))
        found = super().minimise(law, offset, start, replace(settings, max_iterations=most), **conditions)
        self._left -= found.fft_pairs
        return found


def expected_pairs(pressed: PressedMap, found: MapThreshold) -> float:
    """FFT pairs that a search will take, to a factor of three, where the estimate is this."""
    size = pressed.problem.grid.size
    length = found.work / pressed.interface.contact_modulus
    resolved = pressed.interface.range >= on_grid.shortest_range(pressed.topography, length)
    return PAIRS if resolved else max(PAIRS, PAIRS_PER_SIDE * size**0.5)


def expected_seconds(pressed: PressedMap, found: MapThreshold) -> float:
    """CPU seconds that a search will take, to a factor of three."""
    nx, ny = pressed.problem.grid.shape
    return BESIDE * expected_pairs(pressed, found) * _pair_seconds(Grid((nx, ny), (float(nx), float(ny))))


def _pair_seconds(grid: Grid) -> float:
    """Time of a transform and its inverse on a grid, in s, measured on one thread of this machine.

    For a grid of more than 1024 points along a side the time is extrapolated from a smaller one, as n² log n.
    """
    n = min(max(round(np.sqrt(grid.size)), 16), 1024)
    small, seconds = Grid.square(n), np.inf
    field, spectrum = np.random.default_rng(1).normal(size=small.shape), padded(small.shape_q, np.complex128)
    # Arrays are allocated before, as in a solver; the best of a few times is that of an idle machine.
    for _ in range(5):
        began = time.process_time()
        repeats = max(1, 2**18 // small.size)
        for _ in range(repeats):
            rows_forward(field, spectrum)
            columns_forward(spectrum)
            columns_inverse(spectrum)
            rows_inverse(spectrum, field)
            field /= small.size
        seconds = min(seconds, (time.process_time() - began) / repeats)
    work = grid.size * np.log(grid.size) / (small.size * np.log(small.size))
    return float(seconds * work)


def search_threshold(pressed: PressedMap, found: MapThreshold, *, limited: bool = False) -> MapThreshold:
    """The work of adhesion at which the load on a map at 1 % repulsive area changes its sign.

    The range of attraction is that of the interface, or the shortest that the pixels resolve at that work if it is
    longer.  A longer range has its threshold at less work, by a factor that the law of the spectrum estimates
    (:func:`continuum.theory.rough.threshold_share`, docs/law.md): between both it is undecided.  The threshold also
    depends on the pixels: with pixels four times finer it changed by a factor of up to 1.8 on eight surfaces.

    Parameters
    ----------
    pressed, found : the map, and its estimate, where the search begins.
    limited : whether it is given up after :data:`PATIENCE` times the expected FFT pairs.

    Raises
    ------
    UnresolvedError
        If the shortest range that the pixels resolve exceeds the rms height.
    NotConvergedError
        If no threshold is found, or not within the limit.
    """
    topography, unit, problem = pressed.topography, pressed.unit, pressed.problem
    given, modulus, grid = pressed.interface.range, pressed.interface.contact_modulus, problem.grid

    def range_at(length: float) -> float:
        """Range in m at a given l_a in units of the grid."""
        return max(given, on_grid.shortest_range(topography, length * unit))

    def wall_at(length: float) -> Wall:
        return on_grid.wall_on(grid, length, range_at(length) / unit)

    settings = Settings(threshold.RESIDUAL * pressed.slope, threads=pressed.threads)
    pairs = PATIENCE * expected_pairs(pressed, found) if limited else np.inf
    solver = _Patient(grid, problem.stiffness_q, pressed.threads, pairs)
    work = found.work / (unit * modulus)
    # Where the range is longer than that of the estimate, the estimate tells less than coarser grids.
    known = range_at(work) == given and np.isfinite(found.mean_gap)
    problem = replace(problem, wall=wall_at(work))
    first = (found.mean_gap, work) if known else None
    at, state = bracket_threshold(problem, wall_at, AREA, settings, pressed.search, WIDTH, solver, first)
    bracket = state.threshold
    if bracket is None:
        raise NotConvergedError(state.status.value)
    length, scale = bracket.root, unit * modulus
    reach = range_at(length)
    doubts = []
    if reach > given:
        on_grid.check_resolved(topography, reach)
        doubts = [f"the threshold is that of {on_grid.in_place_of(reach, given)}"]
    height = float(topography.heights.std())
    share = threshold_share(given / height) / threshold_share(reach / height)
    doubts += on_grid.solver_doubts(at, pressed.slope, topography, unit)
    return replace(
        found, work=length * scale, low=bracket.before.value * scale,
        high=max(bracket.after.value, share * length) * scale,
        source=Basis.SEARCH, range=reach, why=(), jumps=bracket.kind == "jump-in", solves=state.search_solves + 1,
        area_rep=state.area_rep, area_att=state.area_att, gap=state.gap, wall=at.wall,
        warnings=tuple(dict.fromkeys((*found.warnings, *doubts))),
    )  # fmt: skip


def find_threshold(
    topography: Topography,
    interface: Interface,
    contact: RoughContact,
    threads: int = 1,
    search: bool | None = None,
    told: Callable[[str], None] = lambda text: None,
) -> MapThreshold:
    """The threshold of a map: from one state without adhesion, or from a search where that does not decide.

    Parameters
    ----------
    topography : detrended; of two bodies, face to face.
    contact : its roughness, for bounds where it cannot be pressed.
    search, threads, told : as for :meth:`continuum.maps.verdict.prediction.PredictionNumbers.solved`.
    """
    pressed = threshold.press_map(topography, interface, threads)
    told(f"pressing {topography.source} without adhesion, on {' x '.join(map(str, pressed.problem.grid.shape))} points")
    try:
        found = pressed.threshold()
        if found.source is Basis.STATE and contact.roll_off is not None:
            found = replace(found, sampling=pressed.sampling_error(contact.roll_off))
    except NotConvergedError as error:
        return threshold.bounds(contact, f"the map could not be pressed: {error}")
    # Searched for where asked to, or where w lies in the interval of the state, which then does not decide.
    if search is False or not (search or found.sticky(interface.work_of_adhesion) is None):
        return found
    seconds = expected_seconds(pressed, found)
    if not search and seconds > SHORT:
        return _undecided(found, f"a search would take about {seconds:.2g} s: --solve makes it")
    told(f"searching for the threshold with adhesion: about {seconds:.2g} s, to a factor of three")
    try:
        return search_threshold(pressed, found, limited=not search)
    except (on_grid.UnresolvedError, NotConvergedError) as error:
        return _undecided(found, f"a search has not found it: {error}")


def _undecided(found: MapThreshold, why: str) -> MapThreshold:
    """Threshold without a search: bounds, where the state without adhesion was beyond its range."""
    return replace(found, source=Basis.BOUNDS if found.why else found.source, why=(*found.why, why))
