"""Arrows of what is driven: round the axis of a hinge, along a cylinder where there is room."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.path import Path

from ..ground.arrays import Array
from .attach import Cylinder
from .parts import across_axis, stub
from .skeleton import PlacedJoint
from .symbols import Stroke
from .view import View

_ROUND = 2.3  # radius of the arrow round an axis, in radii of a joint
_BESIDE = 2.4  # distance of the arrow beside a cylinder


def turn_arrow(joint: PlacedJoint, view: View, unit: float, shell: int) -> Stroke:
    """An arc about the axis, tilted where the true arc would be seen edge-on; `shell`: arcs inside of it."""
    axis, middle = joint.axis, joint.point
    along = float(axis @ view.toward)
    if abs(along) < 0.35:
        middle = middle + 2.6 * unit * axis
        axis = axis + (0.42 - abs(along)) * view.toward * (1.0 if along >= 0.0 else -1.0)
        axis = axis / np.linalg.norm(axis)
    across, other = across_axis(axis)
    corner = view.up - view.right  # the gap of the arc is up and to the left
    start = float(np.arctan2(other @ corner, across @ corner))
    angles = start + np.radians(np.linspace(30.0, 320.0, 41))
    radius = (_ROUND + 0.9 * shell) * unit
    arc = middle + radius * (np.outer(np.cos(angles), across) + np.outer(np.sin(angles), other))
    return Stroke(f"drive:{joint.name}", "turn", arc)


def travel_arrow(
    joint: PlacedJoint, cylinder: Cylinder | None, view: View, unit: float, covered: Sequence[Path]
) -> Stroke:
    """A double arrow beside a prismatic joint, on the side and at the place where it covers least of outlines."""
    sideways = np.cross(view.toward, joint.axis)
    sideways /= max(float(np.linalg.norm(sideways)), 1e-9)
    middles = [joint.point]
    half = 3.4 * unit
    if cylinder is not None:
        middles = [0.5 * (cylinder.mouth + cylinder.end), 0.5 * (cylinder.foot + cylinder.mouth)]
        half = min(half, 0.3 * float(np.linalg.norm(cylinder.end - cylinder.foot)))
    choices = [
        stub(middle + side * _BESIDE * unit * sideways, joint.axis, half)
        for middle in middles
        for side in (1.0, -1.0)
    ]
    costs = [_covering(view, choice, covered) + 0.1 * k for k, choice in enumerate(choices)]
    return Stroke(f"drive:{joint.name}", "travel", choices[int(np.argmin(costs))])


def _covering(view: View, ends: Array, covered: Sequence[Path]) -> int:
    """How many points of an arrow lie on parts."""
    points = view.flat(ends[0] + np.linspace(-0.1, 1.1, 13)[:, None] * (ends[1] - ends[0]))
    return int(sum(path.contains_points(points).sum() for path in covered))
