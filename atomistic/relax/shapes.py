"""The wall of an input as a function of the position, and what there is to say of it."""

from __future__ import annotations

from atomistic.config.deck import DeckConfig
from atomistic.lammps.shape import Interpolated, Round, Shape, Waves, shape_of
from continuum.model.fourier import Real
from continuum.runs.surfaces import CylinderSurface, PunchSurface, SineSurface, SphereSurface


def shape_under(config: DeckConfig, heights: Real) -> Shape | None:
    """The wall of an input, if it follows the atoms: the formula of its surface, or what its heights make of it.

    Parameters
    ----------
    config : of the deck.
    heights : of its surface at the sites, shape (nx, ny), in a0.
    """
    if config.follows == "site":
        return None
    surface, period = config.surface, (float(heights.shape[0]), float(heights.shape[1]))
    match surface:
        case SphereSurface():
            return Round(period, surface.radius)
        case CylinderSurface():
            return Round(period, surface.radius, across=(surface.along == "y", surface.along == "x"))
        case PunchSurface():
            return Round(period, surface.edge_radius, surface.flat_radius)
        case SineSurface():
            return Waves(period, surface.amplitude, ((-surface.amplitude, *surface.waves, 0.0),))
    return shape_of(heights)


def shape_notes(shape: Shape | None) -> tuple[str, ...]:
    """What a deck says of its wall between the sites."""
    if not isinstance(shape, Interpolated):
        return ()
    by_height, by_slope = shape.error
    return (
        "Between the sites the heights are a periodic spline of degree 5.  From the trigonometric interpolant it "
        f"differs by at most {by_height:.1e} a0 in height and {by_slope:.1e} in slope.",
    )
