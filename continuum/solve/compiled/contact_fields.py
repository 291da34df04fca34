"""What vanishes off a contact on processor cores: where it may not, its transforms, and the preconditioner."""

import time
from functools import cached_property

import numpy as np

from continuum.model.fourier import Real, columns_forward, columns_inverse, padded, rows_forward, rows_inverse
from continuum.model.grid import Grid
from continuum.solve.backend import SPREAD, near_kernel, node_stiffness
from continuum.solve.compiled import pressing, two_levels
from continuum.solve.compiled.compiling import Marks, Mask
from continuum.solve.compiled.passes import Sweep
from continuum.solve.compiled.pressing import ContactPoints
from continuum.solve.compiled.tiles import TilePasses
from continuum.solve.compiled.two_levels import Nodes


class ContactPasses(TilePasses):
    """The arrays of a grid under a bound.

    Pressures, and all that vanishes off the contact, are looked at in tiles marked by
    :mod:`continuum.solve.compiled.pressing`, and transformed in rows that have such a tile.  A field that is
    transformed lies in an array of its own.

    Parameters
    ----------
    grid, K, threads : as for :class:`continuum.solve.compiled.passes.Passes`; what is not finite counts as zero.
    """

    softest: float
    """K of the softest wave."""
    m: Real

    def __init__(self, grid: Grid, K: Real, threads: int) -> None:
        super().__init__(grid, K, threads)
        K[~np.isfinite(K)] = 0.0
        self.G = np.divide(1.0, K, out=np.zeros_like(K), where=K > 0)
        self.touched: Marks = np.full(self.near.shape, 2, dtype=np.uint8)
        self.lowest, self.worst = np.zeros(self.near.shape), np.zeros(grid.shape[0])
        self.mask: Mask = np.zeros(grid.shape, dtype=np.bool_)
        self.nodes, self.kernel = Nodes.of(grid), near_kernel(grid, K)
        node_grid, self.K_nodes = node_stiffness(grid, K)
        self.node_q, self.far = padded(node_grid.shape_q, np.complex128), np.zeros(node_grid.shape)

    def set_mean_stiffness(self, stiffness: float, *, held: bool) -> None:
        super().set_mean_stiffness(stiffness, held=held)
        self.G[0, 0] = 1.0 / stiffness if stiffness > 0 else 0.0

    @property
    def contact(self) -> ContactPoints:
        """The points in contact, for a sweep."""
        return ContactPoints(self.mask, self.m, self.n, self.touched)

    def _touch_all(self) -> None:
        """Take every tile as one that may have been touched."""
        self.touched[...] = 2

    def _together(self, field: Real) -> Real:
        """The rows of a field, moved together in their own memory."""
        flat = field.ravel()
        rows, n = self.grid.shape
        for i in range(rows):
            flat[i * n : (i + 1) * n] = field[i, :n]
        return flat[: rows * n].reshape(rows, n)

    @cached_property
    def softness(self) -> float:
        """Root of the sum of 1/K² over all modes but the mean."""
        weights = self.grid.mode_weights[0]
        rest = float(np.sum(self.G[1:, 0] ** 2) * weights[0])
        return float(np.sqrt(rest + np.einsum("ij,ij,j->", self.G[:, 1:], self.G[:, 1:], weights[1:])))

    # --- transforms of pressures -------------------------------------------------------------------------------

    def _forward_rows(self, field: Real, first: int, last: int, *, sparse: bool) -> float:
        """Transform a block of rows; those without a touched tile are zero.  Returns the seconds it took."""
        began = time.perf_counter()
        end = first
        for a, b in runs(np.any(self.touched[first:last], axis=1), first) if sparse else [(first, last)]:
            self.work_q[end:a] = 0.0
            rows_forward(field[a:b, : self.n], self.work_q[a:b])
            end = b
        self.work_q[end:last] = 0.0
        return time.perf_counter() - began

    def _loaded(self, field: Real, sweep: Sweep | None = None, *, sparse: bool = True) -> Real:
        """Begin to transform a field, that a sweep makes."""
        self.transforms += 1

        def task(first: int, last: int, sums: Real) -> float:
            if sweep is not None:
                sweep(first, last, sums)
            return self._forward_rows(field, first, last, sparse=sparse)

        return self.over(task, self.row_edges)

    def _unloaded(self, out: Real, sweep: Sweep) -> Real:
        """A field is transformed back, and a sweep uses it."""
        self.transforms += 1

        def task(first: int, last: int, sums: Real) -> float:
            began = time.perf_counter()
            rows_inverse(self.work_q[first:last], out[first:last, : self.n])
            seconds = time.perf_counter() - began
            sweep(first, last, sums)
            return seconds

        return self.over(task, self.row_edges)

    def _comply(self, *, inverse: bool = False) -> float:
        """Multiply the spectrum of the field f at hand by G; returns <f G f>."""
        G, weights = self.G, self.weights
        sums = self.spectral(
            lambda a, b, sums: pressing.compliance(a, b, sums, self.w, G, weights), forward=True, inverse=inverse
        )
        return float(sums[0])

    def _stiffen(self, out: Real, z: Real | None, shift: float) -> float:
        """Set out <- M f on the contact, 0 off it, of f = z + shift, or shift without z; returns its sum.

        For M see :mod:`continuum.solve.compiled.two_levels`.
        """
        nodes, contact = self.nodes, self.contact
        used: Mask = np.any(self.touched, axis=1)
        self.sweep(two_levels.collect_contact, z, shift, out, contact, nodes)
        two_levels.sum_lines(used, nodes, nodes.counts, nodes.density)
        two_levels.sum_lines(used, nodes, nodes.lines, nodes.field)
        nodes.density[...] += SPREAD
        nodes.field[...] /= nodes.density
        self.sweep(two_levels.subtract_means, out, contact, nodes)
        far = self._far(nodes.field[:-1, :-1])
        near = self.w  # no transform of the grid is under way
        self.sweep(two_levels.sum_neighbours, out, self.kernel, near, contact, nodes)
        two_levels.sum_lines(used, nodes, nodes.lines, nodes.field)
        field = nodes.field[:-1, :-1]
        np.subtract(far, field, out=field)
        nodes.field[-1], nodes.field[:, -1] = nodes.field[0], nodes.field[:, 0]
        nodes.field[...] /= nodes.density
        return float(self.sweep(two_levels.add_nodes, near, out, contact, nodes)[0])

    def _far(self, means: Real) -> Real:
        """K on the nodes."""
        spectrum, far = self.node_q, self.far
        rows_forward(means, spectrum)
        columns_forward(spectrum)
        spectrum *= self.K_nodes
        columns_inverse(spectrum)
        rows_inverse(spectrum, far)
        self.transforms += 2 * far.size / self.size
        return far


def runs(used: Mask, first: int) -> list[tuple[int, int]]:
    """Where runs of rows in use begin and end, the first row being of this number."""
    marks = np.zeros(used.size + 2, dtype=np.bool_)
    marks[1:-1] = used
    edges = (first + np.flatnonzero(marks[1:] != marks[:-1])).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))
