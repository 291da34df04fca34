"""The lattice-preconditioned relaxation of :mod:`atomistic.relax.relax` as an optimizer of ASE, for any slab."""

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
import scipy
from ase import Atoms
from ase.calculators.mixing import LinearCombinationCalculator
from ase.optimize.optimize import Optimizer
from ase.optimize.precon import PreconLBFGS

from atomistic.atoms.response import SlabResponse, SurfaceRoot, in_single_precision
from atomistic.atoms.wall import RoughWall
from atomistic.relax.relax import Mixer, falling
from continuum.inputs.arguments import ArgumentError, instance
from continuum.model.fourier import Real

_SETTLED = 0.02
"""Error of the wall's forces in the contact with the linear slab, relative to the wanted largest force."""
_WORTH = 15.0
"""Largest cost of a response, in evaluations of the slab: in all PreconLBFGS takes 14 to 34 (docs/studies)."""
_DIGITS = 100
"""Rounding errors that a step must gain for the energy to tell whether it is one: Armijo's condition asks for 23 %."""
_LEFT, _TRIALS = 0.9, 3
"""Part of the force along a step that may be left, and evaluations that look for one, by forces alone."""


class GreensRelaxation(Optimizer):
    """Relax a slab with few evaluations of its forces, an optimizer of ASE.

    Each iteration evaluates the forces once, adds the difference of the atoms from their linear lattice to the lattice
    problem, and solves the contact of the linear lattice with the wall again (:func:`atomistic.relax.relax.iterate`).
    The wall is the :class:`RoughWall` of the atoms' ``SumCalculator``; without one, the slab relaxes by itself.  The
    linear response is measured before the first step, with the calculator of the crystal on a small slab of the same
    cells; pass it on to the next relaxation of the same slab.

    If the atoms do not repeat along the surface, none is held by a constraint, the slab is unstable, or the forces no
    longer decrease, ASE's ``PreconLBFGS`` continues, with a warning.

    Parameters
    ----------
    atoms : the atoms, with their calculator.
    logfile, trajectory, others : as of ASE's optimizers.  To go on from the last image of a trajectory, read it, and
        pass ``at_rest``.
    response : :attr:`response` of an earlier relaxation.
    at_rest : the slab at rest; that of the wall, or the atoms as they are, if None.

    Examples
    --------
    >>> relaxation = a.GreensRelaxation(atoms, trajectory="relax.traj")  # doctest: +SKIP
    >>> relaxation.run(fmax=1e-4)  # doctest: +SKIP
    """

    def __init__(
        self,
        atoms: Atoms,
        logfile: IO[str] | str | Path | None = "-",
        trajectory: str | Path | None = None,
        *,
        response: SlabResponse | None = None,
        at_rest: Atoms | None = None,
        **others: Any,
    ) -> None:
        if instance("atoms", atoms, Atoms, "an ase.Atoms with its calculator").calc is None:
            raise ArgumentError("atoms", atoms, "atoms with a calculator")
        if response is not None:
            instance("response", response, SlabResponse)
        if at_rest is not None and len(instance("at_rest", at_rest, Atoms, "an ase.Atoms")) != len(atoms):
            raise ArgumentError("at_rest", at_rest, f"the {len(atoms)} atoms of the slab")
        super().__init__(atoms, logfile=logfile, trajectory=trajectory, **others)
        self.response = response
        """Linear response of the slab; None before the first step."""
        self.fallback: PreconLBFGS | None = None
        """Optimizer that took over, if any."""
        mixer = getattr(atoms.calc, "mixer", None)
        parts = [(atoms.calc, 1.0)] if mixer is None else list(zip(mixer.calcs, mixer.weights, strict=True))
        walls = [part for part in parts if isinstance(part[0], RoughWall)]
        # One wall, of weight 1, is solved exactly; others are forces like those of the atoms.
        self._wall = walls[0][0] if [weight for _, weight in walls] == [1.0] else None
        rest = [part for part in parts if part[0] is not self._wall]
        self._crystal = _Counting(*zip(*rest, strict=True)) if rest else None  # type: ignore[no-untyped-call]
        self._parts = [calculator for calculator, _ in parts]
        if at_rest is None:
            at_rest = atoms if self._wall is None else self._wall.slab
        self._rest = at_rest.copy()
        self._rest.set_constraint(atoms.constraints)
        self._root: SurfaceRoot | None = None
        self._mixer, self._linear = Mixer(), np.zeros((0, 3))  # w: where the slab would be without its wall
        self._largest: list[float] = []
        self._best = atoms.positions

    def step(self) -> None:
        """One step, after which the forces are evaluated once; ASE calls this."""
        if self.fallback is not None:
            self.fallback.step()
            return
        forces = self.atoms.get_forces()
        self._largest.append(float(np.linalg.norm(forces, axis=1).max()))
        if self._largest[-1] == min(self._largest):
            self._best = self.atoms.get_positions()  # from which a fallback goes on
        try:
            response = self.response or self._measured()
            if not self._linear.size:
                forces = self._begin(response, forces)
        except ArgumentError as error:
            self._leave(str(error))
            return
        if not falling(self._largest):
            self._leave(f"the largest force no longer falls below {min(self._largest):.2e} eV/Å")
            return
        self._linear = self._mixer.next(self._linear, response.displacements(forces), forces)
        moved = self._linear
        if self._wall is not None:
            moved = moved + response.displacements(self._settled_force())
        if not np.isfinite(moved).all():
            self._leave("the linear slab has no contact")
            return
        self.atoms.set_positions(self._rest.positions + moved)

    def _measured(self) -> SlabResponse:
        if self._crystal is None:
            raise ArgumentError("atoms", self.atoms, "atoms with a calculator, beside that of the wall")
        self.response = found = SlabResponse.measure(self._rest, self._crystal, _WORTH)
        n, m, p = found.index.shape
        self.logfile.write(
            f"{type(self).__name__}: the response of {n} x {m} cells of {p} atoms was measured by {found.evaluations} "
            f"evaluations of a small slab, which cost as much as {found.cost:.2g} of the whole\n"
        )
        return found

    def _begin(self, response: SlabResponse, forces: Real) -> Real:
        """Split where the atoms are into the linear lattice under the wall and the rest; returns the first forces.

        At rest under a wall that overlaps them, deeper atoms would be pushed, which in contact are out of its reach.
        """
        self._linear = self.atoms.positions - self._rest.positions
        if self._wall is not None:
            self._root = response.surface_root(self._wall.surface)
            of_surface = self._of_surface(self.atoms.positions)
            self._linear = self._linear - response.displacements(of_surface)
            return np.asarray(forces - self._wall.get_forces(self.atoms) + of_surface)
        return forces

    def _of_surface(self, positions: Real) -> Real:
        """Forces of the wall on the surface atoms, in the shape of all; those on deeper atoms count as the rest."""
        assert self._wall is not None
        surface, forces = self._wall.surface, np.zeros_like(positions)
        forces[surface] = self._wall.act(positions[surface]).forces
        return forces

    def _settled_force(self) -> Real:
        """Forces of the wall on the surface, in the contact of the linear slab that is nearest to where the atoms are.

        With G = R R of the surface and u = w + R v, the energy is v.v/2 + E_wall(w + R v), which is about as stiff in
        all directions.  Its minimum is found roughly by L-BFGS, then by Newton's method, of the law only.
        """
        wall, root = self._wall, self._root
        assert wall is not None
        assert root is not None
        assert self.fmax is not None
        at = (self._rest.positions + self._linear)[wall.surface]

        def energy(flat: Real) -> tuple[float, Real]:
            v = flat.reshape(at.shape)
            acting = wall.act(at + root(v))
            return float(flat @ flat / 2 + acting.energy.sum()), (v - root(acting.forces)).ravel()

        v = root(wall.act(self.atoms.positions[wall.surface]).forces)
        rough = 1e-3 * float(np.abs(v).max())
        start, options = v.ravel(), {"gtol": rough, "ftol": 0.0, "maxcor": 30, "maxiter": 1000}
        v = scipy.optimize.minimize(energy, start, jac=True, method="L-BFGS-B", options=options).x.reshape(at.shape)
        errors = [np.inf]
        while True:
            acting = wall.act(at + root(v))
            gradient = v - root(acting.forces)
            stiffness = acting.stiffness
            errors.append(float(np.abs(_times(stiffness, root(gradient))).max()))
            if not _SETTLED * self.fmax < errors[-1] < 0.9 * errors[-2]:
                break

            def hessian(flat: Real, stiffness: Real = stiffness) -> Real:
                change = flat.reshape(at.shape)
                return (change + root(_times(stiffness, root(change)))).ravel()

            operator = scipy.sparse.linalg.LinearOperator((v.size, v.size), matvec=hessian, dtype=np.float64)
            v = v - scipy.sparse.linalg.cg(operator, gradient.ravel(), rtol=1e-2, maxiter=200)[0].reshape(at.shape)
        forces = np.zeros_like(self._linear)
        forces[wall.surface] = acting.forces
        return forces

    def _leave(self, reason: str) -> None:
        """Leave the rest to PreconLBFGS, from the best state, and say so."""
        message = f"{type(self).__name__} goes on by PreconLBFGS: {reason}"
        if self.response is None and self._crystal is not None and self._crystal.evaluations:
            message += f" ({self._crystal.evaluations} evaluations of a small slab)"
        warnings.warn(message, stacklevel=2)
        self.logfile.write(message + "\n")
        self.atoms.set_positions(self._best)
        self.fallback = ByForces(self.atoms, self._parts, self.logfile.write)
        self.fallback.step()  # type: ignore[no-untyped-call]


class _Counting(LinearCombinationCalculator):
    """The calculator of the crystal, as the response is measured with it, and how often it was evaluated."""

    evaluations = 0

    def calculate(self, *given: Any, **named: Any) -> None:
        self.evaluations += 1
        super().calculate(*given, **named)  # type: ignore[no-untyped-call]


class ByForces(PreconLBFGS):
    """ASE's ``PreconLBFGS``, preconditioned for any number of atoms, that goes by forces where energies have no digits.

    A line search compares energies.  Of a calculator in single precision they are known to 1e-7 of their sum over all
    atoms, which is more than the last steps gain: there a step is accepted if it takes away most of the force along it,
    and the log says so.

    Parameters
    ----------
    parts : calculators whose energies add up to that of the atoms.
    write : writes a text into the log.
    """

    def __init__(self, atoms: Atoms, parts: Sequence[Any], write: Callable[[str], object]) -> None:
        super().__init__(atoms, logfile=None, precon="Exp")  # type: ignore[no-untyped-call]
        self._parts, self._write, self._said = parts, write, False

    def line_search(self, r: Real, g: Real, e: float, previously_reset_hessian: bool) -> None:
        step = np.asarray(self.p).ravel()
        slope = float(g.ravel() @ step)
        if -slope > _DIGITS * self._rounding():
            super().line_search(r, g, e, previously_reset_hessian)  # type: ignore[no-untyped-call]
            return
        if not self._said:
            rounding = f"of which the energy has no more digits (rounding {self._rounding():.0e} eV)"
            self._write(f"{type(self).__name__}: steps are accepted by their forces from here on, {rounding}\n")
            self._said = True
        most = self.maxstep / float(np.abs(step).max())
        part = min(1.0, most)
        for _ in range(_TRIALS):
            left = float(self.fprime(r.ravel() + part * step) @ step)  # type: ignore[no-untyped-call]
            if abs(left) <= _LEFT * abs(slope) or part == most:
                break
            # The force along the step as a line: where it is zero, but not far beyond.
            part = min(part * (min(2.0, slope / (slope - left)) if left > slope else 2.0), most)
        self.p, self.alpha_k, self.e0, self.e1 = step, part, e, None

    def update(self, r: Real, f: Real, r0: Real, f0: Real) -> None:
        super().update(r, f, r0, f0)  # type: ignore[no-untyped-call]
        if self.rho and not 0 < self.rho[-1] < np.inf:  # no curvature along this step: it tells nothing
            del self.s[-1], self.y[-1], self.rho[-1]

    def _rounding(self) -> float:
        """Rounding of the energy, in eV: single precision where a calculator gives a number that it holds."""
        energies = [float(part.results.get("energy", 0.0)) for part in self._parts]
        types = [np.float32 if in_single_precision(energy) else np.float64 for energy in energies]
        return sum(float(np.finfo(of).eps) * abs(energy) for of, energy in zip(types, energies, strict=True))


def _times(matrices: Real, vectors: Real) -> Real:
    return np.asarray(np.einsum("aij,aj->ai", matrices, vectors))
