"""What one axis of a sweep does: finite size, continuum limit, roll-off, other laws, stiffness, pull-off."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from continuum.measure.curve import Curve, adhesion
from continuum.model.fourier import Real
from continuum.paper.figures import Drawing
from continuum.paper.points import FigureError, Points, colour, draw, legend
from continuum.show import plot
from continuum.show.sheet import Sheet

_LINES = 12
"""Paths up to which their points are joined; of more, lines hide the points."""


def _axis_keys(points: Points) -> set[str]:
    return {key for axis in points.table.listed.axes for key in axis.keys}


def _chosen(points: Points, key: str) -> np.ndarray:
    rows = np.flatnonzero(points.reference)
    if key not in _axis_keys(points) or not rows.size or len(set(points[key][rows])) < 2:
        msg = f"this figure needs a sweep over {key}, with points of enough contact at two values at least"
        raise FigureError(msg)
    return rows


@plot.styled
def _inverse_kappa(points: Points, key: str, label: str, column: str, caption: str, *along: str) -> Drawing:
    """1/κ against a key of the input, means and scatter over surfaces, one curve for each adhesion length."""
    rows = _chosen(points, key)
    figure = plot.new_figure(5.0, 3.6)
    axis = figure.subplots()
    body, plotted = [], set[float]()
    for length in sorted(set(points.length[rows])):
        mine = rows[points.length[rows] == length]
        for curve in points.groups(mine, key, "surface.seed", *along):
            x = np.unique(points[key][curve])
            groups = [1 / points[column][curve[points[key][curve] == value]] for value in x]
            mean = np.array([group.mean() for group in groups])
            scatter = np.array([group.std(ddof=1) if group.size > 1 else 0.0 for group in groups])
            plotted |= set(x.astype(float).tolist())
            axis.errorbar(x.astype(float), mean, yerr=scatter, fmt="o-", color=colour(length), capsize=2)
            body += [(length, float(v), m, s, g.size) for v, m, s, g in zip(x, mean, scatter, groups, strict=True)]
        axis.plot([], [], "o-", color=colour(length), label=rf"$\ell_a/a_0 = {length:g}$")
    axis.axhline(0.5, color="0.6", linestyle="--", linewidth=0.8, label="the paper's 1/2 without adhesion")
    axis.axhline(0, color="0.8", linewidth=0.6, label="below: sticky")
    axis.set_xscale("log")
    axis.set_xticks(sorted(plotted), [f"{value:g}" for value in sorted(plotted)])
    axis.set_xticks([], minor=True)
    axis.set(xlabel=label, ylabel=r"$1/\kappa$" if column == "kappa" else r"$1/\kappa_{rep}$")
    axis.legend(fontsize=7)
    sheet = Sheet.of(caption, ("l_a (a0)", key, f"1/{column}", "scatter over surfaces", "surfaces"), body)
    return Drawing(figure, sheet, f"{caption}; means over surfaces, bars their standard deviation.")


def finite_size(points: Points) -> Drawing:
    """1/κ against the period."""
    text = "κ at 1 % area against the period L = 2λ_L"
    return _inverse_kappa(points, "surface.lambda_L", r"$\lambda_L = L/2$ ($a_0$)", "kappa", text, "grid.n")


def continuum_limit(points: Points) -> Drawing:
    """1/κ_rep against λ_s/a0."""
    return _inverse_kappa(
        points,
        "surface.lambda_s",
        r"$\lambda_s/a_0$",
        "kappa_rep",
        "κ_rep at 1 % area against λ_s/a0",
        "grid.n",
        "surface.lambda_L",
    )


def roll_off(points: Points) -> Drawing:
    """1/κ against λ_L at one period."""
    return _inverse_kappa(
        points, "surface.lambda_L", r"$\lambda_L$ ($a_0$)", "kappa", "κ at 1 % area against λ_L, one period"
    )


@plot.styled
def other_potentials(points: Points) -> Drawing:
    """1/κ_att measured against theory with the effective range, one symbol for each law."""
    rows = np.flatnonzero(points.reference & (points.length > 0))
    laws = points["wall.law"]
    if not rows.size or "wall.law" not in _axis_keys(points):
        msg = "this figure needs a sweep over wall.law"
        raise FigureError(msg)
    figure = plot.new_figure(4.6, 3.8)
    axis = figure.subplots()
    body = []
    for i, law in enumerate(sorted(set(laws[rows]))):
        mine = rows[laws[rows] == law]
        x, y = 1 / points.kappa_att[mine], 1 / points["kappa_att"][mine]
        axis.plot(x, y, "os^Dv"[i % 5], color=plot.SERIES[i], label=str(law))
        body += [
            (str(law), points.length[r], points["effective_range"][r], a, b) for r, a, b in zip(mine, x, y, strict=True)
        ]
    ends = np.array(axis.get_xlim())
    axis.plot(ends, ends, color="0.5", linewidth=0.9, label="equal")
    axis.set(xscale="log", yscale="log", ylabel=r"$1/\kappa_{att}$ measured",
             xlabel=r"$1/\kappa_{att}$, Eqs. (3), (4) with $\Delta r$ of Eq. (S-5)")  # fmt: skip
    axis.legend(fontsize=7)
    heads = ("law", "l_a (a0)", "effective range (a0)", "1/kappa_att theory", "1/kappa_att")
    return Drawing(
        figure, Sheet.of("other potentials", heads, body), "Other laws of the wall beside the theory for the spline."
    )


def _curves(points: Points, x: Real, y: Real, *labels: str) -> tuple[Figure, Axes, list[tuple[float, ...]]]:
    figure = plot.new_figure(5.0, 3.6)
    axis = figure.subplots()
    body: list[tuple[float, ...]] = []
    for path in points.paths():
        length = float(points.length[path[0]])
        axis.plot(x[path], y[path], "o-", color=colour(length), markersize=3, linewidth=0.8)
        body += [(length, float(points["surface.seed"][r]), float(x[r]), float(y[r])) for r in path]
    for length in sorted(set(points.length)):
        axis.plot([], [], "o-", color=colour(length), label=rf"$\ell_a/a_0 = {length:g}$, each line a surface")
    axis.set(xlabel=labels[0], ylabel=labels[1])
    return figure, axis, body


@plot.styled
def stiffness(points: Points) -> Drawing:
    """k_N against load, with and without adhesion."""
    height = points["rms_height"]
    figure, axis, body = _curves(points, points["load"], points["stiffness"] * height,
                                 r"$N/A_0$ ($E^*$)", r"$k_N h_{rms}/A_0$ ($E^*$)")  # fmt: skip
    axis.legend(fontsize=7)
    heads = ("l_a (a0)", "seed", "N/A0 (E*)", "k_N h_rms/A0 (E*)")
    return Drawing(figure, Sheet.of("stiffness", heads, body), "Normal stiffness against load.")


def _cycles(points: Points) -> tuple[list[tuple[float, ...]], dict[tuple[float, float], np.ndarray]]:
    """Numbers of each path with a way back; and of each adhesion length and surface the rows of its deepest one."""
    body, deepest = list[tuple[float, ...]](), dict[tuple[float, float], np.ndarray]()
    for path in points.paths():
        whole = np.array_equal(points["step"][path], np.arange(path.size))
        if not points["retracting"][path].any() or not whole:  # work over a missing point would be a guess
            continue
        case = float(points.length[path[0]]), float(points["surface.seed"][path[0]])
        mean_gap, separation, load = (points[name][path] for name in ("mean_gap", "separation", "load"))
        found = adhesion(Curve(mean_gap, separation, load, points["retracting"][path] == 1))
        area, w = float(points["area_rep"][path].max()), case[0] if case[0] > 0 else np.nan
        works = found.work_of_separation / w, found.loss / w
        body.append((*case, area, found.peak_load, found.largest_tension, found.pull_off, *works))
        if case not in deepest or area > points["area_rep"][deepest[case]].max():
            deepest[case] = path
    return body, deepest


@plot.styled
def pull_off(points: Points) -> Drawing:
    """Cycles of load against mean gap, and the pull-off against how far the contact was pressed before."""
    body, deepest = _cycles(points)
    if not body:
        msg = "this figure needs paths with a way back (retract = true) of which every point converged"
        raise FigureError(msg)
    figure = plot.new_figure(8.8, 3.6)
    left, right = figure.subplots(1, 2)
    for (length, _), path in deepest.items():
        for way, marker, fill in ((0, ".", colour(length)), (1, "s", "none")):
            some = path[points["retracting"][path] == way]
            # Points only: between many of them the contact jumps.
            left.plot(points["mean_gap"][some], points["load"][some] / points["rms_slope"][some], marker,
                      color=colour(length), markerfacecolor=fill, markersize=3)  # fmt: skip
    for length in sorted({row[0] for row in body}):
        for i, seed in enumerate(sorted({row[1] for row in body if row[0] == length})):
            mine = sorted((row[2], row[5]) for row in body if row[:2] == (length, seed) and row[5] > 0)
            name = rf"$\ell_a/a_0 = {length:g}$, each line a surface" if i == 0 else None
            if mine:
                right.plot(*zip(*mine, strict=True), "o-", color=colour(length), linewidth=0.8, label=name)
    left.plot([], [], ".", color="0.3", label="approach")
    left.plot([], [], "s", color="0.3", markerfacecolor="none", label="retraction")
    left.axhline(0, color="0.7", linewidth=0.6)
    tension = max(-float((points["load"] / points["rms_slope"]).min()), 1e-6)
    left.set(xlabel="mean gap ($a_0$)", ylabel=r"$N/(h'_{rms} E^* A_0)$", ylim=(-1.3 * tension, 1.3 * tension))
    left.set_title("the deepest cycle of each surface")
    right.set(yscale="log", ylabel="pull-off, $-N/A_0$ ($E^*$)", xlabel="largest repulsive area before, $A_{rep}/A_0$")
    for axis in (left, right):
        axis.legend(fontsize=7)
    heads = ("l_a (a0)", "seed", "peak A_rep/A0", "peak load (E*)", "tension on approach (E*)", "pull-off (E*)",
             "work of separation/w", "loss/w")  # fmt: skip
    text = "Cycles of load, and pull-off against how far the contact was pressed; peak loads and work are in the table."
    return Drawing(figure, Sheet.of("pull-off", heads, body), text)


@plot.styled
def diameter(points: Points) -> Drawing:
    """Mean diameter of the patches over 4h'/h'' against the area, a line for each path."""
    rows = np.flatnonzero((points["retracting"] == 0) & (points["area_rep"] > 0) & (points["diameter"] > 0))
    paths = [rows[points.table.system[rows] == system] for system in np.unique(points.table.system[rows])]
    paths = [path for path in paths if path.size > 2]
    if not paths:
        msg = "this figure needs paths of three areas at least, as those of figure3"
        raise FigureError(msg)
    rows, ratio, area = np.concatenate(paths), points["diameter"] / points.diameter, points["area_rep"]
    figure = plot.new_figure(5.4, 4.0)
    axis = figure.subplots()
    axis.axhspan(0.5, 2, color="0.94", zorder=0, label="within a factor of two")
    for path in paths if len(paths) <= _LINES else ():
        axis.plot(area[path], ratio[path], "-", color=colour(float(points.length[path[0]])), linewidth=0.5)
    draw(axis, points, area[rows], ratio[rows], rows)
    axis.set(xscale="log", ylim=(0, 3), xlabel=r"$A_{rep}/A_0$", ylabel=r"$d_{rep}/(4h'_{rms}/h''_{rms})$")
    legend(axis, points, rows, fontsize=6, ncols=3, loc="upper center")
    columns = (points["surface.hurst"], points["surface.rms_slope"], points.lambda_s, points.length,
               points["surface.seed"], area, points["diameter"], points.diameter, ratio)  # fmt: skip
    body = [tuple(float(column[row]) for column in columns) for row in rows]
    heads = ("H", "h'rms", "lambda_s (a0)", "l_a (a0)", "seed", "A_rep/A0", "d_rep (a0)", "4h'/h'' (a0)", "ratio")
    return Drawing(figure, Sheet.of("diameter", heads, body), "Mean diameter of contact patches against the area.")


AXES: Mapping[str, Callable[[Points], Drawing]] = {
    "finite-size": finite_size,
    "continuum-limit": continuum_limit,
    "lambda-L": roll_off,
    "other-potentials": other_potentials,
    "stiffness": stiffness,
    "pull-off": pull_off,
    "diameter": diameter,
}
"""Figures of further inputs."""
