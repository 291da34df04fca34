"""The numbers of one contact by which the paper compares all: κ, pressures, perimeter and mean diameter."""

from __future__ import annotations

from dataclasses import dataclass

from continuum.measure.contact import Contact
from continuum.measure.outline import Mask, outline, ratio
from continuum.model.grid import Grid

__all__ = ["Measurement", "characterise"]


@dataclass(frozen=True)
class Measurement:
    """One contact in numbers.  Areas are fractions of A0, loads are per A0, in E*, as in :class:`Contact`.

    A ratio whose two sides are zero is not a number: without contact there is no κ and no diameter.
    """

    area_rep: float
    """A_rep/A0."""
    area_att: float
    """A_att/A0."""
    load: float
    """N/(E* A0)."""
    load_rep: float
    """N_rep/(E* A0), the pushing points."""
    load_att: float
    """N_att/(E* A0), the pulling points, as a positive number."""
    pressure_rep: float
    """p_rep = N_rep/A_rep, in E*."""
    pressure_att: float
    """Mean attractive pressure N_att/A_att, in E*, positive; w/Δr in the paper's theory."""
    kappa: float
    """κ = h'rms E* A_rep/N, Eq. (eqkappa): negative where the load is; infinite where it vanishes."""
    kappa_rep: float
    """κ_rep = h'rms E* A_rep/N_rep."""
    kappa_att: float
    """κ_att = h'rms E* A_rep/N_att, so that 1/κ = 1/κ_rep - 1/κ_att; infinite without attraction."""
    perimeter_cells: int
    """N_P."""
    perimeter: float
    """P, in a0, with the paper's correction 1.1222."""
    perimeter_exact: float
    """P, in a0, with the correction 1.1107."""
    diameter: float
    """d_rep = π A_rep/P, in a0, with the paper's correction."""
    diameter_exact: float
    """d_rep with the correction 1.1107."""
    chord: float
    """Mean chord of both directions, in a0."""
    chord_x: float
    """Mean chord along x, in a0."""
    chord_y: float
    """Mean chord along y, in a0."""


def characterise(grid: Grid, contact: Contact, repulsive: Mask, rms_slope: float) -> Measurement:
    """What the paper measures on one state.

    Parameters
    ----------
    contact : its areas and loads, from :func:`continuum.measure.contact.measure`.
    repulsive : the cells of A_rep: ``contact_map(wall, gap) == REPULSIVE``, or the map stored with a run.
    rms_slope : h'rms of the undeformed surface; its spectral moment, not the target of its synthesis.

    Raises
    ------
    ValueError
        If the map does not fit the grid, or is not that of these areas.
    """
    rim = outline(grid, repulsive)
    if abs(rim.cells - contact.area_rep * grid.size) > 0.5:
        msg = f"the map has {rim.cells} cells, but A_rep/A0 = {contact.area_rep} is {contact.area_rep * grid.size:g}"
        raise ValueError(msg)
    stiff_area = rms_slope * contact.area_rep
    chord_x, chord_y = rim.chords
    return Measurement(
        area_rep=contact.area_rep,
        area_att=contact.area_att,
        load=contact.load,
        load_rep=contact.load_rep,
        load_att=contact.load_att,
        pressure_rep=ratio(contact.load_rep, contact.area_rep),
        pressure_att=ratio(contact.load_att, contact.area_att),
        kappa=ratio(stiff_area, contact.load),
        kappa_rep=ratio(stiff_area, contact.load_rep),
        kappa_att=ratio(stiff_area, contact.load_att),
        perimeter_cells=rim.perimeter_cells,
        perimeter=rim.perimeter("paper"),
        perimeter_exact=rim.perimeter("exact"),
        diameter=rim.diameter("paper"),
        diameter_exact=rim.diameter("exact"),
        chord=rim.chord,
        chord_x=chord_x,
        chord_y=chord_y,
    )
