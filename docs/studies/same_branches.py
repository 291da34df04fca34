"""Whether two checkouts follow paths on the same branches, at other points of them: for changes of area searches.

    python -m docs.studies.same_branches make FOLDER        in each of the two checkouts
    python -m docs.studies.same_branches compare ONE OTHER  in either

Makes the paths of each input of ``inputs/smoke`` and a sample of the reduced Figure 4, there and back, with areas met
to 0.5 %; a few core minutes.  Two searches stop at other places within their tolerance, so that bits differ.  Judged is
what tells branches apart: how a point ended, its branch, and the part of the contact that has snapped in one of the two
states only, which is where the gaps differ by more than half the range of the attraction.

Written down before the first comparison: no point may end otherwise, and of no state may more than 2 % of the contact
have snapped in one of the two alone, the tolerances of both searches twice.  What exceeds this is listed.  Numbers of
the inputs agree to 2 % of themselves; a load is a difference, and compares with both its parts.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from continuum.path.equilibrium import solver_of
from continuum.path.loading import follow
from continuum.path.state import Search
from continuum.solve.solution import Settings
from docs.studies.same_bits import main
from tests.problems import Rough

SYSTEMS = [
    # l_a, λ_s, H, h'rms, seed
    (0.0, 8.0, 0.8, 0.1, 1),
    (0.005, 4.0, 0.8, 0.1, 1),
    (0.005, 16.0, 0.3, 0.3, 2),
    (0.05, 4.0, 0.8, 0.1, 1),
    (0.05, 8.0, 0.5, 0.3, 2),
    (0.05, 16.0, 0.8, 0.1, 2),
    (0.05, 32.0, 0.8, 0.1, 1),
]
"""Of the reduced Figure 4: 512² points, λ_L = 256 a0."""
TARGETS = (0.01, 0.02, 0.04, 0.08, 0.16, 0.08, 0.02)
TOLERANCE, SNAPPED = 0.005, 0.02
"""Of each area, and the largest part of the contact that may have snapped in one of two states only."""
NUMBERS = ("mean_gap", "area_rep", "load")


def make(folder: Path) -> None:
    """Paths of this checkout."""
    folder.mkdir(parents=True)
    for file in sorted(Path("inputs/smoke").glob("*.toml")):
        run = [sys.executable, "-m", "continuum", "run", str(file), "-o", str(folder / "smoke")]
        subprocess.run(run, stdout=subprocess.DEVNULL, check=True)
    for number, (length, shortest, hurst, slope, seed) in enumerate(SYSTEMS):
        rough = Rough(512, length, shortest, seed, slope, hurst, 256.0)
        problem, settings = rough.problem(), Settings(1e-5 * slope)
        states = follow(
            problem, "repulsive-area", TARGETS, settings, search=Search(TOLERANCE), solver=solver_of(problem, settings)
        )
        for point, state in enumerate(states):
            np.savez(
                folder / f"{number}-{point}.npz",
                gap=np.float32(state.gap), status=state.status.name, branch=state.branch, mean_gap=state.mean_gap,
                area_rep=state.area_rep, load=state.load, range=problem.wall.range,
                pairs=state.search_pairs + state.solution.fft_pairs,
            )  # fmt: skip
        sys.stderr.write(f"{rough}\n")


def differences(one: Path, other: Path) -> Iterator[str]:
    """What is not the same in two folders of paths, a line each."""
    for path in sorted(one.glob("*.npz")):
        a, b = np.load(path), np.load(other / path.name)
        if a["status"] != b["status"] or a["branch"] != b["branch"]:
            yield f"{path.stem}: {a['status']} on {a['branch']}, and {b['status']} on {b['branch']}"
        snapped = np.abs(a["gap"] - b["gap"] - (a["mean_gap"] - b["mean_gap"])) > max(a["range"], 0.2) / 2
        near = np.minimum(a["gap"], b["gap"]) < 1 + a["range"]
        part = float(np.mean(snapped & near)) / float(a["area_rep"])
        numbers = ", ".join(f"{name} {float(a[name]):.5g} and {float(b[name]):.5g}" for name in NUMBERS)
        line = f"{path.stem}: {part:.2%} snapped in one only, {numbers}, pairs {a['pairs']:.0f} and {b['pairs']:.0f}"
        sys.stderr.write(f"{line}\n")
        if part > SNAPPED:
            yield line
    for path in sorted((one / "smoke").glob("*.h5")):
        with h5py.File(path) as a, h5py.File(other / "smoke" / path.name) as b:
            for name in ("status", "branch", "control", "target", "events/kind", "events/branch"):
                if name in a and not np.array_equal(a[name][()], b[name][()]):
                    yield f"{path.name}: {name} {a[name][()]} and {b[name][()]}"
            for name in NUMBERS:
                one_has, other_has = a[name][()], b[name][()]
                parts = a["load_rep"][()] + a["load_att"][()]
                size = parts if name == "load" else np.nan_to_num(np.abs(one_has), posinf=0.0)
                if not np.allclose(one_has, other_has, rtol=1e-12, atol=0.02 * size + 1e-6, equal_nan=True):
                    yield f"{path.name}: {name} {a[name][()]} and {b[name][()]}"


if __name__ == "__main__":
    main(__doc__, make, differences)
