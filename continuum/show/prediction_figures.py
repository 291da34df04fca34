"""Pages of predictions and studies with their figures: map and contact, spectrum, threshold, what decides it, faults.

What draws is imported after the answer has been printed.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from continuum.inputs import units
from continuum.maps.faults import Findings
from continuum.maps.map import Topography
from continuum.maps.roughness import spectrum
from continuum.maps.scanlines import line_offsets
from continuum.maps.spectra import profile_spectrum
from continuum.maps.verdict.prediction import PredictionNumbers
from continuum.maps.verdict.study import StudyNumbers
from continuum.maps.verdict.threshold import MapThreshold, RangePoint
from continuum.model.fourier import Real
from continuum.show import plot
from continuum.show.answer import COLOURS, statements, verdict_axis
from continuum.show.page import Page
from continuum.show.prediction import (
    prediction_sheets,
    ranking_row,
    reading_order,
    study_doubts,
    study_sentence,
    study_sheets,
)
from continuum.show.prediction_data import as_csv, load_works, row
from continuum.store import output
from continuum.store.sheet import Sheet

_LINES: dict[str, Any] = {r"$\lambda_L$": ":", r"$\lambda_s$": "-.", "noise": (0, (1, 4))}
"""Lines at the ends of the fit in a spectrum."""
_DECADES = 3.0
"""Decades of a derivative that are told apart."""
_SEEN = 3.0
"""Contact area, in per cent, up to which the curve without adhesion is shown at least."""
_HALF = 0.46
"""Part of the width of the figure that the legend of one of two panels may take."""


@plot.styled
def overview(prediction: PredictionNumbers) -> Figure:
    """The map with its contact at the threshold, its spectrum, the threshold by range, and where it is decided.

    Without a state, as of a line scan, the last panel is empty.
    """
    figure, places = plot.four_panels()
    (image, density), (curve, decided) = places
    corrected, threshold = prediction.mended or prediction, prediction.threshold
    whole = corrected.topographies[0] if corrected.no_map else corrected.facing
    unit = _draw_map(image, whole, "gray" if threshold is not None and threshold.curve else "cividis")
    _draw_spectrum(density, prediction)
    titles = ["map", "power spectral density", "threshold by range"]
    panels = [image, density, curve]
    if threshold is None:
        curve.remove()
        panels.pop()
    else:
        _draw_curve(curve, prediction, threshold)
    if threshold is None or not threshold.curve:
        decided.remove()
    else:
        titles[0] = "map and its contact at the threshold"
        _draw_contact(image, threshold, unit)
        titles.append(_draw_deciding(decided, threshold))
        panels.append(decided)
    plot.letter_panels(panels, titles)
    plot.log_ticks(*(axis for axis in figure.axes if axis is not decided))
    for axis in panels[:3]:
        if plot.labelled(axis):
            plot.legend_under(axis, _HALF)
    plot.place_panels(figure, places)
    return figure


def length_scale(value: float) -> tuple[float, str]:
    """Unit of length for an axis that reaches a value: its size and name."""
    return _unit(value, "length")


def _unit(value: float, quantity: units.Quantity) -> tuple[float, str]:
    """Unit for an axis that reaches a value: its size and name."""
    name = units.readable(value, quantity).split()[1]
    return units.unit_size(name, quantity), name


def _draw_values(
    axis: Axes, lengths: tuple[float, float], values: Real, colours: str, ends: Any, label: str = ""
) -> float:
    """Values on the points of a map, with a bar of their colours if they have a label; the unit of its axes, in m."""
    size, name = length_scale(max(lengths))
    image = plot.map_image(axis, values, [length / size for length in lengths], colours, ends)
    if label:
        # Inside the axes' own frame, so that it stays beside a map of any shape.
        axis.figure.colorbar(image, cax=axis.inset_axes((1.03, 0, 0.04, 1)), label=label)
    axis.set(xlabel=f"x ({name})", ylabel=f"y ({name})")
    return size


def _draw_map(axis: Axes, topography: Topography, colours: str = "cividis") -> float:
    most = 3 * topography.heights.std()
    # Heights below a nanometre are also given in nanometres.
    unit, name = length_scale(max(most, 1e-9))
    ends = (-most / unit, most / unit)
    return _draw_values(axis, topography.lengths, topography.heights / unit, colours, ends, f"height ({name})")


def _draw_spectrum(axis: Axes, prediction: PredictionNumbers) -> None:
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
            [low, high], level * np.array([low, high]) ** slope, "k--", linewidth=1, label=f"$H = {fit.hurst:.2f}$"
        )
        for wavelength, (name, line) in zip((fit.roll_off, fit.cut_off, fit.floor), _LINES.items(), strict=True):
            if wavelength is not None:
                axis.axvline(2 * np.pi / wavelength, color=colour, linestyle=line, linewidth=0.8, label=name)
    axis.set(xlabel="wavenumber $q$ (1/m)", ylabel="$C(q)$ (m⁴)")


def _draw_contact(axis: Axes, threshold: MapThreshold, unit: float) -> None:
    """Map of the repulsive and of the attracted area; its axes have a unit, in m."""
    x, y = threshold.map.lengths
    plot.contact_image(axis, np.where(threshold.kinds > 0, threshold.kinds, np.nan), (x / unit, y / unit))
    for entry in plot.contact_key():
        axis.plot([], [], "s", color=entry.get_facecolor(), label=entry.get_label())


def _draw_curve(axis: Axes, prediction: PredictionNumbers, threshold: MapThreshold) -> None:
    """The threshold with its interval, and the work of adhesion and range of the contact."""
    points = threshold.curve or (RangePoint(threshold.range, threshold.work, threshold.low, threshold.high),)
    ranges, work, low, high = np.array([one[:4] for one in points]).T
    contact = prediction.contact
    # An interval without an end goes beyond the panel.
    seen = [*work[np.isfinite(work)], contact.work_of_adhesion]
    least, most = 1e3 * min(seen) / 2, 1e3 * max(seen) * 2
    low, high = (np.clip(1e3 * ends, least, most) for ends in (low, high))
    if len(points) > 1:
        axis.fill_between(1e9 * ranges, low, high, color=plot.SERIES[0], alpha=0.25, linewidth=0, label="undecided")
    else:
        axis.vlines(1e9 * ranges, low, high, color=plot.SERIES[0], alpha=0.5, linewidth=5, label="undecided")
    style = "-" if len(points) > 1 else "o"
    axis.loglog(1e9 * ranges, 1e3 * work, style, color=plot.SERIES[0], label="threshold $w_c$")
    here = f"this contact: {prediction.verdict.answer}"
    axis.loglog(
        1e9 * contact.range, 1e3 * contact.work_of_adhesion, "*", color=plot.SERIES[5], markersize=9, label=here
    )
    axis.set(xlabel="range of the attraction (nm)", ylabel="work of adhesion (mJ/m²)", ylim=(least, most))


@plot.styled
def load_figure(prediction: PredictionNumbers) -> Figure | None:
    """Mean pressure against the contact area: with w and the error of w_c, at the threshold, and without adhesion.

    None where there are bounds only.
    """
    found, said = prediction.threshold, prediction.adhesion
    curve = None if found is None else found.adhesion
    if found is None or said is None or curve is None:
        return None
    works = load_works(prediction, found)
    areas = 100 * curve.pressures(0.0)[0]
    loads = {name: curve.pressures(work)[1] for name, work in works.items()}
    given = 0.0 if prediction.pressure is None else prediction.pressure
    # The whole of the tension, and about as much of the pressure; a given one is seen.
    most = max(1.5 * given, -2 * said.pull_off.pressure, float(loads["none"][areas <= _SEEN][-1]))
    unit, name = _unit(most, "pressure")
    figure, axis = plot.new_axes(plot.COLUMN, 0.8 * plot.COLUMN)
    axis.fill_between(
        areas, loads["w low"] / unit, loads["w high"] / unit, color=plot.SERIES[0], alpha=0.25, linewidth=0
    )
    for key, label, style in (
        ("none", "without adhesion", "--"),
        ("w_c", "threshold $w_c$", ":"),
        ("w", "this $w$", "-"),
    ):
        axis.semilogx(areas, loads[key] / unit, style, color=plot.SERIES[0] if key == "w" else "black", label=label)
    marks = {"pull-off": said.pull_off, "without load": said.unloaded, "at the load": said.loaded}
    for place, (label, point) in enumerate(marks.items()):
        if point is not None and point.area > 0:
            axis.plot(100 * point.area, point.pressure / unit, "ov*"[place], color=plot.SERIES[5], label=label)
    axis.axhline(0.0, color="gray", linewidth=0.6)
    axis.set(xlabel="contact area (%)", ylabel=f"mean pressure ({name})",
             ylim=(1.3 * min(float(loads["w high"].min()), -0.1 * most) / unit, most / unit))  # fmt: skip
    plot.log_ticks(axis)
    plot.legend_below(figure, plot.labelled(axis))
    return figure


def _draw_deciding(axis: Axes, threshold: MapThreshold) -> str:
    """Draw the heights that change the threshold most, or the gap within the range; returns the title."""
    if threshold.state is None:
        values, ends, label = threshold.distance / threshold.wall.range, (0.0, 1.0), "gap over range"
        title = "gap within the range"
    else:
        values, ends = threshold.deciding(threshold.state, _DECADES), (-_DECADES, 0.0)
        title, label = "where it is decided: $|dw_c/dh|$", "logarithm, over the 99.9 % quantile"
    _draw_values(axis, threshold.map.lengths, values, "magma_r", ends, label)
    return title


@plot.styled
def fault_figure(prediction: PredictionNumbers) -> Figure:
    """The first faulty map: marks on the map, offsets of lines, spectra by direction, heights."""
    i = next(i for i, found in enumerate(prediction.findings) if found.faults)
    topography, found = prediction.topographies[i], prediction.findings[i]
    figure, places = plot.four_panels()
    (image, offsets), (spectra, heights) = places
    _marks(image, topography, found)
    _offsets(offsets, topography, found)
    _spectra(spectra, topography)
    _heights(heights, topography)
    plot.letter_panels(
        (image, offsets, spectra, heights),
        ("scars (red), displaced lines (blue)", "offsets of lines", "spectra by direction", "distribution of heights"),
    )
    plot.log_ticks(spectra, heights)
    for axis in (offsets, spectra, heights):
        plot.legend_under(axis, _HALF)
    plot.place_panels(figure, places)
    return figure


def _marks(axis: Axes, topography: Topography, found: Findings) -> None:
    """The map in grey, scars and outliers in red, displaced lines in blue."""
    ends = np.quantile(topography.heights, (0.01, 0.99))
    size = _draw_values(axis, topography.lengths, topography.heights, "gray", ends)
    x, y = np.nonzero(found.marked)
    pixel = topography.grid.spacing
    axis.plot((x + 0.5) * pixel[0] / size, (y + 0.5) * pixel[1] / size, "s", color="red", markersize=1.0)
    for line in found.lines.outliers:
        draw = axis.axhline if found.lines.axis == 0 else axis.axvline
        draw((line + 0.5) * pixel[1 - found.lines.axis] / size, color="blue", linewidth=0.6)


def _offsets(axis: Axes, topography: Topography, found: Findings) -> None:
    """Medians of lines and of columns, which are alike on an isotropic surface."""
    unit, name = length_scale(topography.heights.std())
    for along, colour in ((found.lines.axis, plot.SERIES[5]), (1 - found.lines.axis, plot.SERIES[0])):
        offsets = line_offsets(topography.heights, along)
        axis.plot(offsets / unit, color=colour, linewidth=0.8, label=f"lines along {'xy'[along]}")
    axis.set(xlabel="number of the line", ylabel=f"median height ({name})")


def _spectra(axis: Axes, topography: Topography) -> None:
    """Spectra of profiles along x and y, averaged: they differ where lines are displaced or the surface is grooved."""
    for along in (0, 1):
        q, c = profile_spectrum(np.moveaxis(topography.heights, along, 1), topography.grid.spacing[along])
        # Twice, so that ∫ C dq over q > 0 is their mean square.
        axis.loglog(q, 2 * c, color=plot.SERIES[5 * along], linewidth=1, label=f"profiles along {'xy'[along]}")
    axis.set(xlabel="wavenumber q (1/m)", ylabel="C of profiles (m³)")


def _heights(axis: Axes, topography: Topography) -> None:
    """Distribution of heights beside the Gaussian of the same variance."""
    z = topography.heights / topography.heights.std()
    counts, edges = np.histogram(z, bins=np.linspace(-8, 8, 121), density=True)
    middle = (edges[1:] + edges[:-1]) / 2
    axis.semilogy(middle[counts > 0], counts[counts > 0], ".", color=plot.SERIES[0], markersize=4, label="heights")
    axis.semilogy(middle, np.exp(-(middle**2) / 2) / np.sqrt(2 * np.pi), color="black", linewidth=0.8, label="Gaussian")
    axis.set(xlabel=r"height over $h_\mathrm{rms}$", ylabel="density", ylim=(1e-6, 1))


def write_prediction(prediction: PredictionNumbers, folder: Path, name: str) -> list[Path]:
    """Write ``NAME.html``, which needs no other file, and its figures as PNG, or in the formats of
    :func:`continuum.show.plot.written_as`; returns HTML and PNG files.
    """
    figures = {name: (overview(prediction), "")}
    if (loads := load_figure(prediction)) is not None:
        figures[f"{name}-load"] = loads, "Mean pressure against contact area, with the error of the threshold."
    if prediction.faults:
        figures[f"{name}-faults"] = (fault_figure(prediction), "Faults of the map.")
    drawn = [
        (plot.save_figure(figure, folder / stem, usual=(), page=True), caption)
        for stem, (figure, caption) in figures.items()
    ]
    (answer, *more), word = statements(prediction), prediction.verdict.answer
    remarks = [Sheet.of("Remarks", ("",), [(text,) for text in prediction.doubts])] if prediction.doubts else []
    page = Page(
        "Is it sticky?  " + " and ".join(t.source for t in prediction.topographies),
        f"{answer}.",
        (),
        drawn,
        [*remarks, *reading_order(prediction_sheets(prediction))],
        sources="Contact and theories: L. Pastewka and M. O. Robbins, PNAS 111, 3298 (2014), and the sources in the "
        "tables.",
        answers=[f"{line}." for line in more],
        answer=(word.capitalize(), COLOURS[word], verdict_axis(prediction)),
    )
    return [page.write(folder / f"{name}.html"), *(path for path, _ in drawn)]


@plot.styled
def study_figure(study: StudyNumbers) -> Figure:
    """Each sample with its spots, mean and interval."""
    shown = [sample for sample in study.samples if sample.margin is not None]
    figure, axis = plot.new_axes(plot.PAGE, 1.2 + 0.35 * max(len(shown), 2))
    for place, sample in enumerate(shown):
        margins = [spot.margin for spot in sample.spots if spot.margin is not None]
        axis.plot(margins, [place] * len(margins), "o", color=plot.SERIES[0], alpha=0.5, label="spots")
        if sample.interval is not None:
            axis.plot(sample.interval, [place] * 2, color="black", linewidth=1.5, label="mean, 95 %")
        axis.plot(sample.margin, place, "|", color="black", markersize=12, markeredgewidth=2)
    axis.axvline(1.0, color="gray", linestyle="--", linewidth=1)
    axis.set(xscale="log", xlabel="w/w_c (sticky above 1)", ylim=(len(shown) - 0.5, -0.5))
    axis.set_yticks(range(len(shown)), [sample.name for sample in shown])
    plot.log_ticks(axis)
    plot.legend_below(figure, plot.labelled(axis))
    return figure


def write_study(study: StudyNumbers, folder: Path, name: str) -> list[Path]:
    """Write the page, its figure, the ranking and its spots as tables; returns their paths."""
    drawn = []
    if any(sample.margin is not None for sample in study.samples):
        picture = plot.save_figure(study_figure(study), folder / name, usual=(), page=True)
        drawn = [(picture, "Spots, and mean of each sample.")]
    title = f"Ranking of samples by stickiness:  {study.folder.resolve().name}"
    page = Page(title, study_sentence(study) + ".", study_doubts(study), drawn, study_sheets(study))
    output.folder(folder)
    spots = []
    for spot in study.spots:
        named: dict[str, str | float | None] = {
            "sample": spot.sample, "spot": spot.name, "files": ", ".join(spot.files),
            "w/w_c": spot.margin, "error": spot.error,
        }  # fmt: skip
        spots.append(named | ({} if spot.found is None else row(spot.found)))
    return [
        page.write(folder / f"{name}.html"),
        *(path for path, _ in drawn),
        output.save(folder / f"{name}.csv", as_csv([ranking_row(sample) for sample in study.samples])),
        output.save(folder / f"{name}-spots.csv", as_csv(spots)),
    ]
