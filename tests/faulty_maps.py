"""Measured maps with one known fault each, made from a clean self-affine surface: in m, 256 points of 4 nm a side."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from scipy.ndimage import grey_dilation

from continuum.maps.map import Topography
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine

__all__ = ["FAULTS", "PIXEL", "clean", "cut_out", "faulty"]

N, PIXEL = 256, 4e-9


@cache
def cut_out(
    hurst: float = 0.8, lambda_s: float = 6.0, lambda_L: float = 64.0, seed: int = 1, n: int = N, slope: float = 0.1
) -> Real:
    """A part of a larger surface, not periodic, in pixels."""
    grid = Grid.square(2 * n)
    return SelfAffine(hurst, slope, lambda_s, lambda_L).synthesise(grid, np.random.default_rng(seed))[:n, :n]


def clean(seed: int = 1, **options: Any) -> Topography:
    """The surface itself."""
    heights = cut_out(seed=seed, **options) * PIXEL
    return Topography(heights, (heights.shape[0] * PIXEL, heights.shape[1] * PIXEL), source="map")


def faulty(kind: str, seed: int = 1) -> Topography:
    """The surface with one fault; lines run along x."""
    rng, base = np.random.default_rng(seed + 100), clean(seed)
    heights, (lx, ly) = np.array(base.heights), base.lengths
    nx, ny = heights.shape
    x, y = np.linspace(-1, 1, nx)[:, None], np.linspace(-1, 1, ny)[None, :]
    step = np.diff(heights, axis=0).std()
    rms = heights.std()
    if kind == "line noise":
        heights += 2e-9 * rng.normal(size=(1, ny))
    elif kind == "outlier lines":
        heights[:, rng.choice(np.arange(5, ny - 5, 3), 6, replace=False)] += 12 * step
    elif kind == "scars":
        for _ in range(12):
            i, j, long = rng.integers(0, nx - 100), rng.integers(2, ny - 2), rng.integers(20, 100)
            heights[i : i + long, j] += rng.choice([-1, 1]) * 15e-9
    elif kind == "spikes":
        heights[rng.integers(2, nx - 2, 10), rng.integers(2, ny - 2, 10)] += 15e-9
    elif kind == "bow":
        heights += 8 * rms * (x**2 + 0.7 * y**2)
    elif kind == "tilt":
        heights += 30 * rms * (x + 0.5 * y)
    elif kind == "noise":
        heights += 0.35e-9 * rng.normal(size=heights.shape)
    elif kind == "anisotropy":
        heights = cut_out(seed=seed, n=3 * nx)[:nx, ::3] * PIXEL
    elif kind == "non-Gaussian heights":
        heights = rms / 2 * np.sinh(1.3 * heights / rms)
    elif kind == "grooves":
        heights[:, rng.choice(np.arange(5, ny - 5, 3), 6, replace=False)] -= 12 * step
    elif kind == "height steps":
        level = np.ptp(heights) / 24
        heights = level * np.round(heights / level)
    elif kind == "saturation":
        heights = np.clip(heights, *np.quantile(heights, (0.02, 0.98)))
    elif kind == "impossible fit":
        grid = Grid.square(2 * N)
        steep = np.maximum(grid.wavenumber, 2 * np.pi / 64) ** -2.5
        heights = grid.inverse(steep * grid.forward(np.random.default_rng(1).normal(size=grid.shape)))[:nx, :ny]
        heights *= rms / heights.std()
    elif kind == "slope":
        heights *= 100
    elif kind == "pixel":
        return Topography(heights * 1e6, (lx * 1e6, ly * 1e6), source="map")
    elif kind == "tip":
        fine = np.array(heights)
        reach = np.arange(-12, 13)
        tip = -(reach[:, None] ** 2 + reach[None, :] ** 2) * PIXEL**2 / (2 * 100e-9)
        heights = grey_dilation(fine, structure=tip)
    return Topography(heights, (lx, ly), source="map")


FAULTS = (
    "line noise",
    "outlier lines",
    "scars",
    "spikes",
    "bow",
    "tilt",
    "noise",
    "anisotropy",
    "non-Gaussian heights",
    "tip",
    "grooves",
    "height steps",
    "saturation",
    "impossible fit",
    "slope",
    "pixel",
)
