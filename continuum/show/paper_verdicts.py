"""Each claim of the paper beside what a sweep has found: reproduced or not, with numbers and how many points."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from continuum.model.grid import Real
from continuum.show.paper_points import Points
from continuum.show.sheet import Sheet
from continuum.theory import paper, rough

__all__ = ["Verdict", "verdict_sheet", "verdicts"]

Word = Literal["reproduced", "reproduced with a remark", "not reproduced", "not looked at"]
Rows = NDArray[np.int64]
_Found = tuple[Word, str, int]
"""Verdict, numbers, how many points."""


@dataclass(frozen=True)
class Verdict:
    """One claim."""

    claim: str
    """In the paper's words, or nearly."""
    word: Word
    found: str
    """What the sweep has, with numbers."""
    points: int
    """That it is judged by, all with A_rep >= 10 λ_s²."""


def verdicts(points: Points) -> list[Verdict]:
    """All claims that a sweep can judge; of the others it is said that they were not looked at."""
    judges: tuple[tuple[str, Callable[[Points], _Found | None]], ...] = (
        ("kappa_rep is close to 2 without adhesion", _kappa_rep),
        ("area is linear in load at low load", _linear),
        ("the repulsive pressure is unchanged by adhesion", _pressure),
        ("mean gap against N_rep is unchanged by adhesion, where not sticky", _mean_gap),
        ("N_att = (w/range) A_att", _attraction),
        ("A_att is a strip of width d_att along the perimeter", _strip),
        ("A_rep/A_att follows Eq. (4) where A_att < A_rep", _ratio),
        ("1/kappa_att follows Eqs. (3) and (4)", _kappa_att),
        ("sticky if and only if 1/kappa_att of theory > 1/kappa_rep", _sticky),
        ("d_rep changes by less than 25 % with area", _constant),
        ("d_rep = 4h'/h'' within a factor of two", _diameter),
        ("P d = pi A_rep where d > 10 a0", _perimeter),
        ("the stiffness is lowered by kappa_rep/kappa, where not sticky", _stiffness),
        ("Greenwood-Williamson theories fall orders of magnitude below N_max", _asperities),
        ("kappa does not depend on lambda_L", _roll_off),
    )
    found = ((claim, judge(points)) for claim, judge in judges)
    nothing: _Found = ("not looked at", "no points for it in this sweep", 0)
    return [Verdict(claim, *(one or nothing)) for claim, one in found]


def verdict_sheet(found: list[Verdict]) -> Sheet:
    """The claims as a table."""
    columns = ("claim of the paper", "verdict", "found here", "points")
    return Sheet.of("Claims of the paper", columns, [(v.claim, v.word, v.found, v.points) for v in found])


def _word(good: bool, fair: bool = False) -> Word:
    return "reproduced" if good else "reproduced with a remark" if fair else "not reproduced"


def _spread(values: Real) -> str:
    """Mean, standard deviation and range."""
    return f"{values.mean():.3g} ± {values.std():.2g} ({values.min():.3g} - {values.max():.3g})"


def _factor(logs: Real) -> str:
    """Of logarithms of ratios."""
    return f"geometric mean {np.exp(logs.mean()):.3g}, scatter by a factor of {np.exp(logs.std()):.3g}"


def _bare(points: Points) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = points.length == 0
    return found


def _not_sticky(points: Points) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = (points["load"] > 0) & (points.length > 0)
    return found


def _kappa_rep(points: Points) -> _Found | None:
    rows = np.flatnonzero(points.reference & _bare(points))
    if not rows.size:
        return None
    inverse = 1 / points["kappa_rep"][rows]
    parts = [f"1/κ_rep = {_spread(inverse)}, κ_rep = {1 / inverse.mean():.3g}"]
    for size in sorted(set(points.lambda_s[rows])):
        parts.append(f"λ_s = {size:g}: {1 / inverse[points.lambda_s[rows] == size].mean():.3g}")
    kappa = 1 / inverse.mean()
    return (_word(abs(kappa - 2) < 0.2, 1.6 < kappa < 3.2), "; ".join(parts), rows.size)


def _linear(points: Points) -> _Found | None:
    exponents, count = [], 0
    for path in points.paths():
        rows = path[points.valid[path] & (points["retracting"][path] == 0) & (points["load"][path] > 0)]
        rows = rows[points["area_rep"][rows] < 0.1]
        if rows.size >= 3 and points.length[rows[0]] < 0.05:
            exponents.append(np.polyfit(np.log(points["load"][rows]), np.log(points["area_rep"][rows]), 1)[0])
            count += rows.size
    if not exponents:
        return None
    found = np.array(exponents)
    return (
        _word(abs(found - 1).max() < 0.1, abs(found.mean() - 1) < 0.15),
        f"exponent of A_rep ~ N^x below 10 % area, l_a <= 0.005: {_spread(found)}",
        count,
    )


def _paired(points: Points, rows: Rows) -> Iterator[tuple[int, Rows]]:
    """Points with adhesion, each with the valid points of the same surface without."""
    bare = np.flatnonzero(_bare(points) & (points["retracting"] == 0))
    of: dict[tuple[object, ...], list[int]] = {}
    for row in bare.tolist():
        of.setdefault(points.surface(row, "wall.adhesion_length", "wall.range"), []).append(row)
    for row in rows.tolist():
        other = of.get(points.surface(row, "wall.adhesion_length", "wall.range"), [])
        if len(other) >= 2:
            yield row, np.array(other)


def _at(points: Points, column: str, others: Rows, of: str, value: float) -> float:
    """A column of the path without adhesion where another one has a value; NaN outside of it."""
    x, y = points[of][others], points[column][others]
    order = np.argsort(x)
    return float(np.interp(value, x[order], y[order], left=np.nan, right=np.nan))


def _pressure(points: Points) -> _Found | None:
    rows = np.flatnonzero(points.valid & (points.length > 0) & (points["retracting"] == 0))
    pairs = [
        points["load_rep"][row] / _at(points, "load_rep", others, "area_rep", float(points["area_rep"][row]))
        for row, others in _paired(points, rows)
    ]
    found = np.array(pairs)
    found = found[np.isfinite(found)]
    if not found.size:
        return None
    return (
        _word(abs(found - 1).max() < 0.1, abs(found.mean() - 1) < 0.1),
        f"N_rep with adhesion over without, at one A_rep: {_spread(found)}",
        found.size,
    )


def _mean_gap(points: Points) -> _Found | None:
    rows = np.flatnonzero(points.valid & _not_sticky(points) & (points["retracting"] == 0))
    found = np.array(
        [
            (points["mean_gap"][row] - _at(points, "mean_gap", others, "load_rep", float(points["load_rep"][row])))
            / points["rms_height"][row]
            for row, others in _paired(points, rows)
        ]
    )
    found = found[np.isfinite(found)]
    if not found.size:
        return None
    text = f"difference of the mean gaps at one N_rep, in units of h_rms: {_spread(found)}"
    return (_word(abs(found).max() < 0.05, abs(found).mean() < 0.1), text, found.size)


def _attracted(points: Points) -> Rows:
    found: Rows = np.flatnonzero(points.valid & (points["area_att"] > 0) & (points["retracting"] == 0))
    return found


def _attraction(points: Points) -> _Found | None:
    rows = _attracted(points)
    if not rows.size:
        return None
    ratio = points["pressure_att"][rows] * points["range"][rows] / points.length[rows]
    parts = [f"N_att over (w/Δr) A_att: {_spread(ratio)}"]
    for length in sorted(set(points.length[rows])):
        parts.append(f"l_a = {length:g}: {ratio[points.length[rows] == length].mean():.3g}")
    return (_word(abs(ratio - 1).max() < 0.15, abs(ratio.mean() - 1) < 0.2), "; ".join(parts), rows.size)


def _thin(points: Points) -> Rows:
    rows = _attracted(points)
    return rows[points["area_att"][rows] < points["area_rep"][rows]]


def _strip(points: Points) -> _Found | None:
    rows = _thin(points)
    if not rows.size:
        return None
    columns = zip(points["rms_slope"][rows], points["diameter"][rows], points["range"][rows], strict=True)
    width = np.array([paper.attraction_width(*each) for each in columns])
    ratio = points["area_att"][rows] * points.area[rows] / (points["perimeter"][rows] * width)
    text = f"A_att/(P d_att), d_att of Eq. (S-2) with the measured d_rep, where A_att < A_rep: {_spread(ratio)}"
    return (_word(abs(ratio - 1).max() < 0.3, 0.7 < ratio.mean() < 1.4), text, rows.size)


def _ratio(points: Points) -> _Found | None:
    rows = _thin(points)
    if not rows.size:
        return None
    logs = np.log(points["area_rep"][rows] / points["area_att"][rows] / points.area_ratio[rows])
    text = f"measured over predicted: {_factor(logs)}"
    return (_word(abs(logs.mean()) < 0.15 and logs.std() < 0.2, abs(logs.mean()) < 0.5), text, rows.size)


def _kappa_att(points: Points) -> _Found | None:
    rows = np.flatnonzero(points.reference & (points["area_att"] > 0))
    if rows.size < 3:
        return None
    logs = np.log(points.kappa_att[rows] / points["kappa_att"][rows])
    decades = np.ptp(np.log10(points["kappa_att"][rows]))
    text = f"measured over predicted 1/κ_att, over {decades:.2g} decades: {_factor(logs)}"
    return (_word(abs(logs.mean()) < 0.15 and logs.std() < 0.2, abs(logs.mean()) < 0.5), text, rows.size)


def _sticky(points: Points) -> _Found | None:
    rows = np.flatnonzero(points.reference & (points.length > 0))
    if not rows.size:
        return None
    pulls, counts = points["load"][rows] < 0, []
    for name, kappa_rep in (("κ_rep = 2", np.full(rows.size, 2.0)), ("κ_rep as measured", points["kappa_rep"][rows])):
        says = 1 / points.kappa_att[rows] > 1 / kappa_rep
        counts.append(
            (
                int((says != pulls).sum()),
                f"with {name}: {int((says & pulls).sum())} sticky and predicted, "
                f"{int((~says & ~pulls).sum())} neither, {int((pulls & ~says).sum())} sticky but not predicted, "
                f"{int((says & ~pulls).sum())} predicted only",
            )
        )
    wrong = counts[0][0]
    return (_word(wrong == 0, wrong < 0.15 * rows.size), "; ".join(text for _, text in counts), rows.size)


def _constant(points: Points) -> _Found | None:
    changes, decades, count = [], [], 0
    for path in points.paths():
        rows = path[points.valid[path] & (points["retracting"][path] == 0)]
        if rows.size >= 3:
            d = points["diameter"][rows]
            changes.append(d.max() / d.min() - 1)
            decades.append(np.ptp(np.log10(points["area_rep"][rows])))
            count += rows.size
    if not changes:
        return None
    found = np.array(changes)
    text = f"largest over smallest d_rep of a path, less 1: {_spread(found)}; {np.mean(decades):.2g} decades of area"
    word = _word(found.max() < 0.25, np.median(found) < 0.25) if np.mean(decades) > 0.5 else "not looked at"
    return (word, text, count)


def _diameter(points: Points) -> _Found | None:
    rows = np.flatnonzero(points.valid & (points["diameter"] > 0))
    if not rows.size:
        return None
    ratio = points["diameter"][rows] / points.diameter[rows]
    outside = int(((ratio < 0.5) | (ratio > 2)).sum())
    return (
        _word(outside == 0, outside < 0.1 * rows.size),
        f"d_rep h''/(4h'): {_spread(ratio)}; {outside} points outside",
        rows.size,
    )


def _perimeter(points: Points) -> _Found | None:
    rows = np.flatnonzero(points.valid & (points["chord"] > 10))
    if not rows.size:
        return None
    ratio = points["perimeter"][rows] * points["chord"][rows] / (np.pi * points["area_rep"][rows] * points.area[rows])
    return (
        _word(abs(ratio - 1).max() < 0.1, abs(ratio.mean() - 1) < 0.1),
        f"P d/(π A_rep): {_spread(ratio)}",
        rows.size,
    )


def _stiffness(points: Points) -> _Found | None:
    rows = np.flatnonzero(
        points.valid & _not_sticky(points) & (points["retracting"] == 0) & np.isfinite(points["stiffness"])
    )
    found, expected = [], []
    for row, others in _paired(points, rows):
        others = others[np.isfinite(points["stiffness"][others])]
        if others.size >= 3:
            bare = _at(points, "stiffness", others, "load_rep", float(points["load_rep"][row]))
            found.append(points["stiffness"][row] / bare)
            expected.append(points["kappa_rep"][row] / points["kappa"][row])
    ratio = np.array(found) / np.array(expected) if found else np.empty(0)
    ratio = ratio[np.isfinite(ratio)]
    if not ratio.size:
        return None
    text = f"k_N with adhesion over without, at one N_rep, over κ_rep/κ: {_spread(ratio)}"
    return (_word(abs(ratio - 1).max() < 0.15, abs(np.median(ratio) - 1) < 0.15), text, ratio.size)


def _asperities(points: Points) -> _Found | None:
    logs = []
    for path in points.paths():
        path = path[(points["retracting"][path] == 0) & points.valid[path]]
        if path.size and points["load"][path].min() < 0:
            row = path[np.argmin(points["load"][path])]
            w, height = points.length[row], points["rms_height"][row]
            reach = 0.75 * (np.pi**2 * w**2 * 2 / points["rms_curvature"][row]) ** (1 / 3)
            theory = max(rough.fuller_tabor(height / reach), 1e-30)
            logs.append(np.log10(-points["load"][row] / rough.asperity_limit(w, height) / theory))
    if not logs:
        return None
    found = np.array(logs)
    text = f"log10 of N_max over Fuller and Tabor's, of systems that pull: {_spread(found)}"
    return (_word(np.median(found) > 1, found.max() > 1), text, found.size)


def _roll_off(points: Points) -> _Found | None:
    axes = [key for axis in points.table.listed.axes for key in axis.keys]
    rows = np.flatnonzero(points.reference)
    if "surface.lambda_L" not in axes or not rows.size:
        return None
    spreads, scatters = [], []
    for group in points.groups(rows, "surface.lambda_L", "surface.seed", "grid.n"):
        inverse, sizes = 1 / points["kappa"][group], points["surface.lambda_L"][group]
        means = [inverse[sizes == size].mean() for size in sorted(set(sizes))]
        if len(means) > 1:
            spreads.append(np.ptp(means))
            scatters.append(np.mean([inverse[sizes == size].std() for size in set(sizes)]))
    if not spreads:
        return None
    text = f"1/κ changes by at most {max(spreads):.2g}; its scatter over surfaces is {np.mean(scatters):.2g}"
    return (
        _word(max(spreads) < 0.05, max(spreads) < 2 * max(scatters)),
        text,
        rows.size,
    )
