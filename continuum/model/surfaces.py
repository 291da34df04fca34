"""Surfaces of the rigid wall, each with its table of the input: random surfaces and simple shapes.

Heights are those of the rigid wall above its mean plane, in a0, shape ``grid.shape``.
"""

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from continuum.arguments import ArgumentError, count, instance, number, pair
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import LARGEST_SLOPE, SMALLEST_SLOPE, Moments, SelfAffine
from continuum.tables import LARGEST_N, Fault, Fraction, Positive, TableFamily, both_directions, constraint

HIGHEST = 1e30
"""Larger heights, in a0, are refused: their squares would overflow."""
_ROUNDING = 1e-12  # a value written in decimal may miss its bound by this fraction


class SurfaceTable(TableFamily):
    """[surface]: heights of the rigid wall."""

    kind_key: ClassVar[str] = "kind"
    sizes: ClassVar[tuple[str, ...]] = ()
    """Keys of the amplitude, of which one is given; a slope out of range is reported for it."""

    @property
    def origin(self) -> str:
        return next((name for name in self.sizes if getattr(self, name) is not None), super().origin)

    @property
    def shortest(self) -> float | None:
        """Shortest wavelength, in a0; None if unknown."""
        return None

    @property
    def longest(self) -> float | None:
        """Longest wavelength, in a0, which the period must contain."""
        return None

    @property
    def most_waves(self) -> tuple[int, int]:
        """Largest number of waves per period along x and y, which the grid must resolve."""
        return 0, 0

    @property
    def expected_slope(self) -> float | None:
        """Expected slope h'rms of a random surface, independent of the grid."""
        return None

    @property
    def attributes(self) -> dict[str, int]:
        """Attributes that are stored with its heights."""
        return {}

    def build(self, grid: Grid) -> Real:
        """Heights, shape ``grid.shape``, in a0."""
        raise NotImplementedError

    def expected(self, grid: Grid) -> Moments | None:
        """Moments of the random ensemble; None if the surface is not random."""
        return None

    def too_short(self, n: tuple[int, int], lengths: tuple[float, float]) -> Iterator[Fault]:
        """Faults: waves that a grid of n points over these periods cannot resolve."""
        if n[1] < 2:
            return  # reported for the grid
        spacing = Grid(n, lengths).widest_step
        if self.shortest is not None and self.shortest < 2 * spacing * (1 - _ROUNDING):
            cause = "too coarse a grid: raise the number of points at the same period, or lambda_s"
            yield Fault(("surface", "lambda_s"), f"at least two spacings, {2 * spacing:g} a0", cause)
        limits = [points // 2 for points in n]
        if any(waves > limit for waves, limit in zip(self.most_waves, limits, strict=True)):
            cause = "the grid cannot show shorter waves: raise its number of points"
            yield Fault(("surface", "waves"), f"at most half the points, {limits}", cause)

    def too_long(self, n: tuple[int, int], lengths: tuple[float, float]) -> Iterator[Fault]:
        """Faults: waves longer than the periods."""
        period = lengths[1] if n[0] == 1 else min(lengths)
        if self.longest is not None and self.longest > period:
            cause = "too small a period: raise it, or lower lambda_L"
            yield Fault(("surface", "lambda_L"), f"at most the period, {period:g} a0", cause)


class SelfAffineTable(SurfaceTable):
    """A self-affine spectrum, without its slope."""

    hurst: Fraction
    """H, the Hurst exponent"""
    lambda_s: Positive
    """shortest wavelength, in a0"""
    lambda_L: Positive
    """roll-off wavelength, in a0"""

    @property
    def shortest(self) -> float:
        return self.lambda_s

    @property
    def longest(self) -> float:
        return self.lambda_L

    def spectrum(self, rms_slope: float, *, rescale: bool = True) -> SelfAffine:
        return SelfAffine(self.hurst, rms_slope, self.lambda_s, self.lambda_L, rescale)


class SelfAffineSurface(SelfAffineTable):
    """[surface] of kind "self-affine": the paper's random surface."""

    newer: ClassVar[frozenset[str]] = frozenset({"rms_height"})
    sizes: ClassVar[tuple[str, ...]] = ("rms_slope", "rms_height")

    kind: Literal["self-affine"]
    rms_slope: Annotated[float, Field(ge=SMALLEST_SLOPE, le=LARGEST_SLOPE)] | None = None
    """h'rms; instead of rms_height"""
    rms_height: Positive | None = None
    """h_rms, in a0; instead of rms_slope"""
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    """seed of the random numbers"""
    rescale: bool = True
    """whether the realisation is scaled to exactly that rms slope or height, or scatters about it"""

    @constraint
    def _ordered(self) -> Iterator[Fault]:
        if self.lambda_s >= self.lambda_L:
            yield Fault(("lambda_s",), f"below lambda_L = {self.lambda_L:g}", "the two are exchanged")

    @constraint
    def _one_size(self) -> Iterator[Fault]:
        if (self.rms_slope is None) == (self.rms_height is None):
            cause = "both are given" if self.rms_slope is not None else "neither is given"
            yield Fault(("rms_slope",), "exactly one of rms_slope and rms_height", cause)

    @property
    def expected_slope(self) -> float:
        """h'rms; if h_rms is given, that of the continuous spectrum between both wavelengths, not of a grid."""
        if self.rms_slope is not None:
            return self.rms_slope
        assert self.rms_height is not None
        low, high = 2 * np.pi / self.lambda_L, 2 * np.pi / self.lambda_s
        hurst = self.hurst
        heights = (low ** (-2 * hurst) - high ** (-2 * hurst)) / (2 * hurst)
        slopes = (high ** (2 - 2 * hurst) - low ** (2 - 2 * hurst)) / (2 - 2 * hurst)
        return float(self.rms_height * np.sqrt(slopes / heights))

    def _slope(self, grid: Grid) -> float:
        """Rms slope of the ensemble on a grid."""
        if self.rms_height is None:
            assert self.rms_slope is not None
            return self.rms_slope
        slope = self.rms_height / self.spectrum(1.0).expected_moments(grid).rms_height
        if not SMALLEST_SLOPE <= slope <= LARGEST_SLOPE:
            least, most = (bound / slope * self.rms_height for bound in (SMALLEST_SLOPE, LARGEST_SLOPE))
            allowed = f"from {least:.3g} to {most:.3g} a0, where the rms slope is {LARGEST_SLOPE:g}"
            raise ArgumentError("rms_height", self.rms_height, allowed)
        return slope

    def build(self, grid: Grid) -> Real:
        exact = self.rescale and self.rms_height is None
        spectrum = self.spectrum(self._slope(grid), rescale=exact)
        heights = spectrum.synthesise(grid, np.random.default_rng(self.seed))
        if self.rescale and self.rms_height is not None:
            heights *= self.rms_height / heights.std()
        return heights

    @property
    def attributes(self) -> dict[str, int]:
        return {"seed": self.seed}

    def expected(self, grid: Grid) -> Moments:
        return self.spectrum(self._slope(grid)).expected_moments(grid)


def sine(grid: Grid, amplitude: float, waves: tuple[int, int]) -> Real:
    """Heights amplitude (1 - cos q.x) with q = 2π (waves[0]/Lx, waves[1]/Ly): lowest at the origin.

    Parameters
    ----------
    amplitude : half the height from valley to crest, in a0.
    waves : number of waves per period along x and y, whole numbers, at most half the points; negative for the other
        diagonal.
    """
    x, y = instance("grid", grid, Grid).positions
    amplitude = number("amplitude", amplitude, least=-HIGHEST, most=HIGHEST)
    for wave, n in zip(pair("waves", waves), grid.shape, strict=True):
        count("waves", wave, -(n // 2), n // 2, why="a wave has two points at least")
    if not any(waves):
        raise ArgumentError("waves", waves, "at least one wave along x or y")
    phase = 2 * np.pi * (waves[0] * x / grid.lengths[0] + waves[1] * y / grid.lengths[1])
    return amplitude * (1 - np.cos(phase))


class SineSurface(SurfaceTable):
    """[surface] of kind "sine"."""

    sizes: ClassVar[tuple[str, ...]] = ("amplitude",)

    kind: Literal["sine"]
    amplitude: Positive
    """half the height from valley to crest, in a0"""
    waves: Annotated[
        tuple[int, int],
        both_directions(int, 0, LARGEST_N, "two whole numbers [mx, my], zero or more"),
    ]
    """waves per period along x and y"""

    @constraint
    def _some_wave(self) -> Iterator[Fault]:
        if self.waves == (0, 0):
            yield Fault(("waves",), "at least one wave along x or y")

    @property
    def most_waves(self) -> tuple[int, int]:
        return self.waves

    def build(self, grid: Grid) -> Real:
        return sine(grid, self.amplitude, self.waves)


def _parabola(squared: Real, name: str, radius: float) -> Real:
    """Heights r²/(2R); a radius so small that they overflow is refused."""
    with np.errstate(over="ignore"):
        heights: Real = squared / (2 * radius)
    if not np.isfinite(heights).all():
        raise ArgumentError(name, radius, "a larger radius: the heights of this one overflow")
    return heights


def sphere(grid: Grid, radius: float) -> Real:
    """The lower side of a paraboloid of the given radius (in a0) that touches at the centre of the period."""
    x, y = instance("grid", grid, Grid).positions
    radius = number("radius", radius, above=0)
    r2 = (x - grid.lengths[0] / 2) ** 2 + (y - grid.lengths[1] / 2) ** 2
    return _parabola(r2, "radius", radius)


class SphereSurface(SurfaceTable):
    """[surface] of kind "sphere"."""

    sizes: ClassVar[tuple[str, ...]] = ("radius",)

    kind: Literal["sphere"]
    radius: Positive
    """radius of the sphere, in a0"""

    def build(self, grid: Grid) -> Real:
        return sphere(grid, self.radius)


def cylinder(grid: Grid, radius: float, axis: int = 1) -> Real:
    """The lower side of a parabolic cylinder of the given radius (in a0), along x (axis 0) or y (1), at the centre."""
    across = 1 - count("axis", axis, 0, 1)
    distance = instance("grid", grid, Grid).positions[across] - grid.lengths[across] / 2
    radius = number("radius", radius, above=0)
    return np.broadcast_to(_parabola(distance**2, "radius", radius), grid.shape).copy()


class CylinderSurface(SurfaceTable):
    """[surface] of kind "cylinder"."""

    sizes: ClassVar[tuple[str, ...]] = ("radius",)

    kind: Literal["cylinder"]
    radius: Positive
    """radius of the cylinder, in a0"""
    along: Literal["x", "y"] = "y"
    """direction of its axis"""

    def build(self, grid: Grid) -> Real:
        return cylinder(grid, self.radius, "xy".index(self.along))


def punch(grid: Grid, flat_radius: float, edge_radius: float) -> Real:
    """A round punch at the centre of the period: flat up to a radius, then rising as a parabola (both radii in a0).

    Heights (r - b)²/(2R) for r > b, b the flat and R the edge radius: the rounded punch of Ciavarella, Hills and
    Monno, Proc. Inst. Mech. Eng. C 212, 319 (1998).
    """
    x, y = instance("grid", grid, Grid).positions
    r = np.hypot(x - grid.lengths[0] / 2, y - grid.lengths[1] / 2)
    b = number("flat_radius", flat_radius, least=0)
    if not b < r.max():
        raise ArgumentError("flat_radius", flat_radius, f"below {r.max():g}: within the period, which needs an edge")
    return _parabola(np.maximum(r - b, 0.0) ** 2, "edge_radius", number("edge_radius", edge_radius, above=0))


class PunchSurface(SurfaceTable):
    """[surface] of kind "punch": round, flat, with a rounded edge."""

    sizes: ClassVar[tuple[str, ...]] = ("edge_radius",)

    kind: Literal["punch"]
    flat_radius: Positive
    """radius of the flat face, in a0"""
    edge_radius: Positive
    """radius of curvature of the edge, in a0"""

    def build(self, grid: Grid) -> Real:
        return punch(grid, self.flat_radius, self.edge_radius)
