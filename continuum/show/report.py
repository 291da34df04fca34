"""A prediction as tables, figures and one self-contained HTML page."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import continuum
from continuum import units
from continuum.measure.contact import contact_map
from continuum.model.surface import Moments
from continuum.show import plot
from continuum.sticky.criteria import Estimate
from continuum.sticky.predict import Prediction, turning_modulus, turning_work
from continuum.sticky.roughness import Cut, spectrum
from continuum.sticky.simulate import Simulation
from continuum.sticky.topography import Topography
from continuum.theory import paper as theory

__all__ = ["Sheet", "contact_figure", "overview", "sheets", "summary", "write"]


class Sheet(NamedTuple):
    """A table of text."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def _length(value: float) -> str:
    return units.show(value, "length", 3)


def _pressure(value: float) -> str:
    return units.show(value, "pressure", 3)


def _work(value: float) -> str:
    return units.show(value, "energy_per_area", 3)


def _answer(estimate: Estimate) -> str:
    if estimate.sticky and estimate.name == "necessary adhesion":
        return "not excluded"
    return "-" if estimate.sticky is None else "sticky" if estimate.sticky else "not sticky"


def summary(prediction: Prediction, simulation: Simulation | None = None) -> str:
    """The paper's verdict in one sentence, and the solver's if there is one."""
    paper, contact = prediction.paper, prediction.contact
    modulus, work = turning_modulus(paper, contact), turning_work(paper, contact)
    margin = paper.margin or 0.0
    factor = f"{max(margin, 1 / margin):.3g}" if margin else "any factor"
    text = f"{_answer(paper)} by the paper's criterion, by a factor of {factor} in w or E*"
    if modulus and work:
        text += f": the verdict turns at E* = {_pressure(modulus)}, or at w = {_work(work)}"
    text += "" if paper.valid else ", out of its range (see the warnings)"
    if simulation is None:
        return text
    solved = "sticky" if simulation.sticky else "not sticky"
    return (
        f"{text}.  Solved on the map: {solved}{'' if simulation.sticky == paper.sticky else ', which is not the same'}"
    )


def sheets(prediction: Prediction, simulation: Simulation | None = None) -> list[Sheet]:
    """Everything there is to say, as tables."""
    solved = [] if simulation is None else [_solved(prediction, simulation)]
    inputs = [_surfaces(prediction), _moments(prediction), _contact(prediction)]
    numbers = [_numbers(prediction), _cuts(prediction), *map(_density, prediction.topographies)]
    return [*inputs, _verdicts(prediction), *solved, *numbers]


def _surfaces(prediction: Prediction) -> Sheet:
    rows = []
    for topography, fit in zip(prediction.topographies, prediction.fits, strict=True):
        size, pixel = topography.lengths, topography.grid.spacing
        rows += [
            ("map", topography.source),
            ("size", f"{_length(size[0])} x {_length(size[1])}"),
            ("points", f"{topography.heights.shape[0]} x {topography.heights.shape[1]}"),
            ("pixel", f"{_length(pixel[0])} x {_length(pixel[1])}"),
            ("edges", "periodic" if topography.periodic else "not periodic"),
            ("done to it", "; ".join(topography.steps) or "nothing"),
            ("heights, SHA-256", topography.digest[:16]),
        ]
        if fit is None:
            rows.append(("self-affine fit", "none possible"))
            continue
        rows += [
            ("Hurst exponent", f"{fit.hurst:.2f} ± {fit.hurst_error:.2f} (of the fit)"),
            ("roll-off λ_L", "none seen" if fit.roll_off is None else _length(fit.roll_off)),
            ("cut-off λ_s", "none seen" if fit.cut_off is None else _length(fit.cut_off)),
            ("noise below", "none seen" if fit.floor is None else _length(fit.floor)),
        ]
    return Sheet("Surface", ("quantity", "value"), tuple(rows))


def _moments(prediction: Prediction) -> Sheet:
    roughness = prediction.roughness

    def row(name: str, of: Moments) -> tuple[str, ...]:
        radius = _length(theory.asperity_radius(of.rms_curvature))
        return name, _length(of.rms_height), f"{of.rms_slope:.4g}", f"{of.rms_curvature * 1e-6:.4g}", radius

    return Sheet(
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
    rows = [
        ("contact modulus E*", _pressure(contact.contact_modulus)),
        ("work of adhesion w", _work(contact.work_of_adhesion)),
        ("range Δr", _length(contact.range)),
        ("adhesion length l_a = w/E*", _length(contact.adhesion_length)),
    ]
    if contact.spacing is not None:
        rows.append(("spacing of the atoms a0", _length(contact.spacing)))
    rows += [("source", line) for line in prediction.interface.origin]
    return Sheet("Contact", ("quantity", "value"), tuple(rows))


def _verdicts(prediction: Prediction) -> Sheet:
    rows = []
    for estimate in prediction.verdicts:
        modulus = turning_modulus(estimate, prediction.contact) or 0.0
        work = turning_work(estimate, prediction.contact) or 0.0
        why = "yes" if estimate.valid else "no: " + "; ".join(estimate.why)
        rows.append(
            (
                estimate.name,
                f"{estimate.symbol} = {estimate.value:.4g}",
                _answer(estimate),
                f"{estimate.margin:.4g}",
                _pressure(modulus),
                _work(work),
                why,
            )
        )
    head = ("criterion", "parameter", "verdict", "margin", "sticky below E*", "sticky above w", "in its range")
    return Sheet("Is it sticky?  (margin: w over the w at which the verdict turns)", head, tuple(rows))


def _numbers(prediction: Prediction) -> Sheet:
    shown = {"": lambda value: f"{value:.4g}", "length": _length, "pressure": _pressure}
    rows = []
    for estimate in prediction.estimates:
        if estimate.margin is None:
            # The tail of a theory that finds no tension is not a push.
            value = max(estimate.value, 0.0) if estimate.name.startswith("pull-off") else estimate.value
            rows.append((estimate.name, estimate.symbol, shown[estimate.unit](value), estimate.source,
                         "yes" if estimate.valid else "no: " + "; ".join(estimate.why)))  # fmt: skip
    paper = "yes" if prediction.paper.valid else "no: see the paper's verdict"
    rows += [
        ("kappa", "κ", f"{prediction.kappa:.4g}", "paper, Eq. (eqrenkappa); negative: sticky", paper),
        (
            "load at 1 % repulsive area", "N/A0", _pressure(prediction.load),
            "paper, Eqs. (eqkappa), (eqrenkappa); negative: borne tension, which the pull-off force exceeds", paper,
        ),
    ]  # fmt: skip
    return Sheet("Numbers", ("quantity", "symbol", "value", "source", "in its range"), tuple(rows))


def _distinct(prediction: Prediction) -> list[int]:
    """Criteria whose margins differ: asperity theories share one."""
    margins = [estimate.margin for estimate in prediction.verdicts]
    return [i for i, margin in enumerate(margins) if margin not in margins[:i]]


def _cuts(prediction: Prediction) -> Sheet:
    cuts, chosen = prediction.cuts, _distinct(prediction)
    # Two per octave are enough to read; the figure has all.
    rows = tuple(
        (
            _length(cut.wavelength),
            f"{cut.moments.rms_slope:.4g}",
            f"{cut.moments.rms_curvature * 1e-6:.4g}",
            _length(theory.contact_diameter(cut.moments.rms_slope, cut.moments.rms_curvature)),
            *(f"{verdicts[i].margin:.3g}" for i in chosen),
        )
        for cut, verdicts in cuts[::2]
    )
    names = tuple(prediction.verdicts[i].name for i in chosen)
    head = ("smallest wavelength", "h'_rms", "h''_rms, 1/µm", "d_rep", *names)
    return Sheet("If only wavelengths above a cut-off counted: roughness, and margin of each criterion", head, rows)


def _density(topography: Topography) -> Sheet:
    q, c = spectrum(topography)
    chosen = np.unique(np.geomspace(1, q.size, 12).round().astype(int)) - 1
    rows = tuple((_length(2 * np.pi / q[i]), f"{q[i]:.4g}", f"{c[i]:.4g}") for i in chosen)
    head = ("wavelength", "q, 1/m", "C(q), m⁴")
    return Sheet(f"Power spectral density, radial average, h_rms² = ∫ C d²q: {topography.source}", head, rows)


def _solved(prediction: Prediction, simulation: Simulation) -> Sheet:
    ratio = prediction.number("area ratio").value
    area = f"{100 * simulation.area_rep:.3g} %" + (": jumped past 1 %" if simulation.jumped else "")
    rows = (
        ("verdict", _answer(prediction.paper), "sticky" if simulation.sticky else "not sticky"),
        ("repulsive area", "1 %", area),
        ("load per area N/A0", _pressure(prediction.load), _pressure(simulation.load)),
        ("κ", f"{prediction.kappa:.4g}", f"{simulation.kappa:.4g}"),
        ("A_rep/A_att", f"{ratio:.4g}", f"{simulation.area_ratio:.4g}"),
    )
    return Sheet("Solved on the map, on approach", ("quantity", "paper", "solver"), rows)


@plot.styled
def overview(prediction: Prediction) -> Figure:
    """Map, spectrum, and what depends on the smallest wavelength."""
    figure = plot.new_figure(8.4, 6.8)
    (image, density), (slopes, margins) = figure.subplots(2, 2)
    _draw_map(image, prediction)
    _draw_spectrum(density, prediction)
    cuts = [cut for cut, _ in prediction.cuts]
    _draw_moments(slopes, cuts)
    _draw_margins(margins, prediction)
    for axis in (image, density, slopes, margins):
        axis.title.set_fontsize(9)
    return figure


def _scale(value: float) -> tuple[float, str]:
    """Unit of length for an axis that reaches a value: its size and name."""
    name = units.show(value, "length").split()[1]
    return units.unit_size(name, "length"), name


def _draw_map(axis: Axes, prediction: Prediction) -> None:
    topography = prediction.topographies[0]
    (size, name), (height, height_name) = _scale(max(topography.lengths)), _scale(topography.heights.std())
    image = axis.imshow(
        topography.heights.T / height,
        origin="lower",
        extent=(0, topography.lengths[0] / size, 0, topography.lengths[1] / size),
        vmin=-3 * topography.heights.std() / height,
        vmax=3 * topography.heights.std() / height,
        cmap="cividis",
    )
    axis.figure.colorbar(image, ax=axis, label=f"height ({height_name})", shrink=0.8, aspect=15, pad=0.02)
    axis.set(xlabel=f"x ({name})", ylabel=f"y ({name})", title="map, ± 3 h_rms")
    axis.spines[:].set_visible(True)


def _draw_spectrum(axis: Axes, prediction: Prediction) -> None:
    for topography, fit, colour in zip(prediction.topographies, prediction.fits, plot.SERIES, strict=False):
        q, c = spectrum(topography)
        # Rounding errors are no spectrum.
        real = c > 1e-12 * c.max(initial=0)
        if not real.any():
            continue
        q, c = q[real], c[real]
        axis.loglog(q, c, color=colour, label=topography.source)
        if fit is None:
            continue
        ends = [2 * np.pi / (fit.roll_off or np.inf), 2 * np.pi / (fit.cut_off or fit.floor or np.nan)]
        low, high = max(ends[0], q[0]), q[-1] if np.isnan(ends[1]) else ends[1]
        inside = (q >= low) & (q <= high)
        slope = -2 - 2 * fit.hurst
        level = np.exp(np.mean(np.log(c[inside]) - slope * np.log(q[inside])))
        axis.loglog(
            [low, high], level * np.array([low, high]) ** slope, "k--", linewidth=1, label=f"H = {fit.hurst:.2f}"
        )
        for wavelength, name in ((fit.roll_off, "λ_L"), (fit.cut_off, "λ_s"), (fit.floor, "noise")):
            if wavelength is not None:
                axis.axvline(2 * np.pi / wavelength, color=colour, linestyle=":", linewidth=0.8)
                axis.annotate(
                    name, (2 * np.pi / wavelength, 1), xycoords=("data", "axes fraction"), va="top", fontsize=8
                )
    axis.set(xlabel="wavenumber q (1/m)", ylabel="C(q) (m⁴)", title="power spectral density")
    if axis.lines:
        axis.legend(loc="lower left", fontsize=7)


def _draw_moments(axis: Axes, cuts: Sequence[Cut]) -> None:
    size, name = _scale(cuts[len(cuts) // 2].wavelength)
    x = np.array([cut.wavelength for cut in cuts]) / size
    axis.loglog(x, [cut.moments.rms_slope for cut in cuts], "o-", color=plot.SERIES[0], markersize=3)
    axis.set(xlabel=f"smallest wavelength counted ({name})", title="slope and curvature, by resolution")
    axis.set_ylabel("rms slope $h'_{rms}$", color=plot.SERIES[0])
    other = axis.twinx()
    other.loglog(x, [cut.moments.rms_curvature * 1e-6 for cut in cuts], "s-", color=plot.SERIES[5], markersize=3)
    other.set_ylabel("rms curvature $h''_{rms}$ (1/µm)", color=plot.SERIES[5])
    other.spines["right"].set_visible(True)


def _draw_margins(axis: Axes, prediction: Prediction) -> None:
    size, name = _scale(prediction.cuts[len(prediction.cuts) // 2][0].wavelength)
    x = [cut.wavelength / size for cut, _ in prediction.cuts]
    styles = ("o-", "s--", "^:", "v-.", "D--", "x:")
    for i in _distinct(prediction):
        y = [found[i].margin or np.nan for _, found in prediction.cuts]
        axis.loglog(x, y, styles[i], color=plot.SERIES[i], markersize=3, label=prediction.verdicts[i].name)
    axis.axhline(1, color="black", linewidth=0.8)
    axis.annotate("sticky above", (0.01, 1), xycoords=("axes fraction", "data"), va="bottom", fontsize=7)
    axis.set(
        xlabel=f"smallest wavelength counted ({name})",
        ylabel="margin: w / w at the turn",
        title="verdicts, by resolution",
    )
    axis.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2)


@plot.styled
def contact_figure(simulation: Simulation) -> Figure:
    """Where the solved contact repels and attracts."""
    figure = plot.new_figure(4.2, 4.2)
    axis = figure.subplots()
    unit, name = _scale(max(simulation.lengths))
    period = (simulation.lengths[0] / unit, simulation.lengths[1] / unit)
    nx, ny = simulation.shape
    plot.contact_image(axis, contact_map(simulation.wall, simulation.gap[:nx, :ny]), period)
    axis.set(xlabel=f"x ({name})", ylabel=f"y ({name})")
    axis.set_title(f"repulsive (orange) and attracted (black), A_rep/A0 = {simulation.area_rep:.3g}", fontsize=8)
    return figure


_PAGE = Template("""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>$title</title><style>
body { font: 15px/1.45 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; margin: 0.4rem 0 1.4rem; font-size: 13px; }
th, td { text-align: left; vertical-align: top; padding: 0.2rem 0.7rem 0.2rem 0; border-bottom: 1px solid #ddd; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.05rem; margin: 1.2rem 0 0; } img { max-width: 100%; }
.verdict { font-size: 1.1rem; padding: 0.6rem 0.9rem; background: #eef3f7; }
footer { color: #666; font-size: 12px; }
</style></head><body>
<h1>$title</h1>
<p class="verdict">$verdict</p>
$warnings
$figures
$tables
<footer>stickiness $version. Criteria and numbers: L. Pastewka and M. O. Robbins, PNAS 111, 3298 (2014), and the sources
in the tables. Margins compare one theory with itself: they say nothing of what is wrong with it.</footer>
</body></html>
""")


def write(prediction: Prediction, folder: Path, name: str, simulation: Simulation | None = None) -> list[Path]:
    """Write ``NAME.html``, which needs no other file, and its figures as PNG and PDF; returns HTML and PNG files."""
    figures = {name: overview(prediction)}
    if simulation is not None:
        figures[f"{name}-contact"] = contact_figure(simulation)
    pictures = [plot.save(figure, folder / stem) for stem, figure in figures.items()]
    images = "\n".join(
        f'<p><img alt="{html.escape(path.stem)}" src="data:image/png;base64,'
        f'{base64.b64encode(path.read_bytes()).decode()}"></p>'
        for path in pictures
    )
    doubts = [*prediction.warnings, *(simulation.warnings if simulation else ())]
    warnings = "".join(f"<li>{html.escape(text)}</li>" for text in doubts)
    tables = sheets(prediction, simulation)
    # A terminal ends, a page begins with what was asked.
    page = _PAGE.substitute(
        title=html.escape("Is it sticky?  " + " and ".join(t.source for t in prediction.topographies)),
        verdict=html.escape(_sentence(summary(prediction, simulation))),
        warnings=f"<h2>Warnings</h2><ul>{warnings}</ul>" if warnings else "",
        figures=images,
        tables="\n".join(_html_table(sheet) for sheet in [*tables[3:], *tables[:3]]),
        version=html.escape(continuum.__version__),
    )
    path = folder / f"{name}.html"
    path.write_text(page, encoding="utf-8")
    return [path, *pictures]


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:] + "."


def _html_table(sheet: Sheet) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in sheet.head)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in sheet.rows)
    return f"<h2>{html.escape(sheet.title)}</h2><table><tr>{head}</tr>{body}</table>"
