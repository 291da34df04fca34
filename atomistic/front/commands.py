"""The functions behind ``atomistic``, one for each sub-command except those on decks."""

import os
from dataclasses import dataclass, field
from pathlib import Path

from atomistic.config.crystal import ElasticConfig
from atomistic.config.quantities import in_both
from atomistic.config.validate import ValidateConfig
from atomistic.crystal.elastic import ContactModulus
from atomistic.crystal.interatomic import Model, Potential, check_potential
from atomistic.relax.decks import deck_input, parts_of
from atomistic.response.discreteness import Discreteness, discreteness
from atomistic.response.lattice import LatticeResponse
from atomistic.response.material import model_of
from continuum.arguments import count, file_name, instance
from continuum.files.inputs import load
from continuum.files.toml import Source, find
from continuum.show.sheet import Sheet, pairs

LATTICES = 48, 256
"""Fewest and most surface atoms a side of a lattice Green's function: fewer have too few long waves to compare with
the continuum, more take too much memory."""


@dataclass(frozen=True, eq=False)
class Elastic:
    """The crystal of an interatomic model, measured."""

    model: Model
    modulus: ContactModulus
    response: LatticeResponse | None = field(repr=False)
    """Lattice Green's function of a slab, if it was asked for."""
    discreteness: Discreteness | None = field(repr=False)
    """Its convergence to the continuum."""

    def sheets(self) -> list[Sheet]:
        """The constants; and the lattice beside the continuum."""
        from atomistic.show.crystal import crystal_sheet, lattice_sheet

        sheets = [crystal_sheet(self.model)]
        if self.response is not None and self.discreteness is not None:
            sheets.append(lattice_sheet(self.response, self.discreteness))
        return sheets

    def plot(self, folder: str | Path, name: str) -> list[Path]:
        """Draw its figures into a folder, under names that begin with ``name``; returns the PNG files."""
        from atomistic.show.figures import draw_contact_modulus, draw_discreteness

        folder = file_name("folder", folder)
        file_name("name", instance("name", name, str, "a text that names of files begin with"))
        drawn = [draw_contact_modulus(self.modulus, folder / f"{name}-contact-modulus", name)]
        if self.discreteness is not None:
            drawn.append(draw_discreteness(self.discreteness, folder / f"{name}-discreteness", name))
        return drawn

    def _repr_html_(self) -> str:
        return "".join(sheet._repr_html_() for sheet in self.sheets())


def elastic(file: str | Path | Potential, *, lattice: int | None = None) -> Elastic:
    """Lattice constant, elastic constants, E*(100) and surface relaxation of a crystal.

    Parameters
    ----------
    file : input (TOML) with a table [interatomic]; or the interatomic model itself.
    lattice : also compute the lattice Green's function of a slab with this many surface atoms a side, 48 to 256, and
        as many a0 deep.

    Raises
    ------
    ArgumentError, ConfigError, PotentialError, LammpsError
        If an argument is not allowed, the crystal is not a stable fcc one, or LAMMPS fails.
    """
    from atomistic.response.cache import slab_response

    if lattice is not None:
        count("lattice", lattice, *LATTICES)
    if isinstance(file, str | os.PathLike):
        potential = load(file_name("file", file), ElasticConfig).interatomic.potential()
    else:
        potential = check_potential("file", file)
    model = model_of(potential)
    modulus = ContactModulus.of(model.elastic_constants)
    if lattice is None:
        return Elastic(model, modulus, None, None)
    response = slab_response(model, lattice)
    return Elastic(model, modulus, response, discreteness(response, model.elastic_constants))


def check(file: str | Path) -> Sheet:
    """Check an input of any command of ``atomistic``, and estimate its cost.

    Parameters
    ----------
    file : input of validate, deck or elastic (TOML).

    Raises
    ------
    ArgumentError, ConfigError
        If it is not the name of a file; with all faults of the file.
    PotentialError, LammpsError
        If the crystal of a deck, which is measured, is not a stable fcc one, or LAMMPS fails.
    """
    from atomistic.ladder.cost import cost_of_deck, cost_of_validation

    both: list[tuple[str, str]] = []
    tables = Source.read(find(file_name("file", file))).data
    if "case" in tables:
        cost, kind = cost_of_validation(load(file, ValidateConfig)), "atomistic validate"
    elif "wall" in tables or "surface" in tables:
        config = deck_input(file)
        both = list(in_both(tables, parts_of(config).model.real_units))
        cost, kind = cost_of_deck(config), "atomistic deck"
    else:
        load(file, ElasticConfig)
        return pairs(f"{file}: valid", [("for", "atomistic elastic"), ("core-seconds, about", "3")])
    rows = [
        ("for", kind),
        ("atoms, about", f"{cost.atoms}"),
        ("equilibria of atoms", f"{cost.equilibria}"),
        ("evaluations of all forces, about", f"{cost.evaluations}"),
        ("core-seconds, about", f"{cost.seconds:.2g}"),
        ("memory of a process, about", f"{cost.memory / 2**20:.3g} MiB"),
        *both,
    ]
    return pairs(f"{file}: valid", rows)
