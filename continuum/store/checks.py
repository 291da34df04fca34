"""Table of the quantities that a certificate checked."""

from collections.abc import Iterable
from itertools import groupby

from continuum.measure.certificate import Examination
from continuum.store.sheet import Column, Sheet


def quantities(points: Iterable[Examination]) -> Sheet:
    """Quantities checked, the number of points, and for each the point nearest to or furthest beyond its bound."""
    looked = list(points)
    columns = (
        Column("quantity"), Column("points"), Column("worst: stored", "", ".6g"), Column("found", "", ".6g"),
        Column("off", "", ".1e"), Column("allowed", "", ".1e"), Column(""),
    )  # fmt: skip
    checks = sorted((check for one in looked for check in one.checks), key=lambda check: check.quantity)
    rows = []
    for quantity, group in groupby(checks, key=lambda check: check.quantity):
        every = list(group)
        # What fails comes first, NaN too.
        worst = max(every, key=lambda check: (not check.ok, check.off / check.allowed if check.allowed else 0.0))
        rows.append((quantity, len(every), *worst[1:5], "sound" if worst.ok else "FAILS"))
    left_out = dict.fromkeys(name for one in looked for name in one.left_out)
    note = f"Not looked at: {', '.join(left_out)}." if left_out else ""
    return Sheet.of("What was looked at, in a0 and E*", columns, rows, note)
