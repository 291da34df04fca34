"""Exact linear response of the slab: its surface Green's function and the displacements below it.

In the plane the slab is periodic, so that each wavevector q is a chain of layers with 3 x 3 blocks.  With u_l
the amplitude of layer l (0 is the surface, M - 1 the last mobile one) and f_l the force on it::

    H_l u_l + U u_(l+1) + U^H u_(l-1) = f_l,     u_M = 0

where H_0 belongs to the surface, all other H_l to the bulk.  Eliminating from the base upwards gives::

    S_(M-1) = H_(M-1),   S_l = H_l - U S_(l+1)^-1 U^H,   G = S_0^-1

Phases are those of the true positions, u_l(r) = u_l exp(iq.r): then U is the same between all layers although
every other layer is shifted by (a0/2, a0/2).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from atomistic.crystal import Slab
from atomistic.interatomic import Springs
from continuum.grid import Complex, Grid, Real

__all__ = ["ForceConstants", "LatticeResponse", "spring_force_constants"]


class ForceConstants(NamedTuple):
    """Blocks of the chain at each wavevector of the half spectrum, shape (nx, ny//2+1, 3, 3), in E* a0."""

    surface: Complex
    """H_0, within the surface layer."""
    bulk: Complex
    """H, within any other layer."""
    coupling: Complex
    """U: force on a layer per minus displacement of the layer below it."""


def spring_force_constants(grid: Grid, springs: Springs) -> ForceConstants:
    """Force constants of springs at rest: k_s n n^T (1 - exp(iq.r)) summed over the neighbours."""
    qx, qy = (np.broadcast_to(q, grid.shape_q) for q in grid.wavevectors)
    surface, bulk, coupling = (np.zeros((*grid.shape_q, 3, 3), dtype=np.complex128) for _ in range(3))
    for bond in springs.bonds:
        stiffness = springs.stiffness * np.outer(bond, bond)
        phase = np.exp(1j * (qx * bond[0] + qy * bond[1]))[..., None, None]
        bulk += stiffness
        if bond[2] == 0:
            bulk -= stiffness * phase
            surface += stiffness * (1 - phase)
        elif bond[2] < 0:
            surface += stiffness
            coupling -= stiffness * phase
    return ForceConstants(surface, bulk, coupling)


@dataclass(frozen=True, eq=False)
class LatticeResponse:
    """Linear response of a slab; a response in the sense of :mod:`continuum.greens`, q = 0 included.

    Parameters
    ----------
    slab : the atoms.
    force_constants : over the half spectrum of ``slab.grid``.

    Raises
    ------
    ValueError
        If the force constants do not belong to the grid of the slab.
    """

    slab: Slab
    force_constants: ForceConstants = field(repr=False)

    def __post_init__(self) -> None:
        """Refuse force constants of another grid."""
        wanted = (*self.slab.grid.shape_q, 3, 3)
        if any(block.shape != wanted for block in self.force_constants):
            msg = f"force constants of a slab {self.slab.shape} have the shape {wanted}"
            raise ValueError(msg)

    @classmethod
    def of_springs(cls, slab: Slab, springs: Springs) -> LatticeResponse:
        """Response of a slab of springs, from their exact force constants."""
        return cls(slab, spring_force_constants(slab.grid, springs))

    @cached_property
    def _inverse_s(self) -> tuple[Complex, ...]:
        """S_l^-1 of each mobile layer, from the surface down."""
        surface, bulk, coupling = self.force_constants
        inverse: list[Complex] = []
        for layer in reversed(range(self.slab.mobile)):
            s = surface if layer == 0 else bulk
            if inverse:
                s = s - coupling @ inverse[-1] @ _adjoint(coupling)
            inverse.append(np.linalg.inv(s).astype(np.complex128, copy=False))
        return tuple(reversed(inverse))

    @property
    def compliance_q(self) -> Complex:
        """G_q: displacement of surface atoms per force on them, shape (nx, ny//2+1, 3, 3), in 1/(E* a0)."""
        return self._inverse_s[0]

    @cached_property
    def stiffness_q(self) -> Real:
        """K_q = 1/G_zz: traction per displacement without lateral traction, shape (nx, ny//2+1), in E*/a0.

        The mean compresses the slab evenly: K_0 is about C11/depth.
        """
        stiffness: Real = 1 / self.compliance_q[..., 2, 2].real
        stiffness.flags.writeable = False
        return stiffness

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum of a grid, which must be the slab's.

        Raises
        ------
        ValueError
            If it is another grid.
        """
        if grid != self.slab.grid:
            msg = f"this response belongs to the grid {self.slab.grid}, got {grid}"
            raise ValueError(msg)
        return np.array(self.stiffness_q)

    def displacements_of_surface_force(self, force_z: Real) -> Real:
        """Displacements of all atoms under a vertical force on each surface atom.

        Parameters
        ----------
        force_z : shape (nx, ny), positive upwards (minus traction x a0²), in E* a0².

        Returns
        -------
        Real
            Shape (layers, nx, ny, 3), in a0; zero in the frozen layers.
        """
        forces = np.zeros((1, *self.slab.shape, 3))
        forces[0, ..., 2] = force_z
        return self.displacements(forces)

    def displacements(self, forces: Real) -> Real:
        """Displacements of all atoms under given forces: the inverse of the Hessian of the slab.

        Parameters
        ----------
        forces : shape (n, nx, ny, 3) for the uppermost n layers, in E* a0²; those on frozen atoms do not
            count.

        Returns
        -------
        Real
            Shape (layers, nx, ny, 3), in a0; zero in the frozen layers.

        Raises
        ------
        ValueError
            If the shape of the forces does not fit the slab.
        """
        slab, coupling, inverse = self.slab, self.force_constants.coupling, self._inverse_s
        if forces.shape[1:] != (*slab.shape, 3) or not 1 <= forces.shape[0] <= slab.layers:
            msg = f"forces on a slab {slab.shape} of {slab.layers} layers cannot have the shape {forces.shape}"
            raise ValueError(msg)
        up = _adjoint(coupling)

        # From below: the load of each layer, with what the layers below it pass on.
        loads: list[Complex] = []
        for layer in reversed(range(min(len(forces), slab.mobile))):
            load = self._forward(forces[layer], layer)
            if loads:
                load -= coupling @ (inverse[layer + 1] @ loads[-1])
            loads.append(load)

        # From above: each layer follows the one over it.
        result = np.zeros((slab.layers, *slab.shape, 3))
        u = np.zeros_like(loads[0])
        for layer in range(slab.mobile):
            load = loads.pop() if loads else np.zeros_like(u)
            u = inverse[layer] @ (load - up @ u)
            result[layer] = self._inverse(u, layer)
        return result

    @cached_property
    def _shift(self) -> Complex:
        """exp(iq.s) of the shift s = (a0/2, a0/2) of the odd layers, shape (nx, ny//2+1)."""
        qx, qy = self.slab.grid.wavevectors
        shift: Complex = np.exp(0.5j * (qx + qy))
        return shift

    def _forward(self, vectors: Real, layer: int) -> Complex:
        """Amplitudes, shape (nx, ny//2+1, 3, 1), of the vectors at the atoms of a layer."""
        grid = self.slab.grid
        spectrum = np.stack([grid.forward(vectors[..., c]) for c in range(3)], axis=-1)[..., None]
        return spectrum / self._shift[..., None, None] if layer % 2 else spectrum

    def _inverse(self, amplitudes: Complex, layer: int) -> Real:
        """Vectors at the atoms of a layer, shape (nx, ny, 3)."""
        grid = self.slab.grid
        spectrum = amplitudes[..., 0] * self._shift[..., None] if layer % 2 else amplitudes[..., 0]
        return np.stack([grid.inverse(np.ascontiguousarray(spectrum[..., c])) for c in range(3)], axis=-1)


def _adjoint(matrices: Complex) -> Complex:
    """Conjugate transpose of each matrix."""
    return matrices.conj().swapaxes(-1, -2)
