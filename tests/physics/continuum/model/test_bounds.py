"""Numbers of walls, substrates and surfaces go to the bounds that their meaning sets, and no further."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from continuum.inputs.arguments import ArgumentError
from continuum.inputs.keys import LARGEST_N, SMALLEST
from continuum.model.grid import Grid, GridTable
from continuum.model.substrates import CubicLayer, LayeredHalfSpace, TabulatedSubstrate
from continuum.model.substrates.crystal import CubicConstants
from continuum.model.substrates.isotropic import Film, Layer
from continuum.model.surface import Counterface, SelfAffine
from continuum.model.surfaces import CylinderSurface, PunchSurface, SelfAffineSurface, SineSurface, sine, sphere
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline
from continuum.model.walls.inverse_powers import LennardJones93
from continuum.path.state import Search
from continuum.store.runs.config import LoadingTable

LEAST = SMALLEST  # of a positive number
GRID = Grid((6, 8), (6.0, 8.0))
ISOTROPIC = CubicConstants(1.5, 0.5, 0.5)


def table(mean: float = 1.0, other: float = 1.0) -> TabulatedSubstrate:
    values = np.ones((6, 5))
    values[0, 0], values[-1, 0] = mean, other
    return TabulatedSubstrate(values, (6.0, 8.0), "made up")


def layers(thickness: float = 1.0, modulus: float = 1.0, poisson: float = 0.3) -> LayeredHalfSpace:
    return LayeredHalfSpace(((thickness, modulus, poisson),), (1.0, 0.3))


def punch(flat_radius: float) -> np.ndarray:
    return PunchSurface(flat_radius, 5.0).build(GRID)


BOUNDS: list[tuple[Callable[..., Any], dict[str, Any], list[Any], list[Any]]] = [
    (LennardJonesSpline, {"range": None}, [0.0], [-LEAST, np.inf]),
    (LennardJonesSpline, {"range": 0.3, "core": None}, [LEAST, 1 - 1e-15], [0.0, 1.0]),
    (LennardJonesSpline, {"range": 0.3, "minimum_stiffness": None}, [LEAST], [0.0]),
    (LennardJonesSpline, {"adhesion_length": None}, [0.0], [-LEAST]),
    (InversePowers, {"powers": None, "minimum_stiffness": 1.0}, [(3, 2), (9, 3)], [(9, 1), (3, 3), (3, 9), (9.5, 3)]),
    (InversePowers, {"powers": (9, 3), "minimum_stiffness": None}, [LEAST], [0.0]),
    (InversePowers, {"powers": (9, 3), "adhesion_length": None}, [LEAST], [0.0]),
    (InversePowers, {"powers": (9, 3), "minimum_stiffness": 1.0, "core": None}, [LEAST, 1 - 1e-15], [0.0, 1.0]),
    (Exponential, {"surface_energy": None, "decay_length": 1.0, "core_stiffness": 1.0}, [LEAST], [0.0]),
    (Exponential, {"surface_energy": 1.0, "decay_length": None, "core_stiffness": 1.0}, [LEAST], [0.0]),
    (Exponential, {"surface_energy": 1.0, "decay_length": 1.0, "core_stiffness": None}, [LEAST], [0.0]),
    (HardWall, {"hardness": None}, [LEAST, np.inf], [0.0]),
    (Layer, {"depth": None, "poisson": 0.3, "mean": "clamped"}, [LEAST], [0.0]),
    (Layer, {"depth": 1.0, "poisson": None, "mean": "clamped"}, [-1 + 1e-15, 0.5], [-1.0, 0.5 + 1e-15]),
    (CubicLayer, {"depth": None, "constants": ISOTROPIC, "mean": "clamped"}, [LEAST, np.inf], [0.0, -np.inf]),
    (layers, {"thickness": None}, [1e-30, 1e30], [0.0, 1.0001e30]),
    (layers, {"modulus": None}, [1e-12, 1e12], [0.999e-12, 1e12 + 0.5]),
    (layers, {"poisson": None}, [-1 + 1e-15, 0.5], [-1.0, 0.5 + 1e-15]),
    (table, {"mean": None}, [0.0, np.inf], [-LEAST, np.nan]),
    (table, {"other": None}, [LEAST], [0.0, np.inf, np.nan]),
    (sphere, {"grid": GRID, "radius": None}, [1e-30], [0.0]),
    (CylinderSurface, {"radius": 5.0, "along": None}, ["x", "y"], ["z", 1]),
    (punch, {"flat_radius": None}, [0.0, 2.9], [-LEAST, 5.1]),
    (PunchSurface, {"flat_radius": 1.0, "edge_radius": None}, [1e-30], [0.0]),
    (sine, {"grid": GRID, "amplitude": 0.1, "waves": None}, [(3, 4), (-3, -4), (0, 1)], [(4, 0), (0, 5), (0, -5)]),
    (SelfAffine, {"hurst": None, "rms_slope": 0.1, "lambda_s": 2.0, "lambda_L": 4.0}, [1e-6, 1 - 1e-15], [0.0, 1.0]),
    (SelfAffine, {"hurst": 0.8, "rms_slope": None, "lambda_s": 2.0, "lambda_L": 4.0}, [1e-100, 10.0], [0.0, 10.001]),
    (SelfAffine, {"hurst": 0.8, "rms_slope": 0.1, "lambda_s": None, "lambda_L": 4.0}, [LEAST, 3.999], [0.0, 4.001]),
]


def test_a_number_goes_to_its_bounds_and_no_further() -> None:
    for make, arguments, allowed, beyond in BOUNDS:
        (name,) = (name for name, value in arguments.items() if value is None)
        for value in allowed:
            make(**arguments | {name: value})
        for value in beyond:
            with pytest.raises(ArgumentError):
                make(**arguments | {name: value})


def test_what_is_left_out_is_what_the_paper_has() -> None:
    """Its stiffness E*/(2 a0) at the minimum, a core that no equilibrium reaches, a crystal cut along <110>."""
    paper = LennardJonesSpline(0.35)
    assert (paper.minimum_stiffness, paper.core, InversePowers((9, 3), 1.0).core) == (0.5, 0.7, 0.7)
    assert HardWall().hardness == np.inf
    assert CubicLayer(5.0, ISOTROPIC, "clamped").axis == np.pi / 4
    along_y = CylinderSurface(5.0).build(GRID)
    assert np.ptp(along_y, axis=1).max() == 0 < np.ptp(along_y, axis=0).min()
    assert (along_y == CylinderSurface(5.0, "y").build(GRID)).all()


SPLINE: dict[str, Any] = {"law": "lennard-jones-spline", "range": 0.3}
SELF_AFFINE: dict[str, Any] = {
    "kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 8.0, "seed": 1
}  # fmt: skip
LAYER: dict[str, Any] = {"response": "layer", "depth": 1.0, "poisson": 0.3, "mean": "clamped"}
FILM: dict[str, Any] = {"thickness": 1.0, "contact_modulus": 1.0, "poisson": 0.3}
SINE: dict[str, Any] = {"kind": "sine", "amplitude": 0.1, "waves": (1, 2)}
TABLES: list[tuple[type[Any], dict[str, Any], str, list[Any], list[Any]]] = [
    (LennardJonesSpline, SPLINE, "range", [0.0, 3.0], [-LEAST, 3.0001]),
    (LennardJonesSpline, SPLINE, "core", [LEAST, 1 - 1e-15], [0.0, 1.0]),
    (LennardJonesSpline, {"law": SPLINE["law"]}, "adhesion_length", [0.0, 9 / 24], [-LEAST, 9.001 / 24]),
    (LennardJones93, {"law": "lennard-jones-9-3"}, "adhesion_length", [LEAST, 9 / 24], [0.0, 9.001 / 24]),
    (Layer, LAYER, "poisson", [-1 + 1e-15, 0.5], [-1.0, 0.5 + 1e-15]),
    (Film, FILM, "thickness", [LEAST, 1e30], [0.0, 1.001e30]),
    (Film, FILM, "contact_modulus", [1e-12, 1e12], [0.999e-12, 1.001e12]),
    (Film, FILM, "poisson", [-1 + 1e-15, 0.5], [-1.0, 0.5 + 1e-15]),
    (SelfAffineSurface, SELF_AFFINE, "rms_slope", [1e-100, 10.0], [0.9e-100, 10.001]),
    (SelfAffineSurface, SELF_AFFINE, "seed", [0, 2**63 - 1], [-1, 2**63]),
    (SelfAffineSurface, SELF_AFFINE, "lambda_s", [LEAST, 8.0], [0.0, 8.001]),
    (SineSurface, SINE, "waves", [(0, 1), (-1, 0), (0, LARGEST_N)], [(0, 0), (0, LARGEST_N + 1), (1, 2, 3), 3]),
    (SineSurface, SINE, "amplitude", [LEAST, 1e30], [0.0, -0.1, 1.1e30]),
    (PunchSurface, {"kind": "punch", "edge_radius": 5.0}, "flat_radius", [LEAST], [0.0]),
    (Counterface, {"surface": SINE}, "shift", [(0.0, 0.0), (-1e6, 1e6)], [(-1.001e6, 0.0), (0.0, 1.001e6)]),
    (Counterface, {"surface": SINE}, "shift_seed", [0, 2**63 - 1], [-1, 2**63]),
    (Counterface, {"surface": SINE}, "angle", [0.0, 90.0, -270.0], [1.0, 89.0, 91.0]),
    (Search, {}, "area_tolerance", [LEAST, 1 - 1e-15], [0.0, 1.0]),
    (Search, {}, "area_resolution", [None, 1e-9, 1.0], [0.0, 0.999e-9]),
    (Search, {}, "event_resolution", [None, 1e-9, 1.0], [0.0, 0.999e-9]),
    (GridTable, {}, "n", [2, LARGEST_N, (1, 2), (1, LARGEST_N)], [1, 0, (2, 1), (0, 2), (1, 1), LARGEST_N + 1]),
    (GridTable, {"n": (4, 8)}, "period", [(4, 8), (2, 4), (1, 1), 4], [(0, 8), (4, 0), (3, 8), (4, 3), (0.5, 8)]),
]


def test_a_key_of_an_input_goes_to_its_bounds_and_no_further() -> None:
    for kind, given, key, allowed, beyond in TABLES:
        read = partial(kind.model_validate, context={})
        for value in allowed:
            read(given | {key: value})
        for value in beyond:
            with pytest.raises(ValueError, match=key):
                read(given | {key: value})


def test_how_closely_an_area_is_met_is_asked_for_in_python_and_in_an_input_by_the_same_keys() -> None:
    keys = {"area_tolerance": 0.1, "area_resolution": 0.01, "event_resolution": 0.02, "event_threshold": 0.03}
    loading = LoadingTable(control="separation", targets=(1.0,), **keys)
    assert [search for _, _, search in loading.aims] == [Search(**keys)]
    assert Search(event_resolution=1e-12).event_resolution == 1e-12  # a mistaken unit is likely in an input only
    for key in keys:
        with pytest.raises(ArgumentError, match=f"{key} = -1"):
            Search(**{key: -1})


def test_waves_fit_a_grid_and_its_period_on_both_sides_of_their_bounds() -> None:
    rough = SelfAffineSurface(**SELF_AFFINE)
    # Two spacings of the wider step are 4 a0; the period that is shorter holds 8 a0.
    assert not [*rough.too_short((8, 4), (8.0, 8.0)), *rough.too_short((1, 4), (0.5, 8.0))]
    for n, lengths in (((8, 4), (8.0, 8.1)), ((2, 2), (8.0, 8.0))):
        assert [fault.key for fault in rough.too_short(n, lengths)] == [("surface", "lambda_s")]
    assert not [*rough.too_short((8, 1), (8.0, 8.0))]  # no grid at all
    assert not [*rough.too_long((8, 8), (8.0, 9.0)), *rough.too_long((8, 8), (9.0, 8.0))]
    for n, lengths in (((8, 8), (7.9, 9.0)), ((8, 8), (9.0, 7.9)), ((1, 8), (9.0, 7.9))):
        assert [fault.key for fault in rough.too_long(n, lengths)] == [("surface", "lambda_L")]
    assert not [*rough.too_long((1, 8), (1.0, 8.0))]  # a line has no period across
    wave = SineSurface(**SINE | {"waves": (3, 4)})
    assert not [*wave.too_short((6, 8), (6.0, 8.0)), *wave.too_short((7, 9), (7.0, 9.0))]
    for n in ((5, 8), (6, 7)):
        assert [fault.key for fault in wave.too_short(n, (6.0, 8.0))] == [("surface", "waves")]


def test_a_second_body_turns_by_quarters_on_a_square_and_by_halves_on_any_period() -> None:
    for angle, n, lengths, fits in (
        (90.0, (8, 8), (8.0, 8.0), True),
        (90.0, (8, 16), (8.0, 8.0), False),
        (90.0, (8, 8), (8.0, 16.0), False),
        (180.0, (8, 16), (8.0, 16.0), True),
        (270.0, (8, 16), (8.0, 16.0), False),
    ):
        found = [*Counterface(surface=SINE, angle=angle).unfit(n, lengths, repeats=True)]
        assert [fault.key for fault in found] == ([] if fits else [("counterface", "angle")])
    found = [*Counterface(surface=SINE | {"waves": (5, 0)}).unfit((8, 8), (8.0, 8.0), repeats=True)]
    assert [fault.key for fault in found] == [("counterface", "surface", "waves")]


def test_a_stack_has_a_thousand_layers_at_most() -> None:
    film = (1.0, 1.0, 0.3)
    assert len(LayeredHalfSpace(1000 * (film,), (1.0, 0.3)).layers) == 1000
    with pytest.raises(ArgumentError, match="layers"):
        LayeredHalfSpace(1001 * (film,), (1.0, 0.3))


@pytest.mark.parametrize(("modulus", "fits"), [(0.67, True), (0.66, False), (1.49, True), (1.51, False)])
def test_the_modulus_of_a_crystal_is_about_one(modulus: float, fits: bool) -> None:
    """That of an isotropic one is C11 (1 - (C12/C11)²), as E/(1 - ν²) is."""
    factor = modulus / (1.5 * (1 - (0.5 / 1.5) ** 2))
    constants = tuple(factor * constant for constant in ISOTROPIC)
    if fits:
        assert CubicLayer(4.0, constants, "clamped").c11 == pytest.approx(1.5 * factor)
    else:
        with pytest.raises(ArgumentError, match=f"it is {modulus:.2g}"):
            CubicLayer(4.0, constants, "clamped")


@pytest.mark.parametrize("sign", [1, -1])
def test_a_second_body_is_shifted_by_a_million_at_most(sign: int) -> None:
    assert Counterface(surface=SINE, shift=(sign * 1e6, 0.0)).shift == (sign * 1e6, 0.0)
    for shift in ((sign * (1e6 + 0.5), 0.0), (0.0, sign * (1e6 + 0.5))):
        with pytest.raises(ArgumentError, match="shift"):
            Counterface(surface=SINE, shift=shift)
