"""Stored results are recognised: the identity of an input is what it was when they were stored."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from atomistic.inputs.validate import ValidateConfig
from atomistic.relax.decks import table_in_words
from continuum.inputs.reading import load
from continuum.inputs.toml import find
from continuum.model.surface import Surface
from continuum.model.walls import Wall
from continuum.store.identity import identity, resolved, restored
from continuum.store.runs.config import RunConfig
from continuum.store.sweeps.axes import Sweep

STORED = Path(__file__).with_name("identities.json")
"""Identities as they were stored, by inputs and by the changes below; new inputs are added, and none is
ever changed, unless the input itself was (those with jumps, 2026-11-28: bounds)."""
INPUTS = find("inputs/smoke/nonadhesive.toml").parents[1]
WAVE = {"kind": "sine", "amplitude": 0.1, "waves": [1, 2]}
ROUGH = {"kind": "self-affine", "hurst": 0.8, "lambda_s": 8.0, "lambda_L": 32.0, "seed": 3}
CHANGES: dict[str, list[dict[str, Any]]] = {
    "wall": [
        {"law": "lennard-jones-spline", "range": 0.35},
        {"law": "lennard-jones-spline", "adhesion_length": 0.005, "core": 0.8},
        {"law": "lennard-jones-9-3", "adhesion_length": 0.005},
        {"law": "lennard-jones-12-6", "adhesion_length": 0.005, "core": 0.9},
        {"law": "exponential", "surface_energy": 0.005, "decay_length": 0.3, "core_stiffness": 2},
        {"law": "attraction-on-core", "shape": "spline", "adhesion_length": 0.005, "effective_range": 0.3,
         "core_stiffness": 2.0},
        {"law": "attraction-on-core", "shape": "exponential", "adhesion_length": 0.005, "effective_range": 0.3,
         "core_stiffness": 2.0},
        {"law": "hard"},
        {"law": "hard", "hardness": 0.5},
        {"law": "table", "path": "wall.txt"},
    ],
    "substrate": [
        {"response": "half-space", "mean": "clamped"},
        {"response": "half-space", "mean": 1},
        {"response": "layer", "depth": 8, "poisson": 0.3, "mean": "free"},
        {"response": "crystal", "c11": 1.2, "c12": 0.6, "c44": 0.5, "mean": 0.3},
        {"response": "crystal", "c11": 1.2, "c12": 0.6, "c44": 0.5, "depth": 4.0, "mean": "clamped"},
        {"response": "layered-half-space", "layers": [{"thickness": 1.0, "contact_modulus": 1, "poisson": 0.3}],
         "base": {"contact_modulus": 0.5, "poisson": 0.5}, "mean": "clamped"},
        {"response": "non-periodic-half-space"},
    ],
    "surface": [
        WAVE,
        ROUGH | {"rms_slope": 0.1},
        ROUGH | {"rms_height": 0.5, "rescale": False},
        {"kind": "sphere", "radius": 50},
        {"kind": "cylinder", "radius": 50.0, "along": "x"},
        {"kind": "cylinder", "radius": 50.0},
        {"kind": "punch", "flat_radius": 4.0, "edge_radius": 20.0},
        {"kind": "file", "path": "heights.npy"},
    ],
    "counterface": [
        {"surface": WAVE, "shift": [1.5, 2]},
        {"surface": ROUGH | {"rms_slope": 0.1}, "shift_seed": 5, "angle": 180},
    ],
}  # fmt: skip
CASES = [(key, i) for key, changes in CHANGES.items() for i in range(len(changes))]


@pytest.fixture(scope="module", autouse=True)
def _folder(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A folder with the files that tables above name, by content of their own."""
    folder = tmp_path_factory.mktemp("files")
    (folder / "wall.txt").write_text("0.7 1.0\n1.0 0.0\n1.2 -0.1\n1.5 -0.05\n2.0 0.0\n")
    with (folder / "heights.npy").open("wb") as file:
        np.lib.format.write_array(file, np.arange(4.0).reshape(2, 2), version=(1, 0))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        yield


def changed(key: str, i: int) -> RunConfig:
    tables = dict(load("inputs/smoke/nonadhesive.toml", RunConfig).source.data)
    return load(tables | {"loading": {"control": "mean-pressure", "targets": [0.1]}, key: CHANGES[key][i]}, RunConfig)


def identity_of(file: str) -> str:
    kind = Path(file).parts[0]
    if kind == "sweep":
        return next(Sweep.read(f"inputs/{file}").systems())[0].key
    return identity(load(f"inputs/{file}", RunConfig if kind == "smoke" else ValidateConfig))


FILES = [f"{kind}/{f.name}" for kind in ("smoke", "sweep", "validate") for f in sorted((INPUTS / kind).glob("*.toml"))]


def test_an_input_that_comes_with_the_package_has_the_identity_of_its_stored_results() -> None:
    for file in FILES:
        assert identity_of(file) == json.loads(STORED.read_text())["inputs"][file]


def test_a_table_of_every_kind_has_the_identity_of_its_stored_results() -> None:
    for key, i in CASES:
        config, stored = changed(key, i), json.loads(STORED.read_text())
        assert identity(config) == stored[key][i]
        # The text of an older result has null for what was not given, and lacks keys that are newer.
        text = json.dumps(json.loads(resolved(config)) | {key: stored["texts"][key][i]})
        read = restored(RunConfig, text)
        if "path" not in CHANGES[key][i]:  # of files only the names are stored
            assert identity(read) == stored[key][i]
            assert getattr(restored(RunConfig, resolved(config)), key) == getattr(config, key)


def test_decks_are_known_by_the_text_of_their_surface_and_wall() -> None:
    surface = Surface.kinds["self-affine"].model_validate(ROUGH | {"rms_slope": 0.1}, context={})
    assert table_in_words(surface) == (
        "hurst = 0.8, lambda_s = 8.0, lambda_L = 32.0, kind = self-affine, rms_slope = 0.1, seed = 3"
    )
    wall = Wall.kinds["lennard-jones-spline"].model_validate({"core": 0.8, "adhesion_length": 0.005}, context={})
    assert table_in_words(wall) == "law = lennard-jones-spline, adhesion_length = 0.005, core = 0.8"


def stored_anew() -> dict[str, Any]:
    """What :data:`STORED` holds, made by this version; only for inputs that it does not have yet."""
    found: dict[str, Any] = {"inputs": {file: identity_of(file) for file in FILES}}
    for key, changes in CHANGES.items():
        found[key] = [identity(changed(key, i)) for i in range(len(changes))]
    found["texts"] = {
        key: [json.loads(resolved(changed(key, i)))[key] for i in range(len(changes))]
        for key, changes in CHANGES.items()
    }
    return found
