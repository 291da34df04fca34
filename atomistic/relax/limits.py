"""Checks of the numbers of a deck against crystal and wall, before anything is solved."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path

from atomistic.crystal.crystal import AnySlab
from atomistic.crystal.model import AnyModel
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.motion import FASTEST, HOTTEST, MotionTable, Steps, thermal_energy
from atomistic.lammps.crystal_wall import crystal_wall, first_touch
from atomistic.lammps.protocol import largest_timestep
from atomistic.lammps.shape import Shape
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.tables import Fault
from continuum.inputs.toml import ConfigError, Source, refuse
from continuum.inputs.units import readable
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.walls import Wall
from continuum.path import loading
from continuum.path.state import Outcome, PathState
from continuum.solve.solution import NotConvergedError, Settings

FARTHEST = 100.0
"""Largest distance of the wall's lowest point from the surface, in a0, beyond the range of any law."""
_MOST_TIMESTEPS = 2**31 - 1
"""Largest number of time steps of a window: LAMMPS counts the samples of an average with 32 bits."""


def require_steps(
    steps: Steps, slab: AnySlab, model: AnyModel, wall: Wall, heights: Real, config: DeckConfig | None = None
) -> None:
    """Check that steps fit the slab, its crystal and its wall.

    Parameters
    ----------
    config : input of the steps; None for arguments of a call.

    Raises ConfigError with all faults.
    """
    faults = list(_beside_the_slab(steps, slab, heights))
    if steps.motion is not None:
        faults += _beyond_the_crystal(steps.motion, slab, model, wall)
    if faults and config is not None:
        place = () if steps.single else ("protocol",)
        raise refuse(config, *(replace(fault, key=(*place, *fault.key)) for fault in faults))
    if faults:
        given = {"separation": steps.values[0], "separations": list(steps.values)}
        if steps.motion is not None:
            given |= dict(steps.motion) | {"window": max(steps.motion.windows[-1])}
        raise ConfigError(Source(Path("protocol"), "", given), faults)


def require_apart(config: DeckConfig, steps: Steps, wall: Wall, shape: Shape, slab: AnySlab) -> None:
    """Check that the atoms of a wall do not overlap the surface at rest at the first separation.

    Raises ConfigError, with the smallest allowed separation, if they do; or if there is no such crystal.
    """
    try:
        touch = first_touch(crystal_wall(wall, shape, slab.grid.shape, config.wall_crystal))
    except ArgumentError as error:
        key = ("wall",) if error.name == "wall" else ("wall_crystal", error.name)
        raise refuse(config, Fault(key, error.allowed)) from error
    if steps.control == "separation" and steps.values[0] < touch:
        place = () if steps.single else ("protocol",)
        least = f"{ceil(1000 * touch) / 1000:g} or above at first"
        allowed = f"{least}: below it atoms of the wall overlap those of the surface at rest"
        raise refuse(config, Fault((*place, _separation_key(steps)), allowed))


def _separation_key(steps: Steps) -> str:
    """Key of the separations in an input."""
    one = steps.single or (steps.motion is not None and steps.motion.slides)
    return "separation" if one else "separations"


def require_strength(problem: ContactProblem, states: Sequence[PathState], settings: Settings, model: AnyModel) -> None:
    """Check that the contact holds the mean tensions asked for.

    Parameters
    ----------
    states : states on the lattice at successive mean pressures.
    settings : settings of their minimisation.

    Raises NotConvergedError with the largest tension that is held, to 1 %.
    """
    lost = next((i for i, state in enumerate(states) if state.outcome is Outcome.PULLED_OFF), None)
    if lost is None:
        return
    held = states[lost - 1] if lost else loading.solve(problem, "mean-pressure", 0.0, settings)
    asked, gap = states[lost].target, held.require().solution.gap
    # The mean tension is at most the largest tension of the law.
    low, high = held.target, max(asked, -problem.wall.largest_tension)
    # Without attraction none is held, and halving would end at the smallest number only.
    while high < 0 and low - high > 0.01 * max(abs(low), 1e-3 * abs(high)):
        middle = (low + high) / 2
        state = loading.solve(problem, "mean-pressure", middle, settings, gap)
        if state.status.ok:
            low, gap = middle, state.solution.gap
        else:
            high = middle
    real = model.real_units
    said = f"{-low:.3g} E*" + ("" if real is None else f" ({readable(-real.to_si(low, 'pressure'), 'pressure', 3)})")
    holds = f"the largest that it holds is {said}" if low < 0 else "it holds none"
    raise NotConvergedError(
        f"the contact does not hold a mean tension of {-asked:g} E*: {holds}; give pressures above {min(low, 0.0):.3g}"
    )


def _beyond_the_crystal(motion: MotionTable, slab: AnySlab, model: AnyModel, wall: Wall) -> Iterator[Fault]:
    """Faults of a motion beyond the atoms, or beyond the counters of LAMMPS."""
    temperature, velocity, scale = motion.temperature, motion.velocity, model.real_units
    here = ("", "") if scale is None else (
        f" ({HOTTEST * scale.si('temperature'):.4g} K)", f" ({FASTEST * scale.si('velocity'):.4g} m/s)"
    )  # fmt: skip
    if isinstance(temperature, str) and scale is None:
        yield Fault(("temperature",), "k_B T in E* a0³", "this crystal has no length scale, and so no kelvin")
    elif thermal_energy(temperature, scale) > HOTTEST:
        allowed = f"k_B T of at most {HOTTEST:g} E* a0³{here[0]}: fcc crystals melt at 0.006 to 0.011"
        cause = "an error in the number"
        if not isinstance(temperature, str):
            cause = "kelvin where k_B T in E* a0³ is asked for"
            cause += ": this crystal has no length scale, and so no kelvin" if scale is None else (
                f"; {temperature:g} E* a0³ are {scale.to_si(temperature, 'temperature'):.3g} K: "
                f'write "{temperature:g}K"'
            )  # fmt: skip
        yield Fault(("temperature",), allowed, cause)
    if velocity > FASTEST:
        allowed = f"at most {FASTEST:g} (E* a0³/m)^(1/2){here[1]}, slower than the shear waves of fcc crystals"
        cause = "a velocity in other units"
        if scale is not None:
            speed = scale.si("velocity")
            cause += f"; {velocity:g} (E* a0³/m)^(1/2) are {velocity * speed:.3g} m/s, and 1 m/s is {1 / speed:.3g}"
        yield Fault(("velocity",), allowed, cause)
    if not motion.thermostat_layers < slab.mobile:
        yield Fault(("thermostat_layers",), f"fewer than the layers that move, {slab.mobile} at this depth")
    timestep = largest_timestep(model, wall)
    if max(motion.windows[-1]) > _MOST_TIMESTEPS * timestep:
        allowed = f"at most {_MOST_TIMESTEPS * timestep:.3g}: {_MOST_TIMESTEPS} time steps of {timestep:.2g} each"
        yield Fault(("window",), allowed, "a time in other units, or a wall so stiff that its time steps are tiny")


def _beside_the_slab(steps: Steps, slab: AnySlab, heights: Real) -> Iterator[Fault]:
    """Faults of a wall that is too far above the slab, or below it."""
    if steps.control != "separation":
        return
    lowest = float(heights.min())
    if not all(-slab.depth <= separation + lowest <= FARTHEST for separation in steps.values):
        allowed = (
            f"from {-slab.depth - lowest:.6g}, where the lowest point of the wall is at the frozen base, to "
            f"{FARTHEST - lowest:.6g}, where it is {FARTHEST:g} a0 above the surface"
        )
        yield Fault((_separation_key(steps),), allowed, "a length in other units than a0")
