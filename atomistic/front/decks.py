"""Decks as functions: written from a contact or an input, run, and read."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, get_args

from atomistic.config.deck import MOST_STEPS, DeckConfig, steps_of
from atomistic.config.motion import LARGEST_PRESSURE, Steps
from atomistic.config.slab import DEEPEST, SHALLOWEST
from atomistic.crystal.interatomic import Potential, Springs, check_potential
from atomistic.lammps.deck import Deck, WallForce
from atomistic.lammps.engine import runner
from atomistic.lammps.shape import Shape, check_shape, shape_of
from atomistic.relax.deckrun import DeckRun, read_run
from atomistic.relax.decks import deck_input, deck_of, deck_under, steps_in_units
from continuum.arguments import ArgumentError, choice, file_name, function, instance, number, several
from continuum.front.contact import Contact


def deck(
    contact: Contact | str | Path | DeckConfig,
    model: Potential | None = None,
    *,
    separation: float | str | None = None,
    separations: Sequence[float | str] | None = None,
    pressures: Sequence[float | str] | None = None,
    protocol: Mapping[str, Any] | None = None,
    depth: float | None = None,
    follows: Literal["site", "atom"] | Shape | None = None,
    wall_force: WallForce | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Deck:
    """A LAMMPS deck: of a contact of your own, or of an input file, which says all else itself.

    Parameters
    ----------
    contact : its wall and heights, one for each surface atom, are those of the deck; or an input (TOML).
    model : what holds the atoms together; springs if None.
    separation : of the wall's zero from the surface at rest, in a0: one equilibrium.  This and what follows may have
        a unit instead, as "2.5Å" or "1GPa", if the crystal has a size.
    separations : several, visited in this order, each from the equilibrium before: approach and retraction.
    pressures : mean pressures, in E*, met one after the other by moving the wall.
    protocol : the table [protocol] of an input, of any kind: ``{"kind": "velocity", "temperature": 1e-4, ...}``.
    depth : of the slab, in a0; its width if None.
    follows : where the height above an atom is taken: above its lattice site ("site", the default), or where it is
        ("atom"), and then the force is lateral, too.  Between the sites the heights are the sum of their waves where
        these are few, else a bicubic spline; or a shape with a formula, whose heights they are.
    wall_force : whether formulas of LAMMPS make the force of the wall, or a plugin, which a C++ compiler builds for the
        installed LAMMPS when the deck is written; or "atoms" of a rigid crystal, cut along heights that follow "atom",
        by a pair law with the work of adhesion of the contact's law; formulas if None.
    progress : called while a crystal is measured at a temperature, about a minute, with how many runs are done and how
        many there are; not at all if that is known.

    Raises
    ------
    TypeError
        If an argument does not belong with an input file, or the law has no formula in LAMMPS.
    ArgumentError, ConfigError, NotConvergedError
        If an argument or the input is at fault, the parts do not fit one another, or the lattice has no equilibrium
        there to start from.
    """
    function("progress", progress)
    steps = {"separation": separation, "separations": separations, "pressures": pressures, "protocol": protocol}
    if isinstance(contact, str | os.PathLike | DeckConfig):
        others = {"model": model, **steps, "depth": depth, "follows": follows, "wall_force": wall_force}
        _require_nothing_else(contact, [name for name, value in others.items() if value is not None])
        read = deck_input(file_name("contact", contact)) if isinstance(contact, str | os.PathLike) else contact
        return deck_of(read, progress)
    instance("contact", contact, Contact, "a continuum.Contact, or the name of an input file")
    if model is not None:
        check_potential("model", model)
    if depth is not None:
        number("depth", depth, least=SHALLOWEST, most=DEEPEST)
    shape: Shape | None = None
    if isinstance(follows, str):
        choice("follows", follows, ("site", "atom"))
        shape = shape_of(contact.problem.heights) if follows == "atom" else None
    elif follows is not None:
        shape = check_shape("follows", follows)
    if wall_force is not None:
        choice("wall_force", wall_force, get_args(WallForce))
    done = _steps(**steps_in_units(steps, model or Springs()))
    return deck_under(contact.problem, model, done, depth, shape, progress, wall_force or "formulas")


def _require_nothing_else(contact: object, names: list[str]) -> None:
    """An input file says all that is said of its deck: what is given beside it would be ignored."""
    if names:
        said = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
        file = f"the input file {str(contact)!r}" if isinstance(contact, str | os.PathLike) else "an input"
        raise TypeError(f"contact is {file}, which says all else itself: leave out {said}, or change the file")


def _steps(**given: Any) -> Steps:
    """What is done, by the one argument that says it."""
    names = [name for name, value in given.items() if value is not None]
    if len(names) != 1:
        what = " and ".join(names) if names else "none of these"
        example = 'separation=1.2, separations=[1.3, 1.2], pressures=[0.01] and protocol={"kind": "velocity", ...}'
        raise ArgumentError("separation", given["separation"], f"exactly one of {example}; here: {what}")
    (name,) = names
    value = given[name]
    if name == "protocol":
        if not isinstance(value, Mapping):
            raise ArgumentError("protocol", value, 'a table, as {"kind": "velocity", ...}')
        return steps_of(value)
    if name == "separation":
        return Steps("separation", (number("separation", value),), single=True)
    if name == "separations":
        return Steps("separation", several("separations", value, longest=MOST_STEPS))
    values = several("pressures", value, longest=MOST_STEPS, least=-LARGEST_PRESSURE, most=LARGEST_PRESSURE)
    if 0 in values:
        raise ArgumentError("pressures", value, "other than zero: a pressure is met to a fraction of itself")
    return Steps("mean-pressure", values)


def read(directory: str | Path) -> DeckRun:
    """Read what a run of a deck found, step by step, and whether these are equilibria.

    Parameters
    ----------
    directory : directory of the deck.

    Raises
    ------
    ArgumentError, DeckError
        If that is no name of a directory, or there is no complete result in it.
    """
    return read_run(file_name("directory", directory))


def run_deck(
    directory: str | Path, lmp_command: str | None = None, progress: Callable[[int, int], None] | None = None
) -> DeckRun:
    """Run the deck of a directory, in this process or by the command of a site, and read what it found.

    Steps of a protocol that are finished stay as they are.

    Parameters
    ----------
    directory : directory of the deck.
    lmp_command : how your site starts LAMMPS, as ``"srun lmp"``; the installed library, in this process, if None.
    progress : called after each step with how many are done and how many there are.

    Raises
    ------
    ArgumentError, LammpsError
        If an argument is not allowed, or LAMMPS cannot be started or fails.
    """
    path = file_name("directory", directory)
    function("progress", progress)
    runner(lmp_command, progress)(path)
    return read(path)
