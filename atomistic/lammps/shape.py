"""Walls as functions of the position of an atom instead of its lattice site.

The gap of an atom at (x, y, z) is separation + h(x, y) - z, its energy w(gap) a0², and so the force on it::

    F_z = -p a0²,      F_x = p dh/dx a0²,      F_y = p dh/dy a0²,      p = -dw/dgap,

the gradient of one energy; the force on the wall is the opposite.  Shapes are written in LAMMPS' language: spheres and
waves as formulas, any other array as a periodic bicubic spline, whose coefficients an atom looks up by the cell that
it is in.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import factorial
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
import scipy

from atomistic.lammps.language import atom_variable, filled, formatted, read_template, vector
from continuum.inputs.arguments import ArgumentError, count, flag, pair
from continuum.inputs.arguments import number as number_of
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import Surface
from continuum.model.surfaces import CylinderSurface, PunchSurface, SineSurface, SphereSurface

MOST_WAVES = 12
"""Largest number of waves in a sum: LAMMPS evaluates each cosine at every use of the variable."""
_DEGREE = 3
_POINTS_PER_SPACING = 4
"""Points per a0 in the map of a wall that has a formula."""


class WallHeight(NamedTuple):
    """Height, in a0, and slopes of the wall above points of the plane."""

    height: Real
    slope_x: Real
    slope_y: Real


@runtime_checkable
class Shape(Protocol):
    """A wall as a periodic function of the position."""

    def evaluate(self, x: Real, y: Real) -> WallHeight:
        """Height and slopes above given points, in a0."""

    def lines(self) -> list[str]:
        """Lines of LAMMPS that define ``v_height``, ``v_slope_x`` and ``v_slope_y`` by ``v_px`` and ``v_py``."""


def _set_period(shape: Round | Waves) -> None:
    """Check the period of a shape, and keep it as two floats."""
    period = tuple(number_of("period", length, above=0) for length in pair("period", shape.period))
    object.__setattr__(shape, "period", period)


@dataclass(frozen=True)
class Round:
    """Heights max(r - b, 0)²/(2 R) at the distance r from the axis: sphere, cylinder, or punch with a rounded edge.

    Parameters
    ----------
    period : (Lx, Ly), in a0.
    radius : R, in a0.
    flat_radius : b, in a0.
    across : axes that enter r: both for sphere and punch, one for a cylinder along the other.
    """

    period: tuple[float, float]
    radius: float
    flat_radius: float = 0.0
    across: tuple[bool, bool] = (True, True)

    def __post_init__(self) -> None:
        _set_period(self)
        number_of("radius", self.radius, above=0)
        number_of("flat_radius", self.flat_radius, least=0)
        if not any(flag("across", counts) for counts in pair("across", self.across)):
            raise ArgumentError("across", self.across, "at least one of x and y")

    def evaluate(self, x: Real, y: Real) -> WallHeight:
        """Height and slopes above given points, in a0."""
        dx, dy = (
            counts * (v - length / 2 - length * np.rint((v - length / 2) / length))
            for v, length, counts in zip((x, y), self.period, self.across, strict=True)
        )
        r = np.hypot(dx, dy)
        rise = np.maximum(r - self.flat_radius, 0.0)
        slope = rise / (self.radius * np.where(r > 0, r, 1.0))
        return WallHeight(rise**2 / (2 * self.radius), slope * dx, slope * dy)

    @property
    def lowest(self) -> float:
        """A bound below all heights, in a0."""
        return 0.0

    def lines(self) -> list[str]:
        """Lines of LAMMPS that define height and slopes by the position."""
        found = []
        for name, length, counts in zip("xy", self.period, self.across, strict=True):
            if counts:
                from_axis = f"v_p{name}-{formatted(length / 2)}"
                nearest = f"{from_axis}-{formatted(length)}*round(({from_axis})/{formatted(length)})"
                found.append(atom_variable(f"d{name}", nearest))
        axes = [name for name, counts in zip("xy", self.across, strict=True) if counts]
        squares = "+".join(f"v_d{name}^2" for name in axes)
        if self.flat_radius:
            flat = formatted(self.flat_radius)
            found += [
                atom_variable("from_axis", f"sqrt({squares})"),
                atom_variable("height", f"(v_from_axis>{flat})*(v_from_axis-{flat})^2/{formatted(2 * self.radius)}"),
            ]
            slope = f"v_d{{}}*(v_from_axis>{flat})*(1.0-{flat}/(v_from_axis+(v_from_axis==0.0)))"
        else:
            found.append(atom_variable("height", f"({squares})/{formatted(2 * self.radius)}"))
            slope = "v_d{}"
        slopes = {name: f"{slope.format(name)}/{formatted(self.radius)}" if name in axes else "0.0" for name in "xy"}
        return found + [atom_variable(f"slope_{name}", text) for name, text in slopes.items()]


@dataclass(frozen=True)
class Waves:
    """A sum of waves: mean + Σ A cos(2π (mx x/Lx + my y/Ly) + φ).

    Parameters
    ----------
    period : (Lx, Ly), in a0.
    mean : in a0.
    waves : (A, mx, my, φ) of each: amplitude in a0, waves per period along x and y, phase.
    """

    period: tuple[float, float]
    mean: float
    waves: tuple[tuple[float, int, int, float], ...]

    def __post_init__(self) -> None:
        _set_period(self)
        number_of("mean", self.mean)
        if not isinstance(self.waves, Sequence) or isinstance(self.waves, str | bytes) or len(self.waves) > MOST_WAVES:
            raise ArgumentError("waves", self.waves, f"a list of at most {MOST_WAVES} waves (A, mx, my, φ)")
        for wave in self.waves:
            if not isinstance(wave, Sequence) or isinstance(wave, str | bytes) or len(wave) != 4:
                raise ArgumentError("waves", wave, "(A, mx, my, φ) of each wave")
            amplitude, mx, my, phase = wave
            for value in (amplitude, phase):
                number_of("waves", value)
            for m in (mx, my):
                count("waves", m, -(2**31))

    def evaluate(self, x: Real, y: Real) -> WallHeight:
        """Height and slopes above given points, in a0."""
        height, slope_x, slope_y = np.full(np.shape(x), self.mean), np.zeros(np.shape(x)), np.zeros(np.shape(x))
        for amplitude, mx, my, phase in self.waves:
            qx, qy = 2 * np.pi * mx / self.period[0], 2 * np.pi * my / self.period[1]
            at = qx * x + qy * y + phase
            height += amplitude * np.cos(at)
            slope_x -= amplitude * qx * np.sin(at)
            slope_y -= amplitude * qy * np.sin(at)
        return WallHeight(height, slope_x, slope_y)

    @property
    def lowest(self) -> float:
        """A bound below all heights, in a0."""
        return self.mean - sum(abs(amplitude) for amplitude, *_ in self.waves)

    def lines(self) -> list[str]:
        """Lines of LAMMPS that define height and slopes by the position."""
        found, terms = [], {"height": [formatted(self.mean)], "slope_x": ["0.0"], "slope_y": ["0.0"]}
        for i, (amplitude, mx, my, phase) in enumerate(self.waves, 1):
            q = [2 * np.pi * m / length for m, length in zip((mx, my), self.period, strict=True)]
            parts = [f"({formatted(k)})*v_p{name}" for name, k in zip("xy", q, strict=True) if k]
            found.append(atom_variable(f"phase{i}", "+".join([*parts, f"({formatted(phase)})"])))
            terms["height"].append(f"({formatted(amplitude)})*cos(v_phase{i})")
            for name, k in zip("xy", q, strict=True):
                if k:
                    terms[f"slope_{name}"].append(f"({formatted(-amplitude * k)})*sin(v_phase{i})")
        return found + [atom_variable(name, "+".join(parts)) for name, parts in terms.items()]


@dataclass(frozen=True, eq=False)
class HeightSpline:
    """Any heights, interpolated by a periodic bicubic spline with continuous second derivatives.

    Parameters
    ----------
    heights : heights at the points of a grid, as the lattice sites are, shape (nx, ny), in a0.
    spacing : distances of the points along x and y, in a0.
    """

    heights: Real = field(repr=False)
    spacing: tuple[float, float] = (1.0, 1.0)

    @cached_property
    def _spline(self) -> scipy.interpolate.NdBSpline:
        coefficients, knots = np.pad(self.heights, ((0, 1), (0, 1)), mode="wrap"), []
        for axis in (0, 1):
            at = np.arange(coefficients.shape[axis], dtype=np.float64)
            along = scipy.interpolate.make_interp_spline(at, coefficients, k=_DEGREE, bc_type="periodic", axis=axis)
            knots.append(along.t)
            coefficients = np.moveaxis(along.c, 0, axis)
        return scipy.interpolate.NdBSpline((knots[0], knots[1]), coefficients, _DEGREE)

    def evaluate(self, x: Real, y: Real) -> WallHeight:
        apart = zip((x, y), self.spacing, self.heights.shape, strict=True)
        at = np.stack([np.mod(v / step, n) for v, step, n in apart], axis=-1)
        height, slope_x, slope_y = (self._spline(at, nu=nu) for nu in ((0, 0), (1, 0), (0, 1)))
        return WallHeight(height, slope_x / self.spacing[0], slope_y / self.spacing[1])

    @property
    def lowest(self) -> float:
        """A bound below all heights, in a0: a spline is a mean of its coefficients."""
        return float(self._spline.c.min())

    @property
    def cells(self) -> Real:
        """Coefficients a of the height in each cell between four points, shape (4, 4, nx, ny).

        In cell (i, j) the height at (x, y) is the sum of a[m, n, i, j] (x - x_i)^m (y - y_j)^n.
        """
        corners = np.stack(np.meshgrid(*map(np.arange, self.heights.shape), indexing="ij"), axis=-1).astype(np.float64)
        found = np.empty((4, 4, *self.heights.shape))
        for m, n in np.ndindex(4, 4):
            # Third derivatives jump at the points and are constant between them.
            at = corners + 0.5 * (np.array([m, n]) == 3)
            unit = factorial(m) * factorial(n) * self.spacing[0] ** m * self.spacing[1] ** n
            found[m, n] = self._spline(at, nu=(m, n)) / unit
        return found

    def lines(self) -> list[str]:
        (nx, ny), cells = self.heights.shape, self.cells
        vectors = [f'variable        a{m}{n} vector "{vector(cells[m, n].ravel())}"' for m, n in np.ndindex(4, 4)]
        values: dict[str, object] = {"coefficients": "\n".join(vectors), "nx": nx, "ny": ny}
        for name, step in zip("xy", self.spacing, strict=True):
            values |= {f"{sign}_{name}": f"{what}{formatted(step)}" if step != 1 else ""
                       for sign, what in (("per", "/"), ("by", "*"))}  # fmt: skip
        text = filled(read_template("shape.spline"), values)
        return [text.rstrip()]

    @cached_property
    def error(self) -> tuple[float, float]:
        """Largest difference of heights, in a0, and of slopes, from those of the trigonometric interpolant.

        Evaluated at halves and quarters between the sites.  For heights without wavelengths down to two spacings the
        trigonometric interpolant is the surface itself.
        """
        nx, ny = self.heights.shape
        unit = HeightSpline(self.heights)
        x, y = np.meshgrid(np.arange(nx, dtype=np.float64), np.arange(ny, dtype=np.float64), indexing="ij")
        m, n = (np.rint(size * np.fft.fftfreq(size)) for size in (nx, ny))
        qx, qy = (2 * np.pi * m / nx)[:, None], 2 * np.pi * n / ny
        waves_q = np.fft.fft2(self.heights) * ((2 * np.abs(m) != nx)[:, None] & (2 * np.abs(n) != ny))
        errors = []
        for a, b in np.ndindex(4, 4):
            there_q = waves_q * np.exp(0.25j * (a * qx + b * qy))
            exact = [np.fft.ifft2(k * there_q).real for k in (1.0, 1j * qx, 1j * qy)]
            errors.append(
                [np.abs(u - v).max() for u, v in zip(exact, unit.evaluate(x + a / 4, y + b / 4), strict=True)]
            )
        by_height, *by_slope = np.max(errors, axis=0) / np.array([1.0, *self.spacing])
        return float(by_height), float(max(by_slope))


def shape_of(heights: Real, period: tuple[float, float] | None = None) -> Waves | HeightSpline:
    """The wall of heights at the points of a grid, shape (nx, ny), in a0: the sum of its waves if few, else a spline.

    The points are a0 apart, as lattice sites are, unless a period is given, in a0.
    """
    nx, ny = heights.shape
    grid = Grid((nx, ny), period or (float(nx), float(ny)))
    waves_q = grid.forward(heights)
    m, n = np.broadcast_arrays(*grid.mode_numbers)
    # Each wave once, without those due to rounding.
    there = (np.abs(waves_q) > 1e-13 * np.abs(waves_q).max()) & ((n > 0) | (m > 0))
    shortest = (2 * np.abs(m) == nx) | (2 * n == ny)
    if np.count_nonzero(there) > MOST_WAVES or np.any(np.abs(waves_q[shortest]) > 1e-13 * np.abs(waves_q).max()):
        return HeightSpline(heights, grid.spacing)
    found = zip(waves_q[there], m[there], n[there], strict=True)
    waves = tuple((2 * float(abs(a)), int(i), int(j), float(np.angle(a))) for a, i, j in found)
    return Waves(grid.lengths, float(heights.mean()), waves)


_Period = tuple[float, float]
_FORMULAS: dict[type[Surface], Callable[[Any, _Period], Shape]] = {
    SphereSurface: lambda surface, period: Round(period, surface.radius),
    CylinderSurface: lambda surface, period: Round(
        period, surface.radius, across=(surface.along == "y", surface.along == "x")
    ),
    PunchSurface: lambda surface, period: Round(period, surface.edge_radius, surface.flat_radius),
    SineSurface: lambda surface, period: Waves(period, surface.amplitude, ((-surface.amplitude, *surface.waves, 0.0),)),
}
"""Kinds of surfaces with a formula, as functions of the position over a period."""


def has_formula(surface: Surface) -> bool:
    """True if a surface has a formula for LAMMPS between the sites."""
    return type(surface) in _FORMULAS


def shape_of_surface(surface: Surface, heights: Real, period: tuple[float, float]) -> Shape:
    """The wall of an input as a function of the position: the formula of its surface, or :func:`shape_of`."""
    formula = _FORMULAS.get(type(surface))
    return shape_of(heights, period) if formula is None else formula(surface, period)


def heights_of_shape(shape: Shape, grid: Grid) -> Real:
    """Heights of a wall at equidistant points over the period; its own points if it is an array."""
    if isinstance(shape, HeightSpline):
        return shape.heights
    points = (np.arange(n * _POINTS_PER_SPACING) * step / _POINTS_PER_SPACING
              for n, step in zip(grid.shape, grid.spacing, strict=True))  # fmt: skip
    return shape.evaluate(*np.meshgrid(*points, indexing="ij")).height


def map_error(shape: Shape, grid: Grid) -> tuple[float, float]:
    """Largest difference of heights, in a0, and of slopes, of the map of a formula from it, in the middles of cells."""
    step_x, step_y = (step / _POINTS_PER_SPACING for step in grid.spacing)
    spline = HeightSpline(heights_of_shape(shape, grid), (step_x, step_y))
    x, y = np.meshgrid(*(np.arange(n * _POINTS_PER_SPACING) + 0.5 for n in grid.shape), indexing="ij")
    at = x * step_x, y * step_y
    by_height, *by_slope = (
        float(np.abs(a - b).max()) for a, b in zip(spline.evaluate(*at), shape.evaluate(*at), strict=True)
    )
    return by_height, max(by_slope)


def shape_notes(shape: Shape | None, grid: Grid, plugin: bool) -> tuple[str, ...]:
    """Notes in a deck about its wall between the sites."""
    if isinstance(shape, HeightSpline):
        about, (by_height, by_slope) = "Between the sites the heights are a", shape.error
        other = "the trigonometric interpolant"
    elif shape is not None and plugin:
        about, (by_height, by_slope) = (
            f"The plugin has {_POINTS_PER_SPACING} heights in each a0, and a",
            map_error(shape, grid),
        )
        other = "the formula"
    else:
        return ()
    return (
        f"{about} periodic bicubic spline.  From {other} it differs by at most {by_height:.1e} a0 in height and "
        f"{by_slope:.1e} in slope.",
    )


def check_shape(name: str, value: Any) -> Shape:
    """Check that an argument is a wall as a function of the position."""
    if isinstance(value, type) or not isinstance(value, Shape):
        raise ArgumentError(name, value, "a shape, such as Round(period, radius) or Waves(period, mean, waves)")
    return value


def misfit(shape: Shape, heights: Real, sites: Real | None = None) -> float:
    """Largest difference of a shape from heights at sites, both in a0; 0 for rounding.

    Parameters
    ----------
    sites : positions in the plane, shape (*heights.shape, 2 or more), in a0; a square grid a0 apart if None.
    """
    if sites is None:
        sites = np.stack(np.meshgrid(*(np.arange(float(n)) for n in heights.shape), indexing="ij"), axis=-1)
    apart = float(np.abs(shape.evaluate(sites[..., 0], sites[..., 1]).height - heights).max())
    return 0.0 if apart <= 1e-9 * (1 + float(np.ptp(heights))) else apart
