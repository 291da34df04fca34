"""The LAMMPS deck: a slab under a rigid rough wall, and what is done to it; checked before anything is written."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Model, check_model
from atomistic.lammps.crystal_wall import crystal_wall
from atomistic.lammps.law import TOLERANCE, native_law
from atomistic.lammps.protocol import Protocol
from atomistic.lammps.shape import Shape, check_shape, misfit
from continuum.arguments import ArgumentError, choice, count, file_name, flag, instance, number
from continuum.arguments import field as field_of
from continuum.model.fourier import Real
from continuum.model.walls import Wall

WallForce = Literal["formulas", "plugin", "atoms"]
"""By what a wall acts: formulas of LAMMPS, the plugin of a map, or the atoms of a rigid crystal."""


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
    wall_tolerance : of the tractions of a wall that is a table, relative to its largest tension, or to the traction
        where that is larger.
    wall_force : whether formulas of LAMMPS make the force of the wall, or a plugin, built for the installed one; or
        "atoms": the wall is a rigid crystal, cut along the shape, whose atoms act by a pair law
        (:mod:`atomistic.lammps.crystal_wall`).
    rise : by how much each layer of the slab at rest lies above its lattice sites, shape (layers,), in a0: the surface
        of most crystals relaxes.  None for springs, which do not.
    protocol : the steps; one equilibrium at the separation if None.
    shape : the wall as a function of the position, which the force of the wall on an atom then follows, sideways too;
        its heights at the sites are ``heights``.  A function of the lattice site if None, the paper's choice.
    notes : where the heights come from, line by line; they are written beside the deck, into no script.
    source : text of the input that it is of, written beside the deck; none if empty.
    stiffness : K_q of the slab, shape ``slab.grid.shape_q``, in E*/a0, of the continuum that is put beside a run; an
        isotropic half-space if None.

    Raises
    ------
    ArgumentError
        If the parts do not fit one another or a number is not allowed.
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
    wall_tolerance: float = TOLERANCE
    wall_force: WallForce = "formulas"
    rise: Real | None = field(default=None, repr=False)
    protocol: Protocol | None = None
    shape: Shape | None = None
    notes: tuple[str, ...] = ()
    stiffness: Real | None = field(default=None, repr=False)
    source: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        slab, model = instance("slab", self.slab, Slab), check_model("model", self.model)
        native_law(instance("wall", self.wall, Wall, "a wall law of continuum"))
        if not np.isclose(model.lattice_constant, np.sqrt(2), rtol=1e-12):
            spacing = model.lattice_constant / np.sqrt(2)
            raise ArgumentError("model", model, f"a crystal of the spacing a0 = 1 of the surface grid, not {spacing:g}")
        if slab.frozen < model.coupled_layers:
            allowed = f"at least {model.coupled_layers} frozen layers, which forces reach, not {slab.frozen}"
            raise ArgumentError("slab", slab, allowed)
        self._set_arrays()
        self._check_numbers()

    def write(self, directory: str | Path, *, force: bool = False) -> Path:
        """Write it into a directory, which a stock ``lmp -in in.contact`` runs; returns it.

        Parameters
        ----------
        force : remove finished steps of another deck there; those that this deck reaches by the same steps stay.

        Raises
        ------
        ArgumentError, OutputError
            If that is no name of a directory, it holds anything but an earlier deck, or finished steps of another one,
            or cannot be written to.
        """
        from atomistic.lammps.directory import write_deck

        return write_deck(file_name("directory", directory), self, force=flag("force", force))

    def _set_arrays(self) -> None:
        slab = self.slab
        sites = (slab.layers, *slab.shape)
        _set_array(self, "heights", self.heights, slab.shape)
        start = np.zeros((*sites, 3)) if self.displacements is None else self.displacements
        _set_array(self, "displacements", start, (*sites, 3))
        if self.stiffness is not None:
            _set_array(self, "stiffness", self.stiffness, slab.grid.shape_q)
        _set_array(self, "rise", np.zeros(slab.layers) if self.rise is None else self.rise, (slab.layers,))
        for name in ("displacements", "rise"):
            moved = getattr(self, name)
            if np.any(moved[slab.mobile :]):
                raise ArgumentError(name, moved, f"zero in the frozen base, the lowest {slab.frozen} layers")
        if self.shape is not None and (apart := misfit(check_shape("shape", self.shape), self.heights)):
            raise ArgumentError("shape", self.shape, f"one of these heights; its own differ by up to {apart:.2g} a0")

    def _check_numbers(self) -> None:
        number("separation", self.separation)
        number("tolerance", self.tolerance, above=0)
        count("evaluations", self.evaluations)
        choice("wall_force", self.wall_force, get_args(WallForce))
        if self.wall_force == "atoms":
            if self.shape is None:
                allowed = (
                    '"formulas" or "plugin" where the wall is a function of the lattice site: atoms act where they are'
                )
                raise ArgumentError("wall_force", self.wall_force, allowed)
            crystal_wall(self.wall, self.shape, self.slab.shape)  # which has a work of adhesion
        number("wall_tolerance", self.wall_tolerance, above=0)
        if not (isinstance(self.notes, tuple) and all(isinstance(note, str) for note in self.notes)):
            raise ArgumentError("notes", self.notes, "a tuple of texts")
        instance("source", self.source, str)
        protocol = self.protocol
        if protocol is None:
            return
        instance("protocol", protocol, Protocol, "Separations, MeanPressures or Motion")
        if self.separation != protocol.separations[0]:
            raise ArgumentError("separation", self.separation, f"that of the first step, {protocol.separations[0]}")
        if misfit := protocol.misfit(self.slab.mobile, stays=self.shape is None):
            raise ArgumentError(*misfit)

    @property
    def start(self) -> Real:
        """Displacements to start from, shape (layers, nx, ny, 3), in a0."""
        assert self.displacements is not None
        return self.displacements

    @property
    def rest(self) -> Real:
        """Positions of the atoms at rest without a wall, shape (layers, nx, ny, 3), in a0."""
        assert self.rise is not None
        at = self.slab.positions.copy()
        at[..., 2] += self.rise[:, None, None]
        return at


def _set_array(deck: Deck, name: str, values: Real, shape: tuple[int, ...]) -> None:
    """Keep a private read-only copy of an array, if it is one of finite numbers of the shape wanted."""
    array = np.array(field_of(name, values, shape))
    array.flags.writeable = False
    object.__setattr__(deck, name, array)
