"""Sheets say the same in every form; pages need no other file."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from continuum.path.state import NEAREST, Event, JumpSide
from continuum.show.console import show
from continuum.show.page import Page
from continuum.show.plot import new_figure, save_figure
from continuum.store.runs.record import PathEvent
from continuum.store.runs.result import Result
from continuum.store.sheet import WIDEST, Column, Sheet, pairs

cells = (
    st.none() | st.integers(-1000, 1000) | st.floats() | st.text(st.characters(codec="utf-8", exclude_characters="\r"))
)


@given(st.integers(1, 5).flatmap(lambda n: st.lists(st.tuples(*[cells] * n), max_size=6)))
def test_every_form_holds_every_cell(rows: list[tuple[str | float | int | None, ...]]) -> None:
    width = len(rows[0]) if rows else 2
    sheet = Sheet.of("a title", [Column(f"c{i}", "a0" if i else "") for i in range(width)], rows, "a note")
    assert sheet.text().startswith("a title\n")
    assert sheet.text().endswith("a note")
    assert f"{sheet}" == str(sheet) == sheet.text()
    assert sheet.html().count("<tr>") == len(rows) + 1
    assert sheet.html().count("<td>") == len(rows) * width
    back = list(csv.reader(io.StringIO(sheet.csv())))
    assert len(back) == len(rows) + 1
    for row, cells in zip(rows, back[1:], strict=True):
        for value, cell in zip(row, cells, strict=True):
            if isinstance(value, float):
                assert float(cell) == value or np.isnan(value)  # to the last digit


def test_numbers_have_units_and_forms() -> None:
    columns = ("name", Column("gap", "a0", ".2f"), Column("area", "%", ".1f"), Column("count"))
    sheet = Sheet.of("", columns, [("one", 1.0, 0.25, 3), ("two", np.nan, None, 4)])
    assert sheet.head == ("name", "gap (a0)", "area", "count")
    assert sheet.cells == (("one", "1.00", "25.0 %", "3"), ("two", "-", "-", "4"))
    assert [sheet.numeric(i) for i in range(4)] == [False, True, True, True]
    assert sheet.markdown().splitlines()[2] == "| one | 1.00 | 25.0 % | 3 |"


words = st.lists(st.text("abc-é²", min_size=1, max_size=8), min_size=1, max_size=12).map(" ".join)


@given(st.lists(st.tuples(words, words, words, words, st.floats(-1, 1)), min_size=1, max_size=4), words)
def test_text_is_broken_between_words_to_fit_and_numbers_are_not(
    rows: list[tuple[str, str, str, str, float]], note: str
) -> None:
    columns = ["a head", "b", "c", "d", Column("a head of many words over a number", "E*", ".3e")]
    sheet = Sheet.of("a title", columns, rows, note)
    assert all(len(line) <= WIDEST for line in sheet.text().splitlines())
    for (*_, last), (*_, printed) in zip(sheet.cells, sheet.laid_out()[1:], strict=True):
        assert printed == [last]
    assert [[" ".join(cell) for cell in row] for row in sheet.laid_out()] == [list(sheet.head), *map(list, sheet.cells)]
    assert sheet.text(10_000).count("\n") == len(rows) + 2


def test_points_of_a_path_and_its_jumps_fit_with_their_longest_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a pipe, and on a terminal of 120 columns, where no number is broken."""
    ends = JumpSide(0.0123456789, -0.0123456, -0.0123456, 1.2345e-5, 1.2345e-5, -1.23456e-3)
    point = SimpleNamespace(
        branch="retract", mean_gap=-0.0123456, separation=-0.0123456, area_rep=1.2345e-5, area_att=1.2345e-5,
        load=-1.23456e-3, load_rep=1.23456e-3, residual=1e-10, fft_pairs=12345, search_pairs=12345,
        status="MAX_ITERATIONS",
    )  # fmt: skip
    event = PathEvent(100, Event("pull-off", "repulsive-area", "retract", ends, ends))
    run = SimpleNamespace(
        points=[point] * 101, resumed=100, events=[event], _not_looked_at=lambda: [True] * 101,
        _count_few=lambda: [f", {NEAREST}"] * 101,
    )  # fmt: skip
    for sheet in Result.sheets(run):
        assert max(map(len, sheet.text().splitlines())) <= WIDEST
        seen = io.StringIO()
        terminal = Console(force_terminal=True, color_system=None, width=WIDEST, file=seen)
        monkeypatch.setattr("continuum.show.console._console", terminal)
        show(sheet)
        assert max(map(len, seen.getvalue().splitlines())) <= WIDEST
        numbers = {cell for row in sheet.cells for i, cell in enumerate(row) if sheet.numeric(i)}
        assert numbers <= set(seen.getvalue().split())


def test_a_row_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match="1 cells under 2 columns"):
        Sheet.of("t", ("a", "b"), [("only one",)])


def test_a_page_stands_alone_and_escapes_what_it_is_told(tmp_path: Path, print_quality: float) -> None:
    figure = new_figure(1, 1)
    figure.subplots()
    picture = save_figure(figure, tmp_path / "figure")
    sheets, listing = [pairs("t", [("<q>", 1)])], ("Input", "<x>")
    page = Page("a < b", "not & so", ["<script>"], [(picture, "a caption")], sheets, listing)
    text = page.write(tmp_path / "page.html").read_text()
    assert "<script" not in text
    assert text.count("&lt;") == 5  # the title twice
    # An inch of a figure has the same pixels, whatever its width: letters are of one size.
    assert f'width="{print_quality / 2:g}" src="data:image/png;base64,' in text
    assert "http" not in text


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t"])
def test_no_name_of_a_user_is_a_formula_of_a_spreadsheet(start: str) -> None:
    """In cells and heads; numbers, dashes and all other text are as they were."""
    harmful = f"{start}HYPERLINK(1)"
    rows = [(harmful, -1.5, None), ("-", "-2e-3", "a=b"), ("map.npy", float("-inf"), "it's")]
    sheet = Sheet.of("", (harmful, "value", "text"), rows)
    back = list(csv.reader(io.StringIO(sheet.csv(), newline="")))
    assert back[0][0] == back[1][0] == f"'{harmful}"
    assert back[1][1:] == ["-1.5", ""]
    assert back[2:] == [["-", "-2e-3", "a=b"], ["map.npy", "-inf", "it's"]]
    assert harmful in sheet.text()
