"""A folder as a study: which file is which, and one ranking of samples with intervals over their spots."""

from __future__ import annotations

import csv
import re
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import continuum as c
from continuum.front.cli import main
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import InputError
from continuum.maps.verdict.criteria import Answer
from continuum.maps.verdict.study import Spot, ranked, results_name, scans
from continuum.show.prediction import study_doubts
from continuum.show.prediction_figures import study_figure
from tests.printed import faults_in_print
from tests.problems import Rough

KNOWN: dict[str, Any] = {"size": "480nm", "unit": "nm", "material": "silica"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two samples of two spots; the second is three times as rough."""
    place = tmp_path / "wafers"
    place.mkdir()
    for sample, factor in (("polished", 2.0), ("ground", 6.0)):
        for spot in (1, 2):
            rough = Rough(48, seed=spot, lambda_s=4.0, lambda_L=24.0, hurst=0.7)  # with waves as on the record's
            np.save(place / f"{sample}_{spot}.npy", factor * rough.heights())
    return place


@pytest.fixture(autouse=True)
def once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A spot is predicted once in a process: by the content of its files and the options."""
    monkeypatch.setattr("continuum.front.predict.predict", known)


FOUND: dict[tuple[object, ...], c.Prediction] = {}
predict = c.predict


@wraps(predict)  # the command takes its options from the signature
def known(*paths: Path, **options: Any) -> c.Prediction:
    key = tuple((path.name, path.read_bytes()) for path in paths), repr(options)
    if key not in FOUND:
        FOUND[key] = predict(*paths, **options)
    return FOUND[key]


class Found(Spot):
    """A spot whose margin is known."""

    def __init__(self, sample: str, name: str, margin: float | None) -> None:
        super().__init__(sample, name, (), None)
        object.__setattr__(self, "_factor", margin)

    @property
    def margin(self) -> float | None:
        return self.__dict__["_factor"]

    @property
    def answer(self) -> Answer:
        return "undecided" if self.margin is None else "sticky" if self.margin > 1 else "not sticky"


def test_the_interval_is_students_with_the_scatter_of_all_spots() -> None:
    """Of two samples alone this is the interval of a t-test with equal variances."""
    values = {"a": [2.0, 3.0, 2.5], "b": [1.0, 0.8]}
    found = ranked(Path(), [Found(name, str(i), m) for name, ms in values.items() for i, m in enumerate(ms)])
    assert [sample.name for sample in found.samples] == ["a", "b"]
    logs = [np.log(ms) for ms in values.values()]
    pooled = np.sqrt(sum(np.sum((one - one.mean()) ** 2) for one in logs) / 3)
    assert found.scatter == pytest.approx(np.exp(pooled))
    for sample, one in zip(found.samples, logs, strict=True):
        half = stats.t.ppf(0.975, 3) * pooled / np.sqrt(one.size)
        assert sample.interval == pytest.approx((np.exp(one.mean() - half), np.exp(one.mean() + half)))


def test_ranks_are_the_places_that_intervals_leave_open() -> None:
    near = {"a": [8.0, 8.4], "b": [2.0, 2.2], "c": [2.1, 2.15], "d": [0.1, 0.11]}
    found = ranked(Path(), [Found(name, str(i), m) for name, ms in near.items() for i, m in enumerate(ms)])
    assert {sample.name: sample.ranks for sample in found.samples} == {
        "a": (1, 1), "b": (2, 3), "c": (2, 3), "d": (4, 4)
    }  # fmt: skip
    assert [sample.answer for sample in found.samples] == ["sticky"] * 3 + ["not sticky"]


def test_spots_are_of_one_surface_whose_mean_decides() -> None:
    """Two spots on either side of the threshold are no vote: their mean and its interval decide."""
    values = {"rough": [0.5, 0.6, 1.05], "smooth": [4.0, 4.4, 4.2], "near": [0.9, 1.0, 1.1]}
    found = ranked(Path(), [Found(name, str(i), m) for name, ms in values.items() for i, m in enumerate(ms)])
    assert {sample.name: sample.answer for sample in found.samples} == {
        "rough": "not sticky", "smooth": "sticky", "near": "undecided"
    }  # fmt: skip


def test_one_spot_of_each_sample_ranks_none() -> None:
    found = ranked(Path(), [Found("a", "1", 5.0), Found("b", "1", 0.2), Found("c", "1", None)])
    assert found.scatter is None
    assert [(sample.name, sample.interval, sample.ranks) for sample in found.samples] == [
        ("a", None, (1, 2)), ("b", None, (1, 2)), ("c", None, None)
    ]  # fmt: skip
    assert any("how spots scatter is not known" in text for text in study_doubts(found))


def test_a_folder_is_ranked_in_a_table_on_a_page_and_in_files(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = c.study(folder, **KNOWN)
    assert [sample.name for sample in found.samples] == ["polished", "ground"]
    first, second = found.samples
    assert first.margin is not None
    assert second.margin is not None
    # Each spot is the contact that its file is by itself, and its threshold goes at least with the square of heights.
    alone = c.predict(folder / "polished_1.npy", **KNOWN, solve=False)
    assert first.spots[0].found is not None
    assert first.spots[0].found.json() == alone.json()
    assert first.margin > 5 * second.margin
    out = tmp_path / "out"
    options = ["--size", "480nm", "--unit", "nm", "--material", "silica", "-o", str(out)]
    assert main(["predict", str(folder), *options]) == 0
    said = capsys.readouterr().out
    assert said.startswith("polished is the stickiest of 2 samples (its spots: 2 sticky)")
    rows = list(csv.DictReader((out / "wafers-study.csv").read_text().splitlines()))
    assert [(row["rank"], row["sample"]) for row in rows] == [("1", "polished"), ("2", "ground")]
    assert float(rows[0]["w/w_c"]) == pytest.approx(first.margin)
    assert float(rows[0]["lower end"]) < first.margin < float(rows[0]["upper end"])
    spots = list(csv.DictReader((out / "wafers-study-spots.csv").read_text().splitlines()))
    assert [(row["sample"], row["spot"]) for row in spots] == [("polished", "1"), ("polished", "2"),
                                                               ("ground", "1"), ("ground", "2")]  # fmt: skip
    page = (out / "wafers-study.html").read_text()
    assert "polished is the stickiest" in page
    assert len(re.findall(r'src="data:image/png', page)) == 1
    assert faults_in_print(study_figure(found)) == []


def test_results_may_go_into_the_folder_or_beside_it_and_are_no_maps(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = [word for name, value in KNOWN.items() for word in (f"--{name}", value)]
    for where in (".", ".", "results", "results", ".."):  # the second finds the results of the first
        assert main(["predict", str(folder), "-o", str(folder / where), *options]) == 0
        assert "of 2 samples" in capsys.readouterr().out
        assert (folder / where / "wafers-study.csv").is_file()
        maps = [scan.path.name for scan in scans(folder, without=folder / where)]
        assert maps == ["ground_1.npy", "ground_2.npy", "polished_1.npy", "polished_2.npy"]


def test_names_of_results_do_not_repeat_study_and_never_replace_the_table(tmp_path: Path) -> None:
    assert [results_name(tmp_path / name) for name in ("wafers", "my-study", "study")] == [
        "wafers-study", "my-study-ranking", "study-ranking"
    ]  # fmt: skip


def test_magnifications_of_a_spot_are_joined(folder: Path) -> None:
    for path in folder.glob("*_2.npy"):
        path.unlink()
    for path in list(folder.glob("*.npy")):
        np.save(path.with_name(f"{path.stem}_close.npy"), np.load(path) / 8)
        path.rename(path.with_name(f"{path.stem}_wide.npy"))
    rows = [f"{p.name},{p.stem.split('_')[0]},{p.stem.split('_')[1]},{'60nm' if 'close' in p.stem else '480nm'}"
            for p in sorted(folder.glob("*.npy"))]  # fmt: skip
    (folder / "study.csv").write_text("\n".join(["file, sample, spot, size", *rows]))
    found = c.study(folder, unit="nm", material="silica")
    assert len(found.spots) == 2
    for spot in found.spots:
        assert spot.found is not None
        assert spot.found.topographies[0].measurements == 2
    joined = c.predict(
        folder / "ground_1_close.npy", folder / "ground_1_wide.npy", join=True, size=["60nm", "480nm"], unit="nm",
        material="silica", solve=False,
    )  # fmt: skip
    ground = next(spot for spot in found.spots if (spot.sample, spot.name) == ("ground", "1"))
    assert ground.found is not None
    assert ground.found.row() == joined.row()


@pytest.mark.parametrize(
    ("names", "pattern", "expected"),
    [
        (["a.npy", "b.txt"], None, [("a", "1"), ("b", "1")]),
        (["a/1.npy", "a/2_10um.npy", "b_1.gwy"], None, [("a", "1"), ("a", "2"), ("b", "1")]),
        (["x-1 fine.npy", "x-2 wide.npy"], "{sample}-{spot} {magnification}", [("x", "1"), ("x", "2")]),
        (["a/s1.npy", "b/s1.npy"], "{sample}/s{spot}", [("a", "1"), ("b", "1")]),
        (["a.npy", "notes.md", ".hidden", "a.html"], None, [("a", "1")]),
    ],
)
def test_names_say_which_file_is_which(
    names: list[str], pattern: str | None, expected: list[tuple[str, str]], tmp_path: Path
) -> None:
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("1")
    assert sorted((scan.sample, scan.spot) for scan in scans(tmp_path, pattern)) == expected


@pytest.mark.parametrize(
    ("files", "table", "options", "expected"),
    [
        ({}, None, {}, "a folder without a map in it"),
        (
            {"my_new_wafer_1.npy": ""},
            None,
            {},
            "1 of 1 names are not of the form SAMPLE.*my_new_wafer_1.npy.*`pattern`",
        ),
        ({"a.npy": ""}, None, {"pattern": "{sample}-{spot}"}, "not of the form '{sample}-{spot}': a.npy"),
        ({"a.npy": ""}, None, {"pattern": "{spot}"}, "it has {sample}"),
        ({"a.npy": ""}, None, {"pattern": "{sample}{sample}"}, "each once"),
        ({"a.npy": ""}, None, {"pattern": "{specimen}"}, "allowed: {sample}, {spot}, {magnification}"),
        ({"a.npy": ""}, "file,sample,side\na.npy,a,1\n", {}, "no column is called 'side'; allowed: file, sample"),
        ({"a.npy": ""}, "file,spot\na.npy,1\n", {}, "columns file and sample are needed"),
        ({"a.npy": ""}, "file,sample\nb.npy,b\n", {}, "study.csv:2: there is no file 'b.npy'"),
        ({"a.npy": ""}, "file,sample\na.npy,\n", {}, "study.csv:2: a file and a sample are needed"),
        ({"a.npy": ""}, "file,sample\n", {}, "no file is named"),
        ({"a.npy": ""}, None, {"material": "granite"}, "'granite' is unknown"),
    ],
)
def test_a_folder_that_is_no_study_is_refused_in_one_message(
    files: dict[str, str], table: str | None, options: dict[str, Any], expected: str, tmp_path: Path
) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    if table is not None:
        (tmp_path / "study.csv").write_text(table)
    with pytest.raises(InputError, match=expected):
        c.study(tmp_path, **KNOWN | options)


def test_arguments_of_a_study_are_named() -> None:
    with pytest.raises(ArgumentError, match=r"^colour = 'red': "):
        c.study(Path(__file__).parent, colour="red")
    with pytest.raises(InputError, match="there is no such folder"):
        c.study("no such folder")
    with pytest.raises(ArgumentError, match=r"^pattern = 3: "):
        c.study(Path(__file__).parent, material="mica", pattern=3)


def test_what_a_folder_cannot_be_used_with_is_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words, expected in (
        ([str(folder), str(folder)], "cannot be used beside 1 more"),
        ([str(folder), "--csv", "a.csv"], "cannot be used with --csv"),
        ([str(folder / "ground_1.npy"), "--pattern", "{sample}"], "no folder is given"),
        ([str(folder), "--pattern", "{spot}"], "--pattern '{spot}'"),
    ):
        assert main(["predict", *words, "--size", "1um", "--unit", "nm", "--material", "mica"]) == 2
        assert expected in capsys.readouterr().err


def test_a_spot_that_cannot_be_used_is_named_and_left_out(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save(folder / "ground_3.npy", np.ones((32, 32)))
    options = ["--size", "480nm", "--unit", "nm", "--material", "silica", "-o", str(tmp_path / "out")]
    assert main(["predict", str(folder), *options]) == 1
    said = capsys.readouterr().out
    assert "ground, spot 3: left out: ground_3.npy: all heights are equal" in said
    assert "1 not usable" in said
