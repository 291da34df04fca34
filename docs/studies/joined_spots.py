"""Joined measurements and line scans that are pressed: spots of surfaces of which the whole is known.

``nice -n 19 python -m docs.studies.joined_spots`` adds to ``docs/measured/joined-spots.csv`` the spots that are
missing; some five minutes on one core.  The statement is in docs/studies/spots.md.  Lengths are in nm, which is a
pixel of the whole, and pressures in E*.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import scipy
from pandas import DataFrame, read_csv

import continuum as c
from continuum.maps.map import Bands, Topography
from continuum.maps.mending import detrend
from continuum.maps.roughness import fit_self_affine, roughness_of, spectrum
from continuum.maps.spectra import constant_in, isotropic_surface, joined, random_surface
from continuum.maps.verdict.extrapolation import CONFIDENCE, ERRORS
from continuum.maps.verdict.materials import Interface
from continuum.maps.verdict.prediction import rough_contact
from continuum.maps.verdict.threshold import MapThreshold, PressedMap, bounds, press_map
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.store.sheet import Sheet
from docs.studies.one_state import Rng, unit
from docs.studies.spots import KINDS as GENTLE
from docs.studies.spots import RANGE, SLOPE, add, self_affine

FILE = Path(__file__).parents[1] / "measured" / "joined-spots.csv"
WHOLE, SIDE, SPOTS, RATIOS, SEED = 1024, 256, 4, (8, 4), 72
"""Points along a side of a surface and of a spot, spots of each surface, and sides of a spot over the roll-off."""
PIXEL, PART, LINES = 4, 4, 16
"""Pixel of the large map, its side over that of the small one, and lines of a scan."""
HOWS = "joined", "lines"
DRAWN = 3
"""Continuations of each spot."""
NM = 1e-9


def lapped(rng: Rng, shortest: float, longest: float, n: int) -> Real:
    """The highest third flattened with all its waves: fine roughness is in the valleys only."""
    rough = unit(self_affine(0.7, rng, shortest, longest, n))
    level = np.quantile(rough, 2 / 3)
    return np.where(rough > level, level + (rough - level) / 10, rough)


def peaked(rng: Rng, shortest: float, longest: float, n: int) -> Real:
    """Lognormal heights, with summits higher than valleys are deep."""
    return np.exp(0.4 * unit(self_affine(0.6, rng, shortest, longest, n)))


KINDS: Mapping[str, Callable[..., Real]] = {kind: made for kind, (made, _) in GENTLE.items()} | {
    "lapped": lapped, "peaked": peaked,
}  # fmt: skip
"""Kinds of surfaces: those of the study of spots, and two that a random continuation should get wrong."""


def whole(kind: str, ratio: int) -> Real:
    """A surface, periodic."""
    heights = KINDS[kind](np.random.default_rng([SEED, list(KINDS).index(kind), ratio]), 4.0, SIDE / ratio, WHOLE)
    return heights * SLOPE / c.moments(Grid.square(WHOLE), heights).rms_slope


def measured(heights: Real, pixel: float = 1.0, periodic: bool = False) -> Topography:
    """A map of these heights."""
    nx, ny = heights.shape
    return Topography(heights * NM, (nx * pixel * NM, ny * pixel * NM), periodic)


def pressed(topography: Topography, reach: float) -> tuple[PressedMap, MapThreshold]:
    """A map without adhesion, and its threshold."""
    level = topography if topography.periodic else detrend(topography)
    found = press_map(level, Interface(1.0, 1e-6 * NM, reach * NM, None))
    return found, found.threshold()


def continued(large: Topography, bands: Bands, spacing: float, seed: int) -> Topography:
    """The waves of the large map down to twice its shortest, and random ones of the joined spectrum below.

    The large map is continued by its mirror images: its waves are cosines, which lie on the finer grid as they are.
    """
    level, n = detrend(large), round(large.lengths[0] / spacing)
    shortest = float(spectrum(level)[0][-1]) / 2
    waves = scipy.fft.dctn(level.heights, norm="ortho")
    q = np.pi / large.lengths[0] * np.hypot(*np.meshgrid(*map(np.arange, waves.shape), indexing="ij"))
    fine = np.zeros((n, n))
    fine[: waves.shape[0], : waves.shape[1]] = np.where(q < shortest, waves, 0.0) * n / waves.shape[0]
    known = constant_in(bands)
    _, more = random_surface(lambda k: np.where(k >= shortest, known(k), 0.0), spacing, n, seed)
    return Topography(scipy.fft.idctn(fine, norm="ortho") + more, large.lengths)


def judged_by(works: Sequence[float], ends: Sequence[tuple[float, float]], sampling: float) -> dict[str, float]:
    """The estimate of some continuations, and its interval: the method's, the sampling error, Student's error of their
    mean, in quadrature.
    """
    logs = np.log(works)
    middle, spread = float(logs.mean()), float(logs.std(ddof=1))
    student = float(scipy.special.stdtrit(DRAWN - 1, (1 + CONFIDENCE) / 2))
    more = student * spread / np.sqrt(DRAWN), ERRORS * sampling
    low, high = (float(np.mean([np.log(end[i] / work) for end, work in zip(ends, works, strict=True)])) for i in (0, 1))
    return {"work": float(np.exp(middle)), "spread": spread, "sampling": sampling,
            "low": float(np.exp(middle - np.hypot(low, np.linalg.norm(more)))),
            "high": float(np.exp(middle + np.hypot(high, np.linalg.norm(more))))}  # fmt: skip


def joined_spot(heights: Real, i: int, j: int, rng: Rng, reach: float) -> dict[str, float]:
    """A large map of every fourth point and a small one from elsewhere, pressed with random fine waves."""
    part = SIDE // PART
    large = measured(heights[i : i + SIDE : PIXEL, j : j + SIDE : PIXEL], PIXEL)
    k, m = rng.integers(0, WHOLE - part, 2)
    together = joined([large, measured(heights[k : k + part, m : m + part])])
    assert together.bands is not None
    edges, density = together.bands
    fit = fit_self_affine(np.sqrt(edges[1:] * edges[:-1]), density)
    roll_off = fit.roll_off if fit is not None and fit.roll_off else large.extent
    works, ends, errors = [], [], []
    for seed in range(DRAWN):
        state, one = pressed(continued(large, together.bands, NM, seed), reach)
        works.append(one.work)
        ends.append((one.low, one.high))
        errors.append(state.sampling_error(roll_off))
    return judged_by(works, ends, float(np.mean(errors))) | {"roll_off": roll_off / NM} | alone(together, reach)


def lines_spot(heights: Real, i: int, j: int, reach: float) -> dict[str, float]:
    """Lines across a spot, pressed as random surfaces of their spectrum."""
    lines, works, ends = NM * heights[i : i + SIDE : SIDE // LINES, j : j + SIDE], [], []
    for seed in range(DRAWN):
        drawn = isotropic_surface(lines, SIDE * NM, seed=seed)
        _, one = pressed(drawn, reach)
        works.append(one.work)
        ends.append((one.low, one.high))
    return judged_by(works, ends, 0.0) | {"roll_off": float(SIDE)} | alone(drawn, reach)


def alone(spectral: Topography, reach: float) -> dict[str, float]:
    """The interval of the spectrum alone, which the program prints today."""
    found = bounds(rough_contact(roughness_of(spectral).whole, Interface(1.0, 1e-6 * NM, reach * NM, None)), "no map")
    return {"alone_low": found.low, "alone_high": found.high}


def rows(kind: str, ratio: int) -> list[dict[str, object]]:
    """The spots of a surface, joined and by lines."""
    heights, found = whole(kind, ratio), list[dict[str, object]]()
    places = np.random.default_rng(SEED).permutation((WHOLE // SIDE) ** 2)[:SPOTS]
    reach = RANGE * float(heights.std())
    known = pressed(measured(heights, periodic=True), reach)[1].work
    for place in places:
        i, j = (SIDE * int(x) for x in divmod(place, WHOLE // SIDE))
        rng = np.random.default_rng([SEED, int(place), ratio])
        for how, numbers in (("joined", joined_spot(heights, i, j, rng, reach)),
                             ("lines", lines_spot(heights, i, j, reach))):  # fmt: skip
            found.append({"how": how, "kind": kind, "ratio": ratio, "spot": int(place)}
                         | {name: f"{value:.6g}" for name, value in ({"whole": known} | numbers).items()})  # fmt: skip
    return found


def read() -> DataFrame:
    """The spots that state an interval, with what is judged of each."""
    rows = read_csv(FILE)
    rows = rows[rows.low.notna()]
    return rows.assign(
        held=(rows.low <= rows.whole) & (rows.whole <= rows.high),
        alone=(rows.alone_low <= rows.whole) & (rows.whole <= rows.alone_high),
        width=np.log(rows.high / rows.low) / np.log(rows.alone_high / rows.alone_low),
        over=np.log(rows.work / rows.whole),
    )


def by_kind(rows: DataFrame) -> Sheet:
    """How often the interval of each kind holds the whole, and how far the estimate is from it."""
    cells = []
    for kind in KINDS:
        cell = [kind]
        for how in HOWS:
            own = rows[(rows.kind == kind) & (rows.how == how)]
            cell += [f"{int(own.held.sum())} of {len(own)}", f"{np.exp(own.over.mean()):.2f}"]
        cells.append(tuple(cell))
    head = ("kind", *(f"{how}: {what}" for how in HOWS for what in ("held", "estimate over the whole")))
    return Sheet.of("Pressed joined measurements", head, cells)


def verdicts(rows: DataFrame) -> str:
    """Each row of the statement with its verdict, for joined measurements and for line scans."""
    lines = []
    for how in HOWS:
        own = rows[rows.how == how]
        share, width = own.held.mean(), own.width.median()
        lines.append(
            f"* {how}: {share:.0%} of {len(own)} intervals hold the whole ({own.alone.mean():.0%} of those of the "
            f"spectrum alone): **{word(share >= 0.9, share < 0.75)}**; they are {width:.2f} times as wide: "
            f"**{word(width <= 0.5, width > 0.75)}**"
        )
    return "\n".join(lines)


def word(held: bool, refuted: bool) -> str:
    """The verdict."""
    return "refuted" if refuted else "held" if held else "not decided"


def main() -> None:
    """Add the spots that are missing, and print the tables."""
    add(FILE, rows, RATIOS, KINDS)
    sys.stdout.write(by_kind(read()).markdown() + "\n" + verdicts(read()))


if __name__ == "__main__":
    sys.exit(main())
