"""How well the first systems of a sweep tell the time of all: ``python -m docs.benchmarks.pace FOLDER ...``.

Of the finished systems of each folder on one grid some are drawn at random, many times: is the mean of all within the
range that they give?  By their wall time, and by their transforms, which no other program disturbs.  The rows are kept
in ``docs/measured/tables/pace.csv``, which docs/studies/sweeps.md shows.
"""

from __future__ import annotations

import csv
import math
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from continuum.model.fourier import Real
from continuum.store import datasets as store
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.listing import systems_of
from continuum.store.sweeps.pace import range_factor

__all__ = ["KEPT", "main"]

KEPT = Path(__file__).parents[1] / "measured" / "tables" / "pace.csv"
DRAWN = (1, 2, 5, 10)
HEAD = ("sweep", "systems", "by", "longest over mean", *(f"n = {drawn}" for drawn in DRAWN))
_DRAWS = 2000
_TIME, _FIRST = "journal/total_seconds", "journal/first_of_process"


def rates(root: Path) -> dict[str, Real]:
    """Seconds and transforms for each state of the finished systems on each grid, without the first of a process."""
    folder, found = Folder(root), defaultdict[str, list[tuple[float, float]]](list)
    for one in systems_of(root).systems:
        path = folder.point(one.key)
        if path.is_file():
            counts, said = store.read_few(path, ("fft_pairs", "search_pairs"), (_TIME, _FIRST))
            pairs = counts["fft_pairs"] + counts["search_pairs"]
            if not said.get(_FIRST):
                found[one.kind].append((float(said[_TIME]) / len(pairs), float(pairs.mean())))
    return {kind: np.array(values).T for kind, values in found.items()}


def within(values: Real, drawn: int) -> float:
    """Share of the draws of so many systems whose range holds the mean of all; NaN of too few systems."""
    if len(values) <= drawn:
        return math.nan
    rng = np.random.default_rng(1)
    draws = [rng.choice(values, drawn, replace=False) for _ in range(_DRAWS)]
    return float(np.mean([abs(math.log(one.mean() / values.mean())) <= math.log(range_factor(one)) for one in draws]))


def rows(roots: list[Path]) -> Iterator[tuple[str, ...]]:
    """Two rows for each sweep and grid of five systems or more."""
    for root in roots:
        for values in rates(root).values():
            for by, each in zip(("time", "transforms"), values, strict=True):
                if len(each) >= 5:
                    shares = (within(each, drawn) for drawn in DRAWN)
                    said = ("" if math.isnan(share) else f"{100 * share:.0f} %" for share in shares)
                    spread = f"{each.max() / each.mean():.1f}"
                    yield (root.name.removesuffix("-reduced"), str(len(each)), by, spread, *said)


def main(names: list[str]) -> None:
    """Judge the sweeps in these folders, and keep the rows."""
    with KEPT.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([HEAD, *rows([Path(name) for name in names])])


if __name__ == "__main__":
    main(sys.argv[1:])
