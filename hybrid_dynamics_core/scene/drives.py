"""Arrows of driven joints: around the axis of a hinge, or beside a prismatic joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.path import Path

from ..ground.arrays import Array
from .attach import CylinderShape
from .parts import across_axis, axis_segment
from .projection import Projection
from .skeleton import PlacedJoint
from .symbols import LineMark

# Lengths in radii of a joint:
_ROUND = 2.3  # radius of the arrow around an axis
_SHELL = 0.9  # added for each arrow inside of it
_BEFORE = 2.6  # distance from the joint of an arrow whose axis lies in the picture
_BESIDE = 2.4  # distance of the arrow beside a cylinder
_HALF = 3.4  # half the length of that arrow
_SHORTEST = 1.7  # least half length, beside a short cylinder
_LATER = 0.1  # penalty of each later candidate, in covered points
_END_ON = 1e-6  # sine to the viewer's direction below which an axis is a point
_EDGE_ON = 0.35  # cosine to the viewer's direction below which an arc is tilted


def turn_arrow(
    joint: PlacedJoint,
    projection: Projection,
    joint_radius: float,
    inside: int,
) -> LineMark:
    """An arc around the axis, tilted if the true arc would be seen edge-on.

    Args:
        joint: driven joint.
        projection: projection of the picture.
        joint_radius: radius of a joint [m].
        inside: number of arcs inside of it.

    Returns:
        The arc.
    """
    axis, middle = joint.axis, joint.point
    along = float(axis @ projection.toward)
    if abs(along) < _EDGE_ON:
        middle = middle + _BEFORE * joint_radius * axis
        side = 1.0 if along >= 0.0 else -1.0
        axis = axis + (0.42 - abs(along)) * projection.toward * side
        axis = axis / np.linalg.norm(axis)
    across, other = across_axis(axis)
    corner = projection.up - projection.right  # direction of the arc's gap: up and to the left
    start = float(np.arctan2(other @ corner, across @ corner))
    angles = start + np.radians(np.linspace(30.0, 320.0, 41))
    radius = (_ROUND + _SHELL * inside) * joint_radius
    cosines = np.outer(np.cos(angles), across)
    circle = cosines + np.outer(np.sin(angles), other)
    return LineMark(f"drive:{joint.name}", "turn", middle + radius * circle)


def travel_arrow(
    joint: PlacedJoint,
    cylinder: CylinderShape | None,
    projection: Projection,
    joint_radius: float,
    outlines: Sequence[Path],
) -> LineMark:
    """A double arrow beside a prismatic joint, where it covers least.

    Args:
        joint: driven joint.
        cylinder: the joint as a cylinder, or None.
        projection: projection of the picture.
        joint_radius: radius of a joint [m].
        outlines: outlines of parts in the picture.

    Returns:
        The arrow.
    """
    sideways = _sideways(joint.axis, projection)
    middles = [joint.point]
    half = _HALF * joint_radius
    if cylinder is not None:
        middles = [
            0.5 * (cylinder.mouth + cylinder.end),
            0.5 * (cylinder.foot + cylinder.mouth),
        ]
        half = min(half, max(0.3 * cylinder.length, _SHORTEST * joint_radius))
    choices = []
    for middle in middles:
        for side in (1.0, -1.0):
            beside = middle + side * _BESIDE * joint_radius * sideways
            choices.append(axis_segment(beside, joint.axis, half))
    covered = [_covered_points(projection, ends, outlines) for ends in choices]
    costs = np.array(covered) + _LATER * np.arange(len(choices))
    best = choices[int(np.argmin(costs))]
    return LineMark(f"drive:{joint.name}", "travel", best)


def _sideways(axis: Array, projection: Projection) -> Array:
    """Unit vector (3,) normal to an axis in the picture; to the right if it is seen end-on."""
    across = np.cross(projection.toward, axis)
    length = float(np.linalg.norm(across))
    if length < _END_ON:
        return projection.right
    return np.asarray(across / length)


def _covered_points(projection: Projection, ends: Array, outlines: Sequence[Path]) -> int:
    """Number of points of an arrow that lie on parts."""
    shares = np.linspace(-0.1, 1.1, 13)
    along = ends[1] - ends[0]
    points = projection.project(ends[0] + shares[:, None] * along)
    covered = [outline.contains_points(points).sum() for outline in outlines]
    return int(sum(covered))
