"""Passes over memory of the smooth solver on arrays: each a function that a library may fuse."""

from collections.abc import Sequence
from functools import cache, partial
from typing import Any, NamedTuple, Self

from continuum.model import laws
from continuum.model.laws import OnArrays
from continuum.solve.arrays.library import Array, Library, fused
from continuum.solve.arrays.modes import ModeMarks, low_part, mean, sum_of, widened, without_mean

# --- passes over spectra ---------------------------------------------------------------------------------------


class ModeStiffness(NamedTuple):
    """What a pass knows of the modes."""

    K: Array
    marks: ModeMarks
    c0: Array
    """Shift c0 of the preconditioner for all modes, and for short waves beside a coarse step."""


def _step_of(xp: Any, g: Array, waves: ModeStiffness, coarse: bool) -> tuple[Array, Array]:
    """M and M g, M = 1/(K + c0)."""
    K, c0, (row, column) = waves.K, waves.c0, waves.marks.low
    M = 1 / (K + (xp.where(row & column, c0[0], c0[1]) if coarse else c0[0]))
    return M, M * g


@fused
def finish_step(
    xp: Any,
    g: Array,
    d: Array,
    work: Array,
    waves: ModeStiffness,
    alpha: Array,
    *,
    coarse: bool,
    held: bool,
    linear: bool,
) -> tuple[Array, Array, Array]:
    """Finish the last step, of length alpha: y = alpha K d + work, alpha times that of a linear wall; g <- g + y.

    Returns g, y and the sums of :class:`continuum.solve.grids.SmoothGrid`.
    """
    K, marks, _ = waves
    alpha = xp.astype(alpha, K.dtype)
    y = alpha * (K * d + work) if linear else alpha * K * d + work
    y = without_mean(xp, y, marks) if held else y
    g = (without_mean(xp, g, marks) if held else g) + y
    M, s = _step_of(xp, g, waves, coarse)
    weights, (row, column) = marks.weights, marks.low
    high = xp.where(row & column, 0.0, weights) if coarse else weights
    pairs = (g * s, y * s, y * M * y, s * K * s, s * K * d)
    return g, y, xp.stack([sum_of(xp, weights * g * g), *(sum_of(xp, high * each) for each in pairs)])


@fused
def low_sums(
    xp: Any, spectra: Sequence[Array], weights: Array, c0: Array, found: Array, low: Array, size: Array
) -> Array:
    """Sums over the modes of the coarser grid, with its step for s, and with s = M g; the first of them is zero.

    ``spectra`` are g, y, d and K.
    """
    g, y, d, K = (low_part(xp, each, low) for each in spectra)
    low, M, sums = xp.where(low, weights[..., : low.shape[-2], :], 0.0), 1 / (K + c0[0]), []
    for s in (xp.astype(found, K.dtype) * xp.astype(-size, K.dtype), M * g):
        pairs = (g * s, y * s, y * M * y, s * K * s, s * K * d)
        sums += [0.0 * size, *(sum_of(xp, low * each) for each in pairs)]
    return xp.reshape(xp.stack(sums), (2, 6))


@fused
def choose(xp: Any, sums: Array, low: Array, size: Array, moved: Array) -> tuple[Array, Array, Array]:
    """Sums over all modes, whether the step of the coarser grid descends, and its size, zero if it does not."""
    both = sums + low[0, :]
    descends = moved & xp.all(xp.isfinite(both)) & (both[1] > 0)
    return xp.where(descends, both, sums + low[1, :]), descends, xp.where(descends, size, 0.0)


@fused
def direction(
    xp: Any,
    d: Array,
    g: Array,
    found: Array,
    low: Array,
    waves: ModeStiffness,
    beta: Array,
    size: Array,
    *,
    coarse: bool,
) -> Array:
    """Direction d <- beta d - s; s is M g but for the modes of a coarser grid that has found a step of a size."""
    K, (row, column), (_, s) = waves.K, waves.marks.low, _step_of(xp, g, waves, coarse)
    if coarse:
        there = widened(xp, xp.astype(found, K.dtype), low, (g.shape[0], g.shape[-2]))
        s = xp.where(row & column & (size > 0), there * xp.astype(-size, K.dtype), s)
    return xp.astype(beta, K.dtype) * d - s


@fused
def forth(xp: Any, x: Array, d: Array, alpha: Array) -> Array:
    """Set x <- x + alpha d."""
    return x + xp.astype(alpha, d.dtype) * d


@fused
def next_line(
    xp: Any, sums: Array, last: Array, conjugate: Array, going: Array, bound: Array, *, first: bool
) -> tuple[Array, Array]:
    """Beta, slope and curvature of the next direction; and whether it goes on, the bound being that of <g g>.

    As :func:`continuum.solve.conjugate.conjugate_line` after an exact line search.
    """
    gs, ys, ss, sd = (sums[i] for i in (1, 2, 4, 5))
    slope, curvature = last[1], last[2]
    follows = conjugate & (slope < 0) & (gs > 0)
    beta = xp.where(follows, ys / xp.where(follows, -slope, 1.0), 0.0)
    beta = xp.where(beta > 0, beta, 0.0)
    line = xp.stack([beta, -gs, ss - 2 * beta * sd + beta * beta * curvature])
    return line, going if first else going & (sums[0] > bound)


@fused
def length(xp: Any, line: Array, stiffness: Array, going: Array) -> tuple[Array, Array]:
    """Step to the minimum along a line, zero where there is none or nothing goes on; and whether it does."""
    curvature = line[2] + stiffness
    going = going & (curvature > 0)
    return xp.where(going, -line[1] / xp.where(going, curvature, 1.0), 0.0), going


# --- passes over fields ----------------------------------------------------------------------------------------


@fused
def respond_at(xp: Any, offset: Array, u: Array, p: Array, *, law: OnArrays) -> tuple[Array, ...]:
    """The gap of a displacement, traction and stiffness of the wall there; mean of the energy."""
    z = offset - u
    energy, traction, stiffness = law(xp, z, p)
    return z, traction, xp.astype(stiffness, xp.float32), mean(xp, energy)


@fused
def step_along(
    xp: Any, z: Array, d: Array, before: Array, p: Array, step: Array, *, law: OnArrays
) -> tuple[Array, ...]:
    """Step z <- z - step d; traction, its change and the stiffness there.

    Means of the change times d, of the traction before times d, of the energy and of its size.
    """
    z = z - step * d
    energy, traction, stiffness = law(xp, z, p)
    change = traction - before
    means = [mean(xp, each) for each in (change * d, before * d, energy, xp.abs(energy))]
    return z, traction, change, xp.astype(stiffness, xp.float32), xp.stack(means)


@fused
def along(xp: Any, z: Array, d: Array, before: Array, p: Array, alpha: Array, *, law: OnArrays) -> Array:
    """At z - alpha d: means of (change of traction) d and of stiffness d²."""
    _, traction, stiffness = law(xp, z - alpha * d, p)
    return xp.stack([mean(xp, (traction - before) * d), mean(xp, stiffness * d * d)])


@fused
def curvature(xp: Any, stiffness: Array, d: Array) -> Array:
    """Mean of stiffness d²."""
    return mean(xp, stiffness * d * d)


@fused
def pull(xp: Any, stiffness: Array, d: Array) -> tuple[Array, Array]:
    """Traction of a linear wall along a direction, and the mean of its product with that."""
    pull = xp.astype(stiffness, d.dtype) * d
    return pull, mean(xp, pull * d)


# --- the wall law ----------------------------------------------------------------------------------------------


@cache
def _powers(m: int, n: int) -> OnArrays:
    """The formula of two exponents, for which it is compiled."""
    return partial(laws.powers_on_arrays, m=m, n=n)


class DeviceLaw(NamedTuple):
    """A law on a device."""

    parameters: Array
    formula: OnArrays

    @classmethod
    def on(cls, library: Library, law: laws.Law) -> Self:
        """A law for the arrays of a library."""
        p, powers = law.parameters, law.kind == laws.INVERSE_POWERS
        return cls(library.put(p), _powers(int(p[2]), int(p[3])) if powers else laws.ON_ARRAYS[law.kind])
