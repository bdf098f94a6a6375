"""Where everything of a closed mechanism is: joints, closures and frames in base axes, no drawing yet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..closed_state.state import ClosedState
from ..description.model import ClosureKind, Frame, JointType, RobotDescription
from ..errors import InputError
from ..ground.arrays import Array
from ..mechanism.tree import Tree, build_tree
from ..robot.robot import Robot

Pose = tuple[Array, Array]  # rotation (3, 3) to base axes, origin (3,) [m]


@dataclass(frozen=True, eq=False)
class PlacedJoint:
    """A joint in base axes: `start` is where the child's frame stands at zero, `point` where it stands now [m].

    home: its value in the reference configuration [rad or m].
    """

    name: str
    type: JointType
    parent: str
    child: str
    start: Array
    point: Array
    axis: Array  # (3,) unit
    limits: tuple[float, float]
    home: float
    active: bool

    @property
    def here(self) -> float:
        """How far a prismatic joint is out [m]."""
        return float((self.point - self.start) @ self.axis)


@dataclass(frozen=True, eq=False)
class PlacedClosure:
    """A closure: its point on either link [m], and the z axis of its frame."""

    name: str
    kind: ClosureKind
    links: tuple[str, str]
    points: tuple[Array, Array]
    axis: Array
    joints: frozenset[str]  # of the loop it closes

    @property
    def point(self) -> Array:
        """Where it is drawn."""
        return 0.5 * (self.points[0] + self.points[1])


@dataclass(frozen=True, eq=False)
class PlacedFrame:
    """A named frame."""

    name: str
    link: str
    point: Array
    rotation: Array


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A mechanism in one configuration; `arm`: the links from the base to the end effector."""

    base: str
    joints: tuple[PlacedJoint, ...]
    closures: tuple[PlacedClosure, ...]
    frames: tuple[PlacedFrame, ...]  # the end effector's first
    arm: tuple[str, ...]
    links: tuple[str, ...]
    massless: frozenset[str]
    parts: frozenset[str]  # names of frames that are links fixed to others

    def names_on(self, link: str) -> str:
        """The link and what is a part of it."""
        return ", ".join(
            [link, *(f.name for f in self.frames if f.link == link and f.name in self.parts)]
        )

    @property
    def tip(self) -> PlacedFrame:
        """The end-effector frame."""
        return self.frames[0]

    @property
    def points(self) -> Array:
        """(k, 3) all joints, closures and frames [m]."""
        marks = (
            [j.point for j in self.joints]
            + [c.point for c in self.closures]
            + [f.point for f in self.frames]
        )
        return np.array(marks)

    @property
    def in_loops(self) -> frozenset[str]:
        """Joints that are part of a loop."""
        return frozenset().union(*(closure.joints for closure in self.closures))

    def pressed(self, normal: Array) -> Skeleton:
        """The skeleton with every point moved along a unit vector into one plane through the base frame."""

        def press(point: Array) -> Array:
            return np.asarray(point - (point @ normal) * normal)

        joints = (replace(j, start=press(j.start), point=press(j.point)) for j in self.joints)
        closures = (
            replace(c, points=(press(c.points[0]), press(c.points[1]))) for c in self.closures
        )
        frames = (replace(f, point=press(f.point)) for f in self.frames)
        return replace(self, joints=tuple(joints), closures=tuple(closures), frames=tuple(frames))


def place(robot: Robot, state: ClosedState) -> Skeleton:
    """Put a robot into a closed state.

    Raises InputError for a batch, for NaN, and for another robot's state.
    """
    if state.s.shape != (len(robot.coordinates),):
        raise InputError(
            f"a drawing shows one state of {robot.name}; this one has coordinates of shape"
            f" {state.s.shape}"
        )
    if not np.isfinite(state.s).all():
        raise InputError("the state is not closed: it has coordinates that are not finite")
    description = robot.description
    tree = build_tree(description)
    poses = link_poses(
        description, tree, dict(zip(robot.coordinates, state.s.tolist(), strict=True))
    )
    joints = tuple(_joint(robot, poses, body.joint) for body in tree.bodies)
    tip = description.frames.get(description.end_effector, Frame(description.end_effector))
    named = {description.end_effector: tip, **description.frames}
    arm = (description.base, *(tree.bodies[k].name for k in tree.path(tree.body_index(tip.link))))
    return Skeleton(
        base=description.base,
        joints=joints,
        closures=tuple(_closures(description, tree, poses)),
        frames=tuple(_frame(name, frame, poses) for name, frame in named.items()),
        arm=arm,
        links=tuple(dict.fromkeys((description.base, *description.links))),
        massless=frozenset(name for name, link in description.links.items() if link.mass == 0.0),
        parts=frozenset(description.parts),
    )


def link_poses(
    description: RobotDescription, tree: Tree, values: Mapping[str, float]
) -> dict[str, Pose]:
    """Pose of every link in the base frame, from the values of all coordinates [rad or m]."""
    poses: dict[str, Pose] = {description.base: (np.eye(3), np.zeros(3))}
    for body in tree.bodies:
        joint, value = description.joints[body.joint], values[body.joint]
        rotation, origin = poses[joint.parent]
        turned, moved = rotation @ joint.rotation, rotation @ joint.translation + origin
        if joint.type == "revolute":
            poses[joint.child] = (
                turned @ Rotation.from_rotvec(value * joint.axis).as_matrix(),
                moved,
            )
        else:
            poses[joint.child] = (turned, moved + turned @ (value * joint.axis))
    return poses


def _joint(robot: Robot, poses: Mapping[str, Pose], name: str) -> PlacedJoint:
    joint = robot.description.joints[name]
    parent_rotation, parent_origin = poses[joint.parent]
    rotation, point = poses[joint.child]
    return PlacedJoint(
        name=name,
        type=joint.type,
        parent=joint.parent,
        child=joint.child,
        start=parent_rotation @ joint.translation + parent_origin,
        point=point,
        axis=rotation @ joint.axis,
        limits=joint.limits,
        home=float(robot.description.reference.get(name, 0.0)),
        active=name in robot.active,
    )


def _closures(
    description: RobotDescription, tree: Tree, poses: Mapping[str, Pose]
) -> list[PlacedClosure]:
    placed = []
    for c in description.closures:
        (rotation_a, origin_a), (rotation_b, origin_b) = poses[c.link_a], poses[c.link_b]
        points = (rotation_a @ c.point_a + origin_a, rotation_b @ c.point_b + origin_b)
        one, other, _ = tree.branches(tree.body_index(c.link_a), tree.body_index(c.link_b))
        joints = frozenset(tree.bodies[k].joint for k in (*one, *other))
        axis = (rotation_a @ c.rotation_a)[:, 2]
        placed.append(PlacedClosure(c.name, c.kind, (c.link_a, c.link_b), points, axis, joints))
    return placed


def _frame(name: str, frame: Frame, poses: Mapping[str, Pose]) -> PlacedFrame:
    rotation, origin = poses[frame.link]
    return PlacedFrame(
        name, frame.link, rotation @ frame.translation + origin, rotation @ frame.rotation
    )
