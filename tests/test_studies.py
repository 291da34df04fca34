"""What the pages show of stored data, tables and quoted numbers, is what the studies make of it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs.studies import pages

TEXTS = {path.relative_to(pages.DOCS).as_posix(): path.read_text(encoding="utf-8") for path in pages.pages()}
MARKED = {page for page, text in TEXTS.items() if "<!--" in text and pages.marked(text)}
LONGEST = {
    "law": 1200, "dispute": 800, "predict": 1500, "validation": 1500, "verification": 800, "paper": 1500,
    "benchmarks": 800, "decks": 3000, "sweeps": 1500, "paths": 1200, "geometry": 1000, "maps": 1400,
    "budget": 800, "trust": 360,
}  # fmt: skip
"""Words of pages of the manual: what was measured, and how it was judged, stands in the studies."""


@pytest.mark.parametrize("page", sorted(MARKED))
def test_a_page_shows_what_its_studies_make(page: str) -> None:
    assert pages.made_anew(TEXTS[page]) == TEXTS[page], f"python -m docs.studies.pages makes {page} anew"


def test_all_that_is_made_is_shown_and_marks_are_closed() -> None:
    shown = {name for page in MARKED for name, _ in pages.marked(TEXTS[page])}
    assert shown == set(pages.MADE)
    for page, text in TEXTS.items():
        assert text.count("<!--made:") == text.count("<!--end-->") == len(pages.marked(text)), page


def test_a_number_and_a_table_that_say_something_else_are_made_anew() -> None:
    number, table = pages.MADE["law.count"](), pages.MADE["law.values"]()
    old = "of <!--made:law.count-->7<!--end--> thresholds\n\n<!--made:law.values-->\n\n| D |\n\n<!--end-->\n"
    new = f"of <!--made:law.count-->{number}<!--end--> thresholds\n\n<!--made:law.values-->\n\n{table}\n\n<!--end-->\n"
    assert number != "7"
    assert pages.made_anew(old) == new == pages.made_anew(new)


def test_each_study_says_question_statement_run_result_verdict_data_and_what_is_open() -> None:
    """The record of theories and the logbook of the solver have parts of their own."""
    studies = {page: text for page, text in TEXTS.items() if page.startswith("studies/")}
    older = {f"studies/{name}.md" for name in ("index", "predict-record", "solver-log")}
    assert len(studies) > 20
    for page in set(studies) - older:
        bold = set(re.findall(r"^\*\*(\w+)", studies[page], re.MULTILINE))
        assert {"Question", "Statement", "Data", "Open"} <= bold or page == "studies/law.md", page
        assert "**Verdict" in studies[page] or "**What was found" in studies[page], page
        assert f"]({Path(page).name})" in studies["studies/index.md"], page


@pytest.mark.parametrize("name", LONGEST)
def test_the_manual_is_no_logbook(name: str) -> None:
    text = TEXTS[f"{name}.md"]
    assert len(re.sub(r"<!--.*?-->", "", text).split()) <= LONGEST[name]
    assert not re.search(r"\b20\d\d-\d\d-\d\d\b|\b\d+ November\b", text), "dates stand in the studies"
