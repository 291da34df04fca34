"""How the paper's Figs. 2 to 4, S-2 and S-3 are drawn from the points of a sweep: each figure with its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from pandas import DataFrame

from continuum.paper.points import alike
from continuum.paper.symbols import adhesion_colour, draw_points, line_of_slope, plain_ticks, symbol_legend
from continuum.show import plot
from continuum.theory import rough
from continuum.theory.paper import asperity_radius
from continuum.theory.smooth import JKR

Drawn = tuple[Figure, DataFrame]
"""A figure, and the numbers that it shows."""


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
    figure = plot.new_figure(5.2, 3.8)
    axis = figure.subplots()
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
    axis.set_xlabel(r"$N/(h'_{rms} E^* A_0)$")
    axis.set_ylabel(r"$A_{rep}/A_0$")
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
    figure = plot.new_figure(9.6, 3.4)
    axes = figure.subplots(1, 3)
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
    figure = plot.new_figure(8.8, 4.2)
    left, right = figure.subplots(1, 2)
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
    figure = plot.new_figure(5.4, 3.8)
    axis = figure.subplots()
    draw_points(axis, points, chord, ratio)
    # One frame for all sweeps, with room for the legend below the curve that points of any chord make.
    low, high = axis.get_ylim()
    axis.set(
        xscale="log", xlim=(min(2.0, chord.min() / 1.1), chord.max() * 1.1), ylim=(min(low, 0.75), max(high, 1.05))
    )
    plain_ticks(axis)
    axis.axhline(1, color="0.5", linewidth=0.9, label="equal")
    axis.axvline(10, color="0.5", linewidth=0.9, linestyle=":", label="below 10 $a_0$ cells show")
    axis.set_xlabel("mean chord of $A_{rep}$ ($a_0$)")
    axis.set_ylabel(r"$P\,d/(\pi A_{rep})$")
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
    figure = plot.new_figure(5.4, 4.0)
    axis = figure.subplots()
    draw_points(axis, pulls, pulls.ratio, pulls.tension)
    ratio = np.geomspace(0.3, 30, 40)
    theory = np.array([rough.fuller_tabor(float(r)) for r in ratio])
    axis.plot(ratio[theory > 1e-6], theory[theory > 1e-6], "-", color="0.4", label="Fuller and Tabor (1975)")
    axis.set(xscale="log", yscale="log", xlabel=r"$h_{rms}/\delta_c$", ylabel=r"$N_{max}/(N P_c)$")
    axis.set_ylim(bottom=1e-6)
    plain_ticks(axis)
    symbol_legend(axis, pulls, loc="lower left", fontsize=6)
    return figure, _numbers(points, {"h_rms/delta_c": points.ratio, "N_max/(N P_c)": points.tension})
