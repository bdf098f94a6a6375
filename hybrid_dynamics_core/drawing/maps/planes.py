"""The planes on which a workspace is shown, and where samples lie on them."""

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

ROUND = 2.0 * np.pi - 1e-6  # [rad]
_X, _Y = np.eye(3)[:2]
FRONT = Projection(_X, UP, False, ("x [m]", "z [m]"))
SIDE = Projection(_Y, UP, False, ("y [m]", "z [m]"))
TOP = Projection(_X, _Y, False, ("x [m]", "y [m]"))


@dataclass(frozen=True, eq=False)
class Plane:
    """A panel: the robot's scene in its view; `positions` (N, 3) of samples as they are shown [m], base axes."""

    title: str
    scene: Scene
    positions: Callable[[Margins], Array]

    @property
    def names(self) -> tuple[str, str]:
        """Of the two axes."""
        return self.scene.projection.names

    def points(self, samples: Margins) -> Array:
        """(N, 2) where samples are on it [m]; NaN where a loop is open."""
        return self.scene.projection.project(self.positions(samples))

    def box(self, points: Array) -> Array:
        """(2, 2) smallest and largest of the scene and of points (N, 2) with a margin about them [m]."""
        scene, margin = limits_of(self.scene), 2.0 * self.scene.unit
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return scene
        low = np.minimum(scene[0], points.min(axis=0) - margin)
        return np.array([low, np.maximum(scene[1], points.max(axis=0) + margin)])


def choose_planes(robot: Robot) -> list[Plane]:
    """The plane of a planar robot, that of an arm on a turning column, else three views.

    Of a turning arm every sample is turned back into the plane of the reference: what is shown
    holds for every angle of the column. Where the column does not turn all round, there is a view
    from above too.
    """
    skeleton = place_skeleton(robot, robot.close(robot.reference))
    view = choose_projection(skeleton)
    if not view.planar:
        told = (
            ("seen from the front", FRONT),
            ("seen from the side", SIDE),
            ("seen from above", TOP),
        )
        return [_plane(robot, skeleton, title, plane) for title, plane in told]
    column = _column(skeleton)
    if column is None:
        letters = [name.removesuffix(" [m]") for name in view.names]
        which = f", {'-'.join(sorted(letters))}" if max(map(len, letters)) == 1 else ""
        return [_plane(robot, skeleton, f"in the robot's plane{which}", view)]
    k = robot.active.index(column.name)

    def turned(samples: Margins) -> Array:
        back = Rotation.from_rotvec(
            np.multiply.outer(robot.reference[k] - samples.u[:, k], column.axis)
        )
        return np.asarray(column.point + back.apply(samples.position - column.point))

    planes = [
        _plane(robot, skeleton, f"in the plane of the arm, at any {column.name}", view, turned)
    ]
    if np.ptp(robot.limits[k]) < ROUND:
        planes.append(_plane(robot, skeleton, "seen from above", TOP))
    return planes


def _plane(
    robot: Robot,
    skeleton: Skeleton,
    title: str,
    view: Projection,
    positions: Callable[[Margins], Array] | None = None,
) -> Plane:
    return Plane(
        title,
        build_scene(robot.description, skeleton, view),
        positions or (lambda samples: samples.position),
    )


def _column(skeleton: Skeleton) -> PlacedJoint | None:
    """The active joint that turns the whole mechanism about a vertical axis."""
    first = [joint for joint in skeleton.joints if joint.parent == skeleton.base]
    if len(first) != 1 or first[0].name in skeleton.in_loops:
        return None
    joint = first[0]
    upright = abs(float(joint.axis @ UP)) > 1.0 - ALIGNED
    return joint if upright and joint.active and joint.type == "revolute" else None
