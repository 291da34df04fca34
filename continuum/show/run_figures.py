"""Runs and analyses as figures."""

from collections.abc import Sequence
from functools import singledispatch
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from continuum.inputs.arguments import file_name
from continuum.measure.outline import patches, size_distribution
from continuum.path.state import PathState
from continuum.show import plot
from continuum.store.runs.record import Point
from continuum.store.runs.result import Analysis, MeasuredPoint, Result
from continuum.theory import paper

_AREA = r"$A_\mathrm{rep}/A_0$"


@singledispatch
def draw(result: Any, folder: Path | None = None) -> list[Path]:
    """Draw every figure of a stored run or of an analysis, beside the run or into a folder; returns the PNG files.

    What draws itself, as a state or a path of a contact, is drawn into the present folder if none is given.
    """
    if callable(drawn := getattr(result, "plot", None)):
        return [plot.save_figure(drawn(), (folder or Path()) / type(result).__name__.lower())]
    return draw(Result.read(file_name("result", result)), folder)


@draw.register
def draw_run(result: Result, folder: Path | None = None) -> list[Path]:
    """Contact maps, and the curves of area and load."""
    stem = (folder or result.path.parent) / result.path.stem
    figures = {
        "contact": run_contact_maps(result),
        "area-and-load": curve_figure(result.points, result.moments.rms_slope),
    }
    return [plot.save_figure(figure, stem.with_name(f"{stem.name}-{name}")) for name, figure in figures.items()]


@plot.styled
def run_contact_maps(result: Result) -> Figure:
    """Contact maps of up to three points of the approach, evenly spaced among those in contact."""
    points = result.points
    touching = [i for i, point in enumerate(points) if point.area_rep > 0 and point.branch != "retract"]
    touching = touching or list(range(len(points)))
    chosen = np.unique(np.array(touching)[np.linspace(0, len(touching) - 1, 3).round().astype(int)])
    figure, axes = _maps(len(chosen), 0.9)
    titles = []
    for axis, step in zip(axes, chosen.tolist(), strict=True):
        plot.contact_image(axis, result.contact_map(step), result.grid.lengths)
        point = points[step]
        titles.append(f"{_AREA} = {point.area_rep:.3g}\n$N/(E^* A_0)$ = {point.load:.3g}")
    plot.letter_panels(axes, titles)
    plot.legend_below(figure, plot.contact_key())
    return figure


def _maps(number: int, beside: float) -> tuple[Figure, Any]:
    """Square maps in a row; ``beside``: height of titles, labels and legend, in inches, by which no text is cut."""
    width = plot.PAGE if number > 1 else plot.COLUMN
    figure, axes = plot.new_axes(width, width / number + beside, 1, number, squeeze=False, sharey=True)
    for axis in axes[0]:
        axis.set_xlabel("x ($a_0$)")
    axes[0, 0].set_ylabel("y ($a_0$)")
    return figure, axes[0]


@plot.styled
def map_figure(kinds: NDArray[np.uint8], period: tuple[float, float], area: float, load: float) -> Figure:
    """One contact map, with its area and load."""
    figure, axis = plot.new_axes(plot.COLUMN, 3.6)
    plot.contact_image(axis, kinds, period)
    axis.set(title=f"{_AREA} = {area:.3g}, $N/(E^* A_0)$ = {load:.3g}", xlabel="x ($a_0$)", ylabel="y ($a_0$)")
    plot.legend_below(figure, plot.contact_key())
    return figure


@plot.styled
def curve_figure(points: Sequence[Point | PathState], slope: float) -> Figure:
    """Repulsive area against load (the paper's Fig. 2), and both against the mean gap; failed points crossed."""
    area, load, gap = np.array([(p.area_rep, p.load, p.mean_gap) for p in points]).T
    retract = np.array([point.branch == "retract" for point in points])
    failed = np.array([not point.converged for point in points])
    figure, axes = plot.new_axes(plot.PAGE, 2.6, 1, 3)
    panels = (
        (load / slope, area, r"load $N/(h'_\mathrm{rms} E^* A_0)$", f"repulsive area {_AREA}"),
        (gap, area, r"mean gap ($a_0$)", f"repulsive area {_AREA}"),
        (gap, load, r"mean gap ($a_0$)", r"load $N/(E^* A_0)$"),
    )
    for axis, (x, y, xlabel, ylabel) in zip(axes, panels, strict=True):
        for mine, style, colour, label in (
            (~retract, "o-", plot.SERIES[0], "approach"),
            (retract, "s--", plot.SERIES[5], "retraction"),
        ):
            if mine.any():
                axis.plot(*plot.broken(x[mine], y[mine]), style, color=colour, markerfacecolor="none", label=label)
        if failed.any():
            axis.plot(x[failed], y[failed], "kx", markersize=6, label="not converged")
        axis.set(xlabel=xlabel, ylabel=ylabel)
        axis.locator_params(axis="x", nbins=4)
    axes[2].axhline(0, color="0.7", linewidth=0.6, zorder=0)
    axes[0].axvline(0, color="0.7", linewidth=0.6, zorder=0)
    plot.letter_panels(axes)
    plot.legend_below(figure, plot.labelled(*axes))
    return figure


@draw.register
def draw_analysis(analysis: Analysis, folder: Path | None = None) -> list[Path]:
    """Draw what was measured on a run, beside its file or into a folder; returns the PNG files."""
    stem = (folder or analysis.result.path.parent) / analysis.result.path.stem
    touching = [point for point in analysis.points if point.numbers.area_rep > 0]
    # Only the approach: points of the retraction would hide one another.
    touching = [point for point in touching if point.point.branch != "retract"] or touching
    if not touching:
        return []
    chosen = [touching[i] for i in np.unique(np.linspace(0, len(touching) - 1, 4).round().astype(int))]
    figures = {"patches": _patch_maps(analysis, chosen[:3]), "sizes": _sizes(chosen)}
    if any(point.fields for point in chosen):
        figures["gap-profile"] = run_gap_profiles(analysis, chosen)
        figures["distributions"] = _distributions(chosen)
    return [plot.save_figure(figure, stem.with_name(f"{stem.name}-{name}")) for name, figure in figures.items()]


def _label(point: MeasuredPoint) -> str:
    return f"{_AREA} = {point.numbers.area_rep:.3g}"


@plot.styled
def _patch_maps(analysis: Analysis, points: list[MeasuredPoint]) -> Figure:
    """Connected patches, the largest in colours of their own, the others grey."""
    figure, axes = _maps(len(points), 0.65)
    titles = []
    grid = analysis.result.grid
    for axis, point in zip(axes, points, strict=True):
        found = patches(grid, analysis.result.repulsive(point.step))
        rank = np.full(found.cells.size + 1, len(plot.SERIES) + 1)
        rank[1 + np.argsort(-found.cells, kind="stable")[: len(plot.SERIES)]] = np.arange(
            1, min(len(plot.SERIES), rank.size - 1) + 1
        )
        rank[0] = 0
        colours = ListedColormap(["white", *plot.SERIES, "0.5"])
        plot.map_image(
            axis, rank[found.labels], grid.lengths, colours, (0, len(plot.SERIES) + 1), interpolation="nearest"
        )
        titles.append(f"{_label(point)}\n{found.cells.size} patch{'es' * (found.cells.size != 1)}")
    plot.letter_panels(axes, titles)
    return figure


@plot.styled
def _sizes(points: list[MeasuredPoint]) -> Figure:
    figure, axis = plot.new_axes(plot.COLUMN, 2.6)
    for point, colour in zip(points, plot.SERIES, strict=False):
        size, density = size_distribution(point.patch_areas)
        axis.loglog(size, density, "o-", color=colour, markerfacecolor="none", label=_label(point))
    axis.set(xlabel=r"area of a patch $a$ ($a_0^2$)", ylabel=r"patches per area $n(a)$ ($1/a_0^2$)")
    plot.log_ticks(axis)
    plot.legend_below(figure, plot.labelled(axis))
    return figure


@plot.styled
def run_gap_profiles(analysis: Analysis, points: list[MeasuredPoint]) -> Figure:
    """Mean gap against the distance from the edge, and its ratio to Eq. (S-1) with the measured mean diameter."""
    figure, (left, right) = plot.new_axes(plot.PAGE, 2.8, 1, 2)
    slope = analysis.expected.rms_slope
    for point, colour in zip(points, plot.SERIES, strict=False):
        if point.fields is None or point.fields.profile.cells.size == 0:
            continue
        profile, diameter = point.fields.profile, point.numbers.diameter
        x = profile.distance
        left.loglog(x, profile.gap, "o", color=colour, markerfacecolor="none", markersize=3, label=_label(point))
        left.loglog(x, paper.gap_outside_contact(x, slope, diameter), "-", color=colour, linewidth=0.8)
        for distance, style in ((x, "-"), (profile.from_perimeter_cells, ":")):
            ratio = profile.gap / paper.gap_outside_contact(distance, slope, diameter)
            right.plot(distance / diameter, ratio, style, color=colour)
    if analysis.expected.range > 0:
        left.axhline(analysis.expected.range, color="0.6", linewidth=0.6, label=r"$\Delta r$")
    right.axhspan(0.8, 1.3, color="0.92", zorder=0, label="0.8 to 1.3")
    right.plot([], [], ":", color="0.3", label="from the perimeter cells")
    right.set(xlim=(0, 1), ylim=(0, 2))
    left.set(xlabel=r"distance from the edge $x$ ($a_0$)", ylabel=r"mean gap above the edge ($a_0$)")
    right.set(xlabel=r"$x/d_\mathrm{rep}$", ylabel="ratio to Eq. (S-1)")
    plot.log_ticks(left)
    plot.letter_panels((left, right), ["points; lines: Eq. (S-1)"])
    plot.legend_below(figure, plot.labelled(left, right))
    return figure


@plot.styled
def _distributions(points: list[MeasuredPoint]) -> Figure:
    figure, (left, right) = plot.new_axes(plot.PAGE, 2.8, 1, 2)
    for point, colour in zip(points, plot.SERIES, strict=False):
        if point.fields is None:
            continue
        left.stairs(point.fields.gaps.density, point.fields.gaps.edges, color=colour, label=_label(point))
        if point.fields.pressures is not None:
            right.stairs(point.fields.pressures.density, point.fields.pressures.edges, color=colour)
    right.set_yscale("log")
    left.set(xlabel="gap $g$ ($a_0$)", ylabel="$P(g)$ ($1/a_0$)")
    right.set(xlabel="pressure $p$ ($E^*$)", ylabel="$P(p)$ ($1/E^*$)")
    right.axvline(0, color="0.7", linewidth=0.6, zorder=0)
    plot.log_ticks(right)
    plot.letter_panels((left, right))
    plot.legend_below(figure, plot.labelled(left))
    return figure
