"""Physical bounds: the one judge of moduli, works of adhesion, lengths, masses and elements.

A quantity beyond these bounds has been given in another unit, or by a slip.  Every place where a person gives one asks
here, so that no bound is written twice:

* a text with its unit, as of ``continuum predict`` and of decks: :func:`from_text`;
* an argument in a unit that its docstring names: :func:`given`.  ``atomistic.RoughWall`` has
  ``given("contact_modulus", 0.85, "modulus", "eV/A3")``, which is 0.85, also of ``"136GPa"``, and an error of 136; and
  ``given("a0", 2.55, "spacing", "A")`` where a point is an atom;
* a number in SI that was measured or calculated, as a pixel: :func:`fault`;
* atoms: ``mass("mass", 63.5, "Cu", atomic_masses[29])`` and ``elements("coefficients", ("Al",), ("Cu",))``, with the
  masses of ``ase.data``, as this package knows no periodic table.  Decks and potentials call both.

A new kind of quantity is a line of :data:`POSSIBLE`.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

from continuum.inputs import units
from continuum.inputs.arguments import ArgumentError, number

Kind = Literal["modulus", "work", "range", "spacing", "thickness", "probe", "tip", "wavelength", "pixel", "height",
               "load", "force"]  # fmt: skip


class Bounds(NamedTuple):
    """Smallest and largest possible value of a quantity, in SI, with materials that have them."""

    quantity: units.Quantity
    least: float
    most: float
    of: str
    example: str


POSSIBLE: Mapping[Kind, Bounds] = {
    # From gels on; diamond has E* = 1.16 TPa.
    "modulus": Bounds("pressure", 1.0, 2e12, "solid", "2MPa"),
    # Up to soft adhesives, whose w has what they lose as they are drawn.
    "work": Bounds("energy_per_area", 1e-9, 1e3, "interface", "50mJ/m2"),
    # From a tenth of the shortest decay of a bond to the fibrils of an adhesive tape.
    "range": Bounds("length", 1e-12, 1e-3, "attraction", "0.5nm"),
    # Neighbours in solids are .07 to .6 nm apart; beads of coarse models some nanometres.
    "spacing": Bounds("length", 5e-11, 1e-8, "solid", "0.25nm"),
    "thickness": Bounds("length", 1e-10, 1e-2, "coating", "50nm"),
    # From a sharp tip to a lens.
    "probe": Bounds("length", 1e-9, 1.0, "probe", "10um"),
    # From the weight of a film to the hardness of diamond.
    "load": Bounds("pressure", 1e-3, 2e11, "contact", "1MPa"),
    # From a bond to a press.
    "force": Bounds("force", 1e-12, 1e9, "contact", "1mN"),
    # From an atom to the ball of a profilometer.
    "tip": Bounds("length", 1e-10, 1e-1, "tip", "10nm"),
    "wavelength": Bounds("length", 1e-12, 1e3, "map", "100nm"),
    # From a map of atoms, with ten points between neighbours, to one of a landscape.
    "pixel": Bounds("length", 2.5e-11, 100.0, "map", "10nm"),
    # The smoothest surfaces that are measured, cleaved mica and graphite, have an rms height of some 20 pm.
    "height": Bounds("length", 1e-12, 100.0, "map", "1nm"),
}
"""Bounds of each kind of quantity."""
LIGHTEST, HEAVIEST = 1.0, 300.0
"""Masses of atoms, in u: from hydrogen on, and beyond the heaviest element."""
ISOTOPES, TRITON = 1.35, 3.02
"""Factor to the mass of an element within which its isotopes and united atoms (CH3 for C) lie, and what those of
hydrogen reach, in u."""


def ends(kind: Kind) -> str:
    """The bounds of a kind in words, as "1 Pa to 2 TPa"."""
    bounds = POSSIBLE[kind]
    return " to ".join(units.readable(end, bounds.quantity, 3) for end in (bounds.least, bounds.most))


def fault(value: float, kind: Kind) -> str:
    """Reason why a number in SI is not possible; empty if it is."""
    bounds = POSSIBLE[kind]
    return "" if bounds.least <= value <= bounds.most else f"no {bounds.of} has this; possible are {ends(kind)}"


def from_text(text: str, kind: Kind) -> float:
    """A quantity in SI from a text with its unit; raises ValueError if it is none, or not possible."""
    value = units.parse(text, POSSIBLE[kind].quantity)
    if why := fault(value, kind):
        raise ValueError(f"{text!r}: {why}")
    return value


def given(name: str, value: Any, kind: Kind, unit: str) -> float:
    """A quantity in a unit that the door names, from a number in this unit or from a text with its own unit.

    Raises
    ------
    ArgumentError
        If it is neither, or not possible.

    Examples
    --------
    >>> given("contact_modulus", 0.85, "modulus", "eV/A3")
    0.85
    >>> round(given("contact_modulus", "136GPa", "modulus", "eV/A3"), 3)
    0.849
    """
    bounds, size = POSSIBLE[kind], units.unit_size(unit, POSSIBLE[kind].quantity)
    shown = unit.replace("A", "Å").replace("3", "³").replace("2", "²")
    allowed = f'a number in {shown}, or a text with its unit, as "{bounds.example}"'
    if isinstance(value, str):
        try:
            return from_text(value, kind) / size
        except ValueError as error:
            raise ArgumentError(name, value, f"{allowed} ({error})") from None
    try:
        found = number(name, value, above=0)
    except ArgumentError:
        raise ArgumentError(name, value, f"{allowed}, greater than 0") from None
    if why := fault(found * size, kind):
        said = units.readable(found * size, bounds.quantity, 3)
        raise ArgumentError(name, value, f"{allowed}: {value:g} {shown} is {said}, and {why}")
    return found


def mass(name: str, value: Any, symbol: str = "", standard: float | None = None) -> float:
    """The mass of an atom in u, which fits its element.

    Parameters
    ----------
    name, value : of the argument.
    symbol, standard : chemical symbol, and the standard atomic weight of this element in u; None if it has none.

    Raises ArgumentError if no atom, or none of this element, has such a mass.
    """
    if standard is None:
        return number(name, value, least=LIGHTEST, most=HEAVIEST)
    least, most = standard / ISOTOPES, max(standard * ISOTOPES, TRITON)
    try:
        return number(name, value, least=least, most=most)
    except ArgumentError:
        allowed = f"{least:.4g} to {most:.4g} u, as {symbol} has {standard:.4g} u"
        raise ArgumentError(name, value, allowed) from None


def elements(name: str, said: Sequence[str], wanted: Sequence[str]) -> None:
    """Check that the elements which one part of an input names are those of another, type by type.

    Words that are not chemical symbols, as ``NULL`` in ``pair_coeff``, stand for no atom, and are passed over.

    Raises ArgumentError if they differ.
    """
    wrong = next((f"{one} in place of {other}" for one, other in zip(said, wanted, strict=False)
                  if one != other and one != "NULL"), "")  # fmt: skip
    if wrong or len(said) != len(wanted):
        of = wrong or f"{len(said)} elements for {len(wanted)}"
        raise ArgumentError(name, " ".join(said), f"the elements of the input, {' '.join(wanted)}: it has {of}")
