"""Fixtures shared by all tests."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import settings

# Whether a test passes must not depend on how fast the machine is, or on who else uses it.
settings.register_profile("any machine", deadline=None)
settings.load_profile("any machine")


@pytest.fixture
def rng() -> np.random.Generator:
    """A seeded generator: a failure repeats."""
    return np.random.default_rng(20140210)
