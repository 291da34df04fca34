"""A stored run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from continuum.arguments import count
from continuum.files import store
from continuum.files.hdf5 import StoreError, understood
from continuum.files.store import Attribute
from continuum.files.tables import restored
from continuum.measure.contact import ATTRACTED, REPULSIVE
from continuum.measure.outline import Mask
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import Moments
from continuum.model.walls import Wall
from continuum.runs.config import RunConfig
from continuum.runs.record import EVENT_DATASETS, FLAGS, PathEvent, Point, events_of, points_of

if TYPE_CHECKING:
    import xarray

    from continuum.runs.analysis import Analysis
    from continuum.show.sheet import Sheet


@dataclass(frozen=True, eq=False)
class Result:
    """A run on disk: numbers in memory, maps and fields read from the file on demand."""

    path: Path
    config: RunConfig = field(repr=False)
    """Input with defaults; of other files that it reads only the names."""
    attributes: Mapping[str, Attribute] = field(repr=False)
    points: tuple[Point, ...]
    """Points of the path, converged or not."""
    events: tuple[PathEvent, ...]
    """Jumps on the path."""
    wall: Wall
    resumed: int = 0
    """Number of points that were stored before this call."""
    seconds: float = 0.0
    """Wall time of that call."""

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a stored run; raises StoreError if the file is missing, damaged or no run."""
        path = Path(path)
        names = {column.name for column in fields(Point)} | {*EVENT_DATASETS, "step", "wall/gap", "wall/traction"}
        file = store.read_datasets(path, RunConfig.result_schema, RunConfig.result_version, names)
        with understood(path):
            config = restored(RunConfig, str(file.attributes["config_resolved"]))
            wall = stored_wall(path, config, file)
            found = cls(path, config, file.attributes, points_of(file), events_of(file), wall)
            # What is derived from the file later is derived once here, where damage is an error of reading.
            _ = found.identity, found.finished, found.grid, found.moments
        return found

    def __repr__(self) -> str:
        good = sum(point.converged for point in self.points)
        return f"Result({str(self.path)!r}, {len(self.points)} points, {good} converged, {len(self.events)} jumps)"

    def _repr_html_(self) -> str:
        return "".join(sheet._repr_html_() for sheet in self.sheets())

    @property
    def identity(self) -> str:
        """Hash of the physics and of the solver's settings."""
        return str(self.attributes["identity"])

    @property
    def finished(self) -> bool:
        """Whether every point of the path is there."""
        return bool(self.attributes["finished"])

    @property
    def converged(self) -> bool:
        """Whether there are points, and each is an equilibrium at its target."""
        return bool(self.points) and all(point.converged for point in self.points)

    @cached_property
    def grid(self) -> Grid:
        return self.config.grid.build()

    @property
    def moments(self) -> Moments:
        """Spectral moments of the heights."""
        return Moments(*(float(self.attributes[f"realised_{name}"]) for name in Moments._fields))

    def repulsive(self, index: int) -> Mask:
        """The cells of A_rep of a point, shape ``grid.shape``.

        Points are counted from 0, or from the last one, -1, as in Python; ArgumentError if there is no such point.
        """
        return self._mask("repulsive", index)

    def contact_map(self, index: int) -> NDArray[np.uint8]:
        """REPULSIVE, ATTRACTED or OUT_OF_RANGE at each cell, shape ``grid.shape``; points as :meth:`repulsive`."""
        pushed, pulled = self._mask("repulsive", index), self._mask("attracted", index)
        return REPULSIVE * pushed.astype(np.uint8) + ATTRACTED * pulled.astype(np.uint8)

    def _place(self, index: int) -> int:
        """Place of a point in the file."""
        points = len(self.points)
        return count("index", index, -points, points - 1, why=f"the run has {points} points") % points

    def _mask(self, name: str, index: int) -> Mask:
        packed = store.read_part(self.path, name, self._place(index))
        if packed is None:
            raise StoreError(f"{self.path}: holds no map {name!r}")
        nx, ny = self.grid.shape
        if packed.shape != (nx, (ny + 7) // 8) or packed.dtype != np.uint8:
            raise StoreError(f"{self.path}: the map {name!r} is not one of the points of the grid")
        return store.unpack(packed, ny)

    def gap(self, index: int) -> Real | None:
        """Gap of a point, shape ``grid.shape``, in a0, from single precision; None if the run did not store gaps.

        Points as :meth:`repulsive`.
        """
        stored = store.read_part(self.path, "gap", self._place(index))
        return None if stored is None else stored.astype(np.float64)

    def heights(self) -> Real | None:
        """Heights of the wall, shape ``grid.shape``, in a0, from single precision; None if the run stored no fields."""
        names = {"heights"}
        file = store.read_datasets(self.path, RunConfig.result_schema, RunConfig.result_version, names)
        return file["heights"].astype(np.float64) if names <= set(file.datasets) else None

    def analyse(self) -> Analysis:
        """Measure all stored equilibria: patches, perimeter, κ, gap profile, pull-off."""
        from continuum.runs.analysis import analyse_run

        return analyse_run(self)

    def sheets(self) -> list[Sheet]:
        """Its points and its jumps."""
        from continuum.show.runs import run_sheets

        return run_sheets(self)

    def plot(self, folder: Path | None = None) -> list[Path]:
        """Draw its figures, beside it or into a folder; returns the PNG files."""
        from continuum.show.run_figures import draw_run

        return draw_run(self, folder)

    def to_xarray(self) -> xarray.Dataset:
        """Open the file with xarray: axes (step, x, y), contact maps as booleans, words as CF flags; read lazily.

        Raises ImportError if xarray and h5netcdf are not installed: ``pip install 'stickiness[xarray]'``.
        """
        try:
            from continuum.files.labelled import open_labelled
        except ImportError as error:
            raise ImportError("xarray is an extra: pip install 'stickiness[xarray]'") from error
        return open_labelled(self.path, FLAGS)


def stored_wall(path: Path, config: RunConfig, file: store.File) -> Wall:
    """The wall of a stored run; raises StoreError if it is a table that the file does not contain."""
    names = (name for name in file.datasets if name.startswith("wall/"))
    try:
        return config.wall.restored({name.removeprefix("wall/"): file[name] for name in names})
    except KeyError as error:
        msg = f"{path}: lacks the table of its wall, which older versions did not store: run it again"
        raise StoreError(msg) from error
