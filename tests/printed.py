"""What matplotlib drew of a figure, measured: width, sizes of letters, and whether anything is on top of anything."""

from __future__ import annotations

from itertools import combinations
from string import ascii_uppercase
from unittest.mock import patch

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

WIDTHS = (8.7, 17.8)
"""Of a column and of a page, in cm."""
SMALLEST, LARGEST = 6.5, 9.0
"""Points."""
_SLACK = 0.5
"""Pixels by which the box of a text exceeds its letters."""


def faults_in_print(figure: Figure) -> list[str]:
    """What is wrong with a figure as it would be printed; empty if nothing is."""
    width = figure.get_figwidth() * 2.54
    faults = [] if any(abs(width - one) < 0.01 for one in WIDTHS) else [f"{width:.2f} cm wide"]
    texts = _texts(figure)
    faults += [
        f"{text.get_text()!r}: {text.get_fontsize():g} pt"
        for text, _ in texts
        if not SMALLEST <= text.get_fontsize() <= LARGEST
    ]
    faults += [f"{text.get_text()!r}: outside" for text, box in texts if not _holds(figure.bbox, box)]
    faults += [
        f"{one.get_text()!r} on {other.get_text()!r}"
        for (one, first), (other, second) in combinations(texts, 2)
        if _overlap(first, second)
    ]
    panels = [axis for axis in figure.axes if axis.get_subplotspec() is not None and not _twin(axis, figure)]
    panels = panels if len(panels) > 1 else []
    faults += [
        f"panel {letter} is not lettered"
        for letter, axis in zip(ascii_uppercase, panels, strict=False)
        if not axis.get_title(loc="left").startswith(rf"$\mathbf{{{letter}}}$")
    ]
    legends = [*figure.legends, *(axis.get_legend() for axis in figure.axes)]
    faults += [
        f"a legend on panel {i}"
        for legend in legends
        for i, axis in enumerate(figure.axes)
        if legend is not None and _overlap(legend.get_window_extent(), axis.get_window_extent())
    ]
    labels = [text.get_text() for legend in figure.legends for text in legend.get_texts() if text.get_text().strip()]
    faults += [f"{label!r} is explained twice" for label in sorted(set(labels)) if labels.count(label) > 1]
    return faults


def _texts(figure: Figure) -> list[tuple[Text, Bbox]]:
    """The texts that are really drawn, with the boxes of their letters."""
    drawn: dict[int, Text] = {}
    draw = Text.draw

    def noted(self: Text, renderer: object, *args: object, **kwargs: object) -> None:
        if self.get_visible() and self.get_text().strip():
            drawn[id(self)] = self
        draw(self, renderer, *args, **kwargs)

    with patch.object(Text, "draw", noted):
        figure.canvas.draw()
    # The box of an annotation would have its arrow in it.
    return [(text, Text.get_window_extent(text)) for text in drawn.values()]


def _twin(axis: Axes, figure: Figure) -> bool:
    """Whether it lies on an axis that came before it."""
    before = figure.axes[: figure.axes.index(axis)]
    return any(axis.get_subplotspec() == other.get_subplotspec() for other in before)


def _overlap(one: Bbox, other: Bbox) -> bool:
    common = Bbox.intersection(one, other)
    return common is not None and min(common.width, common.height) > 2 * _SLACK


def _holds(frame: Bbox, box: Bbox) -> bool:
    return (
        box.x0 > frame.x0 - _SLACK
        and box.y0 > frame.y0 - _SLACK
        and box.x1 < frame.x1 + _SLACK
        and box.y1 < frame.y1 + _SLACK
    )
