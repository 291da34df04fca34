"""The contact problem: the energy of a displaced surface under a wall.  All signs are defined here.

With h the heights, D the separation, u the displacement of the surface and φ the wall law, per area::

    gap       z = D + h - u
    energy    E = ½ <u, K u> + <φ(z)>
    gradient  dE/du = K u + p(z),           p = -dφ/dz, the traction
    Hessian   v -> K v + φ''(z) v

Functions of the displacement return arrays and keep no state.

:func:`doubts` tells whether the grid resolves the surface, and the wall law at the rim of a contact.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from continuum.inputs.arguments import ArgumentError, field_of
from continuum.model.fourier import Complex, Real
from continuum.model.grid import Grid
from continuum.model.substrates import Substrate
from continuum.model.substrates.non_periodic import OpenBoundary
from continuum.model.surface import LARGEST_SLOPE, Moments, moments
from continuum.model.walls import Wall
from continuum.theory.paper import snap_in_wavelength

_OF_THE_SUBSTRATE = ("stiffness_q", "_finite_stiffness_q", "open_boundary")


@dataclass(frozen=True, eq=False)
class ContactProblem:
    """A rigid rough wall above an elastic substrate.

    Parameters
    ----------
    grid : the points of the surface.
    wall : the law between wall and surface.
    heights : of the wall, shape ``grid.shape_here``, in a0.
    substrate : its elastic response, with the mean mode.
    """

    grid: Grid
    wall: Wall
    heights: Real
    substrate: Substrate

    def __post_init__(self) -> None:
        heights = field_of("heights", self.heights, self.grid.shape_here)
        if heights.flags.writeable or heights.base is not None:
            # Copied, as the caller could change them.
            heights = heights.copy()
        heights.flags.writeable = False
        object.__setattr__(self, "heights", heights)

    @cached_property
    def stiffness_q(self) -> Real:
        """K_q over the half spectrum, in E*/a0; infinite at q = 0 where the mean is clamped."""
        return self.substrate.stiffness(self.grid)

    @property
    def mean_stiffness(self) -> float:
        """K at q = 0."""
        return self.grid.first(self.stiffness_q)

    @cached_property
    def open_boundary(self) -> OpenBoundary | None:
        """The response without periodic images; None for a periodic surface."""
        made = getattr(self.substrate, "open_boundary", None)
        return None if made is None else made(self.grid)

    @cached_property
    def period(self) -> tuple[Grid, Real]:
        """Grid and heights of a period; without periodic images, with mirror images."""
        if self.open_boundary is None:
            return self.grid, self.heights
        mirrored = np.concatenate([self.heights, self.heights[::-1]])
        return self.open_boundary.grid, np.concatenate([mirrored, mirrored[:, ::-1]], axis=1)

    @cached_property
    def moments(self) -> Moments:
        """Spectral moments of the heights."""
        return moments(*self.period)

    @cached_property
    def traction_scale(self) -> float:
        """Traction to which tolerances are relative, in E*: h'rms E*, unless the substrate is softer than E* = 1.

        Twice the root-mean-square traction that flattens the surface is h'rms E* of a half-space.  On a substrate that
        is softer at the waves of the heights, tolerances are relative to its own tractions.
        """
        if self.open_boundary is not None:
            return self.moments.rms_slope
        flat = self.grid.forward(self.heights) * self._finite_stiffness_q
        power = (flat.real**2 + flat.imag**2) * self.grid.mode_weights
        self.grid.mean_mode(power)[...] = 0.0
        own, slope = 2 * float(np.sqrt(self.grid.total_q(power))), self.moments.rms_slope
        return own if own < (1 - 1e-9) * slope else slope  # on a half-space they differ by rounding

    @property
    def mean_height(self) -> float:
        """Mean height of the wall; zero for a synthesised surface."""
        return self.grid.mean(self.heights)

    def dented(self, imprint: Real | None) -> Self:
        """The problem after plastic yield: heights raised by the depth of the imprint, shape ``grid.shape``, in a0."""
        if imprint is None:
            return self
        found = replace(self, heights=self.heights + imprint)
        # The cached response is the same.
        vars(found).update({name: vars(self)[name] for name in _OF_THE_SUBSTRATE if name in vars(self)})
        return found

    def gap(self, displacement: Real, separation: float) -> Real:
        """Height of the wall above the displaced surface, in a0."""
        return separation + self.heights - displacement

    def separation(self, mean_gap: float, load: float, traction: Callable[[], Real]) -> float:
        """Separation of an equilibrium, in a0; NaN if the mean displacement is free.

        Its mean gap is in a0, its load per area in E*; the function returns its traction at each point, in E*, and is
        called if the mean pressure is not enough.
        """
        if self.open_boundary is not None:
            return mean_gap - self.mean_height + self.open_boundary.mean_displacement(traction())
        k = self.mean_stiffness
        return mean_gap - self.mean_height - (load / k if k > 0 else np.nan)

    def displacement(self, gap: Real, separation: float) -> Real:
        """Displacement at a given gap, in a0."""
        return separation + self.heights - gap

    def elastic_traction_q(self, displacement_q: Complex) -> Complex:
        """K u, minus the traction that holds the displacement.

        A clamped mean carries any traction; that component is set to zero.
        """
        return self._finite_stiffness_q * displacement_q

    @cached_property
    def _finite_stiffness_q(self) -> Real:
        return np.where(np.isfinite(self.stiffness_q), self.stiffness_q, 0.0)

    def elastic_energy(self, gap: Real) -> float:
        """Elastic energy ½ <u, K u> per area at a given gap, without the mean displacement, in E* a0."""
        u_q = self.grid.forward(self.heights - gap)
        self.grid.mean_mode(u_q)[...] = 0.0
        return 0.5 * self.grid.inner_q(u_q, self._finite_stiffness_q * u_q)

    def energy(self, displacement: Real, separation: float) -> float:
        """Total energy, elastic and of the wall, in E* a0³; infinite if a clamped mean is displaced."""
        u_q = self.grid.forward(displacement)
        if np.isinf(self.mean_stiffness) and abs(u_q[0, 0]) > 1e-12 * np.abs(displacement).max():
            return float("inf")
        elastic = 0.5 * self.grid.inner_q(u_q, self.elastic_traction_q(u_q)) * self.grid.area
        return elastic + self.grid.integrate(self.wall.energy(self.gap(displacement, separation)))

    def gradient(self, displacement: Real, separation: float) -> Real:
        """Derivative of the energy by the displacement, per area, in E*; without its mean if that is clamped."""
        traction = self.wall.evaluate(self.gap(displacement, separation)).traction
        gradient_q = self.elastic_traction_q(self.grid.forward(displacement)) + self.grid.forward(traction)
        if np.isinf(self.mean_stiffness):
            gradient_q[0, 0] = 0.0
        return self.grid.inverse(gradient_q)


POINTS = 4
"""Points of the grid needed per wavelength."""
SMALL_SLOPE = 0.3
"""Largest rms slope that small-slope theory covers: there tan and sin of a typical slope differ by 4 %."""
OTHER_UNIT = 10.0
"""Factor by which a stiffness may differ from that of a half-space of E* = 1 in the median over all waves."""
LARGEST_SHARE = 0.05
"""Largest part of the mean square slope that may lie in shorter waves; surfaces with edges have about as much."""


def check_slope(rms_slope: float) -> None:
    """Check that the slope is not zero, as tolerances refer to it, and not too large for linear elasticity."""
    if not 0 < rms_slope <= LARGEST_SLOPE * (1 + 1e-9):
        what = f"a slope greater than 0 and at most {LARGEST_SLOPE:g}: heights are in a0, as the spacing is"
        raise ArgumentError("rms slope of the heights", float(rms_slope), what)


def steep(rms_slope: float) -> Iterator[str]:
    """Warning about slopes that are not small, with a remedy."""
    if rms_slope > SMALL_SLOPE * (1 + 1e-9):  # a surface scaled to the bound may exceed it by rounding
        yield (
            f"the rms slope, {rms_slope:.3g}, is above {SMALL_SLOPE:g}: the theory of small slopes does not cover "
            "it, and areas and loads are those of that theory only; lower rms_slope, or check the units of the heights"
        )


def short_waves(problem: ContactProblem) -> float:
    """Part of the mean square slope in waves of fewer than ``POINTS`` points."""
    grid, heights = problem.period
    spectrum = grid.forward(heights)
    power: Real = (spectrum.real**2 + spectrum.imag**2) * grid.mode_weights * grid.wavenumber**2
    limit = 2 * np.pi / (POINTS * grid.widest_step)
    total = grid.total_q(power)
    return grid.total_q(np.where(grid.wavenumber > limit * (1 + 1e-9), power, 0.0)) / total if total else 0.0


def other_unit(problem: ContactProblem) -> Iterator[str]:
    """Warning about a stiffness that seems to be in another unit than E*/a0, with a remedy.

    Most waves of a grid are short, and for short waves the substrate is a half-space: the median of 2 K/q over some
    ten thousand waves is about E*.
    """
    every = max(1, round((problem.grid.size / 2e4) ** 0.5))
    of_waves = problem.grid.wavenumber, problem.stiffness_q
    q, stiffness_q = (values[::every, ..., ::every].ravel()[1:] for values in of_waves)
    modulus = float(np.median(2 * stiffness_q / q)) if q.size else 1.0
    if not 1 / OTHER_UNIT <= modulus <= OTHER_UNIT:
        yield (
            f"most waves are {modulus:.3g} times as stiff as those of a half-space of E* = 1, the unit of pressure: "
            "areas, tolerances and kappa refer to that unit; divide the stiffness, and the tractions of the wall, by "
            "the contact modulus"
        )


@dataclass(frozen=True)
class Wording:
    """Words of a warning about a grid: for an input, or for the pixels of a map."""

    length: Callable[[float], str] = "{:.3g} a0".format
    """A length in units of the problem, as text."""
    grid: str = "grid"
    finer: str = "raise grid.n at the same period"
    """What gives a finer grid."""
    smoother: str = "smooth the heights"


def unresolved(
    problem: ContactProblem, rms_slope: float, shortest: float | None = None, words: Wording = Wording()
) -> Iterator[str]:
    """Warnings about lengths that the grid does not resolve, each with a remedy.

    Three lengths are compared with the spacing Δ.  None is an error: the paper's model has one point for each atom,
    and its law acts on single atoms.  But results are then not those of the continuum, and a finer grid gives others.

    * The surface: its shortest wavelength against 4 Δ.  Its curvature, and with it the size of contacts, comes from
      the shortest waves; with fewer points a crest falls between points or on one.
    * The range of the attraction against h'rms Δ, by which the gap grows from one point to the next at the rim of a
      contact: a shorter range acts on less than one point beside the contact, and the attracted area is a count
      of rims.
    * The softening s of the law against the stiffness of the surface, E* q/2: waves longer than π E*/s snap together.
      Where that is shorter than 4 Δ, single points snap in and out one after another (beyond 2 Δ even a wave of
      alternating points): the rim of a contact is pinned to the grid, and hysteresis comes from the grid.

    Where the shortest wavelength of the surface, in a0, is not known, the spectrum of the heights is used.
    """
    wall, spacing = problem.wall, problem.grid.widest_step
    needed = POINTS * spacing
    if shortest is not None and shortest < needed * (1 - 1e-9):
        yield (
            f"the shortest wavelength, {shortest:g} a0, has fewer than {POINTS} points of spacing {spacing:g} a0: "
            "contact areas depend on the grid; raise grid.n at the same period, or lambda_s"
        )
    elif shortest is None and (share := short_waves(problem)) > LARGEST_SHARE:
        yield (
            f"{share:.0%} of the mean square slope lies in waves of fewer than {POINTS} points: contact areas depend "
            f"on the {words.grid}; {words.finer}, or {words.smoother}"
        )
    if wall.work_of_adhesion <= 0:
        return
    change = rms_slope * spacing
    if wall.range < change:
        yield (
            f"the wall attracts over {words.length(wall.range)}, less than the gap changes between neighbouring points "
            f"at the rim of a contact (h'rms times the spacing, {words.length(change)}): attracted areas depend on the "
            f"{words.grid}; {words.finer}"
        )
    snapping = snap_in_wavelength(wall.largest_softening)
    if snapping < needed * (1 - 1e-9):
        yield (
            f"the wall softens so much that waves longer than {words.length(snapping)}, fewer than {POINTS} points, "
            f"snap in: single points of the {words.grid} jump, and hysteresis depends on the {words.grid}; "
            f"{words.finer}, or take a longer range"
        )


def doubts(problem: ContactProblem, rms_slope: float, shortest: float | None = None) -> tuple[str, ...]:
    """All warnings about a problem: :func:`steep`, :func:`other_unit`, :func:`unresolved`."""
    return (*steep(rms_slope), *other_unit(problem), *unresolved(problem, rms_slope, shortest))
