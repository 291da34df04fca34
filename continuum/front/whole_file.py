"""Check what a stored run says beside its states: moments, wall, input, and the numbers that tables are made of.

Readers show these as they show the states, so that a certificate looks at them, too: they are made anew from the input,
and from the stored points and maps, which are checked by themselves.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from continuum.measure.certificate import SINGLE, Check, Examination, moments_of, same_text
from continuum.store import datasets as store
from continuum.store.datasets import Attribute
from continuum.store.hdf5 import understood
from continuum.store.identity import identity
from continuum.store.runs.build import RunSetup
from continuum.store.runs.record import Record
from continuum.store.runs.result import Result
from continuum.store.runs.run import attributes_of, positions_of
from continuum.store.sweeps.measured import COLUMNS, MEASURED_TABLE, measured_columns, numbers_of

EXACT = 1e-12
"""Relative difference of numbers that are the same but for their last digits."""
NEARLY = 1e-9
"""Tolerance of numbers found by other sums or in another version: closed forms replaced integrals to ten digits."""
ITERATED = 1e-5
"""Tolerance of the tangent stiffness, whose solve ends at a residual of 1e-6."""
_READ = frozenset({"schema", "schema_version", "finished", "config_resolved", "quantity"})
"""Attributes without which a file is not read at all, the input, whose hash is the identity, and names of columns."""


@dataclass(frozen=True)
class FileCertificate(Examination):
    """Checks of a file beside its states: of attributes, and of datasets that are not of one point.

    Left out are attributes and datasets, by group.
    """

    path: Path

    @property
    def looked_at(self) -> set[str]:
        """Groups of the attributes and datasets that were looked at."""
        return {check.quantity.partition(":")[0].partition("/")[0] for check in self.checks} | _READ


def certify_file(result: Result, system: RunSetup) -> FileCertificate:
    """Compare what a finished run stores beside its states with its input, its points and its maps."""
    with understood(result.path):
        names = store.read_few(result.path, ("quantity",), ())[0].get("quantity", np.array([])).tolist()
        checks = [*_attributes(result, system), *_datasets(result, system)]
        if names:
            checks += _measured(result, system, names)
    found = FileCertificate(result.path, checks=tuple(checks))
    left_out = {name.partition("/")[0] for name in result.attributes} - found.looked_at
    left_out |= {f"{MEASURED_TABLE}: {name}" for name in COLUMNS if names and name not in names}
    return replace(found, left_out=tuple(sorted(left_out)))


def _attributes(result: Result, system: RunSetup) -> Iterator[Check]:
    """Every attribute that follows from the input; the moments by other sums."""
    record = Record(fields=False, points=list(result.points), events=list(result.events))
    expected: dict[str, Attribute] = {
        **attributes_of(system, identity(result.config)),
        **record.attributes(),
        **{f"realised_{name}": value for name, value in moments_of(system.problem)._asdict().items()},
    }
    for name, value in expected.items():
        # An earlier version may not have stored it, or have had another scale of the tolerance.
        if name in result.attributes and name != "tolerance":
            stored = result.attributes[name]
            if isinstance(value, str) or isinstance(stored, str):
                yield same_text(name, stored, value)
            else:
                yield _of_numbers(name, stored, value, NEARLY)


def _datasets(result: Result, system: RunSetup) -> Iterator[Check]:
    """Positions, heights and knots of the wall, as far as they are stored."""
    axes, problem = positions_of(system), system.problem
    stored = store.read_few(result.path, ("step", "x", "y", "heights", "wall/gap", "wall/traction"), ())[0]
    yield _of_numbers("step", stored["step"], np.arange(len(result.points)), 0.0)
    for name, values in axes.items():
        yield _of_numbers(name, stored[name], values, EXACT)
    if "heights" in stored:
        yield _of_numbers("heights", stored["heights"], problem.heights, 2 * SINGLE)
    for name, values in problem.wall.knots.items():
        yield _of_numbers(f"wall/{name}", stored[f"wall/{name}"], values, EXACT)


def _measured(result: Result, system: RunSetup, names: Sequence[str]) -> Iterator[Check]:
    """The columns of the table of numbers, from the points, their maps and their gaps."""
    twice = sorted({name for name in names if names.count(name) > 1})
    yield same_text("quantity", ", ".join(twice), "")
    found, table = measured_columns(system, result.points, result.repulsive, result.gap), numbers_of(result.path)
    for name in [name for name in found if name in names]:
        allowed = ITERATED if name == "tangent_stiffness" else NEARLY
        yield _of_numbers(f"{MEASURED_TABLE}: {name}", table[name], found[name], allowed)


def _of_numbers(quantity: str, stored: Any, expected: ArrayLike, allowed: float) -> Check:
    """The number that is farthest from what it should be, relative to that or, of an array, to its largest."""
    here, there = np.atleast_1d(np.asarray(stored, dtype=float)), np.atleast_1d(np.asarray(expected, dtype=float))
    if here.shape != there.shape:
        said = f"its shape is {here.shape}, and should be {there.shape}"
        return Check(quantity, np.nan, np.nan, np.inf, 0.0, said)
    if not here.size:
        return Check(quantity, np.nan, np.nan, 0.0, 0.0)
    same = (here == there) | (np.isnan(here) & np.isnan(there))
    with np.errstate(invalid="ignore"):
        off = np.where(same, 0.0, np.abs(here - there))
    off[np.isnan(off)] = np.inf
    worst = int(np.argmax(off))
    scale = float(np.max(np.abs(there), initial=0.0, where=np.isfinite(there)))
    return Check(quantity, float(here.flat[worst]), float(there.flat[worst]), float(off.flat[worst]), allowed * scale)
