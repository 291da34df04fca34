"""The second law on one sphere and one cylinder, from DMT to JKR: `python -m docs.studies.one_contact`, some minutes.

One contact each, of which the range alone is changed; thresholds by one state without adhesion, and by search at the
same area.  Centres lie between points, so that the area has no jumps; the core has the same stiffness in units of the
contact.  Prints the table of docs/studies/one_contact.md.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

import continuum as c
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.path.threshold import press_without_adhesion
from continuum.path.threshold_search import WallOfWork
from continuum.sheet import Sheet
from continuum.solve.solution import NotConvergedError
from continuum.theory.smooth import tabor_parameter
from docs.studies.one_state import RESOLVED, load_kept
from docs.studies.tables import keep

CORE = 5.0


@dataclass(frozen=True)
class Body:
    """A parabola on a grid."""

    name: str
    grid: Grid
    radius: float
    inside: float
    """Radius, or half width, of the contact, in points."""
    ranges: tuple[float, ...]
    """In units of a²/R, twice the height of the profile at the edge of the contact."""

    @property
    def heights(self) -> Real:
        """Lowest at its middle."""
        middle = [length * 0.5 + shift for length, shift in zip(self.grid.lengths, (0.31, 0.17), strict=True)]
        sides = [x - m for x, m in zip(self.grid.positions, middle, strict=True)]
        if self.grid.shape[0] == 1:
            sides[0] = np.zeros((1, 1))
        found: Real = (sides[0] ** 2 + sides[1] ** 2) / (2 * self.radius)
        return found

    @property
    def area(self) -> float:
        """As a fraction of A0."""
        cells = 2 * self.inside if self.grid.shape[0] == 1 else np.pi * self.inside**2
        return cells / self.grid.size

    @property
    def jkr(self) -> float:
        """w of Johnson, Kendall and Roberts at zero load, in E* a point.

        Of the contact there the middle presses: 1/√2 of the width of a cylinder, √(2/3) of the radius of a sphere.
        """
        part, pressing = (np.pi / 32, 1 / 2) if self.grid.shape[0] == 1 else (2 / (9 * np.pi), 2 / 3)
        return float(part * (self.inside / np.sqrt(pressing)) ** 3 / self.radius**2)


RANGES = (6.0, 3.0, 1.5, 0.8, 0.5, 0.3, 0.2)
BODIES = (
    Body("cylinder", Grid((1, 512), (1.0, 512.0)), 400.0, 30.0, RANGES),
    Body("cylinder", Grid((1, 2048), (1.0, 2048.0)), 1600.0, 120.0, RANGES),
    Body("sphere", Grid.square(128), 220.0, 14.5, RANGES[1:6]),
    Body("sphere", Grid.square(256), 440.0, 29.0, RANGES[1:4]),
)


def rows(body: Body) -> Iterator[tuple[object, ...]]:
    """A row for each range that the grid resolves."""
    core = CORE * 20 / body.inside

    for part in body.ranges:
        reach = part * body.inside**2 / body.radius
        wall_of = _law(reach, core)
        contact = c.Contact(body.heights, wall_of(1e-4), c.HalfSpace("clamped"), body.grid.lengths, tolerance=1e-4)
        state = press_without_adhesion(contact.problem, body.area, contact.settings, core)
        one = state.threshold(wall_of)
        kept = load_kept(state, wall_of(one.dmt), one.dmt)
        try:
            searched = replace(contact, wall=wall_of(one.dmt)).find_threshold(wall_of, area=body.area).require()
        except NotConvergedError as error:
            sys.stderr.write(f"{body.name} {part}: {error}\n")
            continue
        w = searched.work
        if w > RESOLVED * reach**2:  # single points snap
            continue
        muller = tabor_parameter(body.radius, w, reach)
        numbers = (w / one.dmt, w / one.low, w / one.high, w / one.work, w / kept)
        found = (f"{muller:.2f}", f"{one.chi:.3f}", *(f"{x:.3f}" for x in numbers), f"{w / body.jkr:.2f}")
        sys.stderr.write(" ".join((body.name, *found)) + f" {time.process_time():.0f} s\n")
        yield (body.name, f"{body.inside:g}", *found, "jumps" if searched.jumps else "")


def _law(reach: float, core: float) -> WallOfWork:
    return lambda work: c.attraction_on_core("spline", work, reach, core)


def main() -> None:
    """Print and keep the table."""
    warnings.filterwarnings("ignore", category=UserWarning)
    heads = ("contact", "its points", "μ_T", "χ", "threshold over w_DMT", "w_low", "w_high", "the estimate",
             "w_DMT (1 + χ), load kept", "w of JKR", "")  # fmt: skip
    table = [row for body in BODIES for row in rows(body)]
    keep("one_contact", Sheet.of("one contact from DMT to JKR", heads, table))


if __name__ == "__main__":
    main()
