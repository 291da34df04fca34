"""One map in many dialects: it is read as itself or refused, never as another map."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import netcdf_file

from continuum.store.heights import RawMap, read_map, stands_for_nothing
from continuum.store.text import read_text

HEIGHTS = np.random.default_rng(3).normal(size=(18, 16)).cumsum(0)
"""nx = 18 heights along a line of text, ny = 16 lines."""
X, Y = 10.0 * np.arange(18), 0.5 * np.arange(16)
HEADER = "# Channel: Topo\n# Width: 0.36 µm\n# Height: 160 nm\n# Value units: nm"
PLAIN = {" ", "  ", "\t", ";", ", ", ","}


@dataclass(frozen=True)
class Dialect:
    """How a program writes a map."""

    between: str = " "
    decimal: str = "."
    thousands: str = ""
    digits: int = 4
    scale: float = 1.0
    header: str = ""
    labels: bool = False
    void: str | None = None
    quoted: bool = False
    trailing: bool = False
    minus: str = "-"
    encoding: str = "utf-8"
    newline: str = "\n"
    last: str = "\n"

    @property
    def heights(self) -> np.ndarray:
        """The heights, as they are written."""
        heights = np.round(self.scale * HEIGHTS, self.digits)
        if self.void is not None:
            heights[3, 4] = heights[0, 0] = heights[17, 5] = np.nan
        return heights

    @property
    def must_be_read(self) -> bool:
        """Whether it can be read in one way only."""
        blank = self.between.strip(" ") == ""
        commas = self.between.strip(" ") == ","
        if not self.quoted and commas and ({self.decimal, self.thousands} & {",", " "}):
            return False
        if blank and (self.void == "" or "" in (self.void or "x").split() or self.thousands == " "):
            return False
        return self.digits not in (0, 3) and not (blank and self.trailing)

    @property
    def may_be_decimal(self) -> bool:
        """Whether all numbers look as 1.234, which is a number with decimals, as printf writes it."""
        return self.thousands == "." and self.digits == 0 and bool(np.nanmin(np.abs(self.heights)) >= 1000)

    def number(self, value: float) -> str:
        if np.isnan(value):
            return self.void or ""
        text = f"{value:,.{self.digits}f}".replace(",", "T").replace(".", "D")
        return text.replace("T", self.thousands).replace("D", self.decimal).replace("-", self.minus)

    def text(self) -> str:
        rows = [[self.number(value) for value in line] for line in self.heights.T]
        if self.labels:
            rows = [[f"{y:g}".replace(".", self.decimal), *row] for y, row in zip(Y, rows, strict=True)]
            rows.insert(0, ["y\\x", *(f"{x:g}" for x in X)])
        mark = '"' if self.quoted else ""
        end = self.between if self.trailing else ""
        lines = [self.between.join(f"{mark}{one}{mark}" for one in row) + end for row in rows]
        return self.newline.join([*self.header.splitlines(), *lines]) + self.last

    def read(self, folder: Path) -> RawMap:
        path = folder / "map.csv"
        path.write_bytes(self.text().encode(self.encoding))
        return read_map(path)


DIALECTS = st.builds(
    Dialect,
    between=st.sampled_from([" ", "  ", "\t", ";", ",", ", ", " ; "]),
    decimal=st.sampled_from(".,"),
    thousands=st.sampled_from(["", "", ",", ".", "'", " ", "\u202f"]),
    digits=st.sampled_from([4, 4, 4, 3, 0]),
    scale=st.sampled_from([1.0, 1000.0, 1e5]),
    header=st.sampled_from(["", "", HEADER, "# a map\n\n# of mine", "exported by a program"]),
    labels=st.booleans(),
    void=st.sampled_from([None, "", "NaN", "nan", "BAD", "***", "---", "n/a", "#N/A", "-1.#IND", "NULL"]),
    quoted=st.booleans(),
    trailing=st.booleans(),
    minus=st.sampled_from(["-", "-", "\u2212"]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"]),
    newline=st.sampled_from(["\n", "\r\n", "\r"]),
    last=st.sampled_from(["", "\n", "\r\n", "\n\n", "\x1a"]),
).filter(lambda one: one.thousands != one.decimal and not one.may_be_decimal)


@given(dialect=DIALECTS)
@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_map_is_read_as_itself_or_refused_in_whatever_dialect(dialect: Dialect, tmp_path: Path) -> None:
    if not dialect.must_be_read:
        with suppress(ValueError):
            np.testing.assert_allclose(dialect.read(tmp_path).heights, dialect.heights, rtol=1e-15)
        return
    found = dialect.read(tmp_path)
    np.testing.assert_allclose(found.heights, dialect.heights, rtol=1e-15)
    assert found.size == ((0.36e-6, 0.16e-6) if dialect.header == HEADER else None)
    assert found.unit == (1e-9 if dialect.header == HEADER else None)
    assert found.extent == ((180.0, 8.0) if dialect.labels else None)


@pytest.mark.parametrize(
    "dialect",
    [
        Dialect("  ", decimal=","),
        Dialect(",", void=""),
        Dialect(" ", void="BAD"),
        Dialect("\t", trailing=True),
        Dialect(";", trailing=True, void=""),
        Dialect(",", labels=True),
        Dialect(";", ",", ".", scale=1e5),
        Dialect(",", ",", quoted=True),
        Dialect("\t", ".", ",", scale=1e5, encoding="utf-16"),
        Dialect("\t", header=HEADER, encoding="cp1252"),
    ],
)
def test_what_programs_write_is_read(dialect: Dialect, tmp_path: Path) -> None:
    assert dialect.must_be_read
    found = dialect.read(tmp_path)
    np.testing.assert_allclose(found.heights, dialect.heights, rtol=1e-15)
    assert (found.unit is not None) == bool(dialect.header)
    assert any("1252" in step for step in found.steps) == (dialect.encoding == "cp1252")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1,234 2,345\n3,456 4,567\n", "number with decimals, or one of thousands"),
        ("1.234;987\n2.345;12\n", "number with decimals, or one of thousands"),
        ("0,4440\n0,6418\n", "one number with a decimal comma, or two"),
        ("0,4440,-0,6418\n0,1230,-0,2345\n", "commas stand between columns and within numbers"),
        ("1.5;2,5\n2.5;1,5\n", "decimal points and decimal commas"),
        ("1 2 3\n4 five 6\n", "'five' in line 2 is neither a number"),
        ("1 2 three\n4 5 6\n", "neither a number"),
        ("1 2 3\n4 5\n", "line 2 has 2 columns, another one 3"),
        ("# Channel: a\n1 2\n3 4\n# Channel: b\n5 6\n7 8\n", "several maps in one file"),
        ("nothing at all\n", "no line of numbers"),
        ("\0\1\2\3", "not a text file"),
        ("# Width: 3 furlong\n1 2\n3 4\n", "not a unit of length"),
        ("# Value units: V\n1 2\n3 4\n", "'V' is not a unit of length"),
    ],
)
def test_what_can_be_read_in_two_ways_or_none_is_refused(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "map.txt").write_text(text)
    with pytest.raises(ValueError, match=said):
        read_map(tmp_path / "map.txt")


@pytest.mark.parametrize(
    ("header", "size", "unit"),
    [
        ("Width: 0.36 µm\nHeight: 0.16 µm\nValue units: m", (0.36e-6, 0.16e-6), 1.0),
        ("x-length = 360 nm\ny-length = 160 nm\nz-unit = nm", (0.36e-6, 0.16e-6), 1e-9),
        ("Scan size: 360 nm x 160 nm", (0.36e-6, 0.16e-6), None),
        ("Width (um): 0,36\nHeight (um): 0,16", (0.36e-6, 0.16e-6), None),
        ("x-unit = microns\nXSize = 0.36\nYSize = 0.16", (0.36e-6, 0.16e-6), None),
        ("pixel size = 20 nm", (0.36e-6, 0.32e-6), None),
        ("Heights in nm, of a part", None, 1e-9),
        ("Width: 18 px\nHeight: 16 px", None, None),
    ],
)
def test_a_header_says_size_and_unit(header: str, size: tuple[float, float] | None, unit: float | None,
                                     tmp_path: Path) -> None:  # fmt: skip
    np.savetxt(tmp_path / "map.txt", HEIGHTS.T, header=header, encoding="utf-8")
    found = read_map(tmp_path / "map.txt")
    assert found.size == (size and pytest.approx(size))
    assert found.unit == unit
    np.testing.assert_array_equal(found.heights, HEIGHTS)


def test_a_number_that_a_header_calls_missing_is_no_height(tmp_path: Path) -> None:
    lines = "\n".join(" ".join(f"{one:.4f}" for one in line) for line in HEIGHTS.T)
    (tmp_path / "grid.asc").write_text(f"ncols 18\nnrows 16\ncellsize 10\nNODATA_value -9999\n{lines[:-6]} -9999\n")
    assert np.isnan(read_map(tmp_path / "grid.asc").heights[-1, -1])


@pytest.mark.parametrize("index", ["columns", "both", "row", "index", "names"])
def test_labels_of_rows_and_columns_are_no_heights(index: str, tmp_path: Path) -> None:
    """As pandas, R and MATLAB write them."""
    rows = [[f"{one:.9g}" for one in line] for line in HEIGHTS.T]
    if index in ("row", "both"):
        rows.insert(0, [str(i) for i in range(18)])
    if index in ("columns", "both", "index", "names"):
        corner = {"both": [""], "index": ["index", *(f"c{i}" for i in range(18))], "names": []}.get(index)
        numbers = [str(i) for i in range(16)]
        if index == "both":
            numbers.insert(0, "")
        rows = [[number, *row] for number, row in zip(numbers, rows, strict=True)]
        if corner and index == "index":
            rows.insert(0, corner)
    (tmp_path / "map.csv").write_text("\n".join(",".join(row) for row in rows))
    np.testing.assert_allclose(read_map(tmp_path / "map.csv").heights, HEIGHTS, rtol=1e-8)


def test_a_slope_along_a_line_is_no_label(tmp_path: Path) -> None:
    """A wedge is linear along each line, not along one."""
    wedge = np.add.outer(np.arange(18.0), np.zeros(16))
    np.savetxt(tmp_path / "map.txt", wedge.T)
    np.testing.assert_array_equal(read_map(tmp_path / "map.txt").heights, wedge)


def test_descending_labels_put_the_map_in_order(tmp_path: Path) -> None:
    """Exports begin with the highest y; the same points are the same map."""
    rows = np.column_stack([Y[::-1], HEIGHTS.T[::-1]])
    table = np.vstack([np.concatenate([[0.0], X]), rows])
    np.savetxt(tmp_path / "map.txt", table, delimiter="\t")
    found = read_map(tmp_path / "map.txt")
    np.testing.assert_array_equal(found.heights, HEIGHTS)
    assert found.extent == (180.0, 8.0)


@pytest.mark.parametrize("kind", ["hdf5", "netcdf4", "netcdf3"])
def test_attributes_of_a_dataset_are_what_the_file_says(kind: str, tmp_path: Path) -> None:
    """Integers with a scale, an offset and a fill value, axes y and x in µm; the order is that of the axes."""
    raw = np.round(1000 * HEIGHTS.T).astype(np.int16)
    raw[2, 3], path = -32768, tmp_path / "map.nc"
    attributes = {
        "units": "nm",
        "scale_factor": np.float64(0.001),
        "add_offset": np.float64(5.0),
        "_FillValue": np.int16(-32768),
    }
    if kind == "netcdf3":
        with netcdf_file(path, "w") as file:
            for name, positions in (("y", 0.01 * Y), ("x", 0.001 * X)):
                file.createDimension(name, positions.size)
                file.createVariable(name, "f8", (name,))[:] = positions
                file.variables[name].units = "um"
            height = file.createVariable("height", "i2", ("y", "x"))
            height[:] = raw
            for name, value in attributes.items():
                setattr(height, name, value)
    else:
        with h5py.File(path, "w") as file:
            height = file.create_dataset("height", data=raw)
            height.attrs.update(attributes)
            for i, (name, positions) in enumerate((("y", 0.01 * Y), ("x", 0.001 * X))):
                scale = file.create_dataset(name, data=positions)
                scale.attrs["units"] = np.bytes_("um") if kind == "hdf5" else "um"
                scale.make_scale(name)
                height.dims[i].attach_scale(scale)
    found = read_map(path, "height")
    expected = np.round(1000 * HEIGHTS) * 0.001 + 5
    expected[3, 2] = np.nan
    np.testing.assert_allclose(found.heights, expected, rtol=1e-12)
    assert found.unit == 1e-9
    assert found.size == pytest.approx((0.18e-6, 0.08e-6))
    assert read_map(path).heights.shape == (18, 16)  # the only one of two dimensions


def test_a_dataset_of_volts_is_no_map(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "map.h5", "w") as file:
        file["phase"] = HEIGHTS
        file["phase"].attrs["units"] = "V"
    with pytest.raises(ValueError, match=r"dataset 'phase': 'V' is not a unit of length"):
        read_map(tmp_path / "map.h5")


@pytest.mark.parametrize("value", [99999.0, -32768.0, 1e30, -500.0, 0.0])
def test_a_value_far_outside_that_is_repeated_is_asked_for(value: float) -> None:
    heights = HEIGHTS + (5000.0 if value == 0 else 0.0)
    heights[[1, 5], [2, 7]] = value
    assert stands_for_nothing(heights) == (value, 2)


@pytest.mark.parametrize("kind", ["rough", "posts", "clipped", "spike", "flat"])
def test_heights_are_not_asked_for(kind: str) -> None:
    heights = HEIGHTS.copy()
    if kind == "posts":
        heights = np.where(np.arange(18)[:, None] % 6 < 2, 100.0, 0.0) * np.ones(16)
    elif kind == "clipped":
        heights = np.clip(heights, *np.quantile(heights, [0.1, 0.9]))
    elif kind == "spike":
        heights[3, 3] = 900.0
    elif kind == "flat":
        heights[:] = 1.0
    assert stands_for_nothing(heights) is None


def test_equal_text_has_equal_rows_however_it_ends(tmp_path: Path) -> None:
    """Line ends, blank lines and comments among the rows are no numbers."""
    texts = ("1 2\n3 4\n", "1 2\r\n3 4", "1 2\r3 4\r", "\n1 2\n\n# said\n3 4 # by hand\n\n")
    for i, text in enumerate(texts):
        (tmp_path / f"{i}.txt").write_bytes(text.encode())
    rows = [read_text(tmp_path / f"{i}.txt").rows for i in range(len(texts))]
    for one, other in pairwise(rows):
        np.testing.assert_array_equal(one, other)
