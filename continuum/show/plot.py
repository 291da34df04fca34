"""Figures of a run, from its stored file only; and the style that all figures of the project share."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from continuum.files import store
from continuum.measure.outline import patches, size_distribution
from continuum.runs.config import RunConfig
from continuum.theory import paper as theory

if TYPE_CHECKING:
    from continuum.runs.analysis import Analysis, Point

__all__ = [
    "ATTRACTED_COLOUR",
    "DIFFERENT_COLOUR",
    "REPULSIVE_COLOUR",
    "SERIES",
    "area_and_load",
    "contact_image",
    "contact_maps",
    "draw_all",
    "draw_analysis",
    "gap_profiles",
    "new_figure",
    "save",
    "styled",
]

REPULSIVE_COLOUR, ATTRACTED_COLOUR = "#f08000", "black"
"""The paper's Fig. 1: orange repels, black attracts.  They also differ in lightness."""
DIFFERENT_COLOUR = "#0072b2"
SERIES = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00")
"""Okabe and Ito's colours, told apart by all kinds of sight."""

_STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "lines.linewidth": 1.4,
    "lines.markersize": 5,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "savefig.dpi": 200,
}


styled = mpl.rc_context(_STYLE)
"""Decorator of functions that draw: the common style, and nothing global."""


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of the given size in inches, without a window."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


@styled
def save(figure: Figure, stem: Path) -> Path:
    """Write ``stem.png`` and ``stem.pdf``; returns the former."""
    stem.parent.mkdir(parents=True, exist_ok=True)
    # Without dates, so that the same result gives the same files.
    figure.savefig(stem.with_name(stem.name + ".pdf"), metadata={"CreationDate": None})
    figure.savefig(stem.with_name(stem.name + ".png"), metadata={"Software": None})
    return stem.with_name(stem.name + ".png")


def contact_image(axis: Axes, kinds: np.ndarray, period: tuple[float, float], alpha: float = 1.0) -> None:
    """Draw a contact map: 2 repulsive, 1 attracted, 0 out of range (shape (nx, ny); lengths in a0)."""
    colours = ListedColormap(["white", ATTRACTED_COLOUR, REPULSIVE_COLOUR])
    axis.imshow(
        kinds.T,
        cmap=colours,
        vmin=0,
        vmax=2,
        origin="lower",
        interpolation="nearest",
        extent=(0, period[0], 0, period[1]),
        alpha=alpha,
    )
    axis.spines[:].set_visible(True)


def draw_all(result: Path, folder: Path | None = None) -> list[Path]:
    """Draw every figure of a stored run, beside it or into a folder; returns the PNG files.

    Raises
    ------
    continuum.files.store.StoreError
        If the file is no run.
    """
    file = store.read(result, RunConfig.result_schema, RunConfig.result_version)
    stem = (folder or result.parent) / result.stem
    figures = {"contact": contact_maps(file), "area-and-load": area_and_load(file)}
    return [save(figure, stem.with_name(f"{stem.name}-{name}")) for name, figure in figures.items()]


def _period(file: store.File) -> tuple[float, float]:
    period = json.loads(str(file.attributes["config_resolved"]))["grid"]["period"]
    return float(period[0]), float(period[1])


@styled
def contact_maps(file: store.File, most: int = 3) -> Figure:
    """Contact maps of up to ``most`` points of the approach, spread evenly over those in contact."""
    area, branch = file["area_rep"], file["branch"]
    touching = np.flatnonzero((area > 0) & (branch != "retract"))
    if touching.size == 0:
        touching = np.arange(area.size)
    chosen = np.unique(touching[np.linspace(0, touching.size - 1, most).round().astype(int)])
    ny = file["y"].size
    figure = new_figure(2.5 * len(chosen) + 0.3, 3.2)
    axes = figure.subplots(1, len(chosen), squeeze=False, sharey=True)[0]
    for axis, step in zip(axes, chosen, strict=True):
        kinds = 2 * store.unpack(file["repulsive"][step], ny).astype(np.uint8)
        kinds += store.unpack(file["attracted"][step], ny)
        contact_image(axis, kinds, _period(file))
        axis.set_title(f"$A_{{rep}}/A_0$ = {area[step]:.3g}\n$N/(E^* A_0)$ = {file['load'][step]:.3g}", fontsize=8)
        axis.set_xlabel("x ($a_0$)")
    axes[0].set_ylabel("y ($a_0$)")
    figure.legend(
        handles=[
            Patch(facecolor=REPULSIVE_COLOUR, label="repulsive"),
            Patch(facecolor=ATTRACTED_COLOUR, label="attracted"),
        ],
        loc="outside lower center",
        ncols=2,
    )
    return figure


@styled
def area_and_load(file: store.File) -> Figure:
    """Repulsive area against load (the paper's Fig. 2), and both against the mean gap; failed points crossed."""
    slope = float(str(file.attributes["realised_rms_slope"]))
    area, load, gap = file["area_rep"], file["load"], file["mean_gap"]
    retract, failed = file["branch"] == "retract", file["status"] != "CONVERGED"
    figure = new_figure(8.4, 3.0)
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
                axis.plot(x[mine], y[mine], style, color=colour, markerfacecolor="none", label=label)
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
    stem = (folder or analysis.path.parent) / analysis.path.stem
    touching = [point for point in analysis.points if point.numbers.area_rep > 0]
    # Points of the approach; on the way back they would hide one another.
    touching = [point for point in touching if point.branch != "retract"] or touching
    if not touching:
        return []
    chosen = [touching[i] for i in np.unique(np.linspace(0, len(touching) - 1, 4).round().astype(int))]
    figures = {"patches": _patch_maps(analysis, chosen[:3]), "sizes": _sizes(chosen)}
    if any(point.fields for point in chosen):
        figures["gap-profile"] = gap_profiles(analysis, chosen)
        figures["distributions"] = _distributions(chosen)
    return [save(figure, stem.with_name(f"{stem.name}-{name}")) for name, figure in figures.items()]


def _label(point: Point) -> str:
    return rf"$A_{{rep}}/A_0$ = {point.numbers.area_rep:.3g}"


@styled
def _patch_maps(analysis: Analysis, points: list[Point]) -> Figure:
    """Connected patches, the largest in colours of their own, the others grey."""
    figure = new_figure(2.6 * len(points) + 0.3, 3.0)
    axes = figure.subplots(1, len(points), squeeze=False, sharey=True)[0]
    grid = analysis.grid
    for axis, point in zip(axes, points, strict=True):
        found = patches(grid, store.unpack(point.packed, grid.shape[1]))
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
        axis.set_title(f"{_label(point)}\n{found.cells.size} patches", fontsize=8)
        axis.set_xlabel("x ($a_0$)")
    axes[0].set_ylabel("y ($a_0$)")
    return figure


@styled
def _sizes(points: list[Point]) -> Figure:
    """Number of patches against their area."""
    figure = new_figure(4.2, 3.2)
    axis = figure.subplots()
    for point, colour in zip(points, SERIES, strict=False):
        size, density = size_distribution(point.patch_areas)
        axis.loglog(size, density, "o-", color=colour, markerfacecolor="none", label=_label(point))
    axis.set_xlabel(r"area of a patch $a$ ($a_0^2$)")
    axis.set_ylabel(r"patches per area $n(a)$ ($1/a_0^2$)")
    axis.legend()
    return figure


@styled
def gap_profiles(analysis: Analysis, points: list[Point]) -> Figure:
    """Mean gap against the distance from the edge, and its ratio to Eq. (gap) with the measured mean diameter."""
    figure = new_figure(7.6, 3.2)
    left, right = figure.subplots(1, 2)
    slope = analysis.prediction.rms_slope
    for point, colour in zip(points, SERIES, strict=False):
        if point.fields is None or point.fields.profile.cells.size == 0:
            continue
        profile, diameter = point.fields.profile, point.numbers.diameter
        x = profile.distance
        left.loglog(x, profile.gap, "o", color=colour, markerfacecolor="none", markersize=3, label=_label(point))
        left.loglog(x, theory.gap_profile(x, slope, diameter), "-", color=colour, linewidth=0.8)
        for distance, style in ((x, "-"), (profile.from_perimeter_cells, ":")):
            right.plot(
                distance / diameter, profile.gap / theory.gap_profile(distance, slope, diameter), style, color=colour
            )
    if analysis.prediction.range > 0:
        left.axhline(analysis.prediction.range, color="0.6", linewidth=0.6)
        left.annotate(r"$\Delta r$", (0.02, analysis.prediction.range), xycoords=("axes fraction", "data"), va="bottom")
    right.axhspan(0.8, 1.3, color="0.92", zorder=0)
    right.set_xlim(0, 1)
    right.set_ylim(0, 2)
    left.set_xlabel(r"distance from the edge $x$ ($a_0$)")
    left.set_ylabel(r"mean gap above that of the edge ($a_0$)")
    right.set_xlabel(r"$x/d_{rep}$ (dotted: from the perimeter cells)")
    right.set_ylabel("ratio to Eq. (gap)")
    left.legend()
    return figure


@styled
def _distributions(points: list[Point]) -> Figure:
    """Distributions of gap and pressure over the area."""
    figure = new_figure(7.6, 3.2)
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
