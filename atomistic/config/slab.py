"""Tables that the inputs of a validation and of a deck share: the slab, and when an equilibrium is one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from continuum.files.tables import Table
from continuum.files.toml import Fault
from continuum.runs.surfaces import SelfAffineSurface, SelfAffineTable
from continuum.runs.tables import Fraction, ToleranceTable

SHALLOWEST, DEEPEST = 2.0, 512.0
"""Depth of a slab, in a0."""


class SlabTable(Table):
    """The atoms."""

    n: Annotated[int, Field(ge=8, le=512)]
    """surface atoms along x and along y; the period is n a0"""
    depth: Annotated[float, Field(ge=SHALLOWEST, le=DEEPEST)]
    """from the surface plane to the frozen base, in a0, rounded to whole layers"""


class AtomsSolverTable(ToleranceTable):
    """When an equilibrium is one."""

    tolerance: Fraction = 1e-9
    """largest rms residual of the continuum rungs, relative to rms_slope E*"""
    force_tolerance: Annotated[float, Field(gt=0, le=1e-8)] = 1e-8
    """largest force left on an atom, relative to rms_slope E* a0²"""


def misfits(slab: SlabTable, surface: SelfAffineTable) -> Iterator[Fault]:
    """Wavelengths that the surface atoms cannot show or the period cannot hold."""
    if surface.lambda_s < 2:
        yield Fault(("surface", "lambda_s"), "at least 2, two spacings of atoms", "a length in other units")
    if surface.lambda_L > slab.n:
        yield Fault(("surface", "lambda_L"), f"at most the period, slab.n = {slab.n}")
    if surface.lambda_L < surface.lambda_s and not isinstance(surface, SelfAffineSurface):  # which looks by itself
        yield Fault(("surface", "lambda_L"), f"at least surface.lambda_s = {surface.lambda_s}")
