"""The map of docs/tutorials/map.md: a polished wafer as an atomic force microscope shows it, made and not measured.

``python -m docs.studies.map_of_the_tutorial`` writes inputs/maps/wafer.txt again.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine

__all__ = ["HEAD", "MAP", "PIXEL", "heights", "write"]

MAP = Path(__file__).parents[2] / "inputs" / "maps" / "wafer.txt"
N, PIXEL = 192, 2.0
"""Points a side, and their distance in nm."""
HEAD = (
    "Made by docs/studies/map_of_the_tutorial.py of stickiness, not measured; MIT licence.\n"
    f"Heights in nm, {N} x {N} points of a square of {N * PIXEL:g} nm."
)


def heights(seed: int = 7) -> Real:
    """Heights in nm: a part of a self-affine surface, tilted as a sample lies, with eight scars along x."""
    rng = np.random.default_rng(seed)
    surface = SelfAffine(hurst=0.8, rms_slope=0.05, lambda_s=5, lambda_L=48)
    found = PIXEL * surface.synthesise(Grid.square(2 * N), rng)[:N, :N]
    rms, x = found.std(), np.linspace(-0.5, 0.5, N)
    found += rms * (8 * x[:, None] - 4 * x[None, :])
    for _ in range(8):
        first, line, length = rng.integers(0, N - 80), rng.integers(2, N - 2), rng.integers(20, 80)
        found[first : first + length, line] += rng.choice([-1, 1]) * 2 * rms
    return found - found.mean()


def write(path: Path = MAP) -> None:
    """The map as text, to 0.01 nm, with x along a line."""
    np.savetxt(path, heights().T, fmt="%.2f", header=HEAD, encoding="utf-8")


if __name__ == "__main__":
    write()
