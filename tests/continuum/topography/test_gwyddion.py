"""Gwyddion and our readers agree on heights, size and unit of one map in the formats that both know."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from continuum.topography.reading import read_topography
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
}


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


@pytest.mark.long
@needs_reader
@pytest.mark.skipif(GWYDDION is None, reason="Gwyddion is not installed: apt-get install gwyddion")
@pytest.mark.parametrize("name", [*BOTH, "simple.gsf"])
def test_what_gwyddion_makes_of_them_is_the_same_map(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(BOTH.get(name, _simple_field)())
    convert = [str(GWYDDION), "--convert-to-gwy=found.gwy", name]  # which needs no display
    subprocess.run(convert, cwd=tmp_path, check=True, capture_output=True, timeout=60)
    _holds(tmp_path / "found.gwy")
