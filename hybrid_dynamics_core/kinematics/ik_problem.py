"""Inverse kinematics of one robot and one target.

Solutions are computed in closed form if the robot has one, otherwise from starts over the limits.
The loops stay closed on their assembly modes.
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
from .ik_descent import MAX_ITERATIONS, STARTS, Descent, Mask, Task, Terms, descend, starts_within
from .ik_one_start import descend_from_one
from .pose import Pose

SOLVED = 1e-9  # [m] default residual below which a target counts as reached
CONVERGED = 1e-3 * SOLVED  # [m] residual at which a descent ends
ALL_STARTS = 384  # number of starts, further ones included, after a search from `STARTS` failed
ALL_SLOW_STARTS = 2 * STARTS  # the same for robots that are followed, which takes longer
SAME = 1e-6  # solutions closer than this in every coordinate are the same
EDGE = 1e-7  # margin at both ends of a closing range, as a share of the range
LEAST_LENGTH = 1e-3  # [m] least weight of a radian
POSITION_ROWS = (0, 1, 2)
POSE_ROWS = (0, 1, 2, 3, 4, 5)


@dataclass(frozen=True, eq=False)
class IKProblem:
    """A robot and a target.

    Attributes:
        robot: robot whose end effector must reach the target.
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
        """Whether the closed form finds every solution."""
        return self.robot.pose_chain is not None and self.task.rows == POSE_ROWS

    def closed_form(self) -> Descent | None:
        """Solutions by the coordinates of the platform.

        None if the end effector has no such coordinates, or no solution is within the limits.
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
        sizes = np.linalg.norm(error, axis=-1)
        residual = np.where(closed, sizes, np.inf)
        settled = np.ones(len(u), dtype=bool)
        return Descent(u, residual, settled, iterations=0)

    def _platform_solutions(self, near: ClosedState) -> list[Array]:
        """Active coordinates (n,) of each platform pose that closes on the modes of `near`."""
        chain, task = self.robot.pose_chain, self.task
        if chain is None:
            return []
        rotation = task.rotation if self.is_exhaustive else None
        solutions = []
        for values in chain.solve(task.position, rotation, near.s):
            names = [self.robot.coordinates[k] for k in values]
            by_name = dict(zip(names, values.values(), strict=True))
            try:
                state = self.robot.close_given(by_name, near=near)
            except (InputError, StateError):
                continue
            within_limits = (task.lower <= state.u) & (state.u <= task.upper)
            if within_limits.all() and state.branch == near.branch:
                solutions.append(state.u)
        return solutions

    def descend(self, starts: Array, max_iterations: int = MAX_ITERATIONS) -> Descent:
        """Descend from each of the starts (N, n)."""
        if len(starts) == 1:
            return descend_from_one(self.task, starts[0], CONVERGED, max_iterations)
        return descend(self.task, starts, CONVERGED, max_iterations)

    def solved(self, descent: Descent) -> Mask:
        """Mask (N,) of starts that reached the target."""
        reached: Mask = descent.residual < self.tolerance
        return reached

    @lazy
    def starts(self) -> Array:
        """Starts (N, n) over the limits.

        Coordinates without effect on the task keep their value at `start`. If one rotation is
        selected, all three count here, since a rotation about z changes the axis of the next one
        about y.
        """
        task = self.task
        if max(task.rows) >= 3:
            rows = sorted({*task.rows, 3, 4, 5})
            task = replace(task, rows=tuple(rows))
        starts = self._starts_between(0, STARTS)
        _, jacobian, closed = task.error(starts)
        entries = np.abs(jacobian[closed])
        sizes = entries.max(axis=(0, 1), initial=0.0)
        idle = sizes < 1e-12 * max(sizes.max(), 1e-300)
        starts[:, idle] = self.start[idle]
        return starts

    @property
    def further_starts(self) -> Array:
        """Further starts (N, n) over the limits, after all others failed."""
        last = ALL_SLOW_STARTS if self.robot.follows else ALL_STARTS
        return self._starts_between(STARTS, last)

    def _starts_between(self, first: int, last: int) -> Array:
        revolute = is_revolute(self.robot).tolist()
        return starts_within(self.task.lower, self.task.upper, revolute, last)[first:]

    def with_limits(self, limits: Array) -> IKProblem:
        """The same problem within other limits (n, 2) [rad, m]."""
        lower, upper = inner_limits(self.robot, limits)
        task = replace(self.task, lower=lower, upper=upper)
        return replace(self, task=task)

    def with_rows(self, rows: tuple[int, ...]) -> IKProblem:
        """The same problem with other rows of the six coordinates selected."""
        task = replace(self.task, rows=rows)
        return replace(self, task=task)

    def closed_at(self, u: Array) -> ClosedState | None:
        """The closed state at u (n,); None if it does not close."""
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
    """Build the problem, within the robot's limits.

    Args:
        robot: robot whose end effector must reach the target.
        target: pose in the base frame.
        rows: indices of the selected coordinates of the target, of six.
        seed: active coordinates (n,) to start from; those of `near` or the reference if None.
        near: closed state whose assembly modes are kept; the robot's modes if None.
        tolerance: residual [m] below which the target counts as reached.
    """
    if near is None:
        start = robot.reference
        terms = partial(_terms, robot)
    else:
        start = near.u
        terms = partial(_terms_near, robot, near)
    pose = robot.forward_kinematics(close(robot, start, near))
    distance = float(np.linalg.norm(pose.position))
    lower, upper = inner_limits(robot, robot.limits)
    task = Task(
        solve_terms=terms,
        position=target.position,
        rotation=target.rotation,
        rows=rows,
        length=max(distance, LEAST_LENGTH),
        lower=lower,
        upper=upper,
    )
    if seed is not None:
        start = seed
    return IKProblem(robot, task, start, near, tolerance)


def close(
    robot: ClosedKinematics, u: Array, near: ClosedState | None, check: bool = True
) -> ClosedState:
    """Close on the modes of `near`; on those of the robot if None."""
    if near is None or robot.follows:
        return robot.close(u, check=check, near=near)
    return robot.close(u, check=check, branch=near.branch)


def inner_limits(robot: ClosedKinematics, limits: Array) -> tuple[Array, Array]:
    """Lower and upper limits (n,) each, with a margin at singular ends of loops."""
    first, last = robot.closing_range.T
    finite = np.isfinite(robot.closing_range).all(axis=1)
    margin = EDGE * np.where(finite, last - first, 0.0)
    lower = np.maximum(limits[:, 0], first + margin)
    upper = np.minimum(limits[:, 1], last - margin)
    return lower, upper


def is_revolute(robot: ClosedKinematics) -> Mask:
    """Mask (n,) of active coordinates that are angles."""
    revolute = [robot.joint_types[name] == "revolute" for name in robot.active]
    return np.array(revolute)


def join_descents(descents: Sequence[Descent]) -> Descent:
    """Concatenate several descents."""
    return Descent(
        u=np.vstack([descent.u for descent in descents]),
        residual=np.concatenate([descent.residual for descent in descents]),
        settled=np.concatenate([descent.settled for descent in descents]),
        iterations=sum(descent.iterations for descent in descents),
    )


def _terms(robot: ClosedKinematics, u: Array) -> Terms:
    """Position, rotation, Jacobian and status; states that do not close are NaN."""
    position, rotation, jacobian = robot.kernels.pose_and_jacobian(u, check=False)
    is_open = np.isnan(position[..., 0])
    return position, rotation, jacobian, is_open


def _terms_near(robot: ClosedKinematics, near: ClosedState, u: Array) -> Terms:
    """The result of `_terms`, on the assembly modes of a closed state."""
    state = close(robot, u, near, check=False)
    pose = robot.forward_kinematics(state)
    jacobian = robot.jacobian(state)
    status = np.asarray(state.status)
    return pose.position, pose.rotation, jacobian, status
