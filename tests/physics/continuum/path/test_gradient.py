"""Derivatives by all heights against finite differences, under every law, on every substrate and under every control.

Central differences of fourth order at steps h = 4e-6, along which all heights contribute with one sign, so that the
change is of order 0.1 h: (4e-6/4e-4)^4 is their error where the edge of the area is nearest to its points, and far less
for the rest; states solved to 1e-13 E* add 1e-13/(0.1 h) = 3e-7 at most.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

import continuum as c
from continuum.inputs.arguments import ArgumentError
from continuum.measure.contact import area_by_lines
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import (
    HalfSpace,
    Substrate,
    TabulatedSubstrate,
)
from continuum.model.surface import SelfAffine
from continuum.model.walls import (
    Exponential,
    HardWall,
    InversePowers,
    LennardJonesSpline,
    TabulatedWall,
    Wall,
    attraction_on_core,
)
from continuum.path.gradient import Given, Number, Tangent, gradient, least_load, threshold_gradient
from continuum.path.loading import solve
from continuum.path.state import Control, PathState, height, nearness
from continuum.path.threshold_search import WallOfWork
from continuum.solve.solution import NotConvergedError, Settings
from continuum.solve.tangent import tangent_stiffness
from tests import kinds
from tests.problems import Rough

TIGHT = Settings(1e-13)
TOLERANCE = 1e-6
"""Relative: a few times the error of the differences."""
STEP = 4e-6
GRID, LINE = Grid((15, 16), (15.0, 16.0)), Grid((1, 33), (1.0, 33.0))
WORK = 0.005
APART = 2e-4
"""Distance of every point from the edge of the repulsive contact, where the area has a kink and the core begins."""


def _table(work: float) -> Wall:
    gap = np.linspace(0.7, 1.4, 41)
    traction = LennardJonesSpline(0.4).evaluate(gap).traction
    return TabulatedWall(gap, traction * work / TabulatedWall(gap, traction).work_of_adhesion)


def _exponential(work: float) -> Wall:
    decay, stiffness = 0.2, 5.0
    return Exponential(2 * work / (1 + np.sqrt(1 + 2 * work / (decay**2 * stiffness))), decay, stiffness)


LAWS: dict[str, WallOfWork] = {
    **kinds.OF_WORK,
    "9-3": lambda work: InversePowers((9, 3), adhesion_length=work, core=0.5),
    "table": _table,
    "exponential": _exponential,
}
SUBSTRATES: dict[str, Callable[[Grid], Substrate]] = {
    **{name: lambda grid, one=one: one for name, one in kinds.SUBSTRATES.items()},
    "half-space, free": lambda grid: HalfSpace("free"),
    "table": lambda grid: TabulatedSubstrate(0.3 + 0.5 * grid.wavenumber, grid.lengths, "test"),
}
PAPERS, NO_IMAGES = "lennard-jones-spline", "non-periodic-half-space"
EACH_ONCE = [
    *((law, "half-space") for law in LAWS),
    *((PAPERS, name) for name in SUBSTRATES if name != "half-space"),
]


class Place:
    """An equilibrium, and those next to it along a direction of the heights."""

    def __init__(
        self,
        wall_of: WallOfWork,
        substrate: Substrate,
        grid: Grid = GRID,
        near: float = 0.1,
        settings: Settings = TIGHT,
    ) -> None:
        rng = np.random.default_rng(4)
        self.heights = SelfAffine(0.8, 0.1, 5.0, grid.lengths[1]).synthesise(grid, rng)
        self.settings = settings
        self.wall_of, self.problem = wall_of, ContactProblem(grid, wall_of(WORK), self.heights, substrate)
        wall, self.control = self.problem.wall, nearness(self.problem)
        self.near = wall.zero_gap + near
        while True:
            self.state = solve(self.problem, self.control, self.near, settings)
            if wall.law is None or np.abs(self.state.gap - wall.zero_gap).min() > APART:
                break
            self.near += 0.007
        self.state.require()
        by_work = wall_of(2 * WORK).work_of_adhesion > wall.work_of_adhesion
        self.tangent = Tangent(self.problem, self.state.gap, wall_of if by_work else None)
        # A random direction, but not one at a right angle to the gradient.
        self.along = np.abs(rng.standard_normal(grid.shape)) * np.sign(self.tangent.load.heights)

    def solved(
        self, by_heights: float, by_nearness: float = 0.0, by_work: float = 0.0
    ) -> tuple[ContactProblem, PathState]:
        """A neighbour."""
        heights = self.heights + by_heights * self.along
        problem = replace(self.problem, heights=heights, wall=self.wall_of(WORK + by_work))
        return problem, solve(problem, self.control, self.near + by_nearness, self.settings, self.state.gap).require()

    def height(self, state: PathState) -> float:
        """How near the wall is."""
        return height(self.problem, state)

    def at(self, *by: float) -> Real:
        """Load, area and separation of a neighbour."""
        problem, state = self.solved(*by)
        area, _ = area_by_lines(state.gap - problem.wall.zero_gap, periodic=problem.open_boundary is None)
        return np.array([state.load, area, state.separation])

    def changes(self, *direction: float) -> Real:
        """Derivatives of load, area and separation along a direction of heights, nearness and work."""
        return difference(lambda step: self.at(*(step * one for one in direction)))


def difference(at: Callable[[float], Real | float]) -> Real:
    """Central difference of fourth order."""
    near, far = (np.asarray(at(step)) - np.asarray(at(-step)) for step in (STEP, 2 * STEP))
    found: Real = (8 * near - far) / (12 * STEP)
    return found


@cache
def place(law: str, substrate: str) -> Place:
    # This law is so steep where the window's rim presses that 1e-13 E* is below rounding.
    settings = Settings(2e-12) if (law, substrate) == ("9-3", NO_IMAGES) else TIGHT
    return Place(LAWS[law], SUBSTRATES[substrate](GRID), settings=settings)


@pytest.mark.parametrize(
    ("law", "substrate"),
    [
        *EACH_ONCE,
        ("exponential", NO_IMAGES),
        ("9-3", NO_IMAGES),
        ("attraction-on-core", "crystal"),
    ],
)
def test_load_area_and_separation_change_as_their_derivatives_say(law: str, substrate: str) -> None:
    here = place(law, substrate)
    numbers = [here.tangent.load, here.tangent.area]
    if here.problem.mean_stiffness > 0:
        numbers.append(here.tangent.separation)
    # Heights, nearness and work each by as much as changes the load alike.
    load = numbers[0]
    share = abs(float((load.heights * here.along).sum()))
    direction = 1.0, share / abs(load.nearness), share / abs(load.work)
    seen = here.changes(*direction)
    for number, one in enumerate(numbers):
        parts = np.array([(one.heights * here.along).sum(), one.nearness, one.work]) * direction
        assert abs(seen[number] - parts.sum()) <= TOLERANCE * np.abs(parts).max(), number


@pytest.mark.parametrize("at", ["mean_gap", "separation", "pressure", "area"])
@pytest.mark.parametrize("number", ["load", "area"])
@pytest.mark.parametrize("substrate", ["layer", NO_IMAGES])
def test_what_is_held_stays(substrate: str, number: Number, at: Given) -> None:
    here = place(PAPERS, substrate)
    if (number, at) in {("load", "pressure"), ("area", "area")} or (substrate, at) == (
        NO_IMAGES,
        "mean_gap",
    ):
        with pytest.raises(ArgumentError, match="at ="):
            gradient(here.problem, here.state, TIGHT, number, at=at)
        return
    found = (gradient(here.problem, here.state, TIGHT, number, at=at) * here.along).sum()
    held = {"pressure": here.tangent.load, "area": here.tangent.area, "separation": here.tangent.separation}
    follow = -(held[at].heights * here.along).sum() / held[at].nearness if at in held else 0.0
    load, area, separation = here.changes(1.0, follow, 0.0)
    assert {"load": load, "area": area}[number] == pytest.approx(found, rel=TOLERANCE)
    kept = {"pressure": load, "area": area, "separation": separation}.get(at, 0.0)
    assert abs(kept) <= TOLERANCE * max(1.0, abs(follow))


@pytest.mark.parametrize("control", ["separation", "mean-gap", "mean-pressure", "repulsive-area"])
def test_the_separation_is_held_where_it_is_given_and_else_the_mean_gap(control: Control) -> None:
    here = place(PAPERS, "layer")
    state, at = replace(here.state, control=control), "separation" if control == "separation" else "mean_gap"
    np.testing.assert_array_equal(
        gradient(here.problem, state, TIGHT, "load"), gradient(here.problem, state, TIGHT, "load", at=at)
    )


@pytest.mark.parametrize(("law", "substrate"), EACH_ONCE)
def test_the_work_of_the_threshold_keeps_load_and_area(law: str, substrate: str) -> None:
    here = place(law, substrate)
    work = (threshold_gradient(here.problem, here.state, here.wall_of) * here.along).sum()
    area = here.tangent.area
    follow = -((area.heights * here.along).sum() + area.work * work) / area.nearness
    seen = here.changes(1.0, follow, work)
    for kept, one in zip(seen[:2], (here.tangent.load, here.tangent.area), strict=True):
        assert abs(kept) <= TOLERANCE * abs(one.work * work)
    # Not by the tolerance: by either of both the other is not kept.
    assert abs(here.changes(1.0, 0.0, work)[1]) > 1e-3 * abs(area.work * work)


@pytest.mark.parametrize(
    ("law", "substrate"), [("exponential", "layer"), pytest.param(PAPERS, NO_IMAGES, marks=pytest.mark.long)]
)
def test_the_least_load_changes_as_the_load_there_at_a_given_gap(
    law: str, substrate: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = Place(LAWS[law], SUBSTRATES[substrate](GRID), near=0.25)
    # Of 240 points each that leaves the core makes a minimum of its own; without this another one may be found.
    monkeypatch.setattr("continuum.path.gradient.FIRST_STEP", 1e-3)
    monkeypatch.setattr("continuum.path.gradient.SMALLEST_STEP", 1e-7)
    top = least_load(here.problem, here.state, TIGHT)
    # From a state beside the place the same search ends at once.
    found = gradient(here.problem, top.below, TIGHT, "pull_off")

    def tension(step: float) -> float:
        problem = replace(here.problem, heights=here.heights + step * here.along)
        begin = solve(problem, here.control, here.height(top.below), TIGHT, top.below.gap)
        least = least_load(problem, begin, TIGHT)
        fall, width = (
            Tangent(problem, least.below.gap).load.nearness,
            here.height(least.above) - here.height(least.below),
        )
        # The tangents of both states meet there.
        return -(least.share * (least.below.load + fall * width) + (1 - least.share) * least.above.load)

    seen = (tension(STEP) - tension(-STEP)) / (2 * STEP)  # its curvature is of order one: h² = 1e-10
    assert (found * here.along).sum() == pytest.approx(seen, rel=TOLERANCE)


@pytest.mark.parametrize(
    ("substrate", "grid", "hardness"),
    [
        *((name, GRID, np.inf) for name in SUBSTRATES),
        ("half-space", LINE, np.inf), ("layer", GRID, 0.06), (NO_IMAGES, GRID, 0.06),
    ],
)  # fmt: skip
def test_under_a_hard_wall_the_contact_follows(substrate: str, grid: Grid, hardness: float) -> None:
    here = Place(lambda work: HardWall(hardness), SUBSTRATES[substrate](grid), grid)
    assert 0.02 < here.state.area_rep < 0.9
    assert (here.state.gap.min() < 0) == np.isfinite(hardness)
    load = here.tangent.load
    seen = difference(lambda step: here.solved(step, step)[1].load)
    assert seen == pytest.approx((load.heights * here.along).sum() + load.nearness, rel=TOLERANCE)
    for number in ("area", "threshold", "pull_off"):
        with pytest.raises(ArgumentError, match="wall"):
            gradient(here.problem, here.state, TIGHT, number, wall_of=lambda work: HardWall())


def test_the_derivative_by_the_mean_gap_is_the_normal_stiffness_and_a_shift_of_all_does_nothing() -> None:
    here = place(PAPERS, "half-space")
    law = here.problem.wall.law
    assert law is not None
    stiffness = tangent_stiffness(GRID, here.problem.stiffness_q, law, here.state.gap)
    assert here.tangent.load.nearness == pytest.approx(-stiffness, rel=1e-9)  # its error is that of the solve, squared
    for number in (here.tangent.load, here.tangent.area):
        assert abs(number.heights.sum()) < 1e-12 * np.abs(number.heights).sum()
    # At a given separation the wall comes down with its heights.
    at_separation = gradient(here.problem, here.state, TIGHT, "load", at="separation")
    assert at_separation.sum() == pytest.approx(-stiffness, rel=1e-9)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("shape", [(1, 9), (6, 7), (9, 2)])
def test_the_area_by_lines_has_its_slope(shape: tuple[int, int], periodic: bool) -> None:
    distance, along = np.random.default_rng(1).standard_normal((2, *shape))
    slope = (area_by_lines(distance, periodic=periodic)[1] * along).sum()
    seen = difference(lambda step: area_by_lines(distance + step * along, periodic=periodic)[0])
    assert seen == pytest.approx(slope, rel=1e-8)  # rounding, 1e-16 over the step; no point is as near to zero as that
    assert area_by_lines(np.full(shape, -1.0), periodic=periodic)[0] == 1.0
    assert area_by_lines(np.full(shape, 1.0), periodic=periodic)[0] == 0.0


def test_the_area_by_lines_is_that_of_a_disc_and_of_a_strip() -> None:
    x, y = Grid.square(64).positions
    disc = np.hypot(x - 31.3, y - 32.6) - 20
    # A count of points is off by about the square root of those at the rim; lines along x and y, less.
    assert area_by_lines(disc)[0] == pytest.approx(np.pi * 20**2 / 64**2, rel=2e-3)
    strip = np.broadcast_to(np.abs(x - 31.3) - 10.4, (64, 64))
    # Along y a strip is a count of points, along x it is exact: half of the error of a count, 1 of 20.8 at most.
    assert area_by_lines(strip)[0] == pytest.approx(20.8 / 64, abs=0.5 / 64)


def test_what_has_no_derivative_is_refused_in_words() -> None:
    here = place(PAPERS, "half-space")
    ask = partial(gradient, here.problem, here.state, TIGHT)
    for wrong in ("w", None, 1):
        with pytest.raises(ArgumentError, match=r"number = .*pull_off"):
            ask(wrong)
    with pytest.raises(ArgumentError, match="wall = None"):
        ask("threshold")
    with pytest.raises(ArgumentError, match=r"wall = .*the law of the state"):
        ask("threshold", wall_of=lambda work: LennardJonesSpline(adhesion_length=2 * work))
    for number in ("threshold", "pull_off"):
        with pytest.raises(ArgumentError, match=r"at = .*None: at"):
            ask(number, at="area", wall_of=here.wall_of)
    free = place(PAPERS, "half-space, free")
    with pytest.raises(ArgumentError, match=r"at = .*mean_gap where"):
        gradient(free.problem, free.state, TIGHT, "load", at="separation")
    apart = solve(here.problem, "mean-gap", 20.0, TIGHT)
    for number in ("load", "area"):
        assert not gradient(here.problem, apart, TIGHT, number).any()
    with pytest.raises(NotConvergedError, match="what is held"):
        gradient(here.problem, apart, TIGHT, "load", at="area")
    with pytest.raises(NotConvergedError, match="smooth minimum"):
        gradient(here.problem, apart, TIGHT, "pull_off")
    failed = solve(here.problem, "mean-gap", 1.1, replace(TIGHT, max_iterations=1))
    with pytest.raises(NotConvergedError, match="iteration limit"):
        gradient(here.problem, failed, TIGHT, "load")


def test_a_threshold_has_the_gradient_that_a_search_on_a_rougher_surface_confirms() -> None:
    rough = Rough(32, lambda_s=8.0, lambda_L=16.0)

    def wall(work: float) -> Wall:
        return attraction_on_core("spline", work, 0.4, 5.0)

    def found(share: float) -> c.FoundThreshold:
        return c.Contact(share * rough.heights(), wall(0.01), area_tolerance=1e-3).find_threshold(
            wall, area=0.1, width=0.004
        )

    as_it_is = found(1.0)
    more = (as_it_is.gradient() * 0.05 * rough.heights()).sum()
    # The area is a count of 102 points: half of one, by 1/0.5 as ln A changes with ln w, is a tenth of this change.
    assert found(1.05).work - as_it_is.work == pytest.approx(more, rel=0.15)
    assert more > 0.05 * as_it_is.work
    assert as_it_is.bracket is not None
    snapped = as_it_is.bracket._replace(kind="jump-in")
    state = replace(as_it_is.state, events=(snapped,))
    with pytest.raises(NotConvergedError, match="jumps over zero"):
        replace(as_it_is, state=state).gradient()


def test_noise_adds_up_over_its_correlation() -> None:
    grid, rng = Grid((6, 7), (6.0, 14.0)), np.random.default_rng(2)
    g = rng.standard_normal(grid.shape)
    assert c.noise_error(grid, g, 0.3) == pytest.approx(0.3 * np.sqrt((g**2).sum()), rel=1e-12)
    x, y = (np.broadcast_to(one, grid.shape).ravel() for one in grid.positions)
    apart = [
        (np.abs(one[:, None] - one) + period / 2) % period - period / 2
        for one, period in zip((x, y), grid.lengths, strict=True)
    ]
    correlation = np.exp(-(apart[0] ** 2 + apart[1] ** 2) / 1.5**2)
    exact = 0.3 * np.sqrt(g.ravel() @ correlation @ g.ravel())
    assert c.noise_error(grid, g, 0.3, 1.5) == pytest.approx(exact, rel=1e-9)
    assert c.noise_error(grid, g, 0.3, 1e-3) == pytest.approx(c.noise_error(grid, g, 0.3), rel=1e-12)
