"""The README does what it says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def test_the_example_runs_as_printed(tmp_path: Path) -> None:
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert code is not None
    lines = [line for line in code[1].splitlines() if line and not line.startswith(("import", "from"))]
    assert len(lines) <= 10
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code[1]], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    area = re.search(r"area_rep=(?:np\.float64\()?([0-9.e-]+)", done.stdout)
    assert area is not None
    assert 0 < float(area[1]) < 0.5
    assert (tmp_path / "contact.png").stat().st_size > 1000


def test_every_room_is_in_the_layout_and_every_picture_exists() -> None:
    for package in ("continuum", "atomistic"):
        for room in (ROOT / package).iterdir():
            if not room.name.startswith("_") and (room.suffix == ".py" or (room / "__init__.py").is_file()):
                assert f"`{room.stem}`" in README, room
    pictures = re.findall(r"\]\((docs/[^)]+)\)", README)
    assert pictures
    for picture in pictures:
        assert (ROOT / picture).is_file(), picture


@pytest.mark.parametrize("path", sorted(set(re.findall(r"inputs/\w+/\w+\.toml", README))))
def test_every_input_named_exists(path: str) -> None:
    assert (ROOT / path).is_file()
