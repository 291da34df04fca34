"""A small run, as an input file; sweeps without processes of their own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import continuum.front.sweeps
from continuum.front.predict import Prediction
from tests.problems import SMALL
from tests.tasks import tasks_here


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """The input file of a run of five points that takes a fraction of a second."""
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture
def unpressed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Predictions press no map: for tests of what is read, and of what is asked."""
    monkeypatch.setattr(Prediction, "no_map", "maps are not pressed here")


@pytest.fixture(autouse=True, scope="session")
def in_this_process() -> Iterator[None]:
    """Sweeps of one worker are done here: a process of their own takes two seconds to start, and says nothing more.

    Sweeps of several workers, clusters, and the tests of the engine have their processes.
    """

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(continuum.front.sweeps, "run_tasks", tasks_here)
        yield
