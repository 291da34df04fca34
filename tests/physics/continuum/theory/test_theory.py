"""The paper's equations against one another, and what is off in its text; every function in any units."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from continuum.maps.verdict.criteria import CRITERIA, Estimate, RoughContact, every_estimate
from continuum.theory import paper, rough, smooth
from docs.studies.persson import persson_area
from tests import classical

positive = st.floats(0.1, 10)
slope = st.floats(0.01, 0.5)


# --- the chain of the paper's equations --------------------------------------------------------------------


@given(slope, positive, positive)
def test_the_rim_follows_from_the_gap(rms_slope: float, curvature: float, range_: float) -> None:
    diameter = paper.contact_diameter(rms_slope, curvature)
    width = paper.attraction_width(rms_slope, diameter, range_)
    assert float(paper.gap_outside_contact(width, rms_slope, diameter)) == pytest.approx(range_, rel=1e-12)
    # A_att = P d_att with P = π A_rep/d_rep: Eqs. (4) and (S-2) say the same.
    ratio = paper.area_ratio(rms_slope, diameter, range_)
    assert 1 / ratio == pytest.approx(paper.perimeter(1.0, diameter) * width, rel=1e-12)
    assert paper.height_change(rms_slope, curvature) == pytest.approx(rms_slope * diameter / 4, rel=1e-14)
    # A parabola of radius R has the slope h' at half the diameter.
    assert diameter / 2 / paper.asperity_radius(curvature) == pytest.approx(rms_slope, rel=1e-14)


def test_the_gap_is_that_outside_a_cylinder() -> None:
    # Johnson, section 5.3 with Baney and Hui: outside a cylinder of radius R pressed to a half-width a without adhesion
    # the slope of the gap is (a/R) sqrt(x²/a² - 1), x from its middle; close to the edge Eq. (S-1).
    a, radius = 1.0, 10.0
    for x in (1e-3, 1e-4):
        exact = quad(lambda s: a / radius * np.sqrt(((a + s) / a) ** 2 - 1), 0, x, epsabs=0)[0]
        # The next term of the expansion is 3x/(20 a).
        assert float(paper.gap_outside_contact(x, a / radius, 2 * a)) == pytest.approx(exact, rel=0.2 * x)


@given(slope, positive, positive, st.floats(1e-4, 0.1), st.floats(1.5, 3))
def test_the_onset_is_where_kappa_changes_sign(
    rms_slope: float, curvature: float, range_: float, length: float, kappa_rep: float
) -> None:
    ratio = paper.area_ratio(rms_slope, paper.contact_diameter(rms_slope, curvature), range_)
    att = paper.kappa_att(rms_slope, range_, length, ratio)
    change = paper.height_change(rms_slope, curvature)
    onset = paper.onset(rms_slope, change, length, range_, kappa_rep)
    assert onset == pytest.approx(att / kappa_rep, rel=1e-12)
    inverse = 1 / kappa_rep - 1 / att
    assert (inverse < 0) == (onset < 1)
    # N = p_rep A_rep - (w/Δr) A_att, the sum that the equations stand for.
    net = paper.repulsive_pressure(rms_slope, kappa_rep) - paper.adhesive_pressure(length, range_) / ratio
    assert net == pytest.approx(rms_slope * inverse, rel=1e-9, abs=1e-12)
    modulus = paper.critical_modulus(rms_slope, change, length, range_, kappa_rep)
    assert paper.onset(rms_slope, change, length / modulus, range_, kappa_rep) == pytest.approx(1, rel=1e-12)


def test_without_attraction_kappa_has_no_part_of_it() -> None:
    assert paper.kappa_att(0.1, 1.0, 0.0, 1.0) == np.inf


@pytest.mark.parametrize(
    ("attraction", "cutoff"),
    [
        (lambda x: x * (1 - x / 0.4) ** 2, 0.4),
        (lambda x: (1 + x) ** -4 - (1 + x) ** -10, np.inf),
        (lambda x: x * np.exp(-x), 60.0),
    ],
)
def test_the_effective_range_keeps_the_load_of_the_rim(attraction: Callable[[float], float], cutoff: float) -> None:
    range_ = paper.effective_range(attraction, cutoff)
    work = quad(attraction, 0, cutoff, epsabs=0, epsrel=1e-11)[0]
    # Eqs. (S-3), (S-4), with the load integrated over the distance x from the edge.
    rim = work / range_ * paper.attraction_width(0.1, 20.0, range_)
    end = paper.attraction_width(0.1, 20.0, cutoff) if np.isfinite(cutoff) else np.inf
    over_x = quad(lambda x: attraction(float(paper.gap_outside_contact(x, 0.1, 20.0))), 0, end, epsabs=0, limit=400)[0]
    assert rim == pytest.approx(over_x, rel=1e-6)


def test_a_flat_attraction_has_its_own_range() -> None:
    # Dugdale: constant p up to r.  (2/3) ∫ Δ^(-1/3) dΔ = r^(2/3), so Eq. (S-5) gives r itself.
    assert paper.effective_range(lambda x: 1.0, cutoff=0.7) == pytest.approx(0.7, rel=1e-10)


# --- what is off in the paper's text -----------------------------------------------------------------------


def test_perimeter_factors() -> None:
    # Mean of 1/cos over the octant, and the inverse of the mean of cos.
    quarter = np.pi / 4
    assert quad(lambda t: 1 / np.cos(t), 0, quarter)[0] / quarter == pytest.approx(paper.PERIMETER_FACTOR_PAPER)
    assert quarter / quad(np.cos, 0, quarter)[0] == pytest.approx(paper.PERIMETER_FACTOR)
    assert pytest.approx(1.1222, abs=5e-5) == paper.PERIMETER_FACTOR_PAPER
    assert pytest.approx(1.1107, abs=5e-5) == paper.PERIMETER_FACTOR
    # Counted discs confirm the latter: cells that have a neighbour outside.
    radius = 200.3
    x = np.arange(-210, 211)
    disc = np.hypot(x[:, None], x) < radius
    inner = disc.copy()
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        inner &= np.roll(disc, step, axis)
    factor = 2 * np.pi * radius / np.count_nonzero(disc & ~inner)
    # One cell in some 1100 either way, and an edge that runs half a cell inside the circle: 0.3 %.
    assert factor == pytest.approx(paper.PERIMETER_FACTOR, rel=4e-3)
    assert factor < paper.PERIMETER_FACTOR_PAPER * (1 - 4e-3)


def test_the_bound_of_the_onset() -> None:
    # κ_att/κ_rep = 1 where the left side of Eq. (6) is π (3/16)^(2/3), "about 1".
    assert np.pi * (3 / 16) ** (2 / 3) == pytest.approx(1.029, abs=5e-4)
    left = 0.1 * 0.5 / (2 * 0.01) * (0.2 / 0.5) ** (2 / 3)
    assert paper.onset(0.1, 0.2, 0.01, 0.5) == pytest.approx(left / (np.pi * (3 / 16) ** (2 / 3)), rel=1e-12)


def test_the_necessary_condition_comes_from_the_onset_not_from_the_area_ratio() -> None:
    needed = paper.onset(0.1, 1.0, 1.0, 1.0)  # δh = Δr = a0, κ_rep = 2, in units of l_a
    assert needed / 0.1 == pytest.approx(0.486, abs=5e-4)
    assert paper.necessary_adhesion_length(0.1) == pytest.approx(needed, rel=0.03)  # printed as 0.5


def test_the_rubber_of_the_discussion_sticks_below_70_megapascal_not_10() -> None:
    slope, diameter, range_, work = 1.0, 10e-9, 0.5e-9, 0.05
    modulus = paper.critical_modulus(slope, slope * diameter / 4, work, range_)
    assert modulus == pytest.approx(70.4e6, rel=1e-3)
    contact = RoughContact(1e-6, slope, 4 * slope / diameter, work, range_, 10e6)
    verdict = CRITERIA["pastewka-robbins"](contact)
    assert verdict.sticky
    assert verdict.margin is not None
    assert verdict.margin * 10e6 == pytest.approx(modulus, rel=1e-12)
    assert not verdict.valid  # a slope of 1 is beyond what was tested


def test_the_tape_of_the_discussion() -> None:
    # E* = 0.1 MPa, h' = 1, Δr = 0.5 nm, w = 50 mJ/m²: sticky up to d_rep of about 0.2 mm ("<~ 100 µm").
    def modulus(diameter: float) -> float:
        return paper.critical_modulus(1.0, diameter / 4, 0.05, 0.5e-9)

    assert modulus(100e-6) > 0.1e6
    assert modulus(300e-6) < 0.1e6


def test_numbers_of_the_supplement() -> None:
    assert rough.asperity_limit(1.0, 1.0) == pytest.approx(0.2356, abs=5e-5)
    # λ_Maugis of 1 for l_a = 5e-4, h' = 0.1, Δr = 1 (in a0) has d_rep = 0.17 mm with a0 = 0.3 nm, and 1 mm at
    # λ_Maugis = 1.8: "accurate even when it exceeds unity ... close to a millimeter".
    for parameter, diameter in ((1.0, 0.1676e-3), (1.8, 0.977e-3)):
        assert paper.maugis_parameter(diameter / 0.3e-9 / 0.2, 5e-4, 1.0) == pytest.approx(parameter, rel=1e-3)


# --- any units ---------------------------------------------------------------------------------------------

NUMBER, LENGTH, CURVATURE, MODULUS, WORK, FORCE = (0, 0), (1, 0), (-1, 0), (0, 1), (1, 1), (2, 1)
ARGUMENTS: dict[str, tuple[tuple[float, int], float]] = {
    # name: powers of length and modulus, a value about which the drawn ones lie
    **dict.fromkeys(("rms_slope", "kappa_att", "area_ratio", "ratio"), (NUMBER, 0.7)),
    "kappa_rep": (NUMBER, 2.0),
    **dict.fromkeys(("diameter", "height_change", "radius", "spacing", "distance", "rms_height"), (LENGTH, 3.0)),
    **dict.fromkeys(("range", "separation", "amplitude", "half_width", "contact_radius"), (LENGTH, 1.0)),
    **dict.fromkeys(("x", "r"), (LENGTH, 0.3)),
    "wavelength": (LENGTH, 20.0),
    "cutoff": (LENGTH, 2.0),
    "adhesion_length": (LENGTH, 0.01),
    **dict.fromkeys(("work", "work_of_adhesion"), (WORK, 0.01)),
    "weighted": ((2 / 3, 1), 0.01),
    "conformal_energy": (WORK, 0.02),
    **dict.fromkeys(("rms_curvature", "wavenumber"), (CURVATURE, 0.5)),
    "area": ((2, 0), 5.0),
    "power": ((2, 0), 0.1),
    "density": ((-2, 0), 0.1),
    **dict.fromkeys(("contact_modulus", "pressure"), (MODULUS, 1.0)),
    "mean_pressure": (MODULUS, 0.05),
    "largest_softening": ((-1, 1), 0.2),
    "load": (FORCE, 2.0),
}
RESULTS: dict[str, tuple[int, int] | tuple[tuple[int, int], ...]] = {
    **dict.fromkeys(("area_ratio", "kappa_att", "onset", "maugis_parameter"), NUMBER),
    **dict.fromkeys(("tabor_parameter", "parameter", "alpha", "fuller_tabor", "dmt_asperities", "area"), NUMBER),
    **dict.fromkeys(
        ("persson_area", "bearing_area_limit", "threshold_share", "generalised_tabor", "pressure_att"), NUMBER
    ),
    **dict.fromkeys(("gap_scale", "diameter", "width"), LENGTH),
    **dict.fromkeys(("asperity_radius", "attraction_width", "contact_diameter", "effective_range"), LENGTH),
    "range_of_integrals": LENGTH,
    **dict.fromkeys(("gap_outside_contact", "height_change", "necessary_adhesion_length", "perimeter"), LENGTH),
    **dict.fromkeys(("snap_in_wavelength", "contact_radius", "indentation"), LENGTH),
    **dict.fromkeys(
        ("separation_distance", "zero_load_radius", "pull_off_radius", "half_width", "pull_off_width"), LENGTH
    ),
    **dict.fromkeys(("snap_in_width",), LENGTH),
    **dict.fromkeys(("adhesive_pressure", "critical_modulus", "repulsive_pressure", "pressure"), MODULUS),
    **dict.fromkeys(("full_pressure", "mean_pressure", "pull_off_pressure", "asperity_limit"), MODULUS),
    **dict.fromkeys(("pull_off_force", "separation_force", "load"), FORCE),
    **dict.fromkeys(("conformal_energy",), WORK),
    "state": (LENGTH, LENGTH, FORCE, LENGTH),
}


def _functions() -> list[Callable[..., Any]]:
    """Every public function and every public property and method of the oracles, as functions of numbers by name."""
    found: list[Callable[..., Any]] = [persson_area]
    for module in (paper, smooth, rough, classical):
        public = [name for name in vars(module) if not name.startswith("_")]
        for thing in (getattr(module, name) for name in public):
            if getattr(thing, "__module__", None) != module.__name__:
                continue
            if isinstance(thing, type) and dataclasses.is_dataclass(thing):
                fields = {field.name for field in dataclasses.fields(thing)}
                found += [
                    _member(thing, member)
                    for member in vars(thing)
                    if not member.startswith("_") and member not in fields
                ]
            elif inspect.isfunction(thing) and not thing.__name__.endswith("_exponent"):  # numbers from numbers
                found.append(thing)
    return found


def _member(cls: type, name: str) -> Callable[..., Any]:
    member = vars(cls)[name]
    own = {} if isinstance(member, property) else dict(list(inspect.signature(member).parameters.items())[1:])
    init = inspect.signature(cls).parameters

    def call(**values: Any) -> Any:
        instance = cls(**{key: values[key] for key in init})
        value = getattr(instance, name)
        return value(**{key: values[key] for key in own}) if own else value

    call.__name__, call.__qualname__ = name, f"{cls.__name__}.{name}"
    named = [p.replace(kind=p.KEYWORD_ONLY) for p in {**init, **own}.values()]
    vars(call)["__signature__"] = inspect.Signature(named)
    return call


@pytest.mark.parametrize("function", _functions(), ids=lambda f: f.__qualname__)
@given(st.data())
@settings(max_examples=2)  # of each of 59: a wrong power of a unit shows in any
def test_units_do_not_matter(function: Callable[..., Any], data: st.DataObject) -> None:
    length, modulus = data.draw(st.floats(1e-9, 1e3)), data.draw(st.floats(1e-6, 1e12))
    names = list(inspect.signature(function).parameters)
    drawn = {name: data.draw(st.floats(0.7, 1.4)) for name in names if name != "attraction"}

    def called(s: float, e: float) -> Any:
        values: dict[str, Any] = {}
        for name in names:
            if name == "attraction":
                values[name] = lambda gap: e * np.exp(-gap / (0.8 * s))
            else:
                (one, two), about = ARGUMENTS[name]
                values[name] = about * drawn[name] * s**one * e**two
        return function(**values)

    expected = RESULTS[function.__name__]
    powers = expected if isinstance(expected[0], tuple) else (expected,)
    base, scaled = np.atleast_1d(called(1.0, 1.0)), np.atleast_1d(called(length, modulus))
    assert np.isfinite(base).all()
    assert (base != 0).all()
    for before, after, (one, two) in zip(base, scaled, powers, strict=True):
        # The minimum by which a pull-off is found is known to 1e-7; where it lies, to the root of that.
        rel = 3e-4 if function.__name__ == "pull_off_radius" else 1e-6
        assert after / (length**one * modulus**two) == pytest.approx(before, rel=rel)


# --- estimates ---------------------------------------------------------------------------------------------

contacts = st.builds(
    RoughContact,
    rms_height=st.floats(0.5, 100),
    rms_slope=st.floats(0.01, 0.5),
    rms_curvature=st.floats(0.001, 1),
    work_of_adhesion=st.floats(1e-4, 0.1),
    range=st.floats(0.1, 1),
    conformal_energy=st.floats(1e-4, 1),
    spacing=st.just(1.0),
)


def verdicts(contact: RoughContact) -> tuple[Estimate, ...]:
    """The criteria of stickiness among all estimates."""
    return tuple(one for one in every_estimate(contact) if one.margin is not None)


@given(contacts)
@settings(max_examples=8)  # each by twenty criteria
def test_the_margin_is_the_factor_by_which_adhesion_exceeds_the_onset(contact: RoughContact) -> None:
    for name, criterion in CRITERIA.items():
        estimate = criterion(contact) if criterion.possible(contact) else None
        if estimate is None or estimate.margin is None:
            continue
        assert estimate.sticky == (estimate.margin > 1)
        for factor in (0.99, 1.01):
            at = dataclasses.replace(contact, work_of_adhesion=factor * contact.work_of_adhesion / estimate.margin)
            assert criterion(at).sticky == (factor > 1), name
            # Softer by as much does the same.
            soft = contact.contact_modulus * estimate.margin / factor
            assert contact.conformal_energy is not None
            energy = contact.conformal_energy * estimate.margin / factor
            at = dataclasses.replace(contact, contact_modulus=soft, conformal_energy=energy)
            assert criterion(at).sticky == (factor > 1), name
    assert (CRITERIA["inverse-kappa"](contact).value < 0) == verdicts(contact)[0].sticky


@given(contacts, st.floats(1e-9, 1e3), st.floats(1e-6, 1e12))
@settings(max_examples=6)
def test_estimates_in_any_units(contact: RoughContact, length: float, modulus: float) -> None:
    values: dict[str, Any] = {
        name: None if value is None else value * length ** ARGUMENTS[name][0][0] * modulus ** ARGUMENTS[name][0][1]
        for name, value in vars(contact).items()
        if name != "coated"
    }
    unit = {"": 1.0, "length": length, "pressure": modulus}
    estimates = every_estimate(contact)
    possible = [criterion for criterion in CRITERIA.values() if criterion.possible(contact)]
    assert len({estimate.name for estimate in estimates}) == len(estimates) == len(possible) >= 19
    assert estimates[: len(verdicts(contact))] == verdicts(contact)
    for one, other in zip(estimates, every_estimate(RoughContact(**values)), strict=True):
        # Pull-off forces that vanish are known to rounding only.
        assert other.value / unit[other.unit] == pytest.approx(one.value, rel=1e-6, abs=1e-12)
        assert other.valid == one.valid == (not one.why)
        assert (one.margin is None) == (one.sticky is None)
        if one.margin is not None:
            assert other.margin == pytest.approx(one.margin, rel=1e-9)


def test_the_numbers_behind_the_verdict_belong_together() -> None:
    contact = RoughContact(10.0, 0.1, 0.02, 0.0005, 0.10954)
    value = {estimate.name: estimate.value for estimate in every_estimate(contact)}
    # N/A_rep = p_rep - (w/Δr) A_att/A_rep = h'/κ, and A_att = π d_att/d_rep of A_rep.
    net = value["repulsive pressure"] - value["adhesive pressure"] / value["area ratio"]
    assert net == pytest.approx(contact.rms_slope * value["inverse kappa"], rel=1e-12)
    rim = np.pi * value["attraction width"] / value["contact diameter"]
    assert rim == pytest.approx(1 / value["area ratio"], rel=1e-12)
    # Smooth asperities: 2π w R against (3/2)π w R, with 0.05 of them per R h_rms.
    smooth = dataclasses.replace(contact, rms_height=1e-4)
    found = {estimate.name: estimate.value for estimate in every_estimate(smooth)}
    assert found["pull-off (DMT asperities)"] == pytest.approx(0.1 * np.pi * 0.0005 / 1e-4, rel=5e-3)
    assert found["pull-off"] == pytest.approx(0.075 * np.pi * 0.0005 / 1e-4, rel=5e-3)


def test_an_estimate_says_why_it_is_out_of_range() -> None:
    strong = RoughContact(1.0, 0.1, 0.1, 0.05, 1.09545)
    verdict = CRITERIA["pastewka-robbins"](strong)
    assert verdict.sticky
    assert any("A_att/A_rep" in reason for reason in verdict.why)
    weak = RoughContact(10.0, 0.1, 0.02, 0.0005, 0.10954)
    verdict = CRITERIA["pastewka-robbins"](weak)
    assert verdict.valid
    assert not verdict.sticky
    # Between the limits neither kind of asperity fits.
    assert CRITERIA["fuller-tabor"](weak).why
    assert CRITERIA["dmt-asperities"](weak).why
    steep = dataclasses.replace(weak, rms_slope=0.5)
    assert all(any("h' = 0.5" in reason for reason in e.why) for e in every_estimate(steep)[:3])
    soft = dataclasses.replace(weak, range=0.01, rms_curvature=0.001)
    assert any("adhesion changes the gap" in reason for reason in CRITERIA["inverse-kappa"](soft).why)
    assert CRITERIA["fuller-tabor"](soft).valid
    flat = RoughContact(0.05, 0.1, 0.02, 0.0005, 0.10954, conformal_energy=1e-4)
    assert any("exceeds h_rms" in reason for reason in CRITERIA["persson-tosatti"](flat).why)


def test_missing_and_meaningless_inputs_are_refused() -> None:
    contact = RoughContact(1.0, 0.1, 0.1, 0.01, 0.5)
    for estimate in (CRITERIA["persson-tosatti"], CRITERIA["half-conformal-energy"], CRITERIA["necessary-adhesion"]):
        with pytest.raises(ValueError, match="needs the"):
            estimate(contact)
    meaningless = {"rms_slope": 0.0, "range": -1.0, "work_of_adhesion": np.nan, "spacing": np.inf}
    for name, value in meaningless.items():
        changed: dict[str, Any] = {name: value}
        with pytest.raises(ValueError, match=f"{name} = .*: allowed: a finite number greater than 0"):
            dataclasses.replace(contact, **changed)


def test_the_expected_contact_is_what_the_equations_say() -> None:
    slope, curvature, reach, length = 0.1, 0.02, 0.35, 0.005
    expected = paper.ExpectedContact(slope, curvature, reach, length)
    ratio = paper.area_ratio(slope, 20.0, reach)
    assert expected.diameter == pytest.approx(20)
    assert expected.area_ratio == pytest.approx(ratio)
    assert expected.width == pytest.approx(20 / (np.pi * ratio))  # Eq. (4): A_rep/A_att = d_rep/(π d_att)
    assert expected.kappa_att == pytest.approx(slope * reach / length * ratio)
    assert expected.pressure_att == pytest.approx(length / reach)


def test_without_attraction_no_attracted_area_is_expected() -> None:
    bare = paper.ExpectedContact(0.1, 0.02)
    assert (bare.width, bare.area_ratio, bare.kappa_att) == (0, np.inf, np.inf)
    assert np.isnan(bare.pressure_att)
