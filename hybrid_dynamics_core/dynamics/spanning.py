"""The spanning tree as an open chain: link poses, geometric Jacobian and recursive Newton-Euler, over any scalar.

Link frames; a rotation takes link coordinates to the parent's (or the base's where it says so).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..algebra.scalar import Scalar
from ..algebra.transform import IDENTITY, RigidTransform, compose
from ..algebra.vector import ZERO3, Vector, add, cross, dot, matvec, scale, sub, transpose
from ..mechanism.configuration import Configuration
from ..mechanism.joint_transform import (
    Column,
    jacobian_column,
    joint_transforms,
    pose_in_base,
    poses_in_base,
)
from ..mechanism.tree import Body, Tree

Wrench = tuple[Vector, Vector]  # force and moment about the link origin, in link axes
BodyMotion = tuple[
    Vector, Vector, Vector
]  # angular velocity, angular and linear acceleration of the origin, link axes


class TreeDynamics:
    """The spanning tree at a configuration.

    Attributes:
        tree: the tree.
        transforms: pose of each body in the frame of its parent.
    """

    def __init__(self, tree: Tree, configuration: Configuration) -> None:
        self.tree = tree
        self.transforms = joint_transforms(tree, configuration)

    def pose(self, body: int) -> RigidTransform:
        """Rotation and origin of a body in the base frame (the base itself: -1)."""
        return pose_in_base(self.tree, self.transforms, body)

    def poses(self) -> list[RigidTransform]:
        """Rotation and origin of every body in the base frame."""
        return poses_in_base(self.tree, self.transforms)

    def jacobian(self, body: int, point: Vector) -> dict[int, Column]:
        """Velocity of a point of a body per unit rate, by coordinate on the path to the body.

        Args:
            body: index of the body, -1 for the base.
            point: the point (3,) [m], base frame.

        Returns:
            Linear velocity of the point and angular velocity (3,), base frame, by coordinate.
        """
        columns: dict[int, Column] = {}
        pose = IDENTITY
        for i in self.tree.path(body):
            link = self.tree.bodies[i]
            pose = compose(pose, self.transforms[i])
            rotation, origin = pose
            axis = matvec(rotation, link.axis)
            columns[link.coordinate] = jacobian_column(link, axis, origin, point)
        return columns

    def inverse_dynamics(
        self, gravity: Vector, ds: Sequence[Scalar], dds: Sequence[Scalar]
    ) -> list[Scalar]:
        """Forces along s that the open tree needs: M(s) s'' + C(s, s') s' + g(s), Chu (2020), Eq. 10.

        Recursive Newton-Euler about the link origins; gravity enters as an acceleration of the
        base.
        """
        return self.along_joints(self.transmitted(self.body_wrenches(gravity, ds, dds)))

    def body_wrenches(
        self, gravity: Vector, ds: Sequence[Scalar], dds: Sequence[Scalar]
    ) -> list[Wrench]:
        """What has to act on each body, gravity aside, for it to move so."""
        motions = self.motions(gravity, ds, dds)
        return [
            _newton_euler(b, *motion) for b, motion in zip(self.tree.bodies, motions, strict=True)
        ]

    def motions(
        self, gravity: Vector, ds: Sequence[Scalar], dds: Sequence[Scalar]
    ) -> list[BodyMotion]:
        """How each body moves, seen from a base that falls freely."""
        base = (ZERO3, ZERO3, scale(-1.0, gravity))
        motions: list[BodyMotion] = []
        for i, b in enumerate(self.tree.bodies):
            omega, alpha, accel = motions[b.parent] if b.parent >= 0 else base
            rotation, r = self.transforms[i]
            to_child = transpose(rotation)
            accel = add(accel, add(cross(alpha, r), cross(omega, cross(omega, r))))
            omega, alpha, accel = (matvec(to_child, v) for v in (omega, alpha, accel))
            step, ddq = scale(ds[b.coordinate], b.axis), scale(dds[b.coordinate], b.axis)
            if b.type == "revolute":
                alpha = add(alpha, add(ddq, cross(omega, step)))
                omega = add(omega, step)
            else:
                accel = add(accel, add(ddq, scale(2.0, cross(omega, step))))
            motions.append((omega, alpha, accel))
        return motions

    def transmitted(
        self, needed: Sequence[Wrench], applied: Mapping[int, Wrench] | None = None
    ) -> list[Wrench]:
        """What each joint passes on to its body: what it and all behind it need, less what is `applied` there."""
        wrenches = list(needed)
        for i, (force, moment) in (applied or {}).items():
            wrenches[i] = (sub(wrenches[i][0], force), sub(wrenches[i][1], moment))
        for i in range(len(wrenches) - 1, -1, -1):
            parent = self.tree.bodies[i].parent
            if parent >= 0:
                force, moment = self.to_parent(i, wrenches[i])
                wrenches[parent] = (
                    add(wrenches[parent][0], force),
                    add(wrenches[parent][1], moment),
                )
        return wrenches

    def to_parent(self, body: int, wrench: Wrench) -> Wrench:
        """A wrench on a body, about the parent's origin and in its axes."""
        rotation, origin = self.transforms[body]
        force = matvec(rotation, wrench[0])
        return force, add(matvec(rotation, wrench[1]), cross(origin, force))

    def along_joints(self, wrenches: Sequence[Wrench]) -> list[Scalar]:
        """The part of each joint's wrench along its axis, in the order of s."""
        forces: list[Scalar] = [0.0] * len(self.tree.coordinates)
        for b, (force, moment) in zip(self.tree.bodies, wrenches, strict=True):
            forces[b.coordinate] = dot(b.axis, moment if b.type == "revolute" else force)
        return forces


def _newton_euler(b: Body, omega: Vector, alpha: Vector, accel: Vector) -> Wrench:
    force = scale(b.mass, accel)
    force = add(
        force, add(cross(alpha, b.first_moment), cross(omega, cross(omega, b.first_moment)))
    )
    moment = add(matvec(b.inertia, alpha), cross(omega, matvec(b.inertia, omega)))
    return force, add(moment, cross(b.first_moment, accel))
