"""Lengths, and linearly independent rows, of floats."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..ground.arrays import Array
from .live import is_live
from .scalar import Scalar, sqrt

REGULAR = 1e-9  # least singular value, over the largest, of a matrix that has an inverse


def norm(vector: ArrayLike) -> float:
    """Length of a vector of floats."""
    return float(np.linalg.norm(np.asarray(vector, dtype=float)))


def length(vector: Array) -> Scalar:
    """Length of a vector of any numbers."""
    if is_live(vector):
        return sqrt(vector @ vector)
    return norm(vector)


def independent_rows(
    matrix: Array, order: Sequence[int], least: ArrayLike, passes: int = 2
) -> list[int]:
    """Choose rows, one after the other, that are independent of those before (Gram-Schmidt).

    Args:
        matrix: (m, n).
        order: indices of the rows, preferred ones first.
        least: norm that a row must have left, outside of that span; a number or (m,).
        passes: how often each row is orthogonalised; two passes make it orthogonal to rounding.

    Returns:
        The chosen rows, at most n.
    """
    limits = np.broadcast_to(least, len(matrix))
    basis: list[Array] = []
    chosen: list[int] = []
    for k in order:
        remainder = matrix[k].copy()
        for _ in range(passes):
            for direction in basis:
                remainder -= (direction @ remainder) * direction
        size = norm(remainder)
        if size > limits[k] and len(chosen) < matrix.shape[1]:
            basis.append(remainder / size)
            chosen.append(k)
    return chosen


def null_space(matrix: Array, zero: float) -> Array:
    """An orthonormal basis (n, n - rank) of the vectors that a matrix maps to zero.

    Args:
        matrix: (m, n).
        zero: share of the largest singular value up to which one counts as zero.
    """
    if not len(matrix):
        return np.eye(matrix.shape[1])
    _, sizes, directions = np.linalg.svd(matrix)
    largest = sizes.max(initial=0.0)
    rank = int(np.count_nonzero(sizes > zero * largest))
    basis: Array = directions[rank:].T
    return basis


def is_regular(matrix: Array) -> bool:
    """Whether a square matrix (n, n) has an inverse, whatever units its rows and columns have."""
    rows = np.abs(matrix).max(axis=1, initial=0.0)
    if not rows.all():
        return False
    scaled = matrix / rows[:, None]
    columns = np.abs(scaled).max(axis=0, initial=0.0)
    if not columns.all():
        return False
    values = np.linalg.svd(scaled / columns, compute_uv=False)
    return bool(values[-1] > REGULAR * values[0])
