"""Robots and states can be copied, and sent to other processes."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, InputError, Pose, Robot, load, shipped_robots
from tests.robots import ROBOTS, robot
from tests.sampling import swept

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


def are_equal(one: object, other: object) -> bool:
    """Equal to the last bit, but where NumPy's arctan2 rounds unlike that of the C library.

    NumPy 1.26 has one of its own, which counts where no compiled code runs.
    """
    y, x = np.random.default_rng(0).normal(size=(2, 1000))
    if np.array_equal(np.arctan2(y, x), list(map(math.atan2, y, x))):
        return np.array_equal(one, other)  # type: ignore[arg-type]
    if isinstance(one, np.ndarray) and one.dtype.kind == "f":
        return np.allclose(one, other, rtol=1e-13, atol=1e-13)  # type: ignore[arg-type]
    return np.array_equal(one, other)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", swept(ROBOTS))
@pytest.mark.parametrize("near", [False, True])
def test_a_state_is_the_row_of_a_batch_whatever_is_read_first(name: str, near: bool) -> None:
    """One state takes a shorter way than a batch, and computes some fields when they are read."""
    machine = robot(name)
    u = machine.reference + 1e-3
    du = np.full_like(u, 0.1)
    start = machine.close(machine.reference) if near else None
    batch = machine.close(u[None], du[None], near=start).rows(0)
    state = machine.close(u, du, near=start)
    unread = pickle.loads(pickle.dumps(machine.close(u, du, near=start)))  # noqa: S301
    u += 1.0
    du += 1.0
    for field in fields(ClosedState):
        expected = getattr(batch, field.name)
        for one in (state, unread, replace(unread)):
            value = getattr(one, field.name)
            assert are_equal(value, expected), field.name
            assert type(value) is not np.ndarray or not value.flags.writeable
    assert state.branch is state.branch
    with pytest.raises(AttributeError, match="no attribute 'residuals'"):
        _ = state.residuals  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", shipped_robots())
def test_nothing_of_a_shipped_description_can_be_changed(name: str) -> None:
    """Its file is read once a process: all robots of the name share what was read."""
    description = load(name).description
    assert load(name).description.lines is description.lines
    for place, part in parts_of(name, description):
        if isinstance(part, np.ndarray):
            assert not part.flags.writeable, place
        assert not isinstance(part, (list, dict, set)), place


def test_parameters_of_a_call_are_of_that_call_alone() -> None:
    plain = load("five_bar").description.joints
    other = load("five_bar", parameters={"crank": 0.2}).description.joints
    later = load("five_bar").description.joints
    lengths = [[joint.translation for joint in joints.values()] for joints in (plain, other, later)]
    assert np.array_equal(lengths[0], lengths[2])
    assert not np.array_equal(lengths[0], lengths[1])


def parts_of(place: str, thing: object) -> Iterator[tuple[str, object]]:
    """All that a description is made of, with where it stands."""
    yield place, thing
    if is_dataclass(thing):
        inner = [(field.name, getattr(thing, field.name)) for field in fields(thing)]
    elif isinstance(thing, Mapping):
        inner = [(str(key), value) for key, value in thing.items()]
    elif isinstance(thing, tuple):
        inner = [(str(k), value) for k, value in enumerate(thing)]
    else:
        return
    for name, part in inner:
        yield from parts_of(f"{place}.{name}", part)
