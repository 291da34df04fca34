"""The input of a prediction: [topography] and [interface].

Each key is an argument of :func:`continuum.predict`, and an option of the command; its docstring is the help of both.
"""

from typing import Annotated, Any

from pydantic import AfterValidator, Field, ValidationError, ValidatorFunctionWrapHandler, WrapValidator
from pydantic_core import PydanticCustomError

from continuum import units
from continuum.files.tables import Document
from continuum.tables import InputFile, Table
from continuum.topography.mending import Detrending


def _several(value: Any, validated: ValidatorFunctionWrapHandler) -> Any:
    """One value as a list of one; its fault is that of the key."""
    if isinstance(value, tuple | list):
        return validated(value)
    try:
        return validated((value,))
    except ValidationError as error:
        fault = error.errors()[0]
        raise PydanticCustomError(fault["type"], "{text}", {"text": fault["msg"]}) from None


def _quantity(quantity: units.Quantity, example: str) -> AfterValidator:
    def check(text: str) -> str:
        try:
            units.parse(text, quantity)
        except ValueError as error:
            words = quantity.replace("_", " ")
            raise PydanticCustomError("quantity", "a positive {words} with its unit, as {example}",
                                      {"words": words, "example": example}) from error  # fmt: skip
        return text

    return AfterValidator(check)


Texts = Annotated[tuple[str, ...], WrapValidator(_several)]
Length = Annotated[str, _quantity("length", '"0.5nm"')]
Pressure = Annotated[str, _quantity("pressure", '"70GPa"')]


class TopographyTable(Table):
    """One measured map, or two that face each other, and what is done to them before they are judged."""

    maps: Annotated[tuple[InputFile, ...], WrapValidator(_several), Field(min_length=1)]
    """Files of the maps; two for two rough bodies, several for one surface with join."""
    size: Texts = ()
    """Physical size LX or LX,LY, from the first row of the array to the last and from the first column to the last; one
    length means square pixels.  Only if the file does not say; given twice it is one for each file."""
    unit: Texts = ()
    """Unit of the heights, or UNIT,UNIT of positions and heights where a file has columns of both; only if the file
    does not say."""
    dataset: Texts = ()
    """Dataset of an HDF5 file, if it has several."""
    part: Texts = ()
    """Map of a container, or channel of a file, if it has several; all: the measurements of a container joined into one
    spectrum."""
    join: bool = False
    """All files are measurements of one surface: they are joined into one spectrum."""
    periodic: bool = False
    """The map continues at its edges (default: as the file says)."""
    override_size: bool = False
    """A given size or unit overrules that of the file."""
    detrend: Detrending | None = None
    """What is taken off: the mean plane (default), or the mean (if periodic), a paraboloid, or plane and median of each
    line of the scan."""
    fill: str | float | None = None
    """Fill missing points, scars and points that stand out, up to this share of all, as 5% (default: missing points
    only, up to 1%)."""
    crop: str | None = None
    """The part that counts, X0,X1,Y0,Y1, as 1um,9um,0,8um."""
    cutoff: Length | None = None
    """Verdict and solution count only waves longer than this length."""
    tip: Length | None = None
    """Radius of the tip that measured the maps, as 10nm: waves that it is too blunt for count as not measured."""
    smallest: Length | None = None
    """Wavelength to which the spectrum is continued below what was measured (default: two atoms)."""


class InterfaceTable(Table):
    """Moduli, adhesion and range of the contact: of one elastic body on a rigid one, or of two."""

    material: Texts = ()
    """Name of a material with cited values (continuum/sticky/materials.toml); given once the other body is rigid, twice
    for two elastic bodies."""
    modulus: Annotated[tuple[Pressure, ...], WrapValidator(_several)] = ()
    """Young's modulus of a body; twice for two."""
    poisson: Annotated[tuple[str | float, ...], WrapValidator(_several)] = ()
    """Poisson's ratio of a body; twice for two."""
    contact_modulus: Pressure | None = None
    """Contact modulus E* = E/(1 - nu^2), instead of modulus and Poisson's ratio."""
    work: Annotated[str, _quantity("energy_per_area", '"50mJ/m2"')] | None = None
    """Work of adhesion w."""
    range: Length | None = None
    """Range of the attraction (for a law without cut-off, its effective range)."""
    coating: str | None = None
    """Coating of the one elastic body: thickness, Young's modulus and Poisson's ratio, as 50nm:200GPa:0.2.  The solver
    alone decides then, as the theories know one modulus."""
    spacing: Length | None = None
    """Spacing a0 of the atoms, for the necessary condition on crystals."""
    probe: Annotated[str, _quantity("length", '"10um"')] | None = None
    """Radius of a sphere that is pulled off the surface, such as 10um: its pull-off force is given as an interval."""


class PredictionInput(Document):
    """Is my surface sticky: a measured map, or two, and the interface between them."""

    result_schema = "stickiness-prediction"
    result_version = 1

    topography: TopographyTable
    interface: InterfaceTable

    @property
    def keys(self) -> dict[str, Any]:
        """The arguments of :func:`continuum.predict` that are given, but for the maps."""
        tables = (self.topography, self.interface)
        return {name: getattr(table, name) for table in tables for name in table.model_fields_set if name != "maps"}


OPTIONS = {**TopographyTable.model_fields, **InterfaceTable.model_fields}
"""Keys of both tables; all but ``maps`` are arguments and options."""
OPTIONS.pop("maps")
