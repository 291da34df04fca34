"""The comparisons with analytic contacts: what is compared, how closely, and why not closer.

Each function makes the lines of one contact.  The tests assert them, and docs/verification.md prints them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from continuum.classical import DMT, JKR, Hertz, Westergaard
from continuum.constrained import Pressed
from continuum.greens import HalfSpace
from continuum.grid import Grid, Real
from continuum.loading import solve
from continuum.minimise import Settings
from continuum.problem import ContactProblem
from continuum.surface import sine, sphere
from continuum.wall import HardWall
from tests.verification.adhesive import (
    IMAGES_CURVATURE,
    IMAGES_SHIFT,
    SphereCurve,
    WaveCurve,
    dugdale_sphere,
    paper_sphere,
    pull_off,
    sphere_loads,
    wave_curve,
    wave_pressures,
)

__all__ = ["COMPARISONS", "Check", "Comparison", "maugis_curve", "order", "pull_off_over_limit", "wave"]


@dataclass(frozen=True)
class Check:
    """One number of the solver beside the analytic one."""

    quantity: str
    ours: float
    analytic: float
    error: float
    """Difference, in the unit that ``quantity`` names or over the analytic number."""
    allowed: float

    @property
    def good(self) -> bool:
        """Whether the difference is allowed; not so where it is no number."""
        return bool(abs(self.error) <= self.allowed)


@dataclass(frozen=True)
class Comparison:
    """One contact."""

    name: str
    make: Callable[[], list[Check]]
    why: str
    """Where the differences come from: the reason of the tolerances."""
    long: bool = False


def relative(quantity: str, ours: float, analytic: float, allowed: float) -> Check:
    """A difference over the analytic number."""
    return Check(quantity, ours, analytic, ours / analytic - 1, allowed)


# --- hard wall ---------------------------------------------------------------------------------------------


def hertz(n: int, contact: float = 0.1) -> list[Check]:
    """A sphere pressed by its indentation; contact radius as a part of the period."""
    radius = 400.0
    grid = Grid.square(n)
    wanted = Hertz(radius, 4 * (contact * n) ** 3 / (3 * radius))
    separation = IMAGES_SHIFT * wanted.load / (np.pi * n) - wanted.indentation
    problem = ContactProblem(grid, HardWall(), sphere(grid, radius), HalfSpace("clamped"))
    state = solve(problem, "separation", separation, Settings(1e-10))
    state.solution.require()
    assert isinstance(state.solution, Pressed)
    load = state.mean_pressure * grid.area
    bent = Hertz(1 / (1 / radius + IMAGES_CURVATURE * load / (2 * np.pi * n**3)), load)
    depth = IMAGES_SHIFT * load / (np.pi * n) - separation
    touching = float(np.sqrt(np.count_nonzero(state.gap == 0) / np.pi))
    r = np.hypot(*(axis - n / 2 for axis in grid.positions))
    off = np.sqrt(np.mean((state.solution.traction - bent.pressure(r))[r < bent.contact_radius] ** 2))
    peak = float(bent.pressure(np.zeros(1))[0])
    return [
        relative(f"indentation at the load, n = {n}", depth, bent.indentation, 5e-3),
        Check("contact radius, in cells", touching, bent.contact_radius, touching - bent.contact_radius, 0.5),
        relative("largest pressure", float(state.solution.traction.max()), peak, 5e-3),
        Check("pressure inside, rms over the largest", float(off), 0.0, float(off / peak), 0.02),
    ]


def westergaard(n: int, part: float) -> list[Check]:
    """A one-dimensional wave at a mean gap that is a part of its amplitude."""
    amplitude, wavelength = 64 * 0.1 / np.pi, 64.0
    grid = Grid((n, 4), (wavelength, 4 * wavelength / n))
    problem = ContactProblem(grid, HardWall(), sine(grid, amplitude, (1, 0)), HalfSpace("free"))
    state = solve(problem, "mean-gap", part * amplitude, Settings(1e-10))
    state.solution.require()
    assert isinstance(state.solution, Pressed)
    exact = Westergaard(amplitude, wavelength, state.mean_pressure)
    width = np.count_nonzero(state.gap[:, 0] == 0) / 2
    x = np.minimum(grid.positions[0], wavelength - grid.positions[0])
    off = np.sqrt(np.mean((state.solution.traction - exact.pressure(x)) ** 2))
    analytic = exact.half_width / grid.spacing[0]
    share = state.mean_pressure / exact.full_pressure
    return [
        Check(f"half-width in cells at p̄/p* = {share:.3f}, n = {n}", width, analytic, width - analytic, 1.0),
        Check("pressure, rms over p*", float(off), 0.0, float(off / exact.full_pressure), 32 / n / 64),
    ]


def double_wave(n: int) -> list[Check]:
    """Two crossed waves: both limits of Johnson, Greenwood and Higginson (1985)."""
    wavelength, amplitude = float(n), 1.0
    grid = Grid.square(n)
    x, y = grid.positions
    heights = amplitude * (1 - np.cos(2 * np.pi * x / wavelength) * np.cos(2 * np.pi * y / wavelength))
    problem = ContactProblem(grid, HardWall(), heights, HalfSpace("free"))
    full = np.sqrt(2) * np.pi * amplitude / wavelength
    checks = []
    for part in (0.9, 0.8, 0.01, 0.004):
        state = solve(problem, "mean-gap", part * amplitude, Settings(1e-9 * full))
        state.solution.require()
        share = state.mean_pressure / full
        area = np.count_nonzero(state.gap == 0) / grid.size
        if part > 0.5:
            # Two crests in a cell, R = λ²/(4π² Δ); the next order is that of (a/λ)², p^(2/3).
            limit = np.pi * (3 * share / (8 * np.pi)) ** (2 / 3)
            checks.append(relative(f"contact area at p̄/p* = {share:.3f}", area, limit, 0.02 + share ** (2 / 3)))
        else:
            limit = 3 / (2 * np.pi) * (1 - share)
            checks.append(relative(f"open area at p̄/p* = {share:.3f}", 1 - area, limit, 0.02 + (1 - share)))
    return checks


# --- adhesion ----------------------------------------------------------------------------------------------


@cache
def maugis_curve(tabor: float, n: int, edge: float, points: int = 10) -> SphereCurve:
    """One computation for the tests, the table and the figure."""
    return dugdale_sphere(tabor, n, edge, points)


def maugis(tabor: float, n: int, edge: float) -> list[Check]:
    """A sphere under nearly Maugis and Dugdale's law, from zero load past its pull-off."""
    curve = maugis_curve(tabor, n, edge)
    worst = int(np.argmax(np.abs(curve.error)))
    force = curve.sphere.maugis.pull_off_force
    tension = float(-curve.load.min())
    contact = float((curve.contact - curve.maugis_contact)[0] / curve.maugis_contact[0])
    # Grid; edge of the law; zone of attraction against contact; yield of the core, as the stiffness of the contact.
    allowed = 0.01 + 0.1 * edge + 0.01 * tabor + 0.003 / tabor
    return [
        Check(
            f"load over its pull-off, worst of {curve.load.size} indentations, n = {n}",
            float(curve.load[worst] / force),
            float(curve.maugis[worst] / force),
            float(curve.error[worst]),
            allowed,
        ),
        relative("pull-off force", tension, force, allowed),
        Check("contact radius without load, relative", curve.contact[0], curve.maugis_contact[0], contact, 0.1),
    ]


@cache
def pull_off_over_limit(tabor: float, n: int, points: int = 12) -> tuple[float, float]:
    """Pull-off force under the paper's law over π w R, and Maugis and Dugdale's."""
    made = paper_sphere(tabor, n)
    unit = np.pi * made.work * made.radius
    return pull_off(made, points) / unit, made.maugis.pull_off_force / unit


PULL_OFFS = ((0.05, 96), (0.1, 96), (0.3, 96), (1.0, 96), (2.0, 128))
PULL_OFFS_LONG = ((3.0, 256), (5.0, 512))


def pull_offs(cases: tuple[tuple[float, int], ...]) -> list[Check]:
    """Pull-off from DMT to JKR, under the paper's law."""
    dmt, jkr = DMT(1.0, 1 / np.pi).pull_off_force, JKR(1.0, 1 / np.pi).pull_off_force
    checks = []
    for tabor, n in cases:
        ours, theirs = pull_off_over_limit(tabor, n)
        name = f"pull-off force/(π w R) at μ = {tabor:g}, n = {n}"
        checks.append(relative(f"{name}, against Maugis", ours, theirs, 0.07))
        if tabor <= 0.1:
            checks.append(relative(f"{name}, against DMT", ours, dmt, 0.2 * tabor))
        if tabor >= 2:
            checks.append(relative(f"{name}, against JKR", ours, jkr, 0.1 / tabor))
    return checks


@cache
def wave(wavelength: float, n: int, points: int = 14, alpha: float = 0.3) -> WaveCurve:
    """One computation for the tests, the table and the figure."""
    return wave_curve(alpha, wavelength, n, points)


def johnson(wavelength: float, n: int) -> list[Check]:
    """A wave with adhesion: partial contact between its jump to full contact and pull-off."""
    curve = wave(wavelength, n)
    known = np.isfinite(curve.johnson) & (curve.repulsive > 0)
    cells = curve.spacing
    # By how many cells Johnson's edge lies outside the zone where the law pulls.
    out = np.maximum(curve.repulsive - curve.johnson, curve.johnson - curve.attracted)[known] / cells
    zone = float(np.mean(curve.attracted - curve.repulsive)) / wavelength
    return [
        relative(
            f"pull-off pressure, λ = {wavelength:g} a0, n = {n}",
            curve.pull_off,
            curve.wave.pull_off_pressure,
            5 / wavelength,
        ),
        Check(
            f"Johnson's edge outside the attracted zone, in cells, worst of {out.size} (zone: {zone:.3f} λ)",
            float(max(out.max(), 0)),
            0.0,
            float(max(out.max(), 0)),
            0.5,
        ),
    ]


SPHERE_GRIDS, WAVE_GRIDS = (64, 128, 256, 512), (128, 256, 512, 1024, 2048)


@cache
def order(kind: str) -> tuple[float, tuple[int, ...], Real]:
    """Observed order of loads with the grid, the grids, and differences from the finest over the largest load."""
    sizes = SPHERE_GRIDS if kind == "sphere" else WAVE_GRIDS
    values = [sphere_loads(1.0, n) if kind == "sphere" else wave_pressures(n) for n in sizes]
    errors = np.array([np.sqrt(np.mean((v - values[-1]) ** 2)) for v in values[:-1]])
    found = -float(np.polyfit(np.log(sizes[:-1]), np.log(errors), 1)[0])
    return found, sizes[:-1], errors / np.abs(values[-1]).max()


def orders() -> list[Check]:
    """Convergence of loads at given separation or mean gap under the paper's law."""
    expected = {"sphere": (3.5, 0.5), "wave": (3.0, 0.3)}
    checks = []
    for kind, (analytic, allowed) in expected.items():
        found, sizes, _ = order(kind)
        name = f"observed order of the load of a {kind}, n = {sizes[0]} ... {sizes[-1]}"
        checks.append(Check(name, found, analytic, found - analytic, allowed))
    return checks


IMAGES = (
    "Images of a sphere and the mean pressure are accounted for in shift and curvature; the next order is (a/L)^5. "
)
COMPARISONS = (
    Comparison(
        "Hertz, hard wall",
        partial(hertz, 160),
        IMAGES + "The edge of contact is known to half a cell of 16, and the pressure there ends as a square root.",
    ),
    *(
        Comparison(
            f"Westergaard's wave, hard wall, mean gap {part} Δ",
            partial(westergaard, 512, part),
            "The edge is known to a cell; the square root of the pressure there makes its rms error p* dx/2λ.",
        )
        for part in (0.7, 0.3, 0.05)
    ),
    Comparison(
        "Crossed waves, hard wall",
        partial(double_wave, 256),
        "Exact at vanishing load and at full contact only: corrections of p^(2/3) and of 1 - p; cells at the edges.",
    ),
    *(
        Comparison(
            f"Maugis-Dugdale sphere, μ = {tabor:g}",
            partial(maugis, tabor, n, edge),
            IMAGES
            + f"The tension ends over {edge:g} of its distance instead of at once; a zone of some cells at the edge "
            "that shrinks as 1/μ² against the contact; the core yields half a per cent of the distance, 0.3 %/μ of the "
            "load. A contact ends where the gap is a quarter of the edge, which adds a tenth to its radius at μ = 0.1.",
            long,
        )
        for tabor, n, edge, long in (
            (1.0, 128, 0.2, False),
            (0.1, 256, 0.05, True),
            (0.3, 256, 0.05, True),
            (1.0, 256, 0.1, True),
            (2.0, 256, 0.2, True),
        )
    ),
    *(
        Comparison(
            f"Sphere, the paper's law, {towards}",
            partial(pull_offs, cases),
            IMAGES
            + "The paper's law is no constant tension: at equal w and largest tension it holds up to 6 % more than "
            "Maugis' in between. Towards the limits it falls short of DMT's force by 0.2 μ (Maugis: 0.3 μ) and exceeds "
            "JKR's by 0.1/μ.",
            long,
        )
        for towards, cases, long in (("DMT to JKR", PULL_OFFS, False), ("towards JKR", PULL_OFFS_LONG, True))
    ),
    *(
        Comparison(
            f"Johnson's adhesive wave, α = 0.3, λ = {wavelength:g} a0",
            partial(johnson, wavelength, n),
            "JKR's edge stands for a zone of finite width, 0.8 w E*/σ² = 6 a0 with the paper's law: 5 a0/λ in the "
            "pull-off pressure. The edge lies within that zone, known to half a cell.",
            long,
        )
        for wavelength, n, long in ((128.0, 128, False), (512.0, 256, False), (2048.0, 1024, True))
    ),
    Comparison(
        "Order with the grid, the paper's law",
        orders,
        "The traction is continuous with its slope, its curvature jumps where the gap is a0 and at the cut-off: third "
        "order where these lines meet the grid alike, as in a wave; half an order more where they meet it at random, "
        "as in a sphere. An exponent from few grids scatters.",
    ),
)
