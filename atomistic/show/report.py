"""What a validation shows, in tables; and all of it on one page of HTML, from its stored file only."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from atomistic.config import ValidateConfig
from atomistic.validate import budget
from atomistic.validate.archive import Archive
from atomistic.validate.budget import Verdict
from atomistic.validate.validate import GEOMETRY, STEPS
from continuum.units import GPA_PER_EV_PER_A3

__all__ = ["Listing", "listings", "summary", "write_html"]


class Listing(NamedTuple):
    """A table in words."""

    title: str
    head: tuple[str, ...]
    rows: list[list[str]]
    note: str = ""


def listings(archive: Archive, verdicts: Sequence[Verdict]) -> list[Listing]:
    """The tables of a validation that hold something: its error budget, its scaling laws, its jumps, its verdicts."""
    all_of_them = (_budget(archive), _scaling(archive), _jumps(archive), _tolerances(verdicts))
    return [listing for listing in all_of_them if listing.rows]


def summary(verdicts: Sequence[Verdict]) -> str:
    """How many bounds hold."""
    failed = sum(not verdict.holds for verdict in verdicts)
    return f"{len(verdicts) - failed} of {len(verdicts)} bounds hold" + (f", {failed} FAIL" if failed else "")


def _budget(archive: Archive) -> Listing:
    columns = archive.columns
    measured = [step for step in (STEPS | GEOMETRY) if f"{step}_load" in columns]
    costs = list(budget.costs(columns, tuple(measured)))
    # The total last, after the parts of the nonlinearity.
    steps = [step for step in costs[0].load if step != "total"] + ["total"]
    rows = [
        [
            cost.case,
            f"{cost.lambda_s:g}",
            f"{cost.rms_slope:g}",
            *(f"{100 * cost.load[step]:.2f} %" for step in steps),
            *(f"{100 * cost.contact[step]:.2f} %" for step in ("nonlinearity", "total")),
            f"{cost.load_ratio[0]:.2f} - {cost.load_ratio[1]:.2f}",
        ]
        for cost in costs
    ]
    first = costs[0]
    notes = [
        f"Read: with lambda_s = {first.lambda_s:g} a0 and h'rms = {first.rms_slope:g} ({first.case}) the load of the "
        f"half-space, which production runs use, is right to {100 * first.load['total']:.1f} % of N_rep.",
        "depth: half-space against layer.  anisotropy: layer against cubic layer.  discreteness: cubic layer against "
        "lattice Green's function.  nonlinearity: lattice Green's function against atoms.  total: half-space against "
        "atoms.",
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
    head = ("case", "λ_s", "h'rms", *steps, "contact nonlinearity",
            "contact total", "mean compliance*")  # fmt: skip
    title = "Error budget: largest difference of the load, relative to N_rep, and points whose contact differs"
    return Listing(title, head, rows, "\n".join(notes))


def _scaling(archive: Archive) -> Listing:
    fits = [fit for fit in budget.exponents(archive.columns) if fit.adhesion_length == 0]
    return Listing(
        "Scaling of the nonlinearity with h'rms (expected without adhesion: load 1, displacement 2)",
        ("case", "quantity", "seed", "A_rep/A0", "h'rms", "fitted", "between neighbours"),
        [
            [fit.case, fit.quantity, str(fit.seed), f"{fit.area:g}", ", ".join(f"{h:g}" for h in fit.slopes),
             f"{fit.fitted:.3f}", ", ".join(f"{local:.3f}" for local in fit.local)]
            for fit in fits
        ],
    )  # fmt: skip


def _jumps(archive: Archive) -> Listing:
    columns = archive.columns
    jumping = set(columns["case"][columns["place"] != "area"].tolist())
    i, j = (columns["rung"].tolist().index(rung) for rung in ("lattice", "atoms"))
    area, load = 100 * columns["area_rep"], columns["load"]
    return Listing(
        "Branch by branch: lattice Green's function against atoms, at equal separation",
        ("case", "branch", "state", "separation", "A_rep/A0: lattice", "atoms", "N/(E* A0): lattice", "atoms",
         "difference of all that acts", "max |du|", "evaluations", "largest force"),
        [
            [case, columns["branch"][s], f"A_rep/A0 = {columns['area'][s]:g}" if place == "area" else place,
             f"{columns['separation'][i, s]:.3f}", f"{area[i, s]:.2f} %", f"{area[j, s]:.2f} %",
             f"{load[i, s]:.5f}", f"{load[j, s]:.5f}", f"{100 * columns['nonlinearity_gross_load'][s]:+.2f} %",
             f"{columns['nonlinearity_displacement'][s]:.4f}", str(columns["evaluations"][s]),
             f"{columns['largest_force'][s]:.1e}"]
            for s, (case, place) in enumerate(zip(columns["case"].tolist(), columns["place"].tolist(), strict=True))
            if case in jumping
        ],
        "Lengths in a0, forces left on an atom in E* a0²; evaluations of forces include the certificate.",
    )  # fmt: skip


def _tolerances(verdicts: Sequence[Verdict]) -> Listing:
    return Listing(
        "Tolerances: lattice Green's function against atoms",
        ("case", "quantity", "bound", "worst / limit", "states", "verdict", "why this bound"),
        [
            [v.case, v.quantity, v.bound, f"{v.measured:.3g} / {v.limit:g}", str(v.states),
             "holds" if v.holds else "FAILS", v.reason]
            for v in verdicts
        ],
    )  # fmt: skip


_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; font-size: 13px; margin: .5em 0; }
th, td { border-bottom: 1px solid #ddd; padding: .25em .7em; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid #888; }
p.note { font-size: 13px; color: #555; white-space: pre-line; }
img { max-width: 100%; } pre { font-size: 12px; background: #f6f6f6; padding: 1em; overflow-x: auto; }
.FAILS { color: #b00020; font-weight: bold; }
"""


def write_html(
    path: Path,
    title: str,
    config: ValidateConfig,
    archive: Archive,
    verdicts: Sequence[Verdict],
    figures: Sequence[Path],
) -> Path:
    """One self-contained page: the substrate, the tables, the figures (PNG files), the input; returns its path."""
    parts = [
        "<!doctype html>",
        f'<html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title><style>{_STYLE}</style>',
        f"<h1>{html.escape(title)}: Green's functions against atoms</h1>",
        f"<p>{html.escape(summary(verdicts))}.  Lengths are in a0, pressures in E*, unless said otherwise.</p>",
        _html(_substrate(archive, config)),
        *map(_html, listings(archive, verdicts)),
    ]
    for figure in figures:
        data = base64.b64encode(figure.read_bytes()).decode("ascii")
        name = html.escape(figure.stem)
        parts.append(f'<h2>{name}</h2><img alt="{name}" src="data:image/png;base64,{data}">')
    made = [[name.removeprefix("provenance/"), str(value)] for name, value in archive.attributes.items()
            if name.startswith("provenance/")]  # fmt: skip
    parts.append(_html(Listing("Made with", ("what", "version"), made)))
    if config.source:
        parts.append(f"<h2>Input</h2><pre>{html.escape(config.source.text)}</pre>")
    path.write_text("\n".join(parts) + "\n</html>\n", encoding="utf-8")
    return path


def _substrate(archive: Archive, config: ValidateConfig) -> Listing:
    known = archive.attributes
    n, depth = config.slab.n, config.slab.depth
    rows = [["slab", f"{n} x {n} surface atoms, {depth:g} a0 deep"]]
    if "model/reference" in known:
        rows.append(["model", str(known["model/reference"])])
        constants = ", ".join(f"{float(known[f'model/{name}']):.5f}" for name in ("c11", "c12", "c44"))
        rows.append(["C11, C12, C44", f"{constants} E*"])
        a0, modulus = (float(known[f"model/{name}"]) for name in ("a0", "contact_modulus"))
        if known["model/units"] == "metal":
            rows.append(["a0", f"{a0:.5f} Å"])
            rows.append(["E*", f"{modulus * GPA_PER_EV_PER_A3:.2f} GPa"])
        rise = float(known["model/surface_relaxation"])
        rows.append(["surface plane at rest", f"{rise:+.5f} a0 from its lattice sites: there the gap begins"])
    return Listing("Substrate", ("what", "value"), rows)


def _html(listing: Listing) -> str:
    head = "".join(f"<th>{html.escape(name)}</th>" for name in listing.head)
    rows = ["".join(map(_cell, row)) for row in listing.rows]
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    note = f'<p class="note">{html.escape(listing.note)}</p>' if listing.note else ""
    return f"<h2>{html.escape(listing.title)}</h2><table><tr>{head}</tr>{body}</table>{note}"


def _cell(text: str) -> str:
    marked = ' class="FAILS"' if text == "FAILS" else ""
    return f"<td{marked}>{html.escape(text)}</td>"
