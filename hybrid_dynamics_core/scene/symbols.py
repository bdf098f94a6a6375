"""Joints and closures as symbols: hinges, collars, balls, pins and axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..ground.arrays import Array
from .attach import CylinderShape
from .groups import JointGroup
from .parts import Part, axis_segment
from .projection import Projection
from .skeleton import PlacedClosure, PlacedJoint

LineRole = Literal["axis", "turn", "travel", "carrier", "triad", "base axes", "dot"]

_FACING = 0.98  # cosine to the viewer's direction above which an axis is drawn as a point


@dataclass(frozen=True, eq=False)
class LineMark:
    """A line beside the parts: an axis, an arrow, a coordinate without a body.

    Attributes:
        owner: the owner, such as "axis:NAME" or "drive:NAME".
        role: its role in the picture.
        points: (k, 3) [m], base axes.
    """

    owner: str
    role: LineRole
    points: Array


Mark = Part | LineMark


def joint_marks(
    group: JointGroup,
    cylinder: CylinderShape | None,
    projection: Projection,
    joint_radius: float,
) -> list[Mark]:
    """The symbol of a joint, or of several that are drawn as one.

    Args:
        group: the joints.
        cylinder: the cylinder of their prismatic joint, or None.
        projection: projection of the picture.
        joint_radius: radius of a joint [m].
    """
    if group.kind == "carrier":
        ends = np.stack([group.first.start, group.last.point])
        return [LineMark(f"joint:{group.names}", "carrier", ends)]
    if group.kind == "spherical":
        return [_ball(group, joint_radius), *inner_dots(group)]
    if group.kind == "universal":
        return _cross(group, joint_radius)
    if group.kind == "prismatic":
        if cylinder is None:
            return []
        return [_collar(group.first, cylinder, joint_radius)]
    return _hinge(group.first, projection, joint_radius)


def closure_marks(
    closure: PlacedClosure,
    normal: Array,
    hinges: Sequence[Array],
    joint_radius: float,
) -> list[Mark]:
    """The symbol of a closure: a pin, a spherical joint, a hinge or a weld.

    Args:
        closure: the closure.
        normal: (3,) axis of the loop's hinges.
        hinges: points (3,) of all hinges [m]; a pin at the place of a hinge is wider.
        joint_radius: radius of a joint [m].

    Returns:
        The symbol.
    """
    owner = f"closure:{closure.name}"
    point, links = closure.point, closure.links
    if closure.kind == "point":
        return [Part(owner, "ball", point[None], 1.15 * joint_radius, None, links)]
    if closure.kind == "frame":
        ends = axis_segment(point, closure.axis, 0.9 * joint_radius)
        return [Part(owner, "weld", ends, 0.9 * joint_radius, closure.axis, links)]
    axis = closure.axis if closure.kind == "axis" else normal
    ends = axis_segment(point, axis, 1.2 * joint_radius)
    width = 1.55 if _is_at(point, hinges, 0.5 * joint_radius) else 1.1
    return [Part(owner, "pin", ends, width * joint_radius, axis, links)]


def _is_at(point: Array, places: Sequence[Array], reach: float) -> bool:
    """Whether a point is at one of several places."""
    return any(np.linalg.norm(place - point) < reach for place in places)


def inner_dots(group: JointGroup) -> list[LineMark]:
    """A dot for each link without extent within a group."""
    point = group.last.point[None]
    return [LineMark(f"link:{link}", "dot", point) for link in group.inner]


def triad(
    owner: str,
    point: Array,
    rotation: Array,
    length: float,
) -> list[LineMark]:
    """Three arrows along the axes of a frame; x, y, z in this order."""
    arrows = []
    for k, letter in enumerate("xyz"):
        tip = point + length * rotation[:, k]
        arrows.append(LineMark(f"{owner}.{letter}", "triad", np.stack([point, tip])))
    return arrows


def _hinge(joint: PlacedJoint, projection: Projection, joint_radius: float) -> list[Mark]:
    marks: list[Mark] = []
    if abs(joint.axis @ projection.toward) < _FACING:
        length = 4.2 if joint.active else 3.0
        axis = axis_segment(joint.point, joint.axis, length * joint_radius)
        marks.append(LineMark(f"axis:{joint.name}", "axis", axis))
    hinge = Part(
        owner=f"joint:{joint.name}",
        role="hinge",
        points=axis_segment(joint.point, joint.axis, 1.25 * joint_radius),
        radius=joint_radius,
        axis=joint.axis,
        links=(joint.parent, joint.child),
    )
    marks.append(hinge)
    return marks


def _collar(joint: PlacedJoint, cylinder: CylinderShape, joint_radius: float) -> Part:
    axis = cylinder.direction
    return Part(
        owner=f"joint:{joint.name}",
        role="collar",
        points=axis_segment(cylinder.mouth, axis, 0.45 * joint_radius),
        radius=1.55 * joint_radius,
        axis=axis,
        links=(joint.parent, joint.child),
    )


def _ball(group: JointGroup, joint_radius: float) -> Part:
    return Part(
        owner=f"joint:{group.names}",
        role="ball",
        points=group.last.point[None],
        radius=1.3 * joint_radius,
        links=(group.first.parent, group.last.child),
    )


def _cross(group: JointGroup, joint_radius: float) -> list[Mark]:
    links = (group.first.parent, group.last.child)
    marks: list[Mark] = []
    for joint in group.joints:
        axle = Part(
            owner=f"joint:{joint.name}",
            role="hinge",
            points=axis_segment(joint.point, joint.axis, 1.6 * joint_radius),
            radius=0.42 * joint_radius,
            axis=joint.axis,
            links=links,
        )
        marks.append(axle)
    for link in group.inner:
        middle = Part(
            owner=f"link:{link}",
            role="cross",
            points=group.last.point[None],
            radius=0.62 * joint_radius,
            links=links,
        )
        marks.append(middle)
    return marks
