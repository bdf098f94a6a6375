"""How the pose of a frame changes with what varies, the loops staying closed.

Each column is moved both ways. The passive coordinates follow by the implicit function of the
closure, and each derivative is a central difference.
"""

from __future__ import annotations

import numpy as np

from ..calibration.closed_rows import ClosedRows, applied, inverse_of, others
from ..calibration.quantities import rotation_vectors
from ..errors import InputError
from ..ground.arrays import Array
from .varied import Variable, VariedRobot

STEP = 1e-5  # of the robot's reach, or rad: change of a column in a derivative
UNFIT = 1e-4  # gap per change [lengths of the loop per reach] that nothing can close
TINY = 1e-300
_UP_AND_DOWN = (1.0, -1.0)


def sensitivities(varied: VariedRobot, rows: ClosedRows, frame: str) -> Array:
    """Derivatives (N, 6, m) of the pose of a frame by each column, in base axes.

    Three rows of its origin [m per m or rad], then three of its rotation vector [rad per m or rad].

    Args:
        varied: the robot.
        rows: N closed states.
        frame: name of the frame.

    Raises:
        InputError: a variable opens a loop that has more equations than unknowns.
    """
    motion = _Motion(varied, rows, frame)
    result = np.zeros((len(rows.s), 6, varied.count))
    for variable in varied.variables:
        for column in range(variable.columns.start, variable.columns.stop):
            result[:, :, column] = motion.derivative(variable, column)
    return result


class _Motion:
    """Closed states that follow a change to first order."""

    def __init__(self, varied: VariedRobot, rows: ClosedRows, frame: str) -> None:
        self.varied = varied
        self.rows = rows
        self.frame = frame
        self.unknowns = others(varied.given, rows.s)
        _, jacobian = rows.geometry.linearised(rows.s, rows.charts)
        self.jacobian = jacobian[:, :, self.unknowns]
        self.inverse = inverse_of(self.jacobian)
        self.reach = max(rows.poses().extent(), TINY)

    def derivative(self, variable: Variable, column: int) -> Array:
        """The derivatives (N, 6) by one column."""
        step = STEP
        if variable.unit != "rad":
            step *= self.reach
        (above, below) = (self._pose(variable, column, way * step) for way in _UP_AND_DOWN)
        moved = (above[1] - below[1]) / (2.0 * step)
        turned = rotation_vectors(above[0] @ np.swapaxes(below[0], 1, 2)) / (2.0 * step)
        return np.concatenate([moved, turned], axis=1)

    def _pose(self, variable: Variable, column: int, change: float) -> tuple[Array, Array]:
        """Rotation (N, 3, 3) and origin (N, 3) of the frame with one column changed."""
        changes = np.zeros(self.varied.count)
        changes[column] = change
        geometry = self.varied.at(changes)
        s = self.rows.s.copy()
        gaps, _ = geometry.linearised(s, self.rows.charts)
        follow = applied(self.inverse, gaps)
        remaining = np.abs(gaps - applied(self.jacobian, follow))
        if remaining.max(initial=0.0) > UNFIT * STEP:
            raise InputError(
                f"tolerances: {variable.name} opens a loop: the loop has more equations than"
                " unknowns, and closes for one value only; leave it out"
            )
        s[:, self.unknowns] -= follow
        return ClosedRows(geometry, s, self.rows.charts).poses().frame(self.frame)
