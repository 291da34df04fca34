"""The hard wall: it only bounds the gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from continuum.model.fourier import Real
from continuum.model.walls.wall import Wall, WallTable


@dataclass(frozen=True)
class HardWall(Wall):
    """Non-overlap, no adhesion: gap >= 0, traction >= 0, and one of them zero at each point.

    It has no law: its traction is not a function of the gap but what holds the surface, as the solution says.  Contact
    is where the gap is exactly zero.
    """

    law: ClassVar[None] = None
    zero_gap: ClassVar[float] = 0.0
    range: ClassVar[float] = 0.0
    core: ClassVar[float] = -np.inf
    bound: ClassVar[float] = 0.0
    work_of_adhesion: ClassVar[float] = 0.0
    largest_tension: ClassVar[float] = 0.0
    largest_softening: ClassVar[float] = 0.0

    def energy(self, gap: Real) -> Real:
        """Zero, infinite where the surface would overlap."""
        return np.where(gap < 0, np.inf, 0.0)

    def touches(self, gap: Real) -> NDArray[np.bool_]:
        """Where the gap is exactly zero, which is where the wall pushes."""
        return np.asarray(gap <= 0.0)


class RigidWall(WallTable):
    """[wall] of law "hard": non-overlap, no adhesion."""

    law: Literal["hard"]
    has_law: ClassVar[bool] = False
    equivalent_range: ClassVar[float] = 0.0

    def build(self) -> Wall:
        return HardWall()
