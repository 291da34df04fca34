"""Figures of the further inputs, each with its table: size, continuum limit, roll-off, laws, stiffness, pull-off."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from pandas import DataFrame

from continuum.measure.curve import adhesion
from continuum.paper.points import (
    LENGTH,
    adhesion_colour,
    adhesion_key,
    alike,
    curve_of,
    draw_points,
    line_of_slope,
    over_surfaces,
    symbol_key,
)
from continuum.show import plot


def inverse_kappas(points: DataFrame, *, key: str, column: str, along: Sequence[str] = ()) -> DataFrame:
    """Means and scatter over surfaces of the inverse of a column, κ or κ_rep.

    The key is that of [surface] on the x axis, and ``along`` are keys that change together with it.
    """
    body = []
    for length, same in points.groupby("length"):
        for _, curve in same.groupby(alike(same, f"surface.{key}", "surface.seed", *along), sort=False):
            inverse = {float(x): 1 / group[column].to_numpy() for x, group in curve.groupby(key)}
            for x, values in inverse.items():
                scatter = values.std(ddof=1) if values.size > 1 else 0.0
                body.append((length, x, values.mean(), scatter, values.size))
    return DataFrame(body, columns=[LENGTH, f"surface.{key}", f"1/{column}", "scatter over surfaces", "surfaces"])


def draw_inverse_kappas(numbers: DataFrame, *, label: str) -> Figure:
    """1/κ against a key of the input, one curve for each adhesion length."""
    figure, axis = plot.new_axes(plot.COLUMN, 2.9)
    key, column = numbers.columns[1:3]
    for length, same in numbers.groupby(LENGTH):
        # The key grows along a curve; where it falls the next begins.
        for _, curve in same.groupby((same[key].diff() <= 0).cumsum()):
            axis.errorbar(curve[key], curve[column], yerr=curve["scatter over surfaces"], fmt="o-", capsize=2,
                          color=adhesion_colour(length))  # fmt: skip
    axis.axhline(0.5, color="0.6", linestyle="--", linewidth=0.8, label="1/2, the paper's without adhesion")
    axis.axhline(0, color="0.6", linestyle=":", linewidth=0.8, label="below: sticky")
    axis.set_xscale("log")
    plotted = sorted(set(numbers[key]))
    axis.set_xticks(plotted, [f"{value:g}" for value in plotted])
    axis.set_xticks([], minor=True)
    axis.set(xlabel=label, ylabel=r"$1/\kappa$" if column == "1/kappa" else r"$1/\kappa_\mathrm{rep}$")
    plot.legend_below(figure, [*adhesion_key(numbers[LENGTH], "o-"), *plot.labelled(axis)])
    return figure


_LAWS = {
    "lennard-jones-spline": "the paper's spline", "spline": "spline of given range", "exponential": "exponential",
    "lennard-jones-12-6": "12-6: tail $z^{-6}$", "lennard-jones-9-3": "9-3: tail $z^{-3}$",
}  # fmt: skip
"""What a law is called in a figure, in the order of their tails; the tails are those of the energy."""
_AROUND = ("spline", "exponential")
"""Chosen to lie where another law does: open symbols around its own."""


def laws(points: DataFrame) -> DataFrame:
    """1/κ_att of each law, means and scatter over surfaces, and by theory with the effective range."""
    shape = points.law.where(points.law != "attraction-on-core", points["shape"])
    points = points.assign(name=shape, inverse=1 / points.kappa_att)
    shown = over_surfaces(points, "inverse")
    return DataFrame({
        "law": shown.name, LENGTH: shown.length, "effective range (a0)": shown.effective_range,
        "1/kappa_att theory": 1 / shown.expected_kappa_att, "1/kappa_att": shown.inverse,
        "scatter over surfaces": shown.inverse_scatter,
    }).sort_values(["law", LENGTH])  # fmt: skip


def draw_laws(numbers: DataFrame) -> Figure:
    """1/κ_att measured against theory with the effective range, one symbol for each law."""
    figure, axis = plot.new_axes(plot.COLUMN, 3.1)
    if "scatter over surfaces" not in numbers:  # tables of before
        numbers = numbers.assign(**{"scatter over surfaces": 0.0})
    names = [law for law in _LAWS if law in set(numbers["law"])]
    names += sorted(set(numbers["law"]) - set(names))
    for i, law in enumerate(names):
        mine = numbers[numbers["law"] == law]
        bars = mine["scatter over surfaces"].where(mine["scatter over surfaces"] > 0)
        look = {"markerfacecolor": "none", "markersize": 6.5} if law in _AROUND else {"markersize": 3.5}
        axis.errorbar(
            mine["1/kappa_att theory"], mine["1/kappa_att"], bars, fmt="os^Dv"[i % 5], elinewidth=0.7,
            capsize=2, color=plot.SERIES[i % len(plot.SERIES)], label=_LAWS.get(law, law), **look,
        )  # fmt: skip
    axis.set(xscale="log", yscale="log", ylabel=r"$1/\kappa_\mathrm{att}$ measured",
             xlabel=r"$1/\kappa_\mathrm{att}$, Eqs. (3), (4) with $\Delta r$ of Eq. (S-5)")  # fmt: skip
    line_of_slope(axis, label="equal")
    line_of_slope(axis, 2.0, "twice that", ":")
    plot.log_ticks(axis)
    plot.legend_below(figure, plot.labelled(axis))
    return figure


_REDUCTION, _STIFFNESS, _SECANT = "kappa_rep/kappa", "k_N h_rms/N_rep", "k_N h_rms/N_rep between points"


def draw_stiffnesses(numbers: DataFrame) -> Figure:
    """k_N over the repulsive load against κ_rep/κ, beside the paper's proportionality."""
    figure, axis = plot.new_axes(plot.COLUMN, 3.2)
    for length, path in numbers.groupby(LENGTH):
        axis.plot(path[_REDUCTION], path[_SECANT], "x", color=adhesion_colour(length), markersize=3, alpha=0.6)
    axis.plot([], [], "x", color="0.3", markersize=3, label="between points, jumps included")
    draw_points(axis, numbers, _REDUCTION, _STIFFNESS)
    bare = numbers[numbers[LENGTH] == 0][_STIFFNESS].mean()
    if np.isfinite(bare):
        line_of_slope(axis, bare, r"$k_N \propto \kappa_\mathrm{rep}/\kappa$, from those without adhesion")
    axis.axhline(0, color="0.7", linewidth=0.6, zorder=0)
    axis.set(xlabel=r"$\kappa_\mathrm{rep}/\kappa = N/N_\mathrm{rep}$", ylabel=r"$k_N h_\mathrm{rms}/N_\mathrm{rep}$")
    plot.legend_below(figure, *symbol_key(numbers)[1:3], plot.labelled(axis))
    return figure


def whole_cycles(points: DataFrame) -> DataFrame:
    """The points of paths with a way back of which every point converged: work over a missing one would be a guess."""
    return points.groupby("system").filter(
        lambda path: path.retracting.any() and np.array_equal(path.step, np.arange(len(path)))
    )


_PEAK, _PULL = "peak A_rep/A0", "pull-off (E*)"


def cycles(points: DataFrame) -> DataFrame:
    """Numbers of each cycle, one row for each system."""
    body = {}
    for system, path in points.groupby("system"):
        found = adhesion(curve_of(path))
        length = path.length.iloc[0]
        w = length if length > 0 else np.nan
        body[system] = {
            LENGTH: length, "seed": float(path.seed.iloc[0]), _PEAK: path.area_rep.max(),
            "peak load (E*)": found.peak_load, "tension on approach (E*)": found.largest_tension,
            _PULL: found.pull_off, "work of separation/w": found.work_of_separation / w, "loss/w": found.loss / w,
        }  # fmt: skip
    return DataFrame.from_dict(body, orient="index")


def draw_cycles(points: DataFrame) -> Figure:
    """Cycles of load against mean gap, and the pull-off against how far the contact was pressed before."""
    numbers = cycles(points)
    figure, (left, right) = plot.new_axes(plot.PAGE, 3.0, 1, 2)
    ways = (("approach", ".", None), ("retraction", "s", "none"))
    for system in numbers.groupby([LENGTH, "seed"], sort=False)[_PEAK].idxmax():
        path = points[points.system == system]
        for (_, marker, fill), some in zip(ways, (path[path.approach], path[~path.approach]), strict=True):
            # Points only: between many of them the contact jumps.
            left.plot(some.mean_gap, some.load / some.rms_slope, marker, markersize=3, markeredgewidth=0.6,
                      color=adhesion_colour(path.length.iloc[0]), markerfacecolor=fill)  # fmt: skip
    pulling = numbers[numbers[_PULL] > 0].sort_values([_PEAK, _PULL])
    for (length, _), mine in pulling.groupby([LENGTH, "seed"]):
        right.plot(mine[_PEAK], mine[_PULL], "o-", color=adhesion_colour(length), linewidth=0.8)
    left.axhline(0, color="0.7", linewidth=0.6)
    tension = max(-float((points.load / points.rms_slope).min()), 1e-6)
    left.set(xlabel="mean gap ($a_0$)", ylabel=r"$N/(h'_\mathrm{rms} E^* A_0)$", ylim=(-1.3 * tension, 1.3 * tension))
    right.set(yscale="log", ylabel="pull-off, $-N/A_0$ ($E^*$)", xlabel=r"largest $A_\mathrm{rep}/A_0$ before")
    plot.log_ticks(right)
    plot.letter_panels((left, right), ("the deepest cycle of each surface", "each line a surface"))
    key = [
        Line2D([], [], marker=marker, linestyle="none", color="0.3", markerfacecolor=fill, label=f"{way} (A)")
        for way, marker, fill in ways
    ]
    plot.legend_below(figure, [*adhesion_key(numbers[LENGTH], "-"), *key])
    return figure
