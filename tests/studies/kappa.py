"""1/kappa of the paper's system at 1 % repulsive area, for several adhesion lengths and seeds: ``docs/kappa.md``.

Run as ``python -m tests.studies.kappa`` (about 20 minutes on two threads; it goes on where it was killed).
"""

from __future__ import annotations

import argparse
import logging
from pathlib import Path
from typing import Any

import numpy as np

from tests.studies.systems import System, each

log = logging.getLogger("studies")

ADHESION_LENGTHS = (0.0, 0.0005, 0.005, 0.05)
SEEDS = (1, 2, 3)

HEAD = """# kappa at 1 % repulsive area

Paper's system: {n} x {n} points, H = 0.8, h'rms = 0.1, lambda_s = {lambda_s:g}, lambda_L = {lambda_L:g} (a0 = 1), the
9-3/spline law with k = E* a0/2, incompressible half-space, {seeds} surfaces, on approach, repulsive area within 1 % of
1 %, residual 1e-6 h'rms E*. Made by `make kappa` (`tests/studies/kappa.py`).

1/kappa = N/(h'rms E* A_rep) is averaged, since kappa diverges at the onset of stickiness; +- is the standard deviation
over the surfaces. kappa is the inverse of the mean. Negative: the surface pulls, it is sticky.

"""


def table(results: list[dict[str, Any]]) -> str:
    """Rows of means and scatter, one for each adhesion length."""
    columns = {
        "1/kappa": lambda r, s: 1 / s["kappa"],
        "1/kappa_rep": lambda r, s: 1 / s["kappa_rep"],
        "A_rep/A_att": lambda r, s: s["area_rep"] / s["area_att"] if s["area_att"] else np.inf,
        "N_att/(A_att w/range)": lambda r, s: (
            s["pressure_att"] * r["range"] / r["adhesion_length"] if r["adhesion_length"] else np.nan
        ),
        "d_rep": lambda r, s: s["diameter"],
        "d_rep h''/(4h')": lambda r, s: s["diameter"] * r["rms_curvature"] / (4 * r["rms_slope_found"]),
        "mean chord": lambda r, s: s["chord"],
    }
    lines = ["| l_a | kappa | " + " | ".join(columns) + " |", "|---" * (len(columns) + 2) + "|"]
    for length in ADHESION_LENGTHS:
        rows = [r for r in results if r["adhesion_length"] == length]
        cells = [f"{length:g}", f"{1 / np.mean([1 / r['states'][-1]['kappa'] for r in rows]):.3g}"]
        for value in columns.values():
            found = np.array([value(r, r["states"][-1]) for r in rows])
            if np.isfinite(found).all():
                cells.append(f"{found.mean():.4g} +- {found.std(ddof=1):.2g}")
            else:
                cells.append("-")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def each_system(results: list[dict[str, Any]]) -> str:
    """One row for each system."""
    lines = [
        "| l_a | seed | status | A_rep | N/(E* A0) | 1/kappa | N_P | mean gap | residual | pairs | search | solves |",
        "|---" * 12 + "|",
    ]
    for r in results:
        s = r["states"][-1]
        lines.append(
            f"| {r['adhesion_length']:g} | {r['seed']} | {s['status'].lower()} | {s['area_rep']:.5f} | {s['load']:.4e} "
            f"| {1 / s['kappa']:.4f} | {s['perimeter_cells']} | {s['mean_gap']:.4f} | {s['residual']:.1e} "
            f"| {s['pairs']:.0f} | {s['search_pairs']:.0f} | {s['solves']} |"
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run what is missing and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, default=4096, help="points a side")
    parser.add_argument("--lambda-s", type=float, default=32.0, help="shortest wavelength, in a0")
    parser.add_argument("--threads", type=int, default=2, help="of each system")
    parser.add_argument("--workers", type=int, default=1, help="systems at once; each needs 1.5 GiB at 4096²")
    parser.add_argument("--kept", type=Path, default=Path("results/kappa"), help="folder of what is done so far")
    parser.add_argument("--page", type=Path, default=Path("docs/kappa.md"))
    given = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    systems = [
        System(given.n, 0.8, 0.1, given.lambda_s, length, seed, (0.01,), given.threads)
        for length in ADHESION_LENGTHS
        for seed in SEEDS
    ]
    results = each(systems, given.kept, given.workers)
    head = HEAD.format(n=given.n, lambda_s=given.lambda_s, lambda_L=given.n / 2, seeds=len(SEEDS))
    page = head + table(results) + "\nEach system:\n\n" + each_system(results)
    given.page.write_text(page)
    log.info("%s", page)


if __name__ == "__main__":
    main()
