"""Values and bounds of limited quantities at states.

Pressures, flows and powers are those of `dynamics.hydraulics`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from .cylinders import Cylinders, quotient
from .robot_interfaces import LimitedRobot
from .rows import Row, rows_of

HYDRAULIC = ("pressure", "flow", "pump_flow", "pump_power")  # kinds of rows

_OF_FORCES = ("effort", "pressure", "power", "pump_power")  # kinds that need forces of drives


class Limits:
    """All limited quantities of a robot.

    Attributes:
        robot: the robot.
        drives: names of the m drives whose forces are limited.
        rows: the k quantities, those of one kind one after the other.
    """

    def __init__(self, robot: LimitedRobot) -> None:
        """Collect the limits of a robot."""
        self.robot = robot
        description = robot.description
        self._joints = description.joints
        self._transmissions = description.transmissions
        self._pumps = description.pumps
        self._cylinders = Cylinders(robot)
        self.drives = robot.drives
        if self._transmissions:
            self.drives = robot.all_drives
        self.rows = rows_of(robot, self.drives)
        self._needs_forces = any(row.kind in _OF_FORCES for row in self.rows)
        self._driven: list[int] = []
        for k, name in enumerate(robot.active):
            if name not in robot.idle:
                self._driven.append(k)

    @property
    def has_accelerations(self) -> bool:
        """Whether an acceleration is limited."""
        return bool(self.rows_of("acceleration"))

    def rows_of(self, kind: str) -> list[Row]:
        """The rows of a kind."""
        return [row for row in self.rows if row.kind == kind]

    # -- values

    def values(self, state: ClosedState, tau: ArrayLike, ddu: ArrayLike | None = None) -> Array:
        """Values (k,) or (N, k) of all rows.

        Args:
            state: closed state, or a batch of N.
            tau: efforts (n,) or (N, n) of the active joints [N m, N].
            ddu: their accelerations [rad/s^2, m/s^2]; accelerations count as zero if None.

        Raises:
            SingularityError: the drives cannot give these efforts.
        """
        forces: dict[str, Array] = {}
        if self._needs_forces:
            forces = self._forces_by_name(state, tau)
        accelerations = np.zeros_like(state.s)
        if ddu is not None and self.has_accelerations:
            accelerations = self.robot.accelerations(state, ddu)
        values = np.zeros((*state.s.shape[:-1], len(self.rows)))
        for k, row in enumerate(self.rows):
            values[..., k] = self._value(row, state, forces, accelerations)
        return values

    def _value(
        self,
        row: Row,
        state: ClosedState,
        forces: dict[str, Array],
        accelerations: Array,
    ) -> Array:
        """Value (...) of one row."""
        name = row.name
        if row.kind == "effort":
            return forces[name]
        if row.kind in HYDRAULIC:
            return self._of_hydraulics(row, state, forces)
        place = self.robot.coordinates.index(name)
        if row.kind == "power":
            return np.asarray(forces[name] * state.ds[..., place])
        of_joints = {
            "position": state.s,
            "rate": state.ds,
            "acceleration": accelerations,
        }
        return np.asarray(of_joints[row.kind][..., place])

    def _of_hydraulics(self, row: Row, state: ClosedState, forces: dict[str, Array]) -> Array:
        """Value (...) of a row of a cylinder or pump."""
        name = row.name
        if row.kind == "pressure":
            return self._cylinders.pressure(name, forces[name])
        if row.kind == "flow":
            return self._cylinders.demand(state, name)
        pump = self._pumps[name]
        if row.kind == "pump_flow":
            return self._cylinders.pump_flow(state, pump)
        return self._cylinders.pump_power(state, pump, forces)

    def bounds(self, state: ClosedState) -> tuple[Array, Array]:
        """Lower and upper bounds (k,) or (N, k) of all rows at a state."""
        shape = (*state.s.shape[:-1], len(self.rows))
        lower, upper = np.zeros(shape), np.zeros(shape)
        for k, row in enumerate(self.rows):
            lower[..., k] = row.lower
            upper[..., k] = row.upper
            if row.kind == "effort":
                largest = self._largest_effort(state, row.name)
                lower[..., k] = -largest
                upper[..., k] = largest
        return lower, upper

    # -- forces of drives

    def forces(self, state: ClosedState, tau: ArrayLike) -> Array:
        """Forces (m,) or (N, m) of `drives` that give tau [N m, N].

        Entries along idle coordinates are ignored. Drives of transmissions that share a motion
        give the least sum of squares.

        Args:
            state: closed state, or a batch of N.
            tau: efforts (n,) or (N, n) [N m, N].

        Raises:
            SingularityError: the drives cannot give these efforts.
        """
        tau = np.asarray(tau, dtype=float)
        if not self.drives:
            return np.zeros((*state.s.shape[:-1], 0))
        if not self._transmissions:
            by_name = self.robot.drive_forces(state, tau)
            return np.stack(
                [by_name[name] for name in self.drives],
                axis=-1,
            )
        rates = self.drive_rates(state)[..., self._driven]
        inverse = np.linalg.pinv(
            np.swapaxes(
                rates,
                -1,
                -2,
            )
        )
        driven = tau[..., self._driven, None]
        return np.asarray((inverse @ driven)[..., 0])

    def drive_rates(self, state: ClosedState) -> Array:
        """Rates (m, n) or (N, m, n) of `drives` per unit rates of the active coordinates."""
        if self._transmissions:
            return self.robot.drive_rates(state)
        places = [self.robot.coordinates.index(name) for name in self.drives]
        return state.R[..., places, :]

    def force_bounds(self, state: ClosedState) -> tuple[Array, Array]:
        """Least and greatest force (m,) or (N, m) of each drive at a state [N m, N].

        They follow from efforts, pressures, powers of drives and powers of pumps.
        """
        shape = (*state.s.shape[:-1], len(self.drives))
        lower, upper = np.zeros(shape), np.zeros(shape)
        for k, name in enumerate(self.drives):
            most = self._strongest(state, name)
            lower[..., k] = -most
            upper[..., k] = most
            if name in self.robot.description.actuators:
                pull, push = self._cylinders.force_bounds(state, name)
                lower[..., k] = np.maximum(
                    lower[..., k],
                    pull,
                )
                upper[..., k] = np.minimum(
                    upper[..., k],
                    push,
                )
        return lower, upper

    def clip(self, state: ClosedState, forces: Array) -> Array:
        """Forces (m,) or (N, m) as far as the drives give them; flows count too [N m, N]."""
        lower, upper = self.force_bounds(state)
        given = np.clip(forces, lower, upper)
        for k, name in enumerate(self.drives):
            if name in self.robot.description.actuators:
                pull, push = self._cylinders.flow_bounds(state, name)
                given[..., k] = np.clip(
                    given[..., k],
                    pull,
                    push,
                )
        return given

    def _strongest(self, state: ClosedState, name: str) -> Array:
        """Largest force (...) of a drive by effort and power [N m, N]."""
        most = self._largest_effort(state, name)
        if name not in self._joints:
            return most
        power = self._joints[name].power_limit
        if math.isinf(power):
            return most
        place = self.robot.coordinates.index(name)
        speed = np.abs(state.ds[..., place])
        return np.minimum(most, quotient(power, speed))

    def _largest_effort(self, state: ClosedState, name: str) -> Array:
        """Largest effort (...) of a drive at a state [N m, N]."""
        if name not in self._joints:
            return np.asarray(self._transmissions[name].effort_limit)
        joint = self._joints[name]
        if joint.effort_table is None:
            return np.asarray(joint.effort_limit)
        place = self.robot.coordinates.index(name)
        position, rate = state.s[..., place], state.ds[..., place]
        by_table = joint.effort_table.at(position, rate)
        return np.minimum(by_table, joint.effort_limit)

    def _forces_by_name(self, state: ClosedState, tau: ArrayLike) -> dict[str, Array]:
        """Forces (...) of drives by name; cylinders that are no drives have none."""
        forces = self.forces(state, tau)
        nothing = np.zeros(state.s.shape[:-1])
        by_name = dict.fromkeys(self.robot.description.actuators, nothing)
        for k, name in enumerate(self.drives):
            by_name[name] = forces[..., k]
        return by_name
