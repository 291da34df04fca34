"""The work of adhesion at which a surface turns sticky, from the points of a sweep over it: two observables.

The systems of one surface and one law differ in the work of adhesion w.  The crossover is where the quantity that tells
sticky from not passes 1: attraction over repulsion at 1 % area, or pull-off over the load before it.  Between two works
its logarithm is taken as linear in that of w.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from pandas import DataFrame, Series

from continuum.measure.curve import adhesion
from continuum.model.grid import Grid
from continuum.model.surfaces import SelfAffineSurface
from continuum.paper.points import alike, curve_of, sweep_points
from continuum.sticky.criteria import AREA, RoughContact
from continuum.sweeps.collect import PointTable
from continuum.theory import rough

NEAR = 1.1
"""Ratio within which the largest or smallest work counts as the crossover itself: attraction is nearly proportional to
w, so that the crossover is then known to a few per cent."""


def crossovers(table: PointTable) -> DataFrame:
    """The crossover of each surface and law of a sweep, one a row, by :func:`attraction_ratio`.

    Where paths have a way back it is that of :func:`pull_off_ratio`.  Columns are

    * ``hurst``, ``lambda_s``, ``lambda_L``, ``seed``: of the surface; ``law``: shape of the attraction;
    * ``range``: effective range of the attraction over h_rms, to two digits;
    * ``peak``: mean gap over h_rms at which the approach ended, as text; empty where paths are not told apart by it;
    * ``contact``: the :class:`RoughContact` at the crossover; ``work``: l_a λ_L/h_rms² there, the pure number of the
      bearing-area model; ``loss``: work lost in the cycle over w, there;
    * ``squares``: squares of λ_s in 1 % of the map, of which the paper shows no surface with fewer than ten.
    """
    points = sweep_points(table)
    ratio = attraction_ratio if points.approach.all() else pull_off_ratio
    points["series"] = alike(points, "wall.adhesion_length")
    energies, trials = conformal_energies(table), []
    for system, path in points.sort_values("step").groupby("system"):
        value, loss = ratio(path)
        if value > 0:
            trial = _trial(table, table.keys[system], path.iloc[0], energies)
            trials.append({**trial, "ratio": value, "loss": loss / trial["work"]})
    if not trials:
        return DataFrame()
    found = DataFrame(trials).sort_values("work", kind="stable")
    turns = (_crossover(each) for _, each in found.groupby("series", sort=False))
    return DataFrame([turn for turn in turns if turn is not None])


def _trial(table: PointTable, key: str, first: Series, energies: Mapping[str, float]) -> dict[str, Any]:
    """A system by the first of its points: its surface, its law, and what the theories ask about it."""
    height, shape = first.rms_height, table.setting(key, "wall.shape")
    contact = RoughContact(
        height, first.rms_slope, first.rms_curvature, first.work_of_adhesion, first.effective_range,
        conformal_energy=energies[key], roll_off=float(first.lambda_L),
    )  # fmt: skip
    targets = table.setting(key, "loading.targets") if "sweep.loading.targets" in first else None
    return {
        **first[["series", "hurst", "lambda_s", "lambda_L", "seed"]],
        "law": shape if isinstance(shape, str) else "spline",
        "range": round(first.effective_range / height, 2),
        "peak": f"{targets[-1] / height:.3g}" if isinstance(targets, (list, tuple)) else "",
        "squares": float(AREA * np.prod(table.setting(key, "grid.period")) / first.lambda_s**2),
        "contact": contact,
        "work": first.work_of_adhesion,
    }


def attraction_ratio(path: DataFrame) -> tuple[float, float]:
    """The paper's observable: attraction over repulsion at the first point of the approach; no work is lost."""
    first = path.iloc[0]
    return (first.load_att / first.load_rep if first.load_rep > 0 else np.nan), np.nan


def pull_off_ratio(path: DataFrame) -> tuple[float, float]:
    """The observable of its critics: pull-off over the peak load of the cycle, and the work lost in it."""
    if path.approach.all() or not np.array_equal(path.step, np.arange(len(path))):
        return np.nan, np.nan  # a point is missing
    found = adhesion(curve_of(path))
    if not found.separated:
        return np.nan, np.nan
    # A contact that never pushes is sticky however it is measured.
    return (found.pull_off / found.peak_load if found.peak_load > 0 else np.inf), found.loss


def _crossover(trials: DataFrame) -> dict[str, Any] | None:
    """Between the last work that is not sticky and the next; None if there is no such pair."""
    work, over, loss = np.log(trials.work.to_numpy()), np.log(trials.ratio.clip(upper=1e6).to_numpy()), trials.loss
    sticky = over > 0
    if sticky.all() or not sticky.any():
        edge = 0 if sticky.all() else -1
        if abs(over[edge]) > np.log(NEAR):
            return None
        at, lost = work[edge] - over[edge], loss.iloc[edge]
    else:
        above = int(np.argmax(sticky))
        if above == 0:  # not steady in w: a surface that sticks at the smallest work and not at a larger one
            return None
        share = -over[above - 1] / (over[above] - over[above - 1])
        at = work[above - 1] + share * (work[above] - work[above - 1])
        lost = loss.iloc[above - 1] + share * (loss.iloc[above] - loss.iloc[above - 1])
    first = trials.iloc[0]
    contact = replace(first.contact, work_of_adhesion=float(np.exp(at)))
    assert contact.roll_off is not None
    number = contact.adhesion_length * contact.roll_off / contact.rms_height**2
    return {**first, "contact": contact, "work": number, "loss": float(lost)}


def conformal_energies(table: PointTable) -> dict[str, float]:
    """Elastic energy per area of full contact of each system's surface, in E* a0: the surfaces are made anew."""

    @cache
    def energy(grid: Grid, surface: SelfAffineSurface) -> float:
        power = np.abs(grid.forward(surface.build(grid))) ** 2 * grid.mode_weights
        return rough.conformal_energy(grid.wavenumber, power)

    surfaces = {key: SelfAffineSurface.model_validate(table.given(key, "surface")) for key in table.keys}
    return {key: energy(table.grid(key), surface) for key, surface in surfaces.items()}


def exponent(cuts: Any, works: Any) -> float:
    """The power x of w ~ λ_s^x, by least squares of the logarithms; NaN for fewer than three."""
    return float(np.polyfit(np.log(cuts), np.log(works), 1)[0]) if len(cuts) > 2 else float("nan")
