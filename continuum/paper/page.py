"""The page of a sweep: verdicts, figures with their captions, and the provenance of the numbers."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from matplotlib.figure import Figure
from pandas import DataFrame

from continuum.front.sweeps import SweepRun
from continuum.inputs.arguments import choice, file_name
from continuum.paper.claims import Claim, Finding, Word, claim_points, claim_verdicts, stored_points, verdict_sheet
from continuum.paper.dispute import write_dispute
from continuum.paper.figures import FIGURES, Drawing, save_drawing
from continuum.paper.points import FigureError, SweepData
from continuum.store import output
from continuum.store.sheet import Sheet
from continuum.store.sweeps.collect import PointTable, collect

NAMES = (*FIGURES, "verdicts", "page", "dispute")
"""Names that ``continuum plot`` knows."""


def plot_figure(name: str, *folders: str | Path, into: str | Path | None = None) -> list[Path]:
    """Draw a figure of the paper, or a page with verdicts, from the files of sweeps alone; returns the files written.

    Parameters
    ----------
    name : one of :data:`NAMES`; "page" is all that the sweep has points for, "dispute" the theories beside one another.
    folders : folder of the sweep; several for page and dispute.
    into : folder to write to; that of the first sweep if None.

    Raises SweepError, FigureError or OutputError if there is no sweep, no such figure, no point for it, or it cannot
    be written.
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
    """A figure of the paper from a stored sweep, as a matplotlib figure; :func:`plot_figure` writes it into files.

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

    The table of points for the verdicts of each sweep, ``paper-NAME-points.csv``, is written beside the page, so that
    it can be judged again by other rules without its files.  The path is that of the page, in Markdown; figures lie
    beside it and carry the names of the sweeps' folders.
    """
    names = [data.root.resolve().name for data in sweeps]
    if len(set(names)) < len(names):
        msg = f"folders of different names, whose figures do not overwrite one another, not {', '.join(names)}"
        raise FigureError(msg)
    written, sections, points = list[Path](), dict[str, str](), dict[str, DataFrame]()
    for folder, data in zip(names, sweeps, strict=True):
        parts = [provenance_line(data.table), _sizes(data), ""]
        for name, drawing in drawings_of(data):
            stem = path.with_name(f"paper-{folder}-{name}")
            written += save_drawing(drawing, stem, page=True)
            parts += drawing.shown(stem)
        written.append(output.save(path.with_name(f"paper-{folder}-points.csv"), claim_points(data.points)))
        sections[folder], points[folder] = "\n".join(parts).strip(), stored_points(written[-1])
    return [output.save(path, page_text(sections, points)), *written]


def page_text(sections: Mapping[str, str], points: Mapping[str, DataFrame]) -> str:
    """A page in Markdown: a summary of the claims, the figures, and all verdicts.

    A section is what stands below the name of each sweep, figures and where they come from; each is judged by the table
    of its points.
    """
    verdicts = {name: claim_verdicts(points[name]) for name in sections}
    parts = ["# The paper's figures and claims, from stored sweeps\n", _answer(list(verdicts.values())), ""]
    for name, section in sections.items():
        parts += [f"## Sweep `{name}`\n", section, ""]
    parts += ["## Verdicts\n", _matrix(verdicts, points), ""]
    for name, found in verdicts.items():
        parts += [f"### Verdicts of `{name}`\n", *_told(found)]
    return "\n".join(parts).rstrip() + "\n"


def _answer(verdicts: Sequence[list[tuple[Claim, Finding]]]) -> str:
    """Summary of the verdicts: each claim once, by its worst verdict, with the number of sweeps."""
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


def _told(found: Sequence[tuple[Claim, Finding]]) -> Iterator[str]:
    """The verdicts of a sweep with their numbers, and the claims that it does not test, by reason."""
    if tested := [(claim, finding) for claim, finding in found if finding.word != "not tested"]:
        yield verdict_sheet(tested).markdown() + "\n"
    reasons: dict[str, list[str]] = {}
    for claim, finding in found:
        if finding.word == "not tested":
            reasons.setdefault(finding.found, []).append(claim.text)
    for reason, claims in reasons.items():
        yield f"*Not tested*, {reason}: {'; '.join(claims)}.\n"


def _matrix(verdicts: Mapping[str, list[tuple[Claim, Finding]]], points: Mapping[str, DataFrame]) -> str:
    """Matrix of claims and sweeps with their bandwidths; each cell is a verdict linked to the sweep."""

    def cell(folder: str, finding: Finding) -> str:
        place = f"sweep-{re.sub(r'[^a-z0-9-]', '', folder.lower())}"
        return f"[{finding.word}](#{place})" if finding.points else "-"

    widths = [points[name].lambda_L / points[name].lambda_s for name in verdicts]
    ends = [dict.fromkeys((f"{width.min():g}", f"{width.max():g}")) for width in widths]
    rows = [("*bandwidths λ_L/λ_s*", *map(" - ".join, ends))]
    for claims in zip(*verdicts.values(), strict=True):
        rows.append((claims[0][0].text, *(cell(name, one[1]) for name, one in zip(verdicts, claims, strict=True))))
    return Sheet.of("All verdicts", ("claim of the paper", *verdicts), rows).markdown()


def drawings_of(data: SweepData) -> Iterator[tuple[str, Drawing]]:
    """The figures of a sweep that it has points for, with their names."""
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
    """Text about the progress of a sweep, its versions and its time."""
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
        f"λ_L = {in_order(points.lambda_L)} a0; λ_L/λ_s = {in_order(points.lambda_L / points.lambda_s)}; "
        f"l_a = {in_order(points.length)} a0. {points.valid.sum()} points have A_rep >= 10 λ_s². κ is read at the "
        "first of them from 1 % area on."
    )
