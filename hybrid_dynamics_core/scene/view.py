"""The direction of view: a side view where the mechanism is planar, an oblique one where it is not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..ground.arrays import Array
from .skeleton import PlacedJoint, Skeleton

ALIGNED = 1e-6  # axes that differ less are parallel
UP = np.array([0.0, 0.0, 1.0])
_AZIMUTHS = np.radians(np.arange(-90.0, 0.0, 5.0))
_ELEVATIONS = np.radians([16.0, 20.0, 24.0, 28.0])
_USUAL = np.radians(
    [-55.0, 22.0]
)  # azimuth and elevation that are kept where nothing speaks against them
_CROWDED = 0.05  # of the size of the picture: points nearer than this hide each other


@dataclass(frozen=True, eq=False)
class View:
    """An orthographic view: unit vectors to the right and up in the picture, in base axes."""

    right: Array
    up: Array
    planar: bool = False
    names: tuple[str, str] = ("", "")  # of the two axes of a planar view

    @property
    def toward(self) -> Array:
        """Unit vector to the viewer."""
        return np.cross(self.right, self.up)

    def flat(self, points: ArrayLike) -> Array:
        """(..., 3) -> (..., 2): where points appear in the picture [m]."""
        return np.asarray(points) @ np.stack([self.right, self.up], axis=1)

    def depth(self, points: ArrayLike) -> Array:
        """(..., 3) -> (...): how near points are to the viewer [m]."""
        return np.asarray(np.asarray(points) @ self.toward)


def choose_view(skeleton: Skeleton) -> View:
    """The view in which a mechanism is drawn."""
    normal = find_plane(skeleton)
    return _oblique(skeleton) if normal is None else _side(skeleton, normal)


# -- planar


def find_plane(skeleton: Skeleton) -> Array | None:
    """Unit normal (3,) of the plane in which the mechanism moves, None for a spatial one.

    In loops every revolute axis is along the normal. Outside of them an axis may also lie in the
    plane, as that of a turning column or of a rolling gripper does. Prismatic axes lie in the
    plane.
    """
    inside = skeleton.in_loops
    hinges = [j for j in skeleton.joints if j.type == "revolute"]
    votes = [j for j in hinges if j.name in inside] or hinges
    if not votes:
        return None
    counts = [
        sum(abs(float(j.axis @ other.axis)) > 1.0 - ALIGNED for other in votes) for j in votes
    ]
    normal = votes[int(np.argmax(counts))].axis
    return normal if all(_fits(j, normal, j.name in inside) for j in skeleton.joints) else None


def _fits(joint: PlacedJoint, normal: Array, in_loop: bool) -> bool:
    along = abs(float(joint.axis @ normal))
    if joint.type == "prismatic":
        return along < ALIGNED
    return along > 1.0 - ALIGNED or (along < ALIGNED and not in_loop)


def _side(skeleton: Skeleton, normal: Array) -> View:
    level = abs(float(normal @ UP)) > 1.0 - ALIGNED
    up = np.array([0.0, 1.0, 0.0]) if level else UP - (UP @ normal) * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    turning = any(j.type == "revolute" and abs(j.axis @ normal) < ALIGNED for j in skeleton.joints)
    away = skeleton.tip.point if turning else np.ones(3)  # a turning arm points to the right
    if level or abs(away @ right) < ALIGNED:
        away = np.ones(3)
    right = right if away @ right > 0.0 else -right
    right[np.abs(right) < ALIGNED] = 0.0
    return View(right, up, True, (_name(right) or "along the arm [m]", _name(up) or "up [m]"))


def _name(direction: Array) -> str:
    along = [k for k in range(3) if direction[k] > 1.0 - ALIGNED]
    return f"{'xyz'[along[0]]} [m]" if along else ""


# -- spatial


def _oblique(skeleton: Skeleton) -> View:
    """The view among many in which the fewest points hide each other."""
    points = _samples(skeleton)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) > _CROWDED * size
    best, least = _at(*_USUAL), np.inf
    for azimuth in _AZIMUTHS:
        for elevation in _ELEVATIONS:
            view = _at(azimuth, elevation)
            flat = view.flat(points)
            distance = np.linalg.norm(flat[:, None] - flat[None], axis=2)
            hidden = np.exp(-((distance / (_CROWDED * size)) ** 2))[apart].sum() / len(points)
            cost = hidden + 0.3 * float(
                np.hypot(azimuth - _USUAL[0], 2.0 * (elevation - _USUAL[1]))
            )
            if cost < least:
                best, least = view, cost
    return best


def _samples(skeleton: Skeleton) -> Array:
    """Joints, closures, and points between the joints of each link."""
    marks: dict[str, list[Array]] = {}
    for joint in skeleton.joints:
        marks.setdefault(joint.parent, []).append(joint.point)
        marks.setdefault(joint.child, []).append(joint.point)
    for closure in skeleton.closures:
        for link, point in zip(closure.links, closure.points, strict=True):
            marks.setdefault(link, []).append(point)
    points = [skeleton.points]
    for link, own in marks.items():
        if link != skeleton.base and len(own) == 2:
            points += [own[0] + share * (own[1] - own[0]) for share in (0.25, 0.5, 0.75)]
    return np.vstack(points)


def _at(azimuth: float, elevation: float) -> View:
    """Seen from where the angles point; x to the right and y away at an azimuth of -90 degrees."""
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    toward = np.array(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ]
    )
    return View(right, np.cross(toward, right))
