"""A lifting chart: the mass that drives hold at rest, over the places of a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..description.effects import Payload
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import finite_vectors
from ..ground.suggestions import no_such_name
from ..kinematics.closed_kinematics import ClosedKinematics
from ..kinematics.workspace import SampleStatus, margins_at
from .box_image import solutions
from .capability import bounds_of, largest
from .robot_interface import CapableRobot

CELLS = 36  # states along each of the two joints
INSET = 1e-6  # share of a range, since rounding may put its very ends outside
STILL = 1e-9  # [m] travel of a frame that counts as none


class LiftingRobot(CapableRobot, ClosedKinematics, Protocol):
    """What a lifting chart needs of a robot."""


@dataclass(frozen=True, eq=False)
class LiftingChart:
    """Lifted masses over two joints, in a grid of c by c states.

    Attributes:
        joints: names of the two joints that move.
        u: (c, c, n) active coordinates [rad, m].
        radius: (c, c) horizontal distance of the frame from the base's z axis [m]; NaN where the
            robot cannot be.
        height: (c, c) of the frame above the base's origin [m].
        mass: (c, c) the largest mass that the drives hold at rest [kg]; 0 where they do not hold
            the robot itself.
        limited_by: (c, c) index in `drives` of a drive at its limit; -1 where none limits.
        drives: names of the drives.
        share: share of the lifted mass that counts.
        frame: name of the frame; None for the end effector.
    """

    joints: tuple[str, str]
    u: Array
    radius: Array
    height: Array
    mass: Array
    limited_by: np.ndarray
    drives: tuple[str, ...]
    share: float
    frame: str | None = None


def lifting_chart(
    robot: LiftingRobot,
    joints: tuple[str, str] | None = None,
    u: ArrayLike | None = None,
    frame: str | None = None,
    loads: Loads | None = None,
    share: float = 1.0,
) -> LiftingChart:
    """The lifting chart of a robot: the masses that it holds at rest at a frame.

    Args:
        robot: the robot.
        joints: the two active joints that move; if None, those that move the frame most up and out.
        u: (n,) where the other active joints stay [rad, m]; the reference if None.
        frame: name of the frame that carries the load; the end effector if None.
        loads: loads besides the actuators and this one; `robot.loads` if None.
        share: share of the lifted mass that counts, as 0.87 for excavators by ISO 10567.

    Raises:
        InputError: a name is unknown, or the robot is nowhere within its limits.
    """
    if not 0.0 < share <= 1.0:
        raise InputError(f"share is {share:g}; expected more than 0, up to 1")
    start = robot.reference
    if u is not None:
        start = finite_vectors("u", u, robot.active, -1)
    pair = joints or moving_joints(robot, start, frame)
    points = _grid(robot, pair, start)
    flat = points.reshape(-1, len(start))
    # as in workspaces: loops closed, all joints within limits and strokes
    valid = margins_at(robot, flat).status == SampleStatus.OK
    if not valid.any():
        raise InputError(
            f"{robot.name} is nowhere within its limits while {pair[0]} and {pair[1]} move; let"
            " the others stay elsewhere"
        )
    radius, height, mass = np.full((3, len(flat)), np.nan)
    drive = np.full(len(flat), -1)
    position, lifted, limiting = _lifted(robot, flat[valid], frame, loads)
    radius[valid] = np.hypot(position[:, 0], position[:, 1])
    height[valid] = position[:, 2]
    mass[valid] = share * lifted
    drive[valid] = limiting
    shape = points.shape[:2]
    return LiftingChart(
        joints=pair,
        u=points,
        radius=radius.reshape(shape),
        height=height.reshape(shape),
        mass=mass.reshape(shape),
        limited_by=drive.reshape(shape),
        drives=robot.all_drives,
        share=share,
        frame=frame,
    )


def moving_joints(robot: LiftingRobot, u: Array, frame: str | None) -> tuple[str, str]:
    """The two active joints that move a frame most up and out, over their ranges.

    Args:
        robot: the robot.
        u: (n,) at which they are compared [rad, m].
        frame: name of the frame; the end effector if None.
    """
    state = robot.close(u)
    position = robot.forward_kinematics(state, frame).position
    outward = np.array([position[0], position[1], 0.0])
    size = float(np.linalg.norm(outward))
    outward = outward / size if size > 0.0 else np.array([1.0, 0.0, 0.0])
    upward = [0.0, 0.0, 1.0]
    jacobian = robot.jacobian(state, frame)[:3]
    velocities = np.stack([outward, upward]) @ jacobian  # (2, n) at unit rates
    ranges = np.nan_to_num(np.ptp(robot.limits, axis=1), posinf=1.0)
    travel = np.linalg.norm(velocities, axis=0) * ranges
    order = np.argsort(-travel)
    if len(order) < 2 or travel[order[1]] < STILL:
        raise InputError("a lifting chart takes two joints that move the frame up and out")
    first, second = sorted(order[:2].tolist())
    return robot.active[first], robot.active[second]


def _grid(robot: LiftingRobot, pair: tuple[str, str], u: Array) -> Array:
    """Active coordinates (c, c, n): a grid over two joints, the others as in u (n,)."""
    for name in pair:
        if name not in robot.active:
            raise InputError(f"joints: {no_such_name('active joint', name, robot.active)}")
    if pair[0] == pair[1]:
        raise InputError(f"joints: expected two different ones, got {pair[0]} twice")
    lines: list[Array] = []
    for name in pair:
        k = robot.active.index(name)
        lower, upper = robot.limits[k].tolist()
        if not np.isfinite(upper - lower):
            lower, upper = u[k] - np.pi, u[k] + np.pi
        inset = INSET * (upper - lower)
        lines.append(np.linspace(lower + inset, upper - inset, CELLS))
    points = np.tile(u, (CELLS, CELLS, 1))
    points[..., robot.active.index(pair[0])] = lines[0][:, None]
    points[..., robot.active.index(pair[1])] = lines[1][None]
    return points


def _lifted(
    robot: LiftingRobot, u: Array, frame: str | None, loads: Loads | None
) -> tuple[Array, Array, np.ndarray]:
    """What drives hold at N active coordinates (N, n).

    Returns:
        Positions (N, 3) of the frame [m], lifted masses (N,) [kg], and the indices (N,) of drives
        that limit them.
    """
    state = robot.close(u)
    still = np.zeros_like(u)
    given = robot.loads if loads is None else loads
    held = robot.inverse_dynamics(state, still, given)
    kilogram = given.with_payload(Payload(1.0), frame or robot.end_effector)
    weights = robot.inverse_dynamics(state, still, kilogram) - held
    rates = robot.drive_rates(state)
    lower, upper = bounds_of(robot.effort_ranges, robot.all_drives)
    masses: list[float] = []
    drives: list[int] = []
    for rate, weight, needed in zip(rates, weights, held, strict=True):
        image = solutions(rate.T, weight[:, None], needed, lower, upper)
        answer = largest(image, robot.all_drives)
        masses.append(max(answer.value, 0.0))
        names = answer.limited_by
        drives.append(robot.all_drives.index(names[0]) if names else -1)
    position = robot.forward_kinematics(state, frame).position
    return position, np.array(masses), np.array(drives)
