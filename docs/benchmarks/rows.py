"""Rows of measurements, each written as soon as it is known, so that a script goes on where it was stopped."""

from __future__ import annotations

import csv
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

__all__ = ["add_row", "rows_of"]


def rows_of(file: Path) -> list[dict[str, str]]:
    """The rows of a file; none if there is no file."""
    return list(csv.DictReader(file.read_text().splitlines())) if file.exists() else []


def add_row(file: Path, row: Mapping[str, Any]) -> None:
    """Write a row below those of a file, and its names above the first; say it, too."""
    fresh = not file.exists()
    with file.open("a", newline="") as out:
        writer = csv.DictWriter(out, list(row), lineterminator="\n")
        if fresh:
            writer.writeheader()
        writer.writerow(row)
    sys.stderr.write(" ".join(map(str, row.values())) + "\n")
