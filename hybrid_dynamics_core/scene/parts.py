"""Solid parts of a drawing: points with a radius, whose outline is convex."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..ground.arrays import Array
from .projection import UP, Projection

PartRole = Literal[
    "plate",
    "bar",
    "rod",
    "barrel",
    "block",
    "rail",
    "hinge",
    "collar",
    "ball",
    "cross",
    "pin",
    "weld",
    "base",
]
_ANGLES = np.linspace(0.0, 2.0 * np.pi, 29)[:-1]
_CIRCLE = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
_EDGE_ON = 0.05  # cosine to the viewer's direction below which a disc is seen edge-on


@dataclass(frozen=True, eq=False)
class Part:
    """The convex hull of balls around points or, with `axis`, of discs normal to it.

    Attributes:
        owner: "link:NAME", "joint:NAME", "closure:NAME" or "base:NAME".
        role: its role in the picture.
        points: (k, 3) [m], base axes.
        radius: radius of balls and discs [m].
        axis: (3,) unit normal of the discs; None: balls.
        links: names of the links that it is on.
    """

    owner: str
    role: PartRole
    points: Array
    radius: float
    axis: Array | None = None
    links: tuple[str, ...] = ()

    def outline(self, projection: Projection) -> Array:
        """(m, 2) corners of its outline in a picture [m], counterclockwise."""
        if self.axis is None:
            centres = projection.project(self.points)
            corners = centres[:, None] + self.radius * _CIRCLE[None]
        else:
            rims = self.points[:, None] + self._disc()[None]
            corners = projection.project(rims)
        return convex_hull(corners.reshape(-1, 2))

    def cap(self, projection: Projection) -> Array | None:
        """(m, 2) outline of the end that faces the viewer [m]; None if there is none."""
        if self.axis is None or abs(self.axis @ projection.toward) < _EDGE_ON:
            return None
        nearest = int(np.argmax(projection.depth(self.points)))
        rim = self.points[nearest] + self._disc()
        return convex_hull(projection.project(rim))

    def depth(self, projection: Projection) -> float:
        """Depth of its middle towards the viewer [m]."""
        return float(projection.depth(self.points).mean())

    def _disc(self) -> Array:
        """(n, 3) points of the circle about the origin, normal to the axis."""
        axis = UP if self.axis is None else self.axis
        circle = _CIRCLE @ np.stack(across_axis(axis))
        return self.radius * circle


def across_axis(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors (3,) that form a right-handed frame with a unit axis as the third."""
    least = int(np.argmin(np.abs(axis)))
    helper = np.eye(3)[least]
    across = np.cross(helper, axis)
    across /= np.linalg.norm(across)
    return across, np.cross(axis, across)


def axis_segment(middle: Array, axis: Array, half: float) -> Array:
    """(2, 3) ends of a segment of an axis, each at the distance `half` from its middle."""
    return np.stack([middle - half * axis, middle + half * axis])


def convex_hull(points: Array) -> Array:
    """Corners (m, 2) of the convex hull of points (k, 2), counterclockwise."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    if len(ordered) < 3:
        return np.array(ordered)
    lower = _hull_side(ordered)
    upper = _hull_side(ordered[::-1])
    return np.array(lower + upper)


def _hull_side(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """One side of the hull of sorted points, without its last point."""
    side: list[tuple[float, float]] = []
    for x, y in points:
        while len(side) > 1:
            (x0, y0), (x1, y1) = side[-2:]
            if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0.0:
                break
            side.pop()
        side.append((x, y))
    return side[:-1]
