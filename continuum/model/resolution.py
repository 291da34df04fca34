"""Checks whether the grid resolves the surface, and the wall law at the rim of a contact."""

from collections.abc import Iterator

import numpy as np

from continuum.inputs.arguments import ArgumentError
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.surface import LARGEST_SLOPE
from continuum.theory.paper import snap_in_wavelength

POINTS = 4
"""Points of the grid needed per wavelength."""
SMALL_SLOPE = 0.3
"""Largest rms slope that small-slope theory covers: there tan and sin of a typical slope differ by 4 %."""
OTHER_UNIT = 10.0
"""Factor by which a stiffness may differ from that of a half-space of E* = 1 in the median over all waves."""
LARGEST_SHARE = 0.05
"""Largest part of the mean square slope that may lie in shorter waves; surfaces with edges have about as much."""


def check_slope(rms_slope: float) -> None:
    """Check that the slope is not zero, as tolerances refer to it, and not too large for linear elasticity."""
    if not 0 < rms_slope <= LARGEST_SLOPE * (1 + 1e-9):
        what = f"a slope greater than 0 and at most {LARGEST_SLOPE:g}: heights are in a0, as the spacing is"
        raise ArgumentError("rms slope of the heights", float(rms_slope), what)


def steep(rms_slope: float) -> Iterator[str]:
    """Warning about slopes that are not small, with a remedy."""
    if rms_slope > SMALL_SLOPE * (1 + 1e-9):  # a surface scaled to the bound may exceed it by rounding
        yield (
            f"the rms slope, {rms_slope:.3g}, is above {SMALL_SLOPE:g}: the theory of small slopes does not cover "
            "it, and areas and loads are those of that theory only; lower rms_slope, or check the units of the heights"
        )


def short_waves(problem: ContactProblem) -> float:
    """Part of the mean square slope in waves of fewer than ``POINTS`` points."""
    grid, heights = problem.period
    spectrum = grid.forward(heights)
    power: Real = (spectrum.real**2 + spectrum.imag**2) * grid.mode_weights * grid.wavenumber**2
    limit = 2 * np.pi / (POINTS * grid.widest_step)
    total = float(power.sum())
    return float(power[grid.wavenumber > limit * (1 + 1e-9)].sum()) / total if total else 0.0


def other_unit(problem: ContactProblem) -> Iterator[str]:
    """Warning about a stiffness that seems to be in another unit than E*/a0, with a remedy.

    Most waves of a grid are short, and for short waves the substrate is a half-space: the median of 2 K/q over some
    ten thousand waves is about E*.
    """
    every = max(1, round((problem.grid.size / 2e4) ** 0.5))
    q, stiffness_q = (values[::every, ::every].ravel()[1:] for values in (problem.grid.wavenumber, problem.stiffness_q))
    modulus = float(np.median(2 * stiffness_q / q)) if q.size else 1.0
    if not 1 / OTHER_UNIT <= modulus <= OTHER_UNIT:
        yield (
            f"most waves are {modulus:.3g} times as stiff as those of a half-space of E* = 1, the unit of pressure: "
            "areas, tolerances and kappa refer to that unit; divide the stiffness, and the tractions of the wall, by "
            "the contact modulus"
        )


def unresolved(problem: ContactProblem, rms_slope: float, shortest: float | None = None) -> Iterator[str]:
    """Warnings about lengths that the grid does not resolve, each with a remedy.

    Three lengths are compared with the spacing Δ.  None is an error: the paper's model has one point for each atom,
    and its law acts on single atoms.  But results are then not those of the continuum, and a finer grid gives others.

    * The surface: its shortest wavelength against 4 Δ.  Its curvature, and with it the size of contacts, comes from
      the shortest waves; with fewer points a crest falls between points or on one.
    * The range of the attraction against h'rms Δ, by which the gap grows from one point to the next at the rim of a
      contact: a shorter range acts on less than one point beside the contact, and the attracted area is a count
      of rims.
    * The softening s of the law against the stiffness of the surface, E* q/2: waves longer than π E*/s snap together.
      Where that is shorter than 4 Δ, single points snap in and out one after another (beyond 2 Δ even a wave of
      alternating points): the rim of a contact is pinned to the grid, and hysteresis comes from the grid.

    Where the shortest wavelength of the surface, in a0, is not known, the spectrum of the heights is used.
    """
    wall, spacing = problem.wall, problem.grid.widest_step
    needed = POINTS * spacing
    if shortest is not None and shortest < needed * (1 - 1e-9):
        yield (
            f"the shortest wavelength, {shortest:g} a0, has fewer than {POINTS} points of spacing {spacing:g} a0: "
            "contact areas depend on the grid; raise grid.n at the same period, or lambda_s"
        )
    elif shortest is None and (share := short_waves(problem)) > LARGEST_SHARE:
        yield (
            f"{share:.0%} of the mean square slope lies in waves of fewer than {POINTS} points: contact areas depend "
            "on the grid; raise grid.n at the same period, or smooth the heights"
        )
    if wall.work_of_adhesion <= 0:
        return
    change = rms_slope * spacing
    if wall.range < change:
        yield (
            f"the wall attracts over {wall.range:.3g} a0, less than the gap changes between neighbouring points at the "
            f"rim of a contact (h'rms times the spacing, {change:.3g} a0): attracted areas depend on the grid; raise "
            "grid.n at the same period"
        )
    snapping = snap_in_wavelength(wall.largest_softening)
    if snapping < needed * (1 - 1e-9):
        yield (
            f"the wall softens so much ({wall.largest_softening:.3g} E*/a0) that waves longer than {snapping:.3g} a0, "
            f"fewer than {POINTS} points, snap in: single points of the grid jump, and hysteresis depends on the grid; "
            "raise grid.n at the same period, or take a longer range"
        )


def doubts(problem: ContactProblem, rms_slope: float, shortest: float | None = None) -> tuple[str, ...]:
    """All warnings about a problem: :func:`steep`, :func:`other_unit`, :func:`unresolved`."""
    return (*steep(rms_slope), *other_unit(problem), *unresolved(problem, rms_slope, shortest))
