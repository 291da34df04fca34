"""A prediction for other programs: JSON with all results, or one row of a table.  SI units."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from continuum.show.sheet import Sheet
from continuum.sticky.prediction import Prediction
from continuum.sticky.verdict import flattened, judge, unmeasured, votes
from continuum.topography.faults import MapFault
from continuum.topography.roughness import spectrum


def row(prediction: Prediction) -> dict[str, str | float | None]:
    """One row of a table: verdict, moments, contact, and the margin and record of each criterion."""
    verdict, contact = judge(prediction), prediction.contact
    found: dict[str, str | float | None] = {
        "map": " on ".join(topography.source for topography in prediction.topographies),
        "verdict": verdict.answer,
        "probability": verdict.probability,
        "faults": "; ".join(fault.kind for fault in prediction.faults),
        "rms_height_m": contact.rms_height,
        "rms_slope": contact.rms_slope,
        "rms_curvature_1/m": contact.rms_curvature,
        "contact_modulus_Pa": contact.contact_modulus,
        "work_of_adhesion_J/m2": contact.work_of_adhesion,
        "range_m": contact.range,
    }
    if (waves := prediction.continuation) is not None:
        beyond = unmeasured(prediction)
        found |= {"not measured below_m": waves.measured, "continued to_m": waves.smallest}
        found["verdict, continued"] = None if beyond is None else beyond.verdict.answer
    inside = ranges(prediction)
    for vote in votes(contact):
        name = vote.estimate.name
        found[f"{name}: margin"] = vote.estimate.margin
        found[f"{name}: in its range"] = "yes" if inside[vote.estimate.key].startswith("yes") else "no"
        if vote.support is not None:
            found[f"{name}: probability"] = vote.support.probability
    if (turn := prediction.turn) is not None:
        found["solved: w at the turn_J/m2"] = turn.work
        found["solved: largest w at the turn_J/m2"] = turn.most
    if prediction.simulation is not None:
        found["solved: load_Pa"] = prediction.simulation.load
    if prediction.solved_answer is not None:
        found["solved: verdict"] = prediction.solved_answer
    if (probe := prediction.probe) is not None:
        found |= {"probe: pull-off with w - U_N": probe.least, "probe: pull-off with w_N": probe.most}
        found["probe: largest with 1 % in contact_N"] = probe.rim
    return found


def ranges(prediction: Prediction) -> dict[str, str]:
    """Whether each criterion, by its key, is in its range and counts in the verdict: yes, or no with the reason."""
    excluded = ", ".join(fault.kind for fault in prediction.excluding)
    cast = {vote.estimate.key: vote for vote in votes(flattened(prediction.contact))}

    def said(key: str, why: str) -> str:
        vote = cast[key]
        if excluded or vote.outside or not vote.estimate.valid:
            return f"no: {excluded or (vote.outside if vote.estimate.valid else why)}"
        return f"yes, with smaller heights: {why}" if why else "yes"

    return {one.key: said(one.key, "; ".join(one.why)) for one in prediction.verdicts}


def remedy_options(fault: MapFault) -> str:
    """The remedy of a fault as options of the command; empty where there is none."""
    return " ".join(f"--{name} {value}" for name, value in fault.arguments.items())


def as_csv(rows: Sequence[Mapping[str, str | float | None]]) -> str:
    """Rows as comma-separated values with all digits; columns in the order of their first appearance."""
    columns = list(dict.fromkeys(name for one in rows for name in one))
    return Sheet.of("", columns, [[one.get(name) for name in columns] for one in rows]).csv()


def as_json(prediction: Prediction) -> str:
    """All numbers of the page, with the whole spectrum of each map."""
    verdict = judge(prediction)
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
        {"name": e.name, "symbol": e.symbol, "value": e.value, "unit": e.unit, "margin": e.margin,
         "source": e.source, "out_of_range": e.why}
        for e in prediction.estimates
    ]  # fmt: skip
    cuts = [
        {"wavelength_m": cut.wavelength, **cut.moments._asdict(), "margins": {e.name: e.margin for e in found}}
        for cut, found in prediction.cuts
    ]
    content = {
        "verdict": {"answer": verdict.answer, "probability": verdict.probability, "why": verdict.why},
        "row": row(prediction),
        "maps": maps,
        "moments": prediction.roughness.moments._asdict(),
        "interface": asdict(prediction.interface),
        "probe": None if prediction.probe is None else vars(prediction.probe),
        "estimates": estimates,
        "cuts": cuts,
        "warnings": prediction.doubts,
    }
    return json.dumps(_finite(content), indent=1, ensure_ascii=False) + "\n"


def _finite(value: Any) -> Any:
    """Replace numbers that JSON does not have."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(one) for name, one in value.items()}
    return [_finite(one) for one in value] if isinstance(value, list | tuple) else value
