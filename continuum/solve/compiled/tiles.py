"""A model of the response on tiles: the bound-constrained solver runs on them as on a whole grid, and the smooth one
solves there what only the points near the wall decide (:mod:`continuum.solve.compiled.corrections`).

G = 1/K is split into what is smooth and what is short.  The smooth part, G times a Gaussian of a few points, goes by
way of the grid of every fourth point and cubic B-splines.  The rest hardly reaches farther than fifteen points: it is
cut off there and summed directly from the points in contact, so that the work is that of the contact, not of the grid.
The model misses G by some thousandths: whoever solves it corrects by the whole grid, and again.

The preconditioner Eᵀ K E is split in the same way, the short part of K reaching seven points, and E has the splines for
its hats.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from continuum.model.fourier import Real, block_edges, cut
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate
from continuum.solve.backend import SPREAD
from continuum.solve.compiled import near_field, pressing
from continuum.solve.compiled.compiling import SUMS, Field, Index, Mask, Single
from continuum.solve.compiled.near_field import RATIO, REACHED, SIDE, cubic_spline, weights, width
from continuum.solve.compiled.passes import Given, Passes, Task
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

    def __init__(self, whole: Passes, coarse: Grid, wall: float = np.inf) -> None:
        self.wall = wall
        self.far = Passes(coarse, np.zeros(coarse.shape_q, np.float32), whole.threads)
        K = cut(whole.K, coarse.shape_q)
        self.G_far = _far(_inverse(K), coarse.shape, SMOOTH)
        self.K_far = _far(K / (1 + K / wall), coarse.shape, STIFF_SMOOTH)
        rows, columns = (n // BOX for n in whole.grid.shape)
        box = _whole(whole.K[::rows, ::columns][:, : BOX // 2 + 1])
        self.G_near, even = _near(_inverse(box), SMOOTH, REACH)
        self.K_near, also = _near(box / (1 + box / wall), STIFF_SMOOTH, STIFF_REACH)
        self.even = even and also
        """Whether the near fields are even along x, as their sweep takes them to be."""
        self.softest = float(whole.K.ravel()[1:].min())
        """K of the softest wave."""
        self.field, self.share, self.smooth, self.back = (self.far.single_rows() for _ in range(4))
        self.spline = weights()
        self._kept: dict[str, Any] = {}

    def memory(self, name: str, count: int, side: tuple[int, int]) -> Single:
        """Memory for so many tiles, kept from one set of tiles to the next."""
        if name not in self._kept or len(self._kept[name]) < count:
            self._kept[name] = np.empty((count + count // 8, *side), np.float32)
        kept: Single = self._kept[name][:count]
        return kept

    def forget(self) -> None:
        """Give that memory back."""
        self._kept.clear()


def _stiffness(law: Law) -> float:
    """Stiffness of the wall at the last of two thousand gaps at which it pushes; zero if it never does."""
    # Contact may begin at a gap of zero or less: a core on which an attraction lies does there.
    _, traction, stiffness = evaluate(law, np.linspace(law.reach - 2 * abs(law.reach), law.reach, 1999))
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


class TilePasses(Passes):
    """A grid that may have tiles; what is done on their coarse grid counts as its own work."""

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

    def near_wall(self, f: Real, z: Real, law: Law) -> Tiles | None:
        """The tiles where f is, or z in reach of a law; None where that does not pay."""
        marked = _with_any((z[:, : self.n] < law.reach + MARGIN) | (f[:, : self.n] != 0))
        split = self._on(law, marked)
        if split is None:
            return None
        split.G_far[0, 0] = 0.0 if self.held else 1.0 / self.K[0, 0]
        return Tiles(self, split, marked)

    def pay_near(self, z: Real, law: Law) -> bool:
        """Whether tiles near a wall pay, by a gap on this or the next coarser grid."""
        side = SIDE * z.shape[1] // self.n
        return self._fits and self._on(law, _with_any(z < law.reach + MARGIN, side)) is not None

    def forget_tiles(self) -> None:
        """Give the memory of tiles back that is kept from one to the next."""
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
        if not self.pays(marked, MOST_SMOOTH) or not (self.held or self.K[0, 0] > 0):
            return None
        wall = _stiffness(law)
        split = self.split(wall) if wall > 0 else None
        return split if split is not None and split.even and split.softest > 0 else None

    @property
    def own_work(self) -> Work:
        own, split = super().own_work, self._split
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


class Tiles:
    """The points of some tiles, one below the other, and a model of the response there.

    Parameters
    ----------
    whole : the passes of the grid, whose threads are used.
    split : the split response.
    marked : which tiles, shape (nx, ny)/SIDE.
    """

    def __init__(self, whole: Passes, split: Split, marked: Mask) -> None:
        self.split, self.places = split, np.argwhere(marked)
        count = len(self.places)
        self.slots: Index = np.full(marked.shape, -1, dtype=np.int64)
        self.slots[marked] = np.arange(count)
        self.whole, self.shape = whole, (count * SIDE, SIDE)
        self.spare, self.shared = self.field(), self.mask()
        self.row_edges, self.tile_edges = (block_edges(each, self.spare.size) for each in (len(self.spare), count))
        around = [(SIDE + 2 * r - 2, SIDE - 4 + width(r)) for r in (REACH, STIFF_REACH)]
        self.own, self.stiff = split.memory("G", count, around[0]), split.memory("K", count, around[1])
        self.corners = split.memory("corners", count, (REACHED, REACHED))
        self.answer, self.beside = (split.memory(name, count, (SIDE, SIDE)).reshape(self.shape) for name in ("a", "b"))
        self.some: Mask = np.zeros(count, dtype=np.bool_)

    # --- arrays ------------------------------------------------------------------------------------------------

    def field(self) -> Real:
        """A field of zeros."""
        return np.zeros(self.shape)

    def mask(self) -> Mask:
        """Marks of points, none set."""
        return np.zeros(self.shape, dtype=np.bool_)

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

    def sweep(self, sweep: Task[Given], *given: Given.args, **named: Given.kwargs) -> Real:
        """Over the rows of the tiles."""
        return self.whole.over(sweep, self.row_edges, *given, **named)

    def _each(self, sweep: Task[Given], *given: Given.args, **named: Given.kwargs) -> Real:
        """Over the tiles."""
        return self.whole.over(sweep, self.tile_edges, *given, **named)

    # --- the model of the response -----------------------------------------------------------------------------

    def _down(self, values: Real, onto: Single) -> None:
        """Values to the coarse grid."""
        self._each(near_field.to_coarse, values, self.split.spline, self.corners)
        near_field.add_coarse(0, len(self.places), np.zeros(SUMS), self.corners, self.places, self.slots, onto)

    def _up(self, coarse: Single, out: Single) -> None:
        """Add what the coarse grid has."""
        self._each(near_field.from_coarse, coarse, self.places, self.slots, self.split.spline, out)

    def _respond(self, field: Single, response: Single) -> Single:
        """A response on the coarse grid."""
        far, back, least = self.split.far, self.split.back, response[0, 0]
        far.forward(field)
        far.spectral(lambda a, b, sums: pressing.stiffness(a, b, sums, far.w, response, least))
        far.inverse(back)
        far.transforms += 2
        return back

    def _sum_near(self, values: Real, kernel: Single, reach: int, own: Single, out: Single) -> None:
        self._each(near_field.near_field, values, kernel, reach, width(reach), own, self.some)
        self._each(near_field.gather_near, own, self.some, reach, self.places, self.slots, out)

    def comply_with(self, values: Real, out: Single) -> Single:
        """Set out <- G times values."""
        near = self.split
        self._sum_near(values, near.G_near, REACH, self.own, out)
        self._down(values, near.field)
        self._up(self._respond(near.field, near.G_far), out)
        return out

    def stiffen(self, mask: Mask, out: Real, least: float, z: Real | None, shift: float) -> float:
        """Set out <- M f on the contact, 0 off it, of f = z + shift, or shift without z; returns its sum.

        M = Eᵀ K E, with ``least`` for K at q = 0.
        """
        # With R to the coarse grid and P from it, and D for share: S = P D R f is smooth, c = f - S on the contact.
        near = self.split
        field, share, smooth = near.field, near.share, near.smooth
        near.K_far[0, 0] = least
        c, beside = self.spare, self.beside

        def on_contact(values: Field | None, by: float) -> None:
            self.sweep(near_field.on_contact, mask, values, by, c)

        if not np.array_equal(mask, self.shared):
            self.shared[...] = mask
            on_contact(None, 1.0)
            self._down(c, share)
            share += np.float32(SPREAD)
            np.divide(np.float32(1), share, out=share)
        on_contact(z, shift)
        self._down(c, field)
        np.multiply(field, share, out=smooth)
        beside[...] = 0.0
        self._up(smooth, beside)
        self.sweep(near_field.subtract_on_contact, mask, beside, c)
        self._down(c, field)
        field += smooth
        back = self._respond(field, near.K_far)
        self._sum_near(c, near.K_near, STIFF_REACH, self.stiff, beside)
        self._up(back, beside)
        on_contact(beside, 0.0)
        self._down(c, field)
        np.subtract(back, field, out=smooth)
        smooth *= share
        more = self.answer
        more[...] = 0.0
        self._up(smooth, more)
        return float(self.sweep(near_field.onto_contact, mask, beside, more, out)[0])

    def precondition(self, missing: Real, stiffness: Single, out: Real) -> None:
        """Set out to about (1 + φ'' G)^-1 missing, φ'' being the stiffness."""
        wall, least = self.split.wall, self.split.softest
        stiff = stiffness > 0.5 * wall
        self.stiffen(stiff, out, least / (1 + least / wall), missing, 0.0)
        np.divide(out, wall, out=out)
        np.copyto(out, missing, where=~stiff)
