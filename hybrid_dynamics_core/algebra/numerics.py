"""The two things that are not written out over scalars: the inverse of a larger matrix, and Newton's iteration.

Both take any scalar type. Symbols record them as one block of the graph, whose generated code calls
the same functions on floats or arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scalar import Scalar

Array = NDArray[np.float64]
Body = Callable[
    [Sequence[Scalar], Sequence[Scalar]], list[Scalar]
]  # (x, p) -> residuals, then the Jacobian row by row

MAX_ITERATIONS = 40
LARGEST_STEP = 0.5  # [rad or m] a longer step is shortened: the linear model does not hold that far
SMALL_STEP = 1e-9  # convergence is quadratic, so the step after this one is rounding


def invert(entries: Sequence[Scalar], size: int) -> list[Scalar]:
    """The inverse (row by row) and the determinant of a matrix given row by row; NaN where it is singular."""
    symbol = _symbol(entries)
    if symbol is not None:
        result: list[Scalar] = symbol.graph.block("invert", size, size * size + 1, [list(entries)])
        return result
    if any(isinstance(e, np.ndarray) for e in entries):
        return invert_columns(entries, size)
    return invert_floats(entries, size)


@np.errstate(all="ignore")  # what is not finite is told by the status
def invert_floats(entries: Sequence[float], size: int) -> list[float]:
    """`invert` of floats."""
    matrix = np.array(entries).reshape(size, size)
    try:
        return [*np.linalg.inv(matrix).ravel().tolist(), float(np.linalg.det(matrix))]
    except np.linalg.LinAlgError:
        return [np.nan] * (size * size) + [0.0]


@np.errstate(all="ignore")  # what is not finite is told by the status
def invert_columns(entries: Sequence[Scalar], size: int) -> list[Scalar]:
    """`invert` of many matrices, one array an entry."""
    matrices = np.stack(np.broadcast_arrays(*entries), axis=-1).reshape(-1, size, size)
    determinant = np.linalg.det(matrices)
    good = np.isfinite(determinant) & (determinant != 0.0)
    inverse = np.full_like(matrices, np.nan)
    inverse[good] = np.linalg.inv(matrices[good])
    return [*inverse.reshape(-1, size * size).T, determinant]


def newton(body: Body, guess: Sequence[Scalar], parameters: Sequence[Scalar]) -> list[Scalar]:
    """Solve body(x, p) residuals = 0 from a guess: x, then the number of iterations, negative if not converged."""
    symbol = _symbol([*guess, *parameters])
    if symbol is not None:
        size = len(guess)
        result: list[Scalar] = symbol.graph.block(
            "newton", size, size + 1, [list(guess), list(parameters)], body
        )
        return result
    if any(isinstance(e, np.ndarray) for e in (*guess, *parameters)):
        return newton_columns(body, guess, parameters)
    return newton_floats(body, guess, parameters)


def newton_floats(body: Body, guess: Sequence[float], parameters: Sequence[float]) -> list[float]:
    """`newton` on floats."""
    size = len(guess)
    x = np.array(guess)
    count = 0
    while count < MAX_ITERATIONS:
        count += 1
        values = np.array(body(x.tolist(), parameters))
        try:
            step = np.linalg.solve(values[size:].reshape(size, size), values[:size])
        except np.linalg.LinAlgError:
            break
        largest = float(np.abs(step).max())
        if not largest < np.inf:
            break
        x = x - step * min(1.0, LARGEST_STEP / max(largest, 1e-300))
        if largest < SMALL_STEP:
            return [*x.tolist(), float(count)]
    return [*x.tolist(), -float(count)]


@np.errstate(all="ignore")  # what is not finite is told by the status
def newton_columns(
    body: Body, guess: Sequence[Scalar], parameters: Sequence[Scalar]
) -> list[Scalar]:
    """`newton` on arrays, one problem a column; each stops for itself."""
    size = len(guess)
    full = np.broadcast_arrays(*guess, *parameters)
    x, known = np.array(full[:size]), np.array(full[size:])
    count = np.zeros(x.shape[1])
    converged, working = np.zeros(x.shape[1], dtype=bool), np.ones(x.shape[1], dtype=bool)
    for _ in range(MAX_ITERATIONS):
        rows = np.flatnonzero(working)
        if not len(rows):
            break
        values = np.array(
            np.broadcast_arrays(x[0, rows], *body(list(x[:, rows]), list(known[:, rows])))[1:]
        )
        jacobian = np.moveaxis(values[size:], 0, -1).reshape(-1, size, size)
        fine = np.isfinite(values).all(axis=0) & (np.abs(np.linalg.det(jacobian)) > 0.0)
        jacobian[~fine] = np.eye(size)
        step = np.linalg.solve(jacobian, values[:size].T[..., None])[..., 0].T
        largest = np.abs(step).max(axis=0)
        x[:, rows] -= np.where(
            fine, step * np.minimum(1.0, LARGEST_STEP / np.maximum(largest, 1e-300)), 0.0
        )
        count[rows] += 1.0
        converged[rows] = fine & (largest < SMALL_STEP)
        working[rows] = fine & ~converged[rows]
    return [*x, np.where(converged, count, -count)]


def _symbol(entries: Sequence[Scalar]) -> Any:
    return next((e for e in entries if hasattr(e, "graph")), None)
