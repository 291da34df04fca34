"""Laws with independent work of adhesion, range and core stiffness; in the paper's law two of them fix the third."""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
import scipy

from continuum.inputs.arguments import ArgumentError
from continuum.inputs.keys import Positive
from continuum.model.walls.exponential import Exponential
from continuum.model.walls.spline import LennardJonesSpline
from continuum.model.walls.tabulated import TabulatedWall
from continuum.model.walls.wall import Wall

Shape = Literal["spline", "exponential"]
CORE_PRESSURE = 10.0
"""Pressure up to which a spline's core is tabulated, in E*: beyond that of any elastic contact."""
_KNOTS = 101
_ROUNDED = 1e-3
"""Largest relative error of the work and the range of a table: 3e-4 for a range of 1000 a0 on a core of 5 E*/a0."""


class AttractionOnCore(Wall, kind="attraction-on-core"):
    """[wall] of law "attraction-on-core": independent work of adhesion, range and core stiffness."""

    example: ClassVar[Mapping[str, Any]] = {
        "shape": "spline",
        "adhesion_length": 0.005,
        "effective_range": 0.3,
        "core_stiffness": 2.0,
    }
    newer: ClassVar[frozenset[str]] = frozenset({"core_depth"})
    work_key: ClassVar[str] = "adhesion_length"

    shape: Shape
    """"spline", the attraction of the paper's law, or "exponential", of infinite range
    """
    adhesion_length: Positive
    """l_a = w/E*, in a0"""
    effective_range: Positive
    """distance over which the wall attracts, Eq. (S-5), in a0"""
    core_stiffness: Positive
    """stiffness of the core, in E*/a0; at least that of the attraction"""
    core_depth: Positive | None = None
    """depth to which the core of a spline is tabulated, in a0, below which the same line continues; if not given, the
    depth at which the pressure is 10 E*"""

    @property
    def pull(self) -> float:
        return 24 * self.adhesion_length / self.effective_range**2

    def build(self) -> Wall:
        """The law, a table or an exponential."""
        w, r = self.adhesion_length, self.effective_range
        reach = r / LennardJonesSpline(1.0).effective_range
        pull = 12 * w / reach**2  # stiffness of the paper's law, Eq. (S-6)
        stiffness = max(self.core_stiffness, pull)
        if self.shape == "spline":
            depth = CORE_PRESSURE / stiffness if self.core_depth is None else self.core_depth
            # Dense on both sides of the kink, so that the cubic through the knots follows it.
            dense = np.linspace(0.0, 1.0, _KNOTS) ** 4
            outside, inside = reach * dense, -depth * dense[:0:-1]
            attraction = -pull * outside * (1 - dense) ** 2
            wall = TabulatedWall(np.concatenate([inside, outside]), np.concatenate([-stiffness * inside, attraction]))
            # The kink is rounded over the first knots, which a core that is very stiff over a long range feels.
            if not abs(wall.effective_range / r - 1) <= _ROUNDED or not abs(wall.work_of_adhesion / w - 1) <= _ROUNDED:
                allowed = (
                    f"a core nearer to 5 E*/a0, or core_depth near to the overlap that is reached: a table of"
                    f" effective_range = {r:g} a0 and {depth:g} a0 of core has a work or range wrong by over 0.1 %"
                )
                raise ArgumentError("core_stiffness", self.core_stiffness, allowed)
            return wall

        def exponential(decay: float) -> Exponential:
            # γ + γ²/(2 ρ² K) = w
            k = decay**2 * stiffness
            return Exponential(2 * w / (1 + np.sqrt(1 + 2 * w / k)), decay, stiffness)

        # On a hard core Δr = 1.35 ρ; on the softest, which overlaps by a part of Δr, ρ is smaller.
        decay = scipy.optimize.brentq(lambda rho: exponential(r * rho).effective_range / r - 1, 0.1, 1.0, rtol=1e-13)
        return exponential(r * float(decay))


def attraction_on_core(
    shape: Shape,
    adhesion_length: float,
    effective_range: float,
    core_stiffness: float,
    core_depth: float | None = None,
) -> Wall:
    """Attraction with a given work and effective range on a linear core.

    In the paper's law repulsion and attraction are equally stiff at the minimum, which ties w to the range and E*.
    Here all three are independent, except that the core cannot be softer than the attraction at the minimum.

    Parameters
    ----------
    shape : "spline", the attraction of the paper's law, Eq. (S-6), of finite range; or "exponential", of infinite
        range.
    adhesion_length : l_a = w/E*, in a0.
    effective_range : Δr of Eq. (S-5), in a0.
    core_stiffness : traction per overlap, in E*/a0; at least the stiffness of the paper's law of this work and range.
    core_depth : depth to which the core of a spline is tabulated, in a0; the same line continues below it.  None for
        the depth at which the pressure is 10 E*.

    Examples
    --------
    >>> import continuum as c
    >>> shape = {"adhesion_length": 0.01, "effective_range": 0.5}  # w/E* and Δr, in a0
    >>> wall = c.attraction_on_core("exponential", **shape, core_stiffness=5)
    >>> round(wall.work_of_adhesion, 6)
    0.01
    """
    return AttractionOnCore(shape, adhesion_length, effective_range, core_stiffness, core_depth).build()
