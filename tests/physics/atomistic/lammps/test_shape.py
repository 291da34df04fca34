"""Walls that follow the atoms: one energy and its gradient, natively where there is a formula, else in this process."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import run_command, run_in_process
from atomistic.lammps.result import DeckResult, read_result
from atomistic.lammps.session import Session
from atomistic.lammps.shape import (
    MOST_WAVES,
    HeightSpline,
    Round,
    Shape,
    Waves,
    heights_of_shape,
    map_error,
    misfit,
    shape_of,
)
from tests.problems import two_ranks

PERIOD = (8.0, 7.0)
SITES = np.meshgrid(np.arange(8.0), np.arange(7.0), indexing="ij")
WALL = c.LennardJonesSpline(adhesion_length=0.005)
SHAPES: dict[str, Shape] = {
    "sphere": Round(PERIOD, 20.0),
    "cylinder": Round(PERIOD, 20.0, across=(True, False)),
    "punch": Round(PERIOD, 9.0, 1.7),
    "sine": Waves(PERIOD, 0.1, ((-0.1, 2, 1, 0.0),)),
    "waves": Waves(PERIOD, 0.0, ((0.1, 1, 0, 0.3), (0.05, 2, -2, -1.0), (0.02, 0, 2, 2.0))),
}
# Of wavelengths down to 3.5 a0: no array has more to say between its points.
SHAPES["array"] = HeightSpline(SHAPES["waves"].evaluate(*SITES).height)

rounds = st.builds(
    Round,
    st.just(PERIOD),
    st.floats(1, 1e3),
    st.floats(0, 3),
    st.sampled_from([(True, True), (True, False), (False, True)]),
)
sums = st.builds(
    Waves,
    st.just(PERIOD),
    st.floats(-1, 1),
    st.lists(
        st.tuples(st.floats(-0.3, 0.3), st.integers(-3, 3), st.integers(-3, 3), st.floats(-7, 7)), max_size=MOST_WAVES
    ).map(tuple),
)
arrays = st.integers(0, 2**32).map(lambda seed: HeightSpline(0.1 * np.random.default_rng(seed).standard_normal((8, 7))))


def displaced(shape: Shape, amplitude: float = 0.2) -> Deck:
    """A slab out of equilibrium, its surface atoms far from their sites; nothing is relaxed."""
    rng = np.random.default_rng(5)
    slab = Slab((8, 7), mobile=2)
    start = np.zeros((slab.layers, *slab.shape, 3))
    start[0] = rng.uniform(-amplitude, amplitude, (*slab.shape, 3))
    return Deck(slab, Springs(), WALL, shape.evaluate(*SITES).height, 1.0, start, tolerance=1e9, shape=shape)


@given(st.one_of(rounds, sums, arrays), st.floats(-20, 20), st.floats(-20, 20))
def test_slopes_are_the_gradient_of_the_height_which_has_the_period_of_the_slab(shape, x, y):
    x, y, h = np.array([x]), np.array([y]), 1e-4
    at = shape.evaluate(x, y)
    if isinstance(shape, Round):
        # It has edges where one period meets the next, and its punch is bent where the flat ends.
        far = [abs(abs((v - p / 2 + p / 2) % p - p / 2) - p / 2) for v, p in zip((x, y), PERIOD, strict=True)]
        if min(far) < 2 * h:
            return
    # Errors: of the step, h²/6 times the third derivative of at most 12 waves of 0.3 a0 and (2π 3/7)³; of a bend, h/R;
    # of rounding, 1e-14/h.
    for dx, dy, slope in ((h, 0, at.slope_x), (0, h, at.slope_y)):
        found = (shape.evaluate(x + dx, y + dy).height - shape.evaluate(x - dx, y - dy).height) / (2 * h)
        assert found == pytest.approx(slope, abs=2 * h if isinstance(shape, Round) else 2e-6)
    there = shape.evaluate(x + PERIOD[0], y - 2 * PERIOD[1])
    for here, moved in zip(at, there, strict=True):
        assert moved == pytest.approx(here, abs=1e-10)


@pytest.mark.parametrize("name", SHAPES)
def test_the_wall_in_lammps_is_its_formula_and_its_force_the_gradient_of_its_energy(tmp_path, name):
    deck = displaced(SHAPES[name])
    directory = write_deck(tmp_path, deck)
    result = run_in_process(directory)
    at = deck.slab.positions[0] + deck.start[0]
    height, *slopes = deck.shape.evaluate(at[..., 0], at[..., 1])
    law = WALL.evaluate(deck.separation + height - deck.start[0, ..., 2])
    scale = np.abs(law.traction).max()
    # Rounding of coordinates up to 8 and of cosines, times the stiffness of the law, 30.
    assert np.allclose(result.heights, height, rtol=0, atol=1e-13)
    assert np.allclose(result.traction, law.traction, rtol=0, atol=1e-11 * scale)
    along = np.random.default_rng(6).standard_normal(deck.start.shape)
    along[deck.slab.mobile :] = 0
    along /= np.linalg.norm(along)
    h = 1e-4
    with Session(directory) as session:
        _, without = session.evaluate(deck.start)
        session.command(f"variable separation index {deck.separation!r}")
        session.run("in.wall")
        energy = {i: session.evaluate(deck.start + i * h * along)[0] for i in range(-2, 3)}
    acting = (result.forces - without)[0]
    for axis, slope in enumerate(slopes):
        assert np.allclose(acting[..., axis], law.traction * slope, rtol=0, atol=1e-11 * scale)
    assert np.allclose(acting[..., 2], -law.traction, rtol=0, atol=1e-11 * scale)
    assert result.lateral_x == pytest.approx(np.sum(law.traction * slopes[0]), abs=1e-10 * scale)
    assert result.lateral_y == pytest.approx(np.sum(law.traction * slopes[1]), abs=1e-10 * scale)
    assert result.wall_energy == pytest.approx(law.energy.sum(), abs=1e-11 * scale)
    assert result.total_energy == pytest.approx(energy[0], rel=1e-14)
    # Fourth order: h⁴/30 of the fifth derivative, 1e5 below the core's gap of 0.8, against rounding of 1e-14/h.
    slope = (8 * (energy[1] - energy[-1]) - (energy[2] - energy[-2])) / (12 * h)
    assert slope == pytest.approx(-np.vdot(result.forces, along), rel=1e-7, abs=1e-9)


def test_a_spline_errs_as_much_across_as_along():
    """Also of an even number of points, whose shortest wave is not one of a known phase."""
    heights = np.random.default_rng(7).standard_normal((6, 4))
    assert HeightSpline(heights).error == pytest.approx(HeightSpline(heights.T).error, rel=1e-9)


@pytest.mark.parametrize("count", [0, 1, MOST_WAVES, MOST_WAVES + 1])
def test_heights_of_few_waves_are_their_sum_and_others_a_spline(count):
    """Over a period whose points are not a0 apart; the shortest wave has no phase, and makes a spline of any sum."""
    period, rng = (12.0, 9.0), np.random.default_rng(count)
    x, y = np.meshgrid(np.arange(8) * 1.5, np.arange(10) * 0.9, indexing="ij")
    modes = [(m, n) for n in range(4) for m in range(-3, 4) if n > 0 or m > 0][:count]
    parts = [(rng.uniform(0.1, 1), m, n, rng.uniform(-3, 3)) for m, n in modes]
    waves, more = Waves(period, 0.3, tuple(parts[:MOST_WAVES])), Waves(period, 0.0, tuple(parts[MOST_WAVES:]))
    heights = waves.evaluate(x, y).height + more.evaluate(x, y).height
    found = shape_of(heights, period)
    assert isinstance(found, HeightSpline) == (count > MOST_WAVES)
    assert isinstance(shape_of(heights + 0.01 * np.cos(np.pi * np.arange(8))[:, None], period), HeightSpline)
    if count <= MOST_WAVES:
        assert len(found.waves) == count
        for one, other in zip(found.evaluate(x + 0.37, y - 0.2), waves.evaluate(x + 0.37, y - 0.2), strict=True):
            np.testing.assert_allclose(one, other, atol=1e-12)
    assert misfit(found, heights, np.stack([x, y], axis=-1)) == 0.0
    assert misfit(found, heights + 0.01, np.stack([x, y], axis=-1)) == pytest.approx(0.01)


@pytest.mark.parametrize("shape", [SHAPES["waves"], SHAPES["punch"]], ids=["waves", "punch"])
def test_a_map_has_four_heights_in_each_spacing_and_states_how_its_spline_errs_in_between(shape):
    grid = c.Grid((4, 7), PERIOD)
    heights = heights_of_shape(shape, grid)
    assert heights.shape == (16, 28)
    x, y = np.meshgrid(np.arange(16) / 2, np.arange(28) / 4, indexing="ij")
    np.testing.assert_allclose(heights, shape.evaluate(x, y).height, atol=1e-14)
    between, exact = (each.evaluate(x + 1 / 4, y + 1 / 8) for each in (HeightSpline(heights, (0.5, 0.25)), shape))
    by_height, *by_slope = (np.abs(a - b).max() for a, b in zip(between, exact, strict=True))
    assert map_error(shape, grid) == pytest.approx((by_height, max(by_slope)), rel=1e-9)


def relaxed(tmp_path: Path, shape: Shape | None, heights, separation: float = 0.97, **changes) -> DeckResult:
    deck = Deck(Slab((8, 7), mobile=4), Springs(), WALL, heights, separation, tolerance=1e-11, shape=shape)
    return run_in_process(write_deck(tmp_path / "deck", replace(deck, **changes), force=True)).require()


def test_the_force_on_the_wall_is_that_on_the_atoms_and_belongs_to_its_energy(tmp_path):
    shape = SHAPES["sphere"]
    deck = Deck(Slab((8, 7), 2), Springs(), WALL, shape.evaluate(*SITES).height, 0.97, tolerance=1e-12, shape=shape)
    directory = write_deck(tmp_path, deck)

    def at(offset: float) -> DeckResult:
        text = (directory / "in.wall").read_text()
        line = next(line for line in text.splitlines() if line.startswith("variable        offset_x"))
        (directory / "in.wall").write_text(text.replace(line, f"variable        offset_x index {offset!r}"))
        return run_in_process(directory).require()

    # The energy of equilibria changes with the wall's place as the wall is pushed: by minus its force on the atoms.
    h, here = 1e-3, at(0.25)
    slope = (at(0.25 + h).total_energy - at(0.25 - h).total_energy) / (2 * h)
    assert abs(here.lateral_x) > 1e-4
    # h² (2π)² of the force, whose period is a0, by the step.
    assert slope == pytest.approx(here.lateral_x, rel=40 * h**2, abs=1e-9)
    # What the wall pushes sideways arrives at the frozen base: nothing is left on any mobile atom.
    assert here.largest_force < 1e-12
    # One a0 on, all is as before.
    after = at(1.25)
    assert after.force == pytest.approx(here.force, abs=1e-9)
    assert after.lateral_x == pytest.approx(here.lateral_x, abs=1e-9)
    assert np.allclose(np.roll(here.gap, 1, axis=0), after.gap, rtol=0, atol=1e-9)


def test_site_and_atom_differ_by_the_slope_times_the_lateral_displacement(tmp_path):
    loads = []
    for size in (0.02, 0.01):
        shape = Waves(PERIOD, 0.0, ((size, 1, 0, 0.4), (size, 2, 1, 0.2)))
        heights = shape.evaluate(*SITES).height
        at_site, at_atom = (relaxed(tmp_path, one, heights, 0.98) for one in (None, shape))
        moved = at_site.displacements[0]
        by_slope = np.abs(shape.evaluate(*SITES).slope_x * moved[..., 0]).max()
        assert np.abs(at_atom.gap - at_site.gap).max() < 20 * by_slope + 20 * size**2
        loads.append(abs(at_atom.force / at_site.force - 1))
    # First order in slope times displacement, which itself is proportional to the slope: a quarter at half the height.
    assert loads[0] / loads[1] == pytest.approx(4, rel=0.15)


def test_few_waves_are_native_and_an_array_of_them_agrees_within_the_error_that_it_states(tmp_path):
    few = SHAPES["waves"].evaluate(*SITES).height
    native = shape_of(few)
    assert isinstance(native, Waves)
    x, y = np.random.default_rng(1).uniform(-9, 9, (2, 50))
    for found, expected in zip(native.evaluate(x, y), SHAPES["waves"].evaluate(x, y), strict=True):
        assert np.allclose(found, expected, rtol=0, atol=1e-14)
    spline = HeightSpline(few)
    by_height, by_slope = spline.error
    # Waves of 0.05 and 0.02 a0, 2.6 and 3.5 a0 long: cubic splines err by some per cent of them, slopes by as much.
    assert 1e-4 < by_height < 1e-2
    assert 1e-4 < by_slope < 2e-2
    off = [np.abs(a - b).max() for a, b in zip(spline.evaluate(x, y), native.evaluate(x, y), strict=True)]
    assert off[0] < 1.5 * by_height
    assert max(off[1:]) < 1.5 * by_slope
    results = [run_in_process(write_deck(tmp_path, displaced(one), force=True)) for one in (native, spline)]
    stiffness = np.abs(WALL.evaluate(results[0].gap).stiffness)
    assert (np.abs(results[1].traction - results[0].traction) <= 1.5 * by_height * stiffness.max()).all()
    rough = c.SelfAffine(0.8, 0.1, 3, 16).synthesise(c.Grid.square(16), np.random.default_rng(1))
    assert isinstance(shape_of(rough), HeightSpline)
    # Cubic splines err by (2π/8)^4/384 = 1e-3 of waves of 8 a0, the shortest here, which are a part of the heights.
    smooth = c.SelfAffine(0.8, 0.1, 8, 16).synthesise(c.Grid.square(32), np.random.default_rng(1))
    assert HeightSpline(smooth).error[0] < 1e-3 * np.ptp(smooth)


def test_an_array_goes_through_a_staircase_by_a_stock_lmp_on_two_ranks(tmp_path):
    heights = 0.02 * np.random.default_rng(1).standard_normal((6, 6))
    with pytest.warns(UserWarning, match="fewer than 4 points"):
        contact = c.Contact(heights, WALL)
    deck = a.deck(contact, separations=[1.05, 1.0], depth=2.2, follows="atom")
    # Two ranks go the same way to it: of more digits the second half of the evaluations says nothing.
    deck = replace(deck, tolerance=1e-6)
    run = a.run_deck(deck.write(tmp_path / "deck"))
    assert run.converged
    assert run.finished
    assert "bicubic spline" in (tmp_path / "deck" / "README.txt").read_text()
    deck.write(tmp_path / "two")
    there = run_command(tmp_path / "two", f"{two_ranks()} -var last 1").require()
    first = read_result(run.directory, 1)
    assert there.evaluations == first.evaluations
    assert there.force == pytest.approx(first.force, rel=1e-9)


@pytest.mark.parametrize("shape", [(3, 5), (8, 7)])
def test_the_cells_of_an_array_are_its_spline(shape):
    rng = np.random.default_rng(2)
    spline = HeightSpline(rng.standard_normal(shape))
    cell = np.stack([rng.integers(0, n, 40) for n in shape])
    s, t = rng.random((2, 40))
    a_mn = spline.cells[:, :, cell[0], cell[1]]
    found = sum(a_mn[m, n] * s**m * t**n for m in range(4) for n in range(4))
    # Rounding of a dozen terms of order 10.
    assert np.allclose(found, spline.evaluate(cell[0] + s, cell[1] + t).height, rtol=0, atol=1e-12)


def test_a_shape_that_is_not_that_of_the_heights_is_refused():
    with pytest.raises(ValueError, match=r"shape = .* one of these heights"):
        replace(displaced(SHAPES["sine"]), heights=np.zeros((8, 7)))
    with pytest.raises(ValueError, match=r"waves = .* at most 12 waves"):
        Waves(PERIOD, 0.0, ((0.1, 1, 0, 0.0),) * 13)
    for wave in (5, "0.1,1", (0.1, 1, 0)):
        with pytest.raises(ValueError, match=r"waves = .*\(A, mx, my, φ\) of each wave"):
            Waves(PERIOD, 0.0, (wave,))
