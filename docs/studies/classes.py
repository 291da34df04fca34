"""Verdicts on classes of surfaces against searches: right, undecided and wrong at works around the threshold.

``nice python -m docs.studies.classes --run`` makes surfaces of each class, with parameters that each draws, finds
their thresholds from one state without adhesion and by a search with adhesion, and adds to
``docs/measured/classes.csv`` what is missing there.  Without ``--run`` it prints the tables of
docs/studies/classes.md from that file: the verdicts at works of adhesion around the threshold of the search.
With ``--again`` all surfaces there are estimated anew.
With ``--alarms``: how many clean surfaces are called not Gaussian.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, TextIO

import numpy as np
from pandas import read_csv
from scipy.ndimage import gaussian_filter, grey_dilation

from continuum.maps.faults import summits_of
from continuum.maps.map import Topography
from continuum.maps.mending import detrend
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.on_grid import UnresolvedError
from continuum.maps.verdict.search import search_threshold
from continuum.maps.verdict.threshold import press_map
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine, moments
from continuum.solve.solution import NotConvergedError
from continuum.store.sheet import Sheet
from docs.studies.judgement import MEASURED

FILE = MEASURED / "classes.csv"
N, SURFACES = 256, 12
GRID = Grid.square(N)
FACTORS = (0.1, 0.3, 0.6, 1.6, 3.0, 10.0)
"""Works of adhesion over that at the threshold, at which verdicts are asked for."""
UNIT = 1e-9
"""Pixel in m, so that the maps are what an instrument gives; E* = 1 Pa."""
Rng = np.random.Generator


def scaled(heights: Real, rms_slope: float) -> Real:
    """Heights stretched to a slope."""
    return heights * rms_slope / moments(GRID, heights).rms_slope


def clean(rng: Rng) -> Real:
    """Self-affine and Gaussian."""
    lambda_s = float(rng.uniform(5, 12))
    surface = SelfAffine(
        float(rng.uniform(0.3, 0.9)), float(rng.uniform(0.04, 0.2)), lambda_s, float(rng.uniform(32, 64))
    )
    return surface.synthesise(GRID, rng)


def worn(rng: Rng) -> Real:
    """The highest tenth to two fifths flattened three- to thirtyfold."""
    heights = clean(rng)
    level, factor = np.quantile(heights, 1 - rng.uniform(0.1, 0.4)), np.exp(rng.uniform(np.log(3), np.log(30)))
    return np.where(heights > level, level + (heights - level) / factor, heights)


def honed(rng: Rng) -> Real:
    """A fine plateau, crossed by grooves in two directions."""
    x, y = np.mgrid[:N, :N]
    depth = np.zeros((N, N))
    for side in (1, -1):
        for _ in range(rng.integers(2, 5)):
            across = (x * rng.integers(1, 3) + side * y * rng.integers(1, 3) + rng.integers(0, N)) % N
            width = rng.uniform(2, 5)
            depth = np.maximum(depth, rng.uniform(0.5, 1) * np.exp(-(((across - N / 2) / width) ** 2)))
    fine = clean(rng)
    return scaled(fine - rng.uniform(4, 10) * fine.std() * depth, rng.uniform(0.05, 0.25))


def pitted(rng: Rng) -> Real:
    """A fine plateau with round pits."""
    x, y = np.mgrid[:N, :N]
    depth = np.zeros((N, N))
    for _ in range(rng.integers(8, 40)):
        centre = rng.uniform(0, N, 2)
        away = [(side - middle + N / 2) % N - N / 2 for side, middle in zip((x, y), centre, strict=True)]
        depth = np.maximum(depth, np.exp(-(away[0] ** 2 + away[1] ** 2) / rng.uniform(3, 7) ** 2))
    fine = clean(rng)
    return scaled(fine - rng.uniform(4, 10) * fine.std() * depth, rng.uniform(0.05, 0.25))


def beaded(rng: Rng) -> Real:
    """Overlapping caps of one radius, their tops not at one height."""
    x, y = np.mgrid[:N, :N]
    heights, radius = np.full((N, N), -np.inf), rng.uniform(40, 200)
    for _ in range(rng.integers(40, 150)):
        centre = rng.uniform(0, N, 2)
        away = [(side - middle + N / 2) % N - N / 2 for side, middle in zip((x, y), centre, strict=True)]
        heights = np.maximum(heights, rng.normal(0, 0.3) - (away[0] ** 2 + away[1] ** 2) / (2 * radius))
    return heights


def stretched(rng: Rng) -> Real:
    """Gaussian, slopes in one direction two to four times those in the other."""
    ratio = rng.uniform(2, 4)
    qx, qy = GRID.wavevectors
    q = np.maximum(np.hypot(qx / np.sqrt(ratio), qy * np.sqrt(ratio)), 2 * np.pi / rng.uniform(32, 48))
    density = np.where(q < 2 * np.pi / rng.uniform(7, 12), q ** -(1 + rng.uniform(0.4, 0.9)), 0.0)
    heights = GRID.inverse(GRID.forward(rng.normal(size=(N, N))) * density)
    return scaled(heights, rng.uniform(0.04, 0.2))


def rounded(rng: Rng) -> Real:
    """Seen by a blunt tip."""
    heights = clean(rng)
    reach = np.arange(-10, 11)
    tip = -(reach[:, None] ** 2 + reach[None, :] ** 2) / (2 * rng.uniform(15, 60))
    return grey_dilation(heights, structure=tip, mode="wrap")


def posts(rng: Rng) -> Real:
    """Flat posts of one width, with little roughness on top."""
    period = int(rng.choice([16, 32]))
    x = (np.arange(N) % period) < period * rng.uniform(0.3, 0.6)
    fine = clean(rng)
    return gaussian_filter(np.outer(x, x).astype(float) * rng.uniform(2, 6), 1.0, mode="wrap") + 0.2 * fine / fine.std()


def egg_box(rng: Rng) -> Real:
    """The sum of two waves, with a little roughness."""
    waves = int(rng.choice([4, 8]))
    x = np.cos(2 * np.pi * waves * np.arange(N) / N)
    fine = clean(rng)
    return rng.uniform(0.3, 1) * (x[:, None] + x[None, :]) + 0.05 * fine / fine.std()


def terraces(rng: Rng) -> Real:
    """Steps of one height."""
    heights = clean(rng)
    step = heights.std() * rng.uniform(0.5, 1.5)
    return gaussian_filter(step * np.round(heights / step), 1.0, mode="wrap")


CLASSES: dict[str, Callable[[Rng], Real]] = {
    "clean": clean, "worn": worn, "honed": honed, "pitted": pitted, "beaded": beaded, "stretched": stretched,
    "rounded": rounded, "posts": posts, "egg-box": egg_box, "terraces": terraces,
}  # fmt: skip


def surface(kind: str, seed: int) -> tuple[Topography, float]:
    """A surface of a class, and the range of the attraction on it."""
    rng = np.random.default_rng([list(CLASSES).index(kind), seed])
    heights = CLASSES[kind](rng)
    reach = float(rng.uniform(0.2, 1.6) * heights.std())
    return Topography(UNIT * heights, (UNIT * N, UNIT * N), True, f"{kind} {seed}"), UNIT * reach


class Row(NamedTuple):
    """Both thresholds of a surface; works in E* a pixel, the range in h_rms."""

    kind: str
    seed: int
    range: float
    work: float
    """By search; NaN where it found none for this range."""
    below: float
    above: float
    """The bracket of the search."""
    solves: int
    """Trial states of the search."""
    estimate: float
    low: float
    high: float
    chi: float
    muller: float
    patches: int
    how: str
    """How the search ended: "threshold", "jump-in", "longer range", or the error."""
    why: str
    """Why the interval of the estimate is wide."""

    def said(self, factor: float) -> str:
        """The verdict from one state at a factor from the threshold: right, undecided, or wrong."""
        work = factor * self.work
        if self.low <= work <= self.high:
            return "undecided"
        return "right" if (work > self.high) is (factor > 1) else "wrong"


def found(kind: str, seed: int) -> Row:
    """Both thresholds of a surface."""
    topography, reach = surface(kind, seed)
    pressed, scale = press_map(topography, Interface(1.0, 1.0, reach, None)), UNIT
    one = pressed.threshold()

    def row(how: str, work: float, below: float, above: float, solves: int) -> Row:
        """Of a search that ended so."""
        return Row(
            kind, seed, reach / float(topography.heights.std()), work, below, above, solves, one.work / scale,
            one.low / scale, one.high / scale, one.chi, one.muller, one.patches, how, "; ".join(one.why),
        )  # fmt: skip

    try:
        searched = search_threshold(pressed, one)
    except (UnresolvedError, NotConvergedError) as error:
        return row(type(error).__name__, np.nan, np.nan, np.nan, 0)
    if searched.range != reach:
        return row("longer range", np.nan, np.nan, np.nan, searched.solves)
    how = "jump-in" if searched.jumps else "threshold"
    return row(how, searched.work / scale, searched.low / scale, searched.high / scale, searched.solves)


def estimated_again(row: Row) -> Row:
    """A row with what one state says of it now, beside the threshold that was found."""
    topography, reach = surface(row.kind, row.seed)
    one = press_map(topography, Interface(1.0, 1.0, reach, None)).threshold()
    return row._replace(
        estimate=one.work / UNIT, low=one.low / UNIT, high=one.high / UNIT, chi=one.chi, muller=one.muller,
        patches=one.patches, why="; ".join(one.why),
    )  # fmt: skip


def write(file: TextIO, rows: Iterable[Row]) -> None:
    """As they stand in the file."""
    for row in rows:
        csv.writer(file, lineterminator="\n").writerow(f"{x:.6g}" if isinstance(x, float) else x for x in row)
        file.flush()


def run(surfaces: int) -> None:
    """Add what is missing to the file, a surface of each class after the other."""
    there = {(row.kind, row.seed) for row in read()}
    with FILE.open("a", encoding="utf-8", newline="") as file:
        if not there:
            file.write(",".join(Row._fields) + "\n")
        for seed in range(surfaces):
            for kind in CLASSES:
                if (kind, seed) in there:
                    continue
                began = time.process_time()
                row = found(kind, seed)
                write(file, [row])
                sys.stderr.write(f"{row}: {time.process_time() - began:.1f} s\n")


def read() -> list[Row]:
    """All surfaces of the file."""
    if not FILE.exists():
        return []
    rows = read_csv(FILE, keep_default_na=False, na_values={"work": "nan", "below": "nan", "above": "nan"})
    return [Row(*line) for line in rows.itertuples(index=False)]


def verdicts(rows: Sequence[Row]) -> Sheet:
    """Right, undecided and wrong of each class at each factor from the threshold, by one state alone."""
    lines: list[Sequence[str | float | int | None]] = []
    for kind in (*CLASSES, "all"):
        of_kind = [row for row in rows if kind in (row.kind, "all")]
        searched = [row for row in of_kind if np.isfinite(row.work)]
        said = [Counter(row.said(factor) for row in searched) for factor in FACTORS]
        far = sum(of["undecided"] for factor, of in zip(FACTORS, said, strict=True) if not 0.5 <= factor <= 2)
        share = far / max(1, len(searched) * sum(not 0.5 <= factor <= 2 for factor in FACTORS))
        ratios = [row.work / row.estimate for row in searched]
        scatter = f"{np.exp(np.mean(np.log(ratios))):.2f} ({min(ratios):.2f} - {max(ratios):.2f})" if ratios else ""
        counts = (f"{of['right']}, {of['undecided']}, {of['wrong']}" for of in said)
        inside = sum(not row.why for row in searched)
        lines.append((kind, f"{len(searched)} of {len(of_kind)}", inside, scatter, *counts, f"{share:.0%}"))
    heads = ("class", "found by search", "in the range of the statement", "threshold over estimate",
             *(f"at {factor:g}" for factor in FACTORS), "undecided beyond a factor of 2")  # fmt: skip
    return Sheet.of("verdicts by one state: right, undecided, wrong", heads, lines)


def open_ones(rows: Sequence[Row]) -> Sheet:
    """The surfaces whose verdict is open beyond a factor of 2, or wrong."""
    heads = ("class, seed", "range", "threshold over estimate", "χ", "Müser's number", "patches", "interval", "why")
    chosen = [row for row in rows if np.isfinite(row.work) and row.why]
    lines: list[Sequence[str | float | int | None]] = [
        (f"{row.kind} {row.seed}", f"{row.range:.2f}", f"{row.work / row.estimate:.2f}", f"{row.chi:.2f}",
         f"{row.muller:.2f}", row.patches, f"{row.low / row.work:.2f} - {row.high / row.work:.2f}", row.why)
        for row in chosen
    ]  # fmt: skip
    return Sheet.of("outside of the range of the statement", heads, lines)


def alarms() -> Sheet:
    """How many clean surfaces are called not Gaussian: periodic ones, and parts cut out of twice their size."""
    rng, rows = np.random.default_rng(1), []
    for n in (32, 64, 128, 256):
        counts = []
        for size in (n, 2 * n):
            called = 0
            for _ in range(300):
                lambda_s = float(rng.uniform(2.2, n / 8))
                lambda_l = float(rng.uniform(max(2 * lambda_s, n / 8), size))
                heights = SelfAffine(float(rng.uniform(0.2, 0.95)), 0.1, lambda_s, lambda_l).synthesise(
                    Grid.square(size), rng
                )
                topography = Topography(UNIT * heights[:n, :n], (UNIT * n, UNIT * n), size == n)
                called += bool(summits_of(detrend(topography)).unlike_gaussian)
            counts.append(f"{called} of 300")
        rows.append((f"{n} x {n}", *counts))
    return Sheet.of("clean surfaces called not Gaussian", ("points", "periodic", "cut out"), rows)


def main() -> None:
    """Show what the verdicts come to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--alarms", action="store_true", help="clean surfaces that are called not Gaussian")
    parser.add_argument("--run", action="store_true", help=f"make what is missing in {FILE.name}")
    parser.add_argument("--again", action="store_true", help="estimate all in that file anew")
    parser.add_argument("--surfaces", type=int, default=SURFACES, help="surfaces of each class")
    given = parser.parse_args()
    if given.run:
        run(given.surfaces)
    if given.again:
        rows = [estimated_again(row) for row in read()]
        with FILE.open("w", encoding="utf-8", newline="") as file:
            file.write(",".join(Row._fields) + "\n")
            write(file, rows)
    rows = [row for row in read() if row.seed < given.surfaces]
    sheets = [alarms()] if given.alarms else [verdicts(rows), open_ones(rows)]
    sys.stdout.write("\n\n".join(sheet.markdown() for sheet in sheets) + "\n")


if __name__ == "__main__":
    main()
