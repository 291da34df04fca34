"""The rough wall as a calculator of ASE, above a slab of any face and any crystal."""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from ase import Atoms
from ase.calculators.calculator import Calculator, all_changes
from numpy.typing import ArrayLike, NDArray

from atomistic.lammps.shape import Shape, shape_of
from continuum.arguments import ArgumentError, array, choice, instance, number, pair
from continuum.arguments import field as map_of
from continuum.front.contact import Contact
from continuum.measure.contact import contact_map
from continuum.model.fourier import Real
from continuum.model.walls import Wall

_PROPERTIES = ("energy", "free_energy", "forces", "gap", "contact")
_ALIKE = 1e-6
"""Relative difference of two periods that are the same, as they were typed with a few digits."""
_MARGIN = 8
"""Points by which a map that is not repeated surpasses the surface: its spline is periodic, and the jump from its end
to its beginning decays by 2 - √3 from point to point, to 3e-5."""


class WallAction(NamedTuple):
    """What the wall does to the surface atoms, in the units of ASE."""

    energy: Real
    """Shape (surface atoms,), in eV."""
    forces: Real
    """Shape (surface atoms, 3), in eV/Å."""
    gap: Real
    """Shape (surface atoms,), in a0."""
    stiffness: Real
    """Derivatives of minus the forces, shape (surface atoms, 3, 3), in eV/Å², without the curvature of the heights."""


class RoughWall(Calculator):
    """A rigid rough wall above the surface of a slab: energy and forces, gap and contact of each surface atom.

    Add it to the calculator of the atoms by ``ase.calculators.mixing.SumCalculator``.  The wall presses down along -z
    on the surface atoms.  An atom has the energy w(gap) A at gap = separation + h(x, y) - z, where A is the area of the
    cell over the number of surface atoms, and the force on it is the gradient of that.  The wall does not change: make
    another one, and another sum, for another separation.

    After a calculation ``results`` has, beside ``energy``, ``free_energy`` and ``forces``: ``gap``, in a0, and
    ``contact``, 2 where the wall repels, 1 where it attracts, and 0 out of range, of each atom; atoms that are not of
    the surface have no gap (NaN), and 0.

    Parameters
    ----------
    contact : a :class:`continuum.Contact`, with its heights and its law; or heights, an array of shape (nx, ny), in a0;
        or a shape that has a formula, as ``Round(period, radius)`` or ``Waves(period, mean, waves)``.
    slab : the atoms at rest, periodic along their first two cell vectors, which lie in the plane.  Their positions are
        the lattice sites, and the mean height of the surface atoms is z = 0 of the separation.
    separation : height of the wall's zero above the surface at rest, in a0.
    law : law of the wall, for heights that come without one.
    pixel : distance of the points of an array along x and y, in a0, one number or two; without it the array covers the
        cell, its rows along the first cell vector and its columns along the second.
    a0 : length of the contact in Å.  Of a contact with one point for each atom it is the distance of neighbours.
    contact_modulus : E* in eV/Å³, ``135 * ase.units.GPa``.  With neither, heights are in Å and tractions in eV/Å³.
    follows : whether the height is taken above the positions of atoms, so that the wall pushes sideways, too, or above
        their lattice sites, as on a grid.
    surface : indices of the surface atoms; those that ASE's builders tag with 1 if None.
    offset : (x, y) by which the wall is shifted, in a0.

    Raises ArgumentError if an argument is not allowed, or the map neither repeats with the cell nor covers the surface.

    Examples
    --------
    >>> from ase.build import fcc111
    >>> from ase.calculators.emt import EMT
    >>> from ase.calculators.mixing import SumCalculator
    >>> import atomistic as a, continuum as c
    >>> atoms = fcc111("Cu", (6, 6, 4), vacuum=10, periodic=True)
    >>> law = c.LennardJonesSpline(adhesion_length=0.005)
    >>> tip = a.Round((40, 40), radius=20)  # whose axis is at (20, 20), here above the middle of the cell
    >>> wall = a.RoughWall(tip, atoms, 0.95, law, a0=2.55, contact_modulus=0.85, offset=(-15.5, -17.4))
    >>> atoms.calc = SumCalculator([EMT(), wall])
    >>> round(-wall.get_forces(atoms)[:, 2].sum(), 2)
    -1.56
    """

    implemented_properties = list(_PROPERTIES)  # noqa: RUF012 - as ASE declares it

    def __init__(
        self,
        contact: Contact | ArrayLike | Shape,
        slab: Atoms,
        separation: float,
        law: Wall | None = None,
        *,
        pixel: float | tuple[float, float] | None = None,
        a0: float = 1.0,
        contact_modulus: float = 1.0,
        follows: Literal["atoms", "sites"] = "atoms",
        surface: Sequence[int] | NDArray[np.int64] | None = None,
        offset: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self.slab = instance("slab", slab, Atoms, "the atoms at rest, an ase.Atoms").copy()
        self.separation = number("separation", separation)
        self.a0, self.modulus = number("a0", a0, above=0), number("contact_modulus", contact_modulus, above=0)
        self.follows = choice("follows", follows, ("atoms", "sites"))
        self.offset = np.array([number("offset", shift) for shift in pair("offset", offset)])
        self._cell = np.array(slab.cell)[:2, :2]
        if not slab.pbc[:2].all() or np.any(slab.cell[:2, 2]) or not abs(np.linalg.det(self._cell)) > 0:
            allowed = "a slab that is periodic along its first two cell vectors, which lie in the plane of x and y"
            raise ArgumentError("slab", slab, allowed)
        given = np.flatnonzero(slab.get_tags() == 1) if surface is None else array("surface", surface, kinds="iu")
        if given.ndim != 1 or not given.size or given.min() < 0 or given.max() >= len(slab):
            known = "" if surface is not None else ": no atom is tagged with 1"
            raise ArgumentError(
                "surface", surface, f"indices of the surface atoms of the slab, 0 to {len(slab) - 1}{known}"
            )
        self.surface = np.unique(given)
        at = slab.positions[self.surface]
        self._sites, self._level = at[:, :2], float(at[:, 2].mean())
        self._area = abs(float(np.linalg.det(self._cell))) / len(self.surface)
        heights: Any = contact
        if isinstance(contact, Contact):
            if law is not None or pixel is not None:
                raise ArgumentError(
                    "law" if pixel is None else "pixel", law or pixel, "left out: a contact has its own"
                )
            heights, law, pixel = contact.problem.heights, contact.wall, contact.grid.spacing
        self.law = instance(
            "law", law, Wall, "the law of the wall, as LennardJonesSpline(adhesion_length=0.005)"
        ).build()
        if self.law.law is None:
            raise ArgumentError("law", law, "a law whose traction is a function of the gap, as LennardJonesSpline(0)")
        self._shape, points, periods = self._map(heights, pixel)
        # A formula holds everywhere.
        margin = 0 if self._shape is heights else _MARGIN
        self._to_points = np.linalg.inv(self._fitted(periods, points, margin)) * points
        """From positions in the plane, in Å, as rows, to points of the map."""

    def _map(self, heights: Any, pixel: Any) -> tuple[Shape, Real, Real]:
        """Shape of the wall, its points along either period, and these periods as rows, in Å."""
        if callable(getattr(heights, "evaluate", None)):
            points = np.array(pair("period", getattr(heights, "period", None)), dtype=np.float64)
            return heights, points, np.diag(points) * self.a0
        heights = map_of("contact", heights)
        if min(heights.shape) < 3:
            raise ArgumentError("contact", heights, "heights of at least three points along either side")
        points = np.array(heights.shape, dtype=np.float64)
        if pixel is None:
            return shape_of(heights), points, self._cell
        spacing = [
            number("pixel", size, above=0) for size in (pair("pixel", pixel) if np.ndim(pixel) else (pixel,) * 2)
        ]
        return shape_of(heights), points, np.diag(points * spacing) * self.a0

    def _fitted(self, periods: Real, points: Real, margin: int) -> Real:
        """The periods of the map, those of the cell to the last digit; or as they are, of a map that covers it."""
        repeats = self._cell @ np.linalg.inv(periods)
        whole = np.rint(repeats)
        if np.abs(repeats - whole).max() <= _ALIKE and abs(np.linalg.det(whole)) > 0.5:
            return np.asarray(np.linalg.solve(whole, self._cell))
        at = (self._sites - self.offset * self.a0) @ np.linalg.inv(periods) * points
        if (at < margin).any() or (at > points - 1 - margin).any():
            size = " x ".join(f"{length / self.a0:.6g}" for length in np.linalg.norm(periods, axis=1))
            cell = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in self._cell / self.a0)
            allowed = (
                f"a map that repeats with the cell, {cell} a0, or covers the surface with {margin} points to spare: "
                f"leave out pixel, so that an array covers the cell, or shift a wide one by offset"
            )
            raise ArgumentError("contact", f"a map of {size} a0", allowed)
        return periods

    def act(self, at: Real) -> WallAction:
        """Energy and forces on the surface atoms.

        Parameters
        ----------
        at : their positions, shape (surface atoms, 3), in Å.
        """
        where = self._sites
        if self.follows == "atoms":
            # Of all images of an atom that which is near its site: a map need not repeat with the cell.
            moved = at[:, :2] - self._sites
            where = self._sites + moved - np.rint(moved @ np.linalg.inv(self._cell)) @ self._cell
        height, *slopes = self._shape.evaluate(*((where - self.offset * self.a0) @ self._to_points).T)
        gap = self.separation + height - (at[:, 2] - self._level) / self.a0
        law, force = self.law.evaluate(gap), self.modulus * self._area
        steepest = np.zeros((len(at), 3))
        if self.follows == "atoms":
            steepest[:, :2] = np.stack(slopes, axis=-1) @ self._to_points.T * self.a0
        steepest[:, 2] = -1.0
        forces = force * law.traction[:, None] * steepest
        stiffness = force / self.a0 * law.stiffness[:, None, None] * steepest[:, :, None] * steepest[:, None, :]
        return WallAction(force * self.a0 * law.energy, forces, gap, stiffness)

    def calculate(
        self,
        atoms: Atoms | None = None,
        properties: Sequence[str] = ("energy",),
        system_changes: Sequence[str] = all_changes,
    ) -> None:
        """Calculate all properties; ASE calls this.

        Raises ArgumentError if the atoms are not those of the slab.
        """
        super().calculate(atoms, properties, system_changes)  # type: ignore[no-untyped-call]
        if self.atoms is None or len(self.atoms) != len(self.slab):
            raise ArgumentError("atoms", self.atoms, f"the {len(self.slab)} atoms of the slab that the wall is above")
        acting = self.act(self.atoms.positions[self.surface])
        energy, forces = float(acting.energy.sum()), np.zeros((len(self.slab), 3))
        gap, contact = np.full(len(self.slab), np.nan), np.zeros(len(self.slab), dtype=np.uint8)
        forces[self.surface], gap[self.surface] = acting.forces, acting.gap
        contact[self.surface] = contact_map(self.law, acting.gap)
        self.results = {"energy": energy, "free_energy": energy, "forces": forces, "gap": gap, "contact": contact}
