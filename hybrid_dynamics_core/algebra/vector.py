"""Vectors (tuples of 2 or 3 scalars) and rotations (tuples of 3 rows) over any scalar type.

Plain tuples keep structural zeros visible: a traced product with the constant 0.0 vanishes from the
kernel.
"""

from __future__ import annotations

from collections.abc import Iterable

from .scalar import Scalar

Vector = tuple[Scalar, ...]
Rotation = tuple[Vector, Vector, Vector]  # rows

ZERO3: Vector = (0.0, 0.0, 0.0)
IDENTITY3: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def add(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def sub(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scale(k: Scalar, a: Vector) -> Vector:
    """k a."""
    return tuple(k * x for x in a)


def dot(a: Vector, b: Vector) -> Scalar:
    """a . b."""
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> Vector:
    """a x b, in three dimensions."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def perp(a: Vector) -> Vector:
    """The plane vector a turned by +90 degrees."""
    return (-a[1], a[0])


def cross2(a: Vector, b: Vector) -> Scalar:
    """The out-of-plane component of a x b for plane vectors."""
    return a[0] * b[1] - a[1] * b[0]


def turn(c: Scalar, s: Scalar, a: Vector) -> Vector:
    """The plane vector a turned by the angle with cosine c and sine s."""
    return (c * a[0] - s * a[1], s * a[0] + c * a[1])


def matvec(m: Rotation, a: Vector) -> Vector:
    """M a."""
    return (dot(m[0], a), dot(m[1], a), dot(m[2], a))


def transposed_matvec(m: Rotation, a: Vector) -> Vector:
    """M^T a."""
    return matvec(transpose(m), a)


def transpose(m: Rotation) -> Rotation:
    """M^T."""
    return ((m[0][0], m[1][0], m[2][0]), (m[0][1], m[1][1], m[2][1]), (m[0][2], m[1][2], m[2][2]))


def matmul(a: Rotation, b: Rotation) -> Rotation:
    """A B."""
    bt = transpose(b)
    return tuple(tuple(dot(row, column) for column in bt) for row in a)  # type: ignore[return-value]


def axis_rotation(axis: Vector, c: Scalar, s: Scalar) -> Rotation:
    """Rotation about a constant unit axis by the angle with cosine c and sine s (Rodrigues)."""
    x, y, z = axis
    if x == y == 0.0:  # the coordinate axes, written out: no products with constants remain
        return ((c, -z * s, 0.0), (z * s, c, 0.0), (0.0, 0.0, 1.0))
    if x == z == 0.0:
        return ((c, 0.0, y * s), (0.0, 1.0, 0.0), (-y * s, 0.0, c))
    if y == z == 0.0:
        return ((1.0, 0.0, 0.0), (0.0, c, -x * s), (0.0, x * s, c))
    k = 1.0 - c
    return (
        (c + k * (x * x), k * (x * y) - s * z, k * (x * z) + s * y),
        (k * (x * y) + s * z, c + k * (y * y), k * (y * z) - s * x),
        (k * (x * z) - s * y, k * (y * z) + s * x, c + k * (z * z)),
    )


def constant(values: Iterable[float]) -> Vector:
    """A tuple of Python floats, with rounding dust next to -1, 0 and 1 removed so that structure shows."""
    return tuple(_snap(float(v)) for v in values)


def _snap(v: float) -> float:
    for exact in (0.0, 1.0, -1.0):
        if abs(v - exact) < 1e-15:
            return exact
    return v
