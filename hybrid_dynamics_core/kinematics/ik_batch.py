"""Inverse kinematics of one target or a batch of independent targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array
from .closed_kinematics import ClosedKinematics
from .ik_descent import IKStatus
from .ik_problem import SOLVED, close
from .inverse_kinematics import IKResult, solve_inverse_kinematics
from .pose import Pose


@dataclass(frozen=True, eq=False)
class IKBatch(IKResult):
    """Results of inverse kinematics for N targets, with the fields of `IKResult`.

    Attributes:
        u: active coordinates (N, n) [rad, m].
        status: why the solver stopped, (N,).
        residual: (N,) [m].
        branch: assembly modes at each row.
        state: a batch of N; rows that do not close are NaN, and their `status` says why.
        solutions: those of each row.
        message: why the solver stopped, as text, for each row.
        redundant: coordinates that the target of each row does not determine.
        iterations: (N,).
        position_error: (N,) [m].
        angle_error: (N,) [rad].
        results: the outcome of each row.
    """

    # Each entry has a leading N, as in batches of states.
    status: NDArray[Any]  # type: ignore[assignment]
    residual: Array  # type: ignore[assignment]
    branch: tuple[Mapping[str, str], ...]  # type: ignore[assignment]
    state: ClosedState
    solutions: tuple[tuple[Array, ...], ...]  # type: ignore[assignment]
    message: tuple[str, ...]  # type: ignore[assignment]
    redundant: tuple[tuple[str, ...], ...]  # type: ignore[assignment]
    iterations: NDArray[np.int64]  # type: ignore[assignment]
    position_error: Array  # type: ignore[assignment]
    angle_error: Array  # type: ignore[assignment]
    results: tuple[IKResult, ...]

    @property
    def solved(self) -> NDArray[np.bool_]:
        """Mask (N,) of rows that reached their target."""
        return np.array([result.status is IKStatus.SOLVED for result in self.results])


def inverse_kinematics(  # noqa: PLR0913, PLR0917 - a method of robots
    robot: ClosedKinematics,
    target: ArrayLike | Pose,
    seed: ArrayLike | None = None,
    all_solutions: bool = False,
    mask: Sequence[bool] | None = None,
    near: ClosedState | None = None,
    tolerance: float = SOLVED,
) -> IKResult:
    """Active coordinates within `limits` that bring the end effector to a target.

    The search starts at `seed`, by default at `near` or the reference. If that fails, or if all
    solutions are requested, a fixed set of starts over the limits follows.

    Args:
        robot: the robot.
        target: position (3,) [m] or Pose in the base frame; for a batch, (N, 3) or a Pose of N.
        seed: active coordinates (n,) or (N, n) to start from [rad, m].
        all_solutions: whether to search for all solutions.
        mask: selects x, y, z and the rotation about x, y, z, in base axes; None: all that the
            target gives.
        near: closed state whose assembly modes are kept, one or one for each target; the robot's
            modes if None.
        tolerance: `residual` [m] below which the target counts as reached. If the target has more
            coordinates than the robot has freedoms, choose it above the target's rounding.

    Returns:
        The solution, with a `status` that says why the search ended. For a batch, an `IKBatch`
        with N of each; rows are independent.

    Raises:
        InputError: an argument is wrong, or the target is too far away for floats. In a batch the
            message begins with the row.
    """
    targets = _rows_of(target)
    if targets is None:
        return solve_inverse_kinematics(robot, target, seed, all_solutions, mask, near, tolerance)
    count = len(targets)
    if not count:
        raise InputError("target: the batch is empty; expected one target or more")
    seeds = _seeds(seed, count)
    states = _states_near(near, count)
    results: list[IKResult] = []
    for k in range(count):
        try:
            result = solve_inverse_kinematics(
                robot, targets[k], seeds[k], all_solutions, mask, states[k], tolerance
            )
        except InputError as error:
            raise InputError(f"row {k}: {error}") from error
        results.append(result)
    return _joined(robot, results, states)


def _rows_of(target: ArrayLike | Pose) -> list[Array | Pose] | None:
    """The targets of a batch; None for a single target or a wrong type."""
    if isinstance(target, Pose):
        position = np.asarray(target.position)
        rotation = np.asarray(target.rotation)
        if position.ndim != 2 or rotation.ndim != 3 or len(position) != len(rotation):
            return None
        return [Pose(p, R) for p, R in zip(position, rotation, strict=True)]
    if isinstance(target, (Mapping, str, bytes)):
        return None
    positions = real_array("target", target)
    if positions.ndim != 2:
        return None
    return list(positions)


def _seeds(seed: ArrayLike | None, count: int) -> list[Array | None]:
    """The seed of each row."""
    if seed is None:
        return [None] * count
    values = real_array("seed", seed)
    if values.ndim != 2:
        return [values] * count
    if len(values) != count:
        raise InputError(f"seed has {len(values)} rows; expected one, or one a target ({count})")
    return list(values)


def _states_near(near: ClosedState | None, count: int) -> list[ClosedState | None]:
    """The state `near` of each row."""
    if not isinstance(near, ClosedState) or near.u.ndim == 1:
        return [near] * count
    length = len(near.u)
    if length != count:
        raise InputError(f"near holds {length} states; expected one, or one a target ({count})")
    return [near.rows(k) for k in range(count)]


def _joined(
    robot: ClosedKinematics,
    results: Sequence[IKResult],
    states_near: Sequence[ClosedState | None],
) -> IKBatch:
    """The batch of the results of all rows, which keep the modes of states."""
    states = []
    statuses = np.empty(len(results), dtype=object)
    for k, (result, near) in enumerate(zip(results, states_near, strict=True)):
        statuses[k] = result.status
        state = result.state
        if state is None:
            state = close(robot, result.u, near, check=False)
        states.append(state)
    return IKBatch(
        u=np.array([result.u for result in results]),
        status=statuses,
        residual=np.array([result.residual for result in results]),
        branch=tuple(result.branch for result in results),
        state=ClosedState.joined(states),
        solutions=tuple(result.solutions for result in results),
        message=tuple(result.message for result in results),
        redundant=tuple(result.redundant for result in results),
        iterations=np.array([result.iterations for result in results]),
        position_error=np.array([result.position_error for result in results]),
        angle_error=np.array([result.angle_error for result in results]),
        results=tuple(results),
    )
