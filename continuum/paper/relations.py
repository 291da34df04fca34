"""How figures are drawn from the points of a sweep, each with its numbers.

Those of the paper are Figs. 2 to 4, S-2 and S-3; those of the further inputs show size, continuum limit, roll-off,
laws, stiffness and pull-off.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from pandas import DataFrame

from continuum.measure.curve import adhesion
from continuum.paper.points import (
    adhesion_colour,
    adhesion_labels,
    alike,
    curve_of,
    draw_points,
    line_of_slope,
    plain_ticks,
    symbol_legend,
)
from continuum.show import plot
from continuum.theory import rough
from continuum.theory.paper import asperity_radius
from continuum.theory.smooth import JKR

Drawn = tuple[Figure, DataFrame]
"""A figure, and the numbers that it shows."""
_LINES = 12
"""Paths up to which their points are joined; of more, lines hide the points."""


def _numbers(points: DataFrame, columns: Mapping[str, Any]) -> DataFrame:
    """What the symbols stand for, and what is drawn."""
    symbols = {
        "H": points.hurst, "h'rms": points.slope, "lambda_s (a0)": points.lambda_s,
        "l_a (a0)": points.work_of_adhesion, "seed": points.seed, "A_rep >= 10 lambda_s^2": points.valid,
    }  # fmt: skip
    return DataFrame(symbols).assign(**columns)


def draw_area_against_load(points: DataFrame) -> Drawn:
    """Fig. 2: A_rep/A0 against N/(h' E* A0), one curve for each adhesion length."""
    points = points.assign(scaled=points.load / points.rms_slope)
    figure, axis = plot.new_axes(5.2, 3.8)
    for length, same in points.groupby("length"):
        shade = adhesion_colour(length)
        name: str | None = rf"$\ell_a/a_0 = {length:g}$, each line a surface"
        for _, path in same.groupby("system", sort=False):
            path = path.sort_values("area_rep")
            axis.plot(path.scaled, path.area_rep, "-", color=shade, linewidth=0.8, label=name)
            for some, fill in ((path[path.valid], shade), (path[~path.valid], "none")):
                axis.plot(some.scaled, some.area_rep, "o", color=shade, markerfacecolor=fill)
            name = None
    high = axis.get_ylim()[1]
    axis.plot([0, high / 2], [0, high], "--", color="0.4", label=r"$\kappa = 2$, the paper's value without adhesion")
    if not points.valid.all():
        axis.plot([], [], "o", color="0.3", markerfacecolor="none", label=r"$A_{rep} < 10\lambda_s^2$")
    axis.axvline(0, color="0.7", linewidth=0.6)
    axis.set(xlabel=r"$N/(h'_{rms} E^* A_0)$", ylabel=r"$A_{rep}/A_0$")
    axis.legend(fontsize=7)
    return figure, _numbers(points, {"N/(h' E* A0)": points.scaled, "A_rep/A0": points.area_rep})


def draw_loads(points: DataFrame) -> Drawn:
    """Fig. 3: N_att against A_att w/Δr; N_rep against h' A_rep; P against A_rep."""
    shown = {
        "A_att w/range (E* A0)": points.area_att * (points.length / points["range"].where(points["range"] > 0, np.inf)),
        "N_att (E* A0)": points.load_att,
        "h' A_rep/2 (A0)": points.rms_slope * points.area_rep / 2,
        "N_rep (E* A0)": points.load_rep,
        "A_rep/A0": points.area_rep,
        "P (4h'/h'')/(pi A0)": points.perimeter * points.expected_diameter / np.pi / points.area,
    }
    labels = (
        (r"$(A_{att}/A_0)\,w/\Delta r$ ($E^*$)", r"$N_{att}/A_0$ ($E^*$)", "equal"),
        (r"$h'_{rms}A_{rep}/(2A_0)$", r"$N_{rep}/(E^*A_0)$", r"$\kappa_{rep} = 2$"),
        (r"$A_{rep}/A_0$", r"$(P/A_0)\,(4h'_{rms}/h''_{rms})/\pi$", r"$d_{rep} = 4h'/h''$"),
    )
    figure, axes = plot.new_axes(9.6, 3.4, 1, 3)
    some = [points.area_att * points.length > 0, points.valid, points.valid]
    pairs = list(shown.values())
    for axis, x, y, mask, (across, up, name) in zip(axes, pairs[::2], pairs[1::2], some, labels, strict=True):
        draw_points(axis, points[mask], x[mask], y[mask])
        axis.set(xscale="log", yscale="log", xlabel=across, ylabel=up)
        line_of_slope(axis, label=name)
    line_of_slope(axes[2], 2.0, "within a factor of two", ":")
    line_of_slope(axes[2], 0.5, "", ":")
    for axis in axes[1:]:
        axis.legend(fontsize=7)
    symbol_legend(axes[0], points, fontsize=5.5)
    return figure, _numbers(points, shown)


def _over_surfaces(points: DataFrame, *names: str) -> DataFrame:
    """One row for systems that differ in the seed only: the first of them, with mean and scatter of some columns."""
    found = points.groupby(alike(points, "surface.seed"), sort=False)
    rows = points.loc[[group.index[0] for _, group in found]].copy()
    for name in names:
        groups = [group[name].to_numpy() for _, group in found]
        rows[name] = [values.mean() for values in groups]
        rows[f"{name}_scatter"] = [values.std(ddof=1) if values.size > 1 else 0.0 for values in groups]
    return rows


def draw_kappa(points: DataFrame) -> Drawn:
    """Fig. 4: 1/κ_att and A_rep/A_att against theory."""
    points = points.assign(
        inverse=1 / points.kappa_att.where(points.kappa_att > 0, np.inf), ratio=points.area_rep / points.area_att
    )
    shown = _over_surfaces(points, "inverse", "ratio", "load")
    figure, (left, right) = plot.new_axes(8.8, 4.2, 1, 2)
    x = 1 / shown.expected_kappa_att
    draw_points(left, shown, x, shown.inverse, shown.inverse_scatter)
    sticky = shown.load < 0
    left.plot(x[sticky], shown.inverse[sticky], "o", color="#009e73", markerfacecolor="none", markersize=11,
              markeredgewidth=0.7, label="sticky: mean load < 0")  # fmt: skip
    left.set(
        xscale="log", yscale="log", xlabel=r"$1/\kappa_{att}$, Eqs. (3) and (4)", ylabel=r"$1/\kappa_{att}$ measured"
    )
    line_of_slope(left, label="equal")
    left.axvspan(0.5, left.get_xlim()[1], color="#009e73", alpha=0.1, linewidth=0,
                 label=r"sticky by theory, $\kappa_{rep} = 2$")  # fmt: skip
    draw_points(right, shown, shown.expected_ratio, shown.ratio, shown.ratio_scatter)
    right.set(xscale="log", yscale="log", xlabel=r"$A_{rep}/A_{att}$, Eq. (4)", ylabel=r"$A_{rep}/A_{att}$ measured")
    line_of_slope(right, label="equal")
    right.legend(fontsize=7)
    symbol_legend(left, shown, fontsize=6)
    columns = {
        "1/kappa_att theory": x, "1/kappa_att": shown.inverse, "scatter of it": shown.inverse_scatter,
        "A_rep/A_att theory": shown.expected_ratio, "A_rep/A_att": shown.ratio, "scatter": shown.ratio_scatter,
        "mean load (E*)": shown.load,
    }  # fmt: skip
    return figure, _numbers(shown, columns)


def draw_perimeter(points: DataFrame) -> Drawn:
    """Fig. S-2: P d/(π A_rep) against the mean chord d."""
    chord = points.chord
    ratio = points.perimeter * chord / (np.pi * points.area_rep * points.area)
    figure, axis = plot.new_axes(5.4, 3.8)
    draw_points(axis, points, chord, ratio)
    # One frame for all sweeps, with room for the legend below the curve that points of any chord make.
    low, high = axis.get_ylim()
    axis.set(
        xscale="log", xlim=(min(2.0, chord.min() / 1.1), chord.max() * 1.1), ylim=(min(low, 0.75), max(high, 1.05))
    )
    plain_ticks(axis)
    axis.axhline(1, color="0.5", linewidth=0.9, label="equal")
    axis.axvline(10, color="0.5", linewidth=0.9, linestyle=":", label="below 10 $a_0$ cells show")
    axis.set(xlabel="mean chord of $A_{rep}$ ($a_0$)", ylabel=r"$P\,d/(\pi A_{rep})$")
    symbol_legend(axis, points, loc="lower right", fontsize=6)
    return figure, _numbers(points, {"chord (a0)": chord, "P d/(pi A_rep)": ratio})


def largest_tension(points: DataFrame) -> DataFrame:
    """The point of largest tension on each approach, with h_rms/δ_c and the tension over N P_c of asperity theories."""
    paths = points[points.approach & (points.length > 0)]
    found = points.loc[paths.groupby("system").load.idxmin()]
    columns = found[["rms_curvature", "work_of_adhesion", "rms_height"]].itertuples(index=False)
    scales = [
        (h / JKR(asperity_radius(curvature), w, 1.0).separation_distance, rough.asperity_limit(w, h))
        for curvature, w, h in columns
    ]
    ratio, limit = np.array(scales).reshape(-1, 2).T
    return found.assign(ratio=ratio, tension=(-found.load).clip(lower=0) / limit)


def draw_tension(points: DataFrame) -> Drawn:
    """Fig. S-3: the largest tension on approach against h_rms/δ_c, beside Fuller and Tabor."""
    pulls = points[points.tension > 0]
    figure, axis = plot.new_axes(5.4, 4.0)
    draw_points(axis, pulls, pulls.ratio, pulls.tension)
    ratio = np.geomspace(0.3, 30, 40)
    theory = np.array([rough.fuller_tabor(float(r)) for r in ratio])
    axis.plot(ratio[theory > 1e-6], theory[theory > 1e-6], "-", color="0.4", label="Fuller and Tabor (1975)")
    axis.set(xscale="log", yscale="log", xlabel=r"$h_{rms}/\delta_c$", ylabel=r"$N_{max}/(N P_c)$")
    axis.set_ylim(bottom=1e-6)
    plain_ticks(axis)
    symbol_legend(axis, pulls, loc="lower left", fontsize=6)
    return figure, _numbers(points, {"h_rms/delta_c": points.ratio, "N_max/(N P_c)": points.tension})


def draw_inverse_kappa(points: DataFrame, *, key: str, label: str, column: str, along: Sequence[str] = ()) -> Drawn:
    """1/κ against a key of the input, means and scatter over surfaces, one curve for each adhesion length.

    Parameters
    ----------
    key, label : key of [surface], on the x axis, and what is written there.
    column : "kappa" or "kappa_rep".
    along : keys that change together with it.
    """
    figure, axis = plot.new_axes(5.0, 3.6)
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
    figure, axis = plot.new_axes(4.6, 3.8)
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
    figure, axis = plot.new_axes(5.0, 3.6)
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
    figure, (left, right) = plot.new_axes(8.8, 3.6, 1, 2)
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
    figure, axis = plot.new_axes(5.4, 4.0)
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
