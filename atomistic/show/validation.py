"""Sheets of a validation, and its page of HTML, from its stored file only."""

from pathlib import Path

import numpy as np

from atomistic.config.validate import ValidateConfig
from atomistic.ladder import budget
from atomistic.ladder.archive import Archive
from atomistic.ladder.comparison import GEOMETRY, STEPS
from atomistic.ladder.ensemble import untested
from atomistic.ladder.rungs import WORDS
from atomistic.ladder.validate import Validation
from atomistic.show.figures import draw_all
from continuum.sheet import Column, Entry, Sheet, pairs
from continuum.show.page import Page
from continuum.units import GPA_PER_EV_PER_A3


def validation_sheets(validation: Validation) -> list[Sheet]:
    """The tables of a validation that are not empty: error budget, its signed parts, scaling, jumps, verdicts."""
    stored = validation.stored
    sheets = (budget_sheet(stored), _closed_sheet(stored), _scaling(stored), _jumps(stored), _tolerances(validation))
    return [sheet for sheet in sheets if sheet.rows]


def budget_sheet(archive: Archive) -> Sheet:
    """Errors of the steps of the ladder, by case and slope."""
    columns = archive.columns
    measured = [step for step in (STEPS | GEOMETRY) if f"{step}_load" in columns]
    costs = list(budget.costs(columns, tuple(measured)))
    # The total last, after the parts of the nonlinearity.
    steps = [step for step in costs[0].load if step != "total"] + ["total"]
    rows: list[tuple[Entry, ...]] = [
        (
            cost.case,
            cost.lambda_s,
            cost.rms_slope,
            *(cost.load[step] for step in steps),
            *(cost.contact[step] for step in ("nonlinearity", "total")),
            f"{cost.load_ratio[0]:.2f} - {cost.load_ratio[1]:.2f}",
        )
        for cost in costs
    ]
    first = costs[0]
    notes = [
        f"Read: with lambda_s = {first.lambda_s:g} a0 and h'rms = {first.rms_slope:g} ({first.case}) the load of the "
        f"half-space, which production runs use, is right to {100 * first.load['total']:.1f} % of N_rep.",
        "  ".join(f"{step}: {WORDS[coarse]} against {WORDS[fine]}." for step, (coarse, fine) in STEPS.items()),
    ]
    if "geometry" in measured:
        notes.append(
            "geometry: the nonlinearity of springs under the same wall at the same mean gap.  anharmonicity: the rest "
            "of the nonlinearity."
        )
    notes.append(
        "*load of the half-space over that of the lattice at equal separation; all else at equal mean gap, lattice "
        "against atoms at equal separation"
    )
    heads = (
        Column("case"), Column("λ_s", "a0", "g"), Column("h'rms", "", "g"),
        *(Column(step, "%", ".2f") for step in (*steps, "contact nonlinearity", "contact total")),
        Column("mean compliance*"),
    )  # fmt: skip
    title = "Error budget: largest difference of the load, relative to N_rep, and points whose contact differs"
    return Sheet.of(title, heads, rows, "\n".join(notes))


def _closed_sheet(archive: Archive) -> Sheet:
    """Signed parts of the budget at one area, and the total."""

    def text(mean: float, error: float) -> str:
        if not np.isfinite(mean):
            return "-"
        return f"{100 * mean:+.2f}" + (f" ± {100 * error:.2f}" if np.isfinite(error) else "")

    rows: list[tuple[Entry, ...]] = [
        (line.case, line.rms_slope, line.area, line.branch, f"{line.surfaces} of {line.of}",
         *(text(*part) for part in line.parts.values()))
        for line in budget.closed(archive.columns, STEPS)
    ]  # fmt: skip
    heads = (
        Column("case"), Column("h'rms", "", "g"), Column("A_rep/A0", "", "g"), Column("branch"), Column("surfaces"),
        *(Column(step) for step in STEPS),
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


def _jumps(archive: Archive) -> Sheet:
    columns = archive.columns
    jumping = set(columns["case"][columns["place"] != "area"].tolist())
    i, j = (columns["rung"].tolist().index(rung) for rung in ("lattice", "atoms"))
    heads = (
        Column("case"), Column("branch"), Column("state"), Column("separation", "a0", ".3f"),
        Column("A_rep/A0: lattice", "%", ".2f"), Column("atoms", "%", ".2f"), Column("N/A0: lattice", "E*", ".5f"),
        Column("atoms", "E*", ".5f"), Column("difference of all that acts", "%", "+.2f"),
        Column("max |du|", "a0", ".4f"), Column("evaluations"), Column("largest force", "E* a0²", ".1e"),
    )  # fmt: skip
    rows = [
        (case, str(columns["branch"][s]), f"A_rep/A0 = {columns['area'][s]:g}" if place == "area" else place,
         *(float(columns[name][k, s]) for name, k in (("separation", i), ("area_rep", i), ("area_rep", j),
                                                      ("load", i), ("load", j))),
         float(columns["nonlinearity_gross_load"][s]), float(columns["nonlinearity_displacement"][s]),
         int(columns["evaluations"][s]), float(columns["largest_force"][s]))
        for s, (case, place) in enumerate(zip(columns["case"].tolist(), columns["place"].tolist(), strict=True))
        if case in jumping
    ]  # fmt: skip
    title = "Branch by branch: lattice Green's function against atoms, at equal separation"
    return Sheet.of(title, heads, rows, "Evaluations of forces include the certificate.")


def _tolerances(validation: Validation) -> Sheet:
    config = validation.config
    notes = [
        f"{case.name}: no bound on what differs.  Not tested by the ensemble: {said}."
        for case in config.case
        if not case.tolerance and (said := untested(config, case))
    ]
    return Sheet.of(
        "Tolerances: lattice Green's function against atoms",
        ("case", "quantity", "bound", "worst / limit", "states", "worst state", "verdict", "why this bound"),
        [
            [v.case, v.quantity, v.bound, f"{v.measured:.3g} / {v.limit:.4g}", str(v.states), v.state,
             "holds" if v.holds else "FAILS", v.reason]
            for v in validation.verdicts
        ],
        "\n".join(notes),
    )  # fmt: skip


def write_validation(validation: Validation) -> list[Path]:
    """Draw the figures and write the page, beside the file of the validation; returns the page and the PNG files.

    The page says how many bounds hold, and has the tables, the figures, the substrate and the input.
    """
    stored, config, path = validation.stored, validation.config, validation.path
    figures = draw_all(stored, path.parent, path.stem)
    made: list[tuple[str, Entry]] = [
        (name.removeprefix("provenance/"), str(value))
        for name, value in stored.attributes.items()
        if name.startswith("provenance/")
    ]
    page = Page(
        f"{path.stem}: Green's functions against atoms",
        f"{validation.sentence}.  Lengths are in a0, pressures in E*, unless said otherwise.",
        figures=[(figure, figure.stem) for figure in figures],
        sheets=[_substrate(stored, config), *validation_sheets(validation), pairs("Made with", made)],
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
