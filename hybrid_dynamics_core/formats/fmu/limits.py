"""Limits that end a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...ground.units import coordinate_unit
from ...robot.robot import Robot


@dataclass(frozen=True)
class Limit:
    """A finite limit of a coordinate.

    Attributes:
        index: of the coordinate.
        value: [rad or m].
        is_upper: whether the coordinate stays below it.
        text: what is said when it is reached.
    """

    index: int
    value: float
    is_upper: bool
    text: str


def limits_of(robot: Robot) -> list[Limit]:
    """Finite limits of all joints, narrowed by the strokes of their cylinders."""
    limits = []
    for index, name in enumerate(robot.coordinates):
        lower, upper = robot.description.joints[name].limits
        if name in robot.cylinders:
            stroke = robot.cylinders[name].stroke
            lower = max(lower, stroke[0])
            upper = min(upper, stroke[1])
        unit = coordinate_unit(robot.joint_types[name])
        for side, value in (("lower", lower), ("upper", upper)):
            if np.isfinite(value):
                text = f"{name} reached its {side} limit {value:.6g} {unit}"
                limits.append(Limit(index, float(value), side == "upper", text))
    return limits
