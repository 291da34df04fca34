"""First yield of copper (111) under a rigid sphere, beside a published order of magnitude.

``python -m docs.studies.first_yield --into docs/measured`` runs ``inputs/lammps/yield.toml``, and the same deeper and
back (four minutes on one core); it writes what was found, the steps, and the figure of the deeper run.  The tables of
docs/studies/first_yield.md are made of these files.

Expected, before the first run: crystals of nickel and molybdenum were found to slip first at a shear stress below the
indenter of about G/7 (L. Wang et al., Scripta Mater. 65, 179 (2011)), by the relation of Hertz, where the largest shear
stress is 0.465 of the mean contact pressure (nu = 0.3).  With G of polycrystalline copper, the mean of the bounds of
Voigt and Reuss of this potential, the mean contact pressure at first yield is then 15 GPa.  The order of magnitude
holds if the pressure found lies within a factor of three, 5 to 44 GPa: the sphere has 12 a0, its contact some dozens of
atoms, and the crystal is at rest.  A pressure outside, or no yield down to the last step, refutes it.
"""

from __future__ import annotations

import argparse
import re
import tempfile
from pathlib import Path

from pandas import DataFrame, concat

import atomistic as a
from atomistic.show.decks import draw_slip
from continuum.show import plot

INPUT = Path("inputs/lammps/yield.toml")
DEEPER = "separations = [1.0, 0.8, 0.6, 0.4, 0.3, 0.2, 0.1, 0.0, -0.1, -0.2, -0.3, -0.4, -0.5]\nretract = true"
"""Steps of the other run, which was the first."""
FILE, STEPS = "first-yield.csv", "first-yield-steps.csv"
PUBLISHED, HERTZ = 1 / 7, 0.465
"""Shear stress of first slip over G, and over the mean contact pressure."""
FACTOR = 3.0
"""Of the same order of magnitude."""
QUOTED = (
    "G", "expected", "least", "most", "separation", "load", "pressure", "factor", "shear", "displaced", "depth",
    "recovered",
)  # fmt: skip
"""Numbers that the page quotes."""


def shear_modulus(c11: float, c12: float, c44: float) -> float:
    """Of a polycrystal of cubic crystals: the mean of the bounds of Voigt and Reuss, in the unit of the constants."""
    tetragonal = c11 - c12
    return ((tetragonal + 3 * c44) / 5 + 5 * tetragonal * c44 / (4 * c44 + 3 * tetragonal)) / 2


def found(run: a.DeckRun, modulus: float) -> tuple[DataFrame, DataFrame]:
    """What a run says of its first yield and imprint, and its steps; pressures, as the modulus, in GPa."""
    real, first, stays = run.description.real_units, run.first_yield, run.imprint
    assert real is not None
    assert first is not None
    assert stays is not None
    giga = real.si("pressure") / 1e9
    rows = [("G", "GPa", modulus, 0.0), ("separation", "a0", *first.separation)]
    rows += [(name, "GPa", *(giga * x for x in getattr(first, name))) for name in ("load", "pressure")]
    rows += [
        (name, unit, getattr(stays, name), 0.0)
        for name, unit in (("displaced", "1"), ("depth", "a0"), ("recovered", "1"))
    ]
    atoms = run.last.slab.surface_atoms
    steps = [
        (i, step.separation, giga * step.load, giga * step.load_rep / step.area_rep if step.area_rep else 0.0,
         round(atoms * step.area_rep), step.slipped, step.faulted)
        for i, step in enumerate(run.steps, 1)
    ]  # fmt: skip
    heads = ["step", "separation", "load", "pressure", "in_contact", "slipped", "hcp"]
    return DataFrame(rows, columns=["quantity", "unit", "value", "half"]), DataFrame(steps, columns=heads)


def table(steps: DataFrame, run: str) -> str:
    """The steps of a run as a table."""
    lines = [
        "| step | separation (a0) | N/A0 (GPa) | N_rep/A_rep (GPa) | atoms in contact | slipped | hcp |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {step.step} | {step.separation:g} | {step.load:.2f} | {step.pressure:.1f} | {step.in_contact} | "
        f"{step.slipped} | {step.hcp} |"
        for step in steps[steps.run == run].itertuples()
    ]
    return "\n".join(lines)


def quoted(rows: DataFrame, run: str, name: str) -> str:
    """A number that the page quotes."""
    by_name = rows[rows.run == run].set_index("quantity")
    value, half = by_name["value"], by_name["half"]
    expected = PUBLISHED * value["G"] / HERTZ
    return {
        "G": f"{value['G']:.0f}", "expected": f"{expected:.0f}",
        "least": f"{expected / FACTOR:.0f}", "most": f"{expected * FACTOR:.0f}",
        "separation": f"{value['separation']:.3f} ± {half['separation']:.3f}",
        "load": f"{value['load']:.1f} ± {half['load']:.1f}",
        "pressure": f"{value['pressure']:.1f} ± {half['pressure']:.1f}",
        "factor": f"{value['pressure'] / expected:.1f}",
        "shear": f"1/{value['G'] / (HERTZ * value['pressure']):.1f}",
        "displaced": f"{value['displaced']:.0f}", "depth": f"{value['depth']:.2f}",
        "recovered": f"{100 * value['recovered']:.0f} %",
    }[name]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--into", type=Path, required=True, help="folder for tables and figure")
    parser.add_argument("--decks", type=Path, help="folder of the decks, which are kept; a temporary one if left out")
    given = parser.parse_args()
    copper = a.elastic(a.EmbeddedAtom.read(a.find_potential("Cu_mishin1.eam.alloy"))).model
    assert copper.real_units is not None
    modulus = copper.real_units.si("pressure") / 1e9 * shear_modulus(*copper.elastic_constants)
    text = INPUT.read_text(encoding="utf-8")
    tables: list[tuple[DataFrame, DataFrame]] = []
    with tempfile.TemporaryDirectory() as folder:
        decks = given.decks or Path(folder)
        for name, written in (("yield", text), ("deeper", re.sub(r"^separations = .*$", DEEPER, text, flags=re.M))):
            path = Path(folder) / f"{name}.toml"
            path.write_text(written, encoding="utf-8")
            run = a.run_deck(a.deck(path).write(decks / name))
            tables.append(tuple(rows.assign(run=name) for rows in found(run, modulus)))
        plot.save_figure(draw_slip(run), given.into / "first-yield", own=True, usual=("png",))
    for rows, name in zip(zip(*tables, strict=True), (FILE, STEPS), strict=True):
        concat(rows).to_csv(given.into / name, index=False, float_format="%.6g")


if __name__ == "__main__":
    main()
