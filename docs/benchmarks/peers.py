"""The peers, each called so that it solves the same problem.  Each function runs in a process of its own.

Their surfaces are rigid below an elastic body above: heights and displacements have the other sign than ours.
Times run from the array of heights to the state, as ours do, after a small problem that loads everything.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from docs.benchmarks.cases import rough

__all__ = ["adhesion", "aspher", "contact_mechanics", "tamaas"]


def adhesion(
    n: int, seed: int, adhesion_length: float, mean_gap: float, pressure: float, gtol: float, save: str, **shape: float
) -> dict[str, Any]:
    """Adhesion's ``SmoothContactSystem`` at an offset that gives the mean gap.

    ``SmoothPotential`` of a 9-3 law with its minimum at a0 and stiffness E* a0/2 is exactly the paper's law;
    without a linear core the first step overshoots into z < 0.  Its mean mode has the stiffness of the longest wave,
    so that the offset for a mean gap needs the mean pressure, in E*, known from a solve before.  NuMPI's L-BFGS is the
    quicker of the two minimisers that its users have; SciPy's takes a fifth to a third longer.
    """
    from Adhesion.Interactions import LJ93, SmoothPotential
    from Adhesion.System import SmoothContactSystem
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from NuMPI.Optimization import l_bfgs
    from scipy.optimize import minimize
    from SurfaceTopography import Topography

    def cold(heights: np.ndarray, offset: float) -> tuple[np.ndarray, Any]:
        sizes = tuple(map(float, heights.shape))
        sigma = 2.5 ** (1 / 6)
        epsilon = 0.5 / (12 * sigma**9 - 12 * sigma**3)
        law = SmoothPotential(LJ93(epsilon, sigma), gamma=adhesion_length).linearize_core(r_ti=0.7)
        half_space = PeriodicFFTElasticHalfSpace(heights.shape, 1.0, sizes)
        system = SmoothContactSystem(half_space, law, Topography(-heights, sizes, periodic=True))
        limits = {"gtol": gtol, "ftol": 0.0, "maxiter": 20000}
        objective = system.objective(offset, gradient=True)
        result = minimize(objective, np.zeros(heights.size), method=l_bfgs, jac=True, options=limits)
        return system.compute_gap(result.x.reshape(heights.shape), offset), result

    cold(rough(64, 1).heights(), -2.0)
    heights = rough(n, seed, **shape).heights()
    offset = pressure / (np.pi / n) - mean_gap
    began = time.process_time()
    gap, result = cold(heights, offset)
    seconds = time.process_time() - began
    np.save(save, gap)
    return {"cpu": seconds, "iterations": int(result.nit), "converged": bool(result.success)}


def contact_mechanics(n: int, seed: int, lambda_s: float, pressure: float, pentol: float, save: str) -> dict[str, Any]:
    """ContactMechanics' constrained conjugate gradients (Polonsky and Keer) at a mean pressure."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import Topography

    def cold(heights: np.ndarray) -> Any:
        sizes = tuple(map(float, heights.shape))
        half_space = PeriodicFFTElasticHalfSpace(heights.shape, 1.0, sizes)
        system = NonSmoothContactSystem(half_space, Topography(-heights, sizes, periodic=True))
        return system.minimize_proxy(external_force=pressure * heights.size, pentol=pentol)

    cold(rough(64, 1, lambda_s=lambda_s).heights())
    heights = rough(n, seed, lambda_s=lambda_s).heights()
    began = time.process_time()
    result = cold(heights)
    seconds = time.process_time() - began
    np.save(save, np.asarray(result.jac))
    return {"cpu": seconds, "iterations": int(result.nit), "converged": bool(result.success)}


def tamaas(n: int, seed: int, lambda_s: float, pressure: float, tolerance: float, save: str) -> dict[str, Any]:
    """Tamaas' ``PolonskyKeerRey`` at a mean pressure; it does not tell its iterations."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)

    def cold(heights: np.ndarray) -> tuple[np.ndarray, float]:
        model = tm.ModelFactory.createModel(
            tm.model_type.basic_2d, list(map(float, heights.shape)), list(heights.shape)
        )
        model.E, model.nu = 1.0, 0.0
        solver = tm.PolonskyKeerRey(model, -heights, tolerance)
        solver.max_iter = 20000
        error = solver.solve(pressure)
        return np.array(model.traction), error

    cold(rough(64, 1, lambda_s=lambda_s).heights())
    heights = rough(n, seed, lambda_s=lambda_s).heights()
    began = time.process_time()
    traction, error = cold(heights)
    seconds = time.process_time() - began
    np.save(save, traction)
    return {"cpu": seconds, "iterations": None, "converged": bool(error <= tolerance)}


def aspher(n: int, seed: int, lambda_s: float, pressure: float, tolerance: float, save: str) -> dict[str, Any]:
    """ASPHER's nested grids on a periodic half-space at a mean pressure, with the settings that it has by default."""
    from aspher import solve_nested

    def cold(heights: np.ndarray) -> Any:
        points = len(heights)
        given = {"domain_size": float(points), "E_star": 1.0, "backend": "periodic", "tol": tolerance}
        return solve_nested(grid_size=points, gap=heights.ravel(), p_nominal=pressure, **given)

    cold(rough(128, 1, lambda_s=lambda_s).heights())
    heights = rough(n, seed, lambda_s=lambda_s).heights()
    began = time.process_time()
    result = cold(heights)
    seconds = time.process_time() - began
    np.save(save, np.asarray(result.pressure).reshape(heights.shape))
    return {"cpu": seconds, "iterations": int(result.iterations), "converged": result.status == "converged"}
