"""Tables of studies as their runs printed them, one CSV a table in ``docs/measured/tables``.

A script keeps what it has found by :func:`keep`; :data:`KEPT` says how the pages show it.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from continuum.store.sheet import Sheet
from docs.studies.judgement import MEASURED

FOLDER = MEASURED / "tables"


def points_of(sweep: str, folder: Path = MEASURED) -> Path:
    """Table of the points of a sweep beside a page of verdicts: the large ones are compressed, which pandas reads."""
    plain = folder / f"paper-{sweep}-points.csv"
    return plain if plain.exists() else plain.with_suffix(".csv.gz")


def keep(name: str, sheet: Sheet) -> None:
    """Print a sheet and keep it, as it is printed, under the name that the page has for it."""
    with (FOLDER / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([sheet.head, *sheet.cells])
    sys.stdout.write(sheet.markdown() + "\n")


def shown(file: Path) -> str:
    """The table of Markdown of a kept one."""
    with file.open(encoding="utf-8", newline="") as opened:
        head, *rows = csv.reader(opened)
    return Sheet.of(file.stem, head, rows).markdown()


QUOTED = ("contacts_of_atoms", "geometry-1", "geometry-2", "geometry-3", "gpu-3")
"""Tables of which pages quote numbers only."""
KEPT = {file.stem: file for file in sorted(FOLDER.glob("*.csv"))}
