"""A sweep on the screen: how far it is, and what one call did."""

from __future__ import annotations

import math

from continuum.files.output import LockedError
from continuum.show.sheet import Sheet, pairs
from continuum.sweeps.collect import PointTable, SweepStatus
from continuum.sweeps.tasks import TaskResult

_MOST = 20


def result_line(ended: TaskResult) -> str:
    """One system, in a line."""
    if ended.ok:
        return f"{ended.task.label}: {'was there' if ended.found else f'{ended.seconds:.1f} s'}"
    if isinstance(ended.error, LockedError):
        return f"{ended.task.label}: locked by another process"
    return f"{ended.task.label}: {ended.reason.splitlines()[0]}"


def status_sheet(found: SweepStatus) -> Sheet:
    """How far a sweep is."""
    rows: list[tuple[str, str | int]] = [
        ("systems", found.total),
        ("done", found.done),
        ("running", len(found.running)),
        *(("", text) for text in found.running[:_MOST]),
        ("failed", len(found.failed)),
        ("left", found.total - found.done - len(found.failed)),
    ]
    if not math.isnan(found.rate):
        rows.append(("lately", f"{found.rate:.3g} systems an hour"))
    if found.done < found.total and not math.isnan(found.seconds_left):
        rows.append(("time left, about", f"{found.seconds_left / 3600:.2g} h at that rate"))
    if found.others:
        rows.append(("of an earlier input, kept", found.others))
    return pairs(found.listing.name, rows)


def failed_sheet(found: SweepStatus) -> Sheet:
    """Table of the systems that failed, with the reasons."""
    rows = list(found.failed[:_MOST])
    note = f"and {len(found.failed) - _MOST} more" if len(found.failed) > _MOST else ""
    return Sheet.of("failed; --retry tries them again", ("system", "reason"), rows, note)


def table_sheet(found: PointTable) -> Sheet:
    """Table of the columns that were collected."""
    rows: list[tuple[str, str | int]] = [
        ("systems", len(found.keys)),
        ("points", len(found.system)),
        ("points that did not converge, left out", found.unconverged),
        ("systems that are not done", found.missing),
        ("files that cannot be read", len(found.faults)),
        *(("computed with", f"{made}: {count} systems") for made, count in found.provenance.items()),
    ]
    return pairs(found.listing.name, rows)
