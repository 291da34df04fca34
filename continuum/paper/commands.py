"""The commands that draw, print and publish what the paper's figures and claims rest on."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from continuum.front import runs as front
from continuum.front.options import FIGURES, like
from continuum.paper import publication
from continuum.paper.examples import examples as paper_examples
from continuum.show.console import report


@like(front.plot, draws=FIGURES)
def plot(
    result: Annotated[str, Parameter(help="file written by `continuum run`, or the name of a figure")],
    *folders: Annotated[Path, Parameter(help="folder of a sweep, for a figure; several for `page` and `dispute`")],
    output: Annotated[Path | None, Parameter(help="folder of the figures (default: that of the result)")] = None,
) -> int:
    from continuum.paper.page import plot_figure

    return report(lines=plot_figure(result, *folders, into=output) if folders else front.plot(result, output))


@like(paper_examples)
def examples() -> int:
    return report(lines=[paper_examples().rstrip("\n")])


@like(publication.sweep_publish, help={"creators": "author of the data, as 'Family, Given'; may be repeated"})
def sweep_publish(**given: Any) -> int:
    found = publication.sweep_publish(**given)
    table = found.table
    return report(*table.sheets(), warnings=found.warnings, lines=found.files, ok=not (table.faults or table.lacking))
