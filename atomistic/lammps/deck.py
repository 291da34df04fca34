"""The LAMMPS deck: a slab under a rigid rough wall, and its protocol, which a stock ``lmp -in in.contact`` runs.

A :class:`Deck` is checked completely, then rendered from ``templates/`` by strict substitution into a self-contained
directory.  Only numbers formatted here and commands of the interatomic model enter a script, never text from a user.
"""

import hashlib
import json
import re
import textwrap
from collections import ChainMap
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from typing import BinaryIO, Literal, get_args

import numpy as np
import scipy

import continuum
from atomistic.crystal.crystal import AnySlab
from atomistic.crystal.model import AnyCrystalModel, AnyModel, check_model
from atomistic.crystal.potentials import POTENTIAL
from atomistic.lammps import crystal_wall, plugin
from atomistic.lammps import directory as disk
from atomistic.lammps.crystal_wall import OWN, CrystalWall, WallCrystal
from atomistic.lammps.language import filled, formatted, listing, read_template, vocabulary
from atomistic.lammps.law import NO_CORE, TOLERANCE, felt, law_of_atoms, name_of, native_law, wall_table
from atomistic.lammps.protocol import Protocol, time_unit, times_area
from atomistic.lammps.result import UNITS
from atomistic.lammps.shape import Shape, check_shape, misfit, shape_of
from continuum.inputs.arguments import (
    ArgumentError,
    choice,
    count,
    field_of,
    file_name,
    flag,
    function,
    instance,
    number,
)
from continuum.inputs.errors import OutputError
from continuum.measure.contact import ATTRACTED, REPULSIVE
from continuum.model.fourier import Real
from continuum.model.walls import TabulatedWall, Wall
from continuum.store.output import folder, save, whole

SCRIPTS = ("in.contact", "in.slab", "in.wall", "in.output", "README.txt")
INPUTS = (
    *SCRIPTS, "in.relax", "in.motion", "slab.data", "slab.start", disk.HEIGHTS, "wall.table", "wall.vtk", "deck.json",
    "stiffness.npy", disk.MAP, "input.toml", plugin.SOURCE, plugin.LIBRARY, plugin.MAP, "in.place", crystal_wall.DATA,
)  # fmt: skip
"""Files of a deck, of equilibria or of a motion, in addition to those of its interatomic model."""
_NUMBERED = re.compile(rf"{re.escape(POTENTIAL)}|potential\.\d+|start(\.\d+)?\.dump")
"""Files of which a deck has as many as it needs."""

LEAST_VERSION = 20240207, "7 February 2024"
"""Oldest LAMMPS that runs a deck, as variables need ternary(x,y,z)."""

_OF_ALL_STEPS = ("in.contact", "README.txt", "wall.vtk")
"""Texts that name all steps, or only show the wall."""

WallForce = Literal["formulas", "plugin", "atoms"]
"""Kind of wall force: by formulas of LAMMPS, a plugin, or the atoms of a rigid crystal."""


@dataclass(frozen=True, eq=False)
class Deck:
    """A slab under a rigid rough wall: one equilibrium, or the steps of a protocol.

    Parameters
    ----------
    slab : the atoms.
    model : interatomic model.
    wall : law between wall and surface, not a hard wall.
    heights : heights of the wall above each surface atom, shape ``slab.shape``, in a0.
    wall_map : heights at the points of ``slab.grid``, in a0, where the surface atoms are not these points; else None.
    separation : height of the wall's zero above the surface at rest, in a0; with a protocol, that of its first step.
    displacements : displacements to start from, shape ``(*slab.ids.shape, 3)``, in a0; the slab at rest if None.
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
    starts : displacements from which the first steps start, as they were relaxed before, each as ``displacements``.
    copied : files from elsewhere than the folder of its input, or from LAMMPS, whose content the deck has.

    Raises
    ------
    ArgumentError
        If the parts do not fit together, or a number is not allowed.
    TypeError
        If LAMMPS has no formula for the law.
    """

    slab: AnySlab
    model: AnyModel
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
    wall_map: Real | None = field(default=None, repr=False)
    starts: tuple[Real, ...] = field(default=(), repr=False)
    copied: tuple[Path, ...] = ()

    def __post_init__(self) -> None:
        slab = instance("slab", self.slab, AnySlab)
        native_law(instance("wall", self.wall, Wall, "a wall law of continuum"))
        self._set_arrays()
        self._check_numbers()
        if not slab.one_to_one:
            instance("model", self.model, AnyCrystalModel, "a model of the atoms of the slab")
            return
        model = check_model("model", self.model)
        if not np.isclose(model.lattice_constant, np.sqrt(2), rtol=1e-12):
            spacing = model.lattice_constant / np.sqrt(2)
            raise ArgumentError("model", model, f"a crystal of the spacing a0 = 1 of the surface grid, not {spacing:g}")
        frozen = slab.size // slab.surface_atoms - slab.mobile
        if frozen < model.coupled_layers:
            allowed = f"at least {model.coupled_layers} frozen layers, which forces reach, not {frozen}"
            raise ArgumentError("slab", slab, allowed)

    def write(
        self, directory: str | Path, *, force: bool = False, progress: Callable[[int, int], None] | None = None
    ) -> Path:
        """Write the deck into a directory, in which a stock ``lmp -in in.contact`` runs it; returns the directory.

        Parameters
        ----------
        force : remove finished steps of another deck there; those that this deck reaches by the same steps stay.
        progress : called with the number of written tables of atoms and of all.

        Raises
        ------
        ArgumentError, OutputError
            If it is not the name of a directory, has files other than an earlier deck, or finished steps of another
            deck, or cannot be written to.
        """
        function("progress", progress)
        return write_deck(file_name("directory", directory), self, force=flag("force", force), progress=progress)

    def _set_arrays(self) -> None:
        slab = self.slab
        sites = slab.ids.shape
        _set_array(self, "heights", self.heights, slab.shape)
        start = np.zeros((*sites, 3)) if self.displacements is None else self.displacements
        _set_array(self, "displacements", start, (*sites, 3))
        if self.stiffness is not None:
            _set_array(self, "stiffness", self.stiffness, slab.grid.shape_q)
        if self.wall_map is not None:
            _set_array(self, "wall_map", self.wall_map, slab.grid.shape)
        _set_array(self, "rise", np.zeros(sites[0]) if self.rise is None else self.rise, sites[:1])
        starts = tuple(_own(field_of("starts", start, (*sites, 3))) for start in self.starts)
        object.__setattr__(self, "starts", starts)
        held = [(name, getattr(self, name)) for name in ("displacements", "rise")]
        for name, moved in [*held, *(("starts", start) for start in starts)]:
            if np.any(moved[slab.moving :]):
                frozen = f"the lowest {len(moved) - slab.moving} {'layers' if slab.one_to_one else 'atoms'}"
                raise ArgumentError(name, moved, f"zero in the frozen base, {frozen}")
        above = slab.positions.reshape(-1, 3)[: slab.surface_atoms].reshape(*slab.shape, 3)
        if self.shape is not None and (apart := misfit(check_shape("shape", self.shape), self.heights, above)):
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
            if not self.slab.one_to_one:
                allowed = f'"formulas" or "plugin" above {self.slab.name}: a wall of atoms continues fcc(100)'
                raise ArgumentError("wall_force", self.wall_force, allowed)
            instance("wall_crystal", self.wall_crystal, WallCrystal)
            # If there is no such crystal, the reason is raised.
            crystal_wall.crystal_wall(self.wall, self.shape, self.slab.grid.shape, self.wall_crystal)
        number("wall_tolerance", self.wall_tolerance, above=0)
        if not (isinstance(self.notes, tuple) and all(isinstance(note, str) for note in self.notes)):
            raise ArgumentError("notes", self.notes, "a tuple of texts")
        instance("source", self.source, str)
        if not (isinstance(self.copied, tuple) and all(isinstance(path, Path) for path in self.copied)):
            raise ArgumentError("copied", self.copied, "a tuple of paths")
        protocol = self.protocol
        if protocol is not None:
            instance("protocol", protocol, Protocol, "Separations, MeanPressures or Motion")
        # Only a step at rest has a start of its own; a moving wall goes on from the step before.
        if len(self.starts) > (1 if protocol is None else protocol.steps if protocol.included == "in.relax" else 0):
            raise ArgumentError("starts", self.starts, "one for each step at rest, at most")
        if protocol is None:
            return
        if self.separation != protocol.separations[0]:
            raise ArgumentError("separation", self.separation, f"that of the first step, {protocol.separations[0]}")
        if misfit := protocol.misfit(self.slab.mobile, stays=self.shape is None):
            raise ArgumentError(*misfit)

    @cached_property
    def crystal(self) -> CrystalWall | None:
        """The atoms of the wall; None if it has none."""
        if self.wall_force != "atoms" or self.shape is None:
            return None
        return crystal_wall.crystal_wall(self.wall, self.shape, self.slab.grid.shape, self.wall_crystal)

    @property
    def start(self) -> Real:
        """Displacements to start from, shape ``(*slab.ids.shape, 3)``, in a0."""
        assert self.displacements is not None
        return self.displacements

    @property
    def rest(self) -> Real:
        """Positions of the atoms at rest without a wall, shape ``(*slab.ids.shape, 3)``, in a0."""
        assert self.rise is not None
        at = self.slab.positions.copy()
        at[..., 2] += self.rise.reshape(-1, *(at.ndim - 2) * (1,))
        return at

    @cached_property
    def surface(self) -> float:
        """Height of the surface at rest, that of its median atom, in a0."""
        return float(np.median(self.rest[..., 2].ravel()[: self.slab.surface_atoms]))

    @cached_property
    def law(self) -> Wall:
        """The law of each atom: ``wall``, or its part where that reaches the layers below."""
        return law_of_atoms(self.wall, self.slab.layer)

    @cached_property
    def above(self) -> Real:
        """Heights of the wall above the site of each atom that moves, shape (mobile atoms,), in a0."""
        return heights_above(self.slab, self.heights, self.profile, self.shape)

    @property
    def lowest(self) -> float:
        """A bound below the heights of the wall, in a0; minus infinity if its shape does not say."""
        return float(self.above.min()) if self.shape is None else getattr(self.shape, "lowest", -np.inf)

    @property
    def profile(self) -> Real:
        """Heights of the wall at the points of the grid, in a0."""
        return self.heights if self.wall_map is None else self.wall_map


def _set_array(deck: Deck, name: str, values: Real, shape: tuple[int, ...]) -> None:
    """Keep a private read-only copy of an array after checking its shape and that it is finite."""
    object.__setattr__(deck, name, _own(field_of(name, values, shape)))


def _own(values: Real) -> Real:
    array = np.array(values)
    array.flags.writeable = False
    return array


def heights_above(slab: AnySlab, heights: Real, profile: Real, shape: Shape | None = None) -> Real:
    """Heights of a wall above the site of each atom that moves, shape (mobile atoms,), in a0.

    A wall of the lattice sites is known at those of the surface, and interpolated above deeper ones.

    Parameters
    ----------
    heights : above the surface atoms, shape ``slab.shape``.
    profile : at the points of the grid, by which it is interpolated.
    shape : of a wall of the position.
    """
    between = shape or shape_of(profile, slab.grid.lengths)
    at = slab.positions.reshape(-1, 3)[: slab.mobile_atoms, :2]
    if slab.one_to_one and shape is None:  # every other layer is above the same places
        pair = np.concatenate([heights.ravel(), between.evaluate(*at[heights.size : 2 * heights.size].T).height])
        return np.resize(pair, len(at))
    found = np.array(between.evaluate(*at.T).height)
    found[: heights.size] = heights.ravel()
    return found


def _near(deck: Deck) -> str:
    """True if an atom is high enough to be reached by the wall, in LAMMPS' language."""
    depth = deck.surface + deck.lowest - felt(deck.law)
    if not np.isfinite(depth):
        return "gmask(all)"
    return f"z>(v_separation+({formatted(depth)}))*v_length_unit"


def render(deck: Deck) -> dict[str, str]:
    """Names and texts of the files of a deck, without its atoms."""
    model, wall, protocol, slab, shape = deck.model, deck.wall, deck.protocol, deck.slab, deck.shape
    surface_atoms, area = slab.surface_atoms, slab.area
    values: dict[str, object] = {
        "units": model.units,
        "length": model.length,
        "reduced_force": model.energy / model.length,
        "force": area * model.energy / model.length,
        "energy": area * model.energy,
        "element": " ".join(model.elements),
        "slab": slab.name,
        "a_slab": f"{'an' if slab.name[0] == 'f' else 'a'} {slab.name}",
        "units_of_area": "" if slab.one_to_one else filled(read_template("area"), {"area": area}),
        "separation": deck.separation,
        "tolerance": deck.tolerance,
        "evaluations": deck.evaluations,
        "surface": deck.surface,
        "law": native_law(deck.law, deck.wall_tolerance).lines,
        "near": _near(deck),
        "times_area": times_area(slab),
        "units_of_keys": ", ".join(f'"{name}": "{unit}"' for name, unit in UNITS.items()),
        "of_heights": "surface atoms" if shape is not None else "atoms that move",
        "zero_gap": wall.zero_gap,
        "reach": wall.zero_gap + wall.range,
        "repulsive": REPULSIVE,
        "attracted": ATTRACTED,
        "settings": model.settings(),
        "interactions": model.interactions(),
        "surface_atoms": surface_atoms,
        "mobile_atoms": slab.mobile_atoms,
        "timestep": model.timestep * time_unit(model),
        "real_units": _real_units(deck),
        "atoms": slab.size,
        "input": "input.toml    the input that this deck is of\n" if deck.source else "",
        "version": continuum.__version__,
        "least": LEAST_VERSION[1],
        "least_version": least_version("deck"),
        "folder": ".",
        "map": plugin.MAP,
        "at_rest": "surface",
        **{f"at_{axis}": f"{axis}/${{length_unit}}-v_offset_{axis}" for axis in "xy"},
        **{f"along_{axis}": "" for axis in "xy"},
        "model": textwrap.fill(model.reference, 118),
        "notes": "".join(f"{textwrap.fill(''.join(filter(str.isprintable, note)), 118)}\n" for note in deck.notes),
        "potential": "".join(
            f"{name:13} the potential, {model.names[name]}, as its authors wrote it\n" for name in model.files
        ),
        "package": "that of the pair_style" if model.files else "EXTRA-PAIR",
        "lost": slab.lost,
        "core": NO_CORE,
        "results": "",
        "relaxed": len(deck.starts),
        "flags": " ".join(plugin.FLAGS),
        "old_strings": plugin.OLD_STRINGS,
        "site": " site d_height" if shape is None else "",
        "lines": "" if shape is None else "\n".join(shape.lines()),
    }
    script, included = ("single", "in.relax") if protocol is None else (protocol.script, protocol.included)
    kinds = (model.atom_style, "site" if shape is None else "position", included, "formulas", deck.wall_force,
             *(["started"] if deck.starts else []))  # fmt: skip
    chosen = ChainMap(*(vocabulary()[kind] for kind in reversed(kinds)))
    if protocol is not None:
        values |= {"results": ".N", "steps": protocol.steps, "separations": listing(protocol.separations)}
        values |= protocol.placeholders(model, slab)
    texts, crystal = {"wall.table": wall_table(wall, deck.wall_tolerance, deck.law)}, deck.crystal
    texts["wall.vtk"] = disk.wall_mesh(
        deck.profile, deck.separation + deck.surface, model.length, spacing=slab.grid.spacing
    )
    if deck.wall_force == "plugin":
        values["core"] = max(deck.law.core, NO_CORE)
        texts |= {plugin.SOURCE: plugin.plugin_source(), plugin.MAP: plugin.wall_map(deck.law, shape, slab.grid)}
    if crystal is not None:
        values["interactions"] = crystal_wall.interactions_beside(model, crystal.strength)
        texts[crystal_wall.DATA] = crystal_wall.crystal_data(crystal, model, slab.grid.shape, deck.surface)
    values |= {name: filled(text, values) for name, text in chosen.items()}
    values |= wall_lines(deck.wall_force, values)
    names = (*SCRIPTS[1:], included, *(() if crystal is None else ("in.place",)))
    scripts = {name: filled(read_template(name), values) for name in names}
    return {"in.contact": filled(read_template(f"contact.{script}"), values)} | scripts | texts


def least_version(what: str) -> str:
    """A line that ends an older LAMMPS than :data:`LEAST_VERSION`.

    It does so by an unknown command; ``quit`` would end a Python that it runs in, too.
    """
    number, date = LEAST_VERSION
    return f'if "$(version) < {number}" then "this_{what}_needs_LAMMPS_of_{date.replace(" ", "_")}_or_later"'


def wall_lines(wall_force: WallForce, values: Mapping[str, object]) -> dict[str, str]:
    """Lines that every script of a wall contains: its force on the atoms, and its numbers."""
    return {
        name: filled(read_template(f"wall.{of}"), values) for name, of in (("acts", wall_force), ("numbers", "numbers"))
    }


def step_keys(deck: Deck, texts: Mapping[str, str]) -> list[str]:
    """A hash of each step of a deck and of all before it; one for a single equilibrium."""
    # Of one digest that goes on from step to step: a finished step is kept only if the way to it is the same.
    digest = hashlib.sha256("".join(texts[name] for name in sorted({*texts} - {*_OF_ALL_STEPS})).encode())
    for content in deck.model.files.values():
        digest.update(content)
    for array in (deck.heights, deck.start, deck.rest):
        digest.update(array.tobytes())
    protocol, keys = deck.protocol, list[str]()
    every = [(deck.separation,)] if protocol is None else protocol.each_step()
    for numbers, start in zip_longest(every, deck.starts, fillvalue=np.zeros(0)):
        digest.update(f"{type(protocol).__name__} {numbers!r}".encode())
        digest.update(start.tobytes())
        keys.append(digest.hexdigest()[:16])
    return keys


def _real_units(deck: Deck) -> str:
    """Load and pressure in SI, if the crystal has a length scale."""
    real = deck.model.real_units
    if real is None:
        return ""
    newtons, pascals = real.si("force") / scipy.constants.nano, real.si("pressure") / scipy.constants.giga
    return (
        f'  "load_nN": $(v_load*{formatted(newtons * deck.slab.area)}:%.17g),\n'
        f'  "mean_pressure_GPa": $(v_load*{formatted(pascals / deck.slab.surface_atoms)}:%.17g),\n'
    )


def write_deck(
    directory: Path, deck: Deck, *, force: bool = False, progress: Callable[[int, int], None] | None = None
) -> Path:
    """Write a deck into a directory, which is made if needed; returns the directory.

    An earlier deck is replaced.  Its finished steps are kept if the new deck reaches them by the same steps, so that
    an extended protocol continues; others are removed if ``force``. ``in.contact`` is written last: without it a
    directory is no deck.

    Raises OutputError or PluginError, and changes nothing, if the directory has other files (which are left alone
    beside a deck that ``force`` replaces), or finished steps of another deck without ``force``, or a run is under way
    there, or it cannot be written to; or if the plugin cannot be built.
    """
    directory = Path(directory)
    texts = render(deck)
    keys = step_keys(deck, texts)
    texts["deck.json"] = _description(deck, texts, keys)
    keep = 0
    if directory.exists():
        if not directory.is_dir():
            raise OutputError(f"{directory}: is not a folder; choose another one for the deck")
        known = {*INPUTS, *disk.PARTS, disk.LOCK}
        foreign = sorted(
            entry.name
            for entry in directory.iterdir()
            if entry.name not in known
            and not disk.OUTPUTS.fullmatch(entry.name)
            and not _NUMBERED.fullmatch(entry.name)
        )
        # `force` replaces a deck, beside files of others; a folder that is no deck is never taken over.
        is_deck = (directory / "deck.json").is_file() and (directory / "in.slab").is_file()
        if foreign and not (force and is_deck):
            names = ", ".join(foreign[:5])
            leave = ", or leave them beside the new deck with --force" if is_deck else ""
            raise OutputError(
                f"{directory} has files that do not belong to a deck ({names}): choose another directory{leave}"
            )
        with suppress(OSError, ValueError):  # without such a file, or where it is damaged
            there = (directory / "deck.json").read_text(encoding="utf-8")
            # The same deck, written to its end: `in.contact` comes last.
            if there == texts["deck.json"] and (directory / "in.contact").is_file():
                return directory
        keep = disk.steps_to_keep(directory, keys, force=force)
    library = plugin.plugin_library() if plugin.SOURCE in texts else None  # before anything there is touched
    folder(directory)
    with disk.hold(directory):
        disk.remove_outputs(directory, keep)
        (directory / "in.contact").unlink(missing_ok=True)  # no deck, until all else is written
        for entry in list(directory.iterdir()):
            if _NUMBERED.fullmatch(entry.name) or (entry.name in INPUTS and entry.name not in texts):
                entry.unlink()
        for name, content in deck.model.files.items():
            save(directory / name, content, own=True)
        tell = (lambda *_: None) if progress is None else progress
        tables = 5 + len(deck.starts)
        tell(0, tables)
        with whole(directory / "slab.data") as file:
            _write_data(file, deck)
        tell(1, tables)
        with whole(directory / disk.HEIGHTS) as file:
            # A wall of positions is evaluated in the script: the file has the heights above the surface only.
            above = deck.heights if deck.shape is not None else deck.above
            disk.write_atoms(file, deck.slab.ids.ravel()[: above.size], above)
        tell(2, tables)
        with whole(directory / "slab.start") as file:
            for axis in range(3):
                mobile = slice(0, deck.slab.moving)
                disk.write_atoms(file, deck.slab.ids[mobile], deck.start[mobile, ..., axis])
                tell(3 + axis, tables)
        # Numbered as the steps of a protocol, from 1; a single equilibrium has `start.dump`.
        for step, start in enumerate(deck.starts, deck.protocol is not None):
            with whole(directory / (f"start.{step}.dump" if step else "start.dump")) as file:
                _write_dump(file, deck, step, start)
        tell(tables, tables)
        if deck.wall_map is not None:
            with whole(directory / disk.MAP) as file:
                np.save(file, deck.wall_map)
        if deck.stiffness is not None:
            with whole(directory / "stiffness.npy") as file:
                np.save(file, deck.stiffness)
        if deck.source:
            save(directory / "input.toml", deck.source, own=True)
        if library is not None:
            save(directory / plugin.LIBRARY, library, own=True)
        for name in reversed(texts):  # in.contact last
            save(directory / name, texts[name], own=True)
    return directory


def _description(deck: Deck, texts: Mapping[str, str], keys: list[str]) -> str:
    """``deck.json``: description of the deck for programs; its identity is a hash of all that LAMMPS reads."""
    digest = hashlib.sha256("".join(texts[name] for name in sorted(texts)).encode())
    for content in deck.model.files.values():
        digest.update(content)
    for array in (deck.heights, deck.start, deck.rest, *deck.starts):
        digest.update(array.tobytes())
    wall, real, protocol = deck.wall, deck.model.real_units, deck.protocol
    heights = deck.heights
    law = name_of(wall)
    numbers = {} if law == TabulatedWall.__name__ else wall.numbers
    description = {
        "format": disk.FORMAT,
        "identity": digest.hexdigest(),
        "steps": 0 if protocol is None else protocol.steps,
        "step_keys": keys,
        **({"relaxed": len(deck.starts)} if deck.starts else {}),
        **({} if protocol is None else protocol.about()),
        "wall": {"law": law, **numbers},
        "element": " ".join(deck.model.elements),
        "model": deck.model.reference,
        "files": dict(deck.model.names),
        "bonded": deck.model.atom_style == "bond",
        "surface": deck.surface,
        "heights": hashlib.sha256(heights.tobytes()).hexdigest(),
        "notes": list(deck.notes),
        "length": deck.model.length,
        "real_units": None if real is None else asdict(real),
    }
    return json.dumps(description, indent=2) + "\n"


def _ends(deck: Deck) -> list[str]:
    """Ends of the box along x and y, and both of them along z, in LAMMPS' unit.

    Two spacings of room on both sides, and up to the highest point of the wall, to which adhesion may lift an atom:
    nothing leaves the box.
    """
    slab = deck.slab
    highest = max(deck.protocol.separations) if deck.protocol else deck.separation
    high = 2 + max(0.0, deck.surface if not slab.one_to_one else 0.0, highest + float(deck.heights.max()))
    return [formatted(deck.model.length * value) for value in (*slab.grid.lengths, slab.bottom - 2, high)]


def _write_dump(file: BinaryIO, deck: Deck, step: int, displacements: Real) -> None:
    """``start.N.dump``: the atoms that move, at displacements."""
    mobile, (x, y, low, high) = slice(0, deck.slab.moving), _ends(deck)
    rows = deck.model.length * (deck.rest + displacements)[mobile].reshape(-1, 3)
    file.write(
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: BOX BOUNDS pp pp ff\n0 {x}\n0 {y}\n"
        f"{low} {high}\nITEM: ATOMS id xu yu zu\n".encode()
    )
    disk.write_rows(file, "%d %.17g %.17g %.17g\n", deck.slab.ids[mobile].ravel(), rows)


def _write_data(file: BinaryIO, deck: Deck) -> None:
    """``slab.data``: the slab at rest."""
    slab, model, ends = deck.slab, deck.model, _ends(deck)
    bonds = model.atom_style == "bond"
    ids, kinds = slab.ids.ravel(), len(model.elements)
    file.write(
        f"{disk.title_of(slab, model.length)}\n\n"
        f"{slab.size} atoms\n{kinds} atom types\n{'1 bond types' if bonds else ''}\n\n"
        f"0 {ends[0]} xlo xhi\n0 {ends[1]} ylo yhi\n{ends[2]} {ends[3]} zlo zhi\n\n"
        "Masses\n\n".encode()
    )
    for i, (element, mass) in enumerate(zip(model.elements, model.masses, strict=True), 1):
        file.write(f"{i} {formatted(mass)} # {element}\n".encode())
    file.write(f"\nAtoms # {model.atom_style}\n\n".encode())
    kind = "%d 1 %d" if bonds else "%d %d"  # molecule and type, or type
    rows = np.column_stack([slab.types + 1, model.length * deck.rest.reshape(-1, 3)])
    disk.write_rows(file, f"{kind} %.17g %.17g %.17g\n", ids, rows)
