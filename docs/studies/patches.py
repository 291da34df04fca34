"""What few contacts do to Eqs. (1) and (4) of the paper, told from what the bandwidth does.

``python -m docs.studies.patches results/patches`` prints the table of docs/studies/patches.md from the files of a sweep
over the period at one bandwidth, and the limit of many contacts: the line through all surfaces in the inverse of their
number.  Without a folder it reads the points stored in docs/measured.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pandas import DataFrame, Series, read_csv
from scipy.stats import t

from docs.studies.bandwidth import QUANTITIES as EVERY
from docs.studies.bandwidth import states
from docs.studies.bandwidth import stored as stored_points
from docs.studies.judgement import MEASURED

QUANTITIES = {name: column for name, column in EVERY.items() if column in ("kappa_rep", "ratio", "diameter_ratio")}
GROUPS = ["wall", "width", "target"]


def limit(patches: Series, values: Series) -> tuple[float, float]:
    """Value for many contacts and half its 95 % interval: a line in 1/N, each surface with the weight N.

    The variance of a mean over N independent contacts is inversely proportional to N.
    """
    weights = np.sqrt(patches.to_numpy(dtype=float))
    matrix = np.column_stack([np.ones_like(weights), 1 / patches]) * weights[:, None]
    found, _, _, _ = np.linalg.lstsq(matrix, values * weights, rcond=None)
    left, free = values * weights - matrix @ found, len(values) - 2
    variance = float(left @ left) / free * np.linalg.inv(matrix.T @ matrix)[0, 0]
    return float(found[0]), float(t.ppf(0.975, free) * np.sqrt(variance))


def stored() -> DataFrame:
    """The states in docs/measured, with the number of contacts and the area that was asked for."""
    rows, every = stored_points(("patches",), "valid"), read_csv(MEASURED / "patches.csv")
    return rows.assign(patches=every.patches, target=every.target)


def lines(rows: DataFrame) -> Iterator[str]:
    """Means over surfaces with 95 % intervals at each period, and the limit of many contacts below them."""
    yield f"| wall | λ_L/λ_s | area | period | surfaces | contacts | {' | '.join(QUANTITIES)} |"
    yield "|---" * (6 + len(QUANTITIES)) + "|"
    rows = rows.assign(period=(np.sqrt(rows.area) / rows.lambda_L).round())
    for (wall, width, target), group in rows.groupby(GROUPS):
        head = f"| {wall} | {width:g} | {100 * target:g} % |"
        for period, each in group.groupby("period"):
            count = len(each)
            cells = [
                f"{each[column].mean():.3g} ± {t.ppf(0.975, count - 1) * each[column].std() / np.sqrt(count):.2g}"
                if count > 1 and np.isfinite(each[column]).all() else "-" for column in QUANTITIES.values()
            ]  # fmt: skip
            yield f"{head} {period:g} λ_L | {count} | {each.patches.mean():.0f} | {' | '.join(cells)} |"
        if group.period.nunique() > 2:
            limits = [
                "{:.3g} ± {:.2g}".format(*limit(group.patches, group[column]))
                if np.isfinite(group[column]).all() else "-" for column in QUANTITIES.values()
            ]  # fmt: skip
            yield f"{head} limit | {len(group)} | many | {' | '.join(f'**{cell}**' for cell in limits)} |"


if __name__ == "__main__":
    rows = states(Path(sys.argv[1]), "valid") if len(sys.argv) > 1 else stored()
    sys.stdout.write("\n".join(lines(rows)) + "\n")
