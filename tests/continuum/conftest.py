"""A small run, as an input file."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.problems import SMALL


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """The input file of a run of five points that takes a fraction of a second."""
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path
