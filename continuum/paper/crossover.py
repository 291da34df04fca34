"""The work of adhesion at which a surface turns sticky, from the points of a sweep over it: two observables.

Of one surface and one law, the systems of a sweep differ in the work of adhesion w.  The turn is where the quantity
that tells sticky from not passes 1: attraction over repulsion at 1 % area, or pull-off over the load before it.
Between two works its logarithm is taken as linear in that of w.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from continuum.measure.curve import Curve, adhesion
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.runs.collect import PointTable
from continuum.runs.surfaces import SelfAffineSurface
from continuum.sticky.criteria import AREA, RoughContact
from continuum.theory import rough

NEAR = 1.1
"""Ratio within which the largest or smallest work counts as the turn itself: attraction is nearly proportional to w, so
that the turn is then known to a few per cent."""
WORK = "wall.adhesion_length"
_TOLD = ("surface.hurst", "surface.lambda_s", "surface.lambda_L", "surface.seed", "grid.n", "grid.period",
         "wall.shape")  # fmt: skip


@dataclass(frozen=True)
class Trial:
    """One system: a surface, a law, and what was found."""

    series: tuple[Hashable, ...]
    """All settings but the work of adhesion."""
    settings: dict[str, Any]
    contact: RoughContact
    ratio: float
    """Above 1: sticky."""
    loss: float = np.nan
    """Work lost in the cycle over w; NaN without a way back."""


@dataclass(frozen=True)
class Turn:
    """A surface with the work of adhesion at which it turns sticky."""

    settings: dict[str, Any]
    contact: RoughContact
    """At the turn."""
    loss: float
    """Work lost in the cycle over w, there."""

    @property
    def shape(self) -> str:
        """Of the attraction: the paper's spline where the wall has no other."""
        given = self.settings.get("wall.shape")
        return given if isinstance(given, str) else "spline"

    @property
    def reach(self) -> float:
        """Effective range of the attraction over h_rms."""
        return self.contact.range / self.contact.rms_height

    @property
    def work(self) -> float:
        """l_a λ_L/h_rms² at the turn, a pure number: the bearing-area model's."""
        assert self.contact.roll_off is not None
        return self.contact.adhesion_length * self.contact.roll_off / self.contact.rms_height**2

    @property
    def contacts(self) -> float:
        """Squares of λ_s in 1 % of the map: the paper shows no surface of fewer than ten."""
        return float(AREA * np.prod(self.settings["grid.period"]) / self.settings["surface.lambda_s"] ** 2)


def exponent(cuts: Real, works: Real) -> float:
    """Of w ~ λ_s^x, by least squares of the logarithms; NaN for fewer than three."""
    return float(np.polyfit(np.log(cuts), np.log(works), 1)[0]) if len(cuts) > 2 else float("nan")


def load_turns(table: PointTable) -> list[Turn]:
    """By the paper's observable, the sign of the load at the first point of each path."""
    return _turns(by_load(table))


def pull_off_turns(table: PointTable) -> list[Turn]:
    """By its critics' observable: the largest tension on retraction equals the largest load before."""
    return _turns(by_pull_off(table))


def by_load(table: PointTable) -> list[Trial]:
    """Attraction over repulsion at the first point of each approach."""

    def ratio(rows: NDArray[np.int64]) -> tuple[float, float]:
        first = rows[np.argmin(table["step"][rows])]
        pushing = table["load_rep"][first]
        return (float(table["load_att"][first] / pushing) if pushing > 0 else np.nan), np.nan

    return list(_trials(table, ratio))


def by_pull_off(table: PointTable) -> list[Trial]:
    """Pull-off over the peak load of each cycle, and the work lost in it."""

    def ratio(rows: NDArray[np.int64]) -> tuple[float, float]:
        rows = rows[np.argsort(table["step"][rows])]
        steps, back = table["step"][rows], table["retracting"][rows] == 1
        if not back.any() or not np.array_equal(steps, np.arange(steps.size)):
            return np.nan, np.nan  # a point is missing
        gap, separation, load = (table[name][rows] for name in ("mean_gap", "separation", "load"))
        found = adhesion(Curve(gap, separation, load, back))
        if not found.separated:
            return np.nan, np.nan
        # A contact that never pushes is sticky however it is measured.
        return (found.pull_off / found.peak_load if found.peak_load > 0 else np.inf), found.loss

    return list(_trials(table, ratio))


def _trials(table: PointTable, found: Callable[[NDArray[np.int64]], tuple[float, float]]) -> Iterator[Trial]:
    axes = [key for axis in table.listed.axes for key in axis.keys]
    told = dict.fromkeys((*_TOLD, *axes))
    energies = conformal_energies(table)
    names = ("rms_height", "rms_slope", "rms_curvature", "work_of_adhesion")
    for index, key in enumerate(table.keys):
        rows = np.flatnonzero(table.system == index)
        if not rows.size:
            continue
        value, loss = found(rows)
        if not value > 0:
            continue
        settings = {name: table.setting(key, name) for name in told}
        numbers = {name: float(table[name][rows[0]]) for name in names}
        reach, roll_off = float(table["effective_range"][rows[0]]), float(settings["surface.lambda_L"])
        contact = RoughContact(**numbers, range=reach, conformal_energy=energies[key], roll_off=roll_off)
        series = tuple(str(settings[name]) for name in settings if name != WORK)
        yield Trial(series, settings, contact, value, loss / contact.work_of_adhesion)


def _turns(trials: list[Trial]) -> list[Turn]:
    series: dict[tuple[Hashable, ...], list[Trial]] = {}
    for trial in sorted(trials, key=lambda each: each.contact.work_of_adhesion):
        series.setdefault(trial.series, []).append(trial)
    return [turn for each in series.values() if (turn := _turn(each)) is not None]


def _turn(trials: list[Trial]) -> Turn | None:
    """Between the last work that is not sticky and the next; NaN-free, or None if there is no such pair."""
    work = np.log([trial.contact.work_of_adhesion for trial in trials])
    over = np.log([min(trial.ratio, 1e6) for trial in trials])
    sticky = over > 0
    if sticky.all() or not sticky.any():
        edge = 0 if sticky.all() else len(trials) - 1
        if abs(over[edge]) > np.log(NEAR):
            return None
        at, loss = work[edge] - over[edge], trials[edge].loss
    else:
        above = int(np.argmax(sticky))
        if above == 0:  # not steady in w: a surface that sticks at the smallest work and not at a larger one
            return None
        share = -over[above - 1] / (over[above] - over[above - 1])
        at = work[above - 1] + share * (work[above] - work[above - 1])
        loss = trials[above - 1].loss + share * (trials[above].loss - trials[above - 1].loss)
    first = trials[0]
    settings = {name: value for name, value in first.settings.items() if name != WORK}
    return Turn(settings, replace(first.contact, work_of_adhesion=float(np.exp(at))), float(loss))


def conformal_energies(table: PointTable) -> dict[str, float]:
    """Elastic energy per area of full contact of each system's surface, in E* a0: the surfaces are made anew."""

    @cache
    def energy(grid: Grid, surface: SelfAffineSurface) -> float:
        power = np.abs(grid.forward(surface.build(grid))) ** 2 * grid.mode_weights
        return rough.conformal_energy(grid.wavenumber, power)

    surfaces = {key: SelfAffineSurface.model_validate(table.given(key, "surface")) for key in table.keys}
    return {key: energy(table.grid(key), surface) for key, surface in surfaces.items()}
