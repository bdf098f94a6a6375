"""The nearest configuration to a target that is not reached, to full precision."""

from __future__ import annotations

import numpy as np

from ..ground.arrays import Array
from .ik_descent import Descent, Task, distinct
from .ik_problem import SAME, IKProblem, is_revolute

CANDIDATES = 4  # number of ends of the search to refine
MAX_ITERATIONS = 300
OPEN = 1e30  # [m^2] cost of a configuration in which a loop is open
FLAT = 1e-13  # gradient over the length of the task that counts as zero


def polished(problem: IKProblem, descent: Descent) -> Descent:
    """Refine the best ends of a search to minima.

    Damped least squares converge slowly if the residual is large. A quasi-Newton method finishes
    here.

    Args:
        problem: robot and target.
        descent: ends of the search.
    """
    order = np.argsort(descent.residual)
    closed = [k for k in order.tolist() if np.isfinite(descent.residual[k])]
    ends = distinct(descent.u[closed[: 4 * CANDIDATES]], is_revolute(problem.robot), SAME)
    if not ends:
        return descent
    solutions = [_minimum(problem.task, end) for end in ends[:CANDIDATES]]
    u = np.array(solutions)
    error, _, is_closed = problem.task.error(u)
    sizes = np.linalg.norm(error, axis=-1)
    residual = np.where(is_closed, sizes, np.inf)
    return Descent(u, residual, np.ones(len(u), dtype=bool), iterations=0)


def _minimum(task: Task, start: Array) -> Array:
    """The minimum (n,) of the squared error near a start, within the limits."""
    from scipy.optimize import minimize  # noqa: PLC0415  slow to import, and only this needs it

    def cost(u: Array) -> tuple[float, Array]:
        error, jacobian, is_closed = task.error_at(u)
        if not is_closed:
            return OPEN, np.zeros_like(u)
        return 0.5 * float(error @ error), -jacobian.T @ error

    bounds = list(zip(task.lower.tolist(), task.upper.tolist(), strict=True))
    options = {"maxiter": MAX_ITERATIONS, "ftol": 0.0, "gtol": FLAT * task.length**2}
    result = minimize(cost, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    minimum: Array = np.clip(result.x, task.lower, task.upper)
    return minimum
