"""The comparisons with analytic contacts: what is compared, how closely, and why not closer.

Each function makes the lines of one contact.  The tests assert them, and docs/studies/verification.md prints them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surfaces import sine, sphere
from continuum.model.walls import HardWall
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from continuum.theory.smooth import DMT, JKR, Hertz
from tests.classical import Westergaard
from tests.verification.adhesive import (
    IMAGES_CURVATURE,
    IMAGES_SHIFT,
    PullOff,
    SphereCurve,
    WaveCurve,
    dugdale_sphere,
    images_shift,
    paper_sphere,
    pull_off,
    sphere_loads,
    wave_curve,
    wave_pressures,
)

__all__ = ["COMPARISONS", "Check", "Comparison", "maugis_curve", "order", "retraction", "wave"]


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
    load = state.load * grid.area
    bent = Hertz(1 / (1 / radius + IMAGES_CURVATURE * load / (2 * np.pi * n**3)), load)
    depth = images_shift(grid, state.solution.traction) - separation
    touching = float(np.sqrt(np.count_nonzero(state.gap == 0) / np.pi))
    r = np.hypot(*(axis - n / 2 for axis in grid.positions))
    off = np.sqrt(np.mean((state.solution.traction - bent.pressure(r))[r < bent.contact_radius] ** 2))
    peak = float(bent.pressure(np.zeros(1))[0])
    return [
        relative(f"indentation at the load, n = {n}", depth, bent.indentation, 1e-3),
        Check("contact radius, in cells", touching, bent.contact_radius, touching - bent.contact_radius, 0.5),
        relative("largest pressure", float(state.solution.traction.max()), peak, 1e-3),
        Check("pressure inside, rms over the largest", float(off), 0.0, float(off / peak), 0.02),
    ]


def westergaard(n: int, part: float) -> list[Check]:
    """A one-dimensional wave at a mean gap that is a part of its amplitude."""
    amplitude, wavelength = 64 * 0.1 / np.pi, 64.0
    grid = Grid((n, 4), (wavelength, 4 * wavelength / n))
    problem = ContactProblem(grid, HardWall(), sine(grid, amplitude, (1, 0)), HalfSpace("free"))
    state = solve(problem, "mean-gap", part * amplitude, Settings(1e-10))
    state.solution.require()
    exact = Westergaard(amplitude, wavelength, state.load)
    width = np.count_nonzero(state.gap[:, 0] == 0) / 2
    x = np.minimum(grid.positions[0], wavelength - grid.positions[0])
    off = np.sqrt(np.mean((state.solution.traction - exact.pressure(x)) ** 2))
    analytic = exact.half_width / grid.spacing[0]
    share = state.load / exact.full_pressure
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
        share = state.load / full
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
    tension = float(-curve.load.min())
    force = curve.sphere.bent(-tension).pull_off_force
    contact = float((curve.contact - curve.maugis_contact)[0] / curve.maugis_contact[0])
    # Grid; edge of the law; zone of attraction against contact; yield of the core, as the stiffness of the contact.
    allowed = 0.01 + 0.05 * edge + 0.01 * tabor + 0.003 / tabor
    grid = int(np.argmax(np.abs(curve.load - curve.annuli)))
    return [
        Check(
            f"load over its pull-off, n = {n}, worst of {curve.load.size}, against annuli",
            float(curve.load[grid] / force),
            float(curve.annuli[grid] / force),
            float((curve.load - curve.annuli)[grid] / force),
            0.02,
        ),
        Check(
            "the same, against Maugis",
            float(curve.load[worst] / force),
            float(curve.maugis[worst] / force),
            float(curve.error[worst]),
            allowed,
        ),
        relative("pull-off force", tension, force, allowed),
        Check("contact radius without load, relative", curve.contact[0], curve.maugis_contact[0], contact, 0.1),
    ]


@cache
def retraction(tabor: float, n: int) -> PullOff:
    """One computation for the tests, the table and the figure."""
    return pull_off(paper_sphere(tabor, n), 12, max(300, 9 * n // 4))


PULL_OFFS = ((0.05, 96), (0.1, 96), (0.3, 96), (1.0, 96), (2.0, 128))
PULL_OFFS_LONG = ((3.0, 256), (5.0, 512))


def pull_offs(cases: tuple[tuple[float, int], ...]) -> list[Check]:
    """From DMT to JKR, under the paper's law."""
    dmt, jkr = DMT(1.0, 1 / np.pi).pull_off_force, JKR(1.0, 1 / np.pi).pull_off_force
    checks = []
    for tabor, n in cases:
        found = retraction(tabor, n)
        worst = int(np.argmax(np.abs(found.error)))
        checks.append(
            Check(
                f"μ = {tabor:g}, n = {n}: load over the pull-off force, worst of {found.load.size}, against annuli",
                float(found.load[worst] / found.tension),
                float(found.annuli[worst] / found.tension),
                float(found.error[worst]),
                4e-3 if tabor < 5 else 6e-3,
            )
        )
        name = f"μ = {tabor:g}: pull-off force/(π w R), against"
        force, maugis = found.tension / found.unit, found.sphere.bent(-found.tension).pull_off_force / found.unit
        checks.append(relative(f"{name} Maugis", force, maugis, 0.06))
        if tabor <= 0.1:
            checks.append(relative(f"{name} DMT", force, dmt, 0.2 * tabor))
        if tabor >= 2:
            checks.append(relative(f"{name} JKR", force, jkr, 0.09 / tabor))
    return checks


@cache
def wave(wavelength: float, n: int, points: int = 14, alpha: float = 0.3) -> WaveCurve:
    """One computation for the tests, the table and the figure."""
    return wave_curve(alpha, wavelength, n, points)


def johnson(wavelength: float, n: int) -> list[Check]:
    """A wave with adhesion: partial contact between its jump to full contact and pull-off."""
    curve = wave(wavelength, n)
    # Before pull-off, where Johnson's stable branch ends.
    known = np.isfinite(curve.johnson) & (np.arange(curve.pressure.size) < np.argmin(curve.pressure) - 1)
    outer = float(np.mean((curve.attracted - curve.johnson)[known]))
    pushing = known & (curve.johnson_repulsive > 0)
    inner = float(np.max(np.abs(curve.repulsive - curve.johnson_repulsive)[pushing]))
    name = f"λ = {wavelength:g} a0, n = {n}"
    # The zone at the edge; the parabola through three states of the path.
    allowed = 5 / wavelength + 1e-3
    return [
        relative(f"pull-off pressure, {name}", curve.pull_off, curve.wave.pull_off_pressure, allowed),
        Check(
            f"edge of attraction beyond Johnson's edge, in a0, mean of {known.sum()}",
            outer,
            0.0,
            outer,
            6.0 + curve.spacing,
        ),
        Check(f"edge of repulsion from his, in a0, worst of {pushing.sum()}", inner, 0.0, inner, 3.0),
    ]


SPHERE_GRIDS, WAVE_GRIDS = (64, 128, 256, 512), (128, 256, 512, 1024, 2048)


@cache
def order(kind: str, grids: tuple[int, ...] | None = None) -> tuple[float, tuple[int, ...], Real]:
    """Observed order of loads with the grid, the grids, and differences from the finest over the largest load."""
    sizes = grids or (SPHERE_GRIDS if kind == "sphere" else WAVE_GRIDS)
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


IMAGES = "Images are accounted for up to (a/L)^5. "
COMPARISONS = (
    Comparison(
        "Hertz, hard wall",
        partial(hertz, 160),
        IMAGES + "The edge of contact is known to half a cell of 16, and the pressure there ends as a square root; of "
        "the integrals and in the middle that leaves some (1/16)² / 4.",
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
            + f"The tension ends over {edge:g} of its distance instead of at once, which the annuli know, not Maugis. "
            "The grid has few points in such an edge where μ is 1 and more. The core of the law yields half a per cent "
            "of the distance, 0.3 %/μ of the load. A contact ends where the gap is a quarter of the edge, which adds a "
            "tenth to its radius at μ = 0.1.",
            long,
        )
        for tabor, n, edge, long in (
            (1.0, 128, 0.2, False),
            (0.1, 256, 0.05, True),
            (0.3, 256, 0.05, True),
            (1.0, 256, 0.1, True),
            (2.0, 256, 0.4, True),
        )
    ),
    *(
        Comparison(
            f"Sphere, the paper's law, {towards}",
            partial(pull_offs, cases),
            IMAGES
            + "The annuli solve the same law without grid, transform or period; what is left is the grid, 3.6 a0 in a "
            "zone of 6 a0 at μ = 5. The law is no constant tension: at equal w and largest tension it holds up to 5 % "
            "more than Maugis' in between. Towards the limits it falls short of DMT's force by 0.2 μ (Maugis: 0.3 μ) "
            "and exceeds JKR's by 0.09/μ.",
            long,
        )
        for towards, cases, long in (("DMT to JKR", PULL_OFFS, False), ("towards JKR", PULL_OFFS_LONG, True))
    ),
    *(
        Comparison(
            f"Johnson's adhesive wave, α = 0.3, λ = {wavelength:g} a0",
            partial(johnson, wavelength, n),
            "JKR's edge stands for a zone of finite width, 0.8 w E*/σ² = 6 a0 with the paper's law, whatever the wave: "
            "the law attracts up to that far outside it, and the pull-off pressure differs by 5 a0/λ.",
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
