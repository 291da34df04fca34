"""The README does what it says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.problems import validation_input
from tests.repository.test_docs import continued

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
VALIDATE = validation_input(
    16,
    8.0,
    [2],
    """
[[case]]
name = "plain"
adhesion_length = 0.0
rms_slopes = [0.02, 0.01]
areas = [0.1]

[[case.tolerance]]
quantity = "load"
coefficient = 0.5
power = 1
reason = "of first order in the slope; the coefficient belongs to the surface"
""",
)
"""Two paths, which two processes share, in a few seconds."""


def test_its_ratios_are_the_medians_of_the_benchmarks() -> None:
    rows = re.findall(
        r"^\|.*\| 512² \|.*\| ([\d.]+), [\d.]+ to [\d.]+ \|$", (ROOT / "docs/benchmarks.md").read_text(), re.MULTILINE
    )
    assert rows == re.findall(r"([\d.]+) times less", README)


@pytest.mark.long
def test_the_example_runs_as_printed_in_a_script(tmp_path: Path) -> None:
    """As a file without `if __name__ == "__main__"`, which the processes of a validation must not run again."""
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert code is not None
    assert "__main__" not in code[1]
    (tmp_path / "snippet.py").write_text(code[1])
    # An input of the user's own comes before that of the package, which takes a minute and has tests of its own.
    (tmp_path / "inputs" / "validate").mkdir(parents=True)
    (tmp_path / "inputs" / "validate" / "quick.toml").write_text(VALIDATE)
    done = subprocess.run(
        [sys.executable, "-W", "error", "snippet.py"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    kappa, curve, answer = done.stdout.splitlines()
    assert np.isfinite(float(kappa))
    pull_off, last_kappa = map(float, curve.split())
    assert pull_off > 0 > last_kappa
    shown = re.search(r"```text\n(Sticky: .*?)```", README, re.DOTALL)
    assert shown is not None
    assert answer.split(".  ") == continued(shown[1]).removesuffix(".\n").split(".\n")
    assert (tmp_path / "state.png").stat().st_size > 1000
    assert (tmp_path / "results" / "path.h5").is_file()
    assert (tmp_path / "results" / "quick.h5").is_file()
    assert (tmp_path / "deck" / "in.contact").is_file()


def test_every_picture_exists() -> None:
    pictures = re.findall(r"\]\((docs/[^)]+)\)", README)
    assert pictures
    for picture in pictures:
        assert (ROOT / picture).is_file(), picture
    assert len(README.splitlines()) <= 130, "what is measured stands on the site"


def test_what_a_run_prints_is_what_the_first_page_is_seen_to_print() -> None:
    """tests/repository/test_docs.py follows that page, and compares."""
    (shown,) = re.findall(r"```text\n(before step.*?)```", README, re.DOTALL)
    assert set(shown.splitlines()) <= set((ROOT / "docs" / "start.md").read_text().splitlines())


@pytest.mark.parametrize("path", sorted(set(re.findall(r"inputs/\w+/\w+\.toml", README))))
def test_every_input_named_exists(path: str) -> None:
    assert (ROOT / path).is_file()
