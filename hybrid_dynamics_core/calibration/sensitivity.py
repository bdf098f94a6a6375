"""Differences of model and measurement, and their derivatives with respect to parameters.

Loops stay closed while a parameter changes: the passive coordinates follow by the implicit function
of the closure. The geometry is moved both ways, and each difference is a central one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import DescriptionError, InputError
from ..ground.arrays import Array
from .adjustable import FreeParameter
from .machine import ClosedRows, Geometry, Machine, closed_near
from .observations import Observations

STEP = 1e-5  # of the robot's reach: change of a parameter in a derivative
UNFIT = 1e-4  # gap per change of a parameter [lengths of the loop] that nothing can close
TINY = 1e-300  # keeps divisors above zero


@dataclass(frozen=True, eq=False)
class Predicted:
    """Model and measurement at some values of the parameters.

    Attributes:
        values: the parameters (k,) [rad, m].
        closed: closed states.
        differences: model minus measurement (N, c) [rad, m]; NaN where nothing was measured.
    """

    values: Array
    closed: ClosedRows
    differences: Array


class Sensitivity:
    """Predictions of a machine for its observations.

    Attributes:
        machine: the robot and its parameters.
        observations: the measured rows.
        given: indices of the given coordinates (n,).
        reach: largest distance of a joint from the base [m].
        scales: natural units (k,): a parameter times its scale is a length [m].
    """

    def __init__(self, machine: Machine, observations: Observations) -> None:
        self.machine = machine
        self.observations = observations
        coordinates = machine.robot.coordinates
        self.given = np.array([coordinates.index(name) for name in observations.given], dtype=int)
        self.reach = max(observations.closed.poses().extent(), TINY)
        scales = [self.scale(k, parameter) for k, parameter in enumerate(machine.parameters)]
        self.scales = np.array(scales)

    def scale(self, k: int, parameter: FreeParameter) -> float:
        """The natural unit of a parameter: 1 for lengths, the reach for angles."""
        if parameter.place == "gain":
            return self.scale_of_gain(str(parameter.path[0]))
        unit = parameter.unit or self.unit_by_influence(k)
        return self.reach if unit == "rad" else 1.0

    def scale_of_gain(self, name: str) -> float:
        """The largest reading of an encoder [m], angles times the reach."""
        columns = self.observations.table.columns
        if name not in columns:
            raise InputError(f"free: joints.{name}.gain: the data have no column {name}")
        largest = float(np.nanmax(np.abs(columns[name]), initial=0.0))
        if self.machine.robot.joint_types[name] == "revolute":
            largest *= self.reach
        return max(largest, STEP * self.reach)

    def unit_by_influence(self, k: int) -> str:
        """`rad` for a parameter that turns frames without moving any, otherwise `m`."""
        before = self.observations.closed.geometry
        after = self.moved(k, self.observations.values, STEP * self.reach)
        turned = 0.0
        moved = 0.0
        for body, other in zip(before.tree.bodies, after.tree.bodies, strict=True):
            turned += float(np.abs(np.subtract(body.rotation, other.rotation)).max())
            moved += float(np.abs(np.subtract(body.translation, other.translation)).max())
        return "rad" if turned > moved else "m"

    # -- predictions

    def at_start(self) -> Predicted:
        """The prediction for the values with which the rows were closed first."""
        observations = self.observations
        return self._predicted(observations.values, observations.closed)

    def at(self, values: Array, near: Predicted) -> Predicted:
        """The prediction for other values.

        Raises:
            DescriptionError: a value is impossible.
            OpenLoopError: a row does not close.
        """
        geometry = self.machine.geometry(values)
        closed = closed_near(geometry, near.closed, self.given, self.observations.readings)
        return self._predicted(values, closed)

    def _predicted(self, values: Array, closed: ClosedRows) -> Predicted:
        differences = self.observations.differences(closed.poses())
        return Predicted(values, closed, differences)

    def moved(self, k: int, values: Array, change: float) -> Geometry:
        """The geometry with one parameter changed.

        Raises:
            InputError: the parameter cannot change.
        """
        others = values.copy()
        others[k] += change
        try:
            return self.machine.geometry(others)
        except DescriptionError as error:
            name = self.machine.parameters[k].name
            raise InputError(f"free: {name} cannot be estimated: {error}") from error

    # -- derivatives

    def jacobian(self, at: Predicted) -> Array:
        """Derivatives (N, c, k) of the differences, per natural unit of each parameter [1/m].

        Raises:
            InputError: a parameter cannot change, or only with open loops.
        """
        s = at.closed.s
        self.unknowns = np.setdiff1d(np.arange(s.shape[1]), self.given)
        _, rows = at.closed.geometry.linearised(s, at.closed.charts)
        in_unknowns = rows[:, :, self.unknowns]
        inverse: Array = np.asarray(np.linalg.pinv(in_unknowns, rcond=1e-9), dtype=float)
        columns: list[Array] = []
        for k in range(len(self.machine.parameters)):
            ends = [self.changed(k, at, sign, in_unknowns, inverse) for sign in (1.0, -1.0)]
            columns.append((ends[0] - ends[1]) / (2.0 * STEP * self.reach))
        return np.nan_to_num(np.stack(columns, axis=2))

    def changed(self, k: int, at: Predicted, sign: float, rows: Array, inverse: Array) -> Array:
        """The differences (N, c) with one parameter changed by a step, to first order."""
        change = sign * STEP * self.reach / float(self.scales[k])
        geometry = self.moved(k, at.values, change)
        s = at.closed.s.copy()
        s[:, self.given] = self.observations.readings * geometry.gains[self.given]
        gaps, _ = geometry.linearised(s, at.closed.charts)
        step = (inverse @ gaps[..., None])[..., 0]
        gap = np.abs(gaps - (rows @ step[..., None])[..., 0]).max(initial=0.0)
        if gap > UNFIT * STEP:
            name = self.machine.parameters[k].name
            text = "the loops have more equations than unknowns, and close for one value only"
            raise InputError(f"free: {name} cannot be estimated: {text}")
        s[:, self.unknowns] -= step
        moved = ClosedRows(geometry, s, at.closed.charts)
        return self.observations.differences(moved.poses())
