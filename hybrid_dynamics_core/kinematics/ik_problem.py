"""Inverse kinematics of one robot and one target.

Solutions come in closed form where the robot has one, otherwise from starts over the limits. The
loops stay closed on their assembly modes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import InputError, StateError
from ..ground.arrays import Array
from ..ground.lazy import lazy
from .closed_kinematics import ClosedKinematics
from .ik_descent import MAX_ITERATIONS, STARTS, Descent, Mask, Task, descend, starts_within
from .pose import Pose

SOLVED = 1e-9  # residual [m] below which a target counts as reached, if nothing else is asked for
SAME = 1e-6  # solutions closer than this in every coordinate are one
EDGE = 1e-7  # share of the range in which a loop closes that is kept clear at both ends
LEAST_LENGTH = 1e-3  # [m] a radian never weighs less
POSITION_ROWS = (0, 1, 2)
POSE_ROWS = (0, 1, 2, 3, 4, 5)


@dataclass(frozen=True, eq=False)
class IKProblem:
    """A robot and a target.

    Attributes:
        robot: whose end effector is to reach the target.
        task: the target.
        start: active coordinates (n,) where the search begins [rad, m].
        near: closed state whose assembly modes are kept; the robot's modes if None.
        tolerance: residual [m] below which the target counts as reached.
    """

    robot: ClosedKinematics
    task: Task
    start: Array
    near: ClosedState | None
    tolerance: float = SOLVED

    @property
    def is_exhaustive(self) -> bool:
        """Whether the closed form finds every solution there is."""
        return self.robot.pose_chain is not None and self.task.rows == POSE_ROWS

    def closed_form(self) -> Descent | None:
        """Solutions by the coordinates of the platform.

        None where the end effector has no such coordinates, or no solution is within the limits.
        """
        task = self.task
        if self.robot.pose_chain is None or task.rows not in (POSITION_ROWS, POSE_ROWS):
            return None
        near = self.closed_at(self.start)
        if near is None:
            return None
        solutions = self._platform_solutions(near)
        if not solutions:
            return None
        u = np.array(solutions)
        error, _, closed = task.error(u)
        residual = np.where(closed, np.linalg.norm(error, axis=-1), np.inf)
        return Descent(u, residual, np.ones(len(u), dtype=bool), 0)

    def _platform_solutions(self, near: ClosedState) -> list[Array]:
        """Active coordinates (n,) of each platform pose that closes on the modes of `near`."""
        chain, task = self.robot.pose_chain, self.task
        if chain is None:
            return []
        rotation = task.rotation if self.is_exhaustive else None
        solutions = []
        for values in chain.solve(task.position, rotation, near.s):
            by_name = {self.robot.coordinates[k]: value for k, value in values.items()}
            try:
                state = self.robot.close_given(by_name, near=near)
            except (InputError, StateError):
                continue
            within_limits = (task.lower <= state.u).all() and (state.u <= task.upper).all()
            if within_limits and state.branch == near.branch:
                solutions.append(state.u)
        return solutions

    def descend(self, starts: Array, max_iterations: int = MAX_ITERATIONS) -> Descent:
        """The damped steps from each of the starts (N, n)."""
        return descend(self.task, starts, SOLVED * 1e-3, max_iterations)

    def solved(self, descent: Descent) -> Mask:
        """Which of the starts reached the target (N,)."""
        reached: Mask = descent.residual < self.tolerance
        return reached

    @lazy
    def starts(self) -> Array:
        """Starts (N, n) over the limits.

        Coordinates that the task sees at none of them stay at the start. Where one rotation counts,
        all three do here: turning about z moves where a turn about y goes.
        """
        task = self.task
        if max(task.rows) >= 3:
            task = replace(task, rows=tuple(sorted({*task.rows, 3, 4, 5})))
        starts = starts_within(task.lower, task.upper, is_revolute(self.robot).tolist(), STARTS)
        _, jacobian, closed = task.error(starts)
        size = np.abs(jacobian[closed]).max(axis=(0, 1), initial=0.0)
        idle = size < 1e-12 * max(size.max(), 1e-300)
        starts[:, idle] = self.start[idle]
        return starts

    def with_limits(self, limits: Array) -> IKProblem:
        """The same problem within other limits (n, 2) [rad, m]."""
        lower, upper = inner_limits(self.robot, limits)
        return replace(self, task=replace(self.task, lower=lower, upper=upper))

    def with_rows(self, rows: tuple[int, ...]) -> IKProblem:
        """The same problem where only these of the six coordinates count."""
        return replace(self, task=replace(self.task, rows=rows))

    def closed_at(self, u: Array) -> ClosedState | None:
        """The closed state at u (n,); None where there is none."""
        try:
            return close(self.robot, u, self.near)
        except StateError:
            return None


def build_problem(
    robot: ClosedKinematics,
    target: Pose,
    rows: tuple[int, ...],
    seed: Array | None,
    near: ClosedState | None,
    tolerance: float = SOLVED,
) -> IKProblem:
    """The problem within the robot's limits.

    Args:
        robot: whose end effector is to reach the target.
        target: pose in the base frame.
        rows: which of the six coordinates of the target count.
        seed: active coordinates (n,) to start from; those of `near` or the reference if None.
        near: closed state whose assembly modes are kept; the robot's modes if None.
        tolerance: residual [m] below which the target counts as reached.
    """
    start = robot.reference if near is None else near.u
    pose = robot.forward_kinematics(close(robot, start, near))
    length = max(float(np.linalg.norm(pose.position)), LEAST_LENGTH)
    terms = partial(_terms, robot) if near is None else partial(_terms_near, robot, near)
    lower, upper = inner_limits(robot, robot.limits)
    task = Task(terms, target.position, target.rotation, rows, length, lower, upper)
    return IKProblem(robot, task, start if seed is None else seed, near, tolerance)


def close(
    robot: ClosedKinematics, u: Array, near: ClosedState | None, check: bool = True
) -> ClosedState:
    """Close on the modes of `near`, or on the robot's if None."""
    if near is None or robot.follows:
        return robot.close(u, check=check, near=near)
    return robot.close(u, check=check, branch=near.branch)


def inner_limits(robot: ClosedKinematics, limits: Array) -> tuple[Array, Array]:
    """Lower and upper limits (n,) each, drawn in a little where a loop ends and is singular."""
    first, last = robot.closing_range.T
    finite = np.isfinite(robot.closing_range).all(axis=1)
    margin = EDGE * np.where(finite, last - first, 0.0)
    return np.maximum(limits[:, 0], first + margin), np.minimum(limits[:, 1], last - margin)


def is_revolute(robot: ClosedKinematics) -> Mask:
    """Which of the active coordinates are angles (n,)."""
    return np.array([robot.joint_types[name] == "revolute" for name in robot.active])


def join_descents(descents: Sequence[Descent]) -> Descent:
    """The ends of several descents as one."""
    return Descent(
        np.vstack([descent.u for descent in descents]),
        np.concatenate([descent.residual for descent in descents]),
        np.concatenate([descent.settled for descent in descents]),
        sum(descent.iterations for descent in descents),
    )


def _terms(robot: ClosedKinematics, u: Array) -> tuple[Array, Array, Array, Array]:
    """Position, rotation, Jacobian and status of a batch; rows that do not close are NaN."""
    position, rotation, jacobian = robot.kernels.pose_and_jacobian(u, check=False)
    return position, rotation, jacobian, np.isnan(position[:, 0])


def _terms_near(
    robot: ClosedKinematics, near: ClosedState, u: Array
) -> tuple[Array, Array, Array, Array]:
    """The same on the assembly modes of a closed state."""
    state = close(robot, u, near, check=False)
    pose = robot.forward_kinematics(state)
    return pose.position, pose.rotation, robot.jacobian(state), np.asarray(state.status)
