"""The lowest eigenvalue of a Hessian that is known by its products: whether an equilibrium is a minimum.

A solver of gradients stops at a saddle as well, where symmetry keeps its start from sliding off: a flat surface under a
flat wall that attracts too strongly stays flat.  The Hessian is not formed.  Its products with a few fields are what
LOBPCG needs (Knyazev, SIAM J. Sci. Comput. 23, 517 (2001)).
"""

import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from continuum.model.fourier import Real

ITERATIONS = 60
"""Largest number of iterations; a negative eigenvalue mostly shows in the first few."""
Product = Callable[[Real], Real]


class Lowest(NamedTuple):
    """The lowest eigenvalue that was found, with its error."""

    eigenvalue: float
    """Rayleigh quotient, so that the exact eigenvalue is no higher."""
    error: float
    """Norm of the residual: an eigenvalue lies within this distance of the Rayleigh quotient."""
    mode: Real
    """Field of the eigenvector, mean square one."""
    products: int
    """Number of products with the Hessian."""


def lowest_eigenvalue(
    hessian: Product, start: Real, accuracy: float, smooth: Product | None = None, iterations: int = ITERATIONS
) -> Lowest:
    """The lowest eigenvalue of a symmetric operator on fields.

    Parameters
    ----------
    hessian : product with a field.
    start : a few fields, the first dimension counts them.
    accuracy : residual of the eigenvector at which to stop, in the unit of the eigenvalue.
    smooth : preconditioner, about the inverse of the operator and positive; None for none.
    iterations : largest number of them.
    """
    shape, size = start.shape[1:], start[0].size
    products = 0

    def operator(product: Product) -> scipy.sparse.linalg.LinearOperator:
        def on_vector(v: NDArray[np.float64]) -> NDArray[np.float64]:
            return product(v.reshape(shape)).ravel()

        return scipy.sparse.linalg.LinearOperator((size, size), matvec=on_vector, dtype=np.float64)

    def one_more(field: Real) -> Real:
        nonlocal products
        products += 1
        return hessian(field)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it stopped at the last iteration is in the error
        values, vectors = scipy.sparse.linalg.lobpcg(
            operator(one_more), start.reshape(len(start), size).T.copy(), M=smooth and operator(smooth),
            largest=False, maxiter=iterations, tol=accuracy,
        )  # fmt: skip
    mode = np.asarray(vectors[:, int(np.argmin(values))], dtype=np.float64).reshape(shape)
    mode *= np.sqrt(size) / np.linalg.norm(mode)
    image = one_more(mode)
    value = float(np.mean(mode * image))
    return Lowest(value, float(np.sqrt(np.mean((image - value * mode) ** 2))), mode, products)
