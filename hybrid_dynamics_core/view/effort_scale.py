"""The effort of a full bar, or of the longest arrow."""

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
    """The largest force of a cylinder in the direction of an effort.

    Args:
        robot: the robot.
        name: name of the driven joint.
        effort: effort whose sign is the direction [N].

    Returns:
        The force at supply pressure [N]; infinite if the description gives none.
    """
    cylinder = robot.description.actuators.get(name)
    if cylinder is None or not math.isfinite(cylinder.supply_pressure):
        return math.inf
    least, greatest = force_range(cylinder)
    return abs(greatest if effort > 0.0 else least)


class EffortScale:
    """The efforts of full bars for the drives of a robot.

    For a cylinder with a known supply pressure it is the force at that pressure. All other forces
    share a value, and so do all torques: a round number above the largest value so far, which never
    decreases.

    Args:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.largest: dict[str, float] = {}  # [N m or N] largest so far, by type of joint

    def full(self, names: Sequence[str], values: Array) -> Array:
        """The effort of a full bar for each drive, after including new efforts.

        Args:
            names: names of the driven joints.
            values: (k,) new efforts [N m or N].

        Returns:
            (k,) [N m or N]; infinite if all efforts were zero so far.
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
        """Increase the full bar of a type of joint if needed."""
        if size > max(NOTHING, self.largest.get(kind, 0.0)):
            self.largest[kind] = round_above(size)
