"""Poses and twists of ball and free joints, and their coordinates and rates.

The pose is that of the child in the joint's frame: the frame where the child stands at zero. The
twist is linear velocity of the child's origin, then angular velocity, both relative to the parent
and in the axes of the child, as in nav_msgs/Odometry. A ball joint has the angular part alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..algebra.charts import Turns, angles_of, better_chart, rate_matrix, rotation_of
from ..description.model import RobotDescription
from ..ground.arrays import Array
from ..mechanism.tree import Tree
from .pose import Pose

TWIST = 6


@dataclass(frozen=True, eq=False)
class FreelyTurning:
    """A ball or free joint as its coordinates see it.

    Attributes:
        name: of the joint.
        chart: index of its chart among those of the tree.
        slides: its three sliding coordinates, none of a ball joint.
        turns: its three turning coordinates.
        frame: (3, 3) axes of slides and turns in the joint's frame.
    """

    name: str
    chart: int
    slides: tuple[int, ...]
    turns: tuple[int, ...]
    frame: Array

    @property
    def coordinates(self) -> list[int]:
        """All its coordinates, slides first."""
        return [*self.slides, *self.turns]

    def pose(self, s: Array, charts: Array) -> Pose:
        """Pose of the child in the joint's frame.

        Args:
            s: all coordinates (..., n_s) [rad, m].
            charts: of all ball and free joints (..., c).
        """
        turned = rotation_of(s[..., self.turns], charts[..., self.chart])
        rotation = self.frame @ turned @ self.frame.T
        position = np.zeros(rotation.shape[:-1])
        if self.slides:
            position = s[..., self.slides] @ self.frame.T
        return Pose(position, rotation)

    def coordinates_at(self, pose: Pose) -> tuple[Array, Array]:
        """Coordinates (..., 3 or 6) [m, rad] of a pose, and the better chart (...) for it."""
        turned = self.frame.T @ pose.rotation @ self.frame
        chart = better_chart(turned)
        angles = angles_of(turned, chart)
        if not self.slides:
            return angles, chart
        return np.concatenate([pose.position @ self.frame, angles], axis=-1), chart

    def velocity_map(self, s: Array, charts: Array) -> Array:
        """V (..., k, k) with twist = V q' for the joint's k coordinates."""
        angular = self.frame @ rate_matrix(s[..., self.turns])
        if not self.slides:
            return angular
        turned = rotation_of(s[..., self.turns], charts[..., self.chart])
        result = np.zeros((*angular.shape[:-2], TWIST, TWIST))
        result[..., :3, :3] = self.frame @ np.swapaxes(turned, -1, -2)
        result[..., 3:, 3:] = angular
        return result

    def drift(self, s: Array, ds: Array, charts: Array) -> Array:
        """V' q' (..., k): what the twist changes by with q'' = 0."""
        angles, rates = s[..., self.turns], ds[..., self.turns]
        _, b, c = np.moveaxis(angles, -1, 0)
        columns = list(np.moveaxis(rates, -1, 0))
        bias = Turns(np.cos(b), np.sin(b), np.cos(c), np.sin(c)).bias(columns, columns)
        angular = np.stack(np.broadcast_arrays(*bias), axis=-1) @ self.frame.T
        if not self.slides:
            return angular
        omega = (rate_matrix(angles) @ rates[..., None])[..., 0]
        turned = rotation_of(angles, charts[..., self.chart])
        velocity = (np.swapaxes(turned, -1, -2) @ ds[..., self.slides, None])[..., 0]
        linear = -np.cross(omega, velocity) @ self.frame.T
        return np.concatenate([linear, angular], axis=-1)


def freely_turning(description: RobotDescription, tree: Tree) -> tuple[FreelyTurning, ...]:
    """The ball and free joints of a robot, in the order of their charts."""
    joints: list[FreelyTurning] = []
    for chart, joint in enumerate(description.freely_turning):
        indices = tuple(map(tree.coordinates.index, joint.joints))
        frame = description.joints[joint.turns[-1]].rotation.T
        joints.append(FreelyTurning(joint.name, chart, indices[:-3], indices[-3:], frame))
    return tuple(joints)
