"""Calls along a motion start from the state before: the numbers of `close(near=)`, and no jumps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.kernels import run
from hybrid_dynamics_core.robot import call_kernels
from tests.kernels.programs_of import BACKENDS
from tests.robots import ROBOTS, made, robot
from tests.sampling import examples, swept
from tests.turning import Turning, turning_linkages

ROUNDING = 1e-9  # of efforts, beside their largest: Newton ends within 1e-12 of a configuration
ITERATED = ("gough", "ankle", "staicu2015")


def motion(machine: Robot, seed: int, size: float = 0.1, rows: int = 40) -> np.ndarray:
    """Active coordinates (N, n) of a slow motion about the reference, within the limits."""
    rng = np.random.default_rng(seed)
    phases = np.linspace(0.0, np.pi, rows)[:, None] + rng.uniform(0.0, 0.1, len(machine.active))
    u = machine.reference + size * np.sin(phases) * rng.uniform(-1.0, 1.0, len(machine.active))
    return np.clip(u, machine.limits[:, 0], machine.limits[:, 1])


def agree(value: np.ndarray, expected: np.ndarray) -> None:
    scale = 1.0 + np.abs(expected).max()
    np.testing.assert_allclose(value, expected, rtol=0.0, atol=ROUNDING * scale)


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_a_motion_step_by_step_and_at_once(name: str) -> None:
    machine = robot(name)
    u = motion(machine, 3)
    du, ddu = 0.3 * np.cos(u), np.sin(u)
    call = machine.kernels.inverse_dynamics
    path = machine.close_path(u, du)
    expected = machine.inverse_dynamics(path, ddu)
    start, rows = machine.kernels.start(), machine.kernels.start()
    for k in range(len(u)):
        agree(call(u[k], du[k], ddu[k], start=start), expected[k])
        np.testing.assert_allclose(start.s, path.s[k], atol=ROUNDING)
    agree(call(u, du, ddu, start=rows), expected)
    np.testing.assert_allclose(rows.s, start.s, atol=ROUNDING)
    np.testing.assert_allclose(rows.start_map, start.start_map, atol=1e-7)


@pytest.mark.parametrize("name", ["ankle", "forging_chu2020"])
def test_a_motion_in_parts(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A long motion goes through the code in parts, each from the end of the one before."""
    machine = robot(name)
    u = motion(machine, 4, rows=23)
    still = np.zeros_like(u)
    call = machine.kernels.inverse_dynamics
    start, in_parts = machine.kernels.start(), machine.kernels.start()
    expected = call(u, still, still, start=start)
    monkeypatch.setattr(call_kernels, "PATH_ROWS", 5)
    agree(call(u, still, still, start=in_parts), expected)
    np.testing.assert_allclose(in_parts.s, start.s, atol=ROUNDING)
    np.testing.assert_allclose(in_parts.start_map, start.start_map, atol=1e-7)
    assert call(u[:0], still[:0], still[:0], check=False).shape == (0, len(u[0]))
    monkeypatch.setattr(call_kernels.CallKernels, "_side_by_side", lambda *_: None)
    one_by_one = machine.kernels.start()
    agree(call(u, still, still, start=one_by_one), expected)
    np.testing.assert_allclose(one_by_one.s, start.s, atol=ROUNDING)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", swept(ITERATED))
def test_near_and_far_from_the_reference(
    name: str, backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A batch of which some rows are one move from the reference, and others are followed."""
    monkeypatch.setattr(run, "default_backend", lambda: backend)
    machine = Robot(robot(name).description)
    rng = np.random.default_rng(5)
    sizes = np.repeat([0.01, 0.6], 8)[:, None]
    u = machine.reference + sizes * rng.uniform(-1.0, 1.0, (16, len(machine.active)))
    closed = [machine.close(row, check=False) for row in u]
    ddu = np.zeros_like(u)
    batch = machine.kernels.inverse_dynamics(u, ddu, ddu, check=False)
    for k, state in enumerate(closed):
        assert np.isnan(batch[k]).all() == bool(state.status)
        if state.status:
            with pytest.raises(StateError):
                machine.kernels.inverse_dynamics(u[k], ddu[k], ddu[k])
            continue
        expected = machine.inverse_dynamics(state, ddu[k])
        agree(batch[k], expected)
        agree(machine.kernels.inverse_dynamics(u[k], ddu[k], ddu[k]), expected)


@examples(30)
@given(turning_linkages(), st.integers(0, 50), st.sampled_from([1.0, -1.0]))
def test_whole_turns_are_counted(linkage: Turning, seed: int, way: float) -> None:
    """The springs of a linkage see the turns of its rods, three times round."""
    machine = linkage.robot(seed)
    u = linkage.start + way * np.linspace(0.0, 6.0 * np.pi, 300)[:, None]
    path = machine.close_path(u)
    still = np.zeros_like(u)
    start = machine.kernels.start(path.rows(0))
    agree(
        machine.kernels.inverse_dynamics(u, still, still, start=start),
        machine.inverse_dynamics(path, still),
    )
    np.testing.assert_allclose(start.s, path.s[-1], atol=ROUNDING)


def test_a_jump_is_refused_and_leaves_the_start() -> None:
    """The forging robot beyond its reach: the motion ends there, by steps and at once."""
    machine = robot("forging_chu2020")
    start = machine.kernels.start()
    before = start.s.copy()
    beyond = np.array([0.0, 0.9, 0.1, 0.0])
    still = np.zeros(4)
    with pytest.raises(StateError):
        machine.kernels.inverse_dynamics(beyond, still, still, start=start)
    assert np.array_equal(start.s, before)
    way = np.linspace(machine.reference, beyond, 50)
    out = np.ones_like(way)
    with pytest.raises(StateError) as problem:
        machine.kernels.inverse_dynamics(way, 0 * way, 0 * way, start=start, out=out)
    assert np.isnan(out).all()
    assert problem.value.index is not None
    assert np.array_equal(start.s, before)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_path_goes_on_after_rows_that_are_far_apart(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Long steps are followed, and the quick rows between them are those of single steps."""
    monkeypatch.setattr(run, "default_backend", lambda: backend)
    machine = made("ankle")
    u = motion(machine, 1, 0.05, 12)
    u[4:8] += 0.25
    state = machine.close(u[0])
    path = machine.close_path(u)
    for k, row in enumerate(u):
        state = machine.close(row, near=state)
        np.testing.assert_allclose(path.s[k], state.s, atol=ROUNDING)


def test_what_a_start_is_told_in_one_line() -> None:
    machine = robot("gough")
    u, still = machine.reference, np.zeros(6)
    call = machine.kernels.inverse_dynamics
    with pytest.raises(InputError, match=r"start is a ndarray; expected a WarmStart"):
        call(u, still, still, start=u)
    start = machine.kernels.start()
    with pytest.raises(InputError, match="give start, or guess and branch"):
        call(u, still, still, start=start, guess=start.s)
    with pytest.raises(InputError, match="starts at one state, not at a batch of 2"):
        machine.kernels.start(machine.close(np.stack([u, u])))
    with pytest.raises(InputError, match="not closed"):
        machine.kernels.start(machine.close(u + 9.0 * np.eye(6)[0], check=False))
    with pytest.raises(InputError, match="another robot"):
        machine.kernels.start(robot("ankle").close(robot("ankle").reference))
    with pytest.raises(InputError, match="finite"):
        call(np.full(6, np.nan), still, still, start=start)
    other = robot("ankle")
    with pytest.raises(InputError, match="another robot"):
        other.kernels.inverse_dynamics(other.reference, [0, 0], [0, 0], start=start)
