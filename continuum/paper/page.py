"""The page of a sweep beside the paper: verdicts, figures with their captions, and where the numbers come from."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from matplotlib.figure import Figure

from continuum.arguments import choice, file_name
from continuum.files import output
from continuum.front.sweeps import SweepRun
from continuum.paper.claims import Claim, Finding, Word, claim_verdicts, verdict_sheet
from continuum.paper.dispute import write_dispute
from continuum.paper.figures import FIGURES, Drawing, save_drawing
from continuum.paper.points import FigureError, SweepData
from continuum.show.sheet import Sheet
from continuum.sweeps.collect import PointTable, collect

NAMES = (*FIGURES, "verdicts", "page", "dispute")
"""What ``continuum plot`` can make of a sweep."""


def plot_figure(name: str, *folders: str | Path, into: str | Path | None = None) -> list[Path]:
    """Draw a figure of the paper, or a page with verdicts, from the files of sweeps alone; returns the files written.

    Parameters
    ----------
    name : one of :data:`NAMES`; "page" is all that the sweep has points for, "dispute" the theories beside one another.
    folders : of the sweep; several for page and dispute.
    into : where to write; the folder of the first sweep if None.

    Raises
    ------
    SweepError, FigureError, OutputError
        If there is no sweep, no such figure, no point for it, or it cannot be written.
    """
    roots = [Path(folder) for folder in folders]
    if name not in NAMES:
        raise FigureError(f"{name}: no such figure; there are {', '.join(NAMES)}")
    place = output.folder(Path(into) if into else roots[0])
    if name == "dispute":
        return write_dispute([(root.resolve().name, collect(root)) for root in roots], place / "dispute.md")
    if name == "page":
        return write_page([SweepData(collect(root), root) for root in roots], place / "paper.md")
    if len(roots) > 1:
        raise FigureError(f"{name}: of one sweep at a time; only page and dispute have several")
    data = SweepData(collect(roots[0]), roots[0])
    if name == "verdicts":
        found = verdict_sheet(claim_verdicts(data.points))
        text = f"# {found.title}\n\n{found.markdown()}\n\n{provenance_line(data.table)}\n"
        return [output.save(place / "verdicts.md", text), output.save(place / "verdicts.csv", found.csv())]
    return save_drawing(FIGURES[name].make(data), place / name)


def figure(name: str, sweep: str | Path | SweepRun) -> Figure:
    """A figure of the paper from a stored sweep, to look at or to change; :func:`plot_figure` writes it into files.

    Parameters
    ----------
    name : as ``continuum plot`` knows it, such as "figure4".
    sweep : folder of a sweep, or what :func:`continuum.sweep` returned.

    Raises
    ------
    ArgumentError, SweepError, FigureError
        If there is no such figure, no sweep, or no point for it.
    """
    choice("name", name, FIGURES)
    root = sweep.folder if isinstance(sweep, SweepRun) else file_name("sweep", sweep)
    return FIGURES[name].make(SweepData(collect(root), root)).figure


def write_page(sweeps: Sequence[SweepData], path: Path) -> list[Path]:
    """Verdicts and every figure that there are points for, of one or several sweeps; returns the files written.

    Parameters
    ----------
    sweeps : their figures carry the names of the folders.
    path : of the page, in Markdown; figures lie beside it.
    """
    names = [data.root.resolve().name for data in sweeps]
    if len(set(names)) < len(names):
        msg = f"folders of different names, whose figures do not overwrite one another, not {', '.join(names)}"
        raise FigureError(msg)
    verdicts = [claim_verdicts(data.points) for data in sweeps]
    written, tables = list[Path](), ["## Verdicts\n", _matrix(names, verdicts), ""]
    parts = ["# The paper's figures and claims, from stored sweeps\n", _answer(verdicts), ""]
    for folder, data, found in zip(names, sweeps, verdicts, strict=True):
        parts += [f"## Sweep `{folder}`\n", provenance_line(data.table), _sizes(data), ""]
        for name, drawing in drawings_of(data):
            stem = path.with_name(f"paper-{folder}-{name}")
            written += save_drawing(drawing, stem)
            parts += drawing.shown(stem)
        looked = [each for each in found if each[1].points]
        tables += [f"### Verdicts of `{folder}`\n", verdict_sheet(looked).markdown(), ""]
    return [output.save(path, "\n".join([*parts, *tables]).rstrip() + "\n"), *written]


def _answer(verdicts: Sequence[list[tuple[Claim, Finding]]]) -> str:
    """The verdicts in words: each claim once, by the worst that a sweep says of it, and how many say so."""
    heads: dict[Word, str] = {
        "reproduced": "Reproduced by every sweep that tests it",
        "reproduced with a remark": "Reproduced, but with a remark by some",
        "not reproduced": "Not reproduced by some",
        "not tested": "Not tested",
    }
    said: dict[Word, list[str]] = {word: [] for word in heads}
    worst_first: tuple[Word, ...] = ("not reproduced", "reproduced with a remark", "reproduced", "not tested")
    for i, (claim, _) in enumerate(verdicts[0]):
        words = [found[i][1].word for found in verdicts if found[i][1].word != "not tested"]
        worst: Word = next((word for word in worst_first if word in words), "not tested")
        count = f" ({words.count(worst)} of {len(words)} sweeps)" if worst in worst_first[:2] else ""
        said[worst].append(f"{claim.text}{count}")
    return "\n".join(f"* **{heads[word]}**: {'; '.join(claims)}." for word, claims in said.items() if claims)


def _matrix(names: Sequence[str], verdicts: Sequence[list[tuple[Claim, Finding]]]) -> str:
    """Claims by sweeps: each cell is a verdict, and leads to the sweep."""

    def cell(folder: str, finding: Finding) -> str:
        place = f"sweep-{re.sub(r'[^a-z0-9-]', '', folder.lower())}"
        return f"[{finding.word}](#{place})" if finding.points else "-"

    rows = [
        (claim.text, *(cell(name, found[i][1]) for name, found in zip(names, verdicts, strict=True)))
        for i, (claim, _) in enumerate(verdicts[0])
    ]
    return Sheet.of("All verdicts", ("claim of the paper", *names), rows).markdown()


def drawings_of(data: SweepData) -> Iterator[tuple[str, Drawing]]:
    """The figures that a sweep is for, and has points for, each with its name."""
    for name in _meant(data):
        with suppress(FigureError):
            yield name, FIGURES[name].make(data)


def _meant(data: SweepData) -> Iterator[str]:
    """The figures that a sweep is for: its own by its name; else, as of figure4, all that there are points for."""
    own = data.table.listing.name.removesuffix("-reduced")
    if own in FIGURES and own != "figure4":
        yield own
        yield from {"figure1": ("figure-s1",), "figure3": ("diameter",)}.get(own, ())
        return
    if data.table.listing.common.get("output.fields"):
        yield from (name for name, figure in FIGURES.items() if figure.fields)
    if data.points.step.max() > 0 and data.points.lambda_s.notna().any():  # symbols have the size of λ_s
        yield from (name for name, figure in FIGURES.items() if figure.general)


def provenance_line(table: PointTable) -> str:
    """How much of a sweep is done, what it was computed with, and how long that took."""
    return (
        f"{len(table.keys)} of {len(table.listing.systems)} systems done, {len(table.system)} converged points; "
        f"{table.unconverged} points did not converge or have no state, and are left out. Computed with {table.made}; "
        f"{table.seconds.sum() / 3600:.2g} hours of wall time in all."
    )


def _sizes(data: SweepData) -> str:
    def in_order(values: Iterable[float]) -> str:
        return ", ".join(f"{value:g}" for value in sorted(set(values)))

    table, points = data.table, data.points
    size = {json.dumps(table.setting(key, "grid.n")) for key in table.keys}
    return (
        f"\nPoints of the grid {', '.join(sorted(size))}; λ_s = {in_order(points.lambda_s)} a0; "
        f"l_a = {in_order(points.length)} a0. {points.valid.sum()} points have A_rep >= 10 λ_s². κ is read at the "
        "first of them from 1 % area on."
    )
