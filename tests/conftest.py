"""Fixtures shared by all tests."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure

OF_WORKERS = {"continuum": "continuum.front.sweeps", "atomistic": "atomistic.front.validation"}
"""The module of each package that starts processes."""

# Whether a test passes must not depend on how fast the machine is, on who else uses it, or on what is drawn that day:
# examples are drawn from a seed.  `make search` draws more of them, and others each time.
settings.register_profile("any machine", deadline=None, derandomize=True, max_examples=12)
settings.register_profile("few", settings.get_profile("any machine"), max_examples=2)  # that a thing runs at all
settings.register_profile("search", deadline=None, max_examples=200)
settings.load_profile("any machine")

# Said before numpy is imported: its BLAS has a thread per core, which spin where they wait, and the tests run one
# process per core already.  A busy machine needed 30 times as long for matrices of 6 x 6.
for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
# Processes of MPI spin where they wait for one another: on a busy machine for the time of the others, seconds each.
os.environ.setdefault("MPIR_CVAR_CH4_PROGRESS_THROTTLE", "1")
os.environ.setdefault("MPIR_CVAR_CH4_PROGRESS_THROTTLE_NO_PROGRESS_COUNT", "8")


# Modules and tests, a million objects, stay to the end.  To search them for what can be freed takes a sixth of the time
# of their collection, and a tenth of that of the tests.
gc.disable()


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.set_threshold(20_000, 10, 10)  # figures and tables are thousands of objects: a few of them between two searches
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The tests of whole programs begin, as some take ten seconds: at the end, one process would wait for the other."""
    items.sort(key=lambda item: package_of(item.path) is not None)


def package_of(path: Path) -> str | None:
    """The package whose rooms the tests of a file are about; None for those of whole programs and of the repository."""
    _, _, inside = path.as_posix().rpartition("/tests/")  # also of a copy, whose files are links to these
    parts = inside.split("/")
    return parts[1] if len(parts) > 2 else None


@pytest.fixture(autouse=True, scope="module")
def in_this_process(request: pytest.FixtureRequest) -> Iterator[None]:
    """Sweeps, and validations, of one worker are done here: a process of their own takes two seconds to start.

    Those of several workers, clusters, and the tests of whole programs have their processes.
    """
    module = OF_WORKERS.get(package_of(request.path) or "")
    with pytest.MonkeyPatch.context() as patch:
        if module:
            from tests.tasks import tasks_here

            patch.setattr(f"{module}.run_tasks", tasks_here)
        yield


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """The input file of a run of five points that takes a fraction of a second."""
    from tests.problems import SMALL

    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture
def unpressed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Predictions press no map: for tests of what is read, and of what is asked."""
    from continuum.front.predict import Prediction

    monkeypatch.setattr(Prediction, "no_map", "maps are not pressed here")


@pytest.fixture(autouse=True, scope="session")
def blank_pictures() -> Iterator[Callable[..., bytes]]:
    """Figures are made, and a blank picture is saved for each, as PNG only, in no time; yields what draws them.

    `really_drawn` has them drawn, `written_as(["png", "pdf"])` gives the formats, and `print_quality` the pixels that
    users get.  Of the session, so that fixtures of modules save such figures, too.
    """
    from continuum.show import plot

    draw = plot.image_bytes

    @cache
    def blank(form: str) -> bytes:
        return draw(plot.new_figure(1.0, 1.0), form)

    with plot.written_as(["png"]), pytest.MonkeyPatch.context() as patch:
        patch.setitem(plot.STYLE, "savefig.dpi", plot.STYLE["savefig.dpi"] / 4)
        patch.setattr(plot, "image_bytes", lambda figure, form="png": blank(form))
        yield draw


@pytest.fixture
def really_drawn(blank_pictures: Callable[..., bytes], monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are drawn as they are saved: for tests of the files of figures, and one of each kind of figure."""
    monkeypatch.setattr("continuum.show.plot.image_bytes", blank_pictures)


@pytest.fixture(autouse=True, scope="session")
def narrow_tables() -> Iterator[None]:
    """Every table that a command prints fits into its width, except for the name of a file."""
    from continuum.show import console
    from continuum.store.sheet import WIDEST

    printed = console._console.out

    def checked(text: str, **how: bool) -> None:
        wide = [line for line in text.splitlines() if len(line) > WIDEST]
        assert all(max(map(len, line.split())) > WIDEST / 2 for line in wide), "\n".join(["a wide table", *wide])
        printed(text, **how)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(console._console, "out", checked)
        yield


@pytest.fixture(autouse=True, scope="session")
def unsynced() -> Iterator[None]:
    """Files are not forced onto the disk, which takes longer than to write them: no test takes its power away."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda descriptor: None)
        yield


@pytest.fixture
def print_quality(really_drawn: None, monkeypatch: pytest.MonkeyPatch) -> float:
    """Figures are drawn and have the pixels per inch of print: for tests of pixels."""
    from continuum.show.plot import STYLE

    monkeypatch.setitem(STYLE, "savefig.dpi", 300.0)
    return 300.0


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> dict[str, Figure]:
    """The figures that would be saved, by name."""
    from continuum.show import plot

    figures: dict[str, Figure] = {}

    def noted(figure: Figure, stem: Path) -> Path:
        figures[stem.name] = figure
        return stem

    monkeypatch.setattr(plot, "save_figure", noted)
    return figures


@pytest.fixture
def rng() -> np.random.Generator:
    """A seeded generator: a failure repeats."""
    import numpy as np

    return np.random.default_rng(20140210)


@pytest.fixture
def expanded(monkeypatch: pytest.MonkeyPatch) -> float:
    """Every crystal at a temperature is larger by this factor: said, not measured, which takes half a minute."""
    from atomistic.response.thermal import WarmCrystal

    def warm(model: object, temperature: float, mobile: int, *_: object) -> WarmCrystal:
        return WarmCrystal(temperature, 1.006, 1e-5, 0.0, (0.0,) * mobile, 1e-4)

    monkeypatch.setattr("atomistic.relax.decks.warm_crystal", warm)
    return 1.006
