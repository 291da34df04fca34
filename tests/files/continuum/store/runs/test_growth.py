"""Paths that grow: what is stored is used where it is the same, down to the last bit, and nowhere else."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import continuum as c
from continuum.front.cli import main
from continuum.inputs.errors import OutputError
from continuum.inputs.reading import load
from continuum.store import datasets as store
from continuum.store.runs.build import build
from continuum.store.runs.config import RunConfig
from continuum.store.runs.result import Result
from continuum.store.runs.reuse import growth_of
from continuum.store.runs.run import follow_run
from continuum.store.sweeps.axes import Sweep
from continuum.store.sweeps.status import sweep_status
from tests.problems import SMALL
from tests.stored import content, same, stop_after

ONE_WAY = SMALL.replace("retract = true\n", "").replace("fields = true", "fields = false")
LONGER = ONE_WAY.replace("1.2]", "1.2, 1.1, 1.0]")
BACK = ONE_WAY + '[loading.retraction]\ncontrol = "separation"\ntargets = [1.0, 2.0]\n'
AREAS = ONE_WAY.replace('"mean-gap"', '"repulsive-area"').replace("[1.6, 1.4,\n           1.2]", "[0.01, 0.02, 0.04]")
THRESHOLDS = AREAS.replace("[output]", "threshold = 0.1\n[output]").replace("0.01, 0.02, 0.04", "0.04")


def config(folder: Path, text: str) -> RunConfig:
    (folder / "run.toml").write_text(text)
    return load(folder / "run.toml", RunConfig)


def seconds(path: Path) -> np.ndarray:
    """Wall time of each point: another one if it was solved again."""
    return store.read_few(path, ("journal/seconds",), ())[0]["journal/seconds"]


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The file of an input, solved once; not to be changed."""

    @cache
    def solved(text: str) -> Path:
        folder = tmp_path_factory.mktemp("solved")
        return follow_run(config(folder, text), folder / "run.h5").path

    return solved


@pytest.mark.parametrize(
    ("short", "long"),
    [
        (ONE_WAY, BACK),
        (THRESHOLDS, THRESHOLDS.replace("0.04", "0.04, 0.08")),
    ],
    ids=["way back", "thresholds"],
)
def test_a_longer_path_goes_on_as_if_it_had_been_one(
    short: str, long: str, stored: Callable[[str], Path], tmp_path: Path
) -> None:
    path, said = tmp_path / "grown.h5", list[str]()
    done = len(Result.read(shutil.copy(stored(short), path)).points)
    before = seconds(path)
    assert follow_run(config(tmp_path, long), path, warn=said.extend).resumed == done
    assert f"continues with {done} stored points of another path" in said[-1]
    np.testing.assert_array_equal(seconds(path)[:done], before)
    same(path, stored(long))


def test_a_path_that_was_stopped_while_it_grew_goes_on(stored: Callable[[str], Path], tmp_path: Path) -> None:
    path, long = tmp_path / "grown.h5", config(tmp_path, LONGER)
    shutil.copy(stored(ONE_WAY), path)
    with pytest.raises(KeyboardInterrupt):
        follow_run(long, path, progress=stop_after(4, KeyboardInterrupt))
    assert follow_run(long, path).resumed == 4
    same(path, stored(LONGER))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("seed = 3", "seed = 4"),
        ("0.005", "0.004"),
        ("1.6, 1.4", "1.6, 1.5"),
        ("1.2, 1.1, 1.0]", "1.2]"),  # shorter: nothing that is stored may be lost in its own file
        ("[output]", "[solver]\ntolerance = 1e-8\n[output]"),
    ],
)
def test_nothing_else_takes_the_place_of_a_stored_path(
    old: str, new: str, stored: Callable[[str], Path], tmp_path: Path
) -> None:
    path = Path(shutil.copy(stored(LONGER), tmp_path / "run.h5"))
    before = path.read_bytes()
    with pytest.raises(OutputError, match="holds another result"):
        follow_run(config(tmp_path, LONGER.replace(old, new)), path)
    assert path.read_bytes() == before


def test_without_the_last_state_a_longer_path_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    follow_run(config(tmp_path, ONE_WAY + "last_state = false\n"), path)
    assert growth_of(config(tmp_path, LONGER), path) is None
    with pytest.raises(OutputError, match="holds another result"):
        follow_run(config(tmp_path, LONGER), path)


def test_a_part_of_a_path_is_taken_from_it(stored: Callable[[str], Path], tmp_path: Path) -> None:
    short = config(tmp_path, ONE_WAY + "last_state = false\n")
    growth = growth_of(short, stored(LONGER))
    assert growth is not None
    assert growth.kept == 3
    assert not growth.whole
    follow_run(short, tmp_path / "part.h5", growth=growth)
    follow_run(short, tmp_path / "alone.h5")
    same(tmp_path / "part.h5", tmp_path / "alone.h5")


@pytest.mark.parametrize("text", [SMALL, AREAS.replace("fields = false", "fields = true")], ids=["gaps", "areas"])
def test_a_finer_tolerance_begins_at_the_stored_states(text: str, tmp_path: Path) -> None:
    rough = text.replace("[output]", "[solver]\ntolerance = 1e-3\n[output]")
    follow_run(config(tmp_path, rough), tmp_path / "rough.h5")
    fine = config(tmp_path, text)
    growth = growth_of(fine, tmp_path / "rough.h5")
    assert growth is not None
    assert (growth.kept, growth.refined) == (0, fine.loading.points)
    found = follow_run(fine, tmp_path / "fine.h5", growth=growth)
    alone = follow_run(fine, tmp_path / "alone.h5")
    assert found.converged
    assert [point.branch for point in found.points] == [point.branch for point in alone.points]
    one, other = content(tmp_path / "fine.h5"), content(tmp_path / "alone.h5")
    # Both are within the tolerance of the same equilibrium, whose stiffness is of the order of E*/λ_L.
    if text == SMALL:
        np.testing.assert_allclose(one["gap"], other["gap"], rtol=0, atol=1e-5)
        assert one["fft_pairs"].sum() < 0.8 * other["fft_pairs"].sum()
    # No point has the residual of its stored state.
    assert one["residual"].max() <= 2 * build(fine).settings.tolerance


def test_a_looser_tolerance_keeps_what_is_better(stored: Callable[[str], Path], tmp_path: Path) -> None:
    path = Path(shutil.copy(stored(ONE_WAY), tmp_path / "run.h5"))
    before = seconds(path)
    loose = config(tmp_path, ONE_WAY.replace("[output]", "[solver]\ntolerance = 1e-3\n[output]"))
    assert follow_run(loose, path).resumed == 3
    np.testing.assert_array_equal(seconds(path), before)


def test_a_sweep_grows_and_says_so_before(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "many.toml"
    axes = '[sweep.axes]\n"surface.seed" = [1, 2]\n'
    file.write_text(ONE_WAY + axes)
    root = c.sweep(file, tmp_path).folder
    file.write_text(LONGER + axes.replace("[1, 2]", "[1, 2, 3]"))
    said = sweep_status(root, why=file).changes
    assert "2 of the new systems continue stored paths: 6 of their 10 points are kept" in said
    assert main(["sweep", "run", str(file), "-o", str(tmp_path), "-q"]) == 0
    assert "6 of their 10 points are kept" in capsys.readouterr().err
    alone = tmp_path / "alone.h5"
    for plan, asked in Sweep.read(file).systems():
        follow_run(asked, alone, force=True)
        measured = content(root / "points" / f"{plan.key[:24]}.h5")
        for name, values in content(alone).items():
            np.testing.assert_array_equal(measured[name], values, err_msg=name)
    # Another contact is another sweep, as before.
    file.write_text((LONGER + axes).replace("0.005", "0.004"))
    assert main(["sweep", "run", str(file), "-o", str(tmp_path)]) == 2
    assert "holds another sweep" in capsys.readouterr().err
