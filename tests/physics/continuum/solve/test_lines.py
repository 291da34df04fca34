"""Line contacts: grids one point wide, against strips, exact contacts in two dimensions, and a million points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum as c
from continuum.inputs.arguments import ArgumentError
from continuum.model.fourier import Real, cut, padded, prolong, restrict
from continuum.model.problem import ContactProblem
from continuum.model.walls import Wall
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from tests.classical import AdhesiveWave, Westergaard
from tests.kinds import covering


def line(n: int, spacing: float = 1.0) -> c.Grid:
    return c.Grid((1, n), (1.0, n * spacing))


def rough(n: int, seed: int = 1) -> Real:
    return c.SelfAffine(0.8, 0.1, 8, n / 4).synthesise(line(n), np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("wall", "n"),
    covering([c.HardWall(), c.HardWall(0.1), c.LennardJonesSpline(adhesion_length=0.002)], [96, 255, 512]),
)
def test_a_line_is_a_strip(wall: Wall, n: int) -> None:
    """The same tractions as on two and three points across, whichever grids the solver takes on its way."""
    heights, settings = rough(n), Settings(1e-9)
    found = []
    for rows in (1, 2, 3):
        grid = c.Grid((rows, n), (float(rows), float(n)))
        problem = ContactProblem(grid, wall, np.repeat(heights, rows, 0), c.HalfSpace())
        # From the same start on the same branch, since under adhesion there may be several states.
        start = None if wall.law is None else np.repeat(np.maximum(heights - heights.min(), 0.0) + 1.0, rows, 0)
        fixed = Settings(1e-9, warm_grids=0)
        found.append(solve(problem, "mean-pressure", 0.005, fixed if start is not None else settings, start).require())
    for other in found[1:]:
        np.testing.assert_allclose(other.traction[:1], found[0].traction, atol=1e-6)  # 1e-9 over all, and more at edges
        assert other.area_rep == found[0].area_rep


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
def test_westergaards_wave(part: float) -> None:
    n, wavelength = 8192, 64.0
    grid = line(n, wavelength / n)
    wave = Westergaard(wavelength * 0.1 / np.pi, wavelength, part * 0.1)
    heights = wave.amplitude * np.cos(2 * np.pi * grid.positions[1] / wavelength) * -1
    problem = ContactProblem(grid, c.HardWall(), heights, c.HalfSpace())
    found = solve(problem, "mean-pressure", wave.mean_pressure, Settings(1e-8)).require()
    # The edge is known to a point; the pressure ends as a square root, an rms error of one spacing.
    assert found.area_rep * wavelength / 2 == pytest.approx(wave.half_width, abs=grid.spacing[1])
    x = np.minimum(grid.positions[1], wavelength - grid.positions[1])
    assert np.sqrt(np.mean((found.traction - wave.pressure(x)) ** 2)) < 0.5 * 0.1 * n**-1 * 10


@pytest.mark.parametrize("wavelength", [256, *(pytest.param(one, marks=pytest.mark.long) for one in (1024, 4096))])
def test_johnsons_adhesive_wave(wavelength: int) -> None:
    """Pull-off of a wave with adhesion, whose short range Johnson's theory is the limit of: it differs as 4/λ."""
    wall, n = c.LennardJonesSpline(adhesion_length=0.005), 2 * wavelength
    work, alpha = wall.work_of_adhesion, 0.3
    wave = AdhesiveWave(float(np.sqrt(2 * wavelength * work) / (np.pi * alpha)), float(wavelength), work)
    heights = wave.amplitude * (1 - np.cos(2 * np.pi * np.arange(n) / n))
    contact = c.Contact(heights[np.newaxis], wall, period=(1.0, float(wavelength)))
    # Steps shorter than the range of the attraction, which a longer one would leave at once.
    steps = np.linspace(1.0, 1.45, 46)
    states = contact.path(mean_gap=list(1 + wave.amplitude * steps))
    assert all(state.converged for state in states)
    assert -min(state.load for state in states) == pytest.approx(wave.pull_off_pressure, rel=6 / wavelength)


def test_coarser_lines_carry_their_waves() -> None:
    fine, coarse = line(64), line(32)
    values = c.SelfAffine(0.5, 0.1, 8, 32).synthesise(fine, np.random.default_rng(1))
    assert fine.coarser == c.Grid((1, 32), (1.0, 64.0))
    part, whole = padded(coarse.shape_q, np.complex128), padded(fine.shape_q, np.complex128)
    restrict(fine.forward(values), part)
    np.testing.assert_allclose(c.Grid((1, 32), (1.0, 64.0)).inverse(part), values[:, ::2], atol=1e-14)
    prolong(part, whole)
    np.testing.assert_allclose(fine.inverse(whole), values, atol=1e-14)
    assert cut(fine.wavenumber, coarse.shape_q).shape == coarse.shape_q


@given(hurst=st.floats(0.1, 0.9), seed=st.integers(0, 2**32 - 1))
def test_a_rough_line_has_its_slope_and_is_one_on_every_grid(hurst: float, seed: int) -> None:
    spectrum = c.SelfAffine(hurst, 0.1, 16, 128)
    small, large = (spectrum.synthesise(c.Grid((1, n), (1.0, 256.0)), np.random.default_rng(seed)) for n in (128, 512))
    assert c.moments(c.Grid((1, 512), (1.0, 256.0)), large).rms_slope == pytest.approx(0.1, rel=1e-12)
    np.testing.assert_allclose(large[:, ::4], small, atol=1e-12)


def test_the_power_of_a_line_gives_its_hurst_exponent() -> None:
    """C(q) ~ q^(-1-2H), so that the mean square of a difference of heights grows as the distance to 2H."""
    grid = line(4096)
    power = c.SelfAffine(0.7, 0.1, 4, 4096).power_q(grid)[0]
    q = grid.wavenumber[0]
    inside = (q > 0) & (q < 2 * np.pi / 4)
    assert np.polyfit(np.log(q[inside]), np.log(power[inside]), 1)[0] == pytest.approx(-1 - 2 * 0.7, abs=1e-9)


def test_a_path_with_adhesion_and_what_there_is_not() -> None:
    contact = c.Contact(rough(256), c.LennardJonesSpline(adhesion_length=0.002))
    assert all(state.converged for state in contact.path(mean_gap=[2.0, 1.6, 1.4, 1.6, 2.0]))
    state = contact.press(area=0.05).require()
    assert state.area_rep == pytest.approx(0.05, abs=0.5 / 256)
    assert state.stability().eigenvalue > 0
    with pytest.raises(ArgumentError, match="line load"):
        c.Contact(rough(64), c.HardWall(), c.NonPeriodicHalfSpace())
    with pytest.raises(ArgumentError, match=r"shape \(1, n\), a line"):
        c.Contact(rough(64).T, c.HardWall())


@pytest.mark.long
def test_a_million_points() -> None:
    """Of one wave: as many iterations as on a thousand."""
    counts = []
    for n in (2**10, 2**20):
        grid = line(n, 64 / n)
        heights = -0.5 * np.cos(2 * np.pi * grid.positions[1] / 64)
        problem = ContactProblem(grid, c.HardWall(), heights, c.HalfSpace())
        counts.append(solve(problem, "mean-pressure", 0.01, Settings(1e-7)).require().solution.iterations)
    assert counts[1] < 4 * counts[0]
