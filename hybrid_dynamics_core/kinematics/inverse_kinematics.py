"""Inverse kinematics: checks of the target, solver, and explanation of the result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number
from ..ground.check_arrays import finite_vectors
from .closed_kinematics import ClosedKinematics
from .ik_descent import Descent, IKStatus, distinct, unwound
from .ik_failure import explain_failure, remaining_error
from .ik_nearest import polished
from .ik_problem import (
    POSE_ROWS,
    POSITION_ROWS,
    SAME,
    SOLVED,
    IKProblem,
    build_problem,
    is_revolute,
    join_descents,
)
from .pose import Pose, checked_pose

FARTHEST = 1e100  # [m] largest coordinate of a target, so that squares do not overflow
UNSOLVED = 1e9  # sort key of starts that failed, above all distances of solutions
INDEPENDENT = 1e-9  # share of the largest singular value of the Jacobian
Rows = tuple[int, ...]
LOOSE = 1e-6  # least component of a redundant coordinate in a motion without effect on the target


@dataclass(frozen=True, eq=False)
class IKResult:
    """Outcome of inverse kinematics.

    Attributes:
        u: active coordinates (n,) [rad, m]. If the status is not SOLVED, they are the nearest
            found, for inspection only.
        status: why the solver stopped.
        residual: the norm that the solver minimises [m]: root of the sum of squares of
            `position_error`, and of `angle_error` times the robot's reach at the start.
        branch: assembly mode of each loop at u, by name.
        state: closed state at u, None if u does not close.
        solutions: all distinct solutions if requested, otherwise (u,) or empty.
        message: why the solver stopped, as text.
        redundant: active coordinates that the target does not determine. They stay near the seed.
        iterations: number of iterations.
        position_error: remaining distance to the target in the selected coordinates [m]; NaN if
            none is selected, or no start closes.
        angle_error: remaining angle in the selected coordinates [rad]; NaN likewise.
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
    seed: ArrayLike | None = None,
    all_solutions: bool = False,
    mask: Sequence[bool] | None = None,
    near: ClosedState | None = None,
    tolerance: float = SOLVED,
) -> IKResult:
    """Active coordinates within the limits that bring the end effector to a target.

    Args:
        robot: the robot.
        target: position (3,) [m], or a Pose, in the base frame.
        seed: active coordinates (n,) to start from [rad, m]; those of `near` or the reference if
            None.
        all_solutions: whether to search for all solutions.
        mask: selects x, y, z and the rotation about x, y, z, in base axes; None: all that the
            target gives.
        near: one closed state whose assembly modes are kept; the robot's modes if None.
        tolerance: residual [m] below which the target counts as reached.

    Raises:
        InputError: an argument is wrong, or the target is too far away for floats.
    """
    pose, rows = _target(target, mask)
    _check_near(robot, near)
    start = None
    if seed is not None:
        start = finite_vectors("seed", seed, robot.active, -1)
    problem = build_problem(robot, pose, rows, start, near, _tolerance(tolerance))
    descent = _solve(problem, all_solutions)
    return _result(problem, descent, all_solutions)


def follow_position(
    robot: ClosedKinematics, position: ArrayLike, near: ClosedState
) -> ClosedState | None:
    """The state to which one descent from a state brings the end effector near to a position.

    There is no search from other starts, so it is quick enough for a position that moves.

    Args:
        robot: the robot.
        position: (3,) in the base frame [m].
        near: closed state of the start, whose assembly modes are kept.

    Returns:
        The closed state; None if it does not close.

    Raises:
        InputError: the position is not finite, or too far away for floats.
    """
    pose, rows = _target(position, None)
    problem = build_problem(robot, pose, rows, None, near, SOLVED)
    descent = problem.descend(problem.start[None])
    return problem.closed_at(descent.u[0])


def _solve(problem: IKProblem, all_solutions: bool) -> Descent:
    """Descend from the start; from many more if that fails or all solutions are requested."""
    descent = problem.closed_form()
    if descent is None or not problem.solved(descent).any():
        descent = problem.descend(problem.start[None])
    is_solved = problem.solved(descent).any()
    if is_solved and (problem.is_exhaustive or not all_solutions):
        return descent
    descent = join_descents([descent, problem.descend(problem.starts)])
    if problem.solved(descent).any():
        return descent
    descent = join_descents([descent, problem.descend(problem.further_starts)])
    if problem.solved(descent).any():
        return descent
    return join_descents([descent, polished(problem, descent)])


def _result(problem: IKProblem, descent: Descent, all_solutions: bool) -> IKResult:
    """The result from the best end, with its remaining error and reason."""
    robot, start = problem.robot, problem.start
    solved = problem.solved(descent)
    distances = np.linalg.norm(descent.u - start, axis=-1)
    order = np.argsort(np.where(solved, distances, UNSOLVED + descent.residual))
    revolute = is_revolute(robot)
    lower, upper = robot.limits.T
    unwinding = [unwound(u, start, revolute, lower, upper) for u in descent.u[order]]
    ends = np.array(unwinding)
    solutions = distinct(ends[: int(solved.sum())], revolute, SAME)
    best = int(order[0])
    remaining = remaining_error(problem.task, descent.u[best])
    status, message = IKStatus.SOLVED, "reached"
    if not solutions:
        status, message = explain_failure(problem, descent, best, remaining)
    state = problem.closed_at(ends[0])
    if not all_solutions:
        solutions = solutions[:1]
    return IKResult(
        u=ends[0],
        status=status,
        residual=float(descent.residual[best]),
        branch={} if state is None else state.branch,
        state=state,
        solutions=tuple(solutions),
        message=message,
        redundant=_redundant(problem, ends[0]),
        iterations=descent.iterations,
        position_error=remaining.position,
        angle_error=remaining.angle,
    )


# -- arguments


def _target(target: ArrayLike | Pose, mask: Sequence[bool] | None) -> tuple[Pose, Rows]:
    """The pose, and the indices of the selected coordinates."""
    rows: Rows
    if isinstance(target, Pose):
        pose, rows = checked_pose(target), POSE_ROWS
    else:
        pose, rows = _position_target(target), POSITION_ROWS
    if mask is not None:
        rows = _masked_rows(mask)
        if max(rows) > 2 and not isinstance(target, Pose):
            raise InputError(
                "mask: a rotation counts, but the target is only a position; give a Pose"
            )
    _check_distance(pose, rows)
    return pose, rows


def _position_target(target: ArrayLike) -> Pose:
    position = finite_vectors("target", target, ("x", "y", "z"))
    if position.ndim != 1:
        raise InputError(
            f"the target has shape {position.shape}; expected one position (3,) or a Pose"
        )
    return Pose(position, np.eye(3))


def _masked_rows(mask: Sequence[bool]) -> Rows:
    flags = np.asarray(mask, dtype=object)
    if flags.shape != (6,) or not any(flags):
        raise InputError(
            "mask: expected six booleans for x, y, z and rotation about x, y, z, at least one True"
        )
    return tuple(k for k in range(6) if mask[k])


def _check_distance(pose: Pose, rows: Sequence[int]) -> None:
    for k, axis in enumerate("xyz"):
        if k in rows and abs(pose.position[k]) > FARTHEST:
            raise InputError(
                f"target: {axis} is {pose.position[k]:g} m: out of reach, and too far away to"
                " compute the distance that is left"
            )


def _tolerance(tolerance: float) -> float:
    tolerance = real_number("tolerance", tolerance)
    if not 0.0 < tolerance < np.inf:
        raise InputError(f"tolerance: {tolerance!r}: expected a length above zero [m]")
    return float(tolerance)


def _check_near(robot: ClosedKinematics, near: object) -> None:
    if near is None:
        return
    problem = ""
    if not isinstance(near, ClosedState):
        problem = type(near).__name__
    elif not robot.owns(near):
        problem = "a state of another robot"
    elif near.u.ndim != 1:
        problem = f"a batch of {len(near.u)}"
    elif near.status != ClosureStatus.OK:
        problem = "one whose loops are not closed (its status says why)"
    if problem:
        expected = "one closed state of this robot is expected, from robot.close(u)"
        raise InputError(f"near: {expected}; got {problem}")


# -- results


def _redundant(problem: IKProblem, u: Array) -> tuple[str, ...]:
    """Names of coordinates that can move without effect on the task."""
    _, jacobian, is_closed = problem.task.error_at(u)
    if not is_closed:
        return ()
    _, sizes, motions = np.linalg.svd(jacobian)
    rank = int((sizes > INDEPENDENT * sizes[0]).sum())
    parts = np.abs(motions[rank:]).max(axis=0, initial=0.0)
    active = problem.robot.active
    return tuple(name for k, name in enumerate(active) if parts[k] > LOOSE)
