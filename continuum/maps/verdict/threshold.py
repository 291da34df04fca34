"""The threshold of a map: the work of adhesion w_c above which its contact is sticky, from one state without adhesion.

The map is pressed on a core without attraction until 1 % of its area touches; that state tells w_c for every range of
attraction (:mod:`continuum.path.threshold`), without spectrum, fit or record.  Where that statement was tested the
interval is that of its two forms and what was measured beyond them; elsewhere it is wide, and a search for the
threshold (:mod:`continuum.maps.verdict.search`) is needed.  Where there is no map, as of a line scan, the law of the
spectrum (:func:`continuum.theory.rough.threshold_share`) and the energy of full contact are bounds.

Transforms of millions of points take seconds.  A map of more than :data:`LINEAR` points is pressed under a hard wall,
which tells w_DMT = N/<τ>; and once more on a coarser grid, which tells w_c/w_DMT.
"""

from __future__ import annotations

import enum
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from continuum.inputs import units
from continuum.inputs.arguments import instance
from continuum.maps.map import Topography
from continuum.maps.roughness import stencil_moments
from continuum.maps.verdict import on_grid
from continuum.maps.verdict.adhesion import MapCurve
from continuum.maps.verdict.criteria import AREA, RoughContact
from continuum.maps.verdict.extrapolation import ERRORS, Blocks, sampling_error
from continuum.maps.verdict.materials import Interface
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.surface import moments
from continuum.model.walls import HardWall, Wall
from continuum.path.adhesion_curve import press_series
from continuum.path.area import find_area
from continuum.path.equilibrium import equilibrium, solver_of
from continuum.path.state import PathState, Search
from continuum.path.threshold import PressedState, Threshold, on_core
from continuum.solve.solution import Settings
from continuum.theory.rough import generalised_tabor, threshold_share

FINEST, LINEAR = 2048**2, 512**2
"""Points that are pressed, and of which linear solves are made, at most: a pair of transforms takes .15 and .01 CPU s
there.  Of maps of 1024² and 2048² points with eight to the shortest wave, w_c/w_DMT was the same to half a per cent on
512² points."""
BEYOND, FEW_POINTS, BEYOND_FEW = 1.05, 400, 1.08
"""Factor by which the threshold may lie outside of both forms, and that where fewer points touch, as the edge of a
contact is known to a point: 95 % and more of the tested ones lie within them (docs/law.md)."""
LEAST_CHI, LARGEST_CHI, LARGEST_TABOR, FEWEST = -0.1, 0.2, 0.5, 10
"""χ between which, Müser's number up to which, and patches from which on, the statement was tested."""
FEW_PATCHES, LESS_SURE = 2, 1.15
"""Patches from which on, below :data:`FEWEST`, the threshold may lie outside of both forms by this factor; also where χ
is negative, as the attraction closes gaps."""
MOST_CHI, MOST_TABOR = 0.5, 1.6
"""χ and Müser's number beyond which nothing of the series is used."""
SCATTER, UNKNOWN = 1.3, 3.0
"""Factors by which the interval is widened where χ is above :data:`LARGEST_CHI`, twice the scatter of 1.14 that was
seen there, and where Müser's number is above :data:`LARGEST_TABOR` or one patch touches: there thresholds of few and of
soft contacts were off by up to 2."""
GAUSSIAN, ANY = (0.39, 2.2), (0.004, 11.0)
"""Threshold over that of the law of the spectrum at 1 % of the area, the least and the largest of single surfaces: of
Gaussian ones, and of worn, honed, lognormal, terraced and lapped ones, too (docs/measured/one-state.csv and
docs/measured/joined-spots.csv)."""
LAW_RANGES = 0.08, 1.6
"""Ranges over h_rms in which the law of the spectrum was tested."""
RANGES = tuple(float(one) for one in np.geomspace(1e-10, 3e-9, 15))
"""Effective ranges of the curve, in m."""
LONGER = 1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.08
"""Ranges over h_rms, of which the shortest that the state answers is a lower bound for shorter ones."""
NEARLY_LARGEST = 0.999
"""Quantile of the derivatives by each height over which they are shown."""
RESIDUAL, AREA_TOLERANCE = 1e-4, 0.03
"""Residual of a state relative to h' E*, and its area relative to 1 %: w_c moves by a few tenths of that."""
MOST_TOLERANCE = 0.3
"""Largest tolerance of the area of a small map, of which four points touch at a time; of a still smaller one too few
touch to tell anything."""


class Basis(enum.Enum):
    """Origin of a threshold."""

    STATE = "one state without adhesion"
    SEARCH = "search"
    BOUNDS = "bounds"


class RangePoint(NamedTuple):
    """The threshold under one effective range, in the units of the interface."""

    range: float
    work: float
    low: float
    high: float
    known: bool = True
    """True if the state answers it; else low and high are bounds."""


@dataclass(frozen=True, eq=False, kw_only=True)
class MapThreshold:
    """The work of adhesion above which the contact of a map is sticky, in the units of the interface.

    Gap, wall and grid are those of the state, empty for bounds.
    """

    gap: Real = field(repr=False)
    """Gap over ``grid``, in its unit."""
    wall: Wall = field(repr=False)
    grid: Grid = field(repr=False)
    """Grid of the map and its mirror images, in the unit of the solver."""
    map: Grid = field(repr=False)
    """Grid of the map itself, whose points are the first of ``grid`` in each direction; in units of the interface."""
    warnings: tuple[str, ...]
    work: float
    """w_c, the estimate."""
    low: float
    """Below it the surface is not sticky."""
    high: float
    """Above it the surface is sticky; between both it is undecided.  May be infinite."""
    source: Basis
    range: float
    """Effective range that it holds for."""
    why: tuple[str, ...] = ()
    """Reasons why the interval is wide; empty within the range of the statement, and of a search."""
    dmt: float = np.nan
    """w_DMT, where adhesion deforms nothing."""
    chi: float = np.nan
    """χ, the second order of w over the first."""
    muller: float = np.nan
    """Müser's number at w_c: how far adhesion deforms the summits."""
    patches: int = 0
    """Connected patches of the contact."""
    area_rep: float = np.nan
    """Repulsive area of the state, as a fraction of A0."""
    area_att: float = np.nan
    """Attracted area of the state."""
    mean_gap: float = np.nan
    """Mean gap at the threshold, in the unit of ``grid``."""
    jumps: bool = False
    """True if the load jumps over zero at the threshold, as the surface snaps; known to a search only."""
    solves: int = 0
    """Trial states of a search."""
    left_out: float = 0.0
    """Wavelength below which waves of the map are left out; 0 where none is."""
    curve: tuple[RangePoint, ...] = ()
    """The threshold against the range, from the same state."""
    state: PressedState | None = field(default=None, repr=False)
    """The state without adhesion, on at most :data:`LINEAR` points."""
    pressed: PressedMap | None = field(default=None, repr=False)
    """The map, of which :attr:`adhesion` is found when it is asked for; None where there are bounds only."""
    sampling: float = np.nan
    """Standard error of ln w_c, as of another spot of the surface; NaN where it is not known
    (:mod:`continuum.maps.verdict.extrapolation`)."""

    @property
    def adhesion(self) -> MapCurve | None:
        """Load, area and gap under adhesion, from several states without it; None where there are bounds only."""
        return None if self.pressed is None else self.pressed.adhesion

    def of_map(self, values: Real) -> Real:
        """Values on the points of the map itself, without its mirror images."""
        images = [round(whole / own) for whole, own in zip(self.grid.shape, self.map.shape, strict=True)]
        return values[: values.shape[0] // images[0], : values.shape[1] // images[1]]

    @property
    def distance(self) -> Real:
        """Gap beyond that of zero traction, on the map, in the unit of ``grid``."""
        return self.of_map(self.gap - self.wall.zero_gap)

    @property
    def kinds(self) -> Real:
        """2 where the surfaces repel, 1 where they attract, 0 elsewhere, on the map."""
        return np.where(self.distance <= 0, 2.0, np.where(self.distance < self.wall.range, 1.0, 0.0))

    def deciding(self, state: PressedState, decades: float) -> Real:
        """Logarithm of how much each height of the map changes the threshold, in so many decades.

        It is over :data:`NEARLY_LARGEST`: at the edge of a contact single points can have a derivative tens of times
        as large as any other, by chance of where the edge crosses their pixel.
        """
        deciding = np.abs(self.of_map(state.deciding_heights(self.wall)))
        over = deciding / (np.quantile(deciding, NEARLY_LARGEST) or deciding.max())
        return np.asarray(np.log10(np.clip(over, 10**-decades, 1.0)))

    def sticky(self, work: float) -> bool | None:
        """True if a work of adhesion is sticky; None where that is undecided."""
        return True if work > self.high else False if work < self.low else None

    @property
    def of_surface(self) -> tuple[float, float]:
        """The interval of the surface from which the map was cut: of two sampling errors and of the map's; else NaN."""
        if np.isnan(self.sampling):
            return np.nan, np.nan
        ends = np.log(self.low / self.work), np.log(self.high / self.work)
        low, high = (float(self.work * np.exp(np.copysign(np.hypot(end, ERRORS * self.sampling), end))) for end in ends)
        return low, high

    def surface_sticky(self, work: float) -> bool | None:
        """True if a work of adhesion is sticky on the whole surface; None where that is undecided."""
        low, high = self.of_surface
        return True if work > high else False if work < low else None


class _Interval(NamedTuple):
    """A threshold in l_a, with its interval."""

    work: float
    low: float
    high: float
    why: tuple[str, ...]
    """Reasons why the interval is wide."""
    known: bool = True
    """True if it is that of the state; else low and high are bounds."""


def by_law(energy: float, height: float, reach: float, shares: tuple[float, float]) -> tuple[float, float, float]:
    """Estimate and bounds of w_c by the spectrum alone, in the unit of the energy of full contact.

    They are :data:`GAUSSIAN` or :data:`ANY` shares of the law of the spectrum where its range was tested.  Elsewhere
    the energy of full contact is the upper one if it is larger, and there is no lower one.
    """
    work = energy * threshold_share(reach / height)
    if LAW_RANGES[0] <= reach / height <= LAW_RANGES[1]:
        return work, shares[0] * work, shares[1] * work
    return work, 0.0, max(energy, shares[1] * work)


def bounds(contact: RoughContact, why: str) -> MapThreshold:
    """Bounds of the threshold where there is no map, or none that can be pressed: a spectrum says no heights."""
    work, low, high = np.nan, 0.0, np.inf
    if contact.conformal_energy is not None:
        work, low, high = by_law(contact.conformal_energy, contact.rms_height, contact.range, ANY)
    none, nothing = Grid.square(2), np.zeros((2, 2))
    wall = on_grid.wall_on(none, contact.adhesion_length, contact.range)
    return MapThreshold(
        work=work, low=low, high=high, source=Basis.BOUNDS, range=contact.range, why=(why,),
        gap=nothing, wall=wall, grid=none, map=none, warnings=(),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class PressedMap:
    """A map that is pressed without adhesion up to 1 % of its area; lengths in units of the pixel of its grid."""

    topography: Topography
    interface: Interface
    threads: int = 1

    @cached_property
    def unit(self) -> float:
        """The unit of length, in that of the map: its pixel."""
        return max(self.topography.grid.spacing)

    @cached_property
    def problem(self) -> ContactProblem:
        """The contact on at most :data:`FINEST` points."""
        return self._on(*on_grid.wall_of_map(self.topography, self.unit, FINEST))

    def _on(self, grid: Grid, heights: Real) -> ContactProblem:
        return ContactProblem(grid, HardWall(), heights, self.interface.substrate(self.unit))

    @cached_property
    def slope(self) -> float:
        """Root mean square slope of what is pressed."""
        return moments(self.problem.grid, self.problem.heights).rms_slope

    @property
    def left_out(self) -> float:
        """Wavelength below which waves are left out as the map is coarsened, in the unit of the map; 0 if it is not."""
        pixel = max(self.problem.grid.spacing) * self.unit
        return 2 * pixel if pixel > 1.01 * self.unit else 0.0

    @cached_property
    def hard(self) -> PathState:
        """The state under a hard wall."""
        return self._pressed(self.problem)

    @property
    def search(self) -> Search:
        """Tolerance of the area: four points touch at a time on a map that is continued by its mirror images."""
        together = 1 if self.topography.periodic else 4
        return Search(min(max(AREA_TOLERANCE, 0.5 * together / (AREA * self.problem.grid.size)), MOST_TOLERANCE))

    def _pressed(self, problem: ContactProblem) -> PathState:
        settings = Settings(RESIDUAL * self.slope, threads=self.threads)
        return find_area(problem, AREA, settings, self.search, (), "start", solver_of(problem, settings)).require()

    @cached_property
    def linear(self) -> _Level:
        """The state on at most :data:`LINEAR` points, from which w_c/w_DMT is known."""
        if self.problem.grid.size <= LINEAR:
            return _Level(self.problem, self.hard)
        grid = self.problem.grid
        coarse = on_grid.at_most(grid, LINEAR)
        problem = self._on(coarse, on_grid.waves_on(coarse, grid, self.problem.heights))
        return _Level(problem, self._pressed(problem))

    def _more(self, reach: float) -> float:
        """w_DMT at a range over that of :attr:`linear`."""
        if self.linear.hard is self.hard:
            return 1.0
        return _dmt(self.hard, self.linear.wall(reach)) / _dmt(self.linear.hard, self.linear.wall(reach))

    def threshold(self) -> MapThreshold:
        """The threshold for the range of the interface, and its curve over :data:`RANGES`."""
        reach, linear = self.interface.range / self.unit, self.linear
        finer = linear.hard is not self.hard
        scale, wall = self.unit * self.interface.contact_modulus, linear.wall(reach)
        found, one, distance = linear.at(reach), self._interval(reach), linear.state.distance
        mean_gap = self.hard.mean_gap + float(distance.mean()) - linear.hard.mean_gap
        grid = self.problem.grid
        return MapThreshold(
            work=one.work * scale, low=one.low * scale, high=one.high * scale,
            source=Basis.STATE if one.known else Basis.BOUNDS,
            range=self.interface.range, why=one.why,
            dmt=self._more(reach) * found.dmt * scale if one.known else np.nan, chi=found.chi if one.known else np.nan,
            muller=self._tabor(one.work, reach), patches=self._own(found.patches), area_rep=found.area_rep,
            area_att=float(np.mean(distance < wall.range)) - found.area_rep,
            mean_gap=mean_gap + wall.zero_gap + (one.work * found.withdrawal if one.known else 0.0),
            curve=tuple(self._curve(one, scale)),
            left_out=self.left_out,
            gap=(self.hard.gap if finer else distance) + wall.zero_gap, wall=wall, grid=grid,
            map=self._own_points(grid), warnings=tuple(self._doubts(one.work)), state=linear.state,
            pressed=self if one.known else None,
        )  # fmt: skip

    def sampling_error(self, roll_off: float) -> float:
        """Standard error of ln w_c for the surface with this roll-off, as of another spot; NaN if the map is too small.

        Of the range of the interface; the roll-off is in the unit of the map.
        """
        linear, blocks = self.linear, Blocks.of(self.topography.lengths, roll_off)
        if not blocks.enough:
            return np.nan
        own = self._own_points(linear.problem.grid).shape
        wall = linear.wall(self.interface.range / self.unit)
        return sampling_error(linear.state, self.beside, wall, own, blocks)

    @cached_property
    def adhesion(self) -> MapCurve:
        """The adhesion curve for the range of the interface, from states on at most :data:`LINEAR` points.

        If the map is pressed on more, loads and works are those of its own state at 1 % of the area.
        """
        linear, reach = self.linear, self.interface.range / self.unit
        settings = Settings(RESIDUAL * self.slope, threads=self.threads)
        states = press_series(linear.problem, linear.hard, settings, linear.core_stiffness)
        modulus = self.interface.contact_modulus
        return MapCurve(
            states.curve(linear.wall(reach)), modulus * self.hard.load / linear.hard.load,
            self._more(reach) * modulus * self.unit, self.unit, 1 if self.topography.periodic else 4,
            states, linear.wall(reach),
        )  # fmt: skip

    @cached_property
    def beside(self) -> PressedState:
        """The state at half the load, on at most :data:`LINEAR` points."""
        problem, hard = self.linear.problem, self.linear.hard
        settings = Settings(RESIDUAL * self.slope, threads=self.threads)
        solver = solver_of(problem, settings)
        half = equilibrium(problem, "mean-pressure", 0.5 * hard.load, settings, hard.gap, "approach", solver)
        return on_core(problem, half.require(), self.linear.core_stiffness)

    def _own_points(self, grid: Grid) -> Grid:
        """The points of the map itself among those of a grid, in units of the interface."""
        images = 1 if self.topography.periodic else 2
        return Grid((grid.shape[0] // images, grid.shape[1] // images), self.topography.lengths)

    def _own(self, count: int) -> int:
        """Number of patches or points that belong to the map itself, of those on the grid."""
        return count if self.topography.periodic else count // 4

    def _tabor(self, work: float, reach: float) -> float:
        return generalised_tabor(self._curvature, work, reach) if work > 0 else np.nan

    @cached_property
    def _curvature(self) -> float:
        """H'' of the map, from neighbouring points: mirror images would add their kinks."""
        own = self.topography
        return stencil_moments(own.grid, own.heights, own.periodic).rms_curvature * self.unit

    @cached_property
    def rms_height(self) -> float:
        """Root mean square height of what is pressed."""
        return float(self.problem.heights.std())

    @cached_property
    def energy(self) -> float:
        """Elastic energy of full contact, in E* times the unit of length."""
        return self.problem.elastic_energy(np.zeros(self.problem.grid.shape))

    def _interval(self, reach: float) -> _Interval:
        """The threshold and its interval at a range."""
        found = self._by_state(reach)
        return found if found.known else self._bounds(reach, found.why)

    def _by_state(self, reach: float) -> _Interval:
        """The threshold and its interval by the series of the state, where that holds."""
        found, more = self.linear.at(reach), self._more(reach)
        chi, patches = found.chi, self._own(found.patches)
        # Beyond the tested χ, where the two forms are far apart, the third order is taken as half of the root's.
        small = chi <= LARGEST_CHI
        work = more * (found.work if small else found.low / (1 + chi) * (1 + chi + chi**2))
        if without := tuple(self._without(work, chi, reach)):
            return _Interval(np.nan, np.nan, np.nan, without, known=False)
        low, high = more * found.low, more * found.high
        wide, why = self._width(chi, patches, self._tabor(work, reach))
        if not small:
            low, high = min(more * found.dmt, work), work
        elif not why:
            points = self._own(round(found.area_rep * self.linear.problem.grid.size))
            wide = BEYOND if points >= FEW_POINTS else BEYOND_FEW
        return _Interval(work, low / wide, high * wide, why)

    def _without(self, work: float, chi: float, reach: float) -> Iterator[str]:
        """Reason why the series says nothing here."""
        if not work > 0:
            yield "this range of attraction is beyond first orders"
        elif not LEAST_CHI <= chi <= MOST_CHI:
            yield "adhesion changes the gaps by too much"
        elif not self._tabor(work, reach) <= MOST_TABOR:
            yield "adhesion deforms the summits"
        if work > 0 and reach < on_grid.shortest_range(self.topography, work * self.unit) / self.unit / np.sqrt(2):
            yield "the pixels do not resolve the range of the attraction"

    @staticmethod
    def _width(chi: float, patches: int, tabor: float) -> tuple[float, tuple[str, ...]]:
        """Factor beyond both forms outside the tested range, and why; 1 within it."""
        reasons = []
        if chi > LARGEST_CHI:
            reasons.append((SCATTER, "adhesion changes the gaps by more than a little"))
        if chi < 0:
            reasons.append((LESS_SURE, "adhesion closes gaps"))
        if patches < FEWEST:
            few = LESS_SURE if patches >= FEW_PATCHES else UNKNOWN
            reasons.append((few, f"{patches} patch{'es touch' if patches != 1 else ' touches'}, fewer than {FEWEST}"))
        if tabor > LARGEST_TABOR:
            reasons.append((UNKNOWN, "adhesion deforms the summits"))
        return max((wide for wide, _ in reasons), default=1.0), tuple(why for _, why in reasons)

    @cached_property
    def _longer(self) -> tuple[float, _Interval] | None:
        """The shortest range of :data:`LONGER` that the state answers, and its threshold; None where there is none."""
        found = None
        for ratio in LONGER:
            one = self._by_state(ratio * self.rms_height)
            if not one.known:
                break
            found = ratio * self.rms_height, one
        return found

    def _bounds(self, reach: float, why: tuple[str, ...]) -> _Interval:
        """Bounds by the law of the spectrum, and by a longer range, as the threshold falls with the range.

        A surface is taken as Gaussian where that law holds for it at the longer range.
        """
        law = self.energy * threshold_share(reach / self.rms_height)
        longer = self._longer if self._longer is not None and self._longer[0] > reach else None
        share = np.nan
        if longer is not None:
            share = longer[1].work / (self.energy * threshold_share(longer[0] / self.rms_height))
        gaussian = GAUSSIAN[0] <= share <= GAUSSIAN[1]
        _, low, high = by_law(self.energy, self.rms_height, reach, GAUSSIAN if gaussian else ANY)
        work = law * share if np.isfinite(share) else law
        if longer is not None:
            low = max(low, longer[1].low)
        return _Interval(min(max(work, low), high), low, high, why, known=False)

    def _curve(self, here: _Interval, scale: float) -> Iterator[RangePoint]:
        """The curve over :data:`RANGES`, and the range of the interface, whose interval is known."""
        given = self.interface.range
        for reach in sorted({given, *(one for one in RANGES if not np.isclose(one, given, atol=0.0))}):
            found = here if reach == given else self._interval(reach / self.unit)
            yield RangePoint(reach, found.work * scale, found.low * scale, found.high * scale, found.known)

    def _doubts(self, work: float) -> Iterator[str]:
        """Remarks about the state."""
        if self.left_out:
            yield (
                f"pressed on {' x '.join(map(str, self.problem.grid.shape))} points: waves below "
                f"{units.readable(self.left_out, 'length', 3)} are left out"
            )
        if self.linear.hard is not self.hard:
            shape = " x ".join(map(str, self.linear.problem.grid.shape))
            yield f"w_c over w_DMT, where adhesion deforms nothing, is that of the map on {shape} points"
        law = replace(self.problem, wall=self.linear.wall(self.interface.range / self.unit, work))
        yield from on_grid.solver_doubts(law, self.slope, self.topography, self.unit)


def _dmt(hard: PathState, wall: Wall) -> float:
    """w_DMT = N/<τ> of a state under a hard wall."""
    gap = hard.gap[(hard.gap > 0) & (hard.gap < 2 * wall.range)]
    pull = -wall.evaluate(wall.zero_gap + gap).traction.sum() / wall.work_of_adhesion / hard.gap.size
    return float(hard.load / pull) if pull > 0 else np.nan


@dataclass(frozen=True, eq=False)
class _Level:
    """A contact on a grid, and its state under a hard wall."""

    problem: ContactProblem
    hard: PathState
    known: dict[float, Threshold] = field(default_factory=dict, repr=False)
    """Thresholds by their range."""

    @property
    def core_stiffness(self) -> float:
        """Stiffness of the core, in E* over the unit of length."""
        return on_grid.CORE_STIFFNESS / max(self.problem.grid.spacing)

    @cached_property
    def state(self) -> PressedState:
        """The state on the core."""
        return on_core(self.problem, self.hard, self.core_stiffness)

    def wall(self, reach: float, work: float = 1e-6) -> Wall:
        """The law of a range; its shape does not depend on its work while its core is the stiffer."""
        return on_grid.wall_on(self.problem.grid, work, reach)

    def at(self, reach: float) -> Threshold:
        """The threshold at a range, unknown where that is below the error of the gap: rounding would decide it."""
        if reach not in self.known and reach <= self.hard.solution.gap_error:
            state = self.state
            self.known[reach] = Threshold(np.nan, np.nan, np.nan, np.nan, state.area_rep, state.patches, np.nan)
        if reach not in self.known:
            self.known[reach] = self.state.threshold(lambda work: self.wall(reach, work))
        return self.known[reach]


def press_map(topography: Topography, interface: Interface, threads: int = 1) -> PressedMap:
    """A map that is to be pressed."""
    instance("interface", interface, Interface)
    return PressedMap(instance("topography", topography, Topography), interface, threads)
