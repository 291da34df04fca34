"""How much attraction acts from beyond the effective range of a law, which Eqs. (3) and (4) do not count.

`continuum sweep run inputs/sweep/other-potentials.toml --reduced --set output.fields=true`, then
`python -m docs.studies.tails results/other-potentials-reduced`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from pandas import DataFrame

from continuum.runs.result import Result
from continuum.sheet import Sheet
from continuum.sweeps.collect import collect
from continuum.sweeps.folder import Folder
from continuum.theory.paper import ExpectedContact
from docs.studies.tables import keep


def tail_of(result: Result) -> dict[str, str | float]:
    """Of the last point of a run: attraction from beyond the range, and what is within it over what theory says."""
    gap, wall, moments = result.gap(len(result.points) - 1), result.wall, result.moments
    assert gap is not None
    pull = np.clip(-wall.evaluate(gap).traction, 0, None)
    reach, work = wall.effective_range, float(result.attributes["work_of_adhesion"])
    touching = gap < wall.zero_gap
    near = ~touching & (gap < wall.zero_gap + reach)
    expected = ExpectedContact(moments.rms_slope, moments.rms_curvature, reach, work)
    return {
        "law": str(getattr(result.config.wall, "shape", result.config.wall.kind_name)),
        "l_a (a0)": work,
        "share from beyond the range": pull[~near & ~touching].sum() / pull.sum(),
        "area within it over Eq. (4)": near.sum() / touching.sum() * expected.area_ratio,
        "pressure there over w/range": pull[near].mean() / (work / reach),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="of the sweep, with fields")
    folder = parser.parse_args().folder
    results = [Result.read(Folder(folder).point(key)) for key in collect(folder).keys]
    rows = DataFrame([tail_of(result) for result in results if result.points[-1].converged])
    means = rows.round({"l_a (a0)": 6}).groupby(["law", "l_a (a0)"], sort=False).mean().reset_index()
    cells = [
        (law, length, *(f"{value:.2f}" for value in found)) for law, length, *found in means.itertuples(index=False)
    ]
    keep("tails", Sheet.of("Means over surfaces, at 1 % area", list(means), cells))


if __name__ == "__main__":
    main()
