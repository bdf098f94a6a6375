"""The projection of a picture: a side view of a planar mechanism, or an oblique view."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ..ground.arrays import Array
from .skeleton import PlacedJoint, Skeleton

ALIGNED = 1e-6  # axes with a smaller difference are parallel
UP = np.array([0.0, 0.0, 1.0])
_AZIMUTHS = np.radians(np.arange(-90.0, 0.0, 5.0))
_ELEVATIONS = np.radians([16.0, 20.0, 24.0, 28.0])
# Default azimuth and elevation.
_USUAL = np.radians([-55.0, 22.0])
_TURN_COST = 0.3  # cost per radian from the default view, against one per hidden point
_CROWDED = 0.05  # share of the picture's size: points closer than this hide each other


@dataclass(frozen=True, eq=False)
class Projection:
    """An orthographic projection.

    Attributes:
        right: (3,) unit vector to the right in the picture, base axes.
        up: (3,) unit vector up in the picture, base axes.
        planar: whether the mechanism moves in the plane of the picture only.
        names: names of the two axes of a planar picture.
    """

    right: Array
    up: Array
    planar: bool = False
    names: tuple[str, str] = ("", "")

    @property
    def toward(self) -> Array:
        """(3,) unit vector to the viewer."""
        return np.cross(self.right, self.up)

    def project(self, points: ArrayLike) -> Array:
        """Project points (..., 3) to the picture (..., 2) [m]."""
        return np.asarray(points) @ np.stack([self.right, self.up], axis=1)

    def depth(self, points: ArrayLike) -> Array:
        """Depth (...) of points (..., 3) towards the viewer [m]."""
        return np.asarray(np.asarray(points) @ self.toward)


def choose_projection(skeleton: Skeleton) -> Projection:
    """The projection in which a mechanism is drawn."""
    normal = find_plane(skeleton)
    if normal is None:
        return oblique(skeleton)
    return _side(skeleton, normal)


# -- planar


def find_plane(skeleton: Skeleton) -> Array | None:
    """Unit normal (3,) of the plane in which the mechanism moves, None for a spatial one.

    In loops every revolute axis is along the normal. Outside of loops an axis may also lie in the
    plane, such as that of a column or a rolling gripper. Prismatic axes lie in the plane.
    """
    in_loops = skeleton.in_loops
    voters = [joint for joint in skeleton.hinges if joint.name in in_loops]
    voters = voters or list(skeleton.hinges)
    if not voters:
        return None
    votes = [_parallel_count(joint, voters) for joint in voters]
    normal = voters[int(np.argmax(votes))].axis
    for joint in skeleton.joints:
        if not _moves_in_plane(joint, normal, joint.name in in_loops):
            return None
    return normal


def _parallel_count(joint: PlacedJoint, others: list[PlacedJoint]) -> int:
    """Number of joints whose axes are parallel to that of one."""
    count = 0
    for other in others:
        if abs(float(joint.axis @ other.axis)) > 1.0 - ALIGNED:
            count += 1
    return count


def _moves_in_plane(joint: PlacedJoint, normal: Array, in_loop: bool) -> bool:
    along = abs(float(joint.axis @ normal))
    if joint.type == "prismatic":
        return along < ALIGNED
    return along > 1.0 - ALIGNED or (along < ALIGNED and not in_loop)


def _side(skeleton: Skeleton, normal: Array) -> Projection:
    """The view along the normal of a planar mechanism, with its end effector to the right."""
    level = abs(float(normal @ UP)) > 1.0 - ALIGNED
    up = np.array([0.0, 1.0, 0.0])
    if not level:
        up = UP - (UP @ normal) * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    ahead = np.ones(3)
    if not level and _has_column(skeleton, normal):  # an arm on a column points to the right
        tip = skeleton.tip.point
        if abs(tip @ right) >= ALIGNED:
            ahead = tip
    if not ahead @ right > 0.0:
        right = -right
    right[np.abs(right) < ALIGNED] = 0.0
    across = _axis_name(right) or "along the arm [m]"
    upward = _axis_name(up) or "up [m]"
    return Projection(right, up, True, (across, upward))


def _has_column(skeleton: Skeleton, normal: Array) -> bool:
    """Whether a hinge turns about an axis in the plane."""
    return any(abs(joint.axis @ normal) < ALIGNED for joint in skeleton.hinges)


def _axis_name(direction: Array) -> str:
    """The name of the base axis along a direction, empty where there is none."""
    for letter, component in zip("xyz", direction, strict=True):
        if component > 1.0 - ALIGNED:
            return f"{letter} [m]"
    return ""


# -- spatial


def oblique(skeleton: Skeleton) -> Projection:
    """The oblique projection, among several, in which the fewest points hide each other."""
    points = _samples(skeleton)
    size = np.linalg.norm(np.ptp(points, axis=0))
    crowded = _CROWDED * (float(size) or 1.0)  # a single point has no size
    apart = _distances(points) > crowded
    best = _from_direction(*_USUAL)
    least = np.inf
    for azimuth, elevation in product(_AZIMUTHS, _ELEVATIONS):
        projection = _from_direction(azimuth, elevation)
        distances = _distances(projection.project(points))
        hiding = np.exp(-((distances / crowded) ** 2))
        hidden = hiding[apart].sum() / len(points)
        turn = np.hypot(azimuth - _USUAL[0], 2.0 * (elevation - _USUAL[1]))
        cost = hidden + _TURN_COST * float(turn)
        if cost < least:
            best, least = projection, cost
    return best


def _distances(points: Array) -> Array:
    """Distances (k, k) between points (k, d)."""
    return np.asarray(np.linalg.norm(points[:, None] - points[None], axis=2))


def _samples(skeleton: Skeleton) -> Array:
    """Joints, closures, and points between the joints of each link."""
    points = [skeleton.points]
    for link, ends in _points_by_link(skeleton).items():
        if link != skeleton.base and len(ends) == 2:
            along = ends[1] - ends[0]
            points += [ends[0] + share * along for share in (0.25, 0.5, 0.75)]
    return np.vstack(points)


def _points_by_link(skeleton: Skeleton) -> dict[str, list[Array]]:
    """Points of joints and closures by the links that they join."""
    points: dict[str, list[Array]] = {}
    for joint in skeleton.joints:
        points.setdefault(joint.parent, []).append(joint.point)
        points.setdefault(joint.child, []).append(joint.point)
    for closure in skeleton.closures:
        for link, point in zip(closure.links, closure.points, strict=True):
            points.setdefault(link, []).append(point)
    return points


def _from_direction(azimuth: float, elevation: float) -> Projection:
    """The view from a direction of given azimuth and elevation [rad].

    At an azimuth of -90 degrees x is to the right, and y away from the viewer.
    """
    x, y = np.cos(azimuth), np.sin(azimuth)
    level = np.cos(elevation)
    right = np.array([-y, x, 0.0])
    toward = np.array([level * x, level * y, np.sin(elevation)])
    return Projection(right, np.cross(toward, right))
