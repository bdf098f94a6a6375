"""What a full bar, or the longest arrow, stands for: what a drive can give, or a round number above all seen so far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from ..dynamics.hydraulics import force_range
from ..ground.arrays import Array
from ..robot.robot import Robot
from .ranges import round_above

NOTHING: Final = 1e-9  # [N m or N] efforts below this are rounding


def limit_of(robot: Robot, name: str, effort: float) -> float:
    """What a drive can give toward the side of an effort [N]; infinite where the robot's file does not say."""
    cylinder = robot.description.actuators.get(name)
    if cylinder is None or not math.isfinite(cylinder.supply_pressure):
        return math.inf
    return abs(force_range(cylinder)[effort > 0.0])


class EffortScale:
    """Full bars of the drives of a robot. Those of its cylinders whose supply pressure is known are their force at it.

    The others share one for all forces, one for all torques: a round number above the largest so
    far, which only grows.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.largest: dict[str, float] = {}  # [N m or N] by type of joint

    def full(self, names: Sequence[str], values: Array) -> Array:
        """What a full bar of each drive is (k,) [N m or N], efforts (k,) that are to be shown now included."""
        kinds = [self.robot.joint_types[name] for name in names]
        told = [
            limit_of(self.robot, name, value)
            for name, value in zip(names, values.tolist(), strict=True)
        ]
        for kind, value, limit in zip(kinds, np.abs(values).tolist(), told, strict=True):
            if math.isinf(limit) and value > max(NOTHING, self.largest.get(kind, 0.0)):
                self.largest[kind] = round_above(value)
        seen = [self.largest.get(kind, math.inf) for kind in kinds]
        return np.where(np.isfinite(told), told, seen)
