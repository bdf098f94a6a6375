"""Joints, closures and frames of a closed mechanism in base axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..closed_state.state import ClosedState
from ..description.model import Closure, ClosureKind, Frame, JointType
from ..errors import InputError
from ..ground.arrays import Array
from ..mechanism.configuration import configuration_at
from ..mechanism.joint_transform import joint_transforms, poses_in_base
from ..mechanism.tree import Tree, build_tree
from ..robot.robot import Robot

Pose = tuple[Array, Array]  # rotation (3, 3) to base axes, origin (3,) [m]


@dataclass(frozen=True, eq=False)
class PlacedJoint:
    """A joint in base axes.

    Attributes:
        name: name of the joint.
        type: revolute or prismatic.
        parent: name of the parent link.
        child: name of the child link.
        start: (3,) origin of the child's frame at zero [m].
        point: (3,) origin of the child's frame in this configuration [m].
        axis: unit vector (3,) along its axis.
        limits: lower and upper [rad or m].
        reference: coordinate in the reference configuration [rad or m].
        active: whether it is driven.
        idle: whether it is an independent coordinate without a drive.
    """

    name: str
    type: JointType
    parent: str
    child: str
    start: Array
    point: Array
    axis: Array
    limits: tuple[float, float]
    reference: float
    active: bool
    idle: bool = False

    @property
    def displacement(self) -> float:
        """Displacement of a prismatic joint from its zero [m]."""
        return float((self.point - self.start) @ self.axis)

    def flattened(self, normal: Array) -> PlacedJoint:
        """The joint projected onto a plane with a normal (3,)."""
        start = _in_plane(self.start, normal)
        return replace(self, start=start, point=_in_plane(self.point, normal))


@dataclass(frozen=True, eq=False)
class PlacedClosure:
    """A closure in base axes.

    Attributes:
        name: name of the closure.
        kind: kind of its equations.
        links: names of the links that it joins.
        points: its point (3,) on either link [m].
        axis: (3,) z axis of its frame.
        joints: names of the joints in its loop.
    """

    name: str
    kind: ClosureKind
    links: tuple[str, str]
    points: tuple[Array, Array]
    axis: Array
    joints: frozenset[str]

    @property
    def point(self) -> Array:
        """(3,) place of its symbol [m]."""
        return 0.5 * (self.points[0] + self.points[1])

    def flattened(self, normal: Array) -> PlacedClosure:
        """The closure projected onto a plane with a normal (3,)."""
        first, second = self.points
        return replace(self, points=(_in_plane(first, normal), _in_plane(second, normal)))


@dataclass(frozen=True, eq=False)
class PlacedFrame:
    """A named frame of a link: its origin (3,) [m] and rotation (3, 3), base axes."""

    name: str
    link: str
    point: Array
    rotation: Array

    def flattened(self, normal: Array) -> PlacedFrame:
        """The frame with its origin projected onto a plane with a normal (3,)."""
        return replace(self, point=_in_plane(self.point, normal))


def _in_plane(point: Array, normal: Array) -> Array:
    return np.asarray(point - (point @ normal) * normal)


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A mechanism in one configuration.

    Attributes:
        base: name of the base link.
        joints: joints, parents first.
        closures: closures of the loops.
        frames: named frames, beginning with the end effector.
        arm: the links from the base to the end effector.
        links: names of all links, the base first.
        massless: links without mass.
        in_rows: links inside the chains of joints of several freedoms.
        parts: names of frames that stand for links fixed to others.
    """

    base: str
    joints: tuple[PlacedJoint, ...]
    closures: tuple[PlacedClosure, ...]
    frames: tuple[PlacedFrame, ...]
    arm: tuple[str, ...]
    links: tuple[str, ...]
    massless: frozenset[str]
    parts: frozenset[str]
    in_rows: frozenset[str] = frozenset()

    def names_on(self, link: str) -> str:
        """Names of a link and of the links fixed to it."""
        frames = [frame.name for frame in self.frames if frame.link == link]
        fixed = [name for name in frames if name in self.parts]
        return ", ".join([link, *fixed])

    @property
    def tip(self) -> PlacedFrame:
        """The end-effector frame."""
        return self.frames[0]

    @property
    def hinges(self) -> tuple[PlacedJoint, ...]:
        """The revolute joints."""
        return tuple(joint for joint in self.joints if joint.type == "revolute")

    @property
    def points(self) -> Array:
        """(k, 3) all joints, closures and frames [m]."""
        points = [joint.point for joint in self.joints]
        points += [closure.point for closure in self.closures]
        points += [frame.point for frame in self.frames]
        return np.array(points)

    @property
    def in_loops(self) -> frozenset[str]:
        """Joints that are part of a loop."""
        names: set[str] = set()
        for closure in self.closures:
            names |= closure.joints
        return frozenset(names)

    def flattened(self, normal: Array) -> Skeleton:
        """The skeleton with every point projected onto the plane through the base frame.

        Args:
            normal: (3,) unit normal of the plane.

        Returns:
            The skeleton in one plane.
        """
        return replace(
            self,
            joints=tuple(joint.flattened(normal) for joint in self.joints),
            closures=tuple(closure.flattened(normal) for closure in self.closures),
            frames=tuple(frame.flattened(normal) for frame in self.frames),
        )


def place_skeleton(robot: Robot, state: ClosedState) -> Skeleton:
    """The skeleton of a robot in a closed state.

    Raises:
        InputError: for a batch, for NaN, and for another robot's state.
    """
    _check_state(robot, state)
    description = robot.description
    tree = build_tree(description)
    poses = link_poses(tree, state)
    end_effector = description.end_effector
    tip = description.frames.get(end_effector, Frame(end_effector))
    named = {end_effector: tip, **description.frames}
    joints = [_joint(robot, poses, body.joint) for body in tree.bodies]
    closures = [_closure(closure, tree, poses) for closure in description.closures]
    frames = [_frame(name, frame, poses) for name, frame in named.items()]
    links = dict.fromkeys((description.base, *description.links))
    massless = [name for name, link in description.links.items() if link.mass == 0.0]
    return Skeleton(
        base=description.base,
        joints=tuple(joints),
        closures=tuple(closures),
        frames=tuple(frames),
        arm=_arm(tree, tip.link),
        links=tuple(links),
        massless=frozenset(massless),
        parts=frozenset(description.parts),
        in_rows=description.links_in_rows,
    )


def _check_state(robot: Robot, state: ClosedState) -> None:
    if state.s.shape != (len(robot.coordinates),):
        raise InputError(
            f"a drawing shows one state of {robot.name}; this one has coordinates of shape"
            f" {state.s.shape}"
        )
    if not np.isfinite(state.s).all():
        raise InputError("the state is not closed: it has coordinates that are not finite")


def link_poses(tree: Tree, state: ClosedState) -> dict[str, Pose]:
    """Pose of every link in the base frame.

    Args:
        tree: the spanning tree.
        state: one closed state.

    Returns:
        By link: rotation (3, 3) to base axes and origin (3,) [m].
    """
    charts = state.signs[len(state.signs) - len(tree.charts) :]
    transforms = joint_transforms(tree, configuration_at(tree, state.s, charts))
    poses: dict[str, Pose] = {tree.base: (np.eye(3), np.zeros(3))}
    for body, pose in zip(tree.bodies, poses_in_base(tree, transforms), strict=True):
        rotation, origin = pose
        poses[body.name] = (np.array(rotation), np.array(origin))
    return poses


def _arm(tree: Tree, link: str) -> tuple[str, ...]:
    """Links from the base to a link."""
    path = tree.path(tree.body_index(link))
    names = [tree.bodies[k].name for k in path]
    return (tree.base, *names)


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
        reference=float(robot.description.reference.get(name, 0.0)),
        active=name in robot.description.motors,
        idle=name in robot.idle,
    )


def _closure(closure: Closure, tree: Tree, poses: Mapping[str, Pose]) -> PlacedClosure:
    rotation_a, origin_a = poses[closure.link_a]
    rotation_b, origin_b = poses[closure.link_b]
    body_a = tree.body_index(closure.link_a)
    body_b = tree.body_index(closure.link_b)
    branch_a, branch_b, _ = tree.branches(body_a, body_b)
    joints = [tree.bodies[k].joint for k in (*branch_a, *branch_b)]
    return PlacedClosure(
        name=closure.name,
        kind=closure.kind,
        links=(closure.link_a, closure.link_b),
        points=(
            rotation_a @ closure.point_a + origin_a,
            rotation_b @ closure.point_b + origin_b,
        ),
        axis=(rotation_a @ closure.rotation_a)[:, 2],
        joints=frozenset(joints),
    )


def _frame(name: str, frame: Frame, poses: Mapping[str, Pose]) -> PlacedFrame:
    rotation, origin = poses[frame.link]
    point = rotation @ frame.translation + origin
    return PlacedFrame(name, frame.link, point, rotation @ frame.rotation)
