"""Figures of a prediction: the map, its spectrum, what depends on resolution, and the solved contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from continuum import units
from continuum.measure.contact import contact_map
from continuum.show import plot
from continuum.sticky.prediction import Prediction
from continuum.sticky.simulate import Simulation
from continuum.topography.roughness import Cut, spectrum

_COLOURS = (*plot.SERIES, "black")
"""Colours of the criteria."""


@plot.styled
def overview(prediction: Prediction) -> Figure:
    """Map, spectrum, and what depends on the smallest wavelength."""
    figure = plot.new_figure(plot.PAGE, 6.8)
    (image, density), (slopes, margins) = figure.subplots(2, 2)
    _draw_map(image, prediction)
    _draw_spectrum(density, prediction)
    cuts = [cut for cut, _ in prediction.cuts]
    _draw_moments(slopes, cuts)
    _draw_margins(margins, prediction)
    return figure


def length_scale(value: float) -> tuple[float, str]:
    """Unit of length for an axis that reaches a value: its size and name."""
    name = units.readable(value, "length").split()[1]
    return units.unit_size(name, "length"), name


def _draw_map(axis: Axes, prediction: Prediction) -> None:
    topography = prediction.topographies[0]
    # Heights of less than a nanometre are still read in nanometres.
    (size, name), (height, height_name) = (
        length_scale(max(topography.lengths)),
        length_scale(max(3 * topography.heights.std(), 1e-9)),
    )
    image = axis.imshow(
        topography.heights.T / height,
        origin="lower",
        extent=(0, topography.lengths[0] / size, 0, topography.lengths[1] / size),
        vmin=-3 * topography.heights.std() / height,
        vmax=3 * topography.heights.std() / height,
        cmap="cividis",
    )
    # Inside the axes' own frame, so that it stays beside a map of any shape.
    axis.figure.colorbar(image, cax=axis.inset_axes((1.04, 0, 0.05, 1)), label=f"height ({height_name})")
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
                    name, (2 * np.pi / wavelength, 1), (-2, 0), xycoords=("data", "axes fraction"),
                    textcoords="offset points", va="top", ha="right",
                )  # fmt: skip
    axis.set(xlabel="wavenumber q (1/m)", ylabel="C(q) (m⁴)", title="power spectral density")
    if axis.lines:
        axis.legend(loc="lower left")


def _draw_moments(axis: Axes, cuts: Sequence[Cut]) -> None:
    size, name = length_scale(cuts[len(cuts) // 2].wavelength)
    x = np.array([cut.wavelength for cut in cuts]) / size
    axis.loglog(x, [cut.moments.rms_slope for cut in cuts], "o-", color=plot.SERIES[0], markersize=3)
    axis.set(xlabel=f"smallest wavelength counted ({name})", title="slope and curvature, by resolution")
    axis.set_ylabel("rms slope $h'_{rms}$", color=plot.SERIES[0])
    other = axis.twinx()
    other.loglog(x, [cut.moments.rms_curvature * 1e-6 for cut in cuts], "s-", color=plot.SERIES[5], markersize=3)
    other.set_ylabel("rms curvature $h''_{rms}$ (1/µm)", color=plot.SERIES[5])
    other.spines["right"].set_visible(True)


def _draw_margins(axis: Axes, prediction: Prediction) -> None:
    size, name = length_scale(prediction.cuts[len(prediction.cuts) // 2][0].wavelength)
    x = [cut.wavelength / size for cut, _ in prediction.cuts]
    styles = ("o-", "s--", "^:", "v-.", "D--", "x:", "P-")
    for i in prediction.distinct:
        y = [found[i].margin or np.nan for _, found in prediction.cuts]
        axis.loglog(x, y, styles[i], color=_COLOURS[i], markersize=3, label=prediction.verdicts[i].name)
    axis.axhline(1, color="black", linewidth=0.8)
    axis.set(
        xlabel=f"smallest wavelength counted ({name})",
        ylabel="margin: w / w at the turn (sticky above 1)",
        title="verdicts, by resolution",
    )
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2)


@plot.styled
def contact_figure(simulation: Simulation) -> Figure:
    """Where the solved contact repels and attracts."""
    figure = plot.new_figure(4.2, 4.2)
    axis = figure.subplots()
    unit, name = length_scale(max(simulation.lengths))
    period = (simulation.lengths[0] / unit, simulation.lengths[1] / unit)
    nx, ny = simulation.shape
    plot.contact_image(axis, contact_map(simulation.wall, simulation.gap[:nx, :ny]), period)
    axis.set(xlabel=f"x ({name})", ylabel=f"y ({name})")
    axis.set_title(f"repulsive (orange) and attracted (black), A_rep/A0 = {simulation.area_rep:.3g}")
    return figure
