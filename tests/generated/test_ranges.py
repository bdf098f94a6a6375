"""A range that is told is true for the whole robot: it closes just inside, and not just outside."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import assume, given

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.errors import ClosureError
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import STATES, examples

NEAR_END = 1e-6  # [rad or m]: a margin of 1e-12 and a distance of 1e-6 would count as singular


def closes(robot: Robot, u: np.ndarray) -> bool:
    """Whether all loops close; a place that is only singular counts."""
    try:
        robot.close(u)
    except ClosureError:
        return False
    except Exception:  # noqa: BLE001  singular, not open
        return True
    return True


def assert_ends(robot: Robot, u: np.ndarray, k: int, ends: tuple[float, float]) -> None:
    for end, way in zip(ends, (-1.0, 1.0), strict=True):
        if math.isfinite(end):
            inside, outside = u.copy(), u.copy()
            inside[k], outside[k] = end - way * NEAR_END, end + way * NEAR_END
            assert closes(robot, inside), (robot.active[k], end)
            assert not closes(robot, outside), (robot.active[k], end)


@examples(40)
@given(class_three(max_links=4, max_loops=4))
def test_ranges_of_the_robot_are_true_at_the_reference(case: Case) -> None:
    robot = case.robot
    for k, (lower, upper) in enumerate(robot.closing_range.tolist()):
        assert_ends(robot, np.array(robot.reference), k, (lower, upper))


@examples(60)
@given(class_three(max_links=4, max_loops=4), STATES)
def test_ranges_that_a_refusal_tells_are_true_there(case: Case, seed: int) -> None:
    robot = case.robot
    assume(not robot.follows)
    rng = np.random.default_rng(seed)
    for _ in range(6):
        u = robot.reference + rng.normal(size=case.n)
        try:
            robot.close(u)
        except ClosureError as error:
            if error.allowed is None:
                continue
            k = robot.active.index(error.coordinate)
            lower, upper = error.allowed
            assert not lower <= u[k] <= upper
            assert_ends(robot, u, k, error.allowed)
        except Exception:  # noqa: BLE001, S112  singular places have no range
            continue
