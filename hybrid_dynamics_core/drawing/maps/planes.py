"""The planes on which a workspace is shown, and the projection of samples onto them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...ground.arrays import Array
from ...kinematics.workspace import Margins
from ...robot.robot import Robot
from ...scene.projection import ALIGNED, UP, Projection, choose_projection
from ...scene.scene import Scene, build_scene
from ...scene.skeleton import PlacedJoint, Skeleton, place_skeleton
from ..paint.picture import limits_of

FULL_TURN = 2.0 * np.pi - 1e-6  # [rad]
_X, _Y = np.eye(3)[:2]
FRONT = Projection(_X, UP, False, ("x [m]", "z [m]"))
SIDE = Projection(_Y, UP, False, ("y [m]", "z [m]"))
TOP = Projection(_X, _Y, False, ("x [m]", "y [m]"))

Positions = Callable[[Margins], Array]  # from samples to shown positions (N, 3) [m], base axes


@dataclass(frozen=True, eq=False)
class Plane:
    """A panel.

    Attributes:
        title: title of the panel.
        scene: the robot in the projection of the panel.
        positions: function from samples to their shown positions.
    """

    title: str
    scene: Scene
    positions: Positions

    @property
    def names(self) -> tuple[str, str]:
        """Names of the two axes."""
        return self.scene.projection.names

    def points(self, samples: Margins) -> Array:
        """(N, 2) places of samples on the plane [m]; NaN where a loop is open."""
        return self.scene.projection.project(self.positions(samples))

    def box(self, points: Array) -> Array:
        """(2, 2) bounding box of the scene and of points (N, 2), with a margin [m]."""
        scene = limits_of(self.scene)
        finite = points[np.isfinite(points).all(axis=1)]
        if not len(finite):
            return scene
        margin = 2.0 * self.scene.joint_radius
        low = np.minimum(scene[0], finite.min(axis=0) - margin)
        high = np.maximum(scene[1], finite.max(axis=0) + margin)
        return np.array([low, high])


def choose_planes(robot: Robot) -> list[Plane]:
    """The plane of a planar robot or of an arm on a column; for other robots three views.

    Samples of an arm on a column are turned back into the plane of the reference, so the map holds
    for every column angle. If the column cannot make a full turn, a view from above is added.
    """
    skeleton = place_skeleton(robot, robot.close(robot.reference))
    projection = choose_projection(skeleton)
    if not projection.planar:
        return [
            _plane(robot, skeleton, _view(FRONT), FRONT),
            _plane(robot, skeleton, _view(SIDE), SIDE),
            _plane(robot, skeleton, _view(TOP), TOP),
        ]
    column = _column(skeleton)
    if column is None:
        title = f"in the robot's plane{_axis_letters(projection)}"
        return [_plane(robot, skeleton, title, projection)]
    title = f"in the plane of the arm, at any {column.name}"
    planes = [_plane(robot, skeleton, title, projection, _turned_back(robot, column))]
    limits = robot.limits[robot.active.index(column.name)]
    if np.ptp(limits) < FULL_TURN:
        planes.append(_plane(robot, skeleton, _view(TOP), TOP))
    return planes


def _view(projection: Projection) -> str:
    """The title of a view along a base axis."""
    letters = "-".join(name.removesuffix(" [m]") for name in projection.names)
    away = -projection.toward
    k = int(np.argmax(np.abs(away)))
    sign = "+" if away[k] > 0.0 else "-"
    return f"{letters} plane, seen along {sign}{'xyz'[k]}"


def _axis_letters(projection: Projection) -> str:
    """`, x-z` for a picture along two base axes; empty for others."""
    letters = [name.removesuffix(" [m]") for name in projection.names]
    if max(map(len, letters)) > 1:
        return ""
    return f", {'-'.join(sorted(letters))}"


def _turned_back(robot: Robot, column: PlacedJoint) -> Positions:
    """Positions with the column turned back to its reference."""
    k = robot.active.index(column.name)

    def positions(samples: Margins) -> Array:
        angles = robot.reference[k] - samples.u[:, k]
        turns = Rotation.from_rotvec(np.multiply.outer(angles, column.axis))
        return np.asarray(column.point + turns.apply(samples.position - column.point))

    return positions


def _positions(samples: Margins) -> Array:
    return samples.position


def _plane(
    robot: Robot,
    skeleton: Skeleton,
    title: str,
    projection: Projection,
    positions: Positions = _positions,
) -> Plane:
    return Plane(title, build_scene(robot.description, skeleton, projection), positions)


def _column(skeleton: Skeleton) -> PlacedJoint | None:
    """The active or idle joint that turns the whole mechanism about a vertical axis."""
    on_base = [joint for joint in skeleton.joints if joint.parent == skeleton.base]
    if len(on_base) != 1:
        return None
    joint = on_base[0]
    if (
        joint.name in skeleton.in_loops
        or joint.type != "revolute"
        or not (joint.active or joint.idle)
    ):
        return None
    upright = abs(float(joint.axis @ UP)) > 1.0 - ALIGNED
    return joint if upright else None
