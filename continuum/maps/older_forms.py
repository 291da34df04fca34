"""Files of instruments in a form that SurfaceTopography does not know, in one that it does.

Surface data files (ISO 25178-71) have their version in the first word: those of its predecessors, by NPL and BCR, have
the same fields.  Gwyddion's own program exports the latter.  Texts in a Gwyddion file (.gwy) are UTF-8, which some
programs do not heed: those are read as Latin-1, without what is not ASCII.
"""

import re
import struct
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from continuum.maps.map import TopographyError

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
