"""Differences of model and measurement, and their derivatives with respect to parameters.

Loops stay closed while a parameter changes: the passive coordinates follow by the implicit function
of the closure. The geometry is moved in both directions, and each difference is a central one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import DescriptionError, InputError
from ..ground.arrays import Array
from .adjustable import FreeParameter
from .closed_rows import ClosedRows, Geometry, closed_near
from .first_order import FirstOrderMotion, OverdeterminedLoopError
from .free_robot import FreeRobot
from .observations import Observations

STEP = 1e-5  # of the robot's reach: change of a parameter in a derivative


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
    """Predictions of a robot for its observations.

    Attributes:
        free_robot: the robot and its parameters.
        observations: the measured rows.
        given: indices of the given coordinates (n,).
        reach: largest distance of a joint or frame from the base [m].
        step: change of a parameter in a derivative, in natural units [m].
        scales: natural units (k,): a parameter times its scale is a length [m].
    """

    def __init__(self, free_robot: FreeRobot, observations: Observations) -> None:
        self.free_robot = free_robot
        self.observations = observations
        coordinates = free_robot.robot.coordinates
        indices = [coordinates.index(name) for name in observations.given]
        self.given = np.array(indices, dtype=int)
        posed = observations.closed.poses()
        self.reach = posed.extent()
        self.step = STEP * self.reach
        numbered = enumerate(free_robot.parameters)
        scales = [self.scale(k, parameter) for k, parameter in numbered]
        self.scales = np.array(scales)

    def scale(self, k: int, parameter: FreeParameter) -> float:
        """The natural unit of a parameter: 1 for lengths, the reach for angles."""
        if parameter.place == "gain":
            return self.scale_of_gain(str(parameter.path[0]))
        unit = parameter.unit
        if not unit and k not in self.free_robot.fixed:
            unit = self.unit_by_influence(k)
        if unit == "rad":
            return self.reach
        return 1.0

    def scale_of_gain(self, name: str) -> float:
        """The largest reading of an encoder [m], angles times the reach."""
        columns = self.observations.table.columns
        if name not in columns:
            raise InputError(f"free: joints.{name}.gain: the data have no column {name}")
        sizes = np.abs(columns[name])
        largest = float(np.nanmax(sizes))
        if self.free_robot.robot.joint_types[name] == "revolute":
            largest *= self.reach
        return max(largest, self.step)

    def unit_by_influence(self, k: int) -> str:
        """`rad` for a parameter that turns frames more than it moves them, otherwise `m`."""
        before = self.observations.closed.geometry
        after = self.moved(k, self.observations.values, self.step)
        turned = 0.0
        moved = 0.0
        pairs = zip(before.tree.bodies, after.tree.bodies, strict=True)
        for body, other in pairs:
            turned += _largest(np.subtract(body.rotation, other.rotation))
            moved += _largest(np.subtract(body.translation, other.translation))
        if turned > moved:
            return "rad"
        return "m"

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
        geometry = self.free_robot.geometry(values)
        coordinates = self.coordinates(geometry)
        closed = closed_near(geometry, near.closed, self.given, coordinates)
        return self._predicted(values, closed)

    def _predicted(self, values: Array, closed: ClosedRows) -> Predicted:
        posed = closed.poses()
        differences = self.observations.differences(posed)
        return Predicted(values, closed, differences)

    def coordinates(self, geometry: Geometry) -> Array:
        """Values (N, n) of the given coordinates, from the readings of their encoders."""
        gains = geometry.gains[self.given]
        coordinates: Array = self.observations.readings * gains
        return coordinates

    def moved(self, k: int, values: Array, change: float) -> Geometry:
        """The geometry with one parameter changed.

        Raises:
            InputError: the parameter cannot change.
        """
        changed = values.copy()
        changed[k] += change
        try:
            return self.free_robot.geometry(changed)
        except DescriptionError as error:
            raise self.fixed(k, str(error)) from error

    def fixed(self, k: int, problem: str) -> InputError:
        """The error for a parameter that cannot change."""
        name = self.free_robot.parameters[k].name
        return InputError(f"free: {name} cannot be estimated: {problem}")

    # -- derivatives

    def jacobian(self, at: Predicted) -> Array:
        """Derivatives (N, c, k) of the differences, per natural unit of each parameter [1/m].

        They are zero where nothing was measured.

        Raises:
            InputError: a parameter cannot change, or only with open loops.
        """
        motion = FirstOrderMotion(at.closed, self.given)
        columns: list[Array] = []
        for k in range(len(self.free_robot.parameters)):
            if k in self.free_robot.fixed:
                columns.append(np.zeros_like(at.differences))
                continue
            above = self._moved_differences(motion, at.values, k, 1.0)
            below = self._moved_differences(motion, at.values, k, -1.0)
            column = (above - below) / (2.0 * self.step)
            columns.append(column)
        jacobian = np.stack(columns, axis=2)
        return np.nan_to_num(jacobian)

    def _moved_differences(
        self, motion: FirstOrderMotion, values: Array, k: int, sign: float
    ) -> Array:
        """The differences (N, c) with one parameter changed by a step up (1) or down (-1)."""
        change = sign * self.step / float(self.scales[k])
        geometry = self.moved(k, values, change)
        try:
            moved = motion.moved(geometry, self.coordinates(geometry), STEP)
        except OverdeterminedLoopError as error:
            problem = "the loops have more equations than unknowns, and close for one value only"
            raise self.fixed(k, problem) from error
        return self.observations.differences(moved.poses())


def _largest(values: Array) -> float:
    """The largest size of some values."""
    sizes = np.abs(values)
    return float(sizes.max(initial=0.0))
