"""Check whether the states of a deck run are equilibria, independently of the run.

The wall is the law of :mod:`continuum` at the heights of the deck, not formulas or a plugin of LAMMPS; the forces of
the crystal come from a new LAMMPS without wall at the final positions; all sums are NumPy's.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from atomistic.lammps.earlier import finished_steps
from atomistic.lammps.result import DeckError, DeckResult, read_result
from atomistic.lammps.session import Session
from atomistic.relax.deckrun import DeckRun
from continuum.measure.contact import ATTRACTED, REPULSIVE, contact_map
from continuum.model.fourier import Real
from continuum.model.walls import Wall
from continuum.show.sheet import Column, Sheet

ENOUGH = 1.5
"""Factor by which the largest force may exceed tolerance and rounding, as sums have another order."""
STEP = 1e-5
"""Root-mean-square of the random displacements along which the energy is tested, in a0."""
DIRECTIONS = 4
_STIFFEST = 10.0
"""Largest derivative of a force by a displacement, in E* a0, which gives the error by rounded positions."""


@dataclass(frozen=True)
class StepCertificate:
    """An equilibrium of a deck with its independent evaluation."""

    stored: DeckResult
    load: float
    """Mean traction of the wall's law at the gaps of the atoms, in E*."""
    area_rep: float
    area_att: float
    residual: float
    """Largest force on a mobile atom, in E* a0²."""
    law_error: float
    """Largest difference of the deck's formulas from the law, in E*."""
    rounding: float
    """Force due to the rounding of positions, in E* a0²."""
    curvature: float
    """Smallest second derivative of the energy along random displacements, in E* a0."""

    @property
    def allowed(self) -> float:
        """Largest force allowed, in E* a0²."""
        return ENOUGH * (self.stored.tolerance + self.law_error + self.rounding)

    @property
    def stored_load(self) -> float:
        """N/A0 stored by LAMMPS, in E*."""
        return self.stored.force / self.stored.gap.size

    @property
    def faults(self) -> tuple[str, ...]:
        """Disagreements, in words; empty if all numbers agree."""
        found, faults = self.stored, []
        if not self.residual <= self.allowed:
            faults.append(f"the largest force is {self.residual:.2e} E* a0², above {self.allowed:.2e} E* a0²")
        for name in ("area_rep", "area_att"):
            here, there = getattr(self, name), getattr(found, name)
            if abs(here - there) > 1e-9:
                faults.append(f"{name}/A0 is {here:.6g}, and {there:.6g} is stored")
        if not abs(self.load - self.stored_load) <= self.allowed:
            faults.append(f"N/A0 is {self.load:.6e} E*, and {self.stored_load:.6e} E* is stored")
        if not self.curvature > 0:
            faults.append("the energy decreases along a displacement, so that this is a saddle point")
        return tuple(faults)


@dataclass(frozen=True)
class DeckCertificate:
    """Result of checking a deck run."""

    directory: Path
    steps: tuple[StepCertificate, ...]
    """Its equilibria; other steps are left out."""

    @property
    def faults(self) -> tuple[str, ...]:
        """Disagreements with their steps; empty if all agree."""
        return tuple(f"{self.directory}, step {one.stored.step}: {fault}" for one in self.steps for fault in one.faults)

    @property
    def ok(self) -> bool:
        """Whether all equilibria are sound."""
        return not self.faults

    def _repr_html_(self) -> str:
        return self.sheet()._repr_html_()

    def sheet(self) -> Sheet:
        """One row for each equilibrium."""
        columns = (
            Column("step"), Column("A_rep/A0"), Column("off", "", ".1e"), Column("N/A0", "E*", ".4e"),
            Column("off", "E*", ".1e"), Column("largest force", "E* a0²", ".2e"), Column("allowed", "E* a0²", ".1e"),
            Column("curvature", "E* a0", ".3g"), Column(""),
        )  # fmt: skip
        rows = [
            (one.stored.step, one.stored.area_rep, one.area_rep - one.stored.area_rep, one.stored_load,
             one.load - one.stored_load, one.residual, one.allowed, one.curvature, "; ".join(one.faults) or "sound")
            for one in self.steps
        ]  # fmt: skip
        return Sheet.of(f"{len(rows)} equilibria of atoms, checked independently of the run", columns, rows)


def certify_deck(run: DeckRun) -> DeckCertificate:
    """Check each equilibrium of a deck run.

    Raises DeckError if it has windows of a motion, or its wall is not a function of the lattice site; LammpsError if
    LAMMPS cannot be loaded, or cannot read the slab.
    """
    directory, steps = run.directory, []
    # What a deck says of its formulas.
    table = (directory / "wall.table").read_text(encoding="utf-8")
    said = re.search(r"differ from the law by at most (\S+) E\*", table)
    law_error = float(said[1]) if said else 0.0
    with Session(directory) as crystal:
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
                steps.append(_certified(crystal, run.wall, found, law_error, seed=step))
    return DeckCertificate(directory, tuple(steps))


def _certified(crystal: Session, wall: Wall, found: DeckResult, law_error: float, seed: int) -> StepCertificate:
    def forces(displacements: Real) -> Real:
        """On the mobile atoms, of crystal and wall, in E* a0²."""
        acting = crystal.evaluate(displacements)[1][: found.slab.mobile]
        acting[0, ..., 2] -= wall.evaluate(_gap(found, displacements)).traction
        return acting

    at = found.displacements
    gap = _gap(found, at)
    kinds = contact_map(wall, gap)
    curvatures = []
    for along in _directions(found, seed):
        change = forces(at + STEP * along) - forces(at - STEP * along)
        moved = along[: found.slab.mobile]
        curvatures.append(-float(np.sum(change * moved)) / (2 * STEP * float(np.sum(moved**2))))
    return StepCertificate(
        found,
        float(wall.evaluate(gap).traction.mean()),
        float(np.mean(kinds == REPULSIVE)),
        float(np.mean(kinds == ATTRACTED)),
        float(np.sqrt((forces(at) ** 2).sum(axis=-1)).max()),
        law_error,
        _STIFFEST * float(np.finfo(float).eps) * max(found.slab.grid.lengths),
        min(curvatures),
    )


def _gap(found: DeckResult, displacements: Real) -> Real:
    """Height of the wall above each surface atom, in a0, for a wall of lattice sites."""
    return np.asarray(found.separation + found.heights - displacements[0, ..., 2])


def _directions(found: DeckResult, seed: int) -> Iterator[Real]:
    """Random displacements of unit root-mean-square, from rough to smooth, zero in the frozen base."""
    rng, slab = np.random.default_rng(seed), found.slab
    q = np.hypot(*np.meshgrid(*(np.fft.fftfreq(n) for n in slab.shape), indexing="ij"))
    q[0, 0] = q[q > 0].min()
    depth = np.linspace(1.0, 0.0, slab.mobile, endpoint=False)[:, None, None, None]
    for power in np.linspace(0.0, 2.0, DIRECTIONS):
        noise = rng.normal(size=found.displacements.shape)
        smooth = np.fft.ifft2(np.fft.fft2(noise, axes=(1, 2)) * (q**-power)[None, :, :, None], axes=(1, 2)).real
        smooth[: slab.mobile] *= depth
        smooth[slab.mobile :] = 0.0
        yield smooth / np.sqrt(np.mean(smooth[: slab.mobile] ** 2))
