"""The ensemble behind bounds that carry over, ``atomistic/ladder/ensemble.csv``, and its judgement by other metals.

``python -m tests.studies.ensemble`` runs eight surfaces on springs and on three metals, some ten minutes on one core,
and writes the file.  ``python -m tests.studies.ensemble --judge`` then runs four other surfaces on gold and on silver
(``inputs/validate/gold.toml`` and ``silver.toml``), which are in no bound, and prints the verdicts.  Expected, written
on 23 November 2026 before the first run of either: all bounds hold on both metals.  A metal that is like the three has
the largest coefficient of four with a probability of 1/4, and then still lies mostly below the limit over surfaces.
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import atomistic as a
from atomistic.config.validate import ValidateConfig
from atomistic.ladder import ensemble
from atomistic.ladder.ensemble import Row
from continuum.files.inputs import load

POTENTIALS = ("Cu_mishin1.eam.alloy", "Ni_u3.eam", "Al_zhou.eam.alloy")
JUDGED = ("gold", "silver")
SEEDS = tuple(range(101, 109))
FILE = Path(ensemble.__file__).with_name("ensemble.csv")


def text(crystal: str) -> str:
    """The input of a crystal: without adhesion at two slopes, with it at one."""
    kind = 'kind = "springs"' if crystal == ensemble.SPRINGS else f'kind = "eam"\nfile = "{crystal}"'
    s = ensemble.LAMBDA_S
    parts = [
        f"[interatomic]\n{kind}\n[slab]\nn = {round(ensemble.PERIOD * s)}\ndepth = {ensemble.DEPTH * s}",
        f"[surface]\nhurst = {ensemble.HURST}\nlambda_s = {s}\nlambda_L = {ensemble.ROLL_OFF * s}",
        f"seeds = {list(SEEDS)}",
    ]
    for name, length, slopes in (
        ("plain", 0.0, ensemble.PLAIN_SLOPES),
        ("sticky", ensemble.ADHESION_LENGTH, (ensemble.STICKY_SLOPE,)),
    ):
        parts.append(f'[[case]]\nname = "{name}"\nadhesion_length = {length}')
        parts.append(f"rms_slopes = {list(slopes)}\nareas = {list(ensemble.AREAS)}")
    return "\n".join(parts) + "\n"


def states(crystal: str, folder: Path) -> list[Row]:
    """The differences in each state of a crystal."""
    path = folder / "ensemble.toml"
    path.write_text(text(crystal), encoding="utf-8")
    columns = a.validate(load(path, ValidateConfig), folder, workers=1, force=True).stored.columns
    return [
        Row(
            crystal,
            *(columns[name][i].item() for name in ("adhesion_length", "seed", "rms_slope", "area")),
            *(abs(columns[f"nonlinearity_{name}"][i].item()) for name in ("load", "gross_load", "displacement")),
        )
        for i in range(len(columns["case"]))
    ]


def run() -> None:
    """Write the file, crystal by crystal."""
    found: list[Row] = []
    for crystal in (ensemble.SPRINGS, *POTENTIALS):
        began = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            found += states(crystal, Path(folder))
        sys.stdout.write(f"{crystal}: {len(found)} states, {time.perf_counter() - began:.0f} s here\n")
        sys.stdout.flush()
        with FILE.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(Row._fields)
            writer.writerows([*row[:3], *(f"{value:.6g}" for value in row[3:])] for row in found)


def judge(names: Sequence[str]) -> None:
    """The verdicts on metals that are in no bound."""
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            found = a.validate(f"inputs/validate/{name}.toml", folder, workers=1)
        sys.stdout.write(f"{name}: {found.sentence}\n{found.sheets()[-1].text()}\n")
        sys.stdout.flush()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--judge", nargs="*", choices=JUDGED, help="run metals that are in no bound; all if none is named"
    )
    names = parser.parse_args().judge
    run() if names is None else judge(names or JUDGED)


if __name__ == "__main__":
    main()
