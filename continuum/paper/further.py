"""How the figures of the further inputs are drawn: size, continuum limit, roll-off, laws, stiffness, pull-off."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pandas import DataFrame

from continuum.measure.curve import adhesion
from continuum.paper.points import alike, curve_of
from continuum.paper.relations import Drawn
from continuum.paper.symbols import adhesion_colour, adhesion_labels, draw_points, symbol_legend
from continuum.show import plot

_LINES = 12
"""Paths up to which their points are joined; of more, lines hide the points."""


def draw_inverse_kappa(points: DataFrame, *, key: str, label: str, column: str, along: Sequence[str] = ()) -> Drawn:
    """1/κ against a key of the input, means and scatter over surfaces, one curve for each adhesion length.

    Parameters
    ----------
    key, label : key of [surface], on the x axis, and what is written there.
    column : "kappa" or "kappa_rep".
    along : keys that change together with it.
    """
    figure = plot.new_figure(5.0, 3.6)
    axis = figure.subplots()
    body = []
    for length, same in points.groupby("length"):
        for _, curve in same.groupby(alike(same, f"surface.{key}", "surface.seed", *along), sort=False):
            inverse = {float(x): 1 / group[column].to_numpy() for x, group in curve.groupby(key)}
            mean = [each.mean() for each in inverse.values()]
            scatter = [each.std(ddof=1) if each.size > 1 else 0.0 for each in inverse.values()]
            axis.errorbar(list(inverse), mean, yerr=scatter, fmt="o-", color=adhesion_colour(length), capsize=2)
            sizes = map(len, inverse.values())
            body += [(length, *row) for row in zip(inverse, mean, scatter, sizes, strict=True)]
    numbers = DataFrame(
        body, columns=["l_a (a0)", f"surface.{key}", f"1/{column}", "scatter over surfaces", "surfaces"]
    )
    adhesion_labels(axis, points.length, "o-")
    axis.axhline(0.5, color="0.6", linestyle="--", linewidth=0.8, label="the paper's 1/2 without adhesion")
    axis.axhline(0, color="0.8", linewidth=0.6, label="below: sticky")
    axis.set_xscale("log")
    plotted = sorted(set(numbers[f"surface.{key}"]))
    axis.set_xticks(plotted, [f"{value:g}" for value in plotted])
    axis.set_xticks([], minor=True)
    axis.set(xlabel=label, ylabel=r"$1/\kappa$" if column == "kappa" else r"$1/\kappa_{rep}$")
    axis.legend(fontsize=7)
    return figure, numbers


def draw_laws(points: DataFrame) -> Drawn:
    """1/κ_att measured against theory with the effective range, one symbol for each law."""
    points = points.sort_values("law", kind="stable")
    numbers = DataFrame({
        "law": points.law, "l_a (a0)": points.length, "effective range (a0)": points.effective_range,
        "1/kappa_att theory": 1 / points.expected_kappa_att, "1/kappa_att": 1 / points.kappa_att,
    })  # fmt: skip
    figure = plot.new_figure(4.6, 3.8)
    axis = figure.subplots()
    for i, (law, mine) in enumerate(numbers.groupby("law")):
        axis.plot(mine["1/kappa_att theory"], mine["1/kappa_att"], "os^Dv"[i % 5], color=plot.SERIES[i], label=law)
    ends = np.array(axis.get_xlim())
    axis.plot(ends, ends, color="0.5", linewidth=0.9, label="equal")
    axis.set(xscale="log", yscale="log", ylabel=r"$1/\kappa_{att}$ measured",
             xlabel=r"$1/\kappa_{att}$, Eqs. (3), (4) with $\Delta r$ of Eq. (S-5)")  # fmt: skip
    axis.legend(fontsize=7)
    return figure, numbers


def draw_stiffness(points: DataFrame) -> Drawn:
    """k_N against load, with and without adhesion."""
    numbers = DataFrame({
        "l_a (a0)": points.length, "seed": points.seed.astype(float), "N/A0 (E*)": points.load,
        "k_N h_rms/A0 (E*)": points.stiffness * points.rms_height,
    })  # fmt: skip
    figure = plot.new_figure(5.0, 3.6)
    axis = figure.subplots()
    for _, path in numbers.groupby(points.system):
        axis.plot(path["N/A0 (E*)"], path["k_N h_rms/A0 (E*)"], "o-",
                  color=adhesion_colour(path["l_a (a0)"].iloc[0]), markersize=3, linewidth=0.8)  # fmt: skip
    adhesion_labels(axis, points.length, "o-", ", each line a surface")
    axis.set(xlabel=r"$N/A_0$ ($E^*$)", ylabel=r"$k_N h_{rms}/A_0$ ($E^*$)")
    axis.legend(fontsize=7)
    return figure, numbers


def whole_cycles(points: DataFrame) -> DataFrame:
    """The points of paths with a way back of which every point converged: work over a missing one would be a guess."""
    return points.groupby("system").filter(
        lambda path: path.retracting.any() and np.array_equal(path.step, np.arange(len(path)))
    )


def draw_pull_off(points: DataFrame) -> Drawn:
    """Cycles of load against mean gap, and the pull-off against how far the contact was pressed before."""
    numbers = _cycles(points)
    figure = plot.new_figure(8.8, 3.6)
    left, right = figure.subplots(1, 2)
    peak, pull = "peak A_rep/A0", "pull-off (E*)"
    surfaces = ["l_a (a0)", "seed"]
    for system in numbers.groupby(surfaces, sort=False)[peak].idxmax():
        path = points[points.system == system]
        shade = adhesion_colour(path.length.iloc[0])
        for some, marker, fill in ((path[path.approach], ".", shade), (path[~path.approach], "s", "none")):
            # Points only: between many of them the contact jumps.
            left.plot(some.mean_gap, some.load / some.rms_slope, marker, color=shade, markerfacecolor=fill,
                      markersize=3)  # fmt: skip
    first = numbers.groupby("l_a (a0)").seed.transform("min")
    for (length, seed), mine in numbers[numbers[pull] > 0].sort_values([peak, pull]).groupby(surfaces):
        name = rf"$\ell_a/a_0 = {length:g}$, each line a surface" if seed == first[mine.index[0]] else None
        right.plot(mine[peak], mine[pull], "o-", color=adhesion_colour(length), linewidth=0.8, label=name)
    left.plot([], [], ".", color="0.3", label="approach")
    left.plot([], [], "s", color="0.3", markerfacecolor="none", label="retraction")
    left.axhline(0, color="0.7", linewidth=0.6)
    tension = max(-float((points.load / points.rms_slope).min()), 1e-6)
    left.set(xlabel="mean gap ($a_0$)", ylabel=r"$N/(h'_{rms} E^* A_0)$", ylim=(-1.3 * tension, 1.3 * tension))
    left.set_title("the deepest cycle of each surface")
    right.set(yscale="log", ylabel="pull-off, $-N/A_0$ ($E^*$)", xlabel="largest repulsive area before, $A_{rep}/A_0$")
    for axis in (left, right):
        axis.legend(fontsize=7)
    return figure, numbers


def _cycles(points: DataFrame) -> DataFrame:
    """Numbers of each cycle, one row for each system."""
    body = {}
    for system, path in points.groupby("system"):
        found = adhesion(curve_of(path))
        length = path.length.iloc[0]
        w = length if length > 0 else np.nan
        body[system] = {
            "l_a (a0)": length, "seed": float(path.seed.iloc[0]), "peak A_rep/A0": path.area_rep.max(),
            "peak load (E*)": found.peak_load, "tension on approach (E*)": found.largest_tension,
            "pull-off (E*)": found.pull_off, "work of separation/w": found.work_of_separation / w,
            "loss/w": found.loss / w,
        }  # fmt: skip
    return DataFrame.from_dict(body, orient="index")


def long_paths(points: DataFrame) -> DataFrame:
    """The approaching points in contact of paths that have three of them at least."""
    touching = points.query("approach and area_rep > 0 and diameter > 0")
    return touching.groupby("system").filter(lambda path: len(path) > 2)


def draw_diameter(points: DataFrame) -> Drawn:
    """Mean diameter of the patches over 4h'/h'' against the area, a line for each path."""
    ratio = points.diameter / points.expected_diameter
    figure = plot.new_figure(5.4, 4.0)
    axis = figure.subplots()
    axis.axhspan(0.5, 2, color="0.94", zorder=0, label="within a factor of two")
    if points.system.nunique() <= _LINES:
        for _, path in points.groupby("system"):
            shade = adhesion_colour(path.length.iloc[0])
            axis.plot(path.area_rep, ratio[path.index], "-", color=shade, linewidth=0.5)
    draw_points(axis, points, points.area_rep, ratio)
    axis.set(xscale="log", ylim=(0, 3), xlabel=r"$A_{rep}/A_0$", ylabel=r"$d_{rep}/(4h'_{rms}/h''_{rms})$")
    symbol_legend(axis, points, fontsize=6, ncols=3, loc="upper center")
    numbers = {
        "H": points.hurst, "h'rms": points.slope, "lambda_s (a0)": points.lambda_s, "l_a (a0)": points.length,
        "seed": points.seed, "A_rep/A0": points.area_rep, "d_rep (a0)": points.diameter,
        "4h'/h'' (a0)": points.expected_diameter, "ratio": ratio,
    }  # fmt: skip
    return figure, DataFrame(numbers).astype(float)
