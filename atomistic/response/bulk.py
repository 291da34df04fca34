"""Crystals below any face, measured through LAMMPS: periods at zero pressure, all elastic constants; slabs at rest.

With strains ε along the axes of an orthogonal cell, displacements u of its n atoms, and the volume V, the energy is
quadratic in both: V ε C0 ε/2 + ε B u + u K u/2.  Atoms follow a strain by u = -K⁻¹ Bᵀ ε, so that the elastic constants
are C = C0 - B K⁻¹ Bᵀ/V (Born and Huang, Dynamical Theory of Crystal Lattices, 1954).
"""

import json
import warnings
from dataclasses import replace
from functools import singledispatch

import numpy as np
from scipy.spatial import KDTree

from atomistic.crystal.crystal import AtomSlab, within
from atomistic.crystal.faces import LARGE, PIECE, CrystalCell, cell_of, size_of_atoms, slab_of_atoms
from atomistic.crystal.interatomic import Springs
from atomistic.crystal.model import AnyCrystalModel, AnyModel, Potential
from atomistic.crystal.potentials import PotentialError
from atomistic.inputs.crystal import CrystalTable
from atomistic.lammps.session import Cell
from atomistic.response.material import STEP, model_of, require_style
from continuum.inputs import possible
from continuum.inputs.arguments import ArgumentError
from continuum.model.fourier import Real
from continuum.model.substrates.crystal import CubicConstants, anisotropic_contact_modulus, rotated, tensor_of

_RATTLE, _LEFT = 1e-3, 1e-8
"""Random displacements from which a surface relaxes, in a0, and the largest force that is left, in E* a0²."""
_ALIKE = 1e-5
"""Largest difference of displacements of atoms that are alike, in a0: many times that by the force that is left."""
_VOIGT = [0, 1, 2, 5, 4, 3]
"""Voigt's places of LAMMPS' xx, yy, zz, xy, xz, yz."""
_TILTS = [1, 2, 2], [0, 0, 1]
"""Places of xy, xz and yz in a box whose rows are its edges."""
_ASIDE = 0.0137
"""Start of a piece of a slab, in cells: beside the sites of any crystal."""
_MEASURED: dict[str, AnyCrystalModel] = {}


def model_below(potential: Potential, crystal: CrystalTable) -> AnyModel:
    """A potential with its crystal below the face of a table [crystal], measured once in a process.

    Raises ArgumentError if there is no such crystal, or it has another number of elements; PotentialError if it is not
    stable; LammpsError if LAMMPS fails.
    """
    if crystal.own:
        return model_of(potential)
    if crystal.given is not None:
        return _of_atoms(potential, crystal)
    cell = cell_of(crystal.lattice, crystal.face)
    if len(potential.elements) != (count := int(cell.types.max()) + 1):
        allowed = f"{count} of them in {crystal.lattice}, as the elements of the potential"
        raise ArgumentError("lattice", crystal.lattice, f"{allowed}; it has {' '.join(potential.elements)}")
    key = json.dumps([dict(potential.identity), cell.name])
    if key not in _MEASURED:
        _MEASURED[key] = _below(potential, cell)
    return _MEASURED[key]


def _of_atoms(potential: Potential, crystal: CrystalTable) -> AnyCrystalModel:
    """Atoms of a file, of a given E*."""
    a0, (x, y) = size_of_atoms(crystal.given, crystal.spacing)
    types = slab_of_atoms(crystal.given, potential.elements, np.inf, crystal.skin, crystal.spacing).types
    modulus = crystal.modulus
    if isinstance(modulus, str) or potential.units == "metal":
        modulus = possible.given("modulus", modulus, "modulus", "eV/A3")
    # An isotropic solid of nu = 1/4, as most crystals are about: E* = 16/15 E, and C11 = 6/5 E, C44 = 2/5 E.
    tensor = CubicConstants(1.125, 0.375, 0.375).stiffness_tensor()
    density = len(types) / (x * y * (float(np.ptp(crystal.given.positions[:, 2])) / a0 + 0.8))
    assert modulus is not None
    return AnyCrystalModel(potential, a0, modulus, tensor, density, _mass(potential, types), None)


def _mass(potential: Potential, types: object) -> float:
    return float(np.mean(np.asarray(potential.masses)[np.asarray(types)]))


def _of_springs(springs: Springs, cell: CrystalCell) -> AnyCrystalModel:
    """Springs with the stiffness at which the face has the contact modulus 1."""
    if not cell.name.startswith("fcc"):
        raise ArgumentError("lattice", cell.name, '"fcc" of springs, which do not hold other crystals together')
    tensor = rotated(Springs(1.0).elastic_constants.stiffness_tensor(), cell.axes)
    found = AnyCrystalModel(Springs(), 1.0, 1.0, tensor, 2**0.5, 1.0, cell)
    modulus = _modulus(found.tensor)
    return replace(found, potential=Springs(1 / modulus), tensor=tensor / modulus, stiffest=8 / modulus)


def _modulus(tensor: Real) -> float:
    """Mean contact modulus of a face, 1/<1/E*>."""
    return float(1 / np.mean(1 / anisotropic_contact_modulus(tensor, np.arange(64) * np.pi / 64)))


def _measured(potential: Potential, cell: CrystalCell) -> AnyCrystalModel:
    require_style(potential)
    with _Strained(potential, cell) as strained:
        strained.settle()
        h = strained.hessian()
        periods, fractions = strained.periods, strained.fractions
        stable = np.linalg.eigvalsh(h[6:, 6:]).min() > -1e-6 * np.abs(h).max()
    volume = float(np.prod(periods))
    c = (h[:6, :6] - h[:6, 6:] @ np.linalg.pinv(h[6:, 6:], rcond=1e-7) @ h[6:, :6]) / volume
    if not (stable and np.linalg.eigvalsh(c).min() > 0):
        raise PotentialError(f"the crystal {cell.name} of this potential is not stable: {potential.reference}")
    at_rest = cell._replace(periods=periods, fractions=fractions)
    length = at_rest.nearest()
    tensor = tensor_of(c)
    modulus = _modulus(tensor)
    density = len(cell.types) * length**3 / volume
    return AnyCrystalModel(
        potential, length, modulus, tensor / modulus, density, _mass(potential, cell.types),
        at_rest._replace(periods=periods / length),
    )  # fmt: skip


class _Strained(Cell):
    """A cell of a crystal under homogeneous strain and displacements of its atoms."""

    def __init__(self, potential: Potential, cell: CrystalCell) -> None:
        guess = potential.guess or (0.5 * potential.cutoff) ** 3
        volumes, self.fractions = guess / cell.volume * np.geomspace(0.35, 3, 120), cell.fractions
        start = cell.periods * np.cbrt(volumes[0])
        super().__init__(potential, cell.fractions * start, start, types=cell.types)
        self.command("change_box all triclinic")
        energies = [self._at(np.zeros(6), cell.periods * np.cbrt(volume))[0] for volume in volumes]
        i = int(np.argmin(energies))
        if not np.isfinite(energies).all() or not 0 < i < len(energies) - 1:
            msg = f"no crystal {cell.name} at zero pressure near {guess:.4g} an atom in volume: {potential.reference}"
            raise PotentialError(msg)
        self.periods = cell.periods * np.cbrt(volumes[i])

    def _at(self, strain: Real, periods: Real, moved: Real | float = 0.0) -> tuple[float, Real]:
        """Energy, and its derivatives by strains in Voigt's order, which tilt the upper edges, and by displacements."""
        box = np.diag(periods * (1 + strain[:3]))  # rows are the edges
        box[1, 0], box[2, 0], box[2, 1] = strain[5] * periods[1], strain[4] * periods[2], strain[3] * periods[2]
        tilts = zip(("xy", "xz", "yz"), box[_TILTS], strict=True)
        self.deform(np.diag(box), "".join(f" {name} final {tilt:.17g}" for name, tilt in tilts))
        energy, forces = self.evaluate(self.fractions @ box + moved)
        return energy, np.concatenate([self.stress(6)[_VOIGT] * float(np.prod(np.diag(box))), -forces.ravel()])

    def hessian(self) -> Real:
        """Second derivatives by six strains and all displacements, by central differences."""
        size = 6 + self.fractions.size
        step = np.full(size, STEP * float(np.cbrt(np.prod(self.periods) / len(self.fractions))))
        step[:6] = STEP
        sides = [[self._at(x[:6], self.periods, x[6:].reshape(-1, 3))[1] for x in (s * e, -s * e)]
                 for s, e in zip(step, np.eye(size), strict=True)]  # fmt: skip
        h = np.array([(up - down) / (2 * s) for s, (up, down) in zip(step, sides, strict=True)])
        return np.asarray((h + h.T) / 2)

    def settle(self) -> None:
        """Bring the lengths of the cell and the atoms in it to rest."""
        h = self.hessian()
        free = np.delete(np.arange(len(h)), [3, 4, 5])
        inverse, scale = np.linalg.pinv(h[np.ix_(free, free)], rcond=1e-7), float(np.abs(h).max())
        for _ in range(60):
            g = self._at(np.zeros(6), self.periods)[1][free]
            if np.abs(g).max() < 1e-11 * scale:
                break
            move = -inverse @ g
            move *= min(1.0, 0.03 / np.abs(move[:3]).max())
            self.fractions = self.fractions + move[3:].reshape(-1, 3) / self.periods
            self.periods = self.periods * (1 + move[:3])


_below = singledispatch(_measured)
_below.register(Springs, _of_springs)


def slab_of_table(crystal: CrystalTable, model: AnyCrystalModel, width: tuple[float, float], depth: float) -> AtomSlab:
    """The slab of a table [crystal], at rest, on a base that forces do not cross, or of given atoms with a warning."""
    if crystal.given is not None:
        found = slab_of_atoms(crystal.given, model.elements, depth, crystal.skin, crystal.spacing)
        below = found.positions[0, 2] - found.bottom
        if found.moving == found.size:
            raise ArgumentError("depth", depth, f"less than {below:.4g} a0, the depth of the atoms: some are held")
        held = float(np.ptp(found.positions[found.moving :, 2]))
        if not held + found.lost > model.reach:
            warnings.warn(
                f"forces reach {model.reach:.3g} a0, through the held base of {held:.3g} a0: the lowest moving atoms "
                f"feel that it ends; with a depth below {below - model.reach:.4g} a0 they would not",
                stacklevel=2,
            )
        return found
    assert model.cell is not None
    return model.cell.slab(width, depth, model.reach, crystal.skin)


def at_rest(slab: AtomSlab, model: AnyCrystalModel) -> tuple[AtomSlab, AnyCrystalModel]:
    """A slab as its surface relaxes from sites that are no longer symmetric, and its model with its stiffest vibration.

    Of a large crystal a piece is relaxed and repeated, unless its cells part, as in a surface that reconstructs.

    Raises LammpsError if LAMMPS fails.
    """
    part = _piece(slab, model)
    if part is not None:
        assert model.cell is not None
        moved, stiffest = _relaxed(part, model)
        cell = np.array([*model.cell.periods[:2], 0.0])  # none across
        tree = KDTree(_in_cell(part.positions, cell), boxsize=cell)
        alike = tree.query_ball_point(_in_cell(part.positions[: part.surface], cell), 1e-3)
        if all(np.ptp(moved[same], axis=0).max() < _ALIKE for same in alike):
            moved = moved[tree.query(_in_cell(slab.positions, cell))[1]]
            return replace(slab, positions=slab.positions + moved), replace(model, stiffest=stiffest)
    moved, stiffest = _relaxed(slab, model)
    return replace(slab, positions=slab.positions + moved), replace(model, stiffest=stiffest)


def _piece(slab: AtomSlab, model: AnyCrystalModel) -> AtomSlab | None:
    """A piece of a large slab, an even number of cells wide; None of a small slab, or of atoms without a cell."""
    if model.cell is None or slab.size <= LARGE:
        return None
    periods, lengths = model.cell.periods[:2], np.array(slab.lengths)
    width = 2 * np.ceil(PIECE / 2 / periods) * periods
    at = within(slab.positions[:, :2] + _ASIDE * periods, lengths)
    inside = np.flatnonzero((at < width).all(axis=1))
    if (lengths < 2 * width).any() or len(inside) != round(slab.size * float(np.prod(width / lengths))):
        return None
    surface, moving = np.searchsorted(inside, (slab.surface, slab.moving)).tolist()
    size = float(width[0]), float(width[1])
    return AtomSlab(slab.name, size, slab.positions[inside], slab.types[inside], surface, moving, slab.lost)


def _in_cell(positions: Real, periods: Real) -> Real:
    """Positions in the first cell of the plane."""
    return np.column_stack([within(positions[:, :2], periods[:2]), positions[:, 2]])


def _relaxed(slab: AtomSlab, model: AnyCrystalModel) -> tuple[Real, float]:
    """Displacements of the atoms of a slab as its surface relaxes, in a0, and its stiffest vibration."""
    rng, sites, unit = np.random.default_rng(1), slab.positions * model.length, model.energy / model.length
    mobile = np.arange(slab.size)[:, None] < slab.moving
    random = mobile * rng.normal(size=sites.shape)
    with Cell(model, sites, np.array(slab.lengths) * model.length, surface=True, types=slab.types) as cell:
        cell.command(f"group base id > {slab.moving}", "fix freeze base setforce 0 0 0", "min_style cg")
        cell.command(f"min_modify line quadratic norm max dmax {0.1 * model.length:.17g}")
        cell.evaluate(sites + _RATTLE * model.length * random)
        cell.command(f"minimize 0 {_LEFT * unit:.17g} 2000 4000")
        rest, v = cell.positions(), random
        for _ in range(12):  # the largest eigenvalue of the Hessian, by its powers, from below
            v /= np.linalg.norm(v)
            h = 1e-4 * model.length / np.abs(v).max()
            v = mobile * (cell.evaluate(rest - h * v)[1] - cell.evaluate(rest + h * v)[1]) / (2 * h)
    stiffest = 1.1 * float(np.linalg.norm(v)) * model.length / unit * model.mass / min(model.masses)
    moved = (rest - sites) / model.length
    moved[:, :2] -= np.array(slab.lengths) * np.rint(moved[:, :2] / slab.lengths)
    return moved, stiffest
