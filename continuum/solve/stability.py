"""Whether an equilibrium is a minimum: the lowest eigenvalue of its Hessian, K + φ''(z) at each point.

Each product takes one pair of transforms, and LOBPCG is preconditioned by 1/(K + c0) as the solver is.
"""

from typing import NamedTuple

import numpy as np

from continuum.model.eigenvalue import lowest_eigenvalue
from continuum.model.fourier import Real
from continuum.model.grid import Grid

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
    grid: Grid,
    stiffness_q: Real,
    stiffness: Real,
    mean_stiffness: float | None = None,
    shift: float = 0.01,
    start: Real | None = None,
) -> Stability:
    """The lowest eigenvalue of v -> K v + φ'' v.

    Parameters
    ----------
    grid, stiffness_q : of the surface; K over the half spectrum, in E*/a0.
    stiffness : φ'' of the wall at the gap of the equilibrium, shape ``grid.shape``, in E*/a0.
    mean_stiffness : K at q = 0 instead of that of ``stiffness_q``; infinite holds the mean, which then is no unknown.
    shift : c0 of the preconditioner, in E*/a0.
    start : a displacement near to the mode, if one is known.
    """
    K = np.array(stiffness_q)
    K[0, 0] = stiffness_q[0, 0] if mean_stiffness is None else mean_stiffness
    held = bool(np.isinf(K[0, 0]))
    K[0, 0] = 0.0 if held else K[0, 0]
    softest = max(0.0, float(-stiffness.min()))

    def hessian(field: Real) -> Real:
        result = grid.inverse(K * grid.forward(field), overwrite=True) + stiffness * field
        return result - held * grid.mean(result)

    def smooth(field: Real) -> Real:
        spectrum = grid.forward(field) / (K + max(shift, softest))
        spectrum[0, 0] *= not held
        return grid.inverse(spectrum, overwrite=True)

    fields = np.random.default_rng(0).standard_normal((grid.size, min(_FIELDS, grid.size - 2))).T
    fields = np.ascontiguousarray(fields).reshape(-1, *grid.shape)
    fields[0] *= np.maximum(-stiffness, 0.0) + 1e-3  # where the wall softens
    fields = np.stack([smooth(field) for field in fields])
    if start is not None:
        fields[0] = start
    scale = max(softest, float(K[K > 0].min()))
    found = lowest_eigenvalue(hessian, fields, ACCURACY * scale, smooth)
    return Stability(*found, scale)
