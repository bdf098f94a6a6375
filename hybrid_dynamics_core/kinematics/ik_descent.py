"""Inverse kinematics over the active coordinates: damped least squares from several starts, all worked at once.

The Jacobian is the closed mechanism's, so the loops stay closed in every iterate and the assembly
branch is kept.
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
MAX_ITERATIONS = 200
DAMPING = (1e-3, 1e-12, 1e6)  # first, smallest, largest; relative to the diagonal of J^T J
STARTS = 64

CREEP, PATIENCE = (
    1e-6,
    8,
)  # a share of the cost; so many steps that gain less say that there is no more to gain


class IKStatus(Enum):
    """Why the solver stopped."""

    SOLVED = "solved"
    OUT_OF_REACH = "out of reach"
    LIMIT = "joint limit"
    SINGULAR = "singular"
    NOT_CONVERGED = "not converged"


@dataclass(frozen=True, eq=False)
class Task:
    """A target: `position` (3,) [m] and `rotation` (3, 3), of which the coordinates of `rows` count.

    rows: of x, y, z and the rotation vector's three parts, all in base axes; `length` [m] weighs a
    radian against metres. `solve_terms(u)` gives for (N, n): position (N, 3), rotation (N, 3, 3),
    Jacobian (N, 6, n), status (N,).
    """

    solve_terms: Callable[[Array], tuple[Array, Array, Array, Array]]
    position: Array
    rotation: Array
    rows: tuple[int, ...]
    length: float
    lower: Array
    upper: Array

    def error(self, u: Array) -> tuple[Array, Array, Mask]:
        """Error (N, rows) [m], its Jacobian (N, rows, n), and whether each state closes (N,)."""
        position, rotation, jacobian, status = self.solve_terms(u)
        good = status == 0
        turn = np.zeros_like(position)
        if max(self.rows) >= 3 and good.any():
            turn[good] = rotation_vector(self.rotation @ np.swapaxes(rotation[good], -1, -2))
        error = np.concatenate([self.position - position, self.length * turn], axis=-1)
        jacobian = jacobian * np.repeat([1.0, self.length], 3)[:, None]
        return error[:, self.rows], jacobian[:, self.rows], good


@dataclass(frozen=True, eq=False)
class Descent:
    """Where each start ended: u (N, n), residual (N,) [m], whether progress had ended (not the iterations)."""

    u: Array
    residual: Array
    settled: Mask
    iterations: int


def descend(task: Task, starts: Array, tolerance: float, most: int = MAX_ITERATIONS) -> Descent:
    """Levenberg-Marquardt on every start; steps that open a loop or leave the limits are shortened."""
    u = np.clip(starts, task.lower, task.upper)
    error, jacobian, good = task.error(u)
    cost = np.where(good, np.einsum("ni,ni->n", error, error), np.inf)
    damping = np.full(len(u), DAMPING[0])
    idle = np.zeros(len(u), dtype=int)  # steps in a row that hardly came nearer
    iteration = 0
    active = good.copy()
    while active.any() and iteration < most:
        iteration += 1
        rows = np.flatnonzero(active)
        held = _held(task, u[rows], jacobian[rows], error[rows])
        step = _step(np.where(held[:, None], 0.0, jacobian[rows]), error[rows], damping[rows])
        trial = np.clip(u[rows] + step, task.lower, task.upper)
        trial_error, trial_jacobian, trial_good = task.error(trial)
        trial_cost = np.where(trial_good, np.einsum("ni,ni->n", trial_error, trial_error), np.inf)
        better = trial_cost < cost[rows]
        moved = rows[better]
        idle[moved] = np.where(trial_cost[better] > (1.0 - CREEP) * cost[moved], idle[moved] + 1, 0)
        u[moved], error[moved], jacobian[moved] = (
            trial[better],
            trial_error[better],
            trial_jacobian[better],
        )
        cost[moved] = trial_cost[better]
        damping[moved] = np.maximum(damping[moved] * 0.1, DAMPING[1])
        damping[rows[~better]] *= 8.0
        active[rows] = (
            (damping[rows] < DAMPING[2]) & (np.sqrt(cost[rows]) > 0.0) & (idle[rows] < PATIENCE)
        )
        done = rows[~better & (np.sqrt(cost[rows]) < tolerance)]
        active[done] = False
    return Descent(u, np.sqrt(cost), ~active, iteration)


def _held(task: Task, u: Array, jacobian: Array, error: Array) -> Mask:
    """Coordinates at a limit that the error pushes further out (N, n): they do not take part in the step."""
    push = np.einsum("nij,ni->nj", jacobian, error)
    held: Mask = ((u <= task.lower) & (push < 0.0)) | ((u >= task.upper) & (push > 0.0))
    return held


def _step(jacobian: Array, error: Array, damping: Array) -> Array:
    normal = np.einsum("nij,nik->njk", jacobian, jacobian)
    size = np.trace(normal, axis1=1, axis2=2) / normal.shape[1]
    normal = normal + (damping * size + 1e-300)[:, None, None] * np.eye(normal.shape[1])
    right = np.einsum("nij,ni->nj", jacobian, error)
    step: Array = np.linalg.solve(normal, right[..., None])[..., 0]
    return step


def spread(lower: Array, upper: Array, revolute: Sequence[bool], count: int) -> Array:
    """Deterministic starts (count, n) that fill the box; an unlimited angle counts as one turn."""
    low = np.where(np.isfinite(lower), lower, -math.pi)
    high = np.where(np.isfinite(upper), upper, math.pi)
    low = np.where(~np.isfinite(lower) & ~np.asarray(revolute), -1.0, low)
    high = np.where(~np.isfinite(upper) & ~np.asarray(revolute), 1.0, high)
    from scipy.stats import qmc  # noqa: PLC0415  slow to import, and only restarts need it

    points: Array = qmc.Halton(len(lower), scramble=False).random(count + 1)[1:]
    starts: Array = low + (0.02 + 0.96 * points) * (high - low)
    return starts


def distinct(solutions: Array, revolute: Mask, tolerance: float) -> list[Array]:
    """Solutions that differ by more than the tolerance, angles compared modulo a turn."""
    kept: list[Array] = []
    for u in solutions:
        if all(np.abs(_difference(u, other, revolute)).max() > tolerance for other in kept):
            kept.append(u)
    return kept


def _difference(a: Array, b: Array, revolute: Mask) -> Array:
    d = a - b
    return np.where(revolute, np.remainder(d + math.pi, 2.0 * math.pi) - math.pi, d)


def unwound(u: Array, near: Array, revolute: Mask, lower: Array, upper: Array) -> Array:
    """Whole turns taken out of unlimited angles: each within pi of `near`."""
    free = revolute & ~np.isfinite(lower) & ~np.isfinite(upper)
    return np.where(free, near + _difference(u, near, revolute), u)
