"""The LAMMPS deck: a slab under a rigid rough wall, and its protocol, checked before anything is written."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from atomistic.crystal.crystal import Slab
from atomistic.crystal.model import Model, check_model
from atomistic.lammps.crystal_wall import OWN, CrystalWall, WallCrystal, crystal_wall
from atomistic.lammps.law import TOLERANCE, native_law
from atomistic.lammps.protocol import Protocol
from atomistic.lammps.shape import Shape, check_shape, misfit
from continuum.arguments import ArgumentError, choice, count, file_name, flag, instance, number
from continuum.arguments import field as field_of
from continuum.model.fourier import Real
from continuum.model.walls import Wall

WallForce = Literal["formulas", "plugin", "atoms"]
"""How a wall acts: by formulas of LAMMPS, a plugin, or the atoms of a rigid crystal."""


@dataclass(frozen=True, eq=False)
class Deck:
    """A slab under a rigid rough wall: one equilibrium, or the steps of a protocol.

    Parameters
    ----------
    slab : the atoms.
    model : interatomic model.
    wall : law between wall and surface, not a hard wall.
    heights : heights of the wall above each surface atom, shape ``slab.shape``, in a0.
    separation : height of the wall's zero above the surface at rest, in a0; with a protocol, that of its first step.
    displacements : displacements to start from, shape (layers, nx, ny, 3), in a0; the slab at rest if None.
    tolerance : largest force left on a mobile atom, in E* a0².
    evaluations : largest number of force evaluations of each minimiser.
    wall_tolerance : tolerance of the tractions of a tabulated wall, relative to its largest tension, or to the
        traction if that is larger.
    wall_force : "formulas" of LAMMPS, a "plugin" built for the installed LAMMPS, or "atoms" of a rigid crystal that
        follows the shape, with a pair law (:mod:`atomistic.lammps.crystal_wall`).
    wall_crystal : the crystal of a wall of atoms; that of the substrate, cut, if not given.
    rise : height of each layer of the slab at rest above its lattice sites, shape (layers,), in a0, by surface
        relaxation; None for springs, which do not relax.
    protocol : the steps; one equilibrium at the separation if None.
    shape : the wall as a function of the position, which gives a lateral force, too; its heights at the sites are
        ``heights``.  None for a function of the lattice site, the paper's choice.
    notes : lines about the origin of the heights, which are written beside the deck, not into a script.
    source : text of its input, which is written beside the deck; empty for none.
    stiffness : K_q of the slab, shape ``slab.grid.shape_q``, in E*/a0, for the comparison with the continuum; an
        isotropic half-space if None.

    Raises
    ------
    ArgumentError
        If the parts do not fit together, or a number is not allowed.
    TypeError
        If LAMMPS has no formula for the law.
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
    wall_crystal: WallCrystal = OWN
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
        """Write the deck into a directory, in which a stock ``lmp -in in.contact`` runs it; returns the directory.

        Parameters
        ----------
        force : remove finished steps of another deck there; those that this deck reaches by the same steps stay.

        Raises
        ------
        ArgumentError, OutputError
            If it is not the name of a directory, has files other than an earlier deck, or finished steps of another
            deck, or cannot be written to.
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
            instance("wall_crystal", self.wall_crystal, WallCrystal)
            crystal_wall(self.wall, self.shape, self.slab.shape, self.wall_crystal)  # or what it cannot be is said
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

    @cached_property
    def crystal(self) -> CrystalWall | None:
        """The atoms of the wall; None if it has none."""
        if self.wall_force != "atoms" or self.shape is None:
            return None
        return crystal_wall(self.wall, self.shape, self.slab.shape, self.wall_crystal)

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
    """Keep a private read-only copy of an array after checking its shape and that it is finite."""
    array = np.array(field_of(name, values, shape))
    array.flags.writeable = False
    object.__setattr__(deck, name, array)
