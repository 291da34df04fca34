"""The work that a tension does, on a curve whose areas are known."""

from __future__ import annotations

import numpy as np
import pytest

from continuum.measure.curve import Curve, adhesion


def test_the_work_of_a_tension_counts_from_where_the_load_crosses_zero() -> None:
    """Load from 2 to -2 along a line, then to 0: the triangle below zero, beginning in the middle of a step."""
    distance, load = np.array([0.0, 1.0, 0.0, 1.0, 3.0]), np.array([1.0, 2.0, 2.0, -2.0, 0.0])
    away = np.array([False, False, True, True, True])
    found = adhesion(Curve(mean_gap=distance, separation=distance, load=load, retracting=away))
    assert found.pull_off == 2.0
    assert found.work_of_separation == pytest.approx(0.5 * 0.5 * 2.0 + 0.5 * 2.0 * 2.0)
