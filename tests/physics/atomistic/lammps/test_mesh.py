"""The wall as triangles, read as any program reads legacy VTK."""

from __future__ import annotations

import numpy as np

from atomistic.lammps.directory import wall_mesh


def test_the_mesh_of_a_wall_covers_its_period_once() -> None:
    heights, level, length, offset = np.random.default_rng(1).normal(size=(3, 5)), 1.3, 2.5, (0.25, -0.5)
    lines = wall_mesh(heights, level, length, offset).splitlines()
    assert wall_mesh(heights, level, length) == wall_mesh(heights, level, length, (0.0, 0.0), (1.0, 1.0))
    assert lines[0].startswith("# vtk DataFile")
    assert lines[2:5] == ["ASCII", "DATASET POLYDATA", "POINTS 24 double"]
    points = np.array([line.split() for line in lines[5:29]], dtype=float)
    assert lines[29] == "POLYGONS 30 120"
    cells = np.array([line.split() for line in lines[30:]], dtype=int)
    assert cells.shape == (30, 4)
    assert (cells[:, 0] == 3).all()
    # Above each surface atom its height, and at the end of the period what is at its beginning.
    for x, y, z in points:
        i, j = round(x / length - offset[0]), round(y / length - offset[1])
        np.testing.assert_allclose((x, y), (length * (i + offset[0]), length * (j + offset[1])), atol=1e-9)
        np.testing.assert_allclose(z, length * (level + heights[i % 3, j % 5]), atol=1e-8)
    # Seen from above the triangles cover the period, without overlap, all turned the same way: to the atoms below.
    a, b, c = (points[cells[:, k]] for k in (1, 2, 3))
    normals = np.cross(b - a, c - a)
    np.testing.assert_allclose(normals[:, 2] / 2, -(length**2) / 2, atol=1e-8)
    edges = {tuple(sorted(pair)) for cell in cells[:, 1:].tolist() for pair in zip(cell, np.roll(cell, 1), strict=True)}
    assert len(edges) == 24 + 30 - 1  # of a disc by Euler


def test_the_points_of_a_mesh_are_as_far_apart_as_those_of_its_grid() -> None:
    heights = np.random.default_rng(1).normal(size=(3, 5))
    plain, wide = (
        np.array([line.split() for line in wall_mesh(heights, 1.3, 2.5, spacing=spacing).splitlines()[5:29]], float)
        for spacing in ((1.0, 1.0), (2.0, 0.5))
    )
    np.testing.assert_allclose(wide, plain * [2.0, 0.5, 1.0], atol=1e-9)
    np.testing.assert_allclose(np.ptp(wide[:, :2], axis=0), [2.5 * 3 * 2.0, 2.5 * 5 * 0.5])
