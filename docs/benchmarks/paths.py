"""What a point costs on a path and in a search, beside a solve from rest at the same mean gap: counts alone."""

from __future__ import annotations

from statistics import median
from typing import Any

import numpy as np

import continuum as c
from docs.benchmarks.cases import rough

AREAS = (0.003, 0.01, 0.05, 0.2, 0.3)
"""Areas that are searched for, each from rest, to 1 % of the area: the default."""
GAPS = (2.2, 0.8, 20)
"""A path of so many mean gaps, from the first to the second, in h_rms: from about 1 to 25 % of the area."""


def _contact(n: int, seed: int, adhesion_length: float) -> c.Contact:
    return c.Contact(rough(n, seed).heights(), c.LennardJonesSpline(adhesion_length=adhesion_length))


def search(n: int, seed: int, adhesion_length: float, area: float) -> dict[str, Any]:
    """Find an area from rest, then solve at its mean gap from rest."""
    contact = _contact(n, seed, adhesion_length)
    found = contact.press(area=area)
    cold = contact.press(mean_gap=found.mean_gap).solution.fft_pairs
    return {
        "status": found.status.name, "area_rep": found.area_rep, "solves": found.search_solves + 1, "cold": cold,
        "fft_pairs": found.search_pairs + found.solution.fft_pairs,
    }  # fmt: skip


def path(n: int, seed: int, adhesion_length: float) -> dict[str, Any]:
    """Follow a path of mean gaps on approach, and solve at each of them from rest."""
    contact = _contact(n, seed, adhesion_length)
    gaps = np.linspace(*GAPS[:2], GAPS[2]) * contact.moments.rms_height
    states = contact.path(mean_gap=gaps.tolist()).states
    cold = [contact.press(mean_gap=float(gap)).solution.fft_pairs for gap in gaps]
    return {
        "areas": [states[0].area_rep, states[-1].area_rep], "cold": median(cold),
        "fft_pairs": median(state.solution.fft_pairs for state in states),
        "status": ", ".join(sorted({state.status.name for state in states})),
    }  # fmt: skip
