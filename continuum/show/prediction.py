"""The answer of a prediction in a sentence, in sheets, and on a page."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from continuum.model.surface import Moments
from continuum.show import plot
from continuum.show.answer import force, length, per_area, percent, pressure, statements
from continuum.show.page import Page
from continuum.show.prediction_data import ranges
from continuum.show.prediction_figures import contact_figure, fault_figure, overview
from continuum.show.sheet import Entry, Sheet, pairs
from continuum.sticky.criteria import ANSWERS, CRITERIA
from continuum.sticky.prediction import Prediction
from continuum.sticky.probe import ProbePullOff
from continuum.sticky.verdict import votes
from continuum.theory import paper
from continuum.topography.map import Topography
from continuum.topography.roughness import spectrum


def prediction_sentence(prediction: Prediction) -> str:
    """The statements of :func:`continuum.show.answer.statements` in one text."""
    return ".  ".join(statements(prediction))


def reading_order(sheets: list[Sheet]) -> list[Sheet]:
    """Sheets of a prediction in the order verdicts, solution, numbers, and then their ingredients."""
    return [*sheets[3:], *sheets[:3]]


def prediction_sheets(prediction: Prediction) -> list[Sheet]:
    """All results as tables."""
    solved = [] if prediction.solved_answer is None else [_solved(prediction)]
    probe = [] if prediction.probe is None else [_probe(prediction.probe)]
    inputs = [_surfaces(prediction), _moments(prediction), _contact(prediction)]
    numbers = [_numbers(prediction), _cuts(prediction), *map(_density, prediction.topographies)]
    return [*inputs, _verdicts(prediction), *solved, *probe, *numbers]


def _surfaces(prediction: Prediction) -> Sheet:
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
            ("skewness and kurtosis of heights", f"{upper.skewness:.2g} and {upper.kurtosis:.3g} (Gaussian: 0 and 3)"),
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
    rows.append(("waves not measured", _unmeasured(prediction)))
    return pairs("Surface", rows)


def _unmeasured(prediction: Prediction) -> str:
    waves = prediction.continuation
    if waves is None:
        return "none are missing, or no power law is known that continues what was measured"
    exponents = " and ".join(f"{hurst:.2g}" for hurst in waves.hursts)
    contact = waves.contact(prediction.contact)
    return (
        f"below {length(waves.measured)}; continued with H = {exponents} to {length(waves.smallest)}: rms slope "
        f"{contact.rms_slope:.3g}, rms curvature {contact.rms_curvature * 1e-6:.3g} 1/µm"
    )


def _moments(prediction: Prediction) -> Sheet:
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


def _contact(prediction: Prediction) -> Sheet:
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


def _verdicts(prediction: Prediction) -> Sheet:
    rows, inside = [], ranges(prediction)
    for vote in votes(prediction.contact):
        estimate, support = vote.estimate, vote.support
        necessary = "not excluded" if estimate.sticky else "excluded"
        modulus = estimate.turning_modulus(prediction.contact) or 0.0
        work = estimate.turning_work(prediction.contact) or 0.0
        record = "no record: a necessary condition"
        if support is not None:
            record = f"{percent(support.probability)} sticky, of {support.count} similar surfaces"
        elif vote.outside:
            record = "none of such surfaces"
        rows.append(
            (
                estimate.name,
                f"{estimate.symbol} = {estimate.value:.4g}",
                "-" if prediction.excluding or vote.outside else necessary if support is None else vote.answer,
                f"{estimate.margin:.4g}",
                record,
                pressure(modulus),
                per_area(work),
                inside[estimate.key],
            )
        )
    head = (
        "criterion", "parameter", "verdict", "margin", "its record at this margin", "turns at E*", "turns at w",
        "in its range",
    )  # fmt: skip
    return Sheet.of(
        "Is it sticky?  (margin: w over w at the turn of the theory; record: share of sticky surfaces at that margin)",
        head,
        tuple(rows),
    )


def _numbers(prediction: Prediction) -> Sheet:
    shown: dict[str, Callable[[float], str]] = {"": "{:.4g}".format, "length": length, "pressure": pressure}
    rows = []
    for estimate in prediction.estimates:
        if estimate.margin is None:
            value = max(estimate.value, CRITERIA[estimate.key].least)
            rows.append((estimate.name, estimate.symbol, shown[estimate.unit](value), estimate.source,
                         "yes" if estimate.valid else "no: " + "; ".join(estimate.why)))  # fmt: skip
    paper = "yes" if prediction.paper.valid else "no: see the paper's verdict"
    rows += [
        ("kappa", "κ", f"{prediction.kappa:.4g}", "paper, Eq. (3); negative: sticky", paper),
        (
            "load at 1 % repulsive area", "N/A0", pressure(prediction.load),
            "paper, Eqs. (1), (3); negative: borne tension, which the pull-off force exceeds", paper,
        ),
    ]  # fmt: skip
    return Sheet.of("Numbers", ("quantity", "symbol", "value", "source", "in its range"), tuple(rows))


def _cuts(prediction: Prediction) -> Sheet:
    cuts, chosen = prediction.cuts, prediction.distinct
    # Two per octave suffice for a table; the figure has all.
    rows = tuple(
        (
            length(cut.wavelength),
            f"{cut.moments.rms_slope:.4g}",
            f"{cut.moments.rms_curvature * 1e-6:.4g}",
            length(paper.contact_diameter(cut.moments.rms_slope, cut.moments.rms_curvature)),
            *(f"{verdicts[i].margin:.3g}" for i in chosen),
        )
        for cut, verdicts in cuts[::2]
    )
    names = tuple(prediction.verdicts[i].name for i in chosen)
    head = ("smallest wavelength", "h'_rms", "h''_rms, 1/µm", "d_rep", *names)
    return Sheet.of("If only wavelengths above a cut-off counted: roughness, and margin of each criterion", head, rows)


def _density(topography: Topography) -> Sheet:
    q, c = spectrum(topography)
    chosen = np.unique(np.geomspace(1, q.size, 12).round().astype(int)) - 1
    rows = tuple((length(2 * np.pi / q[i]), f"{q[i]:.4g}", f"{c[i]:.4g}") for i in chosen)
    head = ("wavelength", "q, 1/m", "C(q), m⁴")
    return Sheet.of(f"Power spectral density, radial average, h_rms² = ∫ C d²q: {topography.source}", head, rows)


def _solved(prediction: Prediction) -> Sheet:
    """The solved turn and state at the given work of adhesion, compared with the paper."""
    rows: list[tuple[str, str, str]] = []
    turn, simulation, contact = prediction.turn, prediction.simulation, prediction.contact
    if (measured := prediction.measured_turn) is not None:
        by_paper = prediction.paper.turning_work(contact) or 0.0
        rows.append(("w at the turn of the map as measured", per_area(by_paper), per_area(measured.work)))
    if turn is not None:
        solved = prediction.mended or prediction
        by_paper = solved.paper.turning_work(solved.contact) or 0.0
        most = "" if turn.most == turn.work else f", with the range given up to {per_area(turn.most)}"
        rows += [
            ("w at the turn", per_area(by_paper), per_area(turn.work) + most),
            ("bracket of the turn", "-", f"{per_area(turn.low)} to {per_area(turn.high)}"),
            ("range of attraction", length(contact.range), length(turn.range)),
            ("attracted area at the turn", "-", f"{100 * turn.area_att:.3g} %"),
        ]
    if simulation is not None:
        ratio = prediction.number("area-ratio").value
        said = {vote.estimate.key: vote.answer for vote in votes(contact)}
        by_record = "-" if prediction.excluding else said[prediction.paper.key]
        area = f"{100 * simulation.area_rep:.3g} %" + (": jumped past 1 %" if simulation.jumped else "")
        rows += [
            ("verdict at the given w", by_record, ANSWERS[simulation.sticky]),
            ("repulsive area", "1 %", area),
            ("load per area N/A0", pressure(prediction.load), pressure(simulation.load)),
            ("κ", f"{prediction.kappa:.4g}", f"{simulation.kappa:.4g}"),
            ("A_rep/A_att", f"{ratio:.4g}", f"{simulation.area_ratio:.4g}"),
        ]
    return Sheet.of("Solved on the map, on approach", ("quantity", "paper", "solver"), tuple(rows))


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
    if probe.rim is not None:
        rows.append(("largest with at most 1 % in contact, 2π R w (A_rep + A_att)/A0", force(probe.rim)))
    return pairs("Pull-off force of the probe", rows)


def write_prediction(prediction: Prediction, folder: Path, name: str) -> list[Path]:
    """Write ``NAME.html``, which needs no other file, and its figures as PNG and PDF; returns HTML and PNG files."""
    figures = {name: (overview(prediction), "Map, spectrum, and what depends on the smallest wavelength counted.")}
    at = " at its turn" if prediction.simulation is None else ""
    if (solved := prediction.simulation or prediction.turn) is not None:
        figures[f"{name}-contact"] = (contact_figure(solved), f"The contact, solved on the map{at}.")
    if prediction.faults:
        figures[f"{name}-faults"] = (fault_figure(prediction), "Faults of the map.")
    drawn = [(plot.save_figure(figure, folder / stem), caption) for stem, (figure, caption) in figures.items()]
    sheets = prediction_sheets(prediction)
    page = Page(
        "Is it sticky?  " + " and ".join(t.source for t in prediction.topographies),
        prediction_sentence(prediction) + ".",
        prediction.doubts,
        drawn,
        reading_order(sheets),
        sources="Criteria and numbers: L. Pastewka and M. O. Robbins, PNAS 111, 3298 (2014), and the sources in the "
        "tables.  Margins are those of each theory, and do not include its errors.",
    )
    return [page.write(folder / f"{name}.html"), *(path for path, _ in drawn)]
