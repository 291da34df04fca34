"""By what the wall of a deck acts: formulas of LAMMPS, the plugin of a map, or the atoms of a rigid crystal."""

from __future__ import annotations

import numpy as np

from atomistic.lammps.crystal_wall import crystal_text, crystal_wall
from atomistic.lammps.deck import Deck
from atomistic.lammps.language import formatted
from atomistic.lammps.law import NO_CORE
from atomistic.lammps.plugin import (
    CRYSTAL,
    CRYSTAL_LIBRARY,
    CRYSTAL_SOURCE,
    FLAGS,
    LIBRARY,
    MAP,
    SOURCE,
    source,
    wall_map,
)

_BUILT = (
    "LAMMPS needs its package PLUGIN.  Another LAMMPS than that of the machine that wrote this\n"
    f"wants the plugin anew:  mpicxx {' '.join(FLAGS)} -I LAMMPS/src {{}} -o {{}}"
)
_BY = {
    "formulas": {
        "plugin": "",
        "used": "the formulas of in.wall",
        "needs": "No other file and no Python are needed.",
        "pushed": "surface",
    },
    "plugin": {
        "plugin": f"{MAP:13} heights and law of the wall, for the plugin\n{SOURCE:13} the plugin, fix wall/heightmap\n"
        f"{LIBRARY:13} the same, built for the LAMMPS of the machine that wrote this\n",
        "used": MAP,
        "needs": _BUILT.format(SOURCE, LIBRARY),
        "pushed": "surface",
    },
    "atoms": {
        "plugin": f"{CRYSTAL:13} atoms of the wall and their pair law, for the plugin\n{CRYSTAL_SOURCE:13} the plugin, "
        f"fix wall/crystal\n{CRYSTAL_LIBRARY:13} the same, built for the LAMMPS of the machine that wrote this\n",
        "used": CRYSTAL,
        "needs": _BUILT.format(CRYSTAL_SOURCE, CRYSTAL_LIBRARY),
        "pushed": "mobile",
    },
}
"""What the texts of a deck say of formulas, of the plugin and of a wall of atoms, and on which atoms each acts."""


def wall_words(deck: Deck) -> dict[str, str]:
    """What the scripts of a deck say of by what its wall acts, by placeholders."""
    words = dict(_BY[deck.wall_force])
    if deck.wall_force == "plugin":
        words |= {"height": "f_wall[4]", "site": " site d_height" if deck.shape is None else ""}
        words["core"] = formatted(deck.wall.core if np.isfinite(deck.wall.core) else NO_CORE)
    elif deck.wall_force == "atoms":
        words["core"] = formatted(NO_CORE)
    return words


def wall_files(deck: Deck) -> dict[str, str]:
    """Files that the wall of a deck reads, and the source of its plugin: their names and texts."""
    size = deck.slab.shape
    if deck.wall_force == "plugin":
        return {SOURCE: source(), MAP: wall_map(deck.wall, deck.shape, size)}
    if deck.wall_force == "atoms" and deck.shape is not None:
        atoms = crystal_wall(deck.wall, deck.shape, size)
        return {CRYSTAL_SOURCE: source(CRYSTAL_SOURCE), CRYSTAL: crystal_text(atoms, size)}
    return {}
