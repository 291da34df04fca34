"""Kinds of walls and surfaces that an input knows: those of the model, and those read from a file of their own."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from continuum.inputs.keys import InputFile
from continuum.inputs.tables import Fault, constraint
from continuum.model import surfaces as surfaces
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import Surface
from continuum.model.walls import TabulatedWall, Wall
from continuum.store.heights import HDF5_SUFFIXES, read_map, stands_for_nothing
from continuum.store.text import read_text


class TableWall(Wall, kind="table"):
    """[wall] of law "table"."""

    path: InputFile
    """text, two columns: gap in a0 (increasing) and traction in E* (compression positive, zero at the end)"""

    def build(self) -> Wall:
        """The law; raises ValueError or OSError if the file is not a table of a wall."""
        columns = read_text(self.path).rows
        if columns.shape[1] != 2:
            raise ValueError(f"{self.path} has {columns.shape[1]} columns, a wall has 2: gap and traction")
        return TabulatedWall(columns[:, 0], columns[:, 1])

    def restored(self, stored: Mapping[str, Any]) -> Wall:
        return TabulatedWall(stored["gap"], stored["traction"])


class FileSurface(Surface, kind="file"):
    """[surface] of kind "file": heights from a file."""

    path: InputFile
    """heights in a0, one number per point of the grid: .npy, .h5/.hdf5 (first index x), or text (x along a line)"""
    dataset: str | None = None
    """name of the dataset in an HDF5 file"""

    @constraint
    def _dataset(self) -> Iterator[Fault]:
        hdf5 = self.path.suffix.lower() in HDF5_SUFFIXES
        if hdf5 and self.dataset is None:
            yield Fault(("dataset",), "the name of a dataset, which an HDF5 file needs")
        if not hdf5 and self.dataset is not None:
            yield Fault(("dataset",), f"only with an HDF5 file ({', '.join(sorted(HDF5_SUFFIXES))})")

    def build(self, grid: Grid) -> Real:
        """The heights; raises ValueError or OSError unless the file has finite numbers of the grid's shape."""
        found = read_map(self.path, self.dataset, grid.shape)
        for what, its in (("size", found.size), ("unit", found.unit)):
            if its is not None:
                raise ValueError(
                    f"{self.path}: the file itself says the {what} of the map in real units, and heights of a run are "
                    "in a0: divide by a0, and leave it out of the file"
                )
        if found.extent is not None and not np.allclose(found.extent, grid.lengths, rtol=1e-3, atol=0):
            extent = " x ".join(f"{length:.6g}" for length in found.extent)
            raise ValueError(f"{self.path}: the positions in the file are those of {extent}, not of the period, in a0")
        heights = found.heights
        missing = np.count_nonzero(~np.isfinite(heights))
        if missing:
            raise ValueError(f"{missing} of the {heights.size} heights in {self.path} are not finite numbers")
        if asked := stands_for_nothing(heights):
            raise ValueError(f"{self.path}: {asked[1]} heights are {asked[0]:.10g}, far from all others: missing?")
        return heights if heights.shape == grid.shape_here else heights[grid.rows]
