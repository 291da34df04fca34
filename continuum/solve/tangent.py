"""The normal stiffness of an equilibrium by one linear solve with its Hessian, K + φ''(z) at each point.

Where the mean gap grows by one, the gap grows by v(x) of mean one, such that K v + φ''(z) v is the same everywhere: it
is what the load falls by, per area.  The Hessian is not formed; each step asks for one product with it, a pair of
transforms, preconditioned by 1/(K + c0) as the solver is.  MINRES takes Hessians that are not positive, too (Paige and
Saunders, SIAM J. Numer. Anal. 12, 617 (1975)): a load-controlled surface may be unstable where its stiffness is asked.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate

ACCURACY = 1e-6
"""Residual at which to stop, relative; the error of the stiffness is of its square."""
ITERATIONS = 2000


def tangent_stiffness(grid: Grid, stiffness_q: Real, law: Law, gap: Real, shift: float = 0.01) -> float:
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

    def hessian(field: Real) -> Real:
        return grid.inverse(K * grid.forward(field), overwrite=True) + stiffness * field

    def on_mean_free(v: NDArray[np.float64]) -> NDArray[np.float64]:
        field = v.reshape(grid.shape)
        image = hessian(field - grid.mean(field))
        return (image - grid.mean(image)).ravel()

    def smooth(v: NDArray[np.float64]) -> NDArray[np.float64]:
        spectrum = grid.forward(v.reshape(grid.shape)) / (K + max(shift / grid.widest_step, float(-stiffness.min())))
        return grid.inverse(spectrum, overwrite=True).ravel()

    linalg, size = scipy.sparse.linalg, (grid.size, grid.size)
    beyond, failed = linalg.minres(
        linalg.LinearOperator(size, matvec=on_mean_free, dtype=np.float64), (grid.mean(stiffness) - stiffness).ravel(),
        M=linalg.LinearOperator(size, matvec=smooth, dtype=np.float64), rtol=ACCURACY, maxiter=ITERATIONS,
    )  # fmt: skip
    if failed:
        return float("nan")
    field = beyond.reshape(grid.shape)
    field += 1.0 - grid.mean(field)
    return float(grid.mean(field * hessian(field)))
