"""Tables and figures of a deck run and of the trace of a wall in a script, and the wall of each step as a mesh."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from atomistic.lammps.directory import wall_mesh
from atomistic.lammps.result import HCP, DeckResult, DeckStatus, read_result
from atomistic.lammps.trace import WallTrace
from atomistic.relax.deckrun import ContinuumStep, DeckSteps
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.units import per_area, readable
from continuum.measure.contact import contact_map
from continuum.show.plot import PAGE, SERIES, contact_image, legend_under, letter_panels, new_axes, save_figure, styled
from continuum.store.output import save as save_file
from continuum.store.sheet import Column, Entry, Sheet, pairs, words

_JUMP = 0.25
"""Change of the contact area from one step to the next that is drawn as a jump."""
_UNITS = {"area_rep": "", "temperature": "K"}
_KINDS = {"load": "nN", "lateral": "nN", "pull": "nN", "distance": "Å", "offset": "Å", "smallest": "Å"}


def deck_run_sheets(run: DeckSteps, beside: tuple[ContinuumStep, ...] = (), remark: str = "") -> list[Sheet]:
    """The last step in detail, all steps of a protocol, and the comparison with the continuum."""
    sheets = [replace(_last(run), note="\n".join([*_starts(run), *filter(None, [remark])]))]
    if run.description.steps:
        sheets[:0] = [_steps(run), *_balance(run), *_friction(run)]
    if beside:
        sheets.append(_compared(run, beside))
    return sheets


def _steps(run: DeckSteps) -> Sheet:
    along, moves = run.slides, bool(run.last.averages)
    columns = {f"offset {along} (a0)": f"offset_{along}"} if along else {"separation (a0)": "separation"}
    if run.description.pressure is not None:
        columns["separation (a0)"] = "separation"
    columns |= {"mean gap (a0)": "mean_gap", "N/A0 (E*)": "load"}
    if moves:
        columns["± N/A0"] = "load_error"
    if along:
        columns |= {"friction/A0 (E*)": f"lateral_{along}", "± friction": f"lateral_{along}_error"}
    columns["A_rep/A0"] = "area_rep"
    if moves and not along:
        columns["± A_rep/A0"] = "area_rep_error"
    columns |= {"A_att/A0": "area_att"} | (
        {"k_B T (E* a0³)": "temperature"} if moves else {"evaluations": "evaluations"}
    )
    if run.description.relaxed:
        columns["moved (a0)"] = "moved"
    hold = run.description.hold
    cells: dict[str, Sequence[Entry]] = {
        "step": range(1, len(run.steps) + 1),
        **{head: [getattr(step, name) for step in run.steps] for head, name in columns.items()},
        "status": [words(step.status) if i >= hold else "coming to rest" for i, step in enumerate(run.steps)],
    }
    if any(step.slipped for step in run.steps):
        cells["slipped atoms"] = [step.slipped for step in run.steps]
        if all(step.faulted >= 0 for step in run.steps):
            cells["hcp atoms"] = [step.faulted for step in run.steps]
    if (real := run.description.real_units) is not None and not along:
        cells["N/A0 (GPa)"] = [real.to_si(step.load, "pressure") / scipy.constants.giga for step in run.steps]
    missing = run.expected - len(run.steps)
    notes = [f"{missing} of {run.expected} steps are not done: the same command goes on with them"] if missing else []
    notes = [*_means(run), *_yield(run), *notes]
    title = f"{run.directory.name}: steps"
    heads = tuple(Column(head, "", ".2g" if head.startswith("±") else ".4g") for head in cells)
    return Sheet.of(title, heads, zip(*cells.values(), strict=True), "\n".join(notes))


def _friction(run: DeckSteps) -> list[Sheet]:
    """Load and friction of a sliding wall in real units, and friction over a compressive load."""
    if not run.slides:
        return []
    real, area, named = (
        run.description.real_units,
        run.last.slab.grid.area,
        {"N": "load", "friction": f"lateral_{run.slides}"},
    )
    cells: dict[str, Sequence[Entry]] = {
        "step": range(1, len(run.steps) + 1),
        "friction/N": [
            getattr(step, named["friction"]) / step.load if step.load > 3 * step.load_error else None
            for step in run.steps
        ],
    }
    if real is not None:
        giga, nano = scipy.constants.giga, scipy.constants.nano
        for head, name in named.items():
            cells[f"{head}/A0 (GPa)"] = [real.to_si(getattr(step, name), "pressure") / giga for step in run.steps]
        for head, name in named.items():
            cells[f"{head} (nN)"] = [real.to_si(getattr(step, name) * area, "force") / nano for step in run.steps]
    return [Sheet.of("Friction and load", tuple(cells), zip(*cells.values(), strict=True))]


def _yield(run: DeckSteps) -> list[str]:
    """The first step in which atoms have slipped, with its load, whether that stays, and what else does."""
    i, real = run.yielded, run.description.real_units

    def told(load: float, error: float | None = None) -> str:
        value = f"{load:.4g}" if error is None else f"{load:.4g} ± {error:.1g}"
        return f"{value} E*" + ("" if real is None else f" ({readable(real.to_si(load, 'pressure'), 'pressure')})")

    if i is None:
        borne = [step.load for step in run.steps if DeckStatus[step.status].ok]
        if run.description.bonded or not borne or any(step.slipped for step in run.steps):
            return []
        return [f"No atom has slipped, up to N/A0 = {told(max(borne))}."]
    step = run.steps[i]

    faults = f", {step.faulted} stand in stacking faults (hcp)" if step.faulted >= 0 else ""
    held = f"; before it the crystal held {told(run.steps[i - 1].load)}" if i else ""
    lines = [
        f"The crystal has slipped in step {i + 1}: {step.slipped} atoms have other nearest neighbours{faults}, "
        f"N/A0 = {told(step.load)}{held}."
    ]
    if (first := run.first_yield) is not None:
        apart, half = first.separation
        lines.append(
            f"First yield, half way between steps {i} and {i + 1}: separation {apart:.4g} ± {half:.1g} a0, "
            f"N/A0 = {told(*first.load)}, mean contact pressure {told(*first.pressure)}."
        )
    if run.unloaded is None:
        return [*lines, "Whether that is plastic is not known: no later step is unloaded."]
    after = run.steps[run.unloaded]
    answers = {
        True: f"unloaded, {after.slipped} still have: it is plastic",
        False: "unloaded, none has: it sprang back, and is not plastic",
        None: f"{after.slipped} still have at N/A0 = {told(after.load)}: withdraw the wall further to see what stays",
    }
    lines.append(f"In step {run.unloaded + 1}, {answers[run.plastic]}.")
    if (stays := run.imprint) is not None:
        lines.append(
            f"Off the surface, {stays.displaced} atoms are further than half of a0 from their places, the imprint "
            f"is {stays.depth:.2f} a0 deep, and {100 * stays.recovered:.0f} % of the work came back."
        )
    return lines


def _starts(run: DeckSteps) -> list[str]:
    """Number of relaxed starts that are at rest in LAMMPS, and the one that is farthest from it."""
    looked_at = list(enumerate(run.steps[: run.description.relaxed], 1))
    if not looked_at:
        return []
    wrong = [(i, step) for i, step in looked_at if not step.start_force <= run.last.tolerance]
    lines = [
        f"{len(looked_at) - len(wrong)} of {len(looked_at)} starts that were relaxed before are at rest in LAMMPS."
    ]
    if wrong:
        i, step = max(wrong, key=lambda one: one[1].moved)
        lines.append(
            f"Farthest from it is that of step {i}: a force of {step.start_force:.2g} E* a0² was left on an atom, and "
            f"an atom moved by {step.moved:.2g} a0.  A start that is far off is that of another wall or crystal: write "
            "the deck again."
        )
    return lines


def _means(run: DeckSteps) -> list[str]:
    """Means over the windows in which the wall slides or rests, a line each, with warnings."""
    if not run.averaged:
        return []
    real, area = run.description.real_units, run.last.slab.grid.area
    named = {"friction over A0": f"lateral_{run.slides}"} if run.slides else {}
    named |= {"N/A0": "load", "A_rep/A0": "area_rep"}
    lines = [f"Means over the {len(run.averaged)} windows in which the wall {'slides' if run.slides else 'rests'}:"]
    for words_of, name in named.items():
        found = run.mean(name)
        unit = "" if name == "area_rep" else " E*"
        if unit and real is not None:
            pressure, force = real.to_si(found.mean, "pressure"), real.to_si(found.mean * area, "force")
            unit += f" ({readable(pressure, 'pressure')}, {force / scipy.constants.nano:.4g} nN)"
        lines.append(f"  {words_of}: {found.mean:.4g} ± {found.error:.1g}{unit}.  {found.doubts}".rstrip())
    if (ratio := run.friction) is not None:
        lines.append(f"  Friction coefficient: {ratio.mean:.4g} ± {ratio.error:.1g}.  {ratio.doubts}".rstrip())
    return lines + _kept(run)


def _kept(run: DeckSteps) -> list[str]:
    """The prescribed mean pressure of the wall, and whether it was kept."""
    asked = run.description.pressure
    if asked is None:
        return []
    load, height = run.mean("load"), run.mean("separation")
    said = f"  The wall was to keep N/A0 = {asked:.6g} E*: its height is {height.mean:.4g} ± {height.error:.1g} a0."
    if abs(load.mean - asked) <= 3 * load.error:
        return [said]
    apart = abs(load.mean - asked) / load.error if load.error else np.inf
    return [
        f"{said}  The load is {apart:.3g} standard errors from it: the wall has not come to rest yet (hold, dwell, or "
        "slide for longer), or the contact does not hold this tension while it slides."
    ]


def _temperatures(run: DeckSteps) -> str:
    """Note about the temperature of the atoms and of the continuum."""
    description = run.description
    if not description.temperature:
        return "Atoms and continuum are at rest, at 0 K."
    real = description.real_units
    kelvin = "" if real is None else f" ({real.to_si(description.temperature, 'temperature'):.4g} K)"
    return (
        f"The atoms are at k_B T = {description.temperature:.4g} E* a0³{kelvin}, the continuum at rest at 0 K; "
        "gaps count from the surface of each at its own temperature."
    )


def _last(run: DeckSteps) -> Sheet:
    last, step, real = run.last, run.steps[-1], run.description.real_units
    area = last.slab.grid.area
    rows: list[tuple[str, Entry]] = [
        ("separation", f"{last.separation:.10g} a0"),
        ("mean gap", f"{last.mean_gap:.10g} a0"),
        ("normal force N", f"{last.force:.10g} E* a0²"),
        ("repulsive force N_rep", f"{last.load_rep:.10g} E* a0²"),
        ("A_rep/A0", f"{last.area_rep:.6g}"),
        ("A_att/A0", f"{last.area_att:.6g}"),
        ("work of adhesion of the law", per_area(run.wall.work_of_adhesion, real)),
        ("total energy", f"{last.total_energy:.10g} E* a0³"),
        ("largest force left", f"{last.largest_force:.3g} E* a0²"),
        ("force evaluations", last.evaluations),
        ("LAMMPS", str(last.lammps_version)),
        ("status", DeckStatus[step.status].value),
    ]
    if real is not None:
        rows[3:3] = [
            ("normal force N", f"{real.to_si(last.force, 'force') / scipy.constants.nano:.10g} nN"),
            ("mean pressure", f"{real.to_si(last.force / area, 'pressure') / scipy.constants.giga:.10g} GPa"),
        ]
    if last.lateral_x or last.lateral_y:  # of a wall that follows the atoms
        rows.insert(3, ("lateral force on the atoms", f"{last.lateral_x:.10g}, {last.lateral_y:.10g} E* a0²"))
    return pairs("End of the last window" if last.averages else "Equilibrium of the deck", rows)


def _balance(run: DeckSteps) -> list[Sheet]:
    """Energy that atoms and wall got while the wall slides or rests, over A0 and, with a size, of the whole."""
    found = run.balance
    if found is None:
        return []
    real, area = run.description.real_units, run.last.slab.grid.area
    kept_load = run.description.pressure is not None

    def said(value: float, error: float = 0.0) -> str:
        mark = f" ± {error:.1g}" if np.isfinite(error) and error else ""
        whole = "" if real is None else f" ({real.to_si(value * area, 'energy') / scipy.constants.eV:.4g} eV)"
        return f"{value:.4g}{mark} E* a0{whole}"

    rows: list[tuple[str, Entry]] = [(f"work of the wall along {run.slides}", said(found.along))] if run.slides else []
    rows.append((f"work of {'the load' if kept_load else 'the wall'}, up and down", said(found.up)))
    if kept_load:
        rows.append(("from the wall that keeps it", said(-found.taken, found.taken_error)))
    rows += [
        ("heat from the thermostat", said(found.heat)),
        ("kept by atoms and wall", said(found.kept)),
        ("left over, by time steps and sampling", said(found.left)),
    ]
    return [pairs(f"Energy over A0 got in the {len(run.averaged)} windows of the means", rows)]


def _compared(run: DeckSteps, beside: tuple[ContinuumStep, ...]) -> Sheet:
    names = ("step", "mean gap (a0)", "N/A0, atoms (E*)", "N/A0, continuum (E*)", "difference/(N_rep + N_att)",
             "A_rep/A0, atoms", "A_rep/A0, continuum", "same contact", "continuum")  # fmt: skip
    rows: list[tuple[Entry, ...]] = [
        (i, step.mean_gap, step.load, other.load,
         (other.load - step.load) / gross if (gross := step.load_rep + step.load_att) else None,
         step.area_rep, other.area_rep, other.same,
         "converged" if other.converged else "not converged")
        for i, (step, other) in enumerate(zip(run.steps, beside, strict=True), 1)
    ]  # fmt: skip
    note = f"The continuum is {run.response} under the same wall, at the mean gap of the atoms.\n{_temperatures(run)}"
    return Sheet.of("Beside the continuum", tuple(map(Column, names)), rows, note)


@styled
def draw_deck_run(run: DeckSteps, beside: tuple[ContinuumStep, ...] = ()) -> Figure:
    """Load and areas against separation, in the order of the steps, and the contact with the largest A_rep."""
    figure, (load, area, contact) = new_axes(PAGE, 2.9, 1, 3)
    along = run.slides
    x = np.array([getattr(step, f"offset_{along}" if along else "separation") for step in run.steps])
    real = run.description.real_units
    scale = 1.0 if real is None else real.si("pressure") / scipy.constants.giga

    reversal = len(x) if along else int(np.argmin(x)) + 1
    jumped = np.abs(np.diff([step.area_rep + step.area_att for step in run.steps])) > _JUMP

    def draw(axes: Axes, name: str, factor: float, label: str, colour: str) -> None:
        values = np.array([factor * getattr(step, name) for step in run.steps])
        errors = np.array([factor * getattr(step, f"{name}_error") for step in run.steps])
        for some, fill, way in ((slice(0, reversal), colour, label), (slice(reversal, None), "white", None)):
            if values[some].size:
                axes.errorbar(x[some], values[some], errors[some] if errors.any() else None, fmt="o", color=colour,
                              markerfacecolor=fill, label=way, zorder=3)  # fmt: skip
        # No line is drawn across a jump.
        for i, jump in enumerate(jumped):
            axes.plot(x[i : i + 2], values[i : i + 2], ":" if jump else "-", color="0.6" if jump else colour, lw=0.9)

    draw(load, "load", scale, "load" if along else "atoms", SERIES[0])
    if along:
        draw(load, f"lateral_{along}", scale, "friction", SERIES[5])
    draw(area, "area_rep", 1.0, "repulsive", SERIES[5])
    draw(area, "area_att", 1.0, "attracted", SERIES[0])
    if beside:
        for name, colour in (("area_rep", SERIES[5]), ("area_att", SERIES[0])):
            area.plot(x, [getattr(step, name) for step in beside], "x", color=colour, zorder=4)
        area.plot([], [], "x", color="0.3", label="continuum")
        load.plot(x, [scale * step.load for step in beside], "x", color=SERIES[1], label="continuum", zorder=4)
    if reversal < len(x):
        load.plot([], [], "o", color=SERIES[0], markerfacecolor="white", label="on the way back")
    if jumped.any():
        load.plot([], [], ":", color="0.6", label="jump")
    load.axhline(0, color="grey", linewidth=0.6)
    place = f"offset along {along} ($a_0$)" if along else "separation ($a_0$)"
    load.set(xlabel=place, ylabel="$N/A_0$ (GPa)" if real is not None else "$N/A_0$ ($E^*$)")
    area.set(xlabel=place, ylabel="$A/A_0$", ylim=(-0.03, 1.03))
    grid = run.last.slab.grid
    widest = int(np.argmax([step.area_rep for step in run.steps]))
    contact_image(contact, contact_map(run.wall, run.last.slab.on_grid(run.gaps[widest])), grid.lengths)
    marked = "; x: slipped" if run.slips[widest].any() else ""
    if marked:
        places = np.nonzero(run.last.slab.on_grid(run.slips[widest]))
        at = [(i + 0.5) * step for i, step in zip(places, grid.spacing, strict=True)]
        contact.plot(*at, "x", color=SERIES[2], markersize=3)
    contact.set(xlabel="x ($a_0$)", ylabel="y ($a_0$)")
    letter_panels((load, area, contact), ("load", "areas", f"contact, step {widest + 1}{marked}"))
    for axis in (load, area):
        legend_under(axis, 0.3)
    return figure


@styled
def draw_trace(run: DeckSteps) -> Figure:
    """Friction, load and separation of each sample while the wall slides, against its way: stick and slip."""
    figure, axes = new_axes(PAGE, 2.9, 1, 3)
    trace, along, real = run.trace, run.slides, run.description.real_units
    scale, unit = (1.0, "E^*") if real is None else (real.si("pressure") / scipy.constants.giga, r"\mathrm{GPa}")
    moving = trace["window"] > run.description.hold + run.description.dwell
    way = trace[f"offset_{along}"][moving]
    for axis, name, factor, label, colour in zip(
        axes, (f"lateral_{along}", "load", "separation"), (scale, scale, 1.0),
        (f"friction$/A_0$ (${unit}$)", f"$N/A_0$ (${unit}$)", "separation ($a_0$)"), (SERIES[5], SERIES[0], SERIES[1]),
        strict=True,
    ):  # fmt: skip
        axis.plot(way, factor * trace[name][moving], "-", color=colour, lw=0.5)
        axis.set(xlabel=f"offset along {along} ($a_0$)", ylabel=label)
    letter_panels(axes, ("friction", "load", "height"))
    return figure


@styled
def draw_slip(run: DeckSteps) -> Figure:
    """Load against separation with the first yield, and atoms that slipped, at the deepest and at the last step."""
    figure, axes = new_axes(PAGE, 2.9, 1, 3)
    load, *views = axes
    real, first = run.description.real_units, run.first_yield
    scale = 1.0 if real is None else real.si("pressure") / scipy.constants.giga
    loads = scale * np.array([step.load for step in run.steps])
    x, slipped = np.array([step.separation for step in run.steps]), np.array([step.slipped > 0 for step in run.steps])
    last, deepest = len(x) - 1, int(np.argmin(x))
    load.plot(x[: deepest + 1], loads[: deepest + 1], "-", color="0.6", lw=0.9)
    load.plot(x[deepest:], loads[deepest:], "--", color="0.6", lw=0.9, label="on the way back")
    for some, fill, label in ((~slipped, "white", "no atom slipped"), (slipped, SERIES[5], "slipped")):
        load.plot(x[some], loads[some], "o", color=SERIES[5], markerfacecolor=fill, label=label)
    if first is not None:
        (at, half), (held, error) = first.separation, first.load
        load.errorbar(at, scale * held, scale * error, half, fmt="none", color="black", label="first yield", zorder=4)
    load.axhline(0, color="grey", linewidth=0.6)
    load.set(xlabel="separation ($a_0$)", ylabel="$N/A_0$ (GPa)" if real is not None else "$N/A_0$ ($E^*$)")
    states = [deepest if deepest < last else int(np.argmax(slipped)), last]
    for axis, i in zip(views, states, strict=True):
        _draw_atoms(axis, read_result(run.directory, i + 1))
    letter_panels(axes, ("load", *(f"step {i + 1}: {run.steps[i].slipped} slipped" for i in states)))
    legend_under(load, 0.3)
    legend_under(views[0], 0.3)
    return figure


def _draw_atoms(axis: Axes, state: DeckResult) -> None:
    """Side view of all atoms that slipped or stand in stacking faults, before those in the plane of the deepest."""
    slab = state.slab
    at, slipped = slab.positions.reshape(-1, 3) + state.displacements.reshape(-1, 3), state.slipped.ravel()
    faulted = np.zeros(slab.size, np.bool_)
    if state.faulted > 0 and state.structure is not None:
        faulted = state.structure.ravel() == HCP
    off = at[:, 1] - at[np.argmin(at[: slab.surface_atoms, 2]), 1]
    in_plane = np.abs(off - slab.grid.lengths[1] * np.rint(off / slab.grid.lengths[1])) < 0.5
    for some, colour, label in (
        (in_plane & ~slipped & ~faulted, "0.8", "as at rest"),
        (slipped & ~faulted, SERIES[5], "other neighbours"),
        (faulted, SERIES[2], "stacking fault"),
    ):
        axis.plot(at[some, 0] % slab.grid.lengths[0], at[some, 2], "o", color=colour, markersize=3.5, label=label)
    axis.set(xlabel="x ($a_0$)", ylabel="z ($a_0$)", aspect="equal")


def write_run(run: DeckSteps, folder: Path, beside: tuple[ContinuumStep, ...] = ()) -> list[Path]:
    """Write a run in every form of :data:`WRITERS`; returns the files."""
    stem = folder / run.directory.resolve().name
    return [path for write in WRITERS for path in write(run, stem, beside)]


def _meshes(run: DeckSteps, stem: Path, beside: tuple[ContinuumStep, ...]) -> Iterator[Path]:
    """The wall of each step."""
    for i, step in enumerate(run.steps, 1):
        mark = f".{i}" if run.description.steps else ""
        level = step.separation + run.description.surface
        offset, grid = (step.offset_x, step.offset_y), run.last.slab.grid
        mesh = wall_mesh(run.heights, level, run.description.length, offset, grid.spacing)
        yield save_file(stem.with_name(f"{stem.name}-wall{mark}.vtk"), mesh)


WRITERS: list[Callable[[DeckSteps, Path, tuple[ContinuumStep, ...]], Iterable[Path]]] = [
    lambda run, stem, beside: [run.store(stem.with_name(f"{stem.name}.h5"), beside)],
    lambda run, stem, beside: [save_figure(draw_deck_run(run, beside), stem)],
    lambda run, stem, beside: (
        [] if run.yielded is None else [save_figure(draw_slip(run), stem.with_name(f"{stem.name}-slip"))]
    ),
    lambda run, stem, beside: (
        [save_figure(draw_trace(run), stem.with_name(f"{stem.name}-trace"))] if run.slides and run.trace else []
    ),
    _meshes,
]
"""Forms in which a run is written: each makes files whose names begin as the stem does, beside the continuum or not."""


def _unit(name: str) -> str:
    return _UNITS.get(name, _KINDS.get(name.split("_")[0], "eV"))


def trace_sheet(trace: WallTrace) -> Sheet:
    """Mean, standard error, least and largest value of each quantity; and the friction of a wall that slides."""
    rows: list[tuple[Entry, ...]] = []
    for name in (name for name in trace if name != "step"):
        if not np.any(trace[name]):
            continue
        rows.append((name, *trace.mean(name), float(trace[name].min()), float(trace[name].max()), _unit(name)))
    for along in ("x", "y"):
        if np.ptp(trace[f"offset_{along}"]) > 0:
            try:
                rows.append((f"lateral_{along}/load", *trace.friction(along), "", "", ""))
            except ArgumentError:  # without a load there is none
                continue
    columns = ("quantity", Column("mean"), Column("±"), "least", "largest", "unit")
    notes = ["The approach is included; in Python `a.read_trace(FILE).after(STEP)` leaves out the first steps."]
    if any(row[0] == "temperature" for row in rows):
        notes.append("The temperature includes the atoms that are held at rest, which lower it.")
    return Sheet.of(f"{trace.samples} samples of the wall", columns, rows, "\n".join(notes))


@styled
def draw_wall_trace(trace: WallTrace) -> Figure:
    """Friction, load and distance of each sample: against the way of a wall that slides, else against the step."""
    figure, axes = new_axes(PAGE, 2.9, 1, 3)
    along = max("xy", key=lambda name: float(np.ptp(trace[f"offset_{name}"])))
    slides = float(np.ptp(trace[f"offset_{along}"])) > 0
    at = trace[f"offset_{along}"] if slides else trace["step"]
    names = (f"lateral_{along}", "load", "distance")
    for axis, name, label, colour in zip(
        axes, names, ("lateral force (nN)", "load (nN)", "distance (Å)"), (SERIES[5], SERIES[0], SERIES[1]), strict=True
    ):
        axis.plot(at, trace[name], "-", color=colour, lw=0.5)
        axis.set(xlabel=f"way along {along} (Å)" if slides else "time step", ylabel=label)
    letter_panels(axes, ("friction", "load", "height"))
    return figure
