"""A contact from arrays, which is pressed to one state or along a path; states and paths show themselves."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self, SupportsIndex, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from continuum.inputs.arguments import (
    ArgumentError,
    field_of,
    file_name,
    function,
    hinted,
    hinted_class,
    instance,
    number,
    pair,
    several,
)
from continuum.measure import contact as contacts
from continuum.measure.contact import Adhesion, Curve, Equilibrium, Measurement, adhesion
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem, check_slope, doubts
from continuum.model.substrates import HalfSpace, Substrate
from continuum.model.surface import BEYOND, BEYOND_WHY, Moments, against
from continuum.model.walls import Wall
from continuum.path import loading, state
from continuum.path.equilibrium import solver_of
from continuum.path.gradient import Given, Number, gradient
from continuum.path.state import Event, PathState, Search, settled
from continuum.path.threshold import Threshold, core_stiffness, press_without_adhesion
from continuum.path.threshold_search import WallOfWork, bracket_threshold, first_work, laws_of
from continuum.show.page import with_picture
from continuum.solve.solution import NotConvergedError, Settings
from continuum.solve.stability import Stability
from continuum.store.runs.config import SolverTable
from continuum.store.runs.record import frame_of
from continuum.store.sheet import Column, Sheet, pairs
from continuum.store.vtk import save_contact

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


@hinted_class
@dataclass(frozen=True, eq=False)
class Contact:
    """A rigid rough wall above an elastic substrate.

    Parameters
    ----------
    heights : heights of the wall, shape (nx, ny), in a0; (1, n) for a line contact.
    wall : law between wall and surface.
    substrate : its elastic response.
    period : (Lx, Ly), in a0; one a0 from point to point if None.
    tolerance : largest root-mean-square residual traction, relative to h'rms E*, at most :data:`LOOSEST`.
    max_iterations : largest number of iterations for one equilibrium.
    area_tolerance : largest difference from a given repulsive area, relative to it, or beyond half contact to what is
        left of A0; half a point of the grid always counts as met.
    threads : threads of the solver; results do not depend on their number.
    device : device of the solver: "cpu", "cuda" (a GPU), or a library of arrays, as in ``[solver] device``.
    shards : devices over which "jax" divides the points.

    Raises ValueError if an argument is not allowed; warns if the grid does not resolve a length of the contact, or
    slopes are not small.

    Examples
    --------
    >>> import numpy as np, continuum as c
    >>> heights = c.SelfAffine(0.8, 0.1, 8, 32).synthesise(c.Grid.square(64), np.random.default_rng(1))
    >>> state = c.Contact(heights, wall=c.LennardJonesSpline(adhesion_length=0.005)).press(area=0.05)
    >>> round(state.area_rep, 2)
    0.05
    """

    heights: ArrayLike = field(repr=False)
    wall: Wall
    substrate: Substrate = field(default_factory=HalfSpace)
    period: tuple[float, float] | None = None
    tolerance: float = 1e-6
    max_iterations: int = 5000
    area_tolerance: float = 0.01
    threads: int = 1
    device: str = "cpu"
    shards: int = 1

    def __post_init__(self) -> None:
        _ = self._solver, Search(self.area_tolerance)  # which check their values
        allowed = "the law of a wall, as LennardJonesSpline(adhesion_length=0.005) or HardWall()"
        object.__setattr__(self, "wall", instance("wall", self.wall, Wall, allowed).build())
        if not callable(getattr(self.substrate, "stiffness", None)) or isinstance(self.substrate, type):
            allowed = 'an object with a method stiffness(grid), as HalfSpace() or Layer(10.0, 0.5, mean="clamped")'
            raise ArgumentError("substrate", self.substrate, allowed)
        slope = self.moments.rms_slope
        check_slope(slope)
        for message in doubts(self.problem, slope):
            warnings.warn(message, stacklevel=4)

    @cached_property
    def problem(self) -> ContactProblem:
        """The contact as the solver needs it."""
        heights = field_of("heights", self.heights)
        shape = (heights.shape[0], heights.shape[1])
        if shape[0] < 1 or shape[1] < 2:
            raise ArgumentError("heights", heights, "at least two points in each direction, or shape (1, n), a line")
        lengths = (float(shape[0]), float(shape[1]))
        if self.period is not None:
            along_x, along_y = (number("period", length, above=0) for length in pair("period", self.period))
            lengths = along_x, along_y
        return ContactProblem(Grid(shape, lengths), self.wall, heights, self.substrate)

    @property
    def grid(self) -> Grid:
        """The points of the surface."""
        return self.problem.grid

    @cached_property
    def moments(self) -> Moments:
        """Spectral moments of the heights."""
        return self.problem.moments

    @property
    def settings(self) -> Settings:
        """Settings of the solver, its tolerance in E*."""
        return self._solver.build(self.problem.traction_scale)

    @property
    def _solver(self) -> SolverTable:
        named = ("tolerance", "max_iterations", "threads", "device", "shards")
        return SolverTable(**{name: getattr(self, name) for name in named})

    @hinted
    def press(
        self,
        *,
        area: float | None = None,
        mean_gap: float | None = None,
        separation: float | None = None,
        pressure: float | None = None,
        start: State | ArrayLike | None = None,
    ) -> State:
        """The equilibrium at a given area, mean gap, separation or pressure.

        Check its status, or call :meth:`State.require`.

        Parameters
        ----------
        area : repulsive area, as a fraction of A0.
        mean_gap, separation : in a0.
        pressure : mean pressure, in E*, compression positive.
        start : state to start from (its imprint is kept if the wall yields), or its gap, shape (nx, ny), in a0; the
            undeformed surface if None.
        """
        control, name, goal = loading.controlled(area=area, mean_gap=mean_gap, separation=separation, pressure=pressure)
        problem, imprint, gap = self.problem, None, None
        if isinstance(start, State):
            known: list[PathState] = [start]
            problem = settled(problem, known)
            imprint, start = known[0].imprint_before, known[0].gap
        if start is not None:
            gap = field_of("start", start, self.grid.shape)
        goal, search = loading.target(name, goal), Search(self.area_tolerance)
        found = loading.solve(problem, control, goal, self.settings, gap, search=search)
        found = State(**vars(replace(found, imprint_before=imprint)), contact=self)
        state.warn_of([found], self.moments.rms_height)
        return found

    @hinted
    def path(
        self,
        *,
        area: Sequence[float] | None = None,
        mean_gap: Sequence[float] | None = None,
        separation: Sequence[float] | None = None,
        pressure: Sequence[float] | None = None,
        event_resolution: float | None = None,
        progress: Callable[[State], None] | None = None,
    ) -> LoadingPath:
        """Equilibria along a path, each started from the one before: approach and retraction.

        The gap of every state is kept in memory; :func:`continuum.run` stores them on disk.

        Parameters
        ----------
        area, mean_gap, separation, pressure : values of one of these, as fractions of A0, in a0 or in E*, in
            the order in which they are visited.
        event_resolution : width to which jumps are bracketed, in the unit of the control; None to leave them out.
            Without it, retraction in steps longer than a tenth of the range may lose contacts early.
        progress : called with each state as it is found.
        """
        control, name, goal = loading.controlled(area=area, mean_gap=mean_gap, separation=separation, pressure=pressure)
        targets = [loading.target(name, value) for value in several(name, goal)]
        search = Search(self.area_tolerance, event_resolution=event_resolution)
        function("progress", progress)
        states = []
        for found in loading.follow(self.problem, control, targets, self.settings, search=search):
            states.append(State(**vars(found), contact=self))
            if progress is not None:
                progress(states[-1])
        state.warn_of(states, self.moments.rms_height)
        return LoadingPath(self, tuple(states))

    def against(self, other: ArrayLike, *, shift: tuple[float, float] = (0.0, 0.0), angle: float = 0.0) -> Self:
        """The contact of this wall with another rough body, shifted and rotated; E* combines both bodies.

        With small slopes only the difference of the heights counts, and 1/E* is the sum of (1 - ν²)/E of both bodies.
        Results are those of the sum: the displacements of both bodies add up.

        Parameters
        ----------
        other : heights of the other body, shape (nx, ny), in a0, positive towards the wall.
        shift : shift of the other body, in a0, periodic; between points by Fourier interpolation.  It is refused where
            nothing is repeated, as what lies beyond the map is not known.
        angle : angle by which it is turned before the shift, in degrees: multiples of 90, which keep the period.

        Examples
        --------
        >>> import numpy as np, continuum as c
        >>> grid, rng = c.Grid.square(64), np.random.default_rng(1)
        >>> one, other = (c.SelfAffine(0.8, 0.1, 8, 32).synthesise(grid, rng) for _ in range(2))
        >>> contact = c.Contact(one, c.LennardJonesSpline(adhesion_length=0.005))
        >>> both = contact.against(other, shift=(3.5, 0), angle=90)
        >>> round(both.moments.rms_slope, 2)  # of independent surfaces the squares add up
        0.15
        """
        lower = field_of("other", other, self.grid.shape)
        if self.problem.open_boundary is not None and any(pair("shift", shift)):
            raise ArgumentError("shift", shift, f"{BEYOND}: {BEYOND_WHY}")
        return replace(self, heights=against(self.grid, self.problem.heights, lower, shift, angle))

    def find_threshold(self, wall: WallOfWork, *, area: float = 0.01, width: float = 0.02) -> FoundThreshold:
        """Search for the work of adhesion at which the load at an area changes its sign; above it the surface sticks.

        Parameters
        ----------
        wall : function that returns the law for a work of adhesion in E* a0; of the contact's own wall only the range
            is used, to begin the search.
        area : repulsive area at which the sign of the load is taken, as a fraction of A0; the paper takes 1 %.
        width : width of the bracket of works, relative to the threshold.

        Examples
        --------
        >>> import numpy as np, continuum as c
        >>> heights = c.SelfAffine(0.8, 0.1, 8, 32).synthesise(c.Grid.square(64), np.random.default_rng(1))
        >>> def wall(work):  # of a range of 0.4 a0
        ...     return c.attraction_on_core("spline", work, 0.4, core_stiffness=5.0)
        >>> found = c.Contact(heights, wall(0.01)).find_threshold(wall, area=0.05).require()
        >>> round(found.work, 4)
        0.0023
        """
        law_of, search = laws_of(wall, self.problem), Search(self.area_tolerance)
        number("area", area, above=0, below=1)
        number("width", width, above=0, below=1)
        problem, found = bracket_threshold(self.problem, law_of, area, self.settings, search, width)
        return FoundThreshold(State(**vars(found), contact=replace(self, wall=problem.wall)), wall)

    def threshold(self, wall: WallOfWork, *, area: float = 0.01) -> Threshold:
        """Estimate of this work from one state without adhesion, without a search.

        It lies between ``low`` and ``high`` where adhesion changes the contacts little: χ up to 0.2, ten patches or
        more.  docs/law.md states it, with the surfaces on which it was tested; elsewhere it has to be searched for,
        by :meth:`find_threshold`.

        Parameters
        ----------
        wall : wall of each work, as for :meth:`find_threshold`; of the contact's own wall nothing is used.
        area : repulsive area, as a fraction of A0.

        Examples
        --------
        >>> import numpy as np, continuum as c
        >>> from functools import partial
        >>> wall = partial(c.attraction_on_core, "spline", effective_range=0.4, core_stiffness=5.0)
        >>> heights = c.SelfAffine(0.8, 0.1, 8, 32).synthesise(c.Grid.square(64), np.random.default_rng(1))
        >>> found = c.Contact(heights, wall(0.01)).threshold(wall, area=0.05)
        >>> round(found.work, 4), found.patches
        (0.0023, 7)
        """
        law_of = laws_of(wall, self.problem)
        number("area", area, above=0, below=1)
        core = core_stiffness(law_of(first_work(replace(self.problem, wall=law_of(1e-3)))))
        search = Search(self.area_tolerance)
        return press_without_adhesion(self.problem, area, self.settings, core, search).threshold(law_of)


@dataclass(frozen=True, eq=False, kw_only=True)
class State(PathState):
    """One equilibrium of a contact, converged or not: its numbers, maps and figures.

    Examples
    --------
    >>> import continuum as c
    >>> contact = c.Contact(c.sine(c.Grid.square(32), 0.5, (1, 1)), c.HardWall())
    >>> state = contact.press(pressure=0.01).require()  # or an error that says why
    >>> round(state.load_rep, 6), state.gap.shape
    (0.01, (32, 32))
    """

    contact: Contact = field(repr=False)

    def __repr__(self) -> str:
        return (
            f"State({self.branch}, mean gap {self.mean_gap:.4g} a0, A_rep/A0 {self.area_rep:.4g}, "
            f"N/A0 {self.load:.4g} E*, {self._ended})"
        )

    _repr_html_ = with_picture

    @property
    def _ended(self) -> str:
        """End of the solve in words, and whether its area is that of few points."""
        few = self.converged and state.counts_few(self, self.contact.area_tolerance)
        return f"{self.status}, {state.NEAREST}" if few else self.status

    @property
    def imprint(self) -> Real:
        """Depth of the imprint left by this state and those before it, shape (nx, ny), in a0."""
        left = super().imprint
        return np.zeros(self.gap.shape) if left is None else left

    @property
    def residual(self) -> float:
        """Root-mean-square residual traction, over that which flattens the surface (h'rms E* on a half-space)."""
        return self.solution.residual / self.contact.problem.traction_scale

    @cached_property
    def duality_gap(self) -> float:
        """Bound on the error of the energy under a hard wall, relative to the elastic energy; NaN for other walls."""
        problem = self.contact.problem.dented(self.imprint_before)
        boundary = problem.open_boundary
        energy = problem.elastic_energy(self.gap) if boundary is None else boundary.elastic_energy(self.traction)
        return self.solution.duality_gap / energy if energy > 0 else float("nan")

    def stability(self) -> Stability:
        """Lowest eigenvalue of the Hessian, which is positive at a minimum; costs one or two hundred transforms.

        The mean displacement is held, as at a given mean gap; without periodic images the half-space far away, and the
        Hessian is that of displacements of the window, beside which the surface follows without traction.

        Raises TypeError under a hard wall, whose energy is convex, so that each equilibrium is the minimum.
        """
        problem = self.contact.problem
        if problem.wall.law is None:
            raise TypeError("under a hard wall the energy is convex: each equilibrium is the minimum")
        mean = np.inf if problem.open_boundary is None else None
        return solver_of(problem, self.contact.settings).stability(problem.wall.law, self.gap, mean)

    def gradient(self, number: Number, *, at: Given | None = None, wall: WallOfWork | None = None) -> Real:
        """Derivative of a quantity with respect to the height of every point, by one or two linear solves.

        Its product with a small change of the heights, summed over the points, is what the number changes by.

        Parameters
        ----------
        number : "load", per A0; "area", the repulsive area as a fraction of A0, the part of the lines of the grid along
            which the gap, linear from point to point, is below zero_gap, as a count of points has no derivative;
            "pull_off", the largest tension per A0, for which the path is followed from this state, best that of largest
            tension in a :class:`LoadingPath`, to the place where it is largest; "threshold", the work of adhesion at
            which the load vanishes at this area, in a state where it does.
        at : what is held, "mean_gap", "separation", "pressure" or "area"; None for the separation, if the state was
            pressed to one or nothing is repeated, and else the mean gap.  Not for a threshold, where area and load are
            held, nor for a pull-off, where it makes no difference.
        wall : for a threshold, function that returns the law for a work of adhesion, as for
            :meth:`Contact.find_threshold`.

        Returns
        -------
        Real
            Shape (nx, ny), in the unit of the number per a0.

        Raises ArgumentError where there is no such derivative: all but the load under a hard wall; what is held; a
        separation on a substrate of free mean displacement, a mean gap without periodic images.  Raises
        NotConvergedError if this is no equilibrium, or one that is about to jump.

        Examples
        --------
        >>> import numpy as np, continuum as c
        >>> heights = c.SelfAffine(0.8, 0.1, 8, 32).synthesise(c.Grid.square(64), np.random.default_rng(1))
        >>> wall = c.LennardJonesSpline(adhesion_length=0.005)
        >>> state = c.Contact(heights, wall).press(mean_gap=1.5)
        >>> gradient = state.gradient("load")
        >>> other = c.Contact(1.001 * heights, wall).press(mean_gap=1.5)
        >>> change = (gradient * 0.001 * heights).sum()
        >>> print(f"{(other.load - state.load) / change:.2f}")
        1.00
        """
        return gradient(self.contact.problem, self, self.contact.settings, number, at=at, wall_of=wall)

    @cached_property
    def contact_map(self) -> NDArray[np.uint8]:
        """2 repulsive, 1 attracted, 0 out of range, shape (nx, ny)."""
        return contacts.contact_map(self.contact.wall, self.gap)

    def measure(self) -> Measurement:
        """Measure κ, perimeter, mean diameter and the other numbers of the paper."""
        repulsive = self.contact_map == contacts.REPULSIVE
        return contacts.measure(self.contact.grid, self, repulsive, self.contact.moments.rms_slope)

    def sheet(self) -> Sheet:
        """Table of its numbers."""
        m = self.measure()
        rows: list[tuple[str, str]] = [
            ("mean gap", f"{self.mean_gap:.5g} a0"),
            ("separation", f"{self.separation:.5g} a0"),
            ("load N/A0", f"{self.load:.4g} E*"),
            ("repulsive area A_rep/A0", f"{self.area_rep:.4g}"),
            ("attracted area A_att/A0", f"{self.area_att:.4g}"),
            ("κ = h'rms E* A_rep/N", f"{m.kappa:.4g}"),
            ("mean diameter d_rep", f"{m.diameter:.4g} a0"),
            ("residual traction, of that which flattens the surface", f"{self.residual:.1e}"),
        ]
        if not np.isnan(self.duality_gap):
            rows.append(("duality gap, of the elastic energy", f"{self.duality_gap:.1e}"))
        rows.append(("status", self._ended))
        return pairs("Contact", rows)

    def save_vtk(self, path: str | Path) -> Path:
        """Write heights, gap, displacement and contact map as ``.vti`` for ParaView; returns the path.

        Lengths are in a0; also the traction, in E*, where it is known.  Raises OutputError if it cannot be written.
        """
        problem, traction = self.contact.problem, self.traction if np.isfinite(self.traction).all() else None
        shown = problem.heights, self.gap, self.separation, self.contact_map, traction
        return save_contact(file_name("path", path), problem.grid, *shown)

    def plot(self) -> Figure:
        """Draw the contact map."""
        from continuum.show.run_figures import map_figure

        return map_figure(self.contact_map, self.contact.grid.lengths, self.area_rep, self.load)


@dataclass(frozen=True, eq=False)
class LoadingPath(Sequence[State]):
    """Equilibria of a contact along a path, in their order.

    Examples
    --------
    >>> import continuum as c
    >>> wall = c.LennardJonesSpline(adhesion_length=0.01)
    >>> contact = c.Contact(c.sine(c.Grid.square(32), 0.5, (1, 1)), wall)
    >>> path = contact.path(mean_gap=[1.6, 1.4, 1.6, 2.0])
    >>> path.to_pandas()[["branch", "load"]].round(4)
            branch   load
    step
    0        start -0.009
    1     approach -0.005
    2      retract -0.009
    3      retract  0.000
    """

    contact: Contact = field(repr=False)
    states: tuple[State, ...] = field(repr=False)

    def __len__(self) -> int:
        return len(self.states)

    @overload
    def __getitem__(self, index: SupportsIndex) -> State: ...
    @overload
    def __getitem__(self, index: slice) -> LoadingPath: ...
    def __getitem__(self, index: SupportsIndex | slice) -> State | LoadingPath:
        """A state, or of a slice the path of these states."""
        return replace(self, states=self.states[index]) if isinstance(index, slice) else self.states[index]

    def __iter__(self) -> Iterator[State]:
        return iter(self.states)

    def __repr__(self) -> str:
        good = sum(one.converged for one in self)
        return f"LoadingPath({len(self)} states, {good} converged, pull-off tension {self.pull_off:.4g} E*)"

    _repr_html_ = with_picture

    @cached_property
    def adhesion(self) -> Adhesion:
        """Largest tension on both branches, work of separation, work lost in the cycle.

        Raises ValueError if no state converged.
        """
        return adhesion(Curve.of([one for one in self if one.converged]))

    @property
    def pull_off(self) -> float:
        """Largest tension on retraction, per A0, in E*; NaN if no state on retraction converged."""
        return self.adhesion.pull_off if any(one.converged for one in self) else float("nan")

    def sheet(self) -> Sheet:
        """One row for each state."""
        columns = (
            Column("branch"), Column("mean gap", "a0", ".5g"), Column("A_rep/A0"), Column("A_att/A0"),
            Column("N/A0", "E*", ".4e"), Column("status"),
        )  # fmt: skip
        one_branch = not self.contact.problem.wall.work_of_adhesion > 0
        points = [(s, one_branch or s.lowest is not None) for s in self]
        passed = state.not_looked_at(points, Search().event_threshold)
        few = [s.converged and state.counts_few(s, self.contact.area_tolerance) for s in self]
        rows = [
            (s.branch, s.mean_gap, s.area_rep, s.area_att, s.load,
             s.status.name.lower() + (f", {state.NOT_LOOKED}" if over else "") + (f", {state.NEAREST}" if one else ""))
            for s, over, one in zip(self, passed, few, strict=True)
        ]  # fmt: skip
        notes = [state.HYSTERESIS] * any(passed) + [state.FEW_POINTS] * any(few)
        return Sheet.of("Path", columns, rows, "; ".join(notes))

    def to_pandas(self) -> pandas.DataFrame:
        """One row for each state; ``attrs["units"]`` has the unit of each column."""
        return frame_of(self, Equilibrium)

    def plot(self) -> Figure:
        """Area and load along the path."""
        from continuum.show.run_figures import curve_figure

        return curve_figure(self, self.contact.moments.rms_slope)


@dataclass(frozen=True, eq=False)
class FoundThreshold:
    """The threshold of a contact, or the last bracket of the search for it."""

    state: State
    """State at the given area whose load is nearest to zero."""
    wall: WallOfWork = field(repr=False)
    """Law of each work of adhesion."""

    @property
    def bracket(self) -> Event | None:
        """States below and above the threshold, with their works as values; None if it was not found."""
        return self.state.threshold

    @property
    def work(self) -> float:
        """Work of adhesion at the threshold, in E* a0; NaN if it was not found.

        Within the bracket the load is taken as linear in the logarithm of the work.
        """
        return float("nan") if self.bracket is None else self.bracket.root

    @property
    def jumps(self) -> bool:
        """True if the load jumps over zero: the surface snaps, and no state has zero load."""
        return self.bracket is not None and self.bracket.kind == "jump-in"

    @property
    def converged(self) -> bool:
        """True if a bracket was found, with equilibria at both ends."""
        return self.state.converged

    @property
    def status(self) -> str:
        """End of the search, in words."""
        return self.state.status

    def require(self) -> FoundThreshold:
        """Return the threshold if it was found; else raise NotConvergedError with the reason."""
        self.state.require()
        return self

    def gradient(self) -> Real:
        """Derivative of the threshold with respect to the height of every point, shape (nx, ny), in E* a0 per a0.

        Positive where a greater height makes the surface less sticky.  See :meth:`State.gradient`.

        Raises NotConvergedError where the threshold was not found, or the load jumps over zero.
        """
        self.require()
        if self.jumps:
            raise NotConvergedError(
                "no gradient of the threshold: the load jumps over zero, and no state has zero load"
            )
        return self.state.gradient("threshold", wall=self.wall)

    def __repr__(self) -> str:
        return f"FoundThreshold(w {self.work:.4g} E* a0 at A_rep/A0 {self.state.area_rep:.4g}, {self.status})"

    def _repr_html_(self) -> str:
        return self.sheet()._repr_html_()

    def sheet(self) -> Sheet:
        """The bracket, with the loads at both ends."""
        rows = [("work of adhesion at the threshold", f"{self.work:.4g} E* a0")]
        if self.bracket is not None:
            for name, side in (("below", self.bracket.before), ("above", self.bracket.after)):
                rows.append((f"{name}: work", f"{side.value:.5g} E* a0"))
                rows.append((f"{name}: load N/A0 at A_rep/A0 {side.area_rep:.4g}", f"{side.load:.3e} E*"))
        found = self.state
        rows.append(("FFT pairs", f"{found.search_pairs + found.solution.fft_pairs:.0f}"))
        return pairs(
            "Threshold", [*rows, ("status", self.status + (", the load jumps over zero" if self.jumps else ""))]
        )
