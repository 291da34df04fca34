"""The measured record of the criteria of stickiness, ``continuum/sticky/record.csv``, from the files of sweeps.

Run as ``python -m tests.studies.record FOLDER ...``: sweeps over the work of adhesion at a given range
(``inputs/sweep/who-is-right.toml``) give surfaces with the work at which they turn; those of the paper's law
(``figure4.toml``) give states, sticky or not.  Rows of the record that no sweep has anew stay.
"""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from continuum.files import output
from continuum.runs.collect import Collected, collect
from continuum.show.paper_points import Points
from continuum.sticky.criteria import RoughContact
from continuum.sticky.turns import conformal_energies, load_turns

COLUMNS = (
    "source", "hurst", "lambda_s", "lambda_L", "seed", "rms_height", "rms_slope", "rms_curvature", "conformal_energy",
    "range", "work", "sticky",
)  # fmt: skip
MOMENTS = ("rms_height", "rms_slope", "rms_curvature")


def turned(table: Collected) -> Iterator[dict[str, object]]:
    """Surfaces with the work of adhesion at which attraction and repulsion cancel at 1 % area."""
    for turn in load_turns(table):
        yield {**_surface(turn.settings), **_contact(turn.contact), "source": "turn", "sticky": "turns"}


def states(table: Collected) -> Iterator[dict[str, object]]:
    """Surfaces of the paper's law with the sign of their load where κ is read: with A_rep >= 10 λ_s²."""
    points, energies = Points(table), conformal_energies(table)
    for row in np.flatnonzero(points.reference & (points.length > 0)).tolist():
        key = table.keys[int(table.system[row])]
        contact = RoughContact(
            *(float(points[name][row]) for name in MOMENTS), float(points.length[row]),
            float(points["effective_range"][row]), conformal_energy=energies[key],
        )  # fmt: skip
        settings = {f"surface.{name}": table.setting(key, f"surface.{name}") for name in COLUMNS[1:5]}
        sticky = "yes" if points["load"][row] < 0 else "no"
        yield {**_surface(settings), **_contact(contact), "source": "state", "sticky": sticky}


def _surface(settings: dict[str, object]) -> dict[str, object]:
    return {name: settings[f"surface.{name}"] for name in COLUMNS[1:5]}


def _contact(contact: RoughContact) -> dict[str, object]:
    moments = {name: getattr(contact, name) for name in (*MOMENTS, "conformal_energy", "range")}
    return {**moments, "work": contact.work_of_adhesion}


def _key(row: dict[str, str]) -> tuple[str, ...]:
    """The surface and its law; of a state, the work of adhesion, too.  Moments were stored with six digits."""
    names = ("source", "hurst", "lambda_s", "lambda_L", "seed", "rms_height", "rms_slope", "range")
    numbers = [f"{float(row[name]):.4g}" if name != "source" else row[name] for name in names]
    return (*numbers, f"{float(row['work']):.4g}" if row["source"] == "state" else "")


def main() -> None:
    """Write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path, help="of sweeps")
    parser.add_argument("--record", type=Path, default=Path("continuum/sticky/record.csv"))
    given = parser.parse_args()
    known = {_key(row): row for row in csv.DictReader(given.record.read_text().splitlines())}
    for table in map(collect, given.folders):
        held = table.setting(table.keys[0], "surface.rms_height")  # NaN where slopes are held instead
        for found in turned(table) if held == held else states(table):
            row = {name: f"{v:.6g}" if isinstance(v := found[name], float) else str(v) for name in COLUMNS}
            known[_key(row)] = row
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(known.values())
    output.save(given.record, out.getvalue())


if __name__ == "__main__":
    main()
