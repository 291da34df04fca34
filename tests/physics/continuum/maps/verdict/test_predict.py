"""Is it sticky: known verdicts, the same in all units, the same from solver and theory; faults; the report."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import docs.materials
from continuum.front.cli import main
from continuum.front.predict import Prediction
from continuum.maps.map import Topography
from continuum.maps.mending import detrend
from continuum.maps.reading import read_all, read_topography
from continuum.maps.verdict.materials import (
    Body,
    Interface,
    InterfaceError,
    interface,
    materials,
    read_interface,
    reduced_modulus,
)
from continuum.maps.verdict.on_grid import UnresolvedError, check_resolved, shortest_range
from continuum.maps.verdict.prediction import prediction_of
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.model.walls import InversePowers
from continuum.model.walls.attraction import attraction_on_core
from continuum.show.prediction_figures import overview
from tests.measured import AFM, MEASURED, needs_files, needs_reader
from tests.printed import faults_in_print

ROOT = Path(__file__).parents[5]


def surface(n: int = 64, seed: int = 1, lambda_s: float = 8.0, slope: float = 0.1) -> Topography:
    """Reduced units: a0 = 1."""
    grid = Grid.square(n)
    heights = SelfAffine(0.8, slope, lambda_s, n / 2).synthesise(grid, np.random.default_rng(seed))
    return Topography(heights, grid.lengths, periodic=True)


def reduced(adhesion_length: float, range: float = 0.35) -> Interface:
    return Interface(1.0, adhesion_length, range, 1.0)


# --- verdicts ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("adhesion_length", "sticky"), [(5e-4, False), (0.05, True)])
def test_a_surface_of_known_moments_has_the_verdict_worked_out_by_hand(adhesion_length: float, sticky: bool) -> None:
    found = prediction_of([surface()], reduced(adhesion_length))
    slope, curvature = found.roughness.moments[1:]
    assert slope == pytest.approx(0.1)
    # Eq. (6), typed here a second time to be independent.
    left = slope * 0.35 / (2 * adhesion_length) * (slope**2 / curvature / 0.35) ** (2 / 3)
    assert found.paper.margin == pytest.approx(np.pi * (3 / 16) ** (2 / 3) / left)
    assert found.paper.sticky is sticky
    assert (found.kappa < 0) is sticky
    assert (found.load < 0) is sticky


def test_at_the_threshold_of_each_theory_its_verdict_changes() -> None:
    topography = surface()
    found = prediction_of([topography], Interface(1.0, 0.003, 0.35, 1.0))
    for i, estimate in enumerate(found.verdicts):
        work = estimate.threshold_work(found.contact)
        assert estimate.margin is not None
        assert work is not None
        modulus = found.contact.contact_modulus * estimate.margin
        for factor, sticky in ((0.99, True), (1.01, False)):
            assert (
                prediction_of([topography], Interface(factor * modulus, 0.003, 0.35, 1.0)).verdicts[i].sticky is sticky
            )
            assert prediction_of([topography], Interface(1.0, work / factor, 0.35, 1.0)).verdicts[i].sticky is sticky


exponents = st.floats(-12, 12)


@settings(max_examples=15)
@given(exponents, exponents, st.booleans())
def test_the_verdict_is_the_same_in_all_units(length: float, pressure: float, periodic: bool) -> None:
    base, unit, stress = surface(32), 10.0**length, 10.0**pressure
    small = Topography(base.heights, base.lengths, periodic)
    large = Topography(unit * base.heights, (unit * base.lengths[0], unit * base.lengths[1]), periodic)
    one = prediction_of([small], Interface(1.0, 0.002, 0.35, 1.0))
    other = prediction_of([large], Interface(stress, 0.002 * stress * unit, 0.35 * unit, unit))
    powers = {"": 1.0, "length": unit, "pressure": stress}
    for mine, same in zip(one.estimates, other.estimates, strict=True):
        assert same.value == pytest.approx(powers[mine.unit] * mine.value, rel=1e-6), mine.name
        assert same.sticky == mine.sticky
        assert same.valid == mine.valid
    assert len(one.warnings) == len(other.warnings)


def test_text_in_si_and_in_other_units_gives_the_verdict_of_reduced_units(tmp_path: Path) -> None:
    base = surface()
    np.save(tmp_path / "nm.npy", 0.3 * base.heights)
    np.save(tmp_path / "m.npy", 0.3e-9 * base.heights)
    # 0.015 J/m² over 10 GPa x 0.3 nm: l_a = 0.005 a0.
    expected = prediction_of([base], reduced(0.005))
    for name, size, unit, modulus, work, reach in (
        ("nm", "19.2nm", "nm", "10GPa", "15mJ/m2", "0.105nm"),
        ("m", "1.92e-8 m", "m", "1e4 MPa", "0.015 N/m", "1.05 Å"),
    ):
        maps = read_all([tmp_path / f"{name}.npy"], size=[size], unit=[unit], periodic=True)
        contact = read_interface(contact_modulus=modulus, work=work, range=reach, spacing="3 Å")
        found = prediction_of([detrend(topography) for topography in maps], contact)
        assert [e.margin for e in found.verdicts] == pytest.approx([e.margin for e in expected.verdicts])
        assert [e.sticky for e in found.verdicts] == [e.sticky for e in expected.verdicts]
        assert found.kappa == pytest.approx(expected.kappa)


@pytest.mark.parametrize(
    ("pattern", "periodic"),
    [
        ("spike", False),
        ("checkerboard", True),
        *(
            pytest.param(one, periodic, marks=pytest.mark.long)
            for one in ("stripes", "step", "steps of a digitiser")
            for periodic in (True, False)
        ),
    ],
)
def test_no_map_is_too_odd_for_a_page(pattern: str, periodic: bool) -> None:
    x, y = np.mgrid[:32, :40]
    heights = {
        "spike": (x == 5) & (y == 6),
        "checkerboard": (x + y) % 2,
        "stripes": x % 2,
        "step": x > 15,
        "steps of a digitiser": np.random.default_rng(0).integers(0, 5, (32, 40)),
    }[pattern]
    topography = detrend(Topography(1e-9 * heights, (1e-6, 2e-6), periodic))
    found = prediction_of([topography], interface([Body(material=materials()["mica"])]))
    assert all(np.isfinite(row.value) for row in found.estimates)
    assert faults_in_print(overview(found)) == []


def test_two_rough_bodies_stick_less_than_one() -> None:
    one, two = surface(seed=1), surface(seed=2)
    single, both = prediction_of([one], reduced(0.005)), prediction_of([one, two], reduced(0.005))
    assert both.contact.rms_slope == pytest.approx(np.sqrt(0.02))
    assert (both.paper.margin or 0) < (single.paper.margin or 0)
    with pytest.raises(ValueError, match="one or two"):
        prediction_of([one, one, two], reduced(0.005))


def test_what_to_doubt_is_said() -> None:
    coarse, cut = surface(lambda_s=3.0), surface(n=128, lambda_s=16.0)
    assert any("resolution" in w for w in prediction_of([coarse], reduced(0.005)).warnings)
    fine = prediction_of([cut], reduced(0.005, range=2.0)).warnings
    assert not any("resolution" in w or "not periodic" in w or "larger than the range" in w for w in fine)
    assert any("single summits" in w for w in fine)
    assert not any("single summits" in w for w in prediction_of([surface(256, lambda_s=4.0)], reduced(0.005)).warnings)
    open_map = detrend(Topography(cut.heights, cut.lengths))
    said = prediction_of([open_map], reduced(0.005))
    assert not any("Hann" in w for w in said.doubts)  # no remark that every map would have
    assert any("larger than the range" in w for w in said.doubts)


@pytest.mark.parametrize(("work", "answer", "told"), [(5e-5, "not sticky", False), (0.5, "sticky", True)])
def test_remarks_are_in_units_of_the_map_and_of_answers_that_they_can_change(
    work: float, answer: str, told: bool
) -> None:
    coarse = surface(lambda_s=3.0)
    open_map = detrend(Topography(1e-9 * coarse.heights, (64e-9, 64e-9)))
    found = prediction_of([open_map], Interface(1e9, work, 0.35e-9, 1e-9)).solved(search=False)
    assert found.verdict.answer == answer
    assert any("roughness between the points" in text for text in found.doubts) is told
    assert any("measure with smaller pixels" in text for text in found.doubts)
    assert not any(word in text for text in found.doubts for word in ("a0", "grid", "d_rep"))


# --- materials ---------------------------------------------------------------------------------------------


KNOWN_WORK = [name for name, one in materials().items() if one.work_of_adhesion is not None]


def test_every_material_names_its_sources_and_makes_a_contact() -> None:
    assert len(materials()) >= 30
    assert 15 <= len(KNOWN_WORK) < len(materials())
    for name, material in materials().items():
        assert name == material.name
        text = " ".join(material.sources)
        for quantity in ("E", "range") if material.work_of_adhesion is None else ("E", "w", "range"):
            assert re.search(rf"\b{quantity}\b", text), (name, quantity)
        # A year in a reference, a standard table, or the data sheet of a glass.
        assert re.search(r"\(\d{4}\)|Kaye and Laby|CRC Handbook|Callister|data sheet", text), name
        contact = read_interface(material=[name], work="1 mJ/m2")
        assert contact.contact_modulus == pytest.approx(material.plane_strain_modulus)
        isotropic = material.modulus / (1 - material.poisson**2)
        assert material.plane_strain_modulus == pytest.approx(
            isotropic, rel=1e-12 if material.contact_modulus is None else 0.4
        )
    # The range between atoms at 0.3 nm is that of the 9-3 law.
    assert materials()["diamond"].range == pytest.approx(0.3e-9 * InversePowers((9, 3), 1.0).effective_range, rel=0.02)


@pytest.mark.parametrize(
    ("name", "face", "along"),
    [
        ("silicon", 164.8e9, 141.0e9),
        ("germanium", 131.4e9, 110.4e9),
        ("gallium-arsenide", 117.4e9, 94.5e9),
        ("graphite", 27.0e9, 38.7e9),
        ("mica", 55.8e9, 54.4e9),
    ],
)
def test_a_crystal_is_pressed_on_its_face(name: str, face: float, along: float) -> None:
    """Which is not E/(1 - ν²) along its normal; a modulus that is given replaces the crystal by an isotropic solid."""
    crystal = materials()[name]
    assert Body(material=crystal).plane_strain_modulus == pytest.approx(face, rel=2e-3)  # as many digits
    assert Body(crystal.modulus, material=crystal).plane_strain_modulus == pytest.approx(along, rel=2e-3)
    assert Body(crystal.modulus, crystal.poisson).plane_strain_modulus == pytest.approx(along, rel=2e-3)


def test_the_page_has_the_table_of_materials() -> None:
    page = docs.materials.table()
    rows = dict(re.findall(r"^\| `([\w-]+)` \| (.+) \|$", page, re.MULTILINE))
    assert set(rows) == set(materials()) == set(re.findall(r"^\* `([\w-]+)`: \S", page, re.MULTILINE))
    assert rows["silica"] == "72.7 GPa | 0.16 | 74.6 GPa | 63.3 mJ/m² | 0.35 nm"
    assert rows["silicon"] == "130 GPa | 0.278 | 165 GPa | 100 mJ/m² | 0.35 nm"
    assert rows["ta-c"] == "572 GPa | 0.12 | 580 GPa | - | 0.35 nm"


def test_van_der_waals_forces_give_the_surface_energies_that_were_measured() -> None:
    """Israelachvili's cut-off: the Hamaker constant of PTFE, 3.8e-20 J, is worth 18.5 mJ/m², 18.3 were measured."""
    silica = materials()["silica"].work_of_adhesion
    assert silica is not None
    assert silica / 2 * 3.8 / 6.5 == pytest.approx(18.3e-3, rel=0.02)


@pytest.mark.parametrize("names", [["steel"], ["steel", "ptfe"], ["ptfe", "steel"], ["gold", "gold"]])
def test_a_work_of_adhesion_without_a_source_is_asked_for(names: list[str]) -> None:
    of = names[0] if len(names) == 1 else f"the pair {names[0]}, {names[1]}"
    with pytest.raises(InterfaceError, match=rf"^no work of adhesion is known for {of}: give `work`$"):
        read_interface(material=names)
    assert read_interface(material=names, work="30mJ/m2").work_of_adhesion == pytest.approx(0.03)


def test_two_bodies_have_their_compliances_added() -> None:
    silicon, pdms = Body(material=materials()["silicon"]), Body(material=materials()["pdms"])
    one, other = silicon.plane_strain_modulus, pdms.plane_strain_modulus
    assert one is not None
    assert other is not None
    both = interface([silicon, pdms])
    assert 1 / both.contact_modulus == pytest.approx(1 / one + 1 / other)
    assert reduced_modulus([one, one]) == pytest.approx(one / 2)
    assert both.work_of_adhesion == pytest.approx(np.sqrt(0.1 * 2 * 0.0226))
    assert both.spacing is None
    assert any("geometric mean" in line for line in both.origin)
    given_modulus = read_interface(modulus=["1GPa"], poisson=["0.5"], work="50mJ/m2", range="0.5nm")
    assert given_modulus.contact_modulus == pytest.approx(4 / 3 * 1e9)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, ["contact modulus", "work of adhesion", "range"]),
        ({"material": ["granite"]}, ["'granite' is unknown", "diamond"]),
        ({"material": ["Alumnium"]}, ["'Alumnium' is unknown: did you mean aluminium?"]),
        ({"material": ["steel", "ptfe"]}, ["no work of adhesion is known for the pair steel, ptfe: give `work`"]),
        ({"modulus": ["70GPa"], "work": "1J/m2", "range": "1nm"}, ["`poisson`"]),
        ({"modulus": ["70"], "poisson": ["0.3"], "work": "50", "range": "0.5nN"}, ["`modulus`", "`work`", "`range`"]),
        ({"modulus": ["70GPa"], "poisson": ["0.6"], "work": "1J/m2", "range": "1nm"}, ["at most 0.5"]),
        ({"modulus": ["70GPa"], "poisson": ["x"], "work": "1J/m2", "range": "1nm"}, ["not a number"]),
        ({"contact_modulus": "1GPa", "modulus": ["1GPa"], "poisson": ["0.1"]}, ["given twice"]),
        ({"contact_modulus": "1J/m2", "material": ["mica"]}, ["not a unit of pressure"]),
        ({"contact_modulus": "0GPa", "material": ["mica"]}, ["positive"]),
        ({"work": "1e300J/m2", "range": "1km", "material": ["mica"]}, ["`work`", "possible are", "`range`"]),
        (
            {"work": "1e300J/m2", "range": "1m", "material": ["mica"]},
            ["`work`", "`range` '1m'", "possible are 1 pm to 1 mm"],
        ),
        ({"material": ["mica"] * 3}, ["two bodies"]),
        ({"material": ["mica"], "pressure": "1MPa", "load": "1mN"}, ["give one of them"]),
        ({"material": ["mica"], "pressure": "1mN"}, ["`pressure`", "not a unit of pressure"]),
    ],
)
def test_a_contact_that_is_not_described_is_refused_with_all_faults(
    options: dict[str, Any], expected: list[str]
) -> None:
    with pytest.raises(InterfaceError) as error:
        read_interface(**options)
    for text in expected:
        assert text in str(error.value)


# --- the command and its report ----------------------------------------------------------------------------


@pytest.mark.long
def test_the_report_needs_no_other_file_and_is_the_same_twice(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "<map> & co.npy"
    np.save(path, surface(32).heights)
    command = [
        "predict",
        str(path),
        str(path),
        "--size",
        "9.6nm",
        "--unit",
        "A",
        "--material",
        "silicon",
        "--solve",
        "-v",
    ]
    assert main([*command, "-o", str(tmp_path / "a")]) == 0
    said = "".join(capsys.readouterr())
    assert main([*command, "-o", str(tmp_path / "b")]) == 0
    pages = [next((tmp_path / folder).glob("*.html")).read_text() for folder in "ab"]
    assert pages[0] == pages[1]
    sources = re.findall(r'src="([^"]{0,30})', pages[0])
    assert len(sources) == 2
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert "http" not in pages[0]
    assert "<script" not in pages[0]
    assert "&lt;map&gt; &amp; co" in pages[0]
    assert "<map>" not in pages[0]
    for text in ("Pastewka-Robbins", "Persson-Tosatti", "not periodic", "olved on the map", "Spierings"):
        assert text in pages[0]
        assert text in said


def test_on_soft_solids_the_limit_of_jkr_is_searched_for_and_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(tmp_path / "map.npy", surface(64, lambda_s=16.0, slope=0.4).heights)
    command = ["predict", str(tmp_path / "map.npy"), "--size", "64um", "--unit", "um", "--periodic", "--solve"]
    command += ["--modulus", "2MPa", "--poisson", "0.5", "--work", "50mJ/m2", "--range", "0.5nm", "-o", str(tmp_path)]
    assert main([*command, "--json", str(tmp_path / "all.json")]) == 0
    assert "searching for the threshold" in capsys.readouterr().err
    found = json.loads((tmp_path / "all.json").read_text())
    assert found["interface"]["range"] == 0.5e-9
    spectrum = found["maps"][0]["spectrum"]
    assert len(spectrum["C_m4"]) == len(spectrum["q_1/m"]) == 32
    assert any("the limit of Johnson, Kendall and Roberts" in warning for warning in found["warnings"])


def test_the_shortest_range_that_pixels_resolve_snaps_above_two_of_them() -> None:
    topography = surface(64, slope=0.4)
    reach = shortest_range(topography, 0.02)
    wall = attraction_on_core("spline", 0.02 / reach, 1.0, 5 * reach)
    snaps = np.pi / wall.largest_softening * reach
    assert snaps == pytest.approx(2.0, rel=0.02)  # the table follows the law to 1 %
    with pytest.raises(UnresolvedError, match="too coarse"):
        check_resolved(surface(32), shortest_range(surface(32), 10.0))


@pytest.mark.usefixtures("unpressed")
def test_many_files_are_one_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in "ab":
        np.save(tmp_path / f"{name}.npy", surface(32).heights)
    np.save(tmp_path / "bad.npy", np.full((32, 32), np.nan))
    files = [str(tmp_path / f"{name}.npy") for name in ("a", "b", "bad")]
    command = ["predict", *files, "--size", "10nm", "--unit", "A", "--material", "silicon"]
    assert main([*command, "--csv", str(tmp_path / "all.csv")]) == 1
    capsys.readouterr()
    rows = list(csv.DictReader((tmp_path / "all.csv").read_text().splitlines()))
    assert [Path(row["map"]).name for row in rows] == ["a.npy", "b.npy", "bad.npy"]
    assert rows[0]["verdict"] == rows[1]["verdict"] != ""
    assert float(rows[0]["rms_slope"]) == float(rows[1]["rms_slope"]) > 0
    assert "missing" in rows[2]["error"]
    before = (tmp_path / "a.npy").read_bytes()
    assert main([*command[:2], *command[4:], "--csv", files[0]]) == 2
    assert main([*command[:3], *command[4:], "--csv", str(tmp_path / "good.csv")]) == 0
    assert main([*command, "--join", "--csv", str(tmp_path / "joined.csv")]) == 2
    assert not (tmp_path / "joined.csv").exists()
    assert (tmp_path / "a.npy").read_bytes() == before


def test_a_folder_that_cannot_be_written_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "map.npy", surface(32).heights)
    command = ["predict", str(tmp_path / "map.npy"), "--size", "3um", "--unit", "nm", "--material", "mica"]
    assert main([*command, "-o", str(tmp_path / "map.npy" / "below")]) == 2
    assert "cannot make a folder for results" in capsys.readouterr().err


def test_the_page_does_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    code = re.search(r"```python\n(.*?)```", (ROOT / "docs" / "predict.md").read_text(), re.DOTALL)
    assert code is not None
    exec(code[1], {})
    said = capsys.readouterr().out
    assert "Pastewka-Robbins" in said
    assert "UnderAdhesion" in said


def test_every_table_is_rectangular_and_every_verdict_is_in_it() -> None:
    found = prediction_of([surface()], reduced(0.005), kind=Prediction)
    tables = found.sheets()
    for table in tables:
        assert {len(row) for row in table.rows} == {len(table.head)}
    theories = next(table for table in tables if table.title.startswith("Theories"))
    assert {estimate.name for estimate in found.verdicts} <= {row[0] for row in theories.rows}


@needs_reader
@needs_files
@pytest.mark.parametrize(
    ("name", "part", "material", "slope", "sticky"),
    [
        ("mi-1.mi", None, "silicon", 0.022, False),
        ("mi-1.mi", None, "pdms", 0.022, True),
        ("container-2.zip", AFM, "diamond", 0.2485, False),
        ("container-2.zip", AFM, "pdms", 0.2485, True),
    ],
)
def test_measured_maps_have_their_published_slope_and_a_verdict(
    name: str, part: str | None, material: str, slope: float, sticky: bool
) -> None:
    found: Prediction = prediction_of(
        [detrend(read_topography(MEASURED / name, part=part))], interface([Body(material=materials()[material])])
    )
    assert found.roughness.moments.rms_slope == pytest.approx(slope, rel=0.01)  # as many digits as are published
    assert found.paper.sticky is sticky
    assert found.solved(search=False).verdict.answer in ("undecided", "sticky" if sticky else "not sticky")
    assert {"noise", "line noise"} & {fault.kind for fault in found.faults}
