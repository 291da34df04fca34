"""The second law judged by the bounds of docs/studies/one_state.md: ``python -m docs.studies.one_state_judged``.

Prints its tables from ``docs/measured/one-state.csv``, which :mod:`docs.studies.one_state` makes; with ``--into`` a
folder it draws ``one-state.png`` there.  Means are over surfaces (seeds), with 95 % intervals from Student's t.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from pandas import DataFrame, Series, read_csv

from continuum.maps.verdict.threshold import (
    ANY,
    BEYOND,
    BEYOND_FEW,
    FEW_POINTS,
    LARGEST_CHI,
    LEAST_CHI,
    MOST_CHI,
    MOST_TABOR,
    PressedMap,
    by_law,
)
from continuum.show import plot
from docs.studies.judgement import COUNT, SURFACES, Mean, word
from docs.studies.law import fit, thresholds
from docs.studies.one_state import FILE, RESOLVED

CHI, PATCHES, MULLER = 0.2, 10, 0.5
"""The range of the statement."""
LOW, HIGH, MOST, FEW = 0.97, 1.03, 0.9, 0.75
"""The interval, the share of thresholds in it that holds the statement, and the share that refutes it."""
NEAR, FAR, SCATTER, TOO_MUCH = 1.04, 1.08, 1.04, 1.08
"""Means and scatters of threshold over estimate that hold the statement, and that refute it."""
SHORT, WIDE = 0.16, 32
"""Range in h_rms up to which, and bandwidth beyond which, surfaces are a class of their own."""


def read() -> DataFrame:
    """The thresholds, with the class of each, its ratios, and whether the statement is about it."""
    rows = read_csv(FILE)
    snaps = (rows["shape"] != "paper") & (rows.work > RESOLVED * rows.range**2)
    rows = rows.assign(
        how=rows.how.mask(snaps, "single points snap at the threshold"),
        estimate=np.sqrt(rows.low * rows.high.replace(np.inf, np.nan)),
        period=rows.n / rows.lambda_L,
        within=(rows.chi <= CHI) & (rows.patches >= PATCHES) & (rows.muller <= MULLER),
        beyond=np.where(rows.area * rows.n**2 < FEW_POINTS, BEYOND_FEW, BEYOND),
    )
    least, most = np.array([_wide(row) for row in rows.itertuples()]).T
    laws = {shape: fit(thresholds(shape)) for shape in ("spline", "exponential")}
    laws["paper"] = laws["spline"]  # the same shape
    law = [float(laws[s](r)) for s, r in zip(rows["shape"], rows.range / rows.height, strict=True)]
    return rows.assign(
        of=[_class(row) for row in rows.itertuples()],
        ratio=np.log(rows.work / rows.estimate),
        law=np.log(rows.work / (rows.energy * law)),
        theory=np.log(rows.work / rows.weak),
        kept=np.log(rows.work / rows.load_kept),
        inside=(rows.work >= LOW * rows.low) & (rows.work <= HIGH * rows.high),
        based=(rows.work >= rows.low / rows.beyond) & (rows.work <= rows.high * rows.beyond),
        wide=(rows.work >= least) & (rows.work <= most),
    )


def _wide(row: Any) -> tuple[float, float]:
    """The interval that ``continuum predict`` states outside of the range of the statement, without longer ranges."""
    if not (LEAST_CHI <= row.chi <= MOST_CHI and row.muller <= MOST_TABOR):
        return by_law(row.energy, row.height, row.range, ANY)[1:]
    work = row.low / (1 + row.chi) * (1 + row.chi + row.chi**2)
    small = row.chi <= LARGEST_CHI and row.estimate > 0
    low, high = (row.low, row.high) if small else (min(row.dmt, work), work)
    wide, _ = PressedMap._width(row.chi, row.patches, row.muller)
    return low / max(wide, row.beyond), high * max(wide, row.beyond)


def _class(row: Any) -> str:
    named = {
        "the paper's law": row.shape == "paper",
        f"fewer than {FEW_POINTS} points": row.area * row.n**2 < FEW_POINTS and row.n < 256,
        f"{row.delta:g} h_rms": row.delta <= SHORT,
        f"λ_L/λ_s of {row.lambda_L / row.lambda_s:g}": row.lambda_L / row.lambda_s > WIDE,
        "period of 2 λ_L": row.period <= 2,
        "16 points to λ_s": row.lambda_s == 16,
        "self-affine": True,
    }
    return str(row.kind) if row.kind != "self-affine" else next(name for name, chosen in named.items() if chosen)


def scatter(logarithms: Series) -> float:
    """As a factor."""
    return float(np.exp(logarithms.std()))


def mean(rows: DataFrame, name: str = "ratio") -> Mean:
    """Over surfaces."""
    return Mean.of(rows.groupby("seed")[name].mean().dropna().to_numpy())


def estimated(rows: DataFrame, groups: Sequence[DataFrame]) -> str:
    """What became of the estimate: by its mean in each group, and its scatter."""
    means, spread = [mean(group) for group in groups], scatter(rows.ratio)
    held = all(1 / NEAR <= m.value <= NEAR for m in means) and spread <= SCATTER
    refuted = spread > TOO_MUCH or any(m.excludes(1.0) and not 1 / FAR <= m.value <= FAR for m in means)
    return word(held, refuted, rows)


def by_one(rows: DataFrame) -> Iterator[tuple[str, DataFrame]]:
    """Groups of self-affine surfaces, by one property at a time, of as many thresholds as a verdict needs."""
    names = {"delta": "range {:g} h_rms", "shape": "{}", "area": "{:.1%} of the area", "hurst": "H = {:g}",
             "lambda_s": "{:g} points to λ_s", "n": "{}²",
             "period": "period of {:g} λ_L"}  # fmt: skip
    for column, name in names.items():
        for value, part in rows.groupby(column):
            if len(part) >= COUNT and part.seed.nunique() >= SURFACES:
                yield name.format(value), part


def line(name: str, rows: DataFrame, groups: Sequence[DataFrame]) -> str:
    """A row of the table of classes."""
    share = rows.inside.mean()
    inside = word(share >= MOST, share < FEW, rows)
    far = np.exp(np.quantile(rows.ratio.abs(), 0.95))
    beside = " | ".join(f"{np.exp(rows[key].mean()):.2f}, {scatter(rows[key]):.2f}" for key in ("law", "theory"))
    return (
        f"| {name} | {len(rows)}, {rows.seed.nunique()} | {rows.inside.sum()}: **{inside}** | {mean(rows)}, "
        f"{scatter(rows.ratio):.3f}: **{estimated(rows, groups)}** | {far:.3f} | {(~rows.based).sum()} | {beside} |"
    )


def shown(rows: DataFrame) -> Iterator[str]:
    """The table of the page: each class of surfaces in the range of the statement, and all that lies outside of it."""
    found = rows[rows.how == "threshold"]
    yield "| class | thresholds, surfaces | within 0.97 w_low to 1.03 w_high | threshold over estimate, scatter |"
    yield "|---|---|---|---|"
    inside, outside = found[found.within], found[~found.within]
    for name, part in [*sorted(inside.groupby("of"), key=lambda pair: -len(pair[1])), ("all", inside)]:
        groups = [group for _, group in by_one(part)] if name == "self-affine" else []
        yield " | ".join(line(name, part, [part, *groups]).split(" | ")[:4]) + " |"
    roots = outside.dropna(subset="ratio")
    yield (f"| outside of the range | {len(outside)}, {outside.seed.nunique()} | {outside.wide.sum()} in the interval "
           f"of `predict` | {mean(roots)}, {scatter(roots.ratio):.3f} |")  # fmt: skip


def tables(rows: DataFrame) -> Iterator[str]:
    """Classes, groups of self-affine surfaces, what lies beyond the range, and what was not run."""
    found = rows[rows.how == "threshold"]
    yield (
        "| class | thresholds, surfaces | within 0.97 w_low to 1.03 w_high | threshold over estimate, scatter "
        "| 95 % within | beyond the error of `predict` | w/(U F), scatter | over Persson and Scaraggi, scatter |"
    )
    yield "|---|---|---|---|---|---|---|---|"
    inside = found[found.within]
    for name, part in sorted(inside.groupby("of"), key=lambda pair: -len(pair[1])):
        groups = [group for _, group in by_one(part)] if name == "self-affine" else []
        yield line(name, part, [part, *groups])
    yield line("all", inside, [inside])
    yield "\n| self-affine | thresholds, surfaces | threshold over estimate | scatter | |\n|---|---|---|---|---|"
    for name, part in by_one(inside[inside.of == "self-affine"]):
        numbers = f"{len(part)}, {part.seed.nunique()} | {mean(part)} | {scatter(part.ratio):.3f}"
        yield f"| {name} | {numbers} | **{estimated(part, [part])}** |"
    yield "\n| 16 points to λ_s | thresholds, surfaces | threshold over estimate | over w_DMT (1 + χ), load kept |"
    yield "|---|---|---|---|"
    fine = found[found.lambda_s == 16]
    for name, part in fine.groupby("shape"):
        yield f"| {name} | {len(part)}, {part.seed.nunique()} | {mean(part)} | {mean(part, 'kept')} |"
    yield (
        "\n| outside of the range | thresholds | of them with a root | threshold over estimate | scatter "
        "| least, largest | beyond the interval of `predict` |"
    )
    yield "|---|---|---|---|---|---|---|"
    beyond = {f"χ above {CHI:g}": found.chi > CHI, f"fewer than {PATCHES} patches": found.patches < PATCHES,
              f"μ_T above {MULLER:g}": found.muller > MULLER, "χ below 0": found.chi < 0, "all of these": ~found.within,
              **{f"{kind}, outside": (found.of == kind) & ~found.within for kind in sorted(set(found.of))}}  # fmt: skip
    for name, chosen in beyond.items():
        part = found[chosen]
        root = part.dropna(subset="ratio")
        if len(root):
            least, most = np.exp([root.ratio.min(), root.ratio.max()])
            numbers = f"{mean(root)} | {scatter(root.ratio):.3f} | {least:.2f}, {most:.2f}"
            yield f"| {name} | {len(part)} | {len(root)} | {numbers} | {(~part.wide).sum()} |"
    ended = rows.how.value_counts()
    yield f"\nSearches: {', '.join(f'{how} {count}' for how, count in ended.items())}."


def _shown(name: str) -> str:
    return name.replace("λ_s", r"$\lambda_s$").replace("λ_L", r"$\lambda_L$")


@plot.styled
def figure(rows: DataFrame) -> Figure:
    """Threshold over w_DMT against the size of the correction; the estimate beside U F and a theory, class by class."""
    found = rows[(rows.how == "threshold") & rows.ratio.notna()]
    drawn, (left, right) = plot.new_axes(plot.PAGE, 5.0, columns=2)
    x = np.array([0.9, 1.55])
    left.fill_between(x, x * LOW, x * HIGH, color="0.9", lw=0, label="3 %")
    left.plot(x, x, "k-", lw=0.8)
    names = list(found.of.value_counts().index)
    marks = "osv^D<>phX*dP8H123+x|_"
    for i, name in enumerate(names):
        part, mark = found[found.of == name], marks[i % len(marks)]
        for inside, colour in ((True, f"C{i % 10}"), (False, "none")):
            shown = part[part.within == inside]
            left.plot(shown.estimate / shown.dmt, shown.work / shown.dmt, mark, ms=3, mew=0.5, mec=f"C{i % 10}",
                      mfc=colour, label=_shown(name) if inside else None)  # fmt: skip
    left.set(xscale="log", yscale="log", xlim=x, ylim=x, xlabel=r"estimate over $w_\mathrm{DMT}$",
             ylabel=r"work at the threshold over $w_\mathrm{DMT}$")  # fmt: skip
    inside = found[found.within]
    columns = {"ratio": ("estimate", "C0o"), "law": (r"$U F$", "C1s"), "theory": ("Persson", "C2^")}
    for k, (key, (name, style)) in enumerate(columns.items()):
        places = [names.index(of) + 0.25 * (k - 1) for of in inside.of]
        right.plot(np.exp(inside[key]), places, style, ms=2, mew=0, alpha=0.6, label=name)
    right.axvline(1.0, color="k", lw=0.8)
    right.set(xscale="log", xlabel="work at the threshold over what was said", yticks=range(len(names)))
    right.set_yticklabels([_shown(name) for name in names], fontsize="small")
    for axis, ticks in (
        (left.xaxis, (0.9, 1, 1.1, 1.2, 1.3, 1.4)),
        (left.yaxis, (0.9, 1, 1.1, 1.2, 1.3, 1.4)),
        (right.xaxis, (0.05, 0.2, 1, 5)),
    ):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
        axis.set_ticks(ticks)
    plot.letter_panels((left, right))
    for axis in (left, right):
        plot.legend_under(axis, 0.48)
    return drawn


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--into", type=Path, help="folder of one-state.png")
    given = parser.parse_args(arguments)
    rows = read()
    if given.into:
        with plot.written_as(["png"]):
            plot.save_figure(figure(rows), given.into / "one-state", own=True)
    sys.stdout.write("\n".join(tables(rows)) + "\n")


if __name__ == "__main__":
    main()
