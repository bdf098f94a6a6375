"""Rows of a batch of closed states, and states joined to a batch."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, ClosureStatus, InputError, Robot
from tests.robots import robot

NAMES = [field.name for field in fields(ClosedState)]


def batch_of(machine: Robot, count: int = 6) -> ClosedState:
    rng = np.random.default_rng(2)
    u = machine.reference + 0.01 * rng.standard_normal((count, len(machine.active)))
    return machine.close(u, rng.standard_normal(u.shape))


def assert_same(a: ClosedState, b: ClosedState) -> None:
    for name in NAMES:
        found, expected = getattr(a, name), getattr(b, name)
        assert type(found) is type(expected), name
        assert (
            np.array_equal(found, expected) if isinstance(found, np.ndarray) else found == expected
        ), name


@pytest.mark.parametrize("name", ["forging_chu2020", "five_bar", "gough"])
def test_rows_are_the_states_that_were_closed_and_join_to_the_batch(name: str) -> None:
    batch = batch_of(robot(name))
    singles = [batch.rows(k) for k in range(6)]
    for k, single in enumerate(singles):
        assert single.status is ClosureStatus.OK
        assert isinstance(single.iterations, int)
        assert isinstance(single.residual, float)
        assert np.array_equal(single.s, batch.s[k])
        assert np.array_equal(
            robot(name).inverse_dynamics(single, single.du),
            robot(name).inverse_dynamics(batch, batch.du)[k],
        )
    assert_same(ClosedState.joined(singles), batch)
    assert_same(
        ClosedState.joined([batch.rows(slice(0, 2)), singles[2], batch.rows(np.arange(3, 6))]),
        batch,
    )
    assert_same(batch.rows(np.array([4, 1])), ClosedState.joined([singles[4], singles[1]]))
    assert_same(batch.rows(np.arange(6) > 3), batch.rows([4, 5]))


def test_rows_keep_their_own_modes_accelerations_and_status(forging: Robot) -> None:
    modes = [mode.state for mode in forging.assembly_modes(forging.reference)[:2]]
    both = ClosedState.joined(modes)
    assert both.signs.shape == (2, modes[0].signs.size)
    for k, mode in enumerate(modes):
        assert np.array_equal(both.rows(k).signs, mode.signs)
        assert np.array_equal(both.rows([k]).signs, mode.signs[None])
    batch = batch_of(forging)
    fast = replace(batch, dds=np.arange(batch.s.size, dtype=float).reshape(batch.s.shape))
    assert np.array_equal(fast.rows(np.array([3, 0])).dds, fast.dds[[3, 0]])  # type: ignore[index]
    assert ClosedState.joined([fast, batch]).dds is None
    broken = forging.close(
        [forging.reference, np.add(forging.reference, [0.0, 0.9, 0.0, 0.0])], check=False
    )
    assert broken.rows(1).status is ClosureStatus.UNREACHABLE
    with pytest.raises(InputError, match="not a batch"):
        modes[0].rows(0)


def test_a_state_prints_what_it_is_in_short_and_a_batch_the_worst_of_its_rows(
    forging: Robot,
) -> None:
    state = forging.close(forging.reference, [0.1, 0.0, 0.0, 0.0])
    shown = repr(state)
    assert shown.startswith(
        "ClosedState(u=[0, 0.1, 0.15, 0], du=[0.1, 0, 0, 0], z=[2.3664, -1.63334, "
    )
    assert f"singularity={state.singularity:.3g}, " in shown
    assert "'theta_1': 'counterclockwise'" in shown
    assert shown.endswith("status=OK)")
    rows = [
        forging.reference,
        np.add(forging.reference, [0.0, 0.4, 0.0, 0.0]),
        [0.0, 0.9, 0.1, 0.0],
    ]
    many = forging.close(rows, check=False)
    assert "u=(3, 4), " in repr(many)
    assert repr(many).endswith("status=OK+UNREACHABLE)")
    closed = many.rows([0, 1])
    assert f"singularity={np.min(closed.singularity):.3g}, " in repr(closed)
    assert f"residual={np.max(closed.residual):.2g}, " in repr(closed)
    assert "u=(0, 4), " in repr(many.rows(slice(0)))
