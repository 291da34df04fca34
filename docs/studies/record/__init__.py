"""The measured record of the criteria of stickiness, ``docs/studies/record/record.csv``, from the files of sweeps.

Run as ``python -m docs.studies.record FOLDER ...``: sweeps over the work of adhesion at a given range
(``inputs/sweep/who-is-right.toml``) give surfaces with the work at which they become sticky; those of the paper's law
(``figure4.toml``) give states, sticky or not.  Rows of the record that no sweep has anew stay.  Without a folder: the
tables of docs/studies/predict-record.md, of the record as it is.  With ``--law`` the thresholds that judged docs/law.md
are added, those at other periods included.
"""

from __future__ import annotations

import argparse
import csv
import io
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from pathlib import Path

import numpy as np
from pandas import DataFrame, concat, read_csv
from scipy.stats import mannwhitneyu

from continuum.maps.verdict.criteria import AREA, CRITERIA, RoughContact
from continuum.paper.dispute import conformal_energies, crossovers
from continuum.paper.points import sweep_points
from continuum.store import output
from continuum.store.sheet import Column, Sheet
from continuum.store.sweeps.collect import PointTable, collect
from docs.studies.record.judged import NECESSARY, judge_contact
from docs.studies.record.votes import Surface, recorded

HERE = Path(__file__).parent
MEASURED = Path(__file__).parents[3] / "docs" / "measured"
LAW = MEASURED / "law.csv.gz", MEASURED / "law-period.csv"
COLUMNS = (
    "source", "law", "hurst", "lambda_s", "lambda_L", "seed", "rms_height", "rms_slope", "rms_curvature",
    "conformal_energy", "range", "work", "sticky",
)  # fmt: skip
SURFACE = ("hurst", "lambda_s", "lambda_L", "seed")
MOMENTS = ("rms_height", "rms_slope", "rms_curvature")


def thresholds(table: PointTable) -> Iterator[dict[str, object]]:
    """Surfaces with the work of adhesion at which attraction and repulsion cancel at 1 % area."""
    for threshold in crossovers(table).itertuples():
        surface = {name: getattr(threshold, name) for name in SURFACE}
        yield {
            **surface,
            **_contact(threshold.contact),
            "source": "threshold",
            "law": threshold.law,
            "sticky": "threshold",
        }


def judged(rows: DataFrame) -> Iterator[dict[str, object]]:
    """The thresholds that judged the law of stickiness at 1 % of the area: surfaces that made no theory here."""
    for row in rows[rows.area == AREA].itertuples():
        found = {name: getattr(row, name) for name in SURFACE}
        yield {**found, "rms_height": row.height, "rms_slope": row.slope, "rms_curvature": row.curvature,
               "conformal_energy": row.moment_1 / 4, "range": row.range, "work": row.work, "source": "law",
               "law": row.shape, "sticky": "threshold"}  # fmt: skip


def states(table: PointTable) -> Iterator[dict[str, object]]:
    """Surfaces of the paper's law with the sign of their load where κ is read: with A_rep >= 10 λ_s²."""
    energies = conformal_energies(table)
    for point in sweep_points(table).query("reference and length > 0").itertuples():
        contact = RoughContact(
            *(getattr(point, name) for name in MOMENTS), point.length, point.effective_range,
            conformal_energy=energies[table.keys[point.system]],
        )  # fmt: skip
        surface = {name: getattr(point, name) for name in SURFACE}
        sticky = "yes" if point.load < 0 else "no"
        yield {**surface, **_contact(contact), "source": "state", "law": "spline", "sticky": sticky}


def _contact(contact: RoughContact) -> dict[str, object]:
    moments = {name: getattr(contact, name) for name in (*MOMENTS, "conformal_energy", "range")}
    return {**moments, "work": contact.work_of_adhesion}


def _key(row: dict[str, str]) -> tuple[str, ...]:
    """The surface and its law; of a state, the work of adhesion, too.  Moments were stored with six digits."""
    numbers = [f"{float(row[name]):.4g}" for name in (*SURFACE, "rms_height", "rms_slope", "range")]
    return (row["source"], row["law"], *numbers, f"{float(row['work']):.4g}" if row["source"] == "state" else "")


def added(rows: Iterable[dict[str, str]], tables: Iterable[PointTable]) -> list[dict[str, str]]:
    """Rows of a record, and those of sweeps: a surface under one law at one range has its threshold once."""
    known = {_key(row): row for row in rows}
    for table in tables:
        held = table.setting(table.keys[0], "surface.rms_height")  # NaN where slopes are held instead
        for found in thresholds(table) if held == held else states(table):
            row = _row(found)
            known[_key(row)] = row
    return list(known.values())


def _row(found: Mapping[str, object]) -> dict[str, str]:
    return {name: f"{v:.6g}" if isinstance(v := found[name], float) else str(v) for name in COLUMNS}


def record_sheet() -> Sheet:
    """Each criterion on the record: margins at the thresholds in its range, and how often it is right on the states."""
    thresholds, others = _kinds()
    rows = []
    for criterion in (one for one in CRITERIA.values() if one.margin and one.key != NECESSARY):
        found = [criterion(surface.contact) for surface in thresholds]
        valid = np.array([estimate.valid for estimate in found])
        margins = np.array([estimate.margin for estimate in found], dtype=float)
        said = [criterion(surface.contact) for surface in others]
        right = np.array([estimate.sticky == surface.sticky for estimate, surface in zip(said, others, strict=True)])
        heard = np.array([estimate.valid for estimate in said])
        middle = ", ".join(f"{m:.2f}" for m in np.percentile(margins[valid], [10, 50, 90])) if valid.any() else "none"
        scatter = float(np.exp(np.log(margins[valid] if valid.any() else margins).std()))
        rows.append((criterion.name, f"{middle} ({valid.sum()} in range)", f"{scatter:.2f}",
                     f"{right.sum()} of {right.size}", f"{(right & heard).sum()} of {heard.sum()}"))  # fmt: skip
    heads = ("criterion", "margin at the threshold: 10, 50, 90 %", "scatter", "right on the states", "in its range")
    return Sheet.of(f"{len(thresholds)} thresholds, {len(others)} states", heads, rows)


def discrimination_sheet() -> Sheet:
    """Each criterion on the states as a test: what it finds of the sticky ones, and how well its margin orders them.

    Right on so many says little of states of which three quarters are not sticky: *always no* is right on these.  The
    area under the ROC curve is the probability that of a sticky state and one that is not the sticky one has the larger
    margin: 1/2 says nothing.  *Near the threshold*: w within a factor of three of half the energy of full contact.
    """
    _, others = _kinds()
    sticky = np.array([bool(surface.sticky) for surface in others])
    half = CRITERIA["half-conformal-energy"]
    near = np.abs([np.log(half(surface.contact).margin or np.nan) for surface in others]) < np.log(3)
    rows = []
    for criterion in (one for one in CRITERIA.values() if one.margin and one.key != NECESSARY):
        found = [criterion(surface.contact) for surface in others]
        margins = np.array([estimate.margin for estimate in found], dtype=float)
        heard, says = np.array([estimate.valid for estimate in found]), margins > 1
        counts = [
            f"{int((says == truth)[chosen & (sticky == truth)].sum())} of {int((chosen & (sticky == truth)).sum())}"
            for chosen in (np.ones_like(heard), heard) for truth in (True, False)
        ]  # fmt: skip
        rows.append((criterion.name, *counts, _area_under_roc(margins, sticky),
                     _area_under_roc(margins[near], sticky[near])))  # fmt: skip
    heads = ("criterion", "sticky found", "not sticky found", "sticky found, in its range",
             "not sticky found, in its range", Column("area under ROC", "", ".4f"),
             Column(f"of the {near.sum()} near the threshold", "", ".3f"))  # fmt: skip
    return Sheet.of("sensitivity and specificity", heads, rows)


def _area_under_roc(margins: np.ndarray, sticky: np.ndarray) -> float:
    pairs = float(sticky.sum() * (~sticky).sum())
    return float(mannwhitneyu(margins[sticky], margins[~sticky]).statistic) / pairs


def vote_sheet() -> Sheet:
    """What the vote says of surfaces that the record has not seen, beside what they do."""
    thresholds, others = _kinds()
    said: dict[str, Counter[str]] = {}
    for surface in others:
        answer = judge_contact(surface.contact, lambda other: other.sticky is not None).answer
        truth = "sticky" if surface.sticky else "not sticky"
        said.setdefault("states, by the thresholds", Counter())[_outcome(answer, truth)] += 1
    for factor, truth in (
        (0.2, "not sticky"),
        (1 / 3, "not sticky"),
        (0.5, "not sticky"),
        (2.0, "sticky"),
        (3.0, "sticky"),
        (5.0, "sticky"),
    ):
        for surface in thresholds:
            contact = replace(surface.contact, work_of_adhesion=factor * surface.contact.work_of_adhesion)
            answer = judge_contact(contact, partial(_same, surface)).answer
            said.setdefault(f"{factor:.2g} times the work of the threshold", Counter())[_outcome(answer, truth)] += 1
    rows = [(name, found["right"], found["undecided"], found["wrong"]) for name, found in said.items()]
    return Sheet.of("the vote", ("surfaces", "right", "undecided", "wrong"), rows)


def calibration_sheet() -> Sheet:
    """What the printed probability is worth: works around each threshold, all of its seed left out of the record."""
    rng, said = np.random.default_rng(1), []
    for surface in _kinds()[0]:
        for factor in np.exp(rng.uniform(np.log(0.1), np.log(10), 6)):
            contact = replace(surface.contact, work_of_adhesion=factor * surface.contact.work_of_adhesion)
            said.append((judge_contact(contact, partial(_same, surface)).probability, factor > 1))
    heard = np.array([(chance, sticky) for chance, sticky in said if chance is not None], dtype=float)
    edges, rows = (0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1), []
    for low, high in pairwise(edges):
        its = heard[(heard[:, 0] >= low) & (heard[:, 0] < high)]
        rows.append(
            (f"{100 * low:g} - {100 * high:g} %", *(f"{100 * mean:.0f} %" for mean in its.mean(axis=0)), len(its))
        )
    return Sheet.of("calibration", ("printed", "printed, mean", "sticky", "contacts"), rows)


def _kinds() -> tuple[list[Surface], list[Surface]]:
    """Surfaces with the work at which they become sticky, and surfaces with one work and what was found at it."""
    thresholds = [surface for surface in recorded() if surface.sticky is None]
    return thresholds, [surface for surface in recorded() if surface.sticky is not None]


def _same(one: Surface, other: Surface) -> bool:
    """Whether two surfaces have the same long waves: one seed draws those of every grid, H and λ_s."""
    seeds = _seeds()
    return seeds[one.contact.rms_curvature] == seeds[other.contact.rms_curvature]


@cache
def _seeds() -> dict[float, str]:
    rows = csv.DictReader((HERE / "record.csv").read_text().splitlines())
    return {float(row["rms_curvature"]): row["seed"] for row in rows}


def _outcome(answer: str, truth: str) -> str:
    return "undecided" if answer == "undecided" else "right" if answer == truth else "wrong"


def main() -> None:
    """Write the record, or show what it comes to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path, help="of sweeps")
    parser.add_argument("--record", type=Path, default=HERE / "record.csv")
    parser.add_argument(
        "--law", action="store_true", help="add the thresholds of docs/measured/law.csv.gz and law-period.csv"
    )
    given = parser.parse_args()
    if not (given.folders or given.law):
        sheets = record_sheet(), discrimination_sheet(), vote_sheet(), calibration_sheet()
        sys.stdout.write("\n\n".join(sheet.markdown() for sheet in sheets) + "\n")
        return
    rows = added(csv.DictReader(given.record.read_text().splitlines()), map(collect, given.folders))
    if given.law:
        rows = [row for row in rows if row["source"] != "law"] + [
            _row(found) for found in judged(concat(map(read_csv, LAW)))
        ]
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    output.save(given.record, out.getvalue(), own=True)
