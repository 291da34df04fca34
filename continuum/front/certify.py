"""Stored results certified: do their states satisfy the equations, by means that took no part in finding them?"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from continuum.arguments import count, file_name, function
from continuum.files.hdf5 import StoreError
from continuum.runs.certify import PointCertificate, certify_run
from continuum.show.sheet import Column, Sheet
from continuum.sweeps.folder import Folder
from continuum.sweeps.sweep import systems_of


@dataclass(frozen=True)
class Certificate:
    """What was certified of a run, or of a sample of a sweep."""

    points: tuple[PointCertificate, ...]
    read: int
    """Number of files that were looked at."""

    @property
    def faults(self) -> tuple[str, ...]:
        """What does not agree, with file and point; none if all is sound."""
        return tuple(f"{one.path}, step {one.step}: {fault}" for one in self.points for fault in one.faults)

    @property
    def ok(self) -> bool:
        """Whether all points are sound."""
        return not self.faults

    def _repr_html_(self) -> str:
        return self.sheet()._repr_html_()

    def sheet(self) -> Sheet:
        """One row for each point."""
        columns = (
            Column("file"), Column("step"), Column("A_rep/A0"), Column("off", "", ".1e"), Column("N/A0", "E*", ".4e"),
            Column("off", "E*", ".1e"), Column("residual", "E*", ".2e"), Column("allowed", "E*", ".1e"),
            Column("curvature", "E*/a0", ".3g"), Column(""),
        )  # fmt: skip
        rows = []
        for one in self.points:
            at, found = one.point, one.found
            rows.append(
                (one.path.stem, one.step, at.area_rep, found.area_rep - at.area_rep, at.load, found.load - at.load,
                 found.residual, one.allowed, found.curvature, "sound" if not one.faults else "; ".join(one.faults))
            )  # fmt: skip
        again = "; states were computed again, as the files hold no gaps" if any(p.again for p in self.points) else ""
        title = f"{len(self.points)} states of {self.read} files, evaluated by other means{again}"
        return Sheet.of(title, columns, rows)


def certify(
    path: str | Path,
    *,
    sample: int = 3,
    seed: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Certificate:
    """Evaluate stored states by other transforms, sums and derivatives than the solver's, and compare.

    Residual, area and load follow from heights and gap alone; the energy is looked at along random displacements.  Runs
    that store fields are certified from these; the others are followed again, and what is stored is compared with that.

    Parameters
    ----------
    path : a stored run, or the folder of a sweep.
    sample : number of systems of a sweep that are certified, drawn at random.
    seed : of that draw.
    progress : called after each file with how many are done and how many there are.

    Raises
    ------
    StoreError
        If a file is no finished run, or what its input names is gone.
    SweepError
        If the folder is no sweep.
    ArgumentError
        If an argument is not allowed.
    """
    given = file_name("path", path)
    count("sample", sample)
    count("seed", seed, least=0)
    function("progress", progress)
    files = _sample(given, sample, seed) if given.is_dir() else [given]
    points: list[PointCertificate] = []
    for done, file in enumerate(files, 1):
        points += certify_run(file)
        if progress is not None:
            progress(done, len(files))
    return Certificate(tuple(points), len(files))


def _sample(root: Path, sample: int, seed: int) -> list[Path]:
    folder, listing = Folder(root), systems_of(root)
    done = [path for system in listing.systems if (path := folder.point(system.key)).is_file()]
    if not done:
        raise StoreError(f"{root}: no system of this sweep is done")
    chosen = np.random.default_rng(seed).choice(len(done), min(sample, len(done)), replace=False)
    return [done[i] for i in sorted(chosen)]
