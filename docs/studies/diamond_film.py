"""A sphere of ruby on a diamond film: the effective work of adhesion from its measured topography.

``python -m docs.studies.diamond_film container.zip`` prints it for surfaces of the joined spectrum of the film's
measurements, under both shapes of the attraction.  By Derjaguin's approximation the pull-off force of a sphere over
2π R is the largest energy per area that two planes gain on approach: ∫ tension d(mean gap) to where the load vanishes.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import get_args

import numpy as np

import continuum as c
from continuum.model.walls.attraction import Shape, attraction_on_core
from continuum.sheet import Sheet
from continuum.topography.instruments import measurements
from continuum.topography.reading import read_topography
from continuum.topography.spectra import joined
from docs.studies.tables import keep

__all__ = ["CONTACT_MODULUS", "RANGE", "WORK", "effective_work", "film"]

WORK, RANGE = 46.3e-3, 5.6e-9
"""Between ruby and diamond, in J/m² and m: Thimons and others, Exp. Mech. 61, 1109 (2021), abstract."""
CONTACT_MODULUS = 318e9
"""In Pa: of polycrystalline diamond on alumina (continuum/sticky/materials.toml)."""
POINTS, FARTHEST, STEPS = 1024, 14.0, 28
"""Points a side; the mean gap at which the approach begins, in h_rms; mean gaps from there to one h_rms."""


def film(container: Path, seed: int, points: int = POINTS) -> tuple[np.ndarray, float]:
    """Heights in m of a surface with the spectrum of all measurements, and the distance of its points."""
    surface = joined([read_topography(container, part=name) for name in measurements(container)], seed=seed)
    every = len(surface.heights) // points
    return surface.heights[::every, ::every], surface.grid.spacing[0] * every


def effective_work(heights: np.ndarray, spacing: float, shape: Shape) -> tuple[float, float]:
    """Largest energy per area that planes gain on approach, in J/m², and the repulsive area there, over A0."""
    wall = attraction_on_core(shape, WORK / CONTACT_MODULUS / spacing, RANGE / spacing, 5.0)
    contact = c.Contact(heights / spacing, wall=wall, tolerance=1e-4)
    gaps = np.std(heights) / spacing * np.geomspace(FARTHEST, 1.0, STEPS)
    return gained(list(_approach(contact, gaps)), CONTACT_MODULUS * spacing)


def _approach(contact: c.Contact, gaps: np.ndarray) -> Iterator[tuple[float, float, float]]:
    """Mean gap, load and repulsive area of each state, to the first that is pressed."""
    state = None
    for gap in gaps:
        state = contact.press(mean_gap=float(gap), start=state).require()
        yield state.mean_gap, state.load, state.area_rep
        if state.load > 0:
            return


def gained(states: Sequence[tuple[float, float, float]], unit: float) -> tuple[float, float]:
    """∫ tension d(mean gap) from the first state to where the load vanishes, and the area there."""
    gap, load, area = np.array(states).T
    if not load[-1] > 0:
        raise ValueError("the load does not vanish on this approach")
    share = load[-2] / (load[-2] - load[-1])
    gap[-1], load[-1], area[-1] = (a[-2] + share * (a[-1] - a[-2]) for a in (gap, load, area))
    return unit * float(np.trapezoid(-load, -gap)), float(area[-1])


def rows(container: Path) -> Iterator[tuple[str, ...]]:
    """A row for each surface and shape."""
    for seed in range(3):
        heights, spacing = film(container, seed)
        for shape in get_args(Shape):
            work, area = effective_work(heights, spacing, shape)
            rms = 1e9 * np.std(heights)
            yield str(seed), f"{rms:.2f}", shape, f"{1e3 * work:.2f}", f"{work / WORK:.3f}", f"{area:.1e}"


if __name__ == "__main__":
    warnings.simplefilter(
        "ignore", UserWarning
    )  # of the slopes, 0.38, and of the grid: docs/studies/diamond_film.md says both
    heads = ("surface", "h_rms, nm", "shape", "effective work, mJ/m²", "of w", "A_rep there")
    keep("diamond_film", Sheet.of("the film", heads, rows(Path(sys.argv[1]))))
