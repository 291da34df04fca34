"""Judge the sweeps of a stored page anew: `python -m docs.studies.judge docs/measured`.

Verdicts are by the rules of today, from the table of points that lies beside the page for each sweep; what the page
says before the first of them, of the figures, and where they come from, stays.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from continuum.files import output
from continuum.paper.claims import stored_points
from continuum.paper.page import page_text


def judged_again(page: Path) -> str:
    """The page as the rules of today have it."""
    text = page.read_text(encoding="utf-8").partition("\n## Verdicts\n")[0]
    title, *said = text.partition("\n## ")[0].partition("\n* ")[0].strip().splitlines(keepends=True)
    parts = re.split(r"^## Sweep `([\w-]+)`\n", text, flags=re.MULTILINE)[1:]
    sections = {name: section.strip() for name, section in zip(parts[::2], parts[1::2], strict=True)}
    points = {name: stored_points(page.with_name(f"paper-{name}-points.csv")) for name in sections}
    found = page_text(sections, points)
    return found.replace(title, f"{title}{''.join(said)}\n", 1) if said else found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    page = parser.parse_args().folder / "paper.md"
    output.save(page, judged_again(page))


if __name__ == "__main__":
    main()
