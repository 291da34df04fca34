"""The paper's own system, 4096² points, from its stored points: ``python -m docs.studies.figure2``.

Means over three surfaces of each area that was asked for; 1/κ is averaged, as κ diverges where surfaces become sticky.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
from pandas import read_csv

from docs.studies.judgement import MEASURED

LENGTHS = (0.0, 0.0005, 0.005, 0.05)


def lines() -> Iterator[str]:
    """κ_rep without adhesion, 1/κ, A_rep/A_att over Eq. (4), and the mean diameter over 4h'/h'', by area."""
    points = read_csv(MEASURED / "paper-figure2-4096-points.csv").query("approach and valid")
    # Areas of 0.25 % and its doublings are met to 30 %.
    points = points.assign(
        target=0.0025 * 2 ** np.round(np.log2(points.area_rep / 0.0025)),
        ratio=points.area_rep / points.area_att / points.expected_ratio,
        inverse=1 / points.kappa,
        inverse_rep=1 / points.kappa_rep,
    )
    said = "; ".join(f"{length:g}" for length in LENGTHS)
    yield f"| area | κ_rep, l_a = 0 | 1/κ: {said} | A_rep/A_att over Eq. (4): {said[3:]} | d_rep h''/(4h'), all |"
    yield "|---|---|---|---|---|"
    for target, part in points.groupby("target"):
        means = part.groupby("length")[["inverse", "inverse_rep", "ratio"]].mean()
        cells = (
            f"{100 * target:g} %", f"{1 / means.inverse_rep[0.0]:.2f}",
            "; ".join(f"{means.inverse[length]:.3f}" for length in LENGTHS),
            "; ".join(f"{means.ratio[length]:.2f}" for length in LENGTHS[1:]), f"{part.diameter_ratio.mean():.2f}",
        )  # fmt: skip
        yield f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.stdout.write("\n".join(lines()) + "\n")
