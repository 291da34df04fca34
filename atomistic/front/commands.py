"""What the command ``atomistic`` does, as functions: one for each of its sub-commands."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import atomistic.ladder.validate
import atomistic.lammps.deck
import atomistic.relax.deckrun
from atomistic.config import DeckConfig, ElasticConfig, Steps, ValidateConfig, steps_of
from atomistic.crystal.elastic import ContactModulus
from atomistic.crystal.interatomic import Model, Potential
from atomistic.ladder.validate import Progress
from atomistic.lammps.directory import write_deck
from atomistic.lammps.doctor import Doctor
from atomistic.lammps.doctor import doctor as look
from atomistic.lammps.engine import command_words, runner
from atomistic.lammps.shape import Shape, shape_of
from atomistic.relax.deckrun import ContinuumStep, read_run
from atomistic.relax.relax import deck_of, deck_under
from atomistic.response.discreteness import Discreteness, discreteness
from atomistic.response.lattice import LatticeResponse
from atomistic.response.material import model_of
from continuum.errors import InputError
from continuum.files.inputs import load
from continuum.files.output import folder
from continuum.files.toml import Source, find
from continuum.front.contact import Contact
from continuum.show.sheet import Sheet, pairs

__all__ = [
    "Deck", "DeckRun", "Elastic", "Validation", "check", "deck", "doctor", "elastic", "read", "run_deck", "validate",
]  # fmt: skip

MOST_WORKERS = 4
"""Processes of a validation, if their number is not given: each holds a slab."""


class Validation(atomistic.ladder.validate.Validation):
    """A finished validation; see :class:`atomistic.ladder.validate.Validation`."""

    def budget(self) -> Sheet:
        """The error budget: what each step of the ladder costs."""
        from atomistic.show.validation import budget_sheet

        return budget_sheet(self.stored)

    def sheets(self) -> list[Sheet]:
        """Budget, scaling laws, jumps, verdicts."""
        from atomistic.show.validation import validation_sheets

        return validation_sheets(self)

    @property
    def sentence(self) -> str:
        """How many bounds hold."""
        from atomistic.show.validation import sentence

        return sentence(self.verdicts)

    def write(self) -> list[Path]:
        """Draw the figures and write the page, beside the file; returns the page and the PNG files."""
        from atomistic.show.validation import write

        return write(self)

    def _repr_html_(self) -> str:
        return f"<p>{self.sentence}</p>{self.budget()._repr_html_()}"


class Deck(atomistic.lammps.deck.Deck):
    """A slab under a wall, ready for LAMMPS; see :class:`atomistic.lammps.deck.Deck`."""

    def write(self, directory: str | Path) -> Path:
        """Write it into a directory, which a stock ``lmp -in in.contact`` runs if :attr:`stock`; returns it.

        Raises
        ------
        OutputError
            If the directory holds anything but an earlier deck, or cannot be written to.
        """
        return write_deck(Path(directory), self)


class DeckRun(atomistic.relax.deckrun.DeckRun):
    """What a run of a deck left behind; see :class:`atomistic.relax.deckrun.DeckRun`."""

    def sheets(self, *, compare: bool = False) -> list[Sheet]:
        """Its steps, the last in detail, and the continuum of the same wall beside them, or why there is none."""
        from atomistic.show.decks import run_sheets

        return run_sheets(self, self._beside(compare), self.incomparable if compare else "")

    def _beside(self, compare: bool) -> tuple[ContinuumStep, ...]:
        return self.compare() if compare and not self.incomparable else ()

    def write(self, folder: str | Path, *, compare: bool = False) -> list[Path]:
        """Write ``NAME.h5``, its figures and the wall of each step as a mesh; returns HDF5, PNG and VTK files.

        Raises
        ------
        OutputError
            If they cannot be written there.
        """
        from atomistic.show.decks import write_run

        return write_run(self, Path(folder), self._beside(compare))

    def _repr_html_(self) -> str:
        return "".join(sheet._repr_html_() for sheet in self.sheets())


def validate(
    file: str | Path | ValidateConfig,
    output: str | Path = "results",
    *,
    workers: int | None = None,
    decks: str | Path | None = None,
    lmp_command: str | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> Validation:
    """Press the walls of an input on Green's functions and on atoms, and judge every bound.

    Parameters
    ----------
    file : input (TOML), or one that was loaded; ``inputs/...`` finds those that come with the package.
    output : folder of the result, which is named after the input, or the file itself, ``NAME.h5``.  What it holds is
        kept.
    workers : processes, one core each; all cores, at most 4, if None.
    decks : folder that keeps every LAMMPS deck.
    lmp_command : how a site starts its own LAMMPS, as ``"srun lmp"``.
    force : start anew.
    progress : called after each path with what it gave, how many are done and how many there are.

    Raises
    ------
    ConfigError, StoreError, LammpsError, ValidationError
        If the input cannot be run, the result not be stored, or a path not be compared.
    """
    config = file if isinstance(file, ValidateConfig) else load(file, ValidateConfig)
    command_words(lmp_command)
    if decks is not None:
        folder(decks)
    path = Path(output)
    if path.suffix != ".h5":
        path = path / f"{config.source.path.stem if config.source else 'validation'}.h5"
    found = atomistic.ladder.validate.validate(
        config,
        path,
        workers=min(MOST_WORKERS, os.cpu_count() or 1) if workers is None else workers,
        decks=None if decks is None else Path(decks),
        lmp_command=lmp_command,
        force=force,
        progress=progress,
    )
    return Validation(**vars(found))


def deck(
    contact: Contact | str | Path | DeckConfig,
    model: Potential | None = None,
    *,
    separation: float | None = None,
    separations: Sequence[float] = (),
    pressures: Sequence[float] = (),
    protocol: Mapping[str, Any] | None = None,
    depth: float | None = None,
    follows: Literal["site", "atom"] | Shape = "site",
) -> Deck:
    """A LAMMPS deck: of a contact of your own, or of an input file.

    Parameters
    ----------
    contact : its wall and heights, one for each surface atom, are those of the deck; or an input (TOML).
    model : what holds the atoms together; springs if None.
    separation : of the wall's zero from the surface at rest, in a0: one equilibrium.
    separations : several, visited in this order, each from the equilibrium before: approach and retraction.
    pressures : mean pressures, in E*, met one after the other by moving the wall.
    protocol : the table [protocol] of an input, of any kind: ``{"kind": "velocity", "temperature": 1e-4, ...}``.
    depth : of the slab, in a0; its width if None.
    follows : where the height above an atom is taken: above its lattice site, or where it is ("atom"), and then the
        force is lateral, too.  Between the sites the heights are the sum of their waves where these are few, else a
        spline, which no stock LAMMPS knows; or a shape with a formula, whose heights they are.

    Raises
    ------
    ConfigError, ValueError, TypeError, NotConvergedError
        If the input is at fault, the parts do not fit one another, or the lattice has no equilibrium there to start
        from.
    """
    if isinstance(contact, Contact):
        shape = shape_of(contact.problem.heights) if follows == "atom" else None if follows == "site" else follows
        made = deck_under(contact.problem, model, _steps(separation, separations, pressures, protocol), depth, shape)
    else:
        config = contact if isinstance(contact, DeckConfig) else load(contact, DeckConfig)
        made = deck_of(config)
    return Deck(**vars(made))


def _steps(
    separation: float | None,
    separations: Sequence[float],
    pressures: Sequence[float],
    protocol: Mapping[str, Any] | None,
) -> Steps:
    given = (separation is not None, bool(len(separations)), bool(len(pressures)), protocol is not None)
    if sum(given) != 1:
        msg = (
            "a deck needs one of separation=1.2, separations=[1.3, 1.2, 1.3], pressures=[0.01, 0.02] and "
            'protocol={"kind": "velocity", ...}'
        )
        raise InputError(msg)
    if protocol is not None:
        return steps_of(protocol)
    if separation is not None:
        return Steps("separation", (float(separation),), single=True)
    if len(separations):
        return Steps("separation", tuple(map(float, separations)))
    return Steps("mean-pressure", tuple(map(float, pressures)))


def read(directory: str | Path) -> DeckRun:
    """What a run of a deck found, step by step, and whether these are equilibria.

    Raises
    ------
    DeckError
        If there is no complete result.
    """
    return DeckRun(**vars(read_run(Path(directory))))


def run_deck(
    directory: str | Path, lmp_command: str | None = None, progress: Callable[[int, int], None] | None = None
) -> DeckRun:
    """Run the deck of a directory, in this process or by the command of a site, and read what it found.

    Steps of a protocol that are finished stay as they are; ``progress`` is called after each with how many there are.

    Raises
    ------
    LammpsError
        If LAMMPS cannot be started or fails.
    """
    runner(lmp_command, progress)(Path(directory))
    return read(directory)


@dataclass(frozen=True, eq=False)
class Elastic:
    """The crystal of an interatomic model, measured."""

    model: Model
    modulus: ContactModulus
    response: LatticeResponse | None = field(repr=False)
    """Of a slab, if it was asked for."""
    discreteness: Discreteness | None = field(repr=False)
    """How that tends to the continuum."""

    def sheets(self) -> list[Sheet]:
        """The constants; and the lattice beside the continuum."""
        from atomistic.show.crystal import crystal_sheet, lattice_sheet

        sheets = [crystal_sheet(self.model)]
        if self.response is not None and self.discreteness is not None:
            sheets.append(lattice_sheet(self.response, self.discreteness))
        return sheets

    def plot(self, folder: str | Path, name: str) -> list[Path]:
        """Draw its figures into a folder; returns the PNG files."""
        from atomistic.show.figures import draw_contact_modulus, draw_discreteness

        folder = Path(folder)
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
    lattice : also the lattice Green's function of so many surface atoms a side, as many a0 deep.

    Raises
    ------
    ConfigError, PotentialError, LammpsError, ValueError
        If the crystal is no stable fcc one, LAMMPS fails, or the slab is too small to be told from the continuum.
    """
    from atomistic.response.cache import slab_response

    potential = load(file, ElasticConfig).interatomic.potential() if isinstance(file, str | Path) else file
    model = model_of(potential)
    modulus = ContactModulus.of(model.elastic_constants)
    if lattice is None:
        return Elastic(model, modulus, None, None)
    response = slab_response(model, lattice)
    return Elastic(model, modulus, response, discreteness(response, model.elastic_constants))


def check(file: str | Path) -> Sheet:
    """Validate an input of any command of ``atomistic``, and say what it will cost.

    Raises
    ------
    ConfigError
        With all faults of the file.
    """
    from atomistic.ladder.cost import cost_of_deck, cost_of_validation

    tables = Source.read(find(file)).data
    if "case" in tables:
        cost, kind = cost_of_validation(load(file, ValidateConfig)), "atomistic validate"
    elif "wall" in tables or "surface" in tables:
        cost, kind = cost_of_deck(load(file, DeckConfig)), "atomistic deck"
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
    ]
    return pairs(f"{file}: valid", rows)


def doctor() -> Doctor:
    """Is LAMMPS usable here, which one, and if not what to do."""
    return look()
