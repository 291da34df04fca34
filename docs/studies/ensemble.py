"""The ensemble behind bounds that carry over, ``atomistic/ladder/ensemble.csv``, and its judgement by other metals.

``python -m docs.studies.ensemble`` runs eight surfaces on springs and on three metals, some ten minutes on one core,
and writes the file.  ``python -m docs.studies.ensemble --judge`` then runs four other surfaces on gold and on silver
(``inputs/validate/gold.toml`` and ``silver.toml``), which are in no bound, and prints the verdicts.  Expected, written
on 23 November 2026 before the first run of either: all bounds hold on both metals.  A metal that is like the three has
the largest coefficient of four with a probability of 1/4, and then still lies mostly below the limit over surfaces.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import atomistic as a
from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import ensemble
from atomistic.ladder.comparison import STEPS
from atomistic.ladder.ensemble import Row
from continuum.inputs.reading import load
from continuum.store.sheet import Column, Entry, Sheet

POTENTIALS = ("Cu_mishin1.eam.alloy", "Ni_u3.eam", "Al_zhou.eam.alloy")
LENNARD_JONES = "lennard-jones"
JUDGED = ("gold", "silver", ensemble.SPRINGS)
OTHERS = (301, 302, 303)
"""Surfaces on the slab of ``quick.toml`` that were not run before the limits of all steps were written down."""
FILE = Path(ensemble.__file__).with_name("ensemble.csv")
Case = tuple[float, tuple[float, ...], tuple[float, ...]]
"""Adhesion length in a0, rms slopes, areas."""


class Family(NamedTuple):
    """Surfaces that are pressed on slabs of one depth."""

    seeds: tuple[int, ...]
    depth: float
    """In λ_s."""
    cases: tuple[Case, ...]
    branches: tuple[str, ...] = ("approach",)
    """With adhesion; without it there is one."""


CRYSTALS = Family(tuple(range(101, 109)), 2.0, ((0.0, (0.1, 0.01), (0.1, 0.25)), (0.005, (0.1,), (0.1, 0.25))))
DEEP = Family(
    tuple(range(201, 217)),
    4.0,
    (
        (0.0, (0.1, 0.03, 0.01), (0.035, 0.1, 0.25)),
        (0.0005, (0.1, 0.05), (0.1, 0.25)),
        (0.005, (0.1, 0.05), (0.1, 0.25)),
    ),
)
"""As in ``inputs/validate/quick.toml``."""
DEEP_CRYSTALS = Family(
    tuple(range(111, 119)),
    4.0,
    ((0.0, (0.1, 0.001), (0.035, 0.1, 0.25)), (0.005, (0.1,), (0.1, 0.25))),
    ("approach", "retract"),
)
"""As in the inputs of metals and of Lennard-Jones."""


def text(crystal: str, family: Family) -> str:
    """The input of a crystal."""
    kind = f'kind = "eam"\nfile = "{crystal}"' if crystal in POTENTIALS else f'kind = "{crystal}"'
    s = ensemble.LAMBDA_S
    parts = [
        f"[interatomic]\n{kind}\n[slab]\nn = {round(ensemble.PERIOD * s)}\ndepth = {family.depth * s}",
        f"[surface]\nhurst = {ensemble.HURST}\nlambda_s = {s}\nlambda_L = {ensemble.ROLL_OFF * s}",
        f"seeds = {list(family.seeds)}",
    ]
    for i, (length, slopes, areas) in enumerate(family.cases):
        parts.append(f'[[case]]\nname = "case{i}"\nadhesion_length = {length}')
        parts.append(f"rms_slopes = {list(slopes)}\nareas = {list(areas)}")
        parts.append(f"branches = {list(family.branches)}" if length > 0 else "")
    return "\n".join(parts) + "\n"


def states(crystal: str, family: Family) -> list[Row]:
    """The differences in each state of a crystal."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "ensemble.toml")
        path.write_text(text(crystal, family), encoding="utf-8")
        columns = a.validate(load(path, ValidateConfig), folder, workers=1, force=True).stored.columns
    found = list[Row]()
    for i, branch in enumerate(columns["branch"]):
        place = (columns[name][i].item() for name in ("adhesion_length", "seed", "rms_slope", "area"))
        last = (abs(columns[f"nonlinearity_{name}"][i].item()) for name in ("load", "gross_load", "displacement"))
        linear = (abs(columns[f"{step}_gross_load"][i].item()) for step in STEPS if step != "nonlinearity")
        values: list[Any] = [crystal, family.depth, *place, str(branch), *last, *linear]
        found.append(Row(*values))
    sys.stdout.write(f"{crystal}: {len(found)} states, {time.perf_counter() - began:.0f} s here\n")
    sys.stdout.flush()
    return found


def run(family: Family, crystals: Sequence[str]) -> None:
    """Write the file, with one family of some crystals anew; its cases of other adhesion lengths are kept."""
    lengths = [length for length, *_ in family.cases]

    def again(row: Row) -> bool:
        return row.seed in family.seeds and row.crystal in crystals and row.adhesion_length in lengths

    kept = [row for row in ensemble.rows() if not again(row)]
    new = [states(crystal, family) for crystal in crystals]
    found = sorted((*kept, *itertools.chain(*new)), key=lambda row: row.seed in DEEP.seeds + DEEP_CRYSTALS.seeds)
    with FILE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(Row._fields)
        writer.writerows([value if isinstance(value, str) else f"{value:.6g}" for value in row] for row in found)


def limits() -> str:
    """Smallest and largest difference of each linear step over the surfaces of a family, and a limit."""
    families: dict[tuple[str, float, float], dict[str, dict[int, dict[str, float]]]] = {}
    for row in ensemble.rows():
        kind = row.crystal if row.crystal in ensemble.ALONE else "metals"
        of = families.setdefault((kind, row.depth, row.adhesion_length), {}).setdefault(row.crystal, {})
        worst = of.setdefault(row.seed, dict.fromkeys(ensemble.LINEAR, 0.0))
        for step in ensemble.LINEAR:
            worst[step] = max(worst[step], float(getattr(row, f"{step}_gross_load")))
    rows: list[tuple[Entry, ...]] = []
    for (kind, depth, length), crystals in families.items():
        cells = []
        for step in ensemble.LINEAR:
            found = {name: {seed: worst[step] for seed, worst in of.items()} for name, of in crystals.items()}
            every = [100 * value for of in found.values() for value in of.values()]
            most = 100 * ensemble.limit(found, 3, logarithms=False)[0]
            cells.append(f"{min(every):.2g} - {max(every):.2g}, {most:.2g}")
        rows.append((kind, f"{depth * ensemble.LAMBDA_S:g}", f"{length:g}", *cells))
    head = (Column("crystals"), Column("depth (a0)"), Column("l_a (a0)"), *map(Column, ensemble.LINEAR))
    return Sheet.of("limits", head, rows).markdown()


def judge(names: Sequence[str]) -> None:
    """The verdicts on metals that are in no bound, and on further surfaces of springs."""
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            file: str | Path = f"inputs/validate/{name}.toml"
            if name == ensemble.SPRINGS:
                file = Path(folder, f"{name}.toml")
                file.write_text(text(name, DEEP._replace(seeds=OTHERS)), encoding="utf-8")
            found = a.validate(file, folder, workers=1)
        sys.stdout.write(f"{name}: {found.sentence}\n{found.sheets()[-1].text()}\n")
        sys.stdout.flush()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--judge", nargs="*", choices=JUDGED, help="run metals that are in no bound; all if none is named"
    )
    parser.add_argument("--deep", action="store_true", help="run the surfaces on deep springs only")
    parser.add_argument(
        "--crystals", nargs="+", choices=(*POTENTIALS, LENNARD_JONES), help="run the surfaces on deep slabs of these"
    )
    parser.add_argument("--adhesion-length", type=float, help="of these, the states of this adhesion length only")
    given = parser.parse_args()
    if given.judge is None:
        if given.crystals:
            length = given.adhesion_length
            cases = tuple(case for case in DEEP_CRYSTALS.cases if length in (None, case[0]))
            run(DEEP_CRYSTALS._replace(cases=cases), given.crystals)
        elif given.deep:
            run(DEEP, (ensemble.SPRINGS,))
        else:
            run(CRYSTALS, (ensemble.SPRINGS, *POTENTIALS))
    else:
        judge(given.judge or JUDGED)


if __name__ == "__main__":
    main()
