"""Robots and states can be copied, and sent to other processes."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Pose, Robot, load

U = [0.1, 0.12, 0.15, 0.2]


@pytest.mark.parametrize(
    "way",
    [copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))],  # noqa: S301
)
def test_a_copy_answers_the_same(forging: Robot, way) -> None:
    twin, state = way(forging), way(forging.close(U, U))
    assert twin.coordinates == forging.coordinates
    assert np.array_equal(state.s, forging.close(U, U).s)
    assert dict(state.branch) == dict(forging.close(U, U).branch)
    assert np.array_equal(
        twin.inverse_dynamics(state, U), forging.inverse_dynamics(forging.close(U, U), U)
    )
    loads = way(forging.loads)
    assert np.array_equal(
        twin.inverse_dynamics(state, U, loads), forging.inverse_dynamics(forging.close(U, U), U)
    )
    with pytest.raises(ValueError, match="read-only"):
        state.s[0] = 1.0


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda _: load(5), "named by a text or a path, not by 5"),
        (lambda _: Pose.from_quaternion([0, 0, 0], "a"), "quaternion is not an array of numbers"),
        (lambda _: Pose.from_quaternion("x", [0, 0, 0, 1]), "position is not an array of numbers"),
        (lambda robot: robot.close(U, branch=["up"]), "expected assembly modes by loop name"),
        (
            lambda robot: robot.inverse_dynamics(robot.close(U), U, loads=5),
            "expected Loads, such as robot.loads, got int",
        ),
    ],
)
def test_things_of_the_wrong_kind_are_refused(forging: Robot, call, words: str) -> None:
    with pytest.raises(InputError, match=words):
        call(forging)
