"""Table and figure of all comparisons into docs: ``python -m docs.studies.verification docs`` (a minute or two).

Exit code 1 if a difference is larger than allowed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from continuum.show.plot import PAGE, SERIES, legend_under, letter_panels, new_figure, save_figure, styled
from continuum.theory.smooth import DMT, JKR, MaugisDugdale
from tests.verification import checks
from tests.verification.checks import COMPARISONS, Comparison

__all__ = ["BEGIN", "END", "draw", "write"]

BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"


def write(comparisons: Iterable[Comparison], page: Path) -> bool:
    """Put the tables between the marker lines of a page; returns whether every difference is allowed."""
    parts, good = [], True
    for comparison in comparisons:
        found = comparison.make()
        good &= all(check.good for check in found)
        parts.append(f"\n**{comparison.name}.** {comparison.why}\n\n| | solver | analytic | difference | allowed | |\n")
        parts.append("|---|---|---|---|---|---|\n")
        parts += [
            f"| {c.quantity} | {c.ours:.5g} | {c.analytic:.5g} | {c.error:.2g} | {c.allowed:.2g} "
            f"| {'yes' if c.good else '**no**'} |\n"
            for c in found
        ]
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    after = rest.split(END)[1]
    page.write_text(f"{before}{BEGIN}\n{''.join(parts)}\n{END}{after}", encoding="utf-8")
    return good


@styled
def draw() -> Figure:
    """Spheres against Maugis, pull-off from DMT to JKR, Johnson's wave, convergence."""
    figure = new_figure(PAGE, 6.6)
    axes = figure.subplots(2, 2)
    _spheres(axes[0, 0])
    _pull_off(axes[0, 1])
    _wave(axes[1, 0])
    _orders(axes[1, 1])
    titles = (
        "spheres: solver, Maugis (lines); the paper's law",
        "pull-off",
        r"wave, $\alpha = 0.3$, the paper's law",
        "convergence, the paper's law",
    )
    letter_panels(axes.flat, titles)
    for axis in axes.flat:
        legend_under(axis, 0.46)
    return figure


def _spheres(axis) -> None:
    for colour, (tabor, n, edge) in zip(SERIES, ((0.3, 256, 0.05), (1.0, 256, 0.1), (2.0, 256, 0.4)), strict=False):
        curve = checks.maugis_curve(tabor, n, edge)
        made = curve.sphere
        force, depth = np.pi * made.work * made.radius, JKR(made.radius, made.work).separation_distance
        first = curve.maugis_contact[0]
        states = [made.maugis.state(a) for a in np.linspace(0.02, 1.05, 200) * first]
        axis.plot(
            [s.indentation / depth for s in states], [s.load / force for s in states], "-", color=colour, linewidth=1
        )
        axis.plot(curve.indentation / depth, curve.load / force, "o", color=colour, label=f"μ = {tabor:g}")
    axis.axhline(0, color="0.7", linewidth=0.6, zorder=0)
    axis.set_xlabel(r"indentation $\delta/\delta_c$")
    axis.set_ylabel(r"load $N/(\pi w R)$")


def _pull_off(axis) -> None:
    cases = (*checks.PULL_OFFS, *checks.PULL_OFFS_LONG)
    found = [checks.retraction(tabor, n) for tabor, n in cases]
    tabors = np.geomspace(0.03, 8, 60)
    # R = 1, w = 1/π: forces in π w R; E* = 1 and the distance that makes the parameter.
    maugis = [MaugisDugdale(1.0, 1 / np.pi, np.pi ** (-2 / 3) / tabor).pull_off_force for tabor in tabors]
    axis.axhline(DMT(1.0, 1 / np.pi).pull_off_force, color="0.5", linestyle=":", label="DMT")
    axis.axhline(JKR(1.0, 1 / np.pi).pull_off_force, color="0.5", linestyle="--", label="JKR")
    axis.semilogx(tabors, maugis, "-", color=SERIES[0], linewidth=1, label="Maugis-Dugdale")
    names, sets = ("solver, the paper's law", "annuli, the same law"), ("load", "annuli")
    for name, which, marker in zip(names, sets, "s+", strict=True):
        forces = [-getattr(one, which).min() / one.unit for one in found]
        axis.semilogx(
            [tabor for tabor, _ in cases], forces, marker, color=SERIES[5 if marker == "s" else 4], label=name
        )
    axis.set_xlabel("Tabor parameter μ")
    axis.set_ylabel(r"pull-off force$/(\pi w R)$")


def _wave(axis) -> None:
    for colour, (wavelength, n) in zip(SERIES, ((128.0, 128), (512.0, 256), (2048.0, 1024)), strict=False):
        curve = checks.wave(wavelength, n)
        pressure = curve.pressure / curve.wave.full_pressure
        attracted = curve.attracted > 0
        axis.plot(
            curve.attracted[attracted] / wavelength,
            pressure[attracted],
            "o",
            color=colour,
            label=f"λ = {wavelength:g} $a_0$",
        )
        pushed = curve.repulsive > 0
        axis.plot(curve.repulsive[pushed] / wavelength, pressure[pushed], "o", color=colour, markerfacecolor="none")
    # α alone fixes the reduced curves: those of any of the waves.
    wave, widths = curve.wave, np.linspace(0.001, 0.3, 400)
    pressures = np.array([wave.mean_pressure(a * wavelength) for a in widths]) / wave.full_pressure
    axis.plot(widths, pressures, "k-", linewidth=1, label="Johnson: contact")
    sine2 = np.sin(np.pi * widths) ** 2 - wave.alpha * np.sqrt(np.tan(np.pi * widths)) / 2
    pushing = sine2 > 0
    inner = np.arcsin(np.sqrt(sine2[pushing])) / np.pi
    axis.plot(inner, pressures[pushing], "k--", linewidth=1, label="Johnson: where it pushes")
    axis.axhline(0, color="0.7", linewidth=0.6, zorder=0)
    axis.set_xlabel(r"half-width $a/\lambda$: attracted (filled), repelled (open)")
    axis.set_ylabel(r"mean pressure $\bar p/p^*$")


def _orders(axis) -> None:
    for colour, kind in zip(SERIES, ("sphere", "wave"), strict=False):
        found, sizes, errors = checks.order(kind)
        axis.loglog(sizes, errors, "o-", color=colour, label=f"{kind}: order {found:.2f}")
    axis.set_xlabel("points along the period")
    axis.set_ylabel("difference of the load from the finest grid")


def main(folder: Path) -> int:
    """Make page and figure."""
    good = write(COMPARISONS, folder / "studies" / "verification.md")
    stem = folder / "verification"
    save_figure(draw(), stem, own=True)
    stem.with_suffix(".pdf").unlink()
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
