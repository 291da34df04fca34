"""The threshold on atoms: from which work of adhesion on does a surface stick, on every rung of the ladder?

``python -m docs.studies.threshold_of_atoms --into docs/measured`` writes ``threshold-atoms.csv``, a row for each
surface, crystal and rung; without it the table of docs/studies/threshold_of_atoms.md is made of that file.

On the continuum rungs the threshold is found as everywhere (:mod:`continuum.path.threshold_search`).  On atoms
separation and work are looked for by a chord method, with the slopes of rough surfaces in general, from the threshold
of the lattice on.  Each state of atoms starts from that of the lattice at the same separation and work, on approach.

``--one-state`` prints the thresholds of that file over the estimate from one state without adhesion on each rung of the
continuum (docs/studies/one_state.md), and those of the atoms over that of the lattice; half a minute.

Expected, before the first run: half-space, layer, crystal and lattice within 10 % of one another, as all but a few
waves are long against a0; atoms within 10 % of their lattice at h' = 0.05, as geometry and anharmonicity are of the
order of the slope.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from pandas import DataFrame, read_csv
from scipy.stats import t

from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder.rungs import CONTINUUM_RUNGS, response_of
from atomistic.lammps.deck import Deck
from atomistic.relax.relax import iterate, lattice_start
from atomistic.relax.specimen import Specimen, specimen_of
from continuum.inputs.reading import load
from continuum.measure.contact import Totals, totals_of
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.surface import SelfAffine
from continuum.model.walls.attraction import attraction_on_core
from continuum.path.estimates import DECAY
from continuum.path.loading import solve
from continuum.path.state import Search
from continuum.path.threshold import press_without_adhesion
from continuum.path.threshold_search import WallOfWork, bracket_threshold
from continuum.solve.solution import Settings

MEASURED = Path(__file__).parents[2] / "docs" / "measured"
CRYSTALS = {"springs": "springs", "Lennard-Jones": "lennard-jones", "copper": "copper"}
AREA, WIDTH = 0.04, 0.02
RANGE = 0.5
"""Of the attraction, in h_rms."""
CORE = 5.0
TRIALS, DAMPED = 10, 0.7
"""States of atoms at most, and part of each step that is made: on some surfaces ln r rises twice as fast as ln w."""
TOLERANCE = 1e-6
"""Largest force on an atom, in E* a0²: a part in 1e4 of the load of one in contact."""


@dataclass(frozen=True)
class Trial:
    """What a state says, against what is looked for."""

    totals: Totals

    @property
    def off(self) -> Real:
        """ln A over the target, and ln(load_att/load_rep)."""
        found = self.totals
        return np.array([np.log(found.area_rep / AREA), np.log(found.load_att / found.load_rep)])


def surface(n: int, seed: int, rms_slope: float) -> Real:
    """The paper's surface, with periods of four λ_L."""
    return SelfAffine(0.8, rms_slope, 6.0, n / 4).synthesise(Grid.square(n), np.random.default_rng(seed))


def thresholds(specimen: Specimen, heights: Real) -> Iterator[tuple[str, float, float]]:
    """Rung, work over U at its threshold, and area there."""
    grid, height = specimen.slab.grid, float(heights.std())
    wall = partial(attraction_on_core, "spline", effective_range=RANGE * height, core_stiffness=CORE)
    energy = ContactProblem(
        grid, wall(1e-4), heights, response_of("half-space", specimen.response, _constants(specimen))
    )
    energy_of_contact = energy.elastic_energy(np.zeros(grid.shape))
    for name in CONTINUUM_RUNGS:
        substrate = response_of(name, specimen.response, _constants(specimen))
        problem = ContactProblem(grid, wall(1e-4), heights, substrate)
        settings = Settings(1e-6 * problem.traction_scale)
        there, state = bracket_threshold(problem, wall, AREA, settings, Search(0.02), WIDTH)
        state.require()
        work = there.wall.work_of_adhesion * state.load_rep / state.load_att
        yield name, work / energy_of_contact, state.area_rep
    # The last rung of the continua is the lattice: the atoms begin there.
    work, area = on_atoms(specimen, heights, wall, state.separation, work)
    yield "atoms", work / energy_of_contact, area


def _constants(specimen: Specimen):
    return specimen.model.elastic_constants


def on_atoms(
    specimen: Specimen, heights: Real, wall: WallOfWork, separation: float, work: float
) -> tuple[float, float]:
    """Work at the threshold on atoms, and area there."""
    grid, response = specimen.slab.grid, specimen.response
    settings = Settings(TOLERANCE / 100)

    def lattice(at: Real) -> tuple[ContactProblem, Real]:
        problem = ContactProblem(grid, wall(float(np.exp(at[1]))), heights, response)
        return problem, solve(problem, "separation", float(at[0]), settings).require().gap

    def trial_of(problem: ContactProblem, gap: Real) -> Trial:
        return Trial(totals_of(grid, problem.wall, gap))

    here = np.array([separation, np.log(work)])
    # ln A falls with the separation, and rises with w; ln(load_att/load_rep) rises as ln w.
    slopes = np.array([[-DECAY / float(heights.std()), 0.5], [0.0, 1.0]])
    problem, gap = lattice(here)
    deck = Deck(specimen.slab, specimen.model, problem.wall, heights, float(here[0]),
                lattice_start(response, problem.wall, gap), tolerance=TOLERANCE, rise=response.rise)  # fmt: skip
    for _ in range(TRIALS):
        problem, gap = lattice(here)
        start = lattice_start(response, problem.wall, gap)
        now = replace(deck, wall=problem.wall, separation=float(here[0]), displacements=start)
        found = iterate(now, specimen.session, response)
        if not found.converged:
            raise RuntimeError(f"atoms did not converge: largest forces {found.largest_forces[-3:]}")
        trial = trial_of(problem, here[0] + heights - found.displacements[0, ..., 2])
        sys.stderr.write(f"    {here[0]:.4f} a0, w {np.exp(here[1]):.3e}: {trial.off}\n")
        # Half a point of the grid is met.
        if abs(trial.off[0]) <= max(0.02, 0.6 / (AREA * grid.size)) and abs(trial.off[1]) <= WIDTH:
            return float(np.exp(here[1] - trial.off[1])), trial.totals.area_rep
        here = here - DAMPED * np.linalg.solve(slopes, trial.off)
    raise RuntimeError("the threshold on atoms was not found")


def measured(n: int, depth: float, rms_slope: float, seeds: list[int], crystals: list[str]) -> DataFrame:
    """Thresholds of all surfaces on all rungs of the crystals."""
    rows = []
    for crystal in crystals:
        settings = {"slab.n": n, "slab.depth": depth}
        specimen = specimen_of(load(f"inputs/validate/{CRYSTALS[crystal]}.toml", ValidateConfig, settings))
        for seed in seeds:
            for rung, ratio, area in thresholds(specimen, surface(n, seed, rms_slope)):
                sys.stderr.write(f"{crystal} {seed} {rung}: {ratio:.4f} at {area:.4f}\n")
                rows.append({"crystal": crystal, "n": n, "depth": depth, "slope": rms_slope, "seed": seed, "rung": rung,
                             "over_energy": ratio, "area": area})  # fmt: skip
    return DataFrame(rows)


def of_one_state(rows: DataFrame) -> DataFrame:
    """The thresholds of the file with the estimate of one state on the rung, that of the lattice for the atoms."""
    made = []
    for (crystal, n, depth), part in rows.groupby(["crystal", "n", "depth"], sort=False):
        settings = {"slab.n": n, "slab.depth": depth}
        specimen = specimen_of(load(f"inputs/validate/{CRYSTALS[crystal]}.toml", ValidateConfig, settings))
        grid = specimen.slab.grid
        for (slope, seed), of_surface in part.groupby(["slope", "seed"]):
            heights = surface(n, seed, slope)
            wall = partial(attraction_on_core, "spline", effective_range=RANGE * heights.std(), core_stiffness=CORE)
            flat = np.zeros(grid.shape)
            for row in of_surface.to_dict("records"):
                if row["rung"] == "half-space":
                    substrate = response_of(row["rung"], specimen.response, _constants(specimen))
                    energy = ContactProblem(grid, wall(1e-4), heights, substrate).elastic_energy(flat)
                if row["rung"] != "atoms":
                    substrate = response_of(row["rung"], specimen.response, _constants(specimen))
                    problem = ContactProblem(grid, wall(1e-4), heights, substrate)
                    settled = Settings(1e-6 * problem.traction_scale)
                    said = press_without_adhesion(problem, AREA, settled, CORE, Search(0.02)).threshold(wall)
                made.append({**row, "ratio": row["over_energy"] * energy / said.work, "low": said.low / energy,
                             "high": said.high / energy, "chi": said.chi, "patches": said.patches,
                             "within": said.low <= row["over_energy"] * energy <= said.high})  # fmt: skip
    return DataFrame(made)


def one_state_table(rows: DataFrame) -> str:
    """Threshold over estimate on each rung, mean and 95 % interval over surfaces."""
    rungs = (*CONTINUUM_RUNGS, "atoms")
    lines = [f"| crystal | {' | '.join(rungs)} | χ | patches |", f"|{'---|' * (len(rungs) + 3)}"]
    for crystal, part in rows.groupby("crystal", sort=False):
        cells = [_mean(np.log(part[part.rung == rung].ratio.to_numpy())) for rung in rungs]
        ends = (f"{part.chi.min():.2f} to {part.chi.max():.2f}", f"{part.patches.min()} to {part.patches.max()}")
        lines.append(f"| {crystal} | {' | '.join((*cells, *ends))} |")
    return "\n".join(lines)


def table(rows: DataFrame) -> str:
    """Work at the threshold over that of the half-space, for each crystal and rung, mean and 95 % interval."""
    lines = ["| crystal | h' | surfaces | " + " | ".join((*CONTINUUM_RUNGS[1:], "atoms", "atoms over lattice")) + " |"]
    lines.append("|---" * (len(CONTINUUM_RUNGS) + 4) + "|")
    for (crystal, slope), part in rows.groupby(["crystal", "slope"], sort=False):
        wide = np.log(part.pivot(index="seed", columns="rung", values="over_energy"))
        cells = [_mean((wide[rung] - wide["half-space"]).to_numpy()) for rung in (*CONTINUUM_RUNGS[1:], "atoms")]
        cells.append(_mean((wide["atoms"] - wide["lattice"]).to_numpy()))
        lines.append(f"| {crystal} | {slope:g} | {len(wide)} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _mean(logarithms: Real) -> str:
    half = t.ppf(0.975, len(logarithms) - 1) * logarithms.std(ddof=1) / np.sqrt(len(logarithms))
    low, mean, high = np.exp(logarithms.mean() + np.array([-half, 0, half]))
    return f"{mean:.3f} ({low:.3f} to {high:.3f})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--into", type=Path, help="find the thresholds anew, into threshold-atoms.csv of this folder")
    parser.add_argument("--n", type=int, default=48, help="surface atoms a side")
    parser.add_argument("--depth", type=float, default=16.0, help="of the slab, in a0")
    parser.add_argument("--slopes", type=float, nargs="+", default=[0.1, 0.05])
    parser.add_argument("--seeds", type=int, nargs="+", default=[11, 12, 13])
    parser.add_argument("--crystals", nargs="+", choices=list(CRYSTALS), default=list(CRYSTALS))
    parser.add_argument("--one-state", action="store_true", help="the thresholds over the estimates from one state")
    given = parser.parse_args()
    if given.one_state:
        sys.stdout.write(one_state_table(of_one_state(read_csv(MEASURED / "threshold-atoms.csv"))) + "\n")
        return
    if given.into:
        found = [measured(given.n, given.depth, slope, given.seeds, given.crystals) for slope in given.slopes]
        rows = DataFrame([row for part in found for row in part.to_dict("records")])
        rows.to_csv(given.into / "threshold-atoms.csv", index=False, float_format="%.6g", lineterminator="\n")
    else:
        rows = read_csv(MEASURED / "threshold-atoms.csv")
    sys.stdout.write(table(rows) + "\n")


if __name__ == "__main__":
    main()
