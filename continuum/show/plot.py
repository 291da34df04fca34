"""The style that all figures of the project share, and what several of them draw."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Patch

from continuum.files import output
from continuum.model.fourier import Real

REPULSIVE_COLOUR, ATTRACTED_COLOUR = "#f08000", "black"
"""The paper's Fig. 1: orange repels, black attracts.  They also differ in lightness."""
DIFFERENT_COLOUR = "#0072b2"
COLUMN, PAGE = 3.42, 7.0
"""Widths of figures, in inches: a column and a page of the journal."""

STYLE: Any = mpl.rc_params_from_file(Path(__file__).with_name("stickiness.mplstyle"), use_default_template=False)
"""What all figures look like; others may use it, too: ``plt.style.use("continuum.show.stickiness")``."""
SERIES: tuple[str, ...] = tuple(STYLE["axes.prop_cycle"].by_key()["color"])
"""Colours of curves, told apart by all kinds of sight."""

_formats: ContextVar[Sequence[str]] = ContextVar("formats", default=("png", "pdf"))
# Without dates, so that the same result gives the same files.
_UNDATED: Any = {"pdf": {"CreationDate": None}, "png": {"Software": None}, "svg": {"Date": None}}

# Of fonts that a PDF embeds, it says that their dates are old.
logging.getLogger("fontTools").setLevel(logging.ERROR)

styled = mpl.rc_context(STYLE)
"""Decorator of functions that draw: the common style, and nothing global."""


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of the given size in inches, without a window."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def new_axes(width: float, height: float, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """A new figure, and its axes as matplotlib's ``subplots`` gives them."""
    figure = new_figure(width, height)
    return figure, figure.subplots(rows, columns, **options)


@contextmanager
def written_as(formats: Sequence[str] | None) -> Iterator[None]:
    """Figures are saved in these formats, of png, pdf and svg, instead of PNG and PDF; as before if None."""
    before = _formats.set(formats or _formats.get())
    try:
        yield
    finally:
        _formats.reset(before)


@styled
def save_figure(figure: Figure, stem: Path) -> Path:
    """Write ``stem.png`` and ``stem.pdf``, or what :func:`written_as` says; returns the first."""
    output.folder(stem.parent)
    paths = [stem.with_name(f"{stem.name}.{one}") for one in _formats.get()]
    for one, path in zip(_formats.get(), paths, strict=True):
        output.save(path, image_bytes(figure, one))
    return paths[0]


@styled
def image_bytes(figure: Figure, form: str = "png") -> bytes:
    """The file of a figure, in a format."""
    file = BytesIO()
    figure.savefig(file, format=form, metadata=_UNDATED[form])
    return file.getvalue()


def broken(x: Real, y: Real) -> tuple[Real, Real]:
    """Points of a path with NaN, where no line is drawn, in each jump.

    A jump is a step of y that is a tenth of its whole range, and five times as large as the steps beside it.
    """
    step = np.abs(np.diff(y))
    if step.size < 3:
        return x, y
    beside = np.maximum(np.concatenate([[0.0], step[:-1]]), np.concatenate([step[1:], [0.0]]))
    jumps = np.flatnonzero((step > 0.1 * np.ptp(y)) & (step > 5 * beside)) + 1
    return np.insert(x, jumps, np.nan), np.insert(y, jumps, np.nan)


def contact_image(axis: Axes, kinds: np.ndarray, period: tuple[float, float], alpha: float = 1.0) -> None:
    """Draw a contact map: 2 repulsive, 1 attracted, 0 out of range (shape (nx, ny); lengths in a0)."""
    colours = ListedColormap(["white", ATTRACTED_COLOUR, REPULSIVE_COLOUR])
    map_image(axis, kinds, period, colours, (0, 2), interpolation="nearest", alpha=alpha)


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
    image = axis.imshow(
        values.T, cmap=colours, vmin=low, vmax=high, origin="lower", extent=extent, aspect=aspect, **more
    )
    if line:
        axis.set_xticks([])
    axis.spines[:].set_visible(True)
    return image
