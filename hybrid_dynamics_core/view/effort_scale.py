"""What a full bar, or the longest arrow, stands for."""

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
    """What a drive can give toward the side of an effort.

    Args:
        robot: with the drive.
        name: of the driven joint.
        effort: whose sign is the side [N].

    Returns:
        The force at supply pressure [N]; infinite where the robot's file gives none.
    """
    cylinder = robot.description.actuators.get(name)
    if cylinder is None or not math.isfinite(cylinder.supply_pressure):
        return math.inf
    least, greatest = force_range(cylinder)
    return abs(greatest if effort > 0.0 else least)


class EffortScale:
    """Full bars of the drives of a robot.

    For a cylinder of known supply pressure it is its force at that pressure. All other forces share
    one, and all other torques: a round number above the largest value so far. It never shrinks.

    Args:
        robot: with the drives.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.largest: dict[str, float] = {}  # [N m or N] by type of joint

    def full(self, names: Sequence[str], values: Array) -> Array:
        """What a full bar of each drive is, efforts that are to be shown now included.

        Args:
            names: of the driven joints.
            values: (k,) their efforts [N m or N].

        Returns:
            (k,) [N m or N]; infinite where all efforts were zero so far.
        """
        kinds = [self.robot.joint_types[name] for name in names]
        limits = []
        for name, kind, value in zip(names, kinds, values.tolist(), strict=True):
            limit = limit_of(self.robot, name, value)
            limits.append(limit)
            if math.isinf(limit):
                self._grow(kind, abs(value))
        shared = [self.largest.get(kind, math.inf) for kind in kinds]
        is_limited = np.isfinite(limits)
        return np.where(is_limited, limits, shared)

    def _grow(self, kind: str, size: float) -> None:
        """Have bars of a type of joint hold a value."""
        if size > max(NOTHING, self.largest.get(kind, 0.0)):
            self.largest[kind] = round_above(size)
