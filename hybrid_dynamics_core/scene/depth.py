"""The order in which parts are painted."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..ground.arrays import Array
from .parts import Part, PartRole
from .projection import Projection
from .scene import Scene

# Painting order of parts in one plane.
_LAYERS: Final[dict[PartRole, int]] = {
    "base": 0,
    "plate": 1,
    "rail": 2,
    "bar": 3,
    "rod": 4,
    "barrel": 5,
    "block": 6,
    "collar": 6,
    "pin": 7,
    "weld": 7,
    "hinge": 8,
    "ball": 9,
    "cross": 9,
}
_SYMBOLS: Final = ("block", "collar", "pin", "weld", "hinge", "ball", "cross")
_JOINED: Final = 3.0  # [radii of a joint] a symbol joins bodies nearer than this
_LAYER_STEP: Final = 1e-9  # [m] depth step between layers of equal depth
_ROD_STEP: Final = 1e-8  # [m] depth step of a rod that points towards the viewer


def from_back(scene: Scene) -> list[Part]:
    """Parts from back to front: by role and size in a planar picture, otherwise by depth."""
    if scene.projection.planar:
        return sorted(scene.parts, key=lambda part: _plane_order(part, scene.projection))
    return sorted(scene.parts, key=lambda part: _nearness(part, scene))


def _plane_order(part: Part, projection: Projection) -> tuple[int, float]:
    """Sort key: layer, then larger parts first."""
    outline = part.outline(projection)
    area = np.prod(np.ptp(outline, axis=0))
    return _LAYERS[part.role], -float(area)


def _nearness(part: Part, scene: Scene) -> float:
    """Depth of a part towards the viewer [m]; a floor is behind everything."""
    depth = part.depth(scene.projection)
    if part.role == "base":
        return -np.inf if _is_floor(part, scene) else depth
    layer = _LAYER_STEP * _LAYERS[part.role]
    is_front_rod = part.role == "rod" and _faces_viewer(part, scene.projection)
    if part.role in _SYMBOLS or is_front_rod:
        for other in _joined(part, scene):
            depth = max(depth, other.depth(scene.projection))
    if is_front_rod:
        return depth + layer + _ROD_STEP
    return depth + layer


def _is_floor(base: Part, scene: Scene) -> bool:
    """Whether a part of the base is below the mechanism."""
    lowest = float(scene.skeleton.points[:, 2].min())
    return bool(base.points[:, 2].max() < lowest + scene.joint_radius)


def _faces_viewer(rod: Part, projection: Projection) -> bool:
    """Whether a rod points from its barrel towards the viewer."""
    return rod.axis is not None and float(rod.axis @ projection.toward) > 0.0


def _joined(part: Part, scene: Scene) -> list[Part]:
    """The bodies that a symbol joins, which must not hide it."""
    place = part.points.mean(axis=0)
    if part.role == "rod":
        place = part.points[0]
    joined = []
    for other in scene.parts:
        is_linked = not set(other.links).isdisjoint(part.links)
        if not is_linked or not _may_hide(other, part, scene.projection):
            continue
        if _distance(other.points, place) < _JOINED * scene.joint_radius:
            joined.append(other)
    return joined


def _may_hide(other: Part, part: Part, projection: Projection) -> bool:
    """Whether a part could wrongly hide another: a body, or the collar of a rod."""
    if part.role == "rod" and other.role == "collar":
        return True
    if other.role in _SYMBOLS:
        return False
    if part.role == "collar" and other.role == "rod":
        return not _faces_viewer(other, projection)
    return True


def _distance(points: Array, place: Array) -> float:
    """Distance from a place to points, or to the line between two points [m]."""
    if len(points) == 2:
        line = points[1] - points[0]
        along = (place - points[0]) @ line
        square = max(float(line @ line), 1e-18)
        share = np.clip(along / square, 0.0, 1.0)
        points = points[:1] + share * line
    distances = np.linalg.norm(points - place, axis=1)
    return float(distances.min())
