"""All results of a prediction as sheets; the ranking of a study in a sentence and as sheets."""

from collections.abc import Callable

import numpy as np

from continuum.maps.map import Topography
from continuum.maps.roughness import spectrum
from continuum.maps.verdict.adhesion import ProbePullOff
from continuum.maps.verdict.prediction import PredictionNumbers
from continuum.maps.verdict.study import SampleRank, StudyNumbers
from continuum.maps.verdict.threshold import MapThreshold
from continuum.model.surface import Moments
from continuum.show.answer import HOW, force, length, per_area, per_cent, pressure
from continuum.show.prediction_data import areal, load_works
from continuum.store.sheet import Column, Entry, Sheet, pairs
from continuum.theory import paper

_ROWS = 12
"""Rows of the table of a curve."""
_NOTE = (
    "Column w/w_c: geometric mean over the spots of a sample; above 1 it is sticky.  Lower and upper end: its 95 % "
    "interval, by Student with the scatter of spots pooled over all samples, or by the sampling error of a single "
    "spot.  Verdict: of this interval, widened by the error of w_c.  Rank: the places that the intervals leave open."
)


def reading_order(sheets: list[Sheet]) -> list[Sheet]:
    """Sheets of a prediction in the order threshold, theories, numbers, and then their ingredients."""
    return [*sheets[3:], *sheets[:3]]


def prediction_sheets(prediction: PredictionNumbers) -> list[Sheet]:
    """All results as tables."""
    inputs = [_surfaces(prediction), _moments(prediction), _contact(prediction)]
    found = [] if prediction.threshold is None else _threshold(prediction, prediction.threshold)
    found += _adhesion(prediction)
    probe = [] if prediction.probe is None else [_probe(prediction.probe)]
    numbers = [_theories(prediction), *map(_density, prediction.topographies)]
    return [*inputs, *found, *probe, *numbers]


def _threshold(prediction: PredictionNumbers, found: MapThreshold) -> list[Sheet]:
    """The threshold with what it was found from, and against the range of attraction."""
    work, measured = prediction.contact.work_of_adhesion, prediction.threshold_as_measured
    factor, why = prediction.verdict.factor, prediction.verdict.why
    rows: list[tuple[str, Entry]] = [
        ("answer", f"{prediction.verdict.answer}{f': {why}' if why else ''}"),
        ("work of adhesion w", per_area(work)),
        ("threshold w_c, the critical work of adhesion", per_area(found.work)),
        ("not sticky below, sticky above", f"{per_area(found.low)} and {per_area(found.high)}"),
        ("w/w_c", "-" if factor is None else f"{factor:.4g}"),
        ("found", HOW[found.source]),
        *(("its interval is wide", text) for text in found.why),
    ]
    if measured is not None:
        rows.append(("w_c of the map as measured", per_area(measured.work)))
    if np.isfinite(found.dmt):
        rows += [
            ("w_DMT, where adhesion deforms nothing", per_area(found.dmt)),
            ("χ, by which deformation raises it", f"{found.chi:.3g}"),
            ("Müser's number", f"{found.muller:.3g}"),
        ]
    if found.patches:
        rows += [
            ("patches in contact", found.patches),
            ("area in contact, attracted", f"{100 * found.area_rep:.3g} % and {100 * found.area_att:.3g} %"),
        ]
    columns = ("range", "w_c, mJ/m²", "low", "high")
    cells = [(length(one.range), *(Column("").text(1e3 * x) for x in one[1:4])) for one in found.curve]
    curve = [Sheet.of("Threshold against the range of attraction", columns, cells)] if cells else []
    return [pairs("Threshold", rows), *curve]


def _adhesion(prediction: PredictionNumbers) -> list[Sheet]:
    """Numbers of the adhesion curve, and the curve."""
    said, found = prediction.adhesion, prediction.threshold
    curve = None if found is None else found.adhesion
    if said is None or found is None or curve is None:
        return []
    points = {"largest tension on approach": said.pull_off, "without load": said.unloaded, "at the load": said.loaded,
              "at the load, without adhesion": said.alone}  # fmt: skip
    rows = [
        (name, pressure(one.pressure), per_cent(one.area), length(one.gap), one.doubt or "-")
        for name, one in points.items()
        if one is not None
    ]
    works = load_works(prediction, found)
    areas = curve.pressures(0.0)[0]
    chosen = np.unique(np.linspace(0, areas.size - 1, _ROWS).astype(int))
    loads = {name: curve.pressures(works[name])[1] for name in ("w", "w_c", "none")}
    gaps = curve.gaps(works["w"])
    cells = [(per_cent(areas[i]), *(pressure(each[i]) for each in loads.values()), length(gaps[i])) for i in chosen]
    head = ("area", "pressure with w", "with w_c", "without adhesion", "mean gap with w")
    return [
        Sheet.of("Contact under adhesion, on approach", ("state", "mean pressure", "area", "mean gap", "doubt"), rows),
        Sheet.of("Load against area", head, cells),
    ]


def _surfaces(prediction: PredictionNumbers) -> Sheet:
    rows: list[tuple[str, Entry]] = []
    maps = zip(prediction.topographies, prediction.fits, prediction.findings, strict=True)
    for topography, fit, found in maps:
        size, pixel = topography.lengths, topography.grid.spacing
        rows += [
            ("map", topography.source),
            ("size", f"{length(size[0])} x {length(size[1])}"),
            ("points", f"{topography.heights.shape[0]} x {topography.heights.shape[1]}"),
            ("pixel", f"{length(pixel[0])} x {length(pixel[1])}"),
            ("edges", "periodic" if topography.periodic else "not periodic"),
            ("done to it", "; ".join(topography.steps) or "nothing"),
            ("heights, SHA-256", topography.digest[:16]),
        ]
        rows += [("fault", f"{fault.kind}: {fault.text}") for fault in found.faults] or [("fault", "none found")]
        by, upper = found.directions, found.summits.value
        rows += [
            ("rms slope along x, y", " and ".join(f"{slope:.3g}" for slope in by.slopes)),
            ("rms curvature along x, y", " and ".join(f"{c * 1e-6:.3g}" for c in by.curvatures) + " 1/µm"),
            ("anisotropy of slopes", f"{by.anisotropy:.2f}, largest at {by.angle:.0f}° from x"),
            (
                "slope, curvature of the upper tenth over those of the lower",
                f"{upper.slope:.2g} and {upper.curvature:.2g} (Gaussian: 1)",
            ),
        ]
        if fit is None:
            rows.append(("self-affine fit", "none possible"))
            continue
        rows += [
            ("Hurst exponent", f"{fit.hurst:.2f} ± {fit.hurst_error:.2f} (of the fit)"),
            ("roll-off λ_L", "none seen" if fit.roll_off is None else length(fit.roll_off)),
            ("cut-off λ_s", "none seen" if fit.cut_off is None else length(fit.cut_off)),
            ("noise at wavelengths below", "none seen" if fit.floor is None else length(fit.floor)),
        ]
    rows += [
        (name.removesuffix("_m"), length(x) if name.endswith("_m") else x) for name, x in areal(prediction).items()
    ]
    rows.append(("waves not measured", _unmeasured(prediction)))
    return pairs("Surface", rows)


def _unmeasured(prediction: PredictionNumbers) -> str:
    waves = prediction.continuation
    if waves is None:
        return "none are missing, or no power law is known that continues what was measured"
    exponents = " and ".join(f"{hurst:.2g}" for hurst in waves.hursts)
    contact = waves.contact(prediction.contact)
    return (
        f"below {length(waves.measured)}; continued with H = {exponents} to {length(waves.smallest)}: rms slope "
        f"{contact.rms_slope:.3g}, rms curvature {contact.rms_curvature * 1e-6:.3g} 1/µm"
    )


def _moments(prediction: PredictionNumbers) -> Sheet:
    roughness = prediction.roughness

    def row(name: str, of: Moments) -> tuple[str, ...]:
        radius = length(paper.asperity_radius(of.rms_curvature))
        return name, length(of.rms_height), f"{of.rms_slope:.4g}", f"{of.rms_curvature * 1e-6:.4g}", radius

    return Sheet.of(
        "Roughness",
        ("moments", "h_rms", "h'_rms", "h''_rms = sqrt<(laplacian h)²>, 1/µm", "R = 2/h''_rms"),
        (
            row("used", roughness.moments),
            row("from the spectrum", roughness.spectral),
            row("from neighbouring points", roughness.stencil),
        ),
    )


def _contact(prediction: PredictionNumbers) -> Sheet:
    contact = prediction.contact
    rows: list[tuple[str, Entry]] = [
        ("contact modulus E*", pressure(contact.contact_modulus)),
        ("work of adhesion w", per_area(contact.work_of_adhesion)),
        ("range Δr", length(contact.range)),
        ("adhesion length l_a = w/E*", length(contact.adhesion_length)),
    ]
    if contact.spacing is not None:
        rows.append(("spacing of the atoms a0", length(contact.spacing)))
    rows += [("source", line) for line in prediction.interface.origin]
    return pairs("Contact", rows)


def _theories(prediction: PredictionNumbers) -> Sheet:
    shown: dict[str, Callable[[float], str]] = {"": "{:.4g}".format, "length": length, "pressure": pressure}
    rows = []
    for one in prediction.estimates:
        work, valid = one.threshold_work(prediction.contact), "yes" if one.valid else "no: " + "; ".join(one.why)
        named = one.name, f"{one.symbol} = {shown[one.unit](one.value)}", "-" if work is None else per_area(work)
        rows.append((*named, one.margin, valid, one.source))
    head = ("theory or number", "parameter", "its w_c", Column("w over it", "", ".3g"), "in its range", "source")
    return Sheet.of("Theories, for comparison: they take no part in the answer", head, rows)


def _density(topography: Topography) -> Sheet:
    q, c = spectrum(topography)
    chosen = np.unique(np.geomspace(1, q.size, 12).round().astype(int)) - 1
    rows = tuple((length(2 * np.pi / q[i]), f"{q[i]:.4g}", f"{c[i]:.4g}") for i in chosen)
    head = ("wavelength", "q, 1/m", "C(q), m⁴")
    return Sheet.of(f"Power spectral density, radial average, h_rms² = ∫ C d²q: {topography.source}", head, rows)


def _probe(probe: ProbePullOff) -> Sheet:
    rows: list[tuple[str, Entry]] = [
        ("radius R", length(probe.radius)),
        ("a smooth sphere: pull-off force, (3/2) to 2 π w R by Maugis", force(probe.smooth)),
        ("a smooth sphere: contact radius without load, (9π w R²/(2 E*))^(1/3)", length(probe.contact_radius)),
        ("Maugis' parameter λ: JKR above 5, DMT below 0.1", f"{probe.maugis:.3g}"),
        ("Tabor's parameter μ", f"{probe.tabor:.3g}"),
        (
            "apparent work of adhesion w - U",
            "none: U exceeds w" if probe.apparent is None else per_area(probe.apparent),
        ),
        ("pull-off force with w - U", "-" if probe.least is None else force(probe.least)),
        ("pull-off force with w, over Δr + h_rms", force(probe.most)),
    ]
    if probe.by_curve is not None:
        rows.append(("pull-off force by the adhesion curve", force(probe.by_curve)))
    if probe.rim is not None:
        rows.append(("largest with at most 1 % in contact, 2π R w (A_rep + A_att)/A0", force(probe.rim)))
    return pairs("Pull-off force of the probe", rows)


def study_sentence(study: StudyNumbers) -> str:
    """The answer in one text."""
    first = [one for one in study.samples if one.margin is not None]
    if not first:
        return "No ranking: the threshold of no spot is known"
    top = [one.name for one in first if one.ranks is not None and one.ranks[0] == 1]
    if len(first) == 1:
        return f"{first[0].name}: {first[0].answer} (its spots: {first[0].counts})"
    if len(top) == 1:
        return f"{top[0]} is the stickiest of {len(study.samples)} samples (its spots: {first[0].counts})"
    alone = all(one.interval is None for one in first)
    why = "no spot was measured beside another" if alone else "their intervals overlap"
    return f"{', '.join(top[:-1])} and {top[-1]} cannot be told apart as the stickiest: {why}"


def study_doubts(study: StudyNumbers) -> list[str]:
    """Warnings about a ranking."""
    doubts = [f"{spot.sample}, spot {spot.name}: left out: {spot.error}" for spot in study.unusable]
    nothing = [spot for spot in study.spots if spot.found is not None and spot.margin is None]
    doubts += [f"{spot.sample}, spot {spot.name}: undecided, and in no mean" for spot in nothing]
    if all(one.interval is None for one in study.samples):
        doubts.append("one spot of each sample: how spots scatter is not known, and no sample is told from another")
    return doubts


def ranking_row(sample: SampleRank) -> dict[str, str | float | None]:
    """One row of the ranking."""
    low, high = sample.interval or (None, None)
    return {
        "rank": "-" if sample.ranks is None else " to ".join(dict.fromkeys(map(str, sample.ranks))),
        "sample": sample.name,
        "verdict": sample.answer,
        "spots": sample.counts,
        "w/w_c": sample.margin,
        "lower end": low,
        "upper end": high,
    }


def study_sheets(study: StudyNumbers) -> list[Sheet]:
    """The ranking, and its spots."""
    rows = [tuple(ranking_row(sample).values()) for sample in study.samples]
    ranking = Sheet.of("Ranking of the samples", tuple(ranking_row(study.samples[0])), rows, _NOTE)
    cells: list[tuple[Entry, ...]] = [
        (spot.sample, spot.name, ", ".join(spot.files), spot.answer or f"not usable: {spot.error}", spot.margin)
        for spot in study.spots
    ]
    return [ranking, Sheet.of("Spots", ("sample", "spot", "files", "verdict", "w/w_c"), cells)]
