"""Parts and lines of a mechanism: bodies, joints, closures, base; and colours of links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..description.model import Loop
from ..ground.arrays import Array
from .attach import Attached, cylinders_of, mechanism_size
from .bodies import body_shapes, link_parts, slide_parts
from .groups import JointGroup
from .parts import Part, axis_segment
from .points import distinct
from .projection import UP, Projection
from .skeleton import PlacedClosure, PlacedJoint, Skeleton
from .style import INK, LOOPS, QUIET
from .symbols import Mark, closure_marks, inner_dots, joint_marks

# Sizes of the base in radii of a joint:
_DISC_DISTANCE = 1.5  # from the joint to the middle of the disc
_DISC_HALF_THICKNESS = 0.3
_DISC_RADIUS = 3.4
_PLATE_RADIUS = 1.7  # radius of the plate's corners


def solid_marks(
    skeleton: Skeleton,
    groups: Sequence[JointGroup],
    attached: Mapping[str, Attached],
    projection: Projection,
    joint_radius: float,
) -> list[Mark]:
    """Parts and lines of links, then of joints, then of closures.

    Args:
        skeleton: the mechanism.
        groups: its joints as they are drawn.
        attached: points and cylinders of its links.
        projection: projection of the picture.
        joint_radius: radius of a joint [m].

    Returns:
        Parts and lines.
    """
    cylinders = cylinders_of(attached)
    marks = _bodies(skeleton, groups, attached, joint_radius)
    for joint in joints_on_rails(groups, cylinders):
        marks += slide_parts(joint, joint_radius)
    for group in groups:
        cylinder = cylinders.get(group.first.name)
        marks += joint_marks(group, cylinder, projection, joint_radius)
    hinges = [joint.point for joint in skeleton.hinges]
    for closure in skeleton.closures:
        normal = _normal(skeleton, closure)
        marks += closure_marks(closure, normal, hinges, joint_radius)
    return marks


def joints_on_rails(
    groups: Sequence[JointGroup], cylinders: Mapping[str, object]
) -> list[PlacedJoint]:
    """Prismatic joints that are no cylinders."""
    prismatic = [group.first for group in groups if group.kind == "prismatic"]
    return [joint for joint in prismatic if joint.name not in cylinders]


def _bodies(
    skeleton: Skeleton,
    groups: Sequence[JointGroup],
    attached: Mapping[str, Attached],
    joint_radius: float,
) -> list[Mark]:
    """Parts of all links that have an extent, and dots for those between coinciding joints."""
    bodiless = {skeleton.base}
    marks: list[Mark] = []
    for group in groups:
        bodiless.update(group.inner)
        if group.kind == "carrier":
            marks += inner_dots(group)
    size = mechanism_size(skeleton)
    for link in skeleton.links:
        if link not in bodiless:
            marks += link_parts(link, attached[link], joint_radius, size)
    return marks


def base_marks(
    skeleton: Skeleton,
    groups: Sequence[JointGroup],
    attached: Attached,
    joint_radius: float,
) -> list[Part]:
    """The base of a spatial mechanism: a plate, or a disc if it carries only one joint.

    Args:
        skeleton: the mechanism.
        groups: its joints as they are drawn.
        attached: points and cylinders of the base.
        joint_radius: radius of a joint [m].

    Returns:
        Its parts; empty if it carries nothing.
    """
    base = skeleton.base
    points = distinct(attached.fixed, mechanism_size(skeleton))
    if len(points) == 0:
        return []
    if len(points) == 1:
        return [_base_disc(base, points[0], _base_axis(base, groups), joint_radius)]
    shapes = body_shapes(points, points, joint_radius)
    return [_base_plate(base, corners, joint_radius) for _, corners in shapes]


def _base_disc(base: str, joint: Array, axis: Array, joint_radius: float) -> Part:
    """A disc below the only joint (3,) [m] of a base, normal to its axis (3,)."""
    below = joint - _DISC_DISTANCE * joint_radius * axis
    return Part(
        owner=f"link:{base}",
        role="base",
        points=axis_segment(below, axis, _DISC_HALF_THICKNESS * joint_radius),
        radius=_DISC_RADIUS * joint_radius,
        axis=axis,
    )


def _base_plate(base: str, corners: Array, joint_radius: float) -> Part:
    """A plate over corners (k, 3) [m]."""
    return Part(
        owner=f"link:{base}",
        role="base",
        points=corners,
        radius=_PLATE_RADIUS * joint_radius,
        links=(base,),
    )


def _base_axis(base: str, groups: Sequence[JointGroup]) -> Array:
    """The axis (3,) of the first joint on the base, pointing up; vertical for a slide."""
    joints = [group.first for group in groups if group.kind != "carrier"]
    on_base = [joint for joint in joints if joint.parent == base]
    if not on_base or on_base[0].type == "prismatic":
        return UP
    axis = on_base[0].axis
    if axis @ UP >= 0.0:
        return axis
    return -axis


def _normal(skeleton: Skeleton, closure: PlacedClosure) -> Array:
    """The common axis (3,) of a planar loop's hinges; the closure's axis if it has no hinges."""
    for joint in skeleton.hinges:
        if joint.name in closure.joints:
            return joint.axis
    return closure.axis


def link_colours(skeleton: Skeleton, loops: Mapping[str, Loop]) -> dict[str, str]:
    """Colours of links and closures.

    The arm is dark (INK). Every other link has the colour of the first loop that it belongs to. A
    link of no loop is grey (QUIET).

    Args:
        skeleton: the mechanism.
        loops: loops of the description; their links k1 and k2 take the colour of the loop.

    Returns:
        Colours by link, and by closure under "closure:NAME".
    """
    child_of = {joint.name: joint.child for joint in skeleton.joints}
    closure_colours = {}
    for k, closure in enumerate(skeleton.closures):
        closure_colours[closure.name] = LOOPS[k % len(LOOPS)]
    colours = dict.fromkeys(skeleton.arm, INK)
    for name, colour in closure_colours.items():
        if name in loops:
            loop = loops[name]
            colours.setdefault(loop.k1, colour)
            colours.setdefault(loop.k2, colour)
    for closure in skeleton.closures:
        for name in closure.joints:
            colours.setdefault(child_of[name], closure_colours[closure.name])
    for link in skeleton.links:
        colours.setdefault(link, QUIET)
    for name, colour in closure_colours.items():
        colours[f"closure:{name}"] = colour
    return colours
