"""Controllers: functions of time [s] and measured ClosedState that return efforts tau (n,).

Each is a few lines over the model; `loads` is what the model believes to act (None: what the
description gives), so that a controller may be wrong about a payload while the machine, or its
simulation, is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.wording import counted
from ..robot.robot import Robot
from .trajectory import JointTrajectory


@dataclass(frozen=True, eq=False)
class GravityCompensation:
    """Holds weight, springs and applied wrenches, and nothing else: the arm moves as if it had no weight.

    `damping`: (n,) or a number [N m s/rad or N s/m], tau falls by it times u'. Raises InputError
    for another shape.
    """

    robot: Robot
    damping: ArrayLike = 0.0
    loads: Loads | None = None

    def __post_init__(self) -> None:
        _check_gains(self.robot, damping=self.damping)

    def __call__(self, t: float, state: ClosedState) -> Array:  # noqa: ARG002  one signature for all controllers
        """The efforts."""
        still = self.robot.close(state.u, near=state)
        hold = self.robot.inverse_dynamics(still, np.zeros_like(state.u), self.loads)
        return np.asarray(hold - np.asarray(self.damping) * state.du)


@dataclass(frozen=True, eq=False)
class ComputedTorque:
    """Follows a trajectory so that its error e = u_d - u obeys e'' + kd e' + kp e = 0, joint by joint.

    tau = ID(u, u', u_d'' + kd e' + kp e). `kp` [1/s^2] and `kd` [1/s]: (n,) or a number; kd = 2
    sqrt(kp) does not overshoot.
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
        """The efforts."""
        goal = self.trajectory(t)
        ddu = (
            goal.ddu
            + np.asarray(self.kd) * (goal.du - state.du)
            + np.asarray(self.kp) * (goal.u - state.u)
        )
        return self.robot.inverse_dynamics(state, ddu, self.loads)


@dataclass(frozen=True, eq=False)
class FeedForward:
    """The efforts that the trajectory needs, and a spring and damper to it: ID(u_d, u_d', u_d'') + kp e + kd e'.

    `kp` [N m/rad or N/m] and `kd` [N m s/rad or N s/m]: (n,) or a number. With `model` False only
    spring and damper.
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
        """The efforts."""
        goal = self.trajectory(t)
        tau = np.asarray(self.kp) * (goal.u - state.u) + np.asarray(self.kd) * (goal.du - state.du)
        if self.model:
            wanted = self.robot.close(goal.u, goal.du, near=state)
            tau = tau + self.robot.inverse_dynamics(wanted, goal.ddu, self.loads)
        return np.asarray(tau)


def efforts_along(
    robot: Robot, trajectory: JointTrajectory, times: ArrayLike, loads: Loads | None = None
) -> Array:
    """Feed-forward efforts (N, n) of a trajectory at ascending times (N,) [s], closed from each point to the next.

    Raises ClosureError or SingularityError with the `index` of the first time at which it cannot be
    reached.
    """
    times = np.asarray(times, dtype=float)
    if times.ndim != 1 or not len(times):
        raise InputError(f"times has shape {times.shape}; expected (N,)")
    _check_trajectory(robot, trajectory)
    goal = trajectory(times)
    return robot.inverse_dynamics(robot.close_path(goal.u, goal.du), goal.ddu, loads)


def _check_gains(robot: Robot, **gains: ArrayLike) -> None:
    """Raise InputError for gains that are neither a number nor one for each active joint, finite and not negative."""
    n = len(robot.active)
    for name, gain in gains.items():
        values = np.asarray(gain, dtype=float)
        if values.shape not in ((), (n,)):
            raise InputError(
                f"{name} has shape {values.shape}; expected a number or ({n},):"
                f" {', '.join(robot.active)}"
            )
        if not (np.isfinite(values) & (values >= 0.0)).all():
            raise InputError(
                f"{name} is {values.tolist()}; expected finite numbers, zero or positive"
            )


def _check_trajectory(robot: Robot, trajectory: JointTrajectory) -> None:
    """Raise InputError for a trajectory of another number of joints."""
    columns, n = trajectory.positions.shape[1], len(robot.active)
    if columns != n:
        raise InputError(
            f"the trajectory has {counted(columns, 'joint')}; {robot.name} has {n}:"
            f" {', '.join(robot.active)}"
        )
