"""Remaining error to a target, and the reason why it was not reached."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array
from ..ground.units import coordinate_unit
from ..ground.wording import counted
from .farthest import farthest_reach
from .ik_descent import Descent, IKStatus, Mask, Task, distinct, unwound
from .ik_problem import SAME, IKProblem, is_revolute

# distances to a singularity, and to the target in lengths, below which EDGE hides the error
AT_TOGGLE = 2e-3
NEGLIGIBLE = 1e-6  # [m or rad] a smaller remaining error counts as zero
RESTARTS = 16  # further starts of a search for fewer coordinates
NEAREST = 8  # best ends of a search from which a search beyond the limits starts
STILL = 1e-9  # share of the largest Jacobian entry below which a coordinate does not move
AXES = ("x", "y", "z", "the rotation about x", "the rotation about y", "the rotation about z")
ALL_ROWS = tuple(range(len(AXES)))


class RemainingError(NamedTuple):
    """Remaining error to a target.

    Attributes:
        position: distance [m]; NaN if no position is selected.
        angle: angle [rad]; NaN if no rotation is selected.
    """

    position: float
    angle: float

    def __str__(self) -> str:
        # an error this small relative to a larger one is rounding
        threshold = 0.0
        if self.position > NEGLIGIBLE or self.angle > NEGLIGIBLE:
            threshold = NEGLIGIBLE
        parts = []
        if not np.isnan(self.position):
            position = self.position if self.position > threshold else 0.0
            parts.append(f"{position:.3g} m")
        if not np.isnan(self.angle):
            angle = self.angle if self.angle > threshold else 0.0
            parts.append(f"{angle:.3g} rad ({np.degrees(angle):.3g} deg)")
        return " and ".join(parts)


def remaining_error(task: Task, u: Array) -> RemainingError:
    """The remaining error at u (n,), in the selected coordinates."""
    error, _, is_closed = task.error_at(u)
    rotations = np.array(task.rows) > 2
    position, turn = error[~rotations], error[rotations]
    if not is_closed:
        return RemainingError(np.nan, np.nan)
    return RemainingError(_size(position), _size(turn) / task.length)


def _size(error: Array) -> float:
    """The norm; NaN of an empty vector."""
    if not error.size:
        return np.nan
    return float(np.linalg.norm(error))


def explain_failure(
    problem: IKProblem, descent: Descent, best: int, remaining: RemainingError
) -> tuple[IKStatus, str]:
    """Explain why a target was not reached.

    Args:
        problem: robot and target.
        descent: ends of the search.
        best: index of the end nearest to the target.
        remaining: the remaining error there.

    Returns:
        The status, and the reason as text.
    """
    u, residual = descent.u[best], float(descent.residual[best])
    if not np.isfinite(residual):
        return IKStatus.NOT_CONVERGED, "no start closes all loops; give a seed that does"
    nearest = f"the nearest found is {remaining} away"
    loop = _toggling_loop(problem, u, residual)
    if loop is not None:
        place = f"reached only where loop '{loop}' is singular and its joints are undetermined"
        return IKStatus.SINGULAR, f"{place}; {nearest}"
    outside = _solution_beyond_limits(problem, descent)
    if outside is not None:
        joints = _exceeded_limits(problem, outside)
        return (
            IKStatus.LIMIT,
            f"reached only beyond the limits of {joints}; {nearest} within them",
        )
    moving = _moving_rows(problem)
    unmoved = [row for row in _open_rows(problem.task, u) if row not in moving]
    cause = _cause(problem, descent, moving, unmoved)
    if problem.is_exhaustive or _is_too_far(problem) or unmoved:
        return IKStatus.OUT_OF_REACH, f"out of reach: {nearest}{cause}"
    if descent.settled[best]:
        return IKStatus.NOT_FOUND, f"no solution was found, which is no proof: {nearest}{cause}"
    stopped = f"stopped {remaining} away after {descent.iterations} iterations"
    return IKStatus.NOT_CONVERGED, f"{stopped}{cause}"


# -- singularities


def _toggling_loop(
    problem: IKProblem,
    u: Array,
    residual: float,
) -> str | None:
    """The loop that is singular at u, if u is almost at the target."""
    state = problem.closed_at(u)
    if state is None or residual >= AT_TOGGLE * problem.task.length:
        return None
    if float(state.singularity) >= AT_TOGGLE:
        return None
    return str(state.singular_loop)


# -- limits


def _solution_beyond_limits(problem: IKProblem, descent: Descent) -> Array | None:
    """Active coordinates (n,) beyond limits that reach the target, or None.

    The solution with the fewest coordinates beyond limits is taken, then the nearest to them.
    """
    revolute = is_revolute(problem.robot)
    lower, upper = problem.robot.limits.T
    ends = _ends_beyond_limits(problem, descent, revolute)
    if ends is None:
        return None
    solved = problem.solved(ends)
    # a platform with fewer freedoms reaches the pose only as far as possible
    if not solved.any():
        return None
    middle = 0.5 * (lower + upper)
    wound = [_wound(u, middle, revolute) for u in ends.u[solved]]
    solutions = np.array(wound)
    below = np.maximum(lower - solutions, 0.0)
    above = np.maximum(solutions - upper, 0.0)
    excess = below + above
    exceeded = (excess > 0.0).sum(axis=1)
    for k in np.lexsort([excess.sum(axis=1), exceeded]):
        if exceeded[k]:
            return np.asarray(solutions[k])
    return None


def _ends_beyond_limits(
    problem: IKProblem,
    descent: Descent,
    revolute: Mask,
) -> Descent | None:
    """Ends of a search without joint limits; None if only loops limit the joints."""
    if problem.is_exhaustive:
        n = len(problem.robot.active)
        unlimited = np.tile([-np.inf, np.inf], (n, 1))
        return problem.with_limits(unlimited).closed_form()
    wider = problem.with_limits(problem.robot.closing_range)
    same_lower = np.array_equal(wider.task.lower, problem.task.lower)
    if same_lower and np.array_equal(wider.task.upper, problem.task.upper):
        return None
    order = np.argsort(descent.residual)
    nearest = distinct(descent.u[order[:NEAREST]], revolute, SAME)
    starts = np.vstack([nearest, wider.starts[:RESTARTS]])
    return wider.descend(starts)


def _wound(u: Array, middle: Array, revolute: Mask) -> Array:
    """u with angles moved by whole turns to be nearest to the middle of their limits."""
    unlimited = np.full_like(u, np.inf)
    near = np.where(np.isfinite(middle), middle, 0.0)
    return unwound(u, near, revolute, -unlimited, unlimited)


def _exceeded_limits(problem: IKProblem, u: Array) -> str:
    """Text on the coordinates beyond limits, such as 'lift: 1.2 rad, limit 0.9 rad'."""
    robot = problem.robot
    joints = []
    for k, name in enumerate(robot.active):
        value, (lower, upper) = u[k], robot.limits[k]
        if lower <= value <= upper:
            continue
        limit = lower if value < lower else upper
        unit = coordinate_unit(robot.joint_types[name])
        joints.append(f"{name} ({value:.4g} {unit}, limit {limit:.4g} {unit})")
    return ", ".join(joints)


# -- unreachable targets


def _cause(
    problem: IKProblem, descent: Descent, moving: tuple[int, ...], unmoved: Sequence[int]
) -> str:
    """Text on the coordinates that cannot be reached, after a semicolon; or empty.

    Args:
        problem: robot and target.
        descent: ends of the search.
        moving: indices of the selected coordinates that move with the active joints.
        unmoved: indices of those that are not reached, and that no active joint moves.
    """
    if unmoved:
        axes = " or ".join(AXES[row] for row in unmoved)
        return f"; no active joint moves {axes}{_outcome_of_rows(problem, descent, moving)}"
    shortage = ""
    joints = len(problem.robot.active)
    if joints < len(moving):
        count = counted(joints, "active joint")
        shortage = f"; {count} cannot meet every target of {len(moving)} coordinates"
    rows = problem.task.rows
    position_rows = tuple(row for row in rows if row < 3)
    if not position_rows or len(position_rows) == len(rows):
        return shortage
    reached, remaining = _solve_rows(problem, descent, position_rows)
    if reached:
        return f"; the position alone can be reached{shortage}"
    return f"; the position alone stays {remaining} away too"


def _is_too_far(problem: IKProblem) -> bool:
    """Whether the target position is beyond the reach of the stretched links."""
    rows = [row for row in problem.task.rows if row < 3]
    distance = _size(problem.task.position[rows]) if rows else 0.0
    return distance > farthest_reach(problem.robot) * (1.0 + NEGLIGIBLE)


def _outcome_of_rows(
    problem: IKProblem,
    descent: Descent,
    rows: tuple[int, ...],
) -> str:
    """Text on the result of a search for some of the coordinates."""
    if not rows:
        return ""
    reached, remaining = _solve_rows(problem, descent, rows)
    if reached:
        return ": the rest is reached"
    return f": of the rest {remaining} are left"


def _solve_rows(
    problem: IKProblem, descent: Descent, rows: tuple[int, ...]
) -> tuple[bool, RemainingError]:
    """Whether a search for some coordinates reaches them, and the remaining error.

    It starts at the ends of the full search, and at some further starts.
    """
    smaller = problem.with_rows(rows)
    starts = smaller.starts
    if len(descent.u) >= len(starts):
        starts = starts[:RESTARTS]
    ends = smaller.descend(np.vstack([descent.u, starts]))
    nearest = ends.u[int(np.argmin(ends.residual))]
    reached = bool(smaller.solved(ends).any())
    return reached, remaining_error(smaller.task, nearest)


def _moving_rows(problem: IKProblem) -> tuple[int, ...]:
    """Indices of the selected coordinates that change with the active joints within limits."""
    # relative to all six: alone, rounding of one would count as motion
    every = problem.with_rows(ALL_ROWS)
    _, jacobian, closed = every.task.error(every.starts)
    entries = np.abs(jacobian[closed])
    sizes = entries.max(axis=(0, 2), initial=0.0)
    threshold = STILL * sizes.max()
    return tuple(row for row in problem.task.rows if sizes[row] > threshold)


def _open_rows(task: Task, u: Array) -> list[int]:
    """Indices of the selected coordinates that are not reached at u (n,)."""
    errors, _, _ = task.error_at(u)
    threshold = NEGLIGIBLE * max(task.length, 1.0)
    is_open = np.abs(errors) > threshold
    return [row for k, row in enumerate(task.rows) if is_open[k]]
