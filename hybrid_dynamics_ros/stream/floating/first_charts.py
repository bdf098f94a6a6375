"""Ball and free joints in messages: their angles are those of the URDF, in the first chart."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from hybrid_dynamics_core import ClosedState, InputError, Robot, SingularityError
from hybrid_dynamics_core.algebra.charts import FIRST, SECOND, Turns, angles_in, rate_matrix

from ...messages.joint_samples import FloatArray

_SINGULAR = 1e-9  # cosine of the second angle below which rates are undefined


def require_first_reference(
    robot: Robot, given: Collection[str], posed: Collection[str] = ()
) -> None:
    """Raise InputError if a given ball or free joint is in its second chart at the reference.

    Args:
        robot: the robot.
        given: names of the coordinates that messages give.
        posed: names of joints that are measured by poses, which are exempt.
    """
    for name, chart in robot.description.charts.items():
        turns = robot.description.multi_dof[name].turns
        if chart != FIRST and name not in posed and not set(turns).isdisjoint(given):
            raise InputError(
                f"joint {name}: its second turn is beyond a radian at the reference, where topics"
                " and URDF have no good angles for it; turn the origin of the joint, or measure"
                " its pose (parameter measured_poses)"
            )


def require_first_charts(
    robot: Robot,
    state: ClosedState,
    given: Collection[str] | None = None,
    posed: Collection[str] = (),
) -> None:
    """Raise SingularityError if a ball joint in a loop changed to its second chart.

    Args:
        robot: the robot.
        state: its state.
        given: names of the coordinates that messages give. Only joints with one of these count;
            all joints if None.
        posed: names of joints that are measured by poses, which are exempt.
    """
    joints = robot.description.freely_turning
    if not joints:
        return
    is_second = charts_of(robot, state) != FIRST
    for k, joint in enumerate(joints):
        is_given = given is None or not set(joint.turns).isdisjoint(given)
        if not is_given or joint.name in posed:
            is_second[..., k] = False
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
        (n_s,) [rad, m] and (n_s,) [rad/s, m/s]; (N, n_s) for rows.
    """
    return turned_to_first(robot, charts_of(robot, state), state.s, state.ds)


class CoordinateMotion(NamedTuple):
    """Motion of all coordinates as messages have it, ball and free joints in the first chart.

    Attributes:
        position: (n_s,) [rad, m].
        velocity: (n_s,) [rad/s, m/s].
        acceleration: (n_s,) [rad/s^2, m/s^2]; None if unknown.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray | None

    def complete(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and acceleration, NaN if unknown."""
        acceleration = self.acceleration
        if acceleration is None:
            acceleration = np.full_like(self.position, np.nan)
        return self.position, self.velocity, acceleration


def motion_in_first(
    robot: Robot, state: ClosedState, dds: FloatArray | None = None
) -> CoordinateMotion:
    """The motion of one state.

    Args:
        robot: the robot.
        state: its state.
        dds: accelerations of all coordinates (n_s,) in the charts of the state.

    Raises:
        SingularityError: the second turn of a ball joint in a loop is exactly a quarter turn, where
            rates of the first chart are undefined.
    """
    s, ds = in_first_charts(robot, state)
    if np.isnan(ds).any() and np.isfinite(state.ds).all():
        problem = "a ball or free joint is at a quarter turn of its second turn: it has no rates"
        raise SingularityError(problem, loop="", distance=0.0)
    if dds is None or s is state.s:
        return CoordinateMotion(s, ds, dds)
    dds = dds.copy()
    charts = charts_of(robot, state)
    for k, joint in enumerate(robot.description.freely_turning):
        if charts[k] == FIRST:
            continue
        turns = [robot.coordinates.index(name) for name in joint.turns]
        before = state.s[turns]
        after = s[turns]
        spin = rate_matrix(before) @ dds[turns]
        spin += _bias(before, state.ds[turns])
        spin -= _bias(after, ds[turns])
        dds[turns] = np.linalg.solve(rate_matrix(after), spin)
    return CoordinateMotion(s, ds, dds)


def efforts_in_first(robot: Robot, state: ClosedState, efforts: FloatArray) -> FloatArray:
    """Efforts of the active coordinates along angles of the first chart, where they are defined.

    A moment has an effort along each of these angles at any orientation.

    Args:
        robot: the robot.
        state: its state, or a batch of N.
        efforts: efforts (n,) or (N, n) in the charts of the state [N m, N].
    """
    charts = charts_of(robot, state)
    if np.all(charts == FIRST):
        return efforts
    wrenches = robot.twist_map(state).wrenches(efforts)
    charts = np.broadcast_to(charts, (*efforts.shape[:-1], charts.shape[-1]))
    position, _ = in_first_charts(robot, state)
    turned = efforts.copy()
    for k, joint in enumerate(robot.description.freely_turning):
        turns = [robot.coordinates.index(name) for name in joint.turns]
        if max(turns) >= state.n:
            continue
        axes = rate_matrix(position[..., turns])
        moment = wrenches[..., turns]
        along = np.einsum("...ji,...j->...i", axes, moment)
        is_second = charts[..., k, None] != FIRST
        turned[..., turns] = np.where(is_second, along, efforts[..., turns])
    turned.flags.writeable = False
    return turned


def in_file_charts(robot: Robot, u: FloatArray) -> FloatArray:
    """Active coordinates (n,) of messages in the charts of the robot file."""
    u = u.copy()
    for joint in robot.description.freely_turning:
        turns = [robot.coordinates.index(name) for name in joint.turns]
        if max(turns) < len(u) and robot.description.charts.get(joint.name, FIRST) != FIRST:
            u[turns] = angles_in(u[turns], FIRST, SECOND)
    return u


def _bias(angles: FloatArray, rates: FloatArray) -> FloatArray:
    """Angular acceleration (3,) [rad/s^2] of three turns at constant rates."""
    rates_of_turns = rates.tolist()
    return np.array(Turns.at(angles).bias(rates_of_turns, rates_of_turns))


def turned_to_first(
    robot: Robot, charts: FloatArray, s: FloatArray, ds: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Coordinates (n_s,) and rates, or rows of them, turned from some charts to the first ones."""
    if np.all(charts == FIRST):
        return s, ds
    s, ds = s.copy(), ds.copy()
    charts = np.broadcast_to(charts, (*s.shape[:-1], charts.shape[-1]))
    for k, joint in enumerate(robot.description.freely_turning):
        turns = [robot.coordinates.index(name) for name in joint.turns]
        for row in np.ndindex(s.shape[:-1]):
            if charts[row][k] != FIRST:
                _turn_to_first(s[row], ds[row], turns)
    s.flags.writeable = ds.flags.writeable = False
    return s, ds


def _turn_to_first(s: FloatArray, ds: FloatArray, turns: list[int]) -> None:
    """Turn one joint of one configuration from the second to the first chart, in place."""
    omega = rate_matrix(s[turns]) @ ds[turns]
    angles = angles_in(s[turns], SECOND, FIRST)
    s[turns], ds[turns] = angles, np.nan
    if abs(np.cos(angles[1])) > _SINGULAR:
        ds[turns] = np.linalg.solve(rate_matrix(angles), omega)


def charts_of(robot: Robot, state: ClosedState) -> FloatArray:
    """Charts of ball and free joints, (c,) or (N, c)."""
    signs = state.signs
    charts: FloatArray = signs[..., signs.shape[-1] - len(robot.middle_turns) :].copy()
    return charts
