"""The map or result that is open in the browser, its views, and the questions of a form about it.

Views of a map are its layers, its roughness, its faults, and those that the answer adds.
"""

import asyncio
import base64
import json
import math
import os
import pickle
import re
import secrets
import shlex
import shutil
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.front.predict import READ, Prediction, of_maps, prepared
from continuum.inputs import units
from continuum.inputs.errors import InputError
from continuum.maps.faults import MapFault, find_faults
from continuum.maps.map import Topography, TopographyError, length_of, share
from continuum.maps.mending import cut_off, detrend, fill_outliers
from continuum.maps.roughness import areal_parameters
from continuum.maps.verdict.prediction import PredictionNumbers
from continuum.maps.verdict.tables import OPTIONS
from continuum.maps.verdict.threshold import Basis, MapThreshold
from continuum.show.answer import COLOURS, statements, verdict_axis
from continuum.store.sweeps.workers import Task, Worker, say
from continuum.view.states import OpenedResults, is_stored

_POINTS = 512
"""Points along a side that are sent to be drawn, at most."""
_PREPARED = READ | {"detrend", "cutoff"}
_UNKNOWN: tuple[tuple[str, dict[str, str | None]], ...] = (
    ("give `size`", {"size": "1m"}),
    ("give `unit`", {"unit": "m"}),
    ("the unit of its positions", {"size": None, "unit": "m,m"}),
)
"""Assumptions with which a map is shown whose file, as the message says, lacks them."""
FLAGS = frozenset(name for name, option in OPTIONS.items() if option.annotation is bool)
"""Fields that are ticked or not; all fields of the form are keys of the tables of a prediction."""
BODIES = frozenset({"material", "modulus", "poisson"})
"""Fields with a value for each body, after commas; others have one for each file, after semicolons."""
Told = Callable[[str], None]
"""Hears what is being done; may raise an InputError to stop it."""
_LONGEST = 200
_FAULTS = "Faulty map"
"""First words of the statement about faults: the page has buttons in its place."""


def prepared_once(maps: Sequence[Path], given: Mapping[str, Any]) -> tuple[list[Topography], list[Topography]]:
    """Maps as measured and as they are judged, as :func:`continuum.front.predict.prepared`.

    Those that were read last are remembered, while the files are the same, with what was found on them.
    """
    changed = tuple(path.stat().st_mtime_ns for path in maps if path.is_file())
    return _read(tuple(maps), changed, tuple((name, value) for name, value in given.items() if name in _PREPARED))


@lru_cache(maxsize=1)
def _read(
    maps: tuple[Path, ...], changed: tuple[int, ...], given: tuple[tuple[str, Any], ...]
) -> tuple[list[Topography], list[Topography]]:
    return prepared(maps, dict(given))


def look(maps: Sequence[Path], given: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Maps and their roughness, and then their faults, without anything of the bodies.

    A map whose size or unit is not known is shown in pixels or in the numbers of its file.

    Parameters
    ----------
    maps : files of the maps.
    given : arguments of :func:`continuum.predict` by name, of which those of the maps are used.

    Raises InputError if they cannot be read.
    """
    lacks = dict[str, str | None]()
    try:
        measured, judged = prepared_once(maps, given)
    except TopographyError as error:
        lacks = {name: value for words, of in _UNKNOWN if words in str(error) for name, value in of.items()}
        if not lacks:
            raise
        measured, judged = prepared_once(maps, {**given, "cutoff": None, **lacks})
    several = len(judged) > 1
    names = [f" of {one.source}" if several else "" for one in judged]
    layers, rows = list[Any](), list[Any]()
    for name, one, before in zip(names, judged, measured, strict=True):
        if one.bands is None:
            layers.append(map_layer(f"heights{name}", one, one.heights))
            layers.append(map_layer(f"as measured{name}", one, detrend(before, "none").heights))
        else:
            layers.append(map_layer(f"a random surface with the measured spectrum{name}", one, one.heights))
        rows += [(f"{label}{name}", value) for label, value in _roughness(one, lacks)]
    yield {
        "layers": layers, "rows": rows, "lacks": list(lacks),
        "bearing": _bearing(judged[0].heights, measured[0].heights),
    }  # fmt: skip
    if lacks:
        return
    layers, faults = [], list[Any]()
    for name, one in zip(names, judged, strict=True):
        for fault in find_faults(one).faults:
            taken = correction_of(one, fault)
            title = f"{fault.kind}{name}: what its correction takes off"
            faults.append({"text": fault.text, "set": fault.arguments, "layer": title if taken is not None else ""})
            layers += [] if taken is None else [map_layer(title, one, taken)]
    yield {"faults": faults, "layers": layers}


def _roughness(topography: Topography, lacks: Container[str]) -> Iterator[tuple[str, str]]:
    """Size and areal parameters, as text; in pixels and in the numbers of the file where that is all that is known."""
    nx, ny = topography.heights.shape
    size = "" if "size" in lacks else " x ".join(units.readable(one, "length", 4) for one in topography.lengths)
    yield "points", f"{nx} x {ny}{size and f' of {size}'}"
    for name, value in areal_parameters(topography)._asdict().items():
        if name.startswith("Sd") and lacks:
            continue  # slopes need both
        in_length = name in {"Sq", "Sa", "Sz"} and "unit" not in lacks
        yield name, units.readable(value, "length", 3) if in_length else f"{value:.3g}"


def _bearing(judged: NDArray[np.float64], measured: NDArray[np.float64]) -> list[list[float]]:
    """Share of the area above a height, in %, and that height above the mean: as judged, as measured, Gaussian."""
    area = np.linspace(0.001, 0.999, 200)
    both = [np.quantile(heights - heights.mean(), 1 - area) for heights in (judged, measured)]
    found: list[list[float]] = np.transpose([100 * area, *both, judged.std() * scipy.special.ndtri(1 - area)]).tolist()
    return found


def correction_of(topography: Topography, fault: MapFault) -> NDArray[np.float64] | None:
    """Heights that a correction takes off, shape (nx, ny); None if the corrected map has other points."""
    told = fault.arguments
    if not told or not told.keys() <= {"detrend", "fill", "cutoff"}:
        return None
    made = fill_outliers(topography, share(told["fill"])) if "fill" in told else topography
    how: Any = told.get("detrend")
    made = made if how is None else detrend(made, how)
    wavelength = length_of("cutoff", told.get("cutoff"))
    made = made if wavelength is None else cut_off(made, wavelength)
    taken = topography.heights - made.heights
    # A scar is narrower than what is drawn of a large map: the largest number of each block stands for it.
    blocks = _blocks(taken)
    high, low = (scipy.ndimage.maximum_filter(taken, blocks), scipy.ndimage.minimum_filter(taken, blocks))
    most: NDArray[np.float64] = np.where(high > -low, high, low)
    return most


def _blocks(values: NDArray[np.float64]) -> list[int]:
    """Points of a map along x and y for each point that is drawn."""
    return [math.ceil(n / _POINTS) for n in values.shape]


def map_layer(name: str, topography: Topography, values: NDArray[np.float64], kind: str = "height") -> dict[str, Any]:
    """Numbers on the points of a map, to be drawn: shape (nx, ny), x slowest, in single precision."""
    nx, ny = _blocks(values)
    sent = np.ascontiguousarray(values[::nx, ::ny], dtype="<f4")
    return {
        "name": name, "kind": kind, "points": values.shape, "shape": sent.shape, "lengths": topography.lengths,
        "values": base64.b64encode(sent.tobytes()).decode(),
    }  # fmt: skip


def solved_layers(found: PredictionNumbers) -> list[dict[str, Any]]:
    """The contact at the threshold, as 2 repulsive, 1 attracted, 0 neither; and the heights that decide it, in J/m³.

    Of two bodies first their heights, face to face.
    """
    threshold = found.threshold
    if threshold is None or threshold.state is None:
        return []
    facing, both = (found.mended or found).facing, len(found.topographies) > 1
    return [
        *([map_layer("both maps, face to face", facing, facing.heights)] if both else []),
        map_layer("contact at the threshold", facing, threshold.kinds, "contact"),
        map_layer("which heights decide", facing, threshold.deciding(threshold.state, 3.0), "deciding"),
    ]


@dataclass(frozen=True)
class OpenedMap:
    """A topography of one or several files, and the folder for what is made of them.

    Parameters
    ----------
    paths : the files: of one body or two, or measurements of one surface that are joined.
    shown : their names that are shown, never paths on this machine.
    folder : private folder of the program.
    """

    paths: tuple[Path, ...]
    shown: tuple[str, ...]
    folder: Path

    def predict(
        self,
        asked: Mapping[str, str],
        last: Prediction | None = None,
        told: Told = lambda text: None,
        search: bool | None = None,
    ) -> Prediction:
        """The prediction for a form, as the command makes it; raises InputError about its fields.

        A threshold that does not depend on the work of adhesion is that of the ``last`` prediction, where nothing else
        has changed.
        """
        found = of_maps(self.paths, arguments(asked), told, prepared_once)
        if last is not None and last.threshold is not None and _same_but_work(found, last):
            again = replace(found, threshold=last.threshold, threshold_as_measured=last.threshold_as_measured)
            work = found.contact.work_of_adhesion
            if all(_settled(one, work) for one in (again.threshold, again.threshold_as_measured) if one):
                return again
        return found.solved(search=search, told=told)

    def searched(self, asked: Mapping[str, str], worker: Worker, told: Told) -> Prediction:
        """The prediction after a search with adhesion by a worker, which may be stopped: then raises InputError."""
        task = Task(self.folder / "searched", "search")
        try:
            worker.give(partial(_search, self, asked), task)
            while (said := worker.take()).share is not None:
                told(said.text)
        finally:
            worker.end(now=True)
        if said.error or said.death:
            raise said.error or InputError(f"the search has ended: {said.death}")
        found: Prediction = pickle.loads(task.path.read_bytes())
        return found

    def command(self, asked: Mapping[str, str], *more: str) -> str:
        """The equivalent command, with further options."""
        words = ["continuum", "predict", *self.shown]
        for name, value in arguments(asked).items():
            option = "--estar" if name == "contact_modulus" else f"--{name.replace('_', '-')}"
            for each in value if isinstance(value, tuple) else (value,):
                words += [option] if each is True else [option, str(each)]
        return shlex.join([*words, *more])

    def report(self, found: Prediction) -> str:
        """The page that the command writes of a prediction."""
        page, *_ = found.write(self.folder / "report", "report")
        return page.read_text(encoding="utf-8")


def _search(opened: OpenedMap, asked: Mapping[str, str], task: Task) -> None:
    found = opened.predict(asked, told=lambda text: say(0.0, text), search=True)
    task.path.write_bytes(pickle.dumps(found))


@dataclass
class View:
    """The state of one call of ``continuum view``; the only mutable object here."""

    folder: Path
    """Private folder, removed when the program ends."""
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    port: int = 0
    opened: OpenedMap | None = None
    results: OpenedResults | None = None
    last: Prediction | None = None
    """The last prediction of the open map."""
    searching: Worker = field(default_factory=lambda: Worker(os.environ))
    working: asyncio.Lock = field(default_factory=asyncio.Lock)
    """Lock for solving and drawing: one thing at a time, as the style of figures is global to the process."""
    asked: int = 0
    """Questions so far: of those that wait or are worked on, only the last one is answered."""

    def place(self, name: str) -> Path:
        """Path for an upload, in a new folder; raises InputError if it would be read as an input."""
        kept = safe_name(name)
        if kept.lower().endswith(".toml"):
            raise InputError("an input names files of this machine: open it with `continuum predict`")
        return self._new_folder() / kept

    def _new_folder(self) -> Path:
        folder = self.folder / secrets.token_hex(4)
        folder.mkdir()
        return folder

    def open(self, path: Path, shown: str, beside: bool = False) -> None:
        """Open a map in place of the open map, or results in place of the open results, which are forgotten.

        A map ``beside`` the open one is of the other body, or joined to it.  Raises InputError if it is a folder
        without results.
        """
        if path.is_dir() or is_stored(path):
            before = [] if self.results is None else [file.parent for file in self.results.runs.values()]
            self.results = OpenedResults.of(path)
        else:
            self.ask()
            self.last, opened = None, self.opened
            if beside and opened is not None:
                self.opened = replace(opened, paths=(*opened.paths, path), shown=(*opened.shown, shown))
                return
            before = [] if opened is None else [*(each.parent for each in opened.paths), opened.folder]
            self.opened = OpenedMap((path,), (shown,), self._new_folder())
        self.forget(*before)

    def ask(self) -> int:
        """Begin another question, and stop the search of the one before; returns its number."""
        self.searching.stop()
        self.asked += 1
        return self.asked

    def forget(self, *folders: Path) -> None:
        """Delete folders of uploads and of what was made of them, and none of the user's."""
        for folder in folders:
            if folder.parent == self.folder:
                shutil.rmtree(folder, ignore_errors=True)

    def is_open(self, path: Path) -> bool:
        """True if a file is the open map or the open results."""
        results = () if self.results is None else self.results.runs.values()
        return path in results or (self.opened is not None and path in self.opened.paths)

    def without_folders(self, said: str) -> str:
        """A text without names of folders."""
        hidden = {} if self.opened is None else dict(zip(map(str, self.opened.paths), self.opened.shown, strict=True))
        hidden |= {} if self.results is None else {f"{file.parent}/": "" for file in self.results.runs.values()}
        for place, shown in hidden.items():
            said = said.replace(place, shown)
        return said


def _settled(threshold: MapThreshold, work: float) -> bool:
    """True if a threshold is from one state without adhesion, and decides a work without a search."""
    return threshold.source is Basis.STATE and threshold.sticky(work) is not None


def _same_but_work(one: Prediction, other: Prediction) -> bool:
    """True if two predictions are of the same heights and bodies, but for w and for what is read off the curve."""
    maps = [[(each.digest, each.lengths, each.periodic) for each in found.topographies] for found in (one, other)]
    read = {name: getattr(other.interface, name) for name in ("work_of_adhesion", "pressure", "load", "probe")}
    return maps[0] == maps[1] and replace(one.interface, **read) == other.interface


def arguments(asked: Mapping[str, str]) -> dict[str, Any]:
    """Convert a form to arguments of :func:`continuum.predict`; raises InputError for what is no field of it."""
    found: dict[str, Any] = {}
    for name, value in asked.items():
        if name not in OPTIONS or not isinstance(value, str) or len(value) > _LONGEST:
            raise InputError(f"{name[:40]}: not a field of the form, or not a short text")
        several = tuple(part.strip() for part in re.split("[;,]" if name in BODIES else ";", value))
        if value.strip():
            found[name] = True if name in FLAGS else several if len(several) > 1 else several[0]
    return found


def answer_of(found: Prediction) -> dict[str, Any]:
    """The answer of a prediction: verdict, statements but that of faults, row, curves, remarks, values of sliders."""
    contact, pixels = found.contact, found.topographies[0].grid.spacing
    shown = {
        "work": units.readable(contact.work_of_adhesion, "energy_per_area", 3),
        "contact_modulus": units.readable(contact.contact_modulus, "pressure", 3),
        "range": units.readable(contact.range, "length", 3),
        "cutoff": units.readable(found.topographies[0].cutoff or 4 * max(pixels), "length", 3),
    }
    # Without a pressure the slider begins at that of the pull-off stress.
    if (pressure := found.pressure or (found.adhesion and -found.adhesion.pull_off.pressure)) and pressure > 0:
        shown["pressure"] = units.readable(pressure, "pressure", 3)
    answer = found.verdict.answer
    said = [f"{line}.".replace("--solve", "“Solve the contact”") for line in statements(found)]
    data = json.loads(found.json())
    return {
        "verdict": answer.capitalize(), "colour": COLOURS[answer], "axis": verdict_axis(found),
        "statements": [line for line in said if not line.startswith(_FAULTS)],
        "row": data["row"], "curve": data["curve"], "adhesion": data["adhesion"], "doubts": data["warnings"],
        "values": {name: text.replace(" ", "").replace("²", "2").replace("µ", "u") for name, text in shown.items()},
    }  # fmt: skip


def safe_name(name: str) -> str:
    """A safe name for an uploaded file: letters, digits, dots, - and _ of its own name."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", Path(name.replace("\\", "/")).name).strip("._")[-80:].lstrip("._")
    return plain or "map"
