"""Gwyddion and our readers agree on heights, size and unit of one map in the formats that both know."""

from __future__ import annotations

import shutil
import struct
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from continuum.maps.map import TopographyError
from continuum.maps.reading import read_topography
from tests.measured import needs_reader

GWYDDION = shutil.which("gwyddion")
HEIGHTS = np.random.default_rng(3).normal(size=(32, 20)).cumsum(0)
"""In nm, on pixels of 10 nm x 20 nm."""
SPIP = """# File Format = ASCII
# Created by SPIP
# x-pixels = 32
# y-pixels = 20
# x-length = 320
# y-length = 400
# Bit2nm = 1
# Start of Data:
"""
NOVA = """File Format = ASCII
Created by Nova
NX = 32
NY = 20
Scale X = 0.01
Scale Y = 0.02
Scale Data = 1
Unit X = um
Unit Y = um
Unit Data = nm
Start of Data :
"""
ATTOCUBE = """# Daisy Frame View Snapshot
# 2026-01-01T12:00:00
#
# x-pixels: 32
# y-pixels: 20
# x-length: 320
# y-length: 400
# x-unit: nm
# y-unit: nm
# z-unit: nm
# Start of Data:
"""
SDF = """
ManufacID = none
CreateDate = 010120261200
ModDate = 010120261200
NumPoints = 32
NumProfiles = 20
Xscale = 1E-8
Yscale = 2E-8
Zscale = 1E-9
Zresolution = -1
Compression = 0
DataType = 7
CheckType = 0
*
"""
SIMPLE_FIELD = b"""Gwyddion Simple Field 1.0
XRes = 32
YRes = 20
XReal = 3.2e-7
YReal = 4e-7
XYUnits = m
ZUnits = m
"""


def _text(header: str, between: str = "\t", end: str = "") -> bytes:
    rows = "\n".join(between.join(f"{one:.9g}" for one in line) for line in HEIGHTS.T)
    return f"{header}{rows}\n{end}".encode()


def _simple_field() -> bytes:
    """The header is filled up by one to four zeros, to a multiple of four bytes."""
    zeros = b"\0" * (4 - len(SIMPLE_FIELD) % 4)
    return SIMPLE_FIELD + zeros + (1e-9 * HEIGHTS.T).astype("<f4").tobytes()


BOTH: dict[str, Callable[[], bytes]] = {
    "spip.asc": lambda: _text(SPIP),
    "nova.txt": lambda: _text(NOVA),
    "attocube.asc": lambda: _text(ATTOCUBE),
    "iso.sdf": lambda: _text("aISO-1.0" + SDF, " ", "*\n"),
    "npl.sdf": lambda: _text("aNPL-V1.0" + SDF, " ", "*\n"),
    "bcr.sdf": lambda: _text("aBCR-1.0" + SDF, " ", "*\n"),
    "exported-by-gwyddion.sdf": lambda: _text("aBCR-0.0" + SDF, " ", "*\n"),
    "binary.sdf": lambda: _binary(b"bISO-1.0"),
    "binary-bcr.sdf": lambda: _binary(b"bBCR-1.0"),
    "fortran.txt": lambda: _fortran(),
}
LANGUAGES = {
    "en": ("Channel:", "Width:", "Height:", "Value units:"),
    "de": ("Kanal:", "Breite:", "Höhe:", "Value units:"),
    "de, newer": ("Kanal:", "Breite:", "Höhe:", "Werteinheiten:"),
    "fr": ("Canal :", "Largeur :", "Hauteur :", "Unités :"),
    "cs": ("Kanál:", "Šířka:", "Výška:", "Jednotky hodnot:"),
    "it": ("Canale:", "Larghezza:", "Altezza:", "unità valore:"),
    "es": ("Canal:", "Anchura:", "Altura:", "Value units:"),
    "ru": ("Канал:", "Ширина:", "Высота:", "Единицы измерения:"),
    "ko": ("채널:", "폭:", "높이:", "값 단위:"),
}
"""Words of Gwyddion's export of text, in the language of its user; those of newer versions are longer."""


def _fortran() -> bytes:
    """Numbers of double precision, also those of the header."""
    rows = "\n".join(
        " ".join(f"{one:.9e}".replace("e", "Dd"[i % 2]) for i, one in enumerate(line)) for line in HEIGHTS.T
    )
    return f"# Width: 3.2D+02 nm\n# Height: 0.4d3 nm\n# Value units: nm\n{rows}\n".encode()


def _binary(version: bytes) -> bytes:
    """The maker's name follows the version at once."""
    scales = struct.pack("<HH4d", 32, 20, 1e-8, 2e-8, 1e-9, 0.0)
    return version + b"ISO".ljust(10) + 2 * b"010120261200" + scales + b"\0\7\0" + HEIGHTS.T.astype("<f8").tobytes()


def _gwyddion_file(unit: bytes, title: bytes) -> bytes:
    """A file of one channel, with texts in any encoding."""

    def item(name: bytes, kind: bytes, value: bytes) -> bytes:
        return name + b"\0" + kind + value

    def of(name: bytes, *items: bytes) -> bytes:
        body = b"".join(items)
        return name + b"\0" + struct.pack("<L", len(body)) + body

    def unit_item(name: bytes) -> bytes:
        return item(name, b"o", of(b"GwySIUnit", item(b"unitstr", b"s", unit + b"\0")))

    data = (1e-9 * HEIGHTS.T).astype("<f8").tobytes()
    field = of(
        b"GwyDataField", item(b"xres", b"i", struct.pack("<i", 32)), item(b"yres", b"i", struct.pack("<i", 20)),
        item(b"xreal", b"d", struct.pack("<d", 3.2e-7)), item(b"yreal", b"d", struct.pack("<d", 4e-7)),
        unit_item(b"si_unit_xy"), unit_item(b"si_unit_z"),
        item(b"data", b"D", struct.pack("<L", 640) + data),
    )  # fmt: skip
    texts = struct.pack("<L", 2) + title + b"\0" + b"plain\0"
    return b"GWYP" + of(b"GwyContainer", item(b"/0/data", b"o", field), item(b"/0/data/title", b"s", title + b"\0"),
                        item(b"/0/texts", b"S", texts))  # fmt: skip


def _holds(path: Path) -> None:
    found = read_topography(path)
    assert found.lengths == pytest.approx((0.32e-6, 0.4e-6), rel=1e-12)
    # Nine digits are written, or the 24 bits of single precision.
    np.testing.assert_allclose(found.heights, 1e-9 * HEIGHTS, rtol=2.0**-24, atol=0)


@needs_reader
@pytest.mark.parametrize("name", BOTH)
def test_formats_that_gwyddion_knows_are_read(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(BOTH[name]())
    _holds(tmp_path / name)


@pytest.mark.parametrize("language", LANGUAGES)
def test_texts_that_gwyddion_exports_are_read_in_each_language(language: str, tmp_path: Path) -> None:
    """Also with decimal commas, as its user has them."""
    channel, width, height, unit = LANGUAGES[language]
    header = f"# {channel} Topographie\n# {width} 320,00 nm\n# {height} 0,400 µm\n# {unit} m\n"
    rows = "\n".join("\t".join(f"{1e-9 * one:.9g}".replace(".", ",") for one in line) for line in HEIGHTS.T)
    (tmp_path / "exported.txt").write_text(header + rows + "\n", encoding="utf-8")
    _holds(tmp_path / "exported.txt")
    with pytest.raises(TopographyError, match="the file itself says the size"):
        read_topography(tmp_path / "exported.txt", size=(1e-6, 1e-6))


def test_a_header_in_another_language_is_not_called_silent(tmp_path: Path) -> None:
    (tmp_path / "odd.txt").write_bytes(_text("# Leveys: 320 nm\n# Korkeus: 400 nm\n"))
    with pytest.raises(TopographyError, match="not found in the header of the file, which is not understood"):
        read_topography(tmp_path / "odd.txt")


@needs_reader
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_a_gwyddion_file_is_read_whatever_the_encoding_of_its_texts(encoding: str, tmp_path: Path) -> None:
    """Titles and units; what is between them are numbers of any bytes."""
    (tmp_path / "map.gwy").write_bytes(_gwyddion_file(b"m", "Höhe über 1 µm".encode(encoding)))
    _holds(tmp_path / "map.gwy")
    (tmp_path / "cut.gwy").write_bytes(_gwyddion_file(b"m", "Höhe".encode(encoding))[:-400])
    with pytest.raises(TopographyError, match="SurfaceTopography cannot read it"):
        read_topography(tmp_path / "cut.gwy")


@needs_reader
@pytest.mark.parametrize("largest", [np.finfo(np.float64).max, -np.finfo(np.float32).max])
def test_the_largest_number_is_a_missing_height(largest: float, tmp_path: Path) -> None:
    """As in surface data files of singles and doubles; and as an array in memory has it."""
    heights = HEIGHTS.T.copy()
    heights[3, 4:8] = largest
    rows = "\n".join(" ".join(f"{one:.17g}" for one in line) for line in heights)
    (tmp_path / "void.sdf").write_text(f"aISO-1.0{SDF}{rows}\n*\n")
    for found in (
        read_topography(tmp_path / "void.sdf"),
        read_topography(heights.T, size=(3.2e-7, 4e-7), unit=1e-9),
    ):
        assert any("4 numbers beyond 1e25 taken as missing" in step for step in found.steps)
        kept = np.ones(heights.T.shape, dtype=bool)
        kept[4:8, 3] = False
        np.testing.assert_allclose(found.heights[kept], 1e-9 * HEIGHTS[kept], rtol=1e-6)


@pytest.mark.long
@needs_reader
@pytest.mark.skipif(GWYDDION is None, reason="Gwyddion is not installed: apt-get install gwyddion")
@pytest.mark.parametrize("name", [*BOTH, "simple.gsf"])
def test_what_gwyddion_makes_of_them_is_the_same_map(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(BOTH.get(name, _simple_field)())
    convert = [str(GWYDDION), "--convert-to-gwy=found.gwy", name]  # which needs no display
    subprocess.run(convert, cwd=tmp_path, check=True, capture_output=True, timeout=60)
    _holds(tmp_path / "found.gwy")
