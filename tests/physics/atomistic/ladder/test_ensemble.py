"""Bounds that carry over: what a quantile is worth, what is left out of it, and where it says nothing."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import budget, ensemble
from atomistic.ladder.budget import LadderCheck
from atomistic.ladder.ensemble import RARE, Row, carried_bounds, limit, untested
from continuum.inputs.reading import load
from tests.problems import validation_input

ROOT = Path(__file__).parents[4]
SPRINGS = validation_input(
    32,
    16.0,
    [1, 2],
    """
[[case]]
name = "plain"
adhesion_length = 0.0
rms_slopes = [0.1, 0.01]
areas = [0.1, 0.25]
""",
)


def of(text: str, tmp_path: Path) -> ValidateConfig:
    (tmp_path / "input.toml").write_text(text)
    return load(tmp_path / "input.toml", ValidateConfig)


def made(
    crystal: str, coefficient: float, seeds: range = range(101, 109), branches: tuple[str, ...] = ("approach",)
) -> list[Row]:
    """States of one crystal whose coefficients scatter by a per cent."""
    return [
        Row(crystal, 2.0, length, seed, slope, area, branch, *(c * slope**n for n in (1, 1, 2)), c, 2 * c, 3 * c, 4 * c)
        for seed in seeds
        for branch in branches
        for length in (0.0, 0.005)
        for slope in (0.1, 0.01)
        for area in (0.1, 0.25)
        for c in (coefficient * (1 + 0.01 * (seed % 2)),)
    ]


def test_a_further_surface_exceeds_the_limit_as_rarely_as_is_said(rng: np.random.Generator) -> None:
    runs, surfaces = 4000, 2
    normal = 0.6 * rng.standard_normal((runs, 8 + surfaces))
    for drawn, logarithms in ((np.exp(normal), True), (normal, False)):
        limits = [limit({"a": dict(enumerate(each[:8]))}, surfaces, logarithms=logarithms)[0] for each in drawn]
        broken = np.mean(drawn[:, 8:].max(axis=1) > limits)
        # The two surfaces share a limit: at most RARE; a binomial of 4000 trials scatters by 0.0016.
        assert broken == pytest.approx(RARE, abs=4 * np.sqrt(RARE / runs))
    # Twice the coefficients are twice the limit; of crystals with equal scatter the larger counts.
    one, two = {1: 1.0, 2: 1.1, 3: 0.9}, {1: 2.0, 2: 2.2, 3: 1.8}
    both = limit({"a": one, "b": two}, 1)
    assert both[1] == "b"
    assert both[0] == pytest.approx(2 * limit({"a": one}, 1)[0], rel=1e-12)


def test_what_is_judged_is_in_no_bound_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gold = load(ROOT / "inputs/validate/gold.toml", ValidateConfig)
    states = [*made("Cu_mishin1.eam.alloy", 0.1), *made("Au_u3.eam", 9.0), *made("springs", 9.0)]
    monkeypatch.setattr(ensemble, "rows", lambda: states)
    plain, sticky = (carried_bounds(gold, case) for case in gold.case)
    linear = ("depth", "anisotropy", "discreteness", "total")
    assert [(b.step, b.quantity, b.power) for b in plain] == [
        *((step, "gross_load", 0) for step in linear),
        ("nonlinearity", "load", 1),
        ("nonlinearity", "displacement", 2),
    ]
    assert [(b.step, b.quantity, b.power) for b in sticky[4:]] == [("nonlinearity", "gross_load", 1)]
    for k, bounds in enumerate(zip(plain[:4], sticky[:4], strict=True), 1):
        assert all(0.1 * k < bound.coefficient < 0.12 * k for bound in bounds)
    assert all(0.1 < bound.coefficient < 0.12 for bound in (*plain[4:], *sticky[4:]))
    assert "8 other surfaces of " in plain[0].reason
    # Of springs the surfaces that are judged are left out, and what is left has to be enough.
    springs = of(SPRINGS, tmp_path)
    states = [*made("springs", 0.1), *made("springs", 9.0, range(1, 3))]
    assert carried_bounds(springs, springs.case[0])[0].coefficient < 0.12
    states = made("springs", 0.1, range(1, 10))
    assert "fewer than 8 surfaces" in untested(springs, springs.case[0])
    assert not carried_bounds(springs, springs.case[0])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('kind = "springs"', 'kind = "lennard-jones"', "depth/λ_s is 4, here 2"),
        (
            "adhesion_length = 0.0",
            'adhesion_length = 0.005\nbranches = ["retract"]',
            "with adhesion it approaches only",
        ),
        ("depth = 16.0", "depth = 40.0", "depth/λ_s is 2 or 4, here 5"),
        ("hurst = 0.8", "hurst = 0.5", "H is 0.8, here 0.5"),
        ("rms_slopes = [0.1, 0.01]", "rms_slopes = [0.001]", "h' is 0.01 to 0.1"),
        ("areas = [0.1, 0.25]", "areas = [0.02]", "A_rep/A0 is 0.1 to 0.25"),
        ("adhesion_length = 0.0", "adhesion_length = 0.05", "l_a/a0 is 0 or 0.005, here 0.05"),
    ],
)
def test_outside_of_the_ensemble_there_is_no_bound(old: str, new: str, words: str, tmp_path: Path) -> None:
    config = of(SPRINGS.replace(old, new), tmp_path)
    assert words in untested(config, config.case[0])
    assert not carried_bounds(config, config.case[0])


def test_retracting_states_are_judged_by_such_states_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = of(SPRINGS.replace("adhesion_length = 0.0", 'adhesion_length = 0.005\nbranches = ["approach"]'), tmp_path)
    states = [*made("springs", 0.1), *made("springs", 9.0, branches=("retract",))]
    monkeypatch.setattr(ensemble, "rows", lambda: states)
    assert carried_bounds(config, config.case[0])[0].coefficient < 0.12
    both = config.case[0].model_copy(update={"branches": ("approach", "retract")})
    assert carried_bounds(config, both)[0].coefficient > 9


def test_lennard_jones_is_judged_by_its_own_surfaces_where_it_was_run() -> None:
    config = load(ROOT / "inputs/validate/lennard-jones.toml", ValidateConfig)
    plain, *others = config.case
    bounds = {bound.step: bound for bound in carried_bounds(config, plain)}
    assert {*ensemble.LINEAR} < {*bounds}
    assert all("8 other surfaces of " in bound.reason for bound in bounds.values())
    assert all("l_a/a0 is 0, here" in untested(config, case) for case in others)


def test_the_ensemble_has_eight_surfaces_of_each_crystal_and_judges_a_case_without_bounds(tmp_path: Path) -> None:
    families: dict[tuple[str, float, float], list[ensemble.Row]] = {}
    for row in ensemble.rows():
        families.setdefault((row.crystal, row.depth, row.adhesion_length), []).append(row)
    for family in families.values():
        seeds = Counter(row.seed for row in family)
        assert len(seeds) >= ensemble.FEWEST
        assert len(set(seeds.values())) == 1  # every surface has all states of its family
    # Sixteen surfaces on the slab of quick.toml, by whose coefficients its own surfaces are judged.
    assert {length for crystal, depth, length in families if (crystal, depth) == ("springs", 4.0)} == {
        0.0,
        0.0005,
        0.005,
    }
    assert all(len({row.seed for row in families["springs", 4.0, length]}) == 16 for length in (0.0, 0.0005, 0.005))
    config = of(SPRINGS, tmp_path)
    assert not untested(config, config.case[0])
    slopes, count = np.array([0.1, 0.01]), 2
    columns = {
        "case": np.array(["plain"] * count), "rms_slope": slopes, "seed": np.array([1, 2]), "area": np.full(count, 0.1),
        "place": np.array(["area"] * count), "branch": np.array(["approach"] * count),
        "largest_force": 1e-10 * slopes,
        "nonlinearity_load": np.array([0.2, 1.0]) * slopes, "nonlinearity_displacement": 0.5 * slopes**2,
        **{f"{step}_gross_load": np.array([0.001, 0.2 * (step == "total")]) for step in ensemble.LINEAR},
        **{f"check_{name}": np.array([]) for name in LadderCheck._fields},
    }  # fmt: skip
    failed = [verdict for verdict in budget.bound_verdicts(config, columns) if not verdict.holds]
    where = "h' = 0.01, seed 2, A_rep/A0 = 0.1, approach"
    assert [(v.step, v.quantity, v.state) for v in failed] == [
        ("total", "gross load", where),
        ("nonlinearity", "load", where),
    ]
