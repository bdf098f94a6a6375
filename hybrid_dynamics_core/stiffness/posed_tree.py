"""The spanning tree at a state, and displacements of its links as twists about the base origin."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..algebra.independence import norm
from ..closed_state.state import ClosedState
from ..closure.constraints.plane import plane_basis
from ..description.geometry import rotation_with_z_axis
from ..description.model import Closure, RobotDescription
from ..dynamics.spanning import TreeDynamics
from ..ground.arrays import Array
from ..mechanism.configuration import configuration_at
from ..mechanism.joint_transform import zero_rotation
from ..mechanism.tree import Tree, build_tree

LEAST_LENGTH = 0.1  # [m]


class Pose(NamedTuple):
    """Pose of a link or place in the base frame.

    Attributes:
        rotation: (3, 3) to base axes.
        origin: (3,) [m].
    """

    rotation: Array
    origin: Array

    def point(self, local: Array) -> Array:
        """A point (3,) of the link in the base frame [m]."""
        arm = self.rotation @ local
        place: Array = self.origin + arm
        return place

    def twists(self, displacements: Array) -> Array:
        """Twists (6, k) about the base origin of displacements (6, k) here, in its own axes.

        Linear before angular. The base origin, carried along, is displaced by d + p x turn.
        """
        linear = self.rotation @ displacements[:3]
        angular = self.rotation @ displacements[3:]
        carried = linear + skew(self.origin) @ angular
        return np.vstack([carried, angular])

    def displacements(self, twists: Array) -> Array:
        """Displacements (6, k) here, in its own axes, of twists (6, k) about the base origin."""
        angular = twists[3:]
        linear = twists[:3] - skew(self.origin) @ angular
        to_axes = self.rotation.T
        return np.vstack([to_axes @ linear, to_axes @ angular])


class PosedTree:
    """The spanning tree of a robot at a state.

    Attributes:
        description: description of the robot.
        tree: its spanning tree.
        length: distance from the base origin to the farthest joint, at least a tenth [m].
        s: all coordinates (n_s,) [rad, m].
    """

    def __init__(self, description: RobotDescription, tree: Tree, state: ClosedState) -> None:
        self.description = description
        self.tree = tree
        self.s = state.s
        charts = state.signs[len(state.signs) - len(tree.charts) :]
        self._configuration = configuration_at(tree, state.s, charts)
        self._poses: list[Pose] = []
        self.length = LEAST_LENGTH
        for rotation, origin in TreeDynamics(tree, self._configuration).poses():
            pose = Pose(np.array(rotation), np.array(origin))
            self._poses.append(pose)
            self.length = max(self.length, norm(pose.origin))

    def pose(self, body: int) -> Pose:
        """Pose of a body; -1 for the base."""
        if body < 0:
            return Pose(np.eye(3), np.zeros(3))
        return self._poses[body]

    def joint_twist(self, body: int) -> Array:
        """Twist (6,) about the base origin per unit of the joint that carries a body."""
        link = self.tree.bodies[body]
        rotation, origin = self._poses[body]
        axis = rotation @ np.array(link.axis)
        if not link.is_revolute:
            return np.concatenate([axis, np.zeros(3)])
        linear = np.cross(origin, axis)
        return np.concatenate([linear, axis])

    def joint_pose(self, body: int) -> Pose:
        """Axes of the joint that carries a body: z along it, x and y fixed to its parent."""
        link = self.tree.bodies[body]
        outer = self.pose(link.parent).rotation
        zero: Array = np.array(zero_rotation(link, self._configuration), dtype=float)
        along = rotation_with_z_axis(np.array(link.axis))
        origin = self._poses[body].origin
        return Pose(outer @ zero @ along, origin)

    def pin_pose(self, closure: Closure) -> Pose:
        """Place of a closure on its link a. z is its axis, or the normal of a planar loop."""
        a = self.tree.body_index(closure.link_a)
        b = self.tree.body_index(closure.link_b)
        on_a = self.pose(a)
        place = on_a.point(closure.point_a)
        if closure.kind != "planar":
            return Pose(on_a.rotation @ closure.rotation_a, place)
        path_a, path_b, ancestor = self.tree.branches(a, b)
        basis = plane_basis(self.tree, path_a + path_b, ancestor)
        outer = self.pose(ancestor).rotation
        return Pose(outer @ basis.T, place)


def pose_tree(description: RobotDescription, state: ClosedState) -> PosedTree:
    """The spanning tree of a description at a state."""
    tree = build_tree(description)
    return PosedTree(description, tree, state)


def skew(vector: Array) -> Array:
    """The matrix (3, 3) of the cross product with a vector (3,)."""
    matrix: Array = np.cross(np.eye(3), vector)
    return matrix
