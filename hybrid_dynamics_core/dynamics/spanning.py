"""The spanning tree as an open chain: poses, Jacobian and recursive Newton-Euler, over any scalar.

All quantities are in link frames. A rotation takes link coordinates to those of the parent, or of
the base where a name says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..algebra.scalar import Scalar, Scalars
from ..algebra.transform import IDENTITY, RigidTransform, compose
from ..algebra.vector import (
    ZERO3,
    Rotation,
    Vector,
    add,
    cross,
    dot,
    matvec,
    scale,
    sub,
    transpose,
    transposed_matvec,
)
from ..mechanism.configuration import Configuration
from ..mechanism.joint_transform import (
    Column,
    jacobian_column,
    joint_transforms,
    pose_in_base,
    poses_in_base,
)
from ..mechanism.tree import Body, Tree

# force and moment about the link origin, in link axes
Wrench = tuple[Vector, Vector]
# angular velocity, angular acceleration and linear acceleration of the origin, in link axes
BodyMotion = tuple[Vector, Vector, Vector]


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

    def inverse_dynamics(self, gravity: Vector, ds: Scalars, dds: Scalars) -> list[Scalar]:
        """Forces along s that the open tree needs: M(s) s'' + C(s, s') s' + g(s).

        The tree's share of the DAE of Chu (2020), Eq. 10, by recursive Newton-Euler about the link
        origins. Gravity enters as an acceleration of the base.

        Args:
            gravity: (3,) [m/s^2], base axes.
            ds: s' (n_s,) [rad/s, m/s].
            dds: s'' (n_s,) [rad/s^2, m/s^2].

        Returns:
            Forces (n_s,) [N m, N].
        """
        return self.along_joints(self.transmitted(self.body_wrenches(gravity, ds, dds)))

    def body_wrenches(self, gravity: Vector, ds: Scalars, dds: Scalars) -> list[Wrench]:
        """The sum of all wrenches but gravity that each body needs for its motion.

        Args:
            gravity: (3,) [m/s^2], base axes.
            ds: s' (n_s,) [rad/s, m/s].
            dds: s'' (n_s,) [rad/s^2, m/s^2].

        Returns:
            Force [N] and moment [N m] of each body.
        """
        motions = self.motions(gravity, ds, dds)
        bodies = zip(self.tree.bodies, motions, strict=True)
        wrenches = [_newton_euler(body, *motion) for body, motion in bodies]
        if gravity == ZERO3 or not any(body.is_compensated for body in self.tree.bodies):
            return wrenches
        in_links = self.in_link_axes(gravity)
        for k, (body, local) in enumerate(zip(self.tree.bodies, in_links, strict=True)):
            wrenches[k] = total(wrenches[k], _compensated_weight(body, local))
        return wrenches

    def in_link_axes(self, direction: Vector) -> list[Vector]:
        """A vector (3,) in base axes, in the axes of each body."""
        in_links: list[Vector] = []
        for body, (rotation, _) in zip(self.tree.bodies, self.transforms, strict=True):
            around = direction
            if body.parent >= 0:
                around = in_links[body.parent]
            in_links.append(transposed_matvec(rotation, around))
        return in_links

    def motions(self, gravity: Vector, ds: Scalars, dds: Scalars) -> list[BodyMotion]:
        """Motions of all bodies, with gravity subtracted from linear accelerations.

        Args:
            gravity: (3,) [m/s^2], base axes.
            ds: s' (n_s,) [rad/s, m/s].
            dds: s'' (n_s,) [rad/s^2, m/s^2].
        """
        motions: list[BodyMotion] = []
        for body, (rotation, r) in zip(self.tree.bodies, self.transforms, strict=True):
            omega, alpha, accel = ZERO3, ZERO3, scale(-1.0, gravity)
            if body.parent >= 0:
                omega, alpha, accel = motions[body.parent]
            # acceleration of the parent at this body's origin, in the parent's axes
            accel = add(accel, matvec(acceleration_map(omega, alpha), r))
            to_child = transpose(rotation)
            omega = matvec(to_child, omega)
            alpha = matvec(to_child, alpha)
            accel = matvec(to_child, accel)
            # then the part of the joint
            rate = scale(ds[body.coordinate], body.axis)
            acceleration = scale(dds[body.coordinate], body.axis)
            if body.is_revolute:
                gyroscopic = cross(omega, rate)
                alpha = add(alpha, add(acceleration, gyroscopic))
                omega = add(omega, rate)
            else:
                coriolis = scale(2.0, cross(omega, rate))
                accel = add(accel, add(acceleration, coriolis))
            motions.append((omega, alpha, accel))
        return motions

    def transmitted(
        self, needed: Sequence[Wrench], applied: Mapping[int, Wrench] | None = None
    ) -> list[Wrench]:
        """The wrench that each joint transmits from the parent to its body.

        Args:
            needed: the sum of wrenches that each body needs, as `body_wrenches` gives it.
            applied: wrenches that act on bodies from elsewhere, by body.

        Returns:
            For each body, the wrenches that it and all bodies behind it need, minus those applied
            to them.
        """
        wrenches = list(needed)
        for i, wrench in (applied or {}).items():
            wrenches[i] = difference(wrenches[i], wrench)
        for i in range(len(wrenches) - 1, -1, -1):
            parent = self.tree.bodies[i].parent
            if parent >= 0:
                passed_on = self.to_parent(i, wrenches[i])
                wrenches[parent] = total(wrenches[parent], passed_on)
        return wrenches

    def to_parent(self, body: int, wrench: Wrench) -> Wrench:
        """A wrench on a body, about the parent's origin and in the parent's axes."""
        rotation, origin = self.transforms[body]
        force = matvec(rotation, wrench[0])
        moment = add(matvec(rotation, wrench[1]), cross(origin, force))
        return force, moment

    def along_joints(self, wrenches: Sequence[Wrench]) -> list[Scalar]:
        """The force [N] or moment [N m] of each joint along its axis (n_s,), in the order of s."""
        forces: list[Scalar] = [0.0] * len(self.tree.coordinates)
        for body, (force, moment) in zip(self.tree.bodies, wrenches, strict=True):
            transmitted = force
            if body.is_revolute:
                transmitted = moment
            forces[body.coordinate] = dot(body.axis, transmitted)
        return forces


def total(a: Wrench, b: Wrench) -> Wrench:
    """The sum of two wrenches about one point."""
    force_a, moment_a = a
    force_b, moment_b = b
    return add(force_a, force_b), add(moment_a, moment_b)


def difference(a: Wrench, b: Wrench) -> Wrench:
    """The difference of two wrenches about one point."""
    force_a, moment_a = a
    force_b, moment_b = b
    return sub(force_a, force_b), sub(moment_a, moment_b)


def _compensated_weight(body: Body, gravity: Vector) -> Wrench:
    """The compensated weight of a body, which `gravity` in `_newton_euler` included."""
    force = scale(body.compensated_mass, gravity)
    return force, cross(body.compensated_moment, gravity)


def _newton_euler(body: Body, omega: Vector, alpha: Vector, accel: Vector) -> Wrench:
    """The wrench that a body needs for its motion, about the link origin and in link axes.

    A point p accelerates by a + U p. With the second moments E, the moment of all points is
    h x a plus the integral of p x U p, which the products U E hold.
    """
    h = body.first_moment
    u = acceleration_map(omega, alpha)
    force = add(scale(body.mass, accel), matvec(u, h))
    x, y, z = body.about_origin  # columns too: E is symmetric
    u_x, u_y, u_z = u
    moment = (
        dot(u_z, y) - dot(u_y, z),
        dot(u_x, z) - dot(u_z, x),
        dot(u_y, x) - dot(u_x, y),
    )
    return force, add(moment, cross(h, accel))


def acceleration_map(omega: Vector, alpha: Vector) -> Rotation:
    """U (3, 3) of a rigid body: U r is the acceleration of a point beyond that of another one.

    Args:
        omega: angular velocity (3,) [rad/s].
        alpha: angular acceleration (3,) [rad/s^2], in the same axes.
    """
    x, y, z = omega
    ax, ay, az = alpha
    xx, yy, zz = x * x, y * y, z * z
    xy, xz, yz = x * y, x * z, y * z
    return (
        (-(yy + zz), xy - az, xz + ay),
        (xy + az, -(xx + zz), yz - ax),
        (xz - ay, yz + ax, -(xx + yy)),
    )
