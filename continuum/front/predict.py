"""Predict whether a contact of measured topographies is sticky, and rank the samples of a study."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, get_args

from numpy.typing import ArrayLike

from continuum.inputs.arguments import ArgumentError, choice, count, file_name, flag, hinted
from continuum.inputs.errors import InputError
from continuum.inputs.reading import load
from continuum.inputs.toml import find
from continuum.maps.map import PER_MAP, Topography, TopographyError, length_of, share
from continuum.maps.mending import Detrending, prepare
from continuum.maps.reading import read_all
from continuum.maps.verdict.materials import InterfaceError, read_interface
from continuum.maps.verdict.prediction import PredictionNumbers, prediction_of
from continuum.maps.verdict.study import Scan, Spot, StudyNumbers, ranked, scans
from continuum.maps.verdict.tables import OPTIONS, InterfaceTable, PredictionInput
from continuum.show.answer import statements
from continuum.show.prediction import prediction_sheets, study_sheets
from continuum.show.prediction_data import as_json, row
from continuum.solve.solution import MOST_THREADS
from continuum.store.sheet import Sheet, Shown

READ = frozenset(OPTIONS) & frozenset(inspect.signature(read_all).parameters)
"""Arguments for reading the maps."""


class Prediction(PredictionNumbers):
    """A prediction, with its sentence, tables, figures and pages."""

    @property
    def sentence(self) -> str:
        """The statements of :func:`continuum.show.answer.statements` in one text."""
        return ".  ".join(statements(self))

    def sheets(self) -> list[Sheet]:
        """Tables of surface, contact, verdicts and numbers."""
        return prediction_sheets(self)

    def json(self) -> str:
        """All results, with the whole spectrum, in SI units."""
        return as_json(self)

    def row(self) -> dict[str, str | float | None]:
        """One row of a table, in SI units."""
        return row(self)

    def write(self, folder: str | Path, name: str) -> list[Path]:
        """Write ``NAME.html`` and its figures; returns HTML and PNG files.

        Raises
        ------
        OutputError
            If they cannot be written there.
        """
        from continuum.show.prediction_figures import write_prediction  # draws, for which the answer need not wait

        return write_prediction(self, Path(folder), name)

    def _repr_html_(self) -> str:
        return f"<p>{self.sentence}</p>{self.sheets()[3]._repr_html_()}"


@hinted
def predict(
    *maps: str | Path | ArrayLike,
    size: str | Sequence[str] | None = None,
    unit: str | Sequence[str] | None = None,
    dataset: str | Sequence[str] | None = None,
    part: str | Sequence[str] | None = None,
    join: bool = False,
    periodic: bool = False,
    override_size: bool = False,
    detrend: Detrending | None = None,
    fill: str | float | None = None,
    void: str | float | Sequence[str | float] = (),
    crop: str | None = None,
    cutoff: str | None = None,
    tip: str | None = None,
    smallest: str | None = None,
    material: str | Sequence[str] = (),
    modulus: str | Sequence[str] = (),
    poisson: str | float | Sequence[str | float] = (),
    contact_modulus: str | None = None,
    work: str | None = None,
    range: str | None = None,
    spacing: str | None = None,
    probe: str | None = None,
    pressure: str | None = None,
    load: str | None = None,
    coating: str | None = None,
    solve: bool | None = None,
    threads: int = 1,
) -> Prediction:
    """Predict whether a measured surface is sticky, from its contact without adhesion, and compare with theories.

    Every quantity is a text with its unit, as ``"50mJ/m2"``.

    Parameters
    ----------
    maps : one topography, or two for two rough bodies: file names (``inputs/...`` finds what comes with the package),
        or arrays of heights, shape (nx, ny), positive out of the body.  Masked points of an array are missing; an array
        of one row or column is a line scan, one of two or three columns has positions and heights.  Or one input (TOML)
        with the tables [topography] and [interface]: other arguments overrule its keys.
    size, unit, dataset, part, join, periodic, override_size, detrend, fill, void, crop, cutoff, tip, smallest : as the
        keys of ``[topography]`` in an input, in their units; an array needs size and unit.  For two maps give one text
        for both, or one for each, where ``"-"`` leaves it to the file.
    material, modulus, poisson, contact_modulus, work, range, spacing, probe, pressure, load, coating : as the keys of
        ``[interface]`` in an input, in their units.
    solve : whether to search for the threshold with adhesion, after the state without adhesion that estimates it; by
        default only if this state does not decide and the search is expected to take at most about a minute.
    threads : threads of the solver.

    Raises
    ------
    TopographyError, InterfaceError
        If a map or the contact cannot be used.
    ArgumentError
        If an argument is of another type, such as a number instead of a text with its unit.

    Examples
    --------
    >>> import numpy as np, continuum as c
    >>> grid = c.Grid.square(64)  # heights below in nm
    >>> heights = c.SelfAffine(0.8, 0.1, 8, 32).synthesise(grid, np.random.default_rng(1))
    >>> contact = {"material": ["silicon", "silicon"], "work": "300mJ/m2"}
    >>> found = c.predict(heights, size="64nm", unit="nm", periodic=True, **contact)
    >>> found.sentence.partition(":")[0]
    'Sticky'
    """
    given = {name: value for name, value in locals().items() if name in OPTIONS}
    if solve is not None:
        flag("solve", solve)
    count("threads", threads, 1, MOST_THREADS)
    return unsolved(maps, given).solved(threads, solve)


def unsolved(
    maps: Sequence[str | Path | ArrayLike], given: Mapping[str, Any], told: Callable[[str], None] = lambda text: None
) -> Prediction:
    """The prediction for maps or for an input, before anything is pressed.

    Parameters
    ----------
    maps : see :func:`predict`.
    given : arguments of :func:`predict` by name, of which those of the maps and of the interface are used.
    told : called with a text once the maps are read.
    """
    if len(maps) == 1 and isinstance(maps[0], str | Path) and str(maps[0]).endswith(".toml"):
        config = load(maps[0], PredictionInput)
        # Defaults overrule no key of the file.  By `is`, as == of an array has no one truth value.
        beside = {name: value for name, value in given.items() if not any(value is left for left in (None, (), False))}
        maps, given = config.topography.maps, {**given, **config.keys, **beside}
    return of_maps([find(file_name("maps", one)) if isinstance(one, str | Path) else one for one in maps], given, told)


def prepared(
    maps: Sequence[str | Path | ArrayLike], given: Mapping[str, Any]
) -> tuple[list[Topography], list[Topography]]:
    """Maps as measured, and as they are judged; the arguments are those of :func:`of_maps`."""
    detrend, limit = given.get("detrend"), share(given.get("fill"))
    if detrend is not None:
        choice("detrend", detrend, get_args(Detrending))
    measured = read_all(maps, **{name: given[name] for name in READ if name in given})
    return measured, [prepare(one, detrend, fill=limit, cutoff=given.get("cutoff")) for one in measured]


def of_maps(
    maps: Sequence[str | Path | ArrayLike],
    given: Mapping[str, Any],
    told: Callable[[str], None] = lambda text: None,
    prepared: Callable[..., tuple[list[Topography], list[Topography]]] = prepared,
) -> Prediction:
    """The prediction for maps, before anything is pressed.

    Parameters
    ----------
    maps : see :func:`predict`; any file is read as a map, never as an input.
    given : arguments of :func:`predict` by name; the others are left out.
    told : called with a text once the maps are read.
    prepared : reads and prepares them, in place of :func:`prepared`.
    """
    contact_of = partial(read_interface, **{name: given[name] for name in InterfaceTable.model_fields if name in given})
    try:
        measured, ready = prepared(maps, given)
    except TopographyError as error:
        try:
            contact_of()
        except InterfaceError as other:  # the faults of both at once
            raise TopographyError(f"{error}\n{other}") from error
        raise
    contact = contact_of()
    tip_radius, shortest = (length_of(name, given.get(name)) for name in ("tip", "smallest"))
    shapes = (f"{one.source}, {' x '.join(map(str, one.heights.shape))} points" for one in measured)
    told(f"looking at {' and at '.join(shapes)}; {contact.values}")
    return prediction_of(ready, contact, shortest, tip_radius, Prediction)


_KNOWN = (frozenset(OPTIONS) - {"join"}) | {"solve", "threads"}


class Study(StudyNumbers, Shown):
    """A study of several samples, with its tables and pages."""

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
        from continuum.show.prediction_figures import write_study  # draws

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
    # A fault of the interface is that of every spot: it is told once, before any map is read.
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
        # A file without an entry in the table keeps the option for all, and without that what it says itself.
        if any(key in scan.options for scan in files):
            told[key] = [scan.options.get(key, same) for scan in files]
    told["solve"] = bool(told.get("solve"))
    paths = [scan.path for scan in files]
    names = tuple(path.name for path in paths)
    try:
        return Spot(sample, name, names, predict(*paths, join=len(paths) > 1, **told))
    except (InterfaceError, ArgumentError):
        raise  # the same for all
    except InputError as error:  # a map that cannot be used costs its spot, not the study
        return Spot(sample, name, names, None, str(error))
