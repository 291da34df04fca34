"""The threshold of a map by one state, against searches and what is known of them; and the verdict by it."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import continuum as c
from continuum.front.cli import main
from continuum.inputs.errors import InputError
from continuum.maps.map import Topography, mirror
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.on_grid import UnresolvedError
from continuum.maps.verdict.prediction import WIDE, PredictionNumbers, prediction_of, unmeasured_shift
from continuum.maps.verdict.search import WIDTH, find_threshold, search_threshold
from continuum.maps.verdict.threshold import (
    ANY,
    BEYOND,
    BEYOND_FEW,
    FEW_POINTS,
    GAUSSIAN,
    LESS_SURE,
    Basis,
    MapThreshold,
    PressedMap,
    bounds,
    press_map,
)
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.show.answer import statements
from continuum.show.prediction_figures import load_figure
from continuum.solve.solution import NotConvergedError
from continuum.theory.rough import threshold_share
from tests.physics.continuum.maps.verdict.test_predict import surface
from tests.printed import faults_in_print

RANGE = 0.35


def textured(kind: str, n: int = 128) -> Topography:
    """Textures on which theories of roughness are off by factors of 2 to 6; the third with few longer waves."""
    x = np.arange(n)
    wave, post = np.cos(2 * np.pi * 8 * x / n), np.clip(1.5 * np.cos(2 * np.pi * 8 * x / n), -0.7, 0.7)
    fine = SelfAffine(0.8, 0.05, 6.0, 16.0).synthesise(Grid.square(n), np.random.default_rng(1))
    heights = {
        "egg-box": 0.5 * (wave[:, None] + wave) + 0.3 * fine,
        "posts": 2 * np.minimum(post[:, None], post) + 0.3 * fine,
        "Gaussian": 4 * fine,
    }[kind]
    return Topography(heights, (float(n), float(n)), periodic=True, source=kind)


@pytest.mark.parametrize("kind", ["egg-box", "posts", "Gaussian"])
def test_one_state_tells_what_a_search_finds(kind: str) -> None:
    topography = textured(kind)
    pressed = press_map(topography, Interface(1.0, 1.0, float(topography.heights.std()), None))
    found = pressed.threshold()
    assert found.source is Basis.STATE
    assert found.why == ()
    assert found.low < found.work < found.high < 1.2 * found.low
    searched = search_threshold(pressed, found)
    # The statement, and the bracket that the load is interpolated in: its hundredth part.
    assert found.low / 1.01 < searched.work < found.high * 1.01
    assert searched.high / searched.low < (1 + WIDTH) * (1 + 1e-9)
    # It begins at the estimate: three in the median, more where posts touch at once; one more or less by 1e-4 of it.
    assert searched.solves <= 10


def test_where_theories_are_off_the_state_is_right() -> None:
    """Two thirds of the theories miss the threshold of posts by more than a factor of two."""
    topography = textured("posts")
    found = prediction_of([topography], Interface(1.0, 1.0, float(topography.heights.std()), None)).solved(search=False)
    assert found.threshold is not None
    ratios = [found.contact.work_of_adhesion / (one.margin or np.nan) / found.threshold.work for one in found.verdicts]
    assert np.sum(np.abs(np.log(ratios)) > np.log(2)) >= 2 / 3 * len(ratios)


@cache
def of_a_small_surface() -> MapThreshold:
    return press_map(surface(64), Interface(1.0, 0.01, RANGE, None)).threshold()


@settings(max_examples=5)
@given(st.floats(-10, 10), st.floats(-10, 10))
def test_a_threshold_has_the_units_of_its_map(length: float, pressure: float) -> None:
    unit, stress, one = 10.0**length, 10.0**pressure, of_a_small_surface()
    large = Topography(unit * surface(64).heights, (64 * unit, 64 * unit), True)
    other = press_map(large, Interface(stress, 0.01 * stress * unit, RANGE * unit, None)).threshold()
    for name in ("work", "low", "high", "dmt"):
        assert getattr(other, name) == pytest.approx(stress * unit * getattr(one, name), rel=1e-3), name
    assert other.patches == one.patches


def test_the_given_work_changes_nothing_and_mirror_images_are_the_periodic_map() -> None:
    plain = surface(32)
    cut = Topography(plain.heights, plain.lengths)
    one = press_map(cut, Interface(1.0, 1e-3, RANGE, None)).threshold()
    other = press_map(mirror(cut), Interface(1.0, 10.0, RANGE, None)).threshold()
    assert one.work == pytest.approx(other.work, rel=1e-9)
    assert one.patches == other.patches // 4
    assert one.gap.shape == (64, 64)
    assert one.map.shape == (32, 32)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_small_map_is_met_to_half_of_what_touches_at_a_time(seed: int) -> None:
    """Its mirror images touch with it: of 38.4 points there are 36 or 40, which is no jump."""
    grid = Grid((40, 24), (40.0, 24.0))
    heights = SelfAffine(0.8, 0.1, 4.0, 24.0).synthesise(grid, np.random.default_rng(seed))
    found = press_map(Topography(heights, grid.lengths), Interface(1.0, 1e-3, RANGE, None)).threshold()
    assert found.source is Basis.STATE
    assert abs(found.area_rep * 4 * grid.size - 38.4) <= 2
    assert found.low < found.work < found.high


def test_the_curve_is_that_of_each_range() -> None:
    topography = Topography(1e-9 * textured("Gaussian").heights, (128e-9, 128e-9), True)
    curve = press_map(topography, Interface(1e9, 0.01, 0.8e-9, None)).threshold().curve
    ranges = [one.range for one in curve]
    assert ranges == sorted(ranges)
    assert 0.8e-9 in ranges
    for one in curve[-2:]:
        alone = press_map(topography, Interface(1e9, 0.01, one.range, None)).threshold()
        assert (one.work, one.low, one.high) == pytest.approx((alone.work, alone.low, alone.high), rel=1e-6)


@pytest.mark.parametrize(("few", "off"), [(FEW_POINTS, BEYOND_FEW), (100, BEYOND)])
def test_where_few_points_touch_the_error_is_larger(monkeypatch: pytest.MonkeyPatch, few: int, off: float) -> None:
    """A hundredth of 128² points are 164."""
    monkeypatch.setattr("continuum.maps.verdict.threshold.FEW_POINTS", few)
    pressed = press_map(textured("Gaussian"), Interface(1.0, 1.0, 1.0, None))
    found, one = pressed.threshold(), pressed.linear.at(1.0)
    assert found.why == ()
    assert (found.low, found.high) == pytest.approx((one.low / off, one.high * off))


def test_a_coarser_grid_has_nearly_the_same_threshold(monkeypatch: pytest.MonkeyPatch) -> None:
    """Linear solves on a quarter of the points, and all on a quarter of them: of sixteen points to the wave."""
    topography = surface(128, lambda_s=16.0)
    contact = Interface(1.0, 0.01, 1.5, None)
    whole = press_map(topography, contact).threshold()
    monkeypatch.setattr("continuum.maps.verdict.threshold.LINEAR", 64**2)
    by_ratio = press_map(topography, contact).threshold()
    assert by_ratio.work == pytest.approx(whole.work, rel=BEYOND - 1)
    assert by_ratio.gap.shape == (128, 128)
    assert any("64 x 64 points" in text for text in by_ratio.warnings)
    monkeypatch.setattr("continuum.maps.verdict.threshold.FINEST", 64**2)
    coarse = press_map(topography, contact).threshold()
    assert coarse.work == pytest.approx(whole.work, rel=2 * (BEYOND - 1))
    assert any("are left out" in text for text in coarse.warnings)


# --- beyond the range of the statement ------------------------------------------------------------------------


def test_beyond_its_range_the_interval_is_wide_and_a_search_decides() -> None:
    topography, found = surface(64), of_a_small_surface()
    assert any("patches touch, fewer than 10" in text for text in found.why)
    assert found.high / found.low > LESS_SURE**2
    for work, source in (
        (found.work, Basis.SEARCH),
        (found.low / 2, Basis.STATE),
        (found.high * 2, Basis.STATE),
    ):
        contact = Interface(1.0, work, RANGE, None)
        assert find_threshold(topography, contact, rough(topography, contact)).source is source
    contact = Interface(1.0, found.low / 2, RANGE, None)
    asked = find_threshold(topography, contact, rough(topography, contact), search=True)
    assert asked.source is Basis.SEARCH
    assert found.low < asked.work < found.high


def rough(topography: Topography, contact: Interface) -> Any:
    return prediction_of([topography], contact).contact


def test_where_the_series_diverges_there_are_bounds_and_a_soft_solid_is_sticky() -> None:
    """Silicone with a rms height of 30 nm on pixels of 40 nm: U F is 0.8 mJ/m², and w 45 mJ/m²."""
    heights = surface(128, lambda_s=4.0).heights
    found = c.predict(
        30 * heights / heights.std(), size="5.12um", unit="nm", periodic=True, modulus="2MPa", poisson=0.5,
        work="45mJ/m2", range="0.5nm", solve=False,
    )  # fmt: skip
    threshold, energy = found.threshold, found.contact.conformal_energy
    assert threshold is not None
    assert energy is not None
    assert threshold.source is Basis.BOUNDS
    assert np.isnan(threshold.chi)
    assert found.verdict.answer == "sticky"
    # The most that the law of the spectrum leaves for a Gaussian surface, as F is at most 1/2.
    assert 0 < threshold.low < threshold.work < threshold.high <= GAUSSIAN[1] / 2 * energy
    # A longer range, which the state answers, has a threshold of at least that bound.
    known = [one for one in threshold.curve if one.known]
    assert all(one.low >= threshold.low for one in threshold.curve)
    assert all(one.high <= ANY[1] / 2 * energy for one in threshold.curve)
    assert found.sentence.startswith("Sticky: w is at least ")
    for word in ("E*", "heights"):  # no root in range
        assert known or word not in found.sentence


def test_what_would_change_the_answer_is_known_or_not_said() -> None:
    """Each printed root of the curve lies between ranges that the state answers."""
    topography = Topography(1e-9 * textured("Gaussian").heights, (128e-9, 128e-9), True)
    found = prediction_of([topography], Interface(1e9, 1.0, 1e-9, None), smallest=2e-9).solved(search=False)
    assert found.threshold is not None
    found = at(found, 2 * found.threshold.work)
    assert "heights and slopes" in statements(found)[3]
    none = replace(found.threshold, curve=tuple(one._replace(known=False) for one in found.threshold.curve))
    said = statements(replace(found, threshold=none))[3]  # none of the ranges is answered
    assert "E* above" in said
    assert "range" not in said
    assert "heights" not in said


def test_a_range_below_the_pixels_leaves_an_interval() -> None:
    """The law of the spectrum says by how much more w a shorter range asks for."""
    topography, contact = surface(), Interface(1.0, 1.0, 0.01, None)
    found = search_threshold(pressed := press_map(topography, contact), pressed.threshold())
    height = topography.heights.std()
    assert found.range > 0.01
    assert found.high / found.work == pytest.approx(
        threshold_share(0.01 / height) / threshold_share(found.range / height)
    )
    assert found.sticky(0.5 * (found.work + found.high)) is None
    assert found.sticky(0.99 * found.low) is False
    assert found.sticky(1.01 * found.high) is True
    assert any("in place of" in text for text in found.warnings)


@pytest.mark.parametrize("error", [UnresolvedError("no pixels"), NotConvergedError("no end")])
def test_where_no_search_ends_there_are_bounds_and_their_reason(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise error

    monkeypatch.setattr("continuum.maps.verdict.search.bracket_threshold", refuse)
    small = surface(64)
    topography = Topography(1e-9 * small.heights, (64e-9, 64e-9), True)
    work = of_a_small_surface().work
    found = prediction_of([topography], Interface(1e9, work, RANGE * 1e-9, None)).solved()
    assert found.threshold is not None
    assert found.threshold.source is Basis.BOUNDS
    assert found.verdict.answer == "undecided"
    assert str(error) in found.verdict.why
    monkeypatch.setattr("continuum.maps.verdict.search.SHORT", -1.0)  # a clock may find that a small grid takes none
    assert "--solve makes it" in prediction_of([topography], found.interface).solved().verdict.why


def test_a_search_that_nobody_asked_for_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("continuum.maps.verdict.search.PATIENCE", 0.05)
    pressed = press_map(surface(), Interface(1.0, 1.0, RANGE, None))
    found = pressed.threshold()
    with pytest.raises(NotConvergedError, match=r"stopped after 15 pairs of transforms, 0\.05 times"):
        search_threshold(pressed, found, limited=True)
    assert search_threshold(pressed, found).work > 0


def test_where_there_is_no_map_the_law_of_the_spectrum_has_bounds() -> None:
    line = c.predict(np.random.default_rng(1).normal(size=128).cumsum(), size="1um", unit="nm", material="mica")
    found = line.threshold
    assert found is not None
    assert found.source is Basis.BOUNDS
    assert "not a map" in found.why[0]
    contact = rough(surface(), Interface(1.0, 0.01, RANGE, None))
    tested, short = bounds(contact, ""), bounds(replace(contact, range=1e-3 * contact.rms_height), "")
    assert 0 < tested.low < tested.work < tested.high
    assert short.low == 0
    assert short.high >= (contact.conformal_energy or np.inf)
    unknown = bounds(replace(contact, conformal_energy=None), "")
    assert unknown.sticky(1e-9) is unknown.sticky(1e9) is None


def test_what_cannot_be_pressed_is_one_clear_message() -> None:
    flat = np.zeros((32, 32))
    known: dict[str, Any] = {"size": "1um", "unit": "nm", "material": "mica"}
    for heights in (flat, np.full((32, 32), np.nan), np.zeros((0, 0))):
        with pytest.raises(InputError) as error:
            c.predict(heights, **known)
        assert len(str(error.value).splitlines()) == 1


# --- the verdict ----------------------------------------------------------------------------------------------


def at(found: PredictionNumbers, work: float) -> PredictionNumbers:
    """The same at another work of adhesion."""
    mended = found.mended and replace(found.mended, contact=replace(found.mended.contact, work_of_adhesion=work))
    return replace(found, contact=replace(found.contact, work_of_adhesion=work), mended=mended)


def test_sticky_above_not_sticky_below_and_undecided_between() -> None:
    topography = Topography(1e-9 * textured("Gaussian").heights, (128e-9, 128e-9), True)
    found = prediction_of([topography], Interface(1e9, 1.0, 1e-9, None), smallest=2e-9).solved(search=False)
    assert found.threshold is not None
    low, high, work = found.threshold.low, found.threshold.high, found.threshold.work
    for w, answer in ((1.01 * high, "sticky"), (work, "undecided"), (0.99 * low, "not sticky")):
        verdict = at(found, w).verdict
        assert verdict.answer == answer
        assert verdict.factor == pytest.approx(w / work)
        assert ("lies between" in verdict.why) is (answer == "undecided")
    assert prediction_of([topography], found.interface).verdict.answer == "undecided"  # nothing is pressed


@pytest.fixture(scope="module")
def noisy() -> PredictionNumbers:
    """White noise beyond the cut-off of a film: 0.25 nm on 2 nm, with waves of 8 pixels and more."""
    grid = Grid.square(64)
    film = SelfAffine(0.8, 0.1, 16.0, 32.0).synthesise(grid, np.random.default_rng(1))
    heights = 2 * film / film.std() + 0.25 * np.random.default_rng(2).normal(size=grid.shape)
    return c.predict(
        heights, size="256nm", unit="nm", periodic=True, contact_modulus="10GPa", work="0.1J/m2", range="1nm",
        smallest="64nm", solve=True,
    )  # fmt: skip


def test_where_the_corrected_map_has_another_answer_it_is_undecided_and_says_so(
    noisy: PredictionNumbers,
) -> None:
    mended, measured = noisy.threshold, noisy.threshold_as_measured
    assert [fault.kind for fault in noisy.faults] == ["noise"]
    assert mended is not None
    assert measured is not None
    assert measured.work > 1.5 * mended.work
    between = at(noisy, float(np.sqrt(mended.work * measured.work))).verdict
    assert between.answer == "undecided"
    assert "as measured the threshold is" in between.why
    assert at(noisy, 1.2 * measured.high).verdict.answer == "sticky"
    assert at(noisy, mended.low / 1.2).verdict.answer == "not sticky"


def test_a_fault_that_nothing_corrects_asks_for_a_wide_margin_and_steep_slopes_for_their_energy() -> None:
    plain = Topography(1e-9 * textured("Gaussian").heights, (128e-9, 128e-9), True)
    level = np.ptp(plain.heights) / 10
    stepped = replace(plain, heights=level * np.round(plain.heights / level), read=np.empty(0))
    gaussian = press_map(plain, Interface(1e9, 1.0, 1e-9, None)).threshold()

    def verdict(topography: Topography, work: float) -> Any:
        found = prediction_of([topography], Interface(1e9, work, 1e-9, None), smallest=2e-9)
        return replace(found, threshold=gaussian, threshold_as_measured=found.mended and gaussian).verdict

    assert verdict(plain, 2 * gaussian.high).answer == "sticky"
    near, far = verdict(stepped, 2 * gaussian.high), verdict(stepped, 1.01 * WIDE * gaussian.high)
    assert near.answer == "undecided"
    assert "without remedy: a verdict would have to hold at 10 times less w" in near.why
    assert far.answer == "sticky"
    for stretch, answer in ((2.2, "undecided"), (8.0, "undecided"), (100.0, "undecided")):
        steep = replace(plain, heights=stretch * plain.heights, read=np.empty(0))
        found = verdict(steep, 1.05 * gaussian.high)
        assert found.answer == answer
        assert "slope" in found.why


def test_waves_that_were_not_measured_leave_it_open_by_what_they_change_of_the_energy() -> None:
    film = SelfAffine(0.3, 0.1, 2.0, 16.0).synthesise(Grid.square(128), np.random.default_rng(1))
    topography = Topography(1e-9 * film, (128e-9, 128e-9), True)
    contact = Interface(1e9, 1.0, 1e-9, None)
    found = prediction_of([topography], contact, smallest=1e-9).solved(search=False)
    shift = unmeasured_shift(found)
    assert found.threshold is not None
    assert shift is not None
    assert 1.05 < shift < 3
    for work, answer in (
        (1.01 * found.threshold.high, "undecided"),
        (1.01 * shift * found.threshold.high, "sticky"),
        (0.99 * found.threshold.low, "not sticky"),
    ):
        verdict = at(found, work).verdict
        assert verdict.answer == answer
        assert ("were not measured" in verdict.why) is (answer == "undecided")


def test_the_figure_of_the_load_fits_and_there_is_none_with_bounds_only() -> None:
    topography = Topography(1e-9 * textured("Gaussian").heights, (128e-9, 128e-9), True)
    contact = Interface(1e9, 0.004, 1e-9, None, pressure=1e6)
    found = prediction_of([topography], contact, smallest=2e-9).solved(search=False)
    figure = load_figure(found)
    assert figure is not None
    assert faults_in_print(figure) == []
    low, high = figure.axes[0].get_ylim()
    assert low < 0 < 1.0 < high  # MPa
    assert load_figure(replace(found, threshold=bounds(found.contact, ""))) is None


def test_a_map_is_pressed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    times = list[int]()
    once = PressedMap._pressed
    monkeypatch.setattr(PressedMap, "_pressed", lambda *given: times.append(1) or once(*given))
    press_map(textured("Gaussian"), Interface(1.0, 1.0, 1.0, None)).threshold()
    assert len(times) == 1


def test_the_command_says_what_it_does_and_then_the_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "map.npy", textured("Gaussian", 64).heights)
    command = ["predict", str(tmp_path / "map.npy"), "--size", "64nm", "--unit", "nm", "--estar", "1GPa", "--periodic"]
    command += ["--range", "1nm", "--work", "8mJ/m2", "--probe", "1um", "-o", str(tmp_path)]
    command += ["--pressure", "10MPa", "--json", str(tmp_path / "all.json")]
    assert main(command) == 0
    said = capsys.readouterr()
    assert said.err.startswith("looking at map.npy, 64 x 64 points")
    assert "pressing map.npy without adhesion" in said.err
    assert "threshold found in " in said.err
    assert said.err.index("pressing to more areas") < said.err.index("drawing the figures")
    assert len(said.out.splitlines()) <= 10
    assert said.out.startswith("Sticky")
    for text in (
        "Pull-off stress: ",
        "At 10 MPa ",
        "touch at a mean gap of",
        "Pull-off force of a probe of radius 1 µm: ",
    ):
        assert text in said.out
    for hidden in ("χ", "Müser", "d_rep"):
        assert hidden not in said.out
    told = json.loads((tmp_path / "all.json").read_text())
    assert told["row"]["pressure_Pa"] == 1e7
    assert told["row"]["pull-off stress_Pa"] > 0
    curve = told["adhesion"]
    assert len(curve["area"]) == len(curve["pressure_Pa"]["w"]) == len(curve["mean_gap_m"]["none"])
    # Adhesion lowers the load at each area, and a stronger one more.
    for less, more in (("none", "w_c"), ("w_c", "w"), ("w low", "w high")):
        assert np.all(np.array(curve["pressure_Pa"][less]) >= np.array(curve["pressure_Pa"][more]))
    assert (tmp_path / "map-predict.png").exists()
    assert (tmp_path / "map-predict-load.png").exists()
    assert not [*tmp_path.glob("*.pdf")]  # of which the fonts alone would take a quarter of the time
    assert main([*command, "--no-solve", "--format", "pdf"]) == 0
    assert {path.suffix for path in tmp_path.glob("map-predict.*")} == {".html", ".png", ".pdf"}


@pytest.mark.parametrize(("text", "expected"), [("0", "a unit of length is missing"), ("banana", "not a number")])
def test_a_probe_that_is_none_is_one_message(
    text: str, expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "map.npy", surface(32).heights)
    command = ["predict", str(tmp_path / "map.npy"), "--size", "9.6nm", "--unit", "A", "--material", "silicon"]
    assert main([*command, "--probe", text, "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "--probe " in said
    assert expected in said
    assert not (tmp_path / "out").exists()
