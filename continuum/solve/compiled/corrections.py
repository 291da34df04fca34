"""Equilibrium of a smooth energy by defect correction: its few tiles near the wall first, then what they missed.

Away from the wall the surface obeys its own elasticity: the tractions f of the wall, on the points within its reach,
are all that is unknown::

    z = offset - u     u = (F - f)/K     f = p(z) at the solution

One pair of transforms of the whole grid gives z, and f - p(z) is its residual.  On the tiles that the wall reaches,
with a model of the response G = 1/K (:mod:`continuum.solve.compiled.tiles`), Newton's method solves the same equations,
and another pair says what the model missed.  The linear problems (1 + φ'' G) t = p(z) - f are solved by generalised
conjugate residuals: where the wall is about as stiff as under a load they are preconditioned as under a hard wall,
K and the stiffness of the wall in series.  The energy falls along each step.  A direction along which it has no
positive curvature ends the linear problem; where a part of the contact snaps the step goes along it, so that the tiles
carry the snap over, which takes conjugate gradients on the whole grid (:mod:`continuum.solve.smooth`) ten iterations
and more.  Those go on from the last state where the tiles do not come to an end.
"""

import numpy as np

from continuum.model.fourier import Real
from continuum.solve.compiled import pressing, spectra, tractions
from continuum.solve.compiled.compiling import Field, Single
from continuum.solve.compiled.smooth_grid import CompiledSmoothGrid
from continuum.solve.compiled.tiles import TilePasses, Tiles
from continuum.solve.solution import Goal, Iteration

SLOW = 0.5
"""Part of the residual that a correction may leave, at most."""
MISSED, BEYOND = 0.01, 0.3
"""Part of it to which tiles are solved, about what their response misses; and that of what is asked for, at least."""
LOOSE, DIRECTIONS = 0.1, 8
"""A linear problem is solved to this part of its residual, or in so many directions."""
NEWTON_STEPS, TRIALS = 25, 30
"""Steps of a correction, and trial lengths of a step, at most."""
SLOPE_ACCEPTED = 0.3
"""Part of the slope of the energy that a step may leave."""
LARGEST_RISE = 1e-12
"""A rise of the energy by this part of that of the wall is rounding; the whole grid judges a larger one."""


class TiledSmoothGrid(TilePasses, CompiledSmoothGrid):
    """A grid of the smooth solver that has tiles near the wall, where these pay."""

    def has_tiles(self, *, below: bool = False) -> bool:
        known = self.chain[1 if below else 0]
        return self.pay_near(known.z[:, : known.n], self.law)

    def correct(self, goal: Goal, history: list[Iteration], iterations: int, *, coarser: bool) -> bool | None:
        f = self._traction_below() if coarser else self._own_traction()
        if f is None:
            return None
        if self._approach(f, goal, history, iterations):
            self.forget_wall()
            self.traction, self.corrected = f, True
            return True
        history.clear()
        self.forget_tiles()
        self.go_to_start()
        return False

    def _traction_below(self) -> Real | None:
        """The traction of the coarser grid, in the memory of the direction; None if that found none."""
        below, f = self.chain[1], self.direction
        # The offset of the coarser grid lies there, and is needed where its state is none.
        traction, of = below.traction, below.n
        if not np.isfinite(traction[:, :of].sum()):
            return None
        self.sweep(pressing.spread, traction, of, f, self.n)
        below.release()
        return f

    def _own_traction(self) -> Real:
        """The traction under which the state at hand is where it is, whose gradient is complete: p - g."""
        self.force()
        f = self.direction
        np.subtract(self.traction, f, out=f)
        f[self.z >= self.law.reach] = 0.0
        return f

    def _approach(self, f: Real, goal: Goal, history: list[Iteration], iterations: int) -> bool:
        """Find the gap under a traction and what is missing, correct the traction on tiles, and again."""
        error = last = np.inf
        first, snapped = 0.0, False
        while len(history) <= iterations:
            mean = self._gap_under(f)
            near = self.near_wall(f, self.z, self.law)
            if near is None:
                return False
            tiles = _Tiles(self, near, f)
            energy = tiles.energy(mean)
            first = first if history else energy
            history.append(Iteration(tiles.residual, energy - first, 1.0))
            if goal.reached(tiles.residual, self.look):
                return True
            # What has snapped is a new state, whose residual says nothing of the last correction; its energy does.
            slow = not (snapped or tiles.residual < SLOW * error)
            if slow or energy > last + LARGEST_RISE * abs(tiles.wall_energy):
                return False
            error, last = tiles.residual, energy
            if not tiles.relax(max(BEYOND * goal.bound, MISSED * error)):
                return False
            snapped = tiles.snapped
            tiles.onto(f)
        return False

    def _gap_under(self, f: Real) -> float:
        """Set z to the gap of a surface under the traction f; returns the mean of its displacement."""
        self._load(f)
        force = 0.0 if self.held else self.pressure
        mean = self.spectral(
            lambda a, b, sums: spectra.yielding(a, b, sums, self.w, self.K, force), forward=True, inverse=True
        )[0]
        self._lay()
        return float(mean)


class _Tiles:
    """Traction f and gap z of the tiles near the wall; from there on a model says how z follows f."""

    def __init__(self, grid: TiledSmoothGrid, tiles: Tiles, f: Real) -> None:
        self.grid, self.tiles, self.law = grid, tiles, grid.law
        self.f, self.z, self.offset = (tiles.gather(each) for each in (f, grid.z, grid.offset))
        self.t, self.w, self.missing, self.spare = (tiles.field() for _ in range(4))
        self.stiffness: Single = np.empty(tiles.shape, np.float32)
        self.snapped = False
        """Whether a step went to where the energy has a negative curvature."""
        self._advance(0.0)

    def _advance(self, step: float) -> tuple[float, float]:
        """Go along the direction: f, z, what is missing there; returns slope and curvature of the energy, summed."""
        given = self.f, self.z, self.t, self.w, step, self.law, self.missing, self.stiffness
        sums = self.tiles.sweep(tractions.advance_traction, *given)
        squares, energy, slope, curvature = (float(each) for each in sums[:4])
        self.residual, self.wall_energy = float(np.sqrt(squares / self.grid.size)), energy / self.grid.size
        return slope, curvature

    def energy(self, mean: float) -> float:
        """Energy per point of the whole surface, before anything has moved; ``mean`` is that of the displacement."""
        grid = self.grid
        work = _dot(self.offset + grid.lift - self.z, self.f) / grid.size
        return self.wall_energy - 0.5 * (work + grid.pressure * mean)

    def relax(self, bound: float) -> bool:
        """Newton's method, to this residual; whether it came there."""
        for _ in range(NEWTON_STEPS):
            if not self.residual > bound:
                return self.residual <= bound
            self._find_direction(max(LOOSE, 0.5 * bound / self.residual))
            if not self._descend():
                return False
        return False

    def _find_direction(self, part: float) -> None:
        """Set t and w = G t to about Newton's step, which leaves a part of the linear residual.

        Where the energy has a negative curvature it is what was found before, if that goes down, or that direction.
        """
        left, tiles = self.missing.copy(), self.tiles
        self.t[...] = self.w[...] = 0.0
        aim = part**2 * _dot(left, left)
        kept: list[tuple[Single, Single, Single, float]] = []
        for _ in range(DIRECTIONS):
            tiles.precondition(left, self.stiffness, self.spare)
            w = tiles.comply_with(self.spare, tiles.answer).copy()
            t = self.spare.astype(np.float32)
            q = t + self.stiffness * w
            for old_t, old_w, old_q, square in kept:
                part_of = np.float32(_dot(q, old_q) / square)
                t -= part_of * old_t
                w -= part_of * old_w
                q -= part_of * old_q
            square = _dot(q, q)
            if not (_dot(w, q) > 0 and square > 0):
                self.snapped = True
                if not _dot(self.missing, self.w) < 0:
                    self.t[...], self.w[...] = t, w
                break
            length = _dot(left, q) / square
            left -= length * q
            self.t -= length * t
            self.w -= length * w
            if _dot(left, left) <= aim:
                break
            kept.append((t, w, q, square))
        if _dot(self.missing, self.w) > 0:
            # At a saddle Newton's step may go up, and a direction of negative curvature has either sign: go down.
            self.snapped = True
            np.negative(self.t, out=self.t)
            np.negative(self.w, out=self.w)

    def _descend(self) -> bool:
        """Go along the direction to about the minimum of the energy; whether there is one."""
        first = _dot(self.missing, self.w)
        step, here, low, high = 1.0, 0.0, 0.0, np.inf
        for _ in range(TRIALS if first < 0 else 0):
            slope, curvature = self._advance(step - here)
            if abs(slope) <= SLOPE_ACCEPTED * abs(first):
                return True
            low, high = (step, high) if slope < 0 else (low, step)
            newton = step - slope / curvature if curvature > 0 else np.inf
            if not low < newton < high:
                newton = (low + high) / 2 if np.isfinite(high) else 2 * step
            here, step = step, newton
        return False

    def onto(self, f: Real) -> None:
        """Set the traction of the whole grid: what has moved out of reach carries none."""
        self.f[self.z >= self.law.reach] = 0.0
        f[...] = 0.0
        self.tiles.scatter(self.f, f)


def _dot(a: Field, b: Field) -> float:
    """Sum over the points of a product."""
    return float((a * b).sum(dtype=np.float64))
