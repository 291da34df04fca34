"""Runs, analyses and sweeps as text and tables."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from continuum.files.output import LockedError
from continuum.files.toml import text_of
from continuum.path.state import HYSTERESIS, NOT_LOOKED, not_looked_at
from continuum.runs.analysis import Analysis, MeasuredPoint
from continuum.runs.record import PathEvent, Point
from continuum.runs.result import Result
from continuum.show.sheet import Column, Sheet, pairs
from continuum.sweeps.collect import PointTable
from continuum.sweeps.crossings import Crossing
from continuum.sweeps.status import SweepStatus
from continuum.sweeps.sweep import SweepListing
from continuum.sweeps.workers import TaskResult

_POINT = (Column("step"), Column("branch"), Column("mean gap", "a0"))
_MOST = 20


def words(status: str) -> str:
    """The name of a status in lower case words."""
    return status.lower().replace("_", " ")


def progress_line(point: Point, seconds: float) -> str:
    """The progress line of a finished point."""
    place = f"mean gap {point.mean_gap:.4g} a0, separation {point.separation:.4g} a0, A_rep {point.area_rep:.4g}"
    search = f" and {point.search_pairs:.0f} in the search" if point.search_pairs else ""
    work = f"residual {point.residual:.1e}, FFT pairs {point.fft_pairs:.0f}{search}, {seconds:.1f} s"
    return f"{place}, N {point.load:.4g} E*, {work}, {words(point.status)}"


def run_sheets(result: Result) -> list[Sheet]:
    """The points of a run, and its jumps if it has any."""
    columns = (
        Column("step"), Column("branch"), Column("mean gap", "a0", ".5g"), Column("separation", "a0", ".5g"),
        Column("A_rep/A0"), Column("A_att/A0"), Column("N/A0", "E*", ".4e"), Column("N_rep/A0", "E*", ".4e"),
        Column("residual", "E*", ".1e"), Column("FFT pairs", "", ".0f"), Column("search", "", ".0f"), Column("status"),
    )  # fmt: skip
    passed = _not_looked_at(result)
    rows = [
        (i, p.branch, p.mean_gap, p.separation, p.area_rep, p.area_att, p.load, p.load_rep, p.residual, p.fft_pairs,
         p.search_pairs, words(p.status) + (f", {NOT_LOOKED}" if over else ""))
        for i, (p, over) in enumerate(zip(result.points, passed, strict=True))
    ]  # fmt: skip
    notes = [f"{result.resumed} points were stored before"] if result.resumed else []
    notes += [HYSTERESIS] if any(passed) else []
    sheets = [Sheet.of("Points of the path", columns, rows, "; ".join(notes))]
    return [*sheets, _jumps(result.events)] if result.events else sheets


def _not_looked_at(result: Result) -> list[bool]:
    """Points to which the way back may have passed over jumps; none without adhesion, where there is one branch."""
    loading = result.config.loading
    looks = loading.event_resolution is not None
    one_branch = not result.wall.work_of_adhesion > 0
    points = [(p.branch, p, one_branch or (looks and p.control != "repulsive-area")) for p in result.points]
    return not_looked_at(points, loading.event_threshold)


def _jumps(events: Sequence[PathEvent]) -> Sheet:
    columns = (
        Column("before step"), Column("jump"), Column("of"), Column("from", "", ".6g"), Column("to", "", ".6g"),
        Column("mean gap", "a0", ".5g"), Column("after", "a0", ".5g"), Column("A_rep/A0", "", ".5g"),
        Column("after", "", ".5g"), Column("N/A0", "E*", ".4e"), Column("after", "E*", ".4e"),
    )  # fmt: skip
    rows = [
        (step, e.kind, e.control, e.before.value, e.after.value, e.before.mean_gap, e.after.mean_gap,
         e.before.area_rep, e.after.area_rep, e.before.load, e.after.load)
        for step, e in events
    ]  # fmt: skip
    return Sheet.of("Jumps and thresholds, with both sides of each", columns, rows)


def threshold_sheet(result: Result) -> Sheet:
    """The threshold at each area of a result of :func:`continuum.threshold`, with its bracket."""
    columns = (
        Column("A_rep/A0"), Column("w at the threshold", "E* a0", ".4g"), Column("below", "E* a0", ".5g"),
        Column("above", "E* a0", ".5g"), Column("N_rep/A0", "E*", ".3e"), Column("N/A0", "E*", ".1e"),
        Column("A_att/A0"), Column("FFT pairs", "", ".0f"), Column("status"),
    )  # fmt: skip
    brackets = dict(result.events)
    rows = []
    for i, p in enumerate(result.points):
        ends = (brackets[i].before.value, brackets[i].after.value) if i in brackets else (np.nan, np.nan)
        jump = ", the load jumps over zero" if i in brackets and brackets[i].kind == "jump-in" else ""
        pairs = p.fft_pairs + p.search_pairs
        rows.append(
            (p.area_rep, p.work_of_adhesion, *ends, p.load_rep, p.load, p.area_att, pairs, words(p.status) + jump)
        )
    return Sheet.of("Work of adhesion above which the surface is sticky", columns, rows)


def analysis_sheets(analysis: Analysis) -> list[Sheet]:
    """Measurements on a run: each point, and the run as a whole."""
    sheets = [_loads(analysis), _geometry(analysis)]
    if any(point.fields for point in analysis.points):
        sheets.append(_outside(analysis))
    return [*sheets, _whole(analysis)]


def _head(measured: MeasuredPoint) -> tuple[int, str, float]:
    return measured.step, measured.point.branch, measured.point.mean_gap


def _loads(analysis: Analysis) -> Sheet:
    columns = (
        *_POINT, Column("A_rep/A0"), Column("A_att/A0"), *(Column(n, "E*", ".3e") for n in ("N/A0", "p_rep", "p_att")),
        Column("1/κ"), Column("κ_rep"), Column("κ_att"), Column("k_N", "E*/a0", ".3e"),
    )  # fmt: skip
    rows = []
    for measured in analysis.points:
        n = measured.numbers
        inverse = 1 / n.kappa if n.kappa else np.nan
        rows.append(
            (*_head(measured), n.area_rep, n.area_att, n.load, n.pressure_rep, n.pressure_att, inverse, n.kappa_rep,
             n.kappa_att, measured.stiffness)
        )  # fmt: skip
    return Sheet.of("Loads", columns, rows)


def _geometry(analysis: Analysis) -> Sheet:
    names = ("P", "d_rep", "d_rep with 1.1107", "chord", "along x", "along y")
    columns = (*_POINT, Column("N_P"), *(Column(n, "a0") for n in names), Column("patches"), Column("largest", "a0²"))
    rows = []
    for measured in analysis.points:
        n, size = measured.numbers, measured.patch_areas
        lengths = (n.perimeter, n.diameter, n.diameter_exact, n.chord, *n.outline.chords)
        rows.append((*_head(measured), n.perimeter_cells, *lengths, size.size, float(size.max(initial=0.0))))
    return Sheet.of("Repulsive contact: P and d_rep with the paper's factor 1.1222", columns, rows)


def _outside(analysis: Analysis) -> Sheet:
    columns = (
        *_POINT, Column("d_att", "a0"), Column("A_att/P", "a0"), Column("Eq. (S-2)", "a0"), Column("gap/Eq. (S-1)"),
        Column("to"), *(Column(n) for n in ("A_rep/A0", "±", "corrected", "contour", "interior", "dilated")),
    )  # fmt: skip
    rows = []
    for measured in analysis.points:
        n, found = measured.numbers, measured.fields
        if found is None:
            continue
        rim = n.area_att * analysis.result.grid.area / n.perimeter if n.perimeter else np.nan
        a = found.areas
        shares = (a.repulsive, a.uncertainty, a.corrected, a.contour, a.interior, a.dilated)
        rows.append((*_head(measured), found.width, rim, found.expected_width, *found.gap_ratio, *shares))
    return Sheet.of("Gap outside the contact; areas by other definitions, as fractions of A0", columns, rows)


def _whole(analysis: Analysis) -> Sheet:
    expected, found = analysis.expected, analysis.adhesion
    rows: list[tuple[str, str]] = [
        ("rms slope h'rms", f"{expected.rms_slope:.4g}"),
        ("rms curvature h''rms", f"{expected.rms_curvature:.4g} 1/a0"),
        ("d_rep, theory 4h'/h''", f"{expected.diameter:.4g} a0"),
        ("d_att, theory Eq. (S-2)", f"{expected.width:.4g} a0"),
        ("A_rep/A_att, theory Eq. (4)", f"{expected.area_ratio:.4g}"),
        ("p_att, theory w/Δr", f"{expected.pressure_att:.4g} E*"),
    ]
    if found is not None:
        ends = "" if found.separated or np.isnan(found.pull_off) else " (path ends under tension: too small)"
        # The error of the trapezoidal rule has either sign.
        lost = f"{found.loss:.4g} E* a0" if found.loss > 1e-6 * found.work_of_separation else "none"
        rows += [
            ("peak load N/A0", f"{found.peak_load:.4g} E*"),
            ("largest tension on approach", f"{found.largest_tension:.4g} E*"),
            ("pull-off tension on retraction", f"{found.pull_off:.4g} E*"),
            ("work of separation per A0", f"{found.work_of_separation:.4g} E* a0{ends}"),
            ("work lost in the cycle per A0", lost),
        ]
    return pairs("Theory and adhesion", rows)


def result_line(ended: TaskResult) -> str:
    """One system, in a line."""
    if ended.ok:
        return f"{ended.task.label}: {'was there' if ended.found else f'{ended.seconds:.1f} s'}"
    if isinstance(ended.error, LockedError):
        return f"{ended.task.label}: locked by another process"
    return f"{ended.task.label}: {ended.reason.splitlines()[0]}"


def status_sheets(found: SweepStatus) -> list[Sheet]:
    """Progress of a sweep, its failures, and the progress of its searches."""
    rows: list[tuple[str, str | int]] = [
        ("systems", found.total),
        ("done", found.done),
        ("running", len(found.running)),
        *(("", text) for text in found.running[:_MOST]),
        *(("a process died", text) for text in found.died[:_MOST]),
        ("failed", len(found.failed)),
        ("left", found.left),
    ]
    if found.crossings:  # the trials of a search are not known in advance
        ended = [one for one in found.crossings if one.complete]
        rows[0], rows[-1] = ("systems so far", found.total), ("searches", len(found.crossings))
        rows += [
            ("crossings found", sum(one.found for one in ended)),
            ("ended without one", sum(not one.found for one in ended)),
            ("not ended", len(found.crossings) - len(ended)),
        ]
    if not math.isnan(found.rate):
        rows.append(("lately", f"{found.rate:.3g} systems an hour"))
    if found.done < found.total and not math.isnan(found.seconds_left):
        rows.append(("time left, about", f"{found.seconds_left / 3600:.2g} h at that rate"))
    if found.others:
        rows.append(("of an earlier input, kept", found.others))
    sheets = [pairs(found.listing.name, rows)]
    if found.failed:
        sheets.append(_beginning(Sheet.of("failed; --retry tries them again", ("system", "reason"), found.failed)))
    if found.crossings:
        sheets.append(_beginning(crossings_sheet(found.listing, found.crossings)))
    return sheets


def _beginning(sheet: Sheet) -> Sheet:
    """As many rows as a terminal shows."""
    more = len(sheet.rows) - _MOST
    return replace(sheet, rows=sheet.rows[:_MOST], note=f"and {more} more") if more > 0 else sheet


def crossings_sheet(listing: SweepListing, crossings: Sequence[Crossing]) -> Sheet:
    """Results of searches so far, one per row."""
    search = listing.bisection
    if search is None:
        return Sheet.of("crossings", ("search",), ())
    axes = [key for axis in listing.axes[:-1] for key in axis.keys]
    ends = (Column(f"{search.column} at {end}", form=".3g") for end in ("lower", "upper"))
    values = (Column(name, form=".6g") for name in (search.key, "lower", "upper"))
    columns: list[Column | str] = ["search", *axes, *values, *ends, "systems", "status"]
    rows = []
    for number, one in enumerate(crossings, 1):
        bracket = one.bracket
        given = [v if isinstance(v, str | int | float) else text_of(v) for v in (one.settings[key] for key in axes)]
        found = (bracket.value, bracket.lower, bracket.upper, bracket.at_lower, bracket.at_upper)
        rows.append((number, *given, *found, bracket.trials, one.status))
    at = "" if search.target is None else f" at {search.target:g}"
    return Sheet.of(f"{search.key} where {search.column}{at} crosses {search.crosses:g}", columns, rows)


def table_sheets(found: PointTable) -> list[Sheet]:
    """The collected points, and the results of searches."""
    rows: list[tuple[str, str | int]] = [
        ("systems", len(found.keys)),
        ("points", len(found.system)),
        ("points that did not converge, left out", found.unconverged),
        ("systems that are not done", found.missing),
        ("files that cannot be read", len(found.faults)),
        *(("computed with", f"{made}: {count} systems") for made, count in found.provenance.items()),
    ]
    searched = [_beginning(crossings_sheet(found.listing, found.crossings))] if found.crossings else []
    return [pairs(found.listing.name, rows), *searched]
