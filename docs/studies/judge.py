"""Judge the sweeps of a stored page anew: `python -m docs.studies.judge docs/measured`.

Verdicts are by the rules of today, from the table of points that lies beside the page for each sweep, and captions
from the tables of the figures; what else the page says before the first verdict stays.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from pandas import read_csv

from continuum.paper.claims import stored_points
from continuum.paper.figures import FIGURES
from continuum.paper.page import page_text
from continuum.store import output
from docs.studies.tables import points_of

_SHOWN = re.compile(r"^!\[.*\]\((paper-[\w-]+)\.png\)\n\n.*$", re.MULTILINE)


def captioned(section: str, folder: Path) -> str:
    """A section with the captions of its figures made from their tables."""

    def again(found: re.Match[str]) -> str:
        stem = found[1]
        name = max((name for name in FIGURES if stem.endswith(f"-{name}")), key=len)
        said = FIGURES[name].said(read_csv(folder / f"{stem}.csv"))
        return f"![{said}]({stem}.png)\n\n{said}"

    return _SHOWN.sub(again, section)


def judged_again(page: Path) -> str:
    """The page as the rules of today have it."""
    text = page.read_text(encoding="utf-8").partition("\n## Verdicts\n")[0]
    title, *said = text.partition("\n## ")[0].partition("\n* ")[0].strip().splitlines(keepends=True)
    parts = re.split(r"^## Sweep `([\w-]+)`\n", text, flags=re.MULTILINE)[1:]
    sections = {
        name: captioned(section.strip(), page.parent) for name, section in zip(parts[::2], parts[1::2], strict=True)
    }
    points = {name: stored_points(points_of(name, page.parent)) for name in sections}
    found = page_text(sections, points)
    return found.replace(title, f"{title}{''.join(said)}\n", 1) if said else found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    page = parser.parse_args().folder / "paper.md"
    output.save(page, judged_again(page))


if __name__ == "__main__":
    main()
