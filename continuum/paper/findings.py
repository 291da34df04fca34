"""The finding of a sweep on a claim: a verdict with numbers; common bounds and counts of all claims."""

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pandas import DataFrame, Series

Word = Literal["reproduced", "reproduced with a remark", "not reproduced", "not tested"]

VISIBLE = 0.1
"""Smallest deviation visible in the paper's figures: a tenth is about the height of a symbol on axes of several
decades."""
OFF = 1.5
"""Factor by which a cloud of points may lie off a line that it is said to follow: the spread of Fig. 4."""
FEWEST = 3
"""Smallest number of surfaces for a verdict, as fewer have no scatter."""


class Finding(NamedTuple):
    """The finding of a sweep on a claim."""

    word: Word
    found: str
    """Numbers."""
    points: int
    """Number of points, all with A_rep >= 10 λ_s²."""


def verdict_word(good: bool | np.bool_, fair: bool | np.bool_ = False) -> Word:
    """The word of a verdict: reproduced if good, with a remark if fair, else not."""
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
    """The finding "not tested" for points of too few surfaces."""
    count = rows.surface.nunique()
    if not count:
        return Finding("not tested", "no points for it in this sweep", 0)
    return Finding("not tested", f"{count} of the {FEWEST} surfaces that a verdict needs", len(rows))


def bandwidth_means(rows: DataFrame, values: Series) -> Series:
    """Means at each bandwidth λ_L/λ_s with enough surfaces, or else over all."""
    groups = rows.assign(value=values).groupby((rows.lambda_L / rows.lambda_s).round(6))
    means: Series = groups["value"].mean()[groups["surface"].nunique() >= FEWEST]
    return means if len(means) else Series({np.nan: float(values.mean())})


def bandwidth_text(means: Series) -> str:
    """Means at each bandwidth as text, if there are several."""
    if len(means) < 2:
        return ""
    return "; " + ", ".join(f"λ_L/λ_s = {width:g}: {mean:.3g}" for width, mean in means.items())


def ratio_finding(
    rows: DataFrame, ratio: ArrayLike, says: str, spread: Callable[[ArrayLike], str] = spread_text
) -> Finding:
    """The verdict on ratios that should be 1, one for each row; non-finite ones are ignored."""
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
