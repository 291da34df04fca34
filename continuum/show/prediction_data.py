"""A prediction for other programs: JSON with all results, or one row of a table.  SI units."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from continuum.maps.faults import MapFault
from continuum.maps.roughness import areal_parameters, spectrum
from continuum.maps.verdict.prediction import PredictionNumbers
from continuum.maps.verdict.threshold import MapThreshold
from continuum.store.sheet import Sheet

AREAL = {"Sq": "m", "Sa": "m", "Sz": "m", "Sdq": "", "Sdr": "", "Ssk": "", "Sku": ""}
"""Columns of areal parameters (ISO 25178-2), with their units."""


def row(prediction: PredictionNumbers) -> dict[str, str | float | None]:
    """One row of a table: the answer, the threshold with its bounds, faults, roughness, and w over that of theories."""
    verdict, contact = prediction.verdict, prediction.contact
    measured = prediction.threshold_as_measured
    found: dict[str, str | float | None] = {
        "map": " on ".join(topography.source for topography in prediction.topographies),
        "verdict": verdict.answer,
        "why": verdict.why,
        "work_of_adhesion_J/m2": contact.work_of_adhesion,
        "w/w_c": verdict.factor,
        **_threshold(prediction.threshold),
        **_adhesion(prediction),
        "w_c as measured_J/m2": None if measured is None else measured.work,
        "faults": "; ".join(fault.kind for fault in prediction.faults),
        "rms_height_m": contact.rms_height,
        "rms_slope": contact.rms_slope,
        "rms_curvature_1/m": contact.rms_curvature,
        **areal(prediction),
        "contact_modulus_Pa": contact.contact_modulus,
        "range_m": contact.range,
    }
    if (waves := prediction.continuation) is not None:
        found |= {"not measured below_m": waves.measured, "continued to_m": waves.smallest}
    found |= {f"{one.name}: w/w_c": one.margin for one in prediction.verdicts}
    if (probe := prediction.probe) is not None:
        found |= {"probe: pull-off with w - U_N": probe.least, "probe: pull-off with w_N": probe.most}
        found["probe: largest with 1 % in contact_N"] = probe.rim
        found["probe: pull-off by the curve_N"] = probe.by_curve
    return found


def _threshold(threshold: MapThreshold | None) -> dict[str, str | float | None]:
    if threshold is None:
        return {}
    return {
        "w_c_J/m2": threshold.work, "w_c low_J/m2": threshold.low, "w_c high_J/m2": threshold.high,
        "w_c from": threshold.source.name.lower(),
        **{f"w_c of the surface, {end}_J/m2": None if math.isnan(value) else value
           for end, value in zip(("low", "high"), threshold.of_surface, strict=True)},
    }  # fmt: skip


def _adhesion(prediction: PredictionNumbers) -> dict[str, str | float | None]:
    """Pull-off stress, and area and gap without load and at the given one."""
    found = prediction.adhesion
    if found is None:
        return {}
    row: dict[str, str | float | None] = {
        "pull-off stress_Pa": -found.pull_off.pressure, "pull-off: why at least": found.pull_off.doubt,
        "area at pull-off": found.pull_off.area,
    }  # fmt: skip
    for name, point in (("without load", found.unloaded), ("at the load", found.loaded),
                        ("at the load without adhesion", found.alone)):  # fmt: skip
        if point is not None:
            row |= {f"area {name}": point.area, f"mean gap {name}_m": point.gap}
    return row | ({} if prediction.pressure is None else {"pressure_Pa": prediction.pressure})


def _load_curve(prediction: PredictionNumbers) -> dict[str, Any] | None:
    """Mean pressures and gaps against the area: at w with the interval of w_c, at w_c, and without adhesion."""
    found = prediction.threshold
    curve = None if found is None else found.adhesion
    if found is None or curve is None or prediction.adhesion is None:
        return None
    works = load_works(prediction, found)
    return {
        "area": curve.pressures(0.0)[0].tolist(),
        "pressure_Pa": {name: curve.pressures(work)[1].tolist() for name, work in works.items()},
        "mean_gap_m": {name: curve.gaps(work).tolist() for name, work in works.items()},
    }


def load_works(prediction: PredictionNumbers, found: MapThreshold) -> dict[str, float]:
    """Works of adhesion of the curves that are shown, by their names.

    An error of w_c is one of the attraction: it is that of the curve of w times w_c over the ends of its interval.
    """
    work = prediction.contact.work_of_adhesion
    return {"w": work, "w low": work * found.work / found.high, "w high": work * found.work / found.low,
            "w_c": found.work, "none": 0.0}  # fmt: skip


def areal(prediction: PredictionNumbers) -> dict[str, float]:
    """Areal parameters with their units, of one measured map: a spectrum of lines or of several maps has none."""
    if len(prediction.topographies) > 1 or prediction.topographies[0].bands is not None:
        return {}
    found = areal_parameters(prediction.topographies[0])._asdict()
    return {f"{name}_{unit}" if unit else name: found[name] for name, unit in AREAL.items()}


def remedy_options(fault: MapFault) -> str:
    """The remedy of a fault as options of the command; empty where there is none."""
    return " ".join(f"--{name} {value}" for name, value in fault.arguments.items())


def as_csv(rows: Sequence[Mapping[str, str | float | None]]) -> str:
    """Rows as comma-separated values with all digits; columns in the order of their first appearance."""
    columns = list(dict.fromkeys(name for one in rows for name in one))
    return Sheet.of("", columns, [[one.get(name) for name in columns] for one in rows]).csv()


def as_json(prediction: PredictionNumbers) -> str:
    """All numbers of the page, with the whole spectrum of each map."""
    maps = []
    for topography, found, fit in zip(prediction.topographies, prediction.findings, prediction.fits, strict=True):
        q, c = spectrum(topography)
        maps.append({
            "source": topography.source,
            "sha256": topography.digest,
            "points": topography.heights.shape,
            "lengths_m": topography.lengths,
            "periodic": topography.periodic,
            "steps": topography.steps,
            "faults": [vars(fault) | {"remedy": remedy_options(fault)} for fault in found.faults],
            "directions": vars(found.directions),
            "summits": found.summits.value._asdict(),
            "fit": None if fit is None else vars(fit),
            "spectrum": {"q_1/m": q.tolist(), "C_m4": c.tolist()},
        })  # fmt: skip
    estimates = [
        {"name": e.name, "symbol": e.symbol, "value": e.value, "unit": e.unit, "w/w_c": e.margin,
         "source": e.source, "out_of_range": e.why}
        for e in prediction.estimates
    ]  # fmt: skip
    threshold, contact = prediction.threshold, prediction.contact
    content = {
        "verdict": {"answer": prediction.verdict.answer, "factor": prediction.verdict.factor,
                    "why": prediction.verdict.why},
        "row": row(prediction),
        "adhesion": _load_curve(prediction),
        "curve": None if threshold is None else [one._asdict() for one in threshold.curve],
        "maps": maps,
        "moments": prediction.roughness.moments._asdict(),
        "interface": asdict(prediction.interface),
        "probe": None if prediction.probe is None else vars(prediction.probe),
        "theories": estimates,
        "conformal_energy_J/m2": contact.conformal_energy,
        "warnings": prediction.doubts,
    }  # fmt: skip
    return json.dumps(_finite(content), indent=1, ensure_ascii=False) + "\n"


def _finite(value: Any) -> Any:
    """Replace numbers that JSON does not have."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(one) for name, one in value.items()}
    return [_finite(one) for one in value] if isinstance(value, list | tuple) else value
