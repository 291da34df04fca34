"""Linear solves with the Hessian of an equilibrium, K + φ''(z) at each point, and its normal stiffness by one of them.

Where the mean gap grows by one, the gap grows by v(x) of mean one, such that K v + φ''(z) v is the same everywhere: it
is what the load falls by, per area.  The Hessian is not formed; each step asks for one product with it, a pair of
transforms, preconditioned by 1/(K + c0) as the solver is.  MINRES takes Hessians that are not positive, too (Paige and
Saunders, SIAM J. Numer. Anal. 12, 617 (1975)): a load-controlled surface may be unstable where its stiffness is asked.
"""

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate

ACCURACY = 1e-6
"""Residual at which to stop, relative; the error of the stiffness is of its square."""
ITERATIONS = 2000
SHIFT = 0.01
"""c0 of the preconditioner, in E* over the spacing of the grid."""


def solve_hessian(
    grid: Grid,
    stiffness_q: Real,
    stiffness: Real,
    right: Real,
    shift: float = SHIFT,
    accuracy: float = ACCURACY,
    *,
    mean_free: bool = True,
) -> Real:
    """The displacement x without mean for which K x + φ'' x is a given field, but for its mean: P (K + φ'') P x = P r.

    Parameters
    ----------
    grid, stiffness_q : of the surface; K over the half spectrum, in E*/a0.  At q = 0 it does not count.
    stiffness : φ'' at each point, shape ``grid.shape``, in E*/a0.
    right : r, shape ``grid.shape``, in E*; its mean does not count.
    shift : c0 of the preconditioner, in E* over the spacing of the grid.
    accuracy : residual at which to stop, relative.
    mean_free : False where the mean is an unknown as all others: K counts at q = 0, where it is finite, and the mean of
        r; P is left out.

    Returns
    -------
    Real
        x, shape ``grid.shape``, in a0; NaN everywhere if the solve does not converge.
    """
    K = np.array(stiffness_q)
    if mean_free:
        K[0, 0] = 0.0

    def project(field: Real) -> Real:
        return field - grid.mean(field) if mean_free else field

    def product(v: NDArray[np.float64]) -> NDArray[np.float64]:
        return project(_product(grid, K, stiffness, project(v.reshape(grid.shape)))).ravel()

    def smooth(v: NDArray[np.float64]) -> NDArray[np.float64]:
        spectrum = grid.forward(v.reshape(grid.shape)) / (K + max(shift / grid.widest_step, float(-stiffness.min())))
        return grid.inverse(spectrum, overwrite=True).ravel()

    linalg, size = scipy.sparse.linalg, (grid.size, grid.size)
    found, failed = linalg.minres(
        linalg.LinearOperator(size, matvec=product, dtype=np.float64), project(right).ravel(),
        M=linalg.LinearOperator(size, matvec=smooth, dtype=np.float64), rtol=accuracy, maxiter=ITERATIONS,
    )  # fmt: skip
    return np.full(grid.shape, np.nan) if failed else project(found.reshape(grid.shape))


def tangent_stiffness(grid: Grid, stiffness_q: Real, law: Law, gap: Real, shift: float = SHIFT) -> float:
    """k_N = -dN/d(mean gap) per A0 of an equilibrium, in E*/a0; NaN where the linear solve does not converge.

    Parameters
    ----------
    grid, stiffness_q : of the surface; K over the half spectrum, in E*/a0.  At q = 0 it does not count.
    law : of the wall.
    gap : of the equilibrium, shape ``grid.shape``, in a0.
    shift : c0 of the preconditioner, in E* over the spacing of the grid.
    """
    stiffness = evaluate(law, gap)[2]
    K = np.array(stiffness_q)
    K[0, 0] = 0.0
    field = 1.0 - solve_hessian(grid, stiffness_q, stiffness, stiffness, shift)
    return float(grid.mean(field * _product(grid, K, stiffness, field)))


def _product(grid: Grid, K: Real, stiffness: Real, field: Real) -> Real:
    """K v + φ'' v."""
    return grid.inverse(K * grid.forward(field), overwrite=True) + stiffness * field
