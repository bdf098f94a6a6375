"""How the pose of a frame changes with what varies, the loops staying closed.

Each column is moved in both directions. The passive coordinates follow by the implicit function of
the closure, and each derivative is a central difference.
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
        for column in variable.indices:
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
        self.reach = rows.poses().extent()

    def derivative(self, variable: Variable, column: int) -> Array:
        """The derivatives (N, 6) by one column."""
        step = STEP
        if variable.unit != "rad":
            step *= self.reach
        rotation, origin = self._pose(variable, column, step)
        before, start = self._pose(variable, column, -step)
        back = np.swapaxes(before, 1, 2)
        turned = rotation_vectors(rotation @ back)
        moved = origin - start
        both = np.concatenate([moved, turned], axis=1)
        slopes: Array = both / (2.0 * step)
        return slopes

    def _pose(self, variable: Variable, column: int, change: float) -> tuple[Array, Array]:
        """Rotation (N, 3, 3) and origin (N, 3) of the frame with one column changed."""
        changes = np.zeros(self.varied.count)
        changes[column] = change
        geometry = self.varied.at(changes)
        s = self.rows.s.copy()
        gaps, _ = geometry.linearised(s, self.rows.charts)
        follow = applied(self.inverse, gaps)
        remaining = gaps - applied(self.jacobian, follow)
        largest = np.abs(remaining).max(initial=0.0)
        if largest > UNFIT * STEP:
            raise InputError(
                f"tolerances: {variable.name} opens a loop: the loop has more equations than"
                " unknowns, and closes for one value only; leave it out"
            )
        s[:, self.unknowns] -= follow
        moved = ClosedRows(geometry, s, self.rows.charts)
        return moved.poses().frame(self.frame)
