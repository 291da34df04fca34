"""Which surfaces stick, measured and predicted from the undeformed surface: ``docs/stickiness.md`` and its figure.

Run as ``python -m tests.studies.stickiness`` (about 15 minutes on three workers; it goes on where it was killed).
"""

from __future__ import annotations

import argparse
import itertools
import logging
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from continuum.theory import paper
from tests.studies.systems import System, each

log = logging.getLogger("studies")

HURST = (0.3, 0.5, 0.8)
SLOPES = (0.1, 0.3)
ADHESION_LENGTHS = (0.0005, 0.005, 0.05)
CUTS = (4.0, 8.0, 16.0, 32.0)
AREAS = (0.003, 0.01, 0.03)
"""Stickiness is judged at the second."""
ENOUGH = 10.0
"""The paper shows contacts with A_rep >= 10 lambda_s² only: fewer patches scatter."""

HEAD = """# Which surfaces stick

{systems} surfaces of {n} x {n} points (a0 = 1): H = 0.3, 0.5, 0.8; h'rms = 0.1, 0.3; lambda_s = 4, 8, 16, 32;
lambda_L = {lambda_L:g}; each with l_a = 0.0005, 0.005, 0.05 and without adhesion; on approach, at A_rep/A0 = 0.003,
0.01, 0.03, residual 1e-6 h'rms E*. Made by `make stickiness` (`tests/studies/stickiness.py`).

![A_rep/A_att and kappa_att against theory](stickiness.png)

*Left: A_rep/A_att against Eq. (4); right: kappa_att = h' E* A_rep/N_att against Eq. (3); both predicted
from the undeformed surface, d_rep = 4h'/h''. Colour: l_a; shape: lambda_s; open: H = 0.3, half: 0.5, full: 0.8. Faint:
A_rep < 10 lambda_s². The line is equality, the band a factor of two.*

"""


@dataclass(frozen=True)
class Point:
    """One state beside what theory says of it from the undeformed surface."""

    system: dict[str, Any]
    state: dict[str, Any]

    @property
    def enough(self) -> bool:
        """Whether the contact is large enough for statistics."""
        return bool(self.state["area_rep"] * self.system["n"] ** 2 >= ENOUGH * self.system["lambda_s"] ** 2)

    @property
    def ratio(self) -> tuple[float, float]:
        """A_rep/A_att: predicted by Eq. (4), and measured."""
        s = self.system
        diameter = paper.contact_diameter(s["rms_slope_found"], s["rms_curvature"])
        return (
            paper.area_ratio(s["rms_slope_found"], diameter, s["range"]),
            self.state["area_rep"] / self.state["area_att"],
        )

    @property
    def kappa_att(self) -> tuple[float, float]:
        """kappa_att: predicted by Eq. (3), and measured."""
        s = self.system
        predicted = paper.kappa_att(s["rms_slope_found"], s["range"], s["adhesion_length"], self.ratio[0])
        return predicted, self.state["kappa_att"]


def points(results: list[dict[str, Any]]) -> list[Point]:
    """All adhesive states that were found."""
    return [
        Point(r, s)
        for r in results
        if r["adhesion_length"] > 0
        for s in r["states"]
        if s["status"] == "CONVERGED" and s["area_rep"] > 0
    ]


def scatter(found: list[Point]) -> str:
    """Mean and scatter of measured over predicted."""
    lines = [
        "| measured/predicted | states | geometric mean | scatter (factor) | within a factor of two |",
        "|---" * 5 + "|",
    ]
    thin = [p for p in found if p.enough and p.ratio[0] > 1]
    for name, of, kept in (
        ("A_rep/A_att, all", "ratio", found),
        ("A_rep/A_att, A_rep >= 10 lambda_s²", "ratio", [p for p in found if p.enough]),
        ("A_rep/A_att, of these A_att < A_rep predicted", "ratio", thin),
        ("kappa_att, all", "kappa_att", found),
        ("kappa_att, A_rep >= 10 lambda_s²", "kappa_att", [p for p in found if p.enough]),
        ("kappa_att, of these A_att < A_rep predicted", "kappa_att", thin),
    ):
        if not kept:
            continue
        log = np.log([measured / predicted for predicted, measured in (getattr(p, of) for p in kept)])
        inside = np.mean(np.abs(log) <= np.log(2))
        lines.append(f"| {name} | {log.size} | {np.exp(log.mean()):.3f} | {np.exp(log.std()):.3f} | {inside:.0%} |")
    return "\n".join(lines) + "\n"


def confusion(results: list[dict[str, Any]]) -> str:
    """Predicted against measured sign of the load at 1 % area, and the cases in which they differ."""
    bare = {
        (r["hurst"], r["rms_slope"], r["lambda_s"]): r["states"][1]["kappa_rep"]
        for r in results
        if r["adhesion_length"] == 0 and r["states"][1]["status"] == "CONVERGED"
    }
    judged: dict[str, Counter[tuple[bool, bool]]] = {"of the non-adhesive run": Counter(), "2": Counter()}
    wrong, lost = [], []
    for r in results:
        state = r["states"][1]
        if r["adhesion_length"] == 0:
            continue
        key = r["hurst"], r["rms_slope"], r["lambda_s"]
        name = f"H = {r['hurst']}, h' = {r['rms_slope']}, lambda_s = {r['lambda_s']:g}, l_a = {r['adhesion_length']}"
        if state["status"] != "CONVERGED" or key not in bare:
            lost.append(f"{name}: {state['status'].lower()}")
            continue
        sticky = state["load"] < 0
        predicted = Point(r, state).kappa_att[0]
        for rule, kappa_rep in (("of the non-adhesive run", bare[key]), ("2", paper.KAPPA_REP)):
            margin = kappa_rep / predicted
            judged[rule][margin > 1, sticky] += 1
            if (margin > 1) != sticky:
                wrong.append(f"| {name} | {rule} | {margin:.2f} | {1 / state['kappa']:+.3f} |")
    lines = [
        "| kappa_rep | sticky, predicted | sticky, not predicted | neither | predicted, not sticky | right |",
        "|---" * 6 + "|",
    ]
    for rule, n in judged.items():
        right = (n[True, True] + n[False, False]) / max(1, n.total())
        lines.append(
            f"| {rule} | {n[True, True]} | {n[False, True]} | {n[False, False]} | {n[True, False]} | {right:.0%} |"
        )
    text = "\n".join(lines) + "\n"
    if wrong:
        text += (
            "\nWhere they differ. Margin: kappa_rep/kappa_att, above 1 where predicted sticky; 1/kappa: measured.\n\n"
        )
        text += "| surface | kappa_rep | margin | 1/kappa |\n|---|---|---|---|\n" + "\n".join(wrong) + "\n"
    if lost:
        text += "\nWithout a state at 1 % on this branch: " + "; ".join(lost) + ".\n"
    return text


def figure(found: list[Point], path: Path) -> None:
    """Measured against predicted, both ratios."""
    colours = dict(zip(ADHESION_LENGTHS, ("tab:blue", "tab:green", "tab:red"), strict=True))
    shapes = dict(zip(CUTS, "os^D", strict=True))
    fills = {0.3: "none", 0.5: "bottom", 0.8: "full"}
    both = Figure(figsize=(9.5, 4.6), layout="constrained")
    axes = both.subplots(1, 2)
    for axis, of, label in zip(axes, ("ratio", "kappa_att"), (r"$A_{rep}/A_{att}$", r"$\kappa_{att}$"), strict=True):
        for p in found:
            predicted, measured = getattr(p, of)
            axis.plot(
                predicted,
                measured,
                marker=shapes[p.system["lambda_s"]],
                fillstyle=fills[p.system["hurst"]],
                color=colours[p.system["adhesion_length"]],
                alpha=1.0 if p.enough else 0.2,
                markersize=5,
                linestyle="none",
            )
        ends = np.array([getattr(p, of)[0] for p in found])
        line = np.array([ends.min() / 1.5, ends.max() * 1.5])
        axis.plot(line, line, color="0.3", linewidth=1)
        axis.fill_between(line, line / 2, line * 2, color="0.5", alpha=0.12, linewidth=0)
        axis.set(xscale="log", yscale="log", xlabel=f"{label} predicted", ylabel=f"{label} measured")
    for length, colour in colours.items():
        axes[0].plot([], [], "o", color=colour, label=f"$l_a$ = {length:g} $a_0$")
    for cut, shape in shapes.items():
        axes[0].plot([], [], shape, color="0.4", label=rf"$\lambda_s$ = {cut:g} $a_0$")
    axes[0].legend(frameon=False, fontsize=8)
    both.savefig(path, dpi=150)


def main() -> None:
    """Run what is missing, draw and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, default=1024, help="points a side")
    parser.add_argument("--workers", type=int, default=3, help="systems at once, one thread each")
    parser.add_argument("--kept", type=Path, default=Path("results/stickiness"), help="folder of what is done so far")
    parser.add_argument("--page", type=Path, default=Path("docs/stickiness.md"))
    given = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    surfaces = list(itertools.product(HURST, SLOPES, CUTS))
    systems = [
        System(given.n, hurst, slope, cut, length, 1, AREAS)
        for hurst, slope, cut in surfaces
        for length in (0.0, *ADHESION_LENGTHS)
    ]
    results = each(systems, given.kept, given.workers)
    found = points(results)
    figure(found, given.page.with_suffix(".png"))
    states = [s for r in results for s in r["states"]]
    ended = Counter(s["status"].lower().replace("_", " ") for s in states)
    page = HEAD.format(systems=len(surfaces), n=given.n, lambda_L=given.n / 2)
    page += (
        scatter(found)
        + "\n## Sticky: negative load at 1 % area\n\nPredicted from the undeformed surface: kappa_att of theory"
    )
    page += " below kappa_rep.\n\n" + confusion(results)
    page += "\nHow the searches ended: " + ", ".join(f"{n} {name}" for name, n in ended.most_common()) + ".\n"
    given.page.write_text(page)
    log.info("%s", page)


if __name__ == "__main__":
    main()
