"""A folder of a sweep for an archive such as Zenodo: page, tables, input, and metadata.

Archives require a flat folder: ``index.html`` with its figures, ``table.csv``, ``table.nc``,
``sweep.toml``, ``.zenodo.json``, ``ro-crate-metadata.json``, and
``SHA256SUMS``, by which the folder is recognised and can be checked.

``ro-crate-metadata.json`` is an RO-Crate, https://w3id.org/ro/crate/1.1, which data portals read.  Its graph names the
data set with its authors and licence, each file, and the program as the instrument that made them.
"""

import hashlib
import html
import json
import mimetypes
import re
import shlex
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from continuum.front.sweeps import sweep_collect
from continuum.inputs.arguments import ArgumentError, file_name, flag
from continuum.inputs.errors import OutputError
from continuum.paper.claims import claim_verdicts, verdict_sheet
from continuum.paper.figures import save_drawing
from continuum.paper.page import drawings_of, provenance_line
from continuum.paper.points import SweepData
from continuum.show.page import Page
from continuum.store import output as files
from continuum.store.provenance import Citation, now, provenance
from continuum.store.sheet import Column, Sheet, pairs
from continuum.store.sweeps.collect import LeftOutWarning, PointTable
from continuum.store.sweeps.crossings import crossings_sheet
from continuum.store.sweeps.folder import Folder

CRATE = "ro-crate-metadata.json"
_ORCID = re.compile(r"(.*?)[;\s(]*(?:https://orcid\.org/)?(\d{4}-\d{4}-\d{4}-\d{3}[\dX])\)?\s*")


class Creator(NamedTuple):
    """An author of data."""

    name: str
    """Name as "Family, Given"."""
    orcid: str = ""
    """ORCID as 0000-0002-1825-0097; empty if it is not known."""

    @classmethod
    def of(cls, text: str) -> "Creator":
        """The author of "Family, Given", with an ORCID after it or not; ArgumentError if that is misspelt."""
        found = _ORCID.fullmatch(text)
        if found is None:
            return cls(text)
        name, orcid = found.groups()
        if not name or _check_digit(orcid) != orcid[-1]:
            raise ArgumentError("creators", text, '"Family, Given; 0000-0002-1825-0097": a digit of the ORCID is wrong')
        return cls(name, orcid)

    @property
    def text(self) -> str:
        return f"{self.name}; {self.orcid}" if self.orcid else self.name

    @property
    def zenodo(self) -> dict[str, str]:
        return {"name": self.name, **({"orcid": self.orcid} if self.orcid else {})}


def _check_digit(orcid: str) -> str:
    """The last digit of an ORCID after ISO 7064, 11-2."""
    total = 0
    for digit in orcid.replace("-", "")[:-1]:
        total = 2 * (total + int(digit))
    left = (12 - total % 11) % 11
    return "X" if left == 10 else str(left)


def software_identifier(provenance: Mapping[str, object]) -> str:
    """The program in the Software Heritage archive, by its commit (ISO/IEC 18670); empty outside a checkout."""
    commit = str(provenance.get("provenance/git_commit", ""))
    return f"swh:1:rev:{commit}" if commit else ""


def crate(
    title: str, description: str, creators: Sequence[Creator], license: str, citation: Citation, software: str,
    date: str, files: Mapping[str, bytes], said: Mapping[str, str],
) -> str:  # fmt: skip
    """The text of ``ro-crate-metadata.json``.

    Parameters
    ----------
    software : identifier of the program; empty if there is none.
    date : of the publication, as 2026-11-28.
    files : contents of the other files of the folder, by name.
    said : what some of them hold.
    """
    people = [
        {"@id": f"https://orcid.org/{one.orcid}" if one.orcid else f"#creator-{i}", "@type": "Person", "name": one.name}
        for i, one in enumerate(creators, 1)
    ]
    program = {
        "@id": software or "#stickiness", "@type": "SoftwareApplication", "name": citation.title,
        "version": citation.version, "license": citation.license,
    }  # fmt: skip
    paper = {"@id": f"https://doi.org/{citation.doi}", "@type": "ScholarlyArticle", "name": citation.paper}
    parts = [
        {
            "@id": name, "@type": "File", "name": name, "contentSize": str(len(content)),
            "encodingFormat": _media_type(name), "sha256": hashlib.sha256(content).hexdigest(),
            **({"description": said[name]} if name in said else {}),
        }
        for name, content in sorted(files.items())
    ]  # fmt: skip
    spdx, full = _LICENCES.get(license.lower(), ("", license))
    terms = {
        "@id": f"http://spdx.org/licenses/{spdx}" if spdx else f"#{license}", "@type": "CreativeWork", "name": full,
        "identifier": license, "description": f"The terms on which all files of this data set may be used: {full}.",
    }  # fmt: skip
    root = {
        "@id": "./", "@type": "Dataset", "name": title, "description": description, "datePublished": date,
        "author": _links(people), "license": {"@id": terms["@id"]}, "citation": {"@id": paper["@id"]},
        "hasPart": _links(parts), "mentions": {"@id": "#sweep"},
    }  # fmt: skip
    made = {
        "@id": "#sweep", "@type": "CreateAction", "instrument": {"@id": program["@id"]}, "result": {"@id": "./"},
        "object": {"@id": "sweep.toml"}, "name": "continuum sweep run",
    }  # fmt: skip
    head = {
        "@id": CRATE, "@type": "CreativeWork", "about": {"@id": "./"},
        "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
    }  # fmt: skip
    graph = [head, root, *people, terms, program, paper, made, *parts]
    context = ["https://w3id.org/ro/crate/1.1/context", {"sha256": "http://schema.org/sha256"}]  # which 1.1 lacks
    whole = {"@context": context, "@graph": graph}
    return json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


_LICENCES = {
    "cc-by-4.0": ("CC-BY-4.0", "Creative Commons Attribution 4.0 International"),
    "cc-by-sa-4.0": ("CC-BY-SA-4.0", "Creative Commons Attribution Share Alike 4.0 International"),
    "cc-zero": ("CC0-1.0", "Creative Commons Zero v1.0 Universal"),
    "cc0-1.0": ("CC0-1.0", "Creative Commons Zero v1.0 Universal"),
    "mit": ("MIT", "MIT License"),
}
"""Identifier and name in the list of SPDX of licences by their Zenodo names; others keep these."""


def _media_type(name: str) -> str:
    """The media type of a file; ``mimetypes`` of Python 3.11 has none of TOML."""
    known = "application/toml" if name.endswith(".toml") else mimetypes.guess_type(name)[0]
    return known or "application/octet-stream"


def _links(entities: Sequence[Mapping[str, Any]]) -> dict[str, Any] | list[dict[str, Any]]:
    """Links to entities; to a single one without a list, as compact JSON-LD has it."""
    links = [{"@id": one["@id"]} for one in entities]
    return links if len(links) > 1 else links[0]


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
) -> dict[str, str]:
    """Write ``index.html`` and its figures; returns what files of the folder hold, by their names.

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
    return {"index.html": "the page: figures, verdicts, and how to cite", **said}


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


SUMS = "SHA256SUMS"
_MARK = f"# written by `continuum sweep publish`; checked by `sha256sum -c {SUMS}`\n"


@dataclass(frozen=True)
class Publication:
    """A published sweep."""

    folder: Path
    files: tuple[Path, ...]
    """Files of the folder, the page first."""
    table: PointTable
    warnings: tuple[str, ...]
    """Points to correct before publication."""


def sweep_publish(
    sweep: str | Path,
    output: str | Path = "published",
    *,
    title: str | None = None,
    creators: Sequence[str] = (),
    license: str = "cc-by-4.0",
    force: bool = False,
) -> Publication:
    """Write one folder of a sweep for an archive: page with figures and verdicts, tables, input, metadata for Zenodo.

    Parameters
    ----------
    sweep : folder of the sweep.
    output : folder to write: new, empty, or written by an earlier call.
    title : title of the data (default: from the name of the sweep).
    creators : authors of the data, as "Family, Given" or "Family, Given; ORCID" (default: those of the program).
    license : licence of the data, by its Zenodo name.
    force : write into a folder with other files, and overwrite changed files.

    Raises SweepError or FigureError if there is no sweep, or no system of it is done; OutputError if the folder holds
    files that are not of an earlier call or were changed since, or cannot be written to; ArgumentError if an argument
    is not allowed.
    """
    root, place = file_name("sweep", sweep), file_name("output", output)
    title, license = None if title is None else _line("title", title), _line("license", license)
    if isinstance(creators, str) or not isinstance(creators, Sequence):
        raise ArgumentError("creators", creators, 'names, each as "Family, Given"')
    names = tuple(Creator.of(_line("creators", name)) for name in creators)
    software = software_identifier(provenance())
    citation, before = Citation.read(), {} if flag("force", force) else _earlier(place)
    with TemporaryDirectory() as made, warnings.catch_warnings():
        warnings.simplefilter("ignore", LeftOutWarning)  # the page and the result say it
        draft = Path(made)
        found = sweep_collect(root, draft)
        files.distinct(place / "sweep.toml", [Folder(root).description])
        name = found.listing.name
        authors = names or tuple(map(Creator, citation.authors))
        about = Metadata(title or f"Sweep {name}: adhesive contacts", authors, license, _description(found))
        files.save(draft / "sweep.toml", Folder(root).description.read_bytes())
        for column in found.listing.columns:
            files.save(draft / column.file_name, (Folder(root).columns / column.file_name).read_bytes())
        _as_netcdf(found, draft / "table.h5")
        files.save(draft / ".zenodo.json", about.zenodo(citation.doi, software))
        doubts = _doubts(found)
        said = write_publication_page(root, found, draft, about, citation, doubts)
        written = {path.name: path.read_bytes() for path in sorted(draft.iterdir())}
        given = about.title, about.description, about.creators, license, citation, software, now()[:10]
        whole = crate(*given, written, said)
        written[CRATE] = whole.encode()
    if not force:
        _require_ours(place, written, before)
    paths = _replaced(place, written, before)
    unnamed = () if names else ("the creators are those of the program; name yours with --creator 'Family, Given'",)
    return Publication(place, paths, found, (*doubts, *unnamed))


def _line(name: str, value: object) -> str:
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise ArgumentError(name, value, "a line of text")
    return value.strip()


def _description(found: PointTable) -> str:
    axes = ", ".join(key for axis in found.listing.axes for key in axis.keys)
    return (
        f"{len(found.system)} equilibria of {len(found.keys)} adhesive contacts, solved by Green's functions; "
        f"a sweep over {axes or 'nothing'}. Lengths are in units of the atomic spacing a0, pressures of the contact "
        "modulus E*. The page index.html has figures and how to cite, table.csv has a row for each equilibrium, and "
        "sweep.toml is the input, from which the program makes all of it again."
    )


def _doubts(found: PointTable) -> tuple[str, ...]:
    """Warnings for readers of the folder."""
    said = [*found.faults, *found.lacking]
    if found.missing:
        said.append(f"{found.missing} of {len(found.listing.systems)} systems are not done")
    each = (found.listing.common, *(system.settings for system in found.listing.systems))
    read = sorted({Path(str(value)).name for given in each for value in _paths(given)})
    if read:
        said.append(f"the input reads files that are not part of this folder: {', '.join(read)}")
    return tuple(said)


def _paths(given: Mapping[str, object]) -> list[object]:
    """Names of files in settings, also within whole tables."""
    inside = [path for value in given.values() if isinstance(value, Mapping) for path in _paths(value)]
    named = re.compile(r"(.*\.)?path(\.name)?")
    return inside + [value for key, value in given.items() if named.fullmatch(key) and isinstance(value, str)]


def _as_netcdf(found: PointTable, cube: Path) -> None:
    """Replace ``table.h5`` by ``table.nc``, a classic netCDF file."""
    data = found.to_xarray()
    said = {f"written_with_{name.rpartition('/')[2]}": value for name, value in provenance().items()}
    data = data.assign_attrs({name: int(value) if isinstance(value, bool) else value for name, value in said.items()})
    data.to_netcdf(cube.with_suffix(".nc"), engine="scipy")
    cube.unlink()


def _earlier(place: Path) -> dict[str, str]:
    """Checksums of the files of an earlier call, by name; raises OutputError if another program wrote the folder."""
    if not place.is_dir() or not any(place.iterdir()):
        return {}
    text = (place / SUMS).read_text(errors="replace") if (place / SUMS).is_file() else ""
    if not text.startswith(_MARK):
        raise OutputError(
            f"{place}: holds files that `continuum sweep publish` has not written, and is left alone; choose another "
            "folder with --output, or write into this one with --force"
        )
    return {name: digest for digest, name in re.findall(r"^([0-9a-f]{64})  ([^/\n]+)$", text, re.MULTILINE)}


def _require_ours(place: Path, written: Mapping[str, bytes], before: Mapping[str, str]) -> None:
    """Check that files to overwrite or remove are unchanged since an earlier call."""
    for name in sorted({*written, *before}):
        there = place / name
        ours = there.is_file() and hashlib.sha256(there.read_bytes()).hexdigest() == before.get(name)
        if there.exists() and not ours:
            raise OutputError(
                f"{there}: is not as `continuum sweep publish` has written it, and is left alone; choose "
                "another folder with --output, or write over it with --force"
            )


def _replaced(place: Path, written: Mapping[str, bytes], before: Mapping[str, str]) -> tuple[Path, ...]:
    """Write the files, remove outdated ones, and write the checksums; returns the paths."""
    files.folder(place)
    for name in before.keys() - written.keys():
        (place / name).unlink(missing_ok=True)
    order = sorted(written, key=lambda name: (name != "index.html", name))
    paths = [files.save(place / name, written[name], own=True) for name in order]
    sums = "".join(f"{hashlib.sha256(written[name]).hexdigest()}  {name}\n" for name in order)
    return (*paths, files.save(place / SUMS, _MARK + sums, own=True))
