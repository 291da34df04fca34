"""Moduli, work of adhesion and range of attraction of some materials, each with its source.

A material is one entry of ``materials.toml``, with its sources.  The values are starting points of an estimate and do
not replace measured ones: works of adhesion vary by factors with preparation and humidity, moduli of elastomers with
cross-linking.  Values without a source are not in the table and must be given where they are needed.
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from itertools import zip_longest
from numbers import Real
from typing import Any

import numpy as np

from continuum.inputs import possible, units
from continuum.inputs.arguments import ArgumentError, instance, number, texts
from continuum.inputs.errors import InputError
from continuum.inputs.toml import slip
from continuum.model.substrates import HalfSpace, LayeredHalfSpace, Substrate
from continuum.model.substrates.crystal import CubicConstants, HexagonalConstants, contact_modulus


class InterfaceError(InputError, ValueError):
    """The description of a contact is incomplete or contradictory: the message has what is missing or wrong."""


@dataclass(frozen=True)
class Material:
    """A material, in SI units.

    Parameters
    ----------
    name : in lower case.
    modulus, poisson : Young's modulus E, in Pa, and Poisson's ratio.
    work_of_adhesion : w of two smooth surfaces, in J/m²; None if no source is known.
    range : Δr, in m.
    sources : sources of these values.
    spacing : a0 of the atoms, in m; None if roughness does not consist of atomic steps.
    contact_modulus : E* of the face of a crystal, in Pa, whose E and ν are those along its normal; None of an isotropic
        solid, whose E* is E/(1 - ν²).
    """

    name: str
    modulus: float
    poisson: float
    work_of_adhesion: float | None
    range: float
    sources: tuple[str, ...]
    spacing: float | None = None
    contact_modulus: float | None = None

    @property
    def plane_strain_modulus(self) -> float:
        """E*, in Pa: E/(1 - ν²), or that of the face of a crystal."""
        return self.modulus / (1 - self.poisson**2) if self.contact_modulus is None else self.contact_modulus


@cache
def materials() -> Mapping[str, Material]:
    """Materials by name."""
    text = resources.files("continuum.maps.verdict").joinpath("materials.toml").read_text(encoding="utf-8")
    table = tomllib.loads(text)
    found = {}
    for name, entry in table["materials"].items():
        reach = table["ranges"][entry["range"]]
        work, how = _work_of_adhesion(entry, table["cutoff"])
        sources = (*entry["sources"], *how, reach["source"])
        modulus, poisson, face = _elasticity(entry)
        found[name] = Material(name, modulus, poisson, work, reach["value"], sources, entry.get("spacing"), face)
    return found


def _elasticity(entry: Mapping[str, Any]) -> tuple[float, float, float | None]:
    """E, ν and, of a crystal, E* of its face; of which E and ν are those along the normal."""
    constants = entry.get("elastic")
    if constants is None:
        return entry["modulus"], entry["poisson"], None
    crystal = HexagonalConstants(**{"c13": constants["c12"], "c33": constants["c11"], **constants})
    poisson = crystal.c13 / (crystal.c11 + crystal.c12)
    face = crystal.contact_modulus() if "c33" in constants else contact_modulus(CubicConstants(**constants))
    return crystal.c33 - 2 * poisson * crystal.c13, poisson, face


def _work_of_adhesion(entry: Mapping[str, Any], cutoff: Mapping[str, Any]) -> tuple[float | None, list[str]]:
    """The work of adhesion of an entry of the table, also from a surface energy or a Hamaker constant."""
    if "hamaker" in entry:
        work = entry["hamaker"] / (12 * np.pi * cutoff["distance"] ** 2)
        text = f"w: of van der Waals forces between dry, clean surfaces, A/(12π D0²), A = {entry['hamaker']:.3g} J"
        return float(work), [text, cutoff["source"]]
    if "surface_energy" in entry:
        return 2 * entry["surface_energy"], ["w: twice the surface energy γ"]
    return entry.get("work_of_adhesion"), []


@dataclass(frozen=True)
class Body:
    """Moduli and materials of one of two bodies, in SI units; None if unknown.

    Parameters
    ----------
    modulus, poisson : Young's modulus and Poisson's ratio; they overrule those of the material.
    material : source of values that are not given.
    """

    modulus: float | None = None
    poisson: float | None = None
    material: Material | None = None

    def __post_init__(self) -> None:
        if self.modulus is not None:
            object.__setattr__(self, "modulus", number("modulus", self.modulus, above=0))
        if self.poisson is not None:
            object.__setattr__(self, "poisson", number("poisson", self.poisson, above=-1, most=0.5))
        if self.material is not None:
            instance("material", self.material, Material)

    @property
    def ratio(self) -> float | None:
        """Poisson's ratio; None if unknown."""
        return self.material.poisson if self.poisson is None and self.material is not None else self.poisson

    @property
    def plane_strain_modulus(self) -> float | None:
        """E/(1 - ν²), in Pa; None if neither E nor ν is known, an InterfaceError if one of them is missing.

        That of a material of which neither is replaced is its own.
        """
        modulus, poisson = self.modulus, self.ratio
        if self.material is not None and self.modulus is None and self.poisson is None:
            return self.material.plane_strain_modulus
        if self.material is not None:
            modulus = self.material.modulus if modulus is None else modulus
        if modulus is None and poisson is None:
            return None
        if modulus is None or poisson is None:
            raise InterfaceError("a body needs a modulus and a Poisson's ratio: `modulus` and `poisson`, or `material`")
        return modulus / (1 - poisson**2)


@dataclass(frozen=True)
class Coating:
    """An elastic layer and its base, in SI units.

    Parameters
    ----------
    thickness : thickness of the layer, in m.
    contact_modulus, poisson : E/(1 - ν²) of the layer, in Pa, and its ν.
    base_modulus, base_poisson : the same of the half-space below.
    """

    thickness: float
    contact_modulus: float
    poisson: float
    base_modulus: float
    base_poisson: float

    def substrate(self, unit: float) -> LayeredHalfSpace:
        """Elastic response, in units of the contact modulus of the layer and of a length in m; it checks the values."""
        layer = (self.thickness / unit, 1.0, self.poisson)
        return LayeredHalfSpace([layer], (self.base_modulus / self.contact_modulus, self.base_poisson))


@dataclass(frozen=True)
class Interface:
    """Two bodies in contact, in SI units."""

    contact_modulus: float
    """E*, in Pa."""
    work_of_adhesion: float
    """w, in J/m²."""
    range: float
    """Δr, in m."""
    spacing: float | None
    """a0 of the atoms, in m."""
    origin: tuple[str, ...] = ()
    """Sources of the values."""
    probe: float | None = None
    """Radius of a spherical probe, in m; None if no pull-off force is asked for."""
    pressure: float | None = None
    """Mean pressure at which area and gap are asked for, in Pa; None if none is."""
    load: float | None = None
    """Force on the area of the map at which they are asked for, in N, in place of a pressure; None if none is."""
    coating: Coating | None = None
    """Coating of the elastic body, which E* then belongs to; None if there is none."""

    def __post_init__(self) -> None:
        optional = ("spacing", "probe", "pressure", "load")
        for name in ("contact_modulus", "work_of_adhesion", "range", *optional):
            value = getattr(self, name)
            if value is not None or name not in optional:
                object.__setattr__(self, name, number(name, value, above=0))

    @property
    def values(self) -> str:
        """E*, w and range, in words."""
        of: tuple[tuple[str, float, units.Quantity], ...] = (
            ("E*", self.contact_modulus, "pressure"),
            ("w", self.work_of_adhesion, "energy_per_area"),
            ("range", self.range, "length"),
        )
        return ", ".join(f"{name} {units.readable(value, quantity, 3)}" for name, value, quantity in of)

    @property
    def adhesion_length(self) -> float:
        """l_a = w/E*, in m."""
        return self.work_of_adhesion / self.contact_modulus

    def substrate(self, unit: float) -> Substrate:
        """Elastic response of the contact, in units of its contact modulus and of a length in m."""
        return HalfSpace("clamped") if self.coating is None else self.coating.substrate(unit)


def reduced_modulus(moduli: Sequence[float]) -> float:
    """E* of bodies in contact, 1/E* = sum of (1 - ν²)/E; a single one is pressed on a rigid body."""
    return float(1 / np.sum(1 / np.asarray(moduli)))


def interface(
    bodies: Sequence[Body],
    contact_modulus: float | None = None,
    work_of_adhesion: float | None = None,
    range: float | None = None,
    spacing: float | None = None,
    probe: float | None = None,
) -> Interface:
    """Combine two bodies to one contact; given values overrule those of the materials.

    There is one body if the other is rigid; the values are those of :class:`Interface`.

    Raises InterfaceError if a value is missing, or E* is given twice.
    """
    origin: list[str] = []
    known = [m for body in bodies if (m := body.plane_strain_modulus) is not None]
    materials = [body.material for body in bodies if body.material is not None]
    if contact_modulus is not None:
        if any(body.modulus is not None or body.poisson is not None for body in bodies):
            msg = "E* is given twice, by `contact_modulus` and by `modulus` with `poisson`: leave out one"
            raise InterfaceError(msg)
        origin.append("E* as given")
    elif known:
        contact_modulus = reduced_modulus(known)
        origin.append("E* of two elastic bodies" if len(known) == 2 else "E* of one elastic body on a rigid one")
    if work_of_adhesion is None and materials:
        work_of_adhesion = _mean_work(materials)
        if len(materials) == 2 and materials[0] != materials[1]:
            origin.append("w as the geometric mean of the two materials', an estimate for dispersion forces")
    if range is None and materials:
        range = float(np.mean([m.range for m in materials]))
    if contact_modulus is None or work_of_adhesion is None or range is None:
        needed = {
            "a contact modulus (`contact_modulus`, or `modulus` with `poisson`, or `material`)": contact_modulus,
            "a work of adhesion (`work`, or `material`)": work_of_adhesion,
            "a range of attraction (`range`, or `material`)": range,
        }
        raise InterfaceError("missing: " + "; ".join(name for name, value in needed.items() if value is None))
    if spacing is None:
        spacings = [m.spacing for m in materials]
        spacing = max((s for s in spacings if s is not None), default=None) if None not in spacings else None
    for material in dict.fromkeys(materials):
        origin += [f"{material.name}: {source}" for source in material.sources]
    return Interface(contact_modulus, work_of_adhesion, range, spacing, tuple(origin), probe)


def _mean_work(materials: Sequence[Material]) -> float:
    """Geometric mean of the works of adhesion of both materials; raises InterfaceError if one has none."""
    works = [material.work_of_adhesion for material in materials]
    known = [work for work in works if work is not None]
    if len(known) < len(works):
        names = ", ".join(material.name for material in materials)
        of = f"the pair {names}" if len(materials) > 1 else names
        raise InterfaceError(f"no work of adhesion is known for {of}: give `work`")
    return float(np.exp(np.mean(np.log(known))))


def read_interface(
    *,
    material: str | Sequence[str] = (),
    modulus: str | Sequence[str] = (),
    poisson: str | float | Sequence[str | float] = (),
    contact_modulus: str | None = None,
    work: str | None = None,
    range: str | None = None,
    spacing: str | None = None,
    probe: str | None = None,
    pressure: str | None = None,
    load: str | None = None,
    coating: str | None = None,
) -> Interface:
    """Parse an interface from text: numbers with units and names of materials, the first of each for the first body.

    Raises InterfaceError with all faults at once; ArgumentError if an argument is of another type, such as a number
    without its unit.
    """
    faults: list[str] = []
    names = texts("material", material, '"silicon"')
    found = [materials().get(name.lower()) for name in names]
    for name, one in zip(names, found, strict=True):
        if one is None:
            hint = slip(name.lower(), materials(), "did you mean {}? ")
            faults.append(f"`material` {name!r} is unknown: {hint}known are {', '.join(materials())}")
    moduli = [_amount(faults, "modulus", text, "modulus") for text in texts("modulus", modulus, '"2MPa"')]
    ratios = [_ratio(faults, value) for value in _ratios(poisson)]
    if max(len(found), len(moduli), len(ratios)) > 2:
        faults.append("a contact has two bodies: `material`, `modulus` and `poisson` can be given twice")
    given = [
        _amount(faults, "contact_modulus", contact_modulus, "modulus"),
        _amount(faults, "work", work, "work"),
        _amount(faults, "range", range, "range"),
        _amount(faults, "spacing", spacing, "spacing"),
        _amount(faults, "probe", probe, "probe"),
    ]
    mean, force = _amount(faults, "pressure", pressure, "load"), _amount(faults, "load", load, "force")
    if pressure is not None and load is not None:
        faults.append("`pressure` and `load` are one thing: give one of them")
    if faults:
        raise InterfaceError("\n".join(faults))
    bodies = [Body(*one) for one in zip_longest(moduli, ratios, found)]
    whole = replace(interface(bodies, *given), pressure=mean, load=force)
    if coating is None:
        return whole
    if len(bodies) != 1 or contact_modulus is not None or probe is not None:
        raise InterfaceError(
            "`coating` needs one elastic body, and cannot be combined with `contact_modulus`, a second body or `probe`"
        )
    layer = _coating(bodies[0], instance("coating", coating, str, 'a text such as "50nm:200GPa:0.2"'))
    said = f"E* is that of a coating of {units.readable(layer.thickness, 'length', 3)}"
    return replace(whole, contact_modulus=layer.contact_modulus, coating=layer, origin=(said, *whole.origin))


def _coating(body: Body, text: str) -> Coating:
    """The coating of a body: thickness, Young's modulus and Poisson's ratio."""
    base, ratio = body.plane_strain_modulus, body.ratio
    if base is None or ratio is None:
        raise InterfaceError("`coating` needs the body below it: `modulus` and `poisson`, or `material`")
    parts, faults = text.split(":"), list[str]()
    if len(parts) != 3:
        raise InterfaceError(
            f"`coating` {text!r}: write thickness, Young's modulus and Poisson's ratio, as 50nm:200GPa:0.2"
        )
    thickness, modulus = (
        _amount(faults, "coating", parts[0], "thickness"),
        _amount(faults, "coating", parts[1], "modulus"),
    )
    poisson = _ratio(faults, parts[2])
    if faults or thickness is None or modulus is None or poisson is None:
        raise InterfaceError("\n".join(faults))
    return Coating(thickness, modulus / (1 - poisson**2), poisson, base, ratio)


def _amount(faults: list[str], name: str, text: str | None, kind: possible.Kind) -> float | None:
    """Parse a quantity with its unit to SI; errors are added to the faults."""
    if text is None:
        return None
    instance(name, text, str, f'a text such as "{possible.POSSIBLE[kind].example}"')
    try:
        return possible.from_text(text, kind)
    except ValueError as error:
        faults.append(f"`{name}` {error}")
        return None


def _ratio(faults: list[str], value: str | float) -> float | None:
    """Parse Poisson's ratio; errors are added to the faults."""
    if not isinstance(value, str):
        return number("poisson", value, above=-1, most=0.5)
    try:
        found = float(value)
    except ValueError:
        faults.append(f"`poisson` {value!r} is not a number")
        return None
    if not -1 < found <= 0.5:
        faults.append(f"`poisson` {value!r}: a Poisson's ratio lies above -1 and is at most 0.5")
    return found


def _ratios(poisson: Any) -> tuple[str | float, ...]:
    """Poisson's ratios, numbers or texts of numbers: they have no unit."""
    several = () if poisson is None else (poisson,) if isinstance(poisson, str | Real) else poisson
    sound = isinstance(several, Sequence) and all(
        isinstance(one, str | Real) and not isinstance(one, bool) for one in several
    )
    if not sound:
        raise ArgumentError("poisson", poisson, "a number such as 0.5, or two in a list")
    return tuple(several)
