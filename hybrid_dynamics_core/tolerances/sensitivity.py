"""How the pose of a frame changes with what varies, the loops staying closed.

Each column is moved in both directions. The passive coordinates follow by the implicit function of
the closure, and each derivative is a central difference.
"""

from __future__ import annotations

import numpy as np

from ..calibration.closed_rows import ClosedRows
from ..calibration.first_order import FirstOrderMotion, OverdeterminedLoopError
from ..calibration.quantities import rotation_vectors
from ..errors import InputError
from ..ground.arrays import Array
from .varied import Variable, VariedRobot

STEP = 1e-5  # of the robot's reach, or rad: change of a column in a derivative


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
    derivatives = _Derivatives(varied, rows, frame)
    result = np.zeros((len(rows.s), 6, varied.count))
    for variable in varied.variables:
        for column in variable.indices:
            result[:, :, column] = derivatives.by(variable, column)
    return result


class _Derivatives:
    """Derivatives of the pose of one frame at closed states."""

    def __init__(self, varied: VariedRobot, rows: ClosedRows, frame: str) -> None:
        self.varied = varied
        self.rows = rows
        self.frame = frame
        self.motion = FirstOrderMotion(rows, varied.given)
        self.reach = rows.poses().extent()

    def by(self, variable: Variable, column: int) -> Array:
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
        values = self.rows.s[:, self.varied.given]
        try:
            moved = self.motion.moved(geometry, values, STEP)
        except OverdeterminedLoopError as error:
            raise InputError(
                f"tolerances: {variable.name} opens a loop: the loop has more equations than"
                " unknowns, and closes for one value only; leave it out"
            ) from error
        return moved.poses().frame(self.frame)
