"""The paper's worked examples: its number, ours, and the reason for differences.

``continuum examples`` prints them; ``docs/measured/examples.md`` holds what it printed.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from continuum.maps.verdict.materials import Body, interface, materials
from continuum.model.substrates.crystal import CubicConstants, directional_contact_modulus
from continuum.model.walls import InversePowers, LennardJonesSpline
from continuum.theory import paper, rough

_SHELLS = 24
"""Half width of the cube of lattice vectors summed over, in lattice constants; the slowest sum, w, is 0.4 % short."""


@dataclass(frozen=True)
class Example:
    """One number of the paper."""

    about: str
    quantity: str
    paper: str
    """Value as printed."""
    value: float
    unit: str
    why: str
    """Origin of our value, and the reason if it differs from the paper's."""


class LennardJonesCrystal(NamedTuple):
    """The fcc crystal of a 12-6 potential at rest, not truncated, in ε and σ."""

    spacing: float
    """a0, distance of nearest neighbours."""
    constants: CubicConstants
    work_of_adhesion: float
    """Work of adhesion of two (100) surfaces, as cut."""


def lennard_jones_crystal() -> LennardJonesCrystal:
    """Lattice sums: elastic constants of central forces at zero pressure, and the energy across a (100) plane.

    With φ the pair energy and n the density, w = -n Σ z φ(r) over lattice vectors with z > 0: n z bonds of each kind
    cross a plane per area.
    """
    i = np.arange(-_SHELLS, _SHELLS + 1)
    vectors = np.stack(np.meshgrid(i, i, i, indexing="ij"), axis=-1).reshape(-1, 3) / np.sqrt(2)
    even = np.rint(vectors.sum(axis=1) * np.sqrt(2)).astype(int) % 2 == 0
    vectors = vectors[even & (np.abs(vectors).sum(axis=1) > 0)]
    r = np.linalg.norm(vectors, axis=1)
    near = r <= _SHELLS / np.sqrt(2)  # a sphere: the sums treat all directions alike
    vectors, r = vectors[near], r[near]

    spacing = float((2 * np.sum(r**-12.0) / np.sum(r**-6.0)) ** (1 / 6))
    vectors, r = spacing * vectors, spacing * r
    density = np.sqrt(2) / spacing**3
    energy = 4 * (r**-12.0 - r**-6.0)
    # φ'' - φ'/r, over r².
    bending = (4 * (168 * r**-14.0 - 48 * r**-8.0)) / r**2
    x2, y2 = vectors[:, 0] ** 2, vectors[:, 1] ** 2
    c11, c12 = (float(density / 2 * np.sum(bending * x2 * z2)) for z2 in (x2, y2))
    z = vectors[:, 2]
    work = -float(density * np.sum((z * energy)[z > 0]))
    return LennardJonesCrystal(spacing, CubicConstants(c11, c12, c12), work)


def _stick_slope(adhesion_length: float, spacing: float) -> float:
    """Slope at the limit of the necessary condition for atomic surfaces."""
    return adhesion_length / paper.necessary_adhesion_length(1.0, spacing)


def worked_examples() -> tuple[Example, ...]:
    """Every number that the paper gives for a material or a law, in its order."""
    return (*_crystals(), *_elastomers(), *_laws())


def _crystals() -> list[Example]:
    bond, van_der_waals = 0.154e-9, 0.05
    diamond = 10 / 1e12 / bond
    crystal = lennard_jones_crystal()
    moduli = directional_contact_modulus(crystal.constants, np.array([0.0, np.pi / 4]))
    lj = [crystal.work_of_adhesion / float(modulus) / crystal.spacing for modulus in moduli]
    found = [
        Example("diamond", "l_a/a0", "≈ 0.06", diamond, "", "w = 10 J/m², E* = 1 TPa, a0 = 0.154 nm"),
        Example(
            "Lennard-Jones crystal", "l_a/a0", "≈ 0.05", float(np.mean(lj)), "",
            f"(100) faces as cut, untruncated; mean of E* along <100> and <110> in the face ({lj[0]:.3f}, {lj[1]:.3f})",
        ),
        Example(
            "diamond on diamond", "h' that sticks, at most", "of order 0.1", _stick_slope(diamond, 1.0), "",
            "necessary condition l_a > 0.5 h' a0",
        ),
        Example(
            "Lennard-Jones crystals", "h' that sticks, at most", "of order 0.1", _stick_slope(float(np.mean(lj)), 1.0),
            "", "the same",
        ),
        Example(
            "diamond, van der Waals", "h' that sticks, at most", "≲ 1e-3", _stick_slope(van_der_waals / 1e12, bond), "",
            "w = 50 mJ/m² in place of 10 J/m²: 200 times less, 'two to three orders of magnitude'",
        ),
    ]  # fmt: skip
    for name, about in (("mica", "mica on mica"), ("silicon", "bonded silicon wafers")):
        material = materials()[name]
        contact = interface([Body(material=material), Body(material=material)])
        slope = _stick_slope(contact.adhesion_length, material.spacing or np.nan)
        found.append(
            Example(
                about, "h' that sticks, at most", "≲ 1e-3", slope, "",
                f"w = {1e3 * contact.work_of_adhesion:.0f} mJ/m² and E* = {1e-9 * contact.contact_modulus:.0f} GPa of "
                "the two, softer than 1 TPa; necessary, not sufficient",
            )
        )  # fmt: skip
    return found


def _elastomers() -> list[Example]:
    work, reach, slope = 0.05, 0.5e-9, 1.0

    def change(diameter: float) -> float:
        return paper.height_change(slope, 4 * slope / diameter)

    def maugis(diameter: float) -> float:
        return paper.maugis_parameter(paper.asperity_radius(4 * 0.1 / diameter), 5e-4, 1.0)

    modulus = paper.critical_modulus(slope, change(10e-9), work, reach)
    widest = scipy.optimize.brentq(
        lambda d: paper.onset(slope, change(d), work / 0.1e6, reach) - 1, 1e-9, 1e-1, xtol=1e-12
    )
    return [
        Example(
            "rubber", "E* that sticks, at most", "≲ 10 MPa", modulus / 1e6, "MPa",
            "w = 50 mJ/m², h' = 1, Δr = 0.5 nm, d_rep = 10 nm in Eq. (6) give seven times the printed modulus; "
            "rubber sticks by either",
        ),
        Example("paper (the sheet)", "E* over the one that sticks", "> 1 GPa, does not stick", 1e9 / modulus, "",
                "the same surface: not sticky, though by less than printed"),
        Example(
            "tape", "d_rep that sticks, at most", "≲ 100 µm", widest * 1e6, "µm",
            "E* = 0.1 MPa (Dahlquist), w, h' and Δr as for rubber: the paper rounds down",
        ),
        Example(
            "atomic solids, Suppl. S-I", "d_rep where λ_Maugis = 1", "close to a millimetre",
            scipy.optimize.brentq(lambda d: maugis(d) - 1, 1, 1e9) * 0.3e-6,
            "mm",
            "l_a = 5e-4 a0, h' = 0.1, Δr = a0 = 0.3 nm; λ grows as d_rep^(1/3), 1.8 at 1 mm: 'exceeds unity'",
        ),
    ]  # fmt: skip


def _laws() -> list[Example]:
    ranges = [InversePowers(powers, 1.0).effective_range for powers in ((9, 3), (12, 6))]
    spline = LennardJonesSpline(1.0).effective_range
    return [
        Example("9-3 law", "Δr/a0", "1.15", ranges[0], "", "Eq. (S-5)"),
        Example("12-6 law", "Δr/a0", "0.62", ranges[1], "", "Eq. (S-5), pressure z^-13 - z^-7"),
        Example("the paper's law", "effective over actual range", "within 6 %", spline, "", "Eq. (S-5)"),
        Example("Eq. (6)", "right side, π (3/16)^(2/3)", "≈ 1", 1 / paper.onset(2, 1, 1, 1, 2), "", "exact"),
        Example("Greenwood-Williamson", "κ_rep", "2.6", rough.KAPPA_BGT, "", "sqrt(2π): misprinted"),
        Example("Persson", "κ_rep", "1.6", rough.KAPPA_PERSSON, "", "sqrt(8/π)"),
        Example("asperity theories, Suppl. S-III", "N P_c h_rms/(w A0)", "≈ 1/4", rough.asperity_limit(1, 1), "",
                "0.05 x 3π/2"),
        Example("perimeter, Suppl. S-II", "β", "1.1222", paper.PERIMETER_FACTOR, "",
                f"1/<cos θ>, as counted discs; the paper averages 1/cos θ: {paper.PERIMETER_FACTOR_PAPER:.4f}"),
    ]  # fmt: skip


_HEAD = """# The paper's worked examples

The numbers that L. Pastewka and M. O. Robbins, PNAS 111, 3298 (2014), give for materials and laws, and those of
`continuum.theory.paper`, `continuum.theory.rough` and `continuum.model.walls` for the same input.
`continuum examples` prints this page.

| system | quantity | the paper | here | how, and why it differs |
|---|---|---|---|---|
"""


def examples() -> str:
    """The paper's worked examples and our numbers, as Markdown."""
    rows = [
        f"| {e.about} | {e.quantity} | {e.paper} | {e.value:.3g}{' ' + e.unit if e.unit else ''} | {e.why} |"
        for e in worked_examples()
    ]
    return _HEAD + "\n".join(rows) + "\n"
