"""Inverse kinematics of a batch is that of its rows."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import IKBatch, IKResult, IKStatus, InputError, Pose, Robot
from tests.robots import robot
from tests.sampling import swept

COUNT = 4


def places(machine: Robot) -> tuple[np.ndarray, Pose]:
    """Active coordinates about the reference, and the poses there."""
    shape = (COUNT, len(machine.active))
    u = machine.reference + np.random.default_rng(3).uniform(-0.03, 0.03, shape)
    return u, machine.forward_kinematics(machine.close(u))


def assert_rows(batch: IKBatch, rows: list[IKResult]) -> None:
    assert batch.u.shape == (len(rows), len(rows[0].u))
    assert batch.state.u.shape == batch.u.shape
    for k, row in enumerate(rows):
        assert np.array_equal(batch.u[k], row.u)
        assert batch.status[k] is row.status
        assert batch.residual[k] == row.residual
        assert batch.branch[k] == row.branch
        assert batch.message[k] == row.message
        assert batch.redundant[k] == row.redundant
        assert batch.iterations[k] == row.iterations
        assert batch.solved[k] == (row.status is IKStatus.SOLVED)
        assert len(batch.solutions[k]) == len(row.solutions)


@pytest.mark.parametrize("name", swept(["five_bar", "excavator", "delta"], ("five_bar",)))
def test_a_batch_of_positions_is_its_rows(name: str) -> None:
    machine = robot(name)
    _, pose = places(machine)
    batch = machine.inverse_kinematics(pose.position)
    assert isinstance(batch, IKBatch)
    assert_rows(batch, [machine.inverse_kinematics(target) for target in pose.position])
    assert batch.solved.all()
    reached = machine.forward_kinematics(batch.state).position
    assert reached == pytest.approx(pose.position, abs=1e-8)


@pytest.mark.parametrize("name", swept(["forging_chu2020", "excavator"], ("excavator",)))
def test_a_batch_of_poses_from_seeds_and_states_is_its_rows(name: str) -> None:
    machine = robot(name)
    u, pose = places(machine)
    near = machine.close(u + 0.01)
    batch = machine.inverse_kinematics(pose, seed=u + 0.02, near=near)
    assert isinstance(batch, IKBatch)
    rows = []
    for k in range(COUNT):
        target = Pose(pose.position[k], pose.rotation[k])
        rows.append(machine.inverse_kinematics(target, seed=u[k] + 0.02, near=near.rows(k)))
    assert_rows(batch, rows)
    one = machine.inverse_kinematics(pose, seed=u[0], near=near.rows(0))
    assert one.u.shape == u.shape


def test_rows_out_of_reach_are_told_apart() -> None:
    machine = robot("five_bar")
    _, pose = places(machine)
    targets = pose.position.copy()
    targets[1] += 50.0
    batch = machine.inverse_kinematics(targets)
    assert isinstance(batch, IKBatch)
    assert batch.solved.tolist() == [True, False, True, True]
    assert batch.message[0] == "reached" != batch.message[1]


WRONG = {
    "not finite": (np.array([[0.0, 0, 0], [np.nan, 0, 0]]), {}, r"row 1: target: x is nan"),
    "two numbers": (np.zeros((2, 2)), {}, r"row 0: target has shape \(2,\)"),
    "empty": (np.zeros((0, 3)), {}, "the batch is empty"),
    "seeds": (np.zeros((2, 3)), {"seed": np.zeros((3, 3))}, "seed has 3 rows; expected one, or"),
    "three dimensions": (np.zeros((2, 2, 3)), {}, r"target has shape \(2, 2, 3\)"),
}


@pytest.mark.parametrize(("targets", "others", "words"), WRONG.values(), ids=WRONG.keys())
def test_batches_of_another_form(targets: np.ndarray, others: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        robot("five_bar").inverse_kinematics(targets, **others)


def test_states_of_another_length() -> None:
    machine = robot("five_bar")
    near = machine.close(np.tile(machine.reference, (3, 1)))
    with pytest.raises(InputError, match="near holds 3 states; expected one, or one a target"):
        machine.inverse_kinematics(np.zeros((2, 3)), near=near)
