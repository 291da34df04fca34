"""The thirty geometries of Figure 4 at the paper's own size, from their points: ``python -m docs.studies.own_size``.

``continuum sweep run inputs/sweep/own-size.toml`` makes the points, and ``continuum plot page`` their table.
``--figure`` draws measured numbers over theory, and writes the table of Figure 4, which ``docs.studies.redraw`` draws.
What was expected is in docs/studies/own_size.md; :func:`judged` says what became of it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from pandas import DataFrame, Series, read_csv

from continuum.paper.claims import stored_points
from continuum.paper.figures import FIGURES
from continuum.paper.points import MARKERS, adhesion_colour
from continuum.show import plot
from continuum.theory import paper
from docs.studies import claims
from docs.studies.judgement import MEASURED, held, verdict
from docs.studies.tables import points_of

POINTS = points_of("own-size")
STEM = MEASURED / "paper-own-size-figure4"
PATHS = MEASURED / "own-size-part.csv"
"""Six systems with three points on a path of approach, by an earlier input; a seventh has one."""
AREA = 0.01
"""A_rep/A0 at which all is read."""
WINDOW = 0.3
"""Largest part by which the area of a single state may differ from it."""
WIDTHS = (512, 256, 128, 64, 32)
"""Bandwidths λ_L/λ_s."""
BORDER = 1.5
"""Factor of N_att/N_rep from 1 within which two more surfaces were run."""
OPEN = 0.06
"""|1/κ| below which the sign is open: two searches for 1 % gave values as much larger than the states judged here."""
KAPPA_REP = 2.0


def points() -> DataFrame:
    """The points of all systems, on approach, with inverse values of κ, which may diverge."""
    rows = stored_points(POINTS)
    return compared(rows[rows.approach & rows.valid])


def compared(rows: DataFrame) -> DataFrame:
    """Points with the bandwidth, and 1/κ, 1/κ_rep, 1/κ_att and A_rep/A_att."""
    return rows.assign(
        width=(rows.lambda_L / rows.lambda_s).round().astype(int), inverse=1 / rows.kappa,
        inverse_rep=1 / rows.kappa_rep, inverse_att=1 / rows.kappa_att,
        ratio=rows.area_rep / rows.area_att.where(rows.area_att > 0),
    )  # fmt: skip


def at_area(rows: DataFrame, area: float = AREA) -> DataFrame:
    """A row for each system: the state nearest to an area, as one of two sides of a jump.

    Systems without a state within :data:`WINDOW` of the area are left out.
    """
    off = np.log(rows.area_rep / area).abs()
    nearest = rows.loc[off.groupby(rows.system).idxmin()]
    return with_theory(nearest[(nearest.area_rep / area - 1).abs() <= WINDOW].reset_index(drop=True))


def from_paths() -> DataFrame:
    """The six systems with three points on a path, and how far 1/κ of the single state is from theirs at its area."""
    table = read_csv(PATHS)
    single = at_area(points().query("seed == 1 and length == 0.05 and slope == 0.1"))
    rows = []
    for (lambda_s, hurst), path in table.groupby(["surface.lambda_s", "surface.hurst"]):
        state = single[(single.lambda_s == lambda_s) & (single.hurst == hurst)]
        if len(path) < 3 or state.empty:
            continue
        area = path.area_rep.to_numpy()
        inverse = path["load (E*)"].to_numpy() / (area * path.rms_slope.to_numpy())
        (one,) = state.itertuples()
        there = float(np.interp(np.log(one.area_rep), np.log(area), inverse))
        rows.append({"lambda_s": lambda_s, "hurst": hurst, "area": one.area_rep, "state": one.inverse, "path": there,
                     "change": float(np.ptp(inverse))})  # fmt: skip
    return DataFrame(rows)


def with_theory(rows: DataFrame) -> DataFrame:
    """What the paper says of each system, over which the measured numbers are taken.

    ``said`` is 1/κ_att of Eqs. (3) and (4) from the undeformed surface; ``ratio_own`` is A_rep/A_att of Eq. (4) with
    the measured d_rep.
    """
    measured = zip(rows.rms_slope, rows.diameter, rows["range"], strict=True)
    said = 1 / rows.expected_kappa_att
    return rows.assign(
        said=said, over=rows.inverse_att / said, ratio_over=rows.ratio / rows.expected_ratio,
        ratio_own=rows.ratio / [paper.area_ratio(*each) if each[2] > 0 else np.inf for each in measured],
        sticks=rows.load < 0, named=said > 1 / KAPPA_REP, thin=rows.area_att < rows.area_rep,
        tension=rows.pressure_att * rows["range"] / rows.length.where(rows.length > 0),
    )  # fmt: skip


def over_bare(rows: DataFrame, column: str) -> Series:
    """A number of each adhesive system over that of the same surface without adhesion; NaN where there is none."""
    bare = rows[rows.length == 0].set_index("surface")[column]
    return rows[column] / rows.surface.map(bare)


def near_border(rows: DataFrame) -> DataFrame:
    """The systems whose attraction and repulsion are within a factor of one another."""
    pull = rows.inverse_att / rows.inverse_rep
    return rows[(rows.length > 0) & pull.between(1 / BORDER, BORDER)]


def geometric(values: Series) -> float:
    return float(np.exp(np.log(values).mean()))


# --- the statements -------------------------------------------------------------------------------------------------

Judged = tuple[str, str, str]


def judged(every: DataFrame) -> Iterator[Judged]:
    """Each statement of the page: its number and subject, what was found, and what became of it."""
    rows = every[every.seed == 1]
    pulling = rows[rows.length > 0]
    flat = pulling.slope == 0.1
    yield from _stickiness(pulling, flat)
    yield from _by_width(pulling, flat)

    within = pulling.diameter_ratio.between(0.5, 2)
    yield _count("5. d_rep within a factor of two of 4h'/h''", within, 80)
    yield _mean("5. d_rep over 4h'/h'' at 512", pulling[pulling.width == 512].diameter_ratio, 1.6, 0.25, log=True)
    yield from _repulsion(rows)

    for name, values, expected in (
        ("7. N_att over (w/Δr) A_att", pulling.tension, ((0.0005, 1.0, 0.05), (0.005, 0.92, 0.06), (0.05, 0.68, 0.1))),
        ("8. N_rep over that without adhesion", over_bare(rows, "inverse_rep")[pulling.index],
         ((0.0005, 0.98, 0.03), (0.005, 0.93, 0.06), (0.05, 0.8, 0.1))),
    ):  # fmt: skip
        for length, said, bound in expected:
            part = values[(pulling.length == length) & (flat | (length < 0.05))].dropna()
            yield _mean(f"{name} at l_a = {length:g}", part, said, bound)
    wide = rows[rows.chord > 10]
    off = (wide.disc_ratio - 1).abs()
    yield ("9. P d/(π A_rep) within 5 % where d > 10 a0", _of(off < 0.05), held(bool((off < 0.05).all())))
    yield _count("11. A_att > A_rep without sticking", ~pulling.thin & ~pulling.sticks, 5)
    scatter = every[every.length > 0].groupby(["lambda_s", "hurst", "slope", "length"]).inverse
    scatter = scatter.std(ddof=1)[scatter.size() >= 3]
    yield _mean("12. scatter of 1/κ among surfaces near the border", scatter, 0.11, 0.05)


def judged_by_paths(paths: DataFrame) -> Iterator[Judged]:
    """Statement 10, and whether a single state may stand for a path: the table of :func:`from_paths`."""
    yield _count("10. 1/κ changes by less than 0.1 over three points", paths.change < 0.1, len(paths))
    near = (paths.state - paths.path).abs() < 0.03
    yield _count("a state from rest is within 0.03 of the path in 1/κ", near, len(paths))


def _of(holds: Series) -> str:
    return f"{int(holds.sum())} of {len(holds)}"


def _count(name: str, holds: Series, least: int, most: int | None = None) -> Judged:
    count = int(holds.sum())
    return name, _of(holds), held(least <= count and (most is None or count <= most))


def _mean(name: str, values: Series, said: float, bound: float, *, log: bool = False) -> Judged:
    """A mean, geometric if ``log``, which is then judged by its logarithm's scatter."""
    if not len(values):
        return name, "-", "not tested"
    found: NDArray[np.float64] = values.to_numpy()
    if log:
        middle = geometric(values)
        # Standard errors of a geometric mean are those of the logarithm times it.
        found = middle * (1 + np.log(found) - np.log(found).mean())
    return name, f"{found.mean():.2f} of {len(found)} (stated {said:g} ± {bound:g})", verdict(found, said, bound)


def _stickiness(rows: DataFrame, flat: Series) -> Iterator[Judged]:
    strong = rows.length == 0.05
    for name, part, least, most in (
        ("l_a = 0.0005", rows.length == 0.0005, 0, 0), ("l_a = 0.005", rows.length == 0.005, 0, 0),
        ("l_a = 0.05, h' = 0.3", strong & ~flat, 0, 0), ("l_a = 0.05, h' = 0.1", strong & flat, 7, 13),
    ):  # fmt: skip
        yield _count(f"1. stick at {name}", rows.sticks[part], least, most)
    yield _count("2. the criterion is right", rows.named == rows.sticks, 83, 88)
    yield _count("2. named, do not stick", ~rows.sticks[rows.named], 2, 5)
    yield _count("2. not named, stick", rows.sticks[~rows.named], 0, 3)


def _by_width(rows: DataFrame, flat: Series) -> Iterator[Judged]:
    strong, weak = rows[(rows.length == 0.05) & flat], rows[rows.length < 0.05]
    thin = rows[rows.thin]
    for name, part, column, expected in (
        ("3. 1/κ_att over theory, l_a = 0.05, h' = 0.1", strong, "over",
         ((0.22, 0.08), (0.38, 0.12), (0.55, 0.15), (0.8, 0.15), (1.0, 0.2))),
        ("3. 1/κ_att over theory, l_a <= 0.005", weak, "over",
         ((0.55, 0.1), (0.67, 0.08), (0.78, 0.08), (0.92, 0.08), (1.1, 0.12))),
        ("4. A_rep/A_att over Eq. (4)", thin, "ratio_over",
         ((1.8, 0.25), (1.5, 0.2), (1.3, 0.15), (1.08, 0.1), (0.9, 0.12))),
        ("4. the same with d_rep as measured", thin, "ratio_own", ((1.0, 0.15),) * 5),
    ):  # fmt: skip
        for width, (said, bound) in zip(WIDTHS, expected, strict=True):
            yield _mean(f"{name}, at {width}", part[part.width == width][column], said, bound, log=True)


def _repulsion(rows: DataFrame) -> Iterator[Judged]:
    bare = rows[rows.length == 0]
    kappa = 1 / bare.inverse_rep
    near = (kappa - 2).abs() <= 0.2
    yield "6. κ_rep without adhesion within 0.2 of 2", _of(near), held(int(near.sum()) <= 5)
    yield _mean("6. κ_rep at λ_s = 32 and 64", kappa[bare.lambda_s >= 32], 2.3, 0.2)
    yield _mean("6. κ_rep at λ_s = 4", kappa[bare.lambda_s == 4], 3.0, 0.4)
    both = bare.assign(kappa=kappa).pivot_table(index=["lambda_s", "hurst"], columns="slope", values="kappa").dropna()
    if {0.1, 0.3} <= set(both):
        yield _count("6. κ_rep smaller at h' = 0.3 than at 0.1", both[0.3] < both[0.1], 12)


# --- the page -------------------------------------------------------------------------------------------------------


def table() -> Iterator[str]:
    """The statements, what was found, and what became of each."""
    yield "| statement | found | |\n|---|---|---|"
    every = (*judged(at_area(points())), *judged_by_paths(from_paths()))
    yield from (f"| {name} | {found} | **{what}** |" for name, found, what in every)


def systems() -> Iterator[str]:
    """1/κ at 1 % of every system with l_a = 0.05, and what the theory says."""
    rows = at_area(points())
    head = "λ_s | H | h' | 1/κ, each surface | 1/κ_rep | 1/κ_att | by Eqs. (3), (4) | A_rep/A_att | by Eq. (4)"
    yield f"| {head} | d_rep h''/(4h') |"
    yield "|---" * 10 + "|"
    strong = rows[rows.length == 0.05].sort_values("seed")
    for (lambda_s, hurst, slope), part in strong.groupby(["lambda_s", "hurst", "slope"]):
        each = "; ".join(f"{value:.3f}" for value in part.inverse)
        means = (part[name].mean() for name in ("inverse_rep", "inverse_att", "said", "ratio", "expected_ratio",
                                               "diameter_ratio"))  # fmt: skip
        yield (f"| {lambda_s:g} | {hurst} | {slope} | {each} | " + " | ".join(f"{m:.2f}" for m in means) + " |")


def widths() -> Iterator[str]:
    """Geometric means of what is measured over theory, by bandwidth, over seed 1."""
    rows = at_area(points()).query("seed == 1")
    adhesive, bare = rows[rows.length > 0], rows[rows.length == 0]
    thin = adhesive[adhesive.thin]
    columns: tuple[tuple[str, Callable[[int], Series]], ...] = (
        ("1/κ_att over Eqs. (3), (4)", lambda width: adhesive[adhesive.width == width].over),
        ("the same where A_att < A_rep", lambda width: thin[thin.width == width].over),
        ("A_rep/A_att over Eq. (4), A_att < A_rep", lambda width: thin[thin.width == width].ratio_over),
        ("with d_rep as measured", lambda width: thin[thin.width == width].ratio_own),
        ("d_rep over 4h'/h''", lambda width: adhesive[adhesive.width == width].diameter_ratio),
        ("κ_rep, l_a = 0", lambda width: 1 / bare[bare.width == width].inverse_rep),
    )
    yield f"| λ_L/λ_s | λ_s | {' | '.join(name for name, _ in columns)} |"
    yield "|---" * (len(columns) + 2) + "|"
    for width in sorted(WIDTHS):
        cells = [f"{geometric(part):.2f} ({len(part)})" if len(part := of(width)) else "-" for _, of in columns]
        yield f"| {width} | {2048 / width:g} | {' | '.join(cells)} |"


QUOTED = (
    "sticks", "right", "open", "named", "missed", "within", "perimeter", "tension", "pressure", "same-diameter",
    "power", "necessary", "kappa-rep", "attraction-weak", "attraction-strong", "ratio", "ratio-measured", "diameter",
)  # fmt: skip


def quoted() -> dict[str, str]:
    """Numbers of docs/paper.md, over the systems of seed 1."""
    every = at_area(points()).query("seed == 1")
    rows, bare = every[every.length > 0], every[every.length == 0]
    strong = (rows.length == 0.05) & (rows.slope == 0.1)
    right = rows.named == rows.sticks
    wide = every[every.chord > 10].disc_ratio
    thin = rows[rows.thin]
    repulsion, diameter = (over_bare(every, name)[rows.index].dropna() for name in ("inverse_rep", "diameter"))
    drawn_by = {
        "attraction-weak": (rows[~strong], "over"), "attraction-strong": (rows[strong], "over"),
        "ratio": (thin, "ratio_over"), "ratio-measured": (thin, "ratio_own"), "diameter": (rows, "diameter_ratio"),
    }  # fmt: skip
    return {
        "sticks": f"{int(rows.sticks.sum())} of {len(rows)}",
        "right": _of(right),
        "open": f"{int((rows.inverse.abs() < OPEN).sum())} of {len(rows)}",
        "named": f"{int((rows.named & ~rows.sticks).sum())} of {int(rows.named.sum())}",
        "missed": f"{int((~rows.named & rows.sticks).sum())} of {int(rows.sticks.sum())}",
        "within": _of(every.diameter_ratio.between(0.5, 2)),
        "perimeter": f"{wide.mean():.2f} ± {wide.std(ddof=1):.2f}",
        "tension": ", ".join(f"{part.tension.mean():.2f}" for _, part in rows.groupby("length")),
        "pressure": ", ".join(f"{part.mean():.2f}" for _, part in repulsion.groupby(rows.length)),
        "same-diameter": ", ".join(f"{part.mean():.2f}" for _, part in diameter.groupby(rows.length)),
        "power": ", ".join(f"{power(rows, *ends):.2f}" for ends in ((0.0005, 0.005), (0.005, 0.05))),
        "necessary": claims.necessary(rows.assign(reference=True)),
        "kappa-rep": _from_narrow_to_wide(1 / bare.inverse_rep, bare.width),
        **{name: _from_narrow_to_wide(part[column], part.width) for name, (part, column) in drawn_by.items()},
    }


def power(rows: DataFrame, low: float, high: float) -> float:
    """Mean exponent of w in 1/κ_att between two l_a, over surfaces."""
    by = rows.pivot_table(index="surface", columns="length", values="inverse_att")
    return float((np.log(by[high] / by[low]) / np.log(high / low)).mean())


def _from_narrow_to_wide(values: Series, widths: Series) -> str:
    """Geometric means at the smallest and the largest bandwidth."""
    means = [geometric(part) for _, part in values.groupby(widths)]
    return f"{means[0]:.2f} to {means[-1]:.2f}"


def drawn() -> DataFrame:
    """The numbers of Figure 4 at 1 % of the area, of the systems with adhesion."""
    rows = at_area(points()).query("length > 0")
    inverse = {f"kappa{end}": 1 / rows[f"inverse{end}"] for end in ("", "_rep", "_att")}
    return FIGURES["figure4"].numbers(rows.assign(**inverse, search=-1))


@plot.styled
def figure(rows: DataFrame) -> Figure:
    """1/κ_att and A_rep/A_att as measured over theory, and 1/κ, of all adhesive systems at :data:`AREA`."""
    drawn, axes = plot.new_axes(plot.PAGE, 2.9, 1, 3)
    left, middle, right = axes
    for length, part in rows[rows.length > 0].groupby("length"):
        shade = adhesion_colour(float(length))
        for (hurst, slope), some in part.groupby(["hurst", "slope"]):
            look = {"linestyle": "none", "marker": MARKERS[hurst], "color": shade, "markersize": 3.5,
                    "fillstyle": "full" if slope < 0.2 else "none"}  # fmt: skip
            label = rf"$\ell_a/a_0 = {length:g}$" if (hurst, slope) == (0.8, 0.1) else None
            left.plot(some.said, some.inverse_att, label=label, **look)
            middle.plot(some.width, some.ratio / some.expected_ratio, **look)
            right.plot(some.said, some.inverse, **look)
    ends = np.array(left.get_xlim())
    left.plot(ends, ends, ":", color="0.4", label="theory")
    left.set(
        xscale="log", yscale="log", xlabel=r"$1/\kappa_\mathrm{att}$, Eqs. (3), (4)", ylabel=r"$1/\kappa_\mathrm{att}$"
    )
    middle.axhline(1, color="0.4", linestyle=":")
    middle.set(xscale="log", yscale="log", xlabel=r"$\lambda_L/\lambda_s$",
               ylabel=r"$A_\mathrm{rep}/A_\mathrm{att}$ over Eq. (4)")  # fmt: skip
    right.axhline(0, color="#009e73", linewidth=0.9, label="below: sticky")
    right.axvline(
        1 / KAPPA_REP, color="0.4", linestyle="--", linewidth=0.9, label=r"criterion, $\kappa_\mathrm{rep} = 2$"
    )
    right.set(xscale="log", xlabel=r"$1/\kappa_\mathrm{att}$, Eqs. (3), (4)", ylabel=r"$1/\kappa$")
    plot.log_ticks(left, middle, right)
    plot.letter_panels(axes)
    plot.legend_below(drawn, plot.labelled(left, right))
    return drawn


if __name__ == "__main__":
    if sys.argv[1:] == ["--figure"]:
        drawn().to_csv(STEM.with_suffix(".csv"), index=False, lineterminator="\n")
        with plot.written_as(["png"]):
            plot.save_figure(figure(at_area(points())), MEASURED / "own-size", own=True)
    sys.stdout.write("\n".join([*table(), "", *widths(), "", *systems()]) + "\n")
