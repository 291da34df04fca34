"""Criteria of stickiness: verdict, margin and range of validity of each theory for a rough contact.

A criterion, or a number behind it, is one entry of :data:`CRITERIA`: its key, name and symbol, the formula in
:mod:`continuum.theory`, the source, the range in which it holds.  Criteria of stickiness have a margin, the same for
all: the work of adhesion over the one at which the verdict changes, everything else the same.  As only w/E* counts, the
verdict changes also at a modulus of margin x E*.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from continuum.inputs.arguments import number
from continuum.theory import paper, rough
from continuum.theory.smooth import JKR, tabor_parameter

Answer = Literal["sticky", "not sticky", "undecided"]
ANSWERS: Mapping[bool | None, Answer] = {True: "sticky", False: "not sticky", None: "undecided"}
"""The three answers."""
AREA = 0.01
"""Repulsive area at which a surface is called sticky if its load is negative."""
GW_LIMIT = 3.0
"""h_rms/δ_c beyond which asperity theories call the pull-off force negligible, as the paper quotes them."""
LARGEST_SLOPE = 0.3
"""Steepest surfaces of the paper; its relations assume small slopes."""
JKR_LIMIT, DMT_LIMIT = 5.0, 0.1
"""Maugis' λ above which the contact of a sphere is JKR's, and below which it is DMT's."""


@dataclass(frozen=True)
class RoughContact:
    """The numbers of a contact that theories need, in any consistent units.

    Parameters
    ----------
    rms_height, rms_slope, rms_curvature : spectral moments; curvature sqrt<(laplacian h)²>.
    work_of_adhesion, range : w and Δr; the effective range of Eq. (S-5) for a law without cut-off.
    contact_modulus : E*.
    conformal_energy : elastic energy per area of full contact, from :func:`continuum.theory.rough.conformal_energy`.
    spacing : a0 of the atoms; None where there is none.
    roll_off : λ_L; None where it is not known.
    kappa_rep : of Eq. (1).
    coated : whether the contact modulus is that of a coating only, which no theory here includes.
    """

    rms_height: float
    rms_slope: float
    rms_curvature: float
    work_of_adhesion: float
    range: float
    contact_modulus: float = 1.0
    conformal_energy: float | None = None
    spacing: float | None = None
    roll_off: float | None = None
    kappa_rep: float = paper.KAPPA_REP
    coated: bool = False

    def __post_init__(self) -> None:
        optional = ("conformal_energy", "spacing", "roll_off")
        for name, value in tuple(vars(self).items()):
            if name != "coated" and (value is not None or name not in optional):
                object.__setattr__(self, name, number(name, value, above=0))

    @property
    def adhesion_length(self) -> float:
        """l_a = w/E*."""
        return self.work_of_adhesion / self.contact_modulus

    @property
    def expected(self) -> paper.ExpectedContact:
        """Predictions of the paper for the contact."""
        return paper.ExpectedContact(self.rms_slope, self.rms_curvature, self.range, self.adhesion_length)

    @property
    def diameter(self) -> float:
        """d_rep = 4h'/h''."""
        return self.expected.diameter

    @property
    def radius(self) -> float:
        """R = 2/h''."""
        return paper.asperity_radius(self.rms_curvature)

    @property
    def maugis(self) -> float:
        """Maugis' λ of one asperity."""
        return paper.maugis_parameter(self.radius, self.adhesion_length, self.range)

    @property
    def height_over_separation(self) -> float:
        """h_rms/δ_c of asperity theories, δ_c that at which a JKR sphere of radius R separates."""
        return self.rms_height / JKR(self.radius, self.work_of_adhesion, self.contact_modulus).separation_distance


@dataclass(frozen=True)
class Estimate:
    """A number of a theory, for one contact."""

    name: str
    """Name of the quantity or criterion."""
    symbol: str
    value: float
    unit: str
    """Unit: "" for a pure number, else a dimension such as "length" or "pressure"."""
    source: str
    why: tuple[str, ...] = ()
    """Reasons why the criterion is out of its range here; empty if it is in range."""
    margin: float | None = None
    """w over the w at which the verdict changes; None if the theory gives no verdict."""
    key: str = ""
    """Key of its entry in :data:`CRITERIA`."""

    @property
    def valid(self) -> bool:
        return not self.why

    @property
    def sticky(self) -> bool | None:
        return None if self.margin is None else self.margin > 1

    def threshold_work(self, contact: RoughContact) -> float | None:
        """Work of adhesion at which a verdict changes: above it the surface is sticky; None without a verdict."""
        return None if self.margin is None else contact.work_of_adhesion / self.margin


@dataclass(frozen=True)
class Limit:
    """One limit of the range of a theory: a quantity that lies above ``least`` and is at most ``most``."""

    quantity: Callable[[RoughContact], float]
    text: str
    """Message for a contact beyond the limit, with a place for the value."""
    least: float = -float("inf")
    most: float = float("inf")

    def why(self, contact: RoughContact) -> str:
        """Reasons why the contact is out of the range, in words; empty if it is not."""
        value = self.quantity(contact)
        return "" if self.least <= value <= self.most else self.text.format(value)


@dataclass(frozen=True)
class Criterion:
    """A criterion of stickiness, or a number of a theory: called with a contact it gives an :class:`Estimate`."""

    key: str
    """Key of the criterion, also in the record."""
    name: str
    symbol: str
    source: str
    formula: Callable[[RoughContact], float]
    limits: tuple[Limit, ...] = ()
    """Range of validity."""
    margin: Callable[[RoughContact, float], float] | None = None
    """Work of adhesion over that at the threshold, from contact and value; None for a number without a verdict."""
    unit: str = ""
    needs: str = ""
    """Name of an optional quantity of the contact that the criterion needs."""

    def __call__(self, contact: RoughContact) -> Estimate:
        """The estimate for a contact; raises ValueError if the contact lacks a quantity."""
        if not self.possible(contact):
            raise ValueError(f"{self.name} needs the {self.needs} of the contact")
        value = self.formula(contact)
        why = tuple(filter(None, (limit.why(contact) for limit in self.limits)))
        why += ("the solid is coated, and the theory has one modulus",) if contact.coated else ()
        margin = None if self.margin is None else self.margin(contact, value)
        return Estimate(self.name, self.symbol, value, self.unit, self.source, why, margin, self.key)

    def possible(self, contact: RoughContact) -> bool:
        return not self.needs or getattr(contact, self.needs) is not None


_STEEP = Limit(
    lambda c: c.rms_slope, f"h' = {{:.3g}} is above {LARGEST_SLOPE}, the steepest surfaces tested", most=LARGEST_SLOPE
)
_RIM = (
    _STEEP,
    Limit(lambda c: 1 / c.expected.area_ratio,
          "A_att/A_rep = {:.3g} is above 1: the attracted area is not a thin rim", most=1),
    Limit(lambda c: c.expected.width / c.diameter,
          "d_att/d_rep = {:.3g} is above 1/2: the gap profile ends inside the next contact", most=0.5),
    Limit(lambda c: c.maugis, f"Maugis' parameter {{:.3g}} is above {JKR_LIMIT:g}: adhesion changes the gap",
          most=JKR_LIMIT),
)  # fmt: skip
_JKR = (_STEEP, Limit(lambda c: c.maugis, f"Maugis' parameter {{:.3g}} is below {JKR_LIMIT:g}: the asperities "
                      "are not in the JKR limit", least=JKR_LIMIT))  # fmt: skip
_DMT = (_STEEP, Limit(lambda c: c.maugis, f"Maugis' parameter {{:.3g}} is above {DMT_LIMIT}: the asperities "
                      "are not in the DMT limit", most=DMT_LIMIT))  # fmt: skip
_ENERGY = (_STEEP, Limit(lambda c: c.range - c.rms_height, "the range of adhesion exceeds h_rms; the theory takes it "
                         "as zero", most=0))  # fmt: skip
_THRESHOLD = (
    _STEEP,
    Limit(lambda c: c.range / c.rms_height, "the range of adhesion, {:.3g} h_rms, is not between 0.3 and 2.5 h_rms, "
          "where the law was tested", 0.3, 2.5),
)  # fmt: skip
_BEARING = (_STEEP, Limit(lambda c: c.range - c.rms_height, "the range of adhesion exceeds h_rms: the repulsion is "
                          "taken at large separations", most=0))  # fmt: skip


def _asperity_margin(contact: RoughContact, value: float) -> float:
    """Margin of h_rms/δ_c < 3, as δ_c grows as w^(2/3)."""
    return float((GW_LIMIT / value) ** 1.5)


def _full_contact(contact: RoughContact) -> float:
    return (contact.conformal_energy or 0.0) / contact.work_of_adhesion


def _asperity_limit(contact: RoughContact) -> float:
    return rough.asperity_limit(contact.work_of_adhesion, contact.rms_height)


_CRITERIA = (
    Criterion(
        "pastewka-robbins", "Pastewka-Robbins", "κ_att/κ_rep", "paper, Eq. (6)",
        lambda c: paper.onset(c.rms_slope, paper.height_change(c.rms_slope, c.rms_curvature), c.adhesion_length,
                              c.range, c.kappa_rep),
        _RIM, margin=lambda c, value: 1 / value,
    ),
    Criterion(
        "fuller-tabor", "Fuller-Tabor", "h_rms/δ_c", "Fuller and Tabor 1975; asperities do not interact",
        lambda c: c.height_over_separation, _JKR, margin=_asperity_margin,
    ),
    Criterion(
        "dmt-asperities", "Maugis (DMT asperities)", "h_rms/δ_c", "Maugis 1996; asperities do not interact",
        lambda c: c.height_over_separation, _DMT, margin=_asperity_margin,
    ),
    Criterion(
        "persson-tosatti", "Persson-Tosatti", "U_full/w", "Persson and Tosatti 2001",
        _full_contact, _ENERGY, margin=lambda c, value: 1 / value, needs="conformal_energy",
    ),
    # High pull-off stress if w exceeds half the elastic energy of full contact, from simulated half-spaces and sheets.
    Criterion(
        "half-conformal-energy", "half conformal energy", "U_full/w", "doi:10.3389/fmech.2022.965584 (Müser's group)",
        _full_contact, _ENERGY, margin=lambda c, value: 1 / (0.5 * value), needs="conformal_energy",
    ),
    # The load at 1 % area changes its sign at w = U F: docs/law.md.  F is that of the paper's law, as stated before.
    Criterion(
        "threshold-energy", "energy of the threshold", "U_full F/w",
        "w/U: Ciavarella and Papangelo 2018; F: the law of the spectrum in the manual, six surfaces, H of 0.2 to 0.9",
        lambda c: _full_contact(c) * rough.threshold_share(c.range / c.rms_height), _THRESHOLD,
        margin=lambda c, value: 1 / value, needs="conformal_energy",
    ),
    # h_rms² below about 0.63 l_a λ_L, whatever the short waves.
    Criterion(
        "bearing-area", "bearing area (BAM)", "h_rms²/(l_a λ_L)", "Ciavarella 2018 (BAM), derived anew with γ = 1/2",
        lambda c: c.rms_height**2 / (c.adhesion_length * (c.roll_off or 0.0)), _BEARING,
        margin=lambda c, value: rough.bearing_area_limit(c.rms_height / c.range) / value, needs="roll_off",
    ),
    # l_a above 0.5 h' a0, for atomic surfaces: Eq. (6) at the least change of height, so within its range.
    Criterion(
        "necessary-adhesion", "necessary adhesion", "2 l_a/(h' a0)",
        "paper, below Eq. (6): necessary by that theory, not sufficient",
        lambda c: c.adhesion_length / paper.necessary_adhesion_length(c.rms_slope, c.spacing or 0.0), _RIM,
        margin=lambda c, value: value, needs="spacing",
    ),
    # (N/A_rep)/(h' E*): finite at the onset, negative where sticky.
    Criterion(
        "inverse-kappa", "inverse kappa", "1/κ", "paper, Eqs. (3), (4)",
        lambda c: 1 / c.kappa_rep - 1 / c.expected.kappa_att, _RIM,
    ),
    Criterion("area-ratio", "area ratio", "A_rep/A_att", "paper, Eq. (4)", lambda c: c.expected.area_ratio, _RIM),
    Criterion(
        "contact-diameter", "contact diameter", "d_rep", "paper, above Eq. (6); measured widths within a factor of two",
        lambda c: c.diameter, (_STEEP,), unit="length",
    ),
    Criterion("attraction-width", "attraction width", "d_att", "paper, Eq. (S-2)",
              lambda c: c.expected.width, _RIM, unit="length"),
    # Mean over the repulsive area, h' E*/κ_rep.
    Criterion(
        "repulsive-pressure", "repulsive pressure", "p_rep", "paper, Eq. (1); A_rep much smaller than A0",
        lambda c: paper.repulsive_pressure(c.rms_slope, c.kappa_rep, c.contact_modulus), (_STEEP,), unit="pressure",
    ),
    # Mean tension over the attracted area.
    Criterion(
        "adhesive-pressure", "adhesive pressure", "w/Δr", "paper, after Eq. (1)",
        lambda c: paper.adhesive_pressure(c.work_of_adhesion, c.range), unit="pressure",
    ),
    # DMT below 0.1, JKR above 5.
    Criterion("maugis-parameter", "Maugis parameter", "λ_Maugis", "paper, Suppl. S-I", lambda c: c.maugis),
    # With Δr for the equilibrium distance.
    Criterion(
        "asperity-tabor", "Tabor parameter", "μ", "Tabor 1977",
        lambda c: tabor_parameter(c.radius, c.work_of_adhesion, c.range, c.contact_modulus),
    ),
    # Measures whether the range matters; not a criterion of stickiness.
    Criterion(
        "generalised-tabor", "generalised Tabor number", "μ_T", "Müser 2016, 1/R the rms of ∂²h/∂x²",
        lambda c: rough.generalised_tabor(c.rms_curvature, c.adhesion_length, c.range),
    ),
    # Δr over the gap beside a patch.
    Criterion(
        "range-over-gap", "range over gap", "Δr/g0", "paper, Eq. (S-1) one patch outside the edge",
        lambda c: c.range / paper.gap_scale(c.rms_slope, c.rms_curvature),
    ),
    # Without tension the tail of the theory is negative.
    Criterion(
        "pull-off", "pull-off", "N/A0", "Fuller and Tabor 1975, 0.05 summits per R h_rms",
        lambda c: max(_asperity_limit(c) * rough.fuller_tabor(c.height_over_separation), 0.0), _JKR, unit="pressure",
    ),
    # 2π w R for each asperity instead of (3/2)π w R.
    Criterion(
        "dmt-pull-off", "pull-off (DMT asperities)", "N/A0", "Maugis 1996, 0.05 summits per R h_rms",
        lambda c: max(4 / 3 * _asperity_limit(c) * rough.dmt_asperities(c.height_over_separation), 0.0), _DMT,
        unit="pressure",
    ),
)  # fmt: skip

CRITERIA = {criterion.key: criterion for criterion in _CRITERIA}
"""Criteria of stickiness, the paper's first, and then the numbers behind them; by key."""


def every_estimate(contact: RoughContact) -> tuple[Estimate, ...]:
    """All estimates that the inputs allow: verdicts, the paper's first, and the numbers behind them."""
    found = [criterion(contact) for criterion in CRITERIA.values() if criterion.possible(contact)]
    return tuple(sorted(found, key=lambda estimate: estimate.margin is None))
