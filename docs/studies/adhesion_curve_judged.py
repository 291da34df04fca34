"""The adhesion curve judged by the bounds of docs/studies/adhesion_curve.md."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from pandas import DataFrame, Series, concat, read_csv

from continuum.maps.verdict.adhesion import FEWEST_PATCHES, LARGEST_X, LEAST_UNLOADED, MOST_MOVED
from continuum.store.sheet import Sheet
from docs.studies.adhesion_curve import FACTORS, FILE, SEEDS

LEAST_AREA, ZERO = 1e-3, (5e-3, 0.12)
"""Least area of a largest tension, and areas at zero load, that the statement is about."""
RIGHT, LITTLE = 0.15, 0.02
"""Relative error up to which a pull-off stress is right, and loss of a loop, over w, that is little."""


class Judged(NamedTuple):
    """A row of the statement: what was found, and the verdict."""

    name: str
    found: str
    held: bool
    refuted: bool

    @property
    def word(self) -> str:
        """The verdict."""
        return "refuted" if self.refuted else "held" if self.held else "not decided"


def read() -> DataFrame:
    """The loops, with the ratios of predicted and solved numbers where the statement is about them."""
    rows = read_csv(FILE)
    touching = (rows.least_area >= LEAST_AREA) & (rows.least_patches >= FEWEST_PATCHES)
    inside = (rows.least_inside == 1) & (rows.solved_least_inside == 1)
    zero = rows.zero_area.between(*ZERO) & rows.solved_zero_area.notna()
    return rows.assign(
        zero=(rows.zero_area / rows.solved_zero_area - 1).where(zero),
        tension=(rows.least / rows.solved_least - 1).where(touching & inside),
        probe=rows.sphere / rows.solved_sphere - 1,
        held=rows.least / rows.solved_pull_off,
        lost=rows.solved_lost / rows.work,
        flagged=(rows.moved > MOST_MOVED) | ~(rows.least_patches >= FEWEST_PATCHES) | (rows.least_inside != 1),
    )


def attraction(rows: DataFrame, name: str = "N") -> DataFrame:
    """Errors of the attraction at 1 and 5 % of the area where the statement is about it; or those of the quadratic."""
    found = []
    for percent in (1, 5):
        free, solved = rows[f"N0_{percent}"], rows[f"solved_N_{percent}"]
        error = (free - rows[f"{name}_{percent}"]) / (free - solved) - 1
        chosen = (rows[f"x_{percent}"] <= LARGEST_X) & (rows[f"patches_{percent}"] >= FEWEST_PATCHES) & error.notna()
        found.append(rows[chosen].assign(error=error[chosen]))
    return concat(found)


def rms(values: Series) -> float:
    """Root mean square."""
    return float(np.sqrt((values**2).mean()))


def within(values: Series, limit: float) -> float:
    """Share of the values that are known and at most so large."""
    return float((values.dropna().abs() <= limit).mean())


def judged(rows: DataFrame) -> Iterator[Judged]:
    """Each row of the statement."""
    part, far = attraction(rows), rows[rows.factor == max(FACTORS)]
    share, error = within(part.error, 0.08), rms(part.error)
    yield Judged(
        "attraction", f"{share:.0%} of {len(part)} states within 8 %, rms {error:.1%}",
        share >= 0.9 and error <= 0.05, error > 0.1,
    )  # fmt: skip
    for column, name, limit in (("zero", "area at zero load", 0.15), ("tension", "least load", 0.2),
                                ("probe", "probe", 0.15)):  # fmt: skip
        share, count = within(rows[column], limit), int(rows[column].notna().sum())
        yield Judged(name, f"{share:.0%} of {count} within {limit:.0%}", share >= 0.9, share < 0.75)
    share = float((rows.held <= 1.1).mean())
    yield Judged("lower bound", f"{share:.0%} of {len(rows)} loops", share >= 0.95, share < 0.9)
    test = rows[rows.seed == SEEDS[-1]]
    plain, little = test[~test.flagged], test[test.lost < LITTLE]
    right, kept = within(plain.held - 1, RIGHT), float((~little.flagged).mean())
    yield Judged(
        "at least", f"{right:.0%} of {len(plain)} unflagged right to {RIGHT:.0%}; {kept:.0%} of those that lose little "
        "are not flagged", right >= 0.9 and kept >= 0.5, right < 0.75,
    )  # fmt: skip
    mine, other = (rms(attraction(far, name).error) for name in ("N", "quadratic"))
    yield Judged(
        f"better than the quadratic at {max(FACTORS):g} w_c", f"rms {mine:.1%}, {other:.1%}", mine < other, mine > other
    )


def whole(rows: DataFrame) -> str:
    """What would refute all: an attraction wrong by more than 10 % rms on any law, range or response."""
    part, worst = attraction(rows), ("", 0.0)
    for column in ("shape", "delta", "kind"):
        for name, group in part.groupby(column):
            if len(group) >= 5 and rms(group.error) > worst[1]:
                worst = str(name), rms(group.error)
    return f"{worst[0]}, {worst[1]:.1%}"


def verdicts(rows: DataFrame) -> Sheet:
    """The statement with its verdicts."""
    return Sheet.of(
        "Verdicts", ("statement", "found", "verdict"), [(one.name, one.found, one.word) for one in judged(rows)]
    )


def by_unloaded(rows: DataFrame) -> Sheet:
    """Forces on a probe by the work of adhesion, and by the area without load that is predicted."""
    groups = {f"{factor:g} w_c": rows.factor == factor for factor in FACTORS}
    groups |= {f"at least {LEAST_UNLOADED:.1%} touch without load": rows.zero_area >= LEAST_UNLOADED,
               "less": rows.zero_area < LEAST_UNLOADED}  # fmt: skip
    cells = []
    for name, chosen in groups.items():
        probe = rows.probe[chosen].dropna()
        cells.append((name, probe.size, f"{within(probe, RIGHT):.0%}"))
    return Sheet.of("The probe", ("loops", "number", f"within {RIGHT:.0%}"), cells)


def by_kind(rows: DataFrame) -> Sheet:
    """Ratios by kind of surface."""
    part, cells = attraction(rows), []
    for kind, group in rows.groupby("kind"):
        plain = group[~group.flagged]
        ends = f"{plain.held.min():.2f} to {plain.held.max():.2f}" if len(plain) else "-"
        cells.append((
            str(kind), f"{rms(part[part.kind == kind].error):.1%}",
            f"{1 + group.zero.min():.2f} to {1 + group.zero.max():.2f}" if group.zero.notna().any() else "-",
            ends, f"{int(group.flagged.sum())} of {len(group)}", f"{group.lost.max():.3f}",
        ))  # fmt: skip
    head = ("kind", "attraction, rms error", "area at zero load, over the solver's", "pull-off stress, not flagged",
            "flagged: at least", "most lost in a loop, in w")  # fmt: skip
    return Sheet.of("By kind", head, cells)
