"""The initial camera, and the floor under a robot."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from ..ground.arrays import Array
from ..scene.projection import choose_projection
from ..scene.skeleton import Skeleton
from .ranges import round_value

# Vertical field of view: narrow, so that parallel bars look parallel.
FIELD: Final = np.radians(32.0)
# Offset of the camera from the normal of a planar mechanism's plane.
ASIDE: Final = np.radians(28.0)
ABOVE: Final = np.radians(20.0)
_CORNER: Final = (-0.95, 0.72)  # to the right and up, in radii of the shown sphere
ROOM: Final = 1.22  # margin around the robot, as a factor
_UP: Final = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera.

    Attributes:
        position: (3,) in base axes [m].
        look_at: (3,) in base axes [m].
        radius: radius of the shown sphere around `look_at` [m].
        field: vertical field of view [rad].
        shown: (k, 3) points to show [m].
    """

    position: Array
    look_at: Array
    radius: float
    field: float = float(FIELD)
    shown: Array | None = None

    @property
    def corner(self) -> Array:
        """(3,) a point at the upper left, in the plane of `look_at` [m].

        It is outside of the shown sphere, and inside the picture.
        """
        away = self.look_at - self.position
        side = np.cross(away, _UP)
        up = np.cross(side, away)
        across = _CORNER[0] * side / np.linalg.norm(side)
        upward = _CORNER[1] * up / np.linalg.norm(up)
        return np.asarray(self.look_at + self.radius * (across + upward))

    def sees(self, points: Array, aspect: float) -> bool:
        """Whether points (k, 3) are in a picture whose width is `aspect` times its height."""
        forward = unit_vector(self.look_at - self.position)
        level = np.cross(forward, _UP)
        if not np.linalg.norm(level) > 1e-9:
            level = np.array([1.0, 0.0, 0.0])
        right = unit_vector(level)
        up = np.cross(right, forward)
        rays = points - self.position
        half_height = np.tan(0.5 * self.field) * (rays @ forward)
        across = np.abs(rays @ right)
        upward = np.abs(rays @ up)
        within = (across < aspect * half_height) & (upward < half_height)
        return bool(within.all())

    def around(self, points: Array) -> Camera:
        """A camera with the same direction that shows points (k, 3)."""
        return camera_around(points, unit_vector(self.position - self.look_at))

    def following(self, points: Array, aspect: float) -> Camera:
        """The same camera, or another one that also shows further points.

        The other one still shows the points of this one, so periodic motion moves it only once.

        Args:
            points: (k, 3) points to show [m].
            aspect: width over height of the picture.

        Returns:
            The camera.
        """
        standing = replace(self, position=self.position_for(aspect))
        if standing.sees(points, aspect):
            return self
        if self.shown is not None:
            points = np.vstack([self.shown, points])
        return self.around(points)

    def position_for(self, aspect: float) -> Array:
        """Its position (3,) [m] for a canvas whose width is `aspect` times its height."""
        distance = (self.position - self.look_at) / min(aspect, 1.0)
        return np.asarray(self.look_at + distance)


@dataclass(frozen=True)
class Floor:
    """A horizontal square.

    Attributes:
        level: its height [m].
        side: side of the square [m].
        tile: side of a tile [m].
    """

    level: float
    side: float
    tile: float


def camera_for(skeleton: Skeleton, points: Array) -> Camera:
    """A camera for a side view of a planar robot, otherwise for an oblique view.

    Args:
        skeleton: the robot's skeleton.
        points: (k, 3) points to show [m].

    Returns:
        The camera.
    """
    projection = choose_projection(skeleton)
    toward = projection.toward
    if projection.planar:
        turn = Rotation.from_rotvec(-ASIDE * projection.up)
        aside = turn.as_matrix() @ toward
        level = np.cos(ABOVE) * aside
        toward = level + np.sin(ABOVE) * projection.up
    return camera_around(points, toward)


def camera_around(points: Array, toward: Array) -> Camera:
    """A camera that shows points (k, 3) [m] from the direction `toward` (3,)."""
    low = points.min(axis=0)
    high = points.max(axis=0)
    middle = 0.5 * (low + high)
    farthest = np.linalg.norm(points - middle, axis=1).max()
    radius = max(float(farthest), 0.05)
    position = middle + ROOM * radius / np.sin(0.5 * FIELD) * toward
    return Camera(position, middle, radius, shown=points)


def unit_vector(vector: Array) -> Array:
    """A vector (3,), normalised; it must not be zero."""
    return np.asarray(vector / np.linalg.norm(vector))


def floor_under(points: Array, unit: float) -> Floor:
    """The floor below points (k, 3) [m]; `unit` is the radius of a joint [m]."""
    extent = np.ptp(points, axis=0).max()
    tile = round_value(max(float(extent), 1e-3) / 5.0)
    lowest = float(points[:, 2].min())
    return Floor(lowest - 2.0 * unit, 24.0 * tile, tile)
