"""One contact shared by several processes: the file that one process writes, and what is said where one is lost."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from continuum.inputs.errors import InputError, StickinessError
from continuum.solve import processes
from continuum.solve.processes import World, launched

needs_jax = pytest.mark.skipif(importlib.util.find_spec("jax") is None, reason="JAX is not installed")
ROOT = Path(__file__).parents[5]
INPUT = """
[grid]
n = 64
[surface]
kind = "self-affine"
hurst = 0.8
rms_slope = 0.1
lambda_s = 8
lambda_L = 32
seed = 1
[wall]
law = "hard"
[substrate]
response = "half-space"
mean = "clamped"
[loading]
control = "mean-pressure"
targets = [0.005, 0.01]
[output]
fields = true
[solver]
device = "jax"
shards = 2
"""


def begun(folder: Path, rank: int, size: int) -> subprocess.Popen[str]:
    """A process of so many that run the same input, as an MPI's mpiexec starts it."""
    own = {"PMI_RANK": str(rank), "PMI_SIZE": str(size), "MPI_LOCALNRANKS": str(size), "JAX_PLATFORMS": "cpu"}
    command = [sys.executable, "-m", "continuum", "run", str(folder / "shared.toml"), "--output", str(folder)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    return subprocess.Popen(command, cwd=ROOT, env=os.environ | own, **pipes)


@needs_jax
def test_two_processes_write_the_file_of_one_bit_for_bit(tmp_path: Path) -> None:
    files = []
    for size in (1, 2):
        folder = tmp_path / str(size)
        folder.mkdir()
        (folder / "shared.toml").write_text(INPUT)
        running = [begun(folder, rank, size) for rank in range(size)]
        said = [each.communicate(timeout=300)[0] for each in running]
        assert [each.returncode for each in running] == [0] * size, said
        assert ["result" in each for each in said] == [True, False][:size]
        files.append(folder / "shared.h5")
    assert {"gap", "repulsive", "load"} < same_bits(*files)


def same_bits(one: Path, two: Path) -> set[str]:
    """Datasets of two finished files of one run, which have the same bits."""
    with h5py.File(one) as first, h5py.File(two) as second:
        names = {name for name in first if isinstance(first[name], h5py.Dataset)}
        assert names == {name for name in second if isinstance(second[name], h5py.Dataset)}
        for name in names:
            np.testing.assert_array_equal(first[name][()], second[name][()], name)
        assert first.attrs["finished"]
        assert second.attrs["finished"]
        assert first.attrs["identity"] == second.attrs["identity"]
    return names


@needs_jax
@pytest.mark.long
def test_a_path_with_jumps_that_lost_a_process_continues_to_the_file_of_one(tmp_path: Path) -> None:
    text = (ROOT / "inputs" / "smoke" / "path.toml").read_text()
    folders = [tmp_path / name for name in ("one", "two")]
    for folder in folders:
        folder.mkdir()
        (folder / "shared.toml").write_text(f'{text}\n[output]\nfields = true\n[solver]\ndevice = "jax"\nshards = 2\n')
    alone = begun(folders[0], 0, 1)
    said = alone.communicate(timeout=300)[0]
    assert alone.returncode == 0, said
    first, second = (begun(folders[1], rank, 2) for rank in range(2))
    assert first.stdout is not None
    said = next(line for line in first.stdout if "shared 1/5" in line)
    second.kill()
    second.communicate(timeout=60)
    said += first.communicate(timeout=300)[0]
    assert first.returncode == 1, said
    assert "process 0 of 2 has lost the others" in said
    again = [begun(folders[1], rank, 2) for rank in range(2)]
    said, _ = (each.communicate(timeout=300)[0] for each in again)
    assert [each.returncode for each in again] == [0, 0], said
    assert "were stored before" in said
    assert "jump-out" in said
    same_bits(*(folder / "shared.h5" for folder in folders))


def test_processes_that_were_started_together_are_known_by_their_launcher() -> None:
    assert launched({}) == launched({"SLURM_PROCID": "0", "SLURM_NTASKS": "4"}) == World()
    assert launched({"SLURM_PROCID": "1", "SLURM_STEP_NUM_TASKS": "4"}) == World(1, 4, 0)
    assert launched({"PMI_RANK": "1", "PMI_SIZE": "2", "MPI_LOCALNRANKS": "2"}) == World(1, 2, 2)
    many = launched({"OMPI_COMM_WORLD_RANK": "3", "OMPI_COMM_WORLD_SIZE": "8", "OMPI_COMM_WORLD_LOCAL_SIZE": "4"})
    assert many == World(3, 8, 4)
    assert many.address({processes.ADDRESS: "node1:4711"}) == "node1:4711"
    with pytest.raises(InputError, match=f"set {processes.ADDRESS} to HOST:PORT"):
        many.address({})
    assert World(1, 2, 2).address({}).startswith("127.0.0.1:")


def test_a_process_that_loses_the_others_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    codes = list[int]()
    monkeypatch.setattr(processes.atexit, "register", lambda function, code: codes.append(code))
    with pytest.raises(RuntimeError), processes.in_company(World()):
        raise RuntimeError("reset by peer")
    assert not codes
    lost = "process 0 of 2 has lost the others: reset by peer"
    with pytest.raises(StickinessError, match=lost), processes.in_company(World(0, 2, 2)):
        raise RuntimeError("reset by peer\nand more")
    with pytest.raises(KeyboardInterrupt), processes.in_company(World(0, 2, 2)):
        raise KeyboardInterrupt
    with pytest.raises(SystemExit, match="143"), processes.in_company(World(1, 2, 2)):  # the first says it for all
        raise KeyboardInterrupt(signal.SIGTERM)
    assert codes == [1, 130, 143]
