"""Parameters that belong to bodies: the estimate nearest to the measurements among those that some body could have.

A body's ten parameters are physical exactly if its pseudo-inertia P = [[tr(J)/2 E - J, m c], [m c^T, m]] is positive
definite: Wensing, Kim and Slotine (2018), doi 10.1109/LRA.2017.2729659. The measurements leave some combinations open;
there the estimate stays near a prior in the divergence tr(P0^-1 P) - log det(P0^-1 P) - 4, which is convex and bars the
border: Lee, Wensing and Park (2020), doi 10.1109/TRO.2019.2926491. The whole is one convex problem for Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..description.model import Array

ITERATIONS = 200
CONVERGED = 1e-9  # Newton decrement, in units of the cost, at which the answer is taken
SHORTEST = 1e-9  # part of Newton's step that is still tried
SPREAD = 0.05  # [m] added to the radii of gyration of a prior that has some at zero, such as a slender rod
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

    The first 10 `bodies` are inertial, the rest positive numbers. `prior` (p,) is physical, or on the border of it.
    """
    blocks = [_body(10 * k, prior[10 * k : 10 * k + 10]) for k in range(bodies)]
    blocks += [_number(k, prior[k]) for k in range(10 * bodies, len(prior))]
    transform = np.zeros((len(prior), len(prior)))
    for block in blocks:
        transform[block.own, block.own] = block.to_x
    a = matrix @ transform
    normal, right = a.T @ a, a.T @ target
    x = np.concatenate([_identity(block) for block in blocks])
    cost = _cost(blocks, x, normal, right, weight)
    for _ in range(ITERATIONS):
        gradient, hessian = normal @ x - right, normal.copy()
        for block in blocks:
            slope, curvature = _divergence(block, x[block.own])
            gradient[block.own] += weight * slope
            hessian[block.own, block.own] += weight * curvature
        step = -_solve(hessian, gradient)
        decrement = float(-gradient @ step)
        if decrement < CONVERGED:
            break
        length = 1.0
        while not (lower := _cost(blocks, x + length * step, normal, right, weight)) <= cost - 0.1 * length * decrement:
            length *= 0.5
            if length < SHORTEST:  # rounding: there is nothing lower
                return np.asarray(transform @ x)
        x, cost = x + length * step, lower
    return np.asarray(transform @ x)


def _cost(blocks: list[_Block], x: Array, normal: Array, right: Array, weight: float) -> float:
    """The cost but for a constant; infinite beyond the border."""
    total = float(x @ (0.5 * normal @ x - right))
    for block in blocks:
        matrix = np.tensordot(x[block.own], block.matrices, axes=1)
        values = np.linalg.eigvalsh(matrix)
        if not values[0] > 0.0:
            return np.inf
        total += weight * float(values.sum() - np.log(values).sum())
    return total


def _solve(matrix: Array, right: Array) -> Array:
    """With rows and columns scaled: combinations that were measured outweigh the open ones by many orders."""
    scale = 1.0 / np.sqrt(np.diag(matrix))
    return np.asarray(scale * np.linalg.solve(scale[:, None] * matrix * scale, scale * right))


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


def _divergence(block: _Block, x: Array) -> tuple[Array, Array]:
    """Gradient and Hessian of tr X - log det X."""
    inverse = np.linalg.inv(np.tensordot(x, block.matrices, axes=1))
    turned = np.einsum("ij,kjl->kil", inverse, block.matrices)
    gradient = _identity(block) - np.einsum("kii->k", turned)
    return np.asarray(gradient), np.asarray(np.einsum("kij,lji->kl", turned, turned))
