"""Margins to the ends of strokes and of limited angles. It does not depend on ROS."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.units import coordinate_unit

from ..messages.joint_samples import FloatArray


class StrokeMargins:
    """Joints with limits, and their margins to both limits.

    Attributes:
        lower, upper: limits of all coordinates (n_s,) [rad or m].
        joints: names of the k joints with a finite limit.
        units: units of their coordinates.
    """

    def __init__(self, robot: Robot) -> None:
        self.lower, self.upper = joint_limits(robot)
        has_end = np.isfinite(self.lower) | np.isfinite(self.upper)
        self._places = np.flatnonzero(has_end)
        self.joints = tuple(robot.coordinates[k] for k in self._places)
        self.units = tuple(coordinate_unit(robot.joint_types[name]) for name in self.joints)
        self._lower = self.lower[self._places]
        self._upper = self.upper[self._places]
        ends = (self._places.tolist(), self._lower.tolist(), self._upper.tolist())
        self._rows = tuple(zip(*ends, strict=True))

    def within(self, s: FloatArray) -> bool:
        """Whether all of `joints` are within their limits.

        Args:
            s: all coordinates of one state (n_s,) [rad or m].
        """
        values = s.tolist()  # plain floats are faster, and every input needs it
        return all(low <= values[k] <= high for k, low, high in self._rows)

    def margins(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Margins to the lower and the upper limit of `joints`, negative beyond.

        Args:
            s: all coordinates, (n_s,) or (N, n_s) [rad or m].

        Returns:
            Two arrays (k,) or (N, k) [rad or m].
        """
        values = s[..., self._places]
        return values - self._lower, self._upper - values


def joint_limits(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Lower and upper limits of all coordinates (n_s,) [rad or m].

    Limits of active coordinates are narrowed to the range in which the loops close.
    """
    joints = robot.description.joints
    limits = np.array([joints[name].limits for name in robot.coordinates], dtype=np.float64)
    limits[: len(robot.active)] = robot.limits
    return limits[:, 0], limits[:, 1]
