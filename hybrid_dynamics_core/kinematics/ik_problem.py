"""The solver on a robot: closed form where it has one, starts over the limits, loops kept closed on their modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import InputError, StateError
from ..ground.arrays import Array
from .closed_kinematics import ClosedKinematics
from .ik_descent import MAX_ITERATIONS, STARTS, Descent, Mask, Task, descend, spread
from .pose import Pose

SOLVED = 1e-9  # residual [m] below which a target counts as reached, if nothing else is asked for
SAME = 1e-6  # solutions closer than this in every coordinate are one
EDGE = 1e-7  # share of the range in which a loop closes that is kept clear at both ends
_POSE = tuple(range(6))


@dataclass(frozen=True, eq=False)
class Search:
    """A robot and what is asked of it.

    Attributes: `start` (n,), where the search begins; `near`, a state whose assembly modes are kept
    (or None); `tolerance`, the residual [m] below which the target counts as reached.
    """

    robot: ClosedKinematics
    task: Task
    start: Array
    near: ClosedState | None
    tolerance: float = SOLVED

    @property
    def whole(self) -> bool:
        """Whether the closed form finds every solution there is."""
        return self.robot.pose_chain is not None and self.task.rows == _POSE

    def closed_form(self) -> Descent | None:
        """Solutions by the coordinates of the platform, where the end effector has such; None where it has not."""
        chain, task = self.robot.pose_chain, self.task
        if chain is None or task.rows not in ((0, 1, 2), _POSE):
            return None
        near = self.closed(self.start)
        if near is None:
            return None
        found = []
        for values in chain.solve(task.position, task.rotation if self.whole else None, near.s):
            try:
                named = {self.robot.coordinates[k]: value for k, value in values.items()}
                state = self.robot.close_given(named, near=near)
            except (InputError, StateError):
                continue
            if (
                state.branch == near.branch
                and (task.lower <= state.u).all()
                and (state.u <= task.upper).all()
            ):
                found.append(state.u)
        if not found:
            return None
        u = np.array(found)
        error, _, good = task.error(u)
        residual = np.where(good, np.linalg.norm(error, axis=-1), np.inf)
        return Descent(u, residual, np.ones(len(u), dtype=bool), 0)

    def descend(self, starts: Array, most: int = MAX_ITERATIONS) -> Descent:
        """The damped steps from each of the starts (N, n)."""
        return descend(self.task, starts, SOLVED * 1e-3, most)

    def solved(self, descent: Descent) -> Mask:
        """Which of the starts reached the target (N,)."""
        reached: Mask = descent.residual < self.tolerance
        return reached

    @cached_property
    def starts(self) -> Array:
        """Starts over the limits (N, n); coordinates that the task does not see at any of them stay at the start.

        Where one rotation counts, all three do here: turning about z moves where a turn about y
        goes.
        """
        rows = self.task.rows
        task = (
            self.task if max(rows) < 3 else replace(self.task, rows=tuple(sorted({*rows, 3, 4, 5})))
        )
        starts = spread(task.lower, task.upper, revolute(self.robot).tolist(), STARTS)
        _, jacobian, good = task.error(starts)
        size = np.abs(jacobian[good]).max(axis=(0, 1), initial=0.0)
        idle = size < 1e-12 * max(size.max(), 1e-300)
        starts[:, idle] = self.start[idle]
        return starts

    def within(self, limits: Array) -> Search:
        """The same search within other limits (n, 2)."""
        lower, upper = inside(self.robot, limits)
        return replace(self, task=replace(self.task, lower=lower, upper=upper))

    def counting(self, rows: tuple[int, ...]) -> Search:
        """The same search where only these of the six coordinates count."""
        return replace(self, task=replace(self.task, rows=rows))

    def closed(self, u: Array) -> ClosedState | None:
        """The closed state at u (n,); None where there is none."""
        try:
            return close(self.robot, u, self.near)
        except StateError:
            return None


def search_for(
    robot: ClosedKinematics,
    target: Pose,
    rows: tuple[int, ...],
    seed: Array | None,
    near: ClosedState | None,
    tolerance: float = SOLVED,
) -> Search:
    """A search within the robot's limits for a pose of which the coordinates of `rows` count."""
    own = robot.reference if near is None else near.u
    length = max(
        float(np.linalg.norm(robot.forward_kinematics(close(robot, own, near)).position)), 1e-3
    )
    terms = partial(_terms, robot) if near is None else partial(_terms_near, robot, near)
    task = Task(terms, target.position, target.rotation, rows, length, *inside(robot, robot.limits))
    return Search(robot, task, own if seed is None else seed, near, tolerance)


def close(
    robot: ClosedKinematics, u: Array, near: ClosedState | None, check: bool = True
) -> ClosedState:
    """Closed on the modes of `near`, or on the robot's own; loops without a closed form are followed from there."""
    if near is None or robot.follows:
        return robot.close(u, check=check, near=near)
    return robot.close(u, check=check, branch=near.branch)


def inside(robot: ClosedKinematics, limits: Array) -> tuple[Array, Array]:
    """Lower and upper limits (n,) each; a little drawn in where a loop ends, which is singular there."""
    ends = robot.closing_range
    width = np.where(np.isfinite(ends).all(axis=1), ends[:, 1] - ends[:, 0], 0.0)
    return np.maximum(limits[:, 0], ends[:, 0] + EDGE * width), np.minimum(
        limits[:, 1], ends[:, 1] - EDGE * width
    )


def revolute(robot: ClosedKinematics) -> Mask:
    """Which of the active coordinates are angles (n,)."""
    return np.array([robot.joint_types[name] == "revolute" for name in robot.active])


def joined(parts: Sequence[Descent]) -> Descent:
    """The ends of several descents as one."""
    return Descent(
        np.vstack([part.u for part in parts]),
        np.concatenate([part.residual for part in parts]),
        np.concatenate([part.settled for part in parts]),
        sum(part.iterations for part in parts),
    )


def _terms(robot: ClosedKinematics, u: Array) -> tuple[Array, Array, Array, Array]:
    """Position, rotation, Jacobian and status of many states, NaN rows where a loop does not close."""
    position, rotation, jacobian = robot.kernels.pose_and_jacobian(u, check=False)
    return position, rotation, jacobian, np.isnan(position[:, 0])


def _terms_near(
    robot: ClosedKinematics, near: ClosedState, u: Array
) -> tuple[Array, Array, Array, Array]:
    """The same on the assembly modes of a closed state."""
    state = close(robot, u, near, check=False)
    pose = robot.forward_kinematics(state)
    return pose.position, pose.rotation, robot.jacobian(state), np.asarray(state.status)
