"""Bounds of the pull-off force of a sphere on the rough surface.

If roughness is much finer than the contact of the sphere, the contact is that of a smooth sphere with an apparent work
of adhesion.  Full contact leaves w - U, where U is its elastic energy; no state of linear elasticity with small slopes
gains more than w.
"""

from dataclasses import dataclass

import numpy as np

from continuum.inputs import units
from continuum.inputs.arguments import instance, number
from continuum.maps.verdict.criteria import RoughContact
from continuum.theory.smooth import JKR, MaugisDugdale, tabor_parameter

WIDE_CONTACT = 0.3
"""Radius of the contact over that of the sphere above which a sphere is not a parabola: heights differ by 2 %."""


@dataclass(frozen=True)
class ProbePullOff:
    """The pull-off force of a rigid sphere, or of an elastic one with E* of both, in the units of the contact.

    The bounds are of states in equilibrium: instabilities at single summits on the way out can hold more, as on a wavy
    sphere (Guduru, J. Mech. Phys. Solids 55, 445 (2007)).
    """

    radius: float
    """R."""
    smooth: float
    """Pull-off force of a smooth sphere."""
    most: float
    """Pull-off force with the full w, and the range increased by h_rms: at most 2π w R."""
    apparent: float | None
    """Apparent work of adhesion w - U of full contact; None if U exceeds w."""
    least: float | None
    """Pull-off force with w - U; None if U exceeds w."""
    rim: float | None
    """Largest pull-off force with at most 1 % in contact, if the contact was solved and is not sticky; else None."""
    contact_radius: float
    """Radius of the contact of a smooth sphere without load."""
    maugis: float
    """Maugis' λ of the smooth sphere: JKR's above 5, DMT's below 0.1."""
    tabor: float
    """Tabor's μ of the smooth sphere, with Δr for the equilibrium distance."""
    by_curve: float | None = None
    """Pull-off force with the work that a sphere feels by the adhesion curve of the map; None if that is not known."""


def probe_pull_off(contact: RoughContact, radius: float, touched: float | None = None) -> ProbePullOff:
    """The pull-off force of a sphere on a rough surface, as an interval.

    * At least that with w - U, the apparent work of full contact (Persson and Tosatti, J. Chem. Phys. 115, 5597 (2001);
      measured on approach: Dalvi and others, PNAS 116, 25484 (2019)).
    * At most that with w, as no contact gains more energy.
    * Where the surface is not sticky, its states under tension have less than 1 % of repulsive area, and no more than
      the attracted area beside it: the energy gained is below w times the share of both, so that the force is
      below 2π R w times this share (Derjaguin, Kolloid-Z. 69, 155 (1934)).  This holds on approach, not for a sphere
      that was pressed into full contact.

    Parameters
    ----------
    contact : the rough contact, with its energy of full contact.
    radius : radius of the sphere, in the same units.
    touched : (A_rep + A_att)/A0 of the state of 1 % repulsive area, if that is known and not sticky.

    Raises ArgumentError if the radius is not positive.
    """
    instance("contact", contact, RoughContact)
    radius = number("radius", radius, above=0)
    w, modulus, reach = contact.work_of_adhesion, contact.contact_modulus, contact.range
    left = None if contact.conformal_energy is None else w - contact.conformal_energy
    apparent = left if left is not None and left > 0 else None
    sphere = MaugisDugdale(radius, w, reach, modulus)
    return ProbePullOff(
        radius=radius,
        smooth=sphere.pull_off_force,
        most=MaugisDugdale(radius, w, reach + contact.rms_height, modulus).pull_off_force,
        apparent=apparent,
        least=None if apparent is None else MaugisDugdale(radius, apparent, reach, modulus).pull_off_force,
        rim=None if touched is None else 2 * np.pi * radius * w * min(touched, 1.0),
        contact_radius=JKR(radius, w, modulus).zero_load_radius,
        maugis=sphere.parameter,
        tabor=tabor_parameter(radius, w, reach, modulus),
    )


def probe_doubts(contact: RoughContact, probe: ProbePullOff) -> list[str]:
    """Warnings where the contact of a probe is not that of a smooth sphere with an apparent work of adhesion.

    Its contact must be larger than the longest waves, λ_L or the size of the map, and much smaller than the sphere.
    """
    radius = probe.contact_radius
    doubts = []
    if contact.roll_off is not None and 2 * radius < contact.roll_off:
        waves = units.readable(contact.roll_off, "length", 3)
        doubts.append(
            f"probe: its contact, {units.readable(2 * radius, 'length', 3)} wide, is smaller than the longest waves, "
            f"{waves}: it matters where it touches, and its U is less than that of the map"
        )
    if radius > WIDE_CONTACT * probe.radius:
        doubts.append(
            f"probe: its contact is {radius / probe.radius:.2g} R in radius, where a sphere is not a parabola"
        )
    return doubts
