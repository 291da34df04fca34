"""A small run, as an input file."""

from __future__ import annotations

from pathlib import Path

import pytest

SMALL = """\
# a comment
[grid]
n = [24, 30]
period = [24, 30]

[surface]
kind = "self-affine"
hurst = 0.8
rms_slope = 0.1
lambda_s = 6.0
lambda_L = 12.0
seed = 3

[wall]
law = "lennard-jones-spline"
adhesion_length = 0.005

[substrate]
response = "half-space"
mean = "clamped"

[loading]
control = "mean-gap"
targets = [1.6, 1.4,
           1.2]
retract = true

[output]
fields = true
"""


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """The input file of a run of five points that takes a fraction of a second."""
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path
