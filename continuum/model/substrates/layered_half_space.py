"""Isotropic layers on a half-space."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from continuum.arguments import ArgumentError, instance, number, pair
from continuum.model.fourier import Real
from continuum.model.grid import LONGEST, Grid
from continuum.model.layered import Solid, layered_stiffness
from continuum.model.substrates.substrate import MeanMode, PeriodicTable, Substrate, check_mean, with_mean
from continuum.tables import Fault, Table, constraint

CONTRAST = 1e12
"""Largest ratio of a modulus to E*, or its inverse: beyond it one material is rigid compared with another."""
MOST_LAYERS = 1000


@dataclass(frozen=True)
class LayeredHalfSpace:
    """Isotropic layers, bonded to one another and to an isotropic half-space; a graded solid is many layers.

    E*, the unit of pressure, is one of the contact moduli E/(1-ν²), or between them.  It is best that of the top
    layer, on which short waves depend: areas, κ and warnings then have the same meaning as on a half-space, and layers
    on a stiff base agree with :class:`Layer`.  K_q is accurate to 1e-13 for any thickness and Poisson's ratio
    (:func:`continuum.model.layered.layered_stiffness`).

    Parameters
    ----------
    layers : (thickness in a0, contact modulus in E*, Poisson's ratio ν) of each, from the surface down, 1 to 1000.
    base : (contact modulus in E*, ν) of the half-space below.
    mean : the mean mode; see :data:`MeanMode`.
    """

    layers: Sequence[tuple[float, float, float]]
    base: tuple[float, float]
    mean: MeanMode = "clamped"

    def __post_init__(self) -> None:
        layers = self.layers.tolist() if isinstance(self.layers, np.ndarray) else self.layers
        allowed = f"a list of 1 to {MOST_LAYERS} layers, (thickness, contact modulus, Poisson's ratio) of each"
        if isinstance(layers, str | bytes) or not isinstance(layers, Sequence) or not 1 <= len(layers) <= MOST_LAYERS:
            raise ArgumentError("layers", self.layers, allowed)
        found = []
        for i, layer in enumerate(layers):
            if isinstance(layer, str | bytes) or not isinstance(layer, Sequence) or len(layer) != 3:
                raise ArgumentError(f"layers[{i}]", layer, "(thickness, contact modulus, Poisson's ratio)")
            thickness = number(f"thickness of layers[{i}]", layer[0], above=0, most=LONGEST)
            found.append((thickness, *_solid(f"layers[{i}]", *layer[1:])))
        base = _solid("base", *pair("base", self.base))
        check_mean(self.mean)
        if other := _other_unit([modulus for _, modulus, _ in found] + [base.contact_modulus]):
            raise ArgumentError("layers", self.layers, other)
        object.__setattr__(self, "layers", tuple(found))
        object.__setattr__(self, "base", base)

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum, in E*/a0; 0.1 µs for each layer and different length of a wavevector."""
        layers = [(thickness, Solid(modulus, poisson)) for thickness, modulus, poisson in self.layers]
        wavenumber = instance("grid", grid, Grid).wavenumber
        return with_mean(layered_stiffness(layers, Solid(*self.base), wavenumber), self.mean)


def _solid(name: str, contact_modulus: object, poisson: object) -> Solid:
    modulus = number(f"contact modulus of {name}", contact_modulus, least=1 / CONTRAST, most=CONTRAST)
    return Solid(modulus, number(f"Poisson's ratio of {name}", poisson, above=-1, most=0.5))


def _other_unit(moduli: Sequence[float]) -> str:
    """Allowed moduli, if the unit of pressure is not among those given."""
    least, most = min(moduli), max(moduli)
    if least <= 1 <= most:
        return ""
    return f"contact moduli in E*: one is 1, or some are above and some below, not all from {least:g} to {most:g}"


class SolidTable(Table):
    """[substrate.base]: the half-space below."""

    contact_modulus: Annotated[float, Field(ge=1 / CONTRAST, le=CONTRAST)]
    """E/(1-ν²), in E*"""
    poisson: Annotated[float, Field(gt=-1, le=0.5)]
    """Poisson's ratio"""


class FilmTable(SolidTable):
    """One of the layers of [substrate]."""

    thickness: Annotated[float, Field(gt=0, le=LONGEST)]
    """in a0"""


class LayeredTable(PeriodicTable):
    """[substrate] of response "layered-half-space"."""

    response: Literal["layered-half-space"]
    layers: Annotated[tuple[FilmTable, ...], Field(max_length=MOST_LAYERS)]
    """from the surface down: {thickness, contact_modulus, poisson} of each"""
    base: SolidTable
    """half-space below: {contact_modulus, poisson}"""

    @constraint
    def _unit(self) -> Iterator[Fault]:
        if not self.layers:
            yield Fault(("layers",), "at least one layer", 'response = "half-space" has none')
            return
        solids: list[SolidTable] = [*self.layers, self.base]
        if other := _other_unit([solid.contact_modulus for solid in solids]):
            yield Fault(("layers",), other, "moduli in another unit: divide them by that of the top layer")

    def build(self) -> Substrate:
        layers = [(film.thickness, film.contact_modulus, film.poisson) for film in self.layers]
        return LayeredHalfSpace(layers, (self.base.contact_modulus, self.base.poisson), self.mean)
