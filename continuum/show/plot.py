"""The common style of all figures, and elements that several of them draw."""

import logging
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from itertools import chain, combinations, pairwise, repeat
from pathlib import Path
from string import ascii_uppercase
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, ListedColormap, to_hex
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator
from matplotlib.transforms import ScaledTranslation

from continuum.model.fourier import Real
from continuum.store import output

REPULSIVE_COLOUR, ATTRACTED_COLOUR = "#f08000", "black"
"""The paper's Fig. 1: orange repels, black attracts.  They also differ in lightness."""
DIFFERENT_COLOUR = "#0072b2"
COLUMN, PAGE = 8.7 / 2.54, 17.8 / 2.54
"""Widths at which figures are printed, in inches: a column and a page of the journal, 8.7 and 17.8 cm.

A figure has one of these widths, and letters only in the sizes of the style: nothing is scaled before it is printed.
"""

STYLE: Any = mpl.rc_params_from_file(Path(__file__).with_name("stickiness.mplstyle"), use_default_template=False)
"""Style of all figures, also for other figures: ``plt.style.use("continuum.show.stickiness")``."""
SERIES: tuple[str, ...] = tuple(STYLE["axes.prop_cycle"].by_key()["color"])
"""Colours of curves, which remain distinct for colour-blind readers."""

_UNDER = 30
"""Points from a panel to the legend under it: ticks and the label of the axis lie between."""

_LEFT, _RIGHT, _TITLE, _BELOW = 0.58, 0.74, 0.3, 0.06
"""Inches beside a panel, left for its labels, right for a bar of colours, above it for its title, below its legend."""
_PIXELS = 1024
"""Points along a side of a map that are drawn at most: a printed panel has fewer."""

_DIGITS: tuple[tuple[float, tuple[float, ...]], ...] = (
    (1.5, ()), (3, tuple(range(1, 10))), (20, (1, 2, 5)), (100, (1, 3)),
)  # fmt: skip
"""First digits that are labelled on a logarithmic axis of less than a given factor."""

_MINOR = 1e6
"""Factor from which on a logarithmic axis has no ticks between powers of ten: they would be as dense as the line."""

_formats: ContextVar[Sequence[str]] = ContextVar("formats", default=())
# Without dates, so that the same result gives the same files.
_METADATA: Any = {
    "pdf": {"CreationDate": None, "Creator": output.MARK.decode()},
    "png": {"Software": output.MARK.decode()},
    "svg": {"Date": None, "Creator": output.MARK.decode()},
}

# fontTools warns about old dates of the fonts in a PDF.
logging.getLogger("fontTools").setLevel(logging.ERROR)

# Not of figures, but of windows: to set a back end would open it.
_PLAIN: dict[str, Any] = {
    k: v for k, v in mpl.rcParamsDefault.items() if not k.startswith(("backend", "toolbar", "interactive"))
}


@contextmanager
def _style(**more: Any) -> Iterator[None]:
    """The common style on matplotlib's own defaults: the user's matplotlibrc or style changes no figure."""
    style: Any = _PLAIN | dict(STYLE) | more
    with mpl.rc_context(style):
        yield


styled = _style()
"""Decorator of functions that draw, which applies the common style without changing global settings."""


_saved = _style(**{"figure.constrained_layout.use": False})
"""The same without a layout engine, which draws twice: of what saves, too, or a figure without one would get it."""


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of the given size in inches, without a window."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def new_axes(width: float, height: float, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """A new figure, and its axes as matplotlib's ``subplots`` gives them."""
    figure = new_figure(width, height)
    return figure, figure.subplots(rows, columns, **options)


@_saved
def four_panels() -> tuple[Figure, Any]:
    """A figure of the width of a page with two by two panels, to which :func:`place_panels` gives their places."""
    figure = Figure(figsize=(PAGE, PAGE))
    FigureCanvasAgg(figure)
    return figure, figure.subplots(2, 2)


def place_panels(figure: Figure, panels: Any) -> None:
    """Give four panels, all square, their places, each row above its legends; to be called last.

    A layout engine would draw all twice to find them, which takes longer than the figure itself.
    """
    side = PAGE / 2 - _LEFT - _RIGHT
    keys = [max((_height(axis) for axis in row if axis in figure.axes), default=0.0) for row in panels]
    below = [_UNDER / 72 + key + _BELOW for key in keys]
    height = 2 * (side + _TITLE) + sum(below)
    figure.set_size_inches(PAGE, height)
    for row, bottom in zip(panels, (height - _TITLE - side, below[1]), strict=True):
        for axis, left in zip(row, (_LEFT, _LEFT + PAGE / 2), strict=True):
            axis.set_position((left / PAGE, bottom / height, side / PAGE, side / height))


def _height(axis: Axes) -> float:
    """Height of the legend of a panel, in inches."""
    legend = axis.get_legend()
    return 0.0 if legend is None else float(legend.get_window_extent().height) / axis.figure.dpi


def letter_panels(axes: Iterable[Axes], titles: Iterable[str] = ()) -> None:
    """Letter panels A, B, C in bold, each with its title; a single panel has its title only."""
    panels = list(axes)
    for letter, axis, title in zip(ascii_uppercase, panels, chain(titles, repeat("")), strict=False):
        named = rf"$\mathbf{{{letter}}}$  {title}" if len(panels) > 1 else title
        # At a given height: matplotlib would lay out all ticks once more to find one above them.
        axis.set_title(named.rstrip(), loc="left", y=1.0)


def labelled(*axes: Axes) -> list[Artist]:
    """Labelled artists in these panels, each label once."""
    pairs = [pair for axis in axes for pair in zip(*axis.get_legend_handles_labels(), strict=True)]
    return list({label: handle for handle, label in reversed(pairs)}.values())[::-1]


def legend_below(figure: Figure, *groups: Sequence[Artist]) -> None:
    """One legend for all panels, below them; to be drawn last.

    Each group has a column, or shares one with the next if the figure is too narrow; a single group is spread over
    columns.
    """
    filled = [list(group) for group in groups if group]
    if len(filled) == 1:
        filled = [[entry] for entry in filled[0]]
        most = min(len(filled), 6)
    else:
        most = len(filled)
    for columns in range(most, 0, -1):
        cuts = min(combinations(range(1, len(filled)), columns - 1), key=lambda cuts: max(_lengths(filled, cuts)))
        parts = [list(chain(*filled[low:high])) for low, high in pairwise((0, *cuts, len(filled)))]
        rows = max(map(len, parts))
        padded = chain(*([*part, *[Patch(visible=False, label=" ")] * (rows - len(part))] for part in parts))
        legend = figure.legend(handles=list(padded), loc="outside lower center", ncols=columns)
        if legend.get_window_extent().width <= figure.bbox.width or columns == 1:
            return
        legend.remove()


def _lengths(groups: Sequence[Sequence[Artist]], cuts: Sequence[int]) -> list[int]:
    """Number of entries in each column, if groups are divided at these places."""
    return [sum(map(len, groups[low:high])) for low, high in pairwise((0, *cuts, len(groups)))]


def legend_under(axis: Axes, width: float) -> None:
    """The legend of one panel, below it and no wider than a part of the figure, for panels with different symbols."""
    entries = labelled(axis)
    for columns in range(min(len(entries), 4), 0, -1):
        place = axis.transAxes + ScaledTranslation(0, -_UNDER / 72, axis.figure.dpi_scale_trans)
        legend = axis.legend(handles=entries, loc="upper left", bbox_to_anchor=(0, 0), bbox_transform=place,
                             borderaxespad=0, borderpad=0, ncols=columns)  # fmt: skip
        if legend.get_window_extent().width <= width * axis.figure.bbox.width:
            return


def log_ticks(*axes: Axes) -> None:
    """Labels that do not overlap on logarithmic axes: powers of ten, or also numbers such as 2 and 5."""
    for axis in (axis for one in axes for axis in (one.xaxis, one.yaxis) if axis.get_scale() == "log"):
        low, high = sorted(axis.get_view_interval())
        axis.set_minor_formatter(NullFormatter())
        if high > _MINOR * low:
            axis.set_minor_locator(NullLocator())
        elif high < 100 * low:
            digits = next(digits for factor, digits in _DIGITS if high < factor * low)
            axis.set_major_locator(LogLocator(subs=digits) if digits else MaxNLocator(4))
            axis.set_major_formatter(FuncFormatter(_number))


def _number(value: float, _: object) -> str:
    """A number as text, such as 0.02 or 2 10^-9."""
    if value == 0 or 1e-3 <= abs(value) < 1e4:
        return f"{value:.4g}"
    digits, power = f"{value:.2e}".split("e")
    front = "" if float(digits) == 1 else rf"{float(digits):g}\cdot"
    return f"${front}10^{{{int(power)}}}$"


@contextmanager
def written_as(formats: Sequence[str] | None) -> Iterator[None]:
    """Save figures in these formats (png, pdf, svg) instead of those that are usual; None changes nothing."""
    before = _formats.set(formats or _formats.get())
    try:
        yield
    finally:
        _formats.reset(before)


@_saved
def save_figure(
    figure: Figure, stem: Path, *, own: bool = False, usual: Sequence[str] = ("png", "pdf"), page: bool = False
) -> Path:
    """Write ``stem.png`` and ``stem.pdf``, the ``usual`` formats, or those of :func:`written_as`; returns the first.

    A figure of a ``page``, which shows it as PNG, is written as PNG, too, and first.  Files of other programs are kept
    unless the folder is the program's ``own``: see :func:`continuum.store.output.save`.
    """
    output.folder(stem.parent)
    formats = list(dict.fromkeys([*(["png"] if page else []), *(_formats.get() or usual)]))
    paths = [stem.with_name(f"{stem.name}.{one}") for one in formats]
    layout = figure.get_layout_engine()
    try:
        for one, path in zip(formats, paths, strict=True):
            output.save(path, image_bytes(figure, one), own=own)
            figure.set_layout_engine("none")  # as it is from now on: nothing has moved since
    finally:
        figure.set_layout_engine(layout)
    return paths[0]


@_saved
def image_bytes(figure: Figure, form: str = "png") -> bytes:
    """The file of a figure, in a format."""
    file = BytesIO()
    figure.savefig(file, format=form, metadata=_METADATA[form])
    return file.getvalue()


def broken(x: Real, y: Real) -> tuple[Real, Real]:
    """Points of a path with NaN inserted in each jump, where no line is drawn.

    A jump is a step of y of at least a tenth of its range, and five times as large as the neighbouring steps.
    """
    step = np.abs(np.diff(y))
    if step.size < 3:
        return x, y
    beside = np.maximum(np.concatenate([[0.0], step[:-1]]), np.concatenate([step[1:], [0.0]]))
    jumps = np.flatnonzero((step > 0.1 * np.ptp(y)) & (step > 5 * beside)) + 1
    return np.insert(x, jumps, np.nan), np.insert(y, jumps, np.nan)


def _few(values: np.ndarray, *, every: bool) -> np.ndarray:
    """Reduce a map to the points that are visible: every n-th point of kinds, means of numbers."""
    steps = [max(n // _PIXELS, 1) for n in values.shape]
    if every or max(steps) == 1:
        return values[tuple(slice(None, None, step) for step in steps)]
    whole = values[tuple(slice(n - n % step) for n, step in zip(values.shape, steps, strict=True))]
    (nx, ny), (by_x, by_y) = whole.shape, steps
    return np.asarray(whole.reshape(nx // by_x, by_x, ny // by_y, by_y).mean(axis=(1, 3)))


def contact_image(axis: Axes, kinds: np.ndarray, period: tuple[float, float], alpha: float = 1.0) -> None:
    """Draw a contact map: 2 repulsive, 1 attracted, 0 out of range (shape (nx, ny); lengths in a0)."""
    map_image(axis, kinds, period, ListedColormap(contact_colours()), (0, 2), interpolation="nearest", alpha=alpha)


def contact_colours() -> list[str]:
    """Colours of contact maps, as #rrggbb: out of range, attracted, repulsive."""
    return [to_hex(one) for one in ("white", ATTRACTED_COLOUR, REPULSIVE_COLOUR)]


def map_colours() -> list[str]:
    """Colours of maps of numbers, as #rrggbb, from the lowest on."""
    return [to_hex(one) for one in mpl.colormaps["cividis"](np.linspace(0, 1, 256))]


def contact_key() -> list[Patch]:
    """Entries of a legend: the colours of contact maps."""
    colours = {"repulsive": REPULSIVE_COLOUR, "attracted": ATTRACTED_COLOUR}
    return [Patch(facecolor=colour, label=name) for name, colour in colours.items()]


def map_image(
    axis: Axes, values: np.ndarray, lengths: Sequence[float], colours: str | Colormap, ends: Any, **more: Any
) -> AxesImage:
    """Draw a map of values, shape (nx, ny), over its lengths in a frame; colours run between two values."""
    extent, (low, high) = (0, lengths[0], 0, lengths[1]), ends
    line = values.shape[0] == 1
    aspect: Any = "auto" if line else "equal"
    drawn = _few(values, every="interpolation" in more)
    image = axis.imshow(
        drawn.T, cmap=colours, vmin=low, vmax=high, origin="lower", extent=extent, aspect=aspect, **more
    )
    if line:
        axis.set_xticks([])
    axis.spines[:].set_visible(True)
    return image
