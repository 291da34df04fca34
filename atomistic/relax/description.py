"""What a deck is, in lines for people: surface, wall, slab and motion, in the words of the input and in real units."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from atomistic.config.deck import DeckConfig
from atomistic.config.motion import TimeWindows
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Model
from continuum.model.fourier import Real
from continuum.model.surface import moments
from continuum.model.walls import Wall
from continuum.tables import Table


def described(config: DeckConfig, slab: Slab, model: Model, wall: Wall, heights: Real) -> tuple[str, ...]:
    """Lines of a README: what of an input makes its deck, with sizes in real units where the crystal has a size."""
    real = model.real_units

    def nanometres(value: float) -> str:
        return f"{value:.4g} a0" + ("" if real is None else f" ({real.to_si(value, 'length') / 1e-9:.4g} nm)")

    found, digest = moments(slab.grid, heights), hashlib.sha256(np.ascontiguousarray(heights).tobytes()).hexdigest()
    work = float(wall.work_of_adhesion)
    lines = [
        f"Surface: {_values(config.surface)}",
        f"  heights from {nanometres(float(heights.min()))} to {nanometres(float(heights.max()))}, rms height "
        f"{nanometres(found.rms_height)}, rms slope {found.rms_slope:.4g}; SHA-256 {digest[:16]}",
        f"Wall: {_values(config.wall)}",
        f"  work of adhesion {work:.4g} E* a0"
        + ("" if real is None else f" ({real.to_si(work, 'energy_per_area') * 1e3:.4g} mJ/m²)")
        + f", attraction over {nanometres(float(wall.range))}",
        f"Slab: {slab.shape[0]} x {slab.shape[1]} atoms, {nanometres(slab.depth)} deep"
        + (
            "" if real is None else f"; a0 = {real.a0 / 1e-10:.5g} Å, E* = {real.contact_modulus / 1e9:.4g} GPa at rest"
        ),
    ]
    windows = config.steps().windows
    return (*lines, *([] if windows is None else _motion(windows, model)))


def _motion(windows: TimeWindows, model: Model) -> Iterator[str]:
    """Velocity and times of a motion in m/s and ps."""
    real = model.real_units
    if real is None:
        return
    yield (
        f"Motion: {windows.velocity:.4g} (E* a0³/m)^(1/2) are {real.to_si(windows.velocity, 'velocity'):.4g} m/s; "
        f"{len(windows.duration)} windows, the longest of {max(windows.duration):.4g} a0 (m/(E* a0³))^(1/2), "
        f"{real.to_si(max(windows.duration), 'time') / 1e-12:.4g} ps"
    )


def _values(table: Table) -> str:
    """Keys and values of a table of an input, without those that were left out."""
    given = table.model_dump(exclude_unset=True, mode="json")
    return ", ".join(f"{key} = {value}" for key, value in given.items())
