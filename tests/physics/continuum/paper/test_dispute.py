"""Thresholds from a sweep: where contacts become sticky as one theory says, that theory is found right."""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import cache
from io import StringIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pandas import DataFrame, concat, read_csv

from continuum.maps.verdict.criteria import RoughContact
from continuum.model.grid import Grid
from continuum.model.surface import moments
from continuum.model.surfaces import SelfAffineSurface
from continuum.paper.dispute import (
    THEORIES,
    Theory,
    conformal_energies,
    crossovers,
    dispute_sheets,
    draw_crossover_table,
    draw_crossovers,
    exponent,
    many_contacts,
    write_dispute,
)
from continuum.paper.points import FigureError
from continuum.store.sweeps.axes import Axis, System
from continuum.store.sweeps.collect import PointTable
from continuum.store.sweeps.listing import SweepListing
from continuum.store.sweeps.measured import COLUMNS
from continuum.theory import rough
from docs.studies.record import added
from tests.kinds import covering
from tests.printed import faults_in_print

N, HEIGHT, REACH = 64, 0.1, 0.02
CUTS, SEEDS = (4.0, 8.0, 16.0), (1, 2)
WORKS = tuple(1e-5 * 4.0**i for i in range(7))
KEYS = ("surface.lambda_s", "surface.seed", "wall.adhesion_length")


@cache
def bare(lambda_s: float, seed: int) -> RoughContact:
    """Of a work of adhesion of one."""
    grid = Grid.square(N)
    surface = SelfAffineSurface(
        kind="self-affine", hurst=0.8, rms_height=HEIGHT, lambda_s=lambda_s, lambda_L=32.0, seed=seed
    )
    heights = surface.build(grid)
    power = np.abs(grid.forward(heights)) ** 2 * grid.mode_weights
    energy = rough.conformal_energy(grid.wavenumber, power)
    return RoughContact(*moments(grid, heights), 1.0, REACH, conformal_energy=energy, roll_off=32.0)


def contact(lambda_s: float, seed: int, work: float) -> RoughContact:
    return replace(bare(lambda_s, seed), work_of_adhesion=work)


@cache
def sweep(theory: Theory, *, back: bool) -> PointTable:
    """Attraction over repulsion, or pull-off over peak load, is w over the w of one theory to the power 0.8."""
    places = list(itertools.product(CUTS, SEEDS, WORKS))
    rows: list[dict[str, float]] = []
    for lambda_s, seed, work in places:
        made = contact(lambda_s, seed, work)
        ratio = (theory.criterion(made).margin or np.nan) ** 0.8
        known = {
            "rms_height": made.rms_height, "rms_slope": made.rms_slope, "rms_curvature": made.rms_curvature,
            "work_of_adhesion": work, "effective_range": REACH, "diameter": made.diameter, "converged": 1,
        }  # fmt: skip
        # A cycle from rest to a load of 1, back to a tension of that ratio, and to rest.
        path = [(0.0, 1.0, 0), (1.0, 0.5, 0), (-ratio, 0.8, 1), (0.0, 1.0, 1)] if back else [(1 - ratio, 1.0, 0)]
        for step, (load, gap, retracting) in enumerate(path):
            rows.append({**known, "step": step, "load": load, "load_rep": 1.0, "load_att": ratio, "mean_gap": gap,
                         "separation": np.nan, "retracting": retracting})  # fmt: skip
    systems = tuple(System(f"{i:024d}", dict(zip(KEYS, p, strict=True)), 1.0, 1.0) for i, p in enumerate(places))
    axes = tuple(Axis((key,), tuple((v,) for v in a)) for key, a in zip(KEYS, (CUTS, SEEDS, WORKS), strict=True))
    common = {
        "surface.kind": "self-affine",
        "surface.hurst": 0.8,
        "surface.rms_height": HEIGHT,
        "surface.lambda_L": 32.0,
        "grid.n": [N, N],
        "grid.period": [float(N), float(N)],
    }
    values = np.array([[row.get(name, np.nan) for name in COLUMNS] for row in rows])
    index = np.repeat(np.arange(len(places)), 4 if back else 1)
    return PointTable(
        SweepListing("made", axes, common, systems), tuple(s.key for s in systems), index, values,
        np.ones(len(places)), 0, 0, (), {"version 0": len(places)},
    )  # fmt: skip


@pytest.mark.parametrize(("back", "theory"), covering([False, True], THEORIES))
def test_the_theory_that_contacts_follow_is_found(theory: Theory, back: bool) -> None:
    table = sweep(theory, back=back)
    thresholds = crossovers(table)
    assert len(thresholds) == len(CUTS) * len(SEEDS)
    # The ratio is a power of w: linear in logarithms, so that nothing is lost between two works.
    assert theory.margins(thresholds).to_numpy() == pytest.approx(1, rel=1e-9)
    exponents, works = dispute_sheets(thresholds)
    column = [c.name for c in works.columns].index(theory.name)
    assert all(row[column] == "1 (x1.00)" for row in works.rows)
    names = [c.name for c in exponents.columns]
    measured, said = names.index("measured, 95 %"), names.index(f"{theory.name} (limit)")
    for row in exponents.rows:
        assert str(row[measured]).strip("*").split()[0] == str(row[said]).split()[0]


def test_a_threshold_outside_of_the_works_is_not_guessed() -> None:
    theory = THEORIES[0]
    table = sweep(theory, back=False)
    column = list(COLUMNS).index("load_att")
    for factor in (1e-9, 1e9):
        values = table.values.copy()
        values[:, column] *= factor
        assert crossovers(replace(table, values=values)).empty
    with pytest.raises(FigureError, match="too few systems"):
        dispute_sheets(DataFrame())


def test_a_cycle_that_misses_a_point_says_nothing() -> None:
    table = sweep(THEORIES[0], back=True)
    kept = np.ones(len(table.values), dtype=bool)
    kept[1::4] = False
    assert crossovers(replace(table, values=table.values[kept], system=table.system[kept])).empty


def test_the_energy_of_full_contact_is_that_of_the_surface() -> None:
    table = sweep(THEORIES[0], back=False)
    energies = conformal_energies(table)
    for key in table.keys[:: len(WORKS)]:
        place = float(table.setting(key, KEYS[0])), int(table.setting(key, KEYS[1]))
        assert energies[key] == contact(*place, 1.0).conformal_energy


@given(st.floats(-3, 3), st.floats(1e-6, 1e6))
def test_an_exponent_is_found_whatever_the_units(power: float, unit: float) -> None:
    cuts = np.array(CUTS)
    assert exponent(cuts, unit * cuts**power) == pytest.approx(power, abs=1e-9)
    assert np.isnan(exponent(cuts[:2], cuts[:2]))


def test_page_and_figures_are_written(tmp_path) -> None:
    load = sweep(THEORIES[0], back=False)
    written = write_dispute(
        [("load", load), ("pulled", sweep(THEORIES[1], back=True)), ("short", load)], tmp_path / "dispute.md"
    )
    text = (tmp_path / "dispute.md").read_text()
    assert "Hysteresis at the threshold" in text
    assert text.index("![") < text.index("## Tables") < text.index("\n|")
    assert "d_rep over 4h'/h''" in text
    names = {"dispute.md", "dispute-load.png", "dispute-pull-off.csv", "dispute-pull-off.png", "dispute-load-short.png"}
    assert {path.name for path in written} >= names
    drawing = draw_crossovers(crossovers(sweep(THEORIES[0], back=False)), "title")
    assert len(drawing.sheet.rows) == len(CUTS)
    assert faults_in_print(drawing.figure) == []
    # A stored table has all that the figure shows.
    again = draw_crossover_table(read_csv(StringIO(drawing.sheet.csv())))
    (axis,), (before,) = again.axes, drawing.figure.axes
    assert [tick.get_text() for tick in axis.get_xticklabels()] == [f"{cut:g}" for cut in CUTS]
    for line, same in zip(axis.lines, before.lines, strict=True):
        assert np.array_equal(line.get_xydata(), same.get_xydata())


def test_exponents_are_told_again_without_the_waves_of_which_few_touch() -> None:
    """Where 1 % of the map is less than 10 λ_s², single summits decide: λ_s = 16 is the longest on 506² points."""
    table = sweep(THEORIES[0], back=False)
    small = crossovers(table)
    thresholds = small.assign(squares=small.squares * (506 / N) ** 2)
    long = thresholds.assign(lambda_s=32.0, squares=thresholds.squares * (thresholds.lambda_s / 32) ** 2)
    assert min(thresholds.squares) == pytest.approx(10, rel=1e-3)
    assert many_contacts(thresholds) == []
    (again,) = many_contacts(concat([thresholds, long]))
    assert again.rows == dispute_sheets(thresholds)[0].rows


def test_a_surface_is_in_the_record_once_for_each_law_and_range() -> None:
    table = sweep(THEORIES[0], back=False)
    laws = [
        replace(table, listing=replace(table.listing, common={**table.listing.common, "wall.shape": shape}))
        for shape in ("spline", "exponential")
    ]
    once = added([], laws)
    assert len(once) == 2 * len(CUTS) * len(SEEDS)
    assert {row["law"] for row in once} == {"spline", "exponential"}
    assert added(once, laws) == once
