"""Figures of a validation, from its stored file only, and of a crystal."""

from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from atomistic.crystal.model import ContactModulus
from atomistic.ladder import budget
from atomistic.ladder.archive import Archive
from atomistic.ladder.rungs import CONTINUUM_RUNGS, RUNGS, WORDS
from atomistic.response.discreteness import Discreteness
from continuum.show import plot

LABELS = WORDS | {"half-space": "half-space, ν = 1/2", "layer": "layer, ν = 1/2", "atoms": "atoms (LAMMPS)"}
_WIDE = 3
"""Largest number of panels in a row for which a title with wall and slope fits into one line."""
_COLOURS = dict(zip(RUNGS, plot.SERIES, strict=False))
_LINES = (("-", 3.0), ("--", 1.2), ("-.", 1.2), ("-", 1.2))
"""Style and width of the lines of the continuum rungs: the first lies below the second, which it nearly equals."""


def draw_all(archive: Archive, folder: Path, stem: str) -> list[Path]:
    """Draw every figure into a folder, as PNG and PDF; returns the PNG files."""
    figures = {"contact": rung_contact_maps(archive), "curves": curves(archive), "scaling": scaling(archive)}
    return [
        plot.save_figure(figure, folder / f"{stem}-{name}") for name, figure in figures.items() if figure is not None
    ]


@plot.styled
def rung_contact_maps(archive: Archive) -> Figure:
    """Contact on the lattice Green's function and on atoms, side by side, and the points that differ.

    A row for each case: its steepest slope, first surface and a middle area.
    """
    columns = archive.columns
    rows = [_shown_states(archive, case)[1] for case in dict.fromkeys(columns["case"].tolist())]
    figure, axes = plot.new_axes(plot.PAGE, 2.3 * len(rows) + 0.5, len(rows), 3, squeeze=False)
    nx, ny = columns["contact"].shape[2:]
    i, j = RUNGS.index("lattice"), RUNGS.index("atoms")
    titles = []
    differs: Any = {"marker": "s", "linestyle": "", "markerfacecolor": "none", "markeredgecolor": plot.DIFFERENT_COLOUR}
    for state, row in zip(rows, axes, strict=True):
        a, b = columns["contact"][i, state], columns["contact"][j, state]
        for axis, kinds in ((row[0], a), (row[1], b)):
            plot.contact_image(axis, kinds, (float(nx), float(ny)))
        plot.contact_image(row[2], b, (float(nx), float(ny)), alpha=0.25)
        for x, y in np.argwhere(a != b):
            row[2].plot(x + 0.5, y + 0.5, markersize=4, **differs)
        area = rf"$A_\mathrm{{rep}}/A_0$ = {columns['area_rep'][j, state]:.3f}"
        differ = int(np.count_nonzero(a != b))
        row[0].set_ylabel(f"{columns['case'][state]}\n{_wall_and_slope(archive, state)}\ny ($a_0$)")
        titles += [LABELS["lattice"], f"{LABELS['atoms']}\n{area}", f"{differ} of {a.size} atoms differ"]
    for axis in axes[-1]:
        axis.set_xlabel("x ($a_0$)")
    plot.letter_panels(axes.flat, titles)
    plot.legend_below(figure, [*plot.contact_key(), Line2D([], [], label="differs", **differs)])
    return figure


def _shown_states(archive: Archive, case: str) -> tuple[NDArray[np.intp], int]:
    """The states of a case of the steepest slope and the first surface; and the one of them of a middle area."""
    columns = archive.columns
    mine = np.flatnonzero(columns["case"] == case)
    mine = mine[columns["rms_slope"][mine] == columns["rms_slope"][mine].max()]
    mine = mine[columns["seed"][mine] == columns["seed"][mine][0]]
    areas = columns["area"][mine]
    return mine, int(mine[np.argsort(areas)[len(areas) // 2]])


@plot.styled
def curves(archive: Archive) -> Figure | None:
    """Repulsive area and load against mean gap on the lattice along the approach, and the load differences of other
    rungs.

    The rungs would lie within a line's width: area and load are drawn for one, the others as differences.
    Atoms are points, at the areas of the input.
    """
    columns = archive.columns
    if "curve_case" not in columns:
        return None
    cases = list(dict.fromkeys(columns["curve_case"].tolist()))
    atoms, titles = RUNGS.index("atoms"), []
    width = plot.PAGE if len(cases) > 1 else plot.COLUMN
    figure, axes = plot.new_axes(width, 5.6, 3, len(cases), squeeze=False, sharex="col")
    for case, (area_axis, load_axis, difference_axis) in zip(cases, axes.T, strict=True):
        along = {
            rung: {
                name: columns[f"curve_{name}"][(columns["curve_case"] == case) & (columns["curve_rung"] == rung)]
                for name in ("mean_gap", "area_rep", "load")
            }
            for rung in CONTINUUM_RUNGS
        }
        mine, middle = _shown_states(archive, case)
        mine = mine[columns["branch"][mine] == "approach"]
        points = {name: columns[name][atoms, mine] for name in ("mean_gap", "area_rep", "load")}
        lattice = along["lattice"]
        order = np.argsort(lattice["mean_gap"])
        at_points = np.interp(points["mean_gap"], lattice["mean_gap"][order], lattice["load"][order])
        for (rung, curve), (style, width) in zip(along.items(), _LINES, strict=True):
            look = {"color": _COLOURS[rung], "label": LABELS[rung], "linestyle": style, "linewidth": width}
            if rung == "lattice":
                area_axis.plot(*plot.broken(curve["mean_gap"], curve["area_rep"]), **look)
                load_axis.plot(*plot.broken(curve["mean_gap"], curve["load"]), **look)
            difference_axis.plot(*plot.broken(curve["mean_gap"], 1e4 * (curve["load"] - lattice["load"])), **look)
        look = {"color": _COLOURS["atoms"], "markerfacecolor": "none", "label": LABELS["atoms"]}
        area_axis.plot(points["mean_gap"], points["area_rep"], "o", **look)
        load_axis.plot(points["mean_gap"], points["load"], "o", **look)
        difference_axis.plot(points["mean_gap"], 1e4 * (points["load"] - at_points), "o", **look)
        load_axis.axhline(0, color="0.7", linewidth=0.6, zorder=0)
        gap = "\n" if len(cases) > _WIDE else ", "
        titles.append(f"{case}\n{_wall_and_slope(archive, middle, gap)}")
        difference_axis.set_xlabel("mean gap ($a_0$)")
    axes[0, 0].set_ylabel(r"repulsive area $A_\mathrm{rep}/A_0$")
    axes[1, 0].set_ylabel("load $N/(E^* A_0)$")
    axes[2, 0].set_ylabel("load minus lattice's\n$\\Delta N/(10^{-4} E^* A_0)$")
    plot.letter_panels(axes.flat, titles)
    plot.legend_below(figure, plot.labelled(axes[2, 0]))
    return figure


def _wall_and_slope(archive: Archive, state: int, gap: str = ", ") -> str:
    length, slope = (archive.columns[name][state] for name in ("adhesion_length", "rms_slope"))
    return rf"$\ell_a$ = {length:g} $a_0${gap}$h'_\mathrm{{rms}}$ = {slope:g}"


@plot.styled
def scaling(archive: Archive) -> Figure | None:
    """Load and displacement difference of lattice response and atoms against the slope, without adhesion."""
    columns = archive.columns
    plain = columns["adhesion_length"] == 0
    fits = [fit for fit in budget.exponents(columns) if fit.adhesion_length == 0]
    if not fits:
        return None
    figure, (left, right) = plot.new_axes(plot.PAGE, 3.4, 1, 2)
    titles = []
    colours = dict(zip(sorted({fit.area for fit in fits}), cycle(plot.SERIES), strict=False))
    markers = dict(zip(sorted({fit.seed for fit in fits}), "osv^D", strict=False))
    for axis, quantity, expected, label in (
        (left, "load", 1, r"load difference $|\Delta N|/N_\mathrm{rep}$"),
        (right, "displacement", 2, "largest displacement difference ($a_0$)"),
    ):
        mine = [fit for fit in fits if fit.quantity == quantity]
        for fit in mine:
            at = plain & (columns["seed"] == fit.seed) & (columns["area"] == fit.area)
            h = columns["rms_slope"][at]
            values = np.abs(columns[f"nonlinearity_{quantity}"][at])
            order = np.argsort(h)
            look = {"marker": markers.get(fit.seed, "o"), "color": colours[fit.area], "markerfacecolor": "none"}
            axis.loglog(h[order], values[order], linewidth=0.8, **look)
        h = np.array(sorted({slope for fit in mine for slope in fit.slopes}))
        flattest = columns[f"nonlinearity_{quantity}"][plain & (columns["rms_slope"] == h[0])]
        top = max(float(np.abs(flattest).max()), 1e-300)
        axis.loglog(h, 2 * top * (h / h[0]) ** expected, "-", color="0.6", linewidth=2, zorder=0)
        fitted = np.array([fit.fitted for fit in mine])
        titles.append(
            f"line: exponent {expected}\nfitted: {fitted.mean():.3f}, from {fitted.min():.3f} to {fitted.max():.3f}"
        )
        axis.set(xlabel=r"rms slope $h'_\mathrm{rms}$", ylabel=label)
    handles = [
        Line2D([], [], color=colour, label=rf"$A_\mathrm{{rep}}/A_0$ = {area:g}") for area, colour in colours.items()
    ]
    outlined: Any = {"color": "0.3", "markerfacecolor": "none", "linestyle": ""}
    handles += [Line2D([], [], marker=m, label=f"seed {s}", **outlined) for s, m in markers.items()]
    plot.log_ticks(left, right)
    plot.letter_panels((left, right), titles)
    plot.legend_below(figure, handles)
    return figure


@plot.styled
def draw_contact_modulus(modulus: ContactModulus, stem: Path, title: str) -> Path:
    """E*(100) over its mean, against the direction of the wavevector; returns the PNG file."""
    figure, axis = plot.new_axes(plot.COLUMN, 2.6)
    relative = modulus.values / modulus.mean
    axis.plot(np.degrees(modulus.angles), relative, color=plot.SERIES[0])
    axis.axhline(1, color="0.6", linewidth=0.8, linestyle="--")
    axis.set_xticks([0, 22.5, 45, 67.5, 90], ["0°\n[100]", "22.5°", "45°\n[110]", "67.5°", "90°\n[010]"])
    axis.set(
        xlim=(0, 90),
        xlabel="direction of the wavevector in the (100) surface",
        ylabel=r"$E^*(\theta)\,/\,E^*$",
        title=f"{title}: {relative.min():.4f} to {relative.max():.4f} of the mean",
    )
    return plot.save_figure(figure, stem)


@plot.styled
def draw_discreteness(found: Discreteness, stem: Path, title: str) -> Path:
    """Stiffness of lattice against continuum over q, all waves and the two limits; returns the PNG file."""
    figure, axis = plot.new_axes(plot.COLUMN, 2.8)
    q = 2 * np.pi / found.wavelength
    # 0 along <110>, 1 along <100>.
    rotation = (1 - np.cos(4 * found.angle)) / 2
    for low, high, colour, label in ((0.0, 0.1, plot.SERIES[0], "[110]"), (0.9, 1.0, plot.SERIES[5], "[100]")):
        near = (rotation >= low) & (rotation <= high)
        axis.plot(q[near], 100 * found.difference[near], ".", color=colour, markersize=2.5, label=f"near {label}")
    between = (rotation > 0.1) & (rotation < 0.9)
    axis.plot(q[between], 100 * found.difference[between], ".", color="0.8", markersize=1, zorder=0, label="between")
    limit = np.array([0, 0.8])
    for slope, colour in ((found.along_110, plot.SERIES[0]), (found.along_100, plot.SERIES[5])):
        axis.plot(limit, 100 * slope * limit, "-", color=colour, linewidth=1)
    axis.axhline(0, color="0.6", linewidth=0.8)
    axis.set(
        xlim=(0, 4.5), xlabel="wavenumber q ($1/a_0$)", ylabel=r"$K_\mathrm{lattice}/K_\mathrm{continuum} - 1$ (%)"
    )
    above = axis.secondary_xaxis("top")
    lengths = (64, 16, 8, 4, 3, 2)
    above.set_xticks([2 * np.pi / length for length in lengths], [str(length) for length in lengths])
    above.set_xlabel("wavelength ($a_0$)")
    axis.set_title(title)
    plot.legend_below(figure, plot.labelled(axis))
    return plot.save_figure(figure, stem)
