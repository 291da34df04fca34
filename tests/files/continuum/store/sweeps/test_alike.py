"""Systems that differ in seeds: listed without checking each, as if each was checked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import continuum as c
from continuum.inputs.reading import load
from continuum.store.identity import identity
from continuum.store.runs.config import RunConfig
from continuum.store.sweeps.axes import Alike, Sweep
from continuum.store.sweeps.sweep import begin

RUN: dict[str, Any] = {
    "grid": {"n": 16},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 16.0, "seed": 1},
    "wall": {"law": "hard"},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "mean-pressure", "targets": [0.01]},
}
OTHER = {**RUN["surface"], "kind": "self-affine", "seed": 5}


def swept(axes: dict[str, Any], **more: Any) -> Sweep:
    return Sweep.read({**RUN, "sweep": {"axes": axes, **more}})


@pytest.mark.parametrize(
    "sweep",
    [
        swept({"surface.seed": [3, 1, 2**62], "surface.lambda_s": [4.0, 8.0]}),
        swept({"surface.lambda_s": [4.0, 8.0, 16.0], "surface.seed": [0, 7]}, keep=["lambda_s * 2 <= lambda_L"]),
        swept({"surface.seed": [1, 2, 3]}, keep=["seed > 1"]),
        swept({"wall": [{"law": "hard"}, {"law": "lennard-jones-spline", "adhesion_length": 0.01}]}, zipped=[
            {"surface.seed": [1, 2], "grid.n": [16, 32]}
        ]),
        Sweep.read({**RUN, "counterface": {"surface": OTHER, "shift": [0, 0]}, "sweep": {
            "axes": {"surface.seed": [1, 2], "counterface.surface.seed": [3, 4]}}}),
        Sweep.read("inputs/sweep/figure4.toml", reduced=True),
        Sweep.read("inputs/sweep/patches.toml", reduced=True),
    ],
)  # fmt: skip
def test_each_system_has_the_identity_of_its_whole_input(sweep: Sweep) -> None:
    listed = list(sweep.plans())
    assert [plan.key for plan, *_ in listed] == [identity(plan.config) for plan, *_ in listed]
    assert [(plan, identity(config)) for plan, config in sweep.systems()] == [(plan, plan.key) for plan, *_ in listed]


def test_only_the_first_of_those_that_differ_in_seeds_is_checked(tmp_path: Path) -> None:
    sweep = swept({"surface.seed": list(range(50)), "surface.lambda_s": [4.0, 8.0]})
    assert sum(not alike for *_, alike in sweep.plans()) == 2
    tasks = begin(sweep, tmp_path / "many")
    assert len({task.cost for task in tasks}) == 1
    assert len({task.path for task in tasks}) == 100


@pytest.mark.parametrize("wrong", [-1, 1.5, "two", True, 2**63])
def test_a_seed_that_is_none_is_told_as_in_a_whole_input(wrong: Any) -> None:
    with pytest.raises(c.ConfigError, match=r"surface\.seed"):
        list(swept({"surface.seed": [1, 2, wrong]}).plans())


def test_a_key_on_which_others_depend_is_not_taken_for_a_seed() -> None:
    config = load(RUN, RunConfig)
    assert Alike.of(config, ["surface.seed"]).key({"surface.seed": 1}) == identity(config)
    for key in ("surface.lambda_s", "grid.n", "surface.nothing", "solver.threads"):
        assert Alike.of(config, [key]).key({key: 4}) is None
