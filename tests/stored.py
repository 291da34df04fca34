"""Stored runs, compared; and runs that are stopped."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from continuum.files import store
from continuum.runs.config import RunConfig
from continuum.runs.record import Point


def content(path: Path) -> dict[str, np.ndarray]:
    """Everything that must be reproducible: all but the journal."""
    file = store.read_datasets(path, RunConfig.result_schema, RunConfig.result_version)
    assert file.attributes["finished"]
    return {n: d.values for n, d in file.datasets.items() if not n.startswith("journal/")}


def same(a: Path, b: Path) -> None:
    one, other = content(a), content(b)
    assert one.keys() == other.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


def stop_after(points: int, error: type[BaseException]) -> Callable[[Point, int, int], None]:
    """A progress that raises after so many points."""

    def progress(point: Point, done: int, total: int) -> None:
        if done == points:
            raise error

    return progress
