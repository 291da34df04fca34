"""The fcc crystal of a potential at zero pressure, measured through LAMMPS: a model in units of a0 and E*.

All is measured on two atoms in a periodic box along <110>, <110> and <001>, whose homogeneous strains give all elastic
constants: an fcc crystal is a Bravais lattice, so that its atoms follow the strain and nothing relaxes.
"""

import json

import numpy as np
import scipy

from atomistic.crystal.model import Crystal, CrystalModel, Model, Potential, is_model
from atomistic.crystal.potentials import PotentialError
from atomistic.lammps.engine import pair_styles
from atomistic.lammps.session import Cell
from continuum.inputs.toml import slip
from continuum.model.fourier import Real
from continuum.model.substrates.crystal import CubicConstants

STEP = 1e-5
"""Strain, or displacement in a0, of all finite differences.

Central differences err by STEP² times the ratio of third-order stiffnesses to the first, some hundred: 1e-8.  Rounding
errs by 1e-15/STEP = 1e-10.  A larger step would meet the knots of tabulated potentials, at which LAMMPS' splines have
jumps in their second derivative: with 1e-5 a crystal lies between knots except in one case in a hundred.
"""

_SQUARE = np.array([1.0, 1.0, np.sqrt(2)])
_FCC = np.array([[0, 0, 0], [1, 1, 1]]) / 2
_CUBE = np.array([[0, 0, 0], [1, 1, 0], [1, 0, 1], [0, 1, 1]]) / 2
# Other structures that a potential may prefer: box in units of its first edge, atoms in fractions.
_OTHERS: dict[str, tuple[Real, Real]] = {
    "bcc": (np.ones(3), _FCC),
    "hcp": (
        np.array([1, np.sqrt(3), np.sqrt(8 / 3)]),
        np.array([[0, 0, 0], [3, 3, 0], [3, 5, 3], [0, 2, 3]]) / 6,
    ),
    "simple cubic": (np.ones(3), np.zeros((1, 3))),
    "diamond": (np.ones(3), np.concatenate([_CUBE, _CUBE + 1 / 4])),
}
_PREFERRED = 2e-3
"""Part of the cohesive energy by which another structure must be lower to be taken as the crystal.

Stackings of the same planes may differ by less: Lennard-Jones cut at 2.5 σ (smooth/linear) is 7e-4 lower as hcp.
"""


_SUFFIXES = {"gpu": "GPU", "intel": "INTEL", "kk": "KOKKOS", "omp": "OPENMP", "opt": "OPT"}
_PACKAGES = {
    "MANYBODY": "adp eam eam/alloy eam/fs sw tersoff rebo airebo vashishta", "MEAM": "meam", "ML-HDNNP": "hdnnp",
    "ML-IAP": "mliap", "ML-PACE": "pace", "ML-POD": "pod", "ML-RANN": "rann", "ML-SNAP": "snap", "ML-UF3": "uf3",
    "REAXFF": "reaxff", "of the authors of MACE": "mace symmetrix/mace", "DeePMD-kit": "deepmd",
    "of the authors of Allegro": "allegro nequip",
}  # fmt: skip
"""Packages with the pair styles of crystals that are in them."""
_PACKAGE_OF = {style: package for package, styles in _PACKAGES.items() for style in styles.split()}

_MEASURED: dict[str, Crystal] = {}
"""Measured crystals, by everything that determines them."""


def model_of(potential: Potential) -> Model:
    """Any potential as a model; springs and measured models are returned unchanged.

    A crystal is measured once in a process: an input is read for its units, then for its deck.

    Raises PotentialError if its crystal is not a stable fcc one; LammpsError if LAMMPS fails.
    """
    if is_model(potential):
        return potential
    key = json.dumps([dict(potential.identity), potential.guess], sort_keys=True)
    if key not in _MEASURED:
        _MEASURED[key] = measure_crystal(potential)
    return CrystalModel(potential, _MEASURED[key])


def measure_crystal(potential: Potential) -> Crystal:
    """Measure the fcc crystal of a potential.

    Raises PotentialError if there is no fcc crystal at zero pressure, it is not stable, or another structure has a
    lower energy; LammpsError if LAMMPS fails.
    """
    if potential.atom_style != "atomic":
        raise ValueError(f"only crystals without fixed bonds are measured on two atoms, not {potential.reference}")
    require_style(potential)
    guess = potential.guess or (0.5 * potential.cutoff) ** 3
    with _Strained(potential, _SQUARE, _FCC) as fcc:
        try:
            a0 = fcc.equilibrium(guess)
        except PotentialError as error:
            raise PotentialError(f"{error}{_preferred(potential, guess)}") from None
        energy = fcc.energy(a0 * _SQUARE)
        along, across = (fcc.stiffness(a0 * _SQUARE, axis) for axis in (0, 2))
    # Along <110>: (C11 + C12)/2 + C44 and (C11 + C12)/2 - C44.
    c44 = float(along[0] - along[1]) / 2
    constants = CubicConstants(float(across[2]), float((across[0] + across[1]) / 2), c44)
    crystal = Crystal(a0 * float(np.sqrt(2)), energy, constants, _others(potential, a0**3 / np.sqrt(2)))
    _require_fcc(potential, crystal)
    return crystal


def require_style(potential: Potential) -> None:
    """Check that the installed LAMMPS has the styles of a potential, also those that a hybrid one combines.

    Raises PotentialError, with the package that a style is in, or a style of a similar name.
    """
    combined, words = potential.interactions().partition("\n")[0].split()[1:2], set[str]()
    if combined[0].startswith("hybrid"):  # the words that are styles: known ones, or of two parts as eam/alloy
        words = {word for word in potential.interactions().split()[2:] if word in _PACKAGE_OF or "/" in word}
    for style in [*combined, *sorted(words)]:
        if style in pair_styles():
            continue
        base, _, suffix = style.rpartition("/")
        package = _PACKAGE_OF.get(style) or (_SUFFIXES.get(suffix) if base in pair_styles() else None)
        near = slip(style, sorted(pair_styles()), "; did you mean {}?")
        hint = f": it is in the package {package}" if package else near
        msg = f"the installed LAMMPS has no pair_style {style!r}{hint}; `atomistic doctor` lists its packages"
        raise PotentialError(msg)


def _require_fcc(potential: Potential, crystal: Crystal) -> None:
    try:
        crystal.constants.require_stable()
    except ValueError as error:
        msg = f"the fcc crystal of this potential is not stable ({error}): {potential.reference}"
        raise PotentialError(msg) from None
    best = min(crystal.others, key=lambda name: crystal.others[name])
    if crystal.others[best] < crystal.energy - _PREFERRED * abs(crystal.energy):
        raise PotentialError(
            f"this potential is not fcc at its minimum: {best} has the energy {crystal.others[best]:.6g} per atom, fcc "
            f"{crystal.energy:.6g}; the substrate here is an fcc crystal: {potential.reference}"
        )


def _preferred(potential: Potential, volume: float) -> str:
    """Another structure of a potential without an fcc crystal, as text; empty if there is none."""
    # A lattice constant meant for diamond, of eight atoms, gives twice its volume per atom.
    energies = _others(potential, volume, volume / 2)
    best = min(energies, key=lambda name: energies[name])
    if not energies[best] < 0:
        return ""
    return f"; {best} is bound with {energies[best]:.6g} per atom, and the substrate here is an fcc crystal"


def _others(potential: Potential, *volumes: float) -> dict[str, float]:
    """Energy per atom of other structures at their best volume near those given."""
    found = {}
    for name, (box, atoms) in _OTHERS.items():
        with _Strained(potential, box, atoms) as other:
            found[name] = min(map(other.lowest, volumes))
    return found


class _Strained(Cell):
    """A crystal of a few atoms under homogeneous strain."""

    def __init__(self, potential: Potential, box: Real, atoms: Real) -> None:
        self._box, self._atoms = box, atoms
        edge = float(np.cbrt(potential.guess * len(atoms) / np.prod(box))) or potential.cutoff
        super().__init__(potential, atoms * edge * box, edge * box)

    def energy(self, periods: Real) -> float:
        """Energy per atom."""
        self.deform(periods)
        return self.evaluate(self._atoms * periods)[0] / len(self._atoms)

    def pressed(self, periods: Real) -> Real:
        """Stress components xx, yy and zz."""
        self.energy(periods)
        return self.stress()

    def stiffness(self, periods: Real, axis: int) -> Real:
        """Derivative of the stress xx, yy, zz by the strain along an axis."""
        strain = np.zeros(3)
        strain[axis] = STEP
        # Cauchy stress at zero pressure: its derivatives are the elastic constants.
        return (self.pressed(periods * (1 + strain)) - self.pressed(periods * (1 - strain))) / (2 * STEP)

    def _edge(self, volume: float) -> float:
        return float(np.cbrt(volume * len(self._atoms) / np.prod(self._box)))

    def equilibrium(self, volume: float) -> float:
        """First edge of the box at zero pressure, near a volume per atom."""
        edges = self._edge(volume) * np.linspace(0.8, 1.25, 46)
        energies = np.array([self.energy(edge * self._box) for edge in edges])
        if not np.isfinite(energies).all() or not 0 < (i := int(np.argmin(energies))) < len(edges) - 1:
            raise PotentialError(
                f"no fcc crystal at zero pressure with nearest neighbours {edges[0]:.4g} to {edges[-1]:.4g} apart: "
                f"{self._potential.reference}"
            )

        def pull(edge: float) -> float:
            return float(self.pressed(edge * self._box).sum())

        return float(scipy.optimize.brentq(pull, edges[i - 1], edges[i + 1], xtol=1e-15 * edges[i], rtol=1e-15))

    def lowest(self, volume: float) -> float:
        """Lowest energy per atom between 0.7 and 1.6 times a volume per atom."""

        def energy(v: float) -> float:
            return self.energy(self._edge(v) * self._box)

        ends, error = (0.7 * volume, 1.6 * volume), 1e-4 * volume
        found = scipy.optimize.minimize_scalar(energy, bounds=ends, method="bounded", options={"xatol": error})
        return float(found.fun)
