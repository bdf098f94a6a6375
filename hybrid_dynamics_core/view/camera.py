"""Where the camera stands at the start, and the floor under a robot."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from ..ground.arrays import Array
from ..scene.projection import choose_projection
from ..scene.skeleton import Skeleton

FIELD: Final = np.radians(
    32.0
)  # of view, from top to bottom: narrow, so that parallel bars look parallel
ASIDE: Final = np.radians(
    28.0
)  # how far the camera stands aside of the plane's normal, of a planar mechanism
ABOVE: Final = np.radians(20.0)
_CORNER: Final = (-0.95, 0.72)  # to the right and up, in radii of what is shown
ROOM: Final = 1.22  # round the robot


@dataclass(frozen=True, eq=False)
class Camera:
    """`position` and `look_at` (3,) in base axes [m]; what it has to show is within `radius` of `look_at` [m].

    field: of view from top to bottom [rad]. shown: (k, 3) what it was made to show [m].
    """

    position: Array
    look_at: Array
    radius: float
    field: float = float(FIELD)
    shown: Array | None = None

    @property
    def corner(self) -> Array:
        """(3,) to the left and above, in the plane of `look_at`: beside all that it has to show, and still seen [m]."""
        away = self.look_at - self.position
        side = np.cross(away, (0.0, 0.0, 1.0))
        up = np.cross(side, away)
        aside = _CORNER[0] * side / np.linalg.norm(side) + _CORNER[1] * up / np.linalg.norm(up)
        return np.asarray(self.look_at + self.radius * aside)

    def sees(self, points: Array, aspect: float) -> bool:
        """Whether points (k, 3) are in a picture whose width is `aspect` times its height."""
        forward = direction(self.look_at - self.position)
        level = np.cross(forward, (0.0, 0.0, 1.0))
        right = direction(level if np.linalg.norm(level) > 1e-9 else np.array([1.0, 0.0, 0.0]))
        seen = points - self.position
        room = np.tan(0.5 * self.field) * (seen @ forward)
        across, upward = np.abs(seen @ right), np.abs(seen @ np.cross(right, forward))
        return bool(((across < aspect * room) & (upward < room)).all())

    def around(self, points: Array) -> Camera:
        """Another one, that looks the same way and shows points (k, 3)."""
        return camera_around(points, direction(self.position - self.look_at))

    def following(self, points: Array, aspect: float) -> Camera:
        """Itself, or another one that shows points (k, 3) besides: what goes to and fro moves it once."""
        if replace(self, position=self.seen_from(aspect)).sees(points, aspect):
            return self
        return self.around(points if self.shown is None else np.vstack([self.shown, points]))

    def seen_from(self, aspect: float) -> Array:
        """Where it has to stand (3,) [m] for a canvas whose width is `aspect` times its height."""
        return np.asarray(self.look_at + (self.position - self.look_at) / min(aspect, 1.0))


@dataclass(frozen=True)
class Floor:
    """A level square: height and side [m], and the side of a tile."""

    level: float
    side: float
    tile: float


def camera_for(skeleton: Skeleton, points: Array) -> Camera:
    """A camera that sees all points (k, 3): from the side where the robot is planar, else where least is hidden."""
    view = choose_projection(skeleton)
    toward = view.toward
    if view.planar:
        aside = Rotation.from_rotvec(-ASIDE * view.up).as_matrix() @ toward
        toward = np.cos(ABOVE) * aside + np.sin(ABOVE) * view.up
    return camera_around(points, toward)


def camera_around(points: Array, toward: Array) -> Camera:
    """A camera that shows all points (k, 3); toward: from them to it (3,)."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    radius = max(float(np.linalg.norm(points - middle, axis=1).max()), 0.05)
    return Camera(
        middle + ROOM * radius / np.sin(0.5 * FIELD) * toward, middle, radius, shown=points
    )


def direction(vector: Array) -> Array:
    """A vector (3,) of length one, along one that is not zero."""
    return np.asarray(vector / np.linalg.norm(vector))


def floor_under(points: Array, unit: float) -> Floor:
    """The floor below points (k, 3), some radii of a joint under the lowest."""
    width = max(float(np.ptp(points, axis=0).max()), 1e-3)
    power = 10.0 ** np.floor(np.log10(width / 5.0))
    tile = float(
        power * min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(np.log(k * power / (width / 5.0))))
    )
    return Floor(float(points[:, 2].min()) - 2.0 * unit, 24.0 * tile, tile)
