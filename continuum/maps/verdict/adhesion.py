"""The adhesion curve of a map in the units of its interface, and bounds of the pull-off force of a sphere on it.

Twelve and more states without adhesion tell the load at each area for every work of adhesion
(:mod:`continuum.path.adhesion_curve`).  It is the curve of slow approach.  Where summits snap, a loop loses energy and
the stress on retraction is larger: the pull-off stress is then said to be a lower bound.

The bounds of a sphere need no curve.  If roughness is much finer than the contact of the sphere, the contact is that of
a smooth sphere with an apparent work of adhesion.  Full contact leaves w - U, where U is its elastic energy; no state
of linear elasticity with small slopes gains more than w.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from continuum.inputs import units
from continuum.inputs.arguments import instance, number
from continuum.maps.verdict.criteria import RoughContact
from continuum.model.fourier import Real
from continuum.model.walls import Wall
from continuum.path.adhesion_curve import AdhesionCurve, PressedSeries, Reading
from continuum.solve.solution import NotConvergedError
from continuum.theory.smooth import JKR, MaugisDugdale, tabor_parameter

LARGEST_X, FEWEST_PATCHES = 0.5, 10
"""x up to which, and patches from which on, the curve was tested (docs/studies/adhesion_curve.md)."""
LEAST_UNLOADED = 0.005
"""Area without load from which on the force on a probe was right to 15 %: on 96 % of 141 loops of the study.  With
less, where summits touch one by one, it was on 61 % of 49."""
MOST_MOVED = 0.5
"""Part of the attraction by which moving gaps may change it at the least load: beyond, summits snap and a loop loses.
With this limit, set on one half of the study, 94 % of the pull-off stresses of the other half are right to 15 %."""


class CurvePoint(NamedTuple):
    """A state of the contact on approach, in the units of the interface."""

    pressure: float
    """Mean pressure over the whole area; negative is tension."""
    area: float
    """Part of the area that touches."""
    gap: float
    """Mean gap beyond the gap of zero traction."""
    doubt: str = ""
    """Reason why the curve is less certain here, and a pull-off stress a lower bound; empty within its tested range."""


class UnderAdhesion(NamedTuple):
    """Numbers of the curve for one work of adhesion, in the units of the interface."""

    pull_off: CurvePoint
    """The largest tension on approach: the pull-off stress, or a lower bound of it."""
    unloaded: CurvePoint | None
    """The state without load; None if it is not known, or nothing touches."""
    loaded: CurvePoint | None = None
    """The state at the pressure that was asked for; None if it is not known, or without one."""
    alone: CurvePoint | None = None
    """The same without adhesion."""


@dataclass(frozen=True, eq=False)
class MapCurve:
    """Load, area and mean gap of a map on approach, for every work of adhesion."""

    curve: AdhesionCurve
    """Adhesion curve in the units of the solver."""
    stress: float
    """Pressure of the unit of load, in the units of the interface."""
    scale: float
    """Work of adhesion of the unit of work."""
    length: float
    """Unit of length."""
    own: int = 1
    """Copies of the map among the patches: its mirror images."""
    states: PressedSeries | None = field(default=None, repr=False)
    """The states of the curve."""
    wall: Wall | None = field(default=None, repr=False)
    """The law, of any work."""

    @cached_property
    def dense(self) -> AdhesionCurve:
        """The curve at many areas."""
        return self.curve.dense

    def pressures(self, work: float) -> tuple[Real, Real]:
        """Areas, as parts of the whole, and mean pressures at a work of adhesion; those without adhesion at zero."""
        return self.dense.areas, self.stress * self.dense.loads(work / self.scale)

    def gaps(self, work: float) -> Real:
        """Mean gaps at the areas of :meth:`pressures`."""
        return self.length * self.dense.gaps(work / self.scale)

    def pull_off(self, work: float) -> CurvePoint:
        """The largest tension on approach; its doubt says why the pull-off stress may be larger."""
        found = self.curve.least(work / self.scale)
        return self._point(found, self._snaps(found, work / self.scale))

    def at_pressure(self, work: float, pressure: float) -> CurvePoint | None:
        """The state at a mean pressure on approach; None beyond the states of the curve, and where the series fails."""
        found = self.curve.at_load(work / self.scale, pressure / self.stress)
        return None if found is None or self._fails(found) else self._point(found)

    def at_work(self, work: float, pressure: float | None = None) -> UnderAdhesion | None:
        """Pull-off stress, and the states without load and at a mean pressure, if one is given.

        None where the series fails at the largest tension.
        """
        if self._fails(self.curve.least(work / self.scale)):
            return None
        unloaded = self.at_pressure(work, 0.0)
        found = UnderAdhesion(self.pull_off(work), unloaded if unloaded is not None and unloaded.area > 0 else None)
        if pressure is None:
            return found
        return found._replace(loaded=self.at_pressure(work, pressure), alone=self.at_pressure(0.0, pressure))

    def pull_off_by_heights(self, work: float) -> Real:
        """The derivative of the pull-off stress by every height of the surfaces' map, on the grid of the states.

        At the least load the derivative of the curve is that at its area (envelope theorem); the part of the work that
        acts is kept.  Positive where a higher wall raises it; per length.
        """
        return -self._load_by_heights(work, self.curve.least(work / self.scale).area)

    def area_by_heights(self, work: float, pressure: float) -> Real:
        """The derivative of the contact area at a pressure by every height, on the grid of the states, per length.

        Raises
        ------
        NotConvergedError
            If the curve does not reach the pressure.
        """
        found = self.at_pressure(work, pressure)
        if found is None or found.area == 0:
            raise NotConvergedError("no derivative: the curve does not reach this pressure")
        step = 0.05
        ends = self.curve.at([found.area * (1 - step), found.area * (1 + step)]).loads(work / self.scale)
        slope = self.stress * float(ends[1] - ends[0]) / (2 * step * found.area)
        return -self._load_by_heights(work, found.area) / slope

    def _load_by_heights(self, work: float, area: float) -> Real:
        """The derivative of the mean pressure at an area by every height, between the two states beside it."""
        if self.states is None or self.wall is None or area < self.curve.areas[0]:
            raise NotConvergedError("no derivative: no state of the curve lies there")
        areas, remaining = np.log(self.curve.areas), self.curve.remaining(work / self.scale)
        i = min(max(int(np.searchsorted(areas, np.log(area))), 1), areas.size - 1)
        share = float(np.clip((np.log(area) - areas[i - 1]) / (areas[i] - areas[i - 1]), 0.0, 1.0))
        low, high = (self.states.states[k].load_by_heights(self.wall, float(remaining[k])) for k in (i - 1, i))
        return np.asarray(((1 - share) * low + share * high) * self.stress / self.length)

    def effective_work(self, work: float) -> tuple[float, CurvePoint] | None:
        """Work of adhesion that a sphere feels, and its state where it is closest; None where the curve is not known.

        The tension integrated over the gap, by which Derjaguin's approximation has the force on a sphere over 2π R.
        Not known either where less than :data:`LEAST_UNLOADED` touches without load.
        """
        tension, inside = self.curve.tension_on_sphere(work / self.scale)
        found = self.at_work(work)
        zero = None if found is None else found.unloaded
        known = inside and zero is not None and not zero.doubt and zero.area >= LEAST_UNLOADED
        return (tension * self.stress * self.length, zero) if known and zero is not None else None

    def force_on_sphere(self, work: float, radius: float, reach: float, modulus: float) -> float | None:
        """Pull-off force of a sphere: that of a smooth one with the effective work; None if that is not known.

        Parameters
        ----------
        radius : R.
        reach : range of the attraction between the rough surfaces, that of the law and the rms height.
        modulus : E*.
        """
        found = self.effective_work(work)
        return None if found is None else float(MaugisDugdale(radius, found[0], reach, modulus).pull_off_force)

    def _point(self, found: Reading, doubt: str = "") -> CurvePoint:
        return CurvePoint(
            found.load * self.stress, found.area, found.mean_gap * self.length, doubt or self._doubt(found)
        )

    def _fails(self, found: Reading) -> bool:
        """Whether the attraction does not bridge the mean gap, so that nothing touches there on approach.

        On soft solids, as PDMS on glass, the series may say such gaps.
        """
        return bool(found.mean_gap > self.curve.gaps_apart.max())

    def _doubt(self, found: Reading) -> str:
        """Reason why the curve is less certain at a state."""
        patches = found.patches / self.own
        if not found.inside:
            return "it is the last state of the curve"
        if found.area == 0 or patches < FEWEST_PATCHES:
            return f"{patches:.0f} patches touch"
        return "adhesion opens the gaps by much" if found.x > LARGEST_X else ""

    def _snaps(self, found: Reading, work: float) -> str:
        """True if summits snap at the least load, so that more is held on the way back."""
        if found.area == 0:
            return ""
        there = self.curve.at([found.area])
        moved = float((there.moved * there.remaining(work))[0])
        return "summits snap on the way" if moved > MOST_MOVED else ""


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
    apparent = left if left is not None and left > 0 else None  # where full contact costs more than w, no bound
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
