"""Are two folders of results the same?  ``python -m tests.compare OLD NEW``

Every file of OLD is looked for in NEW: HDF5 files dataset by dataset and attribute by attribute, bit for bit; JSON of
the benchmarks by its counts.  What may differ is told apart: times, hosts, dates, versions and commits.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

JOURNAL = ("journal", "provenance")
"""Groups whose content is of the moment, not of the physics."""
MOVED = frozenset({"config_resolved"})
"""Text that says the same in another order when a key of an input moves; the identity is compared instead."""
COUNTS = ("fft_pairs", "iterations", "pairs_by_grid", "residual", "area", "pressure", "search_pairs")


def content(path: Path) -> dict[str, Any]:
    """Datasets and attributes of a file, by name; of numbers their bytes."""
    found: dict[str, Any] = {}
    with h5py.File(path) as file:

        def visit(name: str, item: h5py.Group | h5py.Dataset) -> None:
            if name.split("/")[0] in JOURNAL:
                return
            if isinstance(item, h5py.Dataset):
                values = item[()]
                found[name] = (str(values.dtype), np.shape(values), np.asarray(values).tobytes())
            found.update({f"{name}@{key}": _plain(value) for key, value in item.attrs.items() if key not in MOVED})

        file.visititems(visit)
        found.update({f"@{key}": _plain(value) for key, value in file.attrs.items() if key not in MOVED})
    return {key: value for key, value in found.items() if not key.endswith(("_LIST", "@NAME", "@CLASS"))}


def _plain(value: Any) -> Any:
    return value.tobytes() if isinstance(value, np.ndarray) else value


def differences(old: Path, new: Path) -> Iterator[str]:
    """What differs between two files, or two folders, in words."""
    if old.is_dir():
        for path in sorted(old.rglob("*.h5")) + sorted(old.rglob("*.json")):
            other = new / path.relative_to(old)
            yield from differences(path, other) if other.exists() else [f"{other}: missing"]
    elif old.suffix == ".json":
        one, two = (json.loads(path.read_text())["rows"] for path in (old, new))
        for table, rows in one.items():
            for row, again in zip(rows, two.get(table, []), strict=True):
                for name in COUNTS:
                    if row.get(name) != again.get(name):
                        yield f"{table}, n = {row['n']}: {name} was {row.get(name)}, is {again.get(name)}"
    else:
        one, two = content(old), content(new)
        for name in sorted(one.keys() | two.keys()):
            if name not in two or name not in one:
                yield f"{new}: {name} is {'gone' if name in one else 'new'}"
            elif one[name] != two[name]:
                yield f"{new}: {name} differs"


def main() -> int:
    """Print every difference; 1 if there is one."""
    parser = argparse.ArgumentParser(prog="tests.compare", description=__doc__)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    given = parser.parse_args()
    found = list(differences(given.old, given.new))
    files = len(list(given.old.rglob("*.h5")) + list(given.old.rglob("*.json"))) if given.old.is_dir() else 1
    sys.stdout.write("\n".join([*found, f"{files} files, {len(found)} differences"]) + "\n")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
