"""Each claim of the paper beside what a sweep has found: reproduced or not, with numbers and how many points."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pandas import DataFrame

from continuum.model.fourier import Real
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
    judge: Callable[[DataFrame], Finding | None]
    """None where the sweep has no point for it."""
    bounds: str = (
        f"geometric mean within {VISIBLE:.0%}, scatter by less than {2 * VISIBLE:.0%}; mean within a factor of {OFF:g}"
    )
    """What counts as reproduced; and, after a semicolon, as reproduced with a remark."""


class ClaimVerdict(NamedTuple):
    """A claim with what was found."""

    claim: Claim
    finding: Finding


def _word(good: bool | np.bool_, fair: bool | np.bool_ = False) -> Word:
    return "reproduced" if good else "reproduced with a remark" if fair else "not reproduced"


def _spread(values: ArrayLike) -> str:
    """Mean, standard deviation and range."""
    found = np.asarray(values)
    return f"{found.mean():.3g} ± {found.std():.2g} ({found.min():.3g} - {found.max():.3g})"


def _factor(ratio: ArrayLike) -> str:
    logs = np.log(np.asarray(ratio))
    return f"geometric mean {np.exp(logs.mean()):.3g}, scatter by a factor of {np.exp(logs.std()):.3g}"


def _one(ratio: ArrayLike, text: str) -> Finding | None:
    """The verdict on ratios that should be 1."""
    values = np.asarray(ratio, dtype=float)
    if not values.size:
        return None
    logs = np.log(np.maximum(values, 1e-30))
    mean, scatter = abs(logs.mean()), logs.std()
    return Finding(_word(mean < np.log(1 + VISIBLE) and scatter < 2 * VISIBLE, mean < np.log(OFF)), text, values.size)


def _by_ratio(
    query: str, ratio: str, text: str, spread: Callable[[ArrayLike], str] = _spread
) -> Callable[[DataFrame], Finding | None]:
    """A claim that an expression of the columns is 1 at the points that a query finds."""

    def judge(points: DataFrame) -> Finding | None:
        rows = points.query(query)
        return _one(found := rows.eval(ratio), f"{text}: {spread(found)}") if len(rows) else None

    return judge


def _kappa_rep(points: DataFrame) -> Finding | None:
    rows = points.query("reference and length == 0")
    if rows.empty:
        return None
    inverse = 1 / rows.kappa_rep
    kappa = 1 / inverse.mean()
    parts = [f"1/κ_rep = {_spread(inverse)}, κ_rep = {kappa:.3g}"]
    parts += [f"λ_s = {size:g}: {1 / mean:.3g}" for size, mean in inverse.groupby(rows.lambda_s).mean().items()]
    return Finding(_word(abs(kappa - 2) < 0.2, 1.6 < kappa < 2.6), "; ".join(parts), len(rows))


def _linear(points: DataFrame) -> Finding | None:
    rows = points.query("valid and approach and load > 0 and area_rep < 0.1 and length < 0.05")
    paths = [path for _, path in rows.groupby("system") if len(path) >= 3]
    if not paths:
        return None
    found = np.array([np.polyfit(np.log(path.load), np.log(path.area_rep), 1)[0] for path in paths])
    return Finding(
        _word(abs(found.mean() - 1) + found.std() < VISIBLE, abs(found.mean() - 1) < 2 * VISIBLE),
        f"exponent of A_rep ~ N^x below 10 % area, l_a <= 0.005: {_spread(found)}",
        sum(map(len, paths)),
    )


def _against_bare(points: DataFrame, query: str, of: str, column: str, least: int = 2) -> Iterator[tuple[Any, float]]:
    """The points with adhesion that a query finds, and what a column is without adhesion on the same surface.

    Parameters
    ----------
    of : column in which the path without adhesion is interpolated; NaN outside of it.
    least : points that this path must have.
    """
    points = points.assign(surface=alike(points, "wall.adhesion_length", "wall.range"))
    able = points[points.approach & np.isfinite(points[column])]
    bare = {surface: path.sort_values(of) for surface, path in able[able.length == 0].groupby("surface")}
    for row in able.query(f"valid and length > 0 and {query}").itertuples():
        path = bare.get(row.surface, able[:0])
        if len(path) >= least:
            at = np.interp(getattr(row, of), path[of], path[column], left=np.nan, right=np.nan)
            yield row, at


def _pressure(points: DataFrame) -> Finding | None:
    pairs = _against_bare(points, "length > 0", "area_rep", "load_rep")
    found = _finite([row.load_rep / bare for row, bare in pairs])
    return _one(found, f"N_rep with adhesion over without, at one A_rep: {_spread(found)}") if found.size else None


def _finite(values: list[float]) -> Real:
    return np.array([value for value in values if np.isfinite(value)])


def _mean_gap(points: DataFrame) -> Finding | None:
    pairs = _against_bare(points, "load > 0", "load_rep", "mean_gap")
    found = _finite([(row.mean_gap - bare) / row.rms_height for row, bare in pairs])
    if not found.size:
        return None
    text = f"difference of the mean gaps at one N_rep, in units of h_rms: {_spread(found)}"
    return Finding(_word(abs(found).max() < 0.05, abs(found).mean() < 2 * 0.05), text, found.size)


def _stiffness(points: DataFrame) -> Finding | None:
    pairs = _against_bare(points, "load > 0", "load_rep", "stiffness", least=3)
    found = _finite([row.stiffness / bare / (row.kappa_rep / row.kappa) for row, bare in pairs])
    text = "k_N with adhesion over without, at one N_rep, over κ_rep/κ"
    return _one(found, f"{text}: {_spread(found)}") if found.size else None


_ATTRACTED = "valid and area_att > 0 and approach"
_THIN = f"{_ATTRACTED} and area_att < area_rep"


def _attraction(points: DataFrame) -> Finding | None:
    rows = points.query(_ATTRACTED)
    if rows.empty:
        return None
    ratio = rows.pressure_att * rows["range"] / rows.length
    parts = [f"N_att over (w/Δr) A_att: {_spread(ratio)}"]
    parts += [f"l_a = {length:g}: {mean:.3g}" for length, mean in ratio.groupby(rows.length).mean().items()]
    return _one(ratio, "; ".join(parts))


def _strip(points: DataFrame) -> Finding | None:
    rows = points.query(_THIN)
    if rows.empty:
        return None
    measured = zip(rows.rms_slope, rows.diameter, rows["range"], strict=True)
    ratio = rows.area_att * rows.area / (rows.perimeter * [paper.attraction_width(*each) for each in measured])
    text = "A_att/(P d_att), d_att of Eq. (S-2) with the measured d_rep, where A_att < A_rep"
    return _one(ratio, f"{text}: {_spread(ratio)}")


def _kappa_att(points: DataFrame) -> Finding | None:
    rows = points.query("reference and area_att > 0")
    if len(rows) < 3:
        return None
    ratio = rows.expected_kappa_att / rows.kappa_att
    decades = np.ptp(np.log10(rows.kappa_att.to_numpy()))
    return _one(ratio, f"measured over predicted 1/κ_att, over {decades:.2g} decades: {_factor(ratio)}")


def _sticky(points: DataFrame) -> Finding | None:
    rows = points.query("reference and length > 0")
    if rows.empty:
        return None
    pulls, texts, wrong = rows.load < 0, [], []
    for name, kappa_rep in (("κ_rep = 2", 2.0), ("κ_rep as measured", rows.kappa_rep)):
        says = 1 / rows.expected_kappa_att > 1 / kappa_rep
        wrong.append((says != pulls).sum())
        texts.append(
            f"with {name}: {(says & pulls).sum()} sticky and predicted, {(~says & ~pulls).sum()} neither, "
            f"{(pulls & ~says).sum()} sticky but not predicted, {(says & ~pulls).sum()} predicted only"
        )
    return Finding(_word(wrong[0] == 0, wrong[0] < 0.1 * len(rows)), "; ".join(texts), len(rows))


def _constant_diameter(points: DataFrame) -> Finding | None:
    paths = [path for _, path in points[points.valid & points.approach].groupby("system") if len(path) >= 3]
    if not paths:
        return None
    found = np.array([path.diameter.max() / path.diameter.min() - 1 for path in paths])
    decades = np.mean([np.ptp(np.log10(path.area_rep.to_numpy())) for path in paths])
    text = f"largest over smallest d_rep of a path, less 1: {_spread(found)}; {decades:.2g} decades of area"
    word = _word(found.max() < 0.25, np.median(found) < 0.25) if decades > 0.5 else "not looked at"
    return Finding(word, text, sum(map(len, paths)))


def _diameter(points: DataFrame) -> Finding | None:
    ratio = points.query("valid and diameter > 0").eval("diameter / expected_diameter")
    if ratio.empty:
        return None
    outside = ((ratio < 0.5) | (ratio > 2)).sum()
    text = f"d_rep h''/(4h'): {_spread(ratio)}; {outside} points outside"
    return Finding(_word(outside == 0, outside < 0.1 * len(ratio)), text, len(ratio))


def _asperity_theories(points: DataFrame) -> Finding | None:
    pulling = largest_tension(points[points.valid]).query("tension > 0")
    if pulling.empty:
        return None
    found = np.log10(pulling.tension / [max(rough.fuller_tabor(ratio), 1e-30) for ratio in pulling.ratio])
    text = f"log10 of N_max over Fuller and Tabor's, of systems that pull: {_spread(found)}"
    return Finding(_word(found.median() > 1, found.max() > 1), text, len(found))


def _roll_off(points: DataFrame) -> Finding | None:
    rows = points[points.reference].assign(inverse=1 / points.kappa)
    if "sweep.surface.lambda_L" not in points or rows.empty:
        return None
    spreads, scatters = [], []
    for _, group in rows.groupby(alike(rows, "surface.lambda_L", "surface.seed", "grid.n")):
        sizes = group.groupby("lambda_L").inverse
        if sizes.ngroups > 1:
            spreads.append(np.ptp(sizes.mean()))
            scatters.append(sizes.std(ddof=0).mean())
    if not spreads:
        return None
    text = f"1/κ changes by at most {max(spreads):.2g}; its scatter over surfaces is {np.mean(scatters):.2g}"
    return Finding(_word(max(spreads) < VISIBLE / 2, max(spreads) < 2 * max(scatters)), text, len(rows))


CLAIMS = (
    Claim(
        "kappa_rep is close to 2 without adhesion", "2 (Eq. 1); Persson 1.6, asperities 2.6", _kappa_rep,
        "within 0.2, half the way to the nearer rival; between the rivals",
    ),
    Claim(
        "area is linear in load at low load", "exponent 1 (Fig. 2)", _linear,
        f"mean and scatter of exponents within {VISIBLE}, a decade with areas known to 25 %; within twice that",
    ),
    Claim("the repulsive pressure is unchanged by adhesion", "1 (Fig. 3)", _pressure),
    Claim(
        "mean gap against N_rep is unchanged by adhesion, where not sticky", "0: nearly unchanged", _mean_gap,
        "0.05 h_rms, which is 10 % of a load that falls by e in 0.5 h_rms; mean within twice that",
    ),
    Claim("N_att = (w/range) A_att", "1 (Fig. 3)", _attraction),
    Claim("A_att is a strip of width d_att along the perimeter", "1 (Eq. S-2)", _strip),
    Claim(
        "A_rep/A_att follows Eq. (4) where A_att < A_rep", "1 (Fig. 4)",
        _by_ratio(_THIN, "area_rep / area_att / expected_ratio", "measured over predicted", _factor),
    ),
    Claim("1/kappa_att follows Eqs. (3) and (4)", "1 (Fig. 4)", _kappa_att),
    Claim(
        "sticky if and only if 1/kappa_att of theory > 1/kappa_rep", "every surface of Fig. 4", _sticky,
        "no exception with κ_rep = 2; one in ten",
    ),
    Claim(
        "d_rep changes by less than 25 % with area", "25 % over 2 - 3 decades (Fig. 3)", _constant_diameter,
        "every path; half of them",
    ),
    Claim(
        "d_rep = 4h'/h'' within a factor of two", "0.5 - 2 (Fig. 3)", _diameter, "every point; all but one in ten",
    ),
    Claim(
        "P d = pi A_rep where d > 10 a0", "1 (Fig. S-2)",
        _by_ratio("valid and chord > 10", f"perimeter * chord / ({np.pi} * area_rep * area)", "P d/(π A_rep)"),
    ),
    Claim("the stiffness is lowered by kappa_rep/kappa, where not sticky", "1", _stiffness),
    Claim(
        "Greenwood-Williamson theories fall orders of magnitude below N_max", "orders of magnitude (Fig. S-3)",
        _asperity_theories, "half of the systems by more than one; any of them",
    ),
    Claim(
        "kappa does not depend on lambda_L", "not at all (Fig. 4)", _roll_off,
        f"1/κ changes by less than {VISIBLE / 2}, a tenth of 1/κ_rep = 1/2; by less than twice its scatter",
    ),
)  # fmt: skip


def claim_verdicts(points: DataFrame) -> list[ClaimVerdict]:
    """All claims that a sweep can judge; of the others it is said that they were not looked at."""
    nothing = Finding("not looked at", "no points for it in this sweep", 0)
    return [ClaimVerdict(claim, claim.judge(points) or nothing) for claim in CLAIMS]


def verdict_sheet(found: list[ClaimVerdict]) -> Sheet:
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
