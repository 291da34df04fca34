"""The views of a map: its layers, its roughness, its faults, and those that the answer adds."""

import base64
import math
from collections.abc import Container, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.front.predict import READ, prepared
from continuum.inputs import units
from continuum.maps.faults import MapFault, find_faults
from continuum.maps.map import Topography, TopographyError
from continuum.maps.mending import cut_off, detrend, fill_outliers
from continuum.maps.quantities import length_of, share
from continuum.maps.roughness import areal_parameters
from continuum.maps.verdict.prediction import PredictionNumbers

_POINTS = 512
"""Points along a side that are sent to be drawn, at most."""
_PREPARED = READ | {"detrend", "cutoff"}
_UNKNOWN: tuple[tuple[str, dict[str, str | None]], ...] = (
    ("give `size`", {"size": "1m"}),
    ("give `unit`", {"unit": "m"}),
    ("the unit of its positions", {"size": None, "unit": "m,m"}),
)
"""Assumptions with which a map is shown whose file, as the message says, lacks them."""


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
