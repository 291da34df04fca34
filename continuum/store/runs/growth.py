"""Reuse of a stored path by a run with other targets, another way back or another tolerance.

Points are reused as far as both paths agree.  The next point needs the full state of the last of them; a finer
tolerance needs the states of all points, and starts each from its own.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from itertools import takewhile
from pathlib import Path

import numpy as np

from continuum.measure.contact import Equilibrium, shared
from continuum.path.state import PathState
from continuum.solve.solution import Solution, Status
from continuum.store import datasets as store
from continuum.store.hdf5 import StoreError, understood
from continuum.store.identity import former_settings, identity, restored, with_values
from continuum.store.runs.config import RunConfig
from continuum.store.runs.record import Point, points_of

SMALL = 64**2
"""Points of a grid up to which the state of a path of one point is not stored: its solve takes less time."""
_FEW = ("contact_identity", "config_resolved", "identity")
_NUMBERS = ("step", *(column.name for column in fields(Point)))


@dataclass(frozen=True)
class Growth:
    """The part of a stored path that another run uses."""

    source: Path
    """File of the stored path."""
    identity: str
    """Identity of its run."""
    kept: int = 0
    """Number of points that are used unchanged."""
    refined: int = 0
    """Number of points that are solved to a finer tolerance, each from its stored state."""
    whole: bool = False
    """Whether the whole stored path is used, or the one point of a small grid found again."""


def contact_identity(config: RunConfig) -> str:
    """Hash of everything but the path and the tolerance, which two runs of one contact have in common."""
    content = config.plain(identity=True)
    content["loading"] = {config.loading.renamed["threshold"]: config.loading.threshold}
    content["solver"] = {key: value for key, value in content["solver"].items() if key != "tolerance"}
    text = json.dumps([config.result_schema, config.result_version, content], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def growth_of(config: RunConfig, source: Path) -> Growth | None:
    """The part of a stored run that another run can use; None if nothing, or if the contact differs."""
    try:
        held, found = store.read_few(source, ("step", "restart/target"), _FEW)
        if found.get("contact_identity") != contact_identity(config):
            return None
        with understood(source):
            earlier = restored(RunConfig, str(found["config_resolved"]))
            done, identity = len(held["step"]), str(found["identity"])
    except StoreError:
        return None  # damaged, or of another version
    asked = config.loading.points
    yields, searched = np.isfinite(config.wall.hardness), config.loading.threshold is not None
    both = zip(config.loading.aims, earlier.loading.aims, strict=False)
    alike = min(done, sum(1 for _ in takewhile(lambda two: two[0] == two[1], both)))
    if config.output.fields and not earlier.output.fields:
        return None
    if config.solver.tolerance < earlier.solver.tolerance:
        usable = alike and earlier.output.fields and not yields and not searched
        return Growth(source, identity, refined=alike) if usable else None
    goes_on = alike == done and ("restart/target" in held or searched)
    ends = alike == asked and not yields
    if alike == done == 1 and not (goes_on or ends) and config.grid.build().size <= SMALL:
        return Growth(source, identity, whole=True)
    if not alike or not (goes_on or ends):
        return None
    return Growth(source, identity, kept=alike, whole=alike == done)


def as_begun(config: RunConfig, source: Path) -> tuple[RunConfig, str]:
    """An input with the defaults that its stored result was begun with, and their last day; none if those of today.

    That result has the same identity then, or its path can be used.
    """
    try:
        stored = store.read_few(source, (), ("identity",))[1].get("identity")
    except StoreError:
        return config, ""
    if stored == identity(config) or growth_of(config, source) is not None:
        return config, ""
    for until, values in former_settings(config):
        former = with_values(config, values)
        if stored == identity(former) or growth_of(former, source) is not None:
            return former, until
    return config, ""


def growths(configs: Mapping[str, RunConfig], stored: Iterable[Path]) -> dict[str, Growth]:
    """For each run, by its key, the stored path of which it can use most, if any."""
    by_contact: dict[str, list[Path]] = {}
    for path in stored:
        try:
            contact = store.read_few(path, (), _FEW[:1])[1].get("contact_identity")
        except StoreError:
            continue
        by_contact.setdefault(str(contact), []).append(path)
    found: dict[str, Growth] = {}
    for key, config in configs.items() if by_contact else ():
        candidates = (growth_of(config, path) for path in by_contact.get(contact_identity(config), ()))
        usable = [one for one in candidates if one is not None]
        if usable:
            found[key] = max(usable, key=lambda one: (one.kept, one.refined))
    return found


def stored_state(source: Path, step: int) -> PathState | None:
    """The stored state of a point, from its gap in single precision; None if it did not converge."""
    file = store.read_datasets(source, RunConfig.result_schema, RunConfig.result_version, _NUMBERS)
    with understood(source):
        point = points_of(file)[step]
    gap = store.read_part(source, "gap", step)
    if not point.converged or gap is None or not np.isfinite(gap).all():
        return None
    solution = Solution(gap.astype(np.float64), Status.CONVERGED, point.residual, 0)
    return PathState(**shared(Equilibrium, point), solution=solution)
