"""The order in which parts are painted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from ..ground.arrays import Array
from .parts import Part, Role
from .scene import Scene
from .view import View

_LAYERS: Final[dict[Role, int]] = {
    "base": 0, "plate": 1, "rail": 2, "bar": 3, "rod": 4, "barrel": 5, "block": 6, "collar": 6, "pin": 7, "weld": 7,
    "hinge": 8, "ball": 9, "cross": 9,
}  # fmt: skip
_SYMBOLS: Final = ("block", "collar", "pin", "weld", "hinge", "ball", "cross")


def from_back(scene: Scene) -> list[Part]:
    """Parts from back to front: by kind and size where all lie in one plane, else by depth."""
    view = scene.view
    if view.planar:
        return sorted(scene.parts, key=lambda part: (_LAYERS[part.role], -_area(part, view)))
    lowest = float(scene.skeleton.points[:, 2].min()) + scene.unit

    def nearness(part: Part) -> float:
        if part.role == "base":
            return -np.inf if part.points[:, 2].max() < lowest else part.depth(view)
        own = part.depth(view)
        if part.role in _SYMBOLS or (part.role == "rod" and _faces(part, view)):
            own = max(
                [
                    own,
                    *(
                        other.depth(view)
                        for other in _joined(part, scene.parts, 3.0 * scene.unit, view)
                    ),
                ]
            )
        return (
            own
            + 1e-9 * _LAYERS[part.role]
            + (1e-8 if part.role == "rod" and _faces(part, view) else 0.0)
        )

    return sorted(scene.parts, key=nearness)


def _area(part: Part, view: View) -> float:
    return float(np.prod(np.ptp(part.outline(view), axis=0)))


def _faces(rod: Part, view: View) -> bool:
    """Whether a rod comes out of its barrel towards the viewer."""
    return rod.axis is not None and float(rod.axis @ view.toward) > 0.0


def _joined(part: Part, parts: Sequence[Part], reach: float, view: View) -> list[Part]:
    """The bodies that a symbol must not disappear behind: those that it joins."""
    middle = part.points[0] if part.role == "rod" else part.points.mean(axis=0)
    return [
        other
        for other in parts
        if (other.role not in _SYMBOLS or (part.role == "rod" and other.role == "collar"))
        and set(other.links) & set(part.links)
        and not (part.role == "collar" and other.role == "rod" and _faces(other, view))
        and _distance(other.points, middle) < reach
    ]


def _distance(points: Array, place: Array) -> float:
    """From a place to the nearest of the points, or to the line between two of them."""
    if len(points) == 2:
        way = points[1] - points[0]
        share = np.clip((place - points[0]) @ way / max(float(way @ way), 1e-18), 0.0, 1.0)
        points = points[:1] + share * way
    return float(np.linalg.norm(points - place, axis=1).min())
