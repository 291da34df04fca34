"""Analytic contacts: spheres from DMT to JKR, waves with and without adhesion, orders of convergence.

What is compared and why not closer stands in :mod:`tests.verification.checks`; the page of the study is made from it.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import erfc, zeta

from continuum.model.substrates import HalfSpace
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from docs.studies import verification as report
from tests.classical import AdhesiveWave
from tests.verification import checks
from tests.verification.adhesive import IMAGES_CURVATURE, IMAGES_SHIFT, PAPER_LAW, dugdale_law, wave_problem
from tests.verification.checks import COMPARISONS, Check, Comparison


@pytest.mark.parametrize(
    "comparison",
    [
        pytest.param(c, id=c.name, marks=[pytest.mark.long] if c.long or c.make is checks.orders else [])
        for c in COMPARISONS
    ],
)
def test_analytic_contact(comparison: Comparison) -> None:
    found = comparison.make()
    assert found
    assert [check for check in found if not check.good] == []


def test_pressures_of_a_wave_converge_to_third_order() -> None:
    """That of all grids, and of spheres, stands among the comparisons; from three grids it scatters as widely."""
    found, sizes, errors = checks.order("wave", checks.WAVE_GRIDS[:4])
    assert sizes == (128, 256, 512)
    assert found == pytest.approx(3.0, abs=0.3)
    assert errors.max() < 2e-3


def test_pull_off_falls_from_dmt_to_jkr() -> None:
    found = [checks.retraction(tabor, n) for tabor, n in checks.PULL_OFFS]
    forces = [one.tension / one.unit for one in found]
    assert (np.diff(forces) < 0).all()
    assert 1.5 < min(forces) < max(forces) < 2


@pytest.mark.parametrize("alpha", [0.3, 0.56, 0.6])
def test_a_wave_jumps_to_full_contact_without_load_above_johnsons_alpha(alpha: float) -> None:
    # Zero load: the mean is free.  From first touch the contact grows to Johnson's, or through, above α = 0.570.
    wave, problem = wave_problem(alpha, 512.0, 256, PAPER_LAW)
    problem = replace(problem, substrate=HalfSpace("free"))
    state = solve(problem, "separation", 0.0, Settings(1e-8), start=problem.heights + 1.0)
    assert state.status.ok
    assert abs(state.load) < 1e-6 * wave.full_pressure
    row = state.gap[:, 0]
    if alpha > 0.57:
        assert (row < 1 + PAPER_LAW.range).all()
    else:
        # Johnson's edge at no load lies in the zone where the law pulls, known to half a cell.
        half = problem.grid.spacing[0] / 2
        repulsive, attracted = (np.count_nonzero(row < end) * half for end in (1.0, 1.0 + PAPER_LAW.range))
        assert repulsive < _width_without_load(wave) < attracted + half


def _width_without_load(wave: AdhesiveWave) -> float:
    """Half-width of no mean pressure on the stable branch, by a scan."""
    widths = np.linspace(wave.pull_off_width, wave.snap_in_width, 20001)
    return float(widths[np.argmin(np.abs([wave.mean_pressure(a) for a in widths]))])


def test_the_law_of_maugis_is_what_it_says() -> None:
    law = dugdale_law(0.1, 1.0, 20.0, 0.1)
    # Knots lie 0.00125 apart.
    assert law.zero_gap == pytest.approx(0, abs=2e-3)
    assert law.work_of_adhesion == pytest.approx(0.1, rel=1e-3)
    # Steps over 0.05 and 0.1 of the distance, the first from contact, the second about h0: w/(0.975 h0).
    assert law.largest_tension == pytest.approx(0.1 / 0.975, rel=1e-3)
    middle = -law.evaluate(np.linspace(0.06, 0.94, 50)).traction
    np.testing.assert_allclose(middle, 0.1 / 0.975, rtol=1e-3)


def test_lattice_sums_of_the_images() -> None:
    m, n = np.meshgrid(np.arange(-6, 7), np.arange(-6, 7))
    r = np.hypot(m, n)[(m != 0) | (n != 0)]
    # Ewald's sums with the splitting that treats both lattices alike; what is left out is exp(-36 π).
    assert pytest.approx(4 - 2 * np.sum(erfc(np.sqrt(np.pi) * r) / r), abs=1e-7) == IMAGES_SHIFT
    beta = (zeta(1.5, 0.25) - zeta(1.5, 0.75)) / 8
    assert pytest.approx(4 * zeta(1.5) * beta, abs=1e-7) == IMAGES_CURVATURE


def test_what_is_no_number_or_too_far_off_is_reported(tmp_path: Path) -> None:
    assert not Check("", np.nan, 1.0, np.nan, 1.0).good
    assert not checks.relative("", 1.2, 1.0, 0.1).good
    assert checks.relative("", 1.2, 1.0, 0.3).good
    page = tmp_path / "page.md"
    page.write_text(f"before\n{report.BEGIN}\nold\n{report.END}\nafter\n")
    bad = Comparison("one", lambda: [Check("x", 1.0, 2.0, -0.5, 0.1)], "because")
    assert not report.write([bad], page)
    text = page.read_text()
    assert "old" not in text
    assert "| x | 1 | 2 | -0.5 | 0.1 | **no** |" in text
    assert text.startswith("before")
    assert text.endswith("after\n")
