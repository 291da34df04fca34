"""The substrate of an input: its atoms, their interatomic model and linear response."""

from dataclasses import dataclass
from functools import cached_property, singledispatch
from typing import Any, Self, cast

import numpy as np

from atomistic.crystal.crystal import AnySlab, AtomSlab, Slab
from atomistic.crystal.model import AnyCrystalModel, AnyModel, Model, check_model
from atomistic.inputs.crystal import CrystalTable
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.validate import ValidateConfig
from atomistic.lammps.deck import Deck
from atomistic.lammps.session import Session
from atomistic.relax.relax import lattice_start
from atomistic.response.bulk import at_rest, slab_of_table
from atomistic.response.cache import default_folder, response_key, stored_response
from atomistic.response.lattice import LatticeResponse, require_room
from atomistic.response.material import model_of
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.tables import Fault
from continuum.inputs.toml import refuse
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates import TabulatedSubstrate
from continuum.model.walls import LennardJonesSpline, Wall
from continuum.store.datasets import Attribute
from continuum.store.granted import granted_memory

BYTES, BYTES_PER_ATOM = 2.5e8, 1600
"""Memory of a process: that of the libraries, and roughly that of each atom."""


@dataclass(frozen=True, eq=False)
class Specimen:
    """A slab of a crystal and its response."""

    model: Model
    response: LatticeResponse

    @property
    def slab(self) -> Slab:
        return self.response.slab

    @property
    def rise(self) -> Real:
        """Rise of each layer at rest above its lattice sites, in a0."""
        return self.response.rise

    @cached_property
    def session(self) -> Session:
        """LAMMPS on these atoms, as long as the specimen is kept."""
        flat, away = np.zeros(self.slab.shape), self.slab.depth  # room above the surface for what adhesion lifts
        return Session.on_atoms_of(Deck(self.slab, self.model, LennardJonesSpline(0.0), flat, away, rise=self.rise))

    def start(self, wall: Wall, gap: Real) -> Real:
        """Displacements of the lattice at the equilibrium with this gap, shape (layers, nx, ny, 3), in a0."""
        return lattice_start(self.response, wall, gap)

    @classmethod
    def of_slab(cls, slab: Slab, model: Model) -> Self:
        """A slab that was checked (:func:`slab_under`); a response that must be measured is kept on disk."""
        # Springs need no measurement, so that nothing is stored for them.
        if model.harmonic:
            return cls(model, LatticeResponse.of_model(slab, model))
        return cls(model, stored_response(slab, model, default_folder()))

    @classmethod
    def of_model(cls, model: Model, grid: Grid, depth: float) -> Self:
        """The slab under a grid; see :func:`slab_under`."""
        return cls.of_slab(slab_under(model, grid, depth), model)

    def about(self) -> dict[str, Attribute]:
        """Description stored with results; lengths and energies in LAMMPS' units of the model."""
        model, constants = self.model, self.response.force_constants
        checks = {} if constants.checks is None else vars(constants.checks)
        return {
            "model/reference": model.reference,
            "model/units": model.units,
            "model/a0": model.length,
            "model/contact_modulus": model.energy / model.length**3,
            **{
                f"model/{name}": value
                for name, value in zip(("c11", "c12", "c44"), model.elastic_constants, strict=True)
            },
            "model/surface_relaxation": float(self.response.rise[0]),
            "model/layers_reached": constants.coupled_layers,
            "model/response_key": response_key(self.slab, model),
            **{f"model/violation of {name}": value for name, value in checks.items()},
        }


def slab_under(model: Model, grid: Grid, depth: float) -> Slab:
    """The slab under a grid, on a base as thick as the range of forces.

    Raises ArgumentError if the spacing of the grid is not a0, forces reach further than the slab, or it does not fit
    into memory.
    """
    slab = Slab.of_depth(grid, depth, model.coupled_layers)
    require_room(slab, model)
    _require_memory(slab, depth)
    return slab


def _require_memory(slab: AnySlab, depth: float) -> None:
    needed, available = BYTES + BYTES_PER_ATOM * slab.size, granted_memory()
    if needed > available:
        allowed = f"a slab that needs at most the {available / 1e9:.3g} GB of this machine, not {needed / 1e9:.3g}"
        raise ArgumentError("depth", depth, allowed)


@dataclass(frozen=True, eq=False)
class AnySpecimen:
    """A slab below any face, at rest, with the response of the half-space of its crystal and its own mean stiffness."""

    model: AnyCrystalModel
    slab: AtomSlab
    response: TabulatedSubstrate
    rise: None = None

    def start(self, wall: Wall, gap: Real) -> Real:
        """Displacements to start from: the slab at rest."""
        return np.zeros(self.slab.positions.shape)


@singledispatch
def specimen_under(model: AnyModel, slab: Any) -> Specimen | AnySpecimen:
    """The substrate of a slab and its model; a surface is relaxed."""
    return Specimen.of_slab(slab, check_model("model", model))


@specimen_under.register
def _(model: AnyCrystalModel, slab: AtomSlab) -> AnySpecimen:
    slab, model = at_rest(slab, model)
    table = model.stiffness_q(slab.grid, slab.depth)
    return AnySpecimen(model, slab, TabulatedSubstrate(table, slab.grid.lengths, f"the half-space below {slab.name}"))


def slab_of(config: ValidateConfig | DeckConfig, model: AnyModel) -> AnySlab:
    """The slab of an input, of a crystal that has been measured.

    Raises ConfigError in the cases of :func:`slab_under`.
    """
    try:
        return _slab(model, config)
    except ArgumentError as error:
        if error.name == "depth":
            cause = "too many atoms, n² on each layer" if config.slab.points[0] else ""
            raise refuse(config, Fault(("slab", "depth"), error.allowed, cause)) from None
        if error.name == "atoms":
            raise refuse(config, Fault(("crystal", "atoms"), error.allowed)) from None
        cause = "a cell made for springs, which reach one layer only"
        raise refuse(config, Fault(("slab",), error.allowed, cause)) from None


@singledispatch
def _slab(model: AnyModel, config: ValidateConfig | DeckConfig) -> AnySlab:
    return slab_under(check_model("model", model), Grid(config.slab.points, config.slab.lengths), config.slab.depth)


@_slab.register
def _(model: AnyCrystalModel, config: DeckConfig) -> AnySlab:
    return slab_below(model, config.crystal, config.grid.lengths, config.slab.depth)


def slab_below(model: AnyCrystalModel, crystal: CrystalTable, lengths: tuple[float, float], depth: float) -> AtomSlab:
    """The slab of a table [crystal] other than fcc(100), about as wide as periods in a0, in whole cells.

    Raises ArgumentError if forces reach through the base of given atoms, or it does not fit into memory.
    """
    slab = slab_of_table(crystal, model, lengths, depth)
    _require_memory(slab, depth)
    return slab


def specimen_of(config: ValidateConfig) -> Specimen:
    """The substrate of an input.

    Raises ConfigError if forces reach further than its slab, or it does not fit into memory; PotentialError if the
    crystal of the potential is not a stable fcc one; LammpsError if LAMMPS fails.
    """
    model = model_of(config.interatomic.potential())
    return Specimen.of_slab(cast(Slab, slab_of(config, model)), model)
