"""Friction and pull-off of a smooth wall and of three walls of atoms, over the same rough maps of springs.

``python -m docs.studies.friction_of_walls --into docs/measured`` adds what is not yet in ``friction-walls.csv``, a row
for each wall and map, a minute on one core; without ``--into`` it prints the tables of
docs/studies/friction_of_walls.md from that file.  Friction is the mean over whole periods of the lattice under one
load, each of so many windows that the lateral force is also known as a function of where the wall stands above the
sites: its registry.  Pull-off is the largest tension on the way up, at 0 K, in steps of 0.05 a0; beside it stands that
of the continuum on a half-space in the same steps, with the law of the smooth wall, or that of two flat halves of the
crystals (:func:`law_of`).

Expected, before the first run, of means over three maps with their 95 % intervals by Student's t (a statement is held
if the interval lies within the bounds, refuted if it lies outside of them, and not decided otherwise): :data:`STATED`.
The bounds come from runs on one other map: friction of the first three walls, pull-off of all but 17 rows over 16.
Within a contact the registries of turned rows, which repeat every 3 a0, cancel; those of 17 rows over 16, which repeat
once in the map, do not, so that less of the wall is near the surface at once, and its tension is below that of the mean
over all registries.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pandas import DataFrame, MultiIndex, Series, read_csv
from scipy.stats import t

import atomistic as a
import continuum as c
from atomistic.front import DeckRun
from atomistic.lammps.crystal_wall import WallCrystal, energy_of_flat_halves, flat_halves
from atomistic.lammps.deck import WallForce
from atomistic.relax.windows import WindowMean
from continuum.model.fourier import Real

MEASURED = Path(__file__).parents[2] / "docs" / "measured"
FILE = "friction-walls.csv"
N, DEPTH = 16, 8
LAW = c.LennardJonesSpline(adhesion_length=0.002)
PARTS = 8
"""Windows of one period of the lattice."""
WALLS: dict[str, tuple[WallForce, dict[str, Any] | None]] = {
    "smooth": ("plugin", None),
    "the same rows": ("atoms", {"form": "bent"}),
    "17 rows over 16": ("atoms", {"form": "bent", "rows": (17, 0)}),
    "turned by 18 degrees": ("atoms", {"form": "bent", "rows": (15, 5)}),
}
"""How each wall acts, and its crystal."""
DOWN = (1.8, 1.6, 1.4, 1.2, 1.1, 1.0, 0.95)
UP = tuple(np.round(np.arange(1.0, 1.71, 0.05), 2).tolist())
"""Separations of the pull-off, in a0: loads of 0.01 E* and more are reached, as while sliding."""

COLUMNS = {
    "load": ("load kept (E\\*)", 1, 5), "friction": ("friction coefficient", 1, 3),
    "registry": ("registry (1e-3 E\\*)", 1e3, 2), "pull_off": ("pull-off (1e-3 E\\*)", 1e3, 2),
    "over_continuum": ("over the continuum", 1, 3),
}  # fmt: skip
"""Numbers of each wall and map, by what stands above them, their unit and their digits in the table."""


class Stated(NamedTuple):
    """A bound on a mean over maps."""

    what: str
    wall: str
    of: Callable[[DataFrame], Series]
    """Of the rows of all maps, with a wall and a column as columns, the number of each map."""
    low: float
    high: float


def _column(wall: str, name: str) -> Callable[[DataFrame], Series]:
    return lambda wide: wide[name, wall]


def _ratio(name: str, wall: str, other: str) -> Callable[[DataFrame], Series]:
    return lambda wide: wide[name, wall] / wide[name, other]


SMOOTH, SAME, MORE, TURNED = WALLS
STATED = (
    Stated("friction coefficient", SMOOTH, _column(SMOOTH, "friction"), -0.01, 0.01),
    Stated("friction coefficient", SAME, _column(SAME, "friction"), 0.3, 0.6),
    Stated("friction coefficient", MORE, _column(MORE, "friction"), 0.1, 0.3),
    Stated("friction coefficient", TURNED, _column(TURNED, "friction"), -0.1, 0.1),
    Stated("friction over that of the same rows", MORE, _ratio("friction", MORE, SAME), 0.0, 0.8),
    Stated("friction over that of 17 rows over 16", TURNED, _ratio("friction", TURNED, MORE), 0.0, 0.5),
    Stated("registry over that of the same rows", TURNED, _ratio("registry", TURNED, SAME), 0.0, 1 / 3),
    *(
        Stated("pull-off over that of the continuum", wall, _column(wall, "over_continuum"), low, high)
        for wall, low, high in ((SMOOTH, 0.9, 1.1), (SAME, 0.9, 1.1), (MORE, 0.6, 1.0), (TURNED, 0.9, 1.1))
    ),
)


def surface(seed: int) -> Real:
    """Heights of a map of rms slope 0.1 and λ_s = 8 a0, in a0."""
    return c.SelfAffine(0.8, 0.1, 8.0, N).synthesise(c.Grid.square(N), np.random.default_rng(seed))


def run(wall: str, heights: Real, folder: Path, **steps: Any) -> DeckRun:
    """A deck of a wall above springs, from end to end; raises RuntimeError where one of its states is not sound."""
    wall_force, crystal = WALLS[wall]
    made = a.deck(
        c.Contact(heights, LAW), depth=DEPTH, follows="atom", wall_force=wall_force, wall_crystal=crystal, **steps
    )
    found = a.run_deck(made.write(folder))
    if not found.converged:
        raise RuntimeError(f"{wall}: {[step.status for step in found.steps]}")
    return found


def law_of(wall: str) -> c.Wall:
    """Law of a wall between flat surfaces: that of the smooth wall, or of flat halves at the gaps of the crystal."""
    crystal = WALLS[wall][1]
    if crystal is None:
        return LAW
    _, spacing, commensurate = WallCrystal.model_validate(crystal).lattice((N, N))
    rest, unit = flat_halves(spacing, commensurate)
    gap = np.arange(0.7, 2.8, 0.01)  # from the core to beyond the cut-off
    energy = [energy_of_flat_halves(rest + g - LAW.zero_gap, spacing, commensurate) for g in gap]
    return c.TabulatedWall(gap, -np.gradient(np.array(energy), gap) * LAW.work_of_adhesion / unit)


def largest_tension(loads: Real) -> tuple[float, float]:
    """Largest tension on the way up, in E*, and the separation or mean gap there, in a0."""
    up = loads[len(DOWN) :]
    return -float(up.min()), UP[int(up.argmin())]


def pull_off(wall: str, seed: int, given: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """Pull-off of the atoms, and of the continuum."""
    found = run(wall, surface(seed), folder, separations=[*DOWN, *UP])
    tension, at = largest_tension(np.array([step.load for step in found.steps]))
    smooth = c.Contact(surface(seed), law_of(wall)).path(mean_gap=[*DOWN, *UP])
    continuum, _ = largest_tension(np.array([state.require().load for state in smooth]))
    return {"pull_off": tension, "pull_off_at": at, "over_continuum": tension / continuum}


def by_period(run: DeckRun, name: str) -> Real:
    """A mean of each window, or its standard error, shape (periods, PARTS)."""
    return np.array([getattr(step, name) for step in run.averaged]).reshape(-1, PARTS)


def slide(wall: str, seed: int, given: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """Means while a wall slides, over the periods after those of running in.

    Their errors are the scatter of the periods or those of their windows, whichever is larger.
    """
    protocol = {
        "kind": "sliding", "pressure": given.pressure, "velocity": given.velocity, "window": 1 / given.velocity / PARTS,
        "distance": float(given.periods + given.run_in), "temperature": given.temperature, "hold": PARTS,
        "dwell": PARTS // 2, "seed": given.motion,
    }  # fmt: skip
    found = run(wall, surface(seed), folder, protocol=protocol)
    load, shear = (by_period(found, name)[given.run_in :] for name in ("load", "lateral_x"))
    noise = [by_period(found, f"{name}_error")[given.run_in :] for name in ("load", "lateral_x")]
    errors = [np.sqrt(np.mean(each**2, axis=1) / PARTS) for each in noise]
    periods = load.mean(axis=1), shear.mean(axis=1)
    kept = WindowMean.of(periods[0], errors[0])
    friction = WindowMean.of_ratio(periods[1], errors[1], periods[0], errors[0])
    return {
        "load": kept.mean, "load_error": kept.error, "friction": friction.mean, "friction_error": friction.error,
        # Half of the way of the lateral force within a period, and what thermal noise alone would make of it.
        "registry": float(np.ptp(shear.mean(axis=0))) / 2,
        "registry_error": float(np.sqrt(np.mean(noise[1] ** 2) / len(load))),
        "height": float(by_period(found, "separation")[given.run_in :].mean()),
    }  # fmt: skip


def _mean(each: Series) -> tuple[float, float, int]:
    """Mean over the maps that were run, its standard error and their number; of fewer than two there is no error."""
    there = each.dropna()
    return float(there.mean()), float(there.std(ddof=1) / np.sqrt(len(there))), len(there)


def by_wall(rows: DataFrame) -> DataFrame:
    """A row for each map, and a column for each number and wall: NaN where it was not run."""
    return rows.pivot(index="map", columns="wall").reindex(columns=MultiIndex.from_product([COLUMNS, WALLS]))


def table(rows: DataFrame) -> str:
    """Means over maps and their standard errors, for each wall."""
    wide = by_wall(rows)
    lines = [f"| wall | {' | '.join(head for head, *_ in COLUMNS.values())} |", f"|{'---|' * (len(COLUMNS) + 1)}"]
    for wall in WALLS:
        cells = []
        for name, (_, unit, digits) in COLUMNS.items():
            mean, error, count = _mean(wide[name, wall] * unit)
            cells.append(f"{mean:.{digits}f} ± {error:.{digits}f}" if count > 1 else "not run")
        lines.append(f"| {wall} | {' | '.join(cells)} |")
    return "\n".join(lines)


def verdicts(rows: DataFrame) -> str:
    """What became of each statement."""
    wide = by_wall(rows)
    lines = ["| wall | mean over maps | stated | found, 95 % interval | maps | verdict |", f"|{'---|' * 6}"]
    for what, wall, of, low, high in STATED:
        mean, error, count = _mean(of(wide))
        found, verdict = "–", "not run"
        if count > 1:
            half = float(t.ppf(0.975, count - 1)) * error
            within, outside = low <= mean - half and mean + half <= high, mean + half < low or mean - half > high
            found = f"{mean:.3f} ({mean - half:.3f} to {mean + half:.3f})"
            verdict = "held" if within else "**refuted**" if outside else "not decided"
        lines.append(f"| {wall} | {what} | {low:.2g} to {high:.2g} | {found} | {count} | {verdict} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--into", type=Path, help=f"folder of {FILE}, to which the rows that it lacks are added")
    parser.add_argument("--pressure", type=float, default=0.007)
    parser.add_argument("--velocity", type=float, default=0.02)
    parser.add_argument("--temperature", type=float, default=0.0018)
    parser.add_argument("--periods", type=int, default=4)
    parser.add_argument("--run-in", type=int, default=2, help="periods before those of the means")
    parser.add_argument("--maps", type=int, nargs="+", default=[4, 5, 6], help="seeds of the maps")
    parser.add_argument("--motion", type=int, default=1, help="seed of the thermal motion")
    given = parser.parse_args()
    if given.into:
        file = given.into / FILE
        stored = read_csv(file).to_dict("records") if file.is_file() else []
        found: dict[Any, dict[str, Any]] = {(row["map"], row["wall"]): row for row in stored}
        for measure, known in ((pull_off, "pull_off"), (slide, "friction")):
            for seed, wall in itertools.product(given.maps, WALLS):
                row = found.setdefault((seed, wall), {"wall": wall, "map": seed})
                if np.isnan(row.get(known, np.nan)):
                    with tempfile.TemporaryDirectory() as folder:
                        row |= measure(wall, seed, given, Path(folder) / "deck")
                    DataFrame(found.values()).to_csv(file, index=False, float_format="%.6g", lineterminator="\n")
    rows = read_csv((given.into or MEASURED) / FILE)
    sys.stdout.write(f"{table(rows)}\n\n{verdicts(rows)}\n")


if __name__ == "__main__":
    main()
