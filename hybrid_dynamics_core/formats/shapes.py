"""Shapes of links in other tools: rods from the link origin to its attachment points.

A description itself has no shapes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from ..closure.constraints.plane import plane_basis
from ..description.geometry import Transform, rotation_with_z_axis
from ..description.model import Closure, Frame, Link, RobotDescription
from ..ground.arrays import Array
from ..mechanism.tree import build_tree
from .extras_reader import payload_body

ROD_RADIUS = 0.01  # over the size of the robot
SHORTEST_ROD = 1e-6  # [m] shorter rods are omitted


def all_links(robot: RobotDescription) -> dict[str, Link]:
    """All links by name, the base first, which has no mass unless the robot gives one."""
    return {robot.base: Link(robot.base), **robot.links}


def attachment_points(robot: RobotDescription, link: str) -> Iterator[Array]:
    """Points (3,) [m] of a link at which joints, closures or frames are attached, link frame."""
    for joint in robot.joints.values():
        if joint.parent == link:
            yield joint.translation
    for closure in robot.closures:
        if closure.link_a == link:
            yield closure.point_a
        if closure.link_b == link:
            yield closure.point_b
    for frame in robot.frames.values():
        if frame.link == link:
            yield frame.translation


def robot_size(robot: RobotDescription) -> float:
    """The largest distance of an attachment point from the origin of its link [m]."""
    distances: list[float] = []
    for link in all_links(robot):
        distances.extend(map(norm, attachment_points(robot, link)))
    return max(distances, default=1.0)


def rods(points: Iterable[Array]) -> list[Array]:
    """The points to which a rod from the origin is drawn."""
    return [point for point in points if norm(point) > SHORTEST_ROD]


def norm(vector: Array) -> float:
    """The length of a vector."""
    return float(np.linalg.norm(vector))


def extra_frames(robot: RobotDescription) -> Iterator[tuple[str, Frame]]:
    """Frames that are no link frames, under names that no link has.

    A frame with the name of its link is the frame in which the link's data were given. It is
    included if it differs from the frame at the joint.
    """
    for name, frame in robot.frames.items():
        if name not in robot.links and name != robot.base:
            yield name, frame
        elif not _is_identity(frame):
            yield f"{name}_frame", frame


def _is_identity(frame: Frame) -> bool:
    return Transform(frame.rotation, frame.translation).is_identity()


def payload_bodies(robot: RobotDescription, link: str) -> Iterator[tuple[Link, Frame]]:
    """The payloads on a link that have a mass, as links, and their frames."""
    for name, (place, payload) in robot.payloads.items():
        frame = robot.frames.get(place, Frame(place))
        if frame.link == link and payload.mass:
            com = np.asarray(payload.com)
            inertia = np.asarray(payload.inertia)
            yield Link(payload_body(name), payload.mass, com, inertia), frame


def hinge_frames(robot: RobotDescription, closure: Closure) -> tuple[Frame, Frame]:
    """A closure's frames on its two links, with z along the hinge.

    The hinge of a planar loop is normal to its plane.
    """
    if closure.kind != "planar":
        return closure.frames()
    tree = build_tree(robot)
    a = tree.body_index(closure.link_a)
    b = tree.body_index(closure.link_b)
    path_a, path_b, ancestor = tree.branches(a, b)
    _, _, normal = plane_basis(tree, path_a + path_b, ancestor)
    rotation_a, _ = tree.zero_pose(a, ancestor)
    rotation_b, _ = tree.zero_pose(b, ancestor)
    hinge_a = rotation_with_z_axis(rotation_a.T @ normal)
    hinge_b = rotation_with_z_axis(rotation_b.T @ normal)
    return replace(closure, rotation_a=hinge_a, rotation_b=hinge_b).frames()
