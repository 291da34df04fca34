"""Shares that are said of a fault: on a wave of a known slope, with line offsets, a plane or a bowl of known size."""

from __future__ import annotations

import re

import numpy as np
import pytest

from continuum.maps import faults
from continuum.maps.faults import find_faults
from continuum.maps.map import Topography
from tests.kinds import covering

ERROR = 3.3
"""Relative standard error of the share, times the root of the number of lines.

The share is that of the square of a robust standard deviation, s.  From N independent Gaussian numbers the median
absolute deviation gives s to 1.17/√N; bends of independent offsets have correlations of -2/3 and 1/6 with the next two,
which multiplies the variance by at most 1 + 2 (4/9 + 1/36); and a square has twice the relative error."""


def share_of_noise(share: float, points: int, spacing: float) -> float:
    """Standard deviation of the offsets that are this share of the mean square slope, beside the wave of `scan`.

    Offsets of a standard deviation s have neighbours that differ by 2 s² in the mean square, and the wave, of amplitude
    a and phase φ from line to line, a² (1 - cos φ).
    """
    wave = AMPLITUDE**2 * (1 - np.cos(2 * np.pi * WAVES / points))
    return float(np.sqrt(share / (1 - share) * wave / 2)) * spacing


AMPLITUDE, WAVES = 3.0, 40
"""In spacings of the lines, and periods over all lines."""


def scan(lines: int, along: int, spacing: tuple[float, float], share: float, seed: int) -> Topography:
    """A plane wave at an angle to the lines, which run along x: the median of each line is its offset."""
    i, j = np.arange(along)[:, None], np.arange(lines)[None, :]
    wave = AMPLITUDE * spacing[1] * np.cos(2 * np.pi * (4 * i / along + WAVES * j / lines))
    noise = share_of_noise(share, lines, spacing[1]) * np.random.default_rng(seed).normal(size=(1, lines))
    return Topography(wave + noise, (along * spacing[0], lines * spacing[1]), periodic=True, source="scan")


def found(topography: Topography) -> tuple[str, float, float]:
    """Direction of the lines, displacement in m and share, as they are said."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(faults, "ROUGHENING", ())  # what is looked for once lines are level
        text = next(fault.text for fault in find_faults(topography).faults if fault.kind == "line noise")
    said = re.fullmatch(r"lines along ([xy]) displaced by ([\d.e+-]+) (\w+) \(rms\), (\d+) % of the .*", text)
    assert said is not None, text
    units = {"pm": 1e-12, "nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0}
    return said[1], float(said[2]) * units[said[3]], float(said[4]) / 100


@pytest.mark.parametrize(
    ("of", "share"),
    covering(
        [(1024, 64, (4e-9, 4e-9)), (2048, 32, (2e-9, 2e-9)), (2048, 48, (1e-9, 5e-9)), (4096, 40, (3e-7, 1e-7))],
        [0.1, 0.3, 0.6, 0.9],
    ),
)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_the_share_of_line_noise_is_that_of_the_offsets(
    of: tuple[int, int, tuple[float, float]], share: float, seed: int
) -> None:
    """Of so many lines, of so many points, and steps along and across them."""
    lines, along, spacing = of
    topography = scan(lines, along, spacing, share, seed)
    axis, displaced, said = found(topography)
    assert axis == "x"
    # Three standard errors, which at 1024 lines are 31 %: half or twice the share is far outside; and half a per cent
    # of rounding.  More than all of the slope is said to be all.
    assert said == pytest.approx(share, abs=3 * ERROR / np.sqrt(lines) * share + 0.005)
    # The standard deviation has half the error of its square.
    expected = share_of_noise(share, lines, spacing[1])
    assert displaced == pytest.approx(expected, rel=1.5 * ERROR / np.sqrt(lines) + 0.005)


def test_the_mean_over_many_scans_pins_the_factor() -> None:
    """A tenth more or less in it would show."""
    shares = [found(scan(1024, 32, (1e-9, 1e-9), 0.3, seed))[2] for seed in range(20)]
    # A robust estimate from 1022 bends is biased by less than a per cent; the scatter falls with √20.
    assert np.mean(shares) == pytest.approx(0.3, abs=3 * ERROR / np.sqrt(1024 * 20) * 0.3 + 0.005)
    assert np.std(shares) < ERROR / np.sqrt(1024) * 0.3


def test_the_lines_may_run_along_y_and_the_unit_does_not_matter() -> None:
    topography = scan(1024, 64, (4e-9, 4e-9), 0.3, 1)
    axis, displaced, share = found(topography)
    turned = Topography(topography.heights.T.copy(), topography.lengths[::-1], periodic=True)
    assert found(turned) == ("y", displaced, share)
    large = Topography(1e3 * topography.heights, (1e3 * topography.lengths[0], 1e3 * topography.lengths[1]), True)
    assert found(large) == (axis, pytest.approx(1e3 * displaced, rel=1e-2), share)


@pytest.mark.parametrize("share", [0.8, 0.9, 0.99])
@pytest.mark.parametrize(("kind", "remedy"), [("tilt", "plane"), ("bow", "curvature")])
def test_the_share_of_a_plane_or_a_bowl_is_that_of_its_variance(kind: str, remedy: str, share: float) -> None:
    """Beside a wave that is orthogonal to both, as it is even and has whole periods."""
    n = 256
    x, y = (np.expand_dims((np.arange(n) - (n - 1) / 2) / n, 1 - axis) for axis in (0, 1))
    shape = x + 0.5 * y if kind == "tilt" else x**2 - np.mean(x**2) + 0.5 * x * y
    # Along the diagonal: the mean of each line vanishes, so that x, y and x² are orthogonal to it; its mean with xy is
    # 1/(2 π 16)², one part in ten thousand.
    wave = np.cos(2 * np.pi * 16 * (x + y))
    bowl = shape * np.sqrt(share / (1 - share) * np.var(wave) / np.var(shape))
    seen = find_faults(Topography(1e-9 * (wave + bowl), (1e-6, 1e-6), source="map")).faults
    fault = next(fault for fault in seen if fault.kind == kind)
    said = float(fault.text.split(" %")[0]) / 100
    # To the whole per cent that is said, and ten times that overlap.
    assert said == pytest.approx(share, abs=0.005 + 1e-3)
    assert fault.remedy == {"detrend": remedy}
