"""Bodies of a robot for the scene: solids that move with links, and rods between two links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from ..mechanism.tree import Tree, build_tree
from ..robot.robot import Robot
from ..scene.attach import Attached, CylinderShape, attach, cylinders_of, rail
from ..scene.groups import JointGroup, group_joints
from ..scene.marks import base_marks, joints_on_rails, link_colours, solid_marks
from ..scene.part_style import IDLE
from ..scene.parts import Part
from ..scene.projection import choose_projection
from ..scene.skeleton import PlacedJoint, Pose, Skeleton, link_poses, place_skeleton
from ..scene.style import INK, QUIET, RED, mix
from ..scene.symbols import Mark
from . import meshes
from .meshes import Mesh

UNIT: Final = 0.0135  # radius of a joint, as a share of the robot's size
SMALLEST: Final = 0.1  # [m] least size of a robot
STEEL: Final = "#c3ccd5"
BASE: Final = "#9aa5b1"
WHITE: Final = "#ffffff"
OUT: Final = 1.75  # factor of the length of a driven hinge on the base
Kind = Literal["link", "joint", "closure"]
Names = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class SolidBody:
    """A solid body that moves with a link.

    Attributes:
        kind: kind of its owner: link, joint or closure.
        names: names of the link, joints or closure that it shows.
        link: the link that it moves with.
        mesh: mesh in link axes.
        colour: #rrggbb.
        role: its role.
    """

    kind: Kind
    names: Names
    link: str
    mesh: Mesh
    colour: str
    role: str


@dataclass(frozen=True, eq=False)
class Span:
    """A rod from a point on one link to a point on another.

    Attributes:
        kind: kind of its owner: link, joint or closure.
        names: names of the link or joints that it shows.
        links: the two links.
        points: (3,) each, in the axes of their link [m].
        radius: [m].
        colour: #rrggbb.
        along: (3,) its direction in the axes of the first link, if constant.
    """

    kind: Kind
    names: Names
    links: tuple[str, str]
    points: tuple[Array, Array]
    radius: float
    colour: str
    along: Array | None = None


@dataclass(frozen=True, eq=False)
class Anchor:
    """The place of a joint's name and effort.

    Attributes:
        link: the link of its axes.
        point: (3,) [m].
        axis: (3,) of the joint.
    """

    link: str
    point: Array
    axis: Array


@dataclass(frozen=True, eq=False)
class RobotShape:
    """The geometry of a robot in the scene.

    Attributes:
        robot: the robot.
        reference: the state in which the bodies were made.
        tree: the spanning tree.
        skeleton: the skeleton in that state.
        bodies: bodies that move with links.
        spans: rods between links.
        anchors: anchors by joint.
        unit: radius of a joint [m].
        size: size of the robot [m].
        points: (k, 3) points for the camera to show [m].
    """

    robot: Robot
    reference: ClosedState
    tree: Tree
    skeleton: Skeleton
    bodies: tuple[SolidBody, ...]
    spans: tuple[Span, ...]
    anchors: Mapping[str, Anchor]
    unit: float
    size: float
    points: Array

    def poses(self, state: ClosedState) -> dict[str, Pose]:
        """Pose of every link in a closed state."""
        return link_poses(self.tree, state)


def robot_shape(robot: Robot, state: ClosedState) -> RobotShape:
    """Make the bodies of a robot, with lengths from one closed state."""
    skeleton = place_skeleton(robot, state)
    tree = build_tree(robot.description)
    groups = group_joints(skeleton)
    attached = {}
    for link, carried in attach(skeleton, groups).items():
        attached[link] = _within_limits(robot, state, carried)
    cylinders = cylinders_of(attached)
    rails = [rail(joint) for joint in joints_on_rails(groups, cylinders)]
    points = np.vstack([skeleton.points, *rails])
    diagonal = np.ptp(points, axis=0)
    size = max(float(np.linalg.norm(diagonal)), SMALLEST)
    unit = UNIT * size
    projection = choose_projection(skeleton)
    marks = solid_marks(skeleton, groups, attached, projection, unit)
    marks += base_marks(skeleton, groups, attached[skeleton.base], unit)
    builder = _ShapeBuilder(robot, skeleton, groups, unit, link_poses(tree, state))
    builder.add_marks(marks)
    builder.add_carriers(groups)
    anchors = {}
    for joint in skeleton.joints:
        cylinder = cylinders.get(joint.name)
        anchors[joint.name] = builder.anchor(joint, cylinder)
    return RobotShape(
        robot=robot,
        reference=state,
        tree=tree,
        skeleton=skeleton,
        bodies=tuple(builder.bodies),
        spans=tuple(builder.spans),
        anchors=anchors,
        unit=unit,
        size=size,
        points=points,
    )


def span_pose(span: Span, poses: Mapping[str, Pose]) -> tuple[Array, Array, float]:
    """The pose of a rod.

    Args:
        span: the rod.
        poses: poses of the links.

    Returns:
        Rotation (3, 3) with z along the rod, its start (3,) [m] and its length [m].
    """
    first, second = (poses[link] for link in span.links)
    start = _moved(span.points[0], first)
    end = _moved(span.points[1], second)
    if span.along is not None:
        rotation, _ = first
        along = rotation @ span.along
        length = float((end - start) @ along)
        return meshes.frame_along(along), start, max(length, 0.0)
    length = float(np.linalg.norm(end - start))
    if not length > 0.0:
        return np.eye(3), start, length
    return meshes.frame_along(end - start), start, length


def _moved(point: Array, pose: Pose) -> Array:
    """A point of a link in base axes."""
    rotation, origin = pose
    return rotation @ point + origin


def _within_limits(robot: Robot, state: ClosedState, carried: Attached) -> Attached:
    """The cylinders with barrels short enough for their strokes."""
    barrels = [_limited(robot, state, cylinder) for cylinder in carried.barrels]
    rods = [_limited(robot, state, cylinder) for cylinder in carried.rods]
    return replace(carried, barrels=barrels, rods=rods)


def _limited(robot: Robot, state: ClosedState, cylinder: CylinderShape) -> CylinderShape:
    """A cylinder with its least length within the limits of its joint."""
    joint = cylinder.joint
    lower, upper = joint.limits
    if joint.name in robot.active:
        index = robot.active.index(joint.name)
        lower, upper = robot.limits[index].tolist()
    outward = float(cylinder.direction @ joint.axis) > 0.0
    innermost = lower if outward else upper
    coordinate = robot.coordinates.index(joint.name)
    value = float(state.s[coordinate])
    shortest = cylinder.length - abs(value - innermost)
    if not shortest > 0.0:
        return cylinder
    return replace(cylinder, shortest=shortest)


class _ShapeBuilder:
    """Converts marks in base axes to bodies in link axes."""

    def __init__(
        self,
        robot: Robot,
        skeleton: Skeleton,
        groups: Sequence[JointGroup],
        unit: float,
        poses: Mapping[str, Pose],
    ) -> None:
        self.skeleton = skeleton
        self.unit = unit
        self.poses = poses
        self.groups = {group.names: _joint_names(group) for group in groups}
        self.joints = {joint.name: joint for joint in skeleton.joints}
        self.colours = link_colours(skeleton, robot.description.loops)
        self.bodies: list[SolidBody] = []
        self.spans: list[Span] = []

    def add_marks(self, marks: Sequence[Mark]) -> None:
        """Add bodies for parts, rods, and small balls for dots; lines are not shown."""
        radius = 0.6 * self.unit
        for mark in marks:
            if not isinstance(mark, Part):
                if mark.role == "dot":
                    dot = Part(mark.owner, "cross", mark.points, radius)
                    self._add_body(dot)
            elif mark.role == "rod":
                self._add_rod(mark)
            else:
                self._add_body(mark)

    def add_carriers(self, groups: Sequence[JointGroup]) -> None:
        """Add thin lines, from zero, for coordinates of a platform without bodies."""
        for group in groups:
            if group.kind != "carrier":
                continue
            first, last = group.first, group.last
            span = Span(
                kind="joint",
                names=_joint_names(group),
                links=(first.parent, last.child),
                points=(
                    self._local(first.parent, first.start),
                    self._local(last.child, last.point),
                ),
                radius=0.12 * self.unit,
                colour=mix(QUIET, WHITE, 0.4),
            )
            self.spans.append(span)

    def _add_body(self, part: Part) -> None:
        kind, names = self._owner(part)
        if part.role == "hinge" and self._is_drive_on_base(part, names):
            middle = part.points.mean(axis=0)  # to be visible outside of the base
            longer = middle + OUT * (part.points - middle)
            part = replace(part, points=longer)
        link = self._link_of(kind, names, part)
        rotation, origin = self.poses[link]
        mesh = mesh_of(part).placed(rotation.T, -rotation.T @ origin)
        colour = self._colour(kind, names, part)
        body = SolidBody(kind, names, link, mesh, colour, part.role)
        self.bodies.append(body)

    def _is_drive_on_base(self, part: Part, names: Names) -> bool:
        on_base = self.skeleton.base in part.links
        return on_base and self.joints[names[0]].active

    def _add_rod(self, part: Part) -> None:
        """Add a rod from its end to the mouth of its barrel, which is on the other link.

        Its length changes with the joint.
        """
        kind, names = self._owner(part)
        end_link, mouth_link = part.links
        mouth = self._local(mouth_link, part.points[0])
        end = self._local(end_link, part.points[1])
        along = None
        if part.axis is not None:
            rotation, _ = self.poses[mouth_link]
            along = np.asarray(rotation.T @ part.axis)
        span = Span(
            kind=kind,
            names=names,
            links=(mouth_link, end_link),
            points=(mouth, end),
            radius=part.radius,
            colour=STEEL,
            along=along,
        )
        self.spans.append(span)

    def _owner(self, part: Part) -> tuple[Kind, Names]:
        """Kind and names of the owner of a part."""
        kind, _, name = part.owner.partition(":")
        if kind == "joint":
            return "joint", self.groups.get(name, (name,))
        if kind == "closure":
            return "closure", (name,)
        return "link", (name,)

    def anchor(self, joint: PlacedJoint, cylinder: CylinderShape | None) -> Anchor:
        """The anchor of a joint: at the mouth of a barrel, on a slide, or at a hinge."""
        link, point = joint.parent, joint.point
        if cylinder is not None:
            point = cylinder.mouth
        elif joint.type == "prismatic":
            link = joint.child
        rotation, _ = self.poses[link]
        axis = np.asarray(rotation.T @ joint.axis)
        return Anchor(link, self._local(link, point), axis)

    def _local(self, link: str, point: Array) -> Array:
        """A point (3,) in base axes, converted to link axes."""
        rotation, origin = self.poses[link]
        return np.asarray(rotation.T @ (point - origin))

    def _link_of(self, kind: Kind, names: Names, part: Part) -> str:
        """The link that a part moves with."""
        if kind == "link":
            return names[0]
        if kind == "closure":
            return part.links[0]
        joint = self.joints[names[0]]
        return joint.child if part.role == "block" else joint.parent

    def _colour(self, kind: Kind, names: Names, part: Part) -> str:
        if kind == "joint":
            return self._joint_colour(names, part)
        if kind == "closure":
            return mix(self.colours[f"closure:{names[0]}"], INK, 0.25)
        if names[0] == self.skeleton.base:
            return BASE
        colour = self.colours[names[0]]
        return mix(colour, WHITE, 0.28 if colour == INK else 0.12)

    def _joint_colour(self, names: Names, part: Part) -> str:
        if part.role == "rail":
            return STEEL
        if any(self.joints[name].active for name in names):
            return RED
        if any(self.joints[name].idle for name in names):
            return IDLE
        return mix(INK, WHITE, 0.25)


def _joint_names(group: JointGroup) -> Names:
    return tuple(joint.name for joint in group.joints)


def mesh_of(part: Part) -> Mesh:
    """The mesh of a part in base axes."""
    if part.axis is None:
        return meshes.rounded(part.points, part.radius)
    along = (part.points - part.points[0]) @ part.axis
    start = part.points[int(np.argmin(along))]
    end = part.points[int(np.argmax(along))]
    return meshes.cylinder(part.radius, start, end)
