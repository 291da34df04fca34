"""What became of the statements of docs/studies/pull_off.md, from the cycles of :mod:`docs.studies.pull_off`.

Lengths of one surface are in units of its λ_L, so that grids of different numbers of points compare.  States count
where 10 λ_s² or more touch.  Bounds are those that stood in docs/studies/pull_off.md before the first run.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from pandas import DataFrame, Series
from scipy.stats import t

from continuum.maps.verdict.criteria import CRITERIA, RoughContact
from continuum.paper.points import ENOUGH
from continuum.show import plot
from docs.studies.judgement import BETTER, BIAS, SCATTER, TOO_BIASED, TOO_MUCH, Mean, scatter
from docs.studies.law import Real
from docs.studies.persson import PerssonContact

FILE = "law-pull-off.csv"
PART = 0.05
"""s at which w_5 is."""
HALF, DIVIDING = 0.5, 1.25
CONVERGED = 1.1
WIDE, GRID = 0.15, 0.05
FEWEST = 4
"""Surfaces below which nothing is told."""
UPPER = (0.778, 1.1)
"""Works, in U of λ_L/λ_s = 8, at which the stress is compared."""
UPPEST = (0.55, *UPPER)
"""The three largest works, in the same unit."""
SMOOTH = (2.5, 3.0, 4.0)
"""Powers of w by which the stress may rise without a step."""
PERIOD = 4.0
THEORIES = {
    "Pastewka and Robbins, Eq. (6)": "pastewka-robbins", "U: the law, and half the energy": "half-conformal-energy",
    "Fuller and Tabor": "fuller-tabor", "long waves only": "bearing-area", "bearing area, any spectrum": "",
}  # fmt: skip


def reduced(rows: DataFrame) -> DataFrame:
    """Cycles with lengths over λ_L, the part s, and whether they count."""
    unit = rows.lambda_L
    found = rows.assign(
        width=(unit / rows.lambda_s).round(), height=rows.height / unit, curvature=rows.curvature * unit,
        range=rows.range / unit, work=rows.work / unit, energy=rows.energy / unit, gap=rows.gap / unit,
        part=rows.stress * rows.range / rows.work,
        counts=rows.area_rep * rows.n**2 >= ENOUGH * rows.lambda_s**2,
    )  # fmt: skip
    middle = found[found.width == 8].groupby(["hurst", "seed"]).energy.first()
    of_middle = middle.reindex(list(zip(found.hurst, found.seed, strict=True))).to_numpy()
    return found.assign(over_energy=found.work / found.energy, level=(found.work / of_middle).round(3))


def work_at(cycles: DataFrame, part: float = PART) -> float:
    """Work at which s of a surface is so much, between two works that count; NaN where there are none."""
    each = cycles.sort_values("work")
    for (_, one), (_, other) in pairwise(each.iterrows()):
        if one.counts and other.counts and one.part < part <= other.part:
            share = np.log(part / one.part) / np.log(other.part / one.part)
            return float(one.work * (other.work / one.work) ** share)
    return float("nan")


def dividing_work(cycles: DataFrame) -> float:
    """Work at which the line through the stresses of the three largest works is zero; NaN unless they count."""
    last = cycles.sort_values("work").tail(3)
    if len(last) < 3 or not last.counts.all():
        return float("nan")
    rise, foot = np.polyfit(last.work, last.stress, 1)
    return float(-foot / rise) if rise > 0 else float("nan")


def dividing_of_power(power: float) -> float:
    """w_0/U of stresses that go as a power of w, at the three largest works that were stated."""
    works = np.array(UPPEST)
    rise, foot = np.polyfit(works, works**power, 1)
    return float(-foot / rise)


def mean_of(each: Real) -> Mean:
    """Mean over surfaces as a factor; NaN of none."""
    return Mean.of(each) if len(each) else Mean(np.nan, np.nan, np.nan, 0)


def surfaces(rows: DataFrame, part: float = PART) -> DataFrame:
    """One row for each surface: its w_5, or the work at another s, its w_0 and what it is."""
    kept = ["height", "slope", "curvature", "energy", "range"]
    return DataFrame([
        {"hurst": hurst, "width": width, "seed": seed, **each.iloc[0][kept], "work": work_at(each, part),
         "dividing": dividing_work(each)}
        for (hurst, width, seed), each in rows.groupby(["hurst", "width", "seed"])
    ])  # fmt: skip


def theory_work(row: Series, key: str) -> float:
    """Work of a theory for a surface; the contact is that at w_5."""
    if not key:
        made = PerssonContact.self_affine(row.hurst, row.slope, 1 / row.width, 1.0, PERIOD, 0.5)
        return made.bearing_area_threshold(row.range)
    return float(row.work / CRITERIA[key](contact(row)).margin)


def contact(row: Series) -> RoughContact:
    return RoughContact(
        row.height, row.slope, row.curvature, row.work, row.range, conformal_energy=row.energy, roll_off=1.0
    )


def exponents(of: DataFrame, works: Real) -> Real:
    """Power of λ_s in a work, surface by surface, of those that have it at every λ_s."""
    each = of.assign(value=np.log(works)).dropna(subset=["value"])
    whole = [part for _, part in each.groupby("seed") if len(part) == of.width.nunique() > 2]
    return np.array([-np.polyfit(np.log(part.width), part.value, 1)[0] for part in whole])


def interval(each: Real) -> tuple[float, float]:
    """Mean and half the 95 % interval."""
    half = t.ppf(0.975, len(each) - 1) * np.std(each, ddof=1) / np.sqrt(len(each)) if len(each) > 1 else np.inf
    return (float(np.mean(each)) if len(each) else np.nan), float(half)


def word(count: int, held: bool, refuted: bool, between: str = "held with a remark") -> str:
    """What became of a statement of so many surfaces."""
    if count < FEWEST:
        return "not tested"
    return "held" if held else "refuted" if refuted else between


def _of_seeds(of: DataFrame, column: str) -> Real:
    found: Real = of.dropna(subset=[column]).groupby("seed")[column].mean().to_numpy()
    return found


def judged(rows: DataFrame) -> Iterator[tuple[str, str, str]]:
    """Each statement: what it says, what was found, and what became of it; none of the law where no w_5 was found."""
    every = surfaces(rows)
    yield _divided(every)
    found = every.dropna(subset=["work"])
    if len(found):
        yield from _of_the_law(found.assign(left=np.log(found.work / found.energy)))
    yield from _of_the_critics(rows)
    full = rows.dropna(subset=["area_zero"]).area_zero
    yield ("expected: below 0.6 touches at zero load", f"{full.min():.2f} to {full.max():.2f}",
           word(rows.seed.nunique(), full.max() < 0.6, full.max() >= 0.6))  # fmt: skip


def _divided(every: DataFrame) -> tuple[str, str, str]:
    lines = every.assign(ratio=np.log(every.dividing / every.energy))
    means = {hurst: mean_of(_of_seeds(of, "ratio")) for hurst, of in lines.groupby("hurst")}
    near = all(1 / DIVIDING <= m.value / HALF <= DIVIDING for m in means.values())
    off = any(m.low / HALF > DIVIDING or m.high / HALF < 1 / DIVIDING for m in means.values())
    # The works at which the line is drawn decide: stresses that go as a power of w, with no step, give nearly the same.
    smooth = [dividing_of_power(power) for power in SMOOTH]
    free = all(1 / DIVIDING <= ratio / HALF <= DIVIDING for ratio in smooth)
    what = "not tested" if free else word(min(m.surfaces for m in means.values()), near, off)
    powers = ", ".join(f"{ratio:.2f} of w^{power:g}" for power, ratio in zip(SMOOTH, smooth, strict=True))
    return "Müser's group: w_0/U is 1/2", f"{_listed(means, 'H = {:g}')}; without any step {powers}", what


def _of_the_law(found: DataFrame) -> Iterator[tuple[str, str, str]]:
    spread = scatter(found.left.to_numpy(), found.seed.to_numpy())
    apart = {name: _biases(found, column) for name, column in (("H = {:g}", "hurst"), ("λ_L/λ_s = {:g}", "width"))}
    single = [m for each in apart.values() for m in each.values()]
    level = mean_of(_of_seeds(found, "left"))
    near = spread <= SCATTER and all(1 / BIAS <= m.value <= BIAS for m in single)
    off = any(abs(np.log(m.value)) > np.log(TOO_BIASED) and m.excludes(BIAS) for m in single)
    said = f"{level}, scatter {spread:.3f}; over its mean: {', '.join(_listed(m, name) for name, m in apart.items())}"
    yield "the law: w_5/U is one number", said, word(level.surfaces, near, spread > TOO_MUCH or off)
    sums = {0: found.height**2, 1: found.energy, 2: found.slope**2, 4: found.curvature**2}
    by = {p: scatter(np.log(found.work / m).to_numpy(), found.seed.to_numpy()) for p, m in sums.items()}
    least = min(by.values())
    said = ", ".join(f"{p}: {value:.3f}" for p, value in by.items())
    what = word(level.surfaces, by[1] == least, by[1] > least + BETTER)
    yield "the law: p = 1 has the least scatter", said, what


def _of_the_critics(rows: DataFrame) -> Iterator[tuple[str, str, str]]:
    for hurst, name in ((0.8, "critics: σ converges at H = 0.8"), (0.3, "critics: σ goes on falling at H = 0.3")):
        ratios = {work: mean_of(shortened(rows, hurst, work)) for work in UPPER}
        if hurst > 0.5:
            held = all(1 / CONVERGED <= m.value <= CONVERGED for m in ratios.values())
            refuted = any(m.excludes(CONVERGED) for m in ratios.values())
            # Where U itself still grows, a stress that follows U has not converged either.
            growth = mean_of(grown(rows, hurst))
            aside = f"; U at 16 over U at 8: {growth}"
        else:
            aside = ""
            held, refuted = all(m.high < 1 for m in ratios.values()), any(m.low > 1 for m in ratios.values())
        said = ", ".join(f"at {work:g} U: {m} of {m.surfaces}" for work, m in ratios.items())
        what = word(min(m.surfaces for m in ratios.values()), held, refuted)
        if what == "refuted" and aside and growth.value > 1 + GRID:
            what = "not decided"
        yield name, f"σ at 16 over σ at 8 {said}{aside}", what


def grown(rows: DataFrame, hurst: float, widths: tuple[float, float] = (8, 16)) -> Real:
    """ln of U at the second λ_L/λ_s over that at the first, of each surface."""
    energies = rows[rows.hurst == hurst].pivot_table(index="seed", columns="width", values="energy")
    found: Real = np.log(energies[widths[1]] / energies[widths[0]]).dropna().to_numpy()
    return found


def _biases(found: DataFrame, column: str) -> dict[float, Mean]:
    """Mean of each value of a column over that of all, surface by surface."""
    every = found.groupby("seed").left.mean()
    return {
        value: mean_of((part.groupby("seed").left.mean() - every).dropna().to_numpy())
        for value, part in found.groupby(column)
    }


def _listed(means: dict[float, Mean], name: str) -> str:
    return ", ".join(f"{name.format(value)}: {mean}" for value, mean in means.items())


def shortened(rows: DataFrame, hurst: float, level: float, widths: tuple[float, float] = (8, 16)) -> Real:
    """ln of σ at the second λ_L/λ_s over that at the first, at one work, of the surfaces where both count."""
    of = rows[(rows.hurst == hurst) & (rows.level == level) & rows.counts]
    first, second = (of[of.width == width].set_index("seed").stress for width in widths)
    found: Real = np.log(second / first).dropna().to_numpy()
    return found


def exponent_lines(rows: DataFrame, part: float = PART) -> Iterator[str]:
    """Exponents of λ_s in the work at an s, and how far each theory is off on the same surfaces."""
    found = {hurst: of.reset_index(drop=True) for hurst, of in surfaces(rows, part).groupby("hurst")}
    hursts = sorted(found, reverse=True)
    yield f"| exponent of λ_s in w at s = {part:g} | {' | '.join(f'H = {h:g}' for h in hursts)} |"
    yield f"|---|{'---|' * len(hursts)}"
    measured = {h: exponents(found[h], found[h].work.to_numpy()) for h in hursts}
    cells = ["{:+.2f} ± {:.2f}, {} surfaces".format(*interval(measured[h]), len(measured[h])) for h in hursts]
    yield f"| measured | {' | '.join(cells)} |"
    for name, key in THEORIES.items():
        cells = []
        for h in hursts:
            of = found[h].dropna(subset=["work"])
            said = exponents(of, np.array([theory_work(row, key) for _, row in of.iterrows()]))
            each = exponents(of, of.work.to_numpy()) - said
            off, half = interval(each)
            what = word(len(each), abs(off) <= half <= WIDE, abs(off) - half > GRID, "not decided")
            inside = ""
            if key == "pastewka-robbins":
                inside = (
                    f"; in its range {sum(CRITERIA[key](contact(row)).valid for _, row in of.iterrows())}/{len(of)}"
                )
            cells.append(
                f"{np.mean(said) if len(said) else np.nan:+.2f}, off by {off:+.2f} ± {half:.2f}: **{what}**{inside}"
            )
        yield f"| {name} | {' | '.join(cells)} |"


def stress_lines(rows: DataFrame) -> Iterator[str]:
    """s at each work, with the number of surfaces that count; w_5/U and w_0/U."""
    levels = sorted(rows.level.unique())
    yield f"| H | λ_L/λ_s | {' | '.join(f's at {w:g} U' for w in levels)} | w_5/U | w_0/U |"
    yield f"|---|---|{'---|' * len(levels)}---|---|"
    every = surfaces(rows)
    for (hurst, width), of in rows.groupby(["hurst", "width"]):
        cells = []
        for level in levels:
            each = of[of.level == level]
            cells.append(
                f"{np.exp(np.log(each.part).mean()):.3f} ({each.counts.sum()}/{len(each)})" if len(each) else "-"
            )
        mine = every[(every.hurst == hurst) & (every.width == width)]
        ends = [mean_of(np.log((mine[name] / mine.energy).dropna())) for name in ("work", "dividing")]
        yield f"| {hurst:g} | {width:g} | {' | '.join(cells)} | {' | '.join(map(str, ends))} |"


def tables(cycles: DataFrame) -> str:
    """The tables of docs/studies/pull_off.md."""
    rows = reduced(cycles)
    head = [
        f"{len(rows)} cycles of {rows.seed.nunique()} surfaces, {int(rows.counts.sum())} with enough contacts at the "
        f"largest tension; {int(rows.failed.sum())} states not converged; last halving of the step: "
        f"{rows.change.median():.1%} in the median, {rows.change.max():.0%} at most.", "",
        "| statement | found | |", "|---|---|---|",
    ]  # fmt: skip
    return "\n".join([
        *head, *(f"| {name} | {found} | **{what}** |" for name, found, what in judged(rows)), "",
        *exponent_lines(rows), "", *stress_lines(rows),
    ])  # fmt: skip


@plot.styled
def drawn(rows: DataFrame) -> Figure:
    """s against w/U of every cycle, and the stress at one work against λ_s, surface by surface."""
    made, (left, right) = plot.new_axes(plot.PAGE, 3.3, columns=2)
    widths = sorted(rows.width.unique())
    marks = dict(zip(widths, "o^s", strict=False))
    for i, (hurst, part) in enumerate(sorted(rows.groupby("hurst"), reverse=True)):
        for width, of in part.groupby("width"):
            for counts, each in of.groupby("counts"):
                left.plot(each.over_energy, each.part, marks[width], ms=3.5, color=f"C{i}", alpha=0.7,
                          mfc=f"C{i}" if counts else "none",
                          label=rf"$H = {hurst:g}$, $\lambda_L/\lambda_s = {width:g}$" if counts else None)  # fmt: skip
        for level, style in zip(UPPER, ("o--", "s-"), strict=True):
            label: str | None = rf"$H = {hurst:g}$, $w = {level:g}\,U$ of $\lambda_L/\lambda_s = 8$"
            for _, each in part[(part.level == level) & part.counts].groupby("seed"):
                stress = each.set_index("width").stress
                if 8 in stress.index:
                    right.plot(1 / stress.index, stress / stress[8], style, color=f"C{i}", ms=3, lw=0.8, label=label)
                    label = None
    left.axhline(PART, color="0.7", lw=0.7, zorder=-1)
    left.axvline(HALF, color="0.7", lw=0.7, zorder=-1)
    right.axhline(1, color="0.7", lw=0.7, zorder=-1)
    left.set(xscale="log", yscale="log", xlabel="$w/U$", ylabel=r"pull-off stress, $s = \sigma\,\Delta r/w$")
    right.set(xscale="log", yscale="log", xlabel=r"$\lambda_s/\lambda_L$",
              ylabel=r"$\sigma$ over that at $\lambda_s = \lambda_L/8$")  # fmt: skip
    plot.log_ticks(left, right)
    right.xaxis.set_minor_locator(NullLocator())
    right.set_xticks([1 / width for width in widths], [f"1/{width:g}" for width in widths])
    plot.letter_panels((left, right))
    for axis in (left, right):
        plot.legend_under(axis, 0.48)
    return made


def figure(cycles: DataFrame, path: Path) -> None:
    with plot.written_as(["png"]):
        plot.save_figure(drawn(reduced(cycles)), path, own=True)
