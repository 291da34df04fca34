"""The paper's figures, one entry each: the points or stored fields that it needs, how it is drawn, and its caption."""

from collections.abc import Callable, Mapping, Sequence, Sized
from dataclasses import dataclass
from functools import partial
from itertools import cycle
from pathlib import Path
from string import ascii_uppercase
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.typing import LineStyleType
from numpy.typing import NDArray
from pandas import DataFrame

from continuum.measure.contact import ATTRACTED, REPULSIVE
from continuum.measure.outline import GapProfile, Mask, perimeter_map
from continuum.model.fourier import Real
from continuum.paper import relations
from continuum.paper.points import LENGTH, FigureError, SweepData, adhesion_colour, adhesion_key, chosen, figure_table
from continuum.show import plot
from continuum.store import output
from continuum.store.runs.result import MeasuredPoint, Result, gap_ratio
from continuum.store.sheet import Sheet
from continuum.store.sweeps.folder import Folder
from continuum.theory import paper

_MAP_AREA = 0.02
"""A_rep/A0 of the maps of Fig. 1."""
_PROFILE_AREA = 0.01
"""A_rep/A0 at which the profiles are taken."""
_ABREAST = 3
"""Number of maps in a row of Fig. 1."""
_FACES = 96
"""Faces along a side of a body in three dimensions, at most."""
_MARK = plot.DIFFERENT_COLOUR
_ARROW: Any = {"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0, "linewidth": 0.8, "mutation_scale": 7}
_Line = tuple[Real, Real, Mask, Mask]
"""Along a cut: x and height of the surface, where it is repelled and where attracted."""
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


def contact_areas(chosen: Sequence[tuple[Result, int]]) -> DataFrame:
    """Numbers of the maps of Fig. 1."""
    rows = [
        (_length(result), point.area_rep, point.area_att, point.load_rep, point.load, point.mean_gap)
        for result, point in ((result, result.points[step]) for result, step in chosen)
    ]
    return DataFrame(rows, columns=[LENGTH, "A_rep/A0", "A_att/A0", "N_rep/A0 (E*)", "N/A0 (E*)", "mean gap (a0)"])


def draw_contact_maps(chosen: Sequence[tuple[Result, int]]) -> Figure:
    """Fig. 1: the wall above the surface, maps at a fixed repulsive area with growing adhesion, a patch and a cut."""
    first, last = chosen[0], chosen[-1]
    n, spacing = first[0].grid.shape[0], first[0].grid.spacing[0]
    quarter, small = max(n // 4, 16), min(max(int(80 / spacing), 16), n // 2)
    whole = first[0].contact_map(first[1])
    i, j = _window(whole == REPULSIVE, quarter)
    kinds = last[0].contact_map(last[1])
    k, m = _window(kinds == REPULSIVE, small)
    rows = -(-(len(chosen) + 2) // _ABREAST)
    figure = plot.new_figure(plot.PAGE, 2.25 * (rows + 1) + 0.5)
    places = figure.add_gridspec(rows + 1, _ABREAST)
    view = figure.add_subplot(places[0], projection="3d")
    _draw_bodies(view, last)
    maps = [figure.add_subplot(places[divmod(at, _ABREAST)]) for at in range(1, len(chosen) + 2)]
    plot.contact_image(maps[0], whole, first[0].grid.lengths)
    _frame(maps[0], i, j, quarter, spacing)
    titles = ["wall, lifted, and surface", rf"$\ell_a/a_0 = {_length(first[0]):.3g}$, whole"]
    for axis, (result, step) in zip(maps[1:], chosen, strict=True):
        part = result.contact_map(step)[i : i + quarter, j : j + quarter]
        plot.contact_image(axis, part, (quarter * spacing, quarter * spacing))
        area = 100 * result.points[step].area_rep
        titles.append(rf"$\ell_a/a_0 = {_length(result):.3g}$, $A_\mathrm{{rep}} = {area:.2g}\,\%$")
    _frame(maps[-1], k - i, m - j, small, spacing)
    patch, cut = figure.add_subplot(places[rows, 0]), figure.add_subplot(places[rows, 1:])
    plot.contact_image(patch, kinds[k : k + small, m : m + small], (small * spacing, small * spacing))
    titles.append(f"the square of {ascii_uppercase[len(maps)]}")
    titles.append(f"cut along the line in {ascii_uppercase[len(maps) + 1]}, heights magnified")
    for axis in (*maps, patch):
        axis.set(xlabel="x ($a_0$)", ylabel="y ($a_0$)")
    key = _cut(cut, patch, last, (k, m, small))
    plot.letter_panels((view, *maps, patch, cut), titles)
    plot.legend_below(figure, [*plot.contact_key(), *key])
    return figure


def _draw_bodies(axis: Any, drawn: tuple[Result, int]) -> None:
    """The rigid wall, lifted, above the deformed surface with its contact, in three dimensions."""
    result, step = drawn
    gap, heights = result.gap(step), result.heights()
    axis.set_axis_off()
    if gap is None or heights is None:
        axis.text2D(0.5, 0.5, "needs fields = true in [output]", ha="center", va="center", transform=axis.transAxes)
        return
    every = max(1, -(-heights.shape[0] // _FACES))
    x, y = (np.broadcast_to(part, heights.shape)[::every, ::every] for part in result.grid.positions)
    wall, surface = (field[::every, ::every] for field in (heights, heights - gap + result.wall.zero_gap))
    shade = np.full((*wall.shape, 4), to_rgba(_MARK, 0.35))
    kinds = result.contact_map(step)
    for kind, colour in ((ATTRACTED, plot.ATTRACTED_COLOUR), (REPULSIVE, plot.REPULSIVE_COLOUR)):
        # A face has the colour of what lies anywhere within it: patches are smaller than faces.
        touched = np.maximum.reduceat(np.maximum.reduceat(kinds == kind, _starts(kinds, 0, every), 0),
                                      _starts(kinds, 1, every), 1)  # fmt: skip
        shade[touched] = to_rgba(colour)
    faces: Any = {"rstride": 1, "cstride": 1, "linewidth": 0, "antialiased": False}
    axis.plot_surface(x, y, surface, facecolors=shade, shade=False, **faces)
    lifted = wall + (surface.max() - wall.min()) + 0.8 * np.ptp(wall)
    axis.plot_surface(x, y, lifted, color="0.95", **faces)
    axis.view_init(elev=18, azim=-60)
    axis.set_box_aspect((1, 1, 0.8), zoom=1.35)


def _starts(kinds: NDArray[np.uint8], axis: int, every: int) -> NDArray[np.intp]:
    return np.arange(0, kinds.shape[axis], every)


def _frame(axis: Axes, i: int, j: int, width: int, spacing: float) -> None:
    """The square that the next map enlarges, as far as it lies in this one."""
    corner = i * spacing, j * spacing
    axis.add_patch(Rectangle(corner, width * spacing, width * spacing, fill=False, edgecolor=_MARK, linewidth=1.2))


def _cut(axis: Axes, patch: Axes, drawn: tuple[Result, int], window: tuple[int, int, int]) -> list[Artist]:
    """The rigid wall and the deformed surface along a line through the enlarged patch; returns what is to explain."""
    (result, step), (k, m, small) = drawn, window
    gap, heights = result.gap(step), result.heights()
    if gap is None or heights is None:
        axis.text(0.5, 0.5, "a cut needs fields = true in [output]", ha="center", va="center")
        axis.set_axis_off()
        return []
    zero, reach, spacing = result.wall.zero_gap, result.wall.range, result.grid.spacing[0]
    inside = result.repulsive(step)[k : k + small, m : m + small]
    attracted = (gap >= zero) & (gap < zero + reach)
    part = attracted[k : k + small, m : m + small]
    # The line with most contact, among those with a rim if there are any.
    shown = [inside[:, i].sum() * (small if _rims(inside[:, i], part[:, i]) else 1) for i in range(small)]
    row = int(np.argmax(shown))
    patch.axhline((row + 0.5) * spacing, color=_MARK, linewidth=0.8)
    wall = heights[k : k + small, m + row] - heights[k : k + small, m + row].min()
    x = np.arange(0.5, small) * spacing
    surface = wall - gap[k : k + small, m + row] + zero
    axis.fill_between(x, wall, wall.max() * 1.05, color="0.8", linewidth=0)
    axis.plot(x, surface, "-", color=_MARK, linewidth=1.0)
    for where, shade in ((inside[:, row], plot.REPULSIVE_COLOUR), (part[:, row], plot.ATTRACTED_COLOUR)):
        axis.plot(x, np.where(where, surface, np.nan), "-", color=shade, linewidth=2.2)
    axis.set(xlabel="x ($a_0$)", ylabel="height ($a_0$)", xlim=(0, small * spacing))
    if inside[:, row].any():
        _lengths(axis, (x, surface, inside[:, row], part[:, row]), result.moments.rms_slope)
    return [
        Patch(facecolor="0.8", label="rigid wall"),
        Line2D([], [], color=_MARK, linewidth=1.0, label="deformed surface, moved up by $a_0$"),
    ]


def _runs(inside: Mask) -> list[tuple[int, int]]:
    """First and last but one of each run of cells along a line."""
    ends = np.flatnonzero(np.diff(inside.astype(int), prepend=0, append=0))
    return [(int(start), int(stop)) for start, stop in ends.reshape(-1, 2)]


def _rims(repulsive: Mask, attracted: Mask) -> list[tuple[int, int]]:
    """The runs of attraction that end: on one side there is a patch, on the other nothing."""
    inner = [run for run in _runs(attracted) if run[0] > 0 and run[1] < attracted.size]
    return [run for run in inner if bool(repulsive[run[0] - 1]) != bool(repulsive[run[1]])]


def _lengths(axis: Axes, line: _Line, slope: float) -> None:
    """Arrows below the surface, at the lengths that the theory speaks of: a chord of A_rep, d_att, and h'_rms."""
    x, surface, repulsive, attracted = line
    step, low = x[1] - x[0], float(surface.min())
    tall = axis.get_ylim()[1] - low
    marks = [(_longest(_runs(repulsive)), r"a chord: $d_\mathrm{rep}$ is their mean")]
    marks += [(_longest(rims), r"$d_\mathrm{att}$") for rims in [_rims(repulsive, attracted)] if rims]
    for level, ((start, stop), text) in enumerate(marks):
        ends, y = (x[start] - step / 2, x[stop - 1] + step / 2), low - (0.08 + 0.24 * level) * tall
        axis.annotate("", (ends[0], y), (ends[1], y), arrowprops=_ARROW)
        for end, at in zip(ends, (start, stop - 1), strict=True):
            axis.plot([end, end], [y, surface[at]], ":", color="0.5", linewidth=0.6)
        middle = np.clip(np.mean(ends), 0.15 * x[-1], 0.85 * x[-1])
        axis.annotate(text, (float(middle), y), (0, -3), textcoords="offset points", ha="center", va="top")
    axis.set_ylim(low - 0.7 * tall, low + tall)
    # A line as steep as the surface is on average, in the scales of this panel, where no arrow is.
    bottom, run = low - 0.6 * tall, 0.08 * x[-1]
    left = 0.02 * x[-1] if sum(marks[-1][0]) > x.size else 0.75 * x[-1]
    axis.plot([left, left + run, left + run], [bottom, bottom + slope * run, bottom], "-", color="0.3", linewidth=0.8)
    axis.annotate(rf"$h'_\mathrm{{rms}} = {slope:.2g}$", (left + run, bottom), (4, 0), textcoords="offset points")


def _longest(runs: Sequence[tuple[int, int]]) -> tuple[int, int]:
    return max(runs, key=lambda run: run[1] - run[0])


def cell_counts(chosen: Sequence[tuple[Result, int]]) -> DataFrame:
    """Numbers of cells of the first map, and of its perimeter cells."""
    result, step = chosen[0]
    inside = result.repulsive(step)
    counts = int(inside.sum()), int(perimeter_map(inside).sum())
    return DataFrame([counts], columns=["cells of A_rep", "perimeter cells"])


def draw_patch_cells(chosen: Sequence[tuple[Result, int]]) -> Figure:
    """Fig. S-1: which cells are neighbours, and the perimeter cells of a patch."""
    result, step = chosen[0]
    inside = result.repulsive(step)
    width = min(40, inside.shape[0] // 2)
    edge = perimeter_map(inside)
    i, j = _window(edge, width)
    shown = inside.astype(int) + (inside & ~edge)
    part = shown[i : i + width, j : j + width]
    neighbours = np.array([[0, 1, 0], [1, 2, 1], [0, 1, 0]])
    figure, (left, right) = plot.new_axes(plot.COLUMN, 2.0, 1, 2)
    for axis, cells in ((left, neighbours), (right, part)):
        axis.pcolormesh(
            cells.T, cmap=ListedColormap(["white", "0.65", "black"]), vmin=0, vmax=2, edgecolors="0.85", lw=0.3
        )
        axis.set_aspect("equal")
        axis.set_xticks([])
        axis.set_yticks([])
    plot.letter_panels((left, right), ("grey: neighbours", "grey: perimeter"))
    return figure


def stored_profiles(data: SweepData) -> list[_Found]:
    """The point nearest to 1 % area of each system that has stored its gaps; the contact has an edge."""
    found = []
    for key in data.table.keys:
        result = Result.read(Folder(data.root).point(key))
        measured = [point for point in result.analyse().points if point.fields and point.numbers.perimeter > 0]
        if measured:
            nearest = min(measured, key=lambda point: abs(point.numbers.area_rep - _PROFILE_AREA))
            assert nearest.fields is not None
            found.append((result, nearest, nearest.fields.profile))
    return found


def _length(result: Result) -> float:
    """Adhesion length l_a = w/E*, in a0."""
    return round(float(result.attributes["work_of_adhesion"]), 12)


def _lambda_s(result: Result) -> float:
    """λ_s; NaN if this kind of surface has none."""
    return float(getattr(result.config.surface, "lambda_s", None) or "nan")


def gap_ratios(found: Sequence[_Found]) -> DataFrame:
    """Mean gap over Eq. (S-1), and d_att, of each contact."""
    rows = []
    for result, point, profile in found:
        numbers, fields, config = point.numbers, point.fields, result.config
        assert fields is not None
        least, largest = fields.gap_ratio
        cells = gap_ratio(profile, result.moments.rms_slope, numbers.diameter, from_perimeter_cells=True)
        rim = numbers.area_att * result.grid.area / numbers.perimeter if result.wall.range > 0 else float("nan")
        rows.append({
            "lambda_s (a0)": _lambda_s(result),
            "wall": config.wall.kind_name,
            LENGTH: _length(result),
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
        })  # fmt: skip
    return DataFrame(rows)


def draw_gap_profiles(found: Sequence[_Found]) -> Figure:
    """Ratio of the mean gap to Eq. (S-1) against the distance from the edge, at 1 % area."""
    by_wall = {
        "hard wall": [each for each in found if each[0].wall.law is None],
        "wall with a law": [each for each in found if each[0].wall.law is not None],
    }
    groups = [(title, some) for title, some in by_wall.items() if some]
    figure, axes = plot.new_axes(plot.PAGE if len(groups) > 1 else plot.COLUMN, 2.9, 1, len(groups), squeeze=False)
    waves = sorted({_lambda_s(result) for result, *_ in found})
    styles: tuple[LineStyleType, ...] = ("-", "--", ":", "-.")
    lines = dict(zip(waves, cycle(styles), strict=False))
    for axis, (_, some) in zip(axes[0], groups, strict=True):
        for result, point, profile in some:
            diameter, line = point.numbers.diameter, lines[_lambda_s(result)]
            ratio = profile.gap / paper.gap_outside_contact(profile.distance, result.moments.rms_slope, diameter)
            shade = adhesion_colour(_length(result))
            axis.plot(profile.distance / diameter, ratio, line, color=shade, linewidth=0.9)
        axis.axhline(1, color="0.5", linewidth=0.6, zorder=0)
        axis.set(xlim=(0, 0.6), ylim=(0, 2), xlabel=r"$x/d_\mathrm{rep}$, from the edge")
    axes[0, 0].set_ylabel("mean gap / Eq. (S-1)")
    plot.letter_panels(axes[0], [title for title, _ in groups])
    sizes = [
        Line2D([], [], linestyle=line, color="0.3", label=rf"$\lambda_s/a_0 = {lambda_s:g}$")
        for lambda_s, line in lines.items()
        if len(lines) > 1
    ]
    plot.legend_below(figure, adhesion_key([_length(result) for result, *_ in found], "-"), sizes)
    return figure


Select = Callable[[SweepData], Sized]


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure with the numbers that it shows."""

    figure: Figure
    sheet: Sheet
    caption: str

    def shown(self, stem: Path) -> list[str]:
        """The Markdown for the figure and its caption."""
        return [f"![{self.caption}]({stem.name}.png)\n", f"{self.caption}\n"]


@dataclass(frozen=True)
class PaperFigure:
    """Description of how a figure is made."""

    title: str
    """Title of the table of its numbers."""
    select: Select
    """Function that selects what it shows of a sweep."""
    needs: str
    """Message if the sweep has nothing to show."""
    table: Callable[[Any], DataFrame] | Mapping[str, Any]
    """The table of its numbers: a function, or columns for :func:`figure_table`."""
    draw: Callable[[Any], Figure]
    """Function that draws it, from its table alone, or if ``whole`` from all that it shows."""
    caption: str | Callable[[DataFrame], str]
    """Caption and alternative text; a function if it contains numbers."""
    whole: bool = False
    """True if it shows more than its table holds, such as maps."""
    fields: bool = False
    """True if it needs stored gaps."""
    general: bool = False
    """True if every sweep over loads has points for it."""

    @plot.styled
    def make(self, data: SweepData) -> Drawing:
        shown = self.select(data)
        if not len(shown):
            raise FigureError(f"{data.table.listing.name}: {self.needs}")
        numbers = self.numbers(shown)
        figure = self.draw(shown if self.whole else numbers)
        sheet = Sheet.of(self.title, list(numbers), numbers.itertuples(index=False, name=None))
        return Drawing(figure, sheet, self.said(numbers))

    def numbers(self, shown: Any) -> DataFrame:
        """The table of its numbers, of what it shows."""
        return self.table(shown) if callable(self.table) else figure_table(shown, self.table)

    def said(self, numbers: DataFrame) -> str:
        """Caption of the figure."""
        return self.caption if isinstance(self.caption, str) else self.caption(numbers)


def save_drawing(drawing: Drawing, stem: Path, *, page: bool = False) -> list[Path]:
    """Write ``stem.png``, ``stem.pdf`` and ``stem.csv``, perhaps of a page; returns PNG and CSV."""
    picture = plot.save_figure(drawing.figure, stem, page=page)
    return [picture, output.save(stem.with_name(f"{stem.name}.csv"), drawing.sheet.csv())]


def _where(query: str) -> Select:
    return lambda data: chosen(data.points, query)


def _along(key: str, query: str) -> Select:
    """The points of a query, in a sweep with an axis on which they have at least two values."""

    def found(data: SweepData) -> DataFrame:
        points = chosen(data.points, query)
        axis = f"sweep.{key}"
        return points if axis in points and points[axis].nunique() > 1 else points[:0]

    return found


def _of_laws(data: SweepData) -> DataFrame:
    """The adhesive points at which κ is taken, in a sweep over laws or whole walls."""
    points = chosen(data.points, "reference and length > 0")
    return points if {"sweep.wall.law", "sweep.wall"} & set(points) else points[:0]


_ANY = "the sweep has no point that this figure shows: too few systems are done, or it is another sweep"


def _inverse_kappa(title: str, column: str, key: str, label: str, *along: str) -> PaperFigure:
    """1/κ or 1/κ_rep against a key of [surface], and the keys that change along with it."""
    return PaperFigure(
        title,
        _along(f"surface.{key}", "reference"),
        f"this figure needs a sweep over surface.{key}, with points of enough contact at two values at least",
        partial(relations.inverse_kappas, key=key, column=column, along=along),
        partial(relations.draw_inverse_kappas, label=label),
        f"{title}; means over surfaces, bars their standard deviation.",
    )


FIGURES: dict[str, PaperFigure] = {
    "figure1": PaperFigure(
        "Fig. 1", near_target_area, "no system has a converged point to draw", contact_areas,
        draw_contact_maps,
        "Fig. 1: contact at a fixed repulsive area, adhesion growing.", whole=True, fields=True,
    ),
    "figure-s1": PaperFigure(
        "Fig. S-1", near_target_area, "no system has a converged point to draw", cell_counts,
        draw_patch_cells,
        lambda n: "Fig. S-1: cells and perimeter; of {} cells of this map {} are perimeter cells.".format(*n.iloc[0]),
        whole=True, fields=True,
    ),
    "gap-profile": PaperFigure(
        "gap profile", stored_profiles,
        "no system has a contact with its gaps: this figure needs fields = true in [output]", gap_ratios,
        draw_gap_profiles,
        "Mean gap outside the contact at 1 % area, over Eq. (S-1) with the measured d_rep, against x from the edge.",
        whole=True, fields=True,
    ),
    "figure2": PaperFigure(
        "Fig. 2", _where("lambda_s == 32 and hurst == 0.8 and slope == 0.1"), _ANY,
        {"N/(h' E* A0)": "load / rms_slope", "A_rep/A0": "area_rep",
         "way": lambda points: np.where(points.approach, "approach", "retraction")},
        relations.draw_area_against_load, relations.caption_of_area_against_load, general=True,
    ),
    "figure3": PaperFigure(
        "Fig. 3", _where("perimeter > 0 and valid"), _ANY,
        {"A_att w/range (E* A0)": "area_att * expected_pressure_att", "N_att (E* A0)": "load_att",
         "h' A_rep/2 (A0)": "rms_slope * area_rep / 2", "N_rep (E* A0)": "load_rep", "A_rep/A0": "area_rep",
         "P (4h'/h'')/(pi A0)": lambda points: points.perimeter * points.expected_diameter / np.pi / points.area},
        relations.draw_loads,
        "Fig. 3: attractive and repulsive load, and perimeter, against the areas that the paper says they follow.",
        general=True,
    ),
    "figure4": PaperFigure(
        "Fig. 4", _where("reference and length > 0 and area_att > 0"), _ANY, relations.kappas, relations.draw_kappas,
        "Fig. 4: means over surfaces, bars their standard deviation, of the first point with A_rep >= 10 λ_s² from "
        "1 %. Dashed: 1/κ_rep as measured; full: where a search has found the threshold; bands: standard deviations.",
        general=True,
    ),
    "figure-s2": PaperFigure(
        "Fig. S-2", _where("perimeter > 0 and valid and approach"), _ANY,
        {"chord (a0)": "chord", "P d/(pi A_rep)": "disc_ratio"}, relations.draw_perimeters,
        "Fig. S-2: perimeter, chord and area.", general=True,
    ),
    "figure-s3": PaperFigure(
        "Fig. S-3", lambda data: relations.largest_tension(data.points), _ANY,
        {"h_rms/delta_c": "ratio", "N_max/(N P_c)": "tension"}, relations.draw_tensions,
        lambda numbers: "Fig. S-3: largest tension on approach, at the points of each path; "
        f"{np.sum(numbers['N_max/(N P_c)'] > 0)} of {len(numbers)} pull, arrows on the axis never do.", general=True,
    ),
    "finite-size": _inverse_kappa(
        "κ at 1 % area against the period L = 2λ_L", "kappa", "lambda_L", r"$\lambda_L = L/2$ ($a_0$)", "grid.n",
    ),
    "continuum-limit": _inverse_kappa(
        "κ_rep at 1 % area against λ_s/a0", "kappa_rep", "lambda_s", r"$\lambda_s/a_0$", "grid.n", "surface.lambda_L",
    ),
    "lambda-L": _inverse_kappa(
        "κ at 1 % area against λ_L, one period", "kappa", "lambda_L", r"$\lambda_L$ ($a_0$)",
    ),
    "other-potentials": PaperFigure(
        "other potentials", _of_laws, "this figure needs a sweep over wall.law", relations.laws, relations.draw_laws,
        "Other laws of the wall beside the theory for the spline: means over surfaces, bars their standard deviation. "
        "A long range reaches more than the rim of the patches, all that Eq. (4) counts: 9-3 attracts twice as much as "
        "it says, and a spline as wide does, too.",
    ),
    "stiffness": PaperFigure(
        "stiffness", _where("approach and tangent_stiffness.notna()"),
        "this figure needs stored gaps of walls with a law (fields = true in [output]), from which k_N follows",
        {"A_rep/A0": "area_rep", "kappa_rep/kappa": "load / load_rep",
         "k_N h_rms/N_rep": "tangent_stiffness * (rms_height / load_rep)",
         "k_N h_rms/N_rep between points": "stiffness * (rms_height / load_rep)"},
        relations.draw_stiffnesses,
        "Normal stiffness over repulsive load against κ_rep/κ: of each equilibrium, by one linear solve with its "
        "Hessian; crosses: the slope between points, jumps included.",
    ),
    "pull-off": PaperFigure(
        "pull-off", lambda data: relations.whole_cycles(data.points),
        "this figure needs paths with a way back (retract = true) of which every point converged",
        relations.cycles, relations.draw_cycles,
        "Cycles of load, and pull-off against how far the contact was pressed; peak loads and work are in the table.",
        whole=True,
    ),
    "diameter": PaperFigure(
        "diameter", lambda data: relations.long_paths(data.points),
        "this figure needs paths of three areas at least, as those of figure3",
        {"A_rep/A0": "area_rep", "d_rep (a0)": "diameter", "4h'/h'' (a0)": "expected_diameter",
         "ratio": "diameter_ratio"},
        relations.draw_diameters,
        "Mean diameter of contact patches against the area.", general=True,
    ),
}  # fmt: skip
"""Every figure that can be made of one sweep, by its name in ``continuum plot``."""
