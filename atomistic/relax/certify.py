"""Check whether the states of a deck run are equilibria, independently of the run.

The wall is the law of :mod:`continuum` at the heights of the deck, not formulas or a plugin of LAMMPS; the forces of
the crystal come from a new LAMMPS without wall at the final positions; all sums are NumPy's.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from atomistic.lammps.deck import heights_above
from atomistic.lammps.directory import finished_steps
from atomistic.lammps.law import law_of_atoms
from atomistic.lammps.result import DeckError, DeckResult, read_result
from atomistic.lammps.session import Session
from atomistic.relax.deckrun import DeckSteps
from continuum.measure.certificate import Check, Examination, minimum
from continuum.measure.contact import ATTRACTED, REPULSIVE, contact_map
from continuum.model.eigenvalue import Lowest, lowest_eigenvalue
from continuum.model.fourier import Real
from continuum.model.walls import Wall
from continuum.store.sheet import Column, Sheet, Shown, quantities

ENOUGH = 1.5
"""Factor by which the largest force may exceed tolerance and rounding, as sums have another order."""
STEP = 1e-5
"""Root-mean-square of the displacements along which forces are differentiated, in a0."""
RESOLVED = 0.05
"""Residual of the eigenvector at which to stop, relative to the stiffness of the softest wave of the slab."""
_FORCE = "recomputed largest force"
"""Name of the check of the force that is left; the stored ``largest_force`` is not compared with it."""
_STIFFEST = 10.0
"""Largest derivative of a force by a displacement, in E* a0, which gives the error by rounded positions."""
_LAST = 1e-12
"""Relative difference of numbers that are the same but for their last digits, which other sums change."""


@dataclass(frozen=True)
class StepCertificate(Examination):
    """An equilibrium of a deck with what was looked at; nothing of a step that is no equilibrium by what is stored.

    Left out are numbers of the result, and "curvature" where the eigenvalue is within its error of zero.
    """

    stored: DeckResult


@dataclass(frozen=True)
class DeckCertificate(Shown):
    """Result of checking a deck run.

    Of each equilibrium it compares gap and traction of each atom, force, energy of the wall, smallest gap, A_rep,
    A_att, lateral forces (zero), core of the law, largest force left and lowest eigenvalue.  It does not look at the
    total energy, the separation (from which the gaps are computed), offsets, the force that was asked for, evaluations
    and versions.
    """

    directory: Path
    steps: tuple[StepCertificate, ...]
    """Certificates of the equilibria."""
    unconverged: tuple[str, ...] = ()
    """Steps that are no equilibria by what is stored, and were not looked at."""

    @property
    def faults(self) -> tuple[str, ...]:
        """Disagreements with their steps; empty if all agree."""
        if not self.steps:
            return (f"{self.directory}: nothing was looked at: no step is an equilibrium",)
        return tuple(
            f"{self.directory}, step {max(one.stored.step, 1)}: {fault}" for one in self.steps for fault in one.faults
        )

    @property
    def ok(self) -> bool:
        """True if something was looked at, and all of it is sound."""
        return not self.faults

    def sheets(self) -> list[Sheet]:
        """One row for each equilibrium, and one for each quantity."""
        return [self.sheet(), quantities(self.steps)]

    def sheet(self) -> Sheet:
        """One row for each equilibrium."""
        columns = (
            Column("step"), Column("A_rep/A0"), Column("N/A0", "E*", ".4e"), Column("largest force", "E* a0²", ".2e"),
            Column("lowest eigenvalue", "E* a0", ".3g"), Column("checks"), Column(""),
        )  # fmt: skip
        rows = [
            (max(one.stored.step, 1), one.stored.area_rep, one.stored.force / one.stored.gap.size,
             one.found_of(_FORCE), one.found_of("curvature"), len(one.checks),
             "; ".join(one.faults) or "sound")
            for one in self.steps
        ]  # fmt: skip
        steps = len(self.steps) + len(self.unconverged)
        title = f"{len(rows)} of {steps} equilibria of atoms, checked independently of the run"
        return Sheet.of(title, columns, rows, "\n".join(f"not looked at: {one}" for one in self.unconverged))


def certify_deck(run: DeckSteps) -> DeckCertificate:
    """Check each equilibrium of a deck run.

    Raises DeckError if it has windows of a motion, or its wall is not a function of the lattice site; LammpsError if
    LAMMPS cannot be loaded, or cannot read the slab.
    """
    directory, steps, unconverged = run.directory, list[StepCertificate](), list[str]()
    if not run.last.slab.one_to_one:
        raise DeckError(f"{directory}: its slab is {run.last.slab.name}; only one of fcc(100) can be certified")
    # What a deck says of its formulas.
    table = (directory / "wall.table").read_text(encoding="utf-8")
    said = re.search(r"differ from the law by at most (\S+) E\*", table)
    law_error = float(said[1]) if said else 0.0
    with Session(directory) as crystal:
        level = crystal.rest[: crystal.slab.mobile, ..., 2]
        for step in finished_steps(directory):
            found = read_result(directory, step)
            if found.averages:
                raise DeckError(
                    f"{directory}: has windows of a motion, which are not equilibria and cannot be certified"
                )
            if not np.allclose(found.heights, run.heights, rtol=0, atol=1e-12):
                raise DeckError(
                    f"{directory}: its wall follows the atoms; only walls of lattice sites can be certified"
                )
            if found.status.ok:
                above = heights_above(found.slab, found.heights, run.heights)
                bare = found.separation + above.reshape(-1, *found.slab.shape) - (level - run.description.surface)
                steps.append(_certified(crystal, run.wall, found, bare, law_error))
            else:
                unconverged.append(f"step {max(step, 1)}: {found.status.value}")
    return DeckCertificate(directory, tuple(steps), tuple(unconverged))


def _certified(crystal: Session, wall: Wall, found: DeckResult, bare: Real, law_error: float) -> StepCertificate:
    """A state, with the gaps of all mobile atoms at rest below the wall, shape (layers, nx, ny)."""
    at, mobile, law = found.displacements, found.slab.mobile, law_of_atoms(wall, found.slab.layer)

    def gap(displacements: Real) -> Real:
        return np.asarray(bare - displacements[:mobile, ..., 2])

    def forces(displacements: Real) -> Real:
        """Forces of crystal and wall on the mobile atoms, in E* a0²."""
        acting = crystal.evaluate(displacements)[1][:mobile]
        acting[..., 2] -= law.evaluate(gap(displacements)).traction
        return acting

    def hessian(along: Real) -> Real:
        change = np.zeros_like(at)
        size = float(np.sqrt(np.mean(along**2)))
        change[:mobile] = STEP / size * along
        product: Real = (forces(at - change) - forces(at + change)) * (size / (2 * STEP))
        return product

    largest = float(np.sqrt((forces(at) ** 2).sum(axis=-1)).max())
    lowest = _lowest(found, np.maximum(-law.evaluate(gap(at)[0]).stiffness, 0.0), hessian)
    allowed = ENOUGH * (found.tolerance + law_error + _STIFFEST * _rounding(found))
    force = Check(_FORCE, np.nan, largest, largest, allowed, "too large for an equilibrium")
    checks = [*wall_checks(wall, law, found, gap(at), law_error), force]
    if not abs(lowest.eigenvalue) <= lowest.error:
        checks.append(minimum(lowest.eigenvalue))
    names = {one.name for one in fields(DeckResult) if one.metadata} | {"curvature"}
    left_out = tuple(sorted(names - {check.quantity for check in checks}))
    return StepCertificate(found, checks=tuple(checks), left_out=left_out)


def _rounding(found: DeckResult) -> float:
    """Rounding of positions, in a0."""
    return float(np.finfo(float).eps) * max(found.slab.grid.lengths)


def wall_checks(wall: Wall, law: Wall, found: DeckResult, gap: Real, law_error: float) -> Iterator[Check]:
    """Numbers from the gap of each atom and the law, with the errors of the deck's formulas and of rounding."""
    here, kinds, moved = law.evaluate(gap), contact_map(wall, gap), ENOUGH * _rounding(found)
    off = law_error + moved * float(np.abs(here.stiffness).max()) + _LAST
    apart = float(np.abs(found.gap - gap[0]).max())
    yield Check("gap of an atom", float(found.gap.mean()), float(gap[0].mean()), apart, moved + _LAST)
    top = here.traction[0]
    differ = float(np.abs(found.traction - top).max())
    yield Check("traction on an atom", float(found.traction.max()), float(top.max()), differ, off)
    numbers = {
        "force": (float(here.traction.sum()), off * gap.size),
        # A law with an error of its traction has one of its energy of that over its range.
        "wall_energy": (float(here.energy.sum()), off * gap.size * (1 + wall.range)),
        "smallest_gap": (float(gap.min()), moved + _LAST),
        "area_rep": (float(np.count_nonzero(kinds == REPULSIVE)) / gap[0].size, _LAST),
        "area_att": (float(np.mean(kinds[0] == ATTRACTED)), _LAST),
        "lateral_x": (0.0, 0.0),  # of a wall of the sites
        "lateral_y": (0.0, 0.0),
        "core": (law.core, _LAST),
    }
    for name, (value, allowed) in numbers.items():
        stored = float(getattr(found, name))
        yield Check(name, stored, value, abs(value - stored), allowed)


def _lowest(found: DeckResult, softening: Real, hessian: Callable[[Real], Real]) -> Lowest:
    """Lowest eigenvalue of the Hessian, in E* a0, begun where the wall softens.

    Preconditioned by the inverse of a scalar lattice that is free above and held below, as the slab is: white noise
    from layer to layer sees the stiff bonds only.
    """
    layers, shape = found.slab.mobile, found.slab.shape
    along = np.add.outer(*(_waves(np.fft.fftfreq(n)) for n in shape))
    down = 2 * _waves((np.arange(layers) + 0.5) / (2 * layers))  # layers are a0/sqrt(2) apart
    stiffness = (along + down[:, None, None])[..., None]
    shift = float(softening.max()) + float(down[0])

    def smooth(v: Real) -> Real:
        spectrum = scipy.fft.fft2(scipy.fft.dct(v, type=4, axis=0, norm="ortho"), axes=(1, 2)) / (stiffness + shift)
        smoothed: Real = scipy.fft.dct(scipy.fft.ifft2(spectrum, axes=(1, 2)).real, type=4, axis=0, norm="ortho")
        return smoothed

    # Some of all directions, so that none is missed by symmetry.
    start = 0.05 * np.random.default_rng(1).normal(size=(layers, *shape, 3))
    start[0, ..., 2] += layers * (softening / (softening.max() or 1.0) + 0.1)
    return lowest_eigenvalue(hessian, smooth(start)[None], RESOLVED * float(down[0]), smooth)


def _waves(frequency: NDArray[np.floating[Any]]) -> Real:
    """(2 sin πf)², the stiffness of a chain of unit springs."""
    return np.asarray((2 * np.sin(np.pi * frequency)) ** 2)
