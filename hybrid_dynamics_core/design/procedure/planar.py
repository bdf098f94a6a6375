"""Planar triangles and four-bars at one configuration, in the plane of a loop."""

from __future__ import annotations

import math

import numpy as np

from ...errors import InputError
from ...ground.arrays import Array


def point(x: float, y: float) -> Array:
    """A point (2,)."""
    return np.array([x, y])


def along(angle: float, length: float = 1.0) -> Array:
    """A vector (2,) of a length at an angle."""
    return length * point(math.cos(angle), math.sin(angle))


def turned(vector: Array, angle: float) -> Array:
    """A vector (2,) turned by an angle."""
    across = point(-vector[1], vector[0])
    return np.asarray(math.cos(angle) * vector + math.sin(angle) * across)


def angle_of(vector: Array) -> float:
    """The angle of a vector (2,) [rad]."""
    x, y = vector.tolist()
    return math.atan2(y, x)


def distance(one: Array, other: Array) -> float:
    """Distance of two points."""
    x, y = (one - other).tolist()
    return math.hypot(x, y)


def meeting_point(
    place: str, centres: tuple[Array, Array], bars: tuple[float, float], left: bool
) -> Array:
    """Where two bars meet that turn about two centres.

    Args:
        place: the loop, for messages.
        centres: of the first and the second bar (2,) [m].
        bars: their lengths [m].
        left: whether the point is on the left of the way from the first centre to the second.

    Raises:
        InputError: the bars do not meet.
    """
    apart = distance(*centres)
    first, second = bars
    if apart > first + second or apart < abs(first - second) or not apart:
        raise InputError(
            f"{place}: does not close: its bars of {first:.4g} and {second:.4g} m do not meet over"
            f" {apart:.4g} m"
        )
    ahead = (apart * apart + first * first - second * second) / (2.0 * apart)
    aside = math.sqrt(max(first * first - ahead * ahead, 0.0))
    if not left:
        aside = -aside
    direction = angle_of(centres[1] - centres[0])
    return np.asarray(centres[0] + turned(point(ahead, aside), direction))
