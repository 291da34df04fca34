"""Is it sticky?  What each theory says of one rough contact, how much is missing, and whether it may be asked.

Every estimate comes with its source, the inputs that it used, and the reasons, if any, why the contact lies outside its
range.  Criteria of stickiness have a margin, the same for all: the work of adhesion over the one at which the verdict
turns, everything else the same.  As only w/E* counts, the verdict turns also at a modulus of margin x E*.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from continuum.arguments import number
from continuum.theory import paper, rough
from continuum.theory.smooth import JKR, tabor_parameter

AREA = 0.01
"""Repulsive area at which a surface is called sticky if its load is negative."""
GW_LIMIT = 3.0
"""h_rms/δ_c beyond which asperity theories call the pull-off force negligible, as the paper quotes them."""
LARGEST_SLOPE = 0.3
"""Steepest surfaces of the paper; its relations assume small slopes."""
JKR_LIMIT, DMT_LIMIT = 5.0, 0.1
"""Maugis' λ above and below which the contact of a sphere is JKR's and DMT's."""


@dataclass(frozen=True)
class Estimate:
    """A number of a theory, for one contact."""

    name: str
    """Of the quantity or criterion."""
    symbol: str
    value: float
    unit: str
    """"" for a pure number, else in words of the input: "length", "pressure"."""
    source: str
    inputs: Mapping[str, float] = field(repr=False)
    why: tuple[str, ...] = ()
    """Why it is out of range here; empty where it is not."""
    margin: float | None = None
    """w over the w at which the verdict turns; None where the theory gives no verdict."""

    @property
    def valid(self) -> bool:
        """Whether the contact lies in the range of the theory."""
        return not self.why

    @property
    def sticky(self) -> bool | None:
        """The verdict, if there is one."""
        return None if self.margin is None else self.margin > 1


@dataclass(frozen=True)
class RoughContact:
    """What the theories ask about a contact.  Any consistent units.

    Parameters
    ----------
    rms_height, rms_slope, rms_curvature : spectral moments; curvature sqrt<(laplacian h)²>.
    work_of_adhesion, range : w and Δr; the effective range of Eq. (S-5) for a law without cut-off.
    contact_modulus : E*.
    conformal_energy : elastic energy per area of full contact, from :func:`continuum.theory.rough.conformal_energy`.
    spacing : a0 of the atoms; None where there is none.
    roll_off : λ_L; None where it is not known.
    kappa_rep : of Eq. (1).
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

    def __post_init__(self) -> None:
        optional = ("conformal_energy", "spacing", "roll_off")
        for name, value in tuple(vars(self).items()):
            if value is not None or name not in optional:
                object.__setattr__(self, name, number(name, value, above=0))

    @property
    def adhesion_length(self) -> float:
        """l_a = w/E*."""
        return self.work_of_adhesion / self.contact_modulus

    @property
    def diameter(self) -> float:
        """d_rep = 4h'/h''."""
        return paper.contact_diameter(self.rms_slope, self.rms_curvature)

    @property
    def radius(self) -> float:
        """R = 2/h''."""
        return paper.asperity_radius(self.rms_curvature)

    @property
    def area_ratio(self) -> float:
        """A_rep/A_att, Eq. (4)."""
        return paper.area_ratio(self.rms_slope, self.diameter, self.range)

    @property
    def maugis_parameter(self) -> float:
        """λ of one asperity."""
        return paper.maugis_parameter(self.radius, self.adhesion_length, self.range)

    def inputs(self, *names: str) -> dict[str, float]:
        """Inputs of an estimate, by name."""
        return {name: float(getattr(self, name)) for name in names}


def _steep(contact: RoughContact) -> list[str]:
    if contact.rms_slope <= LARGEST_SLOPE:
        return []
    return [f"h' = {contact.rms_slope:.3g} is above {LARGEST_SLOPE}, the steepest surfaces tested"]


def _rim(contact: RoughContact) -> list[str]:
    """Reasons why the paper's theory of a thin attracted rim is out of range."""
    why = _steep(contact)
    if contact.area_ratio < 1:
        why.append(f"A_att/A_rep = {1 / contact.area_ratio:.3g} is above 1: the attracted area is no thin rim")
    width = paper.attraction_width(contact.rms_slope, contact.diameter, contact.range) / contact.diameter
    if width > 0.5:
        why.append(f"d_att/d_rep = {width:.3g} is above 1/2: the gap profile ends inside the next contact")
    if contact.maugis_parameter > JKR_LIMIT:
        why.append(f"Maugis' parameter {contact.maugis_parameter:.3g} is above {JKR_LIMIT:g}: adhesion changes the gap")
    return why


_MOMENTS = ("rms_slope", "rms_curvature", "range")
_ONSET = (*_MOMENTS, "work_of_adhesion", "contact_modulus", "kappa_rep")


def contact_diameter(contact: RoughContact) -> Estimate:
    """d_rep = 4h'/h''."""
    inputs = contact.inputs("rms_slope", "rms_curvature")
    source = "paper, above Eq. (6); measured widths within a factor of two"
    return Estimate("contact diameter", "d_rep", contact.diameter, "length", source, inputs, tuple(_steep(contact)))


def area_ratio(contact: RoughContact) -> Estimate:
    """A_rep/A_att."""
    source = "paper, Eq. (4)"
    inputs = contact.inputs(*_MOMENTS)
    return Estimate("area ratio", "A_rep/A_att", contact.area_ratio, "", source, inputs, tuple(_rim(contact)))


def inverse_kappa(contact: RoughContact) -> Estimate:
    """1/κ = (N/A_rep)/(h' E*): finite at the onset, negative where sticky."""
    att = paper.kappa_att(contact.rms_slope, contact.range, contact.adhesion_length, contact.area_ratio)
    value = 1 / contact.kappa_rep - 1 / att
    source = "paper, Eqs. (3), (4)"
    return Estimate("inverse kappa", "1/κ", value, "", source, contact.inputs(*_ONSET), tuple(_rim(contact)))


def repulsive_pressure(contact: RoughContact) -> Estimate:
    """p_rep = h' E*/κ_rep, mean over the repulsive area."""
    value = paper.repulsive_pressure(contact.rms_slope, contact.kappa_rep, contact.contact_modulus)
    inputs = contact.inputs("rms_slope", "contact_modulus", "kappa_rep")
    source = "paper, Eq. (1); A_rep much smaller than A0"
    return Estimate("repulsive pressure", "p_rep", value, "pressure", source, inputs, tuple(_steep(contact)))


def adhesive_pressure(contact: RoughContact) -> Estimate:
    """w/Δr, mean tension over the attracted area."""
    value = paper.adhesive_pressure(contact.work_of_adhesion, contact.range)
    inputs = contact.inputs("work_of_adhesion", "range")
    return Estimate("adhesive pressure", "w/Δr", value, "pressure", "paper, after Eq. (1)", inputs)


def attraction_width(contact: RoughContact) -> Estimate:
    """d_att, width of the attracted rim."""
    value = paper.attraction_width(contact.rms_slope, contact.diameter, contact.range)
    inputs = contact.inputs(*_MOMENTS)
    return Estimate("attraction width", "d_att", value, "length", "paper, Eq. (S-2)", inputs, tuple(_rim(contact)))


def maugis_parameter(contact: RoughContact) -> Estimate:
    """Maugis' λ of one asperity: DMT below 0.1, JKR above 5."""
    inputs = contact.inputs("rms_curvature", "range", "work_of_adhesion", "contact_modulus")
    return Estimate("Maugis parameter", "λ_Maugis", contact.maugis_parameter, "", "paper, Suppl. S-I", inputs)


def asperity_tabor(contact: RoughContact) -> Estimate:
    """Tabor's μ of one asperity, with Δr for its distance."""
    mu = tabor_parameter(contact.radius, contact.work_of_adhesion, contact.range, contact.contact_modulus)
    inputs = contact.inputs("rms_curvature", "range", "work_of_adhesion", "contact_modulus")
    return Estimate("Tabor parameter", "μ", mu, "", "Tabor 1977", inputs)


def pastewka_robbins(contact: RoughContact) -> Estimate:
    """The paper's condition of stickiness: κ_att/κ_rep below 1."""
    change = paper.height_change(contact.rms_slope, contact.rms_curvature)
    value = paper.onset(contact.rms_slope, change, contact.adhesion_length, contact.range, contact.kappa_rep)
    inputs, source = contact.inputs(*_ONSET), "paper, Eq. (6)"
    return Estimate("Pastewka-Robbins", "κ_att/κ_rep", value, "", source, inputs, tuple(_rim(contact)), 1 / value)


def necessary_adhesion(contact: RoughContact) -> Estimate:
    """The paper's necessary condition for atomic surfaces, l_a above 0.5 h' a0."""
    if contact.spacing is None:
        msg = "the necessary condition l_a > 0.5 h' a0 needs the spacing a0 of the atoms"
        raise ValueError(msg)
    value = contact.adhesion_length / paper.necessary_adhesion_length(contact.rms_slope, contact.spacing)
    inputs = contact.inputs("rms_slope", "work_of_adhesion", "contact_modulus", "spacing")
    source = "paper, below Eq. (6): necessary, not sufficient"
    return Estimate("necessary adhesion", "2 l_a/(h' a0)", value, "", source, inputs, tuple(_steep(contact)), value)


def bearing_area(contact: RoughContact) -> Estimate:
    """Ciavarella's bearing-area model: h_rms² below about 0.63 l_a λ_L, whatever the short waves."""
    if contact.roll_off is None:
        msg = "the bearing-area model needs the roll-off wavelength λ_L"
        raise ValueError(msg)
    limit = rough.bearing_area_limit(contact.rms_height / contact.range)
    value = contact.rms_height**2 / (contact.adhesion_length * contact.roll_off)
    inputs = contact.inputs("rms_height", "roll_off", "range", "work_of_adhesion", "contact_modulus")
    source = "Ciavarella 2018 (BAM), derived anew with γ = 1/2"
    why = _steep(contact)
    if contact.range > contact.rms_height:
        why.append("the range of adhesion exceeds h_rms: the repulsion is taken at large separations")
    name = "bearing area (BAM)"
    return Estimate(name, "h_rms²/(l_a λ_L)", value, "", source, inputs, tuple(why), limit / value)


def generalised_tabor(contact: RoughContact) -> Estimate:
    """Müser's Tabor number of rough surfaces: no verdict, but whether the range matters."""
    value = rough.generalised_tabor(contact.rms_curvature, contact.adhesion_length, contact.range)
    inputs = contact.inputs("rms_curvature", "range", "work_of_adhesion", "contact_modulus")
    return Estimate("generalised Tabor number", "μ_T", value, "", "Müser 2016, R = 1/h''", inputs)


def range_over_gap(contact: RoughContact) -> Estimate:
    """Δr over the gap beside a patch; the paper's rim is thin below 0.1."""
    value = contact.range / paper.gap_scale(contact.rms_slope, contact.rms_curvature)
    source = "Monti, Sanner and Pastewka 2021: below 0.1 a thin rim"
    return Estimate("range over gap", "Δr/g0", value, "", source, contact.inputs(*_MOMENTS))


def _asperities(contact: RoughContact, name: str, source: str, why: list[str]) -> Estimate:
    """The verdict of asperity theories, h_rms/δ_c below 3, where δ_c grows as w^(2/3)."""
    jkr = JKR(contact.radius, contact.work_of_adhesion, contact.contact_modulus)
    value = contact.rms_height / jkr.separation_distance
    inputs = contact.inputs("rms_height", "rms_curvature", "work_of_adhesion", "contact_modulus")
    return Estimate(name, "h_rms/δ_c", value, "", source, inputs, tuple(why), (GW_LIMIT / value) ** 1.5)


def fuller_tabor(contact: RoughContact) -> Estimate:
    """Fuller and Tabor's parameter h_rms/δ_c, negligible pull-off above 3."""
    why = _steep(contact)
    if contact.maugis_parameter < JKR_LIMIT:
        why.append(f"Maugis' parameter {contact.maugis_parameter:.3g} is below {JKR_LIMIT:g}: asperities are not JKR's")
    return _asperities(contact, "Fuller-Tabor", "Fuller and Tabor 1975; asperities do not interact", why)


def dmt_asperities(contact: RoughContact) -> Estimate:
    """The same parameter for DMT asperities."""
    why = _steep(contact)
    if contact.maugis_parameter > DMT_LIMIT:
        why.append(f"Maugis' parameter {contact.maugis_parameter:.3g} is above {DMT_LIMIT}: asperities are not DMT's")
    return _asperities(contact, "Maugis (DMT asperities)", "Maugis 1996; asperities do not interact", why)


def _energy(contact: RoughContact, name: str, source: str, fraction: float) -> Estimate:
    if contact.conformal_energy is None:
        msg = f"{name} needs the elastic energy of full contact"
        raise ValueError(msg)
    why = _steep(contact)
    if contact.range > contact.rms_height:
        why.append("the range of adhesion exceeds h_rms; the theory takes it as zero")
    value = contact.conformal_energy / contact.work_of_adhesion
    inputs = contact.inputs("conformal_energy", "work_of_adhesion", "range", "rms_height")
    return Estimate(name, "U_full/w", value, "", source, inputs, tuple(why), 1 / (fraction * value))


def persson_tosatti(contact: RoughContact) -> Estimate:
    """Full contact gains energy: w above the elastic energy of full contact."""
    return _energy(contact, "Persson-Tosatti", "Persson and Tosatti 2001", 1.0)


def half_conformal_energy(contact: RoughContact) -> Estimate:
    """High pull-off stress where w exceeds half the elastic energy of full contact: simulated half-spaces, sheets."""
    return _energy(contact, "half conformal energy", "doi:10.3389/fmech.2022.965584 (Müser's group)", 0.5)


def asperity_pull_off(contact: RoughContact) -> Estimate:
    """Fuller and Tabor's pull-off force per area."""
    parameter = fuller_tabor(contact)
    limit = rough.asperity_limit(contact.work_of_adhesion, contact.rms_height)
    value = limit * rough.fuller_tabor(parameter.value)
    source = "Fuller and Tabor 1975, 0.05 summits per R h_rms"
    return Estimate("pull-off", "N/A0", value, "pressure", source, parameter.inputs, parameter.why)


def dmt_pull_off(contact: RoughContact) -> Estimate:
    """Pull-off force per area of DMT asperities, 2π w R each instead of (3/2)π w R."""
    parameter = dmt_asperities(contact)
    limit = 4 / 3 * rough.asperity_limit(contact.work_of_adhesion, contact.rms_height)
    value = limit * rough.dmt_asperities(parameter.value)
    source = "Maugis 1996, 0.05 summits per R h_rms"
    return Estimate("pull-off (DMT asperities)", "N/A0", value, "pressure", source, parameter.inputs, parameter.why)


def verdicts(contact: RoughContact) -> tuple[Estimate, ...]:
    """Every criterion of stickiness that the inputs allow, the paper's first."""
    criteria = [pastewka_robbins, fuller_tabor, dmt_asperities]
    if contact.conformal_energy is not None:
        criteria += [persson_tosatti, half_conformal_energy]
    if contact.roll_off is not None:
        criteria += [bearing_area]
    if contact.spacing is not None:
        criteria += [necessary_adhesion]
    return tuple(criterion(contact) for criterion in criteria)


def every_estimate(contact: RoughContact) -> tuple[Estimate, ...]:
    """Every verdict, and the numbers behind them."""
    numbers = (
        inverse_kappa,
        area_ratio,
        contact_diameter,
        attraction_width,
        repulsive_pressure,
        adhesive_pressure,
        maugis_parameter,
        asperity_tabor,
        generalised_tabor,
        range_over_gap,
        asperity_pull_off,
        dmt_pull_off,
    )
    return (*verdicts(contact), *(number(contact) for number in numbers))
