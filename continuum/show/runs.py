"""A run and what was measured on it, as sheets and figures; from its stored file only."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from continuum.measure.curve import CurvePoint
from continuum.measure.outline import patches, size_distribution
from continuum.runs.analysis import Analysis, MeasuredPoint
from continuum.runs.record import PathEvent, Point
from continuum.runs.result import Result
from continuum.show.plot import (
    ATTRACTED_COLOUR,
    COLUMN,
    PAGE,
    REPULSIVE_COLOUR,
    SERIES,
    broken,
    contact_image,
    new_figure,
    save_figure,
    styled,
)
from continuum.show.sheet import Column, Sheet, pairs
from continuum.theory import paper


class PathPoint(CurvePoint, Protocol):
    """What the figure of a path asks of its points."""

    @property
    def area_rep(self) -> float:
        """A_rep/A0."""

    @property
    def converged(self) -> bool:
        """Whether it is an equilibrium."""


def words(status: str) -> str:
    """The name of a status as people say it."""
    return status.lower().replace("_", " ")


def progress_line(point: Point, seconds: float) -> str:
    """What is said of a point when it is done."""
    place = f"mean gap {point.mean_gap:.4g} a0, separation {point.separation:.4g} a0, A_rep {point.area_rep:.4g}"
    search = f" and {point.search_pairs:.0f} in the search" if point.search_pairs else ""
    work = f"residual {point.residual:.1e}, FFT pairs {point.fft_pairs:.0f}{search}, {seconds:.1f} s"
    return f"{place}, N {point.load:.4g} E*, {work}, {words(point.status)}"


# --- sheets --------------------------------------------------------------------------------------------------


def run_sheets(result: Result) -> list[Sheet]:
    """The points of a run, and its jumps if it has any."""
    columns = (
        Column("step"), Column("branch"), Column("mean gap", "a0", ".5g"), Column("separation", "a0", ".5g"),
        Column("A_rep/A0"), Column("A_att/A0"), Column("N/A0", "E*", ".4e"), Column("N_rep/A0", "E*", ".4e"),
        Column("residual", "E*", ".1e"), Column("FFT pairs", "", ".0f"), Column("search", "", ".0f"), Column("status"),
    )  # fmt: skip
    rows = [
        (i, p.branch, p.mean_gap, p.separation, p.area_rep, p.area_att, p.load, p.load_rep, p.residual, p.fft_pairs,
         p.search_pairs, words(p.status))
        for i, p in enumerate(result.points)
    ]  # fmt: skip
    note = f"{result.resumed} points were stored before" if result.resumed else ""
    sheets = [Sheet.of("Points of the path", columns, rows, note)]
    return [*sheets, _jumps(result.events)] if result.events else sheets


def _jumps(events: Sequence[PathEvent]) -> Sheet:
    columns = (
        Column("before step"), Column("jump"), Column("of"), Column("from", "", ".6g"), Column("to", "", ".6g"),
        Column("mean gap", "a0", ".5g"), Column("after", "a0", ".5g"), Column("A_rep/A0", "", ".5g"),
        Column("after", "", ".5g"), Column("N/A0", "E*", ".4e"), Column("after", "E*", ".4e"),
    )  # fmt: skip
    rows = [
        (step, e.kind, e.control, e.before.value, e.after.value, e.before.mean_gap, e.after.mean_gap,
         e.before.area_rep, e.after.area_rep, e.before.load, e.after.load)
        for step, e in events
    ]  # fmt: skip
    return Sheet.of("Jumps, with both sides of each", columns, rows)


def analysis_sheets(analysis: Analysis) -> list[Sheet]:
    """What was measured on a run: each point, and the run as a whole."""
    sheets = [_loads(analysis), _geometry(analysis)]
    if any(point.fields for point in analysis.points):
        sheets.append(_outside(analysis))
    return [*sheets, _whole(analysis)]


_POINT = (Column("step"), Column("branch"), Column("mean gap", "a0"))


def _head(measured: MeasuredPoint) -> tuple[int, str, float]:
    return measured.step, measured.point.branch, measured.point.mean_gap


def _loads(analysis: Analysis) -> Sheet:
    columns = (
        *_POINT, Column("A_rep/A0"), Column("A_att/A0"), *(Column(n, "E*", ".3e") for n in ("N/A0", "p_rep", "p_att")),
        Column("1/κ"), Column("κ_rep"), Column("κ_att"), Column("k_N", "E*/a0", ".3e"),
    )  # fmt: skip
    rows = []
    for measured in analysis.points:
        n = measured.numbers
        inverse = 1 / n.kappa if n.kappa else np.nan
        rows.append(
            (*_head(measured), n.area_rep, n.area_att, n.load, n.pressure_rep, n.pressure_att, inverse, n.kappa_rep,
             n.kappa_att, measured.stiffness)
        )  # fmt: skip
    return Sheet.of("Loads", columns, rows)


def _geometry(analysis: Analysis) -> Sheet:
    names = ("P", "d_rep", "d_rep with 1.1107", "chord", "along x", "along y")
    columns = (*_POINT, Column("N_P"), *(Column(n, "a0") for n in names), Column("patches"), Column("largest", "a0²"))
    rows = []
    for measured in analysis.points:
        n, size = measured.numbers, measured.patch_areas
        lengths = (n.perimeter, n.diameter, n.diameter_exact, n.chord, *n.outline.chords)
        rows.append((*_head(measured), n.perimeter_cells, *lengths, size.size, float(size.max(initial=0.0))))
    return Sheet.of("Repulsive contact: P and d_rep with the paper's factor 1.1222", columns, rows)


def _outside(analysis: Analysis) -> Sheet:
    columns = (
        *_POINT, Column("d_att", "a0"), Column("A_att/P", "a0"), Column("Eq. (S-2)", "a0"), Column("gap/Eq. (S-1)"),
        Column("to"), *(Column(n) for n in ("A_rep/A0", "±", "corrected", "contour", "interior", "dilated")),
    )  # fmt: skip
    rows = []
    for measured in analysis.points:
        n, found = measured.numbers, measured.fields
        if found is None:
            continue
        rim = n.area_att * analysis.result.grid.area / n.perimeter if n.perimeter else np.nan
        a = found.areas
        shares = (a.repulsive, a.uncertainty, a.corrected, a.contour, a.interior, a.dilated)
        rows.append((*_head(measured), found.width, rim, found.expected_width, *found.gap_ratio, *shares))
    return Sheet.of("Gap outside the contact; areas by other definitions, as fractions of A0", columns, rows)


def _whole(analysis: Analysis) -> Sheet:
    expected, found = analysis.expected, analysis.adhesion
    rows: list[tuple[str, str]] = [
        ("rms slope h'rms", f"{expected.rms_slope:.4g}"),
        ("rms curvature h''rms", f"{expected.rms_curvature:.4g} 1/a0"),
        ("d_rep, theory 4h'/h''", f"{expected.diameter:.4g} a0"),
        ("d_att, theory Eq. (S-2)", f"{expected.width:.4g} a0"),
        ("A_rep/A_att, theory Eq. (4)", f"{expected.area_ratio:.4g}"),
        ("p_att, theory w/Δr", f"{expected.pressure_att:.4g} E*"),
    ]
    if found is not None:
        ends = "" if found.separated or np.isnan(found.pull_off) else " (path ends under tension: too small)"
        # The trapezoidal rule leaves a rest of either sign.
        lost = f"{found.loss:.4g} E* a0" if found.loss > 1e-6 * found.work_of_separation else "none"
        rows += [
            ("peak load N/A0", f"{found.peak_load:.4g} E*"),
            ("largest tension on approach", f"{found.largest_tension:.4g} E*"),
            ("pull-off tension on retraction", f"{found.pull_off:.4g} E*"),
            ("work of separation per A0", f"{found.work_of_separation:.4g} E* a0{ends}"),
            ("work lost in the cycle per A0", lost),
        ]
    return pairs("Theory and adhesion", rows)


# --- figures of a run ----------------------------------------------------------------------------------------


def draw_run(result: Result, folder: Path | None = None) -> list[Path]:
    """Draw every figure of a stored run, beside it or into a folder; returns the PNG files."""
    stem = (folder or result.path.parent) / result.path.stem
    figures = {"contact": run_contact_maps(result), "area-and-load": area_and_load(result)}
    return [save_figure(figure, stem.with_name(f"{stem.name}-{name}")) for name, figure in figures.items()]


def _explain(figure: Figure) -> None:
    """The colours of contact maps, below."""
    figure.legend(
        handles=[
            Patch(facecolor=REPULSIVE_COLOUR, label="repulsive"),
            Patch(facecolor=ATTRACTED_COLOUR, label="attracted"),
        ],
        loc="outside lower center",
        ncols=2,
    )


@styled
def run_contact_maps(result: Result, most: int = 3) -> Figure:
    """Contact maps of up to ``most`` points of the approach, spread evenly over those in contact."""
    points = result.points
    touching = [i for i, point in enumerate(points) if point.area_rep > 0 and point.branch != "retract"]
    touching = touching or list(range(len(points)))
    chosen = np.unique(np.array(touching)[np.linspace(0, len(touching) - 1, most).round().astype(int)])
    figure = new_figure(2.5 * len(chosen) + 0.3, 3.2)
    axes = figure.subplots(1, len(chosen), squeeze=False, sharey=True)[0]
    for axis, step in zip(axes, chosen.tolist(), strict=True):
        contact_image(axis, result.contact_map(step), result.grid.lengths)
        point = points[step]
        axis.set_title(f"$A_{{rep}}/A_0$ = {point.area_rep:.3g}\n$N/(E^* A_0)$ = {point.load:.3g}")
        axis.set_xlabel("x ($a_0$)")
    axes[0].set_ylabel("y ($a_0$)")
    _explain(figure)
    return figure


@styled
def map_figure(kinds: NDArray[np.uint8], period: tuple[float, float], area: float, load: float) -> Figure:
    """One contact map, with its area and load."""
    figure = new_figure(COLUMN, 3.6)
    axis = figure.subplots()
    contact_image(axis, kinds, period)
    axis.set_title(f"$A_{{rep}}/A_0$ = {area:.3g}, $N/(E^* A_0)$ = {load:.3g}")
    axis.set_xlabel("x ($a_0$)")
    axis.set_ylabel("y ($a_0$)")
    _explain(figure)
    return figure


def area_and_load(result: Result) -> Figure:
    """Area and load along a stored path."""
    return curve_figure(result.points, result.moments.rms_slope)


@styled
def curve_figure(points: Sequence[PathPoint], slope: float) -> Figure:
    """Repulsive area against load (the paper's Fig. 2), and both against the mean gap; failed points crossed."""
    area, load, gap = np.array([(p.area_rep, p.load, p.mean_gap) for p in points]).T
    retract = np.array([point.branch == "retract" for point in points])
    failed = np.array([not point.converged for point in points])
    figure = new_figure(PAGE, 2.6)
    axes = figure.subplots(1, 3)
    panels = (
        (load / slope, area, r"load $N/(h'_{rms} E^* A_0)$", r"repulsive area $A_{rep}/A_0$"),
        (gap, area, r"mean gap ($a_0$)", r"repulsive area $A_{rep}/A_0$"),
        (gap, load, r"mean gap ($a_0$)", r"load $N/(E^* A_0)$"),
    )
    for axis, (x, y, xlabel, ylabel) in zip(axes, panels, strict=True):
        for mine, style, colour, label in (
            (~retract, "o-", SERIES[0], "approach"),
            (retract, "s--", SERIES[5], "retraction"),
        ):
            if mine.any():
                axis.plot(*broken(x[mine], y[mine]), style, color=colour, markerfacecolor="none", label=label)
        if failed.any():
            axis.plot(x[failed], y[failed], "kx", markersize=8, label="not converged")
        axis.set_xlabel(xlabel)
        axis.set_ylabel(ylabel)
    axes[2].axhline(0, color="0.7", linewidth=0.6, zorder=0)
    axes[0].axvline(0, color="0.7", linewidth=0.6, zorder=0)
    axes[0].legend()
    return figure


# --- what was measured on a run -------------------------------------------------------------------------------


def draw_analysis(analysis: Analysis, folder: Path | None = None) -> list[Path]:
    """Draw what was measured on a run, beside its file or into a folder; returns the PNG files."""
    stem = (folder or analysis.result.path.parent) / analysis.result.path.stem
    touching = [point for point in analysis.points if point.numbers.area_rep > 0]
    # Points of the approach; on the way back they would hide one another.
    touching = [point for point in touching if point.point.branch != "retract"] or touching
    if not touching:
        return []
    chosen = [touching[i] for i in np.unique(np.linspace(0, len(touching) - 1, 4).round().astype(int))]
    figures = {"patches": _patch_maps(analysis, chosen[:3]), "sizes": _sizes(chosen)}
    if any(point.fields for point in chosen):
        figures["gap-profile"] = run_gap_profiles(analysis, chosen)
        figures["distributions"] = _distributions(chosen)
    return [save_figure(figure, stem.with_name(f"{stem.name}-{name}")) for name, figure in figures.items()]


def _label(point: MeasuredPoint) -> str:
    return rf"$A_{{rep}}/A_0$ = {point.numbers.area_rep:.3g}"


@styled
def _patch_maps(analysis: Analysis, points: list[MeasuredPoint]) -> Figure:
    """Connected patches, the largest in colours of their own, the others grey."""
    figure = new_figure(2.6 * len(points) + 0.3, 3.0)
    axes = figure.subplots(1, len(points), squeeze=False, sharey=True)[0]
    grid = analysis.result.grid
    for axis, point in zip(axes, points, strict=True):
        found = patches(grid, analysis.result.repulsive(point.step))
        rank = np.full(found.cells.size + 1, len(SERIES) + 1)
        rank[1 + np.argsort(-found.cells, kind="stable")[: len(SERIES)]] = np.arange(
            1, min(len(SERIES), rank.size - 1) + 1
        )
        rank[0] = 0
        axis.imshow(
            rank[found.labels].T,
            cmap=ListedColormap(["white", *SERIES, "0.5"]),
            vmin=0,
            vmax=len(SERIES) + 1,
            origin="lower",
            interpolation="nearest",
            extent=(0, grid.lengths[0], 0, grid.lengths[1]),
        )
        axis.spines[:].set_visible(True)
        axis.set_title(f"{_label(point)}\n{found.cells.size} patches")
        axis.set_xlabel("x ($a_0$)")
    axes[0].set_ylabel("y ($a_0$)")
    return figure


@styled
def _sizes(points: list[MeasuredPoint]) -> Figure:
    """Number of patches against their area."""
    figure = new_figure(COLUMN, 2.6)
    axis = figure.subplots()
    for point, colour in zip(points, SERIES, strict=False):
        size, density = size_distribution(point.patch_areas)
        axis.loglog(size, density, "o-", color=colour, markerfacecolor="none", label=_label(point))
    axis.set_xlabel(r"area of a patch $a$ ($a_0^2$)")
    axis.set_ylabel(r"patches per area $n(a)$ ($1/a_0^2$)")
    axis.legend()
    return figure


@styled
def run_gap_profiles(analysis: Analysis, points: list[MeasuredPoint]) -> Figure:
    """Mean gap against the distance from the edge, and its ratio to Eq. (S-1) with the measured mean diameter."""
    figure = new_figure(PAGE, 2.8)
    left, right = figure.subplots(1, 2)
    slope = analysis.expected.rms_slope
    for point, colour in zip(points, SERIES, strict=False):
        if point.fields is None or point.fields.profile.cells.size == 0:
            continue
        profile, diameter = point.fields.profile, point.numbers.diameter
        x = profile.distance
        left.loglog(x, profile.gap, "o", color=colour, markerfacecolor="none", markersize=3, label=_label(point))
        left.loglog(x, paper.gap_outside_contact(x, slope, diameter), "-", color=colour, linewidth=0.8)
        for distance, style in ((x, "-"), (profile.from_perimeter_cells, ":")):
            right.plot(
                distance / diameter,
                profile.gap / paper.gap_outside_contact(distance, slope, diameter),
                style,
                color=colour,
            )
    if analysis.expected.range > 0:
        left.axhline(analysis.expected.range, color="0.6", linewidth=0.6)
        left.annotate(r"$\Delta r$", (0.02, analysis.expected.range), xycoords=("axes fraction", "data"), va="bottom")
    right.axhspan(0.8, 1.3, color="0.92", zorder=0)
    right.set_xlim(0, 1)
    right.set_ylim(0, 2)
    left.set_xlabel(r"distance from the edge $x$ ($a_0$)")
    left.set_ylabel(r"mean gap above that of the edge ($a_0$)")
    right.set_xlabel(r"$x/d_{rep}$ (dotted: from the perimeter cells)")
    right.set_ylabel("ratio to Eq. (S-1)")
    left.legend()
    return figure


@styled
def _distributions(points: list[MeasuredPoint]) -> Figure:
    """Distributions of gap and pressure over the area."""
    figure = new_figure(PAGE, 2.8)
    left, right = figure.subplots(1, 2)
    for point, colour in zip(points, SERIES, strict=False):
        if point.fields is None:
            continue
        left.stairs(point.fields.gaps.density, point.fields.gaps.edges, color=colour, label=_label(point))
        if point.fields.pressures is not None:
            right.stairs(point.fields.pressures.density, point.fields.pressures.edges, color=colour)
    right.set_yscale("log")
    left.set_xlabel("gap $g$ ($a_0$)")
    left.set_ylabel("$P(g)$ ($1/a_0$)")
    right.set_xlabel("pressure $p$ ($E^*$)")
    right.set_ylabel("$P(p)$ ($1/E^*$)")
    right.axvline(0, color="0.7", linewidth=0.6, zorder=0)
    left.legend()
    return figure
