"""Figures from stored fields: contact maps, a cut through a contact, its perimeter, the mean gap outside of it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Rectangle
from pandas import DataFrame

from continuum.measure.contact import REPULSIVE
from continuum.measure.outline import Mask, perimeter_map
from continuum.measure.profile import GapProfile
from continuum.paper.points import SweepData, adhesion_colour, adhesion_labels
from continuum.paper.relations import Drawn
from continuum.runs.analysis import MeasuredPoint, analyse_run, gap_ratio
from continuum.runs.result import Result
from continuum.show import plot
from continuum.sweeps.folder import Folder
from continuum.theory import paper

_MAP_AREA = 0.02
"""A_rep/A0 of the maps of Fig. 1."""
_PROFILE_AREA = 0.01
"""A_rep/A0 at which the profiles are taken."""
_Found = tuple[Result, MeasuredPoint, GapProfile]


def near_target_area(data: SweepData) -> list[tuple[Result, int]]:
    """One system for each adhesion length, of the first surface; and the step nearest to the area of Fig. 1."""
    found: dict[float, tuple[Result, int]] = {}
    for key in data.table.keys:
        result = Result.read(Folder(data.root).point(key))
        good = [(abs(point.area_rep - _MAP_AREA), i) for i, point in enumerate(result.points) if point.converged]
        if good:
            found.setdefault(float(result.attributes["work_of_adhesion"]), (result, min(good)[1]))
    return [found[length] for length in sorted(found)]


def _window(inside: Mask, width: int) -> tuple[int, int]:
    """Corner of the square of that width that holds most contact, among squares half a width apart."""
    step = max(1, width // 2)
    corners = [(i, j) for i in range(0, inside.shape[0] - width + 1, step)
               for j in range(0, inside.shape[1] - width + 1, step)]  # fmt: skip
    return max(corners, key=lambda c: int(inside[c[0] : c[0] + width, c[1] : c[1] + width].sum()))


def draw_contact_maps(chosen: Sequence[tuple[Result, int]]) -> Drawn:
    """Fig. 1: geometry, maps at a fixed repulsive area with growing adhesion, one patch, and a cut through it."""
    first, last = chosen[0], chosen[-1]
    n, spacing = first[0].grid.shape[0], first[0].grid.spacing[0]
    quarter, small = max(n // 4, 16), min(max(int(80 / spacing), 16), n // 2)
    whole = first[0].contact_map(first[1])
    i, j = _window(whole == REPULSIVE, quarter)
    columns = max(len(chosen) + 1, 3)  # the second row takes three
    figure, axes = plot.new_axes(3.0 * columns, 6.0, 2, columns, squeeze=False)
    plot.contact_image(axes[0, 0], whole, first[0].grid.lengths)
    axes[0, 0].add_patch(Rectangle((i * spacing, j * spacing), quarter * spacing, quarter * spacing,
                                   fill=False, edgecolor="#0072b2", linewidth=1.2))  # fmt: skip
    axes[0, 0].set_title("whole; the square is enlarged")
    rows = []
    for axis, (result, step) in zip(axes[0, 1:], chosen, strict=False):
        kinds = result.contact_map(step)
        plot.contact_image(axis, kinds[i : i + quarter, j : j + quarter], (quarter * spacing, quarter * spacing))
        length, point = float(result.attributes["work_of_adhesion"]), result.points[step]
        axis.set_title(rf"$\ell_a/a_0 = {length:.3g}$, $A_{{rep}} = {100 * point.area_rep:.2g}\,\%$")
        rows.append((length, point.area_rep, point.area_att, point.load_rep, point.load, point.mean_gap))
    kinds = last[0].contact_map(last[1])
    k, m = _window(kinds == REPULSIVE, small)
    plot.contact_image(axes[1, 0], kinds[k : k + small, m : m + small], (small * spacing, small * spacing))
    axes[1, 0].set_title(f"{small * spacing:g} $a_0$ of the strongest adhesion")
    for axis in (*axes[0, : len(chosen) + 1], axes[1, 0]):
        axis.set_xlabel("$a_0$")
    _cut(axes[1, 1], axes[1, 2], last, k, m, small)
    for axis in (*axes[1, 2:], *axes[0, len(chosen) + 1 :]):
        axis.set_axis_off()
    names = (("repulsive", plot.REPULSIVE_COLOUR), ("attracted", plot.ATTRACTED_COLOUR))
    handles = [Rectangle((0, 0), 1, 1, color=shade, label=name) for name, shade in names]
    axes[1, -1].legend(handles=handles, loc="center", title="contact maps")
    heads = ["l_a (a0)", "A_rep/A0", "A_att/A0", "N_rep/A0 (E*)", "N/A0 (E*)", "mean gap (a0)"]
    return figure, DataFrame(rows, columns=heads)


def _cut(axis: Axes, key: Axes, drawn: tuple[Result, int], k: int, m: int, small: int) -> None:
    """The rigid wall and the deformed surface along a line through the enlarged patch."""
    result, step = drawn
    gap, heights = result.gap(step), result.heights()
    if gap is None or heights is None:
        axis.text(0.5, 0.5, "a cut needs fields = true in [output]", ha="center", va="center")
        axis.set_axis_off()
        return
    touching = result.repulsive(step)[k : k + small, m : m + small].sum(axis=0)
    line = slice(k, k + small), m + int(np.argmax(touching))
    x = np.arange(small) * result.grid.spacing[0]
    wall = heights[line] - heights[line].min()
    surface = wall - gap[line] + result.wall.zero_gap
    axis.fill_between(x, wall, wall.max() + 1, color="0.75", label="rigid wall")
    axis.plot(x, surface, "-", color=plot.SERIES[0], label="deformed surface, moved up by $a_0$")
    attracted = (gap[line] >= result.wall.zero_gap) & (gap[line] < result.wall.zero_gap + result.wall.range)
    axis.plot(x[attracted], surface[attracted], ".", color=plot.ATTRACTED_COLOUR, label="attracted")
    axis.set(xlabel="$a_0$", ylabel="height ($a_0$)", title="cut through it; heights magnified")
    key.legend(*axis.get_legend_handles_labels(), fontsize=7, loc="center left")


def draw_patch_cells(chosen: Sequence[tuple[Result, int]]) -> Drawn:
    """Fig. S-1: which cells are neighbours, and the perimeter cells of a patch."""
    result, step = chosen[0]
    inside = result.repulsive(step)
    width = min(40, inside.shape[0] // 2)
    edge = perimeter_map(inside)
    i, j = _window(edge, width)
    shown = inside.astype(int) + (inside & ~edge)
    part = shown[i : i + width, j : j + width]
    neighbours = np.array([[0, 1, 0], [1, 2, 1], [0, 1, 0]])
    figure, (left, right) = plot.new_axes(6.4, 3.4, 1, 2)
    for axis, cells in ((left, neighbours), (right, part)):
        axis.pcolormesh(
            cells.T, cmap=ListedColormap(["white", "0.65", "black"]), vmin=0, vmax=2, edgecolors="0.85", lw=0.3
        )
        axis.set_aspect("equal")
        axis.set_xticks([])
        axis.set_yticks([])
    left.set_title("neighbours of the black cell: grey")
    right.set_title("perimeter cells: grey")
    counts = int(inside.sum()), int(edge.sum())
    return figure, DataFrame([counts], columns=["cells of A_rep", "perimeter cells"])


def stored_profiles(data: SweepData) -> list[_Found]:
    """The point nearest to 1 % area of each system that has stored its gaps; the contact has an edge."""
    found = []
    for key in data.table.keys:
        result = Result.read(Folder(data.root).point(key))
        measured = [point for point in analyse_run(result).points if point.fields and point.numbers.perimeter > 0]
        if measured:
            nearest = min(measured, key=lambda point: abs(point.numbers.area_rep - _PROFILE_AREA))
            assert nearest.fields is not None
            found.append((result, nearest, nearest.fields.profile))
    return found


def _length(result: Result) -> float:
    """Adhesion length l_a = w/E*, in a0."""
    return round(float(result.attributes["work_of_adhesion"]), 12)


def _lambda_s(result: Result) -> float:
    """NaN where this kind of surface has none."""
    return float(getattr(result.config.surface, "lambda_s", None) or "nan")


def draw_gap_profiles(found: Sequence[_Found]) -> Drawn:
    """Ratio of the mean gap to Eq. (S-1) against the distance from the edge, at 1 % area; d_att in the table."""
    by_wall = {
        "hard wall": [each for each in found if each[0].wall.law is None],
        "wall with a law": [each for each in found if each[0].wall.law is not None],
    }
    groups = [(title, some) for title, some in by_wall.items() if some]
    figure = plot.new_figure(4.4 * len(groups), 3.6)
    for i, (title, some) in enumerate(groups):
        axis = figure.add_subplot(1, len(groups), i + 1)
        _panel(axis, some)
        axis.set_title(title)
        if i == 0:
            axis.set_ylabel("mean gap / Eq. (S-1)")
    return figure, DataFrame([_row(*each) for each in found])


def _panel(axis: Axes, found: Sequence[_Found]) -> None:
    waves = sorted({_lambda_s(result) for result, *_ in found})
    lines = dict(zip(waves, cycle(("-", "--", ":", "-.")), strict=False))
    for result, point, profile in found:
        diameter, line = point.numbers.diameter, lines[_lambda_s(result)]
        ratio = profile.gap / paper.gap_outside_contact(profile.distance, result.moments.rms_slope, diameter)
        axis.plot(profile.distance / diameter, ratio, line, color=adhesion_colour(_length(result)), linewidth=0.9)
    adhesion_labels(axis, [_length(result) for result, *_ in found], "-", ", each line a surface")
    for lambda_s, line in lines.items() if len(lines) > 1 else ():
        axis.plot([], [], line, color="0.3", label=rf"$\lambda_s/a_0 = {lambda_s:g}$")
    axis.axhline(1, color="0.5", linewidth=0.6, linestyle=":", zorder=0, label="equal")
    axis.set(xlim=(0, 0.6), ylim=(0, 2), xlabel=r"$x/d_{rep}$, from the edge")
    axis.legend(fontsize=7)


def _row(result: Result, point: MeasuredPoint, profile: GapProfile) -> dict[str, str | float]:
    numbers, fields, config = point.numbers, point.fields, result.config
    assert fields is not None
    least, largest = fields.gap_ratio
    cells = gap_ratio(profile, result.moments.rms_slope, numbers.diameter, from_perimeter_cells=True)
    rim = numbers.area_att * result.grid.area / numbers.perimeter if result.wall.range > 0 else float("nan")
    return {
        "lambda_s (a0)": _lambda_s(result),
        "wall": config.wall.law,
        "l_a (a0)": _length(result),
        "seed": getattr(config.surface, "seed", ""),
        "A_rep/A0": numbers.area_rep,
        "d_rep (a0)": numbers.diameter,
        "gap over S-1, least, from the edge": least,
        "largest, from the edge": largest,
        "gap over S-1, least, from perimeter cells": cells[0],
        "largest, from perimeter cells": cells[1],
        "d_att (a0)": fields.width,
        "A_att/P (a0)": rim,
        "d_att of S-2 (a0)": fields.expected_width,
    }
