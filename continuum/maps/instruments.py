"""Read files of instruments and containers of contact.engineering by SurfaceTopography, which knows their units.

It is an extra: ``pip install 'stickiness[topography]'``.  A file that cannot be read raises TopographyError.

:func:`understood_form` puts files that SurfaceTopography does not know into a form that it does.  Surface data files
(ISO 25178-71) have their version in the first word: those of its predecessors, by NPL and BCR, have the same fields.
Gwyddion's own program exports the latter.  Texts in a Gwyddion file (.gwy) are UTF-8, which some programs do not heed:
those are read as Latin-1, without what is not ASCII.
"""

import re
import struct
import warnings
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import util
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from continuum.inputs import units
from continuum.inputs.arguments import file_name
from continuum.maps.map import TopographyError
from continuum.store.heights import RawMap, evenly_spaced

_SDF = re.compile(rb"a(?!ISO-1\.0)\w{3}-[V\d][\w.]*|b(?!ISO-1\.0)\w{3}-[V\d][\w.]{2}")
"""The version of a surface data file that is not of ISO 25178-71: a word, or 8 bytes, which the maker's name follows
at once, of a binary file."""
_ALIKE = {b"aNPL-V1.0": b"aISO-1.0"} | {b"%cBCR-%c.0" % (a, v): b"%cISO-1.0" % a for a in b"ab" for v in b"01"}
"""Versions with the same fields, and what they are read as."""
_GWY = b"GWYP"
_SIZES = {"b": 1, "c": 1, "i": 4, "q": 8, "d": 8}
"""Bytes of the types of a Gwyddion file; arrays of them have capital letters, and their length first."""
_PLAIN = {0xB5: ord("u"), 0xC5: ord("A"), 0xE5: ord("a")}
"""Letters in ASCII for µ and Å in Latin-1."""


def understood_form(path: Path) -> str | BinaryIO:
    """The file, or its content in a form that SurfaceTopography can read.

    Raises TopographyError for a surface data file of an unknown version.
    """
    with path.open("rb") as file:
        start = file.read(16)
        version = _SDF.match(start)
        # Only files of these two formats are read whole, and changed in memory.
        if version is None and not start.startswith(_GWY):
            return str(path)
        file.seek(0)
        raw = file.read()
    if version is None:
        plain = _with_plain_texts(raw)
        return str(path) if plain is None else BytesIO(plain)
    if version[0] not in _ALIKE:
        raise TopographyError(
            f"{path}: a surface data file of the unknown version {version[0].decode()}: "
            "open it in the program that wrote it, or in Gwyddion, and save it as text or .gwy"
        )
    return BytesIO(raw.replace(version[0], _ALIKE[version[0]], 1))


def _with_plain_texts(raw: bytes) -> bytes | None:
    """A Gwyddion file whose texts are ASCII; None if they are UTF-8 already, or the file is damaged."""
    found = bytearray(raw)
    try:
        return bytes(found) if _object(found, len(_GWY))[1] else None
    except (ValueError, struct.error, KeyError):
        return None  # its reader says what is wrong


def _text(raw: bytearray, at: int) -> tuple[int, bool]:
    """End of a text, and True if it was changed."""
    end = raw.index(0, at)
    try:
        raw[at:end].decode("utf-8")
    except UnicodeDecodeError:
        raw[at:end] = bytes(byte if byte < 0x80 else _PLAIN.get(byte, ord("?")) for byte in raw[at:end])
        return end + 1, True
    return end + 1, False


def _object(raw: bytearray, at: int) -> tuple[int, bool]:
    """End of an object, and True if a text in it was changed."""
    at, changed = _text(raw, at)
    (size,) = struct.unpack_from("<L", raw, at)
    at += 4
    end = at + size
    if end > len(raw):
        raise ValueError("the file ends within an object")
    while at < end:
        at, one = _text(raw, at)
        kind = chr(raw[at])
        at, other = _component(raw, at + 1, kind)
        changed |= one | other
    return end, changed


def _component(raw: bytearray, at: int, kind: str) -> tuple[int, bool]:
    """End of the value of a component, and True if a text in it was changed."""
    if kind in _SIZES:
        return at + _SIZES[kind], False
    if kind in "so":
        return (_text if kind == "s" else _object)(raw, at)
    (count,) = struct.unpack_from("<L", raw, at)
    at += 4
    if kind not in "SO":
        return at + count * _SIZES[kind.lower()], False
    changed = False
    for _ in range(count):
        at, one = (_text if kind == "S" else _object)(raw, at)
        changed |= one
    return at, changed


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
