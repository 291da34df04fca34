"""Traces: what LAMMPS wrote of a wall every few steps, and means and standard errors of it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Self

import numpy as np

from atomistic.lammps.protocol import BLOCKS
from continuum.inputs.arguments import ArgumentError, choice, number
from continuum.model.fourier import Real


@dataclass(frozen=True, eq=False)
class WallTrace(Mapping[str, Real]):
    """Samples of a wall in a script, by name: lengths in Å, forces in nN, energies in eV, temperatures in K.

    Shape (samples,) each.  ``distance`` is that of the lowest point of the wall from the surface at rest; ``load`` is
    positive in compression, ``lateral_x`` the force of the wall on the atoms, ``pull_x`` that of a spring on the wall;
    ``taken_by_wall`` is what a wall that moves by its load took from the atoms.
    """

    columns: Mapping[str, Real] = field(repr=False)

    def __getitem__(self, name: str) -> Real:
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.columns["step"])

    def after(self, step: float) -> Self:
        """The samples after a time step, as when the wall has come to rest or slides steadily."""
        late = self.columns["step"] > number("step", step)
        return type(self)({name: values[late] for name, values in self.columns.items()})

    def mean(self, name: str) -> tuple[float, float]:
        """Mean of a quantity and its standard error, of as many samples as make whole blocks, up to the last.

        Raises ArgumentError if there is no such quantity, or there are fewer samples than two for each block.
        """
        return mean_and_error(self._whole(choice("name", name, self.columns)))

    def friction(self, along: Literal["x", "y"] = "x") -> tuple[float, float]:
        """Friction coefficient, mean friction over mean load, and its standard error.

        Raises ArgumentError as :meth:`mean`, or if the mean load is zero.
        """
        drag, load = (self._whole(name) for name in (f"lateral_{choice('along', along, ('x', 'y'))}", "load"))
        mean = float(load.mean())
        if not mean:
            raise ArgumentError("load", mean, "a load, which friction is divided by")
        ratio = float(drag.mean()) / mean
        return ratio, mean_and_error(drag - ratio * load)[1] / abs(mean)

    def _whole(self, name: str) -> Real:
        count = self.samples // BLOCKS * BLOCKS
        if count < 2 * BLOCKS:
            raise ArgumentError("samples", self.samples, f"at least {2 * BLOCKS}, for means and their errors")
        return self.columns[name][self.samples - count :]


def trace_of(path: Path) -> WallTrace:
    """The trace that a wall in a script has written; a last line that is not whole yet does not count.

    Raises ValueError if the file is none.
    """
    with path.open(encoding="utf-8") as file:
        names = _names(file)
        rows = [line.split() for line in file if line.endswith("\n")]
    if not {"step", "load"} <= {*names} or not rows:
        raise ValueError("it is no trace of a wall, or has no samples yet")
    values = np.array(rows, np.float64)
    if values.shape[1] != len(names) or not np.isfinite(values).all():
        raise ValueError("it has numbers that are not finite, or lines of another length")
    return WallTrace(dict(zip(names, values.T.copy(), strict=True)))


def _names(file: Iterator[str]) -> list[str]:
    """Names of columns, from the second line."""
    return [next(file, "") for _ in range(2)][1].split()[1:]


def trace_of_window(path: Path) -> dict[str, Real]:
    """Columns of a ``trace.N.txt`` by the names in its second line, shape (samples,).

    Raises ValueError if it has other columns, or no whole blocks of samples.
    """
    with path.open(encoding="utf-8") as file:
        names = _names(file)
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
