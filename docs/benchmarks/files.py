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
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from multiprocessing import get_context
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
HEAD = ("what", "before", "required", "measured")
BEFORE = {
    "32², one point: bytes of its file": ("49558", "26000"),
    "CPU time of `press`": ("11 ms", ""),
    "CPU time of `c.run`": ("58 to 72 ms", ""),
    "ratio": ("6, by this script 4.0", "3"),
    "maps of 60 systems as one dataset, CPU time a file": ("170 to 200 ms", "3 ms"),
    "`Result.to_xarray` with a map read, a file": ("170 to 200 ms", ""),
    "20000 systems: listed the first time": ("14 s", "1 s"),
    "20000 systems: listing read": ("", "1 s"),
    "20000 systems: `collect` with its tables": ("62 s", ""),
    "20000 systems: `collect` again with its tables": ("62 s", "reads only what is new"),
    "`verify` of whole files, CPU time a file": ("50 ms", ""),
}
"""What was found before, on another machine, and what was asked for."""
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
        press.append(_cpu(lambda contact=contact: contact.press(area=0.05)))
        path = folder / f"{seed}.h5"
        run.append(_cpu(lambda seed=seed, path=path: c.run(ONE, path, settings={"surface.seed": seed})))
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


def _asked(call: Callable[..., object], *given: object) -> tuple[float, float]:
    import_module("xarray")  # loading it is not measured
    return _cpu(lambda: call(*given)), peak()


def _apart(call: Callable[..., object], *given: object) -> tuple[float, float]:
    """CPU time of a call in a process of its own, in s, and the largest memory of that process, in MiB."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        return process.submit(_asked, call, *given).result()


def _begin(root: Path, systems: int) -> None:
    begin(Sweep.read({**ONE, "sweep": {"axes": {"surface.seed": list(range(systems))}}}), root)


def scale(folder: Path, systems: int = 20_000, *, collected: bool = True) -> Rows:
    """Listing, status and collections of a folder of many systems by stub files, each in its own process."""
    asked: list[tuple[str, Callable[..., object], tuple[object, ...]]] = [
        ("listed the first time", _begin, (folder / f"listed-{systems}", systems))
    ]
    root = stubs(folder, systems)
    asked += [("listing read", systems_of, (root,)), ("status", c.sweep_status, (root,))]
    if collected:
        asked += [(f"`collect`{again} with its tables", c.sweep_collect, (root,)) for again in ("", " again")]
    rows = []
    for what, call, given in asked:
        seconds, memory = _apart(call, *given)
        rows.append((f"{systems} systems: {what}", f"{seconds:.2f} s, {memory:.0f} MiB"))
    return rows


def large(folder: Path) -> Rows:
    """The same of more."""
    return scale(folder, 100_000)


def million(folder: Path) -> Rows:
    """The same of a million, without collections, which take half an hour of a core."""
    return scale(folder, 1_000_000, collected=False)


def verify(folder: Path) -> Rows:
    """Verification of whole files: time of each, and memory, which does not grow with their number."""
    small = {**ONE, "grid": {"n": 16}, "surface": {**ONE["surface"], "lambda_L": 16.0}}
    done = [
        c.sweep({**small, "sweep": {"axes": {"surface.seed": list(range(count))}}}, folder, name=f"of-{count}")
        for count in (50, 200)
    ]
    (_, few), (seconds, many) = (_apart(c.sweep_verify, one.folder) for one in done)
    return [
        ("`verify` of whole files, CPU time a file", f"{1e3 * seconds / 200:.1f} ms"),
        ("largest memory of `verify`, of 50 files and of 200", f"{few:.1f} and {many:.1f} MiB"),
    ]


MEASURED: dict[str, Callable[[Path], Rows]] = {
    "thin": thin, "maps": maps, "scale": scale, "large": large, "million": million, "verify": verify
}  # fmt: skip


def main(names: list[str]) -> None:
    """Measure what is named, or all, and keep it in place of what was measured of it before."""
    with KEPT.open(newline="", encoding="utf-8") as file:
        kept = {row[0]: row[-1] for row in list(csv.reader(file))[1:]}
    for name in names or [name for name in MEASURED if name != "million"]:
        with tempfile.TemporaryDirectory() as folder:
            kept |= dict(MEASURED[name](Path(folder)))
    with KEPT.open("w", newline="", encoding="utf-8") as file:
        rows = ((what, *BEFORE.get(what, ("", "")), measured) for what, measured in kept.items())
        csv.writer(file, lineterminator="\n").writerows([HEAD, *rows])


if __name__ == "__main__":
    main(sys.argv[1:])
