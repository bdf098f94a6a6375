"""Inverse kinematics of a robot: the target is checked, the solver run, the outcome put into words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import finite_vectors
from .closed_kinematics import ClosedKinematics
from .ik_descent import MAX_ITERATIONS, IKStatus, distinct, unwound
from .ik_failure import failure, remainder
from .ik_problem import SAME, SOLVED, Search, joined, revolute, search_for
from .pose import Pose, checked_pose

NEAREST = 25  # iterations towards a pose known to be out of reach, for the nearest one
FARTHEST = 1e100  # [m] squares of distances stay far from the end of the range of numbers


@dataclass(frozen=True, eq=False)
class IKResult:
    """Outcome of inverse kinematics.

    Attributes:
        u: (n,) active coordinates; with another status than SOLVED the nearest found, for
        inspection only.
        status, message: why the solver stopped.
        residual: what the solver makes small [m]: the root of the sum of the squares of
        `position_error` and of
            `angle_error` times the robot's reach at the start.
        position_error, angle_error: what remains to the target, in the coordinates that count: a
        distance [m] and an
            angle [rad]; NaN where none of them counts, or no start closes.
        branch, state: assembly modes and closed state at u (None if u does not close).
        solutions: all distinct solutions found if asked, otherwise (u,) or nothing.
        redundant: active coordinates that the target does not determine; they stay near the seed.
        iterations: of the solver.
    """

    u: Array
    status: IKStatus
    residual: float
    branch: Mapping[str, str]
    state: ClosedState | None
    solutions: tuple[Array, ...]
    message: str
    redundant: tuple[str, ...]
    iterations: int
    position_error: float
    angle_error: float


def solve_inverse_kinematics(  # noqa: PLR0913, PLR0917 - as the robot's method
    robot: ClosedKinematics,
    target: ArrayLike | Pose,
    seed: ArrayLike | None,
    all_solutions: bool,
    mask: Sequence[bool] | None,
    near: ClosedState | None = None,
    tolerance: float = SOLVED,
) -> IKResult:
    """See `Robot.inverse_kinematics`."""
    pose, rows = _target(target, mask)
    _check_near(robot, near)
    start = None if seed is None else finite_vectors("seed", seed, robot.active, -1)
    search = search_for(robot, pose, rows, start, near, _tolerance(tolerance))
    start = search.start
    descent = search.closed_form()
    if descent is None or not search.solved(descent).any():
        descent = search.descend(start[None], NEAREST if search.whole else MAX_ITERATIONS)
    if not search.whole and (all_solutions or not search.solved(descent).any()):
        descent = joined([descent, search.descend(search.starts)])
    order = np.argsort(
        np.where(
            search.solved(descent),
            np.linalg.norm(descent.u - start, axis=-1),
            1e9 + descent.residual,
        )
    )
    turns = revolute(robot)
    ends = np.array([unwound(u, start, turns, *robot.limits.T) for u in descent.u[order]])
    found = distinct(ends[: int(search.solved(descent).sum())], turns, SAME)
    best = int(order[0])
    left = remainder(search.task, descent.u[best])
    verdict = (IKStatus.SOLVED, "reached") if found else failure(search, descent, best, left)
    state = search.closed(ends[0])
    return IKResult(
        u=ends[0],
        status=verdict[0],
        residual=float(descent.residual[best]),
        branch={} if state is None else state.branch,
        state=state,
        solutions=tuple(found if all_solutions else found[:1]),
        message=verdict[1],
        redundant=_redundant(search, ends[0]),
        iterations=descent.iterations,
        position_error=left.position,
        angle_error=left.angle,
    )


def _target(target: ArrayLike | Pose, mask: Sequence[bool] | None) -> tuple[Pose, tuple[int, ...]]:
    """The pose, and which of the six coordinates count."""
    if isinstance(target, Pose):
        pose, rows = checked_pose(target), tuple(range(6))
    else:
        position = finite_vectors("target", target, ("x", "y", "z"))
        if position.ndim != 1:
            raise InputError(
                f"the target has shape {position.shape}; expected one position (3,) or a Pose"
            )
        pose, rows = Pose(position, np.eye(3)), (0, 1, 2)
    if mask is not None:
        if len(mask) != 6 or not any(mask):
            raise InputError(
                "mask: expected six booleans for x, y, z and rotation about x, y, z, at least one"
                " True"
            )
        rows = tuple(k for k in range(6) if mask[k])
        if max(rows) > 2 and not isinstance(target, Pose):
            raise InputError(
                "mask: a rotation counts, but the target is only a position; give a Pose"
            )
    for k in rows[:3]:
        if k < 3 and abs(pose.position[k]) > FARTHEST:
            told = f"{'xyz'[k]} is {pose.position[k]:g} m"
            raise InputError(
                f"target: {told}: out of reach, and too far away to compute the distance that is"
                " left"
            )
    return pose, rows


def _tolerance(tolerance: float) -> float:
    if not 0.0 < tolerance < np.inf:
        raise InputError(f"tolerance: {tolerance!r}: expected a length above zero [m]")
    return float(tolerance)


def _check_near(robot: ClosedKinematics, near: object) -> None:
    if near is None:
        return
    got = ""
    if not isinstance(near, ClosedState):
        got = type(near).__name__
    elif not robot.owns(near):
        got = "a state of another robot"
    elif near.u.ndim != 1:
        got = f"a batch of {len(near.u)}"
    elif near.status != ClosureStatus.OK:
        got = "one whose loops are not closed (its status says why)"
    if got:
        raise InputError(
            f"near: one closed state of this robot is expected, from robot.close(u); got {got}"
        )


def _redundant(search: Search, u: Array) -> tuple[str, ...]:
    """Coordinates that can move without moving what the task asks for."""
    _, jacobian, good = search.task.error(u[None])
    if not good[0]:
        return ()
    _, sizes, rows = np.linalg.svd(jacobian[0])
    rank = int((sizes > 1e-9 * sizes[0]).sum())
    loose = np.abs(rows[rank:]).max(axis=0, initial=0.0) > 1e-6
    return tuple(name for name, free in zip(search.robot.active, loose, strict=True) if free)
