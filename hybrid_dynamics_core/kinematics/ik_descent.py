"""Damped least squares over the active coordinates, from several starts at once.

The Jacobian is that of the closed mechanism. So the loops stay closed in every iterate, and the
assembly modes do not change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from .pose import rotation_vector

Mask = NDArray[np.bool_]
# positions, rotations, Jacobians and status of a batch
Terms = tuple[Array, Array, Array, Array]

MAX_ITERATIONS = 200
# relative to the mean diagonal entry of J^T J
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-12, 1e6
# after a step that gains, and after one that does not, times so much
RELAXED, DAMPED = 0.1, 8.0
STARTS = 64
# share of the cost: a step with a smaller decrease makes no progress
CREEP = 1e-6
# number of consecutive steps without progress at which a start ends
PATIENCE = 8


class IKStatus(Enum):
    """Outcome of inverse kinematics for a target.

    OUT_OF_REACH is proven by a closed form that finds every solution, by the lengths of the links,
    or because no active joint moves a missing coordinate. LIMIT means that a solution was found
    only beyond the limits. NOT_FOUND is no proof: all starts of the search ended elsewhere.
    """

    SOLVED = "solved"
    OUT_OF_REACH = "out of reach"
    LIMIT = "joint limit"
    SINGULAR = "singular"
    NOT_FOUND = "not found"
    NOT_CONVERGED = "not converged"


@dataclass(frozen=True, eq=False)
class Task:
    """A target, and the coordinates of it to reach.

    Attributes:
        solve_terms: function from u (N, n) to position (N, 3), rotation (N, 3, 3), Jacobian
            (N, 6, n) and status (N,) of the end effector; from u (n,), the same without N.
        position: target position (3,) in the base frame [m].
        rotation: target rotation (3, 3) in the base frame.
        rows: indices among x, y, z and the three components of the rotation vector, in base axes.
        length: metres per radian of a rotation error [m].
        lower: lower limits (n,) of the active coordinates [rad, m].
        upper: upper limits (n,) of the active coordinates [rad, m].
    """

    solve_terms: Callable[[Array], Terms]
    position: Array
    rotation: Array
    rows: tuple[int, ...]
    length: float
    lower: Array
    upper: Array

    def error(self, u: Array) -> tuple[Array, Array, Mask]:
        """Remaining error at u (N, n).

        Returns:
            Error (N, rows) [m], its Jacobian (N, rows, n), and whether each state closes (N,).
        """
        position, rotation, jacobian, status = self.solve_terms(u)
        closed = status == 0
        turn = np.zeros_like(position)
        if max(self.rows) >= 3 and closed.any():
            backward = np.swapaxes(rotation[closed], -1, -2)
            turn[closed] = rotation_vector(self.rotation @ backward)
        move = self.position - position
        error = np.concatenate([move, self.length * turn], axis=-1)
        weights = np.repeat([1.0, self.length], 3)
        jacobian = jacobian * weights[:, None]
        return error[:, self.rows], jacobian[:, self.rows], closed

    def error_at(self, u: Array) -> tuple[Array, Array, bool]:
        """Remaining error at u (n,).

        Returns:
            Error (rows,) [m], its Jacobian (rows, n), and whether the state closes.
        """
        position, rotation, jacobian, status = self.solve_terms(u)
        rows = list(self.rows)
        is_closed = not status
        error = np.zeros(6)
        error[:3] = self.position - position
        if rows[-1] >= 3:
            jacobian = np.concatenate([jacobian[:3], self.length * jacobian[3:]])
            if is_closed:
                error[3:] = self.length * rotation_vector(self.rotation @ rotation.T)
        return error[rows], jacobian[rows], is_closed


@dataclass(frozen=True, eq=False)
class Descent:
    """The result of the descent from each start.

    Attributes:
        u: active coordinates (N, n) [rad, m].
        residual: root of the sum of the squares of the error (N,) [m]; infinite if not closed.
        settled: mask (N,) of starts that ended for lack of progress, not of iterations.
        iterations: number of iterations of the slowest start.
    """

    u: Array
    residual: Array
    settled: Mask
    iterations: int


def descend(
    task: Task, starts: Array, tolerance: float, max_iterations: int = MAX_ITERATIONS
) -> Descent:
    """Levenberg-Marquardt from every start, with steps shortened at limits and open loops.

    Args:
        task: the target.
        starts: active coordinates (N, n) to start from [rad, m].
        tolerance: a start with a residual below it ends at the first step without progress.
        max_iterations: largest number of iterations.
    """
    u = np.clip(starts, task.lower, task.upper)
    error, jacobian, closed = task.error(u)
    cost = _cost(error, closed)
    damping = np.full(len(u), FIRST_DAMPING)
    creeping = np.zeros(len(u), dtype=int)
    iteration = 0
    active = closed.copy()
    while active.any() and iteration < max_iterations:
        iteration += 1
        rows = np.flatnonzero(active)
        blocked = _at_limits(task, u[rows], jacobian[rows], error[rows])
        free_jacobian = np.where(blocked[:, None], 0.0, jacobian[rows])
        step = _step(free_jacobian, error[rows], damping[rows])
        trial = np.clip(u[rows] + step, task.lower, task.upper)
        trial_error, trial_jacobian, trial_closed = task.error(trial)
        trial_cost = _cost(trial_error, trial_closed)
        better = trial_cost < cost[rows]
        moved = rows[better]
        creeps = trial_cost[better] > (1.0 - CREEP) * cost[moved]
        creeping[moved] = np.where(creeps, creeping[moved] + 1, 0)
        u[moved] = trial[better]
        error[moved] = trial_error[better]
        jacobian[moved] = trial_jacobian[better]
        cost[moved] = trial_cost[better]
        damping[moved] = np.maximum(damping[moved] * RELAXED, LEAST_DAMPING)
        damping[rows[~better]] *= DAMPED
        residual = np.sqrt(cost[rows])
        can_gain = (damping[rows] < MOST_DAMPING) & (creeping[rows] < PATIENCE)
        reached = ~better & (residual < tolerance)
        active[rows] = can_gain & (residual > 0.0) & ~reached
    return Descent(u, np.sqrt(cost), ~active, iteration)


def _cost(error: Array, closed: Mask) -> Array:
    """Squared norm of the error (N,); infinite where a loop is open."""
    cost = np.einsum("ni,ni->n", error, error)
    return np.where(closed, cost, np.inf)


def _at_limits(
    task: Task,
    u: Array,
    jacobian: Array,
    error: Array,
) -> Mask:
    """Mask (N, n) of coordinates at a limit that the error pushes outward; steps keep them."""
    push = np.einsum("nij,ni->nj", jacobian, error)
    at_lower = (u <= task.lower) & (push < 0.0)
    at_upper = (u >= task.upper) & (push > 0.0)
    blocked: Mask = at_lower | at_upper
    return blocked


def _step(jacobian: Array, error: Array, damping: Array) -> Array:
    """Steps (N, n) of damped least squares."""
    normal = np.einsum("nij,nik->njk", jacobian, jacobian)
    n = normal.shape[1]
    size = np.trace(normal, axis1=1, axis2=2) / n
    added = damping * size + 1e-300
    normal = normal + added[:, None, None] * np.eye(n)
    gradient = np.einsum("nij,ni->nj", jacobian, error)
    solution = np.linalg.solve(normal, gradient[..., None])
    step: Array = solution[..., 0]
    return step


def starts_within(
    lower: Array,
    upper: Array,
    revolute: Sequence[bool],
    count: int,
) -> Array:
    """Starts (count, n) that fill the limits evenly, the same in every call.

    An unlimited angle counts as one turn, an unlimited length goes from -1 m to 1 m.
    """
    from scipy.stats import qmc  # noqa: PLC0415  slow to import, and only restarts need it

    reach = np.where(np.asarray(revolute), math.pi, 1.0)
    low = np.where(np.isfinite(lower), lower, -reach)
    high = np.where(np.isfinite(upper), upper, reach)
    sampler = qmc.Halton(len(lower), scramble=False)
    # the first point is a corner
    points = sampler.random(count + 1)[1:]
    shares = 0.02 + 0.96 * points
    starts: Array = low + shares * (high - low)
    return starts


def distinct(
    solutions: Array,
    revolute: Mask,
    tolerance: float,
) -> list[Array]:
    """Solutions without duplicates up to a tolerance; angles are compared modulo a turn."""
    result: list[Array] = []
    for u in solutions:
        differences = [_difference(u, other, revolute) for other in result]
        if all(np.abs(difference).max() > tolerance for difference in differences):
            result.append(u)
    return result


def _difference(a: Array, b: Array, revolute: Mask) -> Array:
    difference = a - b
    wrapped = np.remainder(difference + math.pi, 2.0 * math.pi) - math.pi
    return np.where(revolute, wrapped, difference)


def unwound(
    u: Array,
    near: Array,
    revolute: Mask,
    lower: Array,
    upper: Array,
) -> Array:
    """u with unlimited angles reduced by whole turns to within pi of `near`."""
    unlimited = revolute & ~np.isfinite(lower) & ~np.isfinite(upper)
    return np.where(unlimited, near + _difference(u, near, revolute), u)
