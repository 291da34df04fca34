"""The hard wall: it only bounds the gap."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from continuum.inputs.keys import OrInfinite
from continuum.model.fourier import Real
from continuum.model.walls.wall import Wall


class HardWall(Wall, kind="hard"):
    """Non-overlap, no adhesion: gap >= 0, traction >= 0, and one of them zero at each point.

    The traction is not a function of the gap, but the constraint force of the solution.  Points are in contact if the
    gap is exactly zero.

    The hardness limits the traction.  Where it is reached, one of the bodies yields and keeps an imprint: the gap is
    then minus the depth of the new imprint, and points with a gap of zero or less are in contact.  Perfectly plastic,
    without hardening: Almqvist, Sahlin, Larsson and Glavatskih, Tribol. Int. 40, 574 (2007).

    Examples
    --------
    >>> import continuum as c
    >>> contact = c.Contact(c.sine(c.Grid.square(32), 0.5, (1, 1)), wall=c.HardWall())
    >>> round(contact.press(pressure=0.01).area_rep, 3)
    0.281
    """

    example: ClassVar[Mapping[str, Any]] = {}
    newer: ClassVar[frozenset[str]] = frozenset({"hardness"})
    has_law: ClassVar[bool] = False
    equivalent_range: ClassVar[float] = 0.0
    law: ClassVar[None] = None
    zero_gap: ClassVar[float] = 0.0
    range: ClassVar[float] = 0.0
    core: ClassVar[float] = -np.inf
    work_of_adhesion: ClassVar[float] = 0.0
    largest_tension: ClassVar[float] = 0.0
    largest_softening: ClassVar[float] = 0.0

    hardness: OrInfinite = np.inf
    """pressure at which it yields, in E*; it does not yield if not given"""

    @property
    def bound(self) -> float:
        return 0.0 if np.isinf(self.hardness) else -np.inf

    def energy(self, gap: Real) -> Real:
        """Work of an imprint, hardness times depth; zero without imprint, infinite where the wall does not yield."""
        with np.errstate(invalid="ignore"):  # infinity times zero
            return np.where(gap < 0, -self.hardness * gap, 0.0)

    def touches(self, gap: Real) -> NDArray[np.bool_]:
        """Mask of the points that the wall pushes: gap zero, or negative after yield."""
        return np.asarray(gap <= 0.0)
