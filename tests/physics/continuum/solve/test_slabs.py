"""One contact on several devices: the states of one device, and what the devices exchange."""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from continuum.inputs.errors import InputError
from continuum.model.grid import Grid
from continuum.model.substrates import HalfSpace
from continuum.solve.backend import back_end
from continuum.solve.solver import Solver
from tests.physics.continuum.solve.on_slabs import POINTS, states

needs_jax = pytest.mark.skipif(importlib.util.find_spec("jax") is None, reason="JAX is not installed")
ROOT = Path(__file__).parents[4]
SHARDS = 2


def run(walls: Sequence[str], flags: str = "") -> dict[str, list[float]]:
    """The states of :mod:`.on_slabs`, in a process of their own: JAX fixes its devices once."""
    command = [sys.executable, "-m", "tests.physics.continuum.solve.on_slabs", str(SHARDS), *walls]
    environment = os.environ | {"JAX_PLATFORMS": "cpu", "XLA_FLAGS": flags}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, list[float]] = json.loads(done.stdout.splitlines()[-1])
    return found


_KINDS = "all-to-all|all-gather|all-reduce|collective-permute|reduce-scatter|collective-broadcast|ragged-all-to-all"
_SIZES = {"pred": 1, "f32": 4, "s32": 4, "f64": 8, "s64": 8, "c64": 8, "c128": 16}


def collectives(folder: Path) -> Iterator[tuple[str, int]]:
    """Each collective of the programs that XLA has compiled: its kind, and the bytes of its result on a device."""
    for file in folder.glob("*after_optimizations.txt"):
        for given, kind in re.findall(rf"= (.*?) ({_KINDS})(?:-start)?\(", file.read_text()):
            sizes = 0
            for name, shape in re.findall(r"(\w+)\[([\d,]*)\]", given):
                points = 1
                for n in filter(None, shape.split(",")):
                    points *= int(n)
                sizes += _SIZES[name] * points
            yield kind, sizes


@needs_jax
@pytest.mark.parametrize(
    ("walls", "tolerance"),
    # Sums over the points in another order; of the contact's own step also what its residual of 1e-9 E* leaves of mean
    # tractions of 0.02 E*, where 6e-10 was seen.
    [(["law", "hard"], 1e-11), pytest.param(["stiff"], 5e-8, marks=pytest.mark.long)],
)
def test_several_devices_find_what_one_finds_and_exchange_spectra_only(
    walls: list[str], tolerance: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    two = run(walls, f"--xla_dump_to={tmp_path} --xla_dump_hlo_as_text")
    monkeypatch.setattr(back_end("numpy"), "SMALLEST", 128, raising=False)
    one = states("numpy", 1, walls)
    for name, (iterations, pairs, *means, closed) in one.items():
        assert two[name][:2] == [iterations, pairs], name
        assert two[name][-1] == closed
        assert two[name][2:4] == pytest.approx(means, rel=tolerance, abs=tolerance)
    found = list(collectives(tmp_path))
    exchanges = [size for kind, size in found if kind == "all-to-all"]
    # A part of a half spectrum in double precision, with the columns that make the parts equal.
    assert max(exchanges) == 16 * POINTS * (POINTS // 2 + SHARDS) // SHARDS
    # Beside it: sums, and rows at the edges of slabs: kernels reach two under a bound, three in a contact step.
    others = [size for kind, size in found if kind != "all-to-all"]
    assert len(others) > 10
    assert max(others) <= 3 * 8 * POINTS
    assert not {kind for kind, _ in found} - {"all-to-all", "all-reduce", "collective-permute"}


@needs_jax
def test_devices_that_are_not_there_are_refused() -> None:
    importlib.import_module("jax").devices()  # from here on their number is fixed
    with pytest.raises(InputError, match=r"shards = 4096 needs as many devices, of which JAX sees \d+ \("):
        back_end("jax", 4096)


def test_other_devices_have_no_parts() -> None:
    with pytest.raises(ValueError, match='shards = 2 needs device = "jax"'):
        back_end("cpu", 2)
    grid = Grid.square(9)
    with pytest.raises(ValueError, match='shards = 2 needs device = "jax"'):
        Solver(grid, HalfSpace("clamped").stiffness(grid), device="numpy", shards=2)
