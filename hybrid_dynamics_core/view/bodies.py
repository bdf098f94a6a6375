"""A robot as solid bodies, each fixed to a link, and spans between two links: made once, moved afterwards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..mechanism.tree import Tree, build_tree
from ..robot.robot import Robot
from ..scene.attach import Attached, CylinderShape, attach, rail
from ..scene.groups import JointGroup, group_joints
from ..scene.marks import base_marks, link_colours, solid_marks
from ..scene.parts import Part
from ..scene.projection import choose_projection
from ..scene.skeleton import PlacedJoint, Pose, Skeleton, link_poses, place_skeleton
from ..scene.style import INK, QUIET, RED, mix
from ..scene.symbols import LineMark
from . import meshes
from .meshes import Mesh

UNIT: Final = 0.0135  # radius of a joint, of the size of the robot
SMALLEST: Final = 0.1  # [m] size of a robot that is one point
STEEL: Final = "#c3ccd5"
OUT: Final = 1.75  # how much longer the hinge of a drive is on the base
Kind = Literal["link", "joint", "closure"]


@dataclass(frozen=True, eq=False)
class Body:
    """A solid body that moves with a link: `mesh` in the axes of the link; `names`: what of the robot it shows."""

    kind: Kind
    names: tuple[str, ...]
    link: str
    mesh: Mesh
    colour: str
    role: str


@dataclass(frozen=True, eq=False)
class Span:
    """What reaches from a point of one link to a point of another, each (3,) in the axes of its link [m]: a rod.

    along: its direction in the axes of the first link, where that is always the same.
    """

    kind: Kind
    names: tuple[str, ...]
    links: tuple[str, str]
    points: tuple[Array, Array]
    radius: float
    colour: str
    along: Array | None = None


@dataclass(frozen=True, eq=False)
class Anchor:
    """Where the name and the effort of a joint are shown: a point and the joint's axis (3,) in the axes of a link."""

    link: str
    point: Array
    axis: Array


@dataclass(frozen=True, eq=False)
class Shape:
    """All that is seen of a robot; `anchors` by joint.

    unit: radius of a joint [m]. size: of the robot [m]. points: (k, 3) what a camera has to show.
    """

    robot: Robot
    home: ClosedState
    tree: Tree
    skeleton: Skeleton
    bodies: tuple[Body, ...]
    spans: tuple[Span, ...]
    anchors: Mapping[str, Anchor]
    unit: float
    size: float
    points: Array

    def poses(self, state: ClosedState) -> dict[str, Pose]:
        """Pose of every link in a closed state."""
        return link_poses(self.tree, state.s)


def shape_of(robot: Robot, state: ClosedState) -> Shape:
    """The bodies of a robot; their lengths are those of one closed state."""
    skeleton = place_skeleton(robot, state)
    tree = build_tree(robot.description)
    groups = group_joints(skeleton)
    attached = {
        link: _within_limits(robot, state, what) for link, what in attach(skeleton, groups).items()
    }
    cylinders = {c.joint.name: c for what in attached.values() for c in what.barrels}
    rails = [
        rail(g.first) for g in groups if g.kind == "prismatic" and g.first.name not in cylinders
    ]
    points = np.vstack([skeleton.points, *rails])
    size = max(float(np.linalg.norm(np.ptp(points, axis=0))), SMALLEST)
    unit = UNIT * size
    marks = solid_marks(skeleton, groups, attached, choose_projection(skeleton), unit)
    marks += base_marks(skeleton, groups, attached[skeleton.base], unit)
    maker = _Maker(robot, skeleton, groups, unit, link_poses(tree, state.s))
    for mark in marks:
        maker.add(mark)
    for group in groups:
        if group.kind == "carrier":
            maker.carrier(group)
    anchors = {
        joint.name: maker.anchor(joint, cylinders.get(joint.name)) for joint in skeleton.joints
    }
    return Shape(
        robot,
        state,
        tree,
        skeleton,
        tuple(maker.bodies),
        tuple(maker.spans),
        anchors,
        unit,
        size,
        points,
    )


def span_pose(span: Span, poses: Mapping[str, Pose]) -> tuple[Array, Array, float]:
    """Rotation (3, 3) with z along a span, its start (3,) and its length [m]."""
    start, end = (
        poses[link][0] @ point + poses[link][1]
        for link, point in zip(span.links, span.points, strict=True)
    )
    if span.along is not None:
        along = poses[span.links[0]][0] @ span.along
        return meshes.frame_along(along), start, max(float((end - start) @ along), 0.0)
    length = float(np.linalg.norm(end - start))
    return meshes.frame_along(end - start) if length > 0.0 else np.eye(3), start, length


def _within_limits(robot: Robot, state: ClosedState, what: Attached) -> Attached:
    """Barrels short enough for the whole stroke."""
    lower, upper = (dict(zip(robot.active, ends.tolist(), strict=True)) for ends in robot.limits.T)

    def limited(cylinder: CylinderShape) -> CylinderShape:
        joint, value = cylinder.joint, float(state.s[robot.coordinates.index(cylinder.joint.name)])
        outward = float(cylinder.direction @ joint.axis) > 0.0
        end = (
            lower.get(joint.name, joint.limits[0])
            if outward
            else upper.get(joint.name, joint.limits[1])
        )
        shortest = float(np.linalg.norm(cylinder.end - cylinder.foot)) - abs(value - end)
        return replace(cylinder, shortest=shortest) if shortest > 0.0 else cylinder

    return replace(
        what, barrels=[limited(c) for c in what.barrels], rods=[limited(c) for c in what.rods]
    )


class _Maker:
    """Turns marks, which are in base axes, into bodies in the axes of their links."""

    def __init__(
        self,
        robot: Robot,
        skeleton: Skeleton,
        groups: Sequence[JointGroup],
        unit: float,
        poses: Mapping[str, Pose],
    ) -> None:
        self.skeleton, self.unit, self.poses = skeleton, unit, poses
        self.groups = {group.names: tuple(joint.name for joint in group.joints) for group in groups}
        self.joints = {joint.name: joint for joint in skeleton.joints}
        self.colours = link_colours(skeleton, robot.description.loops)
        self.bodies: list[Body] = []
        self.spans: list[Span] = []

    def add(self, mark: Part | LineMark) -> None:
        if isinstance(mark, Part):
            if mark.role == "rod":
                self.rod(mark)
            else:
                self.body(mark)
        elif mark.role == "dot":
            dot = Part(mark.owner, "cross", mark.points, 0.6 * self.unit)
            self.body(dot)

    def body(self, part: Part) -> None:
        kind, names = self.owner(part)
        if (
            part.role == "hinge"
            and self.skeleton.base in part.links
            and self.joints[names[0]].active
        ):
            middle = part.points.mean(axis=0)  # out of the base, whose bars are thicker than others
            part = replace(part, points=middle + OUT * (part.points - middle))
        link = self.link_of(kind, names, part)
        rotation, origin = self.poses[link]
        mesh = mesh_of(part).placed(rotation.T, -rotation.T @ origin)
        self.bodies.append(Body(kind, names, link, mesh, self.colour(kind, names, part), part.role))

    def rod(self, part: Part) -> None:
        """From the mouth of the barrel, which is on the other link, to its end: it slides as the joint does."""
        kind, names = self.owner(part)
        links = (part.links[1], part.links[0])
        points = tuple(
            self.local(link, point) for link, point in zip(links, part.points, strict=True)
        )
        along = None if part.axis is None else np.asarray(self.poses[links[0]][0].T @ part.axis)
        self.spans.append(
            Span(kind, names, links, (points[0], points[1]), part.radius, STEEL, along)
        )

    def owner(self, part: Part) -> tuple[Kind, tuple[str, ...]]:
        kind, _, name = part.owner.partition(":")
        if kind == "joint":
            return "joint", self.groups.get(name, (name,))
        return ("closure" if kind == "closure" else "link"), (name,)

    def carrier(self, group: JointGroup) -> None:
        """Coordinates of a platform that nothing holds: a thin line from where they are zero."""
        links = (group.first.parent, group.last.child)
        points = (self.local(links[0], group.first.start), self.local(links[1], group.last.point))
        names = tuple(joint.name for joint in group.joints)
        self.spans.append(
            Span("joint", names, links, points, 0.12 * self.unit, mix(QUIET, "#ffffff", 0.4))
        )

    def anchor(self, joint: PlacedJoint, cylinder: CylinderShape | None) -> Anchor:
        """At the mouth of a barrel, on what slides, or at a hinge."""
        link = joint.parent if cylinder is not None or joint.type == "revolute" else joint.child
        point = joint.point if cylinder is None else cylinder.mouth
        return Anchor(link, self.local(link, point), np.asarray(self.poses[link][0].T @ joint.axis))

    def local(self, link: str, point: Array) -> Array:
        rotation, origin = self.poses[link]
        return np.asarray(rotation.T @ (point - origin))

    def link_of(self, kind: Kind, names: tuple[str, ...], part: Part) -> str:
        if kind == "link":
            return names[0]
        if kind == "closure":
            return part.links[0]
        joint = self.joints[names[0]]
        return joint.child if part.role == "block" else joint.parent  # an axis is fixed in either

    def colour(self, kind: Kind, names: tuple[str, ...], part: Part) -> str:
        if kind == "joint":
            driven = any(self.joints[name].active for name in names)
            if part.role == "rail":
                return STEEL
            return RED if driven else mix(INK, "#ffffff", 0.25)
        if kind == "closure":
            return mix(self.colours[f"closure:{names[0]}"], INK, 0.25)
        if names[0] == self.skeleton.base:
            return "#9aa5b1"
        colour = self.colours[names[0]]
        return mix(INK, "#ffffff", 0.28) if colour == INK else mix(colour, "#ffffff", 0.12)


def mesh_of(part: Part) -> Mesh:
    """The mesh of a part in base axes."""
    if part.axis is None:
        return meshes.rounded(part.points, part.radius)
    along = (part.points - part.points[0]) @ part.axis
    start = part.points[int(np.argmin(along))]
    end = part.points[int(np.argmax(along))]
    return meshes.cylinder(part.radius, start, end)
