"""The two measured maps: no files of ours; tests read them where STICKINESS_TOPOGRAPHIES names their folder."""

from __future__ import annotations

import os
from importlib import util
from pathlib import Path

import pytest

__all__ = ["AFM", "MEASURED", "needs_files", "needs_reader"]

MEASURED = Path(os.environ.get("STICKINESS_TOPOGRAPHIES", "nowhere"))
AFM = "gain_control_uncd_35.001"
"""The map in the container; the other two members are line scans."""
needs_reader = pytest.mark.skipif(util.find_spec("SurfaceTopography") is None, reason="SurfaceTopography not installed")
needs_files = pytest.mark.skipif(
    not MEASURED.is_dir(), reason="STICKINESS_TOPOGRAPHIES names no folder with the two measured maps"
)
