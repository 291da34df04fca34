"""The table of docs/limits.md: what a certificate looks at in a stored run, and what it does not.

``python -m docs.certificate`` makes it anew from a certificate of runs that are made for it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from contextlib import chdir
from dataclasses import fields
from pathlib import Path

import continuum as c
from continuum.inputs.reading import load
from continuum.store import datasets as store
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import Point
from continuum.store.runs.run import follow_run
from continuum.store.sheet import Sheet
from continuum.store.sweeps.measured import ADDED

PAGE = Path(__file__).with_name("limits.md")
BEGIN, END = "<!-- made by python -m docs.certificate -->\n", "<!-- end -->\n"
_RUN = {
    "grid": {"n": 16},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 8.0, "lambda_L": 16.0, "seed": 3},
    "wall": {"law": "table", "path": "table.txt"},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "mean-gap", "targets": [1.2], "event_resolution": 0.01},
    "output": {"fields": True},
    "solver": {"stability": True},
}


def table() -> str:
    """Names of the stored numbers, maps and texts, by what they are of and whether a certificate looks at them."""
    with tempfile.TemporaryDirectory() as name, chdir(name):
        Path("table.txt").write_text("0.5 1.0\n1.0 0.0\n1.5 -0.1\n2.0 0.0\n")
        path = follow_run(load(_RUN, RunConfig), Path(name) / "run.h5", added=ADDED).path
        config = load({**_RUN, "wall": {"law": "hard"}, "solver": {}}, RunConfig)
        hard = follow_run(config, Path(name) / "hard.h5", added=ADDED).path
        looked, left_out, stored = set[str](), set[str](), set[str]()
        for each in (path, hard):
            examined = c.certify(each)
            assert examined.ok, examined.faults
            for one in (*examined.points, *examined.files):
                looked |= {_group(check.quantity) for check in one.checks}
                left_out |= set(one.left_out)
            stored |= {_group(name) for name in store.dataset_names(each)} | {*c.Result.read(each).attributes}
    looked |= {"gap"}  # by its residual
    left_out -= looked
    columns = {one.name for one in fields(Point)} | {"step"}
    attributes = {name for name in stored if name not in columns}
    rows = [
        ("each point", _listed(looked & columns), _listed(left_out & columns)),
        ("maps and fields", _listed(looked & MAPS), _listed(left_out & MAPS)),
        ("the file", _listed((looked & attributes) - MAPS), _listed((left_out - columns) - MAPS)),
    ]
    return Sheet.of("", ("of", "looked at", "not looked at"), rows).markdown() + "\n"


MAPS = {"repulsive", "attracted", "gap", "heights", "imprint"}


def _group(name: str) -> str:
    return name.partition(":")[0].partition("/")[0]


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in sorted(names)) or "–"


def on_page() -> str:
    """The table as it stands on the page."""
    return PAGE.read_text().partition(BEGIN)[2].partition(END)[0]


if __name__ == "__main__":
    before, _, rest = PAGE.read_text().partition(BEGIN)
    PAGE.write_text(f"{before}{BEGIN}{table()}{END}{rest.partition(END)[2]}")
