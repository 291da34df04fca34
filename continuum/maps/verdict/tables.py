"""The tables [topography] and [interface] of the input of a prediction.

Each key is also an argument of :func:`continuum.predict` and an option of the command, with the same help text.
"""

from typing import Annotated, Any

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from continuum.inputs import possible
from continuum.inputs.keys import InputFile, OneOrSeveral
from continuum.inputs.tables import Table
from continuum.inputs.toml import Document
from continuum.maps.mending import Detrending


def _quantity(kind: possible.Kind) -> AfterValidator:
    def check(text: str) -> str:
        try:
            possible.from_text(text, kind)
        except ValueError as error:
            quantity, *_, example = possible.POSSIBLE[kind]
            said = {"words": quantity.replace("_", " "), "ends": possible.ends(kind), "example": f'"{example}"'}
            raise PydanticCustomError("quantity", "a {words} with its unit, {ends}, as {example}", said) from error
        return text

    return AfterValidator(check)


Texts = Annotated[tuple[str, ...], OneOrSeveral]
Length = Annotated[str, _quantity("wavelength")]
Modulus = Annotated[str, _quantity("modulus")]


class TopographyTable(Table):
    """One measured map, or two that face each other, and how they are prepared."""

    maps: Annotated[tuple[InputFile, ...], OneOrSeveral, Field(min_length=1)]
    """Files of the maps; two for two rough bodies, several for one surface with join."""
    size: Texts = ()
    """Physical size LX or LX,LY, as 10um; x is along a line of text, and along the first index of an array; one length
    means square pixels.  Only if the file does not have it; give it twice for two files."""
    unit: Texts = ()
    """Unit of the heights, or UNIT,UNIT of positions and heights if a file has columns of both.  Only if the file does
    not have it."""
    dataset: Texts = ()
    """Dataset of an HDF5 file, if it has several."""
    part: Texts = ()
    """Map of a container, or channel of a file, if it has several; "all" joins the measurements of a container into
    one spectrum."""
    join: bool = False
    """Join all files, as measurements of one surface, into one spectrum."""
    periodic: bool = False
    """The map is periodic (default: as the file says)."""
    override_size: bool = False
    """Let a given size or unit overrule that of the file."""
    detrend: Detrending | None = None
    """Background to subtract: the mean plane (default; of a periodic map the mean), a paraboloid ("curvature"), or the
    plane and then the median of each scan line ("lines")."""
    fill: str | float | None = None
    """Fill missing points, scars and outliers, up to this share of all points, as 5% (default: missing points only, up
    to 1%)."""
    void: Annotated[tuple[str | float, ...], OneOrSeveral] = ()
    """Number that stands for a missing height, in the unit of the file, as 99999; may be repeated.  "nan" if none
    does."""
    crop: str | None = None
    """Part of the map to use, X0,X1,Y0,Y1, as 1um,9um,0,8um."""
    cutoff: Length | None = None
    """Use only waves longer than this length, as 100nm."""
    tip: Annotated[str, _quantity("tip")] | None = None
    """Radius of the tip that measured the maps, as 10nm: waves too short for it count as not measured."""
    smallest: Length | None = None
    """Length, as 1nm, to which the spectrum is continued below the measured ones (default: two atoms)."""


class InterfaceTable(Table):
    """Moduli, adhesion and range of the contact of one elastic body on a rigid one, or of two elastic bodies."""

    material: Texts = ()
    """Name of a material with cited values (continuum/maps/verdict/materials.toml).  Given once the other body is
    rigid, given twice both are elastic."""
    modulus: Annotated[tuple[Modulus, ...], OneOrSeveral] = ()
    """Young's modulus of a body, as 70GPa; twice for two."""
    poisson: Annotated[tuple[str | float, ...], OneOrSeveral] = ()
    """Poisson's ratio of a body; twice for two."""
    contact_modulus: Modulus | None = None
    """Contact modulus E* = E/(1 - nu^2), as 80GPa, instead of modulus and poisson."""
    work: Annotated[str, _quantity("work")] | None = None
    """Work of adhesion w, as 50mJ/m2."""
    range: Annotated[str, _quantity("range")] | None = None
    """Range of the attraction, as 0.5nm (for a law without cut-off, its effective range)."""
    coating: str | None = None
    """Coating of the one elastic body: thickness, Young's modulus and Poisson's ratio, as 50nm:200GPa:0.2.  Only the
    solver can then decide, as the theories have one modulus."""
    spacing: Annotated[str, _quantity("spacing")] | None = None
    """Spacing a0 of the atoms, as 0.25nm, for the necessary condition on crystals."""
    probe: Annotated[str, _quantity("probe")] | None = None
    """Radius of a sphere that is pulled off the surface, as 10um; its pull-off force is printed."""
    pressure: Annotated[str, _quantity("load")] | None = None
    """Mean pressure, as 1MPa, at which the contact area and the mean gap are printed."""
    load: Annotated[str, _quantity("force")] | None = None
    """Force on the area of the map, as 1mN, in place of a pressure."""


class PredictionInput(Document):
    """Input of a prediction: one or two measured maps, and their interface."""

    result_schema = "stickiness-prediction"
    result_version = 1

    topography: TopographyTable
    interface: InterfaceTable

    @property
    def keys(self) -> dict[str, Any]:
        """The arguments of :func:`continuum.predict` that are given, except the maps."""
        tables = (self.topography, self.interface)
        return {name: getattr(table, name) for table in tables for name in table.model_fields_set if name != "maps"}


OPTIONS = {**TopographyTable.model_fields, **InterfaceTable.model_fields}
"""Keys of both tables; all except ``maps`` are arguments and options."""
OPTIONS.pop("maps")
