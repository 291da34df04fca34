"""The README does what it says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def test_the_example_runs_as_printed(tmp_path: Path) -> None:
    """All but the main job, which takes a minute and has tests of its own."""
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert code is not None
    *lines, last = code[1].rstrip().splitlines()
    assert last == 'a.validate("inputs/validate/quick.toml").budget()'
    np.save(tmp_path / "map.npy", np.random.default_rng(1).normal(size=(64, 64)).cumsum(0).cumsum(1))
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", "\n".join(lines)],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    kappa, curve, answer = done.stdout.splitlines()
    assert np.isfinite(float(kappa))
    pull_off, last_kappa = map(float, curve.split())
    assert pull_off > 0 > last_kappa
    assert "The paper's criterion by itself: " in answer
    assert (tmp_path / "contact.png").stat().st_size > 1000
    assert (tmp_path / "results" / "path.h5").is_file()
    assert (tmp_path / "deck" / "in.contact").is_file()


def test_every_room_is_in_the_layout_and_every_picture_exists() -> None:
    house = (ROOT / "docs" / "house.md").read_text()
    for package in ("continuum", "atomistic"):
        for room in (ROOT / package).iterdir():
            if not room.name.startswith("_") and (room.suffix == ".py" or (room / "__init__.py").is_file()):
                assert f"`{room.stem}`" in house, room
    pictures = re.findall(r"\]\((docs/[^)]+)\)", README)
    assert pictures
    for picture in pictures:
        assert (ROOT / picture).is_file(), picture
    assert len(README.splitlines()) <= 150, "what is measured stands on the site"


@pytest.mark.parametrize("path", sorted(set(re.findall(r"inputs/\w+/\w+\.toml", README))))
def test_every_input_named_exists(path: str) -> None:
    assert (ROOT / path).is_file()
