"""Exact linear response of the slab: its surface Green's function, displacements below it, the continuum beside it.

In the plane the slab is periodic, so that each wavevector q is a chain of layers.  Forces reach b layers: b layers make
a block, and blocks couple to their neighbours only.  With u_l the amplitudes of block l (0 holds the surface, n - 1 the
last mobile layer) and f_l the forces on it, 3b numbers each::

    H_l u_l + U_l u_(l+1) + U_(l-1)^H u_(l-1) = f_l,     u_n = 0

Eliminating from the base upwards gives::

    S_(n-1) = H_(n-1),   S_l = H_l - U_l S_(l+1)^-1 U_l^H,   G = S_0^-1

Phases are those of the true positions, u_l(r) = u_l exp(iq.r): then U is the same between all layers of the bulk
although every other layer is shifted by (a0/2, a0/2).

A wave decays over a depth of the order of its length, so that S_l of all but the longest waves soon stops changing on
the way up: from then on it is stored once, not for each block.  Of the 128 x 65 waves of a slab of 181 layers of
springs this leaves one matrix in nine.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.crystal.model import Model, check_model
from atomistic.crystal.potentials import PotentialError
from atomistic.response.force_constants import ForceConstants, force_constants, least_width, spring_force_constants
from continuum.inputs.arguments import ArgumentError, array, field_of, instance
from continuum.model import fourier
from continuum.model.fourier import Complex, Real
from continuum.model.grid import Grid
from continuum.model.substrates import CubicLayer, TabulatedSubstrate
from continuum.model.substrates.crystal import CubicConstants

_LONG = 12.0
"""Wavelengths, in a0, from which the first order in q is read: its neighbours are then below a tenth of it."""
_ALIKE = 0.03
"""Relative width of a bin of wavelengths."""
_STEADY = 1e-14
"""Relative change of S_l^-1 from block to block below which it is used for all blocks above."""


class _Chain(NamedTuple):
    """S_l^-1 of all blocks, with waves sorted by length, longest first."""

    surface: tuple[Complex, ...]
    """Blocks whose force constants are not those of the bulk, from the top; shape (waves, 3b, 3b)."""
    bulk: tuple[Complex, ...]
    """Blocks below these, from the top: for their first waves only."""
    steady: Complex
    """The limit deep in the bulk, for all waves that a block does not list."""
    couplings: dict[int, Complex]
    """U_l by block; those of the bulk that are missing are that of the next one listed."""

    def solve(self, block: int, x: Complex) -> Complex:
        """Product S_l^-1 x."""
        if block < len(self.surface):
            return self.surface[block] @ x
        own = self.bulk[block - len(self.surface)]
        if len(own) == len(x):
            return own @ x
        return np.concatenate([own @ x[: len(own)], self.steady[len(own) :] @ x[len(own) :]])

    def coupling(self, block: int) -> Complex:
        """U_l, between this block and the next."""
        return self.couplings[min(other for other in self.couplings if other >= block)]


@dataclass(frozen=True, eq=False)
class LatticeResponse:
    """Linear response of a slab; a response in the sense of :mod:`continuum.model.substrates`, q = 0 included.

    Parameters
    ----------
    slab : the atoms.
    force_constants : between them.
    table : :attr:`stiffness_q`, if it is known from a file.

    Raises
    ------
    ValueError
        If the force constants do not fit the slab.

    Examples
    --------
    >>> import numpy as np, atomistic as a, continuum as c
    >>> grid = c.Grid.square(16)
    >>> lattice = a.LatticeResponse.of_springs(a.Slab.of_depth(grid, depth=16), a.Springs())
    >>> ratio = lattice.stiffness(grid)[0, 1] / c.HalfSpace().stiffness(grid)[0, 1]
    >>> round(float(ratio), 3)  # of atoms to an isotropic half-space, for the longest wave
    1.049
    """

    slab: Slab
    force_constants: ForceConstants = field(repr=False)
    table: Real | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        slab = instance("slab", self.slab, Slab)
        constants = instance("force_constants", self.force_constants, ForceConstants)
        if constants.coupled_layers > slab.frozen:
            msg = f"forces reach {constants.coupled_layers} layers, but only {slab.frozen} are frozen: freeze more"
            raise ValueError(msg)
        if self.table is not None:
            field_of("table", self.table, slab.grid.shape_q)
        if constants.depth > slab.mobile:
            msg = f"force constants of {constants.depth} layers do not fit a slab of {slab.mobile} mobile layers"
            raise ValueError(msg)

    @classmethod
    def of_springs(cls, slab: Slab, springs: Springs) -> Self:
        """Response of a slab of springs, from their exact force constants."""
        instance("springs", springs, Springs)
        return cls(slab, spring_force_constants(springs))

    @classmethod
    def of_model(cls, slab: Slab, model: Model) -> Self:
        """Response of a slab of any model: exact for springs, else measured in LAMMPS.

        Raises
        ------
        ValueError
            If forces reach further than the slab, or the crystal is not harmonic.
        LammpsError
            If LAMMPS fails.
        """
        require_room(instance("slab", slab, Slab), check_model("model", model))
        return cls(slab, force_constants(model, slab.mobile))

    @cached_property
    def rise(self) -> Real:
        """Rise of each layer at rest above its lattice sites, shape (layers,), in a0, as the surface relaxes."""
        rise = np.zeros(self.slab.layers)
        relaxed = self.force_constants.relaxation
        rise[: relaxed.size] = relaxed
        return rise

    @cached_property
    def _order(self) -> NDArray[np.int64]:
        """Places of the waves in the half spectrum, longest first."""
        return np.argsort(self.slab.grid.wavenumber.ravel(), kind="stable")

    @cached_property
    def _waves(self) -> tuple[Real, Real]:
        qx, qy = np.broadcast_arrays(*self.slab.grid.wavevectors)
        return qx.ravel()[self._order], qy.ravel()[self._order]

    @property
    def _blocks(self) -> int:
        return -(-self.slab.mobile // self.force_constants.coupled_layers)

    def _block(self, block: int, other: int) -> Complex:
        """H of a block, or U between it and the next one; shape (waves, 3b, 3b)."""
        return block_of(self.force_constants, block, other, *self._waves, self.slab.mobile)

    @cached_property
    def _chain(self) -> _Chain:
        count, constants = self._blocks, self.force_constants
        surface_blocks = min(count, -(-constants.depth // constants.coupled_layers))
        couplings: dict[int, Complex] = {}
        surface: list[Complex] = []
        bulk: list[Complex] = []
        home = inverse = steady = _inverse(self._block(count - 1, count - 1))
        moving = len(inverse)
        (surface if count == surface_blocks else bulk).append(inverse)
        for block in reversed(range(count - 1)):
            at_surface = block < surface_blocks
            # All blocks of the bulk are alike, but what they couple to may hold layers of the base.
            if at_surface or block >= count - 3:
                couplings[block] = self._block(block, block + 1)
                home = self._block(block, block) if at_surface or block == count - 2 else home
            down = couplings.get(block, couplings[min(couplings)])
            if at_surface:
                inverse = _inverse(home - down @ inverse @ _adjoint(down))
                surface.append(inverse)
                continue
            down, below = down[:moving], inverse[:moving]
            above = _inverse(home[:moving] - down @ below @ _adjoint(down))
            change = np.abs(above - below).max(axis=(1, 2)) / np.abs(above).max(axis=(1, 2))
            # A converged wave has the same matrix in this block and in all above.
            inverse = np.concatenate([above, inverse[moving:]])
            moving = 1 + int(np.flatnonzero(change > _STEADY).max(initial=0))
            bulk.append(inverse[:moving].copy())
            steady = inverse
        return _Chain(tuple(surface[::-1]), tuple(bulk[::-1]), steady, couplings)

    @cached_property
    def compliance_q(self) -> Complex:
        """G_q: displacement of surface atoms per force on them, shape (nx, ny//2+1, 3, 3), in 1/(E* a0)."""
        chain = self._chain
        unit = np.zeros((self._order.size, 3 * self.force_constants.coupled_layers, 3), dtype=np.complex128)
        unit[:, :3] = np.eye(3)
        return self._unsorted(chain.solve(0, unit)[:, :3])

    @cached_property
    def stiffness_q(self) -> Real:
        """K_q = 1/G_zz: traction per displacement without lateral traction, shape (nx, ny//2+1), in E*/a0.

        The mean compresses the slab evenly: K_0 is about C11/depth.

        Raises
        ------
        PotentialError
            If the slab is not stable.
        """
        if self.table is not None:
            return self.table
        stiffness: Real = 1 / self.compliance_q[..., 2, 2].real
        if not (np.isfinite(stiffness).all() and (stiffness > 0).all()):
            bad = np.argwhere(~(stiffness > 0))
            msg = f"the slab is not stable: its surface has no stiffness for {len(bad)} waves, e.g. q = {bad[0]}"
            raise PotentialError(msg)
        stiffness.flags.writeable = False
        return stiffness

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum of a grid, which must be the slab's.

        Raises
        ------
        ArgumentError
            If it is another grid.
        """
        if instance("grid", grid, Grid) != self.slab.grid:
            raise ArgumentError("grid", grid, f"the grid of the slab, {self.slab.grid}")
        return np.array(self.stiffness_q)

    def tabulated(self, source: str) -> TabulatedSubstrate:
        """K_q as a table for :mod:`continuum`."""
        instance("source", source, str, "where the table comes from, a text")
        return TabulatedSubstrate(self.stiffness_q, self.slab.grid.lengths, source)

    @property
    def kept(self) -> float:
        """Part of the matrices S_l^-1 of all blocks and waves that had to be stored."""
        chain = self._chain
        held = sum(map(len, (*chain.surface, *chain.bulk))) + len(chain.steady)
        return held / (self._blocks * len(chain.steady))

    def displacements_of_surface_force(self, force_z: Real) -> Real:
        """Displacements of all atoms under a vertical force on each surface atom.

        Parameters
        ----------
        force_z : shape (nx, ny), positive upwards (minus traction x a0²), in E* a0².

        Returns
        -------
        Real
            Shape (layers, nx, ny, 3), in a0, from where the slab is at rest; zero in the frozen layers.
        """
        forces = np.zeros((1, *self.slab.shape, 3))
        forces[0, ..., 2] = field_of("force_z", force_z, self.slab.shape)
        return self.displacements(forces)

    def displacements(self, forces: Real) -> Real:
        """Displacements of all atoms under given forces, by the inverse of the Hessian of the slab.

        Parameters
        ----------
        forces : shape (n, nx, ny, 3) for the uppermost n layers, in E* a0²; those on frozen atoms are ignored.

        Returns
        -------
        Real
            Shape (layers, nx, ny, 3), in a0, from where the slab is at rest; zero in the frozen layers.

        Raises
        ------
        ValueError
            If the shape of the forces does not fit the slab.
        """
        slab, chain, b = self.slab, self._chain, self.force_constants.coupled_layers
        given = array("forces", forces)
        if given.shape[1:] != (*slab.shape, 3) or not 1 <= given.shape[0] <= slab.layers:
            allowed = f"the shape (n, {slab.shape[0]}, {slab.shape[1]}, 3) with n from 1 to {slab.layers}"
            raise ArgumentError("forces", given, allowed)
        field_of("forces", given, given.shape)

        # From below: the load of each block, with what the blocks below it pass on.
        spectra = self._forward(forces[: slab.mobile])
        loads: list[Complex] = []
        for block in reversed(range(-(-len(spectra) // b))):
            load = np.zeros((self._order.size, 3 * b, 1), dtype=np.complex128)
            for layer in self._layers(block):
                if layer < len(spectra):
                    at = 3 * (layer - block * b)
                    load[:, at : at + 3, 0] = spectra[layer].T
            if loads:
                load -= chain.coupling(block) @ chain.solve(block + 1, loads[-1])
            loads.append(load)

        # From above: each block follows the one over it.
        spectra = np.empty((slab.mobile, 3, self._order.size), dtype=np.complex128)
        u: Complex | None = None
        for block in range(self._blocks):
            load = loads.pop() if loads else np.zeros((self._order.size, 3 * b, 1), dtype=np.complex128)
            if u is not None:
                load = load - _adjoint(chain.coupling(block - 1)) @ u
            u = chain.solve(block, load)
            for layer in self._layers(block):
                at = 3 * (layer - block * b)
                spectra[layer] = u[:, at : at + 3, 0].T
        result = np.zeros((slab.layers, *slab.shape, 3))
        result[: slab.mobile] = self._inverse(spectra)
        return result

    def _layers(self, block: int) -> Iterator[int]:
        b = self.force_constants.coupled_layers
        yield from range(block * b, min((block + 1) * b, self.slab.mobile))

    @cached_property
    def _shift(self) -> Complex:
        """exp(iq.s) of the shift s = (a0/2, a0/2) of the odd layers, shape (nx, ny//2+1)."""
        qx, qy = self.slab.grid.wavevectors
        shift: Complex = np.exp(0.5j * (qx + qy))
        return shift

    def _forward(self, vectors: Real) -> Complex:
        """Amplitudes, shape (n, 3, waves), of the vectors at the atoms of the uppermost n layers, (n, nx, ny, 3)."""
        spectra = np.empty((len(vectors), 3, *self.slab.grid.shape_q), dtype=np.complex128)
        fourier.rows_forward(np.ascontiguousarray(np.moveaxis(vectors, 3, 1)), spectra)
        fourier.columns_forward(spectra)
        spectra[1::2] *= self._shift.conj()
        return spectra.reshape(*spectra.shape[:2], -1)[..., self._order]

    def _inverse(self, amplitudes: Complex) -> Real:
        """Vectors at the atoms of the uppermost layers, shape (n, nx, ny, 3)."""
        n, waves = len(amplitudes), np.empty_like(amplitudes)
        waves[..., self._order] = amplitudes
        spectra, vectors = waves.reshape(n, 3, *self.slab.grid.shape_q), np.empty((n, 3, *self.slab.shape))
        spectra[1::2] *= self._shift
        fourier.columns_inverse(spectra)
        fourier.rows_inverse(spectra, vectors)
        return np.moveaxis(vectors, 1, 3)

    def _unsorted(self, values: Complex) -> Complex:
        """Values at the sorted waves, back on the half spectrum."""
        result = np.empty_like(values)
        result[self._order] = values
        return result.reshape(*self.slab.grid.shape_q, *values.shape[1:])


def block_of(constants: ForceConstants, block: int, other: int, qx: Real, qy: Real, mobile: float = np.inf) -> Complex:
    """H of a block of layers, or U between it and the next one, at wavevectors, shape (n,); shape (n, 3b, 3b).

    Layers from ``mobile`` on are held.
    """
    b = constants.coupled_layers
    result = np.zeros((qx.size, 3 * b, 3 * b), dtype=np.complex128)
    for i in range(b):
        for j in range(b):
            up, low = block * b + i, other * b + j
            part = result[:, 3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
            if max(up, low) >= mobile:  # the last block may hold layers of the base: they do not move
                part[:] = np.eye(3) * (up == low)
            elif 0 <= low - up <= b:
                part[:] = constants.blocks(up, low - up, qx, qy)
            elif 0 < up - low <= b:
                part[:] = _adjoint(constants.blocks(low, up - low, qx, qy))
    return result


def half_space_stiffness(constants: ForceConstants, qx: Real, qy: Real) -> Real:
    """K_q = 1/G_zz of the half-space of a crystal at any wavevectors but 0, shape (n,), in E*/a0.

    Every second block is eliminated, again and again, so that the bulk is as deep as 2^k blocks after k steps (Lopez
    Sancho, Lopez Sancho and Rubio, J. Phys. F 15, 851 (1985), Eqs. 11-16).
    """
    top = -(-constants.depth // constants.coupled_layers)
    edge = bulk = block_of(constants, top, top, qx, qy)
    down = block_of(constants, top, top + 1, qx, qy)
    up, change = _adjoint(down), bulk
    while np.abs(change).max() > _STEADY * np.abs(edge).max():
        inverse = _inverse(bulk)
        down_over, up_over = down @ inverse, up @ inverse
        change = down_over @ up
        edge, bulk = edge - change, bulk - change - up_over @ down
        down, up = down_over @ down, up_over @ up
    found = _inverse(edge)
    for block in reversed(range(top)):
        below = block_of(constants, block, block + 1, qx, qy)
        found = _inverse(block_of(constants, block, block, qx, qy) - below @ found @ _adjoint(below))
    return np.asarray(1 / found[:, 2, 2].real)


def require_room(slab: Slab, model: Model) -> None:
    """Check that the slab is larger than the range of forces of a model.

    Raises ArgumentError if its base is thinner than the range of forces, or an atom would interact with its own image.
    """
    width, layers = least_width(model), model.coupled_layers
    if slab.frozen < layers or slab.mobile < layers:
        allowed = (
            f"at least {layers} mobile and as many frozen layers, which forces reach in this crystal, not "
            f"{slab.mobile} and {slab.frozen} ({model.reference})"
        )
        raise ArgumentError("slab", slab, allowed)
    if min(slab.shape) < width:
        allowed = (
            f"at least {width} surface atoms along x and y: forces reach {model.force_range / model.length:.3g} a0 in "
            f"this crystal ({model.reference})"
        )
        raise ArgumentError("slab", slab, allowed)


def _inverse(matrices: Complex) -> Complex:
    return np.linalg.inv(matrices).astype(np.complex128, copy=False)


def _adjoint(matrices: Complex) -> Complex:
    return matrices.conj().swapaxes(-1, -2)


@dataclass(frozen=True, eq=False)
class Discreteness:
    """K_lattice/K_continuum - 1 over the waves of a grid, without its mean."""

    wavelength: Real = field(repr=False)
    """2π/q of each wave, shape (waves,), in a0."""
    angle: Real = field(repr=False)
    """Angle of each wave to <110>, the axis of the surface grid, in radians."""
    difference: Real = field(repr=False)
    """K_lattice/K_continuum - 1 of each wave."""
    along_110: float
    """Limit of difference/q for long waves along <110>, in a0: the difference is linear in q."""
    along_100: float
    """Limit of difference/q for long waves along <100>, in a0."""

    def worst(self, wavelength: float) -> float:
        """Largest difference, with its sign, over the directions of waves of about this length.

        Raises ValueError if there is no such wave.
        """
        near = self.difference[np.abs(self.wavelength / wavelength - 1) < _ALIKE]
        if near.size == 0:
            raise ValueError(f"this grid has no wave of {wavelength} a0")
        return float(near[np.argmax(np.abs(near))])


def discreteness(response: LatticeResponse, constants: CubicConstants) -> Discreteness:
    """Compare a lattice with the cubic layer of its depth and elastic constants, in E*.

    Raises ValueError if the grid is too small for the long waves that the limit is read from.
    """
    grid, depth = response.slab.grid, response.slab.depth
    layer = CubicLayer(depth, constants, constants.c11 / depth).stiffness(grid)
    qx, qy = np.broadcast_arrays(*grid.wavevectors)
    q = grid.wavenumber.ravel()[1:]
    angle = np.arctan2(qy, qx).ravel()[1:]
    difference = (response.stiffness_q / layer - 1).ravel()[1:]
    # Not the very longest, which feel that the base lies a small fraction of a0 from where the continuum has it.
    fitted = (2 * np.pi / q >= _LONG) & (q * depth > 4)
    if np.count_nonzero(fitted) < 20:
        raise ValueError(f"a slab {response.slab.shape} has too few long waves: take 48 x 48 surface atoms or more")
    powers = q[fitted, None] ** np.arange(3)
    of_angle = np.stack([np.ones(fitted.sum()), np.cos(4 * angle[fitted])], axis=1)
    basis = (powers[:, :, None] * of_angle[:, None, :]).reshape(fitted.sum(), -1)
    found = np.linalg.lstsq(basis, difference[fitted] / q[fitted])[0]
    return Discreteness(2 * np.pi / q, angle, difference, float(found[0] + found[1]), float(found[0] - found[1]))
