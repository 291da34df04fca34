"""A second rough body in an input: the contact of the difference, whatever the table says of it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import continuum as c
from continuum.inputs.reading import load
from continuum.inputs.toml import ConfigError
from continuum.store.runs.build import build
from continuum.store.runs.config import RunConfig

TEXT = Path("inputs/smoke/shifted.toml").read_text(encoding="utf-8")


PERIODIC = 'response = "half-space"\nmean = "clamped"'
SELF_AFFINE = re.search(r'kind = "self-affine"[^[]*', TEXT)[0].replace("lambda_L = 64.0", "lambda_L = 32.0")


def config(tmp_path: Path, *changes: tuple[str, str]) -> RunConfig:
    text = TEXT.replace("n = 128", "n = 48").replace("lambda_L = 64.0", "lambda_L = 32.0")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "input.toml").write_text(text, encoding="utf-8")
    return load(tmp_path / "input.toml", RunConfig)


def test_the_input_is_the_contact_of_both_bodies(tmp_path: Path) -> None:
    found = build(config(tmp_path))
    grid = found.problem.grid
    one, other = (c.SelfAffine(0.8, 0.1, 8, 32).synthesise(grid, np.random.default_rng(seed)) for seed in (1, 2))
    same = c.Contact(one, found.problem.wall).against(other, shift=(3.5, 0.0), angle=90)
    np.testing.assert_array_equal(found.problem.heights, same.problem.heights)


def test_a_second_body_of_which_no_more_is_said_is_neither_moved_nor_turned(tmp_path: Path) -> None:
    lines = [line for line in TEXT.splitlines() if line.split(" =")[0] in ("shift", "angle")]
    found = build(config(tmp_path, *((line, "") for line in lines)))
    one, other = (
        c.SelfAffine(0.8, 0.1, 8, 32).synthesise(found.problem.grid, np.random.default_rng(s)) for s in (1, 2)
    )
    np.testing.assert_allclose(found.problem.heights, one - other, rtol=0, atol=1e-15)


def test_expected_moments_add_up_as_squares(tmp_path: Path) -> None:
    found = build(config(tmp_path))
    assert found.expected is not None
    grid = found.problem.grid
    alone = c.SelfAffine(0.8, 0.1, 8, 32).expected_moments(grid)
    np.testing.assert_allclose(found.expected, np.sqrt(2) * np.array(alone), rtol=1e-12)
    # Each has its slope exactly: what is left is their correlation, of mean zero.
    squares = [
        build(config(tmp_path, ("seed = 2", f"seed = {s + 2}"))).problem.moments.rms_slope ** 2 for s in range(40)
    ]
    assert np.mean(squares) == pytest.approx(found.expected.rms_slope**2, abs=4 * np.std(squares) / np.sqrt(40))
    assert np.std(squares) > 0


def test_shifts_by_seed_are_spread_over_the_whole_period(tmp_path: Path) -> None:
    shifts = []
    for seed in range(64):
        drawn = config(tmp_path, ("shift = [3.5, 0.0]", f"shift_seed = {seed}"))
        assert drawn.counterface is not None
        shifts.append(drawn.counterface.moved_by(c.Grid.square(48)))
    quarters = {(x // 12, y // 12) for x, y in shifts}
    assert len(quarters) == 16  # of seeds that are fixed: others may miss one
    assert np.mean(shifts) == pytest.approx(24, abs=4 * 48 / np.sqrt(12 * 128))


IMPOSSIBLE = [
    ("angle = 90.0", "angle = 45.0", "counterface.angle = 45.0"),
    ("angle = 90.0", "shift_seed = 3", "counterface.shift = [3.5, 0.0]"),
    ("angle = 90.0", "shift_sed = 3", "counterface.shift_sed"),
    ("shift = [3.5, 0.0]", "shift = [3.5]", "counterface.shift = [3.5]\n    allowed: a list of 2 entries"),
    ("shift = [3.5, 0.0]", "shift = 1.0", "counterface.shift = 1.0\n    allowed: a list of 2 entries"),
    (
        "shift = [3.5, 0.0]",
        "shift = [1.0, 2.0, 3.0]",
        "counterface.shift = [1.0, 2.0, 3.0]\n    allowed: a list of 2 entries",
    ),
    ("shift = [3.5, 0.0]", 'shift = "1.0"', 'counterface.shift = "1.0"\n    allowed: a list of 2 entries'),
    (
        SELF_AFFINE,
        'kind = "sine"\namplitude = 0.1\nwaves = 1\n',
        "surface.waves = 1\n    allowed: a list of 2 entries",
    ),
    (PERIODIC, 'response = "non-periodic-half-space"', "counterface.shift = [3.5, 0.0]\n    allowed: no shift"),
    ("n = 48", "n = [48, 96]", "counterface.angle = 90.0"),
    ("lambda_s = 8.0\nlambda_L = 32.0\nseed = 2", "lambda_s = 1.0\nlambda_L = 32.0\nseed = 2", "lambda_s = 1.0"),
    ("lambda_s = 8.0\nlambda_L = 32.0\nseed = 2", "lambda_s = 8.0\nlambda_L = 64.0\nseed = 2", "lambda_L = 64.0"),
]


def test_what_cannot_be_is_one_clear_message(tmp_path: Path) -> None:
    for old, new, said in IMPOSSIBLE:
        with pytest.raises(ConfigError, match=re.escape(said)):
            config(tmp_path, (old, new))


def test_a_file_of_another_shape_is_refused_by_its_key(tmp_path: Path) -> None:
    np.save(tmp_path / "lower.npy", np.zeros((8, 8)))
    text = TEXT.replace("lambda_L = 64.0", "lambda_L = 32.0")
    lower = '[counterface.surface]\nkind = "file"\npath = "lower.npy"\n'
    text = re.sub(r"\[counterface\.surface\][^[]*", lower, text)
    (tmp_path / "input.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"counterface\.surface\.path"):
        build(load(tmp_path / "input.toml", RunConfig))
