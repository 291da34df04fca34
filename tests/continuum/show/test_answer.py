"""The answer, its tables and its figure do not contradict one another about which theories count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.model.walls import LennardJonesSpline
from continuum.show.answer import percent
from continuum.show.prediction import prediction_sheets
from continuum.show.prediction_figures import overview
from continuum.sticky.criteria import CRITERIA
from continuum.sticky.materials import Interface
from continuum.sticky.prediction import Prediction, prediction_of
from continuum.sticky.record import turning_margin
from continuum.sticky.simulate import Simulation
from continuum.sticky.verdict import answer_at, judge
from continuum.topography.map import Topography


def predicted(slope: float, worn: bool = False, factor: float = 1.0) -> Prediction:
    grid = Grid.square(64)
    heights = SelfAffine(0.8, slope, 8.0, 32.0).synthesise(grid, np.random.default_rng(1))
    if worn:
        heights = np.minimum(heights, np.quantile(heights, 0.8))
    pixel = 1e-9
    size = (pixel * grid.lengths[0], pixel * grid.lengths[1])
    interface = Interface(1e9, factor * 1e-6 * pixel * 1e9, 0.6 * slope * pixel, pixel)
    return prediction_of([Topography(pixel * heights, size, periodic=True)], interface)


def counted(found: Prediction) -> set[str]:
    """Names of the criteria that the table of verdicts calls in their range, but for the necessary condition."""
    table = next(sheet for sheet in prediction_sheets(found) if sheet.title.startswith("Is it sticky"))
    return {str(row[0]) for row in table.rows if str(row[-1]).startswith("yes")} - {"necessary adhesion"}


def counted_in_row(found: Prediction) -> set[str]:
    """The same by the row of ``--csv``."""
    inside = ": in its range"
    names = {name.removesuffix(inside) for name, said in found.row().items() if name.endswith(inside) and said == "yes"}
    return names - {"necessary adhesion"}


def labels(found: Prediction) -> set[str]:
    return {str(line.get_label()) for axis in overview(found).axes for line in axis.lines}


@pytest.mark.parametrize("slope", [0.1, 0.6])
def test_theories_that_the_answer_names_are_in_their_range_everywhere(slope: float) -> None:
    found = predicted(slope)
    verdict = judge(found)
    assert verdict.probability is not None
    named = {criterion.name for criterion in CRITERIA.values() if criterion.name in verdict.why[0]}
    assert "Pastewka-Robbins" in named
    assert named == counted(found) == counted_in_row(found)
    assert "it is out of its range" not in found.sentence
    assert ("judged with smaller heights, as h' = 0.6 is above 0.3" in found.sentence) is (slope > 0.3)
    assert "together, in range" in labels(found)


def test_no_theory_counts_on_a_map_that_is_not_gaussian() -> None:
    found = predicted(0.1, worn=True)
    assert found.excluding
    assert not counted(found)
    assert not counted_in_row(found)
    assert "together, in range" not in labels(found)
    assert "10 and 90 %" in labels(found)


def test_nor_on_one_that_is_too_steep() -> None:
    found = predicted(1.5)
    assert not counted(found)
    assert not counted_in_row(found)
    assert "it is out of its range" in found.sentence


def test_beside_the_solver_the_paper_says_what_its_record_says() -> None:
    """Its criterion by itself would say not sticky where the record has half of such surfaces sticky."""
    one = predicted(0.1)
    half = turning_margin((CRITERIA[one.paper.key],), one.contact)
    found = predicted(0.1, factor=half / (one.paper.margin or np.nan))
    assert found.paper.sticky is False
    grid = Grid.square(4)
    solved = Simulation(
        area_rep=0.01, area_ratio=1.0, load=-1.0, kappa=-1.0, jumped=False, gap=np.ones(grid.shape),
        wall=LennardJonesSpline(0.1), grid=grid, map=grid, warnings=(),
    )  # fmt: skip
    for prediction, said in ((found, "undecided"), (predicted(0.1, worn=True), "-")):
        sheets = prediction_sheets(replace(prediction, simulation=solved))
        rows = {row[0]: row for sheet in sheets if sheet.title.startswith("Solved") for row in sheet.rows}
        assert rows["verdict at the given w"][1:] == (said, "sticky")


@given(st.floats(0, 1))
def test_a_printed_probability_is_never_certain_and_agrees_with_its_answer(probability: float) -> None:
    text = percent(probability)
    number = float(text.removeprefix("less than ").removeprefix("more than ").removesuffix(" %"))
    assert 1 <= number <= 99
    assert abs(number / 100 - probability) <= 0.01 + 1e-12  # one more than rounding, where that would cross the limit
    assert answer_at(number / 100) == answer_at(probability)
