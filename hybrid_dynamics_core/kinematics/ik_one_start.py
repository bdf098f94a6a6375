"""Damped least squares from one start, with the steps of `ik_descent` but without a batch.

Most targets are reached from the first start. A batch of one row would cost as much as one of some
hundred.
"""

from __future__ import annotations

import math

import numpy as np

from ..ground.arrays import Array
from .ik_descent import (
    CREEP,
    DAMPED,
    FIRST_DAMPING,
    LEAST_DAMPING,
    MOST_DAMPING,
    PATIENCE,
    RELAXED,
    Descent,
    Mask,
    Task,
)


def descend_from_one(task: Task, start: Array, tolerance: float, max_iterations: int) -> Descent:
    """Levenberg-Marquardt from one start, like `ik_descent.descend` from many.

    Args:
        task: the target.
        start: active coordinates (n,) [rad, m].
        tolerance: residual below which the first step without progress ends the search.
        max_iterations: largest number of iterations.
    """
    u = _within(task, start)
    error, jacobian, cost = _terms(task, u)
    damping = FIRST_DAMPING
    creeping = iteration = 0
    is_active = math.isfinite(cost)
    while is_active and iteration < max_iterations:
        iteration += 1
        free = np.where(_at_limits(task, u, jacobian, error), 0.0, jacobian)
        trial = _within(task, u + _step(free, error, damping))
        trial_error, trial_jacobian, trial_cost = _terms(task, trial)
        is_better = trial_cost < cost
        if is_better:
            creeps = trial_cost > (1.0 - CREEP) * cost
            creeping = creeping + 1 if creeps else 0
            u, error, jacobian, cost = trial, trial_error, trial_jacobian, trial_cost
            damping = max(damping * RELAXED, LEAST_DAMPING)
        else:
            damping *= DAMPED
        residual = math.sqrt(cost)
        can_gain = damping < MOST_DAMPING and creeping < PATIENCE
        is_reached = not is_better and residual < tolerance
        is_active = can_gain and residual > 0.0 and not is_reached
    return Descent(u[None], np.sqrt([cost]), np.array([not is_active]), iteration)


def _terms(task: Task, u: Array) -> tuple[Array, Array, float]:
    """Error (r,), its Jacobian (r, n) and its squared norm, which is infinite if a loop is open."""
    error, jacobian, is_closed = task.error_at(u)
    cost = float(error @ error)
    return error, jacobian, cost if is_closed else math.inf


def _within(task: Task, u: Array) -> Array:
    """Active coordinates (n,) clipped to the limits."""
    within: Array = np.minimum(np.maximum(u, task.lower), task.upper)
    return within


def _at_limits(task: Task, u: Array, jacobian: Array, error: Array) -> Mask:
    """Mask (n,) of coordinates at a limit whose gradient points outwards. No step moves them."""
    push = error @ jacobian
    at_lower = (u <= task.lower) & (push < 0.0)
    at_upper = (u >= task.upper) & (push > 0.0)
    blocked: Mask = at_lower | at_upper
    return blocked


def _step(jacobian: Array, error: Array, damping: float) -> Array:
    """The step (n,) of damped least squares."""
    normal = jacobian.T @ jacobian
    n = len(normal)
    size = float(normal.trace()) / n
    normal.flat[:: n + 1] += damping * size + 1e-300
    return np.asarray(np.linalg.solve(normal, error @ jacobian), dtype=np.float64)
