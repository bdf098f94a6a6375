"""Ball and free joints in messages: their angles are those of the URDF, in the first chart."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import ClosedState, InputError, Robot, SingularityError
from hybrid_dynamics_core.algebra.charts import FIRST, angles_in, rate_matrix

from ...messages.joint_samples import FloatArray

_SINGULAR = 1e-9  # cosine of the second angle below which rates are undefined


def require_first_reference(robot: Robot, base: str = "") -> None:
    """Raise InputError if a ball or free joint is in its second chart at the reference.

    Args:
        robot: the robot.
        base: name of the joint with odometry, which is exempt.
    """
    for name, chart in robot.description.charts.items():
        if chart != FIRST and name != base:
            raise InputError(
                f"joint {name}: its second turn is beyond a radian at the reference, where topics"
                " and URDF have no good angles for it; turn the origin of the joint"
            )


def require_first_charts(robot: Robot, state: ClosedState, base: str = "") -> None:
    """Raise SingularityError if a ball joint in a loop changed to its second chart.

    Args:
        robot: the robot.
        state: its state.
        base: name of the joint with odometry, which is exempt.
    """
    names = [joint.name for joint in robot.description.freely_turning]
    if not names:
        return
    is_second = _charts(robot, state) != FIRST
    is_second[..., [name == base for name in names]] = False
    if np.any(is_second):
        problem = (
            "a ball or free joint is so near a quarter turn of its second turn that it has no good"
            " angles on topics; turn the origin of the joint"
        )
        raise SingularityError(problem, loop="", distance=0.0)


def in_first_charts(robot: Robot, state: ClosedState) -> tuple[FloatArray, FloatArray]:
    """All coordinates and rates of a state, with ball and free joints in the first chart.

    If the second angle is exactly a quarter turn, rates are undefined, and are NaN.

    Returns:
        (n_s,) [rad, m] and (n_s,) [rad/s, m/s].
    """
    charts = _charts(robot, state)
    if np.all(charts == FIRST):
        return state.s, state.ds
    s, ds = state.s.copy(), state.ds.copy()
    for chart, joint in zip(charts, robot.description.freely_turning, strict=True):
        if chart != FIRST:
            turns = [robot.coordinates.index(name) for name in joint.turns]
            omega = rate_matrix(s[turns]) @ ds[turns]
            angles = angles_in(s[turns], chart, FIRST)
            s[turns], ds[turns] = angles, np.nan
            if abs(np.cos(angles[1])) > _SINGULAR:
                ds[turns] = np.linalg.solve(rate_matrix(angles), omega)
    s.flags.writeable = ds.flags.writeable = False
    return s, ds


def _charts(robot: Robot, state: ClosedState) -> FloatArray:
    """Charts of ball and free joints, (c,) or (N, c)."""
    signs = state.signs
    charts: FloatArray = signs[..., signs.shape[-1] - len(robot.middle_turns) :].copy()
    return charts
