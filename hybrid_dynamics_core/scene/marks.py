"""A mechanism without paint: bodies, joints, closures and base, and the colours of its links."""

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


def solid_marks(
    skeleton: Skeleton,
    groups: Sequence[JointGroup],
    attached: Mapping[str, Attached],
    projection: Projection,
    unit: float,
) -> list[Mark]:
    """Links, then joints, then closures.

    Args:
        skeleton: the mechanism.
        groups: its joints as they are drawn.
        attached: what its links carry.
        projection: of the picture.
        unit: radius of a joint [m].

    Returns:
        Parts and lines.
    """
    cylinders = cylinders_of(attached)
    marks = _bodies(skeleton, groups, attached, unit)
    for joint in joints_on_rails(groups, cylinders):
        marks += slide_parts(joint, unit)
    for group in groups:
        cylinder = cylinders.get(group.first.name)
        marks += joint_marks(group, cylinder, projection, unit)
    hinges = [joint.point for joint in skeleton.hinges]
    for closure in skeleton.closures:
        normal = _normal(skeleton, closure)
        marks += closure_marks(closure, normal, hinges, unit)
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
    unit: float,
) -> list[Mark]:
    bodiless = {skeleton.base}
    marks: list[Mark] = []
    for group in groups:
        bodiless.update(group.inner)
        if group.kind == "carrier":
            marks += inner_dots(group)
    size = mechanism_size(skeleton)
    for link in skeleton.links:
        if link not in bodiless:
            marks += link_parts(link, attached[link], unit, size)
    return marks


def base_marks(
    skeleton: Skeleton,
    groups: Sequence[JointGroup],
    attached: Attached,
    unit: float,
) -> list[Part]:
    """The base of a spatial mechanism: a plate, or a disc where it carries one joint only.

    Args:
        skeleton: the mechanism.
        groups: its joints as they are drawn.
        attached: what the base carries.
        unit: radius of a joint [m].

    Returns:
        Its parts; none where it carries nothing.
    """
    base = skeleton.base
    points = distinct(attached.fixed, mechanism_size(skeleton))
    if len(points) == 0:
        return []
    if len(points) == 1:
        axis = _base_axis(base, groups)
        below = points[0] - 1.5 * unit * axis
        disc = axis_segment(below, axis, 0.3 * unit)
        return [Part(f"link:{base}", "base", disc, 3.4 * unit, axis)]
    shapes = body_shapes(points, points, unit)
    return [_base_plate(base, corners, unit) for _, corners in shapes]


def _base_plate(base: str, corners: Array, unit: float) -> Part:
    return Part(
        owner=f"link:{base}",
        role="base",
        points=corners,
        radius=1.7 * unit,
        links=(base,),
    )


def _base_axis(base: str, groups: Sequence[JointGroup]) -> Array:
    """The axis (3,) of the first joint on the base, upward."""
    bodies = [group.first for group in groups if group.kind != "carrier"]
    joint = next(joint for joint in bodies if joint.parent == base)
    if joint.type == "prismatic":
        return UP
    if joint.axis @ UP >= 0.0:
        return joint.axis
    return -joint.axis


def _normal(skeleton: Skeleton, closure: PlacedClosure) -> Array:
    """The common axis (3,) of a planar loop's hinges."""
    for joint in skeleton.hinges:
        if joint.name in closure.joints:
            return joint.axis
    return closure.axis


def link_colours(skeleton: Skeleton, loops: Mapping[str, Loop]) -> dict[str, str]:
    """The arm in ink, every other link in the colour of the first loop it belongs to.

    Args:
        skeleton: the mechanism.
        loops: of the description; their links k1 and k2 take the colour of the loop.

    Returns:
        Colours by link, and by closure under "closure:NAME".
    """
    child = {joint.name: joint.child for joint in skeleton.joints}
    closures = {}
    for k, closure in enumerate(skeleton.closures):
        closures[closure.name] = LOOPS[k % len(LOOPS)]
    colours = dict.fromkeys(skeleton.arm, INK)
    for name, colour in closures.items():
        if name in loops:
            loop = loops[name]
            colours.setdefault(loop.k1, colour)
            colours.setdefault(loop.k2, colour)
    for closure in skeleton.closures:
        for name in closure.joints:
            colours.setdefault(child[name], closures[closure.name])
    for link in skeleton.links:
        colours.setdefault(link, QUIET)
    for name, colour in closures.items():
        colours[f"closure:{name}"] = colour
    return colours
