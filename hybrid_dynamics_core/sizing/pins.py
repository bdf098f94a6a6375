"""Distance of the two pins between which a cylinder stands."""

from __future__ import annotations

import numpy as np

from ..closed_state.state import ClosedState
from ..description.model import Frame
from ..ground.arrays import Array
from ..robot.robot import Robot


def pin_distance(robot: Robot, joint: str, state: ClosedState) -> Array | None:
    """Distance of the pins at barrel and rod of a prismatic joint.

    Args:
        robot: the robot.
        joint: name of the joint from barrel to rod.
        state: batch of N closed states.

    Returns:
        (N,) [m]; None if the joint turns, if the barrel hangs on no pivot, or if the rod does not
        end at exactly one pin.
    """
    sliding = robot.description.joints[joint]
    carriers = robot.description.joint_to()
    points = _points_of(robot, sliding.child)
    if sliding.type == "revolute" or len(points) != 1:
        return None
    if sliding.parent not in carriers or carriers[sliding.parent].type != "revolute":
        return None
    pivot = robot.forward_kinematics(state, sliding.parent).position
    rod = robot.forward_kinematics(state, sliding.child)
    pin = rod.position + rod.rotation @ points[0]
    apart = pin - pivot
    return np.asarray(np.linalg.norm(apart, axis=-1))


def _points_of(robot: Robot, link: str) -> list[Array]:
    """Where a link is pinned to others beyond it: points (3,) in its frame [m]."""
    frames: list[Frame] = []
    for closure in robot.description.closures:
        frames += closure.frames()
    for joint in robot.description.joints.values():
        frames.append(Frame(joint.parent, joint.rotation, joint.translation))
    return [frame.translation for frame in frames if frame.link == link]
