"""Whether two checkouts make the same results, bit for bit: for changes of the code that are to change no number.

    python -m docs.studies.same_bits make FOLDER        in each of the two checkouts
    python -m docs.studies.same_bits compare ONE OTHER  in either

Makes the results of each input in ``inputs/smoke``, of ``inputs/validate/quick.toml`` and of a sweep of six systems,
and the decks of ``inputs/lammps``: two minutes on two cores.  Times, hosts, versions and dates are not compared.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import h5py
import numpy as np

SWEEP = """\
[grid]
n = 64

[surface]
kind = "self-affine"
hurst = 0.8
rms_slope = 0.1
lambda_s = 8.0
lambda_L = 32.0
seed = 1

[wall]
law = "lennard-jones-spline"
adhesion_length = 0.005

[substrate]
response = "half-space"
mean = "clamped"

[loading]
control = "repulsive-area"
targets = [0.02, 0.05]
retract = true

[sweep.axes]
"surface.seed" = [1, 2]
"wall.adhesion_length" = [0.0, 0.005, 0.05]
"""
APART = ("journal", "provenance")
"""Groups of a result that hold times and hosts."""
HOSTS = ("host", "version", "date", "time", "seconds", "commit", "created", "python", "platform", "input", "config")
"""Parts of names of attributes that do."""


def make(folder: Path) -> None:
    """Results of this checkout."""
    folder.mkdir(parents=True)
    (folder / "six.toml").write_text(SWEEP)
    for file in sorted(Path("inputs/smoke").glob("*.toml")):
        _do("continuum", "run", file, "-o", folder / "smoke")
    _do("continuum", "sweep", "run", folder / "six.toml", "-o", folder / "six", "--workers", 2)
    _do("atomistic", "validate", "inputs/validate/quick.toml", "-o", folder / "quick")
    for file in sorted(Path("inputs/lammps").glob("*.toml")):
        _do("atomistic", "deck", file, "-o", folder / "decks" / file.stem)


def _do(package: str, *arguments: object) -> None:
    sys.stderr.write(f"{package} {' '.join(map(str, arguments))}\n")
    found = subprocess.run(
        [sys.executable, "-m", package, *map(str, arguments)], stdout=subprocess.DEVNULL, check=False
    )
    if found.returncode > 1:  # 1: a result that is unlike what was expected, which is a result
        sys.exit(found.returncode)


def numbers(path: Path) -> dict[str, np.ndarray | object]:
    """Datasets and attributes of an HDF5 file but for those of the machine."""
    found: dict[str, np.ndarray | object] = {}

    def visit(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if name.split("/")[0] in APART:
            return
        if isinstance(item, h5py.Dataset):
            found[name] = item[()]
        for key, value in item.attrs.items():
            if not key.isupper() and not any(word in key for word in HOSTS):
                found[f"{name}@{key}"] = value

    with h5py.File(path) as file:
        file.visititems(visit)
    return found


def same(one: object, other: object) -> bool:
    a, b = np.asarray(one), np.asarray(other)
    if a.dtype.kind == "O":  # text, whose array holds addresses
        return bool(a.dtype == b.dtype and a.tolist() == b.tolist())
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def differences(one: Path, other: Path) -> Iterator[str]:
    """What is not the same in two folders of results, a line each."""
    names = [{path.relative_to(root) for path in root.rglob("*") if path.is_file()} for root in (one, other)]
    yield from (f"only in one of them: {name}" for name in sorted(names[0] ^ names[1]) if name.suffix in (".h5", ".in"))
    for name in sorted(names[0] & names[1]):
        if name.suffix == ".h5":
            a, b = numbers(one / name), numbers(other / name)
            for key in sorted(a.keys() | b.keys()):
                if key not in a or key not in b:
                    yield f"{name}: {key} is in {'the first' if key in a else 'the second'} only"
                elif not same(a[key], b[key]):
                    yield f"{name}: {key} differs"
        elif _is_deck(name) and (one / name).read_bytes() != (other / name).read_bytes():
            yield f"{name} differs"


def _is_deck(name: Path) -> bool:
    return name.parts[0] == "decks" and name.suffix not in (".txt", ".lock")


def main(about: str | None, make: Callable[[Path], None], differences: Callable[[Path, Path], Iterable[str]]) -> None:
    """Make results, or compare two folders of them; exit code 1 if they differ."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True, dest="command")
    commands.add_parser("make").add_argument("folder", type=Path)
    comparing = commands.add_parser("compare")
    comparing.add_argument("one", type=Path)
    comparing.add_argument("other", type=Path)
    given = parser.parse_args()
    if given.command == "make":
        make(given.folder)
        return
    found = list(differences(given.one, given.other))
    sys.stdout.write("\n".join([*found, f"{len(found)} differences\n"]))
    sys.exit(bool(found))


if __name__ == "__main__":
    main(__doc__, make, differences)
