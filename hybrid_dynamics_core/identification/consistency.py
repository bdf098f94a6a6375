"""Parameters that belong to bodies: the estimate nearest to the measurements among those that some body could have.

A body's ten parameters are physical exactly if its pseudo-inertia P = [[tr(J)/2 E - J, m c], [m
c^T, m]] is positive definite: Wensing, Kim and Slotine (2018), doi 10.1109/LRA.2017.2729659. The
measurements leave some combinations open; there the estimate stays near a prior in the divergence
tr(P0^-1 P) - log det(P0^-1 P) - 4, which is convex and bars the border: Lee, Wensing and Park
(2020), doi 10.1109/TRO.2019.2926491. The whole is one convex problem for Newton's method.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from ..ground.arrays import Array

ITERATIONS = 100  # for each weight
CONVERGED = 1e-6  # Newton decrement, in times of the weight, at which a minimum is taken
SMALLEST = 1e-9  # weight that still counts, as a share of the misfit
# Newton decrement, in times of the weight or the misfit, beyond which a minimum was missed
ROUNDING = 1e-5
SHORTEST = 1e-9  # part of Newton's step that is still tried
# smallest eigenvalue over the largest, in the prior's coordinates: below, the border is rounding
BORDER = 1e-12
# [m] added to the radii of gyration of a prior that has some at zero, such as a slender rod
SPREAD = 0.05
_log = logging.getLogger(__name__)
_INDEX = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def pseudo_inertia(values: Array) -> Array:
    """P (4, 4) of ten parameters."""
    return np.asarray(np.tensordot(values, _BASIS, axes=1))


def _basis() -> Array:
    """P of each parameter at one, the others zero: (10, 4, 4)."""
    basis = np.zeros((10, 4, 4))
    basis[0, 3, 3] = 1.0
    for k in range(3):
        basis[1 + k, k, 3] = basis[1 + k, 3, k] = 1.0
    for k, (i, j) in enumerate(_INDEX):
        if i == j:
            basis[4 + k, :3, :3] = 0.5 * np.eye(3)
            basis[4 + k, i, i] = -0.5
        else:
            basis[4 + k, i, j] = basis[4 + k, j, i] = -1.0
    return basis


_BASIS = _basis()


@dataclass(frozen=True, eq=False)
class _Block:
    """One body, or one positive number, in coordinates x in which its prior is the identity matrix."""

    start: int
    to_x: Array  # (k, k): parameters = to_x x
    matrices: Array  # (k, d, d): X = sum of x_i matrices_i

    @property
    def own(self) -> slice:
        """Its place among all parameters."""
        return slice(self.start, self.start + len(self.to_x))


def consistent(matrix: Array, target: Array, prior: Array, bodies: int, weight: float) -> Array:
    """Parameters (p,) that minimise |matrix pi - target|^2 / 2 + weight * divergence from the prior, all physical.

    The first 10 `bodies` are inertial, the rest positive numbers. `prior` (p,) is physical, or on
    the border of it.
    """
    blocks = [_body(10 * k, prior[10 * k : 10 * k + 10]) for k in range(bodies)]
    blocks += [_number(k, prior[k]) for k in range(10 * bodies, len(prior))]
    transform = np.zeros((len(prior), len(prior)))
    for block in blocks:
        transform[block.own, block.own] = block.to_x
    goal = _triangle(matrix @ transform, target)
    x, decrement = np.concatenate([_identity(block) for block in blocks]), np.inf
    # Where the best fit is no body, the minimum lies at the border; from afar Newton's steps would
    # creep along it. So the divergence counts for much at first, and then for ever less.
    for stage in _weights(0.5 * _square(goal, x), weight):
        x, decrement = _minimised(blocks, x, goal, stage)
        if stage < SMALLEST * 0.5 * _square(goal, x):
            break  # less changes nothing in the fit, and the border comes too near for rounding
    if decrement > ROUNDING * max(stage, _square(goal, x)):
        _log.warning(
            "physical parameters were not found to the end: the cost may be %.2g too high",
            decrement,
        )
    return np.asarray(transform @ x)


def _weights(misfit: float, last: float) -> list[float]:
    """From that of the misfit down to the last, a tenth each."""
    stages = max(0, math.ceil(math.log10(max(misfit, last) / last)))
    return [last * 10.0**k for k in range(stages, -1, -1)]


def _minimised(blocks: list[_Block], x: Array, goal: Array, weight: float) -> tuple[Array, float]:
    """By damped Newton steps, and the last decrement."""
    cost, decrement = _cost(blocks, x, goal, weight), np.inf
    for _ in range(ITERATIONS):
        step, decrement = _newton(blocks, x, goal, weight)
        if decrement < CONVERGED * weight:
            break
        length = 1.0
        while (
            not (lower := _cost(blocks, x + length * step, goal, weight))
            <= cost - 0.1 * length * decrement
        ):
            length *= 0.5
            if length < SHORTEST:  # nothing lower that rounding can tell
                return x, decrement
        x, cost = x + length * step, lower
    return x, decrement


def _square(goal: Array, x: Array) -> float:
    """|matrix x - target|^2."""
    return float(np.square(goal @ np.append(x, -1.0)).sum())


def _triangle(matrix: Array, target: Array) -> Array:
    """[R, Q^T target] (k, p + 1): the same sum of squares as (matrix, target), but for a constant, in few rows."""
    return np.asarray(np.linalg.qr(np.column_stack([matrix, target]), mode="r"))


def _cost(blocks: list[_Block], x: Array, goal: Array, weight: float) -> float:
    """The cost; infinite beyond the border, and where rounding cannot tell the border."""
    total = 0.5 * _square(goal, x)
    for block in blocks:
        values = np.linalg.eigvalsh(np.tensordot(x[block.own], block.matrices, axes=1))
        if not values[0] > BORDER * values[-1]:
            return np.inf
        total += weight * float(values.sum() - np.log(values).sum())
    return total


def _newton(blocks: list[_Block], x: Array, goal: Array, weight: float) -> tuple[Array, float]:
    """Newton's step and decrement, by least squares: squares of what was measured would drown the open combinations.

    With X = C C^T and F_k = C^-1 M_k C^-T, tr X - log det X has the gradient <F_k, C^T C - E> and
    the Hessian <F_k, F_l>: the step s has the smallest |R s + r|^2 + weight |F s + C^T C - E|^2.
    """
    size = len(x)
    rows = [np.column_stack([goal[:, :-1], -(goal @ np.append(x, -1.0))])]
    for block in blocks:
        factor = np.linalg.cholesky(np.tensordot(x[block.own], block.matrices, axes=1))
        inverse = np.linalg.inv(factor)
        slopes = (inverse @ block.matrices @ inverse.T).reshape(len(block.to_x), -1).T
        few = _triangle(slopes, (np.eye(len(factor)) - factor.T @ factor).ravel())[
            : len(block.to_x)
        ]
        own = np.zeros((len(few), size + 1))
        own[:, block.own], own[:, -1] = few[:, :-1], few[:, -1]
        rows.append(np.sqrt(weight) * own)
    matrix = np.concatenate(rows)
    scale = 1.0 / np.linalg.norm(matrix[:, :-1], axis=0)
    whole = _triangle(matrix[:, :-1] * scale, matrix[:, -1])[:size]
    triangle, image = whole[:, :-1], whole[:, -1]
    return np.asarray(scale * solve_triangular(triangle, image)), float(image @ image)


def _body(start: int, prior: Array) -> _Block:
    p = pseudo_inertia(prior)
    p[:3, :3] += p[3, 3] * SPREAD**2 * np.eye(3) * (np.linalg.eigvalsh(p)[0] < 1e-6 * np.trace(p))
    lower = np.linalg.inv(np.linalg.cholesky(p))
    matrices = []
    for i in range(4):
        for j in range(i + 1):
            unit = np.zeros((4, 4))
            unit[i, j] = unit[j, i] = 1.0 if i == j else np.sqrt(0.5)
            matrices.append(unit)
    basis = np.array(matrices)
    whitened = np.array([lower @ e @ lower.T for e in _BASIS])
    to_parameters = np.linalg.inv(np.tensordot(basis, whitened, axes=([1, 2], [1, 2])))
    return _Block(start, to_parameters, basis)


def _number(start: int, prior: float) -> _Block:
    return _Block(start, np.array([[prior]]), np.ones((1, 1, 1)))


def _identity(block: _Block) -> Array:
    return np.asarray(np.einsum("kii->k", block.matrices))
