"""What a mechanism looks like without paint: bodies, joints, closures and base as marks, colours of its links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..description.model import Loop
from ..ground.arrays import Array
from .attach import Attached, extent
from .bodies import link_parts, shapes, slide_parts
from .groups import Group
from .parts import Part, stub
from .points import distinct
from .skeleton import PlacedClosure, Skeleton
from .style import INK, LOOPS, QUIET
from .symbols import Mark, Stroke, closure_marks, joint_marks
from .view import UP, View


def solid_marks(
    skeleton: Skeleton,
    groups: Sequence[Group],
    attached: Mapping[str, Attached],
    view: View,
    unit: float,
) -> list[Mark]:
    """Links, then joints, then closures; `unit` is the radius of a joint [m]."""
    cylinders = {c.joint.name: c for what in attached.values() for c in what.barrels}
    marks: list[Mark] = [*_bodies(skeleton, groups, attached, unit)]
    for joint in (
        g.first for g in groups if g.kind == "prismatic" and g.first.name not in cylinders
    ):
        marks += slide_parts(joint, unit)
    for group in groups:
        marks += joint_marks(group, cylinders.get(group.first.name), view, unit)
    hinges = [joint.point for joint in skeleton.joints if joint.type == "revolute"]
    for closure in skeleton.closures:
        marks += closure_marks(closure, _normal(skeleton, closure), hinges, unit)
    return marks


def _bodies(
    skeleton: Skeleton, groups: Sequence[Group], attached: Mapping[str, Attached], unit: float
) -> list[Mark]:
    inner = {link for group in groups for link in group.inner}
    marks: list[Mark] = []
    for group in groups:
        if group.kind == "carrier":  # links without a body: a dot each, where the coordinates end
            marks += [Stroke(f"link:{link}", "dot", group.last.point[None]) for link in group.inner]
    for link in skeleton.links:
        if link != skeleton.base and link not in inner:
            marks += link_parts(link, attached[link], unit, extent(skeleton))
    return marks


def base_marks(
    skeleton: Skeleton, groups: Sequence[Group], what: Attached, unit: float
) -> list[Part]:
    """The base of a spatial mechanism: a plate, or a disc where it carries one joint only."""
    owner, points = f"link:{skeleton.base}", distinct(what.fixed, extent(skeleton))
    if len(points) == 0:
        return []
    if len(points) > 1:
        return [
            Part(owner, "base", p, 1.7 * unit, None, (skeleton.base,))
            for _, p in shapes(points, points, unit)
        ]
    held = next(
        group.first
        for group in groups
        if group.first.parent == skeleton.base and group.kind != "carrier"
    )
    axis = UP if held.type == "prismatic" else held.axis * (1.0 if held.axis @ UP >= 0.0 else -1.0)
    return [
        Part(owner, "base", stub(points[0] - 1.5 * unit * axis, axis, 0.3 * unit), 3.4 * unit, axis)
    ]


def _normal(skeleton: Skeleton, closure: PlacedClosure) -> Array:
    """The common axis of a planar loop's hinges."""
    hinges = [j.axis for j in skeleton.joints if j.name in closure.joints and j.type == "revolute"]
    return hinges[0] if hinges else closure.axis


def link_colours(skeleton: Skeleton, loops: Mapping[str, Loop]) -> dict[str, str]:
    """The arm in ink, every other link in the colour of the first loop it belongs to."""
    child = {joint.name: joint.child for joint in skeleton.joints}
    colours = dict.fromkeys(skeleton.arm, INK)
    order = {closure.name: LOOPS[k % len(LOOPS)] for k, closure in enumerate(skeleton.closures)}
    for name, colour in order.items():
        if name in loops:
            for link in (loops[name].k1, loops[name].k2):
                colours.setdefault(link, colour)
    for closure in skeleton.closures:
        for joint in closure.joints:
            colours.setdefault(child[joint], order[closure.name])
    for link in skeleton.links:
        colours.setdefault(link, QUIET)
    return colours | {f"closure:{name}": colour for name, colour in order.items()}
