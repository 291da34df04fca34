"""Wall laws: the paper's numbers, continuity, tables."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, simpson
from scipy.interpolate import CubicSpline
from scipy.special import gamma

from continuum.inputs.arguments import ArgumentError
from continuum.model import laws
from continuum.model.laws import evaluate
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline, Wall
from continuum.model.walls.attraction import AttractionOnCore, Shape, attraction_on_core
from continuum.model.walls.tabulated import TabulatedWall
from continuum.theory import paper
from tests import kinds
from tests.kinds import IN_UNITS

RANGES = [0.10954, 0.34641, 1.09545]


def table_of(wall: LennardJonesSpline, knots: int) -> TabulatedWall:
    gap = np.linspace(wall.core, 1 + wall.range, knots)
    return TabulatedWall(gap, wall.evaluate(gap).traction)


@pytest.mark.parametrize(("adhesion_length", "range_"), list(zip([0.0005, 0.005, 0.05], RANGES, strict=True)))
def test_adhesion_lengths_of_the_paper(adhesion_length: float, range_: float) -> None:
    wall = LennardJonesSpline(adhesion_length=adhesion_length)
    assert wall.range == pytest.approx(range_, abs=5e-6)  # the digits printed in DESIGN.md
    assert wall.work_of_adhesion == pytest.approx(adhesion_length, rel=1e-14)
    assert wall.range**2 / 24 == pytest.approx(adhesion_length, rel=1e-14)
    # The energy at the minimum is minus the work of adhesion, and vanishes at the cut-off.
    energy = wall.evaluate(np.array([1.0, 1 + wall.range, 5.0])).energy
    np.testing.assert_allclose(energy, [-adhesion_length, 0, 0], atol=1e-16)


@pytest.mark.parametrize("range_", RANGES)
def test_largest_tension_and_softening(range_: float) -> None:
    wall = LennardJonesSpline(range_)
    fine = wall.evaluate(np.linspace(1, 1 + range_, 300001))
    # Second order in the spacing of the sample, 3e-6 of the range.
    assert -fine.traction.min() == pytest.approx(2 / 27 * range_, rel=1e-9)
    assert wall.largest_tension == pytest.approx(2 / 27 * range_, rel=1e-14)
    assert -fine.stiffness.min() == pytest.approx(1 / 6, rel=1e-9)
    assert paper.snap_in_wavelength(-fine.stiffness.min()) == pytest.approx(6 * np.pi, rel=1e-8)


@pytest.mark.parametrize("range_", RANGES)
def test_effective_range_is_1_05659_of_the_range(range_: float) -> None:
    wall = LennardJonesSpline(range_)
    found = paper.effective_range(lambda x: -float(wall.evaluate(np.array(1 + x)).traction), cutoff=range_)
    assert found / range_ == pytest.approx(1.05659, abs=5e-6)
    assert wall.effective_range == pytest.approx(found, rel=1e-10)
    table = table_of(wall, 400)
    of_table = paper.effective_range(lambda x: -float(table.evaluate(np.array(table.zero_gap + x)).traction), range_)
    assert table.effective_range == pytest.approx(of_table, rel=1e-8)  # the quadrature crosses 200 knots
    assert table.effective_range == pytest.approx(found, rel=1e-3)


@pytest.mark.parametrize("name", kinds.WALLS)
def test_a_range_in_closed_form_is_that_of_any_law(name: str) -> None:
    """A law without a formula of its own has Eq. (S-5) by quadrature, whose digits a table's knots cost."""
    wall = kinds.WALLS[name]
    assert wall.integrated_range() == pytest.approx(wall.effective_range, rel=1e-6)


def test_effective_ranges_of_the_untruncated_laws() -> None:
    # Eq. (S-5): 1.15 a0 for 9-3 and 0.62 a0 for 12-6, the latter as a surface law, pressure z^-7 - z^-13.
    assert paper.effective_range(lambda x: (1 + x) ** -4 - (1 + x) ** -10) == pytest.approx(1.15294, abs=5e-6)
    assert paper.effective_range(lambda x: (1 + x) ** -7 - (1 + x) ** -13) == pytest.approx(0.62043, abs=5e-6)


@given(st.floats(0.01, 3), st.floats(0.05, 50), st.floats(0.5, 0.9))
def test_the_law_is_smooth_at_its_joints(range_: float, stiffness: float, core: float) -> None:
    wall = LennardJonesSpline(range_, stiffness, core)
    for joint in (core, 1.0, 1 + range_):
        left, right = wall.evaluate(np.array([np.nextafter(joint, 0), np.nextafter(joint, 9)]))[1:]
        assert left[0] == pytest.approx(left[1], abs=1e-9 * stiffness)
        assert right[0] == pytest.approx(right[1], rel=1e-9, abs=1e-9 * stiffness)
    assert wall.evaluate(np.array([1.0])).stiffness[0] == pytest.approx(stiffness, rel=1e-12)


@given(st.floats(-1e6, 1e6), st.sampled_from([0.0, *RANGES]))
def test_a_law_is_finite_at_any_gap(gap: float, range_: float) -> None:
    for wall in (LennardJonesSpline(range_), table_of(LennardJonesSpline(range_), 50)):
        response = wall.evaluate(np.array([gap]))
        assert np.isfinite(response).all()
        assert (response.traction[0] > 0) == (gap < wall.zero_gap) or abs(gap - wall.zero_gap) < 1e-3


def test_the_nonadhesive_law_never_pulls() -> None:
    wall = LennardJonesSpline(0)
    response = wall.evaluate(np.linspace(0.5, 3, 1001))
    assert response.traction.min() == 0.0
    assert wall.work_of_adhesion == 0.0
    assert response.energy[-1] == 0.0
    # It is the paper's law without its attraction: the same pressure where it pushes.
    adhesive = LennardJonesSpline(0.3).evaluate(np.linspace(0.5, 1, 101))
    np.testing.assert_array_equal(wall.evaluate(np.linspace(0.5, 1, 101)).traction, adhesive.traction)


def test_a_table_converges_to_the_law_it_samples() -> None:
    wall = LennardJonesSpline(0.34641)
    gap = np.linspace(0.71, 1.4, 4001)
    exact = wall.evaluate(gap)
    # The second derivative of the pressure jumps at a0, by J; within the interval that holds the jump the
    # spline deviates by at most J h²/8, the bound of linear interpolation.
    jump = abs(0.5 / 6 * (110 - 20) - 4 * 0.5 / wall.range)
    for knots in (101, 401):
        spacing = (1 + wall.range - wall.core) / (knots - 1)
        error = np.abs(table_of(wall, knots).evaluate(gap).traction - exact.traction).max()
        assert 0 < error < jump * spacing**2 / 8
    table = table_of(wall, 401)
    assert table.work_of_adhesion == pytest.approx(wall.work_of_adhesion, rel=1e-5)
    assert table.zero_gap == pytest.approx(1.0, abs=1e-6)


def test_a_table_is_the_cubic_through_its_rows_and_a_line_below_them() -> None:
    gap, traction = np.array([-0.2, 0.1, 0.5, 1.4, 1.9, 3.0]), np.array([1.0, 0.2, -0.1, -0.4, -0.15, 0.0])
    law, spline = TabulatedWall(gap, traction).law, CubicSpline(gap, traction)
    inside, below = np.concatenate([gap[:-1], [-0.1, 0.3, 0.9, 1.7, 2.9]]), np.array([-0.21, -2.0])
    slope, depth = spline(-0.2, 1), -0.2 - below
    energy = [spline.integrate(z, 3.0) for z in inside]
    start = spline.integrate(-0.2, 3.0)
    expected = np.concatenate(
        [
            [energy, spline(inside), -spline(inside, 1)],
            [start + depth * (1.0 - 0.5 * slope * depth), 1.0 - slope * depth, np.full(2, -slope)],
            np.zeros((3, 2)),
        ],
        axis=1,
    )
    z = np.concatenate([inside, below, [3.0, 9.0]])
    for response in (evaluate(law, z), laws.ON_ARRAYS[laws.TABLE](np, z, law.parameters)):
        np.testing.assert_allclose(response, expected, rtol=1e-12, atol=1e-14)


def test_a_table_that_ends_steeply_softens_most_just_before_its_end() -> None:
    gap, traction = np.array([0.0, 1.0, 2.0, 3.0, 4.0]), np.array([1.0, -0.1, -0.2, -0.4, 0.0])
    slope = CubicSpline(gap, traction)(gap, 1)
    assert slope.argmax() == 4
    assert TabulatedWall(gap, traction).largest_softening == pytest.approx(slope[-1], rel=1e-12)


@pytest.mark.parametrize(
    ("gap", "traction", "fault"),
    [
        ([0.7, 0.8, 0.9], [1, 0.5, 0], "at least 4 rows"),
        ([0.7, 0.8, 0.8, 1], [1, 0.5, 0.2, 0], "increase"),
        ([0.7, 0.8, 0.9, 1], [1, np.nan, 0.2, 0], "finite"),
        ([0.7, 0.8, 0.9, 1], [1, 0.5, 0.2, 0.1], "vanished"),
        ([0.7, 0.8, 0.9, 1], [-1, 0.5, 0.2, 0], "repulsive"),
    ],
)
def test_a_table_that_is_no_wall_is_refused(gap: list[float], traction: list[float], fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        TabulatedWall(np.array(gap), np.array(traction))


@given(st.integers(4, 12), st.integers(0, 2**32), st.sampled_from([-1.0, 0.0, 0.5, 2.0]))
def test_the_zero_of_a_table_is_the_first_root_of_its_spline(knots: int, seed: int, level: float) -> None:
    """Also where the traction changes its sign twice between two knots, or never."""
    rng = np.random.default_rng(seed)
    gap, traction = np.cumsum(rng.uniform(0.1, 1.0, knots)), level + rng.normal(size=knots)
    traction[0], traction[-1] = 1.0, 0.0
    roots = CubicSpline(gap, traction).roots(extrapolate=False)
    assert TabulatedWall(gap, traction).zero_gap == min(roots[np.isfinite(roots)], default=gap[-1])


@pytest.mark.parametrize("bad", [{"range": -0.1}, {"range": np.nan}, {"range": 0.1, "core": 1.2}])
def test_a_law_that_is_none_is_refused(bad: dict[str, float]) -> None:
    with pytest.raises(ArgumentError, match="allowed"):
        LennardJonesSpline(**bad)


@pytest.mark.parametrize("shape", get_args(Shape))
@given(st.floats(-4, 1.5), st.floats(-2, 1.5), st.floats(-2, 1))
@settings(max_examples=8)
def test_an_attraction_on_a_core_has_the_work_and_the_range_asked_for(
    shape: Shape, work: float, stiffness: float, reach: float
) -> None:
    # All in units of the range, as the dimensions of w and K ask for.
    r = 10.0**reach
    w, k = 10.0**work * r, 10.0**stiffness / r
    wall = attraction_on_core(shape, w, r, k, 10 * r / 10.0**stiffness)
    # A spline through 101 knots follows the law to 1e-6; the exponential is a formula.
    assert wall.work_of_adhesion == pytest.approx(w, rel=1e-6 if shape == "spline" else 1e-12)
    assert wall.effective_range == pytest.approx(r, rel=1e-6)
    if shape == "spline":
        assert wall.zero_gap == pytest.approx(0.0, abs=1e-12 * r)


def test_an_attraction_on_a_core_refuses_what_has_no_meaning() -> None:
    with pytest.raises(ArgumentError, match=r"spline.*exponential"):
        attraction_on_core("square", 0.1, 0.1, 1.0)
    with pytest.raises(ArgumentError, match="effective_range"):
        attraction_on_core("spline", 0.1, -0.1, 1.0)


@pytest.mark.parametrize(("reach", "stiffness"), [(0.4, 1e10), (1e6, 5.0), (1e20, 5.0), (0.4, 2.0**70)])
def test_a_table_that_cannot_follow_its_law_is_refused(reach: float, stiffness: float) -> None:
    """Such a law had 450 times the work of adhesion, or a billionth of the range, that it was asked for."""
    with pytest.raises(ArgumentError, match="a core nearer to"):
        attraction_on_core("spline", 1e-3, reach, stiffness)


LAWS: dict[str, Callable[[float], Wall]] = {
    **{name: partial(made, 1.0) for name, made in IN_UNITS.items() if name != "hard"},
    "lennard-jones-spline": lambda s: LennardJonesSpline(0.35 * s, 0.5 / s),
}
"""Of each kind of law one whose lengths are s times as long, at the same tractions."""


@pytest.mark.parametrize("kind", LAWS)
@given(exponent=st.floats(-30, 30))
@example(exponent=-3.0)
@example(exponent=4.0)
@settings(max_examples=5)
def test_a_law_of_any_length_knows_its_own_numbers(kind: str, exponent: float) -> None:
    s = 10.0**exponent
    wall, base = LAWS[kind](s), LAWS[kind](1.0)
    # Ten digits: laws about a0 have a short range as the difference of two gaps, which leaves no more of it.
    near = partial(pytest.approx, rel=1e-10 if kind != "lennard-jones-spline" else max(1e-10, 1e-15 / s))
    assume(kind != "lennard-jones-spline" or abs(exponent) < 6)
    assert wall.largest_tension == near(base.largest_tension)
    assert wall.largest_softening * s == near(base.largest_softening)
    assert wall.work_of_adhesion / s == near(base.work_of_adhesion)
    assert wall.effective_range / s == near(base.effective_range)
    beyond = wall.zero_gap + base.range * s * np.array([-0.1, 0.2, 0.6])
    tensions = [wall.largest_tension_from(gap) for gap in beyond]
    assert tensions[0] == wall.largest_tension
    assert tensions[2] == near(-wall.evaluate(beyond[2]).traction.item())


@pytest.mark.parametrize("kind", LAWS)
def test_the_largest_tension_and_softening_are_those_of_samples(kind: str) -> None:
    wall = LAWS[kind](1.0)
    gap = np.concatenate([wall.zero_gap + np.linspace(0.0, 3.0, 30001), [0.0, np.nextafter(wall.reach, 0.0)]])
    sampled = wall.evaluate(gap[(gap >= wall.zero_gap) & np.isfinite(gap)])
    # Half the spacing of the sample squared, 1.3e-9, times a second derivative of some hundreds of the value.
    assert wall.largest_tension == pytest.approx(-sampled.traction.min(), rel=1e-6)
    assert wall.largest_softening == pytest.approx(-sampled.stiffness.min(), rel=1e-6)
    assert wall.largest_tension >= -sampled.traction.min() * (1 - 1e-12)
    assert wall.largest_softening >= -sampled.stiffness.min() * (1 - 1e-12)


UNTRUNCATED = {name: wall for name, wall in kinds.WALLS.items() if np.isinf(wall.reach)}


@pytest.mark.parametrize("wall", UNTRUNCATED.values(), ids=UNTRUNCATED.keys())
def test_every_law_knows_its_own_numbers(wall: Wall) -> None:
    """Against nothing but samples of the law: where it crosses zero, how deep, how far."""
    at_zero = wall.evaluate(np.array([wall.zero_gap - 1e-6, wall.zero_gap, wall.zero_gap + 1e-6])).traction
    assert at_zero[0] > 0 > at_zero[2]
    assert abs(at_zero[1]) < 1e-15
    gap = wall.zero_gap + np.linspace(0, 60, 60001)
    sampled = wall.evaluate(gap)
    # Simpson over the sample; the tail beyond 60 a0 is below 1e-5 of the whole for the slowest law, (60)^-3/27.
    assert -simpson(sampled.traction, gap) == pytest.approx(wall.work_of_adhesion, rel=1e-4)
    assert wall.range == wall.effective_range


def test_numbers_of_the_untruncated_laws() -> None:
    ninethree, twelvesix = (InversePowers(powers, adhesion_length=0.005) for powers in ((9, 3), (12, 6)))
    for wall in (ninethree, twelvesix):
        assert wall.work_of_adhesion == pytest.approx(0.005, rel=1e-12)
    assert ninethree.effective_range == pytest.approx(1.15294, abs=5e-6)
    assert twelvesix.effective_range == pytest.approx(0.62043, abs=5e-6)
    # Within the effective range lie 85 % and 89 % of the binding, the paper's "> 85 %".
    for wall, percent in ((ninethree, 85.0), (twelvesix, 89.2)):
        left = -float(wall.evaluate(np.array(1 + wall.effective_range)).energy)
        assert 100 * (1 - left / 0.005) == pytest.approx(percent, abs=0.06)


def test_an_exponential_on_a_stiffer_core_tends_to_the_exponential() -> None:
    for stiffness in (2.0, 20.0, 200.0):
        wall = Exponential(0.005, 0.3, stiffness)
        assert wall.zero_gap == pytest.approx(-0.005 / (0.3 * stiffness), rel=1e-12)
        assert wall.work_of_adhesion == pytest.approx(0.005 + 0.005**2 / (2 * 0.3**2 * stiffness), rel=1e-12)
    limit = 0.3 * (2 / 3 * gamma(2 / 3)) ** -3
    errors = [abs(Exponential(0.005, 0.3, k).effective_range / limit - 1) for k in (2e2, 2e4)]
    # The weight Δ^(-1/3) counts from the shifted zero: an error of (zero/ρ)^(2/3), 0.4 % and 100^(2/3) times less.
    assert errors[0] < 0.02
    assert errors[1] < errors[0] / 10


@pytest.mark.parametrize("stiffness", [3e-4, 1.0, 1e4])
def test_the_effective_range_of_an_exponential_is_that_of_its_integrals(stiffness: float) -> None:
    """On cores that end 400 decays before the zero of gap, 0.06 and hardly any; the quadrature has ten digits."""
    wall = Exponential(0.005, 0.2, stiffness)

    def tension(x: float) -> float:
        return -float(wall.evaluate(np.array(wall.zero_gap + x * wall.effective_range)).traction)

    assert paper.effective_range(tension) == pytest.approx(1.0, rel=1e-10)


@pytest.mark.parametrize(
    "make",
    [
        lambda: InversePowers((3, 9), 1.0),
        lambda: InversePowers((9, 3), -1.0),
        lambda: Exponential(0.1, 0.1, 0.0),
        lambda: Exponential(0.1, -0.1, 1.0),
    ],
)
def test_an_untruncated_law_that_is_none_is_refused(make: Callable[[], Wall]) -> None:
    with pytest.raises(ArgumentError, match="allowed"):
        make()


def spline_of_the_paper(z: float, k: float, r: float) -> float:
    """Eq. (S-6), as it is printed."""
    if z <= 1:
        return k / 6 * (z**-10 - z**-4)
    return -k * (z - 1) * (1 - (z - 1) / r) ** 2 if z < 1 + r else 0.0


@pytest.mark.parametrize(
    ("wall", "traction", "ends"),
    [
        (LennardJonesSpline(0.35), lambda z: spline_of_the_paper(z, 0.5, 0.35), (0.7, 1.0, 1.35)),
        (LennardJonesSpline(1.1, 2.0, core=0.8), lambda z: spline_of_the_paper(z, 2.0, 1.1), (0.8, 1.0, 2.1)),
        (InversePowers((9, 3), 0.5), lambda z: 0.5 / 6 * (z**-10 - z**-4), (0.7, 1.0, np.inf)),
        (InversePowers((12, 6), 2.0, 0.9), lambda z: 2.0 / 6 * (z**-13 - z**-7), (0.9, 1.0, np.inf)),
        (
            Exponential(0.005, 0.3, 2.0),
            lambda z: -0.005 / 0.3 * (np.exp(-z / 0.3) if z >= 0 else 1.0) - 2.0 * min(z, 0.0),
            (-0.3, 0.0, np.inf),
        ),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Wall) else "",
)
def test_a_law_is_the_printed_one(wall: Wall, traction: Callable[[float], float], ends: tuple[float, ...]) -> None:
    """Traction, its integral and its slope at gaps on both sides of the joints; below the core it goes on as a line."""
    law = wall.law
    assert law is not None
    formula = laws.ON_ARRAYS.get(law.kind) or partial(laws.powers_on_arrays, m=wall.powers[0], n=wall.powers[1])
    core, joint, last = ends
    for z in [*np.linspace(core + 1e-3, joint - 1e-3, 7), *np.linspace(joint + 1e-3, min(last, joint + 2) + 0.1, 9)]:
        parts = [z, *(end for end in (joint, last) if z < end), *([] if last == np.inf else [last + 1])]
        energy = sum(quad(traction, a, b, epsabs=1e-12)[0] for a, b in pairwise(sorted(parts)))
        slope = (traction(z + 1e-6) - traction(z - 1e-6)) / 2e-6
        for response in (evaluate(law, np.array([z])), formula(np, np.array([z]), law.parameters)):
            found = [float(values[0]) for values in response]
            np.testing.assert_allclose(found, [energy, traction(z), -slope], rtol=1e-7, atol=1e-9)
    if np.isfinite(wall.core):
        energy, push, stiffness = (float(values[0]) for values in evaluate(law, np.array([core])))
        expected = [energy + 0.2 * push + 0.5 * stiffness * 0.2**2, push + 0.2 * stiffness, stiffness]
        at = np.array([core - 0.2])
        for response in (evaluate(law, at), formula(np, at, law.parameters)):
            np.testing.assert_allclose(np.ravel(response), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("table", "wall"),
    [
        ({"law": "lennard-jones-spline", "range": 0.3, "core": 0.8}, LennardJonesSpline(0.3, core=0.8)),
        (
            {"law": "lennard-jones-spline", "adhesion_length": 0.005, "core": 0.8},
            LennardJonesSpline(adhesion_length=0.005, core=0.8),
        ),
        (
            {"law": "lennard-jones-9-3", "adhesion_length": 0.005, "core": 0.8},
            InversePowers((9, 3), core=0.8, adhesion_length=0.005),
        ),
        (
            {"law": "lennard-jones-12-6", "adhesion_length": 0.005, "core": 0.9},
            InversePowers((12, 6), core=0.9, adhesion_length=0.005),
        ),
        (
            {"law": "exponential", "surface_energy": 0.005, "decay_length": 0.3, "core_stiffness": 2.0},
            Exponential(0.005, 0.3, 2.0),
        ),
    ],
)
def test_a_table_of_an_input_is_the_law_that_it_names(table: dict[str, Any], wall: Wall) -> None:
    read = Wall.kinds[table["law"]].model_validate(table, context={})
    assert read.build() == wall
    # The range of the paper's law of the same work of adhesion.
    work = table.get("adhesion_length", table.get("surface_energy", 0.3**2 / 24))
    assert read.equivalent_range == pytest.approx(LennardJonesSpline(adhesion_length=work).range)


def test_a_hard_wall_touches_where_no_gap_is_left() -> None:
    np.testing.assert_array_equal(HardWall().touches(np.array([-0.1, 0.0, 1e-300, 0.5])), [True, True, False, False])


def test_the_pull_of_an_attraction_is_that_of_the_law_that_it_is_made_of() -> None:
    """Twice the stiffness at the minimum of the paper's law of this work and range, up to its effective range."""
    table = AttractionOnCore("spline", adhesion_length=0.005, effective_range=0.35, core_stiffness=5.0)
    law = LennardJonesSpline(adhesion_length=0.005)
    of_one_range = 24 * law.work_of_adhesion / law.range**2
    assert of_one_range == pytest.approx(2 * law.minimum_stiffness)
    assert table.pull == pytest.approx(of_one_range * (law.range / 0.35) ** 2)


@pytest.mark.parametrize("powers", [(9, 3), (12, 6), (7, 2)])
def test_inverse_powers_are_stationary_where_tension_and_softening_are_largest(powers: tuple[int, int]) -> None:
    wall = InversePowers(powers, adhesion_length=0.1)
    gaps = np.linspace(0.8, 3.0, 220_001)
    found = wall.evaluate(gaps)
    largest = gaps[[np.argmin(found.traction), np.argmin(found.stiffness)]]
    # Extrema on a ladder of 1e-5 are known to a step.
    np.testing.assert_allclose(wall.stationary_gaps, largest, atol=1e-5)
