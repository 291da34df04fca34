"""Build decks from inputs and from contacts: check them, and start from the lattice solution of the first step."""

import hashlib
import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import singledispatch
from math import ceil
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from atomistic.crystal.crystal import AnySlab, Slab, distortion
from atomistic.crystal.model import AnyCrystalModel, AnyModel, Potential, check_model
from atomistic.crystal.potentials import comes_with_lammps
from atomistic.inputs.crystal import CrystalTable, DeckSolverTable, ElasticConfig
from atomistic.inputs.deck import QUANTITIES, DeckConfig, TopographySurface, in_reduced, with_units
from atomistic.inputs.motion import HOTTEST, Steps, thermal_energy
from atomistic.lammps.crystal_wall import OWN, CrystalWall, WallCrystal, crystal_wall, first_touch
from atomistic.lammps.deck import Deck, WallForce
from atomistic.lammps.engine import Progress
from atomistic.lammps.law import native_law
from atomistic.lammps.protocol import MeanPressures, Motion, Protocol, Separations, largest_timestep, swing
from atomistic.lammps.result import LARGEST_DISTORTION, DeckStatus
from atomistic.lammps.shape import Shape, misfit, shape_notes, shape_of, shape_of_surface
from atomistic.relax.limits import require_apart, require_steps, require_strength
from atomistic.relax.specimen import AnySpecimen, Specimen, slab_below, slab_of, slab_under, specimen_under
from atomistic.response.bulk import model_below
from atomistic.response.cache import default_folder
from atomistic.response.thermal import warm_crystal
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.reading import parsed
from continuum.inputs.tables import Fault, Table
from continuum.inputs.toml import ConfigError, Source, find, refuse
from continuum.inputs.units import Units, parse
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem, check_slope
from continuum.model.surface import Surface, moments
from continuum.model.walls import Wall
from continuum.path import loading
from continuum.solve.solution import NotConvergedError

_ALIKE = 1e-6
"""Relative difference of two periods that are the same, as they were typed with a few digits."""


class DeckParts(NamedTuple):
    """Checked parts of a deck."""

    slab: AnySlab
    model: AnyModel
    wall: Wall
    heights: Real
    """Heights of the wall at the points of the grid of the slab, in a0."""
    steps: Steps
    shape: Shape | None
    """The wall as a function of the position; None for lattice sites."""
    wall_force: WallForce
    solver: DeckSolverTable
    notes: tuple[str, ...] = ()
    """Lines about the input and the origin of the heights."""
    source: str = ""
    """Text of the input."""
    wall_crystal: WallCrystal = OWN
    profile: Shape | None = None
    """The wall between the points of the grid, where the surface atoms are not these; else None."""
    copied: tuple[Path, ...] = ()
    """Files from elsewhere than the folder of the input, or from LAMMPS, whose content the deck has."""

    @property
    def crystal(self) -> CrystalWall | None:
        """The atoms of the wall; None if it has none."""
        if self.wall_force != "atoms" or self.shape is None:
            return None
        return crystal_wall(self.wall, self.shape, self.slab.grid.shape, self.wall_crystal)


def parts_of(config: DeckConfig, progress: Progress | None = None) -> DeckParts:
    """Read the parts of an input, and measure its crystal.

    Raises ConfigError if its parts do not fit together, a file is invalid, or its numbers are beyond a crystal under a
    wall; PotentialError if the crystal of the potential is not a stable fcc one; LammpsError if LAMMPS fails.
    """
    model, faults = _model(config), list[Fault]()
    slab = slab_of(config, model)
    wall = heights = None
    try:
        wall = _wall(config)
    except (ValueError, OSError) as error:
        faults.append(Fault(("wall",), str(error)))
    except (ArithmeticError, Warning) as error:
        cause = "lengths in other units than a0, or stiffnesses in other units than E*/a0"
        faults.append(Fault(("wall",), f"a law whose energies and tractions are finite ({error})", cause))
    try:
        heights, notes = _heights(config.surface, config, slab, model)
        if (slope := moments(slab.grid, heights).rms_slope) > 0:  # a flat wall is allowed
            check_slope(slope)
    except ConfigError:
        raise
    except (ValueError, OSError) as error:
        faults.append(Fault(("surface",), str(error)))
    if faults or wall is None or heights is None:
        raise refuse(config, *faults)
    steps = config.steps()
    require_steps(steps, slab, model, wall, heights, config)
    profile = shape_of_surface(config.surface, heights, slab.grid.lengths)
    shape = None if config.follows == "site" else profile  # else a function of the position of the atom
    if config.wall_force == "atoms" and shape is not None:
        require_apart(config, steps, wall, shape, slab)
    notes = described(config, slab, deck_units(config, model, progress), wall, heights) + notes
    source = "" if config.source is None else config.source.text
    return DeckParts(
        slab, model, wall, heights, steps, shape, config.wall_force, config.solver, notes, source, config.wall_crystal,
        None if slab.one_to_one else profile, _from_elsewhere(config),
    )  # fmt: skip


def _from_elsewhere(config: DeckConfig) -> tuple[Path, ...]:
    """Files that an input names outside its folder, links followed, and that do not come with LAMMPS.

    Whoever passes on a deck that somebody else's input describes passes on their content.
    """
    if config.source is None:
        return ()
    here = config.source.path.resolve().parent
    outside = (path.resolve() for path in config.files if not comes_with_lammps(path))
    return tuple(dict.fromkeys(path for path in outside if not path.is_relative_to(here)))


def _model(config: DeckConfig | ElasticConfig) -> AnyModel:
    """The model of an input; raises ConfigError if its potential has no such crystal."""
    try:
        return model_below(config.interatomic.potential(), config.crystal)
    except ArgumentError as error:
        raise refuse(config, Fault(("crystal", error.name), error.allowed)) from error


def deck_units(config: DeckConfig, model: AnyModel, progress: Progress | None = None) -> Units | None:
    """Units of the crystal of an input at the temperature of its motion; None without a length scale."""
    motion = config.steps().motion
    return _units_at(model, 0.0 if motion is None else motion.temperature, progress)


def _units_at(model: AnyModel, temperature: Any, progress: Progress | None = None) -> Units | None:
    """Units with the a0 of a temperature in E* a0³ or text, which is measured unless it is on disk; E* is that at rest.

    Of what is no temperature of a crystal, which is refused where it is read, those at rest.
    """
    real = model.real_units
    if real is None or not model.expands:
        return real
    try:
        energy = float(thermal_energy(temperature, real))
    except (ValueError, TypeError):
        return real
    if not 0 < energy <= HOTTEST:
        return real
    return model.stretched(warm_crystal(model, energy, 0, default_folder(), progress).stretch).real_units


def described(config: DeckConfig, slab: AnySlab, real: Units | None, wall: Wall, heights: Real) -> tuple[str, ...]:
    """Lines for the README of a deck: its settings, with real units if the crystal has a length scale."""

    def nanometres(value: float) -> str:
        return f"{value:.4g} a0" + ("" if real is None else f" ({real.to_si(value, 'length') / 1e-9:.4g} nm)")

    found, digest = moments(slab.grid, heights), hashlib.sha256(np.ascontiguousarray(heights).tobytes()).hexdigest()
    work = float(wall.work_of_adhesion)
    lines = [
        f"Surface: {table_in_words(config.surface)}",
        f"  heights from {nanometres(float(heights.min()))} to {nanometres(float(heights.max()))}, rms height "
        f"{nanometres(found.rms_height)}, rms slope {found.rms_slope:.4g}; SHA-256 {digest[:16]}",
        f"Wall: {table_in_words(config.wall)}",
        f"  work of adhesion {work:.4g} E* a0"
        + ("" if real is None else f" ({real.to_si(work, 'energy_per_area') * 1e3:.4g} mJ/m²)")
        + f", attraction over {nanometres(float(wall.range))}",
        f"Slab: {slab.about}, {nanometres(slab.depth)} deep"
        + (
            ""
            if real is None
            else f"; a0 = {real.a0 / 1e-10:.5g} Å, and E* = {real.contact_modulus / 1e9:.4g} GPa of the crystal at rest"
        ),
    ]
    motion = config.steps().motion
    if motion is not None and real is not None:
        velocity, durations = motion.velocity, motion.windows[-1]
        lines.append(
            f"Motion: {velocity:.4g} (E* a0³/m)^(1/2) are {real.to_si(velocity, 'velocity'):.4g} m/s; "
            f"{len(durations)} windows, the longest of {max(durations):.4g} a0 (m/(E* a0³))^(1/2), "
            f"{real.to_si(max(durations), 'time') / 1e-12:.4g} ps"
        )
    return tuple(lines)


_FIRST = ("hurst", "lambda_s", "lambda_L", "kind", "rms_slope", "rms_height", "seed", "law", "adhesion_length", "range")


def table_in_words(table: Table) -> str:
    """The given keys and values of a table of an input, in a fixed order: decks are known by this text."""
    named = {table.kind_key: table.kind_name} if table.kind_name else {}
    given = named | table.model_dump(exclude_unset=True, mode="json")
    names = sorted(given, key=lambda name: _FIRST.index(name) if name in _FIRST else len(_FIRST))
    return ", ".join(f"{name} = {given[name]}" for name in names)


def _acting(deck: Deck, wall_force: WallForce, crystal: WallCrystal) -> Deck:
    """The deck with another kind of wall force; a wall of atoms starts with the slab at rest and without overlap."""
    deck = replace(deck, wall_force=wall_force, wall_crystal=crystal)
    if deck.crystal is None:
        return deck
    touch = first_touch(deck.crystal)
    protocol = None if deck.protocol is None else deck.protocol.from_separation(touch)
    separation = deck.separation if protocol is None else protocol.separations[0]
    if separation < touch:
        raise NotConvergedError(
            f"at the separation {separation:g} a0 atoms of the wall overlap those of the surface at rest: begin at "
            f"{touch:.4g} a0 or above"
        )
    cut = table_in_words(crystal) or "that of the surface continued upwards, cut"
    note = (
        f"Wall of atoms: a rigid fcc crystal ({cut}) of "
        f"{deck.crystal.about}; it touches the flat surface at the separation {touch:.4g} a0."
    )
    return replace(deck, displacements=None, protocol=protocol, separation=separation, notes=(*deck.notes, note))


def _wall(config: DeckConfig) -> Wall:
    """The law, checked to have finite tractions over its whole range."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # warnings about overflow and integrals that do not converge
        wall = config.wall.build()
        native_law(wall)
        gap = np.linspace(max(wall.core, wall.zero_gap - 1.0), wall.zero_gap + min(wall.range, 10.0), 101)
        law = wall.evaluate(gap)
    if not all(np.isfinite(values).all() for values in (law.energy, law.traction, law.stiffness)):
        raise ArithmeticError("a law of finite energies and tractions")
    return wall


@singledispatch
def _heights(surface: Surface, config: DeckConfig, slab: AnySlab, model: AnyModel) -> tuple[Real, tuple[str, ...]]:
    """Heights of the wall, in a0, and notes about their origin."""
    return surface.build(slab.grid), ()


@_heights.register
def _(surface: TopographySurface, config: DeckConfig, slab: AnySlab, model: AnyModel) -> tuple[Real, tuple[str, ...]]:
    real = deck_units(config, model)
    if real is None and surface.spacing is not None:
        a0 = parse(surface.spacing, "length")
    elif real is not None and surface.spacing is None:
        a0 = real.a0
    else:
        allowed = (
            'a0, as "0.3nm": this crystal has no length scale'
            if real is None
            else "left out: the crystal has its own a0"
        )
        raise refuse(config, Fault(("surface", "spacing"), allowed))
    grid = slab.grid
    # Above other crystals than fcc(100) a side may have an odd number of points, of which mirrors make no map.
    even = grid.shape if slab.one_to_one else tuple(n + n % 2 for n in grid.shape)
    x, y = (a0 * length / n for length, n in zip(grid.lengths, even, strict=True))
    wall = surface.read((even[0], even[1]), (x, y))
    heights = wall.heights / a0
    if even != grid.shape:
        points = np.stack(np.broadcast_arrays(*grid.positions))
        heights = shape_of(heights, grid.lengths).evaluate(*points).height
    return heights, (f"Wall: {wall.source}", *wall.steps)


def deck_of(parts: DeckParts, progress: Progress | None = None) -> Deck:
    """The deck, starting from the lattice solution of its first step.

    Raises NotConvergedError if the lattice model has no equilibrium at its first step, or at one of its pressures;
    PotentialError or LammpsError if its crystal cannot be measured.
    """
    slab, model, wall, heights, steps, shape = parts[:6]
    specimen = specimen_under(model, slab)
    response, rise, slab, model = specimen.response, specimen.rise, specimen.slab, specimen.model
    slope = moments(slab.grid, heights).rms_slope
    scale = slope or 1.0  # a flat wall
    problem = ContactProblem(slab.grid, wall, heights, response)
    settings = parts.solver.build(scale)
    protocol: Protocol | None
    notes: tuple[str, ...] = ()
    if steps.control == "mean-pressure":
        states = list(loading.follow(problem, "mean-pressure", steps.values, settings))
        require_strength(problem, states, settings, model)
        gap = states[0].solution.require().gap
        separations = tuple(state.require().separation for state in states)
    else:
        gap = loading.solve(problem, "separation", steps.values[0], settings).solution.require().gap
        separations = steps.values
    if steps.motion is not None:
        temperature = thermal_energy(steps.motion.temperature, model.real_units)
        model, rise, notes = _warm(specimen, temperature, progress)
        damping = 1 / (2 * swing(model, slab.depth))  # critical for the slab's slowest vibration
        protocol = steps.motion.motion(
            temperature * specimen.model.energy / model.energy,
            largest_timestep(model, wall),
            max(steps.motion.damping, damping),
        ).from_separation(separations[0])
        notes += _hold_notes(protocol, model, slab)
    elif steps.control == "mean-pressure":
        protocol = MeanPressures(steps.values, separations, problem.mean_stiffness)
    else:
        protocol = None if steps.single else Separations(separations)
    start = specimen.start(wall, gap)
    if not (moved := distortion(slab, start)) < LARGEST_DISTORTION:
        msg = f"at the separation {separations[0]:g} a0, {DeckStatus.DISTORTED.value} (by {moved:.2f} a0)"
        raise NotConvergedError(msg)
    tolerance = parts.solver.force_tolerance * scale
    notes = parts.notes + shape_notes(shape or parts.profile, slab.grid, parts.wall_force == "plugin") + notes
    above = heights
    if parts.profile is not None:
        above = parts.profile.evaluate(*slab.positions[: slab.surface_atoms, :2].T).height
    made = Deck(
        slab, model, wall, above, separations[0], start, tolerance, rise=rise, protocol=protocol, shape=shape,
        notes=notes, source=parts.source, stiffness=problem.stiffness_q, wall_tolerance=parts.solver.wall_tolerance,
        wall_map=None if parts.profile is None else heights, copied=parts.copied,
    )  # fmt: skip
    return _acting(made, parts.wall_force, parts.wall_crystal)


def _warm(
    specimen: Specimen | AnySpecimen, temperature: float, progress: Progress | None
) -> tuple[AnyModel, Real | None, tuple[str, ...]]:
    """The model with its lattice constant at a temperature, the rise of its layers, and lines that say so.

    A crystal of harmonic springs remains as at rest.
    """
    model, slab = specimen.model, specimen.slab
    if temperature == 0 or not model.expands:
        return model, specimen.rise, ()
    warm = warm_crystal(model, temperature, slab.mobile if slab.one_to_one else 0, default_folder(), progress)
    found = model.stretched(warm.stretch)
    unit = "Å" if model.units == "metal" else "σ"
    real = model.real_units
    kelvins = "" if real is None else f" ({real.to_si(temperature, 'temperature'):.4g} K)"
    lines = (
        f"Temperature: k_B T = {temperature:.6g} E* a0^3{kelvins}, of the crystal at rest.",
        f"Lattice constant at this temperature: {found.length * 2**0.5:.6g} {unit}, at rest "
        f"{model.length * 2**0.5:.6g} {unit}: {100 * (warm.stretch - 1):.3f}({100 * warm.stretch_error:.3f}) % more, "
        f"measured where a pressure of {warm.pressure:.1e} E* was left.  Cell, frozen base and a0 are those of this "
        "temperature; E* is that at rest.",
    )
    if not slab.one_to_one:
        return found, None, (*lines, "Separations count from the surface as it relaxes at rest.")
    return found, warm.rise_of(cast(Slab, slab)), (
        *lines,
        f"Surface at this temperature: {warm.rise[0]:+.4f}({warm.rise_error:.4f}) a0 above its lattice sites, from "
        "where separations count.",
    )  # fmt: skip


def _hold_notes(motion: Motion, model: AnyModel, slab: AnySlab) -> tuple[str, ...]:
    """Notes about the time for which the slab is damped before averaging, compared with its slowest vibration."""
    time, period = sum(motion.durations[: motion.hold]), 2 * np.pi / swing(model, slab.depth)
    said = (
        f"In {motion.hold} windows of hold the thermostat holds all layers, for {time:.3g} a0 (m/(E* a0³))^(1/2), "
        f"{time / period:.2g} periods of the slowest vibration of the slab"
    )
    if time < period:
        return (f"{said}: too short for it to come to rest; give hold = {ceil(period / time * motion.hold)} at least.",)
    return (f"{said}.",)


def parts_under(
    contact: ContactProblem,
    model: Potential,
    steps: Steps,
    depth: float | None,
    shape: Shape | None,
    force: WallForce,
    crystal: CrystalTable,
    wall_crystal: WallCrystal = OWN,
) -> DeckParts:
    """The parts of a deck of a contact.  The arguments are those of :func:`atomistic.deck`.

    Raises ArgumentError, ConfigError or TypeError if the grid does not have one point for each atom, LAMMPS has no
    formula for the law, or the steps do not fit the crystal or wall; PotentialError or LammpsError as :func:`parts_of`.
    """
    grid, wall, heights = contact.grid, contact.wall, contact.heights
    native_law(wall)  # checked before anything is measured
    points = np.stack(np.broadcast_arrays(*grid.positions), axis=-1)
    if shape is not None and (apart := misfit(shape, heights, points)):
        raise ArgumentError("follows", shape, f"a shape of the heights of the contact, not of others by {apart:.2g} a0")
    if shape is None and force == "atoms":
        raise ArgumentError("wall_force", force, 'follows="atom": atoms of the wall act at the positions of the atoms')
    if shape is None and steps.motion is not None and steps.motion.slides:
        raise ArgumentError("follows", "site", '"atom": a wall that is a function of the lattice site cannot slide')
    measured, deep = model_below(model, crystal), max(grid.lengths) if depth is None else depth
    profile = None
    if crystal.own:
        slab: AnySlab = slab_under(check_model("model", measured), grid, deep)
    else:
        slab = slab_below(cast(AnyCrystalModel, measured), crystal, grid.lengths, deep)
        (nx, ny), (x, y) = slab.grid.shape, slab.grid.lengths
        if grid.shape != (nx, ny) or not np.allclose(grid.lengths, (x, y), rtol=_ALIKE, atol=0):
            cells = f"{nx} x {ny} heights with period = ({x!r}, {y!r}), in whole cells of this crystal near those given"
            raise ArgumentError("contact", f"{grid.shape} heights over {grid.lengths}", cells)
        profile = shape or shape_of(heights, slab.grid.lengths)
    require_steps(steps, slab, measured, wall, heights)
    if shape is not None and force == "atoms" and crystal.own:
        crystal_wall(wall, shape, slab.grid.shape, wall_crystal)  # what it cannot be is said before anything is solved
    return DeckParts(
        slab, measured, wall, heights, steps, shape, force, DeckSolverTable(), wall_crystal=wall_crystal,
        profile=profile,
    )  # fmt: skip


def deck_input(path: str | Path, progress: Progress | None = None) -> DeckConfig:
    """Read the input of a deck, and convert its units to reduced ones, with the a0 of the temperature of its motion.

    Raises ConfigError with all faults of the file; PotentialError or LammpsError if a number has a unit, and the
    crystal is not a stable fcc one, or LAMMPS fails.
    """
    source = Source.read(find(path))
    if not with_units(source.data):
        return parsed(source, DeckConfig)
    try:
        model = _model(parsed(source, ElasticConfig))
    except ConfigError:
        return parsed(source, DeckConfig)  # which reports this fault together with the others
    values, faults = in_reduced(source.data, _units_for(source.data, model, progress))
    try:
        return parsed(source, DeckConfig, values)
    except ConfigError as error:
        told = [fault.key for fault in faults]
        others = [fault for fault in error.faults if not any(fault.key[: len(key)] == key for key in told)]
        raise ConfigError(source, [*faults, *others]) from None


def _units_for(given: Mapping[str, Any], model: AnyModel, progress: Progress | None) -> Units | None:
    """Units for the texts of an input or a call: pressures depend on E* alone, all others also on a0."""
    protocol, real = given.get("protocol"), model.real_units
    only_pressures = all(QUANTITIES[str(key[-1])] == "pressure" for key in with_units(given))
    if not isinstance(protocol, Mapping) or only_pressures or in_reduced(given, real)[1]:  # faults, said at once
        return real
    return _units_at(model, protocol.get("temperature", 0.0), progress)


def steps_in_units(
    given: Mapping[str, Any], model: Potential, crystal: CrystalTable, progress: Progress | None = None
) -> Mapping[str, Any]:
    """The separations, pressures or protocol of a call, with units converted to a0 and E* of a crystal.

    Raises ConfigError, PotentialError or LammpsError as :func:`deck_input`.
    """
    if not with_units(given):
        return given
    values, faults = in_reduced(given, _units_for(given, model_below(model, crystal), progress))
    if faults:
        raise ConfigError(Source(Path("protocol"), "", given), faults)
    return values
