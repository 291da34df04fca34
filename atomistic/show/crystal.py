"""Sheets and figures of a measured crystal: its constants, and the convergence of its lattice to the continuum."""

from pathlib import Path

import numpy as np

from atomistic.crystal.crystal import LAYER_SPACING
from atomistic.crystal.model import ContactModulus, Model, measured
from atomistic.response.force_constants import relaxation
from atomistic.response.lattice import Discreteness, LatticeResponse
from continuum.inputs.units import GPA_PER_EV_PER_A3
from continuum.show import plot
from continuum.store.sheet import Column, Entry, Sheet, pairs

_RELAXED = 40
"""Layers of the slab whose surface relaxes."""


def crystal_sheet(model: Model) -> Sheet:
    """Lattice constant, elastic constants, E*(100) by direction, relaxation of the surface."""
    reduced = ContactModulus.of(model.elastic_constants)
    length, pressure, unit = "a0", "E*", 1.0
    rows: list[tuple[Entry, ...]] = [("model", model.reference, "", None)]
    found = measured(model)
    if found is not None:
        metal = found.units == "metal"
        length, pressure = ("Å", "GPa") if metal else ("σ", "ε/σ³")
        energy = "eV" if metal else "ε"
        unit = found.contact_modulus * (GPA_PER_EV_PER_A3 if metal else 1)
        others = ", ".join(f"{name} {e - found.crystal.energy:+.4g}" for name, e in found.crystal.others.items())
        rows += [
            ("energy per atom", f"{found.crystal.energy:.8g}", energy, None),
            ("of other structures, less that", others, energy, None),
        ]
    rows += [
        ("lattice constant", f"{model.lattice_constant * model.length:.8g}", length, model.lattice_constant),
        ("nearest neighbours, a0", f"{model.length:.8g}", length, 1.0),
        ("forces reach", f"{model.force_range:.6g}", length, model.force_range / model.length),
        ("layers that they reach", f"{model.coupled_layers}", "", None),
    ]
    moduli = [
        *zip(("C11", "C12", "C44"), model.elastic_constants, strict=True),
        ("E*(100), smallest", reduced.smallest),
        ("E*(100), mean 1/<1/E*>", reduced.mean),
        ("E*(100), largest", reduced.largest),
        ("E*(100) along <100>", reduced.along_100),
        ("E*(100) along <110>", reduced.along_110),
    ]
    rows += [(name, f"{unit * value:.7g}", pressure, value) for name, value in moduli]
    rise = relaxation(model, _RELAXED)
    planes = ", ".join(f"{100 * s:+.3f} %" for s in -np.diff(rise)[:3] / LAYER_SPACING + 0.0)
    rows += [
        ("surface plane rises by", f"{rise[0] * model.length:+.6g}", length, f"{rise[0]:+.6f}"),
        ("planes 1-2, 2-3, 3-4 apart by more", planes, "", None),
    ]
    source = "exact lattice sums" if found is None else "measured in LAMMPS"
    columns = (Column("quantity"), Column("value"), Column("unit"), Column("in a0, E*", "", ".6f"))
    return Sheet.of(f"fcc crystal at zero pressure, {source}", columns, rows)


def lattice_sheet(response: LatticeResponse, found: Discreteness) -> Sheet:
    """Surface stiffness of a lattice against the cubic layer of its constants, by wavelength."""
    constants, slab = response.force_constants, response.slab
    n = slab.shape[0]
    rows: list[tuple[str, Entry]] = [
        ("forces reach", f"{constants.coupled_layers} layers"),
        ("layers not as in the bulk", constants.depth),
    ]
    if constants.checks is not None:
        rows += [(f"violation of {name}", f"{value:.1e}") for name, value in vars(constants.checks).items()]
    lengths = sorted({2.0, 3.0, 4.0, 6.0, 8.0, n / 8, n / 4, n / 2, float(n)})
    rows += [(f"difference at {length:g} a0", f"{100 * found.worst(length):+.3f} %") for length in lengths]
    rows += [
        ("limit of difference/q along <110>", f"{found.along_110:+.4f} a0"),
        ("limit of difference/q along <100>", f"{found.along_100:+.4f} a0"),
    ]
    title = (
        f"Surface stiffness of the lattice, {n} x {n} x {slab.mobile} layers, against the cubic layer of its constants"
    )
    note = "difference: K_lattice/K_continuum - 1 in the worst direction, by wavelength"
    return pairs(title, rows, note)


@plot.styled
def draw_contact_modulus(modulus: ContactModulus, stem: Path, title: str) -> Path:
    """E*(100) over its mean, against the direction of the wavevector; returns the PNG file."""
    figure, axis = plot.new_axes(plot.COLUMN, 2.6)
    relative = modulus.values / modulus.mean
    axis.plot(np.degrees(modulus.angles), relative, color=plot.SERIES[0])
    axis.axhline(1, color="0.6", linewidth=0.8, linestyle="--")
    axis.set_xticks([0, 22.5, 45, 67.5, 90], ["0°\n[100]", "22.5°", "45°\n[110]", "67.5°", "90°\n[010]"])
    axis.set(
        xlim=(0, 90),
        xlabel="direction of the wavevector in the (100) surface",
        ylabel=r"$E^*(\theta)\,/\,E^*$",
        title=f"{title}: {relative.min():.4f} to {relative.max():.4f} of the mean",
    )
    return plot.save_figure(figure, stem)


@plot.styled
def draw_discreteness(found: Discreteness, stem: Path, title: str) -> Path:
    """Stiffness of lattice against continuum over q, all waves and the two limits; returns the PNG file."""
    figure, axis = plot.new_axes(plot.COLUMN, 2.8)
    q = 2 * np.pi / found.wavelength
    # 0 along <110>, 1 along <100>.
    rotation = (1 - np.cos(4 * found.angle)) / 2
    for low, high, colour, label in ((0.0, 0.1, plot.SERIES[0], "[110]"), (0.9, 1.0, plot.SERIES[5], "[100]")):
        near = (rotation >= low) & (rotation <= high)
        axis.plot(q[near], 100 * found.difference[near], ".", color=colour, markersize=2.5, label=f"near {label}")
    between = (rotation > 0.1) & (rotation < 0.9)
    axis.plot(q[between], 100 * found.difference[between], ".", color="0.8", markersize=1, zorder=0, label="between")
    limit = np.array([0, 0.8])
    for slope, colour in ((found.along_110, plot.SERIES[0]), (found.along_100, plot.SERIES[5])):
        axis.plot(limit, 100 * slope * limit, "-", color=colour, linewidth=1)
    axis.axhline(0, color="0.6", linewidth=0.8)
    axis.set(
        xlim=(0, 4.5), xlabel="wavenumber q ($1/a_0$)", ylabel=r"$K_\mathrm{lattice}/K_\mathrm{continuum} - 1$ (%)"
    )
    above = axis.secondary_xaxis("top")
    lengths = (64, 16, 8, 4, 3, 2)
    above.set_xticks([2 * np.pi / length for length in lengths], [str(length) for length in lengths])
    above.set_xlabel("wavelength ($a_0$)")
    axis.set_title(title)
    plot.legend_below(figure, plot.labelled(axis))
    return plot.save_figure(figure, stem)
