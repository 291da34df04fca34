"""The table of each figure that shows numbers, and how it is drawn from that.

Figs. 2 to 4, S-2 and S-3 of the paper, and d_rep against area; then those of the further inputs: size, continuum limit,
roll-off, laws, stiffness, pull-off.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from pandas import DataFrame, concat

from continuum.measure.contact import adhesion
from continuum.paper.points import (
    ENOUGH,
    LENGTH,
    adhesion_colour,
    adhesion_key,
    alike,
    chosen,
    curve_of,
    draw_points,
    figure_table,
    line_of_slope,
    over_surfaces,
    symbol_key,
)
from continuum.show import plot
from continuum.theory import rough
from continuum.theory.paper import asperity_radius
from continuum.theory.smooth import JKR

_STICKY = "#009e73"
_LINES = 12
"""Paths up to which their points are joined; of more, lines hide the points."""


def draw_area_against_load(numbers: DataFrame) -> Figure:
    """Fig. 2: a curve for each surface and adhesion length, there and back."""
    figure, axis = plot.new_axes(plot.COLUMN, 3.6)
    ways: dict[str, Any] = {
        "approach": {"linestyle": "-", "marker": "o"},
        "retraction": {"linestyle": "--", "marker": "v", "markerfacecolor": "white"},
    }
    same: dict[str, Any] = {"markersize": 3, "markeredgewidth": 0.6, "linewidth": 0.7}
    numbers = numbers.assign(way=numbers.get("way", "approach"))
    x, y, enough = "N/(h' E* A0)", "A_rep/A0", "A_rep >= 10 lambda_s^2"
    for (length, _, way), path in numbers.groupby([LENGTH, "seed", "way"], sort=False):
        look = {**same, **ways[way], "color": adhesion_colour(length)}
        path = path.sort_values(y)
        axis.plot(path[x], path[y], **{**look, "marker": ""})
        for some, pale in ((path[path[enough]], 1.0), (path[~path[enough]], 0.4)):
            axis.plot(some[x], some[y], **{**look, "linestyle": "none", "alpha": pale})
    pulling = numbers[(numbers["way"] == "retraction") & numbers[enough] & (numbers[x] < 0)]
    hold = pulling.loc[pulling.groupby([LENGTH, "seed"])[x].idxmin()]
    axis.plot(hold[x], hold[y], "o", color=_STICKY, markerfacecolor="none", markersize=8, markeredgewidth=0.6,
              label="largest tension on the way back" if len(hold) else None)  # fmt: skip
    high = axis.get_ylim()[1]
    axis.plot([0, high / 2], [0, high], ":", color="0.4", label=r"$\kappa = 2$, the paper's without adhesion")
    axis.axvline(0, color=_STICKY, linewidth=0.9, zorder=0, label=r"the threshold, $\kappa = \infty$")
    axis.set(xlabel=r"$N/(h'_\mathrm{rms} E^* A_0)$", ylabel=r"$A_\mathrm{rep}/A_0$")
    axis.locator_params(axis="x", nbins=5)
    key = [Line2D([], [], color="0.3", label=way, **same, **ways[way]) for way in ways if way in set(numbers["way"])]
    label = rf"$A_\mathrm{{rep}} < {ENOUGH:g}\lambda_s^2$"
    few = Line2D([], [], color="0.3", marker="o", alpha=0.4, linestyle="none", label=label,
                 markersize=3)  # fmt: skip
    rest = [*(key if len(key) > 1 else ()), *(() if numbers[enough].all() else (few,)), *plot.labelled(axis)]
    plot.legend_below(figure, adhesion_key(numbers[LENGTH], "-"), rest)
    return figure


def caption_of_area_against_load(numbers: DataFrame) -> str:
    """Caption of Fig. 2, which says what was followed back, and the largest tension."""
    numbers = numbers.assign(way=numbers.get("way", "approach"))
    lengths = sorted(set(numbers[LENGTH]))
    back = sorted(set(numbers[LENGTH][numbers["way"] == "retraction"]))
    ways = "on approach"
    if back:
        ways += " and back" + ("" if back == lengths else f" (at l_a = {', '.join(f'{length:g}' for length in back)})")
    area, tension = numbers["A_rep/A0"].max(), -numbers["N/(h' E* A0)"].min()
    most = f" The largest tension is {tension:.2g} h' E* A0." if tension > 0 else ""
    return (
        f"Fig. 2: repulsive area against load up to {100 * area:.2g} % of A0, {ways}; each line a surface, H = 0.8, "
        f"h'rms = 0.1, λ_s = 32 a0. Left of the threshold the load is negative, and so is κ.{most}"
    )


_PANELS = (
    ("A_att w/range (E* A0)", r"$(A_\mathrm{att}/A_0)\,w/\Delta r$ ($E^*$)",
     "N_att (E* A0)", r"$N_\mathrm{att}/A_0$ ($E^*$)", r"$N_\mathrm{att} = (w/\Delta r)\,A_\mathrm{att}$"),
    ("h' A_rep/2 (A0)", r"$h'_\mathrm{rms}A_\mathrm{rep}/(2A_0)$",
     "N_rep (E* A0)", r"$N_\mathrm{rep}/(E^*A_0)$", r"$\kappa_\mathrm{rep} = 2$"),
    ("A_rep/A0", r"$A_\mathrm{rep}/A_0$",
     "P (4h'/h'')/(pi A0)", r"$(P/A_0)\,(4h'_\mathrm{rms}/h''_\mathrm{rms})/\pi$",
     r"$d_\mathrm{rep} = 4h'_\mathrm{rms}/h''_\mathrm{rms}$"),
)  # fmt: skip
"""Panels of Fig. 3: the columns across and up, each with its label, and the title."""


def draw_loads(numbers: DataFrame) -> Figure:
    """Fig. 3: a panel for each relation."""
    figure, axes = plot.new_axes(plot.PAGE, 3.1, 1, 3)
    for axis, (x, across, y, up, _) in zip(axes, _PANELS, strict=True):
        draw_points(axis, numbers[(numbers[x] > 0) & (numbers[y] > 0)], x, y)
        axis.set(xscale="log", yscale="log", xlabel=across, ylabel=up)
        line_of_slope(axis, label="as the title says")
    line_of_slope(axes[2], 2.0, "within a factor of two", ":")
    line_of_slope(axes[2], 0.5, "", ":")
    plot.log_ticks(*axes)
    plot.letter_panels(axes, [title for *_, title in _PANELS])
    plot.legend_below(figure, *symbol_key(numbers), plot.labelled(*axes))
    return figure


_THEORY, _MEASURED, _REPULSIVE = "1/kappa_att theory", "1/kappa_att", "1/kappa_rep"
"""Columns of Fig. 4 by which its border is drawn."""


def kappas(points: DataFrame) -> DataFrame:
    """Fig. 4: 1/κ_att and A_rep/A_att, and what theory says of them; and where searches have found the threshold."""
    points = points.assign(
        inverse=1 / points.kappa_att.where(points.kappa_att > 0, np.inf), ratio=points.area_rep / points.area_att,
        repulsive=1 / points.kappa_rep,
    )  # fmt: skip
    shown = over_surfaces(points, "inverse", "ratio", "load", "repulsive")
    found = figure_table(shown, {
        _THEORY: 1 / shown.expected_kappa_att, _MEASURED: shown.inverse,
        "scatter of it": shown.inverse_scatter, "A_rep/A_att theory": shown.expected_ratio, "A_rep/A_att": shown.ratio,
        "scatter": shown.ratio_scatter, "mean load (E*)": shown.load, _REPULSIVE: shown.repulsive, "threshold": False,
    })  # fmt: skip
    thresholds = [
        threshold
        for _, trials in points[points.search >= 0].groupby("search")
        if (threshold := _threshold(trials)) is not None
    ]
    return concat([found, *thresholds], ignore_index=True)


def _threshold(trials: DataFrame) -> DataFrame | None:
    """Place at which the load changes its sign in a search, between the two nearest trials; None where it does not."""
    trials = trials.assign(theory=1 / trials.expected_kappa_att).sort_values("theory")
    changes = np.flatnonzero((trials.load.to_numpy()[:-1] > 0) & (trials.load.to_numpy()[1:] <= 0))
    if not changes.size:
        return None
    width = (trials.theory.shift(-1) / trials.theory).to_numpy()
    at = changes[np.argmin(width[changes])]
    ends = trials.iloc[[at, at + 1]]
    share = ends.load.iloc[0] / (ends.load.iloc[0] - ends.load.iloc[1])

    def between(column: str) -> float:
        low, high = np.log(ends[column])
        return float(np.exp((1 - share) * low + share * high))

    row = ends[:1].assign(**{name: between(name) for name in ("slope", "length")})
    found = {_THEORY: between("theory"), _MEASURED: between("inverse"), _REPULSIVE: between("repulsive")}
    return figure_table(row, {**found, "mean load (E*)": 0.0, "threshold": True})


def _draw_borders(axis: Axes, numbers: DataFrame) -> None:
    """Borders of stickiness over 1/κ_att of theory: by the paper's κ_rep, the measured one, and searches."""
    ends = axis.get_xlim()
    if ends[1] > 0.5:  # else nothing of it would show but its entry in the legend
        axis.axvspan(0.5, ends[1], color=_STICKY, alpha=0.1, linewidth=0,
                     label=r"sticky by theory, $\kappa_\mathrm{rep} = 2$")  # fmt: skip
    thresholds = numbers["threshold"]
    lines = ((numbers[~thresholds][_REPULSIVE].dropna(), "--", r"the same, $\kappa_\mathrm{rep}$ as measured"),
             (numbers[thresholds][_THEORY], "-",
              f"threshold, by bisection of {thresholds.sum()} surfaces"))  # fmt: skip
    for values, style, label in lines:
        if len(values):
            middle, spread = np.log(values).mean(), np.log(values).std(ddof=1) if len(values) > 1 else 0.0
            axis.axvline(np.exp(middle), color=_STICKY, linestyle=style, linewidth=0.9, zorder=1, label=label)
            axis.axvspan(*np.exp([middle - spread, middle + spread]), color=_STICKY, alpha=0.12, linewidth=0, zorder=0)
    axis.set_xlim(*ends)


def draw_kappas(numbers: DataFrame) -> Figure:
    """Fig. 4: 1/κ_att and A_rep/A_att against theory."""
    figure, (left, right) = plot.new_axes(plot.PAGE, 3.9, 1, 2)
    if "threshold" not in numbers:
        numbers = numbers.assign(threshold=False, **{_REPULSIVE: np.nan})
    points, thresholds = numbers[~numbers["threshold"]], numbers[numbers["threshold"]]
    draw_points(left, points, _THEORY, _MEASURED, "scatter of it")
    sticky = points[points["mean load (E*)"] < 0]
    if len(thresholds):
        left.plot(thresholds[_THEORY], thresholds[_MEASURED], "x", color="black", markersize=5, zorder=5,
                  label=r"the thresholds: $\kappa_\mathrm{att} = \kappa_\mathrm{rep}$")  # fmt: skip
    else:
        left.plot(sticky[_THEORY], sticky[_MEASURED], "o", color=_STICKY, markerfacecolor="none",
                  markersize=8, markeredgewidth=0.6,
                  label="sticky: mean load < 0" if len(sticky) else None)  # fmt: skip
    draw_points(right, points, "A_rep/A_att theory", "A_rep/A_att", "scatter")
    for axis, quantity, equations in (
        (left, r"1/\kappa_\mathrm{att}", "Eqs. (3) and (4)"),
        (right, r"A_\mathrm{rep}/A_\mathrm{att}", "Eq. (4)"),
    ):
        axis.set(xscale="log", yscale="log", xlabel=f"${quantity}$, {equations}", ylabel=f"${quantity}$ measured")
        line_of_slope(axis, label="equal")
    _draw_borders(left, numbers)
    plot.log_ticks(left, right)
    plot.letter_panels((left, right))
    plot.legend_below(figure, *symbol_key(points), plot.labelled(left, right))
    return figure


def draw_perimeters(numbers: DataFrame) -> Figure:
    """Fig. S-2: P d/(π A_rep) against the mean chord d."""
    figure, axis = plot.new_axes(plot.COLUMN, 3.4)
    draw_points(axis, numbers, "chord (a0)", "P d/(pi A_rep)")
    # One frame for all sweeps.
    low, high = axis.get_ylim()
    chord = numbers["chord (a0)"]
    axis.set(
        xscale="log", xlim=(min(2.0, chord.min() / 1.1), chord.max() * 1.1), ylim=(min(low, 0.75), max(high, 1.05))
    )
    plot.log_ticks(axis)
    axis.axhline(1, color="0.5", linewidth=0.9, label="equal", zorder=0)
    if axis.get_xlim()[1] > 10:
        axis.axvline(10, color="0.5", linewidth=0.9, linestyle=":", label=r"below $10\,a_0$ cells show", zorder=0)
    axis.set(xlabel=r"mean chord $d$ of $A_\mathrm{rep}$ ($a_0$)", ylabel=r"$P\,d/(\pi A_\mathrm{rep})$")
    plot.legend_below(figure, *symbol_key(numbers), plot.labelled(axis))
    return figure


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


_LOWEST_TENSION = 1e-6
"""Lower end of the axis of Fig. S-3."""
NEVER = "$\\downarrow$"
"""Symbol of a contact that never pulls, on the axis of Fig. S-3."""


def draw_tensions(numbers: DataFrame) -> Figure:
    """Fig. S-3: the largest tension on approach against h_rms/δ_c, beside Fuller and Tabor.

    A logarithmic axis has no place for contacts that never pull: they are arrows at its lower end.
    """
    pulls = numbers["N_max/(N P_c)"] > 0
    figure, axis = plot.new_axes(plot.COLUMN, 3.6)
    draw_points(axis, numbers[pulls], "h_rms/delta_c", "N_max/(N P_c)")
    ratio = np.geomspace(0.3, 30, 40)
    theory = np.array([rough.fuller_tabor(float(r)) for r in ratio])
    axis.plot(ratio[theory > 1e-6], theory[theory > 1e-6], "-", color="0.4", label="Fuller and Tabor (1975)")
    axis.set(xscale="log", yscale="log", xlabel=r"$h_\mathrm{rms}/\delta_c$", ylabel=r"$N_\mathrm{max}/(N P_c)$")
    axis.set_ylim(bottom=_LOWEST_TENSION)
    never = numbers[~pulls]
    label = f"never pulls on approach, {len(never)} of {len(numbers)}"
    for row, (length, some) in enumerate(never.groupby(LENGTH)):
        level = np.full(len(some), _LOWEST_TENSION * 2.5**row)  # a row for each l_a, as there may be hundreds
        axis.plot(some["h_rms/delta_c"], level, marker=NEVER, linestyle="none", markersize=5, markeredgewidth=0,
                  color=adhesion_colour(length), clip_on=False)  # fmt: skip
    arrow = Line2D([], [], marker=NEVER, linestyle="none", markersize=5, markeredgewidth=0, color="0.3", label=label)
    hursts, _, slopes, cuts = symbol_key(numbers[pulls])
    key = hursts, adhesion_key(numbers[LENGTH]), slopes, cuts
    plot.log_ticks(axis)
    plot.legend_below(figure, *key, [*plot.labelled(axis), *([arrow] if len(never) else [])])
    return figure


def long_paths(points: DataFrame) -> DataFrame:
    """The approaching points in contact of paths that have three of them at least."""
    touching = chosen(points, "approach and area_rep > 0 and diameter > 0")
    return touching.groupby("system").filter(lambda path: len(path) > 2)


def draw_diameters(numbers: DataFrame) -> Figure:
    """Mean diameter of the patches over 4h'/h'' against the area, a line for each path."""
    figure, axis = plot.new_axes(plot.COLUMN, 3.6)
    axis.axhspan(0.5, 2, color="0.94", zorder=0, label="within a factor of two")
    systems = numbers.groupby(["H", "h'rms", "lambda_s (a0)", LENGTH, "seed"], dropna=False)
    paths = [path for _, path in systems]
    for path in paths if len(paths) <= _LINES else ():
        shade = adhesion_colour(path[LENGTH].iloc[0])
        axis.plot(path["A_rep/A0"], path["ratio"], "-", color=shade, linewidth=0.5)
    draw_points(axis, numbers, "A_rep/A0", "ratio")
    axis.set(xscale="log", ylim=(0, 3), xlabel=r"$A_\mathrm{rep}/A_0$",
             ylabel=r"$d_\mathrm{rep}/(4h'_\mathrm{rms}/h''_\mathrm{rms})$")  # fmt: skip
    plot.log_ticks(axis)
    plot.legend_below(figure, *symbol_key(numbers), plot.labelled(axis))
    return figure


# --- figures of the further inputs ----------------------------------------------------------------------------------


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
"""Names of laws in figures, in the order of their tails; the tails are those of the energy."""
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
