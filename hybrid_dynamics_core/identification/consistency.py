"""Physically consistent parameters: the nearest to measurements that bodies can have.

A body's ten parameters are physical exactly if its pseudo-inertia P = [[tr(J)/2 E - J, m c], [m
c^T, m]] is positive definite: Wensing, Kim and Slotine (2018), doi 10.1109/LRA.2017.2729659.
Measurements leave some combinations undetermined. These stay near a prior in the divergence
tr(P0^-1 P) - log det(P0^-1 P) - 4 of Lee, Wensing and Park (2020), doi 10.1109/TRO.2019.2926491. It
is convex, and a barrier of the feasible set. Newton's method solves the convex problem.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from ..ground.arrays import Array

ITERATIONS = 100  # for each weight
CONVERGED = 1e-6  # Newton decrement over the weight at which a minimum is accepted
SMALLEST = 1e-9  # least weight, as a share of the squared error
# Newton decrement over the weight or the squared error above which Newton failed
ROUNDING = 1e-5
SHORTEST = 1e-9  # smallest share of Newton's step in the line search
DECREASE = 0.1  # least decrease of the cost, as a share of the predicted one
# smallest over largest eigenvalue in the prior's coordinates; below it, the barrier is rounding
BORDER = 1e-12
FLAT = 1e-6  # least eigenvalue of a prior, as a share of the trace; a smaller one is increased
# [m] added to radii of gyration of a prior such as a slender rod, where one is zero
WIDENING = 0.05
_log = logging.getLogger(__name__)
_ENTRIES = tuple(combinations_with_replacement(range(3), 2))  # upper triangle, row by row


def pseudo_inertia(values: Array) -> Array:
    """P (4, 4) of ten parameters."""
    return np.asarray(np.tensordot(values, _BASIS, axes=1))


def _basis() -> Array:
    """P (10, 4, 4) of each parameter set to one, with the others zero."""
    basis = np.zeros((10, 4, 4))
    basis[0, 3, 3] = 1.0
    for k, matrix in enumerate(basis[1:4]):
        matrix[k, 3] = matrix[3, k] = 1.0
    for matrix, (i, j) in zip(basis[4:], _ENTRIES, strict=True):
        if i == j:
            matrix[:3, :3] = 0.5 * np.eye(3)
            matrix[i, i] = -0.5
        else:
            matrix[i, j] = matrix[j, i] = -1.0
    return basis


_BASIS = _basis()


@dataclass(frozen=True, eq=False)
class _MatrixVariable:
    """One body, or one positive number, in coordinates x in which its prior is the identity."""

    start: int
    to_parameters: Array  # (k, k): parameters = to_parameters x
    matrices: Array  # (k, d, d): X = sum of x_i matrices_i

    @property
    def columns(self) -> slice:
        """Its columns among all parameters."""
        end = self.start + len(self.to_parameters)
        return slice(self.start, end)

    @property
    def identity(self) -> Array:
        """(k,) the coordinates of its prior."""
        return np.asarray(np.einsum("kii->k", self.matrices))

    def matrix(self, x: Array) -> Array:
        """X (d, d) of the coordinates (p,) of all variables."""
        values = x[self.columns]
        return np.asarray(np.tensordot(values, self.matrices, axes=1))


_Variables = Sequence[_MatrixVariable]


def consistent(
    matrix: Array,
    target: Array,
    prior: Array,
    bodies: int,
    weight: float,
) -> Array:
    """Physical parameters that fit measurements, and stay near a prior where undetermined.

    They minimise |matrix pi - target|^2 / 2 + weight * divergence of pi from the prior.

    Args:
        matrix: (k, p) equations.
        target: (k,) their right-hand sides.
        prior: (p,) physical, or on the boundary. The first 10 `bodies` entries are inertial, the
            others positive numbers.
        bodies: number of bodies.
        weight: weight of the divergence.

    Returns:
        (p,) the parameters pi.
    """
    inertial = 10 * bodies
    variables = [_body(k, prior[k : k + 10]) for k in range(0, inertial, 10)]
    variables += [_number(k, prior[k]) for k in range(inertial, len(prior))]
    transform = _block_diagonal(variables, len(prior))
    equations = _triangle(matrix @ transform, target)
    x = np.concatenate([variable.identity for variable in variables])
    decrement = np.inf
    # If the best fit is no body, the minimum is near the boundary, where Newton's steps are short.
    # So the weight of the barrier starts large and is reduced (interior point method).
    error = _squared_error(equations, x)
    for stage in _weights(0.5 * error, weight):
        x, decrement = _minimised(variables, x, equations, stage)
        error = _squared_error(equations, x)
        if stage < SMALLEST * 0.5 * error:
            break  # a smaller weight would not change the fit
    if decrement > ROUNDING * max(stage, error):
        _log.warning(
            "physical parameters were not found to the end: the cost may be %.2g too high",
            decrement,
        )
    return np.asarray(transform @ x)


def _block_diagonal(variables: _Variables, size: int) -> Array:
    """(p, p): parameters = transform x."""
    transform = np.zeros((size, size))
    for variable in variables:
        place = variable.columns
        transform[place, place] = variable.to_parameters
    return transform


def _weights(misfit: float, last: float) -> list[float]:
    """Weights from the squared error down to the last, each a tenth of the previous one."""
    ratio = max(misfit, last) / last
    stages = max(0, math.ceil(math.log10(ratio)))
    return [last * 10.0**k for k in range(stages, -1, -1)]


def _minimised(
    variables: _Variables,
    x: Array,
    equations: Array,
    weight: float,
) -> tuple[Array, float]:
    """The minimum by damped Newton steps, and the last decrement."""
    cost = _cost(variables, x, equations, weight)
    decrement = np.inf
    for _ in range(ITERATIONS):
        step, decrement = _newton(variables, x, equations, weight)
        if decrement < CONVERGED * weight:
            break
        length = 1.0
        lower = _cost(variables, x + length * step, equations, weight)
        while not lower <= cost - DECREASE * length * decrement:
            length *= 0.5
            if length < SHORTEST:  # rounding hides a lower cost
                return x, decrement
            lower = _cost(variables, x + length * step, equations, weight)
        x = x + length * step
        cost = lower
    return x, decrement


def _squared_error(equations: Array, x: Array) -> float:
    """|matrix x - target|^2 of the equations [matrix, target]."""
    errors = equations @ np.append(x, -1.0)
    return float(np.square(errors).sum())


def _triangle(matrix: Array, target: Array) -> Array:
    """[R, Q^T target] (k, p + 1) of a QR decomposition: the same least squares with fewer rows."""
    equations = np.column_stack([matrix, target])
    return np.asarray(np.linalg.qr(equations, mode="r"))


def _cost(
    variables: _Variables,
    x: Array,
    equations: Array,
    weight: float,
) -> float:
    """The cost; infinite outside of the feasible set, and at its boundary up to rounding."""
    total = 0.5 * _squared_error(equations, x)
    for variable in variables:
        values = np.linalg.eigvalsh(variable.matrix(x))
        if not values[0] > BORDER * values[-1]:
            return np.inf
        logarithm = np.log(values).sum()
        total += weight * float(values.sum() - logarithm)
    return total


def _newton(
    variables: _Variables,
    x: Array,
    equations: Array,
    weight: float,
) -> tuple[Array, float]:
    """Newton's step and decrement, by least squares.

    Normal equations would lose the undetermined combinations to rounding. With X = C C^T and F_k =
    C^-1 M_k C^-T, tr X - log det X has the gradient <F_k, C^T C - E> and the Hessian <F_k, F_l>.
    The step s minimises |R s + r|^2 + weight |F s + C^T C - E|^2.
    """
    from scipy.linalg import solve_triangular  # noqa: PLC0415  slow to import

    size = len(x)
    residual = -(equations @ np.append(x, -1.0))
    rows = [np.column_stack([equations[:, :-1], residual])]
    root = np.sqrt(weight)
    rows += [root * _divergence_rows(variable, x) for variable in variables]
    system = np.concatenate(rows)
    matrix, target = system[:, :-1], system[:, -1]
    scale = 1.0 / np.linalg.norm(matrix, axis=0)
    reduced = _triangle(matrix * scale, target)[:size]
    triangle = reduced[:, :-1]
    image = reduced[:, -1]
    step = np.asarray(scale * solve_triangular(triangle, image))
    return step, float(image @ image)


def _divergence_rows(variable: _MatrixVariable, x: Array) -> Array:
    """[F, E - C^T C] (k, p + 1) of one variable, reduced to its k rows."""
    size = len(variable.to_parameters)
    factor = np.linalg.cholesky(variable.matrix(x))
    inverse = np.linalg.inv(factor)
    slopes = inverse @ variable.matrices @ inverse.T
    gap = np.eye(len(factor)) - factor.T @ factor
    matrix = slopes.reshape(size, -1).T
    reduced = _triangle(matrix, gap.ravel())[:size]
    rows = np.zeros((len(reduced), len(x) + 1))
    rows[:, variable.columns] = reduced[:, :-1]
    rows[:, -1] = reduced[:, -1]
    return rows


def _body(start: int, prior: Array) -> _MatrixVariable:
    p = pseudo_inertia(prior)
    smallest = np.linalg.eigvalsh(p)[0]
    is_flat = smallest < FLAT * np.trace(p)
    radius = WIDENING if is_flat else 0.0
    p[:3, :3] += p[3, 3] * radius**2 * np.eye(3)
    factor = np.linalg.cholesky(p)
    lower = np.linalg.inv(factor)
    basis = _symmetric_basis(4)
    whitened = np.array([lower @ e @ lower.T for e in _BASIS])
    to_x = np.tensordot(basis, whitened, axes=([1, 2], [1, 2]))
    return _MatrixVariable(start, np.linalg.inv(to_x), basis)


def _symmetric_basis(size: int) -> Array:
    """An orthonormal basis of the symmetric matrices (size, size)."""
    matrices = []
    for i in range(size):
        for j in range(i + 1):
            entry = 1.0 if i == j else np.sqrt(0.5)
            matrix = np.zeros((size, size))
            matrix[i, j] = matrix[j, i] = entry
            matrices.append(matrix)
    return np.array(matrices)


def _number(start: int, prior: float) -> _MatrixVariable:
    to_parameters = np.array([[prior]])
    return _MatrixVariable(start, to_parameters, np.ones((1, 1, 1)))
