"""The lowest versions that pyproject.toml allows: ``python -m tests.lowest`` prints them as constraints of pip.

Of each version its last patch is taken: 2.2 of pandas is 2.2.3, since 2.2.0 refuses NumPy 2.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

PROJECT = Path(__file__).parents[1] / "pyproject.toml"
EXTRAS = ("xarray", "topography", "cluster", "app")
"""Extras that the tests use."""


def constraints(project: Path = PROJECT) -> dict[str, str]:
    """Lowest version of each direct requirement of this platform, by name."""
    table = tomllib.loads(project.read_text(encoding="utf-8"))["project"]
    texts = [*table["dependencies"], *(text for extra in EXTRAS for text in table["optional-dependencies"][extra])]
    found = {}
    for one in map(Requirement, texts):
        if one.marker is None or one.marker.evaluate({"extra": ""}):
            (lowest,) = (part.version for part in one.specifier if part.operator in {">=", "=="})
            found[one.name] = lowest
    return found


if __name__ == "__main__":
    sys.stdout.writelines(f"{name}=={version}.*\n" for name, version in constraints().items())
