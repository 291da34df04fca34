"""The page of a published sweep: verdicts, figures, what each column holds, where it comes from, how to cite."""

import html
import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from continuum.paper.claims import claim_verdicts, verdict_sheet
from continuum.paper.crate import CRATE, Creator
from continuum.paper.figures import save_drawing
from continuum.paper.page import drawings_of, provenance_line
from continuum.paper.points import SweepData
from continuum.show.page import Page
from continuum.store.provenance import Citation, provenance
from continuum.store.sheet import Column, Sheet, pairs
from continuum.store.sweeps.collect import PointTable
from continuum.store.sweeps.crossings import crossings_sheet

_KEYWORDS = ["contact mechanics", "adhesion", "surface roughness", "tribology"]
_SAID = {
    "table.csv": "all converged points, a row each",
    "table.nc": "the same with the axes of the input, as NetCDF: xarray opens it",
    "crossings.csv": "what its searches have found, a row each",
    "sweep.toml": "the input of the sweep",
    ".zenodo.json": "metadata of this data set, as Zenodo reads them",
    CRATE: "the same for data portals, as an RO-Crate",
}


@dataclass(frozen=True)
class Metadata:
    """Metadata of a publication for an archive."""

    title: str
    creators: tuple[Creator, ...]
    license: str
    description: str

    def zenodo(self, paper: str, software: str) -> str:
        """The text of ``.zenodo.json``, which refers to the paper of this DOI and to the program, if it has a name."""
        of_program = {"identifier": software, "relation": "isCompiledBy", "resource_type": "software"}
        said = {
            "title": self.title,
            "upload_type": "dataset",
            "description": f"<p>{html.escape(self.description)}</p>",
            "creators": [one.zenodo for one in self.creators],
            "access_right": "open",
            "license": self.license,
            "keywords": _KEYWORDS,
            "related_identifiers": [
                {"identifier": paper, "relation": "references", "resource_type": "publication-article"},
                *([of_program] if software else []),
            ],
        }
        return json.dumps(said, indent=2, ensure_ascii=False) + "\n"


def write_publication_page(
    root: Path, found: PointTable, folder: Path, about: Metadata, citation: Citation, warnings: Sequence[str]
) -> None:
    """Write ``index.html`` and its figures.

    Parameters
    ----------
    root, found : folder of the sweep, and its table.
    folder : where the page goes, beside the files that are there.
    about, citation : of the data, and of the program and the paper.
    warnings : what the page says first.
    """
    data, figures, said = SweepData(found, root), [], dict(_SAID)
    for name, drawing in drawings_of(data):
        picture, numbers = save_drawing(drawing, folder / name)
        figures.append((picture, drawing.caption))
        said |= {picture.name: drawing.caption, f"{name}.pdf": "the same, to print", numbers.name: "its numbers"}
    looked = [each for each in claim_verdicts(data.points) if each[1].points]
    sheets = [verdict_sheet(looked)] if looked else []
    sheets += [crossings_sheet(found.listing, found.crossings)] if found.crossings else []
    sheets += [summary_sheet(found), _origin(found, about), _citing(about, citation)]
    there = {path.name for path in folder.iterdir()}
    Page(
        about.title, about.description, warnings, figures, sheets,
        ("sweep.toml", (folder / "sweep.toml").read_text(encoding="utf-8")), f"Licence of the data: {about.license}.",
        [(name, what) for name, what in said.items() if name in there or name == CRATE],
    ).write(folder / "index.html")  # fmt: skip


def summary_sheet(found: PointTable) -> Sheet:
    """Range of each column of the table over all systems; columns without a number are left out."""
    rows: list[tuple[str | float | int, ...]] = []
    for name, (unit, what) in found.columns.items():
        values = found[name]
        known = np.isfinite(values)
        if known.any():
            spread = (f(values[known]).item() for f in (np.min, np.median, np.max))
            rows.append((name, what, "" if unit == "1" else unit, np.unique(found.system[known]).size, *spread))
    columns = ("column", "what it is", "unit", Column("systems"), "smallest", "median", "largest")
    return Sheet.of("Columns over all systems", columns, rows)


def _origin(found: PointTable, about: Metadata) -> Sheet:
    """Commands and versions; no machine, and no folder of one."""
    versions = {name.rpartition("/")[2]: value for name, value in provenance().items()}
    dirty = " with changes" if versions.pop("git_dirty", False) else ""
    if "git_commit" in versions:
        versions["git_commit"] = f"{str(versions['git_commit'])[:12]}{dirty}"
    again = ["--title", about.title, "--license", about.license]
    again += [word for one in about.creators for word in ("--creator", one.text)]
    return pairs(
        "Where the numbers come from",
        [
            ("points", provenance_line(found)),
            ("tables and figures", ", ".join(f"{name} {value}" for name, value in versions.items())),
            ("the points again", "continuum sweep run sweep.toml -o results"),
            (
                "this folder again",
                shlex.join(["continuum", "sweep", "publish", "results/sweep", "-o", "published", *again]),
            ),
        ],
    )


def _citing(about: Metadata, citation: Citation) -> Sheet:
    names = "; ".join(one.name for one in about.creators)
    return Sheet.of(
        "How to cite",
        ("what", "reference"),
        [
            (
                "these data",
                f"{names}: {about.title}. With the DOI that the archive gives them.",
            ),
            ("the paper whose model this is", citation.paper),
            ("the program", citation.program),
        ],
    )
