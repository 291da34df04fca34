"""The table [surface] of an input, which builds the heights of the rigid wall."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from continuum.arguments import ArgumentError
from continuum.files.arrays import HDF5_SUFFIXES, read_numbers
from continuum.files.tables import InputFile, Positive, Table, constraint
from continuum.files.toml import Fault
from continuum.model.fourier import Real
from continuum.model.grid import LARGEST_N, Grid
from continuum.model.surface import LARGEST_SLOPE, SMALLEST_SLOPE, Moments, SelfAffine, cylinder, punch, sine, sphere
from continuum.runs.tables import Fraction, both_directions


class _Surface(Table):
    """What all tables of surfaces have."""

    sizes: ClassVar[tuple[str, ...]] = ()
    """Keys that say how large the heights are, of which one is given: at fault where the slope is none."""

    @property
    def origin(self) -> str:
        """The key that says how large the heights are, or the file that they are read from."""
        return next((name for name in self.sizes if getattr(self, name) is not None), super().origin)

    @property
    def shortest(self) -> float | None:
        """Shortest wavelength, in a0; None if there is none that is known."""
        return None

    def expected(self, grid: Grid) -> Moments | None:
        """Moments of the ensemble that the heights are drawn from; None if they are not drawn."""
        return None


class SelfAffineTable(_Surface):
    """A self-affine spectrum, without its slope."""

    hurst: Fraction
    """H, the Hurst exponent"""
    lambda_s: Positive
    """shortest wavelength, in a0"""
    lambda_L: Positive
    """roll-off wavelength, in a0"""

    def spectrum(self, rms_slope: float, *, rescale: bool = True) -> SelfAffine:
        """The spectrum at a slope."""
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
    """whether the realisation has exactly that rms slope or height, or scatters about it"""

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
        """h'rms; where h_rms is given, that of a spectrum of all waves between the two, not of those of a grid."""
        if self.rms_slope is not None:
            return self.rms_slope
        assert self.rms_height is not None
        low, high = 2 * np.pi / self.lambda_L, 2 * np.pi / self.lambda_s
        hurst = self.hurst
        heights = (low ** (-2 * hurst) - high ** (-2 * hurst)) / (2 * hurst)
        slopes = (high ** (2 - 2 * hurst) - low ** (2 - 2 * hurst)) / (2 - 2 * hurst)
        return float(self.rms_height * np.sqrt(slopes / heights))

    def _slope(self, grid: Grid) -> float:
        """Rms slope of the ensemble.

        Raises
        ------
        ArgumentError
            If the height that is given makes it steeper, or less steep, than any surface that is computed.
        """
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
        """Heights, shape ``grid.shape``, in a0."""
        exact = self.rescale and self.rms_height is None
        spectrum = self.spectrum(self._slope(grid), rescale=exact)
        heights = spectrum.synthesise(grid, np.random.default_rng(self.seed))
        if self.rescale and self.rms_height is not None:
            heights *= self.rms_height / heights.std()
        return heights

    @property
    def shortest(self) -> float:
        """λ_s."""
        return self.lambda_s

    def expected(self, grid: Grid) -> Moments:
        """Moments of the ensemble that the heights are drawn from."""
        return self.spectrum(self._slope(grid)).expected_moments(grid)


class SineSurface(_Surface):
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

    def build(self, grid: Grid) -> Real:
        """Heights, shape ``grid.shape``, in a0."""
        return sine(grid, self.amplitude, self.waves)


class SphereSurface(_Surface):
    """[surface] of kind "sphere"."""

    sizes: ClassVar[tuple[str, ...]] = ("radius",)

    kind: Literal["sphere"]
    radius: Positive
    """radius of the sphere, in a0"""

    def build(self, grid: Grid) -> Real:
        """Heights, shape ``grid.shape``, in a0."""
        return sphere(grid, self.radius)


class CylinderSurface(_Surface):
    """[surface] of kind "cylinder"."""

    sizes: ClassVar[tuple[str, ...]] = ("radius",)

    kind: Literal["cylinder"]
    radius: Positive
    """radius of the cylinder, in a0"""
    along: Literal["x", "y"] = "y"
    """direction of its axis"""

    def build(self, grid: Grid) -> Real:
        """Heights, shape ``grid.shape``, in a0."""
        return cylinder(grid, self.radius, "xy".index(self.along))


class PunchSurface(_Surface):
    """[surface] of kind "punch": round, flat, with a rounded edge."""

    sizes: ClassVar[tuple[str, ...]] = ("edge_radius",)

    kind: Literal["punch"]
    flat_radius: Positive
    """radius of the flat face, in a0"""
    edge_radius: Positive
    """radius of curvature of the edge, in a0"""

    def build(self, grid: Grid) -> Real:
        """Heights, shape ``grid.shape``, in a0."""
        return punch(grid, self.flat_radius, self.edge_radius)


class FileSurface(_Surface):
    """[surface] of kind "file": heights of your own."""

    kind: Literal["file"]
    path: InputFile
    """heights in a0, one number per point of the grid: .npy, .h5/.hdf5, or text with one row per x"""
    dataset: str | None = None
    """name of the dataset in an HDF5 file"""

    @constraint
    def _dataset(self) -> Iterator[Fault]:
        hdf5 = self.path.suffix.lower() in HDF5_SUFFIXES
        if hdf5 and self.dataset is None:
            yield Fault(("dataset",), "the name of a dataset, which an HDF5 file needs")
        if not hdf5 and self.dataset is not None:
            yield Fault(("dataset",), f"only with an HDF5 file ({', '.join(sorted(HDF5_SUFFIXES))})")

    def build(self, grid: Grid) -> Real:
        """Heights, shape ``grid.shape``, in a0.

        Raises
        ------
        ValueError, OSError
            If the file does not hold finite numbers of that shape.
        """
        heights = read_numbers(self.path, self.dataset, grid.shape)
        missing = np.count_nonzero(~np.isfinite(heights))
        if missing:
            msg = f"{missing} of the {heights.size} heights in {self.path} are not finite numbers"
            raise ValueError(msg)
        return heights


SurfaceTable = Annotated[
    SelfAffineSurface | SineSurface | SphereSurface | CylinderSurface | PunchSurface | FileSurface,
    Field(discriminator="kind"),
]
"""[surface]: heights of the rigid wall."""
