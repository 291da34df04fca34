"""What storing costs: ``python -m docs.benchmarks.files [NAME ...]`` measures what is named, or all but a million.

The rows are kept in ``docs/measured/tables/files.csv``, which docs/studies/sweeps.md shows.

Counts, bytes and ratios of CPU time hold on any machine; seconds are those of this one, on one thread.
"""

from __future__ import annotations

import csv
import hashlib
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import h5py
import numpy as np

import continuum as c
from continuum.inputs.reading import load
from continuum.store.runs.build import build
from continuum.store.runs.config import RunConfig
from continuum.store.sweeps.axes import Axis, Sweep, System
from continuum.store.sweeps.collect import collect
from continuum.store.sweeps.folder import Folder
from continuum.store.sweeps.listing import SweepListing, listing_text, systems_of
from continuum.store.sweeps.measured import COLUMNS
from continuum.store.sweeps.sweep import begin
from docs.benchmarks.job import peak

__all__ = ["MEASURED", "ONE"]

Rows = list[tuple[str, str]]
KEPT = Path(__file__).parents[1] / "measured" / "tables" / "files.csv"
ONE: dict[str, Any] = {
    "grid": {"n": 32},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 32.0, "seed": 1},
    "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.005},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "repulsive-area", "targets": [0.05]},
}
"""One point of a small grid, of which storing is the largest part."""
_TURNS = 20
_FILES = 60


def _cpu(call: Callable[[], object]) -> float:
    began = time.process_time()
    call()
    return time.process_time() - began


def thin(folder: Path) -> Rows:
    """One point on 32²: bytes of its file, and CPU time of the whole run over that of its solve."""
    c.run(ONE, folder / "warm.h5")  # compiled code is loaded
    press, run = [], []
    for seed in range(1, _TURNS + 1):
        system = build(load(ONE, RunConfig, {"surface.seed": seed}))
        contact = c.Contact(system.problem.heights, system.problem.wall)
        press.append(_cpu(lambda contact=contact: contact.press(area=0.05)))  # type: ignore[misc]
        path = folder / f"{seed}.h5"
        run.append(_cpu(lambda seed=seed, path=path: c.run(ONE, path, settings={"surface.seed": seed})))  # type: ignore[misc]
    return [
        ("32², one point: bytes of its file", f"{path.stat().st_size}"),
        ("CPU time of `press`", f"{1e3 * median(press):.1f} ms"),
        ("CPU time of `c.run`", f"{1e3 * median(run):.1f} ms"),
        ("ratio", f"{median(run) / median(press):.1f}"),
    ]


def maps(folder: Path) -> Rows:
    """Maps of a sweep, from copies of one file: per file, as one dataset, read whole, and each opened by itself."""
    done = c.sweep({**ONE, "sweep": {"axes": {"surface.seed": list(range(1, _FILES + 1))}}}, folder)
    results = [c.Result.read(path) for path in sorted((done.folder / "points").iterdir())]
    c.sweep_maps(done.folder)  # xarray is imported
    opened = _cpu(lambda: c.sweep_maps(done.folder))
    read = _cpu(lambda: c.sweep_maps(done.folder)["repulsive"].load())
    each = _cpu(lambda: [result.to_xarray()["repulsive"].load() for result in results])
    return [
        (f"maps of {_FILES} systems as one dataset, CPU time a file", f"{1e3 * opened / _FILES:.2f} ms"),
        ("with one map of each read", f"{1e3 * read / _FILES:.2f} ms"),
        ("`Result.to_xarray` with a map read, a file", f"{1e3 * each / _FILES:.2f} ms"),
    ]


def stubs(folder: Path, systems: int) -> Path:
    """The folder of a sweep of so many systems, whose files hold only what a collection reads."""
    root, values = folder / f"stubs-{systems}", [(seed,) for seed in range(systems)]
    keys = [hashlib.sha256(str(seed).encode()).hexdigest() for seed in range(systems)]
    places = Folder(root)
    places.make()
    listed = tuple(System(key, {"surface.seed": seed}, 1.0, 1.0) for seed, key in enumerate(keys))
    places.listing.write_text(
        listing_text(SweepListing("stubs", (Axis(("surface.seed",), tuple(values)),), {}, listed))
    )
    first = places.point(keys[0])
    with h5py.File(first, "w", libver=("v110", "v110")) as file:
        file.attrs.update(schema=RunConfig.result_schema, schema_version=RunConfig.result_version, identity=keys[0])
        file.attrs.update(finished=np.uint8(1))
        file["journal/written"] = "now"
        file["journal"].attrs["total_seconds"] = 1.0
        file["measured"], file["quantity"] = np.ones((1, len(COLUMNS))), list(COLUMNS)
    whole = first.read_bytes()
    before, after = whole.split(keys[0].encode())  # the identity stands in it once
    for key in keys[1:]:
        places.point(key).write_bytes(before + key.encode() + after)
    return root


def scale(folder: Path, systems: int = 20_000, *, collected: bool = True) -> Rows:
    """Listing, status and collections of a folder of many systems, by stub files."""
    described = Sweep.read({**ONE, "sweep": {"axes": {"surface.seed": list(range(systems))}}})
    listed = _cpu(lambda: begin(described, folder / f"listed-{systems}"))
    root = stubs(folder, systems)
    rows = [(f"{systems} systems: listed the first time, CPU time", f"{listed:.2f} s")]
    for what, call in (
        ("listing read", lambda: systems_of(root)),
        ("status", lambda: c.sweep_status(root)),
        *((what, lambda: collect(root, keep=True)) for what in ("`collect`", "`collect` again") if collected),
    ):
        rows.append((f"{systems} systems: {what}, CPU time", f"{_cpu(call):.2f} s"))
    return [*rows, (f"{systems} systems: largest memory", f"{peak():.0f} MiB")]


def large(folder: Path) -> Rows:
    """The same of more, without collections, which take minutes of a core."""
    return scale(folder, 100_000, collected=False)


def million(folder: Path) -> Rows:
    """The same of a million, whose files take minutes to write."""
    return scale(folder, 1_000_000, collected=False)


def verify(folder: Path) -> Rows:
    """Verification of whole files: time of each, and memory, which does not grow with their number."""
    small = {**ONE, "grid": {"n": 16}, "surface": {**ONE["surface"], "lambda_L": 16.0}}
    done = [
        c.sweep({**small, "sweep": {"axes": {"surface.seed": list(range(count))}}}, folder, name=f"of-{count}")
        for count in (50, 200)
    ]
    c.sweep_verify(done[0].folder)
    few = peak()
    seconds = _cpu(lambda: c.sweep_verify(done[1].folder))
    return [
        ("`verify` of whole files, CPU time a file", f"{1e3 * seconds / 200:.1f} ms"),
        ("largest memory after 50 files, and after 200 more", f"{few:.1f} and {peak():.1f} MiB"),
    ]


MEASURED: dict[str, Callable[[Path], Rows]] = {
    "thin": thin, "maps": maps, "scale": scale, "large": large, "million": million, "verify": verify
}  # fmt: skip


def main(names: list[str]) -> None:
    """Measure what is named, or all, and keep it in place of what was measured of it before."""
    with KEPT.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    kept = dict(rows)
    for name in names or [name for name in MEASURED if name != "million"]:
        with tempfile.TemporaryDirectory() as folder:
            kept |= dict(MEASURED[name](Path(folder)))
    with KEPT.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([head, *kept.items()])


if __name__ == "__main__":
    main(sys.argv[1:])
