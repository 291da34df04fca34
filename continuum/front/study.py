"""Rank samples by stickiness: every spot of a study is one contact."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from continuum.front.predict import predict
from continuum.inputs.arguments import ArgumentError, file_name
from continuum.inputs.errors import InputError
from continuum.maps.quantities import PER_MAP
from continuum.maps.verdict.materials import InterfaceError, read_interface
from continuum.maps.verdict.study import Scan, Spot, StudyNumbers, ranked, scans
from continuum.maps.verdict.tables import OPTIONS, InterfaceTable
from continuum.show.study import study_sheets
from continuum.store.sheet import Sheet, Shown

_KNOWN = (frozenset(OPTIONS) - {"join"}) | {"solve", "threads"}


class Study(StudyNumbers, Shown):
    """A study that shows itself."""

    def sheets(self) -> list[Sheet]:
        """The ranking, and its spots."""
        return study_sheets(self)

    def write(self, folder: str | Path, name: str) -> list[Path]:
        """Write ``NAME.html`` with its figure, and ``NAME.csv`` and ``NAME-spots.csv``; returns their paths.

        Raises
        ------
        OutputError
            If they cannot be written there.
        """
        from continuum.show.study_page import write_study  # draws

        return write_study(self, Path(folder), name)


def study(
    folder: str | Path,
    *,
    pattern: str | None = None,
    without: str | Path | None = None,
    progress: Callable[[Spot], None] = lambda spot: None,
    **options: Any,
) -> Study:
    """Rank the samples in a folder of maps by their stickiness.

    Parameters
    ----------
    folder : folder of the maps, named SAMPLE_SPOT_MAGNIFICATION, or with a table ``study.csv`` of the columns file,
        sample, spot, magnification, size, unit, dataset and part, of which file and sample are needed.
    pattern : pattern of the names without their ending, such as ``"{sample}-{spot}-{magnification}"``.
    without : a folder inside it that is left out.
    progress : called with each finished spot.
    options : as in :func:`continuum.predict`, without join; the same for all spots, and solve is False by default:
        thresholds are not searched for.

    Raises
    ------
    InputError
        If there is no map, names do not fit the pattern, or the contact cannot be used.
    ArgumentError
        If an argument is unknown or of another type.
    """
    place = file_name("folder", folder)
    if not place.is_dir():
        raise InputError(f"{place}: there is no such folder")
    unknown = next((name for name in options if name not in _KNOWN), None)
    if unknown is not None:
        raise ArgumentError(unknown, options[unknown], f"no argument has this name; known: {', '.join(sorted(_KNOWN))}")
    read_interface(**{name: options[name] for name in InterfaceTable.model_fields if options.get(name) is not None})
    found: dict[tuple[str, str], list[Scan]] = {}
    for scan in scans(place, pattern, None if without is None else file_name("without", without)):
        found.setdefault((scan.sample, scan.spot), []).append(scan)
    spots = []
    for (sample, name), files in found.items():
        spots.append(_spot(sample, name, files, options))
        progress(spots[-1])
    rank = ranked(place, spots)
    return Study(rank.folder, rank.samples, rank.scatter)


def _spot(sample: str, name: str, files: Sequence[Scan], options: dict[str, Any]) -> Spot:
    """A spot with its magnifications joined, or the reason why one of its files cannot be used."""
    told = dict(options)
    for key in PER_MAP:
        common = told.get(key)
        same = "-" if not common else common if isinstance(common, str) else common[0]
        if any(key in scan.options for scan in files):
            told[key] = [scan.options.get(key, same) for scan in files]
    told["solve"] = bool(told.get("solve"))
    paths = [scan.path for scan in files]
    names = tuple(path.name for path in paths)
    try:
        return Spot(sample, name, names, predict(*paths, join=len(paths) > 1, **told))
    except (InterfaceError, ArgumentError):
        raise  # the same for all
    except InputError as error:
        return Spot(sample, name, names, None, str(error))
