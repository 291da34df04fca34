"""The LAMMPS deck: a self-contained directory that a stock ``lmp -in in.contact`` runs, serial or with MPI.

Rendering is pure and strict: a :class:`Deck` is checked whole, then turned into texts from ``templates/`` by
strict substitution.  Only numbers formatted here and commands of the interatomic model enter a script, no
text of a user.
"""

from __future__ import annotations

import io
import re
import string
import textwrap
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

import continuum
from atomistic.crystal.crystal import LAYER_SPACING, Slab
from atomistic.crystal.interatomic import Model
from atomistic.crystal.potentials import POTENTIAL
from continuum.model.grid import Real
from continuum.model.tabulated_wall import TabulatedWall
from continuum.model.walls import LennardJonesSpline

__all__ = ["INPUTS", "OUTPUTS", "Deck", "read_slab", "read_wall_table", "render", "write_deck"]

SCRIPTS = ("in.contact", "in.slab", "in.relax", "README.txt")
INPUTS = (*SCRIPTS, "slab.data", "wall.table")
"""Files of a deck, beside those that its interatomic model reads."""
OUTPUTS = ("result.json", "surface.dump", "state.dump", "log.lammps")
"""Files that a run of the deck writes."""

_TITLE = "fcc(100) slab of {} x {} atoms x ({} mobile + {} frozen) layers, at rest"
"""First line of ``slab.data``."""
_TABLE_SPACING = 1e-3
"""Largest distance of the knots of ``wall.table``, in a0."""


@dataclass(frozen=True, eq=False)
class Deck:
    """One equilibrium of a slab under a rigid rough wall.

    Parameters
    ----------
    slab : the atoms.
    model : what holds them together.
    wall : the law between wall and surface; its range may be 0.
    heights : of the wall above each surface atom, shape ``slab.shape``, in a0.
    separation : of the wall's zero from the undeformed surface, in a0.
    displacements : where to start from, shape (layers, nx, ny, 3), in a0; where the slab is at rest if None.
    tolerance : largest force left on a mobile atom, in E* a0².
    evaluations : of the forces, at most, by each minimiser.
    rise : by how much each layer of the slab at rest lies above its lattice sites, shape (layers,), in a0: the surface
        of most crystals relaxes.  None for springs, which do not.

    Raises
    ------
    ValueError
        If the parts do not fit one another or a number has no meaning.
    TypeError
        If the law is one that the deck has no formula for.
    """

    slab: Slab
    model: Model
    wall: LennardJonesSpline
    heights: Real = field(repr=False)
    separation: float
    displacements: Real | None = field(default=None, repr=False)
    tolerance: float = 1e-11
    evaluations: int = 20000
    rise: Real | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Refuse what no equilibrium can come of, before anything is written."""
        slab, model = self.slab, self.model
        if not isinstance(self.wall, LennardJonesSpline):
            msg = (
                f"a deck has formulas for LennardJonesSpline only, got {type(self.wall).__name__}: "
                "other laws act in process (atomistic.relax.relax.Session)"
            )
            raise TypeError(msg)
        if not np.isclose(model.lattice_constant, np.sqrt(2), rtol=1e-12):
            msg = f"the surface grid has the spacing a0 = 1, the crystal {model.lattice_constant / np.sqrt(2)}"
            raise ValueError(msg)
        if slab.frozen < model.reach:
            msg = f"forces reach {model.reach} layers, but only {slab.frozen} are frozen"
            raise ValueError(msg)
        sites = (slab.layers, *slab.shape)
        _set_array(self, "heights", self.heights, slab.shape)
        start = np.zeros((*sites, 3)) if self.displacements is None else self.displacements
        _set_array(self, "displacements", start, (*sites, 3))
        _set_array(self, "rise", np.zeros(slab.layers) if self.rise is None else self.rise, (slab.layers,))
        if np.any(self.start[slab.mobile :]) or np.any(self.rest[slab.mobile :] != slab.positions[slab.mobile :]):
            msg = "atoms of the frozen base cannot be displaced"
            raise ValueError(msg)
        if not np.isfinite(self.separation):
            msg = f"the separation is a finite number, got {self.separation}"
            raise ValueError(msg)
        if not (np.isfinite(self.tolerance) and self.tolerance > 0):
            msg = f"the tolerance is a positive finite force, got {self.tolerance}"
            raise ValueError(msg)
        if isinstance(self.evaluations, bool) or self.evaluations != int(self.evaluations) or self.evaluations < 1:
            msg = f"the number of evaluations is a positive integer, got {self.evaluations}"
            raise ValueError(msg)

    @property
    def start(self) -> Real:
        """Displacements to start from, shape (layers, nx, ny, 3), in a0."""
        assert self.displacements is not None
        return self.displacements

    @property
    def rest(self) -> Real:
        """Where the atoms are at rest without a wall, shape (layers, nx, ny, 3), in a0."""
        assert self.rise is not None
        at = self.slab.positions.copy()
        at[..., 2] += self.rise[:, None, None]
        return at


def _set_array(deck: Deck, name: str, values: Real, shape: tuple[int, ...]) -> None:
    """Keep a private read-only copy of an array, if it is one of finite numbers of the shape wanted."""
    array = np.array(values, dtype=np.float64)
    if array.shape != shape:
        msg = f"{name} of this slab have the shape {shape}, got {array.shape}"
        raise ValueError(msg)
    if not np.isfinite(array).all():
        msg = f"{np.count_nonzero(~np.isfinite(array))} of the {name} are not finite numbers"
        raise ValueError(msg)
    array.flags.writeable = False
    object.__setattr__(deck, name, array)


class _Template(string.Template):
    """Placeholders are @{name}: $ belongs to LAMMPS."""

    delimiter = "@"


def render(deck: Deck) -> dict[str, str]:
    """The files of a deck but for its atoms: their names and texts."""
    texts = {
        name: _Template((files("atomistic.lammps") / "templates" / name).read_text(encoding="utf-8"))
        for name in SCRIPTS
    }
    nx, ny = deck.slab.shape
    model = deck.model
    sizes = {
        "units": model.units,
        "length": _number(model.length),
        "force": _number(model.energy / model.length),
        "energy": _number(model.energy),
    }
    bonds = model.atom_style == "bond"
    return {
        "in.contact": texts["in.contact"].substitute(
            separation=_number(deck.separation),
            tolerance=_number(deck.tolerance),
            evaluations=f"{deck.evaluations:d}",
            surface=_number(deck.rest[0, 0, 0, 2]),
            **_law(deck.wall),
        ),
        "in.slab": texts["in.slab"].substitute(
            settings=model.settings(),
            interactions=model.interactions(),
            room=" &\n                extra/bond/per/atom 12 extra/special/per/atom 24" if bonds else "",
            **sizes,
            surface_atoms=f"{nx * ny:d}",
            mobile_atoms=f"{deck.slab.mobile * nx * ny:d}",
        ),
        "in.relax": texts["in.relax"].substitute(timestep=_number(_timestep(model))),
        "wall.table": _wall_table(deck.wall),
        "README.txt": texts["README.txt"].substitute(
            atoms=f"{deck.slab.size:d}",
            version=continuum.__version__,
            model=textwrap.fill(model.reference, 118),
            potential="".join(f"{name:13} the potential, as its authors wrote it\n" for name in model.files),
            package="MOLECULE" if bonds else "MANYBODY" if model.files else "EXTRA-PAIR",
            **sizes,
        ),
    }


def write_deck(directory: Path, deck: Deck) -> Path:
    """Write a deck into a directory, which is made if needed; returns it.

    An earlier deck there is replaced, and its outputs are removed, so that no result outlives its input.

    Raises
    ------
    FileExistsError
        If the directory holds anything else: it is left as it was.
    """
    directory = Path(directory)
    texts = render(deck)
    if directory.exists():
        known = {*INPUTS, *OUTPUTS, POTENTIAL}
        foreign = sorted({entry.name for entry in directory.iterdir()} - known)
        if foreign:
            names = ", ".join(foreign[:5])
            msg = f"{directory} holds files that are not of a deck ({names}): choose another directory"
            raise FileExistsError(msg)
    directory.mkdir(parents=True, exist_ok=True)
    for name in (*OUTPUTS, POTENTIAL):
        (directory / name).unlink(missing_ok=True)
    for name, text in texts.items():
        (directory / name).write_text(text, encoding="utf-8")
    for name, content in deck.model.files.items():
        (directory / name).write_bytes(content)
    with (directory / "slab.data").open("w", encoding="utf-8") as file:
        _write_data(file, deck)
    return directory


def read_wall_table(path: Path) -> TabulatedWall:
    """The wall law of a ``wall.table``, as a cubic spline through its knots."""
    gap, _, traction = np.loadtxt(path, unpack=True)
    return TabulatedWall(gap, traction)


def read_slab(path: Path) -> Slab:
    """The slab of a ``slab.data``.

    Raises
    ------
    ValueError
        If the file is not one of a deck.
    """
    with Path(path).open(encoding="utf-8") as file:
        title = file.readline().strip()
    numbers = [int(number) for number in re.findall(r"\d+", title)]
    if len(numbers) != 5 or title != _TITLE.format(*numbers[1:5]):
        msg = f"{path} is not the slab.data of a deck: it begins with {title[:80]!r}"
        raise ValueError(msg)
    nx, ny, mobile, frozen = numbers[1:5]
    return Slab((nx, ny), mobile, frozen)


def _number(value: float) -> str:
    """A number with all its digits: it reads back as the same float."""
    return f"{float(value):.17g}"


def _law(wall: LennardJonesSpline) -> dict[str, str]:
    """Numbers and formulas of the wall law."""
    at_core = wall.evaluate(np.array([wall.core]))
    numbers = {
        "stiffness": wall.minimum_stiffness,
        "range": wall.range,
        "work": wall.work_of_adhesion,
        "core": wall.core,
        "core_traction": float(at_core.traction[0]),
        "core_stiffness": float(at_core.stiffness[0]),
        "core_energy": float(at_core.energy[0]),
    }
    if wall.range == 0:
        formulas = {"reduced_gap": "0.0", "attraction": "0.0", "attraction_energy": "0.0"}
    else:
        formulas = {
            "reduced_gap": "(v_gap-1.0)/v_range",
            "attraction": "v_k*v_range*(v_t<1.0)*v_t*(1.0-v_t)^2",
            "attraction_energy": "(v_t<1.0)*(v_k*v_range^2*v_t^2*(0.5+v_t*(v_t/4.0-2.0/3.0))-v_work)",
        }
    return {name: _number(value) for name, value in numbers.items()} | formulas


def _timestep(model: Model) -> float:
    """Of damped dynamics, in LAMMPS' unit of time."""
    # In units metal, mass velocity² in u (Å/ps)² becomes energy in eV by this factor (LAMMPS' mvv2e).
    mvv2e = 1.0364269e-4 if model.units == "metal" else 1.0
    return model.timestep * float(np.sqrt(mvv2e * model.mass * model.length**2 / model.energy))


def _write_data(file: TextIO, deck: Deck) -> None:
    """``slab.data``: the slab at rest, the wall above it and the start."""
    slab, model = deck.slab, deck.model
    bonds = model.atom_style == "bond"
    nx, ny = slab.shape
    ids = slab.ids.ravel()
    heights = np.zeros(slab.ids.shape)
    heights[0] = deck.heights
    # Two spacings of room on both sides, and up to the highest point of the wall, to which adhesion may lift an atom:
    # nothing leaves the box.
    low = -slab.layers * LAYER_SPACING - 2
    high = 2 + max(0.0, deck.separation + float(deck.heights.max()))
    ends = [_number(model.length * value) for value in (nx, ny, low, high)]
    file.write(
        f"{_TITLE.format(nx, ny, slab.mobile, slab.frozen)}\n\n"
        f"{slab.size} atoms\n1 atom types\n{'1 bond types' if bonds else ''}\n\n"
        f"0 {ends[0]} xlo xhi\n0 {ends[1]} ylo yhi\n{ends[2]} {ends[3]} zlo zhi\n\n"
        f"Masses\n\n1 {_number(model.mass)}\n\nAtoms # {model.atom_style}\n\n"
    )
    kind = "%d 1 1" if bonds else "%d 1"  # molecule and type, or type
    _write_rows(file, f"{kind} %.17g %.17g %.17g\n", ids, model.length * deck.rest.reshape(-1, 3))
    file.write("\nWallHeight\n\n")
    _write_rows(file, "%d %.17g\n", ids, heights.reshape(-1, 1))
    file.write("\nDisplacement\n\n")
    _write_rows(file, "%d %.17g %.17g %.17g\n", ids, deck.start.reshape(-1, 3))


def _write_rows(file: TextIO, form: str, ids: NDArray[np.int64], values: Real) -> None:
    """A line for each atom.  Three times as fast as :func:`numpy.savetxt`, and in little memory."""
    for first in range(0, len(ids), 10_000):
        part = slice(first, first + 10_000)
        rows = np.column_stack([ids[part], values[part]])
        file.write(form * len(rows) % tuple(rows.ravel().tolist()))


def _wall_table(wall: LennardJonesSpline) -> str:
    """``wall.table``: the law at knots that include the core, the minimum and the end of the range."""
    sides = [np.linspace(wall.core, 1.0, _knots(1.0 - wall.core))]
    if wall.range > 0:
        sides.append(np.linspace(1.0, 1.0 + wall.range, _knots(wall.range))[1:])
    gap = np.concatenate(sides)
    law = wall.evaluate(gap)
    # Rounding leaves a traction of 1e-17 at the end of the range, where the law ends.
    traction = np.where(gap < 1.0 + wall.range, law.traction, 0.0)
    between = (gap[1:] + gap[:-1]) / 2
    error = np.abs(TabulatedWall(gap, traction).evaluate(between).traction - wall.evaluate(between).traction).max()
    text = io.StringIO()
    text.write(
        "# Wall law: energy and traction per area against gap; traction = -d energy/d gap,\n"
        "# positive in compression.\n"
        "# Units: gap a0, energy E* a0, traction E*; energy and traction are zero beyond the last gap.\n"
        f"# 9-3 repulsion, cubic-spline attraction: k = {_number(wall.minimum_stiffness)} E*/a0, "
        f"range = {_number(wall.range)} a0.\n"
        f"# Resolution: {gap.size} knots at most {_TABLE_SPACING:g} a0 apart; a cubic spline through the "
        f"tractions errs by at most {error:.1e} E*.\n"
        "# gap energy traction\n"
    )
    np.savetxt(text, np.column_stack([gap, law.energy, traction]), fmt="%.17g")
    return text.getvalue()


def _knots(length: float) -> int:
    """Number of equidistant knots that cover a length, both ends included."""
    return max(4, int(np.ceil(length / _TABLE_SPACING)) + 1)
