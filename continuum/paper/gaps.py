"""The mean gap outside the contact beside Eqs. (S-1) and (S-2), from the gaps that a sweep has stored."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path

from matplotlib.axes import Axes

from continuum.measure.profile import GapProfile
from continuum.model.fourier import Real
from continuum.paper.figures import Drawing
from continuum.paper.points import FigureError, colour
from continuum.runs.analysis import MeasuredPoint, analyse, gap_ratio
from continuum.runs.collect import PointTable
from continuum.runs.config import RunConfig
from continuum.runs.folder import Folder
from continuum.runs.result import Result
from continuum.show import plot
from continuum.show.sheet import Sheet
from continuum.theory import paper

_TARGET = 0.01
"""A_rep/A0 at which the profiles are taken."""
_Found = tuple[Result, MeasuredPoint, GapProfile]
_HEADS = (
    "lambda_s (a0)", "wall", "l_a (a0)", "seed", "A_rep/A0", "d_rep (a0)",
    "gap over S-1, least, from the edge", "largest, from the edge",
    "gap over S-1, least, from perimeter cells", "largest, from perimeter cells",
    "d_att (a0)", "A_att/P (a0)", "d_att of S-2 (a0)",
)  # fmt: skip


def _profiles(table: PointTable, root: Path) -> list[_Found]:
    """The point nearest to 1 % area of each system that has stored its gaps."""
    folder, found = Folder(root), []
    for key in table.keys:
        result = Result.read(folder.point(key))
        measured = [point for point in analyse(result).points if point.fields and point.numbers.area_rep > 0]
        if measured:
            nearest = min(measured, key=lambda point: abs(point.numbers.area_rep - _TARGET))
            assert nearest.fields is not None
            found.append((result, nearest, nearest.fields.profile))
    if not found:
        msg = f"{root}: no system has a contact with its gaps: this figure needs fields = true in [output]"
        raise FigureError(msg)
    return found


def _ratio(result: Result, point: MeasuredPoint, profile: GapProfile) -> Real:
    expected: Real = paper.gap_outside_contact(profile.distance, result.moments.rms_slope, point.numbers.diameter)
    return profile.gap / expected


def _length(result: Result) -> float:
    """Adhesion length l_a = w/E*, in a0."""
    return round(float(result.attributes["work_of_adhesion"]), 12)


def _number(config: RunConfig, name: str) -> float:
    """A number of [surface]; NaN where this kind of surface has none."""
    return float(getattr(config.surface, name, None) or float("nan"))


@plot.styled
def gap_profiles(table: PointTable, root: Path) -> Drawing:
    """Ratio of the mean gap to Eq. (S-1) against the distance from the edge, at 1 % area; d_att in the table."""
    found = _profiles(table, root)
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
    text = "Mean gap outside the contact at 1 % area, over Eq. (S-1) with the measured d_rep, against x from the edge."
    return Drawing(figure, Sheet.of("gap profile", _HEADS, [_row(*each) for each in found]), text)


def _panel(axis: Axes, found: Sequence[_Found]) -> None:
    waves = sorted({_number(result.config, "lambda_s") for result, *_ in found})
    lines = dict(zip(waves, cycle(("-", "--", ":", "-.")), strict=False))
    lengths = sorted({_length(result) for result, *_ in found})
    for result, point, profile in found:
        shade = colour(_length(result))
        x, y = profile.distance / point.numbers.diameter, _ratio(result, point, profile)
        axis.plot(x, y, lines[_number(result.config, "lambda_s")], color=shade, linewidth=0.9)
    for length in lengths:
        axis.plot([], [], "-", color=colour(length), label=rf"$\ell_a/a_0 = {length:g}$, each line a surface")
    for lambda_s, line in lines.items() if len(lines) > 1 else ():
        axis.plot([], [], line, color="0.3", label=rf"$\lambda_s/a_0 = {lambda_s:g}$")
    axis.axhline(1, color="0.5", linewidth=0.6, linestyle=":", zorder=0, label="equal")
    axis.set(xlim=(0, 0.6), ylim=(0, 2), xlabel=r"$x/d_{rep}$, from the edge")
    axis.legend(fontsize=7)


def _row(result: Result, point: MeasuredPoint, profile: GapProfile) -> list[str | float]:
    numbers, fields, config = point.numbers, point.fields, result.config
    assert fields is not None
    cells = gap_ratio(profile, result.moments.rms_slope, numbers.diameter, from_perimeter_cells=True)
    rim = numbers.area_att * result.grid.area / numbers.perimeter if result.wall.range > 0 else float("nan")
    return [
        _number(config, "lambda_s"), config.wall.law, _length(result), getattr(config.surface, "seed", ""),
        numbers.area_rep, numbers.diameter, *fields.gap_ratio, *cells, fields.width, rim, fields.expected_width,
    ]  # fmt: skip
