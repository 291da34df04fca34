"""Sweeps over the tiles of a pressure look at those that hold something, and at no point beyond the end of a row.

Their sums and fields are compared with whole arrays in :mod:`tests.physics.continuum.solve.test_words`.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from continuum.model.grid import Grid
from continuum.solve.compiled import near_field, pressing, two_levels
from continuum.solve.compiled.compiling import SUMS, TILE
from continuum.solve.compiled.pressing import ContactPoints
from continuum.solve.compiled.two_levels import Nodes

GRID = Grid((12, 160), (12.0, 160.0))
ROWS, N = GRID.shape
START, STOP, MOST = 3, 11, 0.8
KERNEL = np.array([[0.0, 0.1, 0.0], [0.2, 1.0, 0.3], [0.0, -0.4, 0.0]])
SWEEPS: dict[str, Callable[[Any], tuple[Any, ...]]] = {
    "level": lambda f: (f.p, f.z, MOST, f.contact),
    "select": lambda f: (f.p, f.z, 0.1, MOST, f.lowest, f.contact),
    "correct": lambda f: (f.z, f.change, f.t, f.s, 0.3, f.contact),
    "direction_on_contact": lambda f: (f.t, f.s, 0.7, 0.2, f.out, f.contact),
    "total_pressure": lambda f: (f.p, N, f.touched),
    "trial": lambda f: (f.p, f.t, 0.4, f.s, MOST, N, f.touched),
    "stretch": lambda f: (f.p, 1.3, f.s, MOST, N, f.touched),
    "arrive": lambda f: (f.p, f.z, f.out, N, f.touched, f.lowest),
    "work_above": lambda f: (f.p, f.z, -0.5, N, f.touched),
    "collect_contact": lambda f: (f.z, 0.1, f.s, f.contact, f.nodes),
    "subtract_means": lambda f: (f.s, f.contact, f.nodes),
    "sum_neighbours": lambda f: (f.z, KERNEL, f.out, f.contact, f.nodes),
    "add_nodes": lambda f: (f.z, f.s, f.contact, f.nodes),
}
KERNELS = vars(two_levels) | vars(pressing)


def swept(name: str, *, held: bool) -> tuple[Any, Any]:
    """Sums and fields after a sweep of some rows; where nothing is touched stands what counts for nothing, or zero."""
    rng = np.random.default_rng(3)
    f = SimpleNamespace(touched=rng.integers(0, 3, (ROWS, 3)).astype(np.uint8), nodes=Nodes.of(GRID))
    f.touched[5], f.touched[6] = 0, 1
    f.p, f.z, f.t, f.s, f.m, f.change, f.out = rng.normal(size=(7, ROWS, N + 8))
    f.lowest = np.full((ROWS, 3), 0.2)
    nothing = np.repeat(f.touched == 0, TILE, axis=1)[:, : N + 8]
    f.mask = (rng.random((ROWS, N)) < 0.4) & ~nothing[:, :N]
    for each in (f.p, f.t, f.s, f.m):
        each[nothing] = np.nan if held else 0.0
        each[:, N:] = np.nan
    f.z[nothing] = np.abs(f.z[nothing]) + 0.2  # no overlap
    f.mask |= nothing[:, :N] & held
    for each in (f.nodes.field, f.nodes.density, f.nodes.lines, f.nodes.counts):
        each[...] = rng.normal(size=each.shape)
    f.contact, sums = ContactPoints(f.mask, f.m, N, f.touched), np.zeros(SUMS)
    KERNELS[name](START, STOP, sums, *SWEEPS[name](f))
    for each in (f.p, f.t, f.s, f.m):
        each[nothing] = 0.0
    f.mask &= ~nothing[:, :N]
    return sums, vars(f)


@pytest.mark.parametrize("name", SWEEPS)
def test_a_tile_that_holds_nothing_is_not_looked_at(name: str) -> None:
    (sums, found), (expected, fields) = (swept(name, held=held) for held in (True, False))
    assert np.isfinite(expected).all()
    np.testing.assert_array_equal(sums, expected)
    for key in ("p", "z", "t", "s", "m", "change", "out", "mask", "touched", "lowest"):
        np.testing.assert_array_equal(found[key], fields[key], err_msg=key)
    np.testing.assert_array_equal(found["nodes"].lines, fields["nodes"].lines)
    np.testing.assert_array_equal(found["nodes"].counts, fields["nodes"].counts)


def test_the_tiles_of_a_contact_are_those_with_a_point_that_presses_or_lies_below() -> None:
    rng, side = np.random.default_rng(4), 4
    p, z = np.zeros((2, 16, 2 * TILE + 8))
    p.flat[rng.choice(p.size, 6)] = 1.0
    z.flat[rng.choice(p.size, 6)] = -0.3
    out = np.zeros((4, 2 * TILE // side), dtype=bool)
    blocks = (z[:, : 2 * TILE].reshape(16, 2, TILE), p[:, : 2 * TILE].reshape(16, 2, TILE))
    lowest, touched = blocks[0].min(axis=2), blocks[1].any(axis=2).astype(np.uint8)
    near_field.mark_tiles(0, 16, np.zeros(SUMS), p, z, -0.2, touched, lowest, out)
    expected = ((p > 0) | (z < -0.2))[:, : 2 * TILE].reshape(4, side, -1, side).any(axis=(1, 3))
    assert 4 < expected.sum() < 13
    np.testing.assert_array_equal(out, expected)
