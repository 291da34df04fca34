"""The law of stickiness at bandwidths of 64 to 512, beside the two theories that share its collapse.

``python -m docs.studies.law_bandwidth --expected`` prints what each says of these surfaces before any run;
``python -m docs.studies.law_bandwidth results/law-bandwidth ... --into docs/measured`` writes ``law-bandwidth.csv``,
the thresholds of all these folders, and prints what became of it; without a folder it reads that file.
"""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from pandas import DataFrame, concat, read_csv

from continuum.inputs.toml import find
from continuum.model.grid import Grid
from continuum.model.surfaces import SelfAffineSurface
from docs.studies.judgement import LEVEL, MEASURED, SURFACES, Mean, thresholds_of, with_ratios
from docs.studies.rivals import compared

FILE = "law-bandwidth.csv"
THEORIES = {"law": "U F", "weak": "Persson and Scaraggi", "bearing": "bearing area"}
ALIKE = 1.07
"""Factor within which w over that of a theory is the same at four times the bandwidth."""
SETS = (("spline", 0.01), ("exponential", 0.01), ("spline", 0.001))
"""Shape of the attraction, and the area at which the sign of the load is taken."""
STATED = (0.01,)
"""Areas for which F was stated."""
FACTOR = 4
"""Between the two bandwidths that are compared."""


def surfaces() -> DataFrame:
    """The surfaces of the sweep under each shape and at each area, with a work of 1 where the threshold is sought."""
    given = tomllib.loads(find("inputs/sweep/law-bandwidth.toml").read_text(encoding="utf-8"))
    (zipped,), rows = given["sweep"]["zipped"], []
    for n, wide, height, reach in zip(*zipped.values(), strict=True):
        grid = Grid.square(n)
        for seed in given["sweep"]["axes"]["surface.seed"]:
            surface = given["surface"] | {"lambda_L": wide, "rms_height": height, "seed": seed}
            power = np.abs(grid.forward(SelfAffineSurface(**surface).build(grid))) ** 2 * grid.mode_weights
            power[0, 0] = 0.0
            moments = {f"moment_{p}": float((grid.wavenumber**p * power).sum()) for p in (1, 2, 4)}
            rows += [
                {"n": n, "shape": shape, "hurst": surface["hurst"], "lambda_s": surface["lambda_s"], "lambda_L": wide,
                 "seed": seed, "area": area, "height": height, "slope": moments["moment_2"] ** 0.5,
                 "curvature": moments["moment_4"] ** 0.5, "range": reach, "work": 1.0, **moments}
                for shape, area in SETS
            ]  # fmt: skip
    return DataFrame(rows)


def with_theories(found: DataFrame) -> DataFrame:
    """ln of w over that of each theory, by its name, and the bandwidth; works of theories that are stored are read."""
    rows = with_ratios(found)
    if "weak" not in found:
        return compared(rows.assign(period=rows.n))
    ratios = {name: np.log(rows.work / rows[name]) for name in THEORIES if name != "law"}
    return rows.assign(law=rows.left, **ratios)


def changes(rows: DataFrame, name: str, factor: int = FACTOR) -> Iterator[tuple[str, float, int, Mean]]:
    """Of each set and bandwidth: w over that of a theory at a multiple of it, over that at it, by surface."""
    for shape, area in SETS:
        of_set = rows[(rows["shape"] == shape) & (rows.area == area)]
        table = of_set.pivot_table(index="seed", columns="width", values=name)
        for narrow in table.columns:
            if factor * narrow in table.columns:
                each = (table[factor * narrow] - table[narrow]).dropna().to_numpy()
                if each.size:
                    yield shape, area, int(narrow), Mean.of(each)


def expected(rows: DataFrame) -> Iterator[str]:
    """What w/(U F) does by each theory: over that at a quarter of the bandwidth."""
    yield "| shape | area | λ_L/λ_s | by U F | by Persson and Scaraggi | by the bearing area |"
    yield "|---|---|---|---|---|---|"
    # With w = 1 the logarithms are those of 1 over each theory's work.
    said = rows.assign(**{name: rows.law - rows[name] for name in THEORIES})
    for cells in zip(*(changes(said, name) for name in THEORIES), strict=True):
        shape, area, narrow, _ = cells[0]
        values = " | ".join(f"{mean.value:.3f}" for *_, mean in cells)
        yield f"| {shape} | {100 * area:g} % | {narrow} to {FACTOR * narrow} | {values} |"


def word(mean: Mean) -> str:
    """Whether w over that of a theory is the same at both bandwidths."""
    if mean.surfaces < SURFACES:
        return "not tested"
    if mean.excludes(ALIKE):
        return "refuted"
    return "held" if mean.low >= 1 / ALIKE and mean.high <= ALIKE else "not decided"


def judged(rows: DataFrame) -> Iterator[str]:
    """What became of each theory, and of the level."""
    # Doublings were not stated: they have no verdict.
    for factor in (FACTOR, 2):
        yield f"| shape | area | λ_L/λ_s | surfaces | {' | '.join(f'w over {said}' for said in THEORIES.values())} |"
        yield f"|{'---|' * (4 + len(THEORIES))}"
        for cells in zip(*(changes(rows, name, factor) for name in THEORIES), strict=True):
            shape, area, narrow, mean = cells[0]
            found = " | ".join(f"{mean}{f' **{word(mean)}**' if factor == FACTOR else ''}" for *_, mean in cells)
            yield f"| {shape} | {100 * area:g} % | {narrow} to {factor * narrow} | {mean.surfaces} | {found} |"
        yield ""
    yield "| shape | area | λ_L/λ_s | surfaces | w/(U F) | |"
    yield "|---|---|---|---|---|---|"
    for shape, area in SETS:
        for width, part in rows[(rows["shape"] == shape) & (rows.area == area)].groupby("width"):
            mean = Mean.of(part.law.to_numpy())
            said = level(mean) if area in STATED else ""
            yield f"| {shape} | {100 * area:g} % | {width:g} | {mean.surfaces} | {mean} | {said} |"


def level(mean: Mean) -> str:
    """Whether w is U F itself."""
    if mean.surfaces < SURFACES:
        return "**not tested**"
    if mean.excludes(LEVEL):
        return "**refuted**"
    return "**held**" if 1 / LEVEL <= mean.value <= LEVEL else "**held with a remark**"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path, help=f"of the sweep, in parts; none: docs/measured/{FILE}")
    parser.add_argument("--into", type=Path, help=f"folder of {FILE}")
    parser.add_argument("--expected", action="store_true", help="what each theory says, without any threshold")
    options = parser.parse_args(arguments)
    if options.expected:
        sys.stdout.write("\n".join(expected(with_theories(surfaces()))) + "\n")
        return
    read = map(thresholds_of, options.folders) if options.folders else [read_csv(MEASURED / FILE)]
    found = concat(list(read), ignore_index=True)
    rows = with_theories(found)
    if options.into is not None:
        works = {name: rows.work * np.exp(-rows[name]) for name in THEORIES if name != "law"}
        found.assign(**works).to_csv(options.into / FILE, index=False, float_format="%.6g")
    sys.stdout.write("\n".join(judged(rows)) + "\n")


if __name__ == "__main__":
    main()
