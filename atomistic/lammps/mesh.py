"""The wall as a surface of triangles, in legacy VTK: OVITO and ParaView show it above the atoms."""

from __future__ import annotations

import numpy as np

from continuum.model.fourier import Real


def wall_mesh(heights: Real, level: float, length: float, offset: tuple[float, float] = (0.0, 0.0)) -> str:
    """Text of a file of triangles.

    The period is closed: what lies at its end is what lies at its beginning.

    Parameters
    ----------
    heights : of the wall above each surface atom, shape (nx, ny), in a0.
    level : of its zero above the lattice plane of the surface, in a0: separation and rise of the surface.
    length : a0 in LAMMPS' unit, in which the mesh is.
    offset : of the wall along x and y, in a0.
    """
    z = length * (level + np.pad(heights, ((0, 1), (0, 1)), mode="wrap"))
    nx, ny = z.shape
    axes = (np.arange(n) + shift for n, shift in zip(z.shape, offset, strict=True))
    x, y = (length * axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    points = np.column_stack([x, y, z.ravel()])
    corner = (np.arange(nx - 1)[:, None] * ny + np.arange(ny - 1)).ravel()
    # Two triangles for each square, turned to the atoms below.
    triangles = np.concatenate([
        np.column_stack([corner, corner + 1, corner + ny]),
        np.column_stack([corner + 1, corner + ny + 1, corner + ny]),
    ])  # fmt: skip
    lines = [
        "# vtk DataFile Version 3.0",
        "rigid wall, in LAMMPS' unit of length",
        "ASCII",
        "DATASET POLYDATA",
        f"POINTS {len(points)} double",
        *(" ".join(f"{value:.10g}" for value in point) for point in points),
        f"POLYGONS {len(triangles)} {4 * len(triangles)}",
        *(f"3 {a} {b} {c}" for a, b, c in triangles.tolist()),
    ]
    return "\n".join(lines) + "\n"
