"""The mean gap outside the contact beside Eqs. (S-1) and (S-2), from the gaps that a sweep has stored."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

from matplotlib.axes import Axes
from pandas import DataFrame

from continuum.measure.profile import GapProfile
from continuum.paper.points import SweepData
from continuum.paper.relations import Drawn
from continuum.paper.symbols import adhesion_colour, adhesion_labels
from continuum.runs.analysis import MeasuredPoint, analyse_run, gap_ratio
from continuum.runs.result import Result
from continuum.show import plot
from continuum.sweeps.folder import Folder
from continuum.theory import paper

_TARGET = 0.01
"""A_rep/A0 at which the profiles are taken."""
_Found = tuple[Result, MeasuredPoint, GapProfile]


def stored_profiles(data: SweepData) -> list[_Found]:
    """The point nearest to 1 % area of each system that has stored its gaps."""
    found = []
    for key in data.table.keys:
        result = Result.read(Folder(data.root).point(key))
        measured = [point for point in analyse_run(result).points if point.fields and point.numbers.area_rep > 0]
        if measured:
            nearest = min(measured, key=lambda point: abs(point.numbers.area_rep - _TARGET))
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
