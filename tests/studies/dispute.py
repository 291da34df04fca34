"""Which theory is right?  ``docs/dispute.md`` and its figures from what :mod:`tests.studies.turns` has computed.

Run as ``python -m tests.studies.dispute --kept FOLDER``; nothing is computed here.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from continuum.sticky import criteria
from continuum.sticky.criteria import Estimate, RoughContact
from continuum.theory import dispute, paper
from tests.studies.record import turns

THEORIES: dict[str, tuple[Callable[[RoughContact], Estimate], Callable[[float], float], str]] = {
    "Pastewka-Robbins": (criteria.pastewka_robbins, dispute.pastewka_robbins_exponent, "tab:red"),
    "half conformal energy": (criteria.half_conformal_energy, dispute.conformal_exponent, "tab:blue"),
    "Fuller-Tabor": (criteria.fuller_tabor, dispute.fuller_tabor_exponent, "tab:green"),
    "bearing area (BAM)": (criteria.bearing_area, dispute.long_wave_exponent, "tab:purple"),
}
LEVEL = 1.0
"""Pull-off tension over the pressure before that counts as sticking."""
HURST = (0.3, 0.6, 0.8)
POINTS = 256
"""A side, of what is drawn."""


def contact(row: dict[str, Any], work: float = 1.0) -> RoughContact:
    """A surface as the criteria take it."""
    moments = row["rms_height"], row["rms_slope"], row["rms_curvature"]
    energy = row["conformal_energy"]
    return RoughContact(*moments, work, row["length"], conformal_energy=energy, roll_off=row["lambda_L"])


def exponent(points: list[tuple[float, float]]) -> float:
    """Of w against λ_s."""
    cut, work = np.log(np.array(points)).T
    return float(np.polyfit(cut, work, 1)[0]) if len(points) > 2 else float("nan")


def pulled(folder: Path) -> list[dict[str, Any]]:
    """Surfaces with the work at which the pull-off tension is that of the pressure before, between two trials."""
    found = []
    for path in sorted(folder.glob("*.json")):
        row = json.loads(path.read_text())
        if row["observable"] == "load":
            continue
        trials = [(t["work"], t["tension"] / t["peak"]) for t in row["trials"] if t.get("tension", 0) > 0]
        works, tensions = (np.log(np.array(values)) for values in zip(*trials, strict=True))
        if not tensions.min() < np.log(LEVEL) < tensions.max():
            continue
        found.append({**row, "work": float(np.exp(np.interp(np.log(LEVEL), tensions, works)))})
    return found


Groups = dict[tuple[int, float, float], dict[int, list[dict[str, Any]]]]


def groups(rows: list[dict[str, Any]]) -> Groups:
    """By points a side, range over h_rms and Hurst exponent, then by seed; each in order of λ_s."""
    found: Groups = {}
    for row in sorted(rows, key=lambda row: row["lambda_s"]):
        reach = round(row["length"] / row["rms_height"], 3)
        found.setdefault((row["n"], reach, row["hurst"]), {}).setdefault(row["seed"], []).append(row)
    return found


def _enough(series: list[dict[str, Any]]) -> bool:
    """Whether a series has an exponent and more."""
    return len(series) > 2


def table(rows: list[dict[str, Any]]) -> str:
    """Fitted exponents beside those that each theory has on the same surfaces and in the limit."""
    head = ["points", "range/h_rms", "H", "seeds", "λ_s", "Δr/g0", "measured"]
    head += [f"{name}: same surfaces (limit)" for name in THEORIES]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for (n, reach, hurst), seeds in sorted(groups(rows).items()):
        series = [one for one in seeds.values() if _enough(one)]
        if not series:
            continue
        measured = [exponent([(row["lambda_s"], row["work"]) for row in one]) for one in series]
        cuts = sorted({row["lambda_s"] for one in series for row in one})
        gaps = [
            row["length"] / paper.gap_scale(row["rms_slope"], row["rms_curvature"]) for one in series for row in one
        ]
        scatter = f" ± {np.std(measured, ddof=1):.2f}" if len(measured) > 1 else ""
        cells = [f"{n}²", f"{reach:g}", f"{hurst:g}", str(len(series)), f"{cuts[0]:g} - {cuts[-1]:g}",
                 f"{min(gaps):.2f} - {max(gaps):.2f}", f"**{np.mean(measured):+.2f}{scatter}**"]  # fmt: skip
        for criterion, limit, _ in THEORIES.values():
            same = [
                exponent([(row["lambda_s"], 1 / (criterion(contact(row)).margin or np.nan)) for row in one])
                for one in series
            ]
            cells.append(f"{np.mean(same):+.2f} ({limit(hurst):+.2f})")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def figure(rows: list[dict[str, Any]], path: Path, title: str) -> None:
    """Work at the turn against λ_s, each theory as a line through its own values on the same surfaces."""
    found = groups(rows)
    drawn = [key for key, seeds in found.items() if key[0] == POINTS and any(map(_enough, seeds.values()))]
    reaches = sorted({reach for _, reach, _ in drawn})
    shown = Figure(figsize=(9.6, 1.2 + 2.7 * len(reaches)), layout="constrained")
    axes = shown.subplots(len(reaches), len(HURST), sharex=True, sharey="row", squeeze=False)
    for i, reach in enumerate(reaches):
        for axis, hurst in zip(axes[i], HURST, strict=True):
            seeds = found.get((POINTS, reach, hurst), {})
            for seed, one in seeds.items():
                cut = [row["lambda_s"] for row in one]
                axis.plot(
                    cut, [row["work"] for row in one], "ks" if seed == 1 else "ko", fillstyle="full", markersize=5
                )
                for criterion, _, colour in THEORIES.values():
                    turn = [1 / (criterion(contact(row)).margin or np.nan) for row in one]
                    style = "-" if seed == 1 else "--"
                    axis.plot(cut, turn, style, color=colour, linewidth=1)
            axis.set(xscale="log", yscale="log", title=f"H = {hurst:g}, range {reach:g} h_rms")
            axis.title.set_fontsize(9)
            axis.set_xticks([4, 8, 16, 32], ["4", "8", "16", "32"])
            axis.minorticks_off()
        axes[i][0].set_ylabel("w at the turn (E* x point)")
    for axis in axes[-1]:
        axis.set_xlabel("λ_s (points)")
    for name, (_, _, colour) in THEORIES.items():
        axes[0][0].plot([], [], color=colour, label=name)
    shown.legend(loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    shown.suptitle(title, fontsize=10)
    shown.savefig(path, dpi=110)


def main() -> None:
    """Write figures, and tables to be put into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, default=Path("results/turns"), help="folder of the turns")
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    given = parser.parse_args()
    page = (given.docs / "dispute.md").read_text()
    for name, rows, title in (
        ("load", [{**row, "length": row["range"]} for row in turns(given.kept)],
         "Sign of the load at 1 % repulsive area on approach (squares, circles: two seeds)"),
        ("pull-off", pulled(given.kept), "Pull-off tension equal to the pressure before"),
    ):  # fmt: skip
        figure(rows, given.docs / f"dispute-{name}.png", title)
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        before, rest = page.split(begin)
        page = before + begin + table(rows) + end + rest.split(end, 1)[1]
    (given.docs / "dispute.md").write_text(page)


if __name__ == "__main__":
    main()
