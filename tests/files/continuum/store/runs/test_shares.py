"""What `check` says of the devices of a divided contact."""

import pytest

from continuum.front.runs import check
from continuum.inputs.toml import ConfigError
from continuum.store.runs.config import Share

INPUT = {
    "grid": {"n": [64, 48]},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 8.0, "lambda_L": 32.0, "seed": 1},
    "wall": {"law": "hard"},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "mean-pressure", "targets": [0.01]},
}


def test_check_says_what_each_device_holds_and_sends() -> None:
    rows = {row[0]: row[1:] for row in check(INPUT | {"solver": {"device": "jax", "shards": 4}}).sheet.cells}
    # 16 fields of doubles; of 25 columns, 28 for four equal parts, each device has 7, of which it keeps a quarter.
    assert float(rows["memory on each of 4 devices, about"][0]) == pytest.approx(16 * 8 * 64 * 48 / 4 / 2**20, rel=1e-3)
    assert float(rows["sent by each of them, about"][0]) == pytest.approx(2 * 16 * 64 * 7 * 3 / 4 / 2**20, rel=1e-3)
    assert not [name for name in (row[0] for row in check(INPUT).sheet.cells) if "devices" in name]


def test_shares_are_those_of_one_device_where_nothing_is_divided() -> None:
    assert Share(1, 100, 60, 22.0).sent == 0
    assert Share(1, 100, 60, 22.0).memory == 17600


def test_slabs_that_are_not_equal_are_refused() -> None:
    with pytest.raises(ConfigError, match="a divisor of the 64 points along x"):
        check(INPUT | {"solver": {"device": "jax", "shards": 3}})
    with pytest.raises(ConfigError, match='"jax" where shards is above 1'):
        check(INPUT | {"solver": {"shards": 2}})
