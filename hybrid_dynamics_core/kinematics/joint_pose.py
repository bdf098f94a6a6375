"""Conversion between poses and twists of ball and free joints and their coordinates and rates.

The pose is that of the child in the joint frame, which is the child's frame at zero. The twist has
the linear velocity of the child's origin, then the angular velocity. Both are relative to the
parent and in child axes, as in nav_msgs/Odometry. A ball joint has only the angular part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..algebra.charts import Turns, angles_of, better_chart, rate_matrix, rotation_of
from ..algebra.vector import cross
from ..description.model import RobotDescription
from ..ground.arrays import Array
from ..mechanism.tree import Tree
from .pose import Pose

TWIST = 6


@dataclass(frozen=True, eq=False)
class FreelyTurning:
    """Coordinates and constant frames of a ball or free joint.

    Attributes:
        name: name of the joint.
        chart: index of its chart among those of the tree.
        slides: its three sliding coordinates; empty for a ball joint.
        turns: its three turning coordinates.
        slide_axes: (3, 3) directions of the slides in the joint frame, as columns.
        mount: (3, 3) axes of the turns in the joint frame, at zero.
        carried: (3, 3) axes of the turns in the child frame, after all turns.
    """

    name: str
    chart: int
    slides: tuple[int, ...]
    turns: tuple[int, ...]
    slide_axes: Array
    mount: Array
    carried: Array

    @property
    def coordinates(self) -> list[int]:
        """All its coordinates, slides first."""
        return [*self.slides, *self.turns]

    def pose(self, s: Array, charts: Array) -> Pose:
        """Pose of the child in the joint's frame.

        Args:
            s: all coordinates (..., n_s) [rad, m].
            charts: charts of all ball and free joints (..., c).
        """
        rotation = self._rotation(s[..., self.turns], charts)
        position = np.zeros(rotation.shape[:-1])
        if self.slides:
            position = s[..., self.slides] @ self.slide_axes.T
        return Pose(position, rotation)

    def _rotation(self, angles: Array, charts: Array) -> Array:
        """Rotation (..., 3, 3) of the child in the joint frame."""
        turned = rotation_of(angles, charts[..., self.chart])
        rotation: Array = self.mount @ turned @ self.carried.T
        return rotation

    def coordinates_at(self, pose: Pose) -> tuple[Array, Array]:
        """Coordinates (..., 3 or 6) [m, rad] of a pose, and the better chart (...) for it."""
        turned = self.mount.T @ pose.rotation @ self.carried
        chart = better_chart(turned)
        angles = angles_of(turned, chart)
        if not self.slides:
            return angles, chart
        return np.concatenate([pose.position @ self.slide_axes, angles], axis=-1), chart

    def velocity_map(self, s: Array, charts: Array) -> Array:
        """V (..., k, k) with twist = V q' for the joint's k coordinates."""
        angular = self.carried @ rate_matrix(s[..., self.turns])
        if not self.slides:
            return angular
        rotation = self._rotation(s[..., self.turns], charts)
        result = np.zeros((*angular.shape[:-2], TWIST, TWIST))
        result[..., :3, :3] = np.swapaxes(rotation, -1, -2) @ self.slide_axes
        result[..., 3:, 3:] = angular
        return result

    def drift(self, s: Array, ds: Array, velocity_map: Array) -> Array:
        """V' q' (..., k), the rate of the twist at q'' = 0.

        Args:
            s: all coordinates (..., n_s) [rad, m].
            ds: rates of all coordinates (..., n_s) [rad/s, m/s].
            velocity_map: V (..., k, k) there.
        """
        angles, rates = s[..., self.turns], ds[..., self.turns]
        columns = [rates[..., k] for k in range(3)]
        bias = Turns.at(angles).bias(columns, columns)
        angular = np.stack(bias, axis=-1) @ self.carried.T
        if not self.slides:
            return angular
        twist = (velocity_map @ ds[..., self.coordinates, None])[..., 0]
        velocity = tuple(twist[..., k] for k in range(TWIST))
        linear = np.stack(cross(velocity[:3], velocity[3:]), axis=-1)
        return np.concatenate([linear, angular], axis=-1)


def freely_turning(description: RobotDescription, tree: Tree) -> tuple[FreelyTurning, ...]:
    """The ball and free joints of a robot, in the order of their charts."""
    joints: list[FreelyTurning] = []
    for chart, joint in enumerate(description.freely_turning):
        indices = tuple(map(tree.coordinates.index, joint.joints))
        rows = [description.joints[name] for name in joint.joints]
        carried = rows[-1].rotation.T
        slide_axes = np.eye(3)
        mount = carried  # at zero the child frame is the joint frame
        if joint.type == "free":
            slide_axes = np.stack([row.axis for row in rows[:3]], axis=-1)
            mount = rows[3].rotation
        joints.append(
            FreelyTurning(joint.name, chart, indices[:-3], indices[-3:], slide_axes, mount, carried)
        )
    return tuple(joints)
