"""What links are drawn as in other tools: a description has no shapes, only points where something is attached."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..closure.constraints.plane import plane_basis
from ..description.effects import Payload
from ..description.geometry import rotation_with_z_axis
from ..description.model import Closure, Frame, RobotDescription
from ..ground.arrays import Array
from ..mechanism.tree import build_tree
from .extras_reader import payload_body

THICKNESS = 0.01  # radius of a rod over the size of the robot
SMALLEST = 1e-6  # [m] shorter rods are left out


def marks(robot: RobotDescription, link: str) -> Iterator[Array]:
    """Points of a link where something is attached, in its frame [m]."""
    yield from (joint.translation for joint in robot.joints.values() if joint.parent == link)
    for closure in robot.closures:
        yield from (closure.point_a,) if closure.link_a == link else ()
        yield from (closure.point_b,) if closure.link_b == link else ()
    yield from (frame.translation for frame in robot.frames.values() if frame.link == link)


def frames(robot: RobotDescription) -> Iterator[tuple[str, Frame]]:
    """Places on links that are no links, under names that no link has."""
    for name, frame in robot.frames.items():
        own = (
            name in robot.links or name == robot.base
        )  # where the link's data were given, not its joint's frame
        if not own:
            yield name, frame
        elif frame.translation.any() or not np.array_equal(frame.rotation, np.eye(3)):
            yield f"{name}_frame", frame


def payloads(robot: RobotDescription, link: str) -> Iterator[tuple[str, Frame, Payload]]:
    """Name of the body, place and mass of the payloads on a link."""
    for name, (on, payload) in robot.payloads.items():
        frame = robot.frames.get(on, Frame(on))
        if frame.link == link and payload.mass:
            yield payload_body(name), frame, payload


def hinge(robot: RobotDescription, closure: Closure) -> tuple[Array, Array]:
    """Rotations (3, 3) of a closure's frames on its two links with z along the hinge: of a planar loop, its normal."""
    if closure.kind != "planar":
        return closure.rotation_a, closure.rotation_b
    tree = build_tree(robot)
    a, b = tree.body_index(closure.link_a), tree.body_index(closure.link_b)
    path_a, path_b, ancestor = tree.branches(a, b)
    normal = plane_basis(tree, path_a + path_b, ancestor)[2]
    on_a, on_b = (
        rotation_with_z_axis(tree.zero_pose(body, ancestor)[0].T @ normal) for body in (a, b)
    )
    return on_a, on_b


def number(value: float) -> str:
    """Every digit; no minus zero."""
    return repr(float(value) + 0.0)


def numbers(values: Array) -> str:
    """Every digit of several numbers."""
    return " ".join(number(value) for value in values)
