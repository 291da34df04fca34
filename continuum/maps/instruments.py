"""Read files of instruments and containers of contact.engineering by SurfaceTopography, which knows their units.

It is an extra: ``pip install 'stickiness[topography]'``.  A file that cannot be read raises TopographyError.
"""

import warnings
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import util
from pathlib import Path
from typing import Any

import numpy as np

from continuum.inputs import units
from continuum.inputs.arguments import file_name
from continuum.maps.map import TopographyError
from continuum.maps.older_forms import understood_form
from continuum.store.heights import RawMap, evenly_spaced

ALL = "all"
"""Stands for all measurements of a container, joined, in place of the name of a part."""


def measurements(path: Path) -> tuple[str, ...]:
    """Names of the measurements of a container; empty for any other file."""
    if not (file_name("path", path).is_file() and is_container(path)):
        return ()
    with _opened(path) as maps:
        return tuple(maps)


def from_instrument(path: Path, part: str | None) -> RawMap:
    """Read a map by SurfaceTopography: heights as in the file, size and unit in m if it has them."""
    with _opened(path) as maps:
        chosen = [name for name in maps if part is None or name == part]
        if len(chosen) == 1:
            return maps[chosen[0]]()
        if chosen and part is None and not is_container(path):
            # The first height channel is the one that an instrument shows; others are other scan directions.
            others = ", ".join(map(repr, chosen[1:]))
            return maps[chosen[0]]()._replace(steps=(f"channel {chosen[0]!r} taken, not {others}",))
    names = ", ".join(map(repr, maps)) or "none"
    none = f"holds no map named {part!r}" if part else "holds no map"
    several = f"holds {len(chosen)} maps, choose one by `part`, or all by `part` {ALL!r}"
    raise TopographyError(f"{path}: {several if chosen else none}; maps: {names}")


@contextmanager
def _opened(path: Path) -> Iterator[dict[str, Callable[[], RawMap]]]:
    """Open a file, and yield its maps of heights by name."""
    if util.find_spec("SurfaceTopography") is None:
        raise TopographyError(
            f"{path}: to read this format install SurfaceTopography (pip install 'stickiness[topography]'), "
            "or save the map as .npy or text"
        )
    with warnings.catch_warnings(), ExitStack() as stack:
        warnings.simplefilter("ignore")  # of imports, and of formats that are guessed
        try:
            yield _maps(path, stack)
        except Exception as error:  # readers of vendors' formats may raise anything
            unknown = type(error).__name__ == "CannotDetectFileFormat"
            reason = "none of its formats" if unknown else str(error) or type(error).__name__
            raise TopographyError(f"{path}: SurfaceTopography cannot read it: {reason}") from error


def is_known(path: Path) -> bool:
    """True if a file has an instrument's format, rather than plain numbers or general HDF5."""
    if util.find_spec("SurfaceTopography") is None:
        return False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from SurfaceTopography.IO import detect_format

        try:
            return is_container(path) or detect_format(understood_form(path)) not in ("asc", "xyz", "matrix", "h5")
        except TopographyError:
            raise
        except Exception:  # readers of vendors' formats may raise anything
            return False


def is_container(path: Path) -> bool:
    """True if a file is a container of contact.engineering."""
    if not zipfile.is_zipfile(path):
        return False
    with zipfile.ZipFile(path) as archive:
        return "meta.yml" in archive.namelist()


def _maps(path: Path, stack: ExitStack) -> dict[str, Callable[[], RawMap]]:
    if is_container(path):
        from SurfaceTopography.Container.IO import read_container

        members = [member for surface in read_container(str(path)) for member in surface]
        names = [str(member.info.get("name", i)) for i, member in enumerate(members)]
        return {name: partial(_values, path, name, member) for name, member in zip(names, members, strict=True)}
    from SurfaceTopography import open_topography

    reader = open_topography(understood_form(path))
    stack.callback(reader.close)
    return {c.channel_id: partial(_load, path, reader, c) for c in reader.height_channels}


def _load(path: Path, reader: Any, channel: Any) -> RawMap:
    """Read a channel; a missing size or unit is set to 1 and dropped afterwards."""
    size, unit = channel.physical_sizes, channel.unit
    given: dict[str, Any] = {} if size is not None else {"physical_sizes": (1.0,) * channel.dim}
    given |= {} if unit is not None else {"unit": "m"}
    found = _values(path, None, reader.topography(channel_index=channel.index, **given))
    scale = None if unit is None else found.unit
    return found._replace(size=None if size is None or scale is None else found.size, unit=scale)


def _values(path: Path, name: str | None, measured: Any) -> RawMap:
    """Heights from SurfaceTopography, holes as NaN."""
    scale = units.unit_size(str(measured.unit), "length")
    lengths = tuple(float(length) * scale for length in measured.physical_sizes)
    source = path.name if name is None else f"{path.name}: {name}"
    if not measured.is_uniform:
        heights, steps = evenly_spaced(*(np.asarray(one, dtype=np.float64) for one in measured.positions_and_heights()))
        return RawMap(heights, source, lengths, scale, bool(measured.is_periodic), steps)
    heights = np.ma.filled(np.ma.asarray(measured.heights(), dtype=np.float64), np.nan)
    return RawMap(heights, source, lengths, scale, bool(measured.is_periodic))
