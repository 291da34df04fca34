"""Writers replace their own files only: what somebody else has put there is left alone, and said."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import continuum as c
from continuum.inputs.errors import OutputError
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.paper.page import plot_figure
from continuum.show.plot import new_figure, save_figure, written_as
from continuum.store import output

RUN = {
    "grid": {"n": 16},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 16.0, "seed": 1},
    "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.01},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "mean-gap", "targets": [1.2, 0.9]},
}
Writer = Callable[[Path], object]


def _run(folder: Path) -> object:
    return c.run(RUN, folder)


def _pictures(folder: Path) -> object:
    with written_as(["png", "pdf", "svg"]):
        return save_figure(new_figure(1, 1), folder / "figure")


@cache
def _predicted() -> c.Prediction:
    grid = Grid.square(32)
    heights = 1e-9 * SelfAffine(0.8, 0.1, 4.0, 16.0).synthesise(grid, np.random.default_rng(1))
    return c.predict(heights, size="32nm", unit="m", material="silicon", solve=False)


def _prediction(folder: Path) -> object:
    """Its page, with an empty figure: drawing takes most of the time."""
    with written_as(["png"]), pytest.MonkeyPatch.context() as patch:
        patch.setattr("continuum.show.prediction_figures.overview", lambda _: new_figure(1, 1))
        return _predicted().write(folder, "prediction")


def _figure(folder: Path) -> object:
    root = folder / "of" / "sweep"
    if not root.exists():
        c.sweep(RUN | {"sweep": {"axes": {"surface.seed": [1, 2]}}}, folder / "of", name="sweep", workers=1)
    return plot_figure("verdicts", root, into=folder)


@pytest.mark.parametrize("write", [_run, _pictures, _prediction, _figure])
def test_a_file_of_somebody_else_is_left_alone(write: Writer, tmp_path: Path) -> None:
    write(tmp_path)
    files = [path for path in tmp_path.iterdir() if path.is_file()]
    assert files
    for path in {file.suffix: file for file in files}.values():  # one of each kind
        kept = path.read_bytes()
        path.write_bytes(b"mine, and dear to me\n")
        with pytest.raises(OutputError, match="left alone"):
            write(tmp_path)
        assert path.read_bytes() == b"mine, and dear to me\n"
        path.write_bytes(kept)
    write(tmp_path)  # its own are replaced


@given(st.binary(max_size=60), st.binary(max_size=60))
def test_a_file_is_replaced_by_one_that_begins_alike_or_says_whose_it_is(
    tmp_path_factory: pytest.TempPathFactory, old: bytes, new: bytes
) -> None:
    path = tmp_path_factory.mktemp("output") / "file"
    path.write_bytes(old)
    cells = [text.partition(b"\n")[0].partition(b",")[0].strip() for text in (old, new)]
    if old and cells[0] != cells[1]:
        with pytest.raises(OutputError):
            output.save(path, new)
        assert path.read_bytes() == old
    else:
        assert output.save(path, new).read_bytes() == new
    marked = new + output.MARK
    path.write_bytes(old + output.MARK)
    assert output.save(path, marked).read_bytes() == marked
    path.write_bytes(old + b"!")
    with pytest.raises(OutputError):
        output.save(path, marked)
    assert output.save(path, marked, own=True).read_bytes() == marked


def test_a_figure_of_a_page_is_there_as_png_in_whatever_formats_it_is_asked_for(tmp_path: Path) -> None:
    with written_as(["svg"]):
        assert save_figure(new_figure(1, 1), tmp_path / "alone").suffix == ".svg"
        assert save_figure(new_figure(1, 1), tmp_path / "shown", page=True).suffix == ".png"
    assert {path.name for path in tmp_path.iterdir()} == {"alone.svg", "shown.png", "shown.svg"}
