"""Force constants of the relaxed slab: the force on an atom per displacement of another.

Φ(l, d, r) is minus the force on an atom of layer l per displacement of the atom of layer l + d that lies at r from it
in the plane, a 3 x 3 matrix.  All layers below the first ``depth`` ones are those of the bulk.  Springs are known
exactly; any other potential is measured: one atom at a time is displaced in LAMMPS, and all forces are read.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import singledispatch

import numpy as np
import scipy

from atomistic.crystal.crystal import LAYER_SPACING, Slab
from atomistic.crystal.interatomic import Springs
from atomistic.crystal.model import Model
from atomistic.crystal.potentials import PotentialError
from atomistic.lammps.session import Cell
from atomistic.response.material import STEP
from continuum.model.fourier import Complex, Real

_SETTLED = 1e-9
"""Layers that relax by less, in a0, count as bulk: their stiffness differs by some 1e-8."""
_NEGLIGIBLE = 1e-10
"""Force constants smaller than this part of the largest are rounding errors."""
_RELAXING = 64
"""Largest number of layers that relax.  Relaxation decays by a factor of three or more per layer."""
_SOUND = 1e-4
"""Largest violation of a sum rule, relative to the largest force constant.

Finite differences leave 1e-9; where a distance in the crystal falls on a knot of a tabulated potential, the second
derivative of LAMMPS' spline jumps there, by up to 1e-5 for the tables that come with it.
"""


@dataclass(frozen=True)
class SymmetryErrors:
    """Violation of each symmetry by the measured force constants, relative to the largest of them.

    All are corrected afterwards: forces beyond the range are dropped, matrices symmetrised, and the force of an atom
    on itself set so that a common displacement of all atoms gives no force.
    """

    beyond_reach: float
    """Largest force constant beyond the range of forces."""
    translation: float
    """Σ_j Φ_ij = 0: the acoustic sum rule."""
    symmetry: float
    """Φ_ij = Φ_ji^T: forces have an energy."""
    rotation: float
    """Σ_j Φ_ij x (r_j - r_i) = 0: a rotation of the crystal costs no energy, if it is at rest and without pressure."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value < _SOUND:
                msg = f"the force constants violate {name} by {value:.1e}, more than {_SOUND:g}: no harmonic crystal"
                raise PotentialError(msg)


@dataclass(frozen=True, eq=False)
class ForceConstants:
    """Force constants of a slab, in E* a0, between atoms of one layer and of the layers below it.

    Parameters
    ----------
    surface : of the first layers, shape (depth, reach + 1, 2h + 1, 2h + 1, 3, 3): layer, layers further down, and the
        place in the plane, x = i - h for an even number of layers down and i - h + 1/2 for an odd one.
    bulk : of any other layer, shape (reach + 1, 2h + 1, 2h + 1, 3, 3).
    relaxation : rise of each layer of the surface when it relaxes, shape (depth,), in a0.
    checks : errors of the measurement; None if the constants are exact.
    """

    surface: Real = field(repr=False)
    bulk: Real = field(repr=False)
    relaxation: Real
    checks: SymmetryErrors | None = None

    def __post_init__(self) -> None:
        if self.surface.shape[1:] != self.bulk.shape or self.relaxation.shape != self.surface.shape[:1]:
            raise ValueError(
                f"force constants of shape {self.surface.shape} (surface), {self.bulk.shape} (bulk) and "
                f"{self.relaxation.shape} (relaxation) do not belong together"
            )

    @property
    def coupled_layers(self) -> int:
        """Number of layers that forces reach."""
        return len(self.bulk) - 1

    @property
    def depth(self) -> int:
        """Number of layers that differ from the bulk."""
        return len(self.surface)

    def between(self, layer: int, down: int) -> Real:
        """Φ between a layer and one that lies so many layers further down; shape (2h + 1, 2h + 1, 3, 3)."""
        chosen: Real = self.surface[layer, down] if layer < self.depth else self.bulk[down]
        return chosen

    def blocks(self, layer: int, down: int, qx: Real, qy: Real) -> Complex:
        """Σ_r Φ exp(iq.r) at wavevectors qx, qy, shape (n,) each; shape (n, 3, 3)."""
        x = places(self.bulk.shape[1], down)
        waves = np.exp(1j * np.outer(qx, x)), np.exp(1j * np.outer(qy, x))
        phi = self.between(layer, down).reshape(x.size, -1)
        along = (waves[0] @ phi).reshape(-1, x.size, 9)
        summed: Complex = np.einsum("qj,qjc->qc", waves[1], along)
        return summed.reshape(-1, 3, 3)


def spring_force_constants(springs: Springs) -> ForceConstants:
    """Force constants of springs at rest: -k_s n n^T between neighbours."""
    bulk = np.zeros((2, 3, 3, 3, 3))
    self_surface, self_bulk = np.zeros((3, 3)), np.zeros((3, 3))
    for bond in springs.bonds:
        stiffness = springs.stiffness * np.outer(bond, bond)
        self_bulk += stiffness
        if bond[2] > 0:
            continue
        self_surface += stiffness
        down = int(bond[2] < 0)
        i, j = (round(float(b) - down / 2) + 1 for b in bond[:2])
        bulk[down, i, j] -= stiffness
    surface = bulk.copy()
    surface[0, 1, 1] += self_surface
    bulk[0, 1, 1] += self_bulk
    return ForceConstants(surface[None], bulk, np.zeros(1))


def relaxation(model: Model, mobile: int) -> Real:
    """Rise of the layers of a slab without load, shape (mobile,), in a0, on a base at its lattice sites.

    Raises PotentialError if the surface relaxation does not converge.
    """
    layers = min(mobile, _RELAXING)
    if model.harmonic:
        return np.zeros(mobile)
    slab = Slab((3, 3), layers, max(model.coupled_layers, 1))
    sites = slab.positions[:, 0, 0]  # one atom of each layer, as layers move as a whole
    with Cell(model, sites * model.length, np.ones(2) * model.length, surface=True) as cell:

        def forces(rise: Real) -> Real:
            at = sites.copy()
            at[:layers, 2] += rise
            return cell.evaluate(at * model.length)[1][:layers, 2] * (model.length / model.energy)

        found = scipy.optimize.root(forces, np.zeros(layers), tol=1e-13, method="hybr")
        left = float(np.abs(forces(found.x)).max())
    if not left < 1e-9:
        msg = f"the surface relaxation did not converge: forces of {left:.1e} E* a0² are left ({model.reference})"
        raise PotentialError(msg)
    rise = np.zeros(mobile)
    rise[:layers] = found.x
    return rise


def measure_force_constants(model: Model, mobile: int) -> ForceConstants:
    """Force constants of a relaxed slab of so many mobile layers, from forces in LAMMPS, by central differences.

    Raises PotentialError if the surface relaxation does not converge, or the crystal is not harmonic.
    """
    reach = model.coupled_layers
    rise = relaxation(model, mobile)
    strained = np.flatnonzero(np.abs(np.diff(rise, append=0.0)) > _SETTLED)
    depth = min(mobile, reach + 1 + int(strained.max(initial=-1)))
    raised = np.zeros(depth + 2 * reach)
    raised[: min(mobile, raised.size)] = rise[: raised.size]

    # An even number of layers, so that every other one is shifted across the period too.
    bulk, far = _rows(model, 2 * reach + 2, [reach], None)
    rows, far_at_surface = _rows(model, raised.size, range(depth), raised)
    rows += bulk
    scale = float(np.abs(rows[-1][reach]).max())

    tables, asymmetries, torques = list[Real](), list[float](), list[float]()
    for layer, row in enumerate(rows):
        table = row[reach:].copy()
        for down in range(reach + 1):
            # Between the last layer of the surface and the bulk there is no second measurement.
            if layer == depth or layer + down < depth:
                seen = _mirrored(rows[min(layer + down, depth)][reach - down], down)
                asymmetries.append(float(np.abs(table[down] - seen).max()))
                table[down] = (table[down] + seen) / 2
        tables.append(table)
        around = [raised[max(layer + d, 0)] - raised[layer] for d in range(-reach, reach + 1)]
        torques.append(_torque(row, np.array(around) if layer < depth else np.zeros(2 * reach + 1)))
    checks = SymmetryErrors(
        beyond_reach=max(far, far_at_surface) / scale,
        translation=max(float(np.abs(row.sum(axis=(0, 1, 2))).max()) for row in rows) / scale,
        symmetry=max(asymmetries) / scale,
        rotation=max(torques) / scale,
    )
    # Layers within the nominal range only: less than the error of the differences.
    sizes = [max(float(np.abs(table[down]).max()) for table in tables) for down in range(reach + 1)]
    reach = max(down for down in range(reach + 1) if sizes[down] > _NEGLIGIBLE * scale or down == 1)
    tables = [table[: reach + 1] for table in tables]
    for layer, table in enumerate(tables):
        above = tables[max(0, layer - reach) : layer][::-1] if layer < depth else [tables[depth]] * reach
        half = table.shape[1] // 2
        table[0, half, half] = 0
        others = table.sum(axis=(0, 1, 2)) + sum(
            (upper[down].sum(axis=(0, 1)).T for down, upper in enumerate(above, 1)), np.zeros((3, 3))
        )
        table[0, half, half] = -(others + others.T) / 2
    return ForceConstants(np.array(tables[:-1]), tables[-1], rise[:depth], checks)


force_constants = singledispatch(measure_force_constants)
"""Force constants of a slab of any model: measured, but for springs, whose are exact."""
force_constants.register(Springs, lambda springs, mobile: spring_force_constants(springs))


def least_width(model: Model) -> int:
    """Atoms of a layer along x and y, so many that the forces on an atom and on its next image do not overlap."""
    return int(2 * model.force_range / model.length) + 1


def _rows(model: Model, layers: int, displaced: Iterable[int], raised: Real | None) -> tuple[list[Real], float]:
    """Force constants of an atom in each of some layers with all atoms around it, and the largest beyond reach.

    Each is of shape (2 reach + 1, 2h + 1, 2h + 1, 3, 3), from the layers above to those below.

    Parameters
    ----------
    layers : of the cell; periodic if there is no surface.
    displaced : layers of which an atom is displaced.
    raised : rise of each layer when the surface has relaxed; None for the bulk.
    """
    reach, radius = model.coupled_layers, model.force_range / model.length
    width = max(3, least_width(model))
    half = int(np.ceil(radius))
    slab = Slab((width, width), layers - 1)
    sites, rise = slab.positions.copy(), np.zeros(layers) if raised is None else raised
    sites[..., 2] += rise[:, None, None]
    periods = np.array([width, width, layers * LAYER_SPACING])
    rows, far = [], 0.0
    with Cell(model, sites.reshape(-1, 3) * model.length, periods * model.length, raised is not None) as cell:
        for layer in displaced:
            answer = np.empty((*sites.shape[:3], 3, 3))
            for axis in range(3):
                pushed = []
                for sign in (1, -1):
                    at = sites.copy()
                    at[layer, 0, 0, axis] += sign * STEP
                    forces = cell.evaluate(at.reshape(-1, 3) * model.length)[1] * (model.length / model.energy)
                    pushed.append(forces.reshape(sites.shape))
                answer[..., axis, :] = (pushed[1] - pushed[0]) / (2 * STEP)
            row = np.zeros((2 * reach + 1, 2 * half + 1, 2 * half + 1, 3, 3))
            for down in range(-reach, reach + 1):
                other = (layer + down) % layers
                if raised is not None and other != layer + down:
                    continue
                x = places(2 * half + 1, down)
                # The displaced atom stands at the origin of an even layer, or at (1/2, 1/2) of an odd one.
                index = np.rint(x + (0.5 if layer % 2 else 0.0) - (0.5 if other % 2 else 0.0)).astype(int)
                near = np.abs(x) <= radius
                near_both = np.ix_(near, near)
                inside = answer[other][np.ix_(index[near] % width, index[near] % width)].copy()
                answer[other][np.ix_(index[near] % width, index[near] % width)] = 0
                z = down * LAYER_SPACING + rise[layer] - rise[other]
                outside = x[near, None] ** 2 + x[None, near] ** 2 + z**2 > radius**2 * (1 + 1e-9)
                far = max(far, float(np.abs(inside[outside]).max(initial=0.0)))
                inside[outside] = 0
                row[down + reach][near_both] = inside
            far = max(far, float(np.abs(answer).max()))
            rows.append(row)
    return rows, far


def places(count: int, down: int) -> Real:
    """Positions in the plane, along x or y, of the entries of a table between layers."""
    return np.arange(count, dtype=np.float64) - count // 2 + (0.5 if down % 2 else 0.0)


def _mirrored(table: Real, down: int) -> Real:
    """The same pairs from the side of the other atom: r becomes -r, and the matrices are transposed."""
    turned = np.zeros_like(table)
    # In odd layers the last place, h + 1/2, has no opposite; it is beyond the reach.
    inner = slice(None, -1) if down % 2 else slice(None)
    turned[inner, inner] = table[inner, inner][::-1, ::-1]
    return np.asarray(turned.swapaxes(-1, -2), dtype=np.float64)


def _torque(row: Real, rise: Real) -> float:
    """Largest force on an atom when all others turn about it, per angle."""
    reach = row.shape[0] // 2
    moments = np.zeros((3, 3, 3))
    for i, down in enumerate(range(-reach, reach + 1)):
        x = places(len(row[i]), down)
        r = np.stack(np.broadcast_arrays(x[:, None], x[None, :], -down * LAYER_SPACING + rise[i]), axis=-1)
        moments += np.einsum("xyab,xyc->abc", row[i], r)
    return float(np.abs(moments - moments.swapaxes(1, 2)).max())
