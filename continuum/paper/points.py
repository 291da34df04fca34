"""The points of a sweep as the paper's figures show them: its symbols, and which points have enough asperities."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from pandas import DataFrame, Series

from continuum.errors import InputError
from continuum.measure.curve import Curve
from continuum.sweeps.collect import PointTable
from continuum.sweeps.measured import COLUMNS
from continuum.theory.paper import ExpectedContact

ENOUGH = 10.0
"""Repulsive area in units of λ_s² from which on there is a statistical number of asperities (the paper's Methods)."""
_SETTINGS = {
    "hurst": "surface.hurst", "slope": "surface.rms_slope", "lambda_s": "surface.lambda_s",
    "lambda_L": "surface.lambda_L", "seed": "surface.seed", "law": "wall.law",
}  # fmt: skip


class FigureError(InputError, ValueError):
    """A figure, or a page, cannot be made of this sweep: it has no, or too few, points for it."""


def sweep_points(table: PointTable) -> DataFrame:
    """Converged points of a sweep, one a row.

    Columns are those of :data:`continuum.sweeps.measured.COLUMNS`, lengths in a0, and

    * ``hurst``, ``slope`` (h' that was asked for), ``lambda_s``, ``lambda_L``, ``seed``, ``law``: the input;
    * ``sweep.KEY``: what the input has on an axis of the sweep, as text;
    * ``system``, ``length`` (l_a), ``area`` (A0 in a0²), ``approach`` (not on the way back);
    * ``valid``: the contact has enough asperities, A_rep >= 10 λ_s²;
    * ``reference``: κ is read here, the approaching point of each system of smallest valid area from about 1 % on;
    * ``expected_diameter``, ``expected_ratio``, ``expected_kappa_att``: d_rep = 4h'/h'', A_rep/A_att of Eq. (4), and
      κ_att of Eqs. (3) and (4) with the effective range of Eq. (S-5).
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
    return points


def alike(points: DataFrame, *but: str) -> Series:
    """A number for each point, the same where systems differ in these keys of the input only, such as the seed."""
    keys = [name for name in points if name.startswith("sweep.") and name.removeprefix("sweep.") not in but]
    return points.groupby(keys, sort=False).ngroup() if keys else Series(0, points.index)


def curve_of(path: DataFrame) -> Curve:
    """Load and separation along the path of one system."""
    mean_gap, separation, load = (path[name].to_numpy() for name in ("mean_gap", "separation", "load"))
    return Curve(mean_gap, separation, load, ~path.approach.to_numpy())


@dataclass(frozen=True, eq=False)
class SweepData:
    """What figures are made of: the table of a sweep, its points, and its folder with the fields."""

    table: PointTable
    root: Path

    @cached_property
    def points(self) -> DataFrame:
        return sweep_points(self.table)
