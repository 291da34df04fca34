"""Predict of arrays and files that are no good map, and of arguments that are none: one message, which names them."""

from __future__ import annotations

import inspect
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes

import continuum as c
from continuum.front.cli import main
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import InputError
from continuum.maps.map import TopographyError
from continuum.maps.verdict import tables as sticky_tables
from tests.problems import Rough
from tests.wrong import ANYTHING, refused_by_name

KNOWN: dict[str, Any] = {"size": "10nm", "unit": "A", "material": "mica", "solve": False}
ROUGH = Rough(32).heights()
FEW = ROUGH[:16, :20]
"""As little as is a map: a non-square part of it."""


def margins(found: c.Prediction) -> list[float | None]:
    return [verdict.margin for verdict in found.verdicts]


@pytest.mark.usefixtures("unpressed")
@pytest.mark.parametrize("kind", ["map", "masked", "profile", "two", "integers", "list"])
def test_an_array_says_what_its_file_says(kind: str, tmp_path: Path) -> None:
    """Bit for bit: a map in memory is the same map."""
    holes = np.zeros(FEW.shape, dtype=bool)
    holes[10, 4:7] = True
    arrays: list[Any] = {
        "map": [FEW],
        "masked": [np.ma.masked_array(FEW, holes)],
        "profile": [np.random.default_rng(1).normal(size=128).cumsum()],
        "two": [FEW, FEW[::-1]],
        "integers": [np.rint(100 * FEW).astype(np.int16)],
        "list": [FEW.tolist()],
    }[kind]
    options = KNOWN | ({"fill": "5%"} if kind == "masked" else {})
    files = [tmp_path / f"{i}.npy" for i in range(len(arrays))]
    for file, array in zip(files, arrays, strict=True):
        np.save(file, np.ma.filled(array, np.nan) if isinstance(array, np.ma.MaskedArray) else array)
    one, other = c.predict(*arrays, **options), c.predict(*files, **options)
    assert margins(one) == margins(other)
    assert [t.digest for t in one.topographies] == [t.digest for t in other.topographies]
    assert [t.source for t in one.topographies] == (["array 1", "array 2"] if kind == "two" else ["array"])
    assert "array" in one.sheets()[0].text()


def test_an_array_is_left_as_it_was_and_may_face_a_file(tmp_path: Path) -> None:
    heights = FEW.copy()
    np.save(tmp_path / "map.npy", heights)
    found = c.predict(heights, tmp_path / "map.npy", **KNOWN | {"size": ["10nm", "10nm,10nm"]})
    np.testing.assert_array_equal(heights, FEW)
    assert [t.source for t in found.topographies] == ["array 1", "map.npy"]


@pytest.mark.usefixtures("unpressed")
def test_numbers_without_a_unit_are_taken_as_numbers() -> None:
    given: dict[str, Any] = {"modulus": "2MPa", "work": "50mJ/m2", "range": "1nm"}
    by_text = c.predict(FEW, **KNOWN | {"material": ()}, **given, poisson="0.5", fill="5%")
    by_number = c.predict(FEW, **KNOWN | {"material": ()}, **given, poisson=0.5, fill=0.05)
    assert margins(by_text) == margins(by_number)


BAD_FILES: dict[str, tuple[str, bytes | np.ndarray[Any, Any], str]] = {
    "empty csv": ("map.csv", b"", "the file is empty"),
    "empty npy": ("map.npy", b"", "the file is empty"),
    "empty HDF5": ("map.h5", b"", "the file is empty"),
    "empty file of an instrument": ("map.gwy", b"", "the file is empty"),
    "comments only": ("map.csv", b"# nothing\n", "holds no heights"),
    "words": ("map.txt", b"hello world\n", "not a table of numbers"),
    "rows of two lengths": ("map.csv", b"1,2\n3\n", "not a table of numbers"),
    "bytes": ("map.txt", bytes(range(256)), "not a table of numbers"),
    "no rows": ("map.npy", np.zeros((0, 32)), "holds no heights, an array of 0 x 32"),
    "no columns": ("map.npy", np.zeros((32, 0)), "holds no heights, an array of 32 x 0"),
    "nothing": ("map.npy", np.zeros(0), "holds no heights, an array of 0"),
    "one number": ("map.npy", np.array(3.0), "one number"),
    "one point": ("map.npy", np.ones((1, 1)), "at least 64 heights"),
    "one short row": ("map.npy", ROUGH[:1], "at least 64 heights"),
    "one short column": ("map.npy", ROUGH[:, :1], "at least 64 heights"),
    "one row of equals": ("map.npy", np.ones((1, 99)), "all heights are equal"),
    "one row without a number": ("map.npy", np.full((1, 99), np.nan), "99 of 99 heights are missing"),
    "equals": ("map.npy", np.ones((32, 32)), "all heights are equal"),
    "no number": ("map.npy", np.full((32, 32), np.nan), "1024 of 1024 heights are missing"),
    "three directions": ("map.npy", np.zeros((20, 20, 20)), "two-dimensional"),
    "too large": ("map.npy", 1e200 * ROUGH, "heights of more than"),
    "too small": ("map.npy", 1e-300 * ROUGH, "all heights are equal"),
}


@pytest.mark.parametrize("fault", BAD_FILES)
def test_a_file_that_holds_no_map_is_refused_in_one_message(
    fault: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, content, expected = BAD_FILES[fault]
    path = tmp_path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        np.save(path, content)
    dataset = ["--dataset", "heights"] if name.endswith("h5") else []
    command = ["predict", str(path), "--size", "1um", "--unit", "nm", "--material", "mica", "-o", str(tmp_path / "out")]
    assert main([*command, *dataset]) == 2
    said = capsys.readouterr().err
    assert expected in said
    assert name in said
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "out").exists()
    if isinstance(content, np.ndarray) and content.ndim:
        with pytest.raises(TopographyError, match=f"^array: .*{expected}"):
            c.predict(content, **KNOWN)


def test_a_folder_and_an_impossible_name_are_no_maps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    known = ["--size", "1um", "--unit", "nm", "--material", "mica", "-o", str(tmp_path / "out")]
    assert main(["predict", str(tmp_path), *known]) == 2
    assert "a folder" in capsys.readouterr().err
    assert main(["predict", "a" * 5000, *known]) == 2
    assert "maps = 'aaa" in (said := capsys.readouterr().err)
    assert len(said) < 200


@pytest.mark.parametrize(
    ("maps", "options", "expected"),
    [
        ((3,), {}, "maps = 3: allowed: names of files, or arrays"),
        ((None,), {}, "maps = None: "),
        ((ROUGH + 0j,), {}, "maps = .*not of complex numbers"),
        ((ROUGH > 0,), {}, "maps = .*not of booleans"),
        (([[1.0], [1.0, 2.0]],), {}, "maps = .*rows of one length"),
        (([["a.npy"]],), {}, "maps = .*not of text"),
        ((), {}, "maps: give a height map, or two for two"),
        ((ROUGH,) * 3, {}, "maps: a contact has one or two"),
        ((ROUGH,), {"size": None}, "the array does not say the size of the map: give `size`"),
        ((ROUGH,), {"unit": None}, "the array does not say the unit of the map: give `unit`"),
        ((ROUGH,), {"size": 1e-8}, 'size = 1e-08: allowed: a text such as "10um"'),
        ((ROUGH,), {"size": ("10nm", "10nm")}, "`size`: 2 values for one map.*are one text"),
        ((ROUGH,), {"size": "0nm"}, "`size` '0nm': .*positive"),
        ((ROUGH,), {"size": "1e-300nm"}, "lengths of .*possible|lengths of .*positive"),
        ((ROUGH,), {"size": "1e300nm"}, "lengths of"),
        ((ROUGH,), {"unit": "furlong"}, "`unit`: 'furlong' is not a unit of length"),
        ((ROUGH,), {"dataset": "a"}, "`dataset` 'a': there is only one array"),
        ((ROUGH,), {"part": "a"}, "`part` 'a': there is only one array"),
        ((ROUGH,), {"detrend": "planes"}, "detrend = 'planes': allowed: one of"),
        ((ROUGH,), {"fill": 0}, "fill = 0: allowed"),
        ((ROUGH,), {"fill": "none"}, "`fill` 'none'"),
        ((ROUGH,), {"crop": "0,1nm,0,1nm"}, "`crop` leaves 3 x 3 points"),
        ((ROUGH,), {"periodic": "no"}, "periodic = 'no': allowed: True or False"),
        ((ROUGH,), {"threads": 0}, "threads = 0: allowed: a whole number"),
        ((ROUGH,), {"poisson": 0.6}, "poisson = 0.6: allowed"),
        ((ROUGH,), {"work": 0.05}, "work = 0.05: allowed: a text such as "),
        ((ROUGH,), {"solve": "yes"}, "solve = 'yes': allowed: True or False"),
        ((ROUGH,), {"tip": 10}, "tip = 10: allowed: a text such as "),
        ((ROUGH,), {"tip": "0nm"}, "`tip` '0nm': .*positive"),
        ((ROUGH,), {"smallest": "1"}, "`smallest` '1': a unit of length is missing"),
        ((ROUGH,), {"smallest": "1Pa"}, "`smallest` '1Pa': 'Pa' is not a unit of length"),
        ((ROUGH,), {"unit": "um,nm"}, "`unit` has two units, the first that of positions, but it has no positions"),
        ((ROUGH,), {"unit": "um,um,nm"}, "one unit, of the heights, or two"),
        ((ROUGH,), {"join": True}, "`join`: several measurements of one surface are joined, got 1"),
        ((ROUGH,), {"join": "yes"}, "join = 'yes': allowed: True or False"),
        ((ROUGH,), {"probe": 10}, "probe = 10: allowed: a text such as "),
        ((ROUGH,), {"probe": "0"}, "`probe` '0': a unit of length is missing"),
        ((ROUGH,), {"probe": "0um"}, "`probe` '0um': .*positive"),
        ((ROUGH,), {"probe": "banana"}, "`probe` 'banana' is not a number with a unit of length"),
        ((ROUGH,), {"probe": "10Pa"}, "`probe` '10Pa': 'Pa' is not a unit of length"),
        ((ROUGH,), {"probe": "1e9m"}, "`probe` '1e9m': no probe has this; possible are 1 nm to "),
    ],
)
def test_the_argument_that_is_wrong_is_named(maps: Any, options: dict[str, Any], expected: str) -> None:
    with pytest.raises((TopographyError, ArgumentError, InputError), match=expected):
        c.predict(*maps, **KNOWN | options)


@pytest.mark.parametrize("name", [name for name in inspect.signature(c.predict).parameters if name != "maps"])
@given(value=ANYTHING)
@settings(max_examples=2)  # of each of 25 options
def test_no_argument_of_predict_ends_in_an_error_from_the_depths(name: str, value: object) -> None:
    if name == "solve" and isinstance(value, bool | np.bool_) and value:
        return  # that would be a long test of the solver
    with pytest.MonkeyPatch.context() as patch:
        if name not in ("solve", "threads"):  # the others have their say before a map is pressed
            patch.setattr(c.Prediction, "no_map", "maps are not pressed here")
        refused_by_name(lambda **options: c.predict(ROUGH[:16, :16], **options), KNOWN, name, value)


def patterns(shape: tuple[int, ...], kind: str, rng: np.random.Generator) -> np.ndarray[Any, Any]:
    """Odd maps of a shape."""
    rough = rng.normal(size=shape)
    index = np.indices(shape).sum(axis=0) if shape else np.array(0)
    return {
        "rough": rough,
        "equal": np.full(shape, 3.0),
        "missing": np.full(shape, np.nan),
        "holes": np.where(rough > 1, np.nan, rough),
        "one point": np.where(index == 20, 1.0, 0.0),
        "checkerboard": index % 2.0,
        "plane": index * 1.0,
        "steps": np.rint(rough),
        "infinite": np.where(rough > 2, np.inf, rough),
        "one huge": np.where(index == 20, 1e300, rough),
    }[kind]


KINDS = ("rough", "equal", "missing", "holes", "one point", "checkerboard", "plane", "steps", "infinite", "one huge")


@given(
    array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=40) | st.tuples(st.integers(14, 40), st.integers(14, 40)),
    st.sampled_from(KINDS),
    st.sampled_from((0, -15, 15, -40, 40, -300, 290)),
    st.sampled_from((None, "plane", "curvature", "lines", "none")),
    st.booleans(),
    st.integers(0, 99),
)
@example((0, 32), "rough", 0, None, False, 0)
@example((16, 16), "one point", 0, None, False, 0)
@settings(suppress_health_check=[HealthCheck.too_slow])
def test_an_array_of_any_shape_has_a_verdict_or_one_message(
    shape: tuple[int, ...], kind: str, power: int, detrend: Any, periodic: bool, seed: int
) -> None:
    heights = patterns(shape, kind, np.random.default_rng(seed))
    with warnings.catch_warnings(), np.errstate(over="ignore"):
        warnings.simplefilter("error")
        heights = heights * 10.0**power
        try:
            found = c.predict(heights, **KNOWN, detrend=detrend, periodic=periodic, fill="50%" if seed % 2 else None)
        except (TopographyError, ArgumentError) as error:
            found, message = None, str(error)
    if found is None:
        assert message.startswith("array: " if shape else "maps = ")
        assert "\n" not in message
    else:
        assert all(margin is not None and np.isfinite(margin) for margin in margins(found))


INPUT = """
[topography]
maps = "map.npy"
size = "10nm"
unit = "A"
detrend = "plane"

[interface]
material = ["mica", "mica"]
"""


@pytest.mark.usefixtures("unpressed")
def test_an_input_names_the_map_and_the_interface(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "map.npy", FEW)
    (tmp_path / "contact.toml").write_text(INPUT)
    keys: dict[str, Any] = {
        "size": "10nm",
        "unit": "A",
        "detrend": "plane",
        "material": ["mica", "mica"],
        "solve": False,
    }
    assert c.predict(tmp_path / "contact.toml", solve=False).json() == c.predict(tmp_path / "map.npy", **keys).json()
    # What is given beside an input overrules its keys.
    softer = c.predict(tmp_path / "contact.toml", material="pdms", solve=False)
    assert softer.json() == c.predict(tmp_path / "map.npy", **keys | {"material": "pdms"}).json()
    assert main(["predict", str(tmp_path / "contact.toml"), "--no-solve", "-o", str(tmp_path)]) == 0
    assert (tmp_path / "contact-predict.html").exists()
    assert "silicon" not in capsys.readouterr().out


def test_all_faults_of_an_input_are_named_with_their_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = INPUT.replace("detrend", "detend").replace('unit = "A"', "unit = 3") + 'work = "50"\nrange = "0.5 J/m2"\n'
    (tmp_path / "contact.toml").write_text(wrong)
    assert main(["predict", str(tmp_path / "contact.toml"), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    for text in ("an existing file", "did you mean detrend", "contact.toml:5: topography.unit = 3", "interface.work",
                 "energy per area with its unit", "interface.range"):  # fmt: skip
        assert text in said, said
    assert not (tmp_path / "out").exists()


def test_every_key_of_the_tables_is_an_argument_and_an_option() -> None:
    arguments = set(inspect.signature(c.predict).parameters) - {"maps", "solve", "threads"}
    assert set(sticky_tables.OPTIONS) == arguments


@pytest.mark.usefixtures("unpressed")
def test_a_map_that_comes_with_the_package_is_found_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    wafer, known = "inputs/maps/wafer.txt", {"size": "384nm", "unit": "nm", "material": "silicon"}
    options = [word for name, value in known.items() for word in (f"--{name}", value)]
    options += ["--crop", "0,60nm,0,60nm"]
    assert main(["predict", wafer, *options, "--no-solve"]) == 0
    assert "looking at wafer.txt" in capsys.readouterr().err
    assert (tmp_path / "results" / "wafer-predict.html").is_file()
    assert main(["predict", wafer, *options, "--no-solve", "--csv", "all.csv"]) == 0
    # A map of the user's own comes first.
    (tmp_path / "inputs" / "maps").mkdir(parents=True)
    np.savetxt(tmp_path / wafer, np.random.default_rng(1).normal(size=(16, 20)))
    assert c.predict(wafer, **known, solve=False).topographies[0].heights.shape == (20, 16)  # x is along a line


@pytest.mark.usefixtures("unpressed")
def test_a_table_of_maps_holds_no_formula(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.save(tmp_path / "=1+1.npy", np.random.default_rng(1).normal(size=(16, 16)))
    options = ["--size", "1um", "--unit", "nm", "--material", "mica"]
    assert main(["predict", "=1+1.npy", *options, "--csv", "all.csv"]) == 0
    rows = (tmp_path / "all.csv").read_text().splitlines()
    assert rows[1].startswith("'=1+1.npy,")
