"""The wheel, installed without the checkout, runs both commands of the README: ``python tests/wheel.py dist``.

Run by `make wheel` with any Python; it imports nothing of the project.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

COMMANDS = (
    "continuum doctor",
    "continuum run inputs/smoke/path.toml",
    "continuum predict inputs/maps/wafer.txt --size 384nm --unit nm --material silicon --material silicon --fill 5%",
    "atomistic validate inputs/validate/quick.toml",
)
"""From any folder: inputs come with the package."""
OURS = ("continuum/", "atomistic/")


def faults_of(wheel: Path) -> list[str]:
    """What is in the wheel and should not be, and what is missing."""
    names = zipfile.ZipFile(wheel).namelist()
    strange = [name for name in names if not name.startswith(OURS) and ".dist-info/" not in name]
    inside = [name for name in names if any(part in ("tests", "docs") for part in Path(name).parts)]
    missing = [f"{package}py.typed" for package in OURS if f"{package}py.typed" not in names]
    return [f"not ours: {name}" for name in strange + inside] + [f"missing: {name}" for name in missing]


def main(dist: Path) -> None:
    (wheel,), (_,) = dist.glob("*.whl"), dist.glob("*.tar.gz")
    if faults := faults_of(wheel):
        sys.exit("\n".join(faults))
    with tempfile.TemporaryDirectory() as folder:
        venv.create(Path(folder) / "env", with_pip=True)
        programs = Path(folder) / "env" / "bin"
        pip = [programs / "python", "-m", "pip", "install", "--quiet", "--no-compile", wheel.resolve()]
        subprocess.run(pip, check=True, cwd=folder)
        for command in COMMANDS:
            print(f"$ {command}", flush=True)
            program, *arguments = command.split()
            subprocess.run([programs / program, *arguments], check=True, cwd=folder)
    print(f"{wheel.name}: {len(COMMANDS)} commands ran without the checkout")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
