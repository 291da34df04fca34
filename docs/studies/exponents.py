"""Exponents of λ_s at the threshold, from the record: the tables of docs/studies/exponents.md.

``python -m docs.studies.exponents``: the sheets of ``continuum plot dispute`` of thresholds with A_rep >= 10 λ_s²,
with 95 % intervals over surfaces and the number of thresholds in the range of Eq. (6); and, where two ranges are
compared, works at the threshold over those of the theories on the surfaces that both have.
"""

from __future__ import annotations

import csv
import sys
from functools import cache
from pathlib import Path

import numpy as np
from pandas import DataFrame

from continuum.maps.verdict.criteria import AREA, RoughContact
from continuum.paper.dispute import THEORIES, dispute_sheets
from continuum.paper.points import ENOUGH

COMPARED = (0.12, 0.08)
"""Ranges over h_rms that the page sets beside one another."""
SURFACES, THIN = 3, 0.2
"""Fewest surfaces of an exponent that the manual quotes, and the range over h_rms below which rims are thin."""


def thresholds() -> DataFrame:
    """The thresholds of the record as :func:`continuum.paper.dispute.crossovers` has them; periods are of 2 λ_L."""
    text = (Path(__file__).parent / "record" / "record.csv").read_text()
    rows = []
    for row in csv.DictReader(text.splitlines()):
        if row["source"] != "threshold":
            continue
        values = {name: float(value) for name, value in row.items() if name not in ("source", "law", "sticky")}
        contact = RoughContact(
            values["rms_height"], values["rms_slope"], values["rms_curvature"], values["work"], values["range"],
            conformal_energy=values["conformal_energy"], roll_off=values["lambda_L"],
        )  # fmt: skip
        rows.append({
            **{name: values[name] for name in ("hurst", "lambda_s", "lambda_L", "seed")},
            "law": row["law"], "range": round(values["range"] / values["rms_height"], 2), "peak": "",
            "contact": contact, "work": values["work"] * values["lambda_L"] / values["rms_height"] ** 2,
            "squares": AREA * (2 * values["lambda_L"] / values["lambda_s"]) ** 2,
        })  # fmt: skip
    return DataFrame(rows)


def matched(found: DataFrame) -> str:
    """Works at the threshold over those of the theories, of the same surfaces at both ranges, and λ_L/λ_s."""
    spline = found[(found.law == "spline") & (found.hurst == 0.8)].assign(
        width=lambda rows: rows.lambda_L / rows.lambda_s
    )
    both = set.intersection(*({(r.seed, r.width) for r in spline[spline["range"] == d].itertuples()} for d in COMPARED))
    same = spline[[(r.seed, r.width) in both for r in spline.itertuples()]]
    lines = [
        f"| Δr/h_rms | surfaces | thresholds | {' | '.join(theory.name for theory in THEORIES)} |",
        "|---" * 7 + "|",
    ]
    for reach in COMPARED:
        group = same[same["range"] == reach]
        means = [f"{np.exp(np.log(theory.margins(group)).mean()):.2f}" for theory in THEORIES]
        lines.append(f"| {reach} | {group.seed.nunique()} | {len(group)} | {' | '.join(means)} |")
    return "\n".join(lines)


def tables() -> str:
    """The sheets, and the works of both ranges."""
    found = many()
    return "\n\n".join([*(sheet.markdown() for sheet in dispute_sheets(found)), matched(found)])


def many() -> DataFrame:
    """The thresholds with enough contacts."""
    found = thresholds()
    return found[found.squares >= ENOUGH]


def fitted() -> DataFrame:
    """Exponents of each range, law and H: mean over surfaces, half its 95 % interval (0 of one surface), theories."""
    sheet, _ = dispute_sheets(many())
    rows = []
    for cells in sheet.rows:
        row = dict(zip((column.name for column in sheet.columns), map(str, cells), strict=True))
        mean, _, half = row["measured, 95 %"].strip("*").partition(" ± ")
        rows.append({
            "range": float(row["Δr/h_rms"]), "law": row["law"], "hurst": float(row["H"]),
            "surfaces": int(row["surfaces"]), "inside": row["thresholds in the range of Eq. (6)"],
            "mean": float(mean), "half": float(half or 0),
            **{theory.name: float(row[f"{theory.name} (limit)"].split()[0]) for theory in THEORIES},
        })  # fmt: skip
    return DataFrame(rows)


DECIDES = {
    "Pastewka-Robbins": ("Pastewka and Robbins, Eq. (6)", "slope and curvature"),
    "half conformal energy": ("Müser's group; Persson and Tosatti", "energy of full contact $U$, half of it or all"),
    "bearing area (BAM)": ("Ciavarella; Joe, Thouless and Barber", "heights (bearing area)"),
    "Fuller-Tabor": ("Fuller and Tabor", "summits and heights"),
}
"""What the manual says of each theory."""


def limits() -> str:
    """The table of the manual: theories, and their exponents in the limit of wide bandwidths."""
    hursts = 0.3, 0.6, 0.8
    lines = [f"| theory | what decides | exponent of $\\lambda_s$: H = {', '.join(f'{h:g}' for h in hursts)} |"]
    lines.append("|---|---|---|")
    limit = {theory.name: theory.limit for theory in THEORIES}
    for name, (who, what) in DECIDES.items():
        values = (round(limit[name](h), 2) + 0.0 for h in hursts)
        lines.append(f"| {who} | {what} | {', '.join(f'{value:.2g}' for value in values)} |")
    return "\n".join(lines)


QUOTED = ("short", "excluded", "thin", "inside", "width", "excludes", "fuller-tabor", "shapes")


@cache
def quoted() -> dict[str, str]:
    """What the manual quotes of the exponents, by name."""
    rows = fitted()
    several = rows[rows.surfaces >= SURFACES]
    low, thin = several[several.hurst == 0.3], several[(several.hurst == 0.8) & (several.law == "spline")]
    thin = thin[thin["range"] < THIN].sort_values("range", ascending=False)
    wide = many().query("hurst == 0.8 and law == 'spline'")
    wide = wide[wide["range"].isin(thin["range"])]
    works = many().pivot_table(index=["range", "hurst", "lambda_s", "seed"], columns="law", values="work").dropna()
    shapes = np.exp(np.log(works.exponential / works.spline).groupby(["range", "hurst"]).mean())
    return {
        "short": f"{low['mean'].max():.2f} to {low['mean'].min():.2f}",
        "excluded": f"{int((low['mean'].abs() > low.half).sum())} of {len(low)}",
        "thin": " and ".join(f"{reach:g}" for reach in thin["range"]),
        "inside": " and ".join(thin.inside),
        "width": f"{(wide.lambda_L / wide.lambda_s).max():g}",
        "excludes": f"{int(((thin['mean'] - thin['Pastewka-Robbins']).abs() > thin.half).sum())} of {len(thin)}",
        "fuller-tabor": f"{(several['mean'] - several['Fuller-Tabor']).abs().min():.2f}",
        "shapes": f"{shapes.min():.2f} to {shapes.max():.2f}",
    }


def main() -> None:
    sys.stdout.write(tables() + "\n")


if __name__ == "__main__":
    main()
