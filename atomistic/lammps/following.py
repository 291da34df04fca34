"""Heights of any array above where the atoms are, handed to LAMMPS in this process in each evaluation of the forces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from atomistic.lammps.shape import HeightSpline
from continuum.model.fourier import Real


def follow_atoms(lammps: Any, shape: tuple[int, int]) -> Callable[[], None]:
    """Let the wall of ``slab.data`` follow (nx, ny) surface atoms in a LAMMPS that has read ``in.wall``.

    Its heights, those at the sites, are interpolated; before the force of the wall is evaluated, the height and the
    slopes above each atom are written into ``d_height``, ``d_slope_x`` and ``d_slope_y``.  What is returned raises
    what has gone wrong on the way, which LAMMPS would lose.
    """
    count = shape[0] * shape[1]
    wall = HeightSpline(np.array(lammps.gather("d_height", 1, 1), dtype=np.float64)[:count].reshape(shape))
    length = float(lammps.extract_variable("length_unit"))
    failures: list[BaseException] = []

    def heights(_: Any, step: int, local: int, tag: NDArray[np.int64], x: Real, f: Real) -> None:
        try:
            f[...] = 0.0
            mine = np.flatnonzero(tag <= count)
            offset = [float(lammps.extract_variable(f"offset_{name}")) for name in "xy"]
            found = wall.evaluate(x[mine, 0] / length - offset[0], x[mine, 1] / length - offset[1])
            for name, values in zip(("d_height", "d_slope_x", "d_slope_y"), found, strict=True):
                lammps.numpy.extract_atom(name)[mine] = values
        except BaseException as error:
            failures.append(error)

    def check() -> None:
        if failures:
            raise failures[0]

    lammps.set_fix_external_callback("follow", heights, None)
    return check
