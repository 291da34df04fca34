"""Adhesive spheres and waves: the solver beside JKR, DMT, Maugis and Johnson.

Loads in E* = 1.  A sphere stands for its periodic images too: on a square lattice of period L, with a clamped mean,
those and the mean pressure N/L² raise the surface around the contact by::

    C1 N/(π E* L) - C3 (N r² + M)/(4π E* L³),    C1 = -4 ζ(1/2) β(1/2) = 3.90026,   C3 = 4 ζ(3/2) β(3/2) = 9.03362

up to (a/L)^5, with M = <p r²> A0 the second moment of the pressure (images are discs, not points).  Hence an
indentation of C1 N/(π E* L) - C3 M/(4π E* L³) - D and a curvature of 1/R + C3 N/(2π E* L³).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surfaces import sine, sphere
from continuum.model.walls import LennardJonesSpline, Wall
from continuum.model.walls.tabulated import TabulatedWall
from continuum.path.loading import follow, solve
from continuum.path.state import PathState
from continuum.solve.solution import Settings
from continuum.theory.smooth import DMT, JKR, MaugisDugdale
from tests.classical import AdhesiveWave
from tests.verification.axisymmetric import AxisymmetricSphere

__all__ = [
    "IMAGES_CURVATURE",
    "IMAGES_SHIFT",
    "PAPER_LAW",
    "PullOff",
    "Sphere",
    "SphereCurve",
    "WaveCurve",
    "dugdale_law",
    "dugdale_sphere",
    "images_shift",
    "paper_sphere",
    "pull_off",
    "sphere_loads",
    "wave_curve",
    "wave_pressures",
    "wave_problem",
]

IMAGES_SHIFT, IMAGES_CURVATURE = 3.9002649, 9.0336217
PAPER_LAW = LennardJonesSpline(float(np.sqrt(24 * 0.05)), core=0.3)
"""The strongest of the paper: l_a = 0.05 a0, range 1.095 a0, tension 0.081 E*.  Small spheres go deep into its core."""
TIGHT = Settings(1e-8)


def largest(x: Real, y: Real) -> float:
    """Largest y, by the parabola through it and its neighbours; as it is where the path jumps behind it."""
    i = int(np.argmax(y))
    if not 0 < i < y.size - 1:
        msg = "the largest value lies at an end of the path"
        raise ValueError(msg)
    if y[i + 1] < 0.8 * y[i]:
        return float(y[i])
    a, b, c = np.polyfit(x[i - 1 : i + 2] - x[i], y[i - 1 : i + 2], 2)
    return float(c - b**2 / (4 * a))


def images_shift(grid: Grid, traction: Real) -> float:
    """By how much the images of a contact in the middle of a square period raise the surface there."""
    x, y = grid.positions
    length = grid.lengths[0]
    r2 = (x - length / 2) ** 2 + (y - length / 2) ** 2
    load, moment = grid.integrate(traction), grid.integrate(traction * r2)
    return IMAGES_SHIFT * load / (np.pi * length) - IMAGES_CURVATURE * moment / (4 * np.pi * length**3)


# --- spheres -----------------------------------------------------------------------------------------------


def dugdale_law(work: float, distance: float, core: float, edge: float) -> TabulatedWall:
    """Nearly Maugis and Dugdale's law: a constant tension up to ``distance``, steps smooth over ``edge`` x distance.

    The core takes a pressure ``core`` per gap of -1, and its stiffness within 0.02 distance.
    """
    z = np.concatenate([distance * np.array([-100.0, -50.0, -20.0, -5.0]), distance * np.linspace(-1, 1.5, 2001)])

    def step(x: Real) -> Real:
        t = np.clip(x, 0, 1)
        return t * t * (3 - 2 * t)

    b = 0.02 * distance
    repulsion = np.where(z < -b, -core * (z + b / 2), core * np.minimum(z, 0) ** 2 / (2 * b))
    rise, fall = edge * distance / 2, edge * distance
    tension = step(z / rise) * (1 - step((z - distance + fall / 2) / fall))
    unit = np.trapezoid(tension, z)
    return TabulatedWall(z, np.append(repulsion[:-1] - work / unit * tension[:-1], 0.0))


@dataclass(frozen=True)
class Sphere:
    """A sphere under an adhesive wall, by its Tabor parameter with h0 = w/(largest tension)."""

    radius: float
    work: float
    distance: float
    wall: Wall
    grid: Grid

    @property
    def maugis(self) -> MaugisDugdale:
        """With the law's work and largest tension."""
        return MaugisDugdale(self.radius, self.work, self.distance)

    @property
    def period(self) -> float:
        """L."""
        return self.grid.lengths[0]

    def problem(self) -> ContactProblem:
        """On a half-space whose mean is clamped."""
        return ContactProblem(self.grid, self.wall, sphere(self.grid, self.radius), HalfSpace("clamped"))

    def load(self, state: PathState) -> float:
        """N."""
        return state.load * self.grid.area

    def indentation(self, state: PathState) -> float:
        """δ on an infinite half-space."""
        shift = images_shift(self.grid, self.wall.evaluate(state.gap).traction)
        return shift - (state.separation - self.wall.zero_gap)

    def separation(self, indentation: float, load: float) -> float:
        """D of given δ and N, to first order."""
        return self.wall.zero_gap + IMAGES_SHIFT * load / (np.pi * self.period) - indentation

    def profile(self, state: PathState) -> tuple[Real, Real]:
        """Radii, and the gap along x from the middle."""
        middle = self.grid.shape[0] // 2
        row = state.gap[middle:, middle]
        return np.arange(row.size) * self.grid.spacing[0], row

    def bent(self, load: float) -> MaugisDugdale:
        """The sphere of the curvature that the images leave."""
        curvature = 1 / self.radius + IMAGES_CURVATURE * load / (2 * np.pi * self.period**3)
        return MaugisDugdale(1 / curvature, self.work, self.distance)


def _size(radius: float, work: float, distance: float) -> float:
    """Length on which a sphere acts: its contact without load, or the gap's reach where that is larger."""
    jkr, dmt = JKR(radius, work).zero_load_radius, DMT(radius, work).contact_radius(0)
    return float(max(jkr, dmt, np.sqrt(2 * radius * distance)))


def _sphere(wall: Wall, tabor: float, n: int, periods: float) -> Sphere:
    work = wall.work_of_adhesion
    distance = work / wall.largest_tension
    radius = tabor**3 * distance**3 / work**2
    length = periods * _size(radius, work, distance)
    return Sphere(radius, work, distance, wall, Grid((n, n), (length, length)))


def paper_sphere(tabor: float, n: int, periods: float = 4.0) -> Sphere:
    """Under the paper's law."""
    return _sphere(PAPER_LAW, tabor, n, periods)


@dataclass(frozen=True)
class SphereCurve:
    """Equilibria along a retraction."""

    sphere: Sphere
    indentation: Real
    load: Real
    maugis: Real
    """Maugis' load at the same indentation and curvature."""
    annuli: Real
    """That of the axisymmetric solution of the same law."""
    contact: Real
    """Radius of the touching cells."""
    maugis_contact: Real

    @property
    def error(self) -> Real:
        """Difference of the loads over the pull-off force."""
        return (self.load - self.maugis) / self.sphere.maugis.pull_off_force


def dugdale_sphere(tabor: float, n: int, edge: float, points: int, periods: float = 4.0) -> SphereCurve:
    """From about zero load to half-way between pull-off and the last stable indentation, under :func:`dugdale_law`."""
    work, distance = 0.1, 1.0
    radius = tabor**3 * distance**3 / work**2
    # The core yields 1 % of the distance under the mean pressure of a contact of that size without adhesion.
    core = 200 * _size(radius, work, distance) / (radius * distance)
    wall = dugdale_law(work, distance, core, edge)
    made = _sphere(wall, tabor, n, periods)
    contacts = np.geomspace(0.02, 1.1, 60) * _size(made.radius, made.work, made.distance)
    states = [made.maugis.state(a) for a in contacts]
    reversal = int(np.argmin([s.indentation for s in states]))
    first = max(reversal + 1, int(np.searchsorted([s.load for s in states[reversal:]], 0.0)) + reversal)
    last = (states[reversal].indentation + made.maugis.state(made.maugis.pull_off_radius).indentation) / 2
    depths = np.linspace(states[min(first, 59)].indentation, last, points)
    targets = [made.separation(d, made.maugis.state(_at(made.maugis, d, contacts, reversal)).load) for d in depths]
    rows = []
    for state in follow(made.problem(), "separation", targets, TIGHT):
        state.solution.require()
        load, depth = made.load(state), made.indentation(state)
        bent = made.bent(load)
        exact = AxisymmetricSphere(bent.radius, wall, made.period / 2, 500)
        annuli = exact.load(exact.gap(depth, made.profile(state)))
        a = _at(bent, depth, contacts, reversal)
        # Half the height of the first step of the law is where a contact of Maugis' ends.
        touching = np.count_nonzero(state.gap < edge * distance / 4) * made.grid.cell_area
        rows.append((depth, load, bent.state(a).load, annuli, np.sqrt(touching / np.pi), a))
    return SphereCurve(made, *np.array(rows).T)


def _at(sphere: MaugisDugdale, indentation: float, contacts: Real, reversal: int) -> float:
    """Radius of contact at an indentation, on the branch that is stable at given indentation."""
    return float(brentq(lambda a: sphere.state(a).indentation - indentation, contacts[reversal], 2 * contacts[-1]))


@dataclass(frozen=True)
class PullOff:
    """A retraction beyond the largest tension, under any law."""

    sphere: Sphere
    tension: float
    """Largest, by the parabola through the largest three."""
    load: Real
    annuli: Real
    """Loads of the axisymmetric solution of the same law, at the same indentations and curvatures."""

    @property
    def unit(self) -> float:
        """π w R of the curvature that the images leave."""
        return float(np.pi * self.sphere.work * self.sphere.bent(-self.tension).radius)

    @property
    def error(self) -> Real:
        """Difference of the loads over the largest tension."""
        return (self.load - self.annuli) / self.tension


def pull_off(made: Sphere, points: int, annuli: int) -> PullOff:
    """In steps of the separation, from a load of about zero or less."""
    maugis, jkr = made.maugis, JKR(made.radius, made.work)
    at = maugis.state(maugis.pull_off_radius)
    middle = made.separation(at.indentation, at.load)
    reach = 1.2 * max(made.distance, jkr.separation_distance)
    targets = np.linspace(middle - reach, middle + 0.4 * reach, points)
    loads, theirs = [], []
    for state in follow(made.problem(), "separation", targets, TIGHT):
        state.solution.require()
        loads.append(made.load(state))
        exact = AxisymmetricSphere(made.bent(loads[-1]).radius, made.wall, made.period / 2, annuli)
        theirs.append(exact.load(exact.gap(made.indentation(state), made.profile(state))))
    return PullOff(made, largest(targets, -np.array(loads)), np.array(loads), np.array(theirs))


def sphere_loads(tabor: float, n: int) -> Real:
    """Loads of a sphere under the paper's law at five separations about its zero of load: for orders of convergence."""
    made = paper_sphere(tabor, n)
    scale = JKR(made.radius, made.work).separation_distance
    loads = []
    for depth in (0.6, 0.8, 1.0, 1.2, 1.4):
        state = solve(made.problem(), "separation", made.separation(depth * scale, 0.0), Settings(1e-10))
        state.solution.require()
        loads.append(made.load(state))
    return np.array(loads)


# --- waves -------------------------------------------------------------------------------------------------


def wave_problem(
    alpha: float, wavelength: float, n: int, wall: LennardJonesSpline
) -> tuple[AdhesiveWave, ContactProblem]:
    """A wave of Johnson's α along x, four points wide."""
    work = wall.work_of_adhesion
    wave = AdhesiveWave(float(np.sqrt(2 * wavelength * work) / (np.pi * alpha)), wavelength, work)
    grid = Grid((n, 4), (wavelength, 4 * wavelength / n))
    return wave, ContactProblem(grid, wall, sine(grid, wave.amplitude, (1, 0)), HalfSpace("clamped"))


def wave_pressures(n: int) -> Real:
    """Mean pressures of a wave of 256 a0 at five mean gaps: for orders of convergence."""
    wave, problem = wave_problem(0.3, 256.0, n, PAPER_LAW)
    pressures = []
    for part in (0.3, 0.5, 0.7, 0.9, 1.1):
        state = solve(problem, "mean-gap", 1 + part * wave.amplitude, Settings(1e-10))
        state.solution.require()
        pressures.append(state.load)
    return np.array(pressures)


@dataclass(frozen=True)
class WaveCurve:
    """Equilibria along a retraction from partial contact."""

    wave: AdhesiveWave
    spacing: float
    mean_gap: Real
    pressure: Real
    repulsive: Real
    """Half-width over which the wall repels."""
    attracted: Real
    """Half-width within its range."""
    johnson: Real
    """Johnson's half-width at the same mean pressure."""
    johnson_repulsive: Real
    """Half-width over which Johnson's pressure pushes: his contacts end in tension."""

    @property
    def pull_off(self) -> float:
        """Largest tension."""
        return largest(self.mean_gap, -self.pressure)


def wave_curve(alpha: float, wavelength: float, n: int, points: int) -> WaveCurve:
    """Under the paper's law, of finite range: Johnson's is its limit of long waves."""
    wave, problem = wave_problem(alpha, wavelength, n, PAPER_LAW)
    rows = []
    # Closer where it pulls off, as it may jump there.
    parts = np.concatenate([np.linspace(0.4, 1.1, points // 2), np.linspace(1.15, 1.5, points)])
    gaps = 1 + wave.amplitude * parts
    low, high = wave.pull_off_width, wave.snap_in_width
    for state in follow(problem, "mean-gap", gaps, TIGHT):
        state.solution.require()
        row, half = state.gap[:, 0], problem.grid.spacing[0] / 2
        widths = (np.count_nonzero(row < end) * half for end in (1.0, 1.0 + PAPER_LAW.range))
        p = state.load
        stable = -wave.pull_off_pressure < p < wave.mean_pressure(high)
        johnson = brentq(lambda a, p=p: wave.mean_pressure(a) - p, low, high) if stable else np.nan
        # His pressure vanishes where 2 (sin² ψ - sin² ψ_x) = α sqrt(tan ψ).
        psi = np.pi * johnson / wavelength
        sine2 = np.sin(psi) ** 2 - wave.alpha * np.sqrt(np.tan(psi)) / 2
        pushing = np.arcsin(np.sqrt(max(sine2, 0.0))) * wavelength / np.pi if stable else np.nan
        rows.append((state.mean_gap, p, *widths, johnson, pushing))
    return WaveCurve(wave, problem.grid.spacing[0], *np.array(rows).T)
