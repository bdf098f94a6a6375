"""A duty cycle for a robot that has none yet: places over the ranges of its drives, at rest."""

from __future__ import annotations

from itertools import product

import numpy as np

from ...ground.arrays import Array
from ...robot.robot import Robot

SHARES = (0.1, 0.5, 0.9)  # of the range of a drive
MOST = 4  # drives that are moved: 81 places


def usual_cycle(robot: Robot, payload: float = 0.0) -> dict[str, Array]:
    """Places over the ranges of the drives, as columns of a duty cycle.

    Drives without limits on both sides stay at the reference. Places where a loop does not close
    are left out.

    Args:
        robot: the robot.
        payload: mass at the end effector [kg].

    Returns:
        Columns by name, (N,) each.
    """
    ranges: list[Array] = []
    moved = 0
    for name, place, (lower, upper) in zip(
        robot.active, robot.reference, robot.limits, strict=True
    ):
        values = np.array([place])
        is_moved = np.isfinite(upper - lower) and name not in robot.idle
        if is_moved and moved < MOST:
            moved += 1
            values = lower + (upper - lower) * np.array(SHARES)
        ranges.append(values)
    places = np.array(list(product(*ranges)))
    status = np.asarray(robot.close(places, check=False).status)
    closed = places[status == 0]
    columns = {name: closed[:, k] for k, name in enumerate(robot.active)}
    columns["payload"] = np.full(len(closed), payload)
    return columns


def cycle_text(columns: dict[str, Array]) -> str:
    """The columns as CSV."""
    lines = [",".join(columns)]
    for row in zip(*columns.values(), strict=True):
        words = [f"{value:.12g}" for value in row]
        lines.append(",".join(words))
    return "\n".join(lines) + "\n"
