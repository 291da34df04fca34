"""Programs in a stranger's surroundings, each in a process of its own.

Beside these: one process of a launcher of MPI, in tests/physics/atomistic/lammps/test_alone.py; a disk without locks,
in tests/files/test_without_locks.py; each failure of the cache of compiled code, in
tests/files/continuum/model/test_kept.py.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import pytest

import continuum as c
from tests.problems import SMALL

ROOT = Path(__file__).parents[2]
NAMED = ("HOME", "XDG_CACHE_HOME", "MPLCONFIGDIR", "MATPLOTLIBRC", "NUMBA_CACHE_DIR", "TMPDIR")
SLURM = ("SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE")


def called(
    *words: str, here: Path, before: Callable[[], object] | None = None, **variables: str
) -> subprocess.CompletedProcess[str]:
    """A Python process among these variables; ``before`` is called in it first."""
    own = {name: value for name, value in os.environ.items() if name not in (*NAMED, *SLURM)}
    environment = own | {"PYTHONPATH": str(ROOT)} | variables
    return subprocess.run(
        [sys.executable, *words], cwd=here, env=environment, preexec_fn=before, timeout=300,
        capture_output=True, text=True, check=False,
    )  # fmt: skip


class Stranger:
    """An installation in which nothing can be written, and a user without a home, as in a container."""

    def __init__(self, folder: Path) -> None:
        self.here, self.temporary, installed = folder / "here", folder / "tmp", folder / "installed"
        for name in ("continuum", "atomistic"):
            shutil.copytree(ROOT / name, installed / name, ignore=shutil.ignore_patterns("__pycache__"))
        for source in {path.parent for path in installed.rglob("*.py")}:
            (source / "__pycache__").touch()  # where a folder would be: root cannot write into it, either
        for path in (self.here, self.temporary):
            path.mkdir()
        (self.here / "small.toml").write_text(SMALL)
        self.variables = {"HOME": "/proc/none", "TMPDIR": str(self.temporary), "PYTHONPATH": str(installed)}
        self.files = set(installed.rglob("*"))
        self.installed = installed

    def calls(self, program: str, *words: str, before: Callable[[], object] | None = None) -> str:
        done = called("-m", program, *words, here=self.here, before=before, **self.variables)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "Traceback" not in done.stderr
        assert "Warning" not in done.stderr
        assert set(self.installed.rglob("*")) == self.files
        return done.stdout

    @property
    def compiled(self) -> list[Path]:
        """What is kept of compiled code, in a folder of this user's alone."""
        return sorted((self.temporary / f"stickiness-{os.getuid()}").rglob("*.nbc"))


@pytest.fixture(scope="module")
def stranger(tmp_path_factory: pytest.TempPathFactory) -> Stranger:
    """One who has pressed once: what was compiled is kept."""
    found = Stranger(tmp_path_factory.mktemp("stranger"))
    assert "converged" in found.calls("continuum", "run", "small.toml", "-o", "out")
    assert found.compiled
    return found


def full_disk() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))


def test_the_doctor_presses_where_nothing_can_be_written_beside_a_damaged_cache(stranger: Stranger) -> None:
    """By a job that was killed while it wrote; and the disk is full, so that it cannot be written again, either."""
    damaged = stranger.compiled[::8]  # each takes a quarter of a second to compile
    damaged[0].write_bytes(b"")
    for path in damaged[1:]:
        path.write_bytes(path.read_bytes()[:-100])
    found = stranger.calls("continuum", "doctor", before=full_disk)
    assert found.splitlines()[-1] == "usable"
    assert all(path.stat().st_size == 0 for path in damaged[:1])
    stranger.calls("continuum", "run", "small.toml", "-o", "again")
    assert all(path.stat().st_size > 1000 for path in stranger.compiled), "compiled and written again"
    first, again = (c.Result.read(stranger.here / name / "small.h5") for name in ("out", "again"))
    assert [point.load for point in first.points] == [point.load for point in again.points]


def test_lammps_runs_where_nothing_can_be_written(stranger: Stranger) -> None:
    assert "usable" in stranger.calls("atomistic", "doctor")


@pytest.mark.usefixtures("print_quality")
def test_a_figure_has_the_bytes_that_it_has_beside_a_foreign_matplotlibrc(tmp_path: Path) -> None:
    """In the folder where one works, which matplotlib reads before all others; LaTeX is not asked for."""
    (tmp_path / "small.toml").write_text(SMALL)
    c.run(tmp_path / "small.toml", tmp_path)
    (ours,) = [path for path in c.plot(tmp_path / "small.h5") if path.stem.endswith("contact")]
    own = ours.with_suffix(".png").read_bytes()
    settings = {"text.usetex": True, "font.size": 17, "axes.facecolor": "k", "savefig.dpi": 30, "lines.linewidth": 5}
    assert all(mpl.rcParamsDefault[key] != value for key, value in settings.items())
    (tmp_path / "matplotlibrc").write_text("".join(f"{key}: {value}\n" for key, value in settings.items()))
    done = called("-m", "continuum", "plot", "small.h5", "-o", "theirs", "--format", "png", here=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "theirs" / ours.with_suffix(".png").name).read_bytes() == own


GRANTED = "from continuum.store.granted import granted_processors; print(granted_processors())"


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="processors cannot be taken from a process here")
@pytest.mark.parametrize("processors", [1, 2])
def test_a_process_takes_the_processors_that_it_is_granted(processors: int, tmp_path: Path) -> None:
    """By ``taskset``, and by SLURM where it does not bind them."""
    some = sorted(os.sched_getaffinity(0))[:processors]
    done = called("-c", GRANTED, here=tmp_path, before=lambda: os.sched_setaffinity(0, some))
    assert int(done.stdout) <= len(some), done.stderr
    done = called("-c", GRANTED, here=tmp_path, SLURM_CPUS_PER_TASK="1", SLURM_CPUS_ON_NODE="64")
    assert int(done.stdout) == 1, done.stderr
