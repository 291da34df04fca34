"""Area against load over four decades, from the points of one surface: ``python -m docs.studies.decades``.

``continuum sweep run inputs/sweep/decades.toml`` makes the points, ``continuum plot page`` their table.  What was
expected is in docs/studies/decades.md; :func:`judged` says what became of it.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure
from pandas import DataFrame

from continuum.paper.claims import stored_points
from continuum.paper.points import adhesion_colour
from continuum.show import plot
from docs.studies.judgement import MEASURED, held
from docs.studies.own_size import compared

POINTS = MEASURED / "paper-decades-points.csv"
STEM = MEASURED / "decades"
DECADES = (1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
LINEAR = 0.1
"""Largest difference of an exponent from 1 that counts as linear, as in continuum/paper/claims.py."""


def points() -> DataFrame:
    rows = stored_points(POINTS)
    return compared(rows[rows.approach & rows.valid]).sort_values(["length", "area_rep"])


def exponents(path: DataFrame) -> list[float]:
    """x of A_rep ~ N^x in each decade of the area, by a straight line through its points; NaN where some pull."""
    found = []
    for low, high in itertools.pairwise(DECADES):
        # A decade ends where the next one begins: points beyond its ends by less than half a step belong to both.
        part = path[path.area_rep.between(low / 1.7, high * 1.7)]
        usable = len(part) >= 3 and bool((part.load > 0).all())
        found.append(float(np.polyfit(np.log(part.load), np.log(part.area_rep), 1)[0]) if usable else np.nan)
    return found


def growth(path: DataFrame, column: str, low: float, high: float) -> float:
    """Factor by which a number changes between two areas, each read at the nearest point in ln A_rep."""
    x = np.log(path.area_rep.to_numpy())
    ends = [path[column].to_numpy()[np.argmin(np.abs(x - np.log(area)))] for area in (low, high)]
    return float(ends[1] / ends[0])


def span(rows: DataFrame) -> float:
    """Decades of the area that all paths cover."""
    ends = rows.groupby("length").area_rep.agg(["min", "max"])
    return float(np.log10(ends["max"].min() / ends["min"].max()))


def judged(rows: DataFrame) -> Iterator[tuple[str, str, str]]:
    """Each statement of the page: what it says, what was found, and what became of it."""
    paths = dict(list(rows.groupby("length")))
    for length, low, high, name in (
        (0.0, 0.92, 1.0, "1"), (0.0005, 0.92, 1.0, "1"), (0.005, 0.85, 1.02, "2"),
    ):  # fmt: skip
        found = exponents(paths[length])
        told = [x for x in found if np.isfinite(x)]
        said = ", ".join(f"{x:.3f}" if np.isfinite(x) else "-" for x in found)
        # A decade with fewer than three states is not tested: it can neither hold nor refute.
        what = held(all(low <= x <= high for x in told)) if told else "not tested"
        yield f"{name}. exponents at l_a = {length:g}, in {len(told)} of 4 decades", said, what
    bare = growth(paths[0.0], "inverse_rep", DECADES[0], DECADES[-1])
    yield "1. 1/κ_rep without adhesion grows by", f"{bare:.2f} (stated 1.35 ± 0.20)", held(abs(bare - 1.35) <= 0.2)
    strong = paths[0.05].inverse
    as_said = bool(strong.between(-0.4, 0.1).all() and np.ptp(strong) > 0.1)
    yield "3. 1/κ at l_a = 0.05", f"{strong.min():.3f} to {strong.max():.3f}", held(as_said)
    for name, length, column, said, bound in (
        ("4. d_rep without adhesion grows by", 0.0, "diameter", 1.3, 0.2),
        ("5. A_rep/A_att at 0.005 grows by", 0.005, "ratio", 1.6, 0.3),
    ):
        found_growth = growth(paths[length], column, 1e-4, 0.1)
        text = f"{found_growth:.2f} (stated {said} ± {bound})"
        yield name, text, held(abs(found_growth - said) <= bound)


def linear(rows: DataFrame) -> Iterator[tuple[float, float, bool]]:
    """Each l_a, the mean of its exponents, and whether that counts as linear; NaN and not where some points pull."""
    for length, path in rows.groupby("length"):
        pushes = bool((path.load > 0).all())
        mean = float(np.nanmean(exponents(path))) if pushes else np.nan
        yield float(length), mean, abs(mean - 1) < LINEAR


QUOTED = ("exponents", "weak", "span")


def quoted() -> dict[str, str]:
    """Numbers of docs/paper.md: exponents by decade without and with weak adhesion, and 1/κ under a strong one."""
    rows = points()
    paths = dict(list(rows.groupby("length")))
    told = {length: [x for x in exponents(path) if np.isfinite(x)] for length, path in paths.items()}
    return {
        "exponents": f"{min(told[0.0]):.2f} to {max(told[0.0]):.2f}",
        "weak": f"{min(told[0.005]):.2f} to {max(told[0.005]):.2f}",
        "span": f"{span(rows):.1f}",
    }


def table() -> Iterator[str]:
    """Statements; then the numbers of the paths at the points nearest to each decade."""
    rows = points()
    yield "| statement | found | |\n|---|---|---|"
    yield from (f"| {name} | {found} | **{what}** |" for name, found, what in judged(rows))
    yield ""
    yield "| l_a | A_rep/A0 | 1/κ | 1/κ_rep | A_rep/A_att over Eq. (4) | d_rep h''/(4h') |\n|---|---|---|---|---|---|"
    for length, path in rows.groupby("length"):
        for area in DECADES:
            row = path.iloc[np.argmin(np.abs(np.log(path.area_rep / area)))]
            over = f"{row.ratio / row.expected_ratio:.2f}" if length > 0 else "-"
            yield (
                f"| {length:g} | {row.area_rep:.2g} | {row.inverse:.3f} | {row.inverse_rep:.3f} | {over} "
                f"| {row.diameter_ratio:.2f} |"
            )


@plot.styled
def figure(rows: DataFrame) -> Figure:
    """Area against load, and the ratio of the two that the paper has constant, over all decades."""
    drawn, (left, right) = plot.new_axes(plot.PAGE, 3.0, 1, 2)
    for length, path in rows.groupby("length"):
        shade = adhesion_colour(float(length))
        pushes = path[path.load > 0]
        label = rf"$\ell_a/a_0 = {length:g}$"
        left.plot(pushes.load / pushes.rms_slope, pushes.area_rep, "o-", color=shade, markersize=3, label=label)
        right.plot(path.area_rep, path.inverse, "o-", color=shade, markersize=3)
    ends = np.array(left.get_xlim())
    left.plot(ends, 2 * ends, ":", color="0.4", label=r"$\kappa = 2$")
    left.set(xscale="log", yscale="log", xlabel=r"$N/(h'_\mathrm{rms} E^* A_0)$, where positive",
             ylabel=r"$A_\mathrm{rep}/A_0$")  # fmt: skip
    right.axhline(0.5, color="0.4", linestyle=":")
    right.axhline(0, color="#009e73", linewidth=0.9, label=r"below: the contact pulls")
    right.set(xscale="log", xlabel=r"$A_\mathrm{rep}/A_0$", ylabel=r"$1/\kappa$")
    plot.log_ticks(left, right)
    plot.letter_panels((left, right))
    plot.legend_below(drawn, plot.labelled(left, right))
    return drawn


if __name__ == "__main__":
    if sys.argv[1:] == ["--figure"]:
        with plot.written_as(["png"]):
            plot.save_figure(figure(points()), STEM, own=True)
    sys.stdout.write("\n".join(table()) + "\n")
