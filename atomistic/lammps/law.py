"""Wall laws as LAMMPS formulas: atom-style variables ``v_traction_of_gap`` and ``v_energy_of_gap``, per area.

A law becomes cubic pieces of equal length, as few as a tolerance allows, whose coefficients LAMMPS looks up by the
number of the piece (``compute global/atom``), at a cost independent of their number.  The remaining error is measured
and written into the deck.  The paper's law and the exponential are formulas, as in :mod:`continuum.model.laws`: they
take less time by the factor in ``docs/studies/deck_costs.md``, inverse powers do not.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from atomistic.lammps.language import filled, read_template, vector
from continuum.model.fourier import Real
from continuum.model.walls import Exponential, InversePowers, LennardJonesSpline, Wall
from continuum.model.walls.tabulated import TabulatedWall

PIECES = 4096
"""Largest number of cubic pieces of a table in LAMMPS."""
TOLERANCE = 1e-5
"""Default tolerance of the traction of a table, relative to its largest tension, or to the traction if that is
larger."""
_TABLE_SPACING = 1e-3
"""Largest distance of the knots of ``wall.table``, in a0."""
NO_CORE = -1e9
"""Core of a law without one, in a0."""


@dataclass(frozen=True)
class NativeLaw:
    """A law in LAMMPS' language."""

    lines: str
    """Lines that define the variables ``core``, ``traction_of_gap`` and ``energy_of_gap`` of ``gap`` and ``near``."""
    error: float = 0.0
    """Largest error of the traction, in E*; 0 for a formula, which differs by rounding only."""


def native_law(wall: Wall, tolerance: float = TOLERANCE) -> NativeLaw:
    """The lines of a law.

    Parameters
    ----------
    tolerance : tolerance of the traction of a table, relative to its largest tension, or to the traction if that is
        larger.

    Raises TypeError for a hard wall, whose traction is not a function of the gap.
    """
    if wall.law is None:
        cause = "its traction is not a function of the gap (a repulsive wall with one: LennardJonesSpline(0))"
        raise TypeError(f"the wall law {type(wall).__name__} cannot act in a deck: {cause}")
    return _native_law(wall, tolerance)


def law_of_atoms(wall: Wall, layer: float) -> Wall:
    """The law of each atom of a slab, on all of which the wall acts, from that of a surface, the half-space below it.

    A law that ends before the second layer is the same.  Of one that reaches deeper, as 9-3, each layer a distance
    d below the last would add to the energy w(gap) of the surface.  With w(gap) - w(gap + d) for each, those of layers
    at rest sum up to w(gap) again, less that of the first layer on which the wall does not act: a slab pressed as a
    whole has the adhesion and the load of its law.

    Parameters
    ----------
    wall : law of the surface, no hard wall.
    layer : d, in a0.
    """
    if wall.reach <= wall.zero_gap + layer:
        return wall
    return PARTS.get(type(wall), _layered)(wall, layer)


def _weaker(wall: Exponential, layer: float) -> Exponential:
    gamma, rho, stiffness = wall.surface_energy, wall.decay_length, wall.core_stiffness
    below = gamma * np.exp(-layer / rho)
    return Exponential(float(gamma - below), rho, float(stiffness + below / rho**2))


@lru_cache(maxsize=16)
def _layered(wall: Wall, layer: float) -> TabulatedWall:
    gap = _knots(wall, without_core=1.0)
    traction = wall.evaluate(gap).traction - wall.evaluate(gap + layer).traction
    return TabulatedWall(gap, traction - traction[-1])


@lru_cache(maxsize=4)
def _native_law(wall: Wall, tolerance: float) -> NativeLaw:
    return LAWS.get(type(wall), in_pieces)(wall, tolerance)


def with_core(
    wall: Wall,
    law: str,
    traction: str = "ternary(v_gap>v_core,v_law,v_core_push)",
    energy: str = "ternary(v_gap>v_core,v_law_energy,v_core_push_energy)",
    error: float = 0.0,
) -> NativeLaw:
    """Add the continuation with constant stiffness below the core to a law."""
    at_core = {f"core_{name}": float(v[0]) for name, v in wall.evaluate(np.array([wall.core]))._asdict().items()}
    words = {"core": wall.core, "law": law, "traction": traction, "energy": energy, **at_core}
    return NativeLaw(_filled("core", **words), error)


def felt(wall: Wall) -> float:
    """Gap beyond which a law has no force, or that of an exponential is below rounding; infinite if there is none."""
    decay = getattr(wall, "decay_length", None)
    return wall.reach if decay is None else -decay * float(np.log(np.finfo(np.float64).eps))


def _filled(kind: str, **values: object) -> str:
    return filled(read_template(f"law.{kind}"), values).rstrip()


def _spline(wall: LennardJonesSpline, tolerance: float) -> NativeLaw:
    attraction = _filled("spline-attraction" if wall.range > 0 else "spline-repulsive")
    words = {"k": wall.minimum_stiffness, "range": wall.range, "work": wall.work_of_adhesion, "attraction": attraction}
    return with_core(
        wall,
        _filled("spline", **words),
        "ternary(v_gap>1.0,-v_pull,ternary(v_gap>v_core,v_push,v_core_push))",
        "ternary(v_gap>1.0,v_pull_energy,ternary(v_gap>v_core,v_push_energy,v_core_push_energy))",
    )


def _exponential(wall: Exponential, tolerance: float) -> NativeLaw:
    gamma, rho, stiffness = wall.surface_energy, wall.decay_length, wall.core_stiffness
    return NativeLaw(_filled("exponential", core=NO_CORE, gamma=gamma, rho=rho, stiffness=stiffness))


def _table(wall: TabulatedWall, tolerance: float) -> NativeLaw:
    """Cubic pieces of the traction, which each atom looks up, and of its integral."""
    pieces, error = _pieces(wall, tolerance)
    x, c = pieces.x, pieces.c
    energy = -pieces.antiderivative()(x)
    text = _filled(
        "table",
        pieces=c.shape[1],
        beginning=vector(x[:-1]),
        coefficients="\n".join(f'variable        a{i} vector "{vector(c[3 - i])}"' for i in range(4)),
        first_energy=vector(energy[:-1] - energy[-1]),
        start=x[0],
        length=(x[-1] - x[0]) / c.shape[1],
    )
    return with_core(wall, text, error=error)


def in_pieces(wall: Wall, tolerance: float) -> NativeLaw:
    """A law that has no formula here, by a table of its traction; one without cut-off is shifted to end at zero."""
    gap = _knots(wall)
    traction = wall.evaluate(gap).traction
    table = TabulatedWall(gap, traction - traction[-1])
    between = (gap[1:] + gap[:-1]) / 2
    error = float(np.abs(table.evaluate(between).traction - wall.evaluate(between).traction).max())
    pieces = _table(table, tolerance)
    return replace(pieces, error=pieces.error + error)


LAWS: dict[type[Wall], Callable[[Any, float], NativeLaw]] = {
    LennardJonesSpline: _spline,
    InversePowers: in_pieces,
    Exponential: _exponential,
    TabulatedWall: _table,
}
"""Functions that write the laws that decks name; others are written as cubic pieces, and read again as tables."""
PARTS: dict[type[Wall], Callable[[Any, float], Wall]] = {Exponential: _weaker}
"""Parts of laws that reach the second layer, where these are laws of a kind; others are tables."""


def in_formula(wall: Wall) -> bool:
    """Whether a law is a formula here, not cubic pieces."""
    return LAWS.get(type(wall), in_pieces) in (_spline, _exponential)


def name_of(wall: Wall) -> str:
    """The class by which the law of a deck is read again."""
    return (type(wall) if type(wall) in LAWS else TabulatedWall).__name__


def _pieces(wall: TabulatedWall, tolerance: float) -> tuple[scipy.interpolate.PPoly, float]:
    """Cubic pieces of equal length with the values and slopes of a table at their ends, and their largest error in E*.

    The number grows by a quarter until the tolerance is reached, up to that of an equidistant table itself or
    :data:`PIECES`.
    """
    count, rows = 8, wall.gap.size - 1
    equal = np.allclose(np.diff(wall.gap), (wall.gap[-1] - wall.gap[0]) / rows, rtol=1e-9, atol=0)
    while True:
        exact = equal and count <= rows < count + max(1, count // 4)
        pieces = _hermite(wall, min(rows if exact else count, PIECES))
        step = (wall.gap[-1] - wall.gap[0]) / max(20 * pieces.c.shape[1], 20 * rows)
        at = np.arange(wall.gap[0] + step / 2, wall.gap[-1], step)
        law = wall.evaluate(at).traction
        error = np.abs(pieces(at) - law)
        allowed = tolerance * np.maximum(np.abs(law), wall.largest_tension or np.abs(law).max())
        if count >= PIECES or (error <= allowed).all():
            return pieces, float(error.max())
        count += max(1, count // 4)


def _hermite(wall: TabulatedWall, count: int) -> scipy.interpolate.PPoly:
    """Cubic pieces of equal length with the values and slopes of a table at their ends."""
    x = np.linspace(wall.gap[0], wall.gap[-1], count + 1)
    law = wall.evaluate(np.minimum(x, np.nextafter(wall.gap[-1], 0)))  # beyond the last row the law is zero
    spline = scipy.interpolate.CubicHermiteSpline(x, np.append(law.traction[:-1], 0.0), -law.stiffness)
    return scipy.interpolate.PPoly(spline.c, spline.x)


_IN_PARTS = "# It reaches layers below: an atom has its part, w(gap) - w(gap + d), with d the distance of layers.\n"


def wall_table(wall: Wall, tolerance: float = TOLERANCE, of_atoms: Wall | None = None) -> str:
    """``wall.table``: the law at knots that include the core, the change of sign and, if there is one, the end.

    Parameters
    ----------
    wall, tolerance : as of :func:`native_law`.
    of_atoms : the law of each atom, where it is another (:func:`law_of_atoms`).
    """
    here = of_atoms or wall
    gap, named, stated = wall.knots.get("gap"), "A table", "the law itself"
    if gap is None:
        gap, named, stated = _knots(wall), str(wall), "the law continues beyond the last gap"
    law = wall.evaluate(gap)
    # Rounding leaves a traction of 1e-17 at the end of the range, where the law ends.
    traction = np.where(gap < wall.reach, law.traction, 0.0)
    if not wall.knots and np.isfinite(wall.reach):
        between = (gap[1:] + gap[:-1]) / 2
        error = np.abs(TabulatedWall(gap, traction).evaluate(between).traction - wall.evaluate(between).traction).max()
        stated = f"a cubic spline through the tractions errs by at most {error:.1e} E*"
    text = io.StringIO()
    text.write(
        "# Wall law: energy and traction per area against gap; traction = -d energy/d gap, positive in compression.\n"
        "# Units: gap a0, energy E* a0, traction E*.\n"
        f"# {named}: {gap.size} knots; {stated}.\n"
        f"# The formulas of in.wall differ from the law by at most {native_law(here, tolerance).error:.1e} E*.\n"
        f"{'' if here == wall else _IN_PARTS}"
        "# gap energy traction\n"
    )
    rows = np.column_stack([gap, law.energy, traction]).ravel().tolist()
    text.write("%.17g %.17g %.17g\n" * gap.size % tuple(rows))
    return text.getvalue()


def _knots(wall: Wall, without_core: float = 0.3) -> Real:
    start = wall.core if np.isfinite(wall.core) else wall.zero_gap - without_core
    end = wall.reach if np.isfinite(wall.reach) else wall.zero_gap + 10.0
    sides = [_between(start, wall.zero_gap)]
    if end > wall.zero_gap:
        sides.append(_between(wall.zero_gap, end)[1:])
    return np.concatenate(sides)


def _between(low: float, high: float) -> Real:
    """Equidistant knots that cover a length, both ends included."""
    return np.linspace(low, high, max(4, int(np.ceil((high - low) / _TABLE_SPACING)) + 1))


def read_wall_table(path: Path) -> TabulatedWall:
    """The wall law of a ``wall.table``, as a cubic spline through its knots, shifted to end at zero."""
    gap, _, traction = np.loadtxt(path, unpack=True)
    return TabulatedWall(gap, traction - traction[-1])


def read_law(law: str, numbers: Mapping[str, Any], table: Path) -> Wall:
    """The wall law of a deck, by the name of its class and its parameters; a :class:`TabulatedWall` by its table.

    Raises ValueError or TypeError if no law of this version has this name and these parameters, or OSError if the table
    cannot be read.
    """
    known = {kind.__name__: kind for kind in LAWS}
    if law not in known:
        raise ValueError(f"the wall law {law!r} is not known to this version ({', '.join(known)})")
    if law == TabulatedWall.__name__:
        return read_wall_table(table)
    return known[law](**{name: tuple(v) if isinstance(v, list) else v for name, v in numbers.items()})
