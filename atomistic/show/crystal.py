"""Sheets of a measured crystal: its constants, and the convergence of its lattice to the continuum."""

import numpy as np

from atomistic.crystal.crystal import LAYER_SPACING
from atomistic.crystal.model import ContactModulus, Model, measured
from atomistic.response.discreteness import Discreteness
from atomistic.response.force_constants import relaxation
from atomistic.response.lattice import LatticeResponse
from continuum.sheet import Column, Entry, Sheet, pairs
from continuum.units import GPA_PER_EV_PER_A3

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
