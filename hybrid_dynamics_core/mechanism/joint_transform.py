"""Forward kinematics over any scalar: of a joint, along a chain, of the whole tree.

Closures, dynamics, drawings and shapes all take their poses from here. A pose is a rotation (3, 3)
and an origin (3,) [m].
"""

from __future__ import annotations

from collections.abc import Sequence

from ..algebra.charts import chart_rotation
from ..algebra.transform import IDENTITY, RigidTransform, compose
from ..algebra.vector import (
    ZERO3,
    Rotation,
    Vector,
    add,
    axis_rotation,
    cross,
    matmul,
    matvec,
    scale,
    sub,
)
from .configuration import Configuration
from .tree import Body, Tree

Column = tuple[Vector, Vector]  # linear and angular velocity per unit rate of a coordinate


def joint_transform(body: Body, configuration: Configuration) -> RigidTransform:
    """The pose of a body in the frame of its parent."""
    k = body.coordinate
    if body.is_revolute:
        turn = axis_rotation(body.axis, configuration.c[k], configuration.s[k])
        return matmul(zero_rotation(body, configuration), turn), body.translation
    slide = scale(configuration.q[k], body.axis)
    return body.rotation, add(body.translation, matvec(body.rotation, slide))


def zero_rotation(body: Body, configuration: Configuration) -> Rotation:
    """The rotation (3, 3) of a body in its parent at zero, in the chart of its joint."""
    if body.chart is None or not configuration.charts:
        return body.rotation
    return matmul(body.rotation, chart_rotation(configuration.charts[body.chart]))


def joint_transforms(tree: Tree, configuration: Configuration) -> list[RigidTransform]:
    """The pose of every body in the frame of its parent."""
    return [joint_transform(body, configuration) for body in tree.bodies]


def through_joint(
    outer: RigidTransform, body: Body, configuration: Configuration
) -> tuple[RigidTransform, Vector]:
    """The pose of a body from that of its parent, and the axis of its joint.

    The pose is `compose(outer, joint_transform(body, configuration))`. Here the constants of the
    joint are multiplied in first: that takes fewer operations and gives the axis too.

    Args:
        outer: the pose of the parent in any frame.
        body: the child, with its joint.
        configuration: values of the coordinates.

    Returns:
        The pose of the child and its joint's axis (3,), both in that frame.
    """
    k = body.coordinate
    zero = zero_rotation(body, configuration)
    rotation, origin = compose(outer, (zero, body.translation))
    axis = matvec(rotation, body.axis)
    if body.is_revolute:
        turn = axis_rotation(body.axis, configuration.c[k], configuration.s[k])
        return (matmul(rotation, turn), origin), axis
    slide = scale(configuration.q[k], axis)
    return (rotation, add(origin, slide)), axis


def pose_in_base(tree: Tree, transforms: Sequence[RigidTransform], body: int) -> RigidTransform:
    """The pose of one body in the base frame.

    Args:
        tree: the tree.
        transforms: the pose of every body in the frame of its parent.
        body: index of the body, -1 for the base.
    """
    pose = IDENTITY
    for i in reversed(tree.path(body)):
        pose = compose(transforms[i], pose)
    return pose


def poses_in_base(tree: Tree, transforms: Sequence[RigidTransform]) -> list[RigidTransform]:
    """The pose of every body in the base frame.

    Args:
        tree: the tree.
        transforms: the pose of every body in the frame of its parent.
    """
    poses: list[RigidTransform] = []
    for body, transform in zip(tree.bodies, transforms, strict=True):
        outer = IDENTITY
        if body.parent >= 0:
            outer = poses[body.parent]
        poses.append(compose(outer, transform))
    return poses


def jacobian_column(body: Body, axis: Vector, origin: Vector, point: Vector) -> Column:
    """Velocity that a joint gives to a point behind it, per unit rate.

    Args:
        body: the body that the joint carries.
        axis: axis of the joint (3,).
        origin: a point on the axis (3,) [m].
        point: the point (3,) [m], all in one frame.

    Returns:
        Linear velocity of the point and angular velocity, in that frame.
    """
    if body.is_revolute:
        return cross(axis, sub(point, origin)), axis
    return axis, ZERO3
