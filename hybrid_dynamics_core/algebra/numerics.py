"""Algorithms that are not unrolled: the inverse of a larger matrix, and Newton's method.

Both take any scalar type. Symbols record a call as one node of the graph. The generated code calls
the same functions on floats or arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from .scalar import Scalar, Scalars

# (unknowns, parameters) -> residuals, then the Jacobian row by row
Body = Callable[[Scalars, Scalars], list[Scalar]]

Flags = NDArray[np.bool_]

MAX_ITERATIONS = 40
LARGEST_STEP = 0.5  # [rad or m] a longer step is shortened: the linear model does not hold that far
SMALL_STEP = 1e-9  # convergence is quadratic: after such a step only rounding is left
TINY = 1e-300


def invert(entries: Scalars, size: int) -> list[Scalar]:
    """Invert a square matrix.

    Args:
        entries: the matrix row by row, size * size scalars.
        size: number of rows.

    Returns:
        The inverse row by row, NaN where the matrix is singular.
    """
    symbol = _first_symbol(entries)
    if symbol is not None:
        result: list[Scalar] = symbol.graph.block("invert", size, size * size, [list(entries)])
        return result
    if any(isinstance(e, np.ndarray) for e in entries):
        return invert_columns(entries, size)
    return invert_floats(entries, size)


@np.errstate(all="ignore")  # the caller checks what is not finite
def invert_floats(entries: Sequence[float], size: int) -> list[float]:
    """`invert` of floats."""
    matrix = np.array(entries).reshape(size, size)
    try:
        inverse = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return [np.nan] * (size * size)
    flat: list[float] = inverse.ravel().tolist()
    return flat


@np.errstate(all="ignore")  # the caller checks what is not finite
def invert_columns(entries: Scalars, size: int) -> list[Scalar]:
    """`invert` of many matrices, one array an entry."""
    columns = np.broadcast_arrays(*entries)
    matrices = np.stack(columns, axis=-1).reshape(-1, size, size)
    regular = are_regular(matrices)
    inverse = np.full_like(matrices, np.nan)
    inverse[regular] = np.linalg.inv(matrices[regular])
    return [*inverse.reshape(-1, size * size).T]


def are_regular(matrices: Array) -> Flags:
    """Which matrices have an inverse, also where the determinant is too small for a float."""
    sign, logarithm = np.linalg.slogdet(matrices)
    return np.asarray((sign != 0.0) & np.isfinite(logarithm))


def newton(body: Body, guess: Scalars, parameters: Scalars) -> list[Scalar]:
    """Solve a square system of equations by Newton's method.

    Args:
        body: residuals and Jacobian of the system.
        guess: start of the unknowns.
        parameters: further inputs of the body.

    Returns:
        The unknowns, then the number of iterations: negative if Newton did not converge.
    """
    symbol = _first_symbol([*guess, *parameters])
    if symbol is not None:
        size = len(guess)
        arguments = [list(guess), list(parameters)]
        result: list[Scalar] = symbol.graph.block("newton", size, size + 1, arguments, body)
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
        jacobian = values[size:].reshape(size, size)
        try:
            step = np.linalg.solve(jacobian, values[:size])
        except np.linalg.LinAlgError:
            break
        largest = float(np.abs(step).max())
        if not largest < np.inf:
            break
        x = x - step * min(1.0, LARGEST_STEP / max(largest, TINY))
        if largest < SMALL_STEP:
            return [*x.tolist(), float(count)]
    return [*x.tolist(), -float(count)]


@np.errstate(all="ignore")  # the caller checks what is not finite
def newton_columns(body: Body, guess: Scalars, parameters: Scalars) -> list[Scalar]:
    """`newton` on arrays, one problem a column; each stops by itself."""
    size = len(guess)
    columns = np.broadcast_arrays(*guess, *parameters)
    x = np.array(columns[:size])
    constants = np.array(columns[size:]).reshape(len(parameters), x.shape[1])
    count = np.zeros(x.shape[1])
    converged = np.zeros(x.shape[1], dtype=bool)
    working = np.ones(x.shape[1], dtype=bool)
    for _ in range(MAX_ITERATIONS):
        rows = np.flatnonzero(working)
        if not len(rows):
            break
        step, finite = _newton_steps(body, x[:, rows], constants[:, rows])
        largest = np.abs(step).max(axis=0)
        shortened = step * np.minimum(1.0, LARGEST_STEP / np.maximum(largest, TINY))
        x[:, rows] -= np.where(finite, shortened, 0.0)
        count[rows] += 1.0
        converged[rows] = finite & (largest < SMALL_STEP)
        working[rows] = finite & ~converged[rows]
    return [*x, np.where(converged, count, -count)]


def _newton_steps(body: Body, x: Array, constants: Array) -> tuple[Array, Flags]:
    """Steps (size, k) at unknowns (size, k), and where they are finite (k,)."""
    size = len(x)
    results = body(list(x), list(constants))
    _, *columns = np.broadcast_arrays(x[0], *results)  # x[0] has the width of the batch
    values = np.array(columns)
    residuals = values[:size].T
    jacobian = np.moveaxis(values[size:], 0, -1).reshape(-1, size, size)
    finite = np.isfinite(values).all(axis=0) & are_regular(jacobian)
    jacobian[~finite] = np.eye(size)
    step = np.linalg.solve(jacobian, residuals[..., None])[..., 0]
    return step.T, finite


def _first_symbol(entries: Scalars) -> Any:
    return next((e for e in entries if hasattr(e, "graph")), None)
