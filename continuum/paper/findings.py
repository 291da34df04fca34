"""What a sweep says of a claim: a word and the numbers behind it; bounds and counts that all claims have in common."""

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pandas import DataFrame, Series

Word = Literal["reproduced", "reproduced with a remark", "not reproduced", "not tested"]

VISIBLE = 0.1
"""What the paper's figures can show: a tenth is about the height of a symbol on their axes of several decades."""
OFF = 1.5
"""Factor by which a whole cloud of points may lie off a line and still be said to follow it: the spread of Fig. 4."""
FEWEST = 3
"""Surfaces that a verdict needs: of fewer, no scatter is known."""


class Finding(NamedTuple):
    """What a sweep says of a claim."""

    word: Word
    found: str
    """Numbers."""
    points: int
    """How many it is judged by, all with A_rep >= 10 λ_s²."""


def verdict_word(good: bool | np.bool_, fair: bool | np.bool_ = False) -> Word:
    """Reproduced if good, with a remark if at least fair, else not."""
    return "reproduced" if good else "reproduced with a remark" if fair else "not reproduced"


def spread_text(values: ArrayLike) -> str:
    """Mean, standard deviation and range, in words."""
    found = np.asarray(values)
    return f"{found.mean():.3g} ± {found.std():.2g} ({found.min():.3g} - {found.max():.3g})"


def factor_text(ratio: ArrayLike) -> str:
    """Geometric mean and scatter of ratios, in words."""
    logs = np.log(np.asarray(ratio))
    return f"geometric mean {np.exp(logs.mean()):.3g}, scatter by a factor of {np.exp(logs.std()):.3g}"


def too_few(rows: DataFrame) -> Finding:
    """Not tested, as these points are of too few surfaces."""
    count = rows.surface.nunique()
    if not count:
        return Finding("not tested", "no points for it in this sweep", 0)
    return Finding("not tested", f"{count} of the {FEWEST} surfaces that a verdict needs", len(rows))


def bandwidth_means(rows: DataFrame, values: Series) -> Series:
    """Means of values at each bandwidth λ_L/λ_s that has enough surfaces, else of all of them."""
    groups = rows.assign(value=values).groupby((rows.lambda_L / rows.lambda_s).round(6))
    means: Series = groups["value"].mean()[groups["surface"].nunique() >= FEWEST]
    return means if len(means) else Series({np.nan: float(values.mean())})


def bandwidth_text(means: Series) -> str:
    """Means at each bandwidth, where there are several."""
    if len(means) < 2:
        return ""
    return "; " + ", ".join(f"λ_L/λ_s = {width:g}: {mean:.3g}" for width, mean in means.items())


def ratio_finding(
    rows: DataFrame, ratio: ArrayLike, says: str, spread: Callable[[ArrayLike], str] = spread_text
) -> Finding:
    """The verdict on ratios that should be 1, one for each row; those that are not finite do not count."""
    rows = rows.assign(ratio=np.asarray(ratio, dtype=float))
    rows = rows[np.isfinite(rows.ratio)]
    if rows.surface.nunique() < FEWEST:
        return too_few(rows)
    logs = np.log(np.maximum(rows.ratio, 1e-30))
    means, scatter = bandwidth_means(rows, logs), float(np.std(logs))
    worst = float(means.abs().max())
    word = verdict_word(
        worst < np.log(1 + VISIBLE) and scatter < 2 * VISIBLE, worst < np.log(OFF) and scatter < np.log(OFF)
    )
    return Finding(word, f"{says}: {spread(rows.ratio)}{bandwidth_text(np.exp(means))}", len(rows))
