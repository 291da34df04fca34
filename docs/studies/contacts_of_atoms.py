"""Classical contacts pressed on explicit atoms: Hertz' sphere and cylinder, Westergaard's wave.

Each wall is pressed on the atoms, on their own linear response (the lattice Green's function) and set beside the
formula for an isotropic half-space, at the load of the atoms.  ``python -m docs.studies.contacts_of_atoms`` prints
quoted in docs/trust.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps.deck import Deck
from atomistic.lammps.session import Session
from atomistic.relax.relax import lattice_start, relax_in
from atomistic.response.lattice import LatticeResponse
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.surfaces import CylinderSurface, sine, sphere
from continuum.model.walls import LennardJonesSpline
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from continuum.store.sheet import Sheet
from continuum.theory.smooth import Hertz
from docs.studies.tables import keep
from tests.classical import Westergaard

__all__ = ["CONTACTS", "Compared", "compare"]

WALL = LennardJonesSpline(0.0, minimum_stiffness=20.0)
"""Repulsive, and so stiff that the gap in contact is a0 to 1e-3."""
Pressure = Callable[[float, Real, Real], Real]
"""Of the theory, given the load and the distances from the middle of the period along x and y."""


def _sphere(n: int) -> tuple[Real, Pressure]:
    radius = 100.0 * n
    return sphere(Grid.square(n), radius), lambda load, x, y: Hertz(radius, load).pressure(np.hypot(x, y))


def _cylinder(n: int) -> tuple[Real, Pressure]:
    radius = 100.0 * n

    def line(load: float, x: Real, y: Real) -> Real:
        """a² = 4 P R/(π E*) and p0 = 2 P/(π a), with P the load per length (Johnson, 1985, section 4.2(c))."""
        half_width = float(np.sqrt(4 * (load / n) * radius / np.pi))
        inside = np.sqrt(np.maximum(1 - (x / half_width) ** 2, 0.0))
        return 2 * (load / n) / (np.pi * half_width) * inside + 0 * y

    return CylinderSurface(radius).build(Grid.square(n)), line


def _wave(n: int) -> tuple[Real, Pressure]:
    amplitude = 0.0002 * n

    def wave(load: float, x: Real, y: Real) -> Real:
        return Westergaard(amplitude, n, load / n**2).pressure(x) + 0 * y

    return np.roll(sine(Grid.square(n), amplitude, (1, 0)), n // 2, axis=0), wave


CONTACTS: dict[str, Callable[[int], tuple[Real, Pressure]]] = {
    "Hertz, sphere": _sphere,
    "Hertz, cylinder": _cylinder,
    "Westergaard, wave": _wave,
}


@dataclass(frozen=True)
class Compared:
    """One contact, three ways; differences of pressures are root-mean-square over the grid, relative to its largest."""

    load: float
    """Of the atoms, in E* a0²."""
    peak: float
    """Largest pressure of the atoms, in E*."""
    theory_peak: float
    """Of the theory over that of the atoms, less 1."""
    theory: float
    """Pressure of the theory less that of the atoms."""
    lattice_load: float
    """Load of the lattice response at the same separation over that of the atoms, less 1."""
    lattice: float
    """Pressure of the lattice response less that of the atoms: what it leaves unexplained of the difference before."""


def compare(name: str, n: int, indentation: float = 0.0002) -> Compared:
    """Press a wall on n x n surface atoms, as deep, so far below first touch as a part of the period."""
    heights, theory = CONTACTS[name](n)
    grid = Grid.square(n)
    slab = Slab.of_depth(grid, float(n))
    response = LatticeResponse.of_springs(slab, Springs())
    separation = 1.0 - indentation * n
    problem = ContactProblem(grid, WALL, heights, response)
    lattice = solve(problem, "separation", separation, Settings(1e-9)).solution.require()
    start = lattice_start(response, WALL, lattice.gap)
    deck = Deck(slab, Springs(), WALL, heights, separation, start, tolerance=1e-10)
    with Session.on_atoms_of(deck) as session:
        atoms = relax_in(session, deck, response).require()
    x, y = (position - n / 2 for position in grid.positions)
    pressure = {
        "atoms": atoms.traction,
        "lattice": WALL.evaluate(lattice.gap).traction,
        "theory": theory(atoms.force, x, y),
    }
    peak = float(atoms.traction.max())

    def rms(one: str, other: str) -> float:
        return float(np.sqrt(np.mean((pressure[one] - pressure[other]) ** 2))) / peak

    return Compared(
        load=atoms.force,
        peak=peak,
        theory_peak=float(pressure["theory"].max()) / peak - 1,
        theory=rms("theory", "atoms"),
        lattice_load=float(pressure["lattice"].sum()) / atoms.force - 1,
        lattice=rms("lattice", "atoms"),
    )


def main() -> None:
    """Print and keep the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--n", type=int, nargs="+", default=[32, 64], help="surface atoms a side (default 32 64)")
    heads = ("contact", "atoms a side", "load, E* a0²", "peak pressure, E*", "theory: peak", "theory: pressure",
             "lattice: load", "lattice: pressure")  # fmt: skip
    rows = []
    for n in parser.parse_args().n:
        for name in CONTACTS:
            found = compare(name, n)
            rows.append((
                name, n, f"{found.load:.4f}", f"{found.peak:.5f}", f"{100 * found.theory_peak:+.2f} %",
                f"{100 * found.theory:.2f} %", f"{100 * found.lattice_load:+.4f} %", f"{100 * found.lattice:.4f} %",
            ))  # fmt: skip
    keep("contacts_of_atoms", Sheet.of("contacts of atoms", heads, rows))


if __name__ == "__main__":
    main()
