"""The law of stickiness judged: thresholds of surfaces that made nothing of it, against what was said before.

``python -m docs.studies.judgement results/law-reduced results/law --into docs/measured`` prints what became of each
statement, and writes ``law.csv.gz`` (all thresholds) and ``law.png``.  Without folders it reads that file.

One table of bounds, as they stand in docs/studies/judgement.md.  Means are over surfaces (seeds), with 95 %
intervals from Student's t; the logarithm of w is what scatters.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray
from pandas import DataFrame, Series, concat, read_csv
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.special import expit
from scipy.stats import t

from continuum.model.surfaces import SelfAffineSurface
from continuum.paper.points import ENOUGH, sweep_points
from continuum.show import plot
from continuum.store.sweeps.collect import collect
from docs.studies.law import PLATEAU, Real, fit, thresholds
from docs.studies.threshold_of_atoms import AREA, RANGE

MEASURED = Path(__file__).parents[2] / "docs" / "measured"
POWERS = (0, 1, 2, 3, 4)
BETWEEN = (0.5, 0.75, 1.25, 1.5)
"""Moments that nothing was said of, to see how sharply p = 1 is told."""
EVERY = tuple(sorted((*POWERS, *BETWEEN)))
SCALES = {"h_rms": "height", "δh = h'²/h''": "change", "λ_s h'": "wave", "U/E*": "energy"}
SHAPES = ("spline", "exponential")
SCATTER, TOO_MUCH = 1.15, 1.25
BIAS, TOO_BIASED = 1.07, 1.15
LEVEL = 1.15
BETTER = 0.02
EXPONENT = 0.1
SURFACES, COUNT = 6, 10


def thresholds_of(folder: Path) -> DataFrame:
    """The thresholds that a sweep found, a row each, with the moments of their surfaces; lengths in a0."""
    table = collect(folder)
    points = sweep_points(table).query("valid")
    moments = {}
    for key in table.keys:
        surface, grid = SelfAffineSurface.model_validate(table.given(key, "surface")), table.grid(key)
        made = (grid, surface)
        if made not in moments:
            power = np.abs(grid.forward(surface.build(grid))) ** 2 * grid.mode_weights
            power[0, 0] = 0.0
            q = np.where(grid.wavenumber > 0, grid.wavenumber, 1.0)
            moments[made] = [float((q**p * power).sum()) for p in EVERY]
        moments[key] = moments[made]
    each = np.array([moments[table.keys[i]] for i in points.system])
    return DataFrame({
        "n": np.sqrt(points.area).round().astype(int), "shape": points["shape"], "hurst": points.hurst,
        "lambda_s": points.lambda_s, "lambda_L": points.lambda_L, "seed": points.seed.astype(int),
        "area": points.target, "height": points.rms_height, "slope": points.rms_slope,
        "curvature": points.rms_curvature, "range": points.effective_range,
        # The state is within the bracket of 2 %; ln(load_att/load_rep) rises as ln w.
        "work": points.work_of_adhesion * points.load_rep / points.load_att,
        **{f"moment_{p:g}": each[:, i] for i, p in enumerate(EVERY)},
    })  # fmt: skip


def with_ratios(found: DataFrame) -> DataFrame:
    """What the statements are about: Δ, w over U, over U F, and lengths that could measure the range."""
    laws = {shape: fit(thresholds(shape)) for shape in SHAPES}
    energy = found.moment_1 / 4
    law = np.array([laws[shape](r) for shape, r in zip(found["shape"], found.range / found.height, strict=True)])
    return found.assign(
        width=found.lambda_L / found.lambda_s, delta=(found.range / found.height).round(2), energy=energy,
        change=found.slope**2 / found.curvature, wave=found.lambda_s * found.slope,
        over_energy=found.work / energy, left=np.log(found.work / (energy * law)),
    )  # fmt: skip


@dataclass(frozen=True)
class Mean:
    """A mean over surfaces of a logarithm, as a factor, with its 95 % interval."""

    value: float
    low: float
    high: float
    surfaces: int

    @classmethod
    def of(cls, each: Real) -> Mean:
        """Of one logarithm for each surface."""
        mean, n = float(np.mean(each)), len(each)
        half = float(t.ppf(0.975, n - 1) * np.std(each, ddof=1) / np.sqrt(n)) if n > 1 else np.inf
        return cls(float(np.exp(mean)), float(np.exp(mean - half)), float(np.exp(mean + half)), n)

    def __str__(self) -> str:
        return f"{self.value:.2f} ({self.low:.2f} to {self.high:.2f})"

    def excludes(self, factor: float) -> bool:
        """Whether the interval lies wholly beyond a factor, up or down."""
        return self.low > factor or self.high < 1 / factor


def spread(values: Series) -> str:
    """Mean and standard deviation over surfaces."""
    if values.empty:
        return "-"
    return f"{values.mean():.3f}" + (f" ± {values.std():.3f}" if len(values) > 1 else "")


def verdict(values: Real, said: float, bound: float) -> str:
    """Of a mean over surfaces: refuted where it is off by more than the bound and two standard errors."""
    off = abs(values.mean() - said)
    if off <= bound:
        return "held"
    error = values.std(ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.inf
    return "refuted" if off > bound + 2 * error else "undecided"


def held(holds: bool) -> str:
    """The verdict on a statement that is true or not."""
    return "held" if holds else "refuted"


def scatter(left: Real, seeds: Real) -> float:
    """Factor of the root-mean-square of what is left over with one factor for each surface."""
    rest = np.array(left, dtype=float)
    for seed in np.unique(seeds):
        rest[seeds == seed] -= rest[seeds == seed].mean()
    return float(np.exp(np.sqrt(np.mean(rest**2))))


def refitted(rows: DataFrame, work: Real, reach: Real) -> float:
    """Scatter of ln of a reduced work about its own F of a reduced range: level, D and m for each shape, one factor for
    each surface."""
    of_shape = np.array([SHAPES.index(shape) for shape in rows["shape"]])
    # Levels and factors are linear: what is left over is what lies beside all of them.
    linear = np.column_stack([*(of_shape == i for i in range(len(SHAPES))), *(rows.seed == s for s in set(rows.seed))])
    vectors, sizes, _ = np.linalg.svd(linear.astype(float), full_matrices=False)
    spanned = vectors[:, sizes > 1e-9 * sizes[0]]

    log_work, log_reach = np.log(work), np.log(reach)
    middle = np.mean(log_reach)

    def rest(free: Real) -> Real:
        place, power = free.reshape(2, len(SHAPES))[:, of_shape]
        found: Real = log_work + np.log1p(np.exp(np.clip(power, -3, 3) * (log_reach - place)))
        return found - spanned @ (spanned.T @ found)

    def slopes(free: Real) -> Real:
        place, power = free.reshape(2, len(SHAPES))[:, of_shape]
        cut, far = np.clip(power, -3, 3), log_reach - place
        parts = expit(cut * far) * np.array([-cut, (cut == power) * far])
        found: Real = np.column_stack([part * (of_shape == i) for part in parts for i in range(len(SHAPES))])
        return found - spanned @ (spanned.T @ found)

    found = [
        least_squares(rest, np.repeat([middle + place, power], len(SHAPES)), slopes)
        for place, power in ((0.0, 1.0), (-2.0, 0.5), (0.0, 1.5))
    ]
    return float(np.exp(np.sqrt(min(np.mean(best.fun**2) for best in found))))


def biases(rows: DataFrame, column: str) -> dict[float, Mean]:
    """Mean of w/(U F) at each value of a column over that of all, surface by surface."""
    every = rows.groupby("seed").left.mean()
    return {
        float(value): Mean.of((part.groupby("seed").left.mean() - every).dropna().to_numpy())
        for value, part in rows.groupby(column)
        if len(part) >= COUNT
    }


def exponent(rows: DataFrame) -> Mean:
    """Exponent of U λ_L/h² in w λ_L/h² at one range and shape, surface by surface; mean and interval are no factors."""
    each = []
    for _, part in rows.groupby("seed"):
        scale = np.log(part.lambda_L / part.height**2)
        x, y = np.log(part.energy) + scale, np.log(part.work) + scale
        group = part.groupby(["shape", "delta"]).ngroup()
        x, y = x - x.groupby(group).transform("mean"), y - y.groupby(group).transform("mean")
        each.append(float((x * y).sum() / (x * x).sum()))
    values = np.array(each)
    half = float(t.ppf(0.975, len(each) - 1) * values.std(ddof=1) / np.sqrt(len(each)))
    return Mean(float(values.mean()), float(values.mean() - half), float(values.mean() + half), len(each))


def word(held: bool, refuted: bool, rows: DataFrame) -> str:
    """What became of a statement."""
    if rows.seed.nunique() < SURFACES or len(rows) < COUNT:
        return "not tested"
    return "held" if held else "refuted" if refuted else "held with a remark"


Statement = tuple[str, str, str]


def judged(rows: DataFrame) -> list[Statement]:
    """Each statement of docs/studies/judgement.md: what it says, what was found, and what became of it."""
    found: list[Statement] = []
    all_of_them = scatter(rows.left.to_numpy(), rows.seed.to_numpy())
    shapes = {s: scatter(p.left.to_numpy(), p.seed.to_numpy()) for s, p in rows.groupby("shape")}
    said = f"{all_of_them:.3f}; " + ", ".join(f"{shape} {value:.3f}" for shape, value in shapes.items())
    worst = max(shapes.values())
    found.append(("one F for all H and λ_s: scatter", said, word(worst <= SCATTER, worst > TOO_MUCH, rows)))

    for name, column in (("H", "hurst"), ("λ_L/λ_s", "width")):
        means = biases(rows, column)
        if len(means) < 2:
            found.append((f"no {name} for itself", "one value only", "not tested"))
            continue
        held = all(1 / BIAS <= m.value <= BIAS for m in means.values())
        refuted = any(not 1 / TOO_BIASED <= m.value <= TOO_BIASED and m.excludes(BIAS) for m in means.values())
        said = ", ".join(f"{value:g}: {mean}" for value, mean in means.items())
        found.append((f"no {name} for itself: w/(U F) over its mean", said, word(held, refuted, rows)))

    levels = {
        (shape, delta): Mean.of(part.groupby("seed").left.mean().to_numpy())
        for (shape, delta), part in rows.groupby(["shape", "delta"])
    }
    held = all(1 / LEVEL <= m.value <= LEVEL for m in levels.values())
    said = ", ".join(f"{shape} {delta:g}: {mean}" for (shape, delta), mean in levels.items())
    refuted = any(m.excludes(LEVEL) for m in levels.values())
    found.append(("the half, D and m: w/(U F)", said, word(held, refuted, rows)))

    every = by_moment(rows)
    scales = {p: every[p] for p in POWERS}
    best, one = min(scales, key=lambda p: scales[p]), scales[1]
    said = ", ".join(f"{p:g}: {value:.3f}" for p, value in every.items())
    refuted = scales[best] < one - BETTER
    found.append(("p = 1 has the least scatter", said, word(best == 1, refuted, rows)))

    power = exponent(rows)
    said = f"{power.value:.3f} ({power.low:.3f} to {power.high:.3f})"
    held = power.low <= 1 <= power.high and power.high - power.low <= 2 * EXPONENT
    refuted = power.low > 1 + EXPONENT or power.high < 1 - EXPONENT
    found.append(("the exponent of U is 1", said, word(held, refuted, rows)))

    lengths = {
        name: refitted(rows, (rows.work / rows.energy).to_numpy(), (rows.range / rows[column]).to_numpy())
        for name, column in SCALES.items()
    }
    least = min(lengths, key=lambda name: lengths[name])
    said = ", ".join(f"{name}: {value:.3f}" for name, value in lengths.items())
    refuted = lengths[least] < lengths["h_rms"] - BETTER
    found.append(("h_rms measures the range: scatter", said, word(least == "h_rms", refuted, rows)))
    return found


def by_moment(rows: DataFrame) -> dict[float, float]:
    """Scatter of w over each moment Σ q^p |h|², in units of λ_L and h_rms, about its own F."""
    reach = (rows.range / rows.height).to_numpy()
    return {
        p: refitted(
            rows, (rows.work * rows.lambda_L.astype(float) ** (1 - p) / rows[f"moment_{p:g}"]).to_numpy(), reach
        )
        for p in EVERY
    }


def moment(rows: DataFrame) -> Mean:
    """p of the moment that leaves the least scatter, with 95 % of those of surfaces drawn anew from these.

    As in :func:`by_moment`, for thresholds at few ranges, so that F is a level at each of them and all is linear; the
    same thresholds of each surface.  ln of a moment between two that are stored is that of a cubic spline.
    """
    powers = np.array(EVERY)
    scale = np.log(rows.lambda_L.astype(float)).to_numpy()[:, None] * (1 - powers)
    logs = scale - np.log(rows[[f"moment_{p:g}" for p in EVERY]].to_numpy()) + np.log(rows.work.to_numpy())[:, None]
    fine = np.linspace(0.5, 1.5, 501)
    # Less the surface's own level.
    left = DataFrame(CubicSpline(powers, logs, axis=1)(fine), index=rows.index)
    left -= left.groupby(rows.seed).transform("mean")
    squares = (left**2).groupby(rows.seed).sum().to_numpy()
    levels = left.groupby([rows.seed, rows["shape"], rows.delta]).mean().to_numpy().reshape(len(squares), -1, fine.size)
    count, groups = len(squares), len(rows) / len(squares) / levels.shape[1]

    def least(chosen: NDArray[np.int64]) -> float:
        common = count * groups * (levels[chosen].mean(axis=0) ** 2).sum(axis=0)
        return float(fine[np.argmin(squares[chosen].sum(axis=0) - common)])

    again = [least(drawn) for drawn in np.random.default_rng(1).integers(count, size=(4000, count))]
    return Mean(least(np.arange(count)), *np.quantile(again, [0.025, 0.975]).tolist(), count)


def tables(rows: DataFrame) -> str:
    """The tables of docs/studies/judgement.md: one for each area and size."""
    text = []
    for (area, n), part in rows.groupby(["area", "n"]):
        text += [f"{area:.0%} of the area, {n}²: {len(part)} thresholds, {part.seed.nunique()} surfaces", ""]
        text += ["| statement | found | |", "|---|---|---|"]
        text += [f"| {name} | {said} | **{what}** |" for name, said, what in judged(part)] + [""]
    return "\n".join([*text, *resolved(rows[rows.area == rows.area.min()]), *by_area(rows)])


def resolved(rows: DataFrame) -> list[str]:
    """Table of what grid and bandwidth do to w/(U F), each with the other kept, on the same surfaces."""
    text = ["| 1% of the area | thresholds | w/(U F), second over first | at each H |", "|---|---|---|---|"]
    same = ["seed", "shape", "hurst", "delta"]
    kinds = {kind: part.set_index(same).left for kind, part in rows.groupby(["width", "lambda_s"])}
    for (one, first), (other, second) in itertools.combinations(kinds.items(), 2):
        if (one[0] == other[0]) == (one[1] == other[1]):
            continue
        rise = (second - first).dropna()
        each = {h: np.exp(part.mean()) for h, part in rise.groupby("hurst")}
        text.append(
            f"| λ_L/λ_s {one[0]:g}, {one[1]:g} points to λ_s; {other[0]:g}, {other[1]:g} | {len(rise)} | "
            f"{Mean.of(rise.groupby('seed').mean().to_numpy())} | "
            f"{', '.join(f'{h:g}: {factor:.2f}' for h, factor in each.items())} |"
        )
    return [*text, ""] if len(text) > 2 else []


def larger(rows: DataFrame) -> dict[tuple[float, str, float], Mean]:
    """w at an area over w at the smallest one, on the same surfaces: by area, shape and range."""
    same = ["n", "seed", "shape", "hurst", "delta", "lambda_s"]
    every = {area: np.log(part.set_index(same).work) for area, part in rows.groupby("area")}
    least = min(every)
    return {
        (area, *kind): Mean.of(part.groupby("seed").mean().to_numpy())
        for area in sorted(set(every) - {least})
        for kind, part in (every[area] - every[least]).dropna().groupby(["shape", "delta"])
    }


def by_area(rows: DataFrame) -> list[str]:
    """Table of what a larger area does to w at the threshold."""
    found = larger(rows)
    kinds = sorted({key[1:] for key in found})
    names, least = " | ".join(f"{shape} {delta:g}" for shape, delta in kinds), rows.area.min()
    text = [f"| w at the threshold over that at {least:.0%} of the area | {names} |", "|---" * (len(kinds) + 1) + "|"]
    for area in sorted({key[0] for key in found}):
        text.append(f"| {area:.0%} | {' | '.join(str(found[area, *kind]) for kind in kinds)} |")
    return [*text, ""] if found else []


@plot.styled
def figure(rows: DataFrame) -> Figure:
    """w/U against the range, and the scatter about each moment of the spectrum."""
    laws = {shape: fit(thresholds(shape)) for shape in SHAPES}
    drawn, (left, right) = plot.new_axes(plot.PAGE, 3.3, columns=2)
    x = np.geomspace(0.05, 3, 100)
    short = with_ratios(read_csv(MEASURED / "law-short.csv"))
    shown = concat([rows[(rows.area == rows.area.min()) & (rows.n == rows.n.max())], short])
    for shape, mark, name, line in zip(SHAPES, "os", ("circles", "squares"), ("-", "--"), strict=True):
        left.plot(x, laws[shape](x), "k" + line, label=f"{shape}, {name}")
        for i, (hurst, part) in enumerate(shown[shown["shape"] == shape].groupby("hurst")):
            shift = 1 + 0.04 * (i - 2)  # points of one range beside one another
            left.plot(part.delta * shift, part.over_energy, mark, ms=3, alpha=0.6, color=f"C{i}",
                      label=rf"$H$ = {hurst:g}" if shape == "spline" else None)  # fmt: skip
    atoms = read_csv(MEASURED / "threshold-atoms.csv").query("rung == 'atoms'")
    reach = np.full(len(atoms), RANGE)
    left.plot(reach, atoms.over_energy, "k*", ms=7, mfc="w", mew=0.8, label=f"atoms, {AREA:.0%} of area")
    left.set(xscale="log", yscale="log", xlabel=r"range of the attraction $\Delta r/h_\mathrm{rms}$",
             ylabel="work of adhesion at the threshold, $w/U$")  # fmt: skip
    for axis, ticks in ((left.xaxis, (0.05, 0.1, 0.2, 0.5, 1, 2)), (left.yaxis, (0.1, 0.2, 0.3, 0.4, 0.5))):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
        axis.set_ticks(ticks)
    for i, ((area, n), part) in enumerate(rows.groupby(["area", "n"])):
        found = by_moment(part)
        right.plot(list(found), list(found.values()), "o-", color=f"C{i}", ms=8 - 2 * i, label=f"{area:.0%} of {n}²")
    right.set(xlabel=r"moment $p$ of $\Sigma\, q^p |h_q|^2$", ylabel="scatter of $w$ over it, a factor")
    right.margins(0.12, 0.2)
    measures = right.secondary_xaxis("top")
    measures.set_xticks((0, 1, 2, 4), ("height", "energy", "slope", "curvature"))
    measures.tick_params(direction="in", pad=-12)
    plot.letter_panels((left, right))
    for axis in (left, right):
        plot.legend_under(axis, 0.48)
    return drawn


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path, help="of the sweeps; none: docs/measured/law.csv.gz")
    parser.add_argument("--into", type=Path, help="folder of law.csv and law.png")
    given = parser.parse_args(arguments)
    stored = MEASURED / "law.csv.gz"
    raw = concat([thresholds_of(folder) for folder in given.folders]) if given.folders else read_csv(stored)
    rows = with_ratios(raw)
    if given.into:
        with plot.written_as(["png"]):
            plot.save_figure(figure(rows), given.into / "law", own=True)
        raw.to_csv(given.into / "law.csv.gz", index=False, float_format="%.6g", lineterminator="\n")
    sys.stdout.write(f"Only states with A_rep of {ENOUGH:g} λ_s² or more; F(0) = {PLATEAU}.\n\n{tables(rows)}\n")


if __name__ == "__main__":
    main()
