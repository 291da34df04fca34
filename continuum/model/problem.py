"""The contact problem: the energy of a displaced surface under a wall.  All signs are defined here.

With h the heights, D the separation, u the displacement of the surface and φ the wall law, per area::

    gap       z = D + h - u
    energy    E = ½ <u, K u> + <φ(z)>
    gradient  dE/du = K u + p(z),           p = -dφ/dz, the traction
    Hessian   v -> K v + φ''(z) v

Functions of the displacement return arrays and keep no state.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from continuum.inputs.arguments import field_of
from continuum.model.fourier import Complex, Real
from continuum.model.grid import Grid
from continuum.model.open_boundary import OpenBoundary
from continuum.model.substrates import Substrate
from continuum.model.surface import Moments, moments
from continuum.model.walls import Wall

_OF_THE_SUBSTRATE = ("stiffness_q", "_finite_stiffness_q", "open_boundary")


@dataclass(frozen=True, eq=False)
class ContactProblem:
    """A rigid rough wall above an elastic substrate.

    Parameters
    ----------
    grid : the points of the surface.
    wall : the law between wall and surface.
    heights : of the wall, shape ``grid.shape``, in a0.
    substrate : its elastic response, with the mean mode.
    """

    grid: Grid
    wall: Wall
    heights: Real
    substrate: Substrate

    def __post_init__(self) -> None:
        heights = field_of("heights", self.heights, self.grid.shape)
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
        return float(self.stiffness_q[0, 0])

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
        power[0, 0] = 0.0
        own, slope = 2 * float(np.sqrt(power.sum())), self.moments.rms_slope
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
        u_q[0, 0] = 0.0
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
