"""Designs that are asked for again and again, each in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..robot.robot import Robot
from .cycle import Cycle, Duty
from .problem import Bounds, Design
from .program import Functions
from .quantity import Quantity
from .solution import DesignResult

_STARTS = 2
PLACES = 8  # of a coordinate, in the quadrature of a workspace
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


def ranged(ranges: Mapping[str, tuple[float, float]], places: int = PLACES) -> list[Duty]:
    """Points over ranges of coordinates, with the weights of Gauss and Legendre.

    A sum of a function of the coordinates times `weights` is its integral over the ranges.

    Args:
        ranges: lowest and highest value of each coordinate [rad or m].
        places: number of points along each.

    Raises:
        InputError: a range is empty.
    """
    nodes, weights = np.polynomial.legendre.leggauss(places)
    points = [Duty({})]
    for name, (lower, upper) in ranges.items():
        if not lower < upper:
            raise InputError(f"{name}: the range is {lower:g} to {upper:g}; expected two numbers")
        half = 0.5 * (upper - lower)
        along = zip(lower + half * (nodes + 1.0), half * weights, strict=True)
        points = [
            Duty({**point.at, name: float(value)}, weight=point.weight * float(weight))
            for point, (value, weight) in product(points, list(along))
        ]
    return points


def swept_measure(cycle: Cycle, by: Sequence[str], axes: Sequence[str]) -> Quantity:
    """What the tool sweeps over the points of `ranged`: a length [m], area [m^2] or volume [m^3].

    A place that is reached in several configurations counts as often.
    """
    return (cycle.manipulability(by, axes) * cycle.weights).sum()


def widest_workspace(
    robot: Robot,
    variables: Bounds,
    ranges: Mapping[str, tuple[float, float]],
    axes: Sequence[str],
    limits: Functions | None = None,
    starts: int = _STARTS,
) -> Recipe:
    """Make the workspace of the tool largest, over ranges of some coordinates.

    Args:
        robot: the robot.
        variables: (lower, upper) bound of each free number, by name or path.
        ranges: lowest and highest value [rad or m] of the active coordinates that move; as many as
            axes for an area or a volume.
        axes: directions that count, as ("x", "z") for an area.
        limits: functions of the cycle whose entries are zero or above, by name.
        starts: number of starts.

    Returns:
        The design; minus its objective is the measure, see `swept_measure`.

    Raises:
        InputError: as `Design` and `Design.minimise`, or a range is empty.
    """
    design = Design(robot, variables, ranged(ranges))
    by = list(ranges)
    result = design.minimise(lambda cycle: -swept_measure(cycle, by, axes), limits, starts=starts)
    return Recipe(design, result)
