"""What the pages show of stored data, tables and quoted numbers, is what the studies make of it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs.studies import pages

TEXTS = {path.relative_to(pages.DOCS).as_posix(): path.read_text(encoding="utf-8") for path in pages.pages()}
MARKED = {page for page, text in TEXTS.items() if "<!--" in text and pages.marked(text)}
LONGEST = {
    "benchmarks": 430, "changes": 12, "cite": 125, "cluster": 563, "commands": 365, "contribute": 648,
    "install": 415, "why": 545, "tutorials/python": 190,
    "decks": 1500, "dispute": 490, "gradients": 375, "house": 303, "index": 450,
    "law": 785, "model": 635, "response": 460, "argument": 390,
    "limits": 435, "maps": 755, "paper": 1030, "paths": 720, "peers": 760,
    "predict": 1120, "solver": 879, "start": 165, "substrates": 375, "sweeps": 882, "trust": 265,
    "tutorials/atoms": 405, "tutorials/deck": 120, "tutorials/indent": 148, "tutorials/map": 478,
    "tutorials/script": 347, "tutorials/copper": 212, "tutorials/film": 319, "tutorials/sweep": 266,
    "tutorials/validate": 277, "validation": 680, "view": 290,
}  # fmt: skip
"""Words of each page of the manual, with code and tables; what was measured and how it was judged is in the studies."""
MANUAL = 17_800
"""Words of all of them but those for developers."""
DEVELOPERS = {"contribute.md", "house.md", "solver.md"}
FOR_DEVELOPERS = 1830
"""Words of these; the aim is 1500."""
STUDIES = 21_000
"""Words of all studies, without tables that are made from data; the aim is 20 000."""


def test_a_page_shows_what_its_studies_make() -> None:
    for page in sorted(MARKED):
        assert pages.made_anew(TEXTS[page]) == TEXTS[page], f"python -m docs.studies.pages makes {page} anew"


def test_all_that_is_made_is_shown_and_marks_are_closed() -> None:
    shown = {name for page in MARKED for name, _ in pages.marked(TEXTS[page])}
    assert shown == set(pages.MADE)
    for page, text in TEXTS.items():
        assert text.count("<!--made:") == text.count("<!--end-->") == len(pages.marked(text)), page
        # A comment at the beginning of a line ends the paragraph.
        assert not re.search(r"^<!--made:[^>]*-->.*<!--end-->", text, re.MULTILINE), page


def test_a_number_and_a_table_that_say_something_else_are_made_anew() -> None:
    number, table = pages.MADE["law.count"](), pages.MADE["law.values"]()
    old = "of <!--made:law.count-->7<!--end--> thresholds\n\n<!--made:law.values-->\n\n| D |\n\n<!--end-->\n"
    new = f"of <!--made:law.count-->{number}<!--end--> thresholds\n\n<!--made:law.values-->\n\n{table}\n\n<!--end-->\n"
    assert number != "7"
    assert pages.made_anew(old) == new == pages.made_anew(new)


@pytest.mark.style
def test_each_study_says_question_statement_run_result_verdict_data_and_what_is_open() -> None:
    """The logbook of the solver has parts of its own."""
    studies = {page: text for page, text in TEXTS.items() if page.startswith("studies/")}
    older = {f"studies/{name}.md" for name in ("index", "solver-log")}
    assert len(studies) > 20
    for page in set(studies) - older:
        bold = set(re.findall(r"^\*\*(\w+)", studies[page], re.MULTILINE))
        assert {"Question", "Statement", "Data", "Open"} <= bold, page
        assert "**Verdict" in studies[page] or "**What was found" in studies[page], page
        assert f"]({Path(page).name})" in studies["studies/index.md"], page


def counted(text: str) -> int:
    """Words that somebody wrote, in code too: without what is made from code, and without bars of tables."""
    written = re.sub(r"<!-- (?:made by|table: begin).*?<!-- (?:table: )?end -->", "", text, flags=re.DOTALL)
    return sum(any(map(str.isalnum, word)) for word in re.sub(r"<!--.*?-->", "", written).split())


def words(page: str) -> int:
    return counted(TEXTS[page])


def written(page: str) -> int:
    """Words of a study, without the tables that are made from data."""
    return counted(re.sub(r"<!--made:[^>]*-->\s*\n\n.*?<!--end-->", "", TEXTS[page], flags=re.DOTALL))


@pytest.mark.style
def test_the_studies_can_be_read() -> None:
    assert sum(written(page) for page in TEXTS if page.startswith("studies/")) <= STUDIES


@pytest.mark.style
def test_the_manual_can_be_read() -> None:
    manual = {page for page in TEXTS if not page.startswith(("studies/", "measured/", "joss/"))}
    assert manual == {f"{name}.md" for name in LONGEST}
    assert sum(map(words, manual - DEVELOPERS)) <= MANUAL
    assert sum(map(words, DEVELOPERS)) <= FOR_DEVELOPERS


@pytest.mark.style
def test_the_manual_is_no_logbook() -> None:
    for name in LONGEST:
        assert words(f"{name}.md") <= LONGEST[name]
        assert not re.search(r"\b20\d\d-\d\d-\d\d\b|\b\d+ November\b", TEXTS[f"{name}.md"]), (
            "dates stand in the studies"
        )


@pytest.mark.style
def test_the_paper_for_a_journal_can_be_submitted() -> None:
    """At most 1500 words, the sections that the journal asks for, and each reference cited and listed."""
    text, listed = TEXTS["joss/paper.md"], (pages.DOCS / "joss" / "paper.bib").read_text(encoding="utf-8")
    assert words("joss/paper.md") <= 1500
    sections = ["Summary", "Statement of need", "State of the field", "Software design", "Research impact statement",
                "AI usage disclosure", "Acknowledgements", "References"]  # fmt: skip
    assert re.findall(r"^# (.*)$", text, re.MULTILINE) == sections
    assert set(re.findall(r"@(\w+)", text.partition("# Summary")[2])) == set(
        re.findall(r"^@\w+\{(\w+),", listed, re.MULTILINE)
    )
