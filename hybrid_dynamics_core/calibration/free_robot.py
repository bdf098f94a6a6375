"""The geometry of a robot as a function of free parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..algebra.independence import independent_rows, null_space
from ..closed_state.state import ClosedState
from ..closure.constraints.from_description import loop_equations
from ..description.geometry import Transform, rotation_from_rpy
from ..description.model import Closure, Frame, RobotDescription
from ..errors import DescriptionError, InputError, StateError
from ..ground.arrays import Array
from ..mechanism.tree import build_tree
from ..robot.robot import Robot
from .adjustable import AdjustableRobot, FreeParameter
from .closed_rows import RANK, ClosedRows, Geometry
from .loop_choices import PROBE, LoopChoices, with_general_bars

INDEPENDENT = 1e-3  # share of a coordinate's motion that others do not give: less, and it depends


class FreeRobot:
    """A robot with free parameters.

    Attributes:
        adjustable: its descriptions.
        parameters: the free parameters, k of them.
        robot: the robot as it is in the file.
        start: values of the parameters in the file (k,) [rad, m].
        fixed: parameters that the structure of the robot does not allow to change, by index, with
            the reason. They keep their values.
    """

    def __init__(self, adjustable: AdjustableRobot, parameters: Sequence[FreeParameter]) -> None:
        self.adjustable = adjustable
        self.parameters = tuple(parameters)
        self.start = np.array([parameter.start for parameter in parameters])
        self.robot = adjustable.robot
        self._nominal = self.robot.description
        self._choices = LoopChoices(adjustable, self.parameters, self._nominal)
        self.fixed: dict[int, str] = {}
        for k in range(len(self.parameters)):
            problem = self._problem(k)
            if problem:
                self.fixed[k] = problem
        if len(self.fixed) == len(self.parameters):
            name = self.parameters[0].name
            raise InputError(f"free: {name} cannot change: {self.fixed[0]}")

    def geometry(self, values: Array) -> Geometry:
        """The geometry for values (k,) of the parameters.

        Raises:
            DescriptionError: a value is impossible.
        """
        description = self.adjustable.described(self.parameters, values)
        description = self._choices.applied(self._as_nominal(description))
        tree = build_tree(description)
        loops = loop_equations(tree, description, frozenset())
        frames = {name: Frame(name) for name in description.links}
        frames.update(description.frames)
        base = self._base(values)
        gains = np.ones(len(tree.coordinates))
        for parameter, value in zip(self.parameters, values, strict=True):
            if parameter.place == "gain":
                (joint,) = parameter.path
                gains[tree.coordinates.index(str(joint))] = value
        return Geometry(tree, tuple(loops), frames, base, gains)

    def _problem(self, k: int) -> str:
        """Why the structure of the robot does not allow a parameter to change; empty if it does.

        The loader corrects rounded numbers, so the change is larger than their digits.
        """
        problem = ""
        for sign in (1.0, -1.0):
            values = self.start.copy()
            values[k] += sign * PROBE
            try:
                self.geometry(values)
            except DescriptionError as error:
                problem = str(error)
            else:
                return ""
        return problem

    def _base(self, values: Array) -> Transform:
        """The pose of the base in the measuring frame."""
        xyz = np.zeros(3)
        rpy = np.zeros(3)
        for parameter, value in zip(self.parameters, values, strict=True):
            if parameter.place != "base":
                continue
            key, k = parameter.path
            vector = xyz if key == "xyz" else rpy
            vector[int(k)] = value
        roll, pitch, yaw = rpy.tolist()
        return Transform(rotation_from_rpy(roll, pitch, yaw), xyz)

    def _as_nominal(self, description: RobotDescription) -> RobotDescription:
        """The description with the choices of the loader: coordinates, charts, assembly modes."""
        nominal = self._nominal
        modes = {closure.name: closure.assembly for closure in nominal.closures}
        closures: list[Closure] = []
        for closure in description.closures:
            chosen = replace(closure, assembly=modes[closure.name])
            closures.append(chosen)
        return replace(
            description,
            closures=tuple(closures),
            active=nominal.active,
            idle=nominal.idle,
            active_set=nominal.active_set,
            charts=nominal.charts,
            reference=nominal.reference,
        )

    # -- coordinates

    def given_among(self, names: Sequence[str]) -> tuple[str, ...]:
        """Coordinates among some from which the loops are closed: the active ones if possible.

        Raises:
            InputError: the names do not determine the configuration.
        """
        robot = self.robot
        missing = [name for name in robot.active if name not in names]
        if not missing:
            return robot.active
        geometry = self.geometry(self.start)
        reference = robot.close(robot.reference[None])
        _, jacobian = geometry.linearised(reference.s, ())
        motions = null_space(jacobian[0], RANK)
        present = [name for name in robot.coordinates if name in names]
        indices = [robot.coordinates.index(name) for name in present]
        rows = motions[indices]
        chosen = independent_rows(rows, range(len(rows)), INDEPENDENT)
        if len(chosen) == len(robot.active):
            return tuple(present[k] for k in chosen)
        listed = ", ".join(missing)
        needed = ", ".join(robot.active)
        raise InputError(f"there is no column {listed}; expected a column for each of {needed}")

    def closed_at(
        self, values: Array, given: Sequence[str], readings: Mapping[str, Array]
    ) -> ClosedRows:
        """The closed states for values (k,) of the parameters.

        Args:
            values: the parameters [rad, m].
            given: the coordinates that are given.
            readings: readings of their encoders (N,) [rad, m].

        Raises:
            StateError: a row does not close.
        """
        robot = self._robot_at(values)
        geometry = self.geometry(values)
        coordinates: dict[str, Array] = {}
        for name in given:
            gain = geometry.gains[robot.coordinates.index(name)]
            coordinates[name] = gain * readings[name]
        if tuple(given) == robot.active:
            columns = list(coordinates.values())
            state = robot.close(np.stack(columns, axis=1))
        else:
            state = robot.close_given(coordinates)
        return ClosedRows(geometry, np.array(state.s), charts_of(robot, state))

    def _robot_at(self, values: Array) -> Robot:
        """The robot for values (k,) of the parameters."""
        if np.array_equal(values, self.start):
            return self.robot
        description = self.adjustable.described(self.parameters, values)
        return Robot(with_general_bars(description, self.robot))

    def open_rows(self, given: Sequence[str], readings: Mapping[str, Array]) -> list[int]:
        """Indices of rows that do not close with the robot of the file."""
        rows: list[int] = []
        count = len(readings[given[0]])
        for row in range(count):
            one = {name: values[row : row + 1] for name, values in readings.items()}
            try:
                self.closed_at(self.start, given, one)
            except StateError:
                rows.append(row)
        return rows


def charts_of(robot: Robot, state: ClosedState) -> tuple[Array, ...]:
    """Charts of the ball and free joints of closed rows, (N,) each."""
    joints = len(robot.description.freely_turning)
    blocks = np.shape(state.signs)[-1] - joints
    shape = (len(state.s), blocks + joints)
    signs = np.broadcast_to(state.signs, shape)
    charts = signs[:, blocks:].astype(float)
    return tuple(charts.T)
