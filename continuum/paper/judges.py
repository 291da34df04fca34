"""How each claim of the paper is judged from the points of a sweep: a word, numbers, and how many points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from continuum.model.fourier import Real
from continuum.paper.points import Points
from continuum.theory import paper, rough

Word = Literal["reproduced", "reproduced with a remark", "not reproduced", "not looked at"]
Rows = NDArray[np.int64]
Judged = tuple[Word, str, int]
"""Verdict, numbers, how many points."""


VISIBLE = 0.1
"""What the paper's figures can show: a tenth is about the height of a symbol on their axes of several decades."""
OFF = 1.5
"""Factor by which a whole cloud of points may lie off a line and still be said to follow it: the spread of Fig. 4."""


def _word(good: bool | np.bool_, fair: bool | np.bool_ = False) -> Word:
    return "reproduced" if good else "reproduced with a remark" if fair else "not reproduced"


def _equal(ratio: Real) -> Word:
    """The verdict on ratios that should be 1."""
    logs = np.log(np.maximum(ratio, 1e-30))
    mean, scatter = abs(logs.mean()), logs.std()
    return _word(mean < np.log(1 + VISIBLE) and scatter < 2 * VISIBLE, mean < np.log(OFF))


def _spread(values: Real) -> str:
    """Mean, standard deviation and range."""
    return f"{values.mean():.3g} ± {values.std():.2g} ({values.min():.3g} - {values.max():.3g})"


def _factor(logs: Real) -> str:
    return f"geometric mean {np.exp(logs.mean()):.3g}, scatter by a factor of {np.exp(logs.std()):.3g}"


def _bare(points: Points) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = points.length == 0
    return found


def _not_sticky(points: Points) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = (points["load"] > 0) & (points.length > 0)
    return found


def kappa_rep(points: Points) -> Judged | None:
    """1/κ_rep of the surfaces without adhesion, Eq. (1)."""
    rows = np.flatnonzero(points.reference & _bare(points))
    if not rows.size:
        return None
    inverse = 1 / points["kappa_rep"][rows]
    parts = [f"1/κ_rep = {_spread(inverse)}, κ_rep = {1 / inverse.mean():.3g}"]
    for size in sorted(set(points.lambda_s[rows])):
        parts.append(f"λ_s = {size:g}: {1 / inverse[points.lambda_s[rows] == size].mean():.3g}")
    kappa = 1 / inverse.mean()
    return (_word(abs(kappa - 2) < 0.2, 1.6 < kappa < 2.6), "; ".join(parts), rows.size)


def linear(points: Points) -> Judged | None:
    """Exponent of the area in the load, of each path."""
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
        _word(abs(found.mean() - 1) + found.std() < VISIBLE, abs(found.mean() - 1) < 2 * VISIBLE),
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


def pressure(points: Points) -> Judged | None:
    """Repulsive load with adhesion over that without, at one repulsive area."""
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
        _equal(found),
        f"N_rep with adhesion over without, at one A_rep: {_spread(found)}",
        found.size,
    )


def mean_gap(points: Points) -> Judged | None:
    """Mean gap with adhesion less that without, at one repulsive load."""
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
    return (_word(abs(found).max() < 0.05, abs(found).mean() < 2 * 0.05), text, found.size)


def _attracted(points: Points) -> Rows:
    found: Rows = np.flatnonzero(points.valid & (points["area_att"] > 0) & (points["retracting"] == 0))
    return found


def attraction(points: Points) -> Judged | None:
    """Mean tension over the attracted area, in units of w/Δr."""
    rows = _attracted(points)
    if not rows.size:
        return None
    ratio = points["pressure_att"][rows] * points["range"][rows] / points.length[rows]
    parts = [f"N_att over (w/Δr) A_att: {_spread(ratio)}"]
    for length in sorted(set(points.length[rows])):
        parts.append(f"l_a = {length:g}: {ratio[points.length[rows] == length].mean():.3g}")
    return (_equal(ratio), "; ".join(parts), rows.size)


def _thin(points: Points) -> Rows:
    rows = _attracted(points)
    return rows[points["area_att"][rows] < points["area_rep"][rows]]


def strip(points: Points) -> Judged | None:
    """Attracted area over that of a strip of the width of Eq. (S-2)."""
    rows = _thin(points)
    if not rows.size:
        return None
    columns = zip(points["rms_slope"][rows], points["diameter"][rows], points["range"][rows], strict=True)
    width = np.array([paper.attraction_width(*each) for each in columns])
    ratio = points["area_att"][rows] * points.area[rows] / (points["perimeter"][rows] * width)
    text = f"A_att/(P d_att), d_att of Eq. (S-2) with the measured d_rep, where A_att < A_rep: {_spread(ratio)}"
    return (_equal(ratio), text, rows.size)


def ratio(points: Points) -> Judged | None:
    """A_rep/A_att over that of Eq. (4)."""
    rows = _thin(points)
    if not rows.size:
        return None
    logs = np.log(points["area_rep"][rows] / points["area_att"][rows] / points.area_ratio[rows])
    text = f"measured over predicted: {_factor(logs)}"
    return (_equal(np.exp(logs)), text, rows.size)


def kappa_att(points: Points) -> Judged | None:
    """1/κ_att over that of Eqs. (3) and (4)."""
    rows = np.flatnonzero(points.reference & (points["area_att"] > 0))
    if rows.size < 3:
        return None
    logs = np.log(points.kappa_att[rows] / points["kappa_att"][rows])
    decades = np.ptp(np.log10(points["kappa_att"][rows]))
    text = f"measured over predicted 1/κ_att, over {decades:.2g} decades: {_factor(logs)}"
    return (_equal(np.exp(logs)), text, rows.size)


def sticky(points: Points) -> Judged | None:
    """Which surfaces have a negative load, beside the criterion."""
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
    return (_word(wrong == 0, wrong < 0.1 * rows.size), "; ".join(text for _, text in counts), rows.size)


def constant(points: Points) -> Judged | None:
    """Change of d_rep along each path."""
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


def diameter(points: Points) -> Judged | None:
    """d_rep over 4h'/h''."""
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


def perimeter(points: Points) -> Judged | None:
    """P d over π A_rep, Fig. S-2."""
    rows = np.flatnonzero(points.valid & (points["chord"] > 10))
    if not rows.size:
        return None
    ratio = points["perimeter"][rows] * points["chord"][rows] / (np.pi * points["area_rep"][rows] * points.area[rows])
    return (
        _equal(ratio),
        f"P d/(π A_rep): {_spread(ratio)}",
        rows.size,
    )


def stiffness(points: Points) -> Judged | None:
    """Stiffness with adhesion over that without, beside κ_rep/κ."""
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
    return (_equal(ratio), text, ratio.size)


def asperities(points: Points) -> Judged | None:
    """Largest tension over Fuller and Tabor's, Fig. S-3."""
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


def roll_off(points: Points) -> Judged | None:
    """Change of 1/κ with λ_L at one period."""
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
        _word(max(spreads) < VISIBLE / 2, max(spreads) < 2 * max(scatters)),
        text,
        rows.size,
    )
