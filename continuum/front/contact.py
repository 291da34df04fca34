"""A contact of your own, pressed: its states, and paths of them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from continuum.arguments import count, number
from continuum.arguments import field as map_of
from continuum.measure import contact as contacts
from continuum.measure.contact import Measurement
from continuum.measure.curve import Adhesion, Curve, adhesion
from continuum.model.grid import Grid, Real
from continuum.model.problem import ContactProblem
from continuum.model.resolution import check_slope, steep
from continuum.model.substrates import HalfSpace, Substrate
from continuum.model.surface import Moments, moments
from continuum.model.walls import Wall
from continuum.path import loading, state
from continuum.path.state import Control, Search
from continuum.show.sheet import Column, Sheet, pairs
from continuum.solve.solution import Settings
from continuum.solve.stability import Stability, stability

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Contact", "Path", "State"]

_CONTROLS: dict[str, Control] = {
    "area": "repulsive-area",
    "mean_gap": "mean-gap",
    "separation": "separation",
    "pressure": "mean-pressure",
}


@dataclass(frozen=True, eq=False)
class Contact:
    """A rigid rough wall above an elastic substrate, to be pressed.

    Parameters
    ----------
    heights : of the wall, shape (nx, ny), in a0.
    wall : law between wall and surface.
    substrate : its elastic response.
    period : (Lx, Ly), in a0; one a0 from point to point if None.
    tolerance : largest root-mean-square residual traction, relative to h'rms E*.
    max_iterations : of one equilibrium.

    Raises
    ------
    ValueError
        If the heights are no map of finite numbers with a slope.

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

    def __post_init__(self) -> None:
        """Refuse what cannot be pressed."""
        number("tolerance", self.tolerance, above=0, below=1)
        count("max_iterations", self.max_iterations)
        check_slope(self.moments.rms_slope)
        for message in steep(self.moments.rms_slope):
            warnings.warn(message, stacklevel=3)

    @cached_property
    def problem(self) -> ContactProblem:
        """The contact as the solver takes it."""
        heights = map_of("heights", self.heights)
        shape = (heights.shape[0], heights.shape[1])
        return ContactProblem(
            Grid(shape, self.period or (float(shape[0]), float(shape[1]))), self.wall, heights, self.substrate
        )

    @property
    def grid(self) -> Grid:
        """The points of the surface."""
        return self.problem.grid

    @cached_property
    def moments(self) -> Moments:
        """Spectral moments of the heights."""
        return moments(self.grid, self.problem.heights)

    @property
    def settings(self) -> Settings:
        """Of the solver."""
        return Settings(self.tolerance * self.moments.rms_slope, self.max_iterations)

    def press(
        self,
        *,
        area: float | None = None,
        mean_gap: float | None = None,
        separation: float | None = None,
        pressure: float | None = None,
        start: State | None = None,
    ) -> State:
        """The equilibrium at one of these.

        Parameters
        ----------
        area : repulsive area, as a fraction of A0.
        mean_gap, separation : in a0.
        pressure : mean pressure, in E*, compression positive.
        start : state to start from, whose basin is kept to; the undeformed surface if None.

        Returns
        -------
        State
            Look at its status, or ask :meth:`State.require`.
        """
        control, target = _chosen(area=area, mean_gap=mean_gap, separation=separation, pressure=pressure)
        gap = None if start is None else start.gap
        return State(self, loading.solve(self.problem, control, target, self.settings, gap))

    def path(
        self,
        *,
        area: Sequence[float] | None = None,
        mean_gap: Sequence[float] | None = None,
        separation: Sequence[float] | None = None,
        pressure: Sequence[float] | None = None,
        event_resolution: float | None = None,
        progress: Callable[[State], None] | None = None,
    ) -> Path:
        """Equilibria one after the other, each started from the one before: approach, and the way back.

        Keeps the gap of every state; :func:`continuum.run` keeps them on disk.

        Parameters
        ----------
        area, mean_gap, separation, pressure : values of one of these, in the order in which they are visited.
        event_resolution : width down to which jumps are bracketed, in units of what is given; None not to.
        progress : called with each state as it is found.
        """
        control, targets = _chosen(area=area, mean_gap=mean_gap, separation=separation, pressure=pressure)
        search = Search(event_resolution=event_resolution)
        states = []
        for found in loading.follow(self.problem, control, targets, self.settings, search=search):
            states.append(State(self, found))
            if progress is not None:
                progress(states[-1])
        return Path(self, tuple(states))


def _chosen(**given: Any) -> tuple[Control, Any]:
    """The one control that is given."""
    chosen = [name for name, value in given.items() if value is not None]
    if len(chosen) != 1:
        what = " and ".join(chosen) if chosen else "none"
        msg = f"give one of {', '.join(given)}; here: {what}"
        raise ValueError(msg)
    return _CONTROLS[chosen[0]], given[chosen[0]]


@dataclass(frozen=True, eq=False)
class State:
    """One equilibrium of a contact, converged or not."""

    contact: Contact = field(repr=False)
    found: state.State = field(repr=False)

    def __repr__(self) -> str:
        return (
            f"State({self.found.branch}, mean gap {self.mean_gap:.4g} a0, A_rep/A0 {self.area_rep:.4g}, "
            f"N/A0 {self.load:.4g} E*, {self.status})"
        )

    def _repr_html_(self) -> str:
        return _with_picture(self)

    @property
    def gap(self) -> Real:
        """Height of the wall above the deformed surface, shape (nx, ny), in a0."""
        return self.found.gap

    @property
    def traction(self) -> Real:
        """Of the wall on the surface, compression positive, shape (nx, ny), in E*."""
        return self.found.traction

    @property
    def area_rep(self) -> float:
        """Repulsive area, as a fraction of A0."""
        return self.found.totals.area_rep

    @property
    def area_att(self) -> float:
        """Attracted area, as a fraction of A0."""
        return self.found.totals.area_att

    @property
    def load(self) -> float:
        """Per A0, in E*, compression positive."""
        return self.found.load

    @property
    def mean_gap(self) -> float:
        """In a0."""
        return self.found.mean_gap

    @property
    def separation(self) -> float:
        """In a0; NaN where the mean displacement of the substrate is free."""
        return self.found.separation

    @property
    def branch(self) -> str:
        """Direction from which it was reached: start, approach or retract."""
        return self.found.branch

    @property
    def converged(self) -> bool:
        """Whether it is an equilibrium at its target."""
        return self.found.status.ok

    @property
    def status(self) -> str:
        """How the solve or the search ended, in words."""
        return str(self.found.status.value)

    def require(self) -> State:
        """The state itself, if it is an equilibrium at its target.

        Raises
        ------
        NotConvergedError
            Otherwise, with the reason.
        """
        self.found.require()
        return self

    def stability(self) -> Stability:
        """Whether it is a minimum: the lowest eigenvalue of its Hessian, by a hundred transforms or two.

        The displacement of the mean is held, as at a given mean gap.

        Raises
        ------
        TypeError
            Under a hard wall, whose energy is convex: there each equilibrium is the minimum.
        """
        problem = self.contact.problem
        if problem.wall.law is None:
            msg = "under a hard wall the energy is convex: each equilibrium is the minimum"
            raise TypeError(msg)
        return stability(problem.grid, problem.stiffness_q, problem.wall.law, self.gap, np.inf)

    @cached_property
    def contact_map(self) -> NDArray[np.uint8]:
        """2 repulsive, 1 attracted, 0 out of range, shape (nx, ny)."""
        return contacts.contact_map(self.contact.wall, self.gap)

    def measure(self) -> Measurement:
        """κ, perimeter, mean diameter and all else that the paper measures."""
        repulsive = self.contact_map == contacts.REPULSIVE
        return contacts.measure(self.contact.grid, self.found.totals, repulsive, self.contact.moments.rms_slope)

    def sheet(self) -> Sheet:
        """Its numbers."""
        m, t = self.measure(), self.found.totals
        rows: list[tuple[str, str]] = [
            ("mean gap", f"{self.mean_gap:.5g} a0"),
            ("separation", f"{self.separation:.5g} a0"),
            ("load N/A0", f"{t.load:.4g} E*"),
            ("repulsive area A_rep/A0", f"{t.area_rep:.4g}"),
            ("attracted area A_att/A0", f"{t.area_att:.4g}"),
            ("κ = h'rms E* A_rep/N", f"{m.kappa:.4g}"),
            ("mean diameter d_rep", f"{m.diameter:.4g} a0"),
            ("residual", f"{self.found.solution.residual:.1e} E*"),
            ("status", self.status),
        ]
        return pairs("Contact", rows)

    def plot(self) -> Figure:
        """The contact map."""
        from continuum.show.runs import map_figure

        return map_figure(self.contact_map, self.contact.grid.lengths, self.area_rep, self.load)


@dataclass(frozen=True, eq=False)
class Path(Sequence[State]):
    """Equilibria of a contact, in the order in which they were reached."""

    contact: Contact = field(repr=False)
    states: tuple[State, ...] = field(repr=False)

    def __len__(self) -> int:
        return len(self.states)

    @overload
    def __getitem__(self, index: int) -> State: ...
    @overload
    def __getitem__(self, index: slice) -> Path: ...
    def __getitem__(self, index: int | slice) -> State | Path:
        if isinstance(index, slice):
            return replace(self, states=self.states[index])
        return self.states[index]

    def __iter__(self) -> Iterator[State]:
        return iter(self.states)

    def __repr__(self) -> str:
        good = sum(one.converged for one in self)
        return f"Path({len(self)} states, {good} converged, pull-off tension {self.pull_off:.4g} E*)"

    def _repr_html_(self) -> str:
        return _with_picture(self)

    @cached_property
    def adhesion(self) -> Adhesion:
        """Largest tension on both branches, work of separation, work lost in the cycle."""
        return adhesion(Curve.of([one for one in self if one.converged]))

    @property
    def pull_off(self) -> float:
        """Largest tension on the way back, per A0, in E*; NaN without one."""
        return self.adhesion.pull_off

    def sheet(self) -> Sheet:
        """One row for each state."""
        columns = (
            Column("branch"), Column("mean gap", "a0", ".5g"), Column("A_rep/A0"), Column("A_att/A0"),
            Column("N/A0", "E*", ".4e"), Column("status"),
        )  # fmt: skip
        rows = [(s.branch, s.mean_gap, s.area_rep, s.area_att, s.load, s.found.status.name.lower()) for s in self]
        return Sheet.of("Path", columns, rows)

    def plot(self) -> Figure:
        """Area and load along the path."""
        from continuum.show.runs import curve_figure

        return curve_figure(self, self.contact.moments.rms_slope)


def _with_picture(shown: State | Path) -> str:
    """Numbers and picture, as a notebook shows them."""
    from continuum.show.page import picture
    from continuum.show.plot import drawn

    return shown.sheet()._repr_html_() + picture(drawn(shown.plot()), repr(shown))
