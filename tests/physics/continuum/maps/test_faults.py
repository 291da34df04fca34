"""Maps with one known fault each: it is found, named, and mended, or the verdict is undecided; clean maps have none."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.front.cli import main
from continuum.front.predict import Prediction, of_maps
from continuum.maps import faults
from continuum.maps.faults import LEVELLING, ROUGHENING, directions, find_faults
from continuum.maps.map import Topography, TopographyError
from continuum.maps.mending import Detrending, background, cut_off, detrend, fill_outliers, harmonic
from continuum.maps.reading import read_topography
from continuum.maps.roughness import roughness_of
from continuum.maps.scanlines import scan_lines
from continuum.maps.verdict import threshold
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.prediction import prediction_of
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.show.prediction_data import remedy_options
from continuum.show.prediction_figures import fault_figure
from tests.faulty_maps import FAULTS, PIXEL, clean, cut_out, faulty
from tests.kinds import covering
from tests.printed import faults_in_print

BAND = 1.35
"""A mended map has the threshold of the clean one within this factor.  Lines leave their share of white noise, a
cut-off its share of the surface: up to 15 % in the curvature, of whose power 2/3 thresholds are."""
MENDABLE = ("line noise", "outlier lines", "scars", "spikes", "bow", "tilt", "noise")


INTERFACE = Interface(1e9, 0.05, 1e-9, None)
QUICK = ("scars",)
MEASURED = tuple(kind for kind in FAULTS if kind not in ("slope", "pixel"))
"""Faults with which the surface is still that of the clean map."""
BESIDE = {"tip": ["non-Gaussian heights"], "grooves": ["non-Gaussian heights", "noise"], "height steps": ["noise"]}
"""What else a fault makes: summits that a tip has rounded are no Gaussian's; sharp grooves and steps have all waves."""
"""Faults that are looked for each time; the others in the long run."""


@cache
def pressed(kind: str) -> Prediction:
    """A map with a fault as it was measured, or a clean one, pressed without adhesion."""
    topography = detrend(clean()) if kind == "clean" else as_measured(kind)
    with pytest.MonkeyPatch.context() as patch:
        for name in ("FINEST", "LINEAR"):  # of 512² with mirror images: three points to the shortest wave
            patch.setattr(threshold, name, 256**2)
        return prediction_of([topography], INTERFACE, kind=Prediction).solved(search=False)


def as_measured(kind: str, seed: int = 1) -> Topography:
    return detrend(faulty(kind, seed), "none" if kind == "tilt" else "plane")


@cache
def by_default(kind: str) -> tuple[Prediction, frozenset[faults.Artefact]]:
    """The prediction for a map with a fault, with default arguments, and the artefacts of the registry that found one.

    Nothing is pressed.  A tilt is what the default arguments correct.
    """
    fired = set[faults.Artefact]()

    def watched(artefact: faults.Artefact) -> faults.Artefact:
        def look(topography: Topography, seen: Any) -> faults.MapFault | None:
            found = artefact(topography, seen)
            fired.update([artefact] if found else [])
            return found

        return look

    measured = faulty(kind, seed=2)
    with pytest.MonkeyPatch.context() as patch:
        for name in ("LEVELLING", "ROUGHENING"):
            patch.setattr(faults, name, tuple(tuple(map(watched, stage)) for stage in getattr(faults, name)))
        found = of_maps([np.array(measured.heights)], {
            "size": f"{measured.lengths[0] * 1e9}nm", "unit": "m", "contact_modulus": "1GPa",
            "work": "50mJ/m2", "range": "1nm", "detrend": "none" if kind == "tilt" else None,
        })  # fmt: skip
    return found, frozenset(fired)


@pytest.mark.parametrize("kind", FAULTS)
def test_a_prediction_names_each_fault_by_default(kind: str) -> None:
    found, _ = by_default(kind)
    assert kind in [fault.kind for fault in found.faults]
    # What makes the heights others than those of the surface is said; the tables have what only theories cannot judge.
    told = [one for one in found.faults if one.remedy or one.of_the_heights]
    assert all(any(text in found.sentence for text in (one.kind, one.text)) for one in told)
    assert ("Faulty map: " in found.sentence) is bool(told) or kind in ("slope", "pixel")
    table = str(found.sheets()[0].rows)
    assert all(one.text in table for one in found.faults)


@pytest.mark.parametrize("artefact", [one for stage in (*LEVELLING, *ROUGHENING) for one in stage])
def test_each_artefact_of_the_registry_has_a_map_on_which_a_prediction_finds_it(artefact: faults.Artefact) -> None:
    assert any(artefact in by_default(kind)[1] for kind in FAULTS)


def test_a_tilt_is_corrected_by_default_and_that_is_said() -> None:
    tilted, flat = faulty("tilt"), detrend(clean())
    assert np.abs(detrend(tilted).heights - flat.heights).max() < 1e-9 * np.ptp(tilted.heights)
    assert find_faults(detrend(tilted)).faults == ()
    assert "mean plane taken off" in detrend(tilted).steps[-1]


@pytest.mark.parametrize(("steps", "how"), covering([24, 100], ["plane", "curvature", "lines", "none"]))
def test_equal_heights_are_seen_whatever_is_subtracted(steps: int, how: Detrending) -> None:
    heights = np.array(clean(lambda_s=32.0).heights)
    level = np.ptp(heights) / steps
    stepped = Topography(level * np.round(heights / level), clean().lengths)
    (text,) = (fault.text for fault in find_faults(detrend(stepped, how)).faults if fault.kind == "height steps")
    equal = max(np.mean(np.diff(stepped.heights, axis=axis) == 0) for axis in (0, 1))
    assert text.startswith(f"{100 * equal:.2g} % of neighbouring points")
    assert "height steps" not in [fault.kind for fault in find_faults(detrend(clean(lambda_s=32.0), how)).faults]


@pytest.mark.parametrize(("lambda_s", "hurst"), covering([8.0, 16.0], [0.1, 0.5, 0.9]))
def test_white_noise_beyond_the_cut_off_of_a_surface_is_a_fault_and_the_surface_is_none(
    hurst: float, lambda_s: float
) -> None:
    """0.25 nm on a film of 2 nm; surfaces that are self-affine to the pixel have no noise, either."""
    n, size = 128, (128 * PIXEL, 128 * PIXEL)
    for seed, periodic in ((1, True), (2, False)):
        grid = Grid.square(n if periodic else 2 * n)
        film, fine = (
            SelfAffine(hurst, 0.1, shortest, n / 2).synthesise(grid, np.random.default_rng(seed))[:n, :n]
            for shortest in (lambda_s, 2.0)
        )
        film *= 2e-9 / film.std()
        plain, sharp = (detrend(Topography(one, size, periodic)) for one in (film, PIXEL * fine))
        white = 0.25e-9 * np.random.default_rng(seed + 7).normal(size=(n, n))
        found = find_faults(detrend(Topography(film + white, size, periodic)))
        (noise,) = (fault for fault in found.faults if fault.kind == "noise")
        assert not {"noise"} & {fault.kind for one in (plain, sharp) for fault in find_faults(one).faults}
        # The floor begins where the surface ends, within two of the 8 or 16 rings of the spectrum before it.
        assert noise.remedy["cutoff"] == pytest.approx(lambda_s * PIXEL, rel=0.15)
        assert found.mended is not None
        mended, true = roughness_of(found.mended).moments, roughness_of(plain).moments
        # What is left is noise in the waves of the surface, and what two rings less take off: up to 1 and 3 % here.
        assert mended.rms_slope == pytest.approx(true.rms_slope, rel=0.03)
        assert mended.rms_curvature == pytest.approx(true.rms_curvature, rel=0.06)


@pytest.mark.parametrize(
    "kind", [kind if kind in QUICK else pytest.param(kind, marks=pytest.mark.long) for kind in MEASURED]
)
def test_a_fault_is_found_and_the_verdict_is_that_of_the_clean_map_or_none(kind: str) -> None:
    kinds = {kind, *BESIDE.get(kind, [])}
    assert {fault.kind for fault in find_faults(as_measured(kind, seed=2)).faults} == kinds
    found, right = pressed(kind), pressed("clean").threshold
    assert {fault.kind for fault in found.faults} == kinds
    assert right is not None
    assert found.threshold is not None
    for work in (0.03 * right.work, 5.0 * right.work):  # far from the threshold
        other = replace(found, contact=replace(found.contact, work_of_adhesion=work))
        verdict = other.verdict
        assert verdict.answer in ("sticky" if work > right.work else "not sticky", "undecided")
        assert verdict.answer != "undecided" or verdict.why
    if kind in MENDABLE:
        assert 1 / BAND < found.threshold.work / right.work < BAND


@pytest.mark.long
def test_the_remedy_that_is_named_mends(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kind, measured = "line noise", faulty("line noise")
    np.save(tmp_path / "map.npy", measured.heights * 1e9)
    remedy = [word for fault in find_faults(as_measured(kind)).faults for word in remedy_options(fault).split()]
    command = ["predict", str(tmp_path / "map.npy"), "--size", f"{measured.lengths[0] * 1e9}nm", "-o", str(tmp_path)]
    command += ["--no-solve", "--unit", "nm", "--estar", "1GPa", "--work", "50mJ/m2", "--range", "1nm"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "Faulty map" in said
    assert " ".join(remedy) in said
    assert (tmp_path / "map-predict-faults.png").exists()
    assert main([*command, *remedy]) == 0
    assert "Faulty map" not in capsys.readouterr().out


def test_clean_maps_are_hardly_ever_faulty() -> None:
    found = []
    for hurst in (0.3, 0.8):
        for lambda_s in (2.0, 16.0):
            for lambda_l in (64.0, 512.0):
                for seed in range(2):
                    heights = cut_out(hurst, lambda_s, lambda_l, seed) * PIXEL
                    topography = detrend(Topography(heights, (256 * PIXEL, 256 * PIXEL)))
                    found += [fault.kind for fault in find_faults(topography).faults]
    # Of 16 maps, 2 are of one surface whose longest wave is twice the map: to the map it is a bow.
    assert len(found) <= 3
    assert len([kind for kind in found if kind != "bow"]) <= 1


def test_scars_and_lines_are_found_where_they_are() -> None:
    heights, rng = cut_out(), np.random.default_rng(4)
    true = np.zeros(heights.shape, dtype=bool)
    for _ in range(12):
        i, j = rng.integers(0, 150), rng.integers(2, 250)
        true[i : i + 60, j] = True
    scarred = heights + true * 4.0
    found = scan_lines(scarred)
    assert found.axis == 0
    assert np.count_nonzero(found.scars & true) > 0.95 * np.count_nonzero(true)
    assert np.count_nonzero(found.scars) < 1.3 * np.count_nonzero(true)  # their ends are taken a little long
    assert scan_lines(scarred.T).axis == 1
    displaced = heights.copy()
    displaced[[40, 41, 200]] += 4.0
    assert scan_lines(displaced).axis == 1
    # Of two lines beside each other one of the edges is named.
    assert set(scan_lines(displaced).outliers) <= {39, 40, 41, 42, 200}
    assert 200 in scan_lines(displaced).outliers


@pytest.mark.parametrize("noise", [0.05, 0.5])
def test_the_noise_of_lines_is_measured(noise: float) -> None:
    heights = cut_out() + noise * np.random.default_rng(5).normal(size=(1, 256))
    found = scan_lines(heights)
    assert found.axis == 0
    assert found.independent
    # A median of 256 lines scatters by 6 %; what the surface adds is taken off in the mean only.
    assert found.noise == pytest.approx(noise, rel=0.25)


def test_the_slope_that_lines_make_is_said_in_per_cent() -> None:
    """Independent offsets of variance s² make a mean square slope of 2 s²/Δ² across them."""
    ratios = []
    for seed in range(3):
        lines = 0.1 * np.random.default_rng(5 + seed).normal(size=(1, 256))
        heights = cut_out(seed=seed) + lines
        made = np.mean(np.diff(lines) ** 2) / np.mean(np.diff(heights, axis=1) ** 2)
        (text,) = (
            fault.text
            for fault in find_faults(Topography(PIXEL * heights, (256 * PIXEL, 256 * PIXEL))).faults
            if fault.kind == "line noise"
        )
        ratios.append(float(text.split(" % of the mean square slope")[0].split()[-1]) / 100 / made)
    # Each share goes with the square of a noise that scatters by 6 %: the mean of three by 7 %.
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.2)


def test_the_radius_of_a_tip_is_found() -> None:
    text = next(fault.text for fault in find_faults(as_measured("tip")).faults if fault.kind == "tip")
    radius = float(text.split(" nm")[0].split()[-1])
    assert radius == pytest.approx(100, rel=0.25)


@given(st.floats(1.0, 4.0), st.floats(-80, 80))
def test_the_anisotropy_of_waves_is_their_ratio(ratio: float, angle: float) -> None:
    x, y = np.mgrid[:128, :128] * 2 * np.pi / 128
    # Two waves of one length at right angles, the second weaker; the pair is turned by whole waves of the map.
    m, n = (int(np.rint(8 * f(np.radians(angle)))) for f in (np.cos, np.sin))
    heights = np.cos(m * x + n * y) + np.cos(-n * x + m * y + 1) / ratio
    by = directions(Topography(heights, (128.0, 128.0)))
    # Differences, and their means over a cell, see waves of 16 points a few percent too small, diagonal ones less so.
    assert by.anisotropy == pytest.approx(ratio, rel=0.1)
    if ratio > 1.5 and m * n:
        assert np.degrees(np.arctan(n / m)) == pytest.approx(by.angle, abs=5)


@given(st.integers(0, 1000))
def test_a_harmonic_film_lies_between_its_edges(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = np.mgrid[:20, :24].astype(float)
    holes = rng.random((20, 24)) < rng.uniform(0.01, 0.4)
    holes[0, 0] = False
    # Laplace's equation on the inside: a plane there is its own film; the map's edges are free.
    inner = holes.copy()
    inner[[0, -1]] = inner[:, [0, -1]] = False
    plane = 0.3 * x - 0.2 * y + x * y / 50
    np.testing.assert_allclose(harmonic(np.where(inner, np.nan, plane), inner), plane, atol=1e-9)
    rough = rng.normal(size=(20, 24))
    filled = harmonic(np.where(holes, np.nan, rough), holes)
    known = rough[~holes]
    assert known.min() - 1e-12 <= filled.min() <= filled.max() <= known.max() + 1e-12
    np.testing.assert_array_equal(filled[~holes], known)


def test_a_bow_leaves_no_trace() -> None:
    base = clean()
    x, y = np.meshgrid(*(np.linspace(-1, 1, n) for n in base.heights.shape), indexing="ij")
    bowed = base.after(base.heights + 1e-8 * (x**2 - 0.4 * y**2 + 0.3 * x * y + x), "bow")
    flat = detrend(base, "curvature").heights
    np.testing.assert_allclose(detrend(bowed, "curvature").heights, flat, atol=1e-20)
    fitted, slopes = background(bowed, 1)
    assert np.ptp(fitted) > 0
    assert slopes[0] > 0


def test_a_cut_off_takes_the_short_waves_of_a_measured_map() -> None:
    fine, whole = detrend(clean(lambda_s=4.0)), roughness_of(detrend(clean(lambda_s=4.0)))
    smooth = cut_off(fine, 10 * PIXEL)
    # Heights of the map and its mirror images; the edges have no part in the long waves.
    expected = whole.cut(10 * PIXEL).moments
    assert roughness_of(smooth).moments.rms_slope == pytest.approx(expected.rms_slope, rel=0.05)
    # The window, whose spectrum gives the expected value, and differences weigh the parts of a map differently.
    assert roughness_of(smooth).moments.rms_curvature == pytest.approx(expected.rms_curvature, rel=0.12)
    assert "left out" in smooth.steps[-1]
    for wavelength in (PIXEL, 1.0):
        with pytest.raises(TopographyError, match="between two pixels and half"):
            cut_off(fine, wavelength)


def test_more_than_allowed_is_not_filled() -> None:
    scarred = as_measured("scars")
    with pytest.raises(TopographyError, match="`fill` allows"):
        fill_outliers(scarred, 1e-3)
    assert fill_outliers(detrend(clean()), 1e-3).steps == detrend(clean()).steps


def test_a_map_with_holes_is_read_filled_or_cut(tmp_path: Path) -> None:
    base = clean()
    heights = np.array(base.heights)
    heights[100, 100:103] = np.nan
    np.save(tmp_path / "map.npy", heights)
    whole = read_topography(tmp_path / "map.npy", size=base.lengths, unit=1.0, fill=0.01)
    # Three points in the middle of a surface of waves above six.
    assert np.abs(whole.heights - base.heights).max() < 0.3 * base.heights.std()
    part = read_topography(
        tmp_path / "map.npy", size=base.lengths, unit=1.0, corners=(0.0, 100 * PIXEL, 0.0, 256 * PIXEL)
    )
    np.testing.assert_array_equal(part.heights, base.heights[:100])
    assert part.lengths == pytest.approx((100 * PIXEL, 256 * PIXEL))


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], "800 of 65536 heights are missing, 1.22 %: --fill 2% fills them, or --crop cuts out a part that has all"),
        (["--fill", "0.001%"], "--fill allows"),
        (["--fill", "lots"], "largest share"),
        (["--fill", "90%"], "at most 50%"),
        (["--crop", "0,1um"], "four lengths"),
        (["--crop", "0,1,0,1nm"], "a unit of length is missing"),
        (["--crop", "0,2um,0,1um"], "inside 1.02 µm"),
        (["--crop", "200nm,100nm,0,1um"], "ends after that"),
        (["--fill", "5%", "--cutoff", "7"], "--cutoff '7'"),
        (["--fill", "5%", "--cutoff", "1nm"], "between two pixels"),
    ],
)
def test_holes_are_filled_or_cut_only_as_asked(
    options: list[str], expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = clean()
    heights = np.array(base.heights)
    heights[100:110, 100:180] = np.nan
    np.save(tmp_path / "map.npy", heights)
    command = ["predict", str(tmp_path / "map.npy"), "-o", str(tmp_path / "out")]
    command += ["--no-solve", "--size", "1024nm", "--unit", "m", "--material", "mica"]
    assert main([*command, *options]) == 2
    assert expected in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_figure_of_faults_marks_the_lines_and_can_be_printed() -> None:
    figure = fault_figure(by_default("outlier lines")[0])
    assert len(figure.axes[0].lines) > 1
    assert faults_in_print(figure) == []
