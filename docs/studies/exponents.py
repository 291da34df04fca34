"""Exponents of λ_s at the threshold, from the record: the tables of docs/studies/exponents.md.

``python -m docs.studies.exponents``: the sheets of ``continuum plot dispute`` of thresholds with A_rep >= 10 λ_s²,
with 95 % intervals over surfaces and the number of thresholds in the range of Eq. (6); and, where two ranges are
compared, works at the threshold over those of the theories on the surfaces that both have.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
from pandas import DataFrame

from continuum.paper.dispute import THEORIES, dispute_sheets
from continuum.paper.points import ENOUGH
from continuum.sticky.criteria import AREA, RoughContact

COMPARED = (0.12, 0.08)
"""Ranges over h_rms that the page sets beside one another."""


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
    found = thresholds()
    many = found[found.squares >= ENOUGH]
    return "\n\n".join([*(sheet.markdown() for sheet in dispute_sheets(many)), matched(many)])


def main() -> None:
    sys.stdout.write(tables() + "\n")


if __name__ == "__main__":
    main()
