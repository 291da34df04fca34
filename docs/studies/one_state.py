"""The second law tested: thresholds from one state without adhesion, beside those by search, of new surfaces.

``nice python -m docs.studies.one_state`` adds to ``docs/measured/one-state.csv`` what is missing there, a row for
each threshold, in the order of :func:`cases`, small complete sets first; half an hour on one core.  Rows without a work
have a reason in ``how``.  With ``--again`` all estimates are made anew, not the thresholds.
``python -m docs.studies.one_state_judged`` judges them by the bounds of docs/studies/one_state.md.

Self-affine surfaces have an rms height of 1/8 of a pixel; textures carry a fine roughness of that height on their
tops, with parameters drawn by their class and seed.
"""

from __future__ import annotations

import csv
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import astuple, dataclass, fields, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

import continuum as c
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates import CubicLayer, HalfSpace, Layer, LayeredHalfSpace, Substrate
from continuum.model.substrates.crystal import CubicConstants
from continuum.model.surfaces import SelfAffineSurface
from continuum.model.walls import LennardJonesSpline, Wall, attraction_on_core
from continuum.path.threshold import PressedState, Threshold, press_without_adhesion
from continuum.path.threshold_search import WallOfWork
from continuum.solve.solution import NotConvergedError
from continuum.theory.smooth import tabor_parameter
from docs.studies.persson import PerssonContact

FILE = Path(__file__).parents[2] / "docs" / "measured" / "one-state.csv"
HEIGHT, CORE = 0.125, 5.0
"""Rms height of the roughness in pixels, and stiffness of the core in E* a pixel."""
RESOLVED = 0.35
"""Largest w over the squared range, in E* a pixel: beyond, single points snap."""
STEEP = 0.25
"""Rms slope to which a steeper texture is scaled down."""
SEEDS = range(21, 29)
FAR = 60.0
"""Ranges to which an attraction without end is integrated."""
Rng = np.random.Generator


@dataclass(frozen=True)
class Case:
    """What is asked for; lengths in pixels, the range in h_rms of the fine roughness."""

    kind: str
    seed: int
    n: int
    hurst: float
    """NaN where the class draws it, as are the wavelengths."""
    lambda_s: float
    lambda_L: float
    area: float
    shape: str
    delta: float
    """NaN where the class draws it, or the law ties it to the work."""


class Row(NamedTuple):
    """What was found, beside the case; works in E* a pixel."""

    height: float
    energy: float
    """U of the map."""
    range: float
    """Effective range at the threshold, in pixels."""
    work: float
    """By search; NaN where it found none."""
    low: float
    high: float
    dmt: float
    chi: float
    load_kept: float
    """w_DMT (1 + χ) with the repulsive load kept, D_l in place of D_A."""
    patches: int
    muller: float
    """μ_T at the threshold."""
    weak: float
    """w by Persson and Scaraggi, of the spectrum of the map; NaN where that has no isotropic part."""
    how: str
    """How the search ended: "threshold", "jump-in", "none", or "not resolved"."""


def self_affine(n: int, hurst: float, lambda_s: float, lambda_L: float, seed: int) -> Real:
    """A surface of rms height 1/8."""
    size = {"rms_height": HEIGHT}
    given = {"hurst": hurst, "lambda_s": lambda_s, "lambda_L": lambda_L, "seed": seed, **size}
    return SelfAffineSurface.model_validate({"kind": "self-affine", **given}).build(Grid.square(n))


def fine(rng: Rng, n: int) -> Real:
    """Roughness of a texture, of rms height 1."""
    long = float(rng.uniform(32, 64))
    surface = c.SelfAffine(float(rng.uniform(0.4, 0.9)), 0.1, float(rng.uniform(4, 8)), long)
    return unit(surface.synthesise(Grid.square(n), rng))


def unit(heights: Real) -> Real:
    """Of mean zero and rms 1."""
    found: Real = (heights - heights.mean()) / heights.std()
    return found


def square(phase: Real, edge: float) -> Real:
    """A wave between 0 and 1 with edges of a width, in radians."""
    found: Real = 0.5 + 0.5 * np.tanh(np.sin(phase) / edge)
    return found


def places(rng: Rng, n: int, count: int) -> Iterator[Real]:
    """Squared distances from random points."""
    x, y = np.mgrid[:n, :n]
    for centre in rng.uniform(0, n, (count, 2)):
        away = [(side - middle + n / 2) % n - n / 2 for side, middle in zip((x, y), centre, strict=True)]
        yield away[0] ** 2 + away[1] ** 2


def worn(rng: Rng, n: int) -> Real:
    """The highest part of a rough surface flattened, with a fine roughness."""
    rough = 4 * fine(rng, n)
    level, factor = np.quantile(rough, 1 - rng.uniform(0.1, 0.5)), np.exp(rng.uniform(np.log(3), np.log(30)))
    return np.where(rough > level, level + (rough - level) / factor, rough) + rng.uniform(0.2, 1) * fine(rng, n)


def honed(rng: Rng, n: int) -> Real:
    """A plateau, crossed by grooves in two directions."""
    x, y = np.mgrid[:n, :n]
    depth = np.zeros((n, n))
    for side in (1, -1):
        for _ in range(rng.integers(3, 7)):
            across = (x * rng.integers(1, 3) + side * y * rng.integers(1, 3) + rng.integers(0, n)) % n
            depth = np.maximum(depth, rng.uniform(0.5, 1) * np.exp(-(((across - n / 2) / rng.uniform(3, 7)) ** 2)))
    return fine(rng, n) - rng.uniform(4, 10) * depth


def beaded(rng: Rng, n: int) -> Real:
    """Overlapping caps of one radius, their tops not at one height."""
    caps, radius = np.full((n, n), -np.inf), rng.uniform(40, 200)
    for squared in places(rng, n, int(rng.integers(100, 300))):
        caps = np.maximum(caps, rng.normal(0, 1) - squared / (2 * radius))
    return caps + rng.uniform(0.5, 1.5) * fine(rng, n)


def dimpled(rng: Rng, n: int) -> Real:
    """A plateau with round dimples."""
    depth = np.zeros((n, n))
    for squared in places(rng, n, int(rng.integers(20, 80))):
        depth = np.maximum(depth, np.exp(-squared / rng.uniform(4, 10) ** 2))
    return fine(rng, n) - rng.uniform(4, 10) * depth


def posts(rng: Rng, n: int) -> Real:
    """A square array of posts."""
    waves, edge = 2 * np.pi * rng.integers(3, 9) / n, rng.uniform(0.2, 0.6)
    x, y = np.mgrid[:n, :n] * waves
    return rng.uniform(3, 10) * square(x, edge) * square(y, edge) + fine(rng, n)


def egg_box(rng: Rng, n: int) -> Real:
    """Crossed sine waves."""
    x, y = 2 * np.pi * np.mgrid[:n, :n] * rng.integers(3, 9) / n
    return rng.uniform(1, 4) * np.sin(x) * np.sin(y) + fine(rng, n)


def terraces(rng: Rng, n: int) -> Real:
    """Steps of one height."""
    slow = unit(c.SelfAffine(0.8, 0.1, 24.0, n / 2).synthesise(Grid.square(n), rng)) * rng.uniform(1, 2)
    for _ in range(2):  # a staircase
        slow = slow - np.sin(2 * np.pi * slow) / (2 * np.pi)
    return rng.uniform(2, 6) * slow + fine(rng, n)


def stripes(rng: Rng, n: int) -> Real:
    """Ridges in one direction."""
    x, _ = 2 * np.pi * np.mgrid[:n, :n] * rng.integers(3, 9) / n
    return rng.uniform(2, 8) * square(x, rng.uniform(0.2, 0.8)) + fine(rng, n)


def lognormal(rng: Rng, n: int) -> Real:
    """Skewed heights, of peaks or of valleys."""
    return unit(rng.choice((-1.0, 1.0)) * np.exp(rng.uniform(0.3, 0.8) * fine(rng, n)))


def spectral(rng: Rng, n: int, density: Callable[[Real, Real], Real]) -> Real:
    """A Gaussian surface of an amplitude of each wavevector."""
    grid = Grid.square(n)
    made: Real = grid.inverse(grid.forward(rng.normal(size=(n, n))) * density(*grid.wavevectors))
    return unit(made)


def two_hursts(rng: Rng, n: int) -> Real:
    """One Hurst exponent of long waves, another of short ones."""
    (long, short), kink = rng.uniform(0.2, 1.0, 2), 2 * np.pi / rng.uniform(12, 24)
    first, last = 2 * np.pi / rng.uniform(32, 64), 2 * np.pi / rng.uniform(4, 7)

    def density(qx: Real, qy: Real) -> Real:
        q = np.maximum(np.hypot(qx, qy), first)
        power: Real = np.where(q < kink, (q / kink) ** -(1 + long), (q / kink) ** -(1 + short))
        return np.where(q < last, power, 0.0)

    return spectral(rng, n, density)


def anisotropic(rng: Rng, n: int) -> Real:
    """Slopes in one direction two to four times those in the other."""
    ratio, hurst = np.sqrt(rng.uniform(2, 4)), rng.uniform(0.4, 0.9)
    first, last = 2 * np.pi / rng.uniform(32, 64), 2 * np.pi / rng.uniform(7, 12)

    def density(qx: Real, qy: Real) -> Real:
        q = np.maximum(np.hypot(qx / ratio, qy * ratio), first)
        return np.where(q < last, q ** -(1 + hurst), 0.0)

    return spectral(rng, n, density)


TEXTURES: dict[str, Callable[[Rng, int], Real]] = {
    "worn": worn, "honed": honed, "beaded": beaded, "dimpled": dimpled, "posts": posts, "egg-box": egg_box,
    "terraces": terraces, "stripes": stripes, "lognormal": lognormal, "two Hurst exponents": two_hursts,
    "anisotropic": anisotropic,
}  # fmt: skip
SUBSTRATES: dict[str, Substrate] = {
    "layer": Layer(12.0, 0.4, "clamped"),
    "coating": LayeredHalfSpace([(6.0, 1.0, 0.3)], (0.3, 0.4)),
    "crystal": CubicLayer(np.inf, CubicConstants(1.2, 0.6, 0.5), "clamped"),
}
"""Responses other than that of a half-space; lengths in pixels."""


@lru_cache(1)
def surface(case: Case) -> tuple[Real, float]:
    """Heights of the wall, whose lowest points touch, and the range that a texture draws in h_rms of its roughness."""
    if case.kind not in TEXTURES:
        return self_affine(case.n, case.hurst, case.lambda_s, case.lambda_L, case.seed), case.delta
    rng = np.random.default_rng([list(TEXTURES).index(case.kind), case.seed])
    heights = -HEIGHT * TEXTURES[case.kind](rng, case.n)
    slope = c.moments(Grid.square(case.n), heights).rms_slope
    return heights * min(1.0, STEEP / slope), float(rng.uniform(0.4, 1.2)) * min(1.0, STEEP / slope)


def law(shape: str, reach: float) -> WallOfWork:
    """The law of each work; "paper" ties its range to it."""
    if shape == "paper":
        return lambda work: LennardJonesSpline(adhesion_length=work)
    shapes: dict[str, WallOfWork] = {
        "spline": lambda work: attraction_on_core("spline", work, reach, CORE),
        "exponential": lambda work: attraction_on_core("exponential", work, reach, CORE),
    }
    return cache(shapes[shape])


def pressed(contact: c.Contact, area: float, core: float) -> PressedState:
    """The state without adhesion, kept for the laws that follow."""
    key = contact.problem.heights.tobytes(), repr(contact.substrate), area, core
    if _LAST.get("key") != key:
        found = press_without_adhesion(contact.problem, area, contact.settings, core)
        _LAST.update(key=key, found=found)
    return _LAST["found"]


_LAST: dict = {}


def load_kept(state: PressedState, wall: Wall, dmt: float) -> float:
    """w_DMT (1 + χ), where the wall is withdrawn by what keeps the repulsive load."""
    mean, force, opens = state.grid.mean, state.core.stiffness * state.contact, state.opening
    pull, slope = state.attraction(wall)
    rise = state.core.response(state.core.compliance(pull))
    lift = mean(force * rise) / mean(force * opens)
    return float(dmt * (1 - dmt * mean(slope * (lift * opens - rise)) / mean(pull)))


def weak_adhesion(grid: Grid, heights: Real, area: float, wall: Wall) -> float:
    """Persson and Scaraggi's w, of the spectrum of the map averaged over directions."""
    power = np.abs(grid.forward(heights)) ** 2 * grid.mode_weights
    step = 2 * np.pi / grid.lengths[0]
    shell = np.rint(grid.wavenumber / step).astype(int)
    squares = np.bincount(shell.ravel(), power.ravel())[1:]
    q = step * np.arange(1, squares.size + 1)
    kept = q <= q[np.nonzero(squares > 1e-9 * squares.max())[0][-1]]
    theory = PerssonContact(q[kept], squares[kept] / (2 * np.pi * q[kept] * step))
    reach = min(wall.reach - wall.zero_gap, FAR * wall.effective_range)
    work = wall.work_of_adhesion
    return theory.weak_adhesion_threshold(area, lambda gap: -wall.evaluate(wall.zero_gap + gap).traction / work, reach)


def found(case: Case) -> Row:
    """The threshold of a case by one state, and its threshold by search."""
    heights, delta = surface(replace(case, area=0.0, shape="", delta=0.0 if np.isnan(case.delta) else case.delta))
    delta = case.delta if np.isfinite(case.delta) else delta
    core = LennardJonesSpline(0.1).minimum_stiffness if case.shape == "paper" else CORE
    wall_of = law(case.shape, delta * HEIGHT)
    contact = c.Contact(heights, wall_of(1e-4), SUBSTRATES.get(case.kind, HalfSpace("clamped")), tolerance=1e-4)
    state = pressed(contact, case.area, core)
    threshold = state.threshold(wall_of)
    for _ in range(6 if case.kind in TEXTURES else 0):  # a texture's range, as many times longer as the grid needs
        if threshold.low <= RESOLVED * wall_of(threshold.dmt).effective_range ** 2:
            break
        delta *= 1.4
        wall_of = law(case.shape, delta * HEIGHT)
        threshold = state.threshold(wall_of)
    return row(contact, state, threshold, wall_of, case)


def row(contact: c.Contact, state: PressedState, one: Threshold, wall_of: WallOfWork, case: Case) -> Row:
    """All numbers of a case."""
    grid, heights = contact.grid, contact.problem.heights
    about = one.work if np.isfinite(one.work) else one.low if one.low > 0 else one.dmt
    wall, made = wall_of(about), contact.moments
    work, how = np.nan, "not resolved"
    if case.shape == "paper" or about <= RESOLVED * wall.effective_range**2:
        searched = replace(contact, wall=wall).find_threshold(wall_of, area=case.area)
        how = "jump-in" if searched.jumps else "threshold" if searched.converged else "none"
        work = searched.work
    at = work if np.isfinite(work) else about
    law_there = wall_of(at)
    return Row(
        made.rms_height, contact.problem.elastic_energy(np.zeros(grid.shape)), law_there.effective_range,
        work, one.low, one.high, one.dmt, one.chi, load_kept(state, wall, one.dmt), one.patches,
        tabor_parameter(float(np.sqrt(8 / 3)) / made.rms_curvature, at, law_there.effective_range),
        weak_adhesion(grid, heights, case.area, law_there), how,
    )  # fmt: skip


def cases() -> Iterator[Case]:
    """In the order in which they are run."""
    both = ("spline", "exponential")
    laws = [(shape, delta) for delta in (0.3, 0.5, 1.6) for shape in both]
    nan = float("nan")

    def affine(n: int, seeds: range, lambda_L: float, waves: tuple[float, ...], each: int) -> Iterator[Case]:
        """Some of the laws for each surface, so that each law meets each H, λ_s and area."""
        count = 0
        for seed in seeds:
            for hurst in (0.2, 0.5, 0.8):
                for lambda_s in waves:
                    for area in (0.01, 0.04):
                        for k in range(each):
                            shape, delta = laws[(count + k * 3 + seed) % len(laws)]
                            yield Case("self-affine", seed, n, hurst, lambda_s, lambda_L, area, shape, delta)
                        count += 1

    def textures(seeds: range, areas: tuple[float, ...], odd: int, kinds: Iterable[str] = TEXTURES) -> Iterator[Case]:
        for seed in seeds:
            for kind in kinds:
                area, shape = areas[seed % len(areas)], both[(seed + odd) % 2]
                yield Case(kind, seed, 256, nan, nan, nan, area, shape, nan)

    def one_each(kind: str, seeds: range, n: int, waves: tuple[float, float], area: float, *given: float,
                 hursts: tuple[float, ...] = (0.8,), shapes: tuple[str, ...] = both) -> Iterator[Case]:  # fmt: skip
        for seed in seeds:
            for hurst in hursts:
                for delta in given:
                    for shape in shapes:
                        yield Case(kind, seed, n, hurst, waves[0], waves[1], area, shape, delta)

    areas, first, spline = (0.01, 0.02, 0.04), range(21, 27), ("spline",)
    yield from affine(256, range(21, 25), 64.0, (4.0, 8.0), 1)
    yield from textures(range(21, 31), areas, 0)
    for seeds in (range(21, 27), range(27, 29)):
        yield from one_each("self-affine", seeds, 512, (16.0, 128.0), 0.04, 0.5, hursts=(0.3, 0.8), shapes=("spline",))
        for lambda_s in (4.0, 8.0):
            waves = lambda_s, 64.0
            yield from one_each("self-affine", seeds, 256, waves, 0.02, nan, hursts=(0.3, 0.8), shapes=("paper",))
        yield from one_each("self-affine", seeds, 256, (4.0, 128.0), 0.01, 0.5, hursts=(0.2, 0.8), shapes=("spline",))
        yield from affine(256, seeds, 64.0, (4.0, 8.0), 1)
        yield from textures(range(31, 33), areas, 0)
    for kind in SUBSTRATES:
        yield from one_each(kind, range(21, 24), 256, (6.0, 64.0), 0.02, 0.5)
    yield from one_each("self-affine", range(21, 27), 256, (4.0, 64.0), 0.005, 1.0)
    yield from one_each("self-affine", range(21, 27), 256, (4.0, 64.0), 0.08, 0.5)
    yield from one_each("self-affine", range(21, 23), 256, (4.0, 128.0), 0.04, 0.16)
    # Stated in docs/studies/one_state.md as "More of the second law".
    for kind in SUBSTRATES:
        yield from one_each(kind, range(24, 33), 256, (6.0, 64.0), 0.02, 0.5)
    for n, area in ((64, 0.04), (128, 0.01), (96, 0.04), (128, 0.04), (192, 0.02)):  # 164 to 738 points that touch
        waves = 4.0, n / 4
        yield from one_each("self-affine", range(21, 33), n, waves, area, 0.5, hursts=(0.3, 0.8), shapes=spline)
    yield from textures(range(33, 39), areas, 0, ("egg-box",))
    yield from one_each("self-affine", SEEDS, 256, (4.0, 64.0), 0.01, 0.5, 1.6, hursts=(0.9,))
    yield from one_each("self-affine", first, 512, (4.0, 256.0), 0.01, 0.5, hursts=(0.3, 0.8), shapes=spline)
    yield from one_each("self-affine", SEEDS, 512, (8.0, 256.0), 0.04, 0.16)
    for area in (0.02, 0.08):
        yield from one_each("self-affine", first, 256, (4.0, 64.0), area, 0.5, 1.6, hursts=(0.2, 0.8))
    yield from one_each("self-affine", first, 512, (4.0, 64.0), 0.01, 0.5, hursts=(0.2, 0.8), shapes=spline)
    yield from one_each("self-affine", first, 1024, (4.0, 512.0), 0.01, 0.5, hursts=(0.3, 0.8), shapes=spline)
    yield from one_each("self-affine", first, 1024, (24.0, 768.0), 0.04, 0.08, hursts=(0.9,), shapes=spline)
    yield from one_each("self-affine", range(21, 24), 2048, (4.0, 1024.0), 0.01, 0.5, hursts=(0.3, 0.8), shapes=spline)
    yield from textures(range(33, 57), areas, 0, ("terraces",))
    yield from affine(512, first, 64.0, (4.0, 8.0), 1)
    yield from textures(range(21, 33), (0.04, 0.01, 0.02), 1)
    yield from affine(256, SEEDS, 64.0, (4.0, 8.0), 2)


def estimated_again(given: dict[str, str]) -> dict[str, str]:
    """A row with what one state says of it now, beside the threshold that was found."""
    made = {field.name: given[field.name] for field in fields(Case)}
    texts = {name: made.pop(name) for name in ("kind", "shape")}
    counts = {name: int(made.pop(name)) for name in ("seed", "n")}
    case = Case(**texts, **counts, **{name: float(value) for name, value in made.items()})
    heights, _ = surface(replace(case, area=0.0, shape="", delta=0.0 if np.isnan(case.delta) else case.delta))
    wall_of = law(case.shape, float(given["range"]))
    core = LennardJonesSpline(0.1).minimum_stiffness if case.shape == "paper" else CORE
    contact = c.Contact(heights, wall_of(1e-4), SUBSTRATES.get(case.kind, HalfSpace("clamped")), tolerance=1e-4)
    state = pressed(contact, case.area, core)
    one = state.threshold(wall_of)
    about = one.work if np.isfinite(one.work) else one.low if one.low > 0 else one.dmt
    said = {"low": one.low, "high": one.high, "dmt": one.dmt, "chi": one.chi, "patches": one.patches,
            "load_kept": load_kept(state, wall_of(about), one.dmt)}  # fmt: skip
    return given | {name: text(value) for name, value in said.items()}


NAMES = (*(field.name for field in fields(Case)), *Row._fields)


def text(value: object) -> str:
    """As it stands in the file."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def again() -> None:
    """All estimates of the file made anew, beside the thresholds that were found."""
    with FILE.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    with FILE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, NAMES, lineterminator="\n")
        writer.writeheader()
        writer.writerows(map(estimated_again, rows))


def main() -> None:
    """Add the rows that are missing."""
    if "--again" in sys.argv:
        again()
        return
    warnings.filterwarnings("ignore", category=UserWarning)  # of the grid, which the study is about
    there = set()
    if FILE.exists():
        there = {tuple(line)[: len(fields(Case))] for line in csv.reader(FILE.read_text().splitlines())}
    with FILE.open("a", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if not there:
            writer.writerow(NAMES)
        for case in cases():
            key = tuple(text(value) for value in astuple(case))
            if key in there:
                continue
            there.add(key)
            began = time.process_time()
            try:
                numbers = found(case)
            except NotConvergedError as error:
                sys.stderr.write(f"{key}: {error}\n")
                continue
            writer.writerow([*key, *(text(value) for value in numbers)])
            file.flush()
            ratio = numbers.work / np.sqrt(numbers.low * numbers.high)
            sys.stderr.write(
                f"{' '.join(key)}: {ratio:.3f}, χ {numbers.chi:.3f}, {time.process_time() - began:.1f} s\n"
            )


if __name__ == "__main__":
    main()
