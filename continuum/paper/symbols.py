"""The paper's symbols: shape H, colour l_a, filled for h' < 0.2, larger for larger λ_s."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from pandas import DataFrame

from continuum.model.fourier import Real
from continuum.paper.points import ENOUGH

_MARKERS = {0.3: "^", 0.5: "s", 0.8: "o"}
_COLOURS = {0.0: "0.55", 0.0005: "black", 0.005: "#0072b2", 0.05: "#d55e00"}
"""The paper's black, blue and red, as colours that all kinds of sight tell apart."""
_OTHERS = ("#009e73", "#cc79a7", "#e69f00", "#56b4e9")


def adhesion_colour(length: float) -> str:
    """The colour of an adhesion length."""
    known = next((c for value, c in _COLOURS.items() if np.isclose(value, length, rtol=1e-6, atol=1e-12)), None)
    return known or _OTHERS[int(abs(np.log10(max(length, 1e-9)) * 7)) % len(_OTHERS)]


def adhesion_labels(axis: Axes, lengths: Any, line: str, text: str = "") -> None:
    """An entry of the legend for each adhesion length."""
    for length in sorted(set(lengths)):
        axis.plot([], [], line, color=adhesion_colour(length), label=rf"$\ell_a/a_0 = {length:g}${text}")


def draw_points(axis: Axes, points: DataFrame, x: Real, y: Real, errors: Real | None = None) -> None:
    """Points at x and y, in the paper's symbols; pale where there are too few asperities."""
    bars = np.zeros(len(points)) if errors is None else errors
    for point, at, value, bar in zip(points.itertuples(), x, y, bars, strict=True):
        shade = adhesion_colour(point.length)
        axis.errorbar(
            at, value, yerr=bar if bar > 0 else None,
            marker=_MARKERS.get(point.hurst, "D"), color=shade, linestyle="none", elinewidth=0.6,
            markerfacecolor=shade if point.slope < 0.2 else "none", markeredgewidth=0.8,
            markersize=1.5 + float(np.log2(point.lambda_s)),
            alpha=1.0 if point.valid else 0.25,
        )  # fmt: skip


def symbol_legend(axis: Axes, points: DataFrame, **options: Any) -> None:
    """What the symbols mean, as far as they occur."""
    for hurst in sorted(set(points.hurst)):
        axis.plot([], [], _MARKERS.get(hurst, "D"), color="0.3", label=f"$H = {hurst:g}$")
    adhesion_labels(axis, points.length, "o")
    for slope in sorted(set(points.slope)):
        fill = "0.3" if slope < 0.2 else "none"
        axis.plot([], [], "o", color="0.3", markerfacecolor=fill, label=rf"$h'_{{rms}} = {slope:g}$")
    for size in sorted(set(points.lambda_s)):
        axis.plot([], [], "o", color="0.3", markersize=1.5 + np.log2(size), label=rf"$\lambda_s/a_0 = {size:g}$")
    if not points.valid.all():
        axis.plot([], [], "o", color="0.3", alpha=0.25, label=rf"$A_{{rep}} < {ENOUGH:g}\lambda_s^2$")
    axis.legend(**{"fontsize": 6.5, "ncols": 2, **options})


def line_of_slope(axis: Axes, slope: float = 1.0, label: str = "", linestyle: str = "-") -> None:
    """The line y = slope x, over what is shown."""
    ends = np.array(axis.get_xlim())
    axis.plot(ends, slope * ends, linestyle, color="0.5", linewidth=0.9, zorder=0, label=label)
    axis.set_xlim(*ends)


def plain_ticks(axes: Axes, which: Literal["x", "y"] = "x") -> None:
    """1, 2, 5, 10, ... on an axis of about a decade, where powers of ten alone would be one label or none."""
    axis: Any = axes.xaxis if which == "x" else axes.yaxis
    low, high = axis.get_view_interval()
    ticks = [d * 10.0**e for e in range(-3, 5) for d in (1, 2, 5) if low <= d * 10.0**e <= high]
    axis.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    axis.set_ticks([], minor=True)
    axis.set_view_interval(low, high, ignore=True)
