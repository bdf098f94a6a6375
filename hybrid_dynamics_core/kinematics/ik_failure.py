"""What is left to a target, and why it was not reached."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array
from ..ground.units import coordinate_unit
from ..ground.wording import counted
from .ik_descent import Descent, IKStatus, Mask, Task, distinct, unwound
from .ik_problem import SAME, Search, revolute

# distance to a singularity, and to the target in lengths: from there on EDGE hides what is left
AT_TOGGLE = 2e-3
TOLD = 1e-6  # [m or rad] what is left below it is told as nothing
ANEW = 16  # starts of a search for less, beside the ends of the search for all
STILL = 1e-9  # share of the largest entry of the Jacobian below which a coordinate does not move
AXES = ("x", "y", "z", "the rotation about x", "the rotation about y", "the rotation about z")


class Remainder(NamedTuple):
    """What is left to a target: a distance [m] and an angle [rad], NaN where the target asks for none."""

    position: float
    angle: float

    def __str__(self) -> str:
        least = (
            TOLD if max(value for value in self if not np.isnan(value)) > TOLD else 0.0
        )  # beside the other, rounding
        position, angle = (value if value > least else 0.0 for value in self)
        parts = [] if np.isnan(self.position) else [f"{position:.3g} m"]
        parts += [] if np.isnan(self.angle) else [f"{angle:.3g} rad ({np.degrees(angle):.3g} deg)"]
        return " and ".join(parts)


def remainder(task: Task, u: Array) -> Remainder:
    """What is left at u (n,), in the coordinates of the task."""
    error, _, good = task.error(u[None])
    turns = np.array(task.rows) > 2

    def size(part: Array) -> float:
        return float(np.linalg.norm(part)) if part.size and good[0] else np.nan

    return Remainder(size(error[0, ~turns]), size(error[0, turns]) / task.length)


def failure(search: Search, descent: Descent, best: int, left: Remainder) -> tuple[IKStatus, str]:
    """Which of the reasons it was, where the start `best` came nearest with this left."""
    u, residual, task = descent.u[best], float(descent.residual[best]), search.task
    if not np.isfinite(residual):
        return IKStatus.NOT_CONVERGED, "no start closes all loops; give a seed that does"
    nearest = f"the nearest found is {left} away"
    state = search.closed(u)
    if (
        state is not None
        and float(state.singularity) < AT_TOGGLE
        and residual < AT_TOGGLE * task.length
    ):
        where = (
            f"only reached where loop '{state.singular_loop}' is singular and its joints cannot be"
            " told"
        )
        return IKStatus.SINGULAR, f"{where}; {nearest}"
    outside = _beyond(search, descent)
    if outside is not None:
        return IKStatus.LIMIT, f"only reached beyond the limits of {_limits_left(search, outside)}"
    cause = _cause(search, descent, u)
    if search.whole or descent.settled[best]:
        return IKStatus.OUT_OF_REACH, f"out of reach: {nearest}{cause}"
    return (
        IKStatus.NOT_CONVERGED,
        f"stopped {left} away after {descent.iterations} iterations{cause}",
    )


def _cause(search: Search, descent: Descent, u: Array) -> str:
    """What of the target cannot be met, as far as it can be told; begins with a semicolon, or is empty."""
    rows, joints = search.task.rows, len(search.robot.active)
    moving = _moving(search)
    still = [
        AXES[row]
        for row, off in zip(rows, _off(search.task, u), strict=True)
        if off and row not in moving
    ]
    if still:
        reached, left = _best(search.counting(moving), descent) if moving else (False, None)
        rest = (
            ": the rest is reached"
            if reached
            else f": of the rest {left} are left"
            if moving
            else ""
        )
        return f"; no active joint moves {' or '.join(still)}{rest}"
    few = (
        f"; {counted(joints, 'active joint')} cannot meet every target of {len(moving)} coordinates"
    )
    few *= joints < len(moving)
    place = tuple(row for row in rows if row < 3)
    if not 0 < len(place) < len(rows):
        return few
    reached, left = _best(search.counting(place), descent)
    return (
        f"; the position alone can be reached{few}"
        if reached
        else f"; the position alone stays {left} away too"
    )


def _best(search: Search, descent: Descent) -> tuple[bool, Remainder]:
    """Whether a search for less reaches it, from the ends of the one for all and some anew, and what is left to it."""
    anew = search.starts if len(descent.u) < len(search.starts) else search.starts[:ANEW]
    found = search.descend(np.vstack([descent.u, anew]))
    return bool(search.solved(found).any()), remainder(
        search.task, found.u[int(np.argmin(found.residual))]
    )


def _moving(search: Search) -> tuple[int, ...]:
    """Which of the coordinates that count change with the active joints, anywhere within the limits."""
    every = search.counting(tuple(range(len(AXES))))
    _, jacobian, good = every.task.error(every.starts)
    size = np.abs(jacobian[good]).max(
        axis=(0, 2), initial=0.0
    )  # of all six: of one alone, rounding would count
    return tuple(row for row in search.task.rows if size[row] > STILL * size.max())


def _off(task: Task, u: Array) -> list[bool]:
    """By coordinate that counts: whether something is left to it at u (n,)."""
    error = task.error(u[None])[0][0]
    return [abs(left) > TOLD * max(task.length, 1.0) for left in error.tolist()]


def _beyond(search: Search, descent: Descent) -> Array | None:
    """Active coordinates (n,) beyond their limits that would reach the target; None where none were found.

    Of several those with the fewest beyond, and of these the nearest to the limits.
    """
    robot, turns = search.robot, revolute(search.robot)
    lower, upper = robot.limits.T
    if search.whole:
        wider = search.within(np.tile([-np.inf, np.inf], (len(robot.active), 1)))
        ends = wider.closed_form()
    else:
        wider = search.within(robot.closing_range)
        if np.array_equal(wider.task.lower, search.task.lower) and np.array_equal(
            wider.task.upper, search.task.upper
        ):
            return None
        nearest = distinct(descent.u[np.argsort(descent.residual)[:8]], turns, SAME)
        ends = wider.descend(np.vstack([nearest, wider.starts[:ANEW]]))
    if (
        ends is None or not search.solved(ends).any()
    ):  # a platform of fewer freedoms is placed as far as it can be
        return None
    found = np.array([_wound(u, 0.5 * (lower + upper), turns) for u in ends.u[search.solved(ends)]])
    excess = np.maximum(lower - found, 0.0) + np.maximum(found - upper, 0.0)
    beyond = (excess > 0.0).sum(axis=1)
    order = np.lexsort([excess.sum(axis=1), beyond])
    best = next((k for k in order if beyond[k]), None)
    return None if best is None else np.asarray(found[best])


def _wound(u: Array, middle: Array, turns: Mask) -> Array:
    """Angles whole turns away, as near to the middle of their limits as they can be."""
    whole = np.full_like(u, -np.inf), np.full_like(u, np.inf)
    return unwound(u, np.where(np.isfinite(middle), middle, 0.0), turns, *whole)


def _limits_left(search: Search, u: Array) -> str:
    """'lift: 1.2 rad, limit 0.9 rad' of each of the coordinates that are beyond their limits."""
    told = []
    robot = search.robot
    for name, value, (lower, upper) in zip(robot.active, u, robot.limits, strict=True):
        if not lower <= value <= upper:
            limit, kind = (
                (lower if value < lower else upper),
                coordinate_unit(robot.joint_types[name]),
            )
            told.append(f"{name} ({value:.4g} {kind}, limit {limit:.4g} {kind})")
    return ", ".join(told)
