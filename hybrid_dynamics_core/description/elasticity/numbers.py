"""Checks of numbers and matrices of elasticity."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ...errors import InputError
from ...ground.arrays import Array, frozen
from ...ground.check_arguments import real_number
from ...ground.check_arrays import real_array

SYMMETRIC = 1e-9  # difference of mirrored entries, relative to their diagonal entries
DEFINITE = 1e-12  # least eigenvalue of a matrix scaled to a diagonal of ones


def positive(name: str, value: object, unit: str, what: str = "a finite number") -> float:
    """A finite number above zero.

    Raises:
        InputError: the value is no such number.
    """
    number = real_number(name, value)
    if not (number > 0.0 and math.isfinite(number)):
        raise InputError(f"{name} is {number:g} {unit}; expected {what} above zero")
    return number


def positive_or_rigid(name: str, value: object, unit: str) -> float:
    """A number above zero, infinite for rigid.

    Raises:
        InputError: the value is no such number.
    """
    number = real_number(name, value)
    if not number > 0.0:
        raise InputError(
            f"{name} is {number:g} {unit}; expected a stiffness above zero, or infinity for rigid"
        )
    return number


def stiffness_matrix(name: str, values: ArrayLike, *, definite: bool) -> Array:
    """A symmetric stiffness matrix (6, 6), linear before angular.

    Args:
        name: for messages.
        values: entries [N/m, N/rad, N m/rad].
        definite: whether each direction needs a stiffness.

    Raises:
        InputError: it is not (6, 6), not finite, not symmetric or indefinite.
    """
    matrix = real_array(name, values)
    if matrix.shape != (6, 6) or not np.isfinite(matrix).all():
        raise InputError(f"{name} has shape {matrix.shape}; expected 6 x 6 finite numbers")
    diagonal = np.diag(matrix)
    if (diagonal < 0.0).any():
        raise InputError(f"{name} has a negative entry on its diagonal; expected stiffnesses")
    sizes = np.sqrt(np.outer(diagonal, diagonal))
    if (np.abs(matrix - matrix.T) > SYMMETRIC * np.maximum(sizes, np.abs(matrix))).any():
        row, column = _largest(np.abs(matrix - matrix.T))
        raise InputError(
            f"{name} is not symmetric: entry [{row}][{column}] is {matrix[row, column]:g}, its"
            f" mirror {matrix[column, row]:g}"
        )
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    least = float(np.linalg.eigvalsh(matrix / np.outer(scale, scale)).min())
    if least < -DEFINITE:
        raise InputError(f"{name} is indefinite: a deformation would set energy free")
    if definite and not least > DEFINITE:
        raise InputError(f"{name} is singular; expected a stiffness in each of six directions")
    return frozen(0.5 * (matrix + matrix.T))


def _largest(values: Array) -> tuple[int, int]:
    """Row and column of the largest entry."""
    row, column = np.unravel_index(int(np.argmax(values)), values.shape)
    return int(row), int(column)
