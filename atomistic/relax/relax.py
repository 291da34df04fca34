"""Equilibrium of the slab under the wall.

LAMMPS minimises the energy of a deck from its start.  If the linear response of the slab is known, that start can
first be brought to equilibrium with few force evaluations: each iteration adds the difference of the atoms from the
linear lattice, measured by LAMMPS, to the lattice problem and solves the contact again.  LAMMPS, with the wall of the
deck, then confirms the equilibrium, or finishes it with its minimisers if the iteration stalls: in the run of the deck,
or without any files in the session of the iteration.
"""

import tempfile
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import run_in_process
from atomistic.lammps.result import DeckResult, LammpsError
from atomistic.lammps.session import Session
from atomistic.response.lattice import LatticeResponse
from continuum.model.fourier import Real
from continuum.model.problem import ContactProblem
from continuum.model.walls import Wall
from continuum.path import loading
from continuum.solve.solution import NotConvergedError, Settings

_DEPTH = 8
"""Number of mixed states."""
_MOST_MIXED = 60
"""Largest number of contacts that are solved for the forces on lower layers; 5 to 15 are usual."""
_PATIENCE = 10
"""Number of evaluations within which the largest force must halve."""


def lattice_start(response: LatticeResponse, wall: Wall, gap: Real) -> Real:
    """Displacements of a slab, shape (layers, nx, ny, 3), in a0, at the equilibrium of its response with this gap."""
    return response.displacements_of_surface_force(-wall.evaluate(gap).traction)


def lattice_on_every_layer(deck: Deck, response: LatticeResponse, gap: Real) -> Real:
    """Displacements of the linear slab of a deck under its wall, which acts on each layer as on that of the atoms.

    The forces p on the lower layers are those of the law at the displacements that they cause::

        u = K^-1 p + K^-1 f(u),      p <- p(u)

    The contact of the surface is solved exactly, the rest mixed as in :func:`iterate`.  A law that ends above the
    second layer leaves :func:`lattice_start`.

    Parameters
    ----------
    gap : of the contact under the whole law at the surface, from which the iteration starts, in a0.

    Raises NotConvergedError if there is no equilibrium near this gap.
    """
    slab, wall = deck.slab, deck.law
    settings, mixed = Settings(tolerance=deck.tolerance / 1000), Mixer()
    pushed = np.zeros((slab.mobile - 1, *slab.shape))
    u = lattice_start(response, deck.wall, gap)
    for _ in range(_MOST_MIXED):
        push = _deep_push(deck, u) - pushed
        if np.abs(push).max(initial=0.0) <= deck.tolerance:
            return u
        pushed = mixed.next(pushed, push, push)
        forces = np.zeros((slab.mobile, *slab.shape, 3))
        forces[1:, ..., 2] = -pushed
        w = response.displacements(forces)
        problem = ContactProblem(slab.grid, wall, deck.heights - w[0, ..., 2], response)
        gap = loading.solve(problem, "separation", deck.separation, settings, start=gap).require().gap
        u = w + lattice_start(response, wall, gap)
    raise NotConvergedError(f"the lattice under the wall on every layer found no equilibrium in {_MOST_MIXED} steps")


def relax(
    deck: Deck,
    directory: Path,
    response: LatticeResponse | None = None,
    run: Callable[[Path], DeckResult] = run_in_process,
    session: Session | None = None,
) -> DeckResult:
    """Write a deck to a directory and run it there; returns the last state, for which ``require()`` should be called.

    Parameters
    ----------
    deck : the deck, which starts from ``deck.displacements``.
    directory : directory of the deck; see :func:`atomistic.lammps.deck.write_deck`.
    response : response of the slab, with which the start is first brought to equilibrium (:func:`iterate`); None
        leaves all to the deck.
    run : function that runs the deck: :func:`~atomistic.lammps.engine.run_in_process`, or
        ``lambda directory: run_command(directory, "mpiexec -n 4 lmp")``.
    session : LAMMPS on the atoms of the deck, for the iteration; a new one if None.

    Raises LammpsError if LAMMPS fails.
    """
    evaluations = 0
    if response is not None:
        with nullcontext(session) if session else Session.on_atoms_of(deck) as atoms:
            better = iterate(deck, atoms, response)
        deck, evaluations = replace(deck, displacements=better.displacements), better.evaluations
    result = run(write_deck(directory, deck, force=True))
    return replace(result, evaluations=result.evaluations + evaluations)


def relax_in(session: Session, deck: Deck, response: LatticeResponse) -> DeckResult:
    """Relax a deck in LAMMPS on its atoms; returns the state, for which ``require()`` should be called.

    As :func:`relax`, but a deck is only written, for a while, if the iteration leaves forces to LAMMPS' minimisers.
    """
    better = iterate(deck, session, response)
    deck = replace(deck, displacements=better.displacements)
    result = session.under(deck)
    if not result.largest_force <= deck.tolerance:
        with tempfile.TemporaryDirectory() as folder:
            result = relax(deck, Path(folder))
    return replace(result, evaluations=result.evaluations + better.evaluations)


@dataclass(frozen=True, eq=False)
class RelaxationResult:
    """Result of :func:`iterate`."""

    displacements: Real = field(repr=False)
    """The best state, shape (layers, nx, ny, 3), in a0."""
    largest_forces: tuple[float, ...]
    """Largest force on a mobile atom before each iteration, in E* a0²; the displacements are those with the
    smallest."""
    converged: bool
    """True if the smallest force is below half the tolerance of the deck."""

    @property
    def evaluations(self) -> int:
        return len(self.largest_forces)


def iterate(deck: Deck, session: Session, response: LatticeResponse, limit: int = 120) -> RelaxationResult:
    """Find the equilibrium by an iteration preconditioned by the Green's function.

    With F(u) the forces between the atoms, f(u) the force of the wall and K the stiffness of the linear slab, an
    equilibrium is a fixed point of::

        u = w + K^-1 f(u),      w <- w + r,      r = K^-1 (F(u) + f(u))

    The first equation, with its wall, is a contact problem with the linear response, for the wall shifted by the
    displacement of w at the surface, so that the stiff and one-sided part is solved exactly.  The rest in the second
    equation is smooth: the difference of the atoms from their linear lattice.  It is accelerated by mixing the last w:
    the next one is the mean Σ a_i (w_i + r_i), Σ a_i = 1, that minimises the elastic energy of Σ a_i r_i (Pulay, Chem.
    Phys. Lett. 73, 393 (1980); Walker and Ni, SIAM J. Numer. Anal. 49, 1715 (2011)).

    It ends when converged, when forces no longer fall, or at the limit.  Each contact problem is minimised from the
    last gap, so that a path keeps to its branch; an equilibrium that is unstable for the atoms but not for their
    linear lattice is not distinguished from a stable one.

    Under ``mpiexec`` all processes call this together, for a deck written before: LAMMPS distributes the atoms.

    Parameters
    ----------
    deck : the wall, where it stands, and the start.
    session : LAMMPS on the atoms of the deck.
    response : of the slab.
    limit : largest number of force evaluations.
    """
    wall, separation, mobile = deck.law, deck.separation, deck.slab.mobile
    settings = Settings(tolerance=deck.tolerance / 1000)
    u = best = deck.start
    gap = separation + deck.heights - u[0, ..., 2]
    w = (u - lattice_start(response, wall, gap))[:mobile]
    mixed = Mixer()
    largest: list[float] = []
    while True:
        try:
            _, forces = session.evaluate(u)
        except LammpsError:
            if not largest:
                raise
            break  # LAMMPS lost atoms in a bad iterate: the best one is kept
        gap = separation + deck.heights - u[0, ..., 2]
        total = forces[:mobile]
        total[0, ..., 2] -= wall.evaluate(gap).traction
        deep = _deep_push(deck, u)
        total[1:, ..., 2] -= deep
        largest.append(float(np.sqrt(np.max(np.sum(total**2, axis=-1)))))
        if len(largest) == 1:  # of a start that overlaps the wall, from which the contact is solved first
            total[1:, ..., 2] += deep
        if largest[-1] == min(largest):
            best = u
        if largest[-1] <= deck.tolerance / 2 or not falling(largest) or len(largest) >= limit:
            break
        w = mixed.next(w, response.displacements(total)[:mobile], total)
        problem = ContactProblem(deck.slab.grid, wall, deck.heights - w[0, ..., 2], response)
        # An unconverged contact only gives a worse iterate, which the forces show.
        gap = loading.solve(problem, "separation", separation, settings, start=gap).gap
        if not np.isfinite(gap).all():
            break
        u = lattice_start(response, wall, gap)
        u[:mobile] += w
    return RelaxationResult(best, tuple(largest), min(largest) <= deck.tolerance / 2)


def _deep_push(deck: Deck, u: Real) -> Real | float:
    """Tractions of the wall on the layers below the surface, shape (layers - 1, nx, ny), in E*; 0 out of its reach."""
    below = slice(1, deck.slab.mobile)
    level = deck.rest[below, ..., 2] - deck.surface
    gap = deck.separation + deck.above.reshape(-1, *deck.slab.shape)[below] - level - u[below, ..., 2]
    return deck.law.evaluate(gap).traction if gap.min(initial=np.inf) < deck.law.reach else 0.0


def falling(largest: list[float]) -> bool:
    """True if the largest force, of each evaluation until now, is still decreasing."""
    recent = largest[-_PATIENCE:]
    return bool(np.isfinite(largest[-1])) and (
        len(largest) <= _PATIENCE or min(recent) < 0.5 * min(largest[:-_PATIENCE])
    )


class Mixer:
    """The last states w with their corrections r = K^-1 t, and their mean with the smallest elastic energy."""

    def __init__(self) -> None:
        self._next: list[Real] = []  # w + r
        self._corrections: list[Real] = []
        self._energies = np.zeros((0, 0))  # r_i . K r_j = r_i . t_j

    def next(self, w: Real, correction: Real, force: Real) -> Real:
        """The next state, after adding one with its correction r and force t = K r."""
        self._next.append(w + correction)
        self._corrections.append(correction)
        row = np.array([np.vdot(r, force) for r in self._corrections])
        self._energies = np.block([[self._energies, row[:-1, None]], [row[None, :]]])
        if len(row) > _DEPTH:
            del self._next[0], self._corrections[0]
            self._energies = self._energies[1:, 1:]
        # Scaled to correlations: the energies span twenty orders of magnitude.
        scale = 1 / np.sqrt(np.diag(self._energies))
        weights = scale * (np.linalg.pinv(scale[:, None] * self._energies * scale, rcond=1e-10, hermitian=True) @ scale)
        weights /= weights.sum()
        mean: Real = weights[-1] * self._next[-1]
        for weight, state in zip(weights[:-1], self._next[:-1], strict=True):
            mean += weight * state
        return mean
