"""What measured maps are made of and what is done with them: an argument that is none is refused by its name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import continuum as c
from continuum.inputs.arguments import ArgumentError
from continuum.maps.faults import directions, find_faults
from continuum.maps.map import Topography, mirror, opposed
from continuum.maps.mending import (
    background,
    crop,
    cut_off,
    detrend,
    fill_outliers,
    harmonic,
    prepare,
    wall_from_map,
)
from continuum.maps.reading import read_all, read_topography
from continuum.maps.roughness import fit_self_affine, roughness_of, spectrum, stencil_moments, together
from continuum.maps.scanlines import scan_lines
from continuum.maps.spectra import isotropic_surface, joined
from continuum.maps.verdict.materials import Body, Interface, materials, read_interface
from continuum.maps.verdict.prediction import prediction_of
from continuum.maps.verdict.threshold import press_map
from tests.wrong import ANYTHING, refused_by_name

HEIGHTS = np.random.default_rng(1).normal(size=(16, 18)).cumsum(0)
MAP = Topography(HEIGHTS, (16.0, 18.0))
LARGE = Topography(np.random.default_rng(1).normal(size=(40, 40)).cumsum(0), (40.0, 40.0))
CONTACT = Interface(1.0, 0.01, 0.35, 1.0)
LINE = np.random.default_rng(1).normal(size=64).cumsum()
Q, C = spectrum(MAP)
SIZED: dict[str, Any] = {"size": (1.0,), "unit": 1.0, "periodic": False, "corners": None, "fill": 0.0, "void": ()}

CALLS: dict[str, tuple[Any, dict[str, Any]]] = {
    "Topography": (Topography, {"heights": HEIGHTS, "lengths": (1.0, 1.0), "periodic": False, "source": "map",
                                "cutoff": None, "lines": 0, "measurements": 0}),
    "mirror": (mirror, {"topography": MAP}),
    "opposed": (opposed, {"first": MAP, "second": MAP}),
    "detrend": (detrend, {"topography": MAP, "how": "plane"}),
    "prepare": (prepare, {"topography": MAP, "how": None, "cutoff": None}),
    "background": (lambda topography: background(topography, 2), {"topography": MAP}),
    "crop": (lambda heights, corners: crop(heights, (1.0, 1.0), corners),
             {"heights": HEIGHTS, "corners": (0, 1, 0, 1)}),
    "harmonic": (harmonic, {"heights": HEIGHTS, "holes": HEIGHTS > 100}),
    "fill_outliers": (fill_outliers, {"topography": MAP, "limit": 0.05}),
    "cut_off": (cut_off, {"topography": MAP, "wavelength": 4.0}),
    "wall_of": (wall_from_map, {"topography": LARGE, "n": 32, "spacing": 1.0, "edges": "mirror", "centre": (0.5, 0.5)}),
    "find_faults": (find_faults, {"topography": MAP}),
    "directions": (directions, {"topography": MAP}),
    "scan_lines": (scan_lines, {"heights": HEIGHTS}),
    "joined": (joined, {"topographies": [MAP], "seed": 0, "source": "maps"}),
    "isotropic_surface": (isotropic_surface, {"lines": LINE, "length": 64.0, "periodic": False}),
    "roughness_of": (roughness_of, {"topography": MAP}),
    "spectrum": (spectrum, {"topography": MAP}),
    "cut": (roughness_of(MAP).cut, {"wavelength": 3.0}),
    "stencil_moments": (stencil_moments, {"grid": MAP.grid, "heights": HEIGHTS, "periodic": False}),
    "together": (together, {"first": roughness_of(MAP), "second": roughness_of(MAP)}),
    "fit_self_affine": (fit_self_affine, {"wavenumber": Q, "density": C}),
    "read": (read_topography, {"heights": Path(__file__).parents[5] / "docs" / "none.npy", "size": (1.0,),
                               "unit": 1.0}),
    "read, array": (read_topography, {"heights": HEIGHTS, **SIZED}),
    "read_all": (lambda **given: read_all([HEIGHTS], **given), {"size": "10um", "unit": "nm", "dataset": None,
                                                               "part": None, "periodic": False, "crop": None,
                                                               "fill": None, "void": (), "override_size": False}),
    "Body": (Body, {"modulus": 1.0, "poisson": 0.3, "material": materials()["mica"]}),
    "Interface": (Interface, {"contact_modulus": 1.0, "work_of_adhesion": 1.0, "range": 1.0, "spacing": None}),
    "read_interface": (read_interface, {"material": "mica", "modulus": (), "poisson": (), "contact_modulus": None,
                                        "work": None, "range": None, "spacing": None}),
    "prediction_of": (prediction_of, {"topographies": [MAP], "interface": CONTACT}),
    "press_map": (press_map, {"topography": MAP, "interface": CONTACT}),
}  # fmt: skip


@pytest.mark.parametrize("call", CALLS)
@given(data=st.data())
@settings(suppress_health_check=[HealthCheck.too_slow])
def test_what_is_no_argument_is_refused_by_its_name(call: str, data: st.DataObject) -> None:
    function, good = CALLS[call]
    refused_by_name(function, good, data.draw(st.sampled_from(sorted(good))), data.draw(ANYTHING))


@pytest.mark.parametrize("call", [call for call in CALLS if call != "read"])
def test_what_is_good_is_taken(call: str) -> None:
    function, good = CALLS[call]
    function(**good)


@pytest.mark.parametrize("name", ["contact_modulus", "work_of_adhesion", "range", "spacing"])
@pytest.mark.parametrize("value", [0, -1.0, np.nan, np.inf, "1", True])
def test_an_interface_is_of_positive_numbers(name: str, value: Any) -> None:
    known: dict[str, Any] = {"contact_modulus": 1.0, "work_of_adhesion": 1.0, "range": 1.0, "spacing": 1.0}
    with pytest.raises(ArgumentError, match=rf"^{name} = "):
        Interface(**known | {name: value})


def test_threads_of_a_solution_are_counted_before_it_begins() -> None:
    with pytest.raises(ArgumentError, match=r"^threads = 0: "):
        c.predict(HEIGHTS, size="1um", unit="nm", material="mica", threads=0)


def test_a_masked_point_is_a_missing_one() -> None:
    """The number that stands under a mask, often zero or a million, was taken for a height."""
    mask = np.quantile(HEIGHTS, 0.99) < HEIGHTS
    with pytest.raises(ValueError, match="3 of 288 heights are missing"):
        Topography(np.ma.masked_array(np.where(mask, 1e6, HEIGHTS), mask), (1.0, 1.0))
