"""Inverse kinematics of a robot: the target is checked, the solver run, the outcome put into words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..description.model import Array
from ..errors import InputError, StateError
from ..inputs import vectors
from ..state import ClosedState, ClosureStatus
from .inverse import MAX_ITERATIONS, STARTS, Descent, IKStatus, Mask, Task, descend, distinct, spread, unwound
from .pose import Pose, checked_pose

if TYPE_CHECKING:
    from ..robot import Robot

NEAREST = 25  # iterations towards a pose known to be out of reach, for the nearest one
SOLVED = 1e-9  # residual [m] below which a target counts as reached
EDGE = 1e-7  # share of the range in which a loop closes that is kept clear at both ends
FARTHEST = 1e100  # [m] squares of distances stay far from the end of the range of numbers
AT_TOGGLE = 2e-3  # distance to a singularity, and to the target in lengths: from there on EDGE hides what is left
TOLD = 1e-6  # [m or rad] what is left below it is told as nothing
SAME = 1e-6  # solutions closer than this in every coordinate are one


@dataclass(frozen=True, eq=False)
class IKResult:
    """Outcome of inverse kinematics.

    Attributes:
        u: (n,) active coordinates; with another status than SOLVED the nearest found, for inspection only.
        status, message: why the solver stopped.
        residual: what the solver makes small [m]: the root of the sum of the squares of `position_error` and of
            `angle_error` times the robot's reach at the start.
        position_error, angle_error: what remains to the target, in the coordinates that count: a distance [m] and an
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


class Remainder(NamedTuple):
    """What is left to a target: a distance [m] and an angle [rad], NaN where the target asks for none."""

    position: float
    angle: float

    def __str__(self) -> str:
        position, angle = (value if value > TOLD else 0.0 for value in self)
        parts = [] if np.isnan(self.position) else [f"{position:.3g} m"]
        parts += [] if np.isnan(self.angle) else [f"{angle:.3g} rad ({np.degrees(angle):.3g} deg)"]
        return " and ".join(parts)


def solve_inverse_kinematics(
    robot: Robot,
    target: ArrayLike | Pose,
    seed: ArrayLike | None,
    all_solutions: bool,
    mask: Sequence[bool] | None,
    near: ClosedState | None = None,
) -> IKResult:
    """See `Robot.inverse_kinematics`."""
    position, rotation, rows = _target(target, mask)
    _check_near(robot, near)
    own = robot.reference if near is None else near.u
    start = own if seed is None else vectors("seed", seed, robot.active, -1)
    length = max(float(np.linalg.norm(robot.forward_kinematics(_close(robot, own, near)).position)), 1e-3)
    terms = partial(robot_terms, robot) if near is None else partial(_terms_near, robot, near)
    task = Task(terms, position, rotation, rows, length, *_inside(robot, robot.limits))
    whole = _has_closed_form(robot, task)
    descent = _closed_form(robot, task, start, near)
    if descent is None or not _solved(descent).any():
        descent = descend(task, start[None], SOLVED * 1e-3, NEAREST if whole else MAX_ITERATIONS)
    if not whole and (all_solutions or not _solved(descent).any()):
        descent = _joined(descent, descend(task, _starts(robot, task, start), SOLVED * 1e-3))
    order = np.argsort(np.where(_solved(descent), np.linalg.norm(descent.u - start, axis=-1), 1e9 + descent.residual))
    revolute = _revolute(robot)
    ends = np.array([unwound(u, start, revolute, *robot.limits.T) for u in descent.u[order]])
    found = distinct(ends[: int(_solved(descent).sum())], revolute, SAME)
    best = int(order[0])
    left = _remainder(task, descent.u[best])
    verdict = (IKStatus.SOLVED, "reached") if found else _failure(robot, task, descent, best, near, left)
    state = _closed(robot, ends[0], near)
    return IKResult(
        u=ends[0],
        status=verdict[0],
        residual=float(descent.residual[best]),
        branch={} if state is None else state.branch,
        state=state,
        solutions=tuple(found if all_solutions else found[:1]),
        message=verdict[1],
        redundant=_redundant(robot, task, ends[0]),
        iterations=descent.iterations,
        position_error=left.position,
        angle_error=left.angle,
    )


def _remainder(task: Task, u: Array) -> Remainder:
    """What is left at u (n,), in the coordinates of the task."""
    error, _, good = task.error(u[None])
    turns = np.array(task.rows) > 2

    def size(part: Array) -> float:
        return float(np.linalg.norm(part)) if part.size and good[0] else np.nan

    return Remainder(size(error[0, ~turns]), size(error[0, turns]) / task.length)


def _closed_form(robot: Robot, task: Task, start: Array, near: ClosedState | None) -> Descent | None:
    """Solutions by the coordinates of the platform, where the end effector has such; None where it has not."""
    chain = robot.pose_chain
    if chain is None or task.rows not in ((0, 1, 2), tuple(range(6))):
        return None
    near = _closed(robot, start, near)
    if near is None:
        return None
    found = []
    for values in chain.solve(task.position, task.rotation if len(task.rows) == 6 else None, near.s):
        try:
            state = robot.close_given({robot.coordinates[k]: value for k, value in values.items()}, near=near)
        except (InputError, StateError):
            continue
        if state.branch == near.branch and (task.lower <= state.u).all() and (state.u <= task.upper).all():
            found.append(state.u)
    if not found:
        return None
    u = np.array(found)
    error, _, good = task.error(u)
    residual = np.where(good, np.linalg.norm(error, axis=-1), np.inf)
    return Descent(u, residual, np.ones(len(u), dtype=bool), 0)


def _inside(robot: Robot, limits: Array) -> tuple[Array, Array]:
    """Lower and upper limits; a little drawn in where a loop ends, which is singular there."""
    ends = robot.closing_range
    width = np.where(np.isfinite(ends).all(axis=1), ends[:, 1] - ends[:, 0], 0.0)
    return np.maximum(limits[:, 0], ends[:, 0] + EDGE * width), np.minimum(limits[:, 1], ends[:, 1] - EDGE * width)


def _revolute(robot: Robot) -> Mask:
    return np.array([robot.joint_types[name] == "revolute" for name in robot.active])


def _starts(robot: Robot, task: Task, start: Array) -> Array:
    """Starts over the limits; coordinates that the task does not see at any of them stay at the seed."""
    starts = spread(task.lower, task.upper, _revolute(robot).tolist(), STARTS)
    _, jacobian, good = task.error(starts)
    size = np.abs(jacobian[good]).max(axis=(0, 1), initial=0.0)
    idle = size < 1e-12 * max(size.max(), 1e-300)
    starts[:, idle] = start[idle]
    return starts


def robot_terms(robot: Robot, u: Array) -> tuple[Array, Array, Array, Array]:
    """Position, rotation, Jacobian and status of many states, NaN rows where a loop does not close."""
    position, rotation, jacobian = robot.kernels.pose_and_jacobian(u, check=False)
    return position, rotation, jacobian, np.isnan(position[:, 0])


def _terms_near(robot: Robot, near: ClosedState, u: Array) -> tuple[Array, Array, Array, Array]:
    """The same on the assembly modes of a closed state."""
    state = _close(robot, u, near, check=False)
    pose = robot.forward_kinematics(state)
    return pose.position, pose.rotation, robot.jacobian(state), np.asarray(state.status)


def _target(target: ArrayLike | Pose, mask: Sequence[bool] | None) -> tuple[Array, Array, tuple[int, ...]]:
    """Position, rotation, and which of the six coordinates count."""
    if isinstance(target, Pose):
        pose, rows = checked_pose(target), tuple(range(6))
    else:
        position = vectors("target", target, ("x", "y", "z"))
        if position.ndim != 1:
            raise InputError(f"the target has shape {position.shape}; expected one position (3,) or a Pose")
        pose, rows = Pose(position, np.eye(3)), (0, 1, 2)
    if mask is not None:
        if len(mask) != 6 or not any(mask):
            raise InputError("mask: expected six booleans for x, y, z and rotation about x, y, z, at least one True")
        rows = tuple(k for k in range(6) if mask[k])
        if max(rows) > 2 and not isinstance(target, Pose):
            raise InputError("mask: a rotation counts, but the target is only a position; give a Pose")
    for k in rows[:3]:
        if k < 3 and abs(pose.position[k]) > FARTHEST:
            told = f"{'xyz'[k]} is {pose.position[k]:g} m"
            raise InputError(f"target: {told}: out of reach, and too far away to compute the distance that is left")
    return pose.position, pose.rotation, rows


def _check_near(robot: Robot, near: object) -> None:
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
        raise InputError(f"near: one closed state of this robot is expected, from robot.close(u); got {got}")


def _solved(descent: Descent) -> Mask:
    solved: Mask = descent.residual < SOLVED
    return solved


def _joined(a: Descent, b: Descent) -> Descent:
    return Descent(
        np.vstack([a.u, b.u]),
        np.concatenate([a.residual, b.residual]),
        np.concatenate([a.settled, b.settled]),
        a.iterations + b.iterations,
    )


def _failure(
    robot: Robot, task: Task, descent: Descent, best: int, near: ClosedState | None, left: Remainder
) -> tuple[IKStatus, str]:
    """Which of the reasons it was."""
    residual = float(descent.residual[best])
    asked = len(task.rows)
    few = ""
    if len(robot.active) < asked:
        joints = "joint" if len(robot.active) == 1 else "joints"
        few = f"; {len(robot.active)} active {joints} cannot meet every target of {asked} coordinates"
    if not np.isfinite(residual):
        return IKStatus.NOT_CONVERGED, "no start closes all loops; give a seed that does"
    nearest = f"the nearest found is {left} away{few}"
    state = _closed(robot, descent.u[best], near)
    if state is not None and float(state.singularity) < AT_TOGGLE and residual < AT_TOGGLE * task.length:
        where = f"only reached where loop '{state.singular_loop}' is singular and its joints cannot be told"
        return IKStatus.SINGULAR, f"{where}; {nearest}"
    beyond = _beyond(robot, task, descent, near)
    if beyond:
        return IKStatus.LIMIT, f"only reached beyond the limits of {beyond}{few}"
    if _has_closed_form(robot, task) or descent.settled[best]:
        return IKStatus.OUT_OF_REACH, f"out of reach: {nearest}"
    return IKStatus.NOT_CONVERGED, f"stopped {left} away after {descent.iterations} iterations{few}"


def _has_closed_form(robot: Robot, task: Task) -> bool:
    """Whether the closed form finds every solution there is."""
    return robot.pose_chain is not None and task.rows == tuple(range(6))


def _beyond(robot: Robot, task: Task, descent: Descent, near: ClosedState | None) -> str:
    """The active joints that would have to leave their limits, or ""."""
    if _has_closed_form(robot, task):
        free = replace(task, lower=np.full_like(task.lower, -np.inf), upper=np.full_like(task.upper, np.inf))
        start = robot.reference if near is None else near.u
        return "" if _closed_form(robot, free, start, near) is None else "the active joints"
    lower, upper = _inside(robot, robot.closing_range)
    if np.array_equal(lower, task.lower) and np.array_equal(upper, task.upper):
        return ""
    free = replace(task, lower=lower, upper=upper)
    found = descend(free, descent.u[np.argsort(descent.residual)[:8]], SOLVED * 1e-3)
    if not _solved(found).any():
        return ""
    outside = found.u[int(np.argmin(found.residual))]
    return ", ".join(n for n, v, (a, b) in zip(robot.active, outside, robot.limits, strict=True) if not a <= v <= b)


def _closed(robot: Robot, u: Array, near: ClosedState | None) -> ClosedState | None:
    try:
        return _close(robot, u, near)
    except StateError:
        return None


def _close(robot: Robot, u: Array, near: ClosedState | None, check: bool = True) -> ClosedState:
    """Closed on the modes of `near`, or on the robot's own; loops without a closed form are followed from there."""
    if near is None or robot.follows:
        return robot.close(u, check=check, near=near)
    return robot.close(u, check=check, branch=near.branch)


def _redundant(robot: Robot, task: Task, u: Array) -> tuple[str, ...]:
    """Coordinates that can move without moving what the task asks for."""
    _, jacobian, good = task.error(u[None])
    if not good[0]:
        return ()
    _, sizes, rows = np.linalg.svd(jacobian[0])
    rank = int((sizes > 1e-9 * sizes[0]).sum())
    loose = np.abs(rows[rank:]).max(axis=0, initial=0.0) > 1e-6
    return tuple(name for name, free in zip(robot.active, loose, strict=True) if free)
