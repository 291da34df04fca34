"""The error budget: the error of each step of the ladder, absolute checks, and whether every bound holds.

The errors of the steps follow from the table of a validation, one row per state, as :mod:`atomistic.ladder.archive`
stores it.  Absolute checks need no other run: the responses of a ladder at long waves, and the law of its decks.

At long waves all rungs tend to one elastic crystal.  The lattice, from its measured force constants, has the stiffness
K_q = E*(θ) q/2 (1 + O(q)) of its own half-space.  With K at q and q/2 the first order is eliminated.  The cubic
crystal must have these limits along <110> and <100>, and the isotropic half-space the mean compliance over directions,
1/<1/E*>.  The traction that LAMMPS gives atoms at known gaps must be that of the wall law.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from atomistic.crystal.crystal import LAYER_SPACING, Slab
from atomistic.inputs.validate import CaseTable, ExponentTable, ValidateConfig
from atomistic.ladder.ensemble import carried_bounds
from atomistic.ladder.rungs import RungName, continuum_response
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.result import DeckResult
from atomistic.relax.specimen import Specimen
from atomistic.response.force_constants import ForceConstants, least_width
from atomistic.response.lattice import half_space_stiffness
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates.crystal import CubicConstants
from continuum.model.walls import Wall

LONGEST, DEEP = 512.0, 4096.0
"""Longest wave, and depth of a layer that is a half-space for it to all digits, in a0."""
_DIRECTIONS = ((1, 0), (2, 1), (1, 1))
"""Mode numbers (m, n) of the longest wave of each direction: <110>, between, <100>.  1/E*(θ) is read from them as
a + b cos 4θ + c cos 8θ; of copper, the most anisotropic of our crystals, a is then right to 7e-4."""
GAPS = 100
"""Smallest number of gaps at which a law is looked at."""
SMALLEST_GAP = 0.8
"""In a0: there the wall pushes with 0.6 E*, harder than any contact of these inputs."""
LONG_WAVES, LAW = 0.005, 1e-9
"""Largest relative difference of stiffnesses at long waves, and of tractions.

The first has room for the error of extrapolation and of measured constants: 1.4e-4 along a direction for aluminium,
7e-4 of the mean for copper.  A crystal turned by 45 degrees differs by 1.5 % (aluminium) to 6.6 % (copper).  The second
is of rounding: formulas of LAMMPS and ours agree to 1e-15 of the tractions, gaps in Å to 1e-13.
"""
Columns = Mapping[str, NDArray[Any]]
"""Columns over states (``case``, ``rms_slope``, ``seed``, ``area``, ``branch``, ...), and the differences
``step_quantity``, e.g. ``nonlinearity_load``."""


class LadderCheck(NamedTuple):
    """One check: what was compared, the largest relative difference, the allowed one and the number of values."""

    step: str
    quantity: str
    measured: float
    limit: float
    points: int
    reason: str


def checks_of(
    specimen: Specimen, laws: Mapping[str, Wall], run: Callable[[Path], DeckResult]
) -> tuple[LadderCheck, ...]:
    """The checks of a substrate and of the laws that are pressed on it.

    Parameters
    ----------
    laws : by name.
    run : runs a deck, as :func:`atomistic.lammps.engine.runner` gives it.
    """
    model = specimen.model
    limits = _limits(specimen.response.force_constants)
    reason = "for long waves, both have the elastic constants of the crystal; with room for extrapolation"
    cubic = (_of_rung("crystal", model.elastic_constants) / limits)[[0, 2]]
    found = [
        LadderCheck(
            "crystal", f"K_q of long waves along {name} against the lattice", abs(ratio - 1), LONG_WAVES, 2, reason
        )
        for name, ratio in zip(("<110>", "<100>"), cubic.tolist(), strict=True)
    ]
    half_space = _mean_over_directions(_of_rung("half-space", model.elastic_constants)) / _mean_over_directions(limits)
    what = "K_q/q against the mean of the lattice's long waves"
    found.append(LadderCheck("half-space", what, abs(half_space - 1), LONG_WAVES, 2 * len(_DIRECTIONS), reason))
    for name, wall in laws.items():
        measured, points = law_error(specimen, wall, run)
        what, why = f"traction in LAMMPS under {name}", "the same formula: rounding, and digits of the gap"
        found.append(LadderCheck("law", what, measured, LAW, points, why))
    return tuple(found)


def _limits(constants: ForceConstants) -> Real:
    """Limit of K_q/q of the lattice for long waves in each direction, in E*."""
    m, n = np.array(_DIRECTIONS).T * (2 * np.pi / LONGEST)
    return _extrapolated(*(half_space_stiffness(constants, k * m, k * n) / (k * np.hypot(m, n)) for k in (1, 2)))


def _of_rung(name: RungName, constants: CubicConstants) -> Real:
    """The same of a rung of the ladder, whose base is too deep to be felt."""
    grid = Grid((16, 16), (LONGEST, LONGEST))
    ratio = continuum_response(name, DEEP, constants).stiffness(grid) / np.where(
        grid.wavenumber > 0, grid.wavenumber, 1
    )
    m, n = np.array(_DIRECTIONS).T
    return _extrapolated(ratio[m, n], ratio[2 * m, 2 * n])


def _extrapolated(long: Real, half_as_long: Real) -> Real:
    return np.asarray(2 * long - half_as_long)


def _mean_over_directions(stiffness: Real) -> float:
    """1/<1/stiffness> over directions, of that along each of the three."""
    angle = np.arctan2(*np.array(_DIRECTIONS).T[::-1])
    series = np.cos(4 * np.outer(angle, np.arange(3)))
    return float(1 / np.linalg.solve(series, 1 / stiffness)[0])


def law_error(specimen: Specimen, wall: Wall, run: Callable[[Path], DeckResult]) -> tuple[float, int]:
    """Largest error of the traction of a deck at known gaps, and their number.

    Relative to the traction, or to the largest tension if that is larger.
    """
    model = specimen.model
    n, layers = max(least_width(model), int(np.ceil(np.sqrt(GAPS)))), model.coupled_layers
    slab, rise = Slab((n, n), layers, layers), np.zeros(2 * layers)
    rise[:layers] = specimen.rise[:layers]
    # Where the law reaches the second layer, 5 % nearer as it may relax, the first has only its part of it.
    nearest = max(SMALLEST_GAP, wall.zero_gap + wall.range - 0.95 * LAYER_SPACING)
    gap = np.linspace(nearest, wall.zero_gap + 1.1 * max(wall.range, 0.1), n * n).reshape(n, n)
    separation = float(gap.mean())
    # Nothing is to move: any force is within the tolerance.
    deck = Deck(slab, model, wall, gap - separation, separation, tolerance=1e9, rise=rise)
    with tempfile.TemporaryDirectory() as folder:
        found = run(write_deck(Path(folder) / "deck", deck))
    expected = wall.evaluate(gap).traction
    scale = np.maximum(np.abs(expected), max(0.0, -float(expected.min())))
    error = np.abs(found.traction - expected)
    relative = np.divide(error, scale, out=np.where(error > 0, np.inf, 0.0), where=scale > 0)
    return float(relative.max()), gap.size


class BudgetLine(NamedTuple):
    """Errors of the steps of the ladder for one case and slope: largest magnitudes over its states."""

    case: str
    lambda_s: float
    """Shortest wavelength of the wall, in a0."""
    rms_slope: float
    load: dict[str, float]
    """Step -> largest |load difference|/(N_rep + N_att).  If springs were run, which give the geometric part of the
    nonlinearity, the rest is the step ``anharmonicity``."""
    contact: dict[str, float]
    """Step -> largest fraction of points whose contact differs."""
    load_ratio: tuple[float, float]
    """Smallest and largest N of the half-space over N of the lattice at equal separation: mean compliance."""


class ClosedLine(NamedTuple):
    """Errors of the steps of the ladder in one kind of state, all at its repulsive area, so that they add up."""

    case: str
    rms_slope: float
    area: float
    branch: str
    surfaces: int
    """Number of surfaces that have this state on all rungs."""
    of: int
    parts: dict[str, tuple[float, float]]
    """Step -> mean over the surfaces of N - N', N' being the load of the finer rung, over N_rep + N_att of the atoms,
    and the standard error of this mean; NaN for one surface.  The last step is the total."""


@dataclass(frozen=True)
class BoundVerdict:
    """One bound, the worst state that it applies to, and whether it holds."""

    case: str
    """Name of the case in the input; empty for a check that has none."""
    step: str
    """Step of the ladder; ``crystal``, ``half-space`` or ``law`` for a check, ``equilibrium`` for the forces left."""
    quantity: str
    bound: str
    """The bound as text, such as ``0.3 h'``."""
    measured: float
    """Largest magnitude, in the unit of the bound's coefficient."""
    limit: float
    """Coefficient of the bound."""
    states: int
    """Number of states that were checked."""
    reason: str
    state: str = ""
    """The worst state: slope, seed, area and branch."""
    scale: float = 1.0
    """Power of the slope of the worst state, by which the difference was divided."""

    @property
    def holds(self) -> bool:
        """True if every state is within the bound; a bound without states does not hold."""
        return self.states > 0 and self.measured <= self.limit

    @property
    def told(self) -> str:
        """Value at the worst state, and the allowed one."""
        at = f"at {self.state}, the worst of {self.states}" if self.state else f"{self.states} values"
        at = at if self.states else "no state was looked at"
        of = ", ".join(filter(None, (self.case, self.step, self.quantity)))
        return f"{of}: {self.measured:.3g} where {self.limit:.4g} is allowed ({self.bound}), {at}"


class Exponent(NamedTuple):
    """Exponent of a difference of lattice response and atoms in the slope, for one surface and area."""

    case: str
    adhesion_length: float
    quantity: str
    seed: int
    area: float
    slopes: tuple[float, ...]
    fitted: float
    """Slope of the logarithms, by least squares; NaN where a difference is zero, or no number."""
    local: tuple[float, ...]
    """Exponents between neighbouring slopes, from the steepest down."""


def costs(columns: Columns, steps: tuple[str, ...]) -> Iterator[BudgetLine]:
    """A row of the budget for each case and slope, in the order of the input."""
    points = columns["points"][0]
    for (case, slope), mine in _alike(columns, "case", "rms_slope"):
        ratio = columns["load_ratio"][mine]
        load = {step: float(np.abs(columns[f"{step}_gross_load"][mine]).max()) for step in steps}
        if "geometry" in steps:
            rest = columns["nonlinearity_gross_load"][mine] - columns["geometry_gross_load"][mine]
            load["anharmonicity"] = float(np.abs(rest).max())
        contact = {step: float(columns[f"{step}_pixels"][mine].max() / points) for step in steps}
        shortest, ratios = float(columns["lambda_s"][mine][0]), (float(ratio.min()), float(ratio.max()))
        yield BudgetLine(case, shortest, slope, load, contact, ratios)


def _alike(columns: Columns, *names: str) -> Iterator[tuple[tuple[Any, ...], NDArray[np.bool_]]]:
    """The combinations of values of some columns, in the order of the states, and the states of each."""
    keys = list(zip(*(columns[name].tolist() for name in names), strict=True))
    for key in dict.fromkeys(keys):
        yield key, np.array([each == key for each in keys])


def closed(columns: Columns, steps: Mapping[str, tuple[str, str]]) -> Iterator[ClosedLine]:
    """A row for each case, slope, area and branch, over its states on all surfaces except those beside a jump.

    Parameters
    ----------
    steps : the rungs of each step, in the order of the ladder, and of the total, last.
    """
    rungs = columns["rung"].tolist()
    acts = (columns["load_rep"] + columns["load_att"])[rungs.index("atoms")]
    loads = {rung: columns["load_at_area"][rungs.index(rung)] / acts for pair in steps.values() for rung in pair}
    parts = {step: loads[coarse] - loads[fine] for step, (coarse, fine) in steps.items()}
    everywhere = np.isfinite(list(parts.values())).all(axis=0)
    for (place, case, slope, area, branch), mine in _alike(columns, "place", "case", "rms_slope", "area", "branch"):
        if place != "area":
            continue
        there = mine & everywhere
        found = {step: _mean(part[there]) for step, part in parts.items()}
        yield ClosedLine(case, slope, area, branch, int(np.count_nonzero(there)), int(np.count_nonzero(mine)), found)


def _mean(values: NDArray[np.float64]) -> tuple[float, float]:
    """Mean and its standard error; NaN if there are too few values."""
    mean = float(values.mean()) if values.size else np.nan
    return mean, float(values.std(ddof=1) / np.sqrt(values.size)) if values.size > 1 else np.nan


def bound_verdicts(config: ValidateConfig, columns: Columns) -> Iterator[BoundVerdict]:
    """Every bound of the input, those of the ensemble for all other steps, and those that hold for all cases.

    The bounds of a step are those of the input, if it has any, else of :mod:`atomistic.ladder.ensemble`, if these
    exist.
    """
    for case in config.case:
        mine = columns["case"] == case.name
        worst = partial(_worst, columns, case.name)
        own = {bound.step for bound in case.tolerance}
        for bound in (*case.tolerance, *(one for one in carried_bounds(config, case) if one.step not in own)):
            applies = mine & (np.isin(columns["area"], bound.areas) if bound.areas else True)
            scale = columns["rms_slope"] ** bound.power
            differences = np.abs(columns[f"{bound.step}_{bound.quantity}"])
            power = {0.0: "", 1.0: " h'", 2.0: " h'²"}.get(bound.power, f" h'^{bound.power:g}")
            unit = " a0" if bound.quantity == "displacement" else ""
            areas = " at A_rep " + ", ".join(f"{a:g}" for a in bound.areas) if bound.areas else ""
            quantity, text = bound.quantity.replace("_", " ") + areas, f"{bound.coefficient:.4g}{power}{unit}"
            yield worst(applies, differences, bound.step, quantity, text, bound.coefficient, bound.reason, scale)
        for exponent in case.exponent:
            yield _scaled(case, exponent, columns)
        scale = columns["rms_slope"] * 1e-8
        reason = "largest force at which the atoms count as at rest, so that differences are physical"
        bound_of = "equilibrium", "largest force", "1e-8 h' E* a0²"
        yield worst(mine, columns["largest_force"], *bound_of, 1.0, reason, scale)
    # Those of earlier versions have none.
    of_check = (columns[f"check_{name}"].tolist() for name in LadderCheck._fields if "check_step" in columns)
    for check in map(LadderCheck._make, zip(*of_check, strict=True)):
        yield BoundVerdict("", check.step, check.quantity, f"{check.limit:g}", *check[2:])


def _worst(
    columns: Columns,
    case: str,
    applies: NDArray[np.bool_],
    differences: NDArray[np.float64],
    step: str,
    quantity: str,
    bound: str,
    limit: float,
    reason: str,
    scale: NDArray[np.float64],
) -> BoundVerdict:
    """The verdict on a bound by its worst state; NaN is worst."""
    at, values = np.flatnonzero(applies), differences / scale
    if not at.size:
        return BoundVerdict(case, step, quantity, bound, float("nan"), limit, 0, reason)
    worst = at[np.argmax(values[at])]
    place, area = str(columns["place"][worst]), columns["area"][worst]
    where = f"A_rep/A0 = {area:g}" if place == "area" else place
    slope, seed, branch = (columns[name][worst] for name in ("rms_slope", "seed", "branch"))
    state = f"h' = {slope:g}, seed {seed}, {where}, {branch}"
    return BoundVerdict(
        case, step, quantity, bound, float(values[worst]), limit, at.size, reason, state, float(scale[worst])
    )


def _scaled(case: CaseTable, table: ExponentTable, columns: Columns) -> BoundVerdict:
    fits = [e for e in exponents(columns, table.slopes) if e.case == case.name and e.quantity == table.quantity]
    slopes = ", ".join(f"{s:g}" for s in table.slopes)
    off, state = float("nan"), ""
    if fits:
        worst = max(fits, key=lambda fit: (np.isnan(fit.fitted), abs(fit.fitted - table.expected)))
        off, state = abs(worst.fitted - table.expected), f"seed {worst.seed}, A_rep/A0 = {worst.area:g}"
    quantity, bound = f"exponent of {table.quantity} over h' = {slopes}", f"{table.expected:g} ± {table.tolerance:g}"
    of = case.name, "nonlinearity", quantity
    return BoundVerdict(*of, bound, off, table.tolerance, len(fits), table.reason, state)


def exponents(columns: Columns, slopes: tuple[float, ...] | None = None) -> Iterator[Exponent]:
    """Scaling of load and displacement difference with the slope, for each surface, area and branch.

    Uses the given slopes, all if None; surfaces with fewer than two of them are left out.
    """
    for (case, seed, area, _), states in _alike(columns, "case", "seed", "area", "branch"):
        mine = states if slopes is None else states & np.isin(columns["rms_slope"], slopes)
        if np.count_nonzero(mine) < max(2, len(slopes or ())):
            continue
        order = np.argsort(-columns["rms_slope"][mine])
        h = columns["rms_slope"][mine][order]
        for quantity in ("load", "displacement"):
            d = np.abs(columns[f"nonlinearity_{quantity}"][mine][order])
            usable = bool(np.isfinite(d).all() and (d > 0).all())
            local = np.diff(np.log(d)) / np.diff(np.log(h)) if usable else np.full(h.size - 1, np.nan)
            fitted = float(np.polyfit(np.log(h), np.log(d), 1)[0]) if usable else np.nan
            length = float(columns["adhesion_length"][mine][0])
            yield Exponent(case, length, quantity, seed, area, tuple(h.tolist()), fitted, tuple(local.tolist()))
