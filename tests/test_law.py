"""docs/law.md: its numbers are those of the record, and the fit finds a law that is known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.studies import law


def test_the_page_has_the_numbers_of_the_record() -> None:
    page = (Path(__file__).parents[1] / "docs" / "law.md").read_text()
    for table in law.tables().split("\n\n"):
        assert table in page


@pytest.mark.parametrize("shape", ["spline", "exponential"])
def test_a_law_that_is_known_is_found(shape: str, rng: np.random.Generator) -> None:
    """Turns made from U F with noise: D, m, the factors and the exponent come back within three standard errors."""
    turns = law.turns(shape)
    factors = np.array([1.3, 0.9, 1 / (1.3 * 0.9)])[np.unique(turns.seed, return_inverse=True)[1]]
    noise = np.exp(0.1 * rng.standard_normal(turns.work.size))
    made = law.fit(replace(turns, work=law.PLATEAU / (1 + (turns.range / 0.6) ** 1.1) * factors * noise))
    assert abs(np.log(made.crossover / 0.6)) < 3 * made.errors[0]
    assert abs(made.exponent - 1.1) < 3 * made.errors[1]
    np.testing.assert_allclose(made.factors, [1.3, 0.9, 1 / (1.3 * 0.9)], rtol=3 * 0.1 / np.sqrt(20))
    assert made.scatter == pytest.approx(np.exp(0.1), rel=0.03)
    assert made.power_of_energy == pytest.approx(1, abs=0.1)
