"""The rough wall as a calculator of ASE, above a slab of any face and any crystal.

It acts on all atoms that move, wherever they are: those that come up later are under it, too.
"""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from ase import Atoms
from ase.calculators.calculator import Calculator, all_changes
from ase.constraints import FixAtoms
from numpy.typing import ArrayLike, NDArray

from atomistic.crystal.crystal import exposed, layer_depth
from atomistic.crystal.faces import spacing_of
from atomistic.lammps.law import law_of_atoms
from atomistic.lammps.shape import Shape, shape_of
from continuum.front.contact import Contact
from continuum.inputs import possible
from continuum.inputs.arguments import ArgumentError, array, choice, field_of, instance, number, pair
from continuum.measure.contact import contact_map
from continuum.model.fourier import Real
from continuum.model.walls import Wall

_PROPERTIES = ("energy", "free_energy", "forces", "gap", "contact")
_ALIKE = 1e-6
"""Relative difference of two periods that are the same, as they were typed with a few digits."""
_STRAYED = 0.1
"""Distance of an atom that is held from where it was held, in spacings, at which the slab has been moved."""
_MARGIN = 8
"""Points by which a map that is not repeated surpasses the surface: its spline is periodic, and the jump from its end
to its beginning decays by 2 - √3 from point to point, to 3e-5."""


class WallAction(NamedTuple):
    """Energy and forces of the wall on some atoms, in the units of ASE."""

    energy: Real
    """Shape (atoms,), in eV."""
    forces: Real
    """Shape (atoms, 3), in eV/Å."""
    gap: Real
    """Shape (atoms,), in a0."""
    stiffness: Real
    """Derivatives of minus the forces, shape (atoms, 3, 3), in eV/Å², without the curvature of the heights."""


class RoughWall(Calculator):
    """A rigid rough wall above the surface of a slab: energy and forces, gap and contact of each atom.

    Add it to the calculator of the atoms by ``ase.calculators.mixing.SumCalculator``.  The wall presses down along -z
    on all atoms but those that a ``FixAtoms`` of the slab holds.  An atom has the energy w(gap) A at gap = separation +
    h(x, y) - z, where A is the area of the cell over the number of surface atoms, and feels its negative gradient as a
    force; a law that reaches the layers below is divided among them
    (:func:`atomistic.lammps.law.law_of_atoms`).  The wall does not change: make another one, and another sum, for
    another separation.

    After a calculation ``results`` has, beside ``energy``, ``free_energy`` and ``forces``: ``gap``, in a0, and
    ``contact``, 2 where the wall repels, 1 where it attracts, and 0 out of range, of each atom; atoms that are held
    have no gap (NaN), and 0.

    Parameters
    ----------
    contact : a :class:`continuum.Contact`, with its heights and its law; or heights, an array of shape (nx, ny), in a0;
        or a shape that has a formula, as ``Round(period, radius)`` or ``Waves(period, mean, waves)``.
    slab : the atoms at rest, periodic along their first two cell vectors, which lie in the plane.  Their positions are
        the lattice sites, and the median height of the surface atoms is z = 0 of the separation.
    separation : height of the wall's zero above the surface at rest, in a0.
    law : law of the wall, for heights that come without one.
    pixel : distance of the points of an array along x and y, in a0, one number or two; without it the array covers the
        cell, its rows along the first cell vector and its columns along the second.
    a0 : length of the contact in Å, or a text, "0.255nm".  Of a contact with one point for each atom it is the distance
        of neighbours.
    contact_modulus : E* in eV/Å³, or a text, "135GPa".  With neither, heights are in Å and tractions in eV/Å³.
    follows : whether the height is taken above the positions of atoms, so that the wall pushes sideways, too, or above
        their lattice sites, as on a grid.
    surface : indices of the surface atoms, which share the area; those that are exposed at rest if None.
    offset : (x, y) by which the wall is shifted, in a0.

    Raises ArgumentError if an argument is not allowed, or the map neither repeats with the cell nor covers the surface;
    in a calculation, if the atoms are no longer those of the slab: another cell, other elements, no numbers, or held
    atoms elsewhere.

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
    >>> round(float(-wall.get_forces(atoms)[:, 2].sum()), 2)
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
        a0: float | str = 1.0,
        contact_modulus: float | str = 1.0,
        follows: Literal["atoms", "sites"] = "atoms",
        surface: Sequence[int] | NDArray[np.int64] | None = None,
        offset: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self.slab = instance("slab", slab, Atoms, "the atoms at rest, an ase.Atoms").copy()
        self.separation = number("separation", separation)
        self.a0 = possible.given("a0", a0, "spacing", "A")
        self.modulus = possible.given("contact_modulus", contact_modulus, "modulus", "eV/A3")
        self.follows = choice("follows", follows, ("atoms", "sites"))
        self.offset = np.array([number("offset", shift) for shift in pair("offset", offset)])
        self._cell = np.array(slab.cell)[:2, :2]
        if not slab.pbc[:2].all() or np.any(slab.cell[:2, 2]) or not abs(np.linalg.det(self._cell)) > 0:
            allowed = "a slab that is periodic along its first two cell vectors, which lie in the plane of x and y"
            raise ArgumentError("slab", slab, allowed)
        if not len(slab) or not np.isfinite(slab.positions).all():
            raise ArgumentError("slab", slab, "atoms at rest, of which each has a position")
        self._spacing = spacing_of(slab)
        top = exposed(slab.positions, self._cell, self._spacing)
        given = np.flatnonzero(top) if surface is None else array("surface", surface, kinds="iu")
        if given.ndim != 1 or not given.size or given.min() < 0 or given.max() >= len(slab):
            raise ArgumentError("surface", surface, f"indices of the surface atoms of the slab, 0 to {len(slab) - 1}")
        self.surface = np.unique(given)
        """Indices of the atoms that are exposed at rest."""
        fixed = [held.index for held in slab.constraints if isinstance(held, FixAtoms)]
        self._held = np.unique(np.concatenate([np.zeros(0, np.int64), *fixed]).astype(np.int64))
        self.moving = np.setdiff1d(np.arange(len(slab)), self._held)
        """Indices of the atoms on which the wall acts, all that are not held."""
        self._sites, z = self.slab.positions[:, :2], self.slab.positions[:, 2]
        self._level = float(np.median(z[self.surface]))
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
        self._of_atoms = law_of_atoms(self.law, layer_depth(z, len(self.surface)) / self.a0)
        self._shape, points, periods = self._map(heights, pixel)
        self._repeats = False
        # A formula holds everywhere.
        margin = 0 if self._shape is heights else _MARGIN
        self._to_points = np.linalg.inv(self._fitted(periods, points, margin)) * points
        """Matrix from positions in the plane, in Å, as rows, to points of the map."""

    def _map(self, heights: Any, pixel: Any) -> tuple[Shape, Real, Real]:
        """Shape of the wall, its points along either period, and these periods as rows, in Å."""
        if callable(getattr(heights, "evaluate", None)):
            points = np.array(pair("period", getattr(heights, "period", None)), dtype=np.float64)
            return heights, points, np.diag(points) * self.a0
        heights = field_of("contact", heights)
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
            # To the last digit: else a map of rounded pixels would have a step at the edge of the cell.
            self._repeats = True
            return np.asarray(np.linalg.solve(whole, self._cell))
        at = (self._sites[self.surface] - self.offset * self.a0) @ np.linalg.inv(periods) * points
        if (at < margin).any() or (at > points - 1 - margin).any():
            size = " x ".join(f"{length / self.a0:.6g}" for length in np.linalg.norm(periods, axis=1))
            cell = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in self._cell / self.a0)
            allowed = (
                f"a map that repeats with the cell, {cell} a0, or covers the surface with {margin} points to spare: "
                f"leave out pixel, so that an array covers the cell, or shift a wide one by offset"
            )
            raise ArgumentError("contact", f"a map of {size} a0", allowed)
        return periods

    def act(self, at: Real, atoms: NDArray[np.int64] | None = None) -> WallAction:
        """Energy and forces on some atoms.

        Parameters
        ----------
        at : their positions, shape (atoms, 3), in Å.
        atoms : their indices; those of the surface if None.
        """
        where = self._sites[self.surface if atoms is None else atoms]
        if self.follows == "atoms":
            # Of all images of an atom that which is near its site: a map need not repeat with the cell.
            where = where + self._nearest(at[:, :2] - where)
        height, *slopes = self._shape.evaluate(*((where - self.offset * self.a0) @ self._to_points).T)
        gap = self.separation + height - (at[:, 2] - self._level) / self.a0
        law, force = self._of_atoms.evaluate(gap), self.modulus * self._area
        # A height that is fixed to the site does not change as the atom moves in the plane: no lateral force.
        steepest = np.zeros((len(at), 3))
        if self.follows == "atoms":
            steepest[:, :2] = np.stack(slopes, axis=-1) @ self._to_points.T * self.a0
        steepest[:, 2] = -1.0
        forces = force * law.traction[:, None] * steepest
        stiffness = force / self.a0 * law.stiffness[:, None, None] * steepest[:, :, None] * steepest[:, None, :]
        return WallAction(force * self.a0 * law.energy, forces, gap, stiffness)

    def _nearest(self, moved: Real) -> Real:
        """Displacements in the plane, to the nearest image."""
        return np.asarray(moved - np.rint(moved @ np.linalg.inv(self._cell)) @ self._cell)

    def calculate(
        self,
        atoms: Atoms | None = None,
        properties: Sequence[str] = ("energy",),
        system_changes: Sequence[str] = all_changes,
    ) -> None:
        """Calculate all properties; ASE calls this.

        Raises ArgumentError if the atoms are not those of the slab, or no longer where it is.
        """
        super().calculate(atoms, properties, system_changes)  # type: ignore[no-untyped-call]
        if self.atoms is None or len(self.atoms) != len(self.slab):
            raise ArgumentError("atoms", self.atoms, f"the {len(self.slab)} atoms of the slab that the wall is above")
        self._require_slab(self.atoms)
        acting = self.act(self.atoms.positions[self.moving], self.moving)
        energy, forces = float(acting.energy.sum()), np.zeros((len(self.slab), 3))
        gap, contact = np.full(len(self.slab), np.nan), np.zeros(len(self.slab), dtype=np.uint8)
        forces[self.moving], gap[self.moving] = acting.forces, acting.gap
        contact[self.moving] = contact_map(self.law, acting.gap)
        self.results = {"energy": energy, "free_energy": energy, "forces": forces, "gap": gap, "contact": contact}

    def _require_slab(self, atoms: Atoms) -> None:
        """Check that the wall is still above these atoms; raises ArgumentError otherwise."""
        slab, anew = self.slab, "; make another wall above the atoms as they are"
        if not np.isfinite(atoms.positions).all():
            lost = int(np.argmin(np.isfinite(atoms.positions).all(axis=1)))
            raise ArgumentError("atoms", atoms.positions[lost].tolist(), f"positions that are numbers, of atom {lost}")
        if np.abs(np.array(atoms.cell)[:2, :2] - self._cell).max() > _ALIKE * np.abs(self._cell).max():
            raise ArgumentError(
                "atoms", atoms.cell[:2].tolist(), f"the cell of the wall, {self._cell.tolist()} Å{anew}"
            )
        # A wall of sites, and a map that does not repeat, are known by the place of each atom in its order.
        ordered = self.follows == "sites" or not self._repeats
        numbers, wanted = atoms.numbers, slab.numbers
        if not np.array_equal(numbers, wanted) if ordered else sorted(numbers) != sorted(wanted):
            raise ArgumentError("atoms", atoms, f"the elements of the slab, {slab.symbols!s}, in this order")
        moved = atoms.positions - slab.positions
        moved[:, :2] = self._nearest(moved[:, :2])
        away = np.linalg.norm(moved, axis=1)
        strayed = self._held[away[self._held] > _STRAYED * self._spacing]
        # Half of the atoms far from their sites are no deformation, but another order.
        if not len(strayed) and ordered and np.median(away) > self._spacing / 2:
            strayed = np.array([int(np.argmax(away))])
        if len(strayed):
            raise ArgumentError(
                "atoms", atoms, f"atoms at their sites, in the order of the slab: atom {strayed[0]} is "
                f"{away[strayed[0]]:.2f} Å from its own{anew}"
            )  # fmt: skip
        rise = float(np.median(atoms.positions[:, 2]) - np.median(slab.positions[:, 2]))
        if not abs(rise) < self._spacing:
            raise ArgumentError("atoms", atoms, f"the slab where it was: it is {rise:+.2f} Å higher{anew}")
