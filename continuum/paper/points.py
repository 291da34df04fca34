"""The points of a sweep as the paper's figures see them: its symbols, which points count, means over surfaces."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from continuum.errors import InputError
from continuum.model.fourier import Real
from continuum.runs.collect import PointTable
from continuum.theory import paper

Mask = NDArray[np.bool_]
ENOUGH = 10.0
"""Repulsive area in units of λ_s² from which on there is a statistical number of asperities (the paper's Methods)."""
MARKERS = {0.3: "^", 0.5: "s", 0.8: "o"}
COLOURS = {0.0: "0.55", 0.0005: "black", 0.005: "#0072b2", 0.05: "#d55e00"}
"""Of adhesion lengths: the paper's black, blue and red, as colours that all kinds of sight tell apart."""
_OTHERS = ("#009e73", "#cc79a7", "#e69f00", "#56b4e9")


class FigureError(InputError, ValueError):
    """A figure cannot be made of this sweep."""


@dataclass(frozen=True, eq=False)
class Points:
    """Converged points of a sweep, one array entry each."""

    table: PointTable

    def __getitem__(self, name: str) -> Real:
        """A column of the table, or a key of the input."""
        return self.table[name]

    @cached_property
    def length(self) -> Real:
        """Adhesion length l_a = w/E*, in a0."""
        return np.round(self["work_of_adhesion"], 12)

    @cached_property
    def lambda_s(self) -> Real:
        """Shortest wavelength, in a0."""
        return self["surface.lambda_s"].astype(float)

    @cached_property
    def area(self) -> Real:
        """A0, in a0²."""
        found: Real = np.array([self.table.grid(key).area for key in self.table.keys])[self.table.system]
        return found

    @cached_property
    def valid(self) -> Mask:
        """Whether the contact has enough asperities: A_rep >= 10 λ_s²."""
        found: Mask = self["area_rep"] * self.area >= ENOUGH * self.lambda_s**2
        return found

    @cached_property
    def reference(self) -> Mask:
        """Of each path, the approaching point of smallest valid area from about 1 % on: where κ is read."""
        chosen = np.zeros(self.valid.size, dtype=bool)
        able = self.valid & (self["area_rep"] > 0.009) & (self["retracting"] == 0)
        for rows in self.paths():
            rows = rows[able[rows]]
            if rows.size:
                chosen[rows[np.argmin(self["area_rep"][rows])]] = True
        return chosen

    @cached_property
    def diameter(self) -> Real:
        """d_rep = 4h'/h'' of the undeformed surface, in a0."""
        return np.array(
            [paper.contact_diameter(*pair) for pair in zip(self["rms_slope"], self["rms_curvature"], strict=True)]
        )

    @cached_property
    def area_ratio(self) -> Real:
        """A_rep/A_att of Eq. (4) with that diameter; infinite without adhesion."""
        return self._theory(lambda h, d, r, _: paper.area_ratio(h, d, r), "range")

    @cached_property
    def kappa_att(self) -> Real:
        """κ_att of Eqs. (3) and (4) with that diameter and the effective range of Eq. (S-5)."""
        return self._theory(lambda h, d, r, w: paper.kappa_att(h, r, w, paper.area_ratio(h, d, r)), "effective_range")

    def _theory(self, value: Callable[[float, float, float, float], float], of_range: str) -> Real:
        columns = zip(self["rms_slope"], self.diameter, self[of_range], self["work_of_adhesion"], strict=True)
        return np.array([value(h, d, r, w) if r > 0 else np.inf for h, d, r, w in columns])

    def paths(self) -> Iterator[NDArray[np.int64]]:
        """Rows of each system."""
        for index in range(len(self.table.keys)):
            rows = np.flatnonzero(self.table.system == index)
            if rows.size:
                yield rows

    def surface(self, row: int, *but: str) -> tuple[object, ...]:
        """All settings of a system but those named: the same for systems that differ in these only."""
        key = self.table.keys[int(self.table.system[row])]
        axes = [name for axis in self.table.listed.axes for name in axis.keys]
        return tuple(str(self.table.setting(key, name)) for name in axes if name not in but)

    def groups(self, rows: NDArray[np.int64], *but: str) -> Iterator[NDArray[np.int64]]:
        """The rows of systems that differ in the keys named only, such as realisations by their seed."""
        found: dict[tuple[object, ...], list[int]] = {}
        for row in rows.tolist():
            found.setdefault(self.surface(row, *but), []).append(row)
        yield from map(np.array, found.values())


def colour(length: float) -> str:
    """Of an adhesion length."""
    known = next((c for value, c in COLOURS.items() if np.isclose(value, length, rtol=1e-6, atol=1e-12)), None)
    return known or _OTHERS[int(abs(np.log10(max(length, 1e-9)) * 7)) % len(_OTHERS)]


def draw(axis: Axes, points: Points, x: Real, y: Real, rows: NDArray[np.int64], errors: Real | None = None) -> None:
    """Points by the paper's symbols: shape H, colour l_a, filled for h' < 0.2, larger for larger λ_s."""
    hurst, slope = points["surface.hurst"], points["surface.rms_slope"]
    for i, row in enumerate(rows.tolist()):
        shade = colour(float(points.length[row]))
        axis.errorbar(
            x[i], y[i], yerr=None if errors is None or not errors[i] > 0 else errors[i],
            marker=MARKERS.get(float(hurst[row]), "D"), color=shade, linestyle="none", elinewidth=0.6,
            markerfacecolor=shade if slope[row] < 0.2 else "none", markeredgewidth=0.8,
            markersize=1.5 + float(np.log2(points.lambda_s[row])),
            alpha=1.0 if points.valid[row] else 0.25,
        )  # fmt: skip


def legend(axis: Axes, points: Points, rows: NDArray[np.int64], **options: Any) -> None:
    """What the symbols mean, as far as they occur."""
    for hurst in sorted({float(h) for h in points["surface.hurst"][rows]}):
        axis.plot([], [], MARKERS.get(hurst, "D"), color="0.3", label=f"$H = {hurst:g}$")
    for length in sorted({float(value) for value in points.length[rows]}):
        axis.plot([], [], "o", color=colour(length), label=rf"$\ell_a/a_0 = {length:g}$")
    for slope in sorted({float(s) for s in points["surface.rms_slope"][rows]}):
        fill = "0.3" if slope < 0.2 else "none"
        axis.plot([], [], "o", color="0.3", markerfacecolor=fill, label=rf"$h'_{{rms}} = {slope:g}$")
    for size in sorted({float(s) for s in points.lambda_s[rows]}):
        axis.plot([], [], "o", color="0.3", markersize=1.5 + np.log2(size), label=rf"$\lambda_s/a_0 = {size:g}$")
    if not points.valid[rows].all():
        axis.plot([], [], "o", color="0.3", alpha=0.25, label=rf"$A_{{rep}} < {ENOUGH:g}\lambda_s^2$")
    settings: dict[str, Any] = {"fontsize": 6.5, "ncols": 2, **options}
    axis.legend(**settings)


def plain_ticks(axes: Axes, which: Literal["x", "y"] = "x") -> None:
    """1, 2, 5, 10, ... on an axis of about a decade, where powers of ten alone would be one label or none."""
    axis: Any = axes.xaxis if which == "x" else axes.yaxis
    low, high = axis.get_view_interval()
    ticks = [d * 10.0**e for e in range(-3, 5) for d in (1, 2, 5) if low <= d * 10.0**e <= high]
    axis.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    axis.set_ticks([], minor=True)
    axis.set_view_interval(low, high, ignore=True)
