"""How the wall of a deck acts: by formulas of LAMMPS, a plugin, or the atoms of a rigid crystal."""

from __future__ import annotations

import numpy as np

from atomistic.lammps.crystal_wall import crystal_text, crystal_wall
from atomistic.lammps.deck import Deck
from atomistic.lammps.language import formatted
from atomistic.lammps.law import NO_CORE
from atomistic.lammps.plugin import CRYSTAL, FLAGS, HEIGHTMAP, PLUGINS, wall_map

_FORMULAS = {
    "plugin": "",
    "used": "the formulas of in.wall",
    "needs": "No other file and no Python are needed.",
    "pushed": "surface",
}


def wall_words(deck: Deck) -> dict[str, str]:
    """Placeholders for how the wall of a deck acts, and on which atoms."""
    plugin = PLUGINS.get(deck.wall_force)
    if plugin is None:
        return _FORMULAS
    words = {
        "plugin": f"{plugin.data:13} {plugin.holds}, for the plugin\n"
        f"{plugin.source:13} the plugin, fix wall/{plugin.name}\n"
        f"{plugin.library:13} the same, built for the LAMMPS of the machine that wrote this\n",
        "used": plugin.data,
        "needs": "LAMMPS needs its package PLUGIN.  Another LAMMPS than that of the machine that wrote this\n"
        f"wants the plugin anew:  mpicxx {' '.join(FLAGS)} -I LAMMPS/src {plugin.source} -o {plugin.library}",
        "pushed": plugin.pushed,
        "core": formatted(NO_CORE),
    }
    if plugin is HEIGHTMAP:
        words |= {"height": "f_wall[4]", "site": " site d_height" if deck.shape is None else ""}
        words["core"] = formatted(deck.wall.core if np.isfinite(deck.wall.core) else NO_CORE)
    return words


def wall_files(deck: Deck) -> dict[str, str]:
    """Names and texts of the files that the wall of a deck reads, and of the source of its plugin."""
    size = deck.slab.shape
    if deck.wall_force == "plugin":
        return {HEIGHTMAP.source: HEIGHTMAP.text(), HEIGHTMAP.data: wall_map(deck.wall, deck.shape, size)}
    if deck.wall_force == "atoms" and deck.shape is not None:
        atoms = crystal_wall(deck.wall, deck.shape, size)
        return {CRYSTAL.source: CRYSTAL.text(), CRYSTAL.data: crystal_text(atoms, size)}
    return {}
