"""Random motions of a robot, to find which parameters motion can identify."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import integer, real_number
from ..robot.robot import Robot
from ..robot.taken import AnyRobot, robot_of

REACH = 0.5  # [rad or m] half range about the reference of a coordinate without limits
TRIES = 30
REGULAR = 0.02  # distance to a singularity below which a state is left out


def random_motion(
    robot: AnyRobot,
    count: int,
    seed: int = 0,
    rate: float = 1.0,
    acceleration: float = 3.0,
) -> tuple[ClosedState, Array]:
    """Independent random states within the limits, with accelerations.

    Args:
        robot: the model, or its description.
        count: number of states N.
        seed: seed of the random numbers.
        rate: largest rate of each coordinate [rad/s or m/s].
        acceleration: largest acceleration of each coordinate [rad/s^2 or m/s^2].

    Returns:
        A batch of N closed states, and accelerations (N, n) of the active joints.

    Raises:
        InputError: hardly any state about the reference closes.
    """
    robot = robot_of(robot)
    count = integer("count", count)
    rng = np.random.default_rng(integer("seed", seed, 0))
    rate = real_number("rate", rate)
    acceleration = real_number("acceleration", acceleration)
    n = len(robot.active)
    reach = REACH
    samples: list[Array] = []
    for _ in range(TRIES):
        lower = np.maximum(robot.limits[:, 0], robot.reference - reach)
        upper = np.minimum(robot.limits[:, 1], robot.reference + reach)
        shares = rng.uniform(0.02, 0.98, (count, n))
        u = lower + shares * (upper - lower)
        samples += list(u[_are_regular(robot, u)])
        if len(samples) >= count:
            break
        reach *= 0.8
    else:
        raise InputError(
            f"only {len(samples)} of {count} random states about the reference of"
            f" {robot.name} close"
        )
    du = rng.uniform(-rate, rate, (count, n))
    state = robot.close(np.array(samples[:count]), du)
    ddu = rng.uniform(-acceleration, acceleration, (count, n))
    return state, ddu


def _are_regular(robot: Robot, u: Array) -> NDArray[np.bool_]:
    """Mask (N,) of the active coordinates (N, n) that close away from singularities."""
    state = robot.close(u, check=False)
    closed = np.asarray(state.status) == 0
    distance = np.nan_to_num(state.singularity, nan=0.0)
    return np.asarray(closed & (distance > REGULAR))
