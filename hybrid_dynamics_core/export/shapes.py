"""What links are drawn as in other tools: a description has no shapes, only points where something is attached."""

from __future__ import annotations

from collections.abc import Iterator

from ..description.model import Array, RobotDescription

THICKNESS = 0.01  # radius of a rod over the size of the robot
SMALLEST = 1e-6  # [m] shorter rods are left out


def marks(robot: RobotDescription, link: str) -> Iterator[Array]:
    """Points of a link where something is attached, in its frame [m]."""
    yield from (joint.translation for joint in robot.joints.values() if joint.parent == link)
    for closure in robot.closures:
        yield from (closure.point_a,) if closure.link_a == link else ()
        yield from (closure.point_b,) if closure.link_b == link else ()
    yield from (frame.translation for frame in robot.frames.values() if frame.link == link)


def number(value: float) -> str:
    """Every digit; no minus zero."""
    return repr(float(value) + 0.0)


def numbers(values: Array) -> str:
    """Every digit of several numbers."""
    return " ".join(number(value) for value in values)
