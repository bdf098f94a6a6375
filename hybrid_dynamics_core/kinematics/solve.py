"""Inverse kinematics of a robot: the target is checked, the solver run, the outcome put into words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..description.model import Array
from ..errors import InputError, StateError
from ..inputs import vectors
from .inverse import STARTS, Descent, IKStatus, Task, descend, distinct, spread, unwound
from .pose import Pose, checked_pose

if TYPE_CHECKING:
    from ..robot import Robot
    from ..state import ClosedState

SOLVED = 1e-9  # residual [m] below which a target counts as reached
SAME = 1e-6  # solutions closer than this in every coordinate are one


@dataclass(frozen=True, eq=False)
class IKResult:
    """Outcome of inverse kinematics.

    Attributes:
        u: (n,) active coordinates; with another status than SOLVED the nearest found, for inspection only.
        status, message: why the solver stopped.
        residual: distance to the target [m]; an angle counts with the robot's reach at the start.
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


def solve_inverse_kinematics(
    robot: Robot, target: ArrayLike | Pose, seed: ArrayLike | None, all_solutions: bool
) -> IKResult:
    """See `Robot.inverse_kinematics`."""
    position, rotation = _target(target)
    start = robot.reference if seed is None else vectors("seed", seed, robot.active, -1)
    lower, upper = robot.limits.T
    revolute = np.array([robot.joint_types[name] == "revolute" for name in robot.active])
    length = max(float(np.linalg.norm(robot.forward_kinematics(robot.close(robot.reference)).position)), 1e-3)
    task = Task(partial(robot_terms, robot), position, rotation, length, lower, upper)
    inner = np.nextafter(upper, lower)
    descent = descend(task, np.clip(start, np.nextafter(lower, upper), inner)[None], SOLVED * 1e-3)
    if all_solutions or not _solved(descent).any():
        starts = np.vstack([start, spread(lower, upper, revolute.tolist(), STARTS)])
        descent = _joined(descent, descend(task, starts, SOLVED * 1e-3))
    order = np.argsort(np.where(_solved(descent), np.linalg.norm(descent.u - start, axis=-1), 1e9 + descent.residual))
    ends = np.array([unwound(u, start, revolute, lower, upper) for u in descent.u[order]])
    found = distinct(ends[: int(_solved(descent).sum())], revolute, SAME)
    best = int(order[0])
    return _result(robot, task, descent, best, ends[0], found if all_solutions else found[:1])


def robot_terms(robot: Robot, u: Array) -> tuple[Array, Array, Array, Array]:
    """Position, rotation, Jacobian and status of many states, NaN rows where a loop does not close."""
    state = robot.close(u, check=False)
    pose = robot.forward_kinematics(state)
    return pose.position, pose.rotation, robot.jacobian(state), np.asarray(state.status)


def _target(target: ArrayLike | Pose) -> tuple[Array, Array | None]:
    if isinstance(target, Pose):
        pose = checked_pose(target)
        return pose.position, pose.rotation
    position = vectors("target", target, ("x", "y", "z"))
    if position.ndim != 1:
        raise InputError(f"the target has shape {position.shape}; expected one position (3,) or a Pose")
    return position, None


def _solved(descent: Descent) -> Array:
    solved: Array = descent.closes & (descent.residual < SOLVED)
    return solved


def _joined(a: Descent, b: Descent) -> Descent:
    return Descent(
        np.vstack([a.u, b.u]),
        np.concatenate([a.residual, b.residual]),
        np.concatenate([a.at_limit, b.at_limit]),
        np.concatenate([a.closes, b.closes]),
        a.iterations + b.iterations,
    )


def _result(robot: Robot, task: Task, descent: Descent, best: int, u: Array, found: list[Array]) -> IKResult:
    residual = float(descent.residual[best])
    try:
        state = robot.close(u)
    except StateError:
        state = None
    status, message = _verdict(robot, task, descent, best, bool(found))
    return IKResult(
        u=u,
        status=status,
        residual=residual,
        branch={} if state is None else state.branch,
        state=state,
        solutions=tuple(found),
        message=message,
        redundant=_redundant(robot, task, u),
        iterations=descent.iterations,
    )


def _verdict(robot: Robot, task: Task, descent: Descent, best: int, solved: bool) -> tuple[IKStatus, str]:
    residual = float(descent.residual[best])
    if solved:
        return IKStatus.SOLVED, f"reached to {residual:.1e} m in {descent.iterations} iterations"
    if not np.isfinite(residual):
        return IKStatus.NOT_CONVERGED, "no start closes all loops; give a seed that does"
    free = 6 if task.rotation is not None else 3
    few = (
        f"; {len(robot.active)} active joints cannot reach every one of {free} target coordinates"
        if len(robot.active) < free
        else ""
    )
    if descent.at_limit[best]:
        at = [
            n
            for n, v, low, up in zip(robot.active, descent.u[best], *robot.limits.T, strict=True)
            if v <= low or v >= up
        ]
        return IKStatus.LIMIT, f"{', '.join(at)} at the end of the range, {residual:.3g} m short of the target{few}"
    error, jacobian, _ = task.error(descent.u[best][None])
    slope = np.linalg.norm(jacobian[0].T @ error[0]) / max(residual * np.linalg.norm(jacobian[0]), 1e-300)
    if slope < 1e-4:
        return (
            IKStatus.OUT_OF_REACH,
            f"the target is out of reach: the nearest pose found is {residual:.3g} m away{few}",
        )
    return (
        IKStatus.NOT_CONVERGED,
        f"stopped {residual:.3g} m from the target after {descent.iterations} iterations{few}",
    )


def _redundant(robot: Robot, task: Task, u: Array) -> tuple[str, ...]:
    """Coordinates that can move without moving what the task asks for."""
    _, jacobian, good = task.error(u[None])
    if not good[0]:
        return ()
    _, sizes, rows = np.linalg.svd(jacobian[0])
    rank = int((sizes > 1e-9 * sizes[0]).sum())
    loose = np.abs(rows[rank:]).max(axis=0, initial=0.0) > 1e-6
    return tuple(name for name, free in zip(robot.active, loose, strict=True) if free)
