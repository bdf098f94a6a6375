"""Margins of results to limits of drives, cylinders and pumps. It does not depend on ROS."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot, SingularityError
from hybrid_dynamics_core.limits import LimitMargins, Margin

from ..messages.joint_samples import FloatArray
from .results import MotionResult


def margins_of_result(result: MotionResult) -> LimitMargins | None:
    """Margins of one sample; None if its efforts are unknown."""
    efforts, acceleration = result.efforts, result.active.acceleration
    if efforts is None or acceleration is None:
        return None
    return margins_at(result.robot, result.state, efforts, acceleration)


def margins_at(
    robot: Robot, state: ClosedState, efforts: FloatArray, acceleration: FloatArray
) -> LimitMargins | None:
    """Margins of states; None where the drives cannot give the efforts.

    Args:
        robot: the robot.
        state: closed state, or a batch of N.
        efforts: efforts of the active joints (n,) or (N, n) [N m or N].
        acceleration: their accelerations of the same shape [rad/s^2 or m/s^2].
    """
    try:
        return robot.limit_margins(state, acceleration, efforts)
    except SingularityError:
        return None


def beyond_in_rows(
    robot: Robot,
    time: FloatArray,
    state: ClosedState,
    efforts: FloatArray,
    acceleration: FloatArray,
) -> list[str]:
    """A sentence for each quantity of a motion beyond its limit, where it is furthest.

    Args:
        robot: the robot.
        time: (N,) [s].
        state: a batch of N.
        efforts: (N, n) [N m or N]; rows with NaN are left out.
        acceleration: (N, n) [rad/s^2 or m/s^2].
    """
    complete = np.isfinite(efforts).all(axis=1) & np.isfinite(acceleration).all(axis=1)
    chosen = np.flatnonzero(complete)
    if not chosen.size:
        return []
    margins = margins_at(robot, state.rows(chosen), efforts[chosen], acceleration[chosen])
    if margins is None:
        return []
    return [f"{one.text}, at {time[chosen[one.index]]:.3f} s" for one in drives_beyond(margins)]


def drives_beyond(margins: LimitMargins) -> list[Margin]:
    """What is beyond, without positions of joints, which have margins of their own."""
    return [margin for margin in margins.beyond if margin.kind != "position"]
