"""A run of a deck, for people: tables, figures, and the wall of each step as a mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.constants
from matplotlib.figure import Figure

from atomistic.lammps.mesh import wall_mesh
from atomistic.lammps.result import DeckStatus
from atomistic.relax.deckrun import ContinuumStep, DeckRun
from continuum.files.output import save as save_file
from continuum.measure.contact import contact_map
from continuum.show.plot import SERIES, contact_image, new_figure, save, styled
from continuum.show.sheet import Column, Entry, Sheet, pairs

__all__ = ["draw_run", "run_sheets", "write_run"]


def run_sheets(run: DeckRun, beside: tuple[ContinuumStep, ...] = ()) -> list[Sheet]:
    """The last step in detail; with a protocol all steps; the continuum beside them."""
    sheets = [_last(run)]
    if run.description.steps:
        sheets.insert(0, _steps(run))
    if beside:
        sheets.append(_compared(run, beside))
    return sheets


def _steps(run: DeckRun) -> Sheet:
    real = run.description.real_units
    names = ["step", "separation", "mean gap", "N/A0", "A_rep/A0", "A_att/A0", "evaluations", "status"]
    units = ["", "a0", "a0", "E*", "", "", "", ""]
    columns = [Column(f"{name} ({unit})" if unit else name) for name, unit in zip(names, units, strict=True)]
    rows: list[tuple[Entry, ...]] = []
    for i, step in enumerate(run.steps, 1):
        row: tuple[Entry, ...] = (
            i, step.separation, step.mean_gap, step.load, step.area_rep, step.area_att, step.evaluations,
            step.status.lower().replace("_", " "),
        )  # fmt: skip
        rows.append(row if real is None else (*row, step.load * real.si("pressure") / scipy.constants.giga))
    if real is not None:
        columns.append(Column("N/A0 (GPa)"))
    missing = run.expected - len(run.steps)
    note = f"{missing} of {run.expected} steps are not done: the same command goes on with them" if missing else ""
    return Sheet.of(f"{run.directory.name}: steps", columns, rows, note)


def _last(run: DeckRun) -> Sheet:
    last, step, real = run.last, run.steps[-1], run.description.real_units
    atoms = last.gap.size
    rows: list[tuple[str, Entry]] = [
        ("separation", f"{step.separation:.10g} a0"),
        ("mean gap", f"{step.mean_gap:.10g} a0"),
        ("load N", f"{last.load:.10g} E* a0²"),
        ("repulsive load N_rep", f"{step.load_rep * atoms:.10g} E* a0²"),
        ("A_rep/A0", f"{step.area_rep:.6g}"),
        ("A_att/A0", f"{step.area_att:.6g}"),
        ("total energy", f"{last.total_energy:.10g} E* a0³"),
        ("largest force left", f"{last.largest_force:.3g} E* a0²"),
        ("force evaluations", last.evaluations),
        ("LAMMPS", str(last.lammps_version)),
        ("status", DeckStatus[step.status].value),
    ]
    if real is not None:
        rows[3:3] = [
            ("load N", f"{real.to_si(last.load, 'force') / scipy.constants.nano:.10g} nN"),
            ("mean pressure", f"{real.to_si(step.load, 'pressure') / scipy.constants.giga:.10g} GPa"),
        ]
    if last.lateral_x or last.lateral_y:  # of a wall that follows the atoms
        rows.insert(3, ("lateral force on the atoms", f"{last.lateral_x:.10g}, {last.lateral_y:.10g} E* a0²"))
    return pairs("Equilibrium of the deck", rows)


def _compared(run: DeckRun, beside: tuple[ContinuumStep, ...]) -> Sheet:
    names = ("step", "mean gap (a0)", "N/A0, atoms (E*)", "N/A0, continuum (E*)", "A_rep/A0, atoms",
             "A_rep/A0, continuum", "same contact", "continuum")  # fmt: skip
    rows: list[tuple[Entry, ...]] = [
        (i, step.mean_gap, step.load, other.load, step.area_rep, other.area_rep, other.same,
         "converged" if other.converged else "not converged")
        for i, (step, other) in enumerate(zip(run.steps, beside, strict=True), 1)
    ]  # fmt: skip
    note = "The continuum is an isotropic half-space of nu = 1/2 under the same wall, at the mean gap of the atoms."
    return Sheet.of("Beside the continuum", tuple(map(Column, names)), rows, note)


def write_run(run: DeckRun, folder: Path, beside: tuple[ContinuumStep, ...] = ()) -> list[Path]:
    """Write HDF5 file, figures, and the wall of each step as a mesh; returns them."""
    name = run.directory.resolve().name
    stored = run.store(folder / f"{name}.h5", beside)
    written = [stored, save(draw_run(run, beside), folder / name)]
    for i, step in enumerate(run.steps, 1):
        mark = f".{i}" if run.description.steps else ""
        level = step.separation + run.description.surface
        mesh = wall_mesh(run.last.heights, level, run.description.length)
        written.append(save_file(folder / f"{name}-wall{mark}.vtk", mesh))
    return written


@styled
def draw_run(run: DeckRun, beside: tuple[ContinuumStep, ...] = ()) -> Figure:
    """Load and areas against separation, in the order of the steps, and the contact where A_rep is largest."""
    figure = new_figure(7.0, 2.6)
    load, area, contact = figure.subplots(1, 3)
    gaps = np.array([step.separation for step in run.steps])
    real = run.description.real_units
    scale = 1.0 if real is None else real.si("pressure") / scipy.constants.giga
    load.plot(gaps, [scale * step.load for step in run.steps], "o-", color=SERIES[0], label="atoms")
    for values, label, colour in (("area_rep", "repulsive", SERIES[5]), ("area_att", "attracted", SERIES[0])):
        area.plot(gaps, [getattr(step, values) for step in run.steps], "o-", color=colour, label=label)
        if beside:
            area.plot(gaps, [getattr(step, values) for step in beside], "x:", color=colour)
    if beside:
        load.plot(gaps, [scale * step.load for step in beside], "x:", color=SERIES[1], label="continuum")
        load.legend()
    load.axhline(0, color="grey", linewidth=0.6)
    load.set(xlabel="separation ($a_0$)", ylabel="$N/A_0$ (GPa)" if real is not None else "$N/A_0$ ($E^*$)")
    area.set(xlabel="separation ($a_0$)", ylabel="$A/A_0$", ylim=(-0.03, 1.03))
    area.legend()
    grid = run.last.slab.grid
    widest = int(np.argmax([step.area_rep for step in run.steps]))
    contact_image(contact, contact_map(run.wall, run.gaps[widest]), grid.lengths)
    contact.set(xlabel="x ($a_0$)", ylabel="y ($a_0$)", title=f"contact, step {widest + 1}")
    return figure
