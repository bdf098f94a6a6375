"""Controllers: functions of time [s] and measured ClosedState that return efforts tau (n,).

`loads` are what the controller's model assumes (None: what the description gives). They may differ
from the loads of the machine or its simulation, such as an unknown payload.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.check_arrays import real_array
from ..ground.wording import counted
from ..robot.robot import Robot
from .trajectory import JointTrajectory


@dataclass(frozen=True, eq=False)
class GravityCompensation:
    """Balances weight, springs and applied wrenches: the arm moves as if it had no weight.

    Attributes:
        robot: the model.
        damping: (n,) or a number [N m s/rad or N s/m]; tau falls by `damping` times u'.
        loads: loads that the model assumes; None for those of the description.

    Raises:
        InputError: for a damping of another shape, not finite or negative.
    """

    robot: Robot
    damping: ArrayLike = 0.0
    loads: Loads | None = None

    def __post_init__(self) -> None:
        _check_gains(self.robot, damping=self.damping)

    # All controllers have one signature.
    def __call__(self, t: float, state: ClosedState) -> Array:  # noqa: ARG002
        """Efforts tau (n,) [N m or N] at a time [s] in a measured state."""
        still = self.robot.close(state.u, near=state)
        hold = self.robot.inverse_dynamics(still, np.zeros_like(state.u), self.loads)
        return _of_drives(self.robot, hold - np.asarray(self.damping) * state.du)


@dataclass(frozen=True, eq=False)
class ComputedTorque:
    """Follows a trajectory so that errors e = u_d - u obey e'' + kd e' + kp e = 0.

    This holds if the model is exact and every active coordinate is driven.

    tau = ID(u, u', u_d'' + kd e' + kp e). A gain kd = 2 sqrt(kp) does not overshoot.

    Attributes:
        robot: the model.
        trajectory: u_d with its rates and accelerations.
        kp: (n,) or a number [1/s^2].
        kd: (n,) or a number [1/s].
        loads: loads that the model assumes; None for those of the description.

    Raises:
        InputError: for gains of another shape, not finite or negative, and for a trajectory of
            another number of joints.
    """

    robot: Robot
    trajectory: JointTrajectory
    kp: ArrayLike
    kd: ArrayLike
    loads: Loads | None = None

    def __post_init__(self) -> None:
        _check_gains(self.robot, kp=self.kp, kd=self.kd)
        _check_trajectory(self.robot, self.trajectory)

    def __call__(self, t: float, state: ClosedState) -> Array:
        """Efforts tau (n,) [N m or N] at a time [s] in a measured state."""
        goal = self.trajectory(t)
        damper = np.asarray(self.kd) * (goal.du - state.du)
        spring = np.asarray(self.kp) * (goal.u - state.u)
        ddu = goal.ddu + damper + spring
        return _of_drives(self.robot, self.robot.inverse_dynamics(state, ddu, self.loads))


@dataclass(frozen=True, eq=False)
class FeedForward:
    """Efforts that the trajectory needs, and a spring and damper towards it.

    tau = ID(u_d, u_d', u_d'') + kp e + kd e', with the error e = u_d - u.

    Attributes:
        robot: the model.
        trajectory: u_d with its rates and accelerations.
        kp: (n,) or a number [N m/rad or N/m].
        kd: (n,) or a number [N m s/rad or N s/m].
        loads: loads that the model assumes; None for those of the description.
        model: whether inverse dynamics is added. False: spring and damper only.

    Raises:
        InputError: for gains of another shape, not finite or negative, and for a trajectory of
            another number of joints.
    """

    robot: Robot
    trajectory: JointTrajectory
    kp: ArrayLike = 0.0
    kd: ArrayLike = 0.0
    loads: Loads | None = None
    model: bool = True

    def __post_init__(self) -> None:
        _check_gains(self.robot, kp=self.kp, kd=self.kd)
        _check_trajectory(self.robot, self.trajectory)

    def __call__(self, t: float, state: ClosedState) -> Array:
        """Efforts tau (n,) [N m or N] at a time [s] in a measured state."""
        goal = self.trajectory(t)
        spring = np.asarray(self.kp) * (goal.u - state.u)
        damper = np.asarray(self.kd) * (goal.du - state.du)
        tau = spring + damper
        if self.model:
            wanted = self.robot.close(goal.u, goal.du, near=state)
            tau = tau + self.robot.inverse_dynamics(wanted, goal.ddu, self.loads)
        return _of_drives(self.robot, tau)


def efforts_along(
    robot: Robot, trajectory: JointTrajectory, times: ArrayLike, loads: Loads | None = None
) -> Array:
    """Feed-forward efforts of a trajectory, with the loops closed from each time to the next.

    Args:
        robot: the model.
        trajectory: trajectory of the active joints.
        times: (N,) ascending [s].
        loads: loads besides the actuators; None for those of the description.

    Returns:
        (N, n) efforts [N m or N].

    Raises:
        InputError: for times of another shape, and a trajectory of another number of joints.
        ClosureError, SingularityError: with the `index` of the first time that cannot be reached.
    """
    times = real_array("times", times)
    if times.ndim != 1 or not len(times):
        raise InputError(f"times has shape {times.shape}; expected (N,)")
    _check_trajectory(robot, trajectory)
    goal = trajectory(times)
    state = robot.close_path(goal.u, goal.du)
    return _of_drives(robot, robot.inverse_dynamics(state, goal.ddu, loads))


def _of_drives(robot: Robot, tau: Array) -> Array:
    """Efforts (..., n) with zeros at idle coordinates, which have no drive."""
    is_driven = np.array([name not in robot.idle for name in robot.active])
    return np.where(is_driven, tau, 0.0)


def _check_gains(robot: Robot, **gains: ArrayLike) -> None:
    """Raise InputError for gains that are not a number or (n,), finite and zero or positive."""
    require_type("robot", robot, Robot, "load(...)")
    n = len(robot.active)
    for name, gain in gains.items():
        values = real_array(name, gain)
        if values.shape not in ((), (n,)):
            raise InputError(
                f"{name} has shape {values.shape}; expected a number or ({n},):"
                f" {', '.join(robot.active)}"
            )
        usable = np.isfinite(values) & (values >= 0.0)
        if not usable.all():
            raise InputError(
                f"{name} is {values.tolist()}; expected finite numbers, zero or positive"
            )


def _check_trajectory(robot: Robot, trajectory: JointTrajectory) -> None:
    """Raise InputError for a trajectory of another number of joints."""
    require_type("robot", robot, Robot, "load(...)")
    require_type("trajectory", trajectory, JointTrajectory, "JointTrajectory.between(...)")
    columns = trajectory.positions.shape[1]
    n = len(robot.active)
    if columns != n:
        raise InputError(
            f"the trajectory has {counted(columns, 'joint')}; {robot.name} has {n}:"
            f" {', '.join(robot.active)}"
        )
