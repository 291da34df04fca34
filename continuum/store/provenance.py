"""Provenance of a result: versions and commit, as attributes for :mod:`continuum.store.datasets`; how to cite it."""

import datetime
import importlib.metadata
import platform
import re
import shutil
import socket
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Self

from continuum import __version__
from continuum.inputs.toml import packaged


def versions() -> str:
    """Versions that the numbers depend on, one per line: program, Python, NumPy, LAMMPS, libraries of the back ends."""
    lines = {
        "stickiness": __version__,
        "Python": platform.python_version(),
        "NumPy": version_of("numpy"),
        "LAMMPS": version_of("lammps") or "not installed",
        "device cpu:": f"ducc0 {version_of('ducc0')}, numba {version_of('numba')}",
        **{
            f"device {name}:": version_of(name) or f"not installed (for GPUs: extra {name}, see the page Install)"
            for name in ("torch", "cupy", "jax")
        },
    }
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


def made_by(attributes: Mapping[str, Any]) -> str:
    """Version and commit of a stored result, or of :func:`provenance`, in words."""
    commit = str(attributes.get("provenance/git_commit", ""))[:12]
    changed = " with changes" if attributes.get("provenance/git_dirty") else ""
    return f"version {attributes.get('provenance/stickiness')}{f', commit {commit}' if commit else ''}{changed}"


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


@dataclass(frozen=True)
class Citation:
    """Content of ``CITATION.cff``."""

    title: str
    """Title of the program."""
    authors: tuple[str, ...]
    """Authors of the program."""
    version: str
    license: str
    paper: str
    """Reference of the paper."""
    doi: str
    """DOI of the paper."""

    @property
    def program(self) -> str:
        """Reference of the program."""
        return f"{', '.join(self.authors)}, {self.title}, version {self.version}"

    @classmethod
    def read(cls) -> Self:
        """Read the file that comes with the package: only as much of YAML as it uses."""
        text = packaged("CITATION.cff").read_text(encoding="utf-8")
        program, _, article = text.partition("references:")
        names = zip(_all(article, "family-names"), _all(article, "given-names"), strict=True)
        authors = [" ".join([re.sub(r"(\w)\w*\.?", r"\1.", given), family]) for family, given in names]
        said = {key: _all(article, key)[0] for key in ("title", "journal", "volume", "start", "end", "year", "doi")}
        paper = "{}, {title}, {journal} {volume}, {start}-{end} ({year}), doi:{doi}".format(
            " and ".join(authors), **said
        )
        own = {key: _all(program, key)[0] for key in ("title", "version", "license")}
        return cls(own["title"], _all(program, "name"), own["version"], own["license"], paper, said["doi"])


def _all(text: str, key: str) -> tuple[str, ...]:
    return tuple(re.findall(rf'^[ -]*{key}: "?(.*?)"?$', text, re.MULTILINE))
