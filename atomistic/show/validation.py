"""Sheets and figures of a validation, and its page of HTML, from its stored file only."""

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import budget
from atomistic.ladder.archive import Archive
from atomistic.ladder.budget import BoundVerdict
from atomistic.ladder.comparison import GEOMETRY, LAYERS, STEPS, StepName
from atomistic.ladder.ensemble import untested
from atomistic.ladder.rungs import CONTINUUM_RUNGS, RUNGS, WORDS
from continuum.inputs.units import GPA_PER_EV_PER_A3, Units, per_area
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace, Layer
from continuum.show import plot
from continuum.show.page import Page
from continuum.store.sheet import Column, Entry, Sheet, pairs

LABELS = WORDS | {"half-space": "half-space, ν = 1/2", "layer": "layer, ν = 1/2", "atoms": "atoms (LAMMPS)"}
_CHECKED = {"long waves": ("half-space", "crystal"), "law in LAMMPS": ("law",)}
"""Checks that need no other run, as the answer names them."""
_TOTAL_FIRST = ("total", *(step for step in STEPS if step != "total"))
_FAILED = 4
"""Failed bounds that the answer names."""
_UNFELT = 1e-3
"""Relative difference of a stiffness by the base that no load shows: the budget is told to a tenth of a per cent."""
_WIDE = 3
"""Largest number of panels in a row for which a title with wall and slope fits into one line."""
_COLOURS = dict(zip(RUNGS, plot.SERIES, strict=False))
_LINES = (("-", 3.0), ("--", 1.2), ("-.", 1.2), ("-", 1.2))
"""Style and width of the lines of the continuum rungs: the first lies below the second, which it nearly equals."""


def validation_statements(config: ValidateConfig, stored: Archive, verdicts: Sequence[BoundVerdict]) -> list[str]:
    """The answer in at most nine lines: what was judged and by what, the worst states, the error of the half-space."""
    failed = [verdict for verdict in verdicts if not verdict.holds]
    found = [sentence_of(config, verdicts)]
    if failed:
        found += [f"FAILS: {verdict.told}" for verdict in failed[:_FAILED]]
        found += [f"and {len(failed) - _FAILED} more, in the tables"] if len(failed) > _FAILED else []
    elif differs := [verdict for verdict in verdicts if verdict.step in STEPS]:
        # That the atoms are in equilibrium is asked before they are compared.
        found.append(f"Nearest to its bound: {max(differs, key=_nearness).told}")
    worst = max(budget.costs(stored.columns, ("total",)), key=lambda cost: cost.load["total"])
    states, cases = stored.columns["evaluations"].size, stored.columns["case"].tolist()
    systems = len(set(zip(cases, *(stored.columns[name].tolist() for name in ("rms_slope", "seed")), strict=True)))
    judges = list(dict.fromkeys(verdict.reason for verdict in verdicts if verdict.step in STEPS))
    others = f"; {len(judges) - 1} more reasons in the tables" if judges[1:] else ""
    return [
        *found,
        f"Load of the half-space against that of atoms: {100 * worst.load['total']:.1f} % of N_rep + N_att at worst, "
        f"in {worst.case} at h'rms = {worst.rms_slope:g}",
        *(f"Bounds: {reason}{others}" for reason in judges[:1]),
        f"Looked at: {states} equilibria of atoms in {systems} systems of {len(set(cases))} cases; tables with -v",
    ]


def sentence_of(config: ValidateConfig, verdicts: Sequence[BoundVerdict]) -> str:
    """Each step of the ladder, the total first: its largest load and what is allowed; what was not judged, and why."""

    def percent(value: float) -> str:
        return f"{100 * value:.2g} %"

    said, missing = list[str](), list[str]()
    for step in _TOTAL_FIRST:
        # One that fails before all that hold.
        if of := _of_load(verdicts, step):
            worst = max(of, key=lambda one: (not one.holds, _size(one)))
            words = f"{percent(worst.measured * worst.scale)} of {percent(worst.limit * worst.scale)}"
            said.append(f"half-space against atoms: {words} allowed" if step == "total" else f"{step} {words}")
    for name, steps in _CHECKED.items():
        if of := [v for v in verdicts if v.step in steps]:
            worst = max(of, key=_nearness)
            said.append(f"{name} {worst.measured:.1g} of {worst.limit:.1g}")
        else:
            missing.append(name)
    if unjudged := "; ".join((*_unjudged(config, verdicts), *missing)):
        said.append(f"not judged: {unjudged}")
    holding = sum(verdict.holds for verdict in verdicts)
    fails = f", {len(verdicts) - holding} FAIL" if holding < len(verdicts) else ""
    return f"{'; '.join(said)}; {holding} of {len(verdicts)} bounds hold{fails}"


def _of_load(verdicts: Sequence[BoundVerdict], step: StepName, case: str | None = None) -> list[BoundVerdict]:
    """The bounds on the load of a step, of one case or of all."""
    return [
        verdict
        for verdict in verdicts
        if verdict.step == step and case in (None, verdict.case) and verdict.quantity.startswith(("load", "gross load"))
    ]


def _unjudged(config: ValidateConfig, verdicts: Sequence[BoundVerdict]) -> list[str]:
    """The steps whose load has no bound, and the cases in which they have none, with the reason of each."""
    alike: dict[tuple[StepName, ...], list[str]] = {}
    for case in config.case:
        steps = tuple(step for step in _TOTAL_FIRST if not _of_load(verdicts, step, case.name))
        reason = f" (outside the ensemble: {said})" if (said := untested(config, case)) else ""
        alike.setdefault(steps, []).append(case.name + reason)
    return [
        f"{', '.join(steps).replace('total', 'half-space against atoms')} in {', '.join(cases)}"
        for steps, cases in alike.items()
        if steps
    ]


def _size(verdict: BoundVerdict) -> float:
    size = verdict.measured * verdict.scale
    return size if np.isfinite(size) else np.inf


def _nearness(verdict: BoundVerdict) -> float:
    """Difference over its bound; a difference that is no number is beyond any bound."""
    return verdict.measured / verdict.limit if np.isfinite(verdict.measured) else np.inf


def validation_sheets(config: ValidateConfig, stored: Archive, verdicts: Sequence[BoundVerdict]) -> list[Sheet]:
    """The tables of a validation that are not empty: error budget, its signed parts, scaling, jumps, verdicts."""
    sheets = (
        budget_sheet(config, stored), _beside_the_load(stored), _closed_sheet(config, stored), _scaling(stored),
        *_jumps(stored), _tolerances(config, verdicts),
    )  # fmt: skip
    return [sheet for sheet in sheets if sheet.rows]


def _base_is_felt(config: ValidateConfig) -> float:
    """Relative difference of the stiffness of half-space and layer in the longest wave of the slab."""
    grid, depth = Grid.square(config.slab.n), config.slab.depth
    layer, half_space = (one.stiffness(grid)[0, 1] for one in (Layer(depth, 0.5, "clamped"), HalfSpace("clamped")))
    return abs(float(layer / half_space) - 1)


def _steps_of(config: ValidateConfig) -> list[StepName]:
    """Steps of the ladder but the depth of a slab whose base no wave of the wall feels: zero by construction."""
    return [step for step in STEPS if step != "depth" or _base_is_felt(config) > _UNFELT]


def _unfelt(config: ValidateConfig) -> list[str]:
    """Reason why the depth is not a column."""
    if "depth" in _steps_of(config):
        return []
    return [
        f"depth has no column here: the base, {config.slab.depth:.4g} a0 below the surface, makes the longest wave "
        f"stiffer by {100 * _base_is_felt(config):.1g} %, and shorter ones by less."
    ]


def budget_sheet(config: ValidateConfig, archive: Archive) -> Sheet:
    """Errors of the steps of the ladder, by case and slope."""
    columns = archive.columns
    measured = [step for step in (STEPS | LAYERS | GEOMETRY) if f"{step}_load" in columns]
    costs = list(budget.costs(columns, tuple(measured)))
    # The total last, after the parts of the nonlinearity.
    left_out = set(STEPS) - set(_steps_of(config))
    steps = [step for step in costs[0].load if step != "total" and step not in left_out] + ["total"]
    rows: list[tuple[Entry, ...]] = [
        (cost.case, cost.lambda_s, cost.rms_slope, *(cost.load[step] for step in steps)) for cost in costs
    ]
    first = costs[0]
    notes = [
        f"Read: with lambda_s = {first.lambda_s:g} a0 and h'rms = {first.rms_slope:g} ({first.case}) the load of the "
        f"half-space, which production runs use, is right to {100 * first.load['total']:.1f} % of N_rep + N_att.",
        "  ".join(f"{step}: {WORDS[STEPS[step][0]]} against {WORDS[STEPS[step][1]]}." for step in _steps_of(config)),
        *_unfelt(config),
    ]
    if "layers" in measured:
        notes.append(
            "layers: the whole law at the surface of the lattice, against its parts on every layer it reaches."
        )
    if "geometry" in measured:
        notes.append(
            "geometry: the nonlinearity of springs under the same wall at the same mean gap.  anharmonicity: the rest "
            "of the nonlinearity."
        )
    notes.append("All at equal mean gap, lattice against atoms at equal separation.")
    heads = (
        Column("case"), Column("λ_s", "a0", "g"), Column("h'rms", "", "g"), *(Column(one, "%", ".2f") for one in steps)
    )  # fmt: skip
    title = "Error budget: largest difference of the load, relative to N_rep + N_att"
    return Sheet.of(title, heads, rows, "\n".join(notes))


def _beside_the_load(archive: Archive) -> Sheet:
    """Points whose contact differs, and what a comparison at equal separation would say."""
    costs = budget.costs(archive.columns, tuple(STEPS))
    rows = [
        (cost.case, cost.lambda_s, cost.rms_slope, cost.contact["nonlinearity"], cost.contact["total"],
         f"{cost.load_ratio[0]:.2f} - {cost.load_ratio[1]:.2f}")
        for cost in costs
    ]  # fmt: skip
    heads = (
        Column("case"), Column("λ_s", "a0", "g"), Column("h'rms", "", "g"), Column("contact nonlinearity", "%", ".2f"),
        Column("contact total", "%", ".2f"), Column("mean compliance"),
    )  # fmt: skip
    note = (
        "mean compliance: load of the half-space over that of the lattice at equal separation, least and largest.  The "
        "lattice also yields as a whole, between surface and base; the budget leaves this out by equal mean gaps."
    )
    return Sheet.of("Points whose contact differs, and mean compliance", heads, rows, note)


def _closed_sheet(config: ValidateConfig, archive: Archive) -> Sheet:
    """Signed parts of the budget at one area, and the total."""

    def text(mean: float, error: float) -> str:
        if not np.isfinite(mean):
            return "-"
        return f"{100 * mean:+.2f}" + (f" ± {100 * error:.2f}" if np.isfinite(error) else "")

    rows: list[tuple[Entry, ...]] = [
        (line.case, line.rms_slope, line.area, line.branch, f"{line.surfaces} of {line.of}",
         *(text(*line.parts[step]) for step in _steps_of(config)))
        for line in budget.closed(archive.columns, STEPS)
    ]  # fmt: skip
    heads = (
        Column("case"), Column("h'rms", "", "g"), Column("A_rep/A0", "", "g"), Column("branch"), Column("surfaces"),
        *(Column(step) for step in _steps_of(config)),
    )  # fmt: skip
    notes = (
        "Mean over the surfaces, and its standard error, in % of all that acts on the atoms, N_rep + N_att; positive "
        "where the coarser model carries more.  Every rung stands where as many points are repulsive as on the "
        "lattice; a surface on which one of them jumps over that is left out.  The parts add up to the total by "
        "construction: that they do is no test."
    )
    return Sheet.of("Signed parts of the budget: differences of the load at equal area", heads, rows, notes)


def _scaling(archive: Archive) -> Sheet:
    fits = [fit for fit in budget.exponents(archive.columns) if fit.adhesion_length == 0]
    heads = (
        Column("case"), Column("quantity"), Column("seed"), Column("A_rep/A0", "", "g"), Column("h'rms"),
        Column("fitted", "", ".3f"), Column("between neighbours"),
    )  # fmt: skip
    rows = [
        (fit.case, fit.quantity, fit.seed, fit.area, ", ".join(f"{h:g}" for h in fit.slopes), fit.fitted,
         ", ".join(f"{local:.3f}" for local in fit.local))
        for fit in fits
    ]  # fmt: skip
    title = "Scaling of the nonlinearity with h'rms (expected without adhesion: load 1, displacement 2)"
    return Sheet.of(title, heads, rows)


def _jumps(archive: Archive) -> list[Sheet]:
    """States around jumps: lattice beside atoms, and how far the atoms were relaxed."""
    columns = archive.columns
    jumping = set(columns["case"][columns["place"] != "area"].tolist())
    i, j = (columns["rung"].tolist().index(rung) for rung in ("lattice", "atoms"))
    named = (Column("case"), Column("branch"), Column("state"))
    heads = (
        *named, Column("separation", "a0", ".3f"), Column("A_rep/A0: lattice", "%", ".2f"), Column("atoms", "%", ".2f"),
        Column("N/A0: lattice", "E*", ".5f"), Column("atoms", "E*", ".5f"),
        Column("difference of all that acts", "%", "+.2f"),
    )  # fmt: skip
    further = (
        *named, Column("max |du|", "a0", ".4f"), Column("evaluations"), Column("largest force", "E* a0²", ".1e")
    )  # fmt: skip
    rows, relaxed = list[tuple[Entry, ...]](), list[tuple[Entry, ...]]()
    for s, (case, place) in enumerate(zip(columns["case"].tolist(), columns["place"].tolist(), strict=True)):
        if case not in jumping:
            continue
        state = case, str(columns["branch"][s]), f"A_rep/A0 = {columns['area'][s]:g}" if place == "area" else place
        pairs_of = (("separation", i), ("area_rep", i), ("area_rep", j), ("load", i), ("load", j))
        difference = float(columns["nonlinearity_gross_load"][s])
        rows.append((*state, *(float(columns[name][k, s]) for name, k in pairs_of), difference))
        moved, force = float(columns["nonlinearity_displacement"][s]), float(columns["largest_force"][s])
        relaxed.append((*state, moved, int(columns["evaluations"][s]), force))
    title = "Branch by branch: lattice Green's function against atoms, at equal separation"
    note = "Evaluations of forces include the certificate."
    return [Sheet.of(title, heads, rows), Sheet.of("The same states: displacements and work", further, relaxed, note)]


def _tolerances(config: ValidateConfig, verdicts: Sequence[BoundVerdict]) -> Sheet:
    notes = [
        f"{case.name} is outside the ensemble, which has no bound for it: {said}."
        for case in config.case
        if (said := untested(config, case))
    ]
    for reason in dict.fromkeys(verdict.reason for verdict in verdicts):
        notes.append(f"Bound of {', '.join(_bounded_by(reason, verdicts))}: {reason}.")
    notes.append("Values: the states that were compared; of crystal and half-space the waves, of the law the gaps.")
    return Sheet.of(
        "Bounds: each step of the ladder, the total, and checks that need no other run",
        ("case", "step", "quantity", "bound", "worst / limit", "values", "worst state", "verdict"),
        [
            [v.case or "all", v.step, v.quantity, v.bound, f"{v.measured:.3g} / {v.limit:.4g}", str(v.states), v.state,
             "holds" if v.holds else "FAILS"]
            for v in verdicts
        ],
        "\n".join(notes),
    )  # fmt: skip


def _bounded_by(reason: str, verdicts: Sequence[BoundVerdict]) -> list[str]:
    """The steps whose bounds have this reason; with case and quantity where another bound of the step has another."""
    others = [other for other in verdicts if other.reason != reason]
    steps, in_case = {one.step for one in others}, {(one.step, one.case) for one in others}

    def name(one: BoundVerdict) -> str:
        if one.step not in steps:
            return one.step
        here = f"{one.step} ({one.quantity})" if (one.step, one.case) in in_case else one.step
        return f"{here} in {one.case}" if one.case else here

    return list(dict.fromkeys(name(one) for one in verdicts if one.reason == reason))


def write_validation(
    path: Path, config: ValidateConfig, stored: Archive, verdicts: Sequence[BoundVerdict], sentence: str
) -> list[Path]:
    """Draw the figures and write the page, beside the file of the validation; returns the page and the PNG files.

    The page says in a sentence how many bounds hold, and has the tables, the figures, the substrate and the input.
    """
    figures = draw_all(stored, path.parent, path.stem)
    made: list[tuple[str, Entry]] = [
        (name.removeprefix("provenance/"), str(value))
        for name, value in stored.attributes.items()
        if name.startswith("provenance/")
    ]
    page = Page(
        f"{path.stem}: Green's functions against atoms",
        f"{sentence}.  Lengths are in a0, pressures in E*, unless said otherwise.",
        figures=[(figure, figure.stem) for figure in figures],
        sheets=[
            _substrate(stored, config),
            _works(stored, config),
            *validation_sheets(config, stored, verdicts),
            pairs("Made with", made),
        ],
        listing=("Input", config.source.text) if config.source else None,
    )
    return [page.write(path.with_suffix(".html")), *figures]


def _substrate(archive: Archive, config: ValidateConfig) -> Sheet:
    known = archive.attributes
    n, depth = config.slab.n, config.slab.depth
    rows: list[tuple[str, Entry]] = [("slab", f"{n} x {n} surface atoms, {depth:g} a0 deep")]
    if "model/reference" in known:
        rows.append(("model", str(known["model/reference"])))
        constants = ", ".join(f"{float(known[f'model/{name}']):.5f}" for name in ("c11", "c12", "c44"))
        rows.append(("C11, C12, C44", f"{constants} E*"))
        a0, modulus = (float(known[f"model/{name}"]) for name in ("a0", "contact_modulus"))
        if known["model/units"] == "metal":
            rows.append(("a0", f"{a0:.5f} Å"))
            rows.append(("E*", f"{modulus * GPA_PER_EV_PER_A3:.2f} GPa"))
        rise = float(known["model/surface_relaxation"])
        rows.append(("surface plane at rest", f"{rise:+.5f} a0 from its lattice sites: there the gap begins"))
    return pairs("Substrate", rows)


def _works(archive: Archive, config: ValidateConfig) -> Sheet:
    """The work of adhesion of each case; of a crystal with units in those, too."""
    known = archive.attributes
    real = None
    if known.get("model/units") == "metal":
        real = Units.metal(float(known["model/a0"]), float(known["model/contact_modulus"]))
    return pairs("Work of adhesion", [(case.name, per_area(case.adhesion_length, real)) for case in config.case])


def draw_all(archive: Archive, folder: Path, stem: str) -> list[Path]:
    """Draw every figure into a folder, as PNG and PDF; returns the PNG files."""
    figures = {"contact": rung_contact_maps(archive), "curves": curves(archive), "scaling": scaling(archive)}
    return [
        plot.save_figure(figure, folder / f"{stem}-{name}") for name, figure in figures.items() if figure is not None
    ]


@plot.styled
def rung_contact_maps(archive: Archive) -> Figure:
    """Contact on the lattice Green's function and on atoms, side by side, and the points that differ.

    A row for each case: its steepest slope, first surface and a middle area.
    """
    columns = archive.columns
    rows = [_shown_states(archive, case)[1] for case in dict.fromkeys(columns["case"].tolist())]
    figure, axes = plot.new_axes(plot.PAGE, 2.3 * len(rows) + 0.5, len(rows), 3, squeeze=False)
    nx, ny = columns["contact"].shape[2:]
    i, j = RUNGS.index("lattice"), RUNGS.index("atoms")
    titles = []
    differs: Any = {"marker": "s", "linestyle": "", "markerfacecolor": "none", "markeredgecolor": plot.DIFFERENT_COLOUR}
    for state, row in zip(rows, axes, strict=True):
        a, b = columns["contact"][i, state], columns["contact"][j, state]
        for axis, kinds in ((row[0], a), (row[1], b)):
            plot.contact_image(axis, kinds, (float(nx), float(ny)))
        plot.contact_image(row[2], b, (float(nx), float(ny)), alpha=0.25)
        for x, y in np.argwhere(a != b):
            row[2].plot(x + 0.5, y + 0.5, markersize=4, **differs)
        area = rf"$A_\mathrm{{rep}}/A_0$ = {columns['area_rep'][j, state]:.3f}"
        differ = int(np.count_nonzero(a != b))
        row[0].set_ylabel(f"{columns['case'][state]}\n{_wall_and_slope(archive, state)}\ny ($a_0$)")
        titles += [LABELS["lattice"], f"{LABELS['atoms']}\n{area}", f"{differ} of {a.size} atoms differ"]
    for axis in axes[-1]:
        axis.set_xlabel("x ($a_0$)")
    plot.letter_panels(axes.flat, titles)
    plot.legend_below(figure, [*plot.contact_key(), Line2D([], [], label="differs", **differs)])
    return figure


def _shown_states(archive: Archive, case: str) -> tuple[NDArray[np.intp], int]:
    """The states of a case of the steepest slope and the first surface; and the one of them of a middle area."""
    columns = archive.columns
    mine = np.flatnonzero(columns["case"] == case)
    mine = mine[columns["rms_slope"][mine] == columns["rms_slope"][mine].max()]
    mine = mine[columns["seed"][mine] == columns["seed"][mine][0]]
    areas = columns["area"][mine]
    return mine, int(mine[np.argsort(areas)[len(areas) // 2]])


@plot.styled
def curves(archive: Archive) -> Figure | None:
    """Repulsive area and load against mean gap on the lattice along the approach, and the load differences of other
    rungs.

    The rungs would lie within a line's width: area and load are drawn for one, the others as differences.
    Atoms are points, at the areas of the input.
    """
    columns = archive.columns
    if "curve_case" not in columns:
        return None
    cases = list(dict.fromkeys(columns["curve_case"].tolist()))
    atoms, titles = RUNGS.index("atoms"), []
    width = plot.PAGE if len(cases) > 1 else plot.COLUMN
    figure, axes = plot.new_axes(width, 5.6, 3, len(cases), squeeze=False, sharex="col")
    for case, (area_axis, load_axis, difference_axis) in zip(cases, axes.T, strict=True):
        along = {
            rung: {
                name: columns[f"curve_{name}"][(columns["curve_case"] == case) & (columns["curve_rung"] == rung)]
                for name in ("mean_gap", "area_rep", "load")
            }
            for rung in CONTINUUM_RUNGS
        }
        mine, middle = _shown_states(archive, case)
        mine = mine[columns["branch"][mine] == "approach"]
        points = {name: columns[name][atoms, mine] for name in ("mean_gap", "area_rep", "load")}
        lattice = along["lattice"]
        order = np.argsort(lattice["mean_gap"])
        at_points = np.interp(points["mean_gap"], lattice["mean_gap"][order], lattice["load"][order])
        for (rung, curve), (style, width) in zip(along.items(), _LINES, strict=True):
            look = {"color": _COLOURS[rung], "label": LABELS[rung], "linestyle": style, "linewidth": width}
            if rung == "lattice":
                area_axis.plot(*plot.broken(curve["mean_gap"], curve["area_rep"]), **look)
                load_axis.plot(*plot.broken(curve["mean_gap"], curve["load"]), **look)
            difference_axis.plot(*plot.broken(curve["mean_gap"], 1e4 * (curve["load"] - lattice["load"])), **look)
        look = {"color": _COLOURS["atoms"], "markerfacecolor": "none", "label": LABELS["atoms"]}
        area_axis.plot(points["mean_gap"], points["area_rep"], "o", **look)
        load_axis.plot(points["mean_gap"], points["load"], "o", **look)
        difference_axis.plot(points["mean_gap"], 1e4 * (points["load"] - at_points), "o", **look)
        load_axis.axhline(0, color="0.7", linewidth=0.6, zorder=0)
        gap = "\n" if len(cases) > _WIDE else ", "
        titles.append(f"{case}\n{_wall_and_slope(archive, middle, gap)}")
        difference_axis.set_xlabel("mean gap ($a_0$)")
    axes[0, 0].set_ylabel(r"repulsive area $A_\mathrm{rep}/A_0$")
    axes[1, 0].set_ylabel("load $N/(E^* A_0)$")
    axes[2, 0].set_ylabel("load minus lattice's\n$\\Delta N/(10^{-4} E^* A_0)$")
    plot.letter_panels(axes.flat, titles)
    plot.legend_below(figure, plot.labelled(axes[2, 0]))
    return figure


def _wall_and_slope(archive: Archive, state: int, gap: str = ", ") -> str:
    length, slope = (archive.columns[name][state] for name in ("adhesion_length", "rms_slope"))
    return rf"$\ell_a$ = {length:g} $a_0${gap}$h'_\mathrm{{rms}}$ = {slope:g}"


@plot.styled
def scaling(archive: Archive) -> Figure | None:
    """Load and displacement difference of lattice response and atoms against the slope, without adhesion."""
    columns = archive.columns
    plain = columns["adhesion_length"] == 0
    fits = [fit for fit in budget.exponents(columns) if fit.adhesion_length == 0]
    if not fits:
        return None
    figure, (left, right) = plot.new_axes(plot.PAGE, 3.4, 1, 2)
    titles = []
    colours = dict(zip(sorted({fit.area for fit in fits}), cycle(plot.SERIES), strict=False))
    markers = dict(zip(sorted({fit.seed for fit in fits}), "osv^D", strict=False))
    for axis, quantity, expected, label in (
        (left, "load", 1, r"load difference $|\Delta N|/N_\mathrm{rep}$"),
        (right, "displacement", 2, "largest displacement difference ($a_0$)"),
    ):
        mine = [fit for fit in fits if fit.quantity == quantity]
        for fit in mine:
            at = plain & (columns["seed"] == fit.seed) & (columns["area"] == fit.area)
            h = columns["rms_slope"][at]
            values = np.abs(columns[f"nonlinearity_{quantity}"][at])
            order = np.argsort(h)
            look = {"marker": markers.get(fit.seed, "o"), "color": colours[fit.area], "markerfacecolor": "none"}
            axis.loglog(h[order], values[order], linewidth=0.8, **look)
        h = np.array(sorted({slope for fit in mine for slope in fit.slopes}))
        flattest = columns[f"nonlinearity_{quantity}"][plain & (columns["rms_slope"] == h[0])]
        top = max(float(np.abs(flattest).max()), 1e-300)
        axis.loglog(h, 2 * top * (h / h[0]) ** expected, "-", color="0.6", linewidth=2, zorder=0)
        fitted = np.array([fit.fitted for fit in mine])
        titles.append(
            f"line: exponent {expected}\nfitted: {fitted.mean():.3f}, from {fitted.min():.3f} to {fitted.max():.3f}"
        )
        axis.set(xlabel=r"rms slope $h'_\mathrm{rms}$", ylabel=label)
    handles = [
        Line2D([], [], color=colour, label=rf"$A_\mathrm{{rep}}/A_0$ = {area:g}") for area, colour in colours.items()
    ]
    outlined: Any = {"color": "0.3", "markerfacecolor": "none", "linestyle": ""}
    handles += [Line2D([], [], marker=m, label=f"seed {s}", **outlined) for s, m in markers.items()]
    plot.log_ticks(left, right)
    plot.letter_panels((left, right), titles)
    plot.legend_below(figure, handles)
    return figure
