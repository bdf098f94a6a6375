"""What of a motion is compared, for this library and for every other engine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Observed:
    """Columns that are compared.

    Attributes:
        names: of coordinates; empty for the end effector's point.
        axes: of the world, of that point.
        at_end: only the last sample's values, without rates.
    """

    names: tuple[str, ...] = ()
    axes: tuple[int, ...] = (0, 1)
    at_end: bool = False

    def of_states(self, robot: Robot, states: ClosedState) -> Array:
        """(N, k) values, then rates, of a motion of this library."""
        if self.names:
            return self.of_coordinates(robot.coordinates, states.s, states.ds)
        axes = list(self.axes)
        place = robot.forward_kinematics(states).position
        rate = robot.jacobian(states) @ states.du[:, :, None]
        return np.hstack([place[:, axes], rate[:, axes, 0]])

    def of_coordinates(self, order: tuple[str, ...], s: Array, ds: Array) -> Array:
        """(N, k) values, then rates, of the named coordinates.

        Args:
            order: names of the columns of s.
            s: (N, m) coordinates.
            ds: (N, m) their rates.
        """
        columns = [order.index(name) for name in self.names]
        if self.at_end:
            return np.asarray(s[-1:, columns])
        return np.hstack([s[:, columns], ds[:, columns]])
