"""Poses in Study's coordinates, and the equations of legs between points of two bodies.

A pose is a point x = (e, g) of a projective space of seven dimensions. Here e is the quaternion of
its rotation, up to a factor, and g that of its translation: t = 2 g conj(e) / (e . e). Study's
condition is e . g = 0. A leg of length d from a foot a to a tip b on the platform gives a quadric:

    |t + R b - a|^2 - d^2 = 0, times e . e

The seven quadrics of six legs and Study's condition have no other solutions with e . e other than
zero, over the complex numbers too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array

Complex = NDArray[np.complex128]
SIZE = 8  # homogeneous coordinates
QUADRICS = 7


class Legs(NamedTuple):
    """Six legs between two bodies, real or complex.

    Attributes:
        feet: anchor points on the base (6, 3) [m].
        tips: anchor points on the platform (6, 3) [m].
        squares: squared lengths (6,) [m^2].
    """

    feet: NDArray[np.inexact]
    tips: NDArray[np.inexact]
    squares: NDArray[np.inexact]

    def towards(self, other: Legs, share: float) -> Legs:
        """The legs at a share of the way to others."""
        moved = [(1.0 - share) * a + share * b for a, b in zip(self, other, strict=True)]
        return Legs(*moved)


def _components(v: NDArray[np.inexact]) -> tuple[NDArray[np.inexact], ...]:
    """Components x, y, z (...) of vectors (..., 3), and zeros (...)."""
    x, y, z = np.moveaxis(v, -1, 0)
    return x, y, z, 0.0 * x


def _before(v: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Matrices (..., 4, 4) of q -> v q for vectors v (..., 3)."""
    x, y, z, o = _components(v)
    rows = [
        [o, -x, -y, -z],
        [x, o, -z, y],
        [y, z, o, -x],
        [z, -y, x, o],
    ]
    stacked = [np.stack(row, axis=-1) for row in rows]
    return np.stack(stacked, axis=-2)


def _after(v: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Matrices (..., 4, 4) of q -> q v for vectors v (..., 3)."""
    x, y, z, o = _components(v)
    rows = [
        [o, -x, -y, -z],
        [x, o, z, -y],
        [y, -z, o, x],
        [z, y, -x, o],
    ]
    stacked = [np.stack(row, axis=-1) for row in rows]
    return np.stack(stacked, axis=-2)


def quadrics(legs: Legs) -> NDArray[np.inexact]:
    """Symmetric matrices (7, 8, 8) of the legs, then of Study's condition."""
    feet, tips, squares = legs
    kind = np.result_type(feet, tips, squares)
    result = np.zeros((QUADRICS, SIZE, SIZE), dtype=kind)
    moving = 2.0 * (_after(tips) - _before(feet))
    result[:6, :4, :4] = turning(legs)
    result[:6, 4:, 4:] = 4.0 * np.eye(4)
    result[:6, 4:, :4] = moving
    result[:6, :4, 4:] = np.swapaxes(moving, -1, -2)
    result[6, :4, 4:] = np.eye(4)
    result[6, 4:, :4] = np.eye(4)
    return result


def turning(legs: Legs) -> NDArray[np.inexact]:
    """Symmetric matrices (legs, 4, 4) of the part without translation."""
    feet, tips, squares = legs
    lengths = (feet * feet).sum(axis=-1) + (tips * tips).sum(axis=-1)
    constant = lengths - squares
    product = 2.0 * _before(feet) @ _after(tips)
    one_sided = constant[:, None, None] * np.eye(4) + product
    other_side = np.swapaxes(one_sided, -1, -2)
    return np.asarray(0.5 * (one_sided + other_side))


def pose(x: Array) -> tuple[Array, Array]:
    """Rotation (3, 3) and translation (3,) of real coordinates (8,)."""
    e, g = x[:4], x[4:]
    size = float(e @ e)
    w, vector = e[0], e[1:]
    skew = _before(vector)[1:, 1:]
    outer = np.outer(vector, vector)
    turn = (w * w - vector @ vector) * np.eye(3) + 2.0 * outer + 2.0 * w * skew
    # the vector part of g conj(e)
    product = w * g[1:] - g[0] * vector - np.cross(g[1:], vector)
    return turn / size, 2.0 * product / size
