"""Elastic responses against limits and against the boundary-value problem itself."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from continuum.inputs.arguments import ArgumentError
from continuum.model.grid import Grid
from continuum.model.substrates import CubicLayer, HalfSpace, Layer, MeanMode, Response, TabulatedSubstrate
from continuum.model.substrates.crystal import CubicConstants


def bonded_layer(q: float, depth: float, nu: float) -> float:
    """K_q by integrating plane-strain elasticity through the layer: an oracle that knows no closed form.

    State (i u_x, u_z, i σ_xz, σ_zz) of exp(iqx), E* = 1: nothing in it diverges at ν = 1/2.
    """
    mu = (1 - nu) / 2  # G = E/(2(1+ν)) = E*(1-ν)/2
    r = nu / (1 - nu)
    # From σ_xz = μ(u_x' + iq u_z), σ_zz = M(u_z' + r iq u_x) with 1/M = (1-2ν)/(2μ(1-ν)), and equilibrium,
    # with a = i u_x and b = i σ_xz.
    inverse_m = (1 - 2 * nu) / (2 * mu * (1 - nu))
    matrix = np.array(
        [
            [0, q, 1 / mu, 0],
            [-q * r, 0, 0, inverse_m],
            [4 * mu * q**2 / (2 * (1 - nu)), 0, 0, q * r],
            [0, 0, -q, 0],
        ]
    )
    # From the base (u = 0) the two unknown tractions grow into the state of the surface.
    surface = expm(matrix * depth)[:, 2:]
    base = np.linalg.solve(surface[2:], [0.0, 1.0])  # σ_xz = 0, σ_zz = 1 on top
    return float(1 / (surface[1] @ base))


def test_layer_solves_its_boundary_value_problem() -> None:
    for qd in [0.05, 0.3, 1.0, 3.0]:
        for nu in [-0.3, 0.0, 0.25, 0.4, 0.49, 0.5]:
            depth = 3.0
            grid = Grid((4, 4), (2 * np.pi / (qd / depth), 1.0))
            found = Layer(depth, nu, "free").stiffness(grid)[1, 0]
            # Cancellation in the closed form at small qd: K's denominator is a difference of order (qd)³ of terms qd.
            assert found == pytest.approx(bonded_layer(qd / depth, depth, nu), rel=1e-9)


@given(st.floats(0.01, 0.5), st.floats(30, 1e6))
def test_a_deep_layer_is_a_half_space(nu: float, depth: float) -> None:
    grid = Grid.square(8)
    # exp(-2 q depth) (q depth)² is below 1e-17 for q depth > 2π 30/8 = 23.
    np.testing.assert_allclose(Layer(depth, nu, "free").stiffness(grid), HalfSpace("free").stiffness(grid), rtol=1e-14)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
def test_a_thin_layer_is_a_bed_of_springs(nu: float) -> None:
    grid = Grid.square(16)
    layer = Layer(1e-3, nu, "free")
    # The correction is of order (q depth)² ~ 1e-5/(1-2ν).
    np.testing.assert_allclose(
        layer.stiffness(grid).ravel()[1:], layer.compressive_stiffness, rtol=2e-5 / (1 - 2 * nu) ** 2
    )


def test_an_incompressible_layer_stiffens_as_a_lubricant() -> None:
    # ν = 1/2, small x = q depth: K = E* q/2 (2 + 4x²...)/(4x³/3) -> 3 E*/(4 q² depth³).
    grid = Grid((4, 4), (2e3, 1.0))
    q = 2 * np.pi / 2e3
    assert Layer(1.0, 0.5, "clamped").stiffness(grid)[1, 0] == pytest.approx(0.75 / q**2, rel=1e-4)


def test_depth_of_the_paper_matters_only_for_the_longest_wave() -> None:
    grid = Grid.square(64)
    ratio = Layer(64.0, 0.5, "clamped").stiffness(grid) / HalfSpace("free").stiffness(grid).clip(1e-300)
    x = 2 * np.pi
    exact = (np.cosh(2 * x) + 2 * x**2 + 1) / (np.sinh(2 * x) - 2 * x)
    assert ratio[1, 0] == pytest.approx(exact, rel=1e-13)
    assert exact == pytest.approx(1.0006, abs=5e-5)  # the 0.06 % of DESIGN.md's note on depth
    assert np.abs(ratio[2:-1, 1:] - 1).max() < 1e-4


@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_stiffness_falls_with_depth(nu: float) -> None:
    grid = Grid.square(16)
    thin, thick = (Layer(d, nu, "free").stiffness(grid).ravel()[1:] for d in (2.0, 4.0))
    assert (thin >= thick).all()
    assert thin[0] > 1.2 * thick[0]


@pytest.mark.parametrize(("mean", "value"), [("clamped", np.inf), ("free", 0.0), (0.25, 0.25)])
def test_the_mean_mode_is_what_was_said(mean: MeanMode, value: float) -> None:
    grid = Grid.square(6)
    for response in (HalfSpace(mean), Layer(3.0, 0.5, mean)):
        assert response.stiffness(grid)[0, 0] == value


@pytest.mark.parametrize("mean", ["clampd", -1.0, np.nan])
def test_a_mean_mode_that_is_none_is_refused(mean: MeanMode) -> None:
    with pytest.raises(ArgumentError, match='allowed: "clamped", "free", or a number'):
        HalfSpace(mean)


@pytest.mark.parametrize("kind", [HalfSpace, partial(Layer, 8.0, 0.3)])
def test_a_free_mean_mode_carries_no_load_at_a_separation(kind: Callable[[MeanMode], Response]) -> None:
    """That alone is a control that a substrate is without."""
    for mean, control in product(("free", "clamped", 0.1), ("separation", "mean-gap", "mean-pressure", "area")):
        assert bool(kind(mean).without(control)) == (mean == "free" and control == "separation")


def test_a_table_serves_its_own_grid_only() -> None:
    grid = Grid((6, 7), (6.0, 7.0))
    table = TabulatedSubstrate(HalfSpace(0.1).stiffness(grid), grid.lengths, "half-space")
    np.testing.assert_array_equal(table.stiffness(grid), HalfSpace(0.1).stiffness(grid))
    for other in (Grid((6, 7), (6.0, 7.1)), Grid((7, 6), (6.0, 7.0))):
        with pytest.raises(ValueError, match=r"grid: .* where the table of stiffness has"):
            table.stiffness(other)
    with pytest.raises(ValueError, match="positive finite"):
        TabulatedSubstrate(-HalfSpace(0.1).stiffness(grid), grid.lengths, "negative")


def isotropic(nu: float) -> CubicConstants:
    """Constants of the isotropic material with E* = 1."""
    shear = (1 - nu) / 2
    lame = 2 * shear * nu / (1 - 2 * nu)
    return CubicConstants(lame + 2 * shear, lame, shear)


SPRINGS = CubicConstants(1.0307, 0.51537, 0.51537)  # nearest-neighbour springs with a mean E* of 1, to five digits


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.4])
@pytest.mark.parametrize("shape", [(12, 12), (9, 14)])
def test_an_isotropic_crystal_is_the_isotropic_layer(nu: float, shape: tuple[int, int]) -> None:
    grid = Grid(shape, (24.0, 20.0))
    for depth in (0.5, 7.0, 500.0):
        crystal, layer = CubicLayer(depth, isotropic(nu), "free"), Layer(depth, nu, "free")
        # Rounding of the closed form, which cancels for thin layers, and of some ten doublings.
        np.testing.assert_allclose(crystal.stiffness(grid), layer.stiffness(grid), rtol=1e-11)
        assert crystal.compressive_stiffness == pytest.approx(layer.compressive_stiffness, rel=1e-12)
    np.testing.assert_allclose(
        CubicLayer(np.inf, isotropic(nu), "free").stiffness(grid), HalfSpace("free").stiffness(grid), rtol=1e-12
    )


def test_a_crystal_has_the_symmetry_of_its_surface() -> None:
    grid = Grid.square(16)
    k = CubicLayer(6.0, SPRINGS, "free").stiffness(grid)
    m = np.arange(1, 8)
    np.testing.assert_allclose(k[m, 0], k[0, m], rtol=1e-12)
    np.testing.assert_allclose(k[m, 3], k[-m, 3], rtol=1e-12)
    # Along <110>, the axes of the grid, a crystal of springs is stiffer than along <100>, by 5 %.
    along_110, along_100 = k[7, 0] / 7, k[5, 5] / np.hypot(5, 5)
    assert along_110 / along_100 == pytest.approx(1.4063 / 1.3416, rel=1e-3)
    turned = CubicLayer(6.0, SPRINGS, "free", axis=0.0).stiffness(grid)
    assert turned[7, 0] / 7 == pytest.approx(along_100, rel=1e-3)


def test_a_layer_of_crystal_joins_smoothly_to_its_half_space() -> None:
    # At q depth = 40, where the layer is taken for a half-space.
    grid = Grid((4, 4), (2 * np.pi / 39.99, 1.0))
    near = CubicLayer(1.0, SPRINGS, "free").stiffness(grid)[1, 0]
    far = CubicLayer(np.inf, SPRINGS, "free").stiffness(grid)[1, 0]
    assert near == pytest.approx(far, rel=1e-12)


@pytest.mark.parametrize("bad", [{"depth": 0.0}, {"constants": CubicConstants(1, 2, 1)}])
def test_a_crystal_that_is_none_is_refused(bad: dict) -> None:
    with pytest.raises(ValueError, match=r"depth = .* allowed|stable"):
        CubicLayer(**({"depth": 1.0, "constants": SPRINGS, "mean": "free"} | bad))


@pytest.mark.parametrize("nu", [-0.99, 0.3, 0.4999, float(np.nextafter(0.5, 0)), 0.5])
def test_layers_keep_their_digits_however_thin_and_incompressible(nu: float) -> None:
    """Against 60 digits.  Incompressible ones lost all of theirs at q depth = 1e-8: sinh 2x - 2x was a difference."""
    with mpmath.workdps(60):
        grid = Grid((2, 2), (2 * np.pi, 2 * np.pi))
        q = mpmath.mpf(float(grid.wavenumber[0, 1]))
        for power in np.linspace(-12, 6, 25):
            depth = float(10**power)
            x, n = q * mpmath.mpf(depth), mpmath.mpf(nu)
            ratio = mpmath.mpf(1)  # to all digits where cosh would overflow
            if x < 1000:
                above = (3 - 4 * n) * mpmath.cosh(2 * x) + 2 * x**2 + 5 - 12 * n + 8 * n**2
                ratio = above / ((3 - 4 * n) * mpmath.sinh(2 * x) - 2 * x)
            stiffness = Layer(depth, nu, "free").stiffness(grid)[0, 1]
            assert abs(stiffness / (q / 2 * ratio) - 1) < 1e-12
            if nu < 0.4999 and power < 3:
                cubic = CubicLayer(depth, isotropic(nu), "free").stiffness(grid)[0, 1]
                assert abs(cubic / (q / 2 * ratio) - 1) < 1e-12


def test_a_crystal_whose_digits_would_be_lost_is_refused() -> None:
    with pytest.raises(ValueError, match="digits are lost"):
        CubicLayer(1.0, isotropic(0.49999), "free")
