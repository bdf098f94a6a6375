"""Poses over any scalar type: a rotation and an origin.

The rotation takes coordinates of an inner frame to those of an outer one. The origin is that of the
inner frame, in the outer one.
"""

from __future__ import annotations

from .vector import IDENTITY3, ZERO3, Rotation, Vector, add, matmul, matvec

RigidTransform = tuple[Rotation, Vector]
IDENTITY: RigidTransform = (IDENTITY3, ZERO3)


def compose(outer: RigidTransform, inner: RigidTransform) -> RigidTransform:
    """The pose of `inner`, which is given in the frame of `outer`, in the frame around both."""
    rotation, origin = outer
    inner_rotation, inner_origin = inner
    place = add(origin, matvec(rotation, inner_origin))
    return matmul(rotation, inner_rotation), place
