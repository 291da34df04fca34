"""How well the first systems of a sweep tell the time of all.

``python -m docs.benchmarks.pace FOLDER ...`` draws some of the finished systems of each folder on one grid at random,
many times: is the mean of all within the range that they give?  ``python -m docs.benchmarks.pace told NAME ...`` runs
shipped sweeps with ``--reduced`` and compares each range that is printed on the way with what the other systems then
took.  Both by wall time, and by transforms, which no other program disturbs.  The rows are kept in ``pace.csv`` and
``told.csv`` of ``docs/measured/tables``, which docs/studies/sweeps.md shows.
"""

from __future__ import annotations

import csv
import math
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import continuum as c
from continuum.model.fourier import Real
from continuum.store import datasets as store
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.listing import systems_of
from continuum.store.sweeps.status import SystemTime, effort_of, expected, range_factor
from continuum.store.sweeps.workers import TaskResult

__all__ = ["KEPT", "main"]

TABLES = Path(__file__).parents[1] / "measured" / "tables"
KEPT, TOLD = TABLES / "pace.csv", TABLES / "told.csv"
TOLD_HEAD = ("sweep", "systems", "by", "first range over what the others took", "holds it", "later ranges", "hold it")
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


def told(name: str, output: Path) -> dict[str, list[SystemTime]]:
    """The systems of a shipped sweep as they end: by their wall time, and by their transforms on points of the grid."""
    found = dict[str, list[SystemTime]](time=[], transforms=[])

    def ended(one: TaskResult, done: int, total: int) -> None:
        task = one.task
        counts, _ = store.read_few(task.path, ("fft_pairs", "search_pairs"), ())
        pairs = counts["fft_pairs"] + counts["search_pairs"]
        found["time"].append(SystemTime(task.kind, task.cost, one.seconds, one.first))
        found["transforms"].append(SystemTime(task.kind, task.cost, float(pairs.mean()) * task.cost))

    c.sweep(f"inputs/sweep/{name}.toml", output, reduced=True, progress=ended)
    return found


def told_row(name: str, by: str, ended: list[SystemTime]) -> tuple[str, ...]:
    """The first range that is told and all later ones, each against what the other systems took."""
    judged = list[tuple[float, float, float]]()
    for i in range(1, len(ended)):
        span = expected(ended[:i], effort_of((one.kind, one.effort) for one in ended[i:]))
        if span is not None:
            rest = math.fsum(one.seconds for one in ended[i:])
            judged.append((span.low / rest, span.high / rest, float(span.low <= rest <= span.high)))
    (low, high, within), *later = judged
    right = f"{100 * float(np.mean([one[2] for one in later])):.0f} %" if later else ""
    return name, str(len(ended)), by, f"{low:.2g} to {high:.2g}", "yes" if within else "no", str(len(later)), right


def _keep(path: Path, head: tuple[str, ...], found: dict[str, tuple[str, ...]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([head, *found.values()])


def judge_told(names: list[str]) -> None:
    """Run these sweeps, and keep the rows of each beside those that were judged before."""
    kept = dict[str, tuple[str, ...]]()
    if TOLD.exists():
        with TOLD.open(newline="", encoding="utf-8") as file:
            kept = {f"{row[0]} by {row[2]}": tuple(row) for row in list(csv.reader(file))[1:]}
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            kept |= {f"{name} by {by}": told_row(name, by, ended) for by, ended in told(name, Path(folder)).items()}
        _keep(TOLD, TOLD_HEAD, kept)


def main(names: list[str]) -> None:
    """Judge sweeps in folders, or what is told of shipped ones, and keep the rows."""
    if names[:1] == ["told"]:
        judge_told(names[1:])
        return
    _keep(KEPT, HEAD, {str(i): row for i, row in enumerate(rows([Path(name) for name in names]))})


if __name__ == "__main__":
    main(sys.argv[1:])
