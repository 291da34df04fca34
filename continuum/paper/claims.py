"""Each claim of the paper beside what a sweep has found: reproduced or not, with numbers and how many points."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pandas import DataFrame

from continuum.paper.points import alike
from continuum.paper.relations import largest_tension
from continuum.show.sheet import Sheet
from continuum.theory import paper, rough

Word = Literal["reproduced", "reproduced with a remark", "not reproduced", "not looked at"]

VISIBLE = 0.1
"""What the paper's figures can show: a tenth is about the height of a symbol on their axes of several decades."""
OFF = 1.5
"""Factor by which a whole cloud of points may lie off a line and still be said to follow it: the spread of Fig. 4."""


class Finding(NamedTuple):
    """What a sweep says of a claim."""

    word: Word
    found: str
    """Numbers."""
    points: int
    """How many it is judged by, all with A_rep >= 10 λ_s²."""


@dataclass(frozen=True)
class Claim:
    """A claim of the paper, and how the points of a sweep are held against it."""

    text: str
    """In the paper's words, or nearly."""
    paper: str
    """What the paper says in numbers, and where."""
    query: str
    """The points that it is judged by."""
    judge: Callable[[DataFrame], Finding | None]
    """From these points, one at least; None where they do not suffice."""
    bounds: str = (
        f"geometric mean within {VISIBLE:.0%}, scatter by less than {2 * VISIBLE:.0%}; mean within a factor of {OFF:g}"
    )
    """What counts as reproduced; and, after a semicolon, as reproduced with a remark."""

    def finding(self, points: DataFrame) -> Finding:
        rows = points.query(self.query)
        found = None if rows.empty else self.judge(rows)
        return found or Finding("not looked at", "no points for it in this sweep", 0)


def _word(good: bool | np.bool_, fair: bool | np.bool_ = False) -> Word:
    return "reproduced" if good else "reproduced with a remark" if fair else "not reproduced"


def _spread(values: ArrayLike) -> str:
    found = np.asarray(values)
    return f"{found.mean():.3g} ± {found.std():.2g} ({found.min():.3g} - {found.max():.3g})"


def _factor(ratio: ArrayLike) -> str:
    logs = np.log(np.asarray(ratio))
    return f"geometric mean {np.exp(logs.mean()):.3g}, scatter by a factor of {np.exp(logs.std()):.3g}"


def _equal(ratio: ArrayLike, says: str, spread: Callable[[ArrayLike], str] = _spread) -> Finding | None:
    """The verdict on ratios that should be 1; those that are not finite do not count."""
    values = np.asarray(ratio, dtype=float)
    values = values[np.isfinite(values)]
    if not values.size:
        return None
    logs = np.log(np.maximum(values, 1e-30))
    mean, scatter = abs(logs.mean()), logs.std()
    word = _word(mean < np.log(1 + VISIBLE) and scatter < 2 * VISIBLE, mean < np.log(OFF))
    return Finding(word, f"{says}: {spread(values)}", values.size)


def _kappa_rep(rows: DataFrame) -> Finding:
    inverse = 1 / rows.kappa_rep
    kappa = 1 / inverse.mean()
    parts = [f"1/κ_rep = {_spread(inverse)}, κ_rep = {kappa:.3g}"]
    parts += [f"λ_s = {size:g}: {1 / mean:.3g}" for size, mean in inverse.groupby(rows.lambda_s).mean().items()]
    return Finding(_word(abs(kappa - 2) < 0.2, 1.6 < kappa < 2.6), "; ".join(parts), len(rows))


def _long_paths(rows: DataFrame) -> list[DataFrame]:
    return [path for _, path in rows.groupby("system") if len(path) >= 3]


def _linear(rows: DataFrame) -> Finding | None:
    paths = _long_paths(rows)
    if not paths:
        return None
    found = np.array([np.polyfit(np.log(path.load), np.log(path.area_rep), 1)[0] for path in paths])
    word = _word(abs(found.mean() - 1) + found.std() < VISIBLE, abs(found.mean() - 1) < 2 * VISIBLE)
    text = f"exponent of A_rep ~ N^x below 10 % area, l_a <= 0.005: {_spread(found)}"
    return Finding(word, text, sum(map(len, paths)))


def _against_bare(rows: DataFrame, of: str, column: str, least: int = 2) -> Iterator[tuple[Any, float]]:
    """The valid points with adhesion, and what a column is without adhesion on the same surface.

    Parameters
    ----------
    of : column in which the path without adhesion is interpolated; NaN outside of it.
    least : points that this path must have.
    """
    rows = rows[np.isfinite(rows[column])].assign(surface=alike(rows, "wall.adhesion_length", "wall.range"))
    bare = {surface: path.sort_values(of) for surface, path in rows[rows.length == 0].groupby("surface")}
    for row in rows.query("valid and length > 0").itertuples():
        path = bare.get(row.surface, rows[:0])
        if len(path) >= least:
            yield row, np.interp(getattr(row, of), path[of], path[column], left=np.nan, right=np.nan)


def _pressure(rows: DataFrame) -> Finding | None:
    pairs = _against_bare(rows, "area_rep", "load_rep")
    return _equal([row.load_rep / bare for row, bare in pairs], "N_rep with adhesion over without, at one A_rep")


def _mean_gap(rows: DataFrame) -> Finding | None:
    pairs = _against_bare(rows, "load_rep", "mean_gap")
    found = np.array([(row.mean_gap - bare) / row.rms_height for row, bare in pairs if row.load > 0])
    found = found[np.isfinite(found)]
    if not found.size:
        return None
    text = f"difference of the mean gaps at one N_rep, in units of h_rms: {_spread(found)}"
    return Finding(_word(abs(found).max() < 0.05, abs(found).mean() < 2 * 0.05), text, found.size)


def _stiffness(rows: DataFrame) -> Finding | None:
    pairs = _against_bare(rows, "load_rep", "stiffness", least=3)
    ratio = [row.stiffness / bare / (row.kappa_rep / row.kappa) for row, bare in pairs if row.load > 0]
    return _equal(ratio, "k_N with adhesion over without, at one N_rep, over κ_rep/κ")


def _attraction(rows: DataFrame) -> Finding | None:
    ratio = rows.pressure_att * rows["range"] / rows.length
    found = _equal(ratio, "N_att over (w/Δr) A_att")
    parts = [f"; l_a = {length:g}: {mean:.3g}" for length, mean in ratio.groupby(rows.length).mean().items()]
    return found and found._replace(found=found.found + "".join(parts))


def _strip(rows: DataFrame) -> Finding | None:
    measured = zip(rows.rms_slope, rows.diameter, rows["range"], strict=True)
    width = [paper.attraction_width(*each) for each in measured]
    ratio = rows.area_att * rows.area / (rows.perimeter * width)
    return _equal(ratio, "A_att/(P d_att), d_att of Eq. (S-2) with the measured d_rep, where A_att < A_rep")


def _kappa_att(rows: DataFrame) -> Finding | None:
    if len(rows) < 3:
        return None
    decades = np.ptp(np.log10(rows.kappa_att.to_numpy()))
    says = f"measured over predicted 1/κ_att, over {decades:.2g} decades"
    return _equal(rows.expected_kappa_att / rows.kappa_att, says, _factor)


def _sticky(rows: DataFrame) -> Finding:
    pulls, texts, wrong = rows.load < 0, [], []
    for name, kappa_rep in (("κ_rep = 2", 2.0), ("κ_rep as measured", rows.kappa_rep)):
        says = 1 / rows.expected_kappa_att > 1 / kappa_rep
        wrong.append((says != pulls).sum())
        texts.append(
            f"with {name}: {(says & pulls).sum()} sticky and predicted, {(~says & ~pulls).sum()} neither, "
            f"{(pulls & ~says).sum()} sticky but not predicted, {(says & ~pulls).sum()} predicted only"
        )
    return Finding(_word(wrong[0] == 0, wrong[0] < 0.1 * len(rows)), "; ".join(texts), len(rows))


def _constant_diameter(rows: DataFrame) -> Finding | None:
    paths = _long_paths(rows)
    if not paths:
        return None
    found = np.array([path.diameter.max() / path.diameter.min() - 1 for path in paths])
    decades = np.mean([np.ptp(np.log10(path.area_rep.to_numpy())) for path in paths])
    text = f"largest over smallest d_rep of a path, less 1: {_spread(found)}; {decades:.2g} decades of area"
    word = _word(found.max() < 0.25, np.median(found) < 0.25) if decades > 0.5 else "not looked at"
    return Finding(word, text, sum(map(len, paths)))


def _diameter(rows: DataFrame) -> Finding:
    ratio = rows.diameter / rows.expected_diameter
    outside = ((ratio < 0.5) | (ratio > 2)).sum()
    text = f"d_rep h''/(4h'): {_spread(ratio)}; {outside} points outside"
    return Finding(_word(outside == 0, outside < 0.1 * len(ratio)), text, len(ratio))


def _asperity_theories(rows: DataFrame) -> Finding | None:
    pulling = largest_tension(rows).query("tension > 0")
    if pulling.empty:
        return None
    found = np.log10(pulling.tension / [max(rough.fuller_tabor(ratio), 1e-30) for ratio in pulling.ratio])
    text = f"log10 of N_max over Fuller and Tabor's, of systems that pull: {_spread(found)}"
    return Finding(_word(found.median() > 1, found.max() > 1), text, len(found))


def _roll_off(rows: DataFrame) -> Finding | None:
    spreads, scatters, rows = [], [], rows.assign(inverse=1 / rows.kappa)
    for _, group in rows.groupby(alike(rows, "surface.lambda_L", "surface.seed", "grid.n")):
        sizes = group.groupby("lambda_L").inverse
        if sizes.ngroups > 1:
            spreads.append(np.ptp(sizes.mean()))
            scatters.append(sizes.std(ddof=0).mean())
    if not spreads:
        return None
    text = f"1/κ changes by at most {max(spreads):.2g}; its scatter over surfaces is {np.mean(scatters):.2g}"
    return Finding(_word(max(spreads) < VISIBLE / 2, max(spreads) < 2 * max(scatters)), text, len(rows))


_ATTRACTED = "valid and area_att > 0 and approach"
_THIN = f"{_ATTRACTED} and area_att < area_rep"

CLAIMS = (
    Claim(
        "kappa_rep is close to 2 without adhesion", "2 (Eq. 1); Persson 1.6, asperities 2.6",
        "reference and length == 0", _kappa_rep,
        "within 0.2, half the way to the nearer rival; between the rivals",
    ),
    Claim(
        "area is linear in load at low load", "exponent 1 (Fig. 2)",
        "valid and approach and load > 0 and area_rep < 0.1 and length < 0.05", _linear,
        f"mean and scatter of exponents within {VISIBLE}, a decade with areas known to 25 %; within twice that",
    ),
    Claim("the repulsive pressure is unchanged by adhesion", "1 (Fig. 3)", "approach", _pressure),
    Claim(
        "mean gap against N_rep is unchanged by adhesion, where not sticky", "0: nearly unchanged",
        "approach", _mean_gap,
        "0.05 h_rms, which is 10 % of a load that falls by e in 0.5 h_rms; mean within twice that",
    ),
    Claim("N_att = (w/range) A_att", "1 (Fig. 3)", _ATTRACTED, _attraction),
    Claim("A_att is a strip of width d_att along the perimeter", "1 (Eq. S-2)", _THIN, _strip),
    Claim(
        "A_rep/A_att follows Eq. (4) where A_att < A_rep", "1 (Fig. 4)", _THIN,
        lambda rows: _equal(rows.area_rep / rows.area_att / rows.expected_ratio, "measured over predicted", _factor),
    ),
    Claim("1/kappa_att follows Eqs. (3) and (4)", "1 (Fig. 4)", "reference and area_att > 0", _kappa_att),
    Claim(
        "sticky if and only if 1/kappa_att of theory > 1/kappa_rep", "every surface of Fig. 4",
        "reference and length > 0", _sticky,
        "no exception with κ_rep = 2; one in ten",
    ),
    Claim(
        "d_rep changes by less than 25 % with area", "25 % over 2 - 3 decades (Fig. 3)",
        "valid and approach", _constant_diameter,
        "every path; half of them",
    ),
    Claim(
        "d_rep = 4h'/h'' within a factor of two", "0.5 - 2 (Fig. 3)",
        "valid and diameter > 0", _diameter, "every point; all but one in ten",
    ),
    Claim(
        "P d = pi A_rep where d > 10 a0", "1 (Fig. S-2)",
        "valid and chord > 10",
        lambda rows: _equal(rows.perimeter * rows.chord / (np.pi * rows.area_rep * rows.area), "P d/(π A_rep)"),
    ),
    Claim("the stiffness is lowered by kappa_rep/kappa, where not sticky", "1", "approach", _stiffness),
    Claim(
        "Greenwood-Williamson theories fall orders of magnitude below N_max", "orders of magnitude (Fig. S-3)",
        "valid", _asperity_theories, "half of the systems by more than one; any of them",
    ),
    Claim(
        "kappa does not depend on lambda_L", "not at all (Fig. 4)", "reference", _roll_off,
        f"1/κ changes by less than {VISIBLE / 2}, a tenth of 1/κ_rep = 1/2; by less than twice its scatter",
    ),
)  # fmt: skip


def claim_verdicts(points: DataFrame) -> list[tuple[Claim, Finding]]:
    """All claims that a sweep can judge; of the others it is said that they were not looked at."""
    return [(claim, claim.finding(points)) for claim in CLAIMS]


def verdict_sheet(found: list[tuple[Claim, Finding]]) -> Sheet:
    """The claims as a table."""
    columns = (
        "claim of the paper",
        "in the paper",
        "verdict",
        "found here",
        "points",
        "counts as reproduced; with a remark",
    )
    rows = [(claim.text, claim.paper, *finding, claim.bounds) for claim, finding in found]
    return Sheet.of("Claims of the paper", columns, rows)
