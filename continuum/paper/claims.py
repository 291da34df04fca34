"""Verdicts on the claims of the paper from the points of a sweep, with numbers and the number of points.

The rules use mean, scatter, trend with the bandwidth and number of contacts.  They date from 23 November 2026: before
the bandwidth sweep, but after the other sweeps in docs/measured, which were first judged by less strict rules:

* claims are judged by the worst bandwidth λ_L/λ_s instead of the mean over all, so that deviations of opposite sign do
  not cancel;
* *with a remark* also bounds the scatter, and for stickiness counts exceptions among contacts that stick or should;
* fewer than :data:`FEWEST` surfaces, or for stickiness fewer than :data:`FEWEST` contacts of either kind, are not a
  test; nor is a λ_L outside the paper's range.

Four claims were first judged on 24 November, by the bounds of all ratios or the paper's own number: the gap outside a
contact, other laws (whose data were known then), λ_Maugis above 1 and the range of the spline.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pandas import DataFrame, Series, read_csv

from continuum.paper.points import alike, chosen
from continuum.paper.relations import largest_tension
from continuum.store.sheet import Sheet
from continuum.theory import paper, rough

Word = Literal["reproduced", "reproduced with a remark", "not reproduced", "not tested"]

VISIBLE = 0.1
"""Smallest deviation visible in the paper's figures: a tenth is about the height of a symbol on axes of several
decades."""
OFF = 1.5
"""Factor by which a cloud of points may lie off a line that it is said to follow: the spread of Fig. 4."""
FEWEST = 3
"""Smallest number of surfaces for a verdict, as fewer have no scatter."""
LONG = 512.0
"""Smallest λ_L of the paper, in a0."""


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


@dataclass(frozen=True)
class Claim:
    """A claim of the paper, and its test on the points of a sweep."""

    text: str
    """The claim, nearly in the paper's words."""
    paper: str
    """Number and place in the paper."""
    query: str
    """Query for its points."""
    judge: Callable[[DataFrame], Finding | None]
    """The finding from at least one of these points; None if they do not suffice."""
    bounds: str = (
        f"geometric mean within {VISIBLE:.0%} at every bandwidth, scatter by less than {2 * VISIBLE:.0%}; "
        f"both within a factor of {OFF:g}"
    )
    """Bounds for reproduced and, after a semicolon, for reproduced with a remark."""

    def finding(self, points: DataFrame) -> Finding:
        rows = chosen(points, self.query)
        if rows.surface.nunique() < FEWEST:
            return too_few(rows)
        return self.judge(rows) or Finding("not tested", "no points for it in this sweep", 0)


def _kappa_rep(rows: DataFrame) -> Finding:
    inverse = 1 / rows.kappa_rep
    kappa = 1 / bandwidth_means(rows, inverse)
    text = f"1/κ_rep = {spread_text(inverse)}, κ_rep = {1 / inverse.mean():.3g}{bandwidth_text(kappa)}"
    parts = [f"; λ_s = {size:g}: {1 / mean:.3g}" for size, mean in inverse.groupby(rows.lambda_s).mean().items()]
    walls = inverse.groupby(rows.law).mean()
    parts += [f"; wall {law}: {1 / mean:.3g}" for law, mean in walls.items() if len(walls) > 1]
    return Finding(
        verdict_word((kappa - 2).abs().max() < 0.2, kappa.between(1.6, 2.6).all()), text + "".join(parts), len(rows)
    )


def _long_paths(rows: DataFrame) -> list[DataFrame]:
    return [path for _, path in rows.groupby("system") if len(path) >= 3]


def _linear(rows: DataFrame) -> Finding | None:
    paths = _long_paths(rows)
    if len(paths) < FEWEST:
        return None
    found = np.array([np.polyfit(np.log(path.load), np.log(path.area_rep), 1)[0] for path in paths])
    word = verdict_word(abs(found.mean() - 1) + found.std() < VISIBLE, abs(found.mean() - 1) < 2 * VISIBLE)
    text = f"exponent of A_rep ~ N^x below 10 % area, l_a <= 0.005: {spread_text(found)}"
    return Finding(word, text, sum(map(len, paths)))


def _over_bare(rows: DataFrame, of: str, column: str, least: int = 2) -> DataFrame:
    """The valid points with adhesion, with the value without adhesion on the same surface and law as column ``bare``.

    The path without adhesion, of so many points at ``least``, is interpolated in the column ``of``; points outside its
    range are left out.
    """
    rows = rows[np.isfinite(rows[column])].assign(law=rows.law.map(str))
    own = ["surface", "law"]
    bare = {which: path.sort_values(of) for which, path in rows[rows.length == 0].groupby(own)}
    found = chosen(rows, "valid and length > 0").assign(bare=np.nan)
    for which, path in found.groupby(own):
        known = bare.get(which, rows[:0])
        if len(known) >= least:
            values = np.interp(path[of], known[of], known[column], left=np.nan, right=np.nan)
            found.loc[path.index, "bare"] = values
    return found[np.isfinite(found.bare)]


def _pressure(rows: DataFrame) -> Finding:
    rows = _over_bare(rows, "area_rep", "load_rep")
    return ratio_finding(rows, rows.load_rep / rows.bare, "N_rep with adhesion over without, at one A_rep")


def _same_diameter(rows: DataFrame) -> Finding:
    rows = _over_bare(rows, "area_rep", "diameter")
    return ratio_finding(rows, rows.diameter / rows.bare, "d_rep with adhesion over without, at one A_rep")


def _mean_gap(rows: DataFrame) -> Finding:
    rows = chosen(_over_bare(rows, "load_rep", "mean_gap"), "load > 0")
    if rows.surface.nunique() < FEWEST:
        return too_few(rows)
    found = (rows.mean_gap - rows.bare) / rows.rms_height
    text = f"difference of the mean gaps at one N_rep, in units of h_rms: {spread_text(found)}"
    word = verdict_word(found.abs().max() < 0.05, abs(found.mean()) + found.std(ddof=0) < 2 * 0.05)
    return Finding(word, text, found.size)


def _stiffness(rows: DataFrame) -> Finding:
    rows = chosen(_over_bare(rows, "load_rep", "stiffness", least=3), "load > 0")
    ratio = rows.stiffness / rows.bare / (rows.kappa_rep / rows.kappa)
    return ratio_finding(rows, ratio, "k_N with adhesion over without, at one N_rep, over κ_rep/κ")


def _by_length(rows: DataFrame, ratio: Series, says: str) -> Finding:
    """The verdict on ratios that should be 1, which also says their mean at each adhesion length."""
    found = ratio_finding(rows, ratio, says)
    parts = [f"; l_a = {length:g}: {mean:.3g}" for length, mean in ratio.groupby(rows.length).mean().items()]
    return found._replace(found=found.found + "".join(parts))


def _attraction(rows: DataFrame) -> Finding:
    return _by_length(rows, rows.pressure_att * rows["range"] / rows.length, "N_att over (w/Δr) A_att")


def _strip(rows: DataFrame) -> Finding:
    measured = zip(rows.rms_slope, rows.diameter, rows["range"], strict=True)
    width = [paper.attraction_width(*each) for each in measured]
    ratio = rows.area_att * rows.area / (rows.perimeter * width)
    return ratio_finding(
        rows, ratio, "A_att/(P d_att), d_att of Eq. (S-2) with the measured d_rep, where A_att < A_rep"
    )


def _constant_ratio(rows: DataFrame) -> Finding | None:
    paths = _long_paths(rows)
    if len(paths) < FEWEST:
        return None
    ratio = [path.area_rep / path.area_att for path in paths]
    found = np.array([each.max() / each.min() - 1 for each in ratio])
    text = f"largest over smallest A_rep/A_att of a path, less 1: {spread_text(found)}"
    return Finding(verdict_word(found.max() < 0.25, np.median(found) < 0.25), text, sum(map(len, paths)))


def _kappa_att(rows: DataFrame) -> Finding:
    decades = np.ptp(np.log10(rows.kappa_att.to_numpy()))
    says = f"measured over predicted 1/κ_att, over {decades:.2g} decades"
    return ratio_finding(rows, rows.expected_kappa_att / rows.kappa_att, says, factor_text)


def _width(rows: DataFrame) -> Finding:
    measured = zip(rows.rms_slope, rows.diameter, rows["range"], strict=True)
    ratio = rows.width / [paper.attraction_width(*each) for each in measured]
    return _by_length(rows, ratio, "d_att where the mean gap is Δr, over Eq. (S-2) with the measured d_rep")


def _other_laws(rows: DataFrame) -> Finding | None:
    ratio = np.log(rows.expected_kappa_att / rows.kappa_att)
    name = rows.law.where(rows.law != "attraction-on-core", rows["shape"])
    groups = ratio.groupby(name)
    means = groups.mean()[rows.surface.groupby(name).nunique() >= FEWEST]
    if means.empty:
        return None
    worst, scatter = means.abs().max(), groups.std(ddof=0)[means.index].max()
    word = verdict_word(
        worst < np.log(1 + VISIBLE) and scatter < 2 * VISIBLE, worst < np.log(OFF) and scatter < np.log(OFF)
    )
    parts = [f"{law}: {np.exp(mean):.3g}" for law, mean in means.items()]
    text = f"measured over predicted 1/κ_att, geometric means of each law: {', '.join(parts)}; "
    return Finding(word, f"{text}scatter of a law by a factor of {np.exp(scatter):.3g} at most", len(rows))


def _maugis(rows: DataFrame) -> Finding:
    measured = zip(rows.diameter / (2 * rows.rms_slope), rows.length, rows["range"], strict=True)
    maugis = np.array([paper.maugis_parameter(*each) for each in measured])
    rows = rows[maugis > 1]
    if rows.surface.nunique() < FEWEST:
        return too_few(rows)
    says = f"measured over predicted 1/κ_att at λ_Maugis up to {maugis.max():.2g}"
    return ratio_finding(rows, rows.expected_kappa_att / rows.kappa_att, says, factor_text)


def _range_of_spline(rows: DataFrame) -> Finding:
    ratio = rows.effective_range / rows["range"]
    return Finding(
        verdict_word((ratio - 1).abs().max() < 0.06), f"Δr of Eq. (S-5) over it: {ratio.mean():.4f}", len(rows)
    )


def _sticky(rows: DataFrame) -> Finding:
    pulls, texts, counts = rows.load < 0, [], []
    for name, kappa_rep in (("κ_rep = 2", 2.0), ("κ_rep as measured", rows.kappa_rep)):
        says = 1 / rows.expected_kappa_att > 1 / kappa_rep
        counts.append((int((says != pulls).sum()), int((says | pulls).sum())))
        texts.append(
            f"with {name}: {(says & pulls).sum()} sticky and predicted, {(~says & ~pulls).sum()} neither, "
            f"{(pulls & ~says).sum()} sticky but not predicted{_sizes(rows[pulls & ~says])}, "
            f"{(says & ~pulls).sum()} predicted only{_sizes(rows[says & ~pulls])}"
        )
    wrong, sticky = counts[0]
    word = verdict_word(wrong == 0, wrong < 0.1 * sticky)
    if min(sticky, len(rows) - sticky) < FEWEST:
        word = "not tested"
    return Finding(word, "; ".join(texts), len(rows))


def _sizes(rows: DataFrame) -> str:
    """Number of these contacts at each λ_s, as text."""
    counts = rows.lambda_s.value_counts().sort_index()
    return f" (λ_s = {', '.join(f'{size:g}: {n}' for size, n in counts.items())})" if len(counts) else ""


def _constant_diameter(rows: DataFrame) -> Finding | None:
    paths = _long_paths(rows)
    if len(paths) < FEWEST:
        return None
    found = np.array([path.diameter.max() / path.diameter.min() - 1 for path in paths])
    decades = np.mean([np.ptp(np.log10(path.area_rep.to_numpy())) for path in paths])
    text = f"largest over smallest d_rep of a path, less 1: {spread_text(found)}; {decades:.2g} decades of area"
    word = verdict_word(found.max() < 0.25, np.median(found) < 0.25) if decades > 0.5 else "not tested"
    return Finding(word, text, sum(map(len, paths)))


def _diameter(rows: DataFrame) -> Finding:
    ratio = rows.diameter_ratio
    outside = ((ratio < 0.5) | (ratio > 2)).sum()
    text = f"d_rep h''/(4h'): {spread_text(ratio)}; {outside} points outside"
    return Finding(verdict_word(outside == 0, outside < 0.1 * len(ratio)), text, len(ratio))


def _asperity_theories(rows: DataFrame) -> Finding:
    found = largest_tension(rows)
    pulling, never = found.query("tension > 0"), found.query("tension <= 0")
    if len(pulling) < FEWEST:
        return Finding(
            "not tested", f"{len(pulling)} contacts pull, of {FEWEST} at least that a verdict needs", len(pulling)
        )
    over = np.log10(pulling.tension / [max(rough.fuller_tabor(ratio), 1e-30) for ratio in pulling.ratio])
    text = f"log10 of N_max over Fuller and Tabor's, of the {len(pulling)} systems of {len(found)} that pull: "
    text += spread_text(over)
    if len(never):
        most = max(rough.fuller_tabor(ratio) for ratio in never.ratio)
        text += f"; {len(never)} never pull on approach, where theirs is at most {most:.1g} N P_c"
    return Finding(verdict_word(over.min() > 1, over.median() > 1), text, len(found))


def _roll_off(rows: DataFrame) -> Finding | None:
    spreads, scatters, rows = [], [], rows.assign(inverse=1 / rows.kappa).query("lambda_L >= @LONG")
    for _, group in rows.groupby(alike(rows, "surface.lambda_L", "surface.seed", "grid.n")):
        sizes = group.groupby("lambda_L").inverse
        if sizes.ngroups > 1:
            spreads.append(np.ptp(sizes.mean()))
            scatters.append(sizes.std(ddof=0).mean())
    if not spreads:
        return Finding("not tested", f"fewer than two λ_L from {LONG:g} a0 on, where the paper looked", 0)
    text = f"1/κ changes by at most {max(spreads):.2g}; its scatter over surfaces is {np.mean(scatters):.2g}"
    return Finding(verdict_word(max(spreads) < VISIBLE / 2, max(spreads) < 2 * max(scatters)), text, len(rows))


_ATTRACTED = "valid and area_att > 0 and approach"
_THIN = f"{_ATTRACTED} and area_att < area_rep"

CLAIMS = (
    Claim(
        "kappa_rep is close to 2 without adhesion", "2 (Eq. 1); Persson 1.6, asperities 2.6",
        "reference and length == 0", _kappa_rep,
        "within 0.2, half the way to the nearer rival, at every bandwidth; between the rivals",
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
        "0.05 h_rms, which is 10 % of a load that falls by e in 0.5 h_rms; mean and scatter within twice that",
    ),
    Claim("N_att = (w/range) A_att", "1 (Fig. 3)", _ATTRACTED, _attraction),
    Claim("A_att is a strip of width d_att along the perimeter", "1 (Eq. S-2)", _THIN, _strip),
    Claim(
        "the gap outside a contact is that of Eq. (S-1), x^(3/2), where it reaches the range", "1 (Eqs. S-1, S-2)",
        "valid and width > 0", _width,
    ),
    Claim(
        "the range of Eq. (S-5) is that of the spline within 6 %", "6 % (Suppl. S-I)",
        "length > 0 and law == 'lennard-jones-spline'", _range_of_spline, "6 %",
    ),
    Claim(
        "A_rep/A_att follows Eq. (4) where A_att < A_rep", "1 (Fig. 4)", _THIN,
        lambda rows: ratio_finding(
            rows, rows.area_rep / rows.area_att / rows.expected_ratio, "measured over predicted", factor_text
        ),
    ),
    Claim(
        "A_rep/A_att does not change with load", "constant (Fig. 3)", f"{_THIN} and length < 0.05", _constant_ratio,
        "every path within 25 %, as d_rep; half of them",
    ),
    Claim("1/kappa_att follows Eqs. (3) and (4)", "1 (Fig. 4)", "reference and area_att > 0", _kappa_att),
    Claim(
        "other laws of the wall follow Eqs. (3) and (4) with the range of Eq. (S-5)", "consistent (Methods)",
        "reference and area_att > 0 and law != 'lennard-jones-spline'", _other_laws,
        f"geometric mean within {VISIBLE:.0%} for every law, scatter by less than {2 * VISIBLE:.0%}; both within a "
        f"factor of {OFF:g}",
    ),
    Claim(
        "Eqs. (3) and (4) hold even where lambda_Maugis exceeds 1", "1 (Suppl. S-I)", "reference and area_att > 0",
        _maugis,
    ),
    Claim(
        "sticky if and only if 1/kappa_att of theory > 1/kappa_rep", "every surface of Fig. 4",
        "reference and length > 0", _sticky,
        f"no exception with κ_rep = 2; one in ten of those that stick or should; {FEWEST} of either kind at least",
    ),
    Claim("d_rep is unchanged by adhesion", "1 (Fig. 3)", "approach and diameter > 0", _same_diameter),
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
        lambda rows: ratio_finding(rows, rows.disc_ratio, "P d/(π A_rep)"),
    ),
    Claim("the stiffness is lowered by kappa_rep/kappa, where not sticky", "1", "approach", _stiffness),
    Claim(
        "Greenwood-Williamson theories fall orders of magnitude below N_max", "orders of magnitude (Fig. S-3)",
        "valid", _asperity_theories, "every system that pulls by more than one; half of them",
    ),
    Claim(
        "kappa does not depend on lambda_L", "not at all (Fig. 4)", "reference", _roll_off,
        f"from {LONG:g} a0 on, 1/κ changes by less than {VISIBLE / 2}, a tenth of 1/κ_rep = 1/2; by less than twice "
        "its scatter",
    ),
)  # fmt: skip


_JUDGED = (
    "system", "surface", "hurst", "shape", "width", "effective_range", "lambda_s", "lambda_L", "seed", "law",
    "length", "area", "approach", "valid", "reference", "area_rep", "area_att", "load", "load_rep", "pressure_att",
    "kappa", "kappa_rep", "kappa_att", "mean_gap", "stiffness", "perimeter", "diameter", "chord", "rms_height",
    "rms_slope", "rms_curvature", "range", "work_of_adhesion", "expected_ratio", "expected_kappa_att",
    "diameter_ratio", "disc_ratio",
)  # fmt: skip
"""Columns that claims need, beside the keys on the axes of the sweep."""


def claim_points(points: DataFrame) -> str:
    """The columns of points that claims need, as comma-separated values, from which they can be judged again."""
    axes = [name for name in points if name.startswith("sweep.")]
    return str(points[[*_JUDGED, *axes]].to_csv(index=False, float_format="%.8g"))


def stored_points(path: Path) -> DataFrame:
    """Read such a table; columns that an older one lacks are NaN.  The slope that was asked for is the realised one."""
    points = read_csv(path)
    lacking = {name: np.nan for name in _JUDGED if name not in points}
    return points.assign(**lacking, slope=points.rms_slope.round(6))


def claim_verdicts(points: DataFrame) -> list[tuple[Claim, Finding]]:
    """Verdicts on all claims; those without points are "not tested"."""
    return [(claim, claim.finding(points)) for claim in CLAIMS]


def verdict_sheet(found: list[tuple[Claim, Finding]]) -> Sheet:
    """The claims as a table."""
    bounds = "counts as reproduced; with a remark"
    columns = ("claim of the paper", "in the paper", "verdict", "found here", "points", bounds)
    rows = [(claim.text, claim.paper, *finding, claim.bounds) for claim, finding in found]
    return Sheet.of("Claims of the paper", columns, rows)
