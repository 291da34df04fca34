"""The trace of a time window: what LAMMPS wrote every few steps, and means and standard errors of it."""

from pathlib import Path

import numpy as np

from atomistic.lammps.protocol import BLOCKS
from continuum.model.fourier import Real


def read_trace(path: Path) -> dict[str, Real]:
    """Columns of a ``trace.N.txt`` by the names in its second line, shape (samples,).

    Raises ValueError if it has other columns, or no whole blocks of samples.
    """
    with path.open(encoding="utf-8") as file:
        names = [next(file, "") for _ in range(2)][1].split()[1:]
    rows = np.loadtxt(path, ndmin=2)
    rows = rows[rows[:, 0] > 0]  # the state where the window begins is the end of the one before
    if rows.shape[1] != len(names) or len(rows) % BLOCKS or not len(rows):
        raise ValueError(f"{path} does not hold the samples of a whole window")
    if not np.isfinite(rows).all():
        raise ValueError("it has numbers that are not finite: check separation and start")
    return dict(zip(names, rows.T.copy(), strict=True))


def mean_and_error(samples: Real) -> tuple[float, float]:
    """Mean of samples, shape (n,), and its standard error, from the means of :data:`BLOCKS` blocks about their line.

    With b the means of the blocks and t their distances from the middle, the variance about the line is
    <b²> - <b>² - <b t>²/<t²>, <t²> = (BLOCKS² - 1)/12, of which BLOCKS - 2 degrees of freedom are left.
    """
    block = np.reshape(samples, (BLOCKS, -1)).mean(axis=1)
    mean = float(block.mean())
    t = np.arange(BLOCKS) - (BLOCKS - 1) / 2
    rest = float(np.mean((block - mean) ** 2) - np.mean((block - mean) * t) ** 2 / np.mean(t**2))
    return mean, float(np.sqrt(max(rest, 0.0) / (BLOCKS - 2)))
