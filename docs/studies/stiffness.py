"""Normal stiffness with adhesion over that without, from the table of its figure: ``python -m docs.studies.stiffness``.

Above 1.5 % of the area, means over three areas of three surfaces; of each equilibrium, and of the slope between points.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

from pandas import read_csv

from docs.studies.judgement import MEASURED

LEAST = 0.015
"""Repulsive area, over A0, from which on points count."""
COLUMNS = {
    "l_a (a0)": "length", "A_rep/A0": "area", "kappa_rep/kappa": "lowered", "k_N h_rms/N_rep": "each",
    "k_N h_rms/N_rep between points": "between",
}  # fmt: skip


def lines() -> Iterator[str]:
    """A row for each adhesion length."""
    rows = read_csv(MEASURED / "paper-stiffness-reduced-stiffness.csv").rename(columns=COLUMNS)
    rows = rows[rows.area > LEAST]
    rows = rows.assign(step=rows.groupby(["length", "seed"]).area.rank()).set_index(["seed", "step"])
    bare = rows[rows.length == 0]
    yield "| l_a | κ_rep/κ | k_N over that without, of each equilibrium | less κ_rep/κ | of the slope between points |"
    yield "|---|---|---|---|---|"
    for length, part in rows[rows.length > 0].groupby("length"):
        each = part["each"] / bare["each"]
        above = each - part.lowered
        yield (
            f"| {length:g} | {part.lowered.mean():.2f} | {each.mean():.2f} | {above.mean():.2f} ± {above.std():.2f} "
            f"| {(part.between / bare.between).mean():.2f} |"
        )


if __name__ == "__main__":
    sys.stdout.write("\n".join(lines()) + "\n")
