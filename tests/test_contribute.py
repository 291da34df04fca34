"""What docs/contribute.md adds is one file, on a copy of the source: no list is touched; tests of all kinds run it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/contribute.md").read_text(encoding="utf-8")


def copied(tmp_path: Path, room: str) -> Path:
    """The source with one room whose files may be added to; all others are links, with what is compiled of them."""
    place = tmp_path
    for part in (None, *Path(room).parts):
        here = place if part is None else place / part
        of = ROOT / here.relative_to(tmp_path)
        here.mkdir(exist_ok=True)
        for found in of.iterdir():
            if found.name != next(iter(Path(room).relative_to(here.relative_to(tmp_path)).parts), None):
                (here / found.name).symlink_to(found)
        place = here
    return place


def source_of(name: str) -> str:
    """The class of a page with the imports above it, as a module."""
    (block,) = (code for code in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if f"class {name}(" in code)
    imports = "\n".join(re.findall(r"^(?:from|import) .*$", block, re.MULTILINE)).replace("import continuum as c\n", "")
    (body,) = re.findall(rf"^class {name}\(.*?(?=^\S)", block + "end", re.DOTALL | re.MULTILINE)
    return f'"""An exercise."""\n\n{imports}\n\n\n{body.rstrip()}\n'


def run_in(copy: Path, *command: str) -> str:
    """Output of Python in a copy of the source."""
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([sys.executable, *command], cwd=copy, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize(
    ("added", "room", "kind", "tests"),
    [
        # Units, decks and their plugin take their laws from the same registry as the last of these.
        ("Morse", "continuum/model/walls", "morse", ["test_tables", "model/test_consistency", "model/test_wall"]),
        ("SurfaceTension", "continuum/model/substrates", "surface-tension", ["test_tables", "model/test_consistency"]),
    ],
)
def test_a_file_is_all_that_a_kind_needs(tmp_path: Path, added: str, room: str, kind: str, tests: list[str]) -> None:
    (copied(tmp_path, room) / f"{added.lower()}.py").write_text(source_of(added))
    files = [f"tests/continuum/{name}.py" for name in tests]
    found = run_in(tmp_path, "-m", "pytest", "-v", "-p", "no:cacheprovider", "-k", kind, *files)
    passed = {line.partition("::")[0] for line in found.splitlines() if kind in line and "PASSED" in line}
    assert passed == set(files)
