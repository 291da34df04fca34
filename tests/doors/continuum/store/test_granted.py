"""Memory and processors that may be used: those of the machine, less what SLURM or control groups do not allow."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from continuum.front.cli import main
from continuum.inputs.errors import InputError
from continuum.store.granted import (
    cgroup_memory,
    cgroup_processors,
    granted_memory,
    granted_processors,
    slurm_memory,
    slurm_processors,
)
from tests.problems import SMALL

MB = 2**20


def machine(root: Path, groups: str, limits: dict[str, str]) -> Path:
    """Files as the kernel shows them."""
    for name, text in {"proc/self/cgroup": groups, **{f"sys/fs/cgroup/{k}": v for k, v in limits.items()}}.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


@pytest.mark.parametrize(
    ("environment", "limit"),
    [
        ({}, np.inf),
        ({"SLURM_MEM_PER_NODE": "4096"}, 4096 * MB),
        ({"SLURM_MEM_PER_NODE": "4G"}, 4096 * MB),
        ({"SLURM_MEM_PER_NODE": "0"}, np.inf),  # --mem=0: all of the node
        ({"SLURM_MEM_PER_CPU": "2000", "SLURM_CPUS_ON_NODE": "16"}, 32000 * MB),
        ({"SLURM_MEM_PER_CPU": "2000"}, np.inf),  # no job: a variable that srun would read
        ({"SLURM_MEM_PER_GPU": "100", "SLURM_GPUS_ON_NODE": "2"}, 200 * MB),
    ],
)
def test_what_slurm_gives_a_job(environment: dict[str, str], limit: float) -> None:
    assert slurm_memory(environment) == limit


@pytest.mark.parametrize(
    "environment",
    [
        {"SLURM_MEM_PER_NODE": "x"},
        {"SLURM_MEM_PER_NODE": ""},
        {"SLURM_MEM_PER_NODE": "nan"},
        {"SLURM_MEM_PER_NODE": "-4"},
        {"SLURM_MEM_PER_CPU": "1.5", "SLURM_CPUS_ON_NODE": "2"},
        {"SLURM_MEM_PER_CPU": "2000", "SLURM_CPUS_ON_NODE": "many"},
    ],
)
def test_what_slurm_never_says_is_one_message_and_nothing_is_written(
    environment: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(InputError, match=f"{next(iter(environment))} = .*a number of MB"):
        slurm_memory(environment)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    path = tmp_path / "many.toml"
    path.write_text(SMALL)
    assert main(["run", str(path), "-o", str(tmp_path / "out")]) == 2
    path.write_text(f'{SMALL}[sweep.axes]\n"surface.seed" = [1, 2]\n')
    assert main(["sweep", "run", str(path), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2
    assert all(line.startswith(next(iter(environment))) for line in said)
    assert not (tmp_path / "out").exists()


GROUPS = [
    ("0::/\n", {"memory.max": "123\n"}, 123),  # a container sees its own group as the root
    ("0::/\n", {"memory.max": "max\n"}, np.inf),
    ("0::/slurm/job_7/step_0\n", {"slurm/job_7/memory.max": "500", "slurm/job_7/step_0/memory.max": "max"}, 500),
    ("0::/a/b/c\n", {"a/memory.max": "300", "a/b/memory.max": "900", "a/b/c/memory.max": "400"}, 300),
    ("0::/a/b\n", {"a/b/c/memory.max": "1", "x/memory.max": "2"}, np.inf),  # neither its own, nor above it
    ("0::/a\n", {"unified/a/memory.max": "77"}, 77),
    (
        "4:memory:/slurm/uid_0/job_7\n1:cpu:/\n0::/\n",
        {
            "memory/slurm/uid_0/job_7/memory.limit_in_bytes": "800",
            "memory/memory.limit_in_bytes": str(2**63 - 4096),
        },
        800,
    ),
    ("9:cpuset,memory:/out/of/sight\n", {"memory/memory.limit_in_bytes": "600"}, 600),
    ("4:memory:/a\n", {"memory/a/memory.limit_in_bytes": str(2**63 - 4096)}, 2.0**63 - 4096),
]


def test_the_lowest_limit_of_all_groups_around_a_process_holds(tmp_path: Path) -> None:
    for number, (groups, limits, limit) in enumerate(GROUPS):
        assert cgroup_memory(machine(tmp_path / str(number), groups, limits)) == limit


def test_a_machine_without_control_groups_has_its_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cgroup_memory(tmp_path) == np.inf
    whole = granted_memory()
    assert 0 < whole <= os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    monkeypatch.setenv("SLURM_MEM_PER_CPU", "1")
    monkeypatch.setenv("SLURM_CPUS_ON_NODE", "2")
    assert granted_memory() == min(whole, 2 * MB)


@pytest.mark.parametrize(
    ("environment", "processors"),
    [
        ({}, np.inf),
        ({"SLURM_CPUS_PER_TASK": "4", "SLURM_CPUS_ON_NODE": "16"}, 4),
        ({"SLURM_CPUS_ON_NODE": "16"}, 16),
        ({"SLURM_NTASKS": "2"}, np.inf),  # a variable that srun would read
    ],
)
def test_processors_that_slurm_gives_a_job(environment: dict[str, str], processors: float) -> None:
    assert slurm_processors(environment) == processors


@pytest.mark.parametrize("given", ["", "x", "0", "-1", "1.5"])
def test_a_number_of_processors_that_slurm_never_gives_is_refused(given: str) -> None:
    with pytest.raises(InputError, match=f"SLURM_CPUS_ON_NODE = '{given}': allowed: a number of processors"):
        slurm_processors({"SLURM_CPUS_ON_NODE": given})


QUOTAS = [
    ("0::/\n", {"cpu.max": "200000 100000\n"}, 2),
    ("0::/\n", {"cpu.max": "max 100000\n"}, np.inf),
    ("0::/a/b\n", {"a/cpu.max": "150000 100000", "a/b/cpu.max": "max 100000"}, 2),  # one and a half
    ("4:cpu,cpuacct:/a\n", {"cpu/a/cpu.cfs_quota_us": "400000", "cpu/a/cpu.cfs_period_us": "100000"}, 4),
    ("4:cpu,cpuacct:/a\n", {"cpu/a/cpu.cfs_quota_us": "-1", "cpu/a/cpu.cfs_period_us": "100000"}, np.inf),
    ("4:cpuset:/a\n", {"cpu/a/cpu.cfs_quota_us": "400000", "cpu/a/cpu.cfs_period_us": "100000"}, np.inf),
]


def test_the_lowest_quota_of_all_groups_around_a_process_holds(tmp_path: Path) -> None:
    for number, (groups, limits, limit) in enumerate(QUOTAS):
        assert cgroup_processors(machine(tmp_path / str(number), groups, limits)) == limit
    assert cgroup_processors(tmp_path) == np.inf


def test_the_least_of_all_grants_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = granted_processors()
    assert 1 <= whole <= (os.cpu_count() or 1)
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "1")
    assert granted_processors() == 1
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "4096")
    assert granted_processors() == whole
