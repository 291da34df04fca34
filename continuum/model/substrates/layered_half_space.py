"""Isotropic layers on a half-space."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar

from pydantic import Field

from continuum.inputs.arguments import instance
from continuum.inputs.tables import Description, Fault, constraint
from continuum.model.fourier import Real
from continuum.model.grid import LONGEST, Grid
from continuum.model.layered import Solid, layered_stiffness
from continuum.model.substrates.substrate import MeanMode, PeriodicResponse, Poisson, with_mean

CONTRAST = 1e12
"""Largest ratio of a modulus to E*, or its inverse: beyond it one material is rigid compared with another."""
MOST_LAYERS = 1000
Modulus = Annotated[float, Field(ge=1 / CONTRAST, le=CONTRAST)]
"""A contact modulus, in E*."""


def _other_unit(moduli: Sequence[float]) -> str:
    """Allowed moduli, if the unit of pressure is not among those given."""
    least, most = min(moduli), max(moduli)
    if least <= 1 <= most:
        return ""
    return f"contact moduli in E*: one is 1, or some are above and some below, not all from {least:g} to {most:g}"


class Base(Description):
    """[substrate.base]: the half-space below."""

    contact_modulus: Modulus
    """E/(1-ν²), in E*"""
    poisson: Poisson
    """Poisson's ratio"""


class Film(Description):
    """One of the layers of [substrate]."""

    thickness: Annotated[float, Field(gt=0, le=LONGEST)]
    """in a0"""
    contact_modulus: Modulus
    """E/(1-ν²), in E*"""
    poisson: Poisson
    """Poisson's ratio"""


class LayeredHalfSpace(PeriodicResponse, kind="layered-half-space"):
    """Isotropic layers, bonded to one another and to an isotropic half-space; a graded solid is many layers.

    E*, the unit of pressure, is one of the contact moduli E/(1-ν²), or between them.  It is best that of the top
    layer, on which short waves depend: areas, κ and warnings then have the same meaning as on a half-space, and layers
    on a stiff base agree with :class:`Layer`.  K_q is accurate to 1e-13 for any thickness and Poisson's ratio
    (:func:`continuum.model.layered.layered_stiffness`).

    In Python layers are tuples (thickness in a0, contact modulus in E*, Poisson's ratio), and so is the base (contact
    modulus in E*, Poisson's ratio).
    """

    example: ClassVar[Mapping[str, Any]] = {
        "layers": ({"thickness": 2.0, "contact_modulus": 1.0, "poisson": 0.3},),
        "base": {"contact_modulus": 0.4, "poisson": 0.5},
        "mean": "clamped",
    }

    layers: Annotated[tuple[Film, ...], Field(max_length=MOST_LAYERS)]
    """from the surface down: {thickness, contact_modulus, poisson} of each, in a0 and E*"""
    base: Base
    """half-space below: {contact_modulus, poisson}, in E*"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""

    def __init__(
        self,
        layers: Sequence[tuple[float, float, float] | Film],
        base: tuple[float, float] | Base,
        mean: MeanMode = "clamped",
    ) -> None:
        self._take(layers=layers, base=base, mean=mean)

    @constraint
    def _unit(self) -> Iterator[Fault]:
        if not self.layers:
            yield Fault(("layers",), "at least one layer", 'response = "half-space" has none')
            return
        moduli = [film.contact_modulus for film in self.layers]
        if other := _other_unit([*moduli, self.base.contact_modulus]):
            yield Fault(("layers",), other, "moduli in another unit: divide them by that of the top layer")

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum, in E*/a0; 0.1 µs for each layer and different length of a wavevector."""
        layers = [(film.thickness, Solid(film.contact_modulus, film.poisson)) for film in self.layers]
        base = Solid(self.base.contact_modulus, self.base.poisson)
        return with_mean(layered_stiffness(layers, base, instance("grid", grid, Grid).wavenumber), self.mean)
