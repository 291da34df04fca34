"""The error of a surface from one map of it: spots of surfaces of which the whole is known.

``nice -n 19 python -m docs.studies.spots`` adds to ``docs/measured/spots.csv`` the spots that are missing; some ten
minutes on one core.  The statement is in docs/studies/spots.md.  Lengths are in pixels, pressures in E*.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from pandas import DataFrame, Series, read_csv

import continuum as c
from continuum.maps.map import Topography
from continuum.maps.mending import detrend
from continuum.maps.roughness import fit_self_affine, spectrum
from continuum.maps.verdict.extrapolation import ERRORS, Blocks
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.threshold import MapThreshold, PressedMap, press_map
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.store.sheet import Sheet
from docs.studies.one_state import Rng, unit

FILE = Path(__file__).parents[1] / "measured" / "spots.csv"
WHOLE, SPOTS, SEED = 1024, 12, 71
RATIOS = 8, 4, 2, 0
"""Side of a spot over the roll-off length; 0 where the roll-off is the whole surface."""
CLAIMED = 8, 4
OTHER_SEED, ROLL_OFFS = 73, Path(__file__).parents[1] / "measured" / "roll-offs.csv"
"""Seed and file of the surfaces on which roll-offs are looked for only."""
STATES = {8: (0.95, 0.85), 4: (0.85, 0.70), 2: (0.10, 0.20), 0: (0.02, 0.05)}
"""Share of maps that should state an error, by ratio, and that beyond which the statement is refuted."""
RANGE, SLOPE = 0.5, 0.1
"""Range in rms heights, and rms slope."""


def self_affine(hurst: float, rng: Rng, shortest: float, longest: float, n: int = WHOLE) -> Real:
    """Gaussian."""
    return c.SelfAffine(hurst, SLOPE, shortest, longest).synthesise(Grid.square(n), rng)


def anisotropic(rng: Rng, shortest: float, longest: float, n: int = WHOLE) -> Real:
    """Slopes along x twice those along y."""
    grid = Grid.square(n)
    qx, qy = grid.wavevectors
    q = np.maximum(np.hypot(qx / np.sqrt(2), qy * np.sqrt(2)), 2 * np.pi / longest)
    density = np.where(q < 2 * np.pi / (1.5 * shortest), q**-1.7, 0.0)
    made: Real = grid.inverse(grid.forward(rng.normal(size=grid.shape)) * density)
    return made


def worn(rng: Rng, shortest: float, longest: float, n: int = WHOLE) -> Real:
    """The highest third flattened, under a fine roughness."""
    rough = unit(self_affine(0.8, rng, 2 * shortest, longest, n))
    level = np.quantile(rough, 2 / 3)
    flat = np.where(rough > level, level + (rough - level) / 5, rough)
    return flat + 0.1 * unit(self_affine(0.8, rng, shortest, longest / 2, n))


def skewed(rng: Rng, shortest: float, longest: float, n: int = WHOLE) -> Real:
    """Lognormal heights, with valleys deeper than summits are high."""
    return -np.exp(-0.4 * unit(self_affine(0.6, rng, shortest, longest, n)))


KINDS: Mapping[str, tuple[Callable[..., Real], int]] = {
    "H = 0.3": (partial(self_affine, 0.3), 128), "H = 0.5": (partial(self_affine, 0.5), 256),
    "H = 0.8": (partial(self_affine, 0.8), 128), "anisotropic": (anisotropic, 256), "worn": (worn, 128),
    "skewed": (skewed, 256),
}  # fmt: skip
"""Kinds of surfaces, and the points along a side of their spots."""


def whole(kind: str, ratio: int, seed: int = SEED) -> Real:
    """A surface, periodic."""
    made, n = KINDS[kind]
    rng = np.random.default_rng([seed, list(KINDS).index(kind), ratio])
    heights = made(rng, 4.0, n / ratio if ratio else float(WHOLE))
    return heights * SLOPE / c.moments(Grid.square(WHOLE), heights).rms_slope


def pressed(heights: Real, reach: float, periodic: bool = False) -> tuple[PressedMap, MapThreshold]:
    """A map without adhesion, and its threshold."""
    side = float(heights.shape[0])
    topography = Topography(heights, (side, side), periodic)
    found = press_map(topography if periodic else detrend(topography), Interface(1.0, 1e-6, reach, None))
    return found, found.threshold()


def rows(kind: str, ratio: int) -> list[dict[str, object]]:
    """The spots of a surface."""
    heights, n = whole(kind, ratio), KINDS[kind][1]
    reach = RANGE * float(heights.std())
    known = pressed(heights, reach, periodic=True)[1]
    places = np.random.default_rng(SEED).permutation((WHOLE // n) ** 2)[:SPOTS]
    found = []
    for place in places:
        i, j = (n * int(x) for x in divmod(place, WHOLE // n))
        spot, one = pressed(heights[i : i + n, j : j + n], reach)
        roll_off = roll_off_of(heights[i : i + n, j : j + n])
        sampling = spot.sampling_error(roll_off)
        # Where the program states none: what thirds of the map would say.
        thirds = spot.sampling_error(n / 3)
        numbers = {"whole": known.work, "work": one.work, "low": one.low, "high": one.high, "chi": one.chi,
                   "patches": one.patches, "roll_off": roll_off, "sampling": sampling, "thirds": thirds}  # fmt: skip
        found.append({"kind": kind, "ratio": ratio, "n": n, "spot": int(place), "source": one.source.value}
                     | {name: f"{value:.6g}" for name, value in numbers.items()})  # fmt: skip
    return found


def roll_off_of(heights: Real) -> float:
    """The roll-off that the program finds on a map, in pixels; its side if it finds none."""
    side = float(heights.shape[0])
    fit = fit_self_affine(*spectrum(detrend(Topography(heights, (side, side)))))
    return fit.roll_off if fit is not None and fit.roll_off else side


def roll_offs(kind: str, ratio: int) -> list[dict[str, object]]:
    """The roll-off on every spot of a surface of another seed, without pressing it."""
    heights, n = whole(kind, ratio, OTHER_SEED), KINDS[kind][1]
    spots = heights.reshape(WHOLE // n, n, WHOLE // n, n).swapaxes(1, 2).reshape(-1, n, n)
    return [{"kind": kind, "ratio": ratio, "n": n, "roll_off": f"{roll_off_of(one):.6g}"} for one in spots]


def enough(data: DataFrame) -> Series:
    """Whether a map with this roll-off states an error."""
    found = [Blocks.of((n, n), roll_off).enough for n, roll_off in zip(data.n, data.roll_off, strict=True)]
    return Series(found, index=data.index)


def states(data: DataFrame) -> Sheet:
    """How many maps of each ratio state an error, by the roll-off that is found."""
    cells = []
    for ratio in RATIOS:
        rows = data[data.ratio == ratio]
        share = enough(rows).mean()
        good, bad = STATES[ratio]
        word = "held" if (share - good) * (1 if good > bad else -1) >= 0 else \
            "refuted" if (share - bad) * (1 if good > bad else -1) < 0 else "not decided"  # fmt: skip
        cells.append((str(ratio or "none"), len(rows), f"{share:.1%}", word))
    return Sheet.of("Maps that state an error", ("map over roll-off", "maps", "state an error", "verdict"), cells)


def judged(data: DataFrame) -> Sheet:
    """How often the stated interval holds the whole, by ratio."""
    cells = []
    for ratio in RATIOS:
        rows = data[data.ratio == ratio]
        away = np.log(rows.work / rows.whole)
        stated = rows.sampling.notna() & enough(rows)
        held = away.abs() <= ERRORS * rows.sampling
        alone = (rows.whole >= rows.low) & (rows.whole <= rows.high)
        scatter = np.sqrt((away**2).groupby(rows.kind).mean())
        cells.append((
            str(ratio or "none"), len(rows), int(stated.sum()),
            f"{int(held[stated].sum())} ({held[stated].mean():.0%})" if stated.any() else "-",
            f"{int((away.abs() <= ERRORS * rows.thirds).sum())}", int(alone.sum()),
            f"{np.exp(scatter.min()):.2f} to {np.exp(scatter.max()):.2f}", f"{np.exp(away.median()):.2f}",
            f"{width(data, ratio):.2f}" if stated.any() else "-",
        ))  # fmt: skip
    head = ("map over roll-off", "spots", "an error is stated", "of these it holds the whole", "with thirds of the map",
            "the interval of the map alone", "scatter of spots", "median over the whole",
            "interval over scatter")  # fmt: skip
    return Sheet.of("Spots and the whole", head, cells)


def held(data: DataFrame, ratio: int) -> float:
    """Share of the stated intervals that hold the whole; of thirds of the map where there is no roll-off."""
    rows = data[data.ratio == ratio]
    error = rows.sampling.where(enough(rows)) if ratio else rows.thirds
    stated = error.notna()
    away = np.log(rows.work / rows.whole).abs()
    return float((away <= ERRORS * error)[stated].mean())


def width(data: DataFrame, ratio: int) -> float:
    """The median interval of a kind over the scatter of its spots, the median of the kinds."""
    rows = data[(data.ratio == ratio) & data.sampling.notna() & enough(data)]
    scatter = np.log(rows.work / rows.whole).pow(2).groupby(rows.kind).mean() ** 0.5
    return float((rows.sampling.groupby(rows.kind).median() * ERRORS / scatter).median())


def verdicts(data: DataFrame) -> str:
    """Each row of the statement with its verdict."""
    lines = []
    for ratio in CLAIMED:
        share = held(data, ratio)
        word = "held" if share >= 0.9 else "not decided" if share >= 0.8 else "refuted"
        lines.append(f"* a map of {ratio} roll-off lengths: {share:.0%} of the intervals hold the whole: **{word}**")
    none = held(data, 0)
    word = "held" if none < 0.8 else "refuted" if none >= 0.9 else "not decided"
    lines.append(f"* without a roll-off: blocks of a third of the map would hold it for {none:.0%}: **{word}**")
    most = max(width(data, ratio) for ratio in CLAIMED)
    word = "held" if most <= 2.5 else "refuted" if most > 4 else "not decided"
    lines.append(f"* the interval is at most {most:.2f} times the scatter of the spots: **{word}**")
    return "\n".join(lines)


def add(
    file: Path,
    made: Callable[[str, int], list[dict[str, object]]],
    ratios: Iterable[int] = RATIOS,
    kinds: Iterable[str] = tuple(KINDS),
) -> None:
    """Add the rows of ratios and kinds that a file lacks."""
    known = set()
    if file.exists():
        with file.open(newline="") as stored:
            known = {(one["kind"], int(one["ratio"])) for one in csv.DictReader(stored)}
    for ratio in ratios:
        for kind in kinds:
            if (kind, ratio) in known:
                continue
            found, new = made(kind, ratio), not file.exists()
            with file.open("a", newline="") as stored:
                writer = csv.DictWriter(stored, list(found[0]), lineterminator="\n")
                if new:
                    writer.writeheader()
                writer.writerows(found)
            print(kind, ratio, flush=True)  # noqa: T201


def main() -> None:
    """Add what is missing, and print the tables."""
    add(ROLL_OFFS, roll_offs)
    add(FILE, rows)
    tables = states(read_csv(ROLL_OFFS)), judged(read_csv(FILE))
    sys.stdout.write("\n".join(one.markdown() for one in tables) + "\n" + verdicts(read_csv(FILE)))


if __name__ == "__main__":
    sys.exit(main())
