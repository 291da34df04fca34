"""Rough walls: what all surfaces have, self-affine spectra, their synthesis and moments, and two rough bodies as one.

Heights are those of the rigid wall above its mean plane, in a0, shape ``grid.shape``.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from continuum.inputs.arguments import ArgumentError, field_of, instance, number, pair
from continuum.inputs.keys import Fraction, Positive, Seed
from continuum.inputs.tables import Description, Fault, constraint
from continuum.model.fourier import Real
from continuum.model.grid import Grid

SMALLEST_SLOPE, LARGEST_SLOPE = 1e-100, 10.0
"""Bounds of the rms slope: below, its square underflows; above, heights are probably in other units than a0."""
Slope = Annotated[float, Field(ge=SMALLEST_SLOPE, le=LARGEST_SLOPE)]
"""An rms slope."""
_AT_ONCE = 2**18  # modes
_ROUNDING = 1e-12  # a value written in decimal may miss its bound by this fraction
_GENERATOR = "a numpy.random.Generator, such as numpy.random.default_rng(1)"


class Moments(NamedTuple):
    """Root-mean-square height, slope and curvature of a surface."""

    rms_height: float
    """h_rms = sqrt(<h²>), in a0."""
    rms_slope: float
    """h'_rms = sqrt(<|grad h|²>)."""
    rms_curvature: float
    """h''_rms = sqrt(<(laplacian h)²>), in 1/a0: the paper's definition; some packages report half of it."""


def _moments(grid: Grid, power_q: Real) -> Moments:
    """Moments of a power |h_q|² over the half spectrum."""
    q2 = grid.wavenumber**2
    weighted = power_q * grid.mode_weights
    return Moments(*(float(np.sqrt(grid.total_q(weighted * q2**k))) for k in range(3)))


def moments(grid: Grid, heights: Real) -> Moments:
    """Spectral moments of given heights; the mean height does not count.

    Parameters
    ----------
    grid : points of the surface.
    heights : shape ``grid.shape``, in a0.

    Examples
    --------
    >>> import continuum as c
    >>> grid = c.Grid.square(64)
    >>> found = c.moments(grid, c.sine(grid, amplitude=2, waves=(2, 0)))
    >>> round(found.rms_height, 3), round(found.rms_slope, 3)  # 2/√2, and times 2π/32
    (1.414, 0.278)
    """
    heights = field_of("heights", heights, instance("grid", grid, Grid).shape_here)
    # Heights too large to square are refused below, with their name, not by a warning of NumPy.
    with np.errstate(over="ignore", invalid="ignore"):
        power_q = np.abs(grid.forward(heights)) ** 2
        grid.mean_mode(power_q)[...] = 0.0
        found = _moments(grid, power_q)
    if not all(np.isfinite(found)):
        raise ArgumentError("heights", heights, "smaller heights: the mean squares of these overflow")
    return found


class Surface(Description):
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
        if any(abs(waves) > limit for waves, limit in zip(self.most_waves, limits, strict=True)):
            cause = "the grid cannot show shorter waves: raise its number of points"
            yield Fault(("surface", "waves"), f"at most half the points, {limits}", cause)

    def too_long(self, n: tuple[int, int], lengths: tuple[float, float]) -> Iterator[Fault]:
        """Faults: waves longer than the periods."""
        period = lengths[1] if n[0] == 1 else min(lengths)
        if self.longest is not None and self.longest > period:
            cause = "too small a period: raise it, or lower lambda_L"
            yield Fault(("surface", "lambda_L"), f"at most the period, {period:g} a0", cause)


class SelfAffineSpectrum(Surface):
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

    def spectrum(self, rms_slope: float, *, rescale: bool = True) -> "SelfAffine":
        """The spectrum of a slope."""
        return SelfAffine(self.hurst, rms_slope, self.lambda_s, self.lambda_L, rescale)

    @constraint
    def _ordered(self) -> Iterator[Fault]:
        if self.lambda_s > self.lambda_L:
            yield Fault(("lambda_s",), f"at most lambda_L = {self.lambda_L:g}", "the two are exchanged")


class SelfAffine(SelfAffineSpectrum):
    """The paper's random surface: self-affine between two wavelengths (Methods).

    The amplitude of each mode is Gaussian with variance C(q), its phase uniform::

        C(q) ~ q^(-2-2H)        2π/λ_L <= q <= 2π/λ_s
             ~ const            q < 2π/λ_L
             = 0                q = 0 and q > 2π/λ_s

    On a line C(q) ~ q^(-1-2H), so that H is again the exponent by which heights differ at a distance.

    Since the amplitudes scatter, so does the rms slope of a realisation, by sqrt(Σw²/2)/Σw over independent
    modes with w = C q²; it is therefore rescaled to ``rms_slope``, unless ``rescale`` is false.

    In Python its arguments are H, the slope, both wavelengths, in a0, and whether to rescale.

    Examples
    --------
    >>> import numpy as np, continuum as c
    >>> surface = c.SelfAffine(hurst=0.8, rms_slope=0.1, lambda_s=8, lambda_L=32)
    >>> grid = c.Grid.square(64)
    >>> heights = surface.synthesise(grid, np.random.default_rng(1))
    >>> heights.shape, round(c.moments(grid, heights).rms_slope, 3)
    ((64, 64), 0.1)
    """

    rms_slope: Slope
    """target of h'rms, the rms slope"""
    rescale: bool = True
    """whether the realisation is scaled to exactly that rms slope, or scatters about it"""

    def __init__(self, hurst: float, rms_slope: float, lambda_s: float, lambda_L: float, rescale: bool = True) -> None:
        self._take(hurst=hurst, lambda_s=lambda_s, lambda_L=lambda_L, rms_slope=rms_slope, rescale=rescale)

    def power_q(self, grid: Grid) -> Real:
        """Expected ``|h_q|²`` over the half spectrum, in a0², normalised to the target slope."""
        q = instance("grid", grid, Grid).wavenumber
        grid.mean_mode(q)[...] = np.inf  # no power
        power = np.maximum(q, 2 * np.pi / self.lambda_L) ** (-(1 if grid.is_line else 2) - 2 * self.hurst)
        # One part in 1e12: a mode that lies on the cut-off belongs to the surface on every grid.
        power[q > 2 * np.pi / self.lambda_s * (1 + 1e-12)] = 0.0
        slope = _moments(grid, power).rms_slope
        if slope == 0.0:
            allowed = f"at most the longest period, {max(grid.lengths):g}: no wavevector of the grid lies below 2π/λ_s"
            raise ArgumentError("lambda_s", self.lambda_s, allowed)
        return power * (self.rms_slope / slope) ** 2

    def expected_moments(self, grid: Grid) -> Moments:
        """Moments of the ensemble: the exact sums over the modes of the grid."""
        return _moments(grid, self.power_q(grid))

    def slope_scatter(self, grid: Grid) -> float:
        """Relative standard deviation of the rms slope of a realisation that is not rescaled."""
        # An independent mode is a pair (q, -q); its share of the squared slope is w times a Gaussian squared.
        power, (m, n) = self.power_q(grid), grid.mode_numbers
        w = (power * grid.wavenumber**2)[(n > 0) | (m > 0)]
        return float(np.sqrt(np.sum(w**2) / 2) / np.sum(w))

    def synthesise(self, grid: Grid, rng: np.random.Generator) -> Real:
        """One realisation.

        The same generator state gives the same surface on every grid of the same periods that resolves λ_s.

        Parameters
        ----------
        grid : the points of the heights.
        rng : random generator for phases and amplitudes, such as ``numpy.random.default_rng(seed)``.
        """
        finest = 2 * instance("grid", grid, Grid).widest_step
        instance("rng", rng, np.random.Generator, _GENERATOR)
        if self.lambda_s < finest * (1 - 1e-12):
            allowed = f"at least {finest:g}; below two grid spacings the grid would alias the surface"
            raise ArgumentError("lambda_s", self.lambda_s, allowed)
        # 1e-9: rounding must not lose the mode whose wavelength is exactly λ_s.
        most = max(int(length / self.lambda_s + 1e-9) for length in grid.lengths)
        # Two streams, so that a smaller λ_s adds modes and leaves the others as they were.
        phases, gaussians = rng.spawn(2)
        nx, ny = grid.shape
        heights_q = np.zeros(grid.shape_q_here, dtype=np.complex128)
        for m, n in _modes(most, line=grid.is_line):
            amplitude = np.exp(2j * np.pi * phases.random(m.size)) * gaussians.standard_normal(m.size)
            # All modes are drawn, and those that this grid lacks left out: the others are the same on every grid.
            kept = (np.abs(m) <= nx // 2) & (n <= ny // 2)
            m, n, amplitude = m[kept], n[kept], amplitude[kept]
            mine, places = grid.places_q(m, n)
            heights_q[places] = amplitude[mine]
            # The half spectrum stores both signs of m on this axis, of which one was drawn.
            on_axis = n == 0
            mine, places = grid.places_q(-m[on_axis], n[on_axis])
            heights_q[places] = amplitude[on_axis][mine].conj()
        heights_q *= np.sqrt(self.power_q(grid))

        heights = grid.inverse(heights_q)
        if self.rescale:
            heights *= self.rms_slope / moments(grid, heights).rms_slope
        return heights


_Numbers = np.ndarray[tuple[int], np.dtype[np.int64]]


def _modes(largest: int, *, line: bool) -> Iterator[tuple[_Numbers, _Numbers]]:
    """Mode numbers of one half plane, by shells of max(|m|, |n|), in them by n and m: the grid does not change them.

    In blocks of shells, so that the modes of a large grid need little memory.
    """
    if line:
        yield np.zeros(largest, dtype=np.int64), np.arange(largest) + 1
        return
    first = 1
    while first <= largest:
        last = min(max(first, int((first**2 + _AT_ONCE / 2) ** 0.5)), largest)
        shells = [_shell(s) for s in range(first, last + 1)]
        m, n = (np.concatenate(numbers) for numbers in zip(*shells, strict=True))
        yield m, n
        first = last + 1


def _shell(s: int) -> tuple[_Numbers, _Numbers]:
    """Both ends of the rows n = 0 to s - 1, of the first only the one with m > 0, and the row n = s."""
    ends, row = np.tile([-s, s], s)[1:], np.arange(-s, s + 1)
    return np.concatenate([ends, row]), np.concatenate([np.repeat(np.arange(s), 2)[1:], np.full(row.size, s)])


def power_spectrum(grid: Grid, heights: Real) -> tuple[Real, Real]:
    """Isotropic power spectral density C(q), the average over rings one fundamental wide.

    Returns the mean wavenumber of each ring, in 1/a0, and C = A0 |h_q|²/(2π)², in a0⁴, so that
    h_rms² = ∫ C d²q.
    """
    heights = field_of("heights", heights, instance("grid", grid, Grid).shape)
    power = np.abs(grid.forward(heights)) ** 2 * grid.area / (2 * np.pi) ** 2
    q, weights = grid.wavenumber, np.broadcast_to(grid.mode_weights, grid.shape_q)
    ring = np.rint(q / (2 * np.pi / max(grid.lengths))).astype(np.int64).ravel()
    ring[0] = ring.max() + 1  # q = 0 is a mean, not roughness

    def ring_sum(values: Real) -> Real:
        return np.bincount(ring, weights=values.ravel()).astype(np.float64)[1:-1]

    count = ring_sum(weights.astype(np.float64))
    filled = count > 0
    return ring_sum(q * weights)[filled] / count[filled], ring_sum(power * weights)[filled] / count[filled]


def shifted(grid: Grid, heights: Real, shift: tuple[float, float]) -> Real:
    """Heights shifted by a vector, in a0, periodically: exactly by whole points, by Fourier interpolation otherwise.

    The shortest wave of an even grid has no phase and is shifted by the nearest whole number of points.
    """
    points = [length / spacing for length, spacing in zip(shift, grid.spacing, strict=True)]
    whole = [round(number) for number in points]
    rolled = np.roll(heights, whole, (0, 1))
    rest = [number - nearest for number, nearest in zip(points, whole, strict=True)]
    if not any(rest):
        return rolled
    m, n = grid.mode_numbers
    nx, ny = grid.shape
    phase = -2 * np.pi * (m * rest[0] / nx + n * rest[1] / ny)
    alone = (2 * np.abs(m) == nx) | (2 * n == ny)
    spectrum = grid.forward(rolled) * np.where(alone, 1.0, np.exp(1j * phase))
    return grid.inverse(spectrum)


_Shift = Annotated[float, Field(ge=-1e6, le=1e6)]
BEYOND = "no shift, or one of zero, where nothing is repeated"
BEYOND_WHY = "what lies beyond the map is not known: cut the map of the second body where it is to lie"
_TURNS = "a multiple of 90 degrees: any other turn breaks the period"


def turned(grid: Grid, heights: Real, angle: float) -> Real:
    """Heights turned by an angle in degrees, a multiple of 90, or of 180 where the period is no square."""
    turns = number("angle", angle) / 90
    if not turns.is_integer():
        raise ArgumentError("angle", angle, _TURNS)
    if turns % 2 and not (grid.shape[0] == grid.shape[1] and grid.lengths[0] == grid.lengths[1]):
        raise ArgumentError("angle", angle, "a multiple of 180 degrees where the period is no square")
    return np.rot90(heights, int(turns) % 4)


def against(grid: Grid, heights: Real, other: Real, shift: tuple[float, float], angle: float) -> Real:
    """Heights of the one rigid wall that is equivalent to two bodies: with small slopes only their difference counts.

    Parameters
    ----------
    heights : heights of the upper body, shape ``grid.shape``, in a0, positive away from the other.
    other : heights of the lower body, positive towards the upper one.
    shift : shift of the lower body, in a0, periodic: of zero where nothing is repeated.
    angle : angle by which it is turned before the shift, in degrees.
    """
    along_x, along_y = (number("shift", length) for length in pair("shift", shift))
    return heights - shifted(grid, turned(grid, field_of("other", other, grid.shape), angle), (along_x, along_y))


class Counterface(Description):
    """[counterface]: a second rough body, below the surface; E* is that of both."""

    newer: ClassVar[frozenset[str]] = frozenset({"shift_seed"})

    surface: Surface
    """its heights, positive towards the surface; the keys of [surface]"""
    shift: tuple[_Shift, _Shift] = (0.0, 0.0)
    """shift along x and y, periodic, in a0; none where nothing is repeated"""
    shift_seed: Seed | None = None
    """seed of a uniformly random shift over the period; instead of shift"""
    angle: float = 0.0
    """angle by which it is turned before the shift, in degrees: a multiple of 90"""

    @constraint
    def _one_shift(self) -> Iterator[Fault]:
        if self.shift_seed is not None and any(self.shift):
            yield Fault(("shift",), "nothing where shift_seed draws it", "both are given")

    @constraint
    def _quarter_turns(self) -> Iterator[Fault]:
        if self.angle % 90:
            yield Fault(("angle",), _TURNS)

    def unfit(self, n: tuple[int, int], lengths: tuple[float, float], *, repeats: bool) -> Iterator[Fault]:
        """Faults: what the grid cannot resolve, or the period cannot hold; a shift where there is no period."""
        if not repeats and (self.shift_seed is not None or any(self.shift)):
            yield Fault(("counterface", "shift" if any(self.shift) else "shift_seed"), BEYOND, BEYOND_WHY)
        if self.angle % 180 and (n[0] != n[1] or lengths[0] != lengths[1]):
            yield Fault(("counterface", "angle"), "a multiple of 180 degrees where the period is no square")
        for found in (self.surface.too_short(n, lengths), self.surface.too_long(n, lengths)):
            yield from (replace(fault, key=("counterface", *fault.key)) for fault in found)

    def moved_by(self, grid: Grid) -> tuple[float, float]:
        """The shift, in a0."""
        if self.shift_seed is None:
            return self.shift
        along_x, along_y = np.random.default_rng(self.shift_seed).random(2) * grid.lengths
        return float(along_x), float(along_y)

    def under(self, grid: Grid, heights: Real, own: Real) -> Real:
        """Heights of the wall that is equivalent to a surface and this counterface."""
        return against(grid, heights, own, self.moved_by(grid), self.angle)

    def expected(self, grid: Grid, surface: Moments | None) -> Moments | None:
        """Moments of the sum of both independent random surfaces, whose squares add up."""
        own = self.surface.expected(grid)
        return Moments(*np.hypot(surface, own).tolist()) if surface is not None and own is not None else None
