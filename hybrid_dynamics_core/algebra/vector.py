"""Vectors (tuples of 2 or 3 scalars) and rotations (tuples of 3 rows) over any scalar type.

Plain tuples keep constant zeros visible: tracing drops a product with the constant 0.0.
"""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Real

from .scalar import Scalar, Scalars

Vector = tuple[Scalar, ...]
Rotation = tuple[Vector, Vector, Vector]  # rows

ZERO3: Vector = (0.0, 0.0, 0.0)
IDENTITY3: Rotation = (
    (1.0, 0.0, 0.0),
    (0.0, 1.0, 0.0),
    (0.0, 0.0, 1.0),
)
DUST = 1e-15  # rounding of constants that should be -1, 0 or 1


def add(a: Scalars, b: Scalars) -> Vector:
    """a + b."""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def sub(a: Scalars, b: Scalars) -> Vector:
    """a - b."""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scale(k: Scalar, a: Scalars) -> Vector:
    """k a."""
    return tuple(k * x for x in a)


def dot(a: Vector, b: Vector) -> Scalar:
    """a . b."""
    first, *others = zip(a, b, strict=True)
    total = first[0] * first[1]
    for x, y in others:
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> Vector:
    """a x b, in three dimensions."""
    ax, ay, az = a
    bx, by, bz = b
    return (
        ay * bz - az * by,
        az * bx - ax * bz,
        ax * by - ay * bx,
    )


def perp(a: Vector) -> Vector:
    """The plane vector a turned by +90 degrees."""
    x, y = a
    return (-y, x)


def cross2(a: Vector, b: Vector) -> Scalar:
    """The out-of-plane component of a x b for plane vectors."""
    return a[0] * b[1] - a[1] * b[0]


def turn(c: Scalar, s: Scalar, a: Vector) -> Vector:
    """The plane vector a turned by the angle with cosine c and sine s."""
    x, y = a
    return (
        c * x - s * y,
        s * x + c * y,
    )


def matvec(m: Rotation, a: Vector) -> Vector:
    """M a."""
    x, y, z = a
    (a11, a12, a13), (a21, a22, a23), (a31, a32, a33) = m
    return (
        a11 * x + a12 * y + a13 * z,
        a21 * x + a22 * y + a23 * z,
        a31 * x + a32 * y + a33 * z,
    )


def transposed_matvec(m: Rotation, a: Vector) -> Vector:
    """M^T a."""
    return matvec(transpose(m), a)


def transpose(m: Rotation) -> Rotation:
    """M^T."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return (
        (a, d, g),
        (b, e, h),
        (c, f, i),
    )


def matmul(a: Rotation, b: Rotation) -> Rotation:
    """A B."""
    columns = transpose(b)
    x, y, z = a
    return (matvec(columns, x), matvec(columns, y), matvec(columns, z))


def trace(m: Rotation) -> Scalar:
    """The sum of the diagonal of M."""
    x, y, z = m
    return x[0] + y[1] + z[2]


def axis_rotation(axis: Vector, c: Scalar, s: Scalar) -> Rotation:
    """Rotation about a constant unit axis by the angle with cosine c and sine s (Rodrigues).

    Coordinate axes have formulas of their own, without products with constants.
    """
    x, y, z = axis
    if x == y == 0.0:
        return (
            (c, -z * s, 0.0),
            (z * s, c, 0.0),
            (0.0, 0.0, 1.0),
        )
    if x == z == 0.0:
        return (
            (c, 0.0, y * s),
            (0.0, 1.0, 0.0),
            (-y * s, 0.0, c),
        )
    if y == z == 0.0:
        return (
            (1.0, 0.0, 0.0),
            (0.0, c, -x * s),
            (0.0, x * s, c),
        )
    k = 1.0 - c
    xy = k * (x * y)
    xz = k * (x * z)
    yz = k * (y * z)
    return (
        (c + k * (x * x), xy - s * z, xz + s * y),
        (xy + s * z, c + k * (y * y), yz - s * x),
        (xz - s * y, yz + s * x, c + k * (z * z)),
    )


def constant(values: Iterable[float]) -> Vector:
    """A tuple of Python floats; entries within rounding of -1, 0 or 1 are made exact."""
    return tuple(_without_dust(value) for value in values)


def _without_dust(value: Scalar) -> Scalar:
    if not isinstance(value, Real):
        return value  # an argument of a program
    value = float(value)
    for exact in (0.0, 1.0, -1.0):
        if abs(value - exact) < DUST:
            return exact
    return value
