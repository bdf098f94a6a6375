"""What is left of strokes and angles that end. Knows no ROS."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.units import coordinate_unit

from ..messages.joint_samples import FloatArray


class Strokes:
    """Joints whose motion ends somewhere, and what is left to both ends."""

    def __init__(self, robot: Robot) -> None:
        self.lower, self.upper = joint_limits(robot)
        self._places = np.flatnonzero(np.isfinite(self.lower) | np.isfinite(self.upper))
        self.joints = tuple(robot.coordinates[k] for k in self._places)
        self.units = tuple(coordinate_unit(robot.joint_types[name]) for name in self.joints)
        self._ends = self.lower[self._places], self.upper[self._places]
        self._rows = tuple(
            zip(self._places.tolist(), *(ends.tolist() for ends in self._ends), strict=True)
        )

    def within(self, s: FloatArray) -> bool:
        """Whether all of ``joints`` of s (n_s,) are within their limits; in plain floats, as every input is asked."""
        told = s.tolist()
        return all(low <= told[k] <= high for k, low, high in self._rows)

    def margins(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """To the lower and the upper end of each of ``joints`` [rad or m], (k,) or (N, k), negative beyond it."""
        here = s[..., self._places]
        return here - self._ends[0], self._ends[1] - here


def joint_limits(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Lower and upper limits of all coordinates (n_s,) [rad or m]; of active ones within what closes."""
    told = np.array(
        [robot.description.joints[name].limits for name in robot.coordinates], dtype=np.float64
    )
    told[: len(robot.active)] = robot.limits
    return told[:, 0], told[:, 1]
