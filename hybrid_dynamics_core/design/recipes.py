"""Designs that are asked for again and again, each in one call."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..robot.robot import Robot
from .cycle import Cycle, Duty
from .problem import Bounds, Design
from .program import Functions
from .quantity import Quantity
from .solution import DesignResult

_STARTS = 2
LEAST_DISTANCE = 0.1  # to singular places, of a scale from 0 to 1


class Recipe(NamedTuple):
    """A design and its result.

    Attributes:
        design: the problem; `design.cycle(...)` has what the robot does.
        result: its solution.
    """

    design: Design
    result: DesignResult


def unevenness(cycle: Cycle, drive: str) -> Quantity:
    """Deviation of the force of a drive from its mean over the cycle, as a share of the mean."""
    force = cycle.effort(drive)
    apart = force - force.mean()
    return (apart * apart).mean().sqrt() / abs(force.mean())


def level_force(
    robot: Robot,
    cylinder: str,
    pins: Bounds,
    swing: Sequence[Duty],
    given: Sequence[str] | None = None,
    limits: Functions | None = None,
) -> Recipe:
    """Place the pins of a cylinder so that its force is level over a swing.

    Loops stay away from singular places, and the stroke within the limits of the joint where the
    description has some.

    Args:
        robot: the robot.
        cylinder: joint of the cylinder.
        pins: (lower, upper) bound [m] of each free number, by name or path.
        swing: points of the swing, usually by the angle of the link that the cylinder drives.
        given: coordinates that the points name; the active ones if None.
        limits: further functions of the cycle whose entries are zero or above, by name.

    Raises:
        InputError: as `Design` and `Design.minimise`.
    """
    design = Design(robot, pins, swing, given)
    constraints = {"regular": lambda cycle: cycle.distance() - LEAST_DISTANCE, **(limits or {})}
    if design.has_limits(cylinder):
        constraints["stroke"] = lambda cycle: cycle.margin(cylinder)
    result = design.minimise(lambda cycle: unevenness(cycle, cylinder), constraints, starts=_STARTS)
    return Recipe(design, result)


def keep_regular(
    robot: Robot,
    variables: Bounds,
    workspace: Sequence[Duty],
    given: Sequence[str] | None = None,
    limits: Functions | None = None,
    starts: int = 1,
) -> Recipe:
    """Keep singular places away from a workspace: its least distance to one is made largest.

    Args:
        robot: the robot.
        variables: (lower, upper) bound of each free number, by name or path.
        workspace: places of the workspace.
        given: coordinates that the places name, such as those of a platform; the active ones if
            None.
        limits: functions of the cycle whose entries are zero or above, by name.
        starts: number of starts.

    Raises:
        InputError: as `Design` and `Design.minimise`.
    """
    design = Design(robot, variables, workspace, given)
    result = design.minimise_largest(lambda cycle: -cycle.distance(), limits, starts=starts)
    return Recipe(design, result)
