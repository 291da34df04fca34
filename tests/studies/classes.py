"""Worn, honed, pitted, beaded, stretched, tip-rounded, steep and clean surfaces: where each turns, and the verdicts.

``python -m tests.studies.classes --solve`` finds the turns and writes the record of summits,
``continuum/sticky/summits.csv``, together with the summits of the surfaces of the other record (five minutes on one
core).  Without it the tables of docs/predict.md are made: clean surfaces that are called anything else; right,
undecided and wrong verdicts at works of adhesion around the turn, each class left out of the record of summits when it
is judged.  Surfaces are periodic, on 128² points; each draws the parameters of its class.
"""

from __future__ import annotations

import argparse
import csv
import io
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import numpy as np
from scipy.ndimage import grey_dilation

from continuum.files import output
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine, moments
from continuum.show.sheet import Sheet
from continuum.solve.solution import NotConvergedError
from continuum.sticky.materials import Interface
from continuum.sticky.prediction import prediction_of, rough_contact, summit_contact
from continuum.sticky.simulate import UnresolvedError, resolvable, simulate
from continuum.sticky.verdict import judge, judge_contact
from continuum.topography.map import Topography
from continuum.topography.mending import detrend
from continuum.topography.roughness import roughness_of
from continuum.topography.summits import summits_of

N, SURFACES = 128, 14
GRID = Grid.square(N)
FACTORS = (0.1, 0.2, 0.5, 2.0, 5.0, 10.0)
"""Works of adhesion over that at the turn, at which verdicts are asked for."""
UNIT = 1e-9
"""Pixel in m, so that the maps are what an instrument gives; E* = 1 Pa."""
ACCURACY = 0.1
"""Relative width of the bracket of a turn: a tenth of the smallest distance from it at which a verdict is asked for."""
STICKY = Path(__file__).parents[2] / "continuum" / "sticky"
COLUMNS = ("class", "seed", "rms_height", "rms_slope", "rms_curvature", "conformal_energy", "range", "work")
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


def steep(rng: Rng) -> Real:
    """Gaussian, of slopes up to 1: to the solver, which takes slopes as small, a clean one that was stretched."""
    return scaled(clean(rng), rng.uniform(0.35, 1))


CLASSES: dict[str, Callable[[Rng], Real]] = {
    "clean": clean,
    "worn": worn,
    "honed": honed,
    "pitted": pitted,
    "beaded": beaded,
    "stretched": stretched,
    "rounded": rounded,
    "steep": steep,
}


def surface(kind: str, seed: int) -> tuple[Topography, float]:
    """A surface of a class, and the range of the attraction on it."""
    rng = np.random.default_rng([list(CLASSES).index(kind), seed])
    heights = CLASSES[kind](rng)
    reach = float(rng.uniform(0.2, 0.8) * heights.std())
    return Topography(UNIT * heights, (UNIT * N, UNIT * N), True, f"{kind} {seed}"), UNIT * reach


def turn(topography: Topography, reach: float) -> float | None:
    """Work of adhesion at which the load at 1 % repulsive area changes its sign; None where the grid resolves none."""

    def sticky(work: float) -> bool | None:
        contact = Interface(1.0, work, reach, None)
        try:
            return None if resolvable(topography, contact)[1] else simulate(topography, contact).sticky
        except (UnresolvedError, NotConvergedError):
            return None

    work = 0.3 * roughness_of(topography).conformal_energy
    low: float | None = None
    high: float | None = None
    answer: bool | None = None  # at the upper end of the bracket
    while low is None or high is None or high / low > 1 + ACCURACY:
        found = sticky(work)
        low, high, answer = (work, high, answer) if found is False else (low, work, found)
        work = work / 3 if low is None else work * 3 if high is None else float(np.sqrt(low * high))
    return float(np.sqrt(low * high)) if answer else None


def entry(kind: str, seed: int, topography: Topography, reach: float, work: float) -> dict[str, str]:
    """A row of the record: the contact of the summits at the turn, in pixels."""
    pixel = topography.grid.spacing[0]
    whole = rough_contact(roughness_of(topography).whole, Interface(1.0, work, reach, None))
    contact = summit_contact(topography, whole)
    assert contact is not None
    values = (contact.rms_height / pixel, contact.rms_slope, contact.rms_curvature * pixel,
              (contact.conformal_energy or 0.0) / pixel, contact.range / pixel, work / pixel)  # fmt: skip
    return dict(zip(COLUMNS, (kind, str(seed), *(f"{value:.5g}" for value in values)), strict=True))


def solved() -> Iterator[dict[str, str]]:
    """Turns of all surfaces that have one."""
    for kind in CLASSES:
        for seed in range(SURFACES):
            topography, reach = surface(kind, seed)
            work = turn(topography, reach)
            sys.stderr.write(f"{kind} {seed}: {work}\n")
            if work is not None:
                yield entry(kind, seed, topography, reach, work)


def of_the_record() -> Iterator[dict[str, str]]:
    """The surfaces of the record of moments, on 512² points: walls, whose summits are the lowest points."""
    grid, rows = Grid.square(512), csv.DictReader((STICKY / "record.csv").read_text().splitlines())
    for i, row in enumerate(row for row in rows if row["source"] == "turn"):
        numbers = [float(row[name]) for name in ("hurst", "rms_slope", "lambda_s", "lambda_L")]
        heights = _synthesised(grid, (numbers[0], 0.1, *numbers[2:]), int(row["seed"])) * (-numbers[1] / 0.1)
        topography = Topography(heights, grid.lengths, True, "record")
        # Three of the longest roll-offs were on a larger grid.
        if abs(heights.std() / float(row["rms_height"]) - 1) < 0.01:
            yield entry("self-affine", i, topography, float(row["range"]), float(row["work"]))


@cache
def _synthesised(grid: Grid, numbers: tuple[float, ...], seed: int) -> Real:
    return SelfAffine(*numbers).synthesise(grid, np.random.default_rng(seed))


def verdicts() -> Sheet:
    """Right, undecided and wrong verdicts of each class, at each factor from the turn: of moments, and as they are."""
    said: dict[str, dict[float, Counter[str]]] = {}
    for row in csv.DictReader((STICKY / "summits.csv").read_text().splitlines()):
        if row["class"] not in CLASSES:
            continue
        topography, reach = surface(row["class"], int(row["seed"]))
        for factor in FACTORS:
            contact = Interface(1.0, UNIT * factor * float(row["work"]), reach, None)
            pixels = 2 * max(topography.grid.spacing)  # a surface that was made has no waves that were not measured
            prediction = prediction_of([topography], contact, smallest=pixels)
            truth = "sticky" if factor > 1 else "not sticky"
            unseen = judge(prediction, lambda other, kind=row["class"]: other.kind == kind)
            for name, answer in (("moments", judge_contact(prediction.contact).answer), ("verdict", unseen.answer)):
                outcome = "undecided" if answer == "undecided" else "right" if answer == truth else "wrong"
                said.setdefault(f"{row['class']}, {name}", {}).setdefault(factor, Counter())[outcome] += 1
    rows = [
        (kind, *(f"{of[f]['right']}, {of[f]['undecided']}, {of[f]['wrong']}" for f in FACTORS))
        for kind, of in said.items()
    ]
    heads = ("class", *(f"at {factor:g} times the turn" for factor in FACTORS))
    return Sheet.of("verdicts: right, undecided, wrong", heads, rows)


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
    """Find the turns, or show what the verdicts come to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--solve", action="store_true", help="find the turns anew")
    if parser.parse_args().solve:
        out = io.StringIO()
        writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows((*solved(), *of_the_record()))
        output.save(STICKY / "summits.csv", out.getvalue(), own=True)
    sys.stdout.write("\n\n".join(sheet.markdown() for sheet in (alarms(), verdicts())) + "\n")


if __name__ == "__main__":
    main()
