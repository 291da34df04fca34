"""Layers on a half-space: the boundary-value problem in many digits, limits, and what others found of coated solids."""

from __future__ import annotations

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum as c
from continuum.inputs.arguments import ArgumentError
from continuum.model.substrates.isotropic import Solid, layered_stiffness

QH = np.logspace(-8, 4, 97)
Stack = list[tuple[float, Solid]]


def bonded_stack(layers: Stack, base: Solid, q: float) -> mpmath.mpf:
    """K_q from the fields themselves: what decays in the half-space, integrated up through the layers.

    State (i u_x, u_z, i t_x, t_z)/q in 60 digits, and more where it grows as exp(q h).
    """
    with mpmath.workdps(60 + int(2 * sum(q * thickness for thickness, _ in layers))):
        modulus, nu = map(mpmath.mpf, base)
        state = mpmath.matrix([[2, (1 - 2 * nu) / (1 - nu)], [(1 - 2 * nu) / (1 - nu), 2], [modulus, 0], [0, modulus]])
        for thickness, solid in reversed(layers):
            modulus, nu = map(mpmath.mpf, solid)
            shear = modulus * (1 - nu) / 2
            across = mpmath.matrix(
                [
                    [0, 1, 1 / shear, 0],
                    [-nu / (1 - nu), 0, 0, (1 - 2 * nu) / (2 * shear * (1 - nu))],
                    [4 * shear / (2 * (1 - nu)), 0, 0, nu / (1 - nu)],
                    [0, 0, -1, 0],
                ]
            )
            state = mpmath.expm(across * mpmath.mpf(q) * mpmath.mpf(thickness)) * state
        pressed = mpmath.lu_solve(state[2:4, 0:2], mpmath.matrix([0, 1]))  # t_x = 0, t_z = 1 on top
        return q / (state[1, 0] * pressed[0] + state[1, 1] * pressed[1])


@pytest.mark.parametrize("contrast", [1, 10, 1e3, 1e6, 1e12])
def test_stacks_keep_their_digits(contrast: float) -> None:
    rng = np.random.default_rng(int(np.log10(contrast)))
    for _ in range(8):

        def solid() -> Solid:
            nu = rng.choice([0.5, np.nextafter(0.5, 0), 0.4999, 0.25, 0.0, rng.uniform(-0.99, 0.5)])
            return Solid(contrast ** rng.uniform(-1, 1), float(nu))

        stack, base = [(10 ** rng.uniform(-8, 1), solid()) for _ in range(rng.integers(1, 4))], solid()
        q = 10 ** rng.uniform(-1, 0.3)
        found = layered_stiffness(stack, base, np.array([q]))[0]
        # Some ten operations a layer; of 400 such stacks the worst was off by 2e-15.
        assert abs(found / bonded_stack(stack, base, q) - 1) < 2e-14, (stack, base, q)


@pytest.mark.parametrize("nu", [-0.9, 0.0, 0.3, 0.5])
def test_limits_hold_for_every_thickness(nu: float) -> None:
    own, other = Solid(1.0, nu), Solid(7.0, 0.2)
    np.testing.assert_allclose(layered_stiffness([(1.0, own)], own, QH), QH / 2, rtol=1e-14)  # equal
    thick = QH[QH > 20]  # exp(-40) (q h)² is below rounding
    np.testing.assert_allclose(layered_stiffness([(1.0, own)], other, thick), thick / 2, rtol=1e-14)
    np.testing.assert_allclose(layered_stiffness([(1e-15, own)], other, QH[QH < 1]), 3.5 * QH[QH < 1], rtol=1e-13)
    # On a rigid base: the closed form of the layer.
    grid = c.Grid((2, 2), (2 * np.pi, 2 * np.pi))
    for thickness in QH:
        rigid = layered_stiffness([(thickness, own)], Solid(1e40, 0.2), grid.wavenumber)
        layer = c.Layer(thickness, nu, "free").stiffness(grid)
        np.testing.assert_allclose(rigid.ravel()[1:], layer.ravel()[1:], rtol=1e-12)


SOLIDS = st.builds(Solid, st.floats(1e-3, 1e3), st.floats(-0.9, 0.5))
STACKS = st.lists(st.tuples(st.floats(1e-6, 1e3), SOLIDS), min_size=1, max_size=4)


@given(STACKS, SOLIDS, st.data())
def test_what_must_hold_for_every_stack(stack: Stack, base: Solid, data: st.DataObject) -> None:
    q = np.logspace(-4, 3, 15)
    stiffness_q = layered_stiffness(stack, base, q)
    every = [base.contact_modulus, *(solid.contact_modulus for _, solid in stack)]
    assert (stiffness_q > 0).all()
    # A cut through a layer changes nothing, nor does a unit of modulus or of length.
    i, share = data.draw(st.integers(0, len(stack) - 1)), data.draw(st.floats(0.01, 0.99))
    thickness, solid = stack[i]
    cut = [*stack[:i], (share * thickness, solid), ((1 - share) * thickness, solid), *stack[i + 1 :]]
    np.testing.assert_allclose(layered_stiffness(cut, base, q), stiffness_q, rtol=1e-12)
    softer = [(t, Solid(s.contact_modulus / 7, s.poisson)) for t, s in stack]
    softer_base = Solid(base.contact_modulus / 7, base.poisson)
    np.testing.assert_allclose(layered_stiffness(softer, softer_base, q), stiffness_q / 7, rtol=1e-12)
    np.testing.assert_allclose(
        layered_stiffness([(7 * t, s) for t, s in stack], base, q / 7), stiffness_q / 7, rtol=1e-12
    )
    # What is stiffer somewhere is nowhere softer as a whole.
    stiffer = [*stack[:i], (thickness, Solid(2 * solid.contact_modulus, solid.poisson)), *stack[i + 1 :]]
    assert (layered_stiffness(stiffer, base, q) >= stiffness_q * (1 - 1e-12)).all()
    # Short waves feel the top layer only.
    if q[-1] * stack[0][0] > 40 and max(every) < 100 * min(every):
        assert stiffness_q[-1] == pytest.approx(stack[0][1].contact_modulus * q[-1] / 2, rel=1e-12)


def test_a_stiff_coating_is_a_plate_that_floats() -> None:
    """K = E* h³ q⁴/12 + E_base q/2: a base of ν = 1/2 does not feel that the plate holds it sidewards."""
    h, soft = 1.0, 1e-9
    q = np.logspace(-3.5, -2, 7)
    found = layered_stiffness([(h, Solid(1.0, 0.3))], Solid(soft, 0.5), q)
    plate, base = h**3 * q**4 / 12, soft * q / 2
    assert plate[0] < base[0] / 100
    assert plate[-1] > 100 * base[-1]
    # Left out: shear of the plate, 1e-4 = (q h)²; its stretching by the base, E_base/(E* q h) = 3e-6.
    np.testing.assert_allclose(found, plate + base, rtol=2e-4)


def test_an_incompressible_solid_whose_stiffness_grows_with_depth_is_a_bed_of_springs() -> None:
    """G = m z, ν = 1/2: K = 2 m whatever q (Gibson, Géotechnique 17, 58 (1967)); E* = 4 G."""
    q, errors = np.array([0.3, 1.0, 3.0]), []
    for n in (100, 200, 400):
        edges = np.concatenate([[0.0], np.geomspace(1e-5, 30, n)])
        stack = [(b - a, Solid(4 * (a + b) / 2, 0.5)) for a, b in pairwise(edges)]
        errors.append(np.abs(layered_stiffness(stack, Solid(120.0, 0.5), q) / 2 - 1).max())
    # Layers of the modulus in their middle: an error of their thickness squared.
    assert errors[2] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.15)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("thickness", [0.2, 1.0, 4.0])
def test_a_punch_on_a_coating_feels_it_as_gao_found(nu: float, thickness: float) -> None:
    """First order in the contrast: Gao, Chiu and Lee, Int. J. Solids Struct. 29, 2471 (1992), their function I0.

    The punch of radius 1 presses as 1/sqrt(1 - r²), whose transform is sin(q)/q: the compliance of its depth
    is the integral of sin²(q)/q K⁻¹.  What is felt of the base, 1 - I0, falls as exp(-2 q h).
    """
    q = np.linspace(0, 30 / thickness, 30001)[1:]
    step = 1e-4  # central: an error of its square
    low, high = (1 / layered_stiffness([(thickness, Solid(1.0, nu))], Solid(e, nu), q) for e in (1 - step, 1 + step))
    kernel = np.concatenate([[2.0], np.sin(q) ** 2 / q * (low - high) / (2 * step)])
    of_base = np.trapezoid(kernel, dx=q[0]) / np.pi
    xi = thickness
    logarithm = (1 - 2 * nu) * xi * np.log((1 + xi**2) / xi**2) - xi / (1 + xi**2)
    coating = 2 / np.pi * np.arctan(xi) + logarithm / (2 * np.pi * (1 - nu))
    assert 1 - of_base == pytest.approx(coating, abs=1e-6)  # of the trapezoids: (30/30000 h)²


def test_a_sphere_on_a_thin_incompressible_coating() -> None:
    """p = 3 E*/(128 R h³) (a² - r²)² at a depth of a²/4R: Johnson 1985, section 5.8, for a sphere, not a cylinder.

    A wide contact squeezes the coating out as a lubricant: K = 3 E*/(4 q² h³).
    """
    grid, radius, a, excess = c.Grid.square(64), 400.0, 16.0, []
    for h in (2 / 3, 1 / 3):
        coated = c.LayeredHalfSpace([(h, 1.0, 0.5)], (1e9, 0.3))
        state = c.Contact(c.sphere(grid, radius), c.HardWall(), coated).press(separation=-(a**2) / (4 * radius))
        excess.append(state.require().load * grid.area / (np.pi * a**6 / (128 * radius * h**3)) - 1)
        # The layer leaves its face within some h of the edge, which is known to a point.
        assert np.sqrt(state.area_rep * grid.area / np.pi) == pytest.approx(a - 1.3 * h, abs=0.5)
        assert state.traction.max() == pytest.approx(3 * a**4 / (128 * radius * h**3), rel=0.05)
    # K = 3 E*/(4 q² h³) (1 + 8/5 (q h)² ...): the next term is of order (h/a)².
    assert excess[1] < 0.01
    assert excess[0] / excess[1] == pytest.approx(4, rel=0.1)


NO_LAYERS = [
    ({"layers": []}, "layers = .* at least one layer"),
    ({"layers": [(1.0, 1.0)]}, r"layers\[0\] = \(1.0, 1.0\).*thickness, contact_modulus, poisson"),
    ({"layers": [(0.0, 1.0, 0.3)]}, r"thickness of layers\[0\] = 0.0: .*greater than 0"),
    ({"layers": [(1.0, 1.0, 0.3), (1.0, 1.0, 0.51)]}, r"poisson of layers\[1\] = 0.51"),
    ({"layers": [(1.0, 1e13, 0.3)]}, r"contact_modulus of layers\[0\]"),
    ({"base": (1.0,)}, r"base = \(1.0,\): .*\(contact_modulus, poisson\)"),
    ({"base": (1.0, -1.0)}, "poisson of base"),
    ({"layers": [(1.0, 70.0, 0.3)], "base": (200.0, 0.3)}, "not all from 70 to 200"),
    ({"mean": "rigid"}, 'mean = .*"clamped"'),
]


def test_layers_that_are_none_are_refused() -> None:
    for bad, words in NO_LAYERS:
        with pytest.raises(ArgumentError, match=words):
            c.LayeredHalfSpace(**({"layers": [(1.0, 1.0, 0.3)], "base": (0.1, 0.5)} | bad))
