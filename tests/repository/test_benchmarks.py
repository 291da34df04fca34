"""The arithmetic of the benchmarks; they themselves run by `make bench`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from continuum.path.loading import solve
from continuum.solve.solution import Settings
from docs.benchmarks import atoms, kinds, ours, paths, report, run
from docs.benchmarks.cases import rough as surface_of

POINT = {"n": 64, "seed": 1, "adhesion_length": 0.005}


def test_growth_is_the_exponent_of_a_power_law() -> None:
    sizes = [512, 1024, 4096]
    assert report.growth_exponent(sizes, [7 * n**0.3 for n in sizes]) == pytest.approx(0.3, abs=1e-12)
    assert np.isnan(report.growth_exponent([512], [30.0]))


def test_the_judge_finds_what_the_solver_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And what stands beside a peer's state, in place of which is ours."""
    monkeypatch.setattr(ours, "warm_up", lambda: None)  # grids of 256 and 512, for times
    file, problem = str(tmp_path / "gap.npy"), surface_of(**POINT).problem()
    np.save(file, solve(problem, "mean-gap", 2.0, Settings(1e-9)).gap)
    row = ours.beside(**POINT, file=file, turns=2)
    said, (peer, state) = row["ours"], row["states"]
    assert row["pixels_different"] == 0
    assert state["pixels_rep"] == peer["pixels_rep"] == round(said["area"] * 64**2) > 0
    assert state["mean_gap"] == pytest.approx(2.0, abs=1e-12)
    # Both are rms gradients of one state; rounding of the fields is 1e-16 of order one, times K of order one.
    assert state["rms_residual"] == pytest.approx(said["residual"], abs=1e-14)
    # A state that is none is told from one that is.
    rough = np.load(file) + 1e-3 * np.random.default_rng(1).standard_normal((64, 64))
    assert ours.judge(problem, rough)["rms_residual"] > 1e-4


def test_the_judge_of_the_hard_wall_accepts_full_contact(tmp_path: Path) -> None:
    """Pressed flat, u = h: the pressure is P - K h, the gap zero everywhere."""
    rough = surface_of(64, 1, lambda_s=16.0)
    pressure = 1.0 - rough.grid.inverse(rough.problem().elastic_traction_q(rough.grid.forward(rough.heights())))
    assert pressure.min() > 0
    file = tmp_path / "pressure.npy"
    np.save(file, pressure)
    state = ours.judge_hard(64, 1, 16.0, [str(file)])["states"][0]
    assert state["pixels"] == 64**2
    assert state["pressure"] == pytest.approx(1.0, rel=1e-14)
    # Rounding of heights of a few a0.
    assert state["max_error"] < 1e-13
    np.save(file, pressure + 0.01 * np.cos(np.arange(64)))
    assert ours.judge_hard(64, 1, 16.0, [str(file)])["states"][0]["max_error"] > 1e-3


def _page(folder: Path) -> Path:
    page = folder / "studies" / "benchmarks.md"
    page.parent.mkdir()
    page.write_text(f"before\n{report.BEGIN}\nold\n{report.END}\nafter\n")
    return page


@pytest.mark.long
def test_a_run_fills_the_page_and_the_next_measures_nothing_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Real solves of 64² in processes of their own; no peer is needed."""
    monkeypatch.setattr(run, "ADHESION_LENGTHS", (0.005,))
    monkeypatch.setattr(run, "REPEATS", 1)
    page, file = _page(tmp_path), tmp_path / "results.json"
    plan = ["--sizes", "64", "--tables", "iteration", "--atoms", "--results", str(file), "--docs", str(tmp_path)]
    run.main(plan)
    first = json.loads(file.read_text())
    run.main([*plan, "--minutes", "0"])
    assert "left out" not in page.read_text()
    again = json.loads(file.read_text())
    assert again["rows"] == first["rows"]
    assert again["seconds"] == first["seconds"]
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "old" not in text
    assert "| 64² | 0.005 |" in text
    assert (tmp_path / "benchmarks.png").is_file()


def test_what_is_missing_is_named_and_tried_again(tmp_path: Path) -> None:
    results = run.Results(tmp_path / "results.json", minutes=1.0)
    point = {"n": 512, "seed": 1, "peer": "Adhesion"}

    def absent() -> run.Row:
        raise run.Missing("Adhesion is not installed")

    results.measure("adhesive", point, absent)
    page = _page(tmp_path)
    report.write(results.content, tmp_path)
    assert "Adhesion: Adhesion is not installed" in page.read_text()
    # What would take longer than there is time is left out: a grid of twice the points takes longer than this one.
    assert results.measure("work", {"n": 512, "seed": 1}, lambda: {"cpu": 1.0})["cpu"] == 1.0
    results.content["rows"]["work"][0]["seconds"] = 3600.0
    assert "left out" in results.measure("work", {"n": 1024, "seed": 1}, lambda: {"cpu": 1.0})["skipped"]
    assert results.measure("adhesive", point, lambda: {"cpu": 2.0})["cpu"] == 2.0
    assert len(results.content["rows"]["adhesive"]) == 1


def test_a_job_that_fails_says_why(tmp_path: Path) -> None:
    results = run.Results(tmp_path / "results.json", minutes=1.0)
    with pytest.raises(run.Missing, match=r"lambda_s = 32.0: allowed"):
        results.job("kinds.contact", n=1, seed=1, kind="hard wall, pressure 4e-4 E*")  # one that warms nothing up


def test_contacts_of_other_kinds_are_pressed_as_they_say() -> None:
    rows = [{"n": 64, "kind": kind, "seed": 1} | kinds.contact(64, 1, kind) for kind in kinds.KINDS]
    assert all(row["status"] == "CONVERGED" for row in rows)
    areas = {row["kind"]: row["area"] for row in rows}
    assert areas["hard wall, 90 % of the area"] == pytest.approx(0.9, abs=0.01 * 0.1 + 0.5 / 64**2)
    assert areas["hardness 0.1 E*, half of it"] > 0.5  # no point carries more than the hardness
    assert report.kinds(rows).count("| converged |") == len(kinds.KINDS)


def test_both_ways_to_the_equilibrium_of_atoms_end_at_one() -> None:
    row = {"n": 16, "crystal": "springs", "adhesion_length": 0.005, "peak_mib": 1.0}
    row |= atoms.equilibrium(16, "springs", 0.005, alone=True)
    # To 1e-9 h'rms E* a0² of force on 16² atoms a layer.
    assert row["ours"]["load"] == pytest.approx(row["lammps"]["load"], abs=1e-6)
    assert row["lammps"]["evaluations"] > 5 * row["ours"]["evaluations"]
    assert f"| **{row['ours']['evaluations']}** |" in report.atoms([row])


@pytest.mark.long
def test_the_memory_of_a_job_is_its_own(tmp_path: Path) -> None:
    """Not that of the process that starts it, which is larger here."""
    ballast = np.ones(2**26)
    results = run.Results(tmp_path / "results.json", minutes=1.0)
    found = results.job("ours.mean_gap_at", **POINT, mean_gap=2.0)
    assert ballast.nbytes / 2**20 > found["peak_mib"] > 1


@pytest.mark.long
def test_what_a_wall_costs_is_measured_for_each_kind() -> None:
    rows = [{"n": 8, "kind": kind} | atoms.wall(8, kind, evaluations=20) for kind in atoms.WALLS]
    assert all(row["cpu"] > 0 for row in rows)
    text = report.walls(rows)
    assert "| 8² | none | 768 |" in text
    assert text.count("**") == 2 * len(rows)


@pytest.mark.filterwarnings("ignore:not converged")  # areas that are jumped over count, too
def test_searches_and_paths_are_counted_beside_solves_from_rest() -> None:
    rows = [
        {"n": 64, "adhesion_length": 0.005, "seed": 1, "area": 0.05} | paths.search(64, 1, 0.005, 0.05),
        {"n": 64, "adhesion_length": 0.005, "seed": 1, "area": "path"} | paths.path(64, 1, 0.005),
    ]
    assert rows[0]["status"] == "CONVERGED"
    assert rows[0]["area"] == pytest.approx(0.05, abs=0.01 * 0.05 + 0.5 / 64**2)
    assert rows[1]["areas"][0] < rows[1]["areas"][1]
    ratio = rows[0]["fft_pairs"] / rows[0]["cold"]
    assert f"| 64² | 0.005 | {ratio:.2f} |" in report.searches(rows)
