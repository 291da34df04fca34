"""The points of a sweep for the paper's figures: those with enough asperities, and their symbols.

The shape of a symbol tells H, its colour l_a; it is filled for h' < 0.2, and larger for larger λ_s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from pandas import DataFrame, Series

from continuum.inputs.errors import InputError
from continuum.measure.contact import Curve
from continuum.store.sweeps.collect import PointTable
from continuum.store.sweeps.measured import COLUMNS
from continuum.theory.paper import ExpectedContact

ENOUGH = 10.0
"""Smallest repulsive area, in units of λ_s², with a statistical number of asperities (the paper's Methods)."""
_SETTINGS = {
    "hurst": "surface.hurst", "slope": "surface.rms_slope", "lambda_s": "surface.lambda_s",
    "lambda_L": "surface.lambda_L", "seed": "surface.seed", "law": "wall.law",
    "shape": "wall.shape",
}  # fmt: skip
_STEEP, _SLOPES = 0.2, 4
"""Smallest slope of open symbols, and largest number of slopes in a legend."""
_HURST, _SLOPE, _CUT, _VALID = "H", "h'rms", "lambda_s (a0)", "A_rep >= 10 lambda_s^2"
LENGTH = "l_a (a0)"
"""Columns of the tables of figures; the others above are read here only."""
MARKERS = {0.3: "^", 0.5: "s", 0.8: "o"}
"""Symbols of H, as in the paper."""
_COLOURS = {0.0: "0.55", 0.0005: "black", 0.005: "#0072b2", 0.05: "#d55e00", 0.1: "#cc79a7"}
"""The paper's black, blue and red, as colours that remain distinct for colour-blind readers."""
_OTHERS = ("#e69f00", "#56b4e9", "#785ef0", "#882255", "#8c510a")
"""Colours of other lengths: neither the green of the border nor a colour of above."""


class FigureError(InputError, ValueError):
    """A figure or a page cannot be made from this sweep: it has no points for it, or too few."""


def sweep_points(table: PointTable) -> DataFrame:
    """Converged points of a sweep, one per row.

    Columns are those of :data:`continuum.store.sweeps.measured.COLUMNS`, lengths in a0, and

    * ``hurst``, ``slope`` (h' that was asked for), ``lambda_s``, ``lambda_L``, ``seed``, ``law``, ``shape``: the input;
    * ``sweep.KEY``: what the input has on an axis of the sweep, as text;
    * ``surface``: a number for each rough surface, whatever its wall;
    * ``search``: a number for each search of the sweep for the threshold, along whatever key; -1 for points of no
    search;
    * ``system``, ``length`` (l_a), ``area`` (A0 in a0²), ``approach`` (not on the way back);
    * ``valid``: the contact has enough asperities, A_rep >= 10 λ_s²;
    * ``reference``: κ is read here, the approaching point of each system of smallest valid area from about 1 % on;
    * ``expected_diameter``, ``expected_ratio``, ``expected_kappa_att``: d_rep = 4h'/h'', A_rep/A_att of Eq. (4), and
      κ_att of Eqs. (3) and (4) with the effective range of Eq. (S-5); ``expected_pressure_att``: w/Δr, or 0;
    * ``diameter_ratio``, ``disc_ratio``: d_rep over 4h'/h'', and P d/(π A_rep) with the mean chord d; 1 by the paper.
    """
    if table.values.size == 0:
        raise FigureError(f"{table.listing.name}: no system of this sweep is done")
    points = DataFrame(dict(zip(COLUMNS, table.values.T, strict=True)))
    for name, key in _SETTINGS.items():
        points[name] = table[key]
    for key in (key for axis in table.listing.axes for key in axis.keys):
        points[f"sweep.{key}"] = np.array([str(table.setting(system, key)) for system in table.keys])[table.system]
    points["system"] = table.system
    points["length"] = points.work_of_adhesion.round(12)
    points["area"] = np.array([table.grid(system).area for system in table.keys])[table.system]
    own = ["hurst", "slope", "lambda_s", "lambda_L", "seed", "area"]
    points["surface"] = points.groupby(own, dropna=False, sort=False).ngroup()
    seeks = table.listing.bisection
    of_threshold = seeks is not None and (seeks.column, seeks.crosses) == ("load", 0)
    points["search"] = alike(points, seeks.key) if seeks is not None and of_threshold else -1
    points["approach"] = points.retracting == 0
    points["valid"] = points.area_rep * points.area >= ENOUGH * points.lambda_s**2
    able = points.query("valid and approach and area_rep > 0.009")
    points["reference"] = points.index.isin(able.groupby("system").area_rep.idxmin())
    moments = points.rms_slope, points.rms_curvature
    near = [ExpectedContact(*one) for one in zip(*moments, points["range"], strict=True)]
    effective = zip(*moments, points.effective_range, points.work_of_adhesion, strict=True)
    points["expected_diameter"] = [one.diameter for one in near]
    points["expected_ratio"] = [one.area_ratio for one in near]
    points["expected_kappa_att"] = [ExpectedContact(*one).kappa_att for one in effective]
    points["expected_pressure_att"] = points.length / points["range"].where(points["range"] > 0, np.inf)
    points["diameter_ratio"] = points.diameter / points.expected_diameter
    points["disc_ratio"] = points.perimeter * points.chord / (np.pi * points.area_rep * points.area)
    return points


def chosen(points: DataFrame, condition: str) -> DataFrame:
    """The points that meet a condition: as `DataFrame.query`, which prepares all columns, of which it has a few."""
    return points[points[[name for name in points if name in condition]].eval(condition)]


def alike(points: DataFrame, *but: str) -> Series:
    """A number for each point, equal for systems that differ in these keys only, such as the seed."""
    keys = [name for name in points if name.startswith("sweep.") and name.removeprefix("sweep.") not in but]
    return points.groupby(keys, sort=False).ngroup() if keys else Series(0, points.index)


def over_surfaces(points: DataFrame, *names: str) -> DataFrame:
    """One row for all systems that differ in the seed only: the first, with mean and scatter of some columns."""
    found = points.groupby(alike(points, "surface.seed"), sort=False)
    rows = points.loc[[group.index[0] for _, group in found]].copy()
    for name in names:
        groups = [group[name].to_numpy() for _, group in found]
        rows[name] = [values.mean() for values in groups]
        rows[f"{name}_scatter"] = [values.std(ddof=1) if values.size > 1 else 0.0 for values in groups]
    return rows


def curve_of(path: DataFrame) -> Curve:
    """Load and separation along the path of one system."""
    mean_gap, separation, load = (path[name].to_numpy() for name in ("mean_gap", "separation", "load"))
    return Curve(mean_gap, separation, load, ~path.approach.to_numpy())


@dataclass(frozen=True, eq=False)
class SweepData:
    """Data for figures: the table of a sweep, its points, and its folder with the fields."""

    table: PointTable
    root: Path

    @cached_property
    def points(self) -> DataFrame:
        return sweep_points(self.table)


def adhesion_colour(length: float) -> str:
    """The colour of an adhesion length."""
    known = next((c for value, c in _COLOURS.items() if np.isclose(value, length, rtol=1e-6, atol=1e-12)), None)
    return known or _OTHERS[int(abs(np.log10(max(length, 1e-9)) * 11)) % len(_OTHERS)]


def figure_table(points: DataFrame, columns: Mapping[str, Any]) -> DataFrame:
    """The table of a figure, from which alone it is drawn: the meaning of its symbols, and its numbers.

    A column is a name or a formula in the columns of :func:`sweep_points`, or a function of the points.
    """

    def column(given: Any) -> Any:
        if callable(given):
            return given(points)
        return points.eval(given, engine="python") if isinstance(given, str) else given

    symbols = {
        _HURST: points.hurst, _SLOPE: points.slope, _CUT: points.lambda_s, LENGTH: points.length,
        "seed": points.seed, _VALID: points.valid,
    }  # fmt: skip
    return DataFrame(symbols).assign(**{name: column(given) for name, given in columns.items()})


def adhesion_key(lengths: Any, line: str = "o") -> list[Artist]:
    """An entry of the legend for each adhesion length."""
    look: Any = {"marker": line.strip("-"), "linestyle": "-" if "-" in line else "none"}
    return [
        Line2D([], [], **look, color=adhesion_colour(length), label=rf"$\ell_a/a_0 = {length:g}$")
        for length in sorted(set(lengths))
    ]


def draw_points(axis: Axes, numbers: DataFrame, x: str, y: str, error: str | None = None) -> None:
    """Draw two columns of a table in the paper's symbols, small over large; pale if there are too few asperities."""
    styles = [_VALID, _CUT, _HURST, _SLOPE, LENGTH]
    for (valid, cut, hurst, slope, length), some in sorted(
        numbers.groupby(styles, dropna=False), key=lambda found: (found[0][0], -found[0][1], found[0][4])
    ):
        shade = adhesion_colour(length)
        bars = None if error is None else some[error].where(some[error] > 0)
        axis.errorbar(
            some[x], some[y], yerr=bars, marker=MARKERS.get(hurst, "D"), color=shade, linestyle="none",
            elinewidth=0.5, markerfacecolor=shade if slope < _STEEP else "none", markeredgewidth=0.6,
            markersize=_size(cut), alpha=1.0 if valid else 0.25,
        )  # fmt: skip


def _size(cut: float) -> float:
    """Size of a symbol, in points."""
    return 0.8 + 0.75 * float(np.log2(cut))


def symbol_key(numbers: DataFrame) -> list[Sequence[Artist]]:
    """Legend of the symbols that occur, a list for each property."""
    grey: Any = {"color": "0.3", "linestyle": "none", "markeredgewidth": 0.6}
    hursts = [
        Line2D([], [], marker=MARKERS.get(hurst, "D"), label=f"$H = {hurst:g}$", **grey)
        for hurst in sorted(set(numbers[_HURST]))
    ]
    known = sorted(set(numbers[_SLOPE]))
    said = [(slope < _STEEP, f"= {slope:g}") for slope in known]
    if len(known) > _SLOPES:  # of a search, which the shape of a symbol does not tell apart
        said = [(True, f"< {_STEEP:g}"), (False, rf"\geq {_STEEP:g}")]
    slopes = [
        Line2D([], [], marker="o", markerfacecolor="0.3" if filled else "none",
               label=rf"$h'_\mathrm{{rms}} {what}$", **grey)
        for filled, what in said
    ]  # fmt: skip
    cuts = [
        Line2D([], [], marker="o", markersize=_size(cut), label=rf"$\lambda_s/a_0 = {cut:g}$", **grey)
        for cut in sorted(set(numbers[_CUT]))
    ]
    if not numbers[_VALID].all():
        few = rf"$A_\mathrm{{rep}} < {ENOUGH:g}\lambda_s^2$"
        slopes.append(Line2D([], [], marker="o", alpha=0.25, label=few, **grey))
    return [hursts, adhesion_key(numbers[LENGTH]), slopes, cuts]


def line_of_slope(axis: Axes, slope: float = 1.0, label: str = "", linestyle: str = "-") -> None:
    """The line y = slope x, over what is shown."""
    ends = np.array(axis.get_xlim())
    axis.plot(ends, slope * ends, linestyle, color="0.5", linewidth=0.9, zorder=0, label=label)
    axis.set_xlim(*ends)
