"""The answer is at most ten lines whatever is known, and its tables, figure and files say the same."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum
import continuum.front.cli
from continuum.front.predict import Prediction
from continuum.maps import faults
from continuum.maps.faults import NOT_GAUSSIAN, MapFault
from continuum.maps.map import Topography
from continuum.maps.verdict.adhesion import ProbePullOff
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.prediction import prediction_of
from continuum.maps.verdict.threshold import RANGES, Basis, MapThreshold, RangePoint
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.show.answer import _range_and_heights, statements, times, verdict_axis
from continuum.show.prediction_data import row
from continuum.show.prediction_figures import overview

NANO = 1e-9
INTERFACE = Interface(1e9, 0.05, 0.5 * NANO, 0.3 * NANO, probe=1e-5)


def surface(seed: int = 1) -> Topography:
    grid = Grid.square(32)
    heights = SelfAffine(0.8, 0.1, 8.0, 16.0).synthesise(grid, np.random.default_rng(seed))
    return Topography(NANO * heights, (32 * NANO, 32 * NANO), periodic=True)


PREDICTED = prediction_of([surface()], INTERFACE, kind=Prediction)
SOLVED = PREDICTED.solved()


def known(work: float, low: float, high: float, source: Basis = Basis.STATE, **more: object) -> MapThreshold:
    """A threshold in units of the given work of adhesion, alike at all ranges."""
    w = INTERFACE.work_of_adhesion
    curve = tuple(RangePoint(reach, work * w, low * w, high * w) for reach in RANGES)
    grid = Grid.square(32)
    given: dict[str, object] = {
        "work": work * w, "low": low * w, "high": high * w, "source": source, "range": 0.5 * NANO, "curve": curve,
        "gap": np.ones(grid.shape), "wall": LennardJonesSpline(0.1), "grid": grid,
        "map": Grid.square(32), "warnings": (),
    }  # fmt: skip
    return MapThreshold(**(given | more))


def with_threshold(*bounds: float, **more: object) -> Prediction:
    return replace(PREDICTED, threshold=known(*bounds, **more))


@pytest.mark.parametrize(
    ("bounds", "first", "third"),
    [
        ((0.5, 0.4, 0.55), "Sticky: w is 2 times the threshold, which is known to 25 %", "It would not be sticky with "
         "w below 25 mJ/m², E* above 2 GPa, or heights and slopes 1.4 times as large"),
        ((4.0, 3.8, 4.2), "Not sticky: w is 0.25 times the threshold, which is known to 5 %", "It would be sticky with "
         "w above 200 mJ/m², E* below 250 MPa, or heights and slopes 0.5 times as large"),
        ((2.0, 1.5, np.inf), "Not sticky: w is 0.5 times the threshold, which is at least 75 mJ/m²", None),
        ((0.5, 0.0, 0.8), "Sticky: w is 2 times the threshold, which is at most 40 mJ/m²", None),
        ((6.0, 2.0, 7.0), "Not sticky: w is 0.17 times the threshold, which is known to a factor of 3", None),
        ((1.0, 0.9, 1.1), "Undecided: w = 50 mJ/m² lies between 45 mJ/m² and 55 mJ/m²",
         "It would be not sticky with w below 45 mJ/m², sticky with w above 55 mJ/m²"),
        ((1.0, 0.0, np.inf), "Undecided: w = 50 mJ/m² lies between ", "It would be "),
    ],
)  # fmt: skip
def test_the_answer_its_factor_and_what_would_change_it(
    bounds: tuple[float, ...], first: str, third: str | None
) -> None:
    said = statements(with_threshold(*bounds))
    assert said[0].startswith(first)
    # Before it may stand that the map says little of its surface.
    assert third is None or any(one.startswith(third) for one in said[2:])


@given(st.floats(0.2, 5.0), st.floats(0.3, 3.0))
def test_a_change_that_is_said_changes_the_answer(power: float, share: float) -> None:
    """Under w_c = c range^-power, range and heights at which w_c is w are known: s^(2 + power) = w/w_c."""
    reach = 0.5 * NANO
    curve = [(one, (one / reach) ** -power) for one in np.geomspace(1e-11, 1e-7, 400)]
    threshold = known(1.0, 0.9, 1.1, curve=tuple(RangePoint(one, w, w, w) for one, w in curve))
    there, heights = _range_and_heights(replace(threshold, work=1.0), share, reach)
    assert heights == pytest.approx(share ** (1 / (2 + power)), rel=1e-6)
    expected = reach * share ** (-1 / power)
    if 1e-11 < expected < 1e-7 and abs(np.log(share)) > 1e-6:
        assert there == pytest.approx(expected, rel=1e-6)


def test_a_range_that_no_point_of_the_curve_needs_is_left_out() -> None:
    assert _range_and_heights(known(2.0, 1.9, 2.1), 1.0, 0.5 * NANO)[0] is None
    alone = known(2.0, 1.9, 2.1, curve=())
    assert _range_and_heights(alone, alone.work / 4, 0.5 * NANO) == (None, None)  # nor heights without a known range


@given(st.floats(1e-12, 1e12))
def test_a_factor_is_never_said_to_be_one_where_it_is_not_nearly(ratio: float) -> None:
    assert float(times(ratio)) == pytest.approx(ratio, rel=0.051)
    assert times(ratio) != "1" or abs(ratio - 1) < 0.006


ARTEFACTS = [artefact for stage in (*faults.LEVELLING, *faults.ROUGHENING) for artefact in stage]
EVERY_FAULT = tuple(
    MapFault(f"fault {i}", f"fault {i}, 1.2 % of the points", {"fill": "5%"} if i % 2 else {}, of_the_heights=True)
    for i in range(len(ARTEFACTS))
)
PULL = ProbePullOff(1e-5, 1e-6, 2e-6, 0.03, 1e-6, 3e-6, 1e-7, 0.5, 0.4)
"""With an interval and a bound before full contact."""
SILICON = {"material": ["silicon", "silicon"], "work": "20mJ/m2", "probe": "10um"}
COATED = {"modulus": "1GPa", "poisson": "0.3", "coating": "2nm:3GPa:0.3", "work": "20mJ/m2", "range": "0.5nm"}
HEIGHTS = 1e9 * surface().heights


def predicted(*maps: Any, **given: Any) -> Prediction:
    return continuum.predict(*maps, size="32nm", unit="nm", solve=False, **given)


KINDS: dict[str, Callable[[], Prediction]] = {
    "solved": lambda: SOLVED,
    "not solved": lambda: PREDICTED,
    "two bodies": lambda: predicted(HEIGHTS, HEIGHTS.T.copy(), **SILICON),
    "tip": lambda: predicted(HEIGHTS, tip="20nm", **SILICON),
    "coating": lambda: predicted(HEIGHTS, **COATED),
    "line": lambda: predicted(np.random.default_rng(1).standard_normal(128).cumsum().reshape(-1, 1) * 0.1, **SILICON),
    "every fault": lambda: replace(
        SOLVED,
        threshold_as_measured=SOLVED.threshold,
        findings=(replace(SOLVED.findings[0], faults=EVERY_FAULT),),
    ),
    "search": lambda: with_threshold(1.0, 0.99, 1.02, source=Basis.SEARCH),
    "bounds": lambda: with_threshold(1.0, 0.0, np.inf, source=Basis.BOUNDS, why=("a reason",), curve=()),
    "no number": lambda: with_threshold(np.nan, 0.0, np.inf, source=Basis.BOUNDS, why=("a reason",), curve=()),
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_work_of_adhesion_stands_in_the_part_of_the_axis_of_its_answer(kind: str) -> None:
    found = KINDS[kind]()
    axis, threshold, work = verdict_axis(found), found.threshold, found.contact.work_of_adhesion
    if threshold is None or not np.isfinite(threshold.work):
        assert axis == ""
        return
    bars = [[float(n) for n in bar] for bar in re.findall(r'<rect x="([\d.]+)" y="40" width="([\d.]+)"', axis)]
    mark = re.search(r'd="M([\d.]+) 48l', axis)
    assert mark is not None
    left, width = bars[[False, None, True].index(threshold.sticky(work))]
    assert left - 0.1 <= float(mark[1]) <= left + width + 0.1  # a tenth is the last digit that is written


@pytest.mark.parametrize("kind", KINDS)
def test_the_answer_is_short_and_the_tables_and_the_files_agree(kind: str) -> None:
    found = KINDS[kind]()
    lines = statements(found)
    # The terminal adds the files of the page and of --json.
    assert 1 <= len(lines) <= 8
    assert all(line and len(line) < 600 and "nan" not in line for line in lines)
    assert lines[0].lower().startswith(found.verdict.answer)
    cells = row(found)
    assert cells["verdict"] == found.verdict.answer
    sheets = found.sheets()
    assert (found.threshold is None) == (not any(sheet.title == "Threshold" for sheet in sheets))
    assert json.loads(found.json())["verdict"]["answer"] == found.verdict.answer
    assert all(fault.kind in found.sentence for fault in found.faults)


@pytest.mark.parametrize(
    ("kind", "count"), [("not solved", 2), ("bounds", 3), ("no number", 3), ("line", 3), ("solved", 4)]
)
def test_the_figure_has_a_panel_for_all_that_is_known(kind: str, count: int) -> None:
    assert len([axis for axis in overview(KINDS[kind]()).axes if axis.get_title(loc="left")]) == count


@pytest.mark.parametrize("probe", [PULL, replace(PULL, rim=None), replace(PULL, least=None, apparent=None, rim=None)])
def test_a_probe_is_one_line(probe: ProbePullOff, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Prediction, "probe", probe)
    (said,) = [line for line in statements(SOLVED) if line.startswith("Pull-off force of a probe of radius 10 µm: ")]
    assert ("before full contact" in said) == (probe.rim is not None)
    assert ("1 µN to 2 µN" in said) == (probe.least is not None)


def test_every_artefact_that_is_looked_for_is_one_name_in_one_line() -> None:
    assert len(EVERY_FAULT) > 8
    (said,) = [line for line in statements(KINDS["every fault"]()) if line.startswith("Faulty map")]
    assert said.count("fault ") == len(EVERY_FAULT)
    only = replace(SOLVED.findings[0], faults=(MapFault(NOT_GAUSSIAN, "a text", excludes="what to do"),))
    assert not any("a text" in line for line in statements(replace(SOLVED, findings=(only,))))
    assert said.count("--fill 5%") == 1


def test_a_row_has_the_threshold_its_error_faults_and_the_parameters_of_instruments() -> None:
    found = row(SOLVED)
    threshold = SOLVED.threshold
    assert threshold is not None
    assert [found[f"w_c{end}_J/m2"] for end in ("", " low", " high")] == [
        threshold.work, threshold.low, threshold.high,
    ]  # fmt: skip
    assert {"Sq_m", "Sa_m", "Sz_m", "Sdq", "Sdr", "Ssk", "Sku", "faults", "w_c from"} <= set(found)
    assert found["Sq_m"] == pytest.approx(found["rms_height_m"])
    assert "Sq_m" not in row(KINDS["line"]())  # a spectrum has no heights


@pytest.mark.usefixtures("unpressed")
def test_ten_lines_and_a_page_that_begins_with_the_answer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    np.save(tmp_path / "map.npy", HEIGHTS)
    words = ["predict", str(tmp_path / "map.npy"), "--size", "32nm", "--unit", "nm", "--no-solve", "--probe", "10um"]
    words += ["--material", "silicon", "--output", str(tmp_path), "--json", str(tmp_path / "all.json")]
    assert continuum.front.cli.main(words) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 10
    assert lines[-2].endswith("map-predict.html")
    page = (tmp_path / "map-predict.html").read_text()
    assert re.findall(r'<p class="verdict">(.*?)</p>', page) == [lines[0]]
    assert re.search(r'<p class="answer" style="background: #\w{6}">[A-Z][a-z ]+</p><svg', page)
    assert "Hann" not in "".join(lines)
    monkeypatch.setattr(Prediction, "write", lambda *_: [tmp_path / "map-predict.html"])
    assert continuum.front.cli.main(["-v", *words]) == 0
    assert "Theories, for comparison" in capsys.readouterr().out
