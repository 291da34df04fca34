"""The command ``continuum predict``: what they import is more than a run needs."""

import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from continuum.front import predict as predictions
from continuum.front import predict as studies
from continuum.front.options import as_options, like
from continuum.inputs.errors import InputError
from continuum.inputs.tables import explained
from continuum.maps.instruments import measurements
from continuum.maps.map import TopographyError
from continuum.maps.verdict.materials import InterfaceError
from continuum.maps.verdict.study import results_name
from continuum.maps.verdict.tables import OPTIONS, InterfaceTable, TopographyTable
from continuum.maps.verdict.threshold import Basis
from continuum.show.answer import statements
from continuum.show.console import report, tell, verbose
from continuum.show.prediction import reading_order
from continuum.show.prediction_data import as_csv
from continuum.store import output as files

_EXPLAINED = {**explained(TopographyTable), **explained(InterfaceTable)}


@like(
    predictions.predict,
    help={name: " ".join((_EXPLAINED[name].description or "").split()) for name in OPTIONS},
    draws="format of the figures beside the PNG of the page; may be repeated",
)
def predict(
    *maps: Annotated[Path, Parameter(help="topography; two for two rough bodies; an input (TOML) that names them; or "
                                          "a folder of samples, which are ranked")],
    output: Annotated[Path, Parameter(help="folder for report and figures")] = Path("results"),
    json: Annotated[Path | None, Parameter(help="file for all numbers, with the spectrum, in SI units")] = None,
    csv: Annotated[Path | None, Parameter(help="file for a table with one row for each map or measurement of a "
                                          "container, each a contact of its own; no pages are written")] = None,
    pattern: Annotated[str | None, Parameter(help="pattern of the file names in a folder, without their ending, such "
                                              "as '{sample}-{spot}-{magnification}'; by default "
                                              "'{sample}_{spot}_{magnification}' or fewer of these parts")] = None,
    solve: bool | None = None,
    threads: int = 1,
    **given: Any,
) -> int:  # fmt: skip
    if any(map(os.path.isdir, maps)):  # Path.is_dir raises for names that are too long
        beside = {"--csv": csv, "--json": json, "--join": given.pop("join", None)}
        return _study(maps, [name for name, value in beside.items() if value], output, pattern,
                      given | {"solve": solve, "threads": threads})  # fmt: skip
    if pattern is not None:
        raise InputError("--pattern applies to the files of a folder, and no folder is given")
    if csv is not None:
        return _predict_each(maps, csv, solve, threads, given)
    began = time.monotonic()
    found = predictions.unsolved(maps, given, tell)
    # Checked before hours of work, but after the input.
    files.folder(output)
    if json is not None:
        files.distinct(json, maps)
        files.folder(json.parent)
    found = found.solved(threads, solve, tell)
    tell(f"threshold found in {time.monotonic() - began:.2g} s")
    if found.threshold is not None and found.threshold.pressed is not None:
        tell("pressing to more areas, for pull-off stress, area and gap")
    report(lines=[f"{line}." for line in statements(found)])
    if verbose():
        report(*reading_order(found.sheets()), warnings=found.doubts)
    tell("drawing the figures")
    page, *_ = found.write(output, "-".join([*(path.stem for path in maps), "predict"]))
    written = [] if json is None else [files.save(json, found.json())]
    missed = solve and found.threshold is not None and found.threshold.source is not Basis.SEARCH
    return report(lines=[f"Figures, tables and {len(found.doubts)} remarks: {page}", *written], ok=not missed)


def _predict_each(maps: Sequence[Path], csv: Path, solve: bool | None, threads: int, given: dict[str, Any]) -> int:
    """Write a table: each file is a contact of its own, and one that cannot be used has the reason in its row.

    Thresholds are searched for only if that is asked for.
    """
    if given.get("join"):
        raise TopographyError(
            "--join makes one surface of all files, but --csv writes a row for each: use one of the two"
        )
    files.distinct(csv, maps)
    rows: list[dict[str, str | float | None]] = []
    for path, part in _contacts(maps, given):
        named = {"map": str(path)} if part is None else {"map": str(path), "part": part}
        try:
            found = predictions.unsolved([path], given if part is None else given | {"part": [part]})
            found = found.solved(threads, bool(solve))
        except InterfaceError:
            raise  # the same for all
        except InputError as error:
            rows.append({**named, "error": as_options(str(error), OPTIONS)})
        else:
            rows.append({**found.row(), **named})
        print(f"{': '.join(named.values())}: {rows[-1].get('verdict') or rows[-1]['error']}", flush=True)
    files.folder(csv.parent)
    return report(lines=[files.save(csv, as_csv(rows))], ok=not any("error" in row for row in rows))


def _study(
    maps: Sequence[Path], beside: Sequence[str], output: Path, pattern: str | None, given: dict[str, Any]
) -> int:
    """Rank the samples in a folder; print the ranking and write its files."""
    from continuum.show.prediction import study_doubts, study_sentence

    if len(maps) > 1 or beside:
        also = f"with {beside[0]}" if beside else f"beside {len(maps) - 1} more"
        raise InputError(f"{maps[0]}: a folder is a whole study, and cannot be used {also}")
    folder = maps[0]
    found = studies.study(
        folder, pattern=pattern, without=output, **given,
        progress=lambda spot: tell(f"{spot.sample}, spot {spot.name}: {spot.answer or spot.error}"),
    )  # fmt: skip
    files.folder(output)
    report(lines=[f"{study_sentence(found)}.", *(f"warning: {doubt}" for doubt in study_doubts(found))])
    report(*found.sheets())
    return report(lines=found.write(output, results_name(folder)), ok=not found.unusable)


def _contacts(maps: Sequence[Path], given: dict[str, Any]) -> Iterator[tuple[Path, str | None]]:
    """Each file, or each measurement of a container unless one is chosen."""
    for path in maps:
        try:
            names = () if given.get("part") else measurements(path)
        except InputError:
            names = ()  # reported when it is read
        yield from ((path, name) for name in names or [None])
