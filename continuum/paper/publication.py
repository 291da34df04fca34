"""A folder of a sweep for an archive such as Zenodo: page, tables, input, and metadata.

Archives require a flat folder: ``index.html`` with its figures, ``table.csv``, ``table.nc``,
``sweep.toml``, ``.zenodo.json``, ``ro-crate-metadata.json``, and
``SHA256SUMS``, by which the folder is recognised and can be checked.
"""

import hashlib
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from continuum.front.sweeps import sweep_collect
from continuum.inputs.arguments import ArgumentError, file_name, flag
from continuum.inputs.errors import OutputError
from continuum.paper.crate import CRATE, Creator, crate, software_identifier
from continuum.store import output as files
from continuum.store.provenance import Citation, now, provenance
from continuum.store.sweeps.collect import LeftOutWarning, PointTable
from continuum.store.sweeps.folder import Folder

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
    """What to correct before publication."""


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
    from continuum.paper.publication_page import (  # pandas and Matplotlib, which take a second
        Metadata,
        write_publication_page,
    )

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
        write_publication_page(root, found, draft, about, citation, doubts)
        written = {path.name: path.read_bytes() for path in sorted(draft.iterdir())}
        whole = crate(about.title, about.description, about.creators, license, citation, software, now()[:10], written)
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
