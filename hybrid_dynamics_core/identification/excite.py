"""Random motions of a robot, to find out what any motion can show."""

from __future__ import annotations

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.arrays import Array
from ..robot.robot import Robot

REACH = 0.5  # [rad or m] about the reference where a coordinate has no limits
TRIES = 30
REGULAR = 0.02  # distance to a singularity below which a state is left out


def random_motion(
    robot: Robot, count: int, seed: int = 0, rate: float = 1.0, acceleration: float = 3.0
) -> tuple[ClosedState, Array]:
    """`count` independent closed states (a batch) within the limits, and accelerations (count, n) for them.

    rate, acceleration: largest of each coordinate, in rad or m per second, and per second squared.
    Raises InputError where hardly any state about the reference closes.
    """
    rng = np.random.default_rng(seed)
    n, reach = len(robot.active), REACH
    found: list[Array] = []
    for _ in range(TRIES):
        lower = np.maximum(robot.limits[:, 0], robot.reference - reach)
        upper = np.minimum(robot.limits[:, 1], robot.reference + reach)
        u = lower + rng.uniform(0.02, 0.98, (count, n)) * (upper - lower)
        state = robot.close(u, check=False)
        good = (np.asarray(state.status) == 0) & (
            np.nan_to_num(state.singularity, nan=0.0) > REGULAR
        )
        found += list(u[good])
        if len(found) >= count:
            break
        reach *= 0.8
    else:
        raise InputError(
            f"only {len(found)} of {count} random states about the reference of {robot.name} close"
        )
    du = rng.uniform(-rate, rate, (count, n))
    return robot.close(np.array(found[:count]), du), rng.uniform(
        -acceleration, acceleration, (count, n)
    )
