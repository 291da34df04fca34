"""Two theories without a free parameter beside every threshold on record: `python -m docs.studies.rivals`.

Persson and Scaraggi's weak adhesion and the bearing area for any spectrum (:mod:`docs.studies.persson`), and the
law of docs/law.md, against w at the threshold of docs/measured/law.csv.gz (period 8 λ_L) and
docs/studies/record/record.csv (period 2 λ_L).  ``--run`` evaluates both, a good minute, and writes
``docs/measured/rivals.csv``, from which the table is made.  ``--parts`` takes the first apart on one surface.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np
from pandas import DataFrame, concat, read_csv

import continuum as c
from continuum.model.grid import Grid
from continuum.model.surfaces import SelfAffineSurface
from continuum.model.walls.attraction import Shape, attraction_on_core
from continuum.path.threshold import press_without_adhesion
from docs.studies.judgement import MEASURED
from docs.studies.law import fit, thresholds
from docs.studies.persson import PerssonContact

FAR = 60.0
"""Ranges to which an attraction without end is integrated."""
FILE = "rivals.csv"
STORED = ["source", "shape", "hurst", "lambda_s", "lambda_L", "seed", "area", "delta", "law", "weak", "bearing"]
"""What is kept of a threshold; the last three are logarithms of w over what each theory says."""
CORE = 5.0
"""Stiffness of the wall's core in the sweeps, in E*/a0."""
HARD = 1e-4
"""Work of the wall over core stiffness and range²: a wall of any range has the same shape, in units of it."""


def recorded() -> DataFrame:
    """Thresholds at 1 % area and more: those that tested the law, and those from which it was made."""
    tested = read_csv(MEASURED / "law.csv.gz").assign(source="law", period=lambda rows: rows.n)
    tested = tested.assign(energy=tested.moment_1 / 4)
    made = read_csv(Path(__file__).parent / "record" / "record.csv").query("source == 'threshold'")
    names = {"law": "shape", "rms_height": "height", "rms_slope": "slope", "conformal_energy": "energy"}
    made = made.rename(columns=names).assign(area=0.01, period=2 * made.lambda_L, source="record")
    columns = ["source", "shape", "hurst", "lambda_s", "lambda_L", "period", "seed", "area", "height", "slope",
               "energy", "range", "work"]  # fmt: skip
    rows = concat([tested[columns], made[columns]], ignore_index=True)
    return rows.assign(delta=(rows.range / rows.height).round(2))


@lru_cache(None)
def surface(
    hurst: float, slope: float, lambda_s: float, lambda_L: float, period: float, gamma: float
) -> PerssonContact:
    """The surface of a threshold, by its parameters; its roughness has the slope of the map."""
    return PerssonContact.self_affine(hurst, slope, lambda_s, lambda_L, period, gamma)


def weak_adhesion(contact: PerssonContact, shape: Shape, reach: float, area: float) -> float:
    """Work at the threshold by Persson and Scaraggi, under the wall of the sweeps on a core that hardly gives way."""
    wall = attraction_on_core(shape, HARD * reach**2, reach, 1.0)
    end = min(wall.reach - wall.zero_gap, FAR * reach)
    work = wall.work_of_adhesion
    return contact.weak_adhesion_threshold(area, lambda gap: -wall.evaluate(wall.zero_gap + gap).traction / work, end)


def compared(rows: DataFrame) -> DataFrame:
    """The logarithms of w over what each theory says."""
    laws = {shape: fit(thresholds(shape)) for shape in ("spline", "exponential")}
    found = []
    for row in rows.itertuples():
        given = row.hurst, row.slope, row.lambda_s, row.lambda_L, row.period
        expected = (
            row.energy * laws[row.shape](row.range / row.height),
            weak_adhesion(surface(*given, 0.45), row.shape, row.range, row.area),
            surface(*given, 0.5).bearing_area_threshold(row.range),
        )
        found.append(np.log(row.work / np.array(expected)))
    return rows.assign(**dict(zip(("law", "weak", "bearing"), np.transpose(found), strict=True)))


def power(part: DataFrame, name: str) -> float:
    """Exponent of λ_L/λ_s in a ratio, each surface at its own level; of thresholds with several λ_L/λ_s."""
    surfaces = [part.hurst, part.seed, part.lambda_L]
    width = np.log(part.lambda_L / part.lambda_s)
    x, y = (values - values.groupby(surfaces).transform("mean") for values in (width, part[name]))
    return float((x * y).sum() / (x * x).sum())


def parts() -> Iterator[str]:
    """On one surface, pressed without adhesion: pressure and mean tension over those of the theory, and w likewise."""
    yield "| area | Δr/h_rms | pressure | attraction | w at the threshold |\n|---|---|---|---|---|"
    rows = read_csv(MEASURED / "law.csv.gz").query("n == 512 and seed == 11 and hurst == 0.8 and shape == 'spline'")
    for row in rows.itertuples():
        grid = Grid.square(row.n)
        heights = SelfAffineSurface(
            kind="self-affine", hurst=row.hurst, lambda_s=row.lambda_s, lambda_L=row.lambda_L, seed=row.seed,
            rms_height=row.height,
        ).build(grid)  # fmt: skip
        wall = attraction_on_core("spline", row.work, row.range, CORE)
        contact = c.Contact(heights, wall=wall, substrate=c.HalfSpace("clamped"), tolerance=1e-5)
        state = press_without_adhesion(contact.problem, row.area, contact.settings, CORE)
        theory = surface(row.hurst, row.slope, row.lambda_s, row.lambda_L, row.n, 0.45)
        pressure, work = theory.pressure(row.area), weak_adhesion(theory, "spline", row.range, row.area)
        found = (state.load / pressure, grid.mean(state.attraction(wall)[0]) / (pressure / work), row.work / work)
        yield f"| {row.area:.0%} | {row.range / row.height:g} | {' | '.join(f'{ratio:.2f}' for ratio in found)} |"


def lines(rows: DataFrame) -> Iterator[str]:
    """Means of w over that of each theory, by source, shape, area and range."""
    columns = ("law", "weak", "bearing")
    yield (
        "| thresholds of | shape | area | Δr/h_rms | thresholds | w/(U F) | over Persson and Scaraggi "
        "| over the bearing area | powers of λ_L/λ_s in these |\n|---|---|---|---|---|---|---|---|---|"
    )
    for (source, shape, area, delta), part in rows.groupby(["source", "shape", "area", "delta"]):
        of_hurst = part.groupby("hurst")[list(columns)].mean()
        cells = [f"the {source}", shape, f"{area:.0%}", f"{delta:g}", str(len(part))]
        for name in columns:
            low, high = np.exp([of_hurst[name].min(), of_hurst[name].max()])
            cells.append(f"{np.exp(part[name].mean()):.2f} ({low:.2f} to {high:.2f})")
        several = part.lambda_s.nunique() > 1
        cells.append(", ".join(f"{power(part, name):+.2f}" for name in columns) if several else "-")
        yield f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the table of docs/studies/rivals.md."""
    if "--parts" in sys.argv:
        sys.stdout.write("\n".join(parts()) + "\n")
        return
    if "--run" in sys.argv:
        compared(recorded())[STORED].to_csv(MEASURED / FILE, index=False, float_format="%.6g", lineterminator="\n")
    sys.stdout.write("\n".join(lines(read_csv(MEASURED / FILE))) + "\n")


if __name__ == "__main__":
    main()
