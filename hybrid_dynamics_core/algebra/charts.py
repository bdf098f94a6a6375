"""Two charts that together cover all orientations of a ball or free joint.

The angles of R = C Rx(a) Ry(b) Rz(c) are singular at b = +-pi/2. The chart +1 has C = 1, the chart
-1 has C = Rz(pi/2). With n the third column of R, sin b is n_x in the chart +1 and n_y in the chart
-1. So in one of them |b| is at most pi/4.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array
from .scalar import Scalar, Scalars, atan2, cos, sin, sqrt
from .vector import Rotation, Vector

LEAVE: Final = 1.0  # [rad] |b| at which the chart changes; there it is below 0.58 in the other
FIRST: Final = 1.0
SECOND: Final = -1.0
_HALF_ROOT: Final = math.sqrt(0.5)
_TINY: Final = 1e-300  # keeps roots off zero, where their slopes have no value
_SINGULAR: Final = 1e-12  # cosine of b below which the axes of a and c coincide


def chart_rotation(chart: Scalar) -> Rotation:
    """C (3, 3) of a chart, +1 or -1."""
    cosine = 0.5 + 0.5 * chart
    sine = 0.5 - 0.5 * chart
    return (cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0)


class Turns(NamedTuple):
    """Cosines and sines of the second and third of three turns, scalars of any kind."""

    cos_b: Scalar
    sin_b: Scalar
    cos_c: Scalar
    sin_c: Scalar

    @classmethod
    def at(cls, angles: Array) -> Turns:
        """Cosines and sines of angles (..., 3) [rad], as arrays (...)."""
        b = angles[..., 1]
        c = angles[..., 2]
        return cls(
            np.cos(b),
            np.sin(b),
            np.cos(c),
            np.sin(c),
        )

    def axes(self) -> tuple[Vector, Vector, Vector]:
        """Columns of E in omega = E (a', b', c'): the axes of the turns, in the rotated frame."""
        return (
            (self.cos_b * self.cos_c, -self.cos_b * self.sin_c, self.sin_b),
            (self.sin_c, self.cos_c, 0.0),
            (0.0, 0.0, 1.0),
        )

    def bias(self, first: Scalars, second: Scalars) -> Vector:
        """The bias E' (a', b', c') as a symmetric bilinear form of two sets of rates.

        Args:
            first: rates (a', b', c') [rad/s].
            second: further rates [rad/s]. Equal rates give the angular acceleration (3,) [rad/s^2]
                at a'' = b'' = c'' = 0.
        """
        ab = _mixed(first, second, 0, 1)
        ac = _mixed(first, second, 0, 2)
        bc = _mixed(first, second, 1, 2)
        return (
            bc * self.cos_c - ab * (self.sin_b * self.cos_c) - ac * (self.cos_b * self.sin_c),
            ab * (self.sin_b * self.sin_c) - ac * (self.cos_b * self.cos_c) - bc * self.sin_c,
            ab * self.cos_b,
        )


def rotation_vector(angles: Scalars, chart: Scalar) -> Vector:
    """The axis of R times its angle (3,) [rad], at most pi; the same in both frames.

    Args:
        angles: (a, b, c) [rad].
        chart: +1 or -1.
    """
    cosine = 0.5 + 0.5 * chart
    sine = 0.5 - 0.5 * chart
    quaternion = (cosine + _HALF_ROOT * sine, 0.0, 0.0, _HALF_ROOT * sine)
    for axis, angle in enumerate(angles):
        half: list[Scalar] = [cos(0.5 * angle), 0.0, 0.0, 0.0]
        half[1 + axis] = sin(0.5 * angle)
        quaternion = _product(quaternion, half)
    w, x, y, z = quaternion
    sign = w / sqrt(w * w + _TINY)
    length = sqrt(x * x + y * y + z * z + _TINY)
    factor = sign * (2.0 * atan2(length, sign * w) / length)
    return factor * x, factor * y, factor * z


def _product(one: Scalars, other: Scalars) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """The product of two quaternions w, x, y, z."""
    aw, ax, ay, az = one
    bw, bx, by, bz = other
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def _mixed(first: Scalars, second: Scalars, i: int, k: int) -> Scalar:
    """Half of x_i y_k + y_i x_k: the product of two rates, polarised."""
    return 0.5 * (first[i] * second[k] + second[i] * first[k])


def rotation_of(angles: Array, charts: Array) -> Array:
    """R (..., 3, 3) of angles (..., 3) [rad] in charts (...)."""
    ca, cb, cc = np.moveaxis(np.cos(angles), -1, 0)
    sa, sb, sc = np.moveaxis(np.sin(angles), -1, 0)
    turned = _matrix(
        (cb * cc, -cb * sc, sb),
        (ca * sc + sa * sb * cc, ca * cc - sa * sb * sc, -sa * cb),
        (sa * sc - ca * sb * cc, sa * cc + ca * sb * sc, ca * cb),
    )
    return np.where(_in_first(charts), turned, _quarter_turned(turned, 1.0))


def angles_of(rotation: Array, charts: Array) -> Array:
    """Angles (..., 3) [rad] of R (..., 3, 3) in charts (...), |b| at most pi/2."""
    matrix = np.where(_in_first(charts), rotation, _quarter_turned(rotation, -1.0))
    cosine = np.hypot(matrix[..., 0, 0], matrix[..., 0, 1])
    b = np.arctan2(matrix[..., 0, 2], cosine)
    singular = cosine < _SINGULAR  # a and c turn about one axis: c is set to zero
    both = np.arctan2(matrix[..., 2, 1], matrix[..., 1, 1])
    a = np.arctan2(-matrix[..., 1, 2], matrix[..., 2, 2])
    c = np.arctan2(-matrix[..., 0, 1], matrix[..., 0, 0])
    a = np.where(singular, both, a)
    c = np.where(singular, 0.0, c)
    return np.stack([a, b, c], axis=-1)


def better_chart(rotation: Array) -> Array:
    """The chart (...) in which R (..., 3, 3) is farther from singular."""
    first = np.abs(rotation[..., 0, 2])
    second = np.abs(rotation[..., 1, 2])
    return np.where(first <= second, FIRST, SECOND)


def rate_matrix(angles: Array) -> Array:
    """E (..., 3, 3) in omega = E (a', b', c'), with omega in the rotated frame."""
    first, second, third = Turns.at(angles).axes()
    return _matrix(*zip(first, second, third, strict=True))


def angles_in(angles: Array, before: Array | float, after: Array | float) -> Array:
    """Convert angles (..., 3) [rad] from charts `before` (...) to charts `after` (...)."""
    rotation = rotation_of(angles, np.asarray(before))
    return angles_of(rotation, np.asarray(after))


def in_other_chart(
    angles: Array,
    rates: Array,
    before: Array,
    after: Array,
) -> tuple[Array, Array]:
    """Convert angles (..., 3) [rad] and rates [rad/s] from charts `before` to charts `after`.

    Where both charts (...) are the same, the values stay the same to the last bit.
    """
    turned = angles_in(angles, before, after)
    omega = rate_matrix(angles) @ rates[..., None]
    turned_rates = np.linalg.solve(rate_matrix(turned), omega)
    same = (before == after)[..., None]
    new_angles = np.where(same, angles, turned)
    new_rates = np.where(same, rates, turned_rates[..., 0])
    return new_angles, new_rates


def _in_first(charts: Array) -> NDArray[np.bool_]:
    mask: NDArray[np.bool_] = np.asarray(charts)[..., None, None] > 0.0
    return mask


def _quarter_turned(matrix: Array, sense: float) -> Array:
    """Rz(+-pi/2) times a matrix (..., 3, 3)."""
    turned = matrix.copy()
    turned[..., 0, :] = -sense * matrix[..., 1, :]
    turned[..., 1, :] = sense * matrix[..., 0, :]
    return turned


def _matrix(*rows: tuple[Scalar, Scalar, Scalar]) -> Array:
    """A matrix (..., 3, 3) of its entries (...); the first is an array, others may be floats."""
    matrix = np.empty((*np.shape(rows[0][0]), 3, 3))
    for i, row in enumerate(rows):
        for k, entry in enumerate(row):
            matrix[..., i, k] = entry
    return matrix
