"""Figures of the further inputs: what they show is what the files of a small sweep say by another way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from pandas import DataFrame

import continuum
from continuum.measure.contact import Curve, adhesion
from continuum.paper import relations
from continuum.paper.figures import FIGURES
from continuum.paper.page import plot_figure
from continuum.paper.points import FigureError, SweepData
from continuum.show import plot
from continuum.solve.tangent import tangent_stiffness
from continuum.store.runs.result import Result
from continuum.store.sheet import Sheet
from continuum.store.sweeps.folder import Folder
from tests.printed import faults_in_print
from tests.problems import SMALL

DEPTHS = '[sweep.axes]\n"loading.targets" = [{from = 1.8, to = 1.4, step = -0.1}, {from = 1.8, to = 1.0, count = 9}]\n'
WALLS = """
[sweep.axes]
"wall" = [{law = "hard"}, {law = "lennard-jones-spline", adhesion_length = 0.005}]
"""


def swept(folder: Path, text: str) -> SweepData:
    folder.mkdir(exist_ok=True)
    path = folder / "many.toml"
    path.write_text(text)
    done = continuum.sweep(path, folder)
    assert done.ok
    return SweepData(done.collect(), done.folder)


def columns(sheet: Sheet) -> dict[str, np.ndarray]:
    cells = zip(*sheet.rows, strict=True)
    return {column.name: np.array(values) for column, values in zip(sheet.columns, cells, strict=True)}


def test_pull_off_and_work_are_those_of_each_cycle(tmp_path: Path) -> None:
    data = swept(tmp_path, SMALL + DEPTHS)
    drawing = FIGURES["pull-off"].make(data)
    shown = columns(drawing.sheet)
    for i, key in enumerate(data.table.keys):
        found = adhesion(Curve.of(Result.read(Folder(data.root).point(key)).points))
        assert shown["pull-off (E*)"][i] == found.pull_off
        assert shown["tension on approach (E*)"][i] == found.largest_tension
        assert shown["work of separation/w"][i] == pytest.approx(found.work_of_separation / 0.005, rel=1e-12)
        assert shown["peak load (E*)"][i] == found.peak_load
    assert shown["peak A_rep/A0"][0] < shown["peak A_rep/A0"][1]
    assert faults_in_print(drawing.figure) == []
    assert drawing.figure.legends


@pytest.mark.long
def test_a_sweep_without_a_way_back_has_no_pull_off(tmp_path: Path) -> None:
    text = SMALL.replace("retract = true\n", "") + '[sweep.axes]\n"surface.seed" = [1]\n'
    data = swept(tmp_path, text)
    with pytest.raises(FigureError, match="a way back"):
        FIGURES["pull-off"].make(data)
    # Three areas make a line of d_rep; what the figure shows is the table's own column.
    shown = columns(FIGURES["diameter"].make(data).sheet)
    np.testing.assert_allclose(shown["ratio"] * shown["4h'/h'' (a0)"], data.points.query("diameter > 0").diameter)
    assert {path.suffix for path in plot_figure("diameter", data.root)} == {".png", ".csv"}


def test_gap_profiles_are_those_of_the_stored_gaps(tmp_path: Path) -> None:
    text = (
        SMALL.replace("[1.6, 1.4,\n           1.2]", "[0.1]")
        .replace("mean-gap", "repulsive-area")
        .replace("retract = true\n", "")
    )
    # Patches wide enough that points lie between 2 a0 and d_rep/4 of their edge.
    text = text.replace("24, 30", "96, 80").replace("lambda_s = 6.0", "lambda_s = 30.0").replace("12.0", "40.0")
    data = swept(tmp_path, text + WALLS)
    drawing = FIGURES["gap-profile"].make(data)
    shown = columns(drawing.sheet)
    assert faults_in_print(drawing.figure) == []
    titles = [axis.get_title(loc="left") for axis in drawing.figure.axes]
    assert [title.split("  ")[1] for title in titles] == ["hard wall", "wall with a law"]
    assert set(data.points.law) == {"hard", "lennard-jones-spline"}
    for i, key in enumerate(data.table.keys):
        (point,) = Result.read(Folder(data.root).point(key)).analyse().points
        assert point.fields is not None
        assert shown["d_rep (a0)"][i] == point.numbers.diameter
        low, high = shown["gap over S-1, least, from the edge"][i], shown["largest, from the edge"][i]
        np.testing.assert_array_equal((low, high), point.fields.gap_ratio)
        assert low > 0
    assert np.isnan(shown["d_att (a0)"][shown["wall"] == "hard"]).all()


@pytest.mark.long
def test_gap_profiles_of_a_sweep_without_gaps_say_what_is_missing(tmp_path: Path) -> None:
    data = swept(tmp_path, SMALL.replace("fields = true", "") + '[sweep.axes]\n"surface.seed" = [1]\n')
    with pytest.raises(FigureError, match="fields = true"):
        FIGURES["gap-profile"].make(data)


def test_contact_maps_of_two_adhesion_lengths(tmp_path: Path) -> None:
    text = SMALL.replace("retract = true\n", "").replace("[1.6, 1.4,\n           1.2]", "[1.2]")
    data = swept(tmp_path, text + '[sweep.axes]\n"wall.adhesion_length" = [0.0, 0.005]\n')
    drawing = FIGURES["figure1"].make(data)
    np.testing.assert_array_equal(columns(drawing.sheet)["A_rep/A0"], data.table["area_rep"])
    # Both bodies, the whole, one map each, a part of the last, and a cut through it.
    assert [axis.name for axis in drawing.figure.axes] == ["3d", *["rectilinear"] * 5]
    surface = drawing.figure.axes[0].collections[0]
    orange, black, free = (to_rgba(c) for c in (plot.REPULSIVE_COLOUR, plot.ATTRACTED_COLOUR, plot.DIFFERENT_COLOUR))
    shown = {tuple(colour[:3]) for colour in surface.get_facecolor()}
    assert {orange[:3], black[:3], free[:3]} == shown
    assert faults_in_print(drawing.figure) == []
    assert faults_in_print(FIGURES["figure-s1"].make(data).figure) == []


def test_the_stiffness_of_each_point_is_that_of_its_gap(tmp_path: Path) -> None:
    data = swept(tmp_path, SMALL.replace("retract = true\n", "") + '[sweep.axes]\n"surface.seed" = [1]\n')
    result = Result.read(Folder(data.root).point(data.table.keys[0]))
    law, response = result.wall.law, result.config.substrate.build().stiffness(result.grid)
    assert law is not None
    gaps = [result.gap(step) for step in range(len(result.points))]
    expected = [tangent_stiffness(result.grid, response, law, gap) for gap in gaps if gap is not None]
    np.testing.assert_allclose(data.table["tangent_stiffness"], expected, rtol=1e-9)
    drawing = FIGURES["stiffness"].make(data)
    ratio = data.points.tangent_stiffness * data.points.rms_height / data.points.load_rep
    np.testing.assert_allclose(columns(drawing.sheet)["k_N h_rms/N_rep"], ratio)
    bare = swept(tmp_path / "bare", SMALL.replace("fields = true", "") + '[sweep.axes]\n"surface.seed" = [1]\n')
    with pytest.raises(FigureError, match="fields = true"):
        FIGURES["stiffness"].make(bare)


def test_laws_are_told_apart_by_shape_and_averaged_over_surfaces() -> None:
    walls = [("lennard-jones-spline", np.nan), ("attraction-on-core", "spline"), ("attraction-on-core", "exponential")]
    inverse = {0: (0.1, 0.2), 1: (0.3, 0.7), 2: (0.4, 0.4)}
    points = DataFrame([
        {"law": law, "shape": shape, "length": 0.005, "effective_range": 1.0, "expected_kappa_att": 4.0,
         "kappa_att": 1 / inverse[i][seed], "sweep.wall": f"wall {i}", "sweep.surface.seed": str(seed)}
        for i, (law, shape) in enumerate(walls) for seed in (0, 1)
    ])  # fmt: skip
    found = relations.laws(points).set_index("law")
    assert set(found.index) == {"lennard-jones-spline", "spline", "exponential"}
    np.testing.assert_allclose(found.loc["spline", ["1/kappa_att", "scatter over surfaces"]], [0.5, 0.4 / 2**0.5])
    np.testing.assert_allclose(found["1/kappa_att theory"], 0.25)
    figure = relations.draw_laws(found.reset_index())
    assert {"the paper's spline", "exponential", "twice that"} < {t.get_text() for t in figure.legends[0].get_texts()}
