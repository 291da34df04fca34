"""Figures of a prediction: map, spectrum, dependence on resolution, the solved contact, the faults of a map."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from continuum import units
from continuum.measure.contact import contact_map
from continuum.show import plot
from continuum.sticky.criteria import CRITERIA
from continuum.sticky.prediction import Prediction, rough_contact
from continuum.sticky.record import support
from continuum.sticky.simulate import Simulation
from continuum.sticky.solved_turn import SolvedTurn
from continuum.sticky.verdict import SURE, judge_contact
from continuum.topography.faults import Findings
from continuum.topography.map import Topography
from continuum.topography.roughness import Cut, spectrum
from continuum.topography.scanlines import line_offsets
from continuum.topography.spectra import profile_spectrum

_COLOURS = (*plot.SERIES, "black")
"""Colours of the criteria."""
_LINES: dict[str, Any] = {r"$\lambda_L$": ":", r"$\lambda_s$": "-.", "noise": (0, (1, 4))}
"""Lines at the ends of the fit in a spectrum."""
_HALF = 0.46
"""Part of the width of the figure that the legend of one of two panels may take."""


@plot.styled
def overview(prediction: Prediction) -> Figure:
    """Map, spectrum, and roughness and verdicts against the smallest wavelength."""
    figure, ((image, density), (slopes, chances)) = plot.new_axes(plot.PAGE, 6.8, 2, 2)
    _draw_map(image, prediction.topographies[0])
    _draw_spectrum(density, prediction)
    cuts = [cut for cut, _ in prediction.cuts]
    _draw_moments(slopes, cuts)
    _draw_chances(chances, prediction)
    plot.letter_panels(
        (image, density, slopes, chances),
        (r"map, $\pm 3\,h_\mathrm{rms}$", "power spectral density", "slope and curvature, by resolution",
         "verdicts, by resolution"),
    )  # fmt: skip
    plot.log_ticks(*figure.axes)
    for axis in (density, chances):
        plot.legend_under(axis, _HALF)
    return figure


def length_scale(value: float) -> tuple[float, str]:
    """Unit of length for an axis that reaches a value: its size and name."""
    name = units.readable(value, "length").split()[1]
    return units.unit_size(name, "length"), name


def _draw_map(axis: Axes, topography: Topography) -> None:
    size, name = length_scale(max(topography.lengths))
    most = 3 * topography.heights.std()
    # Heights below a nanometre are also given in nanometres.
    height, height_name = length_scale(max(most, 1e-9))
    lengths = [length / size for length in topography.lengths]
    image = plot.map_image(axis, topography.heights / height, lengths, "cividis", (-most / height, most / height))
    # Inside the axes' own frame, so that it stays beside a map of any shape.
    axis.figure.colorbar(image, cax=axis.inset_axes((1.04, 0, 0.05, 1)), label=f"height ({height_name})")
    axis.set(xlabel=f"x ({name})", ylabel=f"y ({name})")


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
            [low, high], level * np.array([low, high]) ** slope, "k--", linewidth=1, label=f"$H = {fit.hurst:.2f}$"
        )
        for wavelength, (name, line) in zip((fit.roll_off, fit.cut_off, fit.floor), _LINES.items(), strict=True):
            if wavelength is not None:
                axis.axvline(2 * np.pi / wavelength, color=colour, linestyle=line, linewidth=0.8, label=name)
    axis.set(xlabel="wavenumber $q$ (1/m)", ylabel="$C(q)$ (m⁴)")


def _draw_moments(axis: Axes, cuts: Sequence[Cut]) -> None:
    size, name = length_scale(cuts[len(cuts) // 2].wavelength)
    x = np.array([cut.wavelength for cut in cuts]) / size
    axis.loglog(x, [cut.moments.rms_slope for cut in cuts], "o-", color=plot.SERIES[0], markersize=3)
    axis.set_xlabel(f"smallest wavelength counted ({name})")
    axis.set_ylabel(r"rms slope $h'_\mathrm{rms}$", color=plot.SERIES[0])
    other = axis.twinx()
    other.loglog(x, [cut.moments.rms_curvature * 1e-6 for cut in cuts], "s-", color=plot.SERIES[5], markersize=3)
    other.set_ylabel(r"rms curvature $h''_\mathrm{rms}$ (1/µm)", color=plot.SERIES[5])
    other.spines["right"].set_visible(True)


def _draw_chances(axis: Axes, prediction: Prediction) -> None:
    """Probability by the record of each theory and of all together, and the limits beyond which a verdict is given."""
    size, name = length_scale(prediction.cuts[len(prediction.cuts) // 2][0].wavelength)
    x = [cut.wavelength / size for cut, _ in prediction.cuts]
    contact = prediction.contact
    cast = [rough_contact(cut, prediction.interface, contact.roll_off) for cut, _ in prediction.cuts]
    styles = ("o-", "s--", "^:", "v-.", "D--", "x:", "P-")
    for i in prediction.distinct:
        criterion = CRITERIA[prediction.verdicts[i].key]
        if criterion.sufficient:
            supported = [support((criterion,), one) for one in cast]
            y = [np.nan if one is None else one.probability for one in supported]
            axis.semilogx(x, y, styles[i], color=_COLOURS[i], markersize=3, label=criterion.name)
    together = [None if prediction.excluding else judge_contact(one).probability for one in cast]
    if any(chance is not None for chance in together):
        axis.semilogx(x, [np.nan if chance is None else chance for chance in together], color="black", linewidth=2.5,
                      alpha=0.5, label="together, in range")  # fmt: skip
    for edge in (1 - SURE, SURE):
        axis.axhline(edge, color="black", linewidth=0.8, label="10 and 90 %")
    axis.set(
        xlabel=f"smallest wavelength counted ({name})",
        ylabel="probability of sticking, by the records",
        ylim=(-0.02, 1.02),
    )


@plot.styled
def mending_figure(measured: Topography, judged: Topography) -> Figure:
    """The measured and the corrected map, and the bearing curves of both."""
    figure, (before, after, bearing) = plot.new_axes(plot.PAGE, 2.6, 1, 3)
    _draw_map(before, measured)
    _draw_map(after, judged)
    unit, name = length_scale(max(3 * judged.heights.std(), 1e-9))
    share = np.linspace(0.001, 0.999, 300)
    for topography, style, label in ((measured, "--", "as measured"), (judged, "-", "as judged")):
        heights = topography.heights - topography.heights.mean()
        colour = plot.SERIES[5 if label == "as measured" else 0]
        bearing.plot(100 * share, np.quantile(heights, 1 - share) / unit, style, color=colour, label=label)
    gaussian = judged.heights.std() * scipy.special.ndtri(1 - share) / unit
    bearing.plot(100 * share, gaussian, ":", color="black", label="Gaussian")
    bearing.set(xlabel="area above the height (%)", ylabel=f"height ({name})")
    plot.letter_panels((before, after, bearing), ("as measured", "as judged", "bearing curve"))
    plot.legend_under(bearing, 0.26)
    return figure


@plot.styled
def contact_figure(solved: Simulation | SolvedTurn) -> Figure:
    """Map of repulsion and attraction in the solved contact."""
    figure, axis = plot.new_axes(plot.COLUMN, 3.6)
    (nx, ny), lengths = solved.map.shape, solved.map.lengths
    unit, name = length_scale(max(lengths))
    period = lengths[0] / unit, lengths[1] / unit
    plot.contact_image(axis, contact_map(solved.wall, solved.gap[:nx, :ny]), period)
    area = rf"$A_\mathrm{{rep}}/A_0$ = {solved.area_rep:.3g}"
    axis.set(xlabel=f"x ({name})", ylabel=f"y ({name})", title=area)
    plot.legend_below(figure, plot.contact_key())
    return figure


@plot.styled
def fault_figure(prediction: Prediction) -> Figure:
    """The first faulty map: marks on the map, offsets of lines, spectra by direction, heights."""
    i = next(i for i, found in enumerate(prediction.findings) if found.faults)
    topography, found = prediction.topographies[i], prediction.findings[i]
    figure, ((image, offsets), (spectra, heights)) = plot.new_axes(plot.PAGE, 6.8, 2, 2)
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
    return figure


def _marks(axis: Axes, topography: Topography, found: Findings) -> None:
    """The map in grey, scars and outliers in red, displaced lines in blue."""
    size, name = length_scale(max(topography.lengths))
    lengths = [length / size for length in topography.lengths]
    plot.map_image(axis, topography.heights, lengths, "gray", np.quantile(topography.heights, (0.01, 0.99)))
    x, y = np.nonzero(found.marked)
    pixel = topography.grid.spacing
    axis.plot((x + 0.5) * pixel[0] / size, (y + 0.5) * pixel[1] / size, "s", color="red", markersize=1.0)
    for line in found.lines.outliers:
        draw = axis.axhline if found.lines.axis == 0 else axis.axvline
        draw((line + 0.5) * pixel[1 - found.lines.axis] / size, color="blue", linewidth=0.6)
    axis.set(xlabel=f"x ({name})", ylabel=f"y ({name})")


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
