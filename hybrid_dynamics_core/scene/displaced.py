"""A picture of links displaced a little, as under a load or in a natural mode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from ..algebra.independence import norm
from ..description.geometry import rotation_about
from ..ground.arrays import Array
from .parts import Part
from .projection import Projection, choose_projection, oblique
from .scene import Scene
from .skeleton import Pose, Skeleton

SAME_PLACE: Final = 1e-6  # [m] between two points that are one
TINY: Final = 1e-300  # [rad] turn without an axis
ASIDE: Final = 0.5  # share of a displacement across a picture's plane that needs another picture


class Displacements:
    """Displacements of links in a skeleton.

    Args:
        skeleton: the robot without displacements.
        by_link: displacement (6,) of each link's origin and its turn, base axes [m, rad].
    """

    def __init__(self, skeleton: Skeleton, by_link: Mapping[str, Array]) -> None:
        self.skeleton = skeleton
        self.by_link = by_link
        self._origins = {joint.child: joint.point for joint in skeleton.joints}

    def of_point(self, link: str, point: Array) -> Array:
        """Displacement (3,) of a point (3,) of a link [m].

        The place of a joint that the link carries moves with that joint: the link may bend.
        """
        for joint in self.skeleton.joints:
            is_here = norm(joint.point - point) <= SAME_PLACE
            if joint.parent == link and is_here and joint.child in self.by_link:
                return self.by_link[joint.child][:3]
        if link not in self.by_link or link not in self._origins:
            return np.zeros(3)
        moved = self.by_link[link]
        arm = point - self._origins[link]
        shift: Array = moved[:3] + np.cross(moved[3:], arm)
        return shift

    def of_points(self) -> Array:
        """Displacements (k, 3) of all joints and frames [m]."""
        shifts = [self.of_point(joint.child, joint.point) for joint in self.skeleton.joints]
        shifts += [self.of_point(frame.link, frame.point) for frame in self.skeleton.frames]
        return np.array(shifts)

    def projection(self) -> Projection:
        """The robot's projection, or an oblique one where it moves out of its plane."""
        projection = choose_projection(self.skeleton)
        if not projection.planar:
            return projection
        shifts = self.of_points()
        aside = norm(shifts @ projection.toward)
        if aside > ASIDE * norm(shifts):
            return oblique(self.skeleton)
        return projection

    def of_scene(self, scene: Scene, scale: float) -> Scene:
        """A scene of the skeleton with its parts moved, without arrows and axes.

        Args:
            scene: the scene.
            scale: by which displacements are multiplied.
        """
        parts = tuple(self._of_part(part, scale) for part in scene.parts)
        return replace(scene, parts=parts, lines=())

    def _of_part(self, part: Part, scale: float) -> Part:
        if not part.links:
            return part
        link = part.links[-1]
        if part.role == "collar":  # on the barrel
            link = part.links[0]
        points = [point + scale * self.of_point(link, point) for point in part.points]
        return replace(part, points=np.array(points))


def displaced(
    poses: Mapping[str, Pose],
    by_link: Mapping[str, Array],
    scale: float,
) -> dict[str, Pose]:
    """Poses of links moved by multiples of their displacements.

    Args:
        poses: pose by link.
        by_link: displacement (6,) of each link's origin and its turn, base axes [m, rad].
        scale: the multiple.
    """
    moved = dict(poses)
    for name, displacement in by_link.items():
        rotation, origin = poses[name]
        turn = scale * displacement[3:]
        angle = norm(turn)
        if angle > TINY:
            rotation = rotation_about(turn / angle, angle) @ rotation
        moved[name] = (rotation, origin + scale * displacement[:3])
    return moved
