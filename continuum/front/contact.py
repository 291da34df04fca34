"""A contact from arrays, which is pressed to one state or along a path."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

from numpy.typing import ArrayLike

from continuum.arguments import ArgumentError, choice, count, function, instance, number, pair, several
from continuum.arguments import field as map_of
from continuum.front.states import LoadingPath, State, Turn
from continuum.model.counterface import BEYOND, BEYOND_WHY, against
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.resolution import check_slope, doubts
from continuum.model.substrates import HalfSpace, Substrate
from continuum.model.surface import Moments
from continuum.model.walls import Wall
from continuum.path import loading
from continuum.path.state import Control, Search, settled
from continuum.path.threshold import Threshold, core_stiffness, press_without_adhesion
from continuum.path.turn import WallOfWork, find_turn, first_work
from continuum.solve.backend import BACK_ENDS
from continuum.solve.solution import LOOSEST, MOST_THREADS, Settings

_CONTROLS: dict[str, Control] = {
    "area": "repulsive-area",
    "mean_gap": "mean-gap",
    "separation": "separation",
    "pressure": "mean-pressure",
}

FARTHEST = 1e12
"""Larger gaps (in a0) or pressures (in E*) are refused: they would overflow in the energy."""


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

    Raises
    ------
    ValueError
        If an argument is not allowed.

    Warns
    -----
    UserWarning
        If the grid does not resolve a length of the contact, or slopes are not small.

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

    def __post_init__(self) -> None:
        number("tolerance", self.tolerance, above=0, most=LOOSEST)
        count("max_iterations", self.max_iterations)
        number("area_tolerance", self.area_tolerance, above=0, below=1)
        count("threads", self.threads, most=MOST_THREADS)
        choice("device", self.device, BACK_ENDS)
        allowed = "the law of a wall, as LennardJonesSpline(adhesion_length=0.005) or HardWall()"
        object.__setattr__(self, "wall", instance("wall", self.wall, Wall, allowed).build())
        if not callable(getattr(self.substrate, "stiffness", None)) or isinstance(self.substrate, type):
            allowed = 'an object with a method stiffness(grid), as HalfSpace() or Layer(10.0, 0.5, mean="clamped")'
            raise ArgumentError("substrate", self.substrate, allowed)
        slope = self.moments.rms_slope
        check_slope(slope)
        for message in doubts(self.problem, slope):
            warnings.warn(message, stacklevel=3)

    @cached_property
    def problem(self) -> ContactProblem:
        """The contact as the solver needs it."""
        heights = map_of("heights", self.heights)
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
        scale = self.problem.traction_scale
        return Settings(self.tolerance * scale, self.max_iterations, threads=self.threads, device=self.device)

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

        Parameters
        ----------
        area : repulsive area, as a fraction of A0.
        mean_gap, separation : in a0.
        pressure : mean pressure, in E*, compression positive.
        start : state to start from (its imprint is kept if the wall yields), or its gap, shape (nx, ny), in a0; the
            undeformed surface if None.

        Returns
        -------
        State
            Check its status, or call :meth:`State.require`.
        """
        name, given = _chosen(area=area, mean_gap=mean_gap, separation=separation, pressure=pressure)
        control, target = _CONTROLS[name], _target(name, given)
        problem, imprint, gap = self.problem, None, None
        if isinstance(start, State):
            before = [start.found]
            problem, imprint, start = settled(problem, before), before[0].imprint, before[0].gap
        if start is not None:
            gap = map_of("start", start, self.grid.shape)
        found = loading.solve(problem, control, target, self.settings, gap, search=Search(self.area_tolerance))
        return State(self, replace(found, imprint=imprint))

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
        area, mean_gap, separation, pressure : values of one of these, in the order in which they are visited.
        event_resolution : width to which jumps are bracketed, in units of the control; None to leave them out.
            Without it, retraction in steps longer than a tenth of the range may lose contacts early.
        progress : called with each state as it is found.
        """
        name, given = _chosen(area=area, mean_gap=mean_gap, separation=separation, pressure=pressure)
        control, targets = _CONTROLS[name], [_target(name, value) for value in several(name, given)]
        search = Search(self.area_tolerance, event_resolution=event_resolution)
        function("progress", progress)
        states = []
        for found in loading.follow(self.problem, control, targets, self.settings, search=search):
            states.append(State(self, found))
            if progress is not None:
                progress(states[-1])
        return LoadingPath(self, tuple(states))

    def against(self, other: ArrayLike, *, shift: tuple[float, float] = (0.0, 0.0), angle: float = 0.0) -> Self:
        """The contact of this wall with another rough body, shifted and turned; E* is that of both bodies.

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
        lower = map_of("other", other, self.grid.shape)
        if self.problem.open_boundary is not None and any(pair("shift", shift)):
            raise ArgumentError("shift", shift, f"{BEYOND}: {BEYOND_WHY}")
        return replace(self, heights=against(self.grid, self.problem.heights, lower, shift, angle))

    def turn(self, wall: WallOfWork, *, area: float = 0.01, width: float = 0.02) -> Turn:
        """The work of adhesion above which the surface is sticky: where the load at an area changes its sign.

        Parameters
        ----------
        wall : function that returns the law for a work of adhesion in E* a0; of the contact's own wall only the range
            is used, to begin the search.
        area : repulsive area at which the sign of the load is taken, as a fraction of A0; the paper takes 1 %.
        width : width of the bracket of works, relative to the turn.

        Examples
        --------
        >>> import numpy as np, continuum as c
        >>> heights = c.SelfAffine(0.8, 0.1, 8, 32).synthesise(c.Grid.square(64), np.random.default_rng(1))
        >>> def wall(work):  # of a range of 0.4 a0
        ...     return c.attraction_on_core("spline", work, 0.4, core_stiffness=5.0)
        >>> turn = c.Contact(heights, wall(0.01)).turn(wall, area=0.05).require()
        >>> round(turn.work, 4)
        0.0023
        """
        law_of = self._family(wall)
        number("area", area, above=0, below=1)
        number("width", width, above=0, below=1)
        search = Search(self.area_tolerance)
        problem, found = find_turn(self.problem, law_of, area, self.settings, search, width)
        return Turn(State(replace(self, wall=problem.wall), found), wall)

    def threshold(self, wall: WallOfWork, *, area: float = 0.01) -> Threshold:
        """The same work, estimated from one state without adhesion: a second, where a search takes a minute.

        It lies between ``low`` and ``high`` where adhesion changes the contacts little: χ up to 0.2, ten patches or
        more.  docs/law.md states it, with the surfaces on which it was tested; elsewhere it has to be searched for,
        by :meth:`turn`.

        Parameters
        ----------
        wall, area : as for :meth:`turn`; of the contact's own wall nothing is used.

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
        law_of = self._family(wall)
        number("area", area, above=0, below=1)
        core = core_stiffness(law_of(first_work(replace(self.problem, wall=law_of(1e-3)))))
        search = Search(self.area_tolerance)
        return press_without_adhesion(self.problem, area, self.settings, core, search).threshold(law_of)

    def _family(self, wall: WallOfWork) -> WallOfWork:
        """The laws of each work of adhesion, each looked at before it is used."""
        allowed = "a function that returns the law of a work of adhesion, as LennardJonesSpline(adhesion_length=w)"
        if not callable(wall):
            raise ArgumentError("wall", wall, allowed)
        if self.problem.open_boundary is not None:
            raise ArgumentError("substrate", self.substrate, "a periodic one: a threshold is that of a mean gap")

        def law_of(work: float) -> Wall:
            made = wall(work)
            if getattr(made, "law", None) is None:
                raise ArgumentError("wall", wall, allowed)
            return made

        return law_of


def _chosen(**given: Any) -> tuple[str, Any]:
    """Name and value of the one control that is given."""
    chosen = [name for name, value in given.items() if value is not None]
    if len(chosen) != 1:
        what = " and ".join(chosen) if chosen else "none"
        raise ValueError(f"give one of {', '.join(given)}; here: {what}")
    return chosen[0], given[chosen[0]]


def _target(name: str, value: Any) -> float:
    if name == "area":
        return number(name, value, above=0, below=1)
    return number(name, value, least=-FARTHEST, most=FARTHEST)
