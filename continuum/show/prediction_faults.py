"""Figure of a faulty map: what was looked for, and where it was found."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from continuum.model.fourier import Real
from continuum.show import plot
from continuum.show.prediction_figures import length_scale
from continuum.sticky.prediction import Prediction
from continuum.topography.faults import Findings
from continuum.topography.linescan import profile_spectrum
from continuum.topography.map import Topography
from continuum.topography.scanlines import line_offsets


@plot.styled
def fault_figure(prediction: Prediction) -> Figure:
    """The first map with a fault: marks on the map, offsets of lines, spectra by direction, heights."""
    i = next(i for i, found in enumerate(prediction.findings) if found.faults)
    topography, found = prediction.topographies[i], prediction.findings[i]
    figure = plot.new_figure(plot.PAGE, 6.8)
    (image, offsets), (spectra, heights) = figure.subplots(2, 2)
    _marks(image, topography, found)
    _offsets(offsets, topography, found)
    _spectra(spectra, topography)
    _heights(heights, topography)
    return figure


def _marks(axis: Axes, topography: Topography, found: Findings) -> None:
    """The map in grey, scars and outliers in red, displaced lines in blue."""
    size, name = length_scale(max(topography.lengths))
    lx, ly = (length / size for length in topography.lengths)
    low, high = np.quantile(topography.heights, (0.01, 0.99))
    axis.imshow(topography.heights.T, origin="lower", extent=(0, lx, 0, ly), cmap="gray", vmin=low, vmax=high)
    x, y = np.nonzero(found.marked)
    pixel = topography.grid.spacing
    axis.plot((x + 0.5) * pixel[0] / size, (y + 0.5) * pixel[1] / size, "s", color="red", markersize=1.0)
    for line in found.lines.outliers:
        draw = axis.axhline if found.lines.axis == 0 else axis.axvline
        draw((line + 0.5) * pixel[1 - found.lines.axis] / size, color="blue", linewidth=0.6)
    axis.set(xlabel=f"x ({name})", ylabel=f"y ({name})", title="scars (red), displaced lines (blue)")
    axis.spines[:].set_visible(True)


def _offsets(axis: Axes, topography: Topography, found: Findings) -> None:
    """Medians of lines and of columns: an isotropic surface has two curves of one kind."""
    unit, name = length_scale(topography.heights.std())
    for along, colour in ((found.lines.axis, plot.SERIES[5]), (1 - found.lines.axis, plot.SERIES[0])):
        offsets = line_offsets(topography.heights, along)
        axis.plot(offsets / unit, color=colour, linewidth=0.8, label=f"lines along {'xy'[along]}")
    axis.set(xlabel="number of the line", ylabel=f"median height ({name})", title="offsets of lines")
    axis.legend()


def _spectra(axis: Axes, topography: Topography) -> None:
    """Spectra of profiles along x and y, averaged: they differ where lines are displaced or the surface is grooved."""
    for along in (0, 1):
        q, c = _profiles(topography, along)
        axis.loglog(q, c, color=plot.SERIES[5 * along], linewidth=1, label=f"profiles along {'xy'[along]}")
    axis.set(xlabel="wavenumber q (1/m)", ylabel="C of profiles (m³)", title="spectra by direction")
    axis.legend(loc="lower left")


def _profiles(topography: Topography, along: int) -> tuple[Real, Real]:
    """Spectrum of the profiles in one direction; ∫ C dq over q > 0 is their mean square."""
    q, c = profile_spectrum(np.moveaxis(topography.heights, along, 1), topography.grid.spacing[along])
    return q, 2 * c


def _heights(axis: Axes, topography: Topography) -> None:
    """Distribution of heights beside the Gaussian of the same variance."""
    z = topography.heights / topography.heights.std()
    counts, edges = np.histogram(z, bins=np.linspace(-8, 8, 121), density=True)
    middle = (edges[1:] + edges[:-1]) / 2
    axis.semilogy(middle[counts > 0], counts[counts > 0], ".", color=plot.SERIES[0], markersize=4, label="heights")
    axis.semilogy(middle, np.exp(-(middle**2) / 2) / np.sqrt(2 * np.pi), color="black", linewidth=0.8, label="Gaussian")
    axis.set(xlabel="height over h_rms", ylabel="density", title="distribution of heights", ylim=(1e-6, 1))
    axis.legend()
