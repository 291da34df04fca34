"""Evaluations of the forces that optimizers need on a slab under a rough wall, for the same largest force."""

from __future__ import annotations

import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from ase.build import fcc100, fcc111
from ase.calculators.calculator import Calculator, all_changes
from ase.calculators.emt import EMT
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms
from ase.optimize import FIRE, LBFGS
from ase.optimize.precon import PreconLBFGS

import atomistic as a
from atomistic.crystal.crystal import Slab
from atomistic.lammps.deck import Deck
from atomistic.lammps.session import Cell
from atomistic.relax.relax import relax
from atomistic.relax.specimen import Specimen
from atomistic.response.material import model_of
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline

__all__ = ["OPTIMIZERS", "SLABS", "counts"]

OPTIMIZERS = {"GreensRelaxation": a.GreensRelaxation, "PreconLBFGS": PreconLBFGS, "LBFGS": LBFGS, "FIRE": FIRE}
WALL = LennardJonesSpline(adhesion_length=0.005)
TOLERANCE, MOST = 1e-5, 3000
"""Largest force left, in E* a0², and most steps of an optimizer."""
LARGEST = {"PreconLBFGS": 5000, "LBFGS": 5000}
"""Most atoms of some optimizers, which take minutes for more."""
COPPER = {"a0": 3.615 / 2**0.5, "contact_modulus": 0.85}
"""In Å and eV/Å³."""
SNAP = "Cu_Zuo_JPCA2020.snap"


class Lammps(Calculator):
    """A potential in LAMMPS, on one element in rectangular cells."""

    implemented_properties = ["energy", "free_energy", "forces"]  # noqa: RUF012

    def __init__(self, potential: Any) -> None:
        super().__init__()
        self.potential, self.cells = potential, dict[int, Cell]()

    def calculate(self, atoms: Any = None, properties: Any = (), system_changes: Any = all_changes) -> None:
        super().calculate(atoms, properties, system_changes)
        if len(atoms) not in self.cells:
            self.cells[len(atoms)] = Cell(self.potential, atoms.positions, atoms.cell.lengths(), surface=True)
        energy, forces = self.cells[len(atoms)].evaluate(atoms.positions)
        self.results = {"energy": energy, "free_energy": energy, "forces": forces}


class SinglePrecision(EMT):
    """EMT whose results are rounded to single precision, as those of most learned potentials."""

    def calculate(self, atoms: Any = None, properties: Any = (), system_changes: Any = all_changes) -> None:
        super().calculate(atoms, properties, system_changes)
        self.results = {name: np.float64(np.float32(value)) for name, value in self.results.items()}


def _copper() -> a.EmbeddedAtom:
    return a.EmbeddedAtom.read(a.find_potential("Cu_mishin1.eam.alloy"))


def _snap() -> a.PairStyle:
    """A machine-learned potential: Zuo et al., J. Phys. Chem. A 124, 731 (2020)."""
    files = a.PairStyle.read_files([a.find_potential(SNAP + end) for end in ("coeff", "param")])
    words = ("*", "*", SNAP + "coeff", SNAP + "param", "Cu")
    return a.PairStyle("snap", "Cu", 63.546, 4.0, 3.615, coefficients=(words,), contents=files)


def _cut(build: Callable[..., Atoms], calculator: Calculator, n: int, layers: int, held: int) -> Atoms:
    """A slab of copper, at rest."""
    options = {"orthogonal": True} if build is fcc111 else {}
    slab = build("Cu", (n, n, layers), a=2**0.5 * COPPER["a0"], vacuum=10.0, periodic=True, **options)
    slab.set_constraint(FixAtoms(mask=slab.get_tags() > layers - held))
    slab.calc = calculator
    LBFGS(slab, logfile=None).run(fmax=0.1 * TOLERANCE * COPPER["contact_modulus"] * COPPER["a0"] ** 2)
    return slab


SLABS: dict[str, Callable[[], tuple[Atoms, Callable[[], Calculator], Any]]] = {
    "springs (100), large": lambda: _of_deck(a.Springs(), 32, 32.0),
    "springs (100)": lambda: _of_deck(a.Springs(), 12, 4.0),
    "EAM copper (100)": lambda: _of_deck(_copper(), 12, 4.0),
    "EAM copper (111)": lambda: (_cut(fcc111, Lammps(_copper()), 8, 8, 4), lambda: Lammps(_copper()), None),
    "SNAP copper (111)": lambda: (_cut(fcc111, Lammps(_snap()), 8, 6, 3), lambda: Lammps(_snap()), None),
    "EMT copper (100)": lambda: (_cut(fcc100, EMT(), 8, 6, 2), EMT, None),
    "EMT copper (111)": lambda: (_cut(fcc111, EMT(), 8, 6, 2), EMT, None),
    "EMT copper (100), float32": lambda: (_cut(fcc100, EMT(), 8, 6, 2), SinglePrecision, None),
    "EMT copper (111), float32": lambda: (_cut(fcc111, EMT(), 8, 6, 2), SinglePrecision, None),
    "EMT copper (111), small": lambda: (_cut(fcc111, EMT(), 4, 4, 2), EMT, None),
    "EMT copper (111), small, float32": lambda: (_cut(fcc111, EMT(), 4, 4, 2), SinglePrecision, None),
}
"""Each slab at rest, with how its calculator is made, and the specimen of a deck."""


def _of_deck(potential: Any, n: int, depth: float) -> tuple[Atoms, Callable[[], Calculator], Specimen]:
    """n x n surface atoms as they stand in a deck."""
    model = model_of(potential)
    specimen = Specimen.of_slab(Slab.of_depth(Grid.square(n), depth, model.coupled_layers), model)
    rise = np.zeros((specimen.slab.layers, *specimen.slab.shape, 3))
    rise[..., 2] = specimen.response.rise[:, None, None]
    return specimen.slab.to_atoms(rise, "Cu", model.length), lambda: Lammps(model), specimen


def counts(slab: str) -> dict[str, Any]:
    """Evaluations and CPU seconds of each optimizer, and evaluations of LAMMPS' cg, for one slab."""
    rest, calculator, specimen = SLABS[slab]()
    units = COPPER
    if specimen is not None:
        units = {"a0": specimen.model.length, "contact_modulus": specimen.model.energy / specimen.model.length**3}
    n = int(np.sqrt(np.count_nonzero(rest.get_tags() == 1)))
    longest = min(8.0, n)
    heights = SelfAffine(0.8, 0.1, longest, longest).synthesise(Grid.square(n), np.random.default_rng(2))
    separation = 1 + float(heights.std())
    wall = a.RoughWall(heights, rest, separation, WALL, follows="sites", **units)
    row: dict[str, Any] = {"atoms": len(rest)}
    for name, optimizer in OPTIMIZERS.items():
        if len(rest) > LARGEST.get(name, len(rest)):
            continue
        atoms, crystal, evaluations = rest.copy(), calculator(), list[int]()

        def counted(*given: Any, run: Any = crystal.calculate, seen: Any = evaluations, **named: Any) -> None:
            run(*given, **named)
            seen.append(len(given[0]))

        crystal.calculate = counted
        atoms.calc = SumCalculator([crystal, wall])
        began = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)
            optimization = optimizer(atoms, logfile=None)
            try:
                converged = bool(
                    optimization.run(fmax=TOLERANCE * units["contact_modulus"] * units["a0"] ** 2, steps=MOST)
                )
            except RuntimeError:  # a line search that finds nothing lower
                converged = False
        response = getattr(optimization, "response", None)
        # The small slab may be as large as the whole.
        measured = 0 if response is None else response.evaluations
        row[name] = {
            "evaluations": len(evaluations) - measured,
            "measured": measured,
            "cost": 0.0 if response is None else response.cost,
            "cpu": time.process_time() - began,
            "converged": converged and getattr(optimization, "fallback", None) is None,
            "load": -float(wall.results["forces"][:, 2].sum()),
            "contact": float(np.mean(wall.results["contact"][wall.surface] == 2)),
        }
    if specimen is not None:
        deck = Deck(
            specimen.slab, specimen.model, WALL, heights, separation, tolerance=TOLERANCE, rise=specimen.response.rise
        )
        with tempfile.TemporaryDirectory() as folder:
            row["LAMMPS"] = {"evaluations": relax(deck, Path(folder)).require().evaluations}
    return row
