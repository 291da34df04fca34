"""Whether an equilibrium is a minimum: the lowest eigenvalue of its Hessian, K + φ''(z) at each point.

A solver of gradients stops at a saddle as well, where symmetry keeps its start from sliding off: a flat surface under a
flat wall that attracts too strongly stays flat.  The Hessian is not formed.  Its products with a few fields, one pair
of transforms each, are what LOBPCG needs (Knyazev, SIAM J. Sci. Comput. 23, 517 (2001)), preconditioned by
1/(K + c0) as the solver is.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, lobpcg

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.laws import Law, evaluate

ITERATIONS = 60
"""Largest number of iterations; a negative eigenvalue mostly shows in the first few."""
ACCURACY = 1e-3
"""Residual of the eigenvector at which to stop, relative to the largest softening of the law, or to K of long waves."""
_FIELDS = 3


class Stability(NamedTuple):
    """Lowest eigenvalue of the Hessian of an equilibrium, with its error."""

    eigenvalue: float
    """Rayleigh quotient in E*/a0, so that the exact eigenvalue is no higher."""
    error: float
    """The Hessian has an eigenvalue within so much of it, in E*/a0."""
    mode: Real
    """Displacement along which the energy curves least, shape of the grid, mean square one."""
    products: int
    """With the Hessian, a pair of transforms each."""
    scale: float
    """What the eigenvalue compares with, in E*/a0: the largest softening at this gap, or K of the longest wave."""

    @property
    def is_saddle(self) -> bool:
        """Whether the energy falls along the mode, beyond rounding: then it is no minimum, without doubt."""
        return self.eigenvalue < -1e-12 * self.scale


def stability(
    grid: Grid, stiffness_q: Real, law: Law, gap: Real, mean_stiffness: float | None = None, shift: float = 0.01
) -> Stability:
    """The lowest eigenvalue of v -> K v + φ''(gap) v.

    Parameters
    ----------
    grid, stiffness_q : of the surface; K over the half spectrum, in E*/a0.
    law : of the wall.
    gap : of the equilibrium, shape ``grid.shape``, in a0.
    mean_stiffness : K at q = 0 instead of that of ``stiffness_q``; infinite holds the mean, which then is no unknown.
    shift : c0 of the preconditioner, in E*/a0.
    """
    stiffness = evaluate(law, gap)[2]
    K = np.array(stiffness_q)
    K[0, 0] = stiffness_q[0, 0] if mean_stiffness is None else mean_stiffness
    held = bool(np.isinf(K[0, 0]))
    K[0, 0] = 0.0 if held else K[0, 0]
    products = 0

    def hessian(v: NDArray[np.float64]) -> NDArray[np.float64]:
        nonlocal products
        products += 1
        field = v.reshape(grid.shape)
        result = grid.inverse(K * grid.forward(field), overwrite=True) + stiffness * field
        return (result - held * grid.mean(result)).ravel()

    def smooth(v: NDArray[np.float64]) -> NDArray[np.float64]:
        spectrum = grid.forward(v.reshape(grid.shape)) / (K + max(shift, float(-stiffness.min())))
        spectrum[0, 0] *= not held
        return grid.inverse(spectrum, overwrite=True).ravel()

    start = np.random.default_rng(0).standard_normal((grid.size, min(_FIELDS, grid.size - 2)))
    start[:, 0] *= np.maximum(-stiffness, 0.0).ravel() + 1e-3  # where the wall softens
    start = np.stack([smooth(column) for column in start.T], axis=1)
    size = (grid.size, grid.size)
    scale = max(float(-stiffness.min()), float(K[K > 0].min()))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it stopped at the last iteration is in the error
        values, vectors = lobpcg(
            LinearOperator(size, matvec=hessian, dtype=np.float64), start,
            M=LinearOperator(size, matvec=smooth, dtype=np.float64),
            largest=False, maxiter=ITERATIONS, tol=ACCURACY * scale,
        )  # fmt: skip
    i = int(np.argmin(values))
    mode = np.asarray(vectors[:, i], dtype=np.float64) / np.linalg.norm(vectors[:, i])
    image = hessian(mode)
    value = float(mode @ image)
    error = float(np.linalg.norm(image - value * mode))
    return Stability(value, error, mode.reshape(grid.shape) * np.sqrt(grid.size), products, scale)
