"""The law of stickiness on surfaces of few long waves: thresholds at periods of 16 to 1 λ_L (docs/studies/periods.md).

``python -m docs.studies.periods results/law-period --into docs/measured`` writes ``law-period.csv`` (all thresholds)
and prints the table; without a folder it reads that file.  The thresholds at 8 λ_L are those of ``law.csv.gz``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from pandas import DataFrame, concat, read_csv

from docs.studies.judgement import (
    LEVEL,
    MEASURED,
    SCATTER,
    SURFACES,
    TOO_MUCH,
    Mean,
    scatter,
    thresholds_of,
    with_ratios,
)

FILE = "law-period.csv"
HURST = (0.4, 0.8)
"""Of the thresholds at 8 λ_L those that are alike: these H, the spline, 1 % of the area."""


def alike(rows: DataFrame) -> DataFrame:
    """Thresholds of the record of the law that differ from these by the period alone, and by the points of a wave."""
    width = rows.lambda_L / rows.lambda_s
    chosen = (rows["shape"] == "spline") & (rows.area == 0.01) & rows.hurst.isin(HURST) & (rows.n == 1024)
    return rows[chosen & (width == 32)]


def word(rows: DataFrame, factor: float, level: Mean) -> str:
    """Held, refuted or neither, by the bounds of the page: of the scatter, and of the level."""
    if rows.seed.nunique() < SURFACES:
        return "not tested"
    if factor > TOO_MUCH or level.excludes(LEVEL):
        return "refuted"
    return "held" if factor <= SCATTER and 1 / LEVEL <= level.value <= LEVEL else "held with a remark"


def lines(found: DataFrame) -> Iterator[str]:
    """Of each period: level and scatter of w/(U F), and how far its surfaces lie apart."""
    yield "| period | points to λ_s | thresholds | surfaces | w/(U F) | scatter | surfaces apart: sd of ln w/(U F) | |"
    yield "|---|---|---|---|---|---|---|---|"
    rows = with_ratios(found)
    rows["period"] = (rows.n / rows.lambda_L).round()
    for period, each in sorted(rows.groupby("period"), reverse=True):
        by_surface = each.groupby("seed").left.mean()
        level, factor = Mean.of(by_surface.to_numpy()), scatter(each.left.to_numpy(), each.seed.to_numpy())
        yield (
            f"| {period:g} λ_L | {each.lambda_s.iloc[0]:g} | {len(each)} | {len(by_surface)} | {level} | {factor:.3f} "
            f"| {by_surface.std(ddof=1):.2f} | **{word(each, factor, level)}** |"
        )
    yield ""
    yield "| period | H | Δr/h_rms | surfaces | w/(U F) |"
    yield "|---|---|---|---|---|"
    for (period, hurst, delta), each in sorted(rows.groupby(["period", "hurst", "delta"]), reverse=True):
        yield f"| {period:g} λ_L | {hurst:g} | {delta:g} | {each.seed.nunique()} | {Mean.of(each.left.to_numpy())} |"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, help=f"of the sweep; none: docs/measured/{FILE}")
    parser.add_argument("--into", type=Path, help=f"folder of {FILE}")
    options = parser.parse_args(arguments)
    found = read_csv(MEASURED / FILE) if options.folder is None else thresholds_of(options.folder)
    if options.into is not None:
        found.to_csv(options.into / FILE, index=False, float_format="%.6g")
    judged = concat([alike(read_csv(MEASURED / "law.csv.gz")), found], ignore_index=True)
    sys.stdout.write("\n".join(lines(judged)) + "\n")


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main()
