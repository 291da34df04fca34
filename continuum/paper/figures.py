"""The paper's figures from the files of a sweep alone: PNG, PDF and CSV, one function each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from continuum.files import output
from continuum.model.fourier import Real
from continuum.paper.points import FigureError, Points, colour, draw, legend, plain_ticks
from continuum.runs.collect import PointTable
from continuum.show import plot
from continuum.show.sheet import Sheet
from continuum.theory import rough


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure with the numbers that it shows."""

    figure: Figure
    sheet: Sheet
    caption: str


def save_drawing(drawing: Drawing, stem: Path) -> list[Path]:
    """Write ``stem.png``, ``stem.pdf`` and ``stem.csv``; returns PNG and CSV.

    Raises
    ------
    OutputError
        If they cannot be written there.
    """
    picture = plot.save_figure(drawing.figure, stem)
    return [picture, output.save(stem.with_name(f"{stem.name}.csv"), drawing.sheet.csv())]


def _rows(mask: Real | np.ndarray) -> np.ndarray:
    rows = np.flatnonzero(mask)
    if rows.size == 0:
        msg = "the sweep has no point that this figure shows: too few systems are done, or it is another sweep"
        raise FigureError(msg)
    return rows


def _line(axis: Axes, slope: float = 1.0, label: str = "", linestyle: str = "-") -> None:
    """Y = slope x over what is shown."""
    low, high = axis.get_xlim()
    ends = np.array([low, high])
    axis.plot(ends, slope * ends, linestyle, color="0.5", linewidth=0.9, zorder=0, label=label)
    axis.set_xlim(low, high)


_KEYS = ("surface.hurst", "surface.rms_slope", "surface.lambda_s", "work_of_adhesion", "surface.seed")


def _sheet(points: Points, rows: np.ndarray, title: str, columns: Mapping[str, Real]) -> Sheet:
    """The numbers of a figure: what the symbols stand for, and what is drawn."""
    names = ["H", "h'rms", "lambda_s (a0)", "l_a (a0)", "seed", "A_rep >= 10 lambda_s^2", *columns]
    body = zip(*(points[key][rows] for key in _KEYS), points.valid[rows].tolist(), *columns.values(), strict=True)
    return Sheet.of(title, names, [[x.item() if isinstance(x, np.generic) else x for x in row] for row in body])


@plot.styled
def area_against_load(points: Points) -> Drawing:
    """Fig. 2: A_rep/A0 against N/(h' E* A0), one curve for each adhesion length."""
    chosen = (points.lambda_s == 32) & (points["surface.hurst"] == 0.8) & (points["surface.rms_slope"] == 0.1)
    rows = _rows(chosen & (points["retracting"] == 0))
    load = points["load"] / points["rms_slope"]
    figure = plot.new_figure(5.2, 3.8)
    axis = figure.subplots()
    for length in sorted(set(points.length[rows])):
        mine = rows[points.length[rows] == length]
        for i, path in enumerate(points.groups(mine)):
            path = path[np.argsort(points["area_rep"][path])]
            name = rf"$\ell_a/a_0 = {length:g}$, each line a surface" if i == 0 else None
            axis.plot(load[path], points["area_rep"][path], "-", color=colour(length), linewidth=0.8, label=name)
            for valid, fill in ((True, colour(length)), (False, "none")):
                some = path[points.valid[path] == valid]
                axis.plot(load[some], points["area_rep"][some], "o", color=colour(length), markerfacecolor=fill)
    high = axis.get_ylim()[1]
    axis.plot([0, high / 2], [0, high], "--", color="0.4", label=r"$\kappa = 2$, the paper's value without adhesion")
    if not points.valid[rows].all():
        axis.plot([], [], "o", color="0.3", markerfacecolor="none", label=r"$A_{rep} < 10\lambda_s^2$")
    axis.axvline(0, color="0.7", linewidth=0.6)
    axis.set_xlabel(r"$N/(h'_{rms} E^* A_0)$")
    axis.set_ylabel(r"$A_{rep}/A_0$")
    axis.legend(fontsize=7)
    sheet = _sheet(points, rows, "Fig. 2", {"N/(h' E* A0)": load[rows], "A_rep/A0": points["area_rep"][rows]})
    return Drawing(figure, sheet, "Fig. 2: repulsive area against load; H = 0.8, h'rms = 0.1, λ_s = 32 a0.")


@plot.styled
def loads(points: Points) -> Drawing:
    """Fig. 3: N_att against A_att w/Δr; N_rep against h' A_rep; P against A_rep."""
    rows = _rows((points["area_rep"] > 0) & points.valid)
    adhesive = rows[points["area_att"][rows] * points.length[rows] > 0]
    pulling = points.length / np.where(points["range"] > 0, points["range"], np.inf)
    expected = points["area_att"] * pulling
    pushed = points["rms_slope"] * points["area_rep"] / 2
    around = points["perimeter"] * points.diameter / np.pi / points.area
    figure = plot.new_figure(9.6, 3.4)
    axes = figure.subplots(1, 3)
    draw(axes[0], points, expected[adhesive], points["load_att"][adhesive], adhesive)
    draw(axes[1], points, pushed[rows], points["load_rep"][rows], rows)
    draw(axes[2], points, points["area_rep"][rows], around[rows], rows)
    labels = (
        (r"$(A_{att}/A_0)\,w/\Delta r$ ($E^*$)", r"$N_{att}/A_0$ ($E^*$)", "equal"),
        (r"$h'_{rms}A_{rep}/(2A_0)$", r"$N_{rep}/(E^*A_0)$", r"$\kappa_{rep} = 2$"),
        (r"$A_{rep}/A_0$", r"$(P/A_0)\,(4h'_{rms}/h''_{rms})/\pi$", r"$d_{rep} = 4h'/h''$"),
    )
    for axis, (x, y, name) in zip(axes, labels, strict=True):
        axis.set(xscale="log", yscale="log", xlabel=x, ylabel=y)
        _line(axis, label=name)
    _line(axes[2], 2.0, "within a factor of two", linestyle=":")
    _line(axes[2], 0.5, "", linestyle=":")
    for axis in axes[1:]:
        axis.legend(fontsize=7)
    legend(axes[0], points, rows, fontsize=5.5)
    columns = {
        "A_att w/range (E* A0)": expected[rows], "N_att (E* A0)": points["load_att"][rows],
        "h' A_rep/2 (A0)": pushed[rows], "N_rep (E* A0)": points["load_rep"][rows],
        "A_rep/A0": points["area_rep"][rows], "P (4h'/h'')/(pi A0)": around[rows],
    }  # fmt: skip
    text = "Fig. 3: attractive and repulsive load, and perimeter, against the areas that the paper says they follow."
    return Drawing(figure, _sheet(points, rows, "Fig. 3", columns), text)


def _over_seeds(points: Points, rows: np.ndarray, *columns: Real) -> tuple[np.ndarray, list[Real], list[Real]]:
    """One row for each system; means and standard deviations over its surfaces."""
    groups = list(points.groups(rows, "surface.seed"))
    first = np.array([group[0] for group in groups])
    means = [np.array([column[group].mean() for group in groups]) for column in columns]
    scatter = [np.array([c[g].std(ddof=1) if g.size > 1 else 0.0 for g in groups]) for c in columns]
    return first, means, scatter


@plot.styled
def kappa(points: Points) -> Drawing:
    """Fig. 4: 1/κ_att and A_rep/A_att against theory."""
    rows = _rows(points.reference & (points.length > 0) & (points["area_att"] > 0))
    measured = 1 / np.where(points["kappa_att"] > 0, points["kappa_att"], np.inf)
    ratio = points["area_rep"] / np.where(points["area_att"] > 0, points["area_att"], np.inf)
    shown, means, errors = _over_seeds(points, rows, measured, ratio, points["load"])
    figure = plot.new_figure(8.8, 4.2)
    left, right = figure.subplots(1, 2)
    x = 1 / points.kappa_att[shown]
    draw(left, points, x, means[0], shown, errors[0])
    sticky = means[2] < 0
    left.plot(x[sticky], means[0][sticky], "o", color="#009e73", markerfacecolor="none", markersize=11,
              markeredgewidth=0.7, label="sticky: mean load < 0")  # fmt: skip
    left.set(
        xscale="log", yscale="log", xlabel=r"$1/\kappa_{att}$, Eqs. (3) and (4)", ylabel=r"$1/\kappa_{att}$ measured"
    )
    _line(left, label="equal")
    left.axvspan(0.5, left.get_xlim()[1], color="#009e73", alpha=0.1, linewidth=0,
                 label=r"sticky by theory, $\kappa_{rep} = 2$")  # fmt: skip
    draw(right, points, points.area_ratio[shown], means[1], shown, errors[1])
    right.set(xscale="log", yscale="log", xlabel=r"$A_{rep}/A_{att}$, Eq. (4)", ylabel=r"$A_{rep}/A_{att}$ measured")
    _line(right, label="equal")
    right.legend(fontsize=7)
    legend(left, points, shown, fontsize=6)
    columns = {
        "1/kappa_att theory": x, "1/kappa_att": means[0], "scatter of it": errors[0],
        "A_rep/A_att theory": points.area_ratio[shown], "A_rep/A_att": means[1], "scatter": errors[1],
        "mean load (E*)": means[2],
    }  # fmt: skip
    text = (
        "Fig. 4: means over surfaces, bars their standard deviation, of the first point with A_rep >= 10 λ_s² from 1 %."
    )
    return Drawing(figure, _sheet(points, shown, "Fig. 4", columns), text)


@plot.styled
def perimeter(points: Points) -> Drawing:
    """Fig. S-2: P d/(π A_rep) against the mean chord d."""
    rows = _rows((points["chord"] > 0) & points.valid & (points["retracting"] == 0))
    ratio = points["perimeter"] * points["chord"] / (np.pi * points["area_rep"] * points.area)
    figure = plot.new_figure(5.4, 3.8)
    axis = figure.subplots()
    draw(axis, points, points["chord"][rows], ratio[rows], rows)
    # One frame for all sweeps, with room for the legend below the curve that points of any chord make.
    chord, (low, high) = points["chord"][rows], axis.get_ylim()
    axis.set(
        xscale="log", xlim=(min(2.0, chord.min() / 1.1), chord.max() * 1.1), ylim=(min(low, 0.75), max(high, 1.05))
    )
    plain_ticks(axis)
    axis.axhline(1, color="0.5", linewidth=0.9, label="equal")
    axis.axvline(10, color="0.5", linewidth=0.9, linestyle=":", label="below 10 $a_0$ cells show")
    axis.set_xlabel("mean chord of $A_{rep}$ ($a_0$)")
    axis.set_ylabel(r"$P\,d/(\pi A_{rep})$")
    legend(axis, points, rows, loc="lower right", fontsize=6)
    columns = {"chord (a0)": points["chord"][rows], "P d/(pi A_rep)": ratio[rows]}
    return Drawing(figure, _sheet(points, rows, "Fig. S-2", columns), "Fig. S-2: perimeter, chord and area.")


@plot.styled
def asperities(points: Points) -> Drawing:
    """Fig. S-3: the largest tension on approach against h_rms/δ_c, beside Fuller and Tabor."""
    rows, tension = [], []
    for path in points.paths():
        path = path[points["retracting"][path] == 0]
        if path.size and points.length[path[0]] > 0:
            rows.append(int(path[np.argmin(points["load"][path])]))
            tension.append(max(0.0, -float(points["load"][path].min())))
    found = _rows(np.isin(np.arange(points.valid.size), rows)) if rows else _rows(np.zeros(1))
    found, force = np.array(rows), np.array(tension)
    w, height = points.length[found], points["rms_height"][found]
    reach = 0.75 * (np.pi**2 * w**2 * 2 / points["rms_curvature"][found]) ** (1 / 3)
    scaled = force / np.array([rough.asperity_limit(*pair) for pair in zip(w, height, strict=True)])
    pulls = scaled > 0
    figure = plot.new_figure(5.4, 4.0)
    axis = figure.subplots()
    draw(axis, points, (height / reach)[pulls], scaled[pulls], found[pulls])
    ratio = np.geomspace(0.3, 30, 40)
    theory = np.array([rough.fuller_tabor(float(r)) for r in ratio])
    axis.plot(ratio[theory > 1e-6], theory[theory > 1e-6], "-", color="0.4", label="Fuller and Tabor (1975)")
    axis.set(xscale="log", yscale="log", xlabel=r"$h_{rms}/\delta_c$", ylabel=r"$N_{max}/(N P_c)$")
    axis.set_ylim(bottom=1e-6)
    plain_ticks(axis)
    legend(axis, points, found[pulls], loc="lower left", fontsize=6)
    columns = {"h_rms/delta_c": height / reach, "N_max/(N P_c)": scaled}
    text = f"Fig. S-3: largest tension on approach, at the points of each path; {int((~pulls).sum())} never pull."
    return Drawing(figure, _sheet(points, found, "Fig. S-3", columns), text)


FIGURES: Mapping[str, Callable[[Points], Drawing]] = {
    "figure2": area_against_load,
    "figure3": loads,
    "figure4": kappa,
    "figure-s2": perimeter,
    "figure-s3": asperities,
}
"""Figures that need the table of a sweep only."""


def points_of(table: PointTable) -> Points:
    """The points of a sweep.

    Raises
    ------
    FigureError
        If there are none.
    """
    if table.values.size == 0:
        msg = f"{table.listed.name}: no system of this sweep is done"
        raise FigureError(msg)
    return Points(table)
