"""What stands for a robot's shapes in other tools: rods to the points where something is attached.

A description has no shapes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ..closure.constraints.plane import plane_basis
from ..description.effects import Payload
from ..description.geometry import rotation_with_z_axis
from ..description.model import Closure, Frame, Link, RobotDescription
from ..ground.arrays import Array
from ..mechanism.tree import build_tree
from .extras_reader import payload_body

ROD_RADIUS = 0.01  # over the size of the robot
SHORTEST_ROD = 1e-6  # [m] shorter ones are omitted


def all_links(robot: RobotDescription) -> dict[str, Link]:
    """The links by name, the base first: it has no mass unless the robot gives one."""
    return {robot.base: Link(robot.base), **robot.links}


def attachment_points(robot: RobotDescription, link: str) -> Iterator[Array]:
    """Points of a link where something is attached, (3,) in its frame [m]."""
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

    A frame with the name of its link is where the link's data were given. It counts where it is
    not the frame at the joint.
    """
    for name, frame in robot.frames.items():
        if name not in robot.links and name != robot.base:
            yield name, frame
        elif frame.translation.any() or not np.array_equal(frame.rotation, np.eye(3)):
            yield f"{name}_frame", frame


def payload_bodies(robot: RobotDescription, link: str) -> Iterator[tuple[str, Frame, Payload]]:
    """Name of the body, frame and mass of the payloads on a link."""
    for name, (place, payload) in robot.payloads.items():
        frame = robot.frames.get(place, Frame(place))
        if frame.link == link and payload.mass:
            yield payload_body(name), frame, payload


def hinge_rotations(robot: RobotDescription, closure: Closure) -> tuple[Array, Array]:
    """Rotations (3, 3) of a closure's frames on its two links, with z along the hinge.

    The hinge of a planar loop is normal to its plane.
    """
    if closure.kind != "planar":
        return closure.rotation_a, closure.rotation_b
    tree = build_tree(robot)
    a = tree.body_index(closure.link_a)
    b = tree.body_index(closure.link_b)
    path_a, path_b, ancestor = tree.branches(a, b)
    _, _, normal = plane_basis(tree, path_a + path_b, ancestor)
    rotation_a, _ = tree.zero_pose(a, ancestor)
    rotation_b, _ = tree.zero_pose(b, ancestor)
    return (
        rotation_with_z_axis(rotation_a.T @ normal),
        rotation_with_z_axis(rotation_b.T @ normal),
    )
