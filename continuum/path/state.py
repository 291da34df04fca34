"""One equilibrium under load, as a path keeps it; jumps between two of them; the words for how they were reached."""

from __future__ import annotations

import enum
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, NamedTuple, Self, get_args

import numpy as np

from continuum.inputs.arguments import choice, number
from continuum.inputs.keys import Fraction, InInputs, Positive
from continuum.inputs.tables import Description
from continuum.measure.contact import Equilibrium, totals_of
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.path.crossing import Bracket
from continuum.solve.solution import NotConvergedError, NotConvergedWarning, Solution, Status

Control = Literal["separation", "mean-gap", "mean-pressure", "repulsive-area"]
CONTROLS: tuple[Control, ...] = get_args(Control)
Branch = Literal["start", "approach", "retract"]
EventKind = Literal["jump-in", "jump-out", "pull-off", "threshold"]


YIELDS = "an imprint changes the mean gap, and with it what a mean gap means"
"""Why a path under a wall that yields has no given mean gap."""


class Outcome(enum.StrEnum):
    """Why there is no state at a target, although the solver did what it could."""

    PULLED_OFF = "the contact does not hold this tension: the surface has left the wall"
    JUMPED_OVER = "the repulsive area jumps over the target on this branch; the state is the last one before"
    NOT_FOUND = "the search for the area did not end: it is no steady function of the mean gap at this tolerance"
    NO_THRESHOLD = "no work of adhesion was found at which the load at this area changes its sign"

    @property
    def ok(self) -> bool:
        """Whether the state is an equilibrium at its target: never."""
        return False


class Search(Description):
    """How closely a given area is met, and how closely jumps are looked for: keys of [loading], and of Python."""

    area_tolerance: Fraction = 0.01
    """largest difference from a given repulsive area, relative to it or, beyond half contact, to what is left of A0;
    half a grid point is always accepted"""
    area_resolution: Annotated[Positive, InInputs(ge=1e-9)] | None = None
    """width in mean gap to which a jump of the area over its target is bracketed, in a0; a thousandth of the rms height
    if not given"""
    event_resolution: Annotated[Positive, InInputs(ge=1e-9)] | None = None
    """width to which jumps between points are bracketed, in the unit of the control; jumps are not bracketed if not
    given"""
    event_threshold: Fraction = 0.01
    """smallest jump to report, as a fraction of A0: in repulsive area, in contact area, or in attractive load over the
    largest tension of the wall"""


def check_target(control: Control, target: float) -> None:
    """Refuse a control that there is not, and a target that no state can have.

    Raises
    ------
    ArgumentError
        If the control is none of :data:`Control`, or the target no finite number, or an area outside of 0 to 1.
    """
    if choice("control", control, CONTROLS) == "repulsive-area":
        number("repulsive-area", target, above=0, below=1)
    else:
        number(control, target)


class JumpSide(NamedTuple):
    """One side of a jump, as numbers: lengths in a0, loads per A0 in E*, areas as fractions of A0."""

    value: float
    """Value of the controlled quantity."""
    separation: float
    mean_gap: float
    area_rep: float
    area_att: float
    load: float


class Event(NamedTuple):
    """A jump from one equilibrium to another far from it, while the control hardly changes."""

    kind: EventKind
    """"jump-in" on approach, "jump-out" on retraction, "pull-off" where no repulsive contact remains after it;
    "threshold" where the load changes its sign from one work of adhesion to another."""
    control: Control | Literal["work-of-adhesion"]
    branch: Branch
    before: JumpSide
    after: JumpSide

    @property
    def root(self) -> float:
        """Value at which the load vanishes between both sides, taken as linear in the logarithm of the value."""
        low, high = self.before, self.after
        between = Bracket(low.value, high.value, low.load, high.load, log=True)
        return between.root if low.load > 0 > high.load else between.middle


@dataclass(frozen=True, eq=False, kw_only=True)
class PathState(Equilibrium):
    """One state of a path: its numbers, and the solution that it was found by."""

    control: Control
    branch: Branch
    solution: Solution = field(repr=False)
    outcome: Outcome | None = None
    """Why the target has no state; None if it has one."""
    beyond: PathState | None = field(default=None, repr=False)
    """Numbers of the state after the jump, where the area jumps over the target; it has no fields."""
    events: tuple[Event, ...] = ()
    """Jumps on the way from the state before."""
    lowest: tuple[float, float] | None = None
    """Smallest load per A0, in E*, and its mean gap, among the equilibria on the way from the state before and it."""
    imprint_before: Real | None = field(default=None, repr=False)
    """Depth of the imprint that the wall had before, shape ``grid.shape``, in a0; None without one."""
    search_pairs: float = 0.0
    """FFT pairs, weighted as those of the solution, of the other equilibria on the way."""
    search_solves: int = 0
    """Number of those equilibria."""

    @property
    def gap(self) -> Real:
        """Height of the wall above the deformed surface, shape ``grid.shape``, in a0."""
        return self.solution.gap

    @property
    def imprint(self) -> Real | None:
        """Depth of the imprint that the state leaves: where the gap is negative the wall has yielded once more."""
        new = np.maximum(-self.gap, 0.0)
        if not new.any():
            return self.imprint_before
        return new if self.imprint_before is None else self.imprint_before + new

    @property
    def traction(self) -> Real:
        """Traction of the wall on the surface, compression positive, shape ``grid.shape``, in E*; NaN if not known."""
        return self.solution.traction

    @property
    def threshold(self) -> Event | None:
        """The bracket of the threshold that was sought, with works of adhesion as values; None if it was not found."""
        return next((event for event in self.events if event.control == "work-of-adhesion"), None)

    @property
    def status(self) -> Status | Outcome:
        """How the solve, or the search, ended."""
        return self.outcome or self.solution.status

    @property
    def converged(self) -> bool:
        """Whether it is an equilibrium at its target."""
        return self.status.ok

    def require(self) -> Self:
        """The state itself, if it is an equilibrium at its target; else raises NotConvergedError with the reason."""
        if self.outcome is not None:
            raise NotConvergedError(self.outcome.value)
        self.solution.require()
        return self


def state_of(problem: ContactProblem, control: Control, target: float, branch: Branch, solution: Solution) -> PathState:
    """A state with all that follows from its gap; loads are NaN where neither a law nor the solution has tractions."""
    traction = solution.traction if solution.law is None else None
    totals = totals_of(problem.grid, problem.wall, solution.gap, traction)
    mean_gap = problem.grid.mean(solution.gap)
    separation = target
    if control != "separation":
        separation = problem.separation(mean_gap, totals.load, lambda: solution.traction)
    return PathState(
        **vars(totals), control=control, target=target, branch=branch, separation=separation, mean_gap=mean_gap,
        work_of_adhesion=problem.wall.work_of_adhesion, solution=solution,
    )  # fmt: skip


def nearness(problem: ContactProblem) -> Control:
    """What says how near the wall is where another control is searched for.

    The mean gap, in which the base takes no part; where nothing is repeated, and no mean gap can be given, the
    separation.
    """
    return "mean-gap" if problem.open_boundary is None else "separation"


def height(problem: ContactProblem, state: PathState) -> float:
    """How near the wall is in a state, by :func:`nearness`, in a0."""
    return state.mean_gap if problem.open_boundary is None else state.separation


def kept(state: PathState) -> PathState:
    """What a path keeps of a state: its numbers, and of its fields the gap only."""
    found = state.solution
    solution = Solution(found.gap, found.status, found.residual, found.iterations, found.work, law=found.law)
    return replace(state, solution=solution, outcome=None, beyond=None, events=())


def numbers(state: PathState) -> PathState:
    """A state without its fields."""
    nothing = np.broadcast_to(np.nan, state.gap.shape)
    return replace(kept(state), imprint_before=None, solution=replace(kept(state).solution, gap=nothing))


def settled(problem: ContactProblem, good: list[PathState]) -> ContactProblem:
    """The problem with the imprint that the last state of a list has left, and that state as one of this problem."""
    if np.isinf(problem.wall.hardness) or not good:
        return problem
    last = good[-1]
    imprint, gap = last.imprint, np.maximum(last.gap, 0.0)
    solution = replace(last.solution, gap=gap)
    good[-1] = replace(last, imprint_before=imprint, mean_gap=problem.grid.mean(gap), solution=solution)
    return problem.dented(imprint)


def gone(problem: ContactProblem, target: float, branch: Branch, solution: Solution | None = None) -> PathState:
    """The state of a surface that has left the wall under tension: no contact, no load, an infinite gap.

    Its residual is the tension, which nothing holds; so that it is none that a solve has converged to.
    """
    solution = solution or Solution(problem.heights, Status.STOPPED, -target, 0)
    solution = replace(solution, gap=np.broadcast_to(np.inf, problem.grid.shape_here), residual=-target)
    return PathState(
        area_rep=0.0, area_att=0.0, load_rep=0.0, load_att=0.0, load=0.0, wall_energy=0.0, smallest_gap=np.inf,
        control="mean-pressure", target=target, branch=branch, separation=np.inf, mean_gap=np.inf,
        work_of_adhesion=problem.wall.work_of_adhesion, solution=solution, outcome=Outcome.PULLED_OFF,
    )  # fmt: skip


def coordinate(control: Control, state: PathState) -> float:
    """Value of a controlled quantity in a state, also one that was reached under another control."""
    if control == state.control:
        return state.target
    return {
        "separation": state.separation,
        "mean-gap": state.mean_gap,
        "mean-pressure": state.load,
        "repulsive-area": state.area_rep,
    }[control]


def event(control: Control, branch: Branch, before: PathState, after: PathState) -> Event:
    """The jump between two states; its controlled quantity is the mean gap where an area is searched for."""
    kind: EventKind = "jump-in"
    if branch == "retract":
        kind = "pull-off" if after.area_rep == 0 else "jump-out"
    sides = (side_of(state, coordinate(control, state)) for state in (before, after))
    return Event(kind, control, branch, *sides)


def side_of(state: PathState, value: float) -> JumpSide:
    """A state as one side of a jump, at a value of the controlled quantity."""
    return JumpSide(value, state.separation, state.mean_gap, state.area_rep, state.area_att, state.load)


NOT_LOOKED = "jumps on the way not looked for"
"""What is said of a point where :func:`not_looked_at`, and why."""
HYSTERESIS = (
    "jumps on the way back were not looked for, and after steps so long contacts may be missing that a slow retraction "
    "would hold: take shorter steps, or give event_resolution with another control than the area"
)


NEAREST = "met to half a grid point only"
"""What is said of a point where :func:`counts_few`, and why."""
FEW_POINTS = (
    "an area is a number of grid points: of an area of so few the nearest number differs by more than area_tolerance; "
    "take a larger area or a finer grid"
)


def counts_few(point: Equilibrium, area_tolerance: float) -> bool:
    """Whether the number of grid points that was found for a given area differs from it by more than the tolerance.

    Parameters
    ----------
    area_tolerance : relative to the area or, beyond half contact, to what is left of A0.
    """
    if point.control != "repulsive-area":
        return False
    allowed = area_tolerance * min(point.target, 1 - point.target)
    return abs(point.area_rep - point.target) > allowed * (1 + 1e-9)


def not_looked_at(points: Iterable[tuple[Equilibrium, bool]], threshold: float) -> list[bool]:
    """Whether the way back to each point may have passed over jumps, so that its branch is not certain.

    Parameters
    ----------
    points : each, and whether jumps on the way to it were looked for.
    threshold : change of an area, as a fraction of A0, up to which a step is short.
    """
    found, last = list[bool](), None
    for point, looked in points:
        change = 0.0
        if last is not None and point.branch == "retract" and not looked:
            repulsive = point.area_rep - last.area_rep
            change = max(abs(repulsive), abs(repulsive + point.area_att - last.area_att))
        found.append(change > threshold)
        last = point
    return found


_FLAT = 1e-4
"""Rms height, in a0, below which heights are probably in another unit."""


def warn_of(states: Sequence[PathState], rms_height: float) -> None:
    """Warn once of states that are no equilibria, with the likely cause; a surface that has left the wall is as asked.

    Parameters
    ----------
    rms_height : of the heights, in a0.
    """
    failed = [
        one for one in states if not one.converged and (one.outcome is not Outcome.PULLED_OFF or len(states) == 1)
    ]
    if failed:
        cause = f"; heights of {rms_height:.1e} a0 are probably in metres: divide them by a0" * (rms_height < _FLAT)
        said = f"not converged: {len(failed)} of {len(states)} states; the first: {failed[0].status}{cause}"
        # Above this function and the one of the contact, with the one that gives hints, is the caller.
        warnings.warn(said, NotConvergedWarning, stacklevel=4)
