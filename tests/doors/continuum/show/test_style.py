"""Figures look the same to whoever draws them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest

from continuum.show import plot

WORDS = ("serif", "#123456", "right", "center", "none", "out", "stix", "bottom", "x", "bold", "magma", "line", "log")
"""Values of settings that are texts, of which one is likely to be allowed and not the default."""


def changed(value: Any) -> list[Any]:
    """Other values that a setting of this value may have."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int | float):
        return [1.3 * value + 0.1, 0.5, 2, True]
    if isinstance(value, list):
        return [["serif"], [1, 2], [], *WORDS]
    return [*WORDS, 0.7, True]


def foreign() -> dict[str, Any]:
    """A user's settings, each of which differs from matplotlib's own, but for those of windows."""
    found = {}
    with mpl.rc_context():
        for key, value in mpl.rcParamsDefault.items():
            if key.startswith(("backend", "toolbar", "interactive")):
                continue
            for other in changed(value):
                with suppress(ValueError, TypeError):
                    mpl.rcParams[key] = other
                    if mpl.rcParams[key] != value:
                        found[key] = other
                        break
    return found


@plot.styled
def picture() -> Any:
    figure, (left, right) = plot.new_axes(plot.COLUMN, 2.0, columns=2)
    left.loglog([1, 10, 100], [1e-3, 2, -3], "o-", label="a line")
    left.set(xlabel="x", ylabel=r"$\kappa_\mathrm{rep}$")
    left.text(1, 1, "-1 %")
    plot.log_ticks(left)
    plot.contact_image(right, np.arange(12).reshape(3, 4) % 3, (3, 4))
    plot.letter_panels([left, right], ["one", "other"])
    plot.legend_below(figure, plot.labelled(left), plot.contact_key())
    return figure


@pytest.mark.filterwarnings("ignore")
def test_no_setting_of_the_user_changes_a_figure(blank_pictures: Callable[..., bytes]) -> None:
    """By a matplotlibrc, or by a style that is in use: as LaTeX, which may not be there."""
    draw = blank_pictures
    own = draw(picture())
    users = foreign()
    assert len(users) > 280
    assert users["text.usetex"]
    with mpl.rc_context(users):
        assert draw(picture()) == own
