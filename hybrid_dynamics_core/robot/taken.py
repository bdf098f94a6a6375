"""Conversion of arguments that may be a robot or a description."""

from __future__ import annotations

from ..description.model import RobotDescription
from ..errors import InputError
from .robot import Robot

AnyRobot = Robot | RobotDescription


def robot_of(robot: object) -> Robot:
    """The robot itself, or the robot of a description.

    Raises:
        InputError: `robot` is neither.
    """
    if isinstance(robot, RobotDescription):
        return Robot(robot)
    if isinstance(robot, Robot):
        return robot
    raise _neither(robot)


def description_of(robot: object) -> RobotDescription:
    """The description itself, or the description of a robot.

    Raises:
        InputError: `robot` is neither.
    """
    if isinstance(robot, RobotDescription):
        return robot
    if isinstance(robot, Robot):
        return robot.description
    raise _neither(robot)


def _neither(robot: object) -> InputError:
    given = type(robot).__name__
    hint = ""
    if isinstance(robot, str):
        hint = f"; load({robot!r}) gives one"
    return InputError(f"the robot is of type {given}; expected a Robot or its description{hint}")
