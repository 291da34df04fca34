"""What is open in the browser: the files of a map, what is seen at once, and the answer."""

import base64
import json
import math
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from continuum import units
from continuum.errors import InputError
from continuum.front.predict import READ, Prediction, of_maps
from continuum.model.fourier import Real
from continuum.show.answer import statements
from continuum.show.plot import contact_colours, map_colours, written_as
from continuum.sticky.materials import materials
from continuum.sticky.tables import OPTIONS
from continuum.sticky.threshold import Basis, MapThreshold
from continuum.topography.areal import areal_parameters
from continuum.topography.faults import MapFault, find_faults
from continuum.topography.map import Topography, TopographyError
from continuum.topography.mending import cut_off, detrend, fill_outliers, prepare
from continuum.topography.quantities import length_of, share
from continuum.topography.reading import read_all

FLAGS = frozenset(name for name, field in OPTIONS.items() if field.annotation is bool)
"""Fields that are ticked or not; all fields of the form are keys of the tables of a prediction."""
BODIES = frozenset({"material", "modulus", "poisson"})
"""Fields with a value for each body, after commas; others have one for each file, after semicolons."""
EXAMPLE = "inputs/maps/wafer.txt"
"""A map to try, and what is filled in for it."""
EXAMPLE_FORM = {"size": "384nm", "unit": "nm", "material": "silicon, silicon"}
_LONGEST = 200
_FAULTS = "Faulty map"
"""How the statement about faults begins: the page has buttons in its place."""
_POINTS = 512
"""Points along a side that are sent to be drawn, at most."""
_ASSUMED = {"size": "1m", "unit": "m"}
"""What is assumed to show a map whose file does not say it."""


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

    def look(self, asked: Mapping[str, str]) -> dict[str, Any]:
        """The map, its roughness and its faults, without the fields of the bodies.

        A map whose size or unit is not known is shown in pixels or in the numbers of its file.  Raises InputError if
        it cannot be read.
        """
        given = arguments(asked)
        measured, lacks = self._read({name: given[name] for name in READ if name in given})
        how, limit = given.get("detrend"), share(given.get("fill"))
        cutoff = None if lacks else given.get("cutoff")
        judged = [prepare(one, how, fill=limit, cutoff=cutoff) for one in measured]
        layers, faults, rows = list[Any](), list[Any](), list[Any]()
        for one, before in zip(judged, measured, strict=True):
            name = f" of {one.source}" if len(judged) > 1 else ""
            layers += [
                _layer(f"heights{name}", one, one.heights),
                _layer(f"as measured{name}", one, detrend(before, "none").heights),
            ]
            rows += [(f"{label}{name}", value) for label, value in _roughness(one, lacks)]
            for fault in () if lacks else find_faults(one).faults:
                taken = _correction(one, fault)
                title = f"{fault.kind}: what its correction takes off"
                faults.append({"text": fault.text, "set": fault.arguments, "layer": title if taken is not None else ""})
                layers += [] if taken is None else [_layer(title, one, taken)]
        bearing = _bearing(judged[0].heights, measured[0].heights)
        return {"layers": layers, "rows": rows, "faults": faults, "lacks": lacks, "bearing": bearing}

    def _read(self, told: Mapping[str, Any]) -> tuple[list[Topography], list[str]]:
        """The maps as read, and what of size and unit is not known."""
        try:
            return read_all(self.paths, **told), []
        except TopographyError as error:
            lacks = [name for name in _ASSUMED if f"give `{name}`" in str(error)]
            if not lacks:
                raise
        return read_all(self.paths, **{**told, **{name: _ASSUMED[name] for name in lacks}}), lacks

    def predict(
        self, asked: Mapping[str, str], last: Prediction | None = None, told: Callable[[str], None] = lambda text: None
    ) -> Prediction:
        """The prediction for a form, as the command makes it; raises InputError about its fields.

        A threshold that does not depend on the work of adhesion is that of the ``last`` prediction, where nothing else
        has changed.
        """
        found = of_maps(self.paths, arguments(asked), told)
        if last is not None and last.threshold is not None and _same_but_work(found, last):
            again = replace(found, threshold=last.threshold, threshold_as_measured=last.threshold_as_measured)
            work = found.contact.work_of_adhesion
            if all(_settled(one, work) for one in (again.threshold, again.threshold_as_measured) if one):
                return again
        return found.solved(told=told)

    def command(self, asked: Mapping[str, str], files: Sequence[str] = (), *more: str) -> list[str]:
        """The equivalent command, with further options."""
        words = ["continuum", "predict", *(files or self.shown)]
        for name, value in arguments(asked).items():
            option = "--estar" if name == "contact_modulus" else f"--{name.replace('_', '-')}"
            for each in value if isinstance(value, tuple) else (value,):
                words += [option] if each is True else [option, str(each)]
        return [*words, *more]

    def solving(self, asked: Mapping[str, str]) -> list[str]:
        """The command of this program that solves the map and writes page and numbers into the folder."""
        made = "--solve", "--output", str(self.folder / "solved"), "--json", str(self.folder / "solved.json")
        _, *words = self.command(asked, [str(path) for path in self.paths], *made)
        return [sys.executable, "-m", "continuum", *words]

    def solved(self) -> dict[str, Any]:
        """The answer of that command and its page; raises InputError where there is none."""
        pages, numbers = sorted((self.folder / "solved").glob("*.html")), self.folder / "solved.json"
        if not pages or not numbers.is_file():
            raise InputError("the map has not been solved yet")
        # The last lines of the command have the names of files.
        lines = (self.folder / "solved.txt").read_text(encoding="utf-8").splitlines()
        said = answer([line for line in lines if str(self.folder) not in line], json.loads(numbers.read_text("utf-8")))
        return {"answer": said, "page": pages[0].read_text(encoding="utf-8")}

    def report(self, found: Prediction) -> str:
        """The page that the command writes of a prediction."""
        with written_as(["png"]):
            page, *_ = found.write(self.folder / "report", "report")
        return page.read_text(encoding="utf-8")


def known_to_page() -> dict[str, Any]:
    """What the page knows from the start: materials, colours from the lowest value on, what its fields are."""
    return {
        "materials": sorted(materials()),
        "colours": {"contact": contact_colours(), "numbers": map_colours()},
        "help": {name: " ".join((one.description or "").split()) for name, one in OPTIONS.items()},
    }


def _settled(threshold: MapThreshold, work: float) -> bool:
    """Whether a threshold is from one state without adhesion, and decides a work without a search."""
    return threshold.source is Basis.STATE and threshold.sticky(work) is not None


def _same_but_work(one: Prediction, other: Prediction) -> bool:
    """Whether two predictions are of the same heights and bodies, but for the work of adhesion."""
    maps = [[(each.digest, each.lengths, each.periodic) for each in found.topographies] for found in (one, other)]
    work = other.interface.work_of_adhesion
    return maps[0] == maps[1] and replace(one.interface, work_of_adhesion=work) == other.interface


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


def _roughness(topography: Topography, lacks: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Size and areal parameters, as text; in pixels and in the numbers of the file where that is all that is known."""
    nx, ny = topography.heights.shape
    size = "" if "size" in lacks else " x ".join(units.readable(one, "length", 4) for one in topography.lengths)
    yield "points", f"{nx} x {ny}{size and f' of {size}'}"
    for name, value in areal_parameters(topography)._asdict().items():
        if name.startswith("Sd") and lacks:
            continue  # slopes need both
        in_length = name in {"Sq", "Sa", "Sz"} and "unit" not in lacks
        yield name, units.readable(value, "length", 3) if in_length else f"{value:.3g}"


def _bearing(judged: Real, measured: Real) -> list[list[float]]:
    """Share of the area above a height, in %, and that height above the mean: as judged, as measured, Gaussian."""
    area = np.linspace(0.001, 0.999, 200)
    both = [np.quantile(heights - heights.mean(), 1 - area) for heights in (judged, measured)]
    found: list[list[float]] = np.transpose([100 * area, *both, judged.std() * scipy.special.ndtri(1 - area)]).tolist()
    return found


def _correction(topography: Topography, fault: MapFault) -> Real | None:
    """What the correction of one fault takes off, shape (nx, ny); None where there is none of the same points."""
    told = fault.arguments
    if not told or not told.keys() <= {"detrend", "fill", "cutoff"}:
        return None
    made = fill_outliers(topography, share(told["fill"])) if "fill" in told else topography
    how: Any = told.get("detrend")
    made = made if how is None else detrend(made, how)
    wavelength = length_of("cutoff", told.get("cutoff"))
    made = made if wavelength is None else cut_off(made, wavelength)
    taken: Real = topography.heights - made.heights
    return taken


def _layer(name: str, topography: Topography, values: Real) -> dict[str, Any]:
    """Numbers on the points of a map, to be drawn: shape (nx, ny), x slowest, in single precision."""
    nx, ny = (math.ceil(n / _POINTS) for n in values.shape)
    sent = np.ascontiguousarray(values[::nx, ::ny], dtype="<f4")
    return {
        "name": name, "points": values.shape, "shape": sent.shape, "lengths": topography.lengths,
        "values": base64.b64encode(sent.tobytes()).decode(),
    }  # fmt: skip


def solved_layers(found: Prediction) -> list[dict[str, Any]]:
    """The contact at the threshold, as 2 repulsive, 1 attracted, 0 neither; and the heights that decide it, in J/m³."""
    threshold = found.threshold
    if threshold is None or threshold.state is None:
        return []
    facing, distance = (found.mended or found).facing, threshold.gap - threshold.wall.zero_gap
    kinds = np.where(distance <= 0, 2.0, np.where(distance < threshold.wall.range, 1.0, 0.0))
    deciding = np.abs(threshold.state.deciding_heights(threshold.wall))
    logarithm = np.log10(np.maximum(deciding / deciding.max(), 1e-3))

    def own(values: Real) -> Real:  # without mirror images
        images = [round(whole / one) for whole, one in zip(threshold.grid.shape, threshold.map.shape, strict=True)]
        return values[: values.shape[0] // images[0], : values.shape[1] // images[1]]

    return [
        _layer("contact at the threshold", facing, own(kinds)),
        _layer("which heights decide", facing, own(logarithm)),
    ]


def answer(lines: Sequence[str], data: Mapping[str, Any]) -> dict[str, Any]:
    """The answer of a prediction: its statements but that of faults, its row, its curve and its remarks.

    Parameters
    ----------
    lines : as the terminal has them.
    data : what ``--json`` writes.
    """
    said = [line.replace("--solve", "“Solve the contact”") for line in lines if not line.startswith(_FAULTS)]
    return {"statements": said, "row": data["row"], "curve": data["curve"], "doubts": data["warnings"]}


def answer_of(found: Prediction) -> dict[str, Any]:
    """The answer of a prediction, and the values of its sliders."""
    contact, pixels = found.contact, found.topographies[0].grid.spacing
    shown = {
        "work": units.readable(contact.work_of_adhesion, "energy_per_area", 3),
        "contact_modulus": units.readable(contact.contact_modulus, "pressure", 3),
        "range": units.readable(contact.range, "length", 3),
        "cutoff": units.readable(found.topographies[0].cutoff or 4 * max(pixels), "length", 3),
    }
    values = {name: text.replace(" ", "").replace("²", "2").replace("µ", "u") for name, text in shown.items()}
    return answer([f"{line}." for line in statements(found)], json.loads(found.json())) | {"values": values}


def safe_name(name: str) -> str:
    """A safe name for an uploaded file: letters, digits, dots, - and _ of its own name."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", Path(name.replace("\\", "/")).name).strip("._")[-80:].lstrip("._")
    return plain or "map"
