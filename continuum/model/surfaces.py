"""Surfaces of the rigid wall that an input knows: random surfaces and simple shapes.

Heights are those of the rigid wall above its mean plane, in a0, shape ``grid.shape``.
"""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from continuum.inputs.arguments import ArgumentError, count, instance
from continuum.inputs.keys import LARGEST_N, InInputs, Positive, Seed
from continuum.inputs.tables import Fault, constraint
from continuum.model import surface
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import Moments, SelfAffineSpectrum, Slope, Surface

HIGHEST = 1e30
"""Larger heights, in a0, are refused: their squares would overflow."""


class SelfAffineSurface(SelfAffineSpectrum, kind="self-affine"):
    """[surface] of kind "self-affine": the paper's random surface."""

    example: ClassVar[Mapping[str, Any]] = {"hurst": 0.8, "lambda_s": 4.0, "lambda_L": 8.0, "seed": 1, "rms_slope": 0.1}
    newer: ClassVar[frozenset[str]] = frozenset({"rms_height"})
    sizes: ClassVar[tuple[str, ...]] = ("rms_slope", "rms_height")

    alone: ClassVar[frozenset[str]] = frozenset({"seed"})
    seed: Seed
    """seed of the random numbers"""
    rms_slope: Slope | None = None
    """h'rms, the rms slope; instead of rms_height"""
    rms_height: Annotated[float, Field(gt=0)] | None = None  # bounds follow from those of the slope
    """h_rms, in a0; instead of rms_slope"""
    rescale: bool = True
    """whether the realisation is scaled to exactly that rms slope or height, or scatters about it"""

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
        if not surface.SMALLEST_SLOPE <= slope <= surface.LARGEST_SLOPE:
            least, most = (bound / slope * self.rms_height for bound in (surface.SMALLEST_SLOPE, surface.LARGEST_SLOPE))
            allowed = f"from {least:.3g} to {most:.3g} a0, where the rms slope is {surface.LARGEST_SLOPE:g}"
            raise ArgumentError("rms_height", self.rms_height, allowed)
        return slope

    def build(self, grid: Grid) -> Real:
        exact = self.rescale and self.rms_height is None
        spectrum = self.spectrum(self._slope(grid), rescale=exact)
        heights = spectrum.synthesise(grid, np.random.default_rng(self.seed))
        if self.rescale and self.rms_height is not None:
            heights *= self.rms_height / grid.deviation(heights)
        return heights

    @property
    def attributes(self) -> dict[str, int]:
        return {"seed": self.seed}

    def expected(self, grid: Grid) -> Moments:
        return self.spectrum(self._slope(grid)).expected_moments(grid)


_Waves = Annotated[int, Field(ge=-LARGEST_N, le=LARGEST_N)]


class SineSurface(Surface, kind="sine"):
    """[surface] of kind "sine"."""

    example: ClassVar[Mapping[str, Any]] = {"amplitude": 0.1, "waves": (1, 2)}
    sizes: ClassVar[tuple[str, ...]] = ("amplitude",)

    amplitude: Annotated[float, Field(ge=-HIGHEST, le=HIGHEST), InInputs(gt=0)]
    """half the height from valley to crest, in a0"""
    waves: tuple[_Waves, _Waves]
    """waves per period along x and y, negative for the other diagonal"""

    @constraint
    def _some_wave(self) -> Iterator[Fault]:
        if self.waves == (0, 0):
            yield Fault(("waves",), "at least one wave along x or y")

    @property
    def most_waves(self) -> tuple[int, int]:
        return self.waves

    def build(self, grid: Grid) -> Real:
        x, y = grid.positions
        for wave, n in zip(self.waves, grid.shape, strict=True):
            count("waves", wave, -(n // 2), n // 2, why="a wave has two points at least")
        phase = 2 * np.pi * (self.waves[0] * x / grid.lengths[0] + self.waves[1] * y / grid.lengths[1])
        return self.amplitude * (1 - np.cos(phase))


def sine(grid: Grid, amplitude: float, waves: tuple[int, int]) -> Real:
    """Heights amplitude (1 - cos q.x) with q = 2π (waves[0]/Lx, waves[1]/Ly): lowest at the origin.

    Parameters
    ----------
    grid : points of the surface.
    amplitude : half the height from valley to crest, in a0.
    waves : number of waves per period along x and y, whole numbers, at most half the points; negative for the other
        diagonal.

    Examples
    --------
    >>> import continuum as c
    >>> heights = c.sine(c.Grid.square(64), amplitude=2, waves=(2, 2))
    >>> round(float(heights.max()), 6), heights.shape
    (4.0, (64, 64))
    """
    return SineSurface(amplitude, waves).build(instance("grid", grid, Grid))


def _parabola(squared: Real, name: str, radius: float) -> Real:
    """Heights r²/(2R); a radius so small that they overflow is refused."""
    with np.errstate(over="ignore"):
        heights: Real = squared / (2 * radius)
    if not np.isfinite(heights).all():
        raise ArgumentError(name, radius, "a larger radius: the heights of this one overflow")
    return heights


def _from_centre(grid: Grid) -> tuple[Real, Real]:
    """Distances from the centre of the period along x, shape (nx, 1), and y, shape (1, ny)."""
    x, y = grid.positions
    return x - grid.lengths[0] / 2, y - grid.lengths[1] / 2


class SphereSurface(Surface, kind="sphere"):
    """[surface] of kind "sphere"."""

    example: ClassVar[Mapping[str, Any]] = {"radius": 50.0}
    sizes: ClassVar[tuple[str, ...]] = ("radius",)

    radius: Positive
    """radius of the sphere, in a0"""

    def build(self, grid: Grid) -> Real:
        x, y = _from_centre(grid)
        return _parabola(x**2 + y**2, "radius", self.radius)


def sphere(grid: Grid, radius: float) -> Real:
    """Heights of the lower side of a paraboloid that touches at the centre of the period.

    Parameters
    ----------
    grid : points of the surface.
    radius : radius of curvature at its lowest point, in a0.

    Examples
    --------
    >>> import continuum as c
    >>> heights = c.sphere(c.Grid.square(64), radius=100)
    >>> contact = c.Contact(heights, wall=c.HardWall())
    >>> round(contact.press(pressure=0.001).area_rep, 3)
    0.035
    """
    return SphereSurface(radius).build(instance("grid", grid, Grid))


class CylinderSurface(Surface, kind="cylinder"):
    """[surface] of kind "cylinder": the lower side of a parabolic cylinder at the centre of the period."""

    example: ClassVar[Mapping[str, Any]] = {"radius": 50.0}
    sizes: ClassVar[tuple[str, ...]] = ("radius",)

    radius: Positive
    """radius of the cylinder, in a0"""
    along: Literal["x", "y"] = "y"
    """direction of its axis"""

    def build(self, grid: Grid) -> Real:
        across = _from_centre(grid)["yx".index(self.along)]
        return np.broadcast_to(_parabola(across**2, "radius", self.radius), grid.shape_here).copy()


class PunchSurface(Surface, kind="punch"):
    """[surface] of kind "punch": round at the centre of the period, flat up to a radius, then rising as a parabola.

    Heights (r - b)²/(2R) for r > b, b the flat and R the edge radius: the rounded punch of Ciavarella, Hills and
    Monno, Proc. Inst. Mech. Eng. C 212, 319 (1998).
    """

    example: ClassVar[Mapping[str, Any]] = {"flat_radius": 2.0, "edge_radius": 20.0}
    sizes: ClassVar[tuple[str, ...]] = ("edge_radius",)

    flat_radius: Annotated[float, Field(ge=0), InInputs(gt=0)]
    """radius of the flat face, in a0"""
    edge_radius: Positive
    """radius of curvature of the edge, in a0"""

    def build(self, grid: Grid) -> Real:
        r, b = np.hypot(*_from_centre(grid)), self.flat_radius
        if not b < (farthest := grid.greatest(r)):
            raise ArgumentError("flat_radius", b, f"below {farthest:g}: within the period, which needs an edge")
        return _parabola(np.maximum(r - b, 0.0) ** 2, "edge_radius", self.edge_radius)
