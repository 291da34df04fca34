"""The LAMMPS deck: a slab under a rigid rough wall, and what is done to it; checked before anything is written."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Model
from atomistic.lammps.law import native_law
from atomistic.lammps.protocol import Motion, Protocol
from atomistic.lammps.shape import Shape
from continuum.model.grid import Real
from continuum.model.walls import Wall

__all__ = ["Deck"]


@dataclass(frozen=True, eq=False)
class Deck:
    """A slab under a rigid rough wall: one equilibrium, or the steps of a protocol.

    Parameters
    ----------
    slab : the atoms.
    model : what holds them together.
    wall : the law between wall and surface, any but the hard wall.
    heights : of the wall above each surface atom, shape ``slab.shape``, in a0.
    separation : of the wall's zero from the surface at rest, in a0; with a protocol, that of its first step.
    displacements : where to start from, shape (layers, nx, ny, 3), in a0; where the slab is at rest if None.
    tolerance : largest force left on a mobile atom, in E* a0².
    evaluations : of the forces, at most, by each minimiser.
    rise : by how much each layer of the slab at rest lies above its lattice sites, shape (layers,), in a0: the surface
        of most crystals relaxes.  None for springs, which do not.
    protocol : the steps; one equilibrium at the separation if None.
    shape : the wall as a function of the position, which the force of the wall on an atom then follows, sideways too;
        its heights at the sites are ``heights``.  A function of the lattice site if None, the paper's choice.
    notes : where the heights come from, line by line; they are written beside the deck, into no script.

    Raises
    ------
    ValueError
        If the parts do not fit one another or a number has no meaning.
    TypeError
        If the law is one that the deck has no formula for.
    """

    slab: Slab
    model: Model
    wall: Wall
    heights: Real = field(repr=False)
    separation: float
    displacements: Real | None = field(default=None, repr=False)
    tolerance: float = 1e-11
    evaluations: int = 20000
    rise: Real | None = field(default=None, repr=False)
    protocol: Protocol | None = None
    shape: Shape | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what no equilibrium can come of, before anything is written."""
        slab, model = self.slab, self.model
        native_law(self.wall)
        if not np.isclose(model.lattice_constant, np.sqrt(2), rtol=1e-12):
            msg = f"the surface grid has the spacing a0 = 1, the crystal {model.lattice_constant / np.sqrt(2)}"
            raise ValueError(msg)
        if slab.frozen < model.reach:
            msg = f"forces reach {model.reach} layers, but only {slab.frozen} are frozen"
            raise ValueError(msg)
        self._set_arrays()
        self._check_numbers()

    def _set_arrays(self) -> None:
        slab = self.slab
        sites = (slab.layers, *slab.shape)
        _set_array(self, "heights", self.heights, slab.shape)
        start = np.zeros((*sites, 3)) if self.displacements is None else self.displacements
        _set_array(self, "displacements", start, (*sites, 3))
        _set_array(self, "rise", np.zeros(slab.layers) if self.rise is None else self.rise, (slab.layers,))
        if np.any(self.start[slab.mobile :]) or np.any(self.rest[slab.mobile :] != slab.positions[slab.mobile :]):
            msg = "atoms of the frozen base cannot be displaced"
            raise ValueError(msg)
        if self.shape is not None:
            x, y = np.moveaxis(slab.positions[0, ..., :2], -1, 0)
            there = self.shape.evaluate(x, y).height
            if not np.allclose(there, self.heights, rtol=0, atol=1e-9 * (1 + float(np.ptp(self.heights)))):
                apart = np.abs(there - self.heights).max()
                msg = f"the shape is not that of the heights: they differ by up to {apart} a0"
                raise ValueError(msg)

    def _check_numbers(self) -> None:
        if self.protocol is not None and self.separation != self.protocol.separations[0]:
            msg = f"the first step is at the separation {self.protocol.separations[0]}, got {self.separation}"
            raise ValueError(msg)
        if isinstance(self.protocol, Motion):
            if not self.protocol.layers < self.slab.mobile:
                msg = f"a thermostat holds less layers than move, {self.slab.mobile}, got {self.protocol.layers}"
                raise ValueError(msg)
            if self.protocol.slides and self.shape is None:
                msg = "a wall that is a function of the lattice site cannot slide: let it follow the atoms"
                raise ValueError(msg)
        if not np.isfinite(self.separation):
            msg = f"the separation is a finite number, got {self.separation}"
            raise ValueError(msg)
        if not (np.isfinite(self.tolerance) and self.tolerance > 0):
            msg = f"the tolerance is a positive finite force, got {self.tolerance}"
            raise ValueError(msg)
        if isinstance(self.evaluations, bool) or self.evaluations != int(self.evaluations) or self.evaluations < 1:
            msg = f"the number of evaluations is a positive integer, got {self.evaluations}"
            raise ValueError(msg)

    @property
    def stock(self) -> bool:
        """Whether a stock LAMMPS runs it; else only this process does."""
        return self.shape is None or self.shape.lines() is not None

    @property
    def start(self) -> Real:
        """Displacements to start from, shape (layers, nx, ny, 3), in a0."""
        assert self.displacements is not None
        return self.displacements

    @property
    def rest(self) -> Real:
        """Where the atoms are at rest without a wall, shape (layers, nx, ny, 3), in a0."""
        assert self.rise is not None
        at = self.slab.positions.copy()
        at[..., 2] += self.rise[:, None, None]
        return at


def _set_array(deck: Deck, name: str, values: Real, shape: tuple[int, ...]) -> None:
    """Keep a private read-only copy of an array, if it is one of finite numbers of the shape wanted."""
    array = np.array(values, dtype=np.float64)
    if array.shape != shape:
        msg = f"{name} of this slab have the shape {shape}, got {array.shape}"
        raise ValueError(msg)
    if not np.isfinite(array).all():
        msg = f"{np.count_nonzero(~np.isfinite(array))} of the {name} are not finite numbers"
        raise ValueError(msg)
    array.flags.writeable = False
    object.__setattr__(deck, name, array)
