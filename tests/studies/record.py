"""The measured record of the criteria of stickiness, ``continuum/sticky/record.csv``, from what is computed already.

Run as ``python -m tests.studies.record``: the turns of :mod:`tests.studies.turns`, and the 65 states at 1 % area behind
``docs/stickiness.md``, whose signs follow from that page: it names every state that differs from the prediction.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from continuum.files import output
from continuum.model.surface import moments
from continuum.theory import paper, rough
from tests.problems import Rough
from tests.studies.turns import RESOLVED

COLUMNS = (
    "source", "hurst", "lambda_s", "lambda_L", "seed", "rms_height", "rms_slope", "rms_curvature", "conformal_energy",
    "range", "work", "sticky",
)  # fmt: skip
POINTS = 256
"""A side, of the surfaces that count."""
NEAR = 0.9
"""Ratio of attraction to repulsion from which the work at the turn is extrapolated: 4 % in the work."""


def turns(folder: Path) -> Iterator[dict[str, Any]]:
    """Surfaces with the work of adhesion at which attraction and repulsion cancel at 1 % area."""
    for path in sorted(folder.glob("*.json")):
        row = json.loads(path.read_text())
        if row["observable"] != "load":
            continue
        trials = [t for t in row["trials"] if t.get("load_rep") and t["snap"] >= RESOLVED]
        ratios = {t["work"]: t["load_att"] / t["load_rep"] for t in trials}
        best = min(ratios, key=lambda work: abs(math.log(ratios[work])), default=None)
        if best is None or not NEAR < ratios[best] < 1 / NEAR:
            continue
        yield {**row, "source": "turn", "range": row["length"], "work": best / ratios[best], "sticky": "turns"}


def states(page: str) -> Iterator[dict[str, Any]]:
    """States of docs/stickiness.md: of one surface and one work of adhesion each, sticky or not."""
    name = r"H = ([\d.]+), h' = ([\d.]+), lambda_s = ([\d.]+), l_a = ([\d.]+)"
    lost = {match.groups() for match in re.finditer(name + r": jumped_over", page)}
    differ = {match.groups()[:4] for match in re.finditer(name + r" \| 2 \| ([\d.]+) \| -", page)}
    for hurst in ("0.3", "0.5", "0.8"):
        for slope in ("0.1", "0.3"):
            for cut in ("4", "8", "16", "32"):
                rough_wall = Rough(1024, 0.005, float(cut), 1, float(slope), float(hurst))
                grid, heights = rough_wall.grid, rough_wall.heights()
                height, slope_found, curvature = moments(grid, heights)
                power = np.abs(grid.forward(heights)) ** 2 * grid.mode_weights
                base = {
                    "source": "state", "hurst": float(hurst), "lambda_s": float(cut), "lambda_L": 512.0, "seed": 1,
                    "rms_height": height, "rms_slope": slope_found, "rms_curvature": curvature,
                    "conformal_energy": rough.conformal_energy(grid.wavenumber, power),
                }  # fmt: skip
                for length in ("0.0005", "0.005", "0.05"):
                    key = hurst, slope, cut, length
                    if key in lost:
                        continue
                    reach = 1.05659 * math.sqrt(24 * float(length))
                    change = paper.height_change(slope_found, curvature)
                    predicted = paper.onset(slope_found, change, float(length), reach) < 1
                    sticky = "yes" if predicted or key in differ else "no"
                    yield {**base, "range": reach, "work": float(length), "sticky": sticky}


def main() -> None:
    """Write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, default=Path("results/turns"), help="folder of the turns")
    parser.add_argument("--page", type=Path, default=Path("docs/stickiness.md"))
    parser.add_argument("--record", type=Path, default=Path("continuum/sticky/record.csv"))
    given = parser.parse_args()
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in (*(row for row in turns(given.kept) if row["n"] == POINTS), *states(given.page.read_text())):
        writer.writerow([f"{v:.6g}" if isinstance(v := row[name], float) else v for name in COLUMNS])
    output.save(given.record, out.getvalue())


if __name__ == "__main__":
    main()
