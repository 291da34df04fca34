"""All that can be measured on the stored points of a run, and the paper's predictions beside it."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from continuum.files import store
from continuum.measure.contact import Contact
from continuum.measure.curve import Adhesion, Curve, adhesion, normal_stiffness
from continuum.measure.kappa import Measurement, characterise
from continuum.measure.outline import Areas, Mask, areas, patches
from continuum.measure.profile import Distribution, GapProfile, gap_distribution, gap_profile, pressure_distribution
from continuum.model.grid import Grid, Real
from continuum.model.walls import HardWall, Wall
from continuum.runs.build import wall_of
from continuum.runs.config import RunConfig
from continuum.theory import paper as theory

__all__ = ["Analysis", "Fields", "Point", "Prediction", "analyse", "gap_ratio", "summary", "tables"]


@dataclass(frozen=True, eq=False)
class Fields:
    """What only the gap at each point tells."""

    areas: Areas
    profile: GapProfile
    """Above zero_gap, up to twice the mean diameter."""
    width: float
    """d_att, in a0: where the mean gap above zero_gap reaches the range; not a number without attraction."""
    predicted_width: float
    """d_att of Eq. (datt) with the measured d_rep, in a0."""
    gap_ratio: tuple[float, float]
    """Smallest and largest ratio of the mean gap to Eq. (gap), see :func:`gap_ratio`."""
    gaps: Distribution
    pressures: Distribution | None
    """None under a hard or a tabulated wall: the traction is not stored."""


@dataclass(frozen=True, eq=False)
class Point:
    """One stored equilibrium."""

    step: int
    branch: str
    mean_gap: float
    """In a0."""
    numbers: Measurement
    patch_areas: Real
    """Area of each connected patch of A_rep, in a0²."""
    stiffness: float
    """k_N = -dN/d(mean gap), in E*/a0."""
    packed: NDArray[np.uint8]
    """Map of A_rep, for :func:`continuum.files.store.unpack`: many points of a large grid stay small."""
    fields: Fields | None
    """None where the run did not store gaps."""


@dataclass(frozen=True)
class Prediction:
    """The paper's relations for the undeformed surface and the wall of a run."""

    rms_slope: float
    rms_curvature: float
    """In 1/a0."""
    range: float
    """Δr, in a0."""
    diameter: float
    """d_rep = 4h'/h'', in a0."""
    width: float
    """d_att, Eq. (datt), in a0."""
    area_ratio: float
    """A_rep/A_att, Eq. (attrep); infinite without attraction."""
    pressure_att: float
    """w/Δr, in E*."""


@dataclass(frozen=True, eq=False)
class Analysis:
    """A run, measured."""

    path: Path
    grid: Grid
    prediction: Prediction
    points: tuple[Point, ...]
    """The equilibria, in the order of the path."""
    adhesion: Adhesion | None
    """None without equilibria."""
    notes: tuple[str, ...]
    """What is missing, and what to do about it."""


def analyse(path: Path) -> Analysis:
    """Measure every equilibrium of a stored run.

    Raises
    ------
    continuum.files.store.StoreError
        If the file is no run.
    """
    contact = [field.name for field in dataclasses.fields(Contact)]
    names = {"status", "branch", "mean_gap", "separation", "repulsive", *contact}
    file = store.read(path, RunConfig.result_schema, RunConfig.result_version, names)
    grid, wall = _restored(file)
    notes = []
    if isinstance(wall, (_Bounds, HardWall)):
        notes.append("no distribution of pressures: under a tabulated or a hard wall they do not follow from the file")
    good = np.flatnonzero(file["status"] == "CONVERGED")
    if good.size < file["status"].size:
        notes.append(f"{file['status'].size - good.size} points that did not converge are left out")
    if not file.attributes.get("finished"):
        notes.append("the run is not finished: `continuum run` with its input goes on with it")
    has_fields = store.read_part(path, "gap", 0) is not None
    if not has_fields:
        notes.append(
            "areas under other definitions, gap profile, d_att and distributions need the gap at each point, which "
            "this run did not store: set fields = true in [output] of its input and run it again into the same folder"
        )
    curve = Curve(
        file["mean_gap"][good], file["separation"][good], file["load"][good], file["branch"][good] == "retract"
    )
    prediction = _prediction(file, wall)
    points = []
    for step, stiffness in zip(good.tolist(), normal_stiffness(curve), strict=True):
        repulsive = store.unpack(file["repulsive"][step], grid.shape[1])
        loads = Contact(**{name: float(file[name][step]) for name in contact})
        numbers = characterise(grid, loads, repulsive, prediction.rms_slope)
        stored_gap = store.read_part(path, "gap", step)
        found = None
        if stored_gap is not None:
            full = stored_gap.astype(np.float64)
            found = _fields(grid, wall, full, repulsive, numbers, prediction.rms_slope)
        sizes = patches(grid, repulsive).areas
        branch, gap = str(file["branch"][step]), float(file["mean_gap"][step])
        points.append(Point(step, branch, gap, numbers, sizes, float(stiffness), file["repulsive"][step], found))
    return Analysis(path, grid, prediction, tuple(points), adhesion(curve) if good.size else None, tuple(notes))


@dataclass(frozen=True)
class _Bounds(Wall):
    """What is left of a tabulated wall, whose table is not stored: where it repels and where it attracts."""

    zero_gap: float
    range: float


def _restored(file: store.File) -> tuple[Grid, Wall]:
    """Grid and wall of a run, from its resolved configuration."""
    tables = json.loads(str(file.attributes["config_resolved"]))
    grid = Grid(tuple(tables["grid"]["n"]), tuple(tables["grid"]["period"]))
    if tables["wall"]["law"] == "table":
        return grid, _Bounds(float(file.attributes["wall_zero_gap"]), float(file.attributes["wall_range"]))
    tables["surface"] = {"kind": "sphere", "radius": 1.0}  # not needed here, and it may be a file that is gone
    return grid, wall_of(RunConfig.model_validate_json(json.dumps(tables)))


def _prediction(file: store.File, wall: Wall) -> Prediction:
    slope = float(file.attributes["realised_rms_slope"])
    curvature = float(file.attributes["realised_rms_curvature"])
    diameter = theory.contact_diameter(slope, curvature)
    if wall.range == 0:
        return Prediction(slope, curvature, 0.0, diameter, 0.0, np.inf, np.nan)
    return Prediction(
        slope,
        curvature,
        wall.range,
        diameter,
        theory.attraction_width(slope, diameter, wall.range),
        theory.area_ratio(slope, diameter, wall.range),
        theory.adhesive_pressure(float(file.attributes["work_of_adhesion"]), wall.range),
    )


def _fields(grid: Grid, wall: Wall, gap: Real, repulsive: Mask, numbers: Measurement, slope: float) -> Fields:
    # Twice the diameter shows the gap between patches; the map is held with a margin that wide, hence the limit.
    reach = 2 * numbers.diameter if np.isfinite(numbers.diameter) else 0.0
    farthest = min(max(reach, 16 * max(grid.spacing)), min(grid.lengths) / 8)
    profile = gap_profile(grid, gap, repulsive, farthest, wall.zero_gap)
    return Fields(
        areas(grid, wall, gap),
        profile,
        profile.width(wall.range) if wall.range > 0 else np.nan,
        theory.attraction_width(slope, numbers.diameter, wall.range) if wall.range > 0 else np.nan,
        gap_ratio(profile, slope, numbers.diameter),
        gap_distribution(grid, gap),
        None if isinstance(wall, (_Bounds, HardWall)) else pressure_distribution(grid, wall, gap),
    )


def gap_ratio(
    profile: GapProfile, rms_slope: float, diameter: float, *, from_perimeter_cells: bool = False
) -> tuple[float, float]:
    """Smallest and largest ratio of a mean gap to Eq. (gap) with the measured d_rep, for 2 a0 <= x <= d_rep/4.

    Parameters
    ----------
    profile : its gap above zero_gap.
    rms_slope, diameter : h'rms and the measured d_rep.
    from_perimeter_cells : count x from the centres of the perimeter cells instead of the edge.

    Returns
    -------
    lowest, highest : not numbers where no distance lies between those.
    """
    x = profile.from_perimeter_cells if from_perimeter_cells else profile.distance
    near = (x >= 2) & (x <= diameter / 4)
    if not near.any():
        return np.nan, np.nan
    ratio = profile.gap[near] / theory.gap_profile(x[near], rms_slope, diameter)
    return float(ratio.min()), float(ratio.max())


def tables(analysis: Analysis) -> list[tuple[str, list[str], list[list[str]]]]:
    """The tables of a run: title, names of the columns, one row for each point."""
    loads, geometry, fields = [], [], []
    for point in analysis.points:
        n, found, size = point.numbers, point.fields, point.patch_areas
        head = [str(point.step), point.branch, f"{point.mean_gap:.4g}"]
        inverse = 1 / n.kappa if n.kappa else np.nan
        pressures = [f"{value:.3e}" for value in (n.load, n.pressure_rep, n.pressure_att)]
        kappas = _cells(inverse, n.kappa_rep, n.kappa_att)
        loads.append([*head, *_cells(n.area_rep, n.area_att), *pressures, *kappas, f"{point.stiffness:.3e}"])
        lengths = _cells(n.perimeter, n.diameter, n.diameter_exact, n.chord, n.chord_x, n.chord_y)
        patch = [str(size.size), *_cells(size.max(initial=0.0))]
        geometry.append([*head, str(n.perimeter_cells), *lengths, *patch])
        if found is not None:
            rim = n.area_att * analysis.grid.area / n.perimeter if n.perimeter else np.nan
            low, high = found.gap_ratio
            a = found.areas
            shares = _cells(a.repulsive, a.uncertainty, a.corrected, a.contour, a.interior, a.dilated)
            fields.append([*head, *_cells(found.width, rim, found.predicted_width, low, high), *shares])
    point_head = ["step", "branch", "mean gap"]
    found_tables = [
        (
            "loads: pressures in E*, areas as fractions of A0",
            [*point_head, "A_rep", "A_att", "N", "p_rep", "p_att", "1/κ", "κ_rep", "κ_att", "k_N"],
            loads,
        ),
        (
            "repulsive contact: lengths in a0; P and d_rep with the paper's 1.1222, d_rep also with 1.1107",
            [*point_head, "N_P", "P", "d_rep", "1.1107", "chord", "along x", "along y", "patches", "largest"],
            geometry,
        ),
    ]
    if fields:
        names = ["d_att", "A_att/P", "Eq. (datt)", "gap/Eq. (gap)", "to", "A_rep", "±", "corrected", "contour",
                 "interior", "dilated"]  # fmt: skip
        title = "gap outside, in a0; areas by other definitions, as fractions of A0"
        found_tables.append((title, [*point_head, *names], fields))
    return found_tables


def _cells(*values: float) -> list[str]:
    return [f"{value:.4g}" for value in values]


def summary(analysis: Analysis) -> list[list[str]]:
    """What holds for the run as a whole: quantity, value, unit."""
    theory, found = analysis.prediction, analysis.adhesion
    rows = [
        ["rms slope h'rms", f"{theory.rms_slope:.4g}", ""],
        ["rms curvature h''rms", f"{theory.rms_curvature:.4g}", "1/a0"],
        ["d_rep, theory 4h'/h''", f"{theory.diameter:.4g}", "a0"],
        ["d_att, theory Eq. (datt)", f"{theory.width:.4g}", "a0"],
        ["A_rep/A_att, theory Eq. (attrep)", f"{theory.area_ratio:.4g}", ""],
        ["p_att, theory w/Δr", f"{theory.pressure_att:.4g}", "E*"],
    ]
    if found is not None:
        ends = "" if found.separated or np.isnan(found.pull_off) else " (path ends under tension: too small)"
        rows += [
            ["peak load N/A0", f"{found.peak_load:.4g}", "E*"],
            ["largest tension on approach", f"{found.largest_tension:.4g}", "E*"],
            ["pull-off tension on retraction", f"{found.pull_off:.4g}", "E*"],
            ["work of separation per A0", f"{found.work_of_separation:.4g}{ends}", "E* a0"],
            ["work lost in the cycle per A0", f"{found.loss:.4g}", "E* a0"],
        ]
    return rows
