"""Solid parts of a drawing: a few points with a radius.

What is seen of them is always a convex outline.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..ground.arrays import Array
from .view import UP, View

Role = Literal[
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
_AROUND = np.linspace(0.0, 2.0 * np.pi, 29)[:-1]
_CIRCLE = np.stack([np.cos(_AROUND), np.sin(_AROUND)], axis=1)


@dataclass(frozen=True, eq=False)
class Part:
    """A body around points (k, 3) [m]: balls of a radius joined by their hull, or with `axis` discs across it."""

    owner: str  # "link:NAME", "joint:NAME", "closure:NAME" or "base:NAME"
    role: Role
    points: Array
    radius: float
    axis: Array | None = None
    links: tuple[str, ...] = ()  # on which it sits

    def outline(self, view: View) -> Array:
        """(m, 2) corners of what is seen of it, counterclockwise."""
        if self.axis is None:
            corners = view.flat(self.points)[:, None] + self.radius * _CIRCLE[None]
        else:
            corners = view.flat(self.points[:, None] + self._disc()[None])
        return hull(corners.reshape(-1, 2))

    def cap(self, view: View) -> Array | None:
        """(m, 2) outline of the end that faces the viewer, None where none does."""
        if self.axis is None or abs(self.axis @ view.toward) < 0.05:
            return None
        nearest = int(np.argmax(view.depth(self.points)))
        return hull(view.flat(self.points[nearest] + self._disc()))

    def depth(self, view: View) -> float:
        """How near its middle is to the viewer [m]."""
        return float(view.depth(self.points).mean())

    def _disc(self) -> Array:
        """(n, 3) points of the circle across the axis, about zero."""
        across, other = across_axis(UP if self.axis is None else self.axis)
        return self.radius * (_CIRCLE @ np.stack([across, other]))


def across_axis(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors that make a right-handed frame with a unit axis as the third."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    across = np.cross(helper, axis)
    across /= np.linalg.norm(across)
    return across, np.cross(axis, across)


def stub(middle: Array, axis: Array, half: float) -> Array:
    """(2, 3) ends of a short piece of an axis."""
    return np.stack([middle - half * axis, middle + half * axis])


def hull(points: Array) -> Array:
    """(k, 2) -> (m, 2): corners of the convex hull, counterclockwise; one or two points stay as they are."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    if len(ordered) < 3:
        return np.array(ordered)
    return np.array(_chain(ordered) + _chain(ordered[::-1]))


def _chain(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """One side of the hull, without its last point."""
    kept: list[tuple[float, float]] = []
    for x, y in points:
        while len(kept) > 1:
            (x0, y0), (x1, y1) = kept[-2:]
            if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0.0:
                break
            kept.pop()
        kept.append((x, y))
    return kept[:-1]
