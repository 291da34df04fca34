"""The law of stickiness at a range of 0.16 h_rms: thresholds at two ranges of the same surfaces, 2048², against
docs/studies/short_range.md.

``python -m docs.studies.short_range results/law-short ... --into docs/measured`` writes ``law-short.csv``, the
thresholds of all these folders, and prints the table; without a folder it reads that file.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from pandas import DataFrame, concat, read_csv

from docs.studies.judgement import MEASURED, SURFACES, Mean, thresholds_of, with_ratios

FILE = "law-short.csv"
SHORT, LONG = 0.16, 0.5
"""Ranges, in h_rms."""
ALIKE = 1.07
"""Factor within which the levels at the two ranges are the same."""
PLATEAU = {"spline": 0.72, "exponential": 0.66}
"""Level at the short range over that at the long one, if F ended in a plateau at the long one."""


def word(ratio: Mean, plateau: float) -> str:
    """Whether F goes on to shorter ranges as stated, by the ratio of the levels."""
    if ratio.surfaces < SURFACES:
        return "not tested"
    if ratio.excludes(ALIKE):
        return "refuted"
    return "held" if 1 / ALIKE <= ratio.value <= ALIKE and ratio.low > plateau else "held with a remark"


def lines(found: DataFrame) -> Iterator[str]:
    """Levels of w/(U F) at both ranges, and their ratio on the same surfaces, for each shape and H."""
    rows = with_ratios(found)
    yield "| shape | H | surfaces | w/(U F) at 0.16 h_rms | at 0.5 h_rms | the one over the other | at a plateau | |"
    yield "|---|---|---|---|---|---|---|---|"
    for (shape, hurst), each in sorted(rows.groupby(["shape", "hurst"]), reverse=True):
        left = each.pivot_table(index="seed", columns="delta", values="left").reindex(columns=[SHORT, LONG]).dropna()
        if len(left) < 2:
            continue
        short, long = (Mean.of(left[delta].to_numpy()) for delta in (SHORT, LONG))
        ratio = Mean.of((left[SHORT] - left[LONG]).to_numpy())
        yield (
            f"| {shape} | {hurst:g} | {len(left)} | {short} | {long} | {ratio} "
            f"| {PLATEAU[shape]:g} | **{word(ratio, PLATEAU[shape])}** |"
        )


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path, help=f"of the sweep, in parts; none: docs/measured/{FILE}")
    parser.add_argument("--into", type=Path, help=f"folder of {FILE}")
    options = parser.parse_args(arguments)
    read = map(thresholds_of, options.folders) if options.folders else [read_csv(MEASURED / FILE)]
    found = concat(list(read), ignore_index=True)
    if options.into is not None:
        found.to_csv(options.into / FILE, index=False, float_format="%.6g")
    sys.stdout.write("\n".join(lines(found)) + "\n")


if __name__ == "__main__":
    np.seterr(all="raise", under="ignore")
    main()
