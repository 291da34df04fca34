"""A crystal at a temperature: its lattice constant at zero pressure, and the positions of its surface layers.

Both are means over time of atoms that LAMMPS moves in this process, under a Langevin thermostat.  Potential and
elastic constants remain those of the crystal at rest; only the positions of the atoms change.
"""

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from atomistic.crystal.crystal import Slab
from atomistic.crystal.model import AnyCrystalModel, AnyModel, CrystalModel
from atomistic.lammps.engine import Progress
from atomistic.lammps.protocol import BOLTZMANN, time_unit, vibration_timestep
from atomistic.lammps.session import Cell
from atomistic.response.force_constants import least_width
from continuum.inputs.errors import OutputError
from continuum.model.fourier import Real
from continuum.store import output

_Crystal = CrystalModel | AnyCrystalModel
VERSION = 1
"""Version of the measurement; increase it whenever the measurement changes."""
_BLOCKS, _BULK_STEPS, _SURFACE_STEPS = 10, 1500, 2000
"""Number of blocks of a mean, whose scatter gives its error, and time steps of each."""
_SETTLING = 2000
"""Time steps before averaging, in which the start is forgotten."""
_DAMPING = 40
"""Time constant of the thermostat, in time steps: little more than the period of the fastest vibration."""
_LAYERS = 16
"""Largest number of mobile layers; in a deeper slab the additional layers are those of the middle."""
_WIDTH = 8
"""Smallest number of surface atoms of the slab along x and y."""
_SEED = 12345


@dataclass(frozen=True)
class WarmCrystal:
    """Positions of the atoms of a crystal at a temperature, in a0 of that temperature unless noted."""

    temperature: float
    """k_B T, in E* a0³ of the crystal at rest."""
    stretch: float
    """Lattice constant over that at rest."""
    stretch_error: float
    """Standard error of the stretch."""
    pressure: float
    """Remaining pressure of the last run, in E*, positive in compression; the stretch is corrected for it."""
    rise: tuple[float, ...]
    """Rise of each layer of a slab above its lattice site, from the surface down to the frozen base; empty without."""
    rise_error: float
    """Standard error of the rise of the surface."""

    def rise_of(self, slab: Slab) -> Real:
        """Rise of each layer of a slab, shape (layers,), in a0."""
        half = len(self.rise) // 2
        deep = np.full(slab.mobile - len(self.rise), np.mean(self.rise[half - 1 : half + 1]))
        return np.concatenate([self.rise[:half], deep, self.rise[half:], np.zeros(slab.frozen)])


def warm_crystal(
    model: _Crystal,
    temperature: float,
    mobile: int,
    folder: Path,
    progress: Progress | None = None,
) -> WarmCrystal:
    """A crystal at a temperature: read from a folder if it is there, else measured and stored.

    Parameters
    ----------
    model : the crystal at rest.
    temperature : k_B T, in its E* a0³.
    mobile : number of mobile layers of the slab; zero for the lattice constant alone, in a third of the time, as of all
        other slabs than fcc(100).
    folder : folder of the files, made if needed; nothing is stored if that fails.
    progress : called after each run of a measurement with the number of finished runs and of all.

    Raises LammpsError if LAMMPS fails.
    """
    layers = min(mobile, _LAYERS)
    content = {
        "version": VERSION,
        "model": dict(model.identity),
        "temperature": float(f"{temperature:.12g}"),
        "layers": layers,
    }
    key = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    path = Path(folder) / f"warm-{key[:32]}.json"
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        return WarmCrystal(**(found | {"rise": tuple(found["rise"])}))
    except (OSError, ValueError, TypeError, KeyError):
        pass  # missing or damaged: measured again
    bulk = warm_crystal(model, temperature, 0, folder, progress) if layers else None
    warm = measure_warm_crystal(model, temperature, layers, progress, bulk)
    try:
        output.folder(path.parent)
        output.save(path, json.dumps(asdict(warm), indent=2) + "\n", own=True)
    except OutputError:
        pass  # the next one measures again
    return warm


def measure_warm_crystal(
    model: _Crystal,
    temperature: float,
    layers: int = _LAYERS,
    progress: Progress | None = None,
    bulk: WarmCrystal | None = None,
) -> WarmCrystal:
    """Measure the lattice constant of a periodic crystal at zero pressure, then the layers of a slab on a frozen base.

    The lattice constant follows from three runs: two with their secant, and a third whose pressure is corrected for.
    The pressure is that of the virial and of an ideal gas, N k_B T/V, whose mean is exact.  The arguments are those of
    :func:`warm_crystal`; ``layers`` of the slab move, and without any only the lattice constant is measured; ``bulk``
    has it already.
    """
    tell = progress or (lambda done, total: None)
    bulk = bulk or measure_bulk(model, temperature, tell)
    if not layers:
        return bulk
    warm = cast(CrystalModel, model.stretched(bulk.stretch))
    rise, rise_error = surface_rise(warm, temperature * bulk.stretch**-3, layers)
    tell(4, 4)
    return replace(bulk, rise=rise, rise_error=rise_error)


def measure_bulk(model: _Crystal, temperature: float, tell: Progress) -> WarmCrystal:
    """The lattice constant at a temperature, without the layers of a slab."""
    stretch, stiffness = 1.0, model.dilation  # -dp/d ln(a), at rest
    pressure, error = stretch_pressure(model, temperature, stretch, _BLOCKS // 2)
    tell(1, 4)
    for done, blocks in enumerate((_BLOCKS // 2, _BLOCKS), 2):
        before, step = pressure, pressure / stiffness
        stretch *= 1 + step
        pressure, error = stretch_pressure(model, temperature, stretch, blocks)
        tell(done, 4)
        # A warm crystal is softer; after a small step the difference is dominated by noise.
        if before > 10 * error:
            stiffness = (before - pressure) / step
    stretch *= 1 + pressure / stiffness
    return WarmCrystal(temperature, stretch, error / stiffness, pressure, (), 0.0)


def stretch_pressure(model: _Crystal, temperature: float, stretch: float, blocks: int) -> tuple[float, float]:
    """Mean pressure of a periodic crystal, in E*, and its standard error."""
    block = model.supercell
    edge = block.edge * model.length * stretch
    positions = edge * block.sites
    gas = len(positions) * temperature / (block.volume * stretch**3)  # in E*: V in a0³ at rest
    with Cell(model, positions, edge * block.periods, types=block.types) as cell:
        _warm_up(cell, model, temperature, "all")
        cell.command(
            f"fix mean all ave/time 10 {_BULK_STEPS // 10} {_BULK_STEPS} c_pressure[1] c_pressure[2] c_pressure[3]"
        )
        found = []
        for _ in range(blocks):
            cell.command(f"run {_BULK_STEPS} post no")
            found.append(np.mean([cell.fix("mean", i) for i in range(3)]))
        virial = np.array(found) / cell.pressure_unit * model.length**3 / model.energy
    return float(virial.mean() + gas), float(virial.std(ddof=1) / np.sqrt(blocks))


def surface_rise(model: CrystalModel, temperature: float, layers: int) -> tuple[tuple[float, ...], float]:
    """Mean rise of each mobile layer of a slab above its sites, in a0 of the model, and the error of the first."""
    width = max(_WIDTH, least_width(model))
    slab = Slab((width, width), layers, model.coupled_layers)
    per_layer = width * width
    sites = slab.positions.reshape(-1, 3)
    with Cell(model, sites * model.length, np.array(slab.shape) * model.length, surface=True) as cell:
        cell.command(f"group mobile id <= {slab.mobile * per_layer}", "group base subtract all mobile")
        cell.command("fix freeze base setforce 0 0 0")
        _warm_up(cell, model, temperature, "mobile")
        found = []
        for _ in range(_BLOCKS):
            cell.command(f"fix place mobile ave/atom 10 {_SURFACE_STEPS // 10} {_SURFACE_STEPS} z")
            cell.command(f"run {_SURFACE_STEPS} post no")
            z = cell.per_atom("place")[: slab.mobile * per_layer] / model.length
            cell.command("unfix place")
            found.append((z - sites[: z.size, 2]).reshape(slab.mobile, per_layer).mean(axis=1))
    rise = np.array(found)
    error = rise[:, 0].std(ddof=1) / np.sqrt(_BLOCKS)
    return tuple(float(value) for value in rise.mean(axis=0)), float(error)


def _warm_up(cell: Cell, model: AnyModel, temperature: float, group: str) -> None:
    """Atoms of a group under Newton's law and a thermostat, settled."""
    kelvin = temperature * model.energy / BOLTZMANN[model.units]
    timestep = vibration_timestep(model) * time_unit(model)
    cell.command(
        f"timestep {timestep:.17g}",
        f"velocity {group} create {2 * kelvin:.17g} {_SEED} dist gaussian mom no",
        f"fix motion {group} nve",
        f"fix thermostat {group} langevin {kelvin:.17g} {kelvin:.17g} {_DAMPING * timestep:.17g} {_SEED}",
        f"run {_SETTLING} post no",
        "reset_timestep 0",  # means are taken over multiples of their number of steps
    )
