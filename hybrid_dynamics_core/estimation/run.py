"""A measured run: closed states with accelerations, and efforts of some drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..closed_state.state import ClosedState
from ..dynamics.hydraulics import cylinder_force
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.check_arrays import finite_vectors, mapping_of, real_array
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot
from ..robot.taken import AnyRobot, robot_of
from .motion import ClosedMotion, closed_motion
from .sensors import check_changing, check_clock, check_moving, check_pressures

Pressures = Mapping[str, tuple[ArrayLike, ArrayLike]]
Rows = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """Samples of a motion, or of poses at rest, with measured efforts.

    Attributes:
        robot: the robot.
        state: closed states, a batch of N.
        ddu: (N, n) accelerations of the active joints [rad/s^2, m/s^2].
        efforts: (N, k) measured efforts of `drives` [N m, N]; NaN where a sample has none.
        drives: the k drives with efforts.
        time: (N,) [s]; None for poses that are no motion.
        exchanged: efforts (N,) by cylinder if cap and rod pressures were exchanged [N].
        bandwidth: to which the motion was smoothed [Hz]; infinite if it was not.
    """

    robot: Robot
    state: ClosedState
    ddu: Array
    efforts: Array
    drives: tuple[str, ...]
    time: Array | None = None
    exchanged: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    bandwidth: float = np.inf

    @classmethod
    def from_state(
        cls,
        robot: AnyRobot,
        state: ClosedState,
        ddu: ArrayLike | None = None,
        efforts: Mapping[str, ArrayLike] | None = None,
        pressures: Pressures | None = None,
    ) -> MeasuredRun:
        """A run of one closed state, or of a batch of poses.

        Args:
            robot: the model, or its description.
            state: closed state, or a batch of N.
            ddu: active accelerations (n,) or (N, n) [rad/s^2, m/s^2]; None for zero.
            efforts: measured effort [N m, N] by drive, each a number or (N,).
            pressures: pressures [Pa] on cap and rod side by cylinder, each a number or (N,).

        Raises:
            InputError: no effort is given, a name is unknown, or a shape is wrong.
        """
        robot = robot_of(robot)
        require_type("state", state, ClosedState, "robot.close(u, du)")
        rows = -1 if state.u.ndim == 1 else len(state.u)
        if ddu is None:
            ddu = np.zeros_like(state.u)
        accelerations = finite_vectors("ddu", ddu, robot.active, rows)
        if rows < 0:
            state = ClosedState.joined([state])
            accelerations = accelerations[None]
        measured, exchanged = _measured(robot, len(state.u), efforts, pressures)
        drives = tuple(measured)
        table = np.stack(list(measured.values()), axis=1)
        return cls(robot, state, accelerations, table, drives, None, exchanged)

    @classmethod
    def from_samples(
        cls,
        robot: AnyRobot,
        time: ArrayLike,
        positions: Mapping[str, ArrayLike],
        efforts: Mapping[str, ArrayLike] | None = None,
        pressures: Pressures | None = None,
        bandwidth: float = 1.5,
    ) -> MeasuredRun:
        """A run from recorded samples of a motion.

        Args:
            robot: the model, or its description.
            time: (N,) [s], rising.
            positions: coordinates (N,) [rad, m] by name; any n that determine the others will do.
            efforts: measured effort (N,) [N m, N] by drive.
            pressures: pressures (N,) [Pa] on cap and rod side by cylinder.
            bandwidth: of the motion [Hz]; what is quicker is smoothed.

        Raises:
            SensorError: the clock jumps, a sensor is stuck, a unit is wrong. It is an InputError.
            InputError: a name is unknown, a shape is wrong, or a value is not finite.
        """
        robot = robot_of(robot)
        stamps = check_clock(real_array("time", time))
        columns: dict[str, Array] = {}
        for name, values in mapping_of("positions", positions).items():
            if name not in robot.coordinates:
                raise InputError(
                    f"positions: {no_such_name('coordinate', name, robot.coordinates)}"
                )
            columns[name] = _column(name, values, len(stamps))
        motion = closed_motion(robot, stamps, columns, bandwidth)
        check_moving(robot, stamps, columns, motion.state)
        measured, exchanged = _measured(robot, len(stamps), efforts, pressures)
        _check_changing(robot, stamps, motion, pressures)
        drives = tuple(measured)
        table = np.stack(list(measured.values()), axis=1)
        parts = (robot, motion.state, motion.ddu, table, drives, stamps, exchanged)
        return cls(*parts, bandwidth)

    def rows(self, rows: Rows | slice) -> MeasuredRun:
        """The run of some samples, by their indices or a slice."""
        exchanged = {name: values[rows] for name, values in self.exchanged.items()}
        return MeasuredRun(
            robot=self.robot,
            state=self.state.rows(rows),
            ddu=self.ddu[rows],
            efforts=self.efforts[rows],
            drives=self.drives,
            time=None if self.time is None else self.time[rows],
            exchanged=MappingProxyType(exchanged),
            bandwidth=self.bandwidth,
        )

    def of_drives(self, drives: tuple[str, ...]) -> MeasuredRun:
        """The run with the efforts of some drives only.

        Raises:
            InputError: the run lacks one of them.
        """
        missing = [name for name in drives if name not in self.drives]
        if missing:
            raise InputError(f"empty: no effort of {', '.join(missing)}; expected those of the run")
        columns = [self.drives.index(name) for name in drives]
        parts = (self.robot, self.state, self.ddu, self.efforts[:, columns], drives)
        return MeasuredRun(*parts, self.time, self.exchanged, self.bandwidth)


def _measured(
    robot: Robot,
    count: int,
    efforts: Mapping[str, ArrayLike] | None,
    pressures: Pressures | None,
) -> tuple[dict[str, Array], Mapping[str, Array]]:
    """Efforts (N,) by drive, and by cylinder those with exchanged chambers [N m, N]."""
    measured: dict[str, Array] = {}
    exchanged: dict[str, Array] = {}
    for name, values in mapping_of("efforts", efforts).items():
        if name not in robot.drives:
            raise InputError(f"efforts: {no_such_name('drive', name, robot.drives)}")
        measured[name] = _column(f"{name}.effort", values, count)
    for name, pair in mapping_of("pressures", pressures).items():
        if name not in robot.cylinders:
            raise InputError(f"pressures: {no_such_name('cylinder', name, robot.cylinders)}")
        sides = _sides(name, pair, count)
        cap, rod = sides.values()
        cylinder = robot.cylinders[name]
        check_pressures(cylinder, cap, rod)
        measured[name] = cylinder_force(cylinder, cap, rod)
        exchanged[name] = cylinder_force(cylinder, rod, cap)
    if not measured:
        drives = ", ".join(robot.drives)
        raise InputError(f"no effort is measured; expected efforts or pressures of {drives}")
    ordered = {name: measured[name] for name in robot.drives if name in measured}
    return ordered, MappingProxyType(exchanged)


def _sides(cylinder: str, pair: object, count: int) -> dict[str, Array]:
    """Pressures (N,) of cap and rod side, by the name of the sensor [Pa]."""
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise InputError(f"pressures: {cylinder}: expected (cap_pressure, rod_pressure)")
    names = (f"{cylinder}.cap_pressure", f"{cylinder}.rod_pressure")
    return {name: _column(name, values, count) for name, values in zip(names, pair, strict=True)}


def _check_changing(
    robot: Robot, time: Array, motion: ClosedMotion, pressures: Pressures | None
) -> None:
    """Raise SensorError for a pressure that is stuck."""
    if not pressures:
        return
    tau = robot.inverse_dynamics(motion.state, motion.ddu)
    forces = robot.drive_forces(motion.state, tau)
    zero = np.zeros(len(time))
    for cylinder, pair in pressures.items():
        sides = _sides(cylinder, pair, len(time))
        idle = robot.cylinders[cylinder].return_pressure
        required = forces.get(cylinder, zero)
        check_changing(time, sides, idle, required)


def _column(name: str, values: ArrayLike, count: int) -> Array:
    """Finite values (N,) of a sensor; a single number stands for all samples."""
    column = real_array(name, values)
    if column.ndim == 0:
        column = np.full(count, float(column))
    if column.shape != (count,):
        raise InputError(f"{name} has shape {column.shape}; expected ({count},)")
    bad = np.flatnonzero(~np.isfinite(column))
    if len(bad):
        raise InputError(f"{name}: sample {bad[0]} is {column[bad[0]]}; expected finite numbers")
    return column
