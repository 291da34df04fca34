"""States of a contact, and paths of them: their numbers, maps and figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import NDArray

from continuum.measure import contact as contacts
from continuum.measure.contact import Measurement
from continuum.measure.curve import Adhesion, Curve, adhesion
from continuum.model.fourier import Real
from continuum.path import state
from continuum.path.equilibrium import solver_of
from continuum.path.gradient import Given, Number, gradient
from continuum.path.state import Event
from continuum.path.turn import WallOfWork
from continuum.sheet import Column, Sheet, pairs
from continuum.solve.solution import NotConvergedError
from continuum.solve.stability import Stability

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from continuum.front.contact import Contact


@dataclass(frozen=True, eq=False)
class State:
    """One equilibrium of a contact, converged or not."""

    contact: Contact = field(repr=False)
    found: state.PathState = field(repr=False)

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
        """Traction of the wall on the surface, compression positive, shape (nx, ny), in E*."""
        return self.found.traction

    @property
    def imprint(self) -> Real:
        """Depth of the imprint that this state and those before it leave, shape (nx, ny), in a0."""
        left = self.found.imprint_left
        return np.zeros(self.gap.shape) if left is None else left

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
        """Load per A0, in E*, compression positive."""
        return self.found.load

    @property
    def mean_gap(self) -> float:
        """Mean gap, in a0."""
        return self.found.mean_gap

    @property
    def separation(self) -> float:
        """Separation, in a0; NaN where the mean displacement of the substrate is free."""
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

    @property
    def residual(self) -> float:
        """Root-mean-square residual traction, over that which flattens the surface (h'rms E* on a half-space)."""
        return self.found.solution.residual / self.contact.problem.traction_scale

    @cached_property
    def duality_gap(self) -> float:
        """Bound on the error of the energy under a hard wall, relative to the elastic energy; NaN for other walls."""
        problem = self.contact.problem.dented(self.found.imprint)
        boundary = problem.open_boundary
        energy = problem.elastic_energy(self.gap) if boundary is None else boundary.elastic_energy(self.traction)
        return self.found.solution.duality_gap / energy if energy > 0 else float("nan")

    def require(self) -> State:
        """Return the state if it is an equilibrium at its target; else raise NotConvergedError with the reason."""
        self.found.require()
        return self

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
        """The derivative of a number by the height of every point, at the cost of one or two linear solves.

        Its product with a small change of the heights, summed over the points, is what the number changes by.

        Parameters
        ----------
        number : "load", per A0; "area", the repulsive area as a fraction of A0, the part of the lines of the grid along
            which the gap, linear from point to point, is below zero_gap, as a count of points has no derivative;
            "pull_off", the largest tension per A0, for which the path is followed from this state, best that of largest
            tension in a :class:`LoadingPath`, to the place where it is largest; "turn", the work of adhesion at which
            the load vanishes at this area, in a state where it does.
        at : what is held, "mean_gap", "separation", "pressure" or "area"; None for the separation, if the state was
            pressed to one or nothing is repeated, and else the mean gap.  Not for a turn, where area and load are held,
            nor for a pull-off, where it makes no difference.
        wall : for a turn, function that returns the law for a work of adhesion, as for :meth:`Contact.turn`.

        Returns
        -------
        Real
            Shape (nx, ny), in the unit of the number per a0.

        Raises
        ------
        ArgumentError
            Where there is no such derivative: all but the load under a hard wall; what is held; a separation on a
            substrate of free mean displacement, a mean gap without periodic images.
        NotConvergedError
            If this is no equilibrium, or one that is about to jump.

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
        return gradient(self.contact.problem, self.found, self.contact.settings, number, at=at, wall_of=wall)

    @cached_property
    def contact_map(self) -> NDArray[np.uint8]:
        """2 repulsive, 1 attracted, 0 out of range, shape (nx, ny)."""
        return contacts.contact_map(self.contact.wall, self.gap)

    def measure(self) -> Measurement:
        """Measure κ, perimeter, mean diameter and the other numbers of the paper."""
        repulsive = self.contact_map == contacts.REPULSIVE
        return contacts.measure(self.contact.grid, self.found.totals, repulsive, self.contact.moments.rms_slope)

    def sheet(self) -> Sheet:
        """Table of its numbers."""
        m, t = self.measure(), self.found.totals
        rows: list[tuple[str, str]] = [
            ("mean gap", f"{self.mean_gap:.5g} a0"),
            ("separation", f"{self.separation:.5g} a0"),
            ("load N/A0", f"{t.load:.4g} E*"),
            ("repulsive area A_rep/A0", f"{t.area_rep:.4g}"),
            ("attracted area A_att/A0", f"{t.area_att:.4g}"),
            ("κ = h'rms E* A_rep/N", f"{m.kappa:.4g}"),
            ("mean diameter d_rep", f"{m.diameter:.4g} a0"),
            ("residual, of the traction that flattens the heights", f"{self.residual:.1e}"),
        ]
        if not np.isnan(self.duality_gap):
            rows.append(("duality gap, of the elastic energy", f"{self.duality_gap:.1e}"))
        rows.append(("status", self.status))
        return pairs("Contact", rows)

    def plot(self) -> Figure:
        """Draw the contact map."""
        from continuum.show.run_figures import map_figure

        return map_figure(self.contact_map, self.contact.grid.lengths, self.area_rep, self.load)


@dataclass(frozen=True, eq=False)
class LoadingPath(Sequence[State]):
    """Equilibria of a contact, in the order in which they were reached."""

    contact: Contact = field(repr=False)
    states: tuple[State, ...] = field(repr=False)

    def __len__(self) -> int:
        return len(self.states)

    @overload
    def __getitem__(self, index: int) -> State: ...
    @overload
    def __getitem__(self, index: slice) -> LoadingPath: ...
    def __getitem__(self, index: int | slice) -> State | LoadingPath:
        if isinstance(index, slice):
            return replace(self, states=self.states[index])
        return self.states[index]

    def __iter__(self) -> Iterator[State]:
        return iter(self.states)

    def __repr__(self) -> str:
        good = sum(one.converged for one in self)
        return f"LoadingPath({len(self)} states, {good} converged, pull-off tension {self.pull_off:.4g} E*)"

    def _repr_html_(self) -> str:
        return _with_picture(self)

    @cached_property
    def adhesion(self) -> Adhesion:
        """Largest tension on both branches, work of separation, work lost in the cycle.

        Raises ValueError if no state converged.
        """
        return adhesion(Curve.of([one for one in self if one.converged]))

    @property
    def pull_off(self) -> float:
        """Largest tension on the way back, per A0, in E*; NaN where no state of a way back converged."""
        return self.adhesion.pull_off if any(one.converged for one in self) else float("nan")

    def sheet(self) -> Sheet:
        """One row for each state."""
        columns = (
            Column("branch"), Column("mean gap", "a0", ".5g"), Column("A_rep/A0"), Column("A_att/A0"),
            Column("N/A0", "E*", ".4e"), Column("status"),
        )  # fmt: skip
        one_branch = not self.contact.problem.wall.work_of_adhesion > 0
        points = [(s.branch, s.found.totals, one_branch or s.found.lowest is not None) for s in self]
        passed = state.not_looked_at(points, state.Search.event_threshold)
        rows = [
            (s.branch, s.mean_gap, s.area_rep, s.area_att, s.load,
             s.found.status.name.lower() + (f", {state.NOT_LOOKED}" if over else ""))
            for s, over in zip(self, passed, strict=True)
        ]  # fmt: skip
        return Sheet.of("Path", columns, rows, state.HYSTERESIS if any(passed) else "")

    def plot(self) -> Figure:
        """Area and load along the path."""
        from continuum.show.run_figures import curve_figure

        return curve_figure(self, self.contact.moments.rms_slope)


def _with_picture(shown: State | LoadingPath) -> str:
    from continuum.show.page import picture
    from continuum.show.plot import image_bytes

    return shown.sheet()._repr_html_() + picture(image_bytes(shown.plot()), repr(shown))


@dataclass(frozen=True, eq=False)
class Turn:
    """The turn of a contact, or the last bracket of the search for it."""

    state: State
    """State at the given area whose load is nearest to zero."""
    wall: WallOfWork = field(repr=False)
    """Law of each work of adhesion."""

    @property
    def bracket(self) -> Event | None:
        """States below and above the turn, with their works as values; None if it was not found."""
        return self.state.found.turn

    @property
    def work(self) -> float:
        """Work of adhesion at the turn, in E* a0; NaN if it was not found.

        Within the bracket the load is taken as linear in the logarithm of the work.
        """
        return float("nan") if self.bracket is None else self.bracket.root

    @property
    def jumps(self) -> bool:
        """Whether the load jumps over zero: the surface snaps, and no state has zero load."""
        return self.bracket is not None and self.bracket.kind == "jump-in"

    @property
    def converged(self) -> bool:
        """Whether a bracket was found, with equilibria at both ends."""
        return self.state.converged

    @property
    def status(self) -> str:
        """How the search ended, in words."""
        return self.state.status

    def require(self) -> Turn:
        """Return the turn if it was found; else raise NotConvergedError with the reason."""
        self.state.require()
        return self

    def gradient(self) -> Real:
        """The derivative of the work at the turn by the height of every point, shape (nx, ny), in E* a0 per a0.

        Positive where a greater height makes the surface less sticky.  See :meth:`State.gradient`.

        Raises NotConvergedError where the turn was not found, or the load jumps over zero.
        """
        self.require()
        if self.jumps:
            raise NotConvergedError("no gradient of the turn: the load jumps over zero, and no state has zero load")
        return self.state.gradient("turn", wall=self.wall)

    def __repr__(self) -> str:
        return f"Turn(w {self.work:.4g} E* a0 at A_rep/A0 {self.state.area_rep:.4g}, {self.status})"

    def _repr_html_(self) -> str:
        return self.sheet()._repr_html_()

    def sheet(self) -> Sheet:
        """The bracket, with the loads at both ends."""
        rows = [("work of adhesion at the turn", f"{self.work:.4g} E* a0")]
        if self.bracket is not None:
            for name, side in (("below", self.bracket.before), ("above", self.bracket.after)):
                rows.append((f"{name}: work", f"{side.value:.5g} E* a0"))
                rows.append((f"{name}: load N/A0 at A_rep/A0 {side.area_rep:.4g}", f"{side.load:.3e} E*"))
        found = self.state.found
        rows.append(("FFT pairs", f"{found.search_pairs + found.solution.fft_pairs:.0f}"))
        return pairs("Turn", [*rows, ("status", self.status + (", the load jumps over zero" if self.jumps else ""))])
