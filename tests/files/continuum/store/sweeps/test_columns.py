"""Columns of one's own: they stand in the table as the others do, and what is wrong with them costs nothing else."""

from __future__ import annotations

import hashlib
import json
import math
import pickle
import re
import shutil
import signal
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum as c
from continuum.front.cli import main
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.toml import ConfigError
from continuum.store.runs.result import Result
from continuum.store.sweeps import sweep as sweeps
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.collect import collect
from continuum.store.sweeps.columns import ColumnError, OwnColumn
from continuum.store.sweeps.crossings import TrialError, done_before, solve_task
from continuum.store.sweeps.sweep import begin, record
from continuum.store.sweeps.workers import StopSignal, TaskResult
from tests.problems import SMALL

SEEDS = '[sweep.axes]\n"surface.seed" = [3, 4]\n'
TEXT = SMALL.replace("1.6, 1.4,\n           1.2", "1.6, 1.4").replace("retract = true", "")
PAGE = (Path(__file__).parents[5] / "docs" / "sweeps.md").read_text()
MINE = """\

SCALE = 2.0


def doubled(result):
    return [SCALE * point.load for point in result.points]


def apart(result):
    return [result.gap(step).mean() for step in range(len(result.points))]


def seed(result):
    return result.config.surface.seed


def broken(result):
    if result.config.surface.seed == 4:
        raise RuntimeError("no patches here")
    return 1.0
"""
MINE = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)[1] + MINE


def described(folder: Path, columns: str, axes: str = SEEDS, mine: str = MINE, text: str = TEXT) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "mine.py").write_text(mine)
    path = folder / "many.toml"
    path.write_text(f"{text}{axes}[sweep.columns]\n{columns}")
    return path


def run(path: Path, root: Path, **options: Any) -> list[str]:
    """As the command does it, in this process; the reasons of what failed."""
    is_done, reasons = done_before(root), []
    for task in begin(Sweep.read(path), root, **options):
        if is_done(task):
            continue
        try:
            solve_task(root, task)
        except ColumnError as error:
            record(root, TaskResult(task, 0.0, str(error), error))
            reasons.append(str(error))
    return reasons


GOOD = (
    'doubled = "mine.py"\nclosest = "mine.py:apart"\nname_of_the_surface = "mine.py:seed"\nlargest_patch = "mine.py"\n'
)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two systems of two points, with columns."""
    folder = tmp_path_factory.mktemp("columns")
    assert run(described(folder, GOOD), folder / "many") == []
    return folder


@pytest.fixture
def copied(finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same, where nothing may be solved again."""
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.setattr(sweeps, "follow_run", lambda *args, **options: pytest.fail("a stored system is solved again"))
    return tmp_path / "copy"


def test_columns_of_a_file_stand_in_every_table(finished: Path, tmp_path: Path) -> None:
    found = c.sweep_collect(finished / "many", tmp_path)
    np.testing.assert_array_equal(found["doubled"], 2 * found["load"])
    np.testing.assert_allclose(found["closest"], found["mean_gap"], rtol=1e-6)  # gaps are stored in single precision
    frame, means, cube = found.to_pandas(), found.means(), found.to_xarray()
    assert frame["name_of_the_surface"].tolist() == [3, 3, 4, 4]
    assert means["name_of_the_surface"].tolist() == [3.5, 3.5]
    assert means["doubled_error"].tolist() == pytest.approx(2 * means["load_error"])
    assert cube["doubled"].dims == cube["load_net"].dims
    digest = hashlib.sha256(f"apart\n{MINE}".encode()).hexdigest()[:12]
    assert cube["closest"].attrs["long_name"].endswith(f"mine.py:apart ({digest})")
    header, first = (tmp_path / "table.csv").read_text().splitlines()[:2]
    row = dict(zip(header.split(","), first.split(","), strict=True))
    assert float(row["doubled"]) == 2 * float(row["load (E*)"])
    # That of docs/sweeps.md: all of the contact is one patch, or none is as large as that.
    touched = found["patches"] > 0
    part, count = found["largest_patch"][touched], found["patches"][touched]
    assert touched.any()
    assert ((part >= 1 / count) & ((part < 1) == (count > 1))).all()
    assert np.isnan(found["largest_patch"][~touched]).all()
    assert found.lacking == ()
    kept = {path.read_text() for path in (finished / "many" / "columns").glob("*.py")}
    assert kept == {MINE}  # what computed them


def test_a_stored_system_gets_new_and_changed_columns_without_a_solve(copied: Path) -> None:
    root = copied / "many"
    before = {path: path.read_bytes() for path in (root / "points").iterdir()}
    path = described(copied, GOOD + 'half = "mine.py"\n', mine=MINE + "\n\ndef half(result):\n    return 0.5\n")
    stale = c.sweep_status(root, path).changes
    assert any("half" in line for line in stale)
    begin(Sweep.read(path), root)
    (one, *_) = lacking = collect(root).lacking  # the text of the file is another one: its columns are not of it
    assert len(lacking) == 5
    assert "missing in 2 of 2 systems: not computed yet" in one
    assert run(path, root) == []
    assert collect(root)["half"].tolist() == [0.5] * 4
    path = described(copied, GOOD, mine=MINE.replace("SCALE = 2.0", "SCALE = 3.0"))
    assert run(path, root) == []
    found = collect(root)
    np.testing.assert_array_equal(found["doubled"], 3 * found["load"])
    assert "half" not in found.to_pandas()
    # Of a file that cannot be read the columns are computed again.
    for path_of_one, content in zip(
        (root / "columns").glob("*.json"), ("{", '{"columns": {"doubled": [3, ["x"]]}}'), strict=True
    ):
        path_of_one.write_text(content)
    assert run(path, root) == []
    np.testing.assert_array_equal(collect(root)["doubled"], found["doubled"])
    assert before == {path: path.read_bytes() for path in (root / "points").iterdir()}


def test_a_function_that_raises_leaves_its_system_and_the_other_columns(
    copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = copied / "many"
    path = described(copied, GOOD + 'broken = "mine.py"\n')
    (reason,) = run(path, root)
    assert reason.startswith("column broken (mine.py:broken): RuntimeError: no patches here; its points are stored")
    status = c.sweep_status(root)
    assert (status.done, len(status.failed), status.left) == (2, 1, 0)
    assert main(["sweep", "collect", str(root)]) == 1
    assert "broken is missing in 1 of 2 systems: column broken" in capsys.readouterr().err
    found = collect(root)
    np.testing.assert_array_equal(found["broken"], [1, 1, np.nan, np.nan])
    np.testing.assert_array_equal(found["doubled"], 2 * found["load"])
    # As any other failure it is tried again on request.
    path = described(copied, GOOD + 'broken = "mine.py"\n', mine=MINE.replace("== 4", "== 5"))
    assert run(path, root) == []
    assert collect(root).lacking
    assert run(path, root, retry=True) == []
    assert collect(root)["broken"].tolist() == [1.0] * 4
    assert c.sweep_status(root).failed == ()


def test_a_search_can_be_along_a_column_of_ones_own(tmp_path: Path) -> None:
    key, text = "wall.adhesion_length", TEXT.replace("1.6, 1.4", "1.4").replace("fields = true", "")
    search = '{ bisect = "doubled at 1.4", crosses = -0.03, from = 0.006, to = 0.018, tolerance = 0.5 }'
    path, root = (
        described(tmp_path, 'doubled = "mine.py"\n', f'[sweep.axes]\n"{key}" = {search}\n', text=text),
        tmp_path / "a",
    )
    assert run(path, root) == []
    table = collect(root)
    (found,) = table.crossings
    assert found.found
    load = dict(zip(table[key], table["load"], strict=True))
    ends = found.bracket.lower, found.bracket.upper
    assert (found.bracket.at_lower, found.bracket.at_upper) == tuple(2 * load[end] for end in ends)
    assert min(map(load.get, ends)) <= -0.015 <= max(map(load.get, ends))
    assert done_before(root)(*begin(Sweep.read(path), root))
    # A changed function is called for every trial before the search goes on; where it fails the search ends with why.
    path.with_name("mine.py").write_text(MINE.replace("SCALE *", "None *"))
    assert not done_before(root)(*begin(Sweep.read(path), root))
    assert c.sweep_status(root).crossings[0].status == "not done"
    with pytest.raises(TrialError, match=r"at adhesion_length 0\.006: ColumnError: column doubled .* TypeError"):
        run(path, root)


WRONG = [
    ('half = "none.py"', MINE, "none.py cannot be read: No such file"),
    ('half = "mine.txt"', MINE, 'a Python file, beside the input, as "mine.py"'),
    ('half = "mine.py"', "def half(:\n", "SyntaxError"),
    ('double = "mine.py"', MINE, "has no function double; did you mean doubled?"),
    ('SCALE = "mine.py"', MINE, "has no function SCALE"),
    ('load = "mine.py:doubled"', MINE, "load is a method of xarray's datasets"),
    ('area_rep = "mine.py:doubled"', MINE, "the table has a column of this name"),
    ('load_error = "mine.py:doubled"', MINE, "the table has a column of this name, or makes one"),
    ('"no name" = "mine.py:doubled"', MINE, "a name of letters, digits and _"),
    ('half = "a function of Python"', MINE, "its function was given in Python"),
]


def test_what_is_wrong_with_a_column_is_one_message_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for columns, mine, said in WRONG:
        path = described(tmp_path, columns, mine=mine)
        assert main(["sweep", "run", str(path), "-o", str(tmp_path / "out")]) == 2
        error = capsys.readouterr().err
        assert error.startswith(f"{path}: 1 fault")
        assert said in error
        assert not (tmp_path / "out").exists()


HOSTILE = """\
import os
from pathlib import Path
Path("executed").write_text("")
def half(result):
    os.chdir("/")
    raise END
"""


def test_reading_an_input_executes_nothing(
    copied: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(copied)
    path = described(copied, 'half = "mine.py"\n', mine=HOSTILE)
    digest = hashlib.sha256(f"half\n{HOSTILE}".encode()).hexdigest()
    made = f"mine.py:half ({digest[:12]})"
    for words in (["check", str(path)], ["sweep", "slurm", str(path)], ["sweep", "status", "many", "--why", str(path)]):
        assert main(words) == 0
        assert made in capsys.readouterr().out
    c.sweep_slurm(path)
    collect(copied / "many")
    assert not (copied / "executed").exists()


@pytest.mark.parametrize(
    ("mine", "said"),
    [
        ("import nothing_of_this_name\nhalf = len\n", "ModuleNotFoundError"),
        ("def half(result):\n    pass\nraise SystemExit(3)\n", "SystemExit: 3"),
        ("half = 1 + 2\n", "is no function, but 3"),
    ],
)
def test_a_file_that_cannot_be_executed_fails_before_anything_is_solved(copied: Path, mine: str, said: str) -> None:
    reasons = run(described(copied, 'half = "mine.py"\n', SEEDS.replace("4", "5"), mine), copied / "many")
    assert len(reasons) == 2
    assert all(said in reason and "nothing was solved" in reason for reason in reasons)


@pytest.mark.parametrize("end", ["SystemExit(3)", "KeyboardInterrupt", "GeneratorExit", "BaseException('x')"])
def test_however_a_function_ends_it_is_a_failure_of_its_column(
    copied: Path, monkeypatch: pytest.MonkeyPatch, end: str
) -> None:
    """Also where it went elsewhere: relative paths mean what they did.  A signal stops the worker all the same."""
    monkeypatch.chdir(copied)
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as in a worker
    try:
        reasons = run(described(copied, 'half = "mine.py"\n', mine=HOSTILE.replace("END", end)), Path("many"))
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(reasons) == 2
    assert all(end.partition("(")[0] in reason and "its points are stored" in reason for reason in reasons)
    assert Path.cwd() == copied
    stopped = OwnColumn("mine", "mine.py:mine", "", code=pickle.dumps(Stops()))
    with pytest.raises(SystemExit):
        stopped.of(cast(Result, SimpleNamespace(points=[])))


class Stops:
    def __call__(self, result: Any) -> Any:
        raise StopSignal(143)


def test_a_column_is_that_of_the_modules_beside_it(copied: Path) -> None:
    """Its helper is found, and after a change of it, or of what that imports, the column is computed anew."""
    (copied / "deeper.py").write_text("FACTOR = 2.0\n")
    (copied / "helper.py").write_text("from deeper import FACTOR\n")
    mine = "import helper\ndef twice(result):\n    return helper.FACTOR\n"
    path = described(copied, 'twice = "mine.py"\n', mine=mine)
    assert run(path, copied / "many") == []
    assert set(collect(copied / "many")["twice"]) == {2.0}
    (copied / "deeper.py").write_text("FACTOR = 3.0\n")
    assert any("twice" in line for line in c.sweep_status(copied / "many", path).changes)


def test_verify_looks_at_numbers_and_texts_of_columns(copied: Path) -> None:
    root = copied / "many"
    assert c.sweep_verify(root).ok
    folder = root / "columns"
    code, numbers = next(folder.glob("*.py")), next(folder.glob("*.json"))
    text = numbers.read_text()
    damages = [
        (code, code.read_text().replace("SCALE = 2.0", "SCALE = 2.5")),
        (numbers, re.sub(r"(\[\[?-?\d\.\d)", r"\g<1>1", text, count=1)),
        (numbers, text.replace("doubled", "halved")),
        (numbers, "[" * 9999),
        (numbers, json.dumps({**json.loads(text), "system": "another"})),
        (numbers, json.dumps([1])),
    ]
    for path, other in damages:
        before = path.read_text()
        path.write_text(other)
        assert [str(path) in fault for fault in c.sweep_verify(root).faults] == [True], (path, other[:99])
        path.write_text(before)
    listing = root / "systems.json"
    text = listing.read_text()
    listing.write_text(text.replace("[3], ", "[7], ") if "[3], " in text else text.replace(", [3]", ", [7]"))
    (fault,) = c.sweep_verify(root).faults
    assert "lists surface.seed = 7, which is 3" in fault
    listing.write_text(text.replace('"surface.hurst": 0.8', '"surface.hurst": 0.7'))
    assert len(c.sweep_verify(root).faults) == 2
    listing.write_text(text)
    path = next(folder.glob("*.json"))
    path.write_text("{")
    assert not c.sweep_verify(root, aside=True).ok
    assert not path.exists()
    assert c.sweep_verify(root).ok


def test_a_function_of_python_is_that_of_the_modules_that_it_uses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "used_by_mine.py").write_text("FACTOR = 2.0\n")
    (tmp_path / "mine_of_python.py").write_text("import used_by_mine\ndef f(result):\n    return used_by_mine.FACTOR\n")
    path = described(tmp_path, "")
    function = import_module("mine_of_python").f

    def digest() -> str:
        (column,) = Sweep.read(path, columns={"f": function}).columns
        return column.digest

    before = digest()
    assert digest() == before
    (tmp_path / "used_by_mine.py").write_text("FACTOR = 3.0\n")
    assert digest() != before


def test_all_files_that_cannot_be_used_are_named_at_once(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="2 faults"):
        Sweep.read(described(tmp_path, 'one = "none.py"\ntwo = "mine.py"\n'))


@pytest.mark.parametrize("columns", [3, {"half": 0.5}, {3: len}, ["half"]])
def test_columns_in_python_are_functions_by_name(columns: Any, tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match="columns"):
        c.sweep(described(tmp_path, ""), tmp_path / "out", columns=columns)
    assert not (tmp_path / "out").exists()


RETURNED = st.one_of(
    st.none(), st.floats(), st.integers(-(2**60), 2**60), st.booleans(), st.text(max_size=3), st.complex_numbers(),
    st.lists(st.floats() | st.none(), max_size=4), st.lists(st.lists(st.floats(), max_size=2), max_size=3),
)  # fmt: skip


@given(RETURNED, st.integers(1, 3))
def test_a_column_is_a_number_for_each_point_or_a_message(returned: Any, points: int) -> None:
    one = OwnColumn("mine", "mine.py:mine", "", code=pickle.dumps(Returns(returned)))
    result = cast(Result, SimpleNamespace(points=[None] * points))
    each = returned if isinstance(returned, list) else [returned] * points
    numbers = all(isinstance(value, int | float) and not math.isinf(value) for value in each or [returned])
    if not numbers or len(each) != points:
        with pytest.raises(ColumnError, match=f"of the {points} points"):
            one.of(result)
    else:
        np.testing.assert_array_equal(one.of(result), np.array(each, dtype=float))


class Returns:
    """A function that returns a value."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __call__(self, result: Any) -> Any:
        return self.value
