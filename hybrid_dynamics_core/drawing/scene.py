"""A mechanism in one configuration as marks: everything that will be painted, with the colours of its links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path

from ..description.model import Array, Loop, RobotDescription
from .attach import Attached, Cylinder, attach, extent, rail
from .bodies import link_parts, shapes, slide_parts
from .drives import travel_arrow, turn_arrow
from .groups import Group, group_joints
from .parts import Part, stub
from .points import distinct
from .skeleton import PlacedClosure, Skeleton
from .style import INK, LOOPS, QUIET
from .symbols import Mark, Stroke, closure_marks, joint_marks, triad
from .view import UP, View

_UNIT = 0.0125  # radius of a joint, of the size of the picture
_SMALLEST = 0.1  # [m] size of the picture of a robot that is one point
_TRIAD = 0.075  # length of the end effector's axes


@dataclass(frozen=True, eq=False)
class Scene:
    """What is painted. `unit`: radius of a joint [m]; `colours` by link, and by closure under "closure:NAME"."""

    skeleton: Skeleton
    view: View
    groups: tuple[Group, ...]
    parts: tuple[Part, ...]
    strokes: tuple[Stroke, ...]
    colours: Mapping[str, str]
    unit: float
    ground: tuple[Array, ...]  # (3,) each: where the base of a planar mechanism is held


def build_scene(description: RobotDescription, skeleton: Skeleton, view: View, unit: float | None = None) -> Scene:
    """Turn a skeleton into marks; `unit` as in another scene, or such that it suits this one."""
    if view.planar:
        skeleton = skeleton.pressed(view.toward)
    groups = group_joints(skeleton)
    attached = attach(skeleton, groups)
    cylinders = {c.joint.name: c for what in attached.values() for c in what.barrels}
    slides = [g.first for g in groups if g.kind == "prismatic" and g.first.name not in cylinders]
    if unit is None:
        points = view.flat(np.vstack([skeleton.points, *(rail(joint) for joint in slides)]))
        width, height = np.ptp(points, axis=0)
        unit = _UNIT * (max(float(width), 1.25 * float(height)) or _SMALLEST)
    marks: list[Mark] = [*_bodies(skeleton, groups, attached, unit)]
    for joint in slides:
        marks += slide_parts(joint, unit)
    for group in groups:
        marks += joint_marks(group, cylinders.get(group.first.name), view, unit)
    hinges = [joint.point for joint in skeleton.joints if joint.type == "revolute"]
    for closure in skeleton.closures:
        marks += closure_marks(closure, _normal(skeleton, closure), hinges, unit)
    if not view.planar:
        marks += _base(skeleton, groups, attached[skeleton.base], unit)
    parts = tuple(mark for mark in marks if isinstance(mark, Part))
    strokes = [mark for mark in marks if isinstance(mark, Stroke)]
    strokes += _drives(skeleton, cylinders, view, unit, parts)
    size = _TRIAD * unit / _UNIT
    strokes += triad(f"frame:{skeleton.tip.name}", skeleton.tip.point, skeleton.tip.rotation, size)
    ground = tuple(distinct(attached[skeleton.base].fixed, extent(skeleton))) if view.planar else ()
    colours = link_colours(skeleton, description.loops)
    return Scene(skeleton, view, groups, parts, tuple(strokes), colours, unit, ground)


def _bodies(skeleton: Skeleton, groups: Sequence[Group], attached: Mapping[str, Attached], unit: float) -> list[Mark]:
    inner = {link for group in groups for link in group.inner}
    marks: list[Mark] = []
    for group in groups:
        if group.kind == "carrier":  # links without a body: a dot each, where the coordinates end
            marks += [Stroke(f"link:{link}", "dot", group.last.point[None]) for link in group.inner]
    for link in skeleton.links:
        if link != skeleton.base and link not in inner:
            marks += link_parts(link, attached[link], unit, extent(skeleton))
    return marks


def _drives(
    skeleton: Skeleton, cylinders: Mapping[str, Cylinder], view: View, unit: float, parts: Sequence[Part]
) -> list[Stroke]:
    """An arrow for every active joint; arrows round one place get growing radii."""
    covered = [Path(part.outline(view)) for part in parts]
    strokes: list[Stroke] = []
    turned: list[Array] = []
    for joint in skeleton.joints:
        if joint.active and joint.type == "prismatic":
            strokes.append(travel_arrow(joint, cylinders.get(joint.name), view, unit, covered))
        elif joint.active:
            shell = sum(float(np.linalg.norm(joint.point - place)) < unit for place in turned)
            turned.append(joint.point)
            strokes.append(turn_arrow(joint, view, unit, shell))
    return strokes


def _base(skeleton: Skeleton, groups: Sequence[Group], what: Attached, unit: float) -> list[Part]:
    """The base of a spatial mechanism: a plate, or a disc where it carries one joint only."""
    owner, points = f"link:{skeleton.base}", distinct(what.fixed, extent(skeleton))
    if len(points) == 0:
        return []
    if len(points) > 1:
        return [Part(owner, "base", p, 1.7 * unit, None, (skeleton.base,)) for _, p in shapes(points, points, unit)]
    held = next(group.first for group in groups if group.first.parent == skeleton.base and group.kind != "carrier")
    axis = UP if held.type == "prismatic" else held.axis * (1.0 if held.axis @ UP >= 0.0 else -1.0)
    return [Part(owner, "base", stub(points[0] - 1.5 * unit * axis, axis, 0.3 * unit), 3.4 * unit, axis)]


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
