"""One contact of each further kind: bodies, boundaries and bounds beyond the paper's rough wall on a half-space."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import continuum as c
from docs.benchmarks.cases import PEER_ADHESION_LENGTH, PRESSURE, rough

_HARDNESS = 0.1
_Pressed = tuple[c.Contact, dict[str, float]]


def _heights(n: int, seed: int) -> Any:
    return rough(n, seed).heights()


def _law() -> c.LennardJonesSpline:
    return c.LennardJonesSpline(adhesion_length=PEER_ADHESION_LENGTH)


def _line(n: int, seed: int) -> _Pressed:
    grid = c.Grid((1, n * n), (1.0, float(n * n)))
    heights = c.SelfAffine(0.8, 0.1, 32.0, n * n / 2).synthesise(grid, np.random.default_rng(seed))
    return c.Contact(heights, c.HardWall()), {"pressure": PRESSURE}


def _two(n: int, seed: int) -> _Pressed:
    both = c.Contact(_heights(n, seed), _law()).against(_heights(n, seed + 10), shift=(n / 3, n / 5), angle=90)
    return both, {"area": 0.05}


KINDS: dict[str, Callable[[int, int], _Pressed]] = {
    "hard wall, pressure 4e-4 E*": lambda n, seed: (c.Contact(_heights(n, seed), c.HardWall()), {"pressure": PRESSURE}),
    "the same without periodic images": lambda n, seed: (
        c.Contact(_heights(n, seed), c.HardWall(), c.NonPeriodicHalfSpace()),
        {"pressure": PRESSURE},
    ),
    "hard wall, 90 % of the area": lambda n, seed: (c.Contact(_heights(n, seed), c.HardWall()), {"area": 0.9}),
    "hard wall, 99.99 % of the area": lambda n, seed: (c.Contact(_heights(n, seed), c.HardWall()), {"area": 0.9999}),
    "hardness 0.1 E*, half of it": lambda n, seed: (
        c.Contact(_heights(n, seed), c.HardWall(_HARDNESS)),
        {"pressure": 0.5 * _HARDNESS},
    ),
    "hardness 0.1 E*, 99 % of it": lambda n, seed: (
        c.Contact(_heights(n, seed), c.HardWall(_HARDNESS)),
        {"pressure": 0.99 * _HARDNESS},
    ),
    "line of n² points, hard wall, pressure 4e-4 E*": _line,
    "l_a = 0.005 a0, 5 % of the area": lambda n, seed: (c.Contact(_heights(n, seed), _law()), {"area": 0.05}),
    "the same, two rough bodies": _two,
    "the same, coating of 8 a0 ten times as stiff": lambda n, seed: (
        c.Contact(_heights(n, seed), _law(), c.LayeredHalfSpace([(8.0, 10.0, 0.3)], (1.0, 0.3))),
        {"area": 0.05},
    ),
    "spline on a core of 5 E*/a0, 1 % of the area": lambda n, seed: (
        c.Contact(_heights(n, seed), c.attraction_on_core("spline", 0.0004, 0.25, 5.0)),
        {"area": 0.01},
    ),
    "exponential on a core of 5 E*/a0, 1 % of the area": lambda n, seed: (
        c.Contact(_heights(n, seed), c.attraction_on_core("exponential", 0.0004, 0.8, 5.0)),
        {"area": 0.01},
    ),
}
"""Each makes a contact from points a side and a seed, with what it is pressed to."""


def contact(n: int, seed: int, kind: str) -> dict[str, Any]:
    """Press a contact of one kind from rest."""
    case, target = KINDS[kind](n, seed)
    began = time.process_time()
    found = case.press(**target)
    return {
        "status": found.status.name, "area": found.area_rep, "solves": found.search_solves + 1,
        "fft_pairs": found.search_pairs + found.solution.fft_pairs, "cpu": time.process_time() - began,
    }  # fmt: skip
