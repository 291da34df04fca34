"""The engine of a model of the response on tiles: the bound-constrained solver runs on them as on a whole grid, and
the smooth one solves there what only the points near the wall decide (:mod:`continuum.solve.corrections`).

G = 1/K is split into what is smooth and what is short.  The smooth part, G times a Gaussian of a few points, goes by
way of the grid of every fourth point and cubic B-splines.  The rest hardly reaches farther than fifteen points: it is
cut off there and summed directly from the points in contact, so that the work is that of the contact, not of the grid.
The model misses G by some thousandths: whoever solves it corrects by the whole grid, and again.

The preconditioner Eᵀ K E is split in the same way, the short part of K reaching seven points, and E has the splines for
its hats.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from continuum.model.fourier import Real, block_edges, cut
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate
from continuum.solve.backend import SPREAD, Array
from continuum.solve.cpu.compiled import SUMS, Index, Mask, Single
from continuum.solve.cpu.engine import CpuEngine, Task
from continuum.solve.cpu.near_field import RATIO, REACHED, SIDE, cubic_spline, weights, width
from continuum.solve.solution import Work

REACH, STIFF_REACH = 15, 7
"""Points that the near fields of G and K reach, less one."""
SMOOTH, STIFF_SMOOTH = 4.2, 4.8
"""Widths of the Gaussians that the far fields of G and K are smoothed with, in points."""
BOX = 256
"""Side of the periodic box in which near fields are found, in points."""
SMALLEST = 2**18
"""Grids of fewer points have no tiles: there calls, not points, would take the time."""
MOST, MOST_SMOOTH = 0.25, 0.1
"""Share of tiles beyond which the whole grid is as fast: under a bound, and under a law."""
SMALL_SHARE = 0.7
"""Part of that share on grids of less than twice as many points as the smallest."""
MARGIN = 0.05
"""A tile is near the wall where a gap is within so much of the range of the law, in a0."""


class Split:
    """The split response of one grid: near fields of G and K, and far fields on the grid of every fourth point.

    On a wall that is not infinitely stiff, K and the wall lie in series: that of the preconditioner is K/(1 + K/k).
    """

    def __init__(self, engine: CpuEngine, coarse: Grid, wall: float = np.inf) -> None:
        self.wall = wall
        self.far = CpuEngine(coarse, np.zeros(coarse.shape_q, np.float32), engine.threads)
        K = cut(engine.K, coarse.shape_q)
        K[0, 0] = 0.0
        self.G_far = _far(_inverse(K), coarse.shape, SMOOTH)
        self.K_far = _far(K / (1 + K / wall), coarse.shape, STIFF_SMOOTH)
        rows, columns = (n // BOX for n in engine.grid.shape)
        box = _whole(engine.K[::rows, ::columns][:, : BOX // 2 + 1])
        self.G_near, even = _near(_inverse(box), SMOOTH, REACH)
        self.K_near, also = _near(box / (1 + box / wall), STIFF_SMOOTH, STIFF_REACH)
        self.even = even and also
        """Whether the near fields are even along x, as their sweep takes them to be."""
        self.softest = float(engine.K.ravel()[1:].min())
        """K of the softest wave."""
        self.field, self.share, self.smooth, self.back = (self.far.single_rows() for _ in range(4))
        self.spline = weights()
        self._kept: dict[str, Any] = {}

    def memory(self, name: str, count: int, side: tuple[int, int]) -> Single:
        """Memory for so many tiles, kept from one engine to the next."""
        if name not in self._kept or len(self._kept[name]) < count:
            self._kept[name] = np.empty((count + count // 8, *side), np.float32)
        kept: Single = self._kept[name][:count]
        return kept

    def forget(self) -> None:
        """Give that memory back."""
        self._kept.clear()


def _stiffness(law: Law) -> float:
    """Stiffness of the wall at the last of a thousand gaps at which it pushes; zero if it never does."""
    _, traction, stiffness = evaluate(law, np.linspace(0.0, law.reach, 1000))
    pushing = np.flatnonzero(traction > 0)
    return float(stiffness[pushing[-1]]) if pushing.size else 0.0


def _with_any(points: Mask, side: int = SIDE) -> Mask:
    """Tiles of so many points a side with any of these points, shape of the whole over ``side``."""
    nx, ny = points.shape
    found: Mask = np.asarray(points.reshape(nx // side, side, ny // side, side).any(axis=(1, 3)))
    return found


def _inverse(K: Real) -> Real:
    """1/K, zero where K is."""
    return np.divide(1.0, K, out=np.zeros_like(K), where=K > 0)


def _along(n: int, period: int) -> tuple[Real, Real]:
    """Wavenumbers of n modes of a period, in points, and what a spline on every fourth point leaves of them."""
    q = 2 * np.pi * np.fft.fftfreq(n, 1 / n) / period
    x = np.arange(1 - 2 * RATIO, 2 * RATIO)
    return q, np.cos(np.outer(q, x)) @ cubic_spline(x / RATIO) / RATIO


def _far(values: Real, shape: tuple[int, int], smooth: float) -> Single:
    """A response on the coarse grid, half spectrum: smoothed, without what the splines do to it."""
    (qx, wx), (qy, wy) = (_along(n, RATIO * n) for n in shape)
    columns = values.shape[1]
    smoothed = np.exp(-0.5 * smooth**2 * (qx[:, None] ** 2 + qy[:columns] ** 2))
    return (values * smoothed / (wx[:, None] * wy[:columns]) ** 2).astype(np.float32)


def _whole(half: Real) -> Real:
    """The whole of an even spectrum, from one half."""
    back = -np.arange(BOX) % BOX
    return np.hstack([half, half[back][:, BOX // 2 - 1 : 0 : -1]])


def _near(values: Real, smooth: float, reach: int) -> tuple[Single, bool]:
    """What a response has beyond its far field, as rows for a sweep; whether it is even along either direction."""
    values[0, 0] = 0.0
    zone = BOX // RATIO
    folded = (np.arange(BOX) + zone // 2) % zone - zone // 2
    q, w = _along(BOX, BOX)
    smoothed = np.exp(-0.5 * smooth**2 * (q[folded][:, None] ** 2 + q[folded] ** 2))
    far = values[np.ix_(folded, folded)] * smoothed * ((w / w[folded])[:, None] * (w / w[folded])) ** 2
    rest = values - far  # the mean mode passes by way of the far field
    rest[0, 0] = 0.0
    kernel = np.fft.ifft2(rest).real
    around = np.arange(1 - reach, reach)
    rows = np.zeros((reach, width(reach) + 8), np.float32)
    rows[:, 4 : 2 * reach + 3] = kernel[np.ix_(np.arange(reach), around)]
    even = np.abs(kernel - kernel[-np.arange(BOX)]).max() <= 1e-6 * np.abs(kernel).max()
    return rows, bool(even)


class TiledEngine(CpuEngine):
    """The engine of a grid that may have tiles; what is done on their coarse grid counts as its own work."""

    _split: Split | None = None
    _wall = np.nan
    """Stiffness of the wall of which the split was made, if it was asked for."""

    def split(self, wall: float = np.inf) -> Split | None:
        """The response as tiles have it, with a wall of this stiffness; None on a grid that has none."""
        if wall != self._wall:
            half = self.grid.coarser
            coarse = half.coarser if half is not None else None
            self._wall = wall
            self._split = Split(self, coarse, wall) if self._fits and coarse is not None else None
        return self._split

    def near_wall(self, f: Real, z: Real, law: Law) -> CpuTileEngine | None:
        marked = _with_any((z[:, : self.n] < law.reach + MARGIN) | (f[:, : self.n] != 0))
        split = self._on(law, marked)
        if split is None:
            return None
        split.G_far[0, 0] = 0.0 if self._held else 1.0 / self.K[0, 0]
        return CpuTileEngine(self, split, marked)

    def has_tiles(self, engine: CpuEngine, z: Real, law: Law) -> bool:
        side = SIDE * engine.n // self.n
        return self._fits and self._on(law, _with_any(z[:, : engine.n] < law.reach + MARGIN, side)) is not None

    def forget_tiles(self) -> None:
        if self._split is not None:
            self._split.forget()

    @property
    def _fits(self) -> bool:
        return self.size >= SMALLEST and not any(n % BOX for n in self.grid.shape)

    def pays(self, marked: Mask, most: float) -> bool:
        """Whether there are tiles, and few enough."""
        return bool(0 < marked.mean() <= (most if self.size >= 2 * SMALLEST else SMALL_SHARE * most))

    def _on(self, law: Law, marked: Mask) -> Split | None:
        """The response on these tiles of a wall; None where they do not pay, or there is none."""
        if not self.pays(marked, MOST_SMOOTH) or not (self._held or self.K[0, 0] > 0):
            return None
        wall = _stiffness(law)
        split = self.split(wall) if wall > 0 else None
        return split if split is not None and split.even and split.softest > 0 else None

    @property
    def work(self) -> Work:
        own, split = super().work, self._split
        if split is None:
            return own
        return own._replace(
            fft_pairs=own.fft_pairs + split.far.transforms / 2 * split.far.size / self.size,
            fft_seconds=own.fft_seconds + split.far.fft_seconds,
        )

    def forget_work(self) -> None:
        super().forget_work()
        if self._split is not None:
            self._split.far.forget_work()


class CpuTileEngine(CpuEngine):
    """What the solvers ask of an engine, for the points of some tiles, one below the other.

    Parameters
    ----------
    whole : the engine of the grid, whose threads it uses.
    near : the split response.
    marked : which tiles, shape (nx, ny)/SIDE.
    """

    def __init__(self, whole: CpuEngine, near: Split, marked: Mask) -> None:
        # Nothing of a grid: no K, no spectrum.
        self.split, self.places = near, np.argwhere(marked)
        count = len(self.places)
        self.slots: Index = np.full(marked.shape, -1, dtype=np.int64)
        self.slots[marked] = np.arange(count)
        self.whole, self.size, self.n = whole, whole.size, SIDE
        self.shape = count * SIDE, SIDE
        self.row_edges, self.tile_edges = (block_edges(each, count * SIDE**2) for each in (count * SIDE, count))
        self.touched = np.full((count * SIDE, 1), 2, dtype=np.uint8)
        self.lowest = np.full((count * SIDE, 1), -np.inf)
        self._own = {"n": SIDE, "most": np.inf, "touched": self.touched, "lowest": self.lowest}
        self._own |= {"tiles": self.places, "slots": self.slots, "spline": near.spline}
        self.trials = 0
        around = [(SIDE + 2 * r - 2, SIDE - 4 + width(r)) for r in (REACH, STIFF_REACH)]
        self.own, self.stiff = near.memory("G", count, around[0]), near.memory("K", count, around[1])
        self.corners = near.memory("corners", count, (REACHED, REACHED))
        self.answer, self.beside = (near.memory(name, count, (SIDE, SIDE)).reshape(self.shape) for name in ("a", "b"))
        self.some = np.zeros(count, dtype=np.bool_)
        self.spare, self.shared = self.field(), self.mask()

    # --- arrays --------------------------------------------------------------------------------------------

    def field(self) -> Real:
        return np.zeros(self.shape)

    def mask(self) -> Mask:
        return np.zeros(self.shape, dtype=np.bool_)

    def fill(self, values: Real, number: float) -> None:
        values[...] = number
        self.touched[...] = 2

    def scale(self, field: Real, factor: float) -> None:
        self.sweep("stretch", p=field, factor=factor, out=field)

    def gather(self, whole: Real) -> Real:
        """The tiles of a field of the whole grid."""
        nx, ny = self.slots.shape
        blocks = whole[: nx * SIDE, : ny * SIDE].reshape(nx, SIDE, ny, SIDE)
        found: Real = blocks[self.places[:, 0], :, self.places[:, 1]].reshape(self.shape)
        return found

    def scatter(self, values: Real, whole: Real) -> None:
        """The tiles back into a field of the whole grid."""
        nx, ny = self.slots.shape
        blocks = whole[: nx * SIDE, : ny * SIDE].reshape(nx, SIDE, ny, SIDE)
        blocks[self.places[:, 0], :, self.places[:, 1]] = values.reshape(-1, SIDE, SIDE)

    def over(self, task: Task, edges: Sequence[int]) -> Real:
        return self.whole.over(task, edges)

    # --- the model of the response -------------------------------------------------------------------------

    def _tiles(self, name: str, **given: Any) -> Real:
        """A sweep over the tiles."""
        kernel, arguments = self._bound(name, 3, given)
        return self.over(lambda a, b, sums: kernel(a, b, sums, *arguments), self.tile_edges)

    def _down(self, values: Array, onto: Array) -> None:
        """Values to the coarse grid."""
        nx, ny = self.split.far.grid.shape
        self._tiles("to_coarse", values=values, own=self.corners)
        kernel, arguments = self._bound("add_coarse", 3, {"own": self.corners, "rows": nx, "columns": ny, "out": onto})
        kernel(0, len(self.places), np.zeros(SUMS), *arguments)

    def _up(self, coarse: Array, out: Array) -> None:
        """Add what the coarse grid has."""
        nx, ny = self.split.far.grid.shape
        self._tiles("from_coarse", values=coarse, rows=nx, columns=ny, out=out)

    def _respond(self, field: Array, response: Single) -> Array:
        """A response on the coarse grid."""
        far, back = self.split.far, self.split.back
        far.forward(field)
        far.spectral("stiffness", K=response, least=response[0, 0])
        far.inverse(back)
        far.transforms += 2
        return back

    def _sum_near(self, values: Real, kernel: Single, reach: int, own: Single, out: Single) -> None:
        near = {"own": own, "some": self.some, "reach": reach}
        self._tiles("near_field", values=values, kernel=kernel, columns=width(reach), **near)
        self._tiles("gather_near", out=out, **near)

    def comply_with(self, values: Real, out: Single) -> Single:
        """Set out <- G times values."""
        near = self.split
        self._sum_near(values, near.G_near, REACH, self.own, out)
        self._down(values, near.field)
        self._up(self._respond(near.field, near.G_far), out)
        return out

    def stiffen(self, mask: Mask, out: Real, least: float, z: Real | None = None, shift: float = 0.0) -> float:
        # With R to the coarse grid and P from it, and D for share: S = P D R f is smooth, c = f - S on the contact.
        near = self.split
        field, share, smooth = near.field, near.share, near.smooth
        near.K_far[0, 0] = least
        c, beside = self.spare, self.beside
        if not np.array_equal(mask, self.shared):
            self.shared[...] = mask
            self.sweep("on_contact", mask=mask, z=c, shift=0.0, ones=True, out=c)
            self._down(c, share)
            share += np.float32(SPREAD)
            np.divide(np.float32(1), share, out=share)
        self.sweep("on_contact", mask=mask, z=c if z is None else z, shift=shift, ones=z is None, out=c)
        self._down(c, field)
        np.multiply(field, share, out=smooth)
        beside[...] = 0.0
        self._up(smooth, beside)
        self.sweep("without", mask=mask, beside=beside, out=c)
        self._down(c, field)
        field += smooth
        back = self._respond(field, near.K_far)
        self._sum_near(c, near.K_near, STIFF_REACH, self.stiff, beside)
        self._up(back, beside)
        self.sweep("on_contact", mask=mask, z=beside, shift=0.0, ones=False, out=c)
        self._down(c, field)
        np.subtract(back, field, out=smooth)
        smooth *= share
        more = self.answer
        more[...] = 0.0
        self._up(smooth, more)
        return float(self.sweep("onto_contact", mask=mask, field=beside, more=more, out=out)[0])

    # --- in the words of the smooth solver -----------------------------------------------------------------

    def advance(self, step: float, law: Law, **given: Any) -> tuple[float, float]:
        sums = self.sweep("advance_traction", step=step, kind=law.kind, parameters=law.parameters, **given)
        return float(sums[0]), float(sums[1])

    def along(self, step: float, law: Law, **given: Any) -> tuple[float, float]:
        sums = self.sweep("along_traction", step=step, kind=law.kind, parameters=law.parameters, **given)
        return float(sums[0]), float(sums[1])

    def relent(self, missing: Real, stiffness: Single, out: Real) -> None:
        wall, least = self.split.wall, self.split.softest
        stiff = stiffness > 0.5 * wall
        self.stiffen(stiff, out, least / (1 + least / wall), missing)
        np.divide(out, wall, out=out)
        np.copyto(out, missing, where=~stiff)

    # --- in the words of the bound-constrained solver ------------------------------------------------------

    def into(self, name: str, **given: Any) -> Real:
        self._direction = given["t"]
        return self.sweep(name, **given)

    def comply(self, *, inverse: bool = False) -> float:
        t = self._direction
        return float(self.sweep("dot", values=t, field=self.comply_with(t, self.answer))[0] / self.size)

    def alter(self, step: float, factor: float, **given: Real) -> float:
        """Set out <- the gap under the pressure new, ``factor`` times p - ``step`` t cut at zero, after :meth:`comply`.

        Returns by how much the energy rises, summed over the points.
        """
        self.sweep("cut_off", step=step, out=self.spare, **{key: given[key] for key in "pt"})
        cut = self.comply_with(self.spare, self.beside)
        rise = self.sweep("change", along=self.answer, cut=cut, step=step, factor=factor, **given)[0]
        self.lowest[...] = -np.inf
        return float(rise)

    def spectral(self, name: str = "", **given: Any) -> Real:
        return np.zeros(SUMS)

    def out_of(self, name: str, **given: Any) -> Real:
        given["out"][...] = self.answer
        return self.sweep(name, **given)
