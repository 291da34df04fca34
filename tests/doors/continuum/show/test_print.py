"""Figures as they are printed: those of a run, of its analysis, of a prediction; and that a fault would be seen."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

import continuum
from continuum.maps.map import Topography
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.prediction import prediction_of
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.show import plot
from continuum.show.prediction_figures import overview
from continuum.show.run_figures import draw_analysis, draw_run, map_figure
from tests.printed import faults_in_print

pytestmark = pytest.mark.style


def test_figures_of_a_run_and_of_its_analysis(small: Path, drawn: dict[str, Figure]) -> None:
    result = continuum.run(small)
    draw_run(result)
    draw_analysis(result.analyse())
    names = ("contact", "area-and-load", "patches", "sizes", "gap-profile", "distributions")
    assert {name: faults_in_print(figure) for name, figure in drawn.items()} == {f"small-{n}": [] for n in names}
    first = result.points[0]
    assert faults_in_print(map_figure(result.contact_map(0), result.grid.lengths, first.area_rep, first.load)) == []


@pytest.mark.parametrize("targets", [[0.02], [0.02, 0.1], [0.02, 0.1, 0.3]])
def test_no_title_of_one_to_three_maps_is_cut(targets: list[float], small: Path, drawn: dict[str, Figure]) -> None:
    tables = {"loading": {"control": "repulsive-area", "targets": targets, "area_tolerance": 0.2}}
    result = continuum.run(small, small.parent, settings=tables)
    draw_run(result)
    draw_analysis(result.analyse())
    assert {name: faults_in_print(drawn[f"small-{name}"]) for name in ("contact", "patches")} == {
        "contact": [],
        "patches": [],
    }


def test_figures_of_a_prediction() -> None:
    """Of two bodies that are pressed; in ``test_predict.py`` are some that are not."""
    grid = Grid.square(32)
    maps = [
        Topography(SelfAffine(0.8, 0.1, 8.0, 16.0).synthesise(grid, np.random.default_rng(seed)), grid.lengths, True)
        for seed in (1, 2)
    ]
    found = prediction_of(maps, Interface(1.0, 0.005, 0.35, 1.0))
    solved = found.solved(search=False)
    assert solved.threshold is not None
    assert faults_in_print(overview(solved)) == []


def test_a_figure_has_the_pixels_of_print(print_quality: float) -> None:
    with Image.open(BytesIO(plot.image_bytes(plot.new_figure(plot.COLUMN, 1.0)))) as image:
        dpi = image.info["dpi"][0]
        assert dpi == pytest.approx(print_quality, abs=0.1)
        assert image.size[0] / dpi * 2.54 == pytest.approx(8.7, abs=0.02)


@plot.styled
def two_panels() -> tuple[Figure, Axes, Axes]:
    figure, (left, right) = plot.new_axes(plot.PAGE, 2.0, 1, 2)
    plot.letter_panels((left, right))
    left.plot([1, 2], label="line")
    plot.legend_below(figure, plot.labelled(left))
    return figure, left, right


def test_what_is_wrong_is_seen() -> None:
    figure, left, right = two_panels()
    assert faults_in_print(figure) == []
    left.legend()
    left.text(0.5, 1.5, "small", fontsize=4)
    right.text(0.5, 0.5, "here")
    right.text(0.5, 0.5, "and here")
    right.text(9.0, 0.5, "away").set_in_layout(False)
    right.set_title("", loc="left")
    figure.set_size_inches(6, 2)
    seen = faults_in_print(figure)
    for fault in ("15.24 cm wide", "'small': 4 pt", "'here' on 'and here'", "a legend on panel 0"):
        assert fault in seen
    assert "panel B is not lettered" in seen
    assert any("'away'" in fault for fault in seen)
