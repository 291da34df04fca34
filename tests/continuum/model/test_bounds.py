"""Numbers of walls, substrates and surfaces go to the bounds that their meaning sets, and no further."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from continuum.arguments import ArgumentError
from continuum.model.cubic import CubicConstants
from continuum.model.grid import Grid
from continuum.model.substrates import CubicLayer, LayeredHalfSpace, TabulatedSubstrate
from continuum.model.substrates.layer import Layer
from continuum.model.surface import SelfAffine
from continuum.model.surfaces import cylinder, punch, sine, sphere
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline

LEAST = 1e-300  # of a positive number
GRID = Grid((6, 8), (6.0, 8.0))
ISOTROPIC = CubicConstants(1.5, 0.5, 0.5)


def table(mean: float = 1.0, other: float = 1.0) -> TabulatedSubstrate:
    values = np.ones((6, 5))
    values[0, 0], values[-1, 0] = mean, other
    return TabulatedSubstrate(values, (6.0, 8.0), "made up")


def layers(thickness: float = 1.0, modulus: float = 1.0, poisson: float = 0.3) -> LayeredHalfSpace:
    return LayeredHalfSpace(((thickness, modulus, poisson),), (1.0, 0.3))


BOUNDS: list[tuple[Callable[..., Any], dict[str, Any], list[Any], list[Any]]] = [
    (LennardJonesSpline, {"range": None}, [0.0], [-LEAST, np.inf]),
    (LennardJonesSpline, {"range": 0.3, "core": None}, [LEAST, 1 - 1e-15], [0.0, 1.0]),
    (LennardJonesSpline, {"range": 0.3, "minimum_stiffness": None}, [LEAST], [0.0]),
    (LennardJonesSpline, {"adhesion_length": None}, [0.0], [-LEAST]),
    (InversePowers, {"powers": None, "minimum_stiffness": 1.0}, [(2, 1 + 1e-12), (9, 3)], [(9, 1), (3, 3), (3, 9)]),
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
    (layers, {"modulus": None}, [1e-12, 1e12], [0.999e-12, 1.001e12]),
    (layers, {"poisson": None}, [-1 + 1e-15, 0.5], [-1.0, 0.5 + 1e-15]),
    (table, {"mean": None}, [0.0, np.inf], [-LEAST, np.nan]),
    (table, {"other": None}, [LEAST], [0.0, np.inf, np.nan]),
    (sphere, {"grid": GRID, "radius": None}, [1e-30], [0.0]),
    (cylinder, {"grid": GRID, "radius": 5.0, "axis": None}, [0, 1], [-1, 2]),
    (punch, {"grid": GRID, "flat_radius": None, "edge_radius": 5.0}, [0.0, 2.9], [-LEAST, 5.1]),
    (punch, {"grid": GRID, "flat_radius": 1.0, "edge_radius": None}, [1e-30], [0.0]),
    (sine, {"grid": GRID, "amplitude": 0.1, "waves": None}, [(3, 4), (-3, -4), (0, 1)], [(4, 0), (0, 5), (0, -5)]),
    (SelfAffine, {"hurst": None, "rms_slope": 0.1, "lambda_s": 2.0, "lambda_L": 4.0}, [1e-6, 1 - 1e-15], [0.0, 1.0]),
    (SelfAffine, {"hurst": 0.8, "rms_slope": None, "lambda_s": 2.0, "lambda_L": 4.0}, [1e-100, 10.0], [0.0, 10.001]),
    (SelfAffine, {"hurst": 0.8, "rms_slope": 0.1, "lambda_s": None, "lambda_L": 4.0}, [LEAST, 3.999], [0.0, 4.001]),
]  # fmt: skip


@pytest.mark.parametrize(("make", "arguments", "allowed", "beyond"), BOUNDS)
def test_a_number_goes_to_its_bounds_and_no_further(
    make: Callable[..., Any], arguments: dict[str, Any], allowed: list[Any], beyond: list[Any]
) -> None:
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
    along_y = cylinder(GRID, 5.0)
    assert np.ptp(along_y, axis=1).max() == 0 < np.ptp(along_y, axis=0).min()
    assert (along_y == cylinder(GRID, 5.0, 1)).all()
