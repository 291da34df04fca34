"""The back end for GPUs, on machines without one: in numba's simulator, through the compilers, and what it says."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from continuum.cli import main
from continuum.errors import InputError
from continuum.files.inputs import load
from continuum.files.tables import identity
from continuum.runs.config import RunConfig
from continuum.solve.backend import back_end

ROOT = Path(__file__).parents[3]
HERE = Path(__file__).parent
SMOKE = "inputs/smoke/hard.toml"
SPECTRAL = {
    "gradient", "low_modes", "low_gradient", "low_direction", "elastic", "add_square", "energy", "restrict", "prolong",
    "kernel_q", "positive", "multiply", "compliance", "square", "begin", "linear_gradient", "linear_last",
    "linear_restrict", "linear_low_modes", "linear_low_gradient", "linear_low_direction",
}  # fmt: skip
"""Kernels that read or write complex numbers."""
REGISTERS = 128
"""Of a thread, at most: with 128 threads a block, four blocks then fit on a multiprocessor, 65536 registers."""


def without_gpu() -> bool:
    try:
        back_end("cuda")
    except InputError:
        return True
    return False


no_gpu = pytest.mark.skipif(not without_gpu(), reason="there is a GPU here")


def simulated(tmp_path: Path, *which: str) -> None:
    """Tests of another file, in a process that has the simulator."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--basetemp", str(tmp_path / "inner")]
    command += ["-p", "no:xdist", str(HERE / "cuda_simulated.py"), *which]
    done = subprocess.run(
        command, env=os.environ | {"NUMBA_ENABLE_CUDASIM": "1"}, cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


def test_kernels_and_solves_find_what_the_cpu_finds(tmp_path: Path) -> None:
    simulated(tmp_path)


@pytest.mark.long
def test_more_solves(tmp_path: Path) -> None:
    simulated(tmp_path, "-m", "long")


@pytest.mark.long
def test_every_kernel_in_the_simulator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STICKINESS_IN_SIMULATOR", "1")
    simulated(tmp_path, "-k", "not whole and not run and not one_set")


def compiler() -> str:
    """Assembler of machine code: beside numba's compiler, of the same release, or on the path."""
    spec = importlib.util.find_spec("nvidia")
    found = [path for place in spec.submodule_search_locations or () for path in Path(place).glob("cu*/bin/ptxas")] \
        if spec else []  # fmt: skip
    return str(found[0]) if found else shutil.which("ptxas") or ""


KINDS = pytest.mark.parametrize("kind", [(8, 0), (9, 0)], ids=["sm_80", "sm_90"])


def compiled(*arguments: object, **environment: str) -> str:
    """What `cuda_compiled` prints, in a process without the simulator."""
    if importlib.util.find_spec("numba_cuda") is None:
        pytest.skip("no compiler for GPUs: pip install 'stickiness[gpu]'")
    command = [sys.executable, "-m", "tests.continuum.solve.cuda_compiled", *map(str, arguments)]
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_ENABLE_CUDASIM"} | environment
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, check=False)
    if "Unsupported .version" in done.stderr:
        pytest.skip("the assembler is older than numba's compiler: pip install nvidia-cuda-nvcc of its release")
    assert done.returncode == 0, done.stderr
    return done.stdout


@KINDS
def test_every_kernel_compiles_and_keeps_its_numbers_in_registers(kind: tuple[int, int], tmp_path: Path) -> None:
    if importlib.util.find_spec("numba_cuda") is not None and not compiler():
        pytest.skip("no assembler for GPUs: pip install nvidia-cuda-nvcc")
    rows = [line.split() for line in compiled(*kind, compiler(), tmp_path).splitlines()]
    assert len(rows) > 30
    numbers = {name: list(map(int, counts)) for name, *counts in rows}
    assert {name: spilled for name, (_, spilled, *_) in numbers.items() if spilled} == {}
    assert {name: registers for name, (registers, *_) in numbers.items() if registers > REGISTERS} == {}
    # Complex numbers cross as one; a larger or smaller number that drops NaN is taken nowhere but in the wall laws, and
    # where a beta that is no number is none, as in Python.
    assert {name for name, (_, _, pairs, *_) in numbers.items() if pairs} == SPECTRAL
    assert {name: single for name in ("restrict", "prolong", "low_direction") if (single := numbers[name][3])} == {}
    drops = {name for name, (*_, number) in numbers.items() if number}
    assert drops <= {"press", "line", "move", "decide_gradient", "decide_low_modes", "decide_low_gradient"}


@KINDS
def test_what_one_process_compiled_another_reads(kind: tuple[int, int], tmp_path: Path) -> None:
    found = [int(compiled(*kind, NUMBA_CACHE_DIR=str(tmp_path))) for _ in range(2)]
    assert found == [0, 3]


# --- what is said ------------------------------------------------------------------------------------------


@no_gpu
def test_without_a_gpu_there_is_one_message_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results"
    assert main(["run", str(ROOT / SMOKE), "--device", "cuda", "-o", str(out)]) == 2
    said = capsys.readouterr().err.strip()
    assert "pip install 'stickiness[gpu]'" in said
    assert said.count("\n") == 0
    assert not out.exists()


def test_each_release_of_cuda_has_an_extra_of_the_same_libraries() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    libraries = {}
    for name, release in (("gpu", "cu13"), ("gpu12", "cu12")):
        assert [one for one in extras[name] if f"[{release}]" in one]
        libraries[name] = {re.split(r"[\[><=]", one)[0].removesuffix("-cu12") for one in extras[name]}
        for said in (ROOT / "README.md", ROOT / "docs" / "solver.md"):
            assert f"`stickiness[{name}]`" in said.read_text()
    assert libraries["gpu"] == libraries["gpu12"] == {"numba-cuda", "nvmath-python", "nvidia-cufft"}


def test_a_device_that_there_is_not_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(ROOT / SMOKE), "--device", "abacus", "-o", str(tmp_path)]) == 2
    assert "'abacus'" in (said := capsys.readouterr().err)
    assert 'one of "cpu", "cuda"' in said
    faulty = tmp_path / "run.toml"
    faulty.write_text((ROOT / SMOKE).read_text() + '\n[solver]\ndevice = "gpu"\n')
    assert main(["run", str(faulty), "-o", str(tmp_path)]) == 2
    assert '"cpu" or "cuda"' in capsys.readouterr().err


def test_results_of_two_devices_are_kept_apart() -> None:
    config = load(ROOT / SMOKE, RunConfig)
    assert identity(config.on("cpu")) == identity(config)
    assert identity(config.on("cuda")) != identity(config)
    assert config.on("cuda").source == config.source
    assert config.on("cuda").solver.build(0.1).device == "cuda"


@no_gpu
def test_the_benchmark_without_a_gpu_ends_with_one_message() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.benchmarks.gpu"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "pip install 'stickiness[gpu]'" in done.stderr
    assert done.stderr.strip().count("\n") == 0
