"""A response given as a table."""

from dataclasses import dataclass, field

import numpy as np

from continuum.inputs.arguments import ArgumentError, array, instance, number, pair
from continuum.model.fourier import Real
from continuum.model.grid import Grid


@dataclass(frozen=True, eq=False)
class TabulatedSubstrate:
    """A response given as a table on one grid: K_q over its half spectrum, including q = 0.

    Parameters
    ----------
    table : K_q, shape ``grid.shape_q``, in E*/a0; positive, except that q = 0 may be zero or infinite.
    lengths : periods of the grid it belongs to, in a0.
    source : description of its origin, stored with results.

    Examples
    --------
    >>> import numpy as np, continuum as c
    >>> grid = c.Grid.square(16)
    >>> table = 2 * c.HalfSpace().stiffness(grid)
    >>> substrate = c.TabulatedSubstrate(table, grid.lengths, "a half-space twice as stiff")
    >>> bool(np.all(substrate.stiffness(grid) == table))
    True
    """

    table: Real = field(repr=False)
    lengths: tuple[float, float]
    source: str

    def __post_init__(self) -> None:
        what = "a half spectrum of positive finite numbers (q = 0: zero or more, or infinite)"
        table = np.array(array("table", self.table), dtype=np.float64)
        others = table.ravel()[1:]
        if (
            table.ndim != 2
            or not table.size
            or not (np.isfinite(others).all() and (others > 0).all() and table[0, 0] >= 0)
        ):
            raise ArgumentError("table", table, what)
        lengths = tuple(number("lengths", length, above=0) for length in pair("lengths", self.lengths))
        instance("source", self.source, str, "a text that says where the table comes from")
        table.flags.writeable = False
        object.__setattr__(self, "table", table)
        object.__setattr__(self, "lengths", lengths)

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum, in E*/a0; the grid must be that of the table."""
        instance("grid", grid, Grid)
        if grid.shape_q != self.table.shape or not np.allclose(grid.lengths, self.lengths, rtol=1e-12):
            raise ValueError(
                f"grid: {grid.shape_q} modes of periods {grid.lengths}, where the table of stiffness has "
                f"{self.table.shape} and {self.lengths}"
            )
        return grid.modes_of(self.table)
