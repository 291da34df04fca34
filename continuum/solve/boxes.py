"""Parts of a surface that are about to snap, each looked at in a small box with the rest held.

Where attraction is strong and short-ranged a solve stalls: the residual is small, and lies in a few places at which
the rim of a contact snaps from one row of points to the next.  Iterations of the whole surface move such a rim by
about a point each.  So the energy of what happens in a box alone is minimised, from the state at hand: with f the force
of the substrate there, K of the waves that fit, and the displacement v on top of what there is::

    E_box(v) = <f, v> + ½ <v, K v> + <φ(z - v)>

A window lets v go to zero at the edge.  The whole surface then goes on from there; what is an equilibrium is decided
by its own residual only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate
from continuum.solve.solution import Solution

POINTS = 64
"""Points of a box along a side, about; 32 are too few."""
TILES = 4
"""A box is so many tiles along a side; its place is that of the residual in the middle ones."""
FEWEST = 4
"""Boxes that a side of the surface must have room for."""
LEAST = 0.01
"""Share of the sum of squares of the residual that the middle of a box must hold."""
MOST = 64
"""Boxes at once."""
Place = tuple[NDArray[np.intp], NDArray[np.intp]]
"""Rows and columns of a box."""
Descent = Callable[[Real, Real], Solution]
"""The equilibrium of a box, from its offset and the gap at which it begins."""


@dataclass(frozen=True, eq=False)
class Boxes:
    """The boxes that fit on a grid.

    Parameters
    ----------
    grid : of a box.
    of : of the surface.
    stiffness_q : K of the waves of a box, in E*/a0.
    """

    grid: Grid
    of: Grid
    stiffness_q: Real

    @classmethod
    def on(cls, grid: Grid, stiffness_q: Real) -> Boxes | None:
        """Boxes on a grid of which each wave is one of the surface; None where it is small, or has no such boxes."""
        parts = [round(n / POINTS) for n in grid.shape]
        if min(parts) < FEWEST or any(n % (part * TILES) for n, part in zip(grid.shape, parts, strict=True)):
            return None
        (nx, ny), (px, py) = grid.shape, parts
        lengths = grid.lengths[0] / px, grid.lengths[1] / py
        K = np.array(stiffness_q[::px, ::py])
        # The mean of a box is no mean of the surface: it is as stiff as the longest wave.
        K[0, 0] = min(K[0, 1], K[1, 0])
        return cls(Grid((nx // px, ny // py), lengths), grid, K)

    @cached_property
    def window(self) -> Real:
        """1 in the middle, falling to 0 over the tiles at the edge."""
        sides = []
        for n in self.grid.shape:
            rise = 0.5 - 0.5 * np.cos(np.pi * (np.arange(n // TILES) + 0.5) / (n // TILES))
            sides.append(np.concatenate([rise, np.ones(n - 2 * rise.size), rise[::-1]]))
        return np.outer(*sides)

    def places(self, g: Real) -> Iterator[Place]:
        """Where the residual g, shape of the surface, is largest: boxes that do not overlap."""
        tile = [n // TILES for n in self.grid.shape]
        rows, columns = (n // t for n, t in zip(self.of.shape, tile, strict=True))
        squares = np.einsum("iajb,iajb->ij", *(2 * [g.reshape(rows, tile[0], columns, tile[1])]))
        total = float(squares.sum())
        middle = sum(np.roll(squares, (-a, -b), (0, 1)) for a in (0, 1) for b in (0, 1))
        for _ in range(MOST):
            i, j = np.unravel_index(int(np.argmax(middle)), middle.shape)
            if not middle[i, j] > LEAST * total:
                return
            near = np.arange(1 - TILES, TILES)
            middle[np.ix_((i + near) % rows, (j + near) % columns)] = 0.0
            (height, width), (nx, ny) = self.grid.shape, self.of.shape
            yield (
                ((i - 1) * tile[0] + np.arange(height)) % nx,
                ((j - 1) * tile[1] + np.arange(width)) % ny,
            )

    def relax(self, law: Law, z: Real, traction: Real, g: Real, descend: Descent) -> tuple[float, float]:
        """Go down in boxes where the residual g is largest, and change the gap z by what was found.

        A box whose energy would rise, as what was found did not end within the window, is left as it is.

        Parameters
        ----------
        z, traction, g : of the surface, shape ``of.shape``; the traction is that of the wall.
        descend : finds the equilibrium of a box.

        Returns
        -------
        rise, pairs
            Change of the energy, per point of the surface, and the pairs of transforms of a box.
        """
        rise, pairs = 0.0, 0.0
        for place in self.places(g):
            at = np.ix_(*place)
            inside, force = z[at], g[at] - traction[at]
            found = descend(self.offset(inside, force), inside)
            pairs += found.fft_pairs + 2
            v = self.window * (inside - found.gap)
            change = self.rise(law, inside, force, v)
            if change < 0:
                z[at] = inside - v
                rise += change * self.grid.size / self.of.size
        return rise, pairs

    def carried(self, stiffness: NDArray[np.float32]) -> bool:
        """Whether the next coarser grid of the surface has four points for the shortest wave that snaps.

        That is the one as stiff as the softest point of the wall is soft; ``stiffness`` is that of the wall.
        """
        (nx, ny), K = self.grid.shape, self.stiffness_q
        return bool(stiffness.min() >= -min(K[0, ny // 8], K[nx // 8, 0]))

    def offset(self, z: Real, f: Real) -> Real:
        """The gap at which the surface of a box would rest without a wall, by the force f of the substrate."""
        return z + self.grid.inverse(self.grid.forward(f) / self.stiffness_q, overwrite=True)

    def rise(self, law: Law, z: Real, f: Real, v: Real) -> float:
        """Change of the energy of a box by a displacement v, per point."""
        v_q = self.grid.forward(v)
        elastic = self.grid.mean(f * v) + 0.5 * self.grid.inner_q(v_q, self.stiffness_q * v_q)
        return elastic + self.grid.mean(evaluate(law, z - v)[0] - evaluate(law, z)[0])
