"""Inverse kinematics on chosen assembly modes, and targets that only a singular place reaches."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import IKStatus, Robot
from tests.robots import robot


@pytest.mark.parametrize("name", ["five_bar", "forging_chu2020", "delta", "gough"])
def test_a_target_is_reached_on_the_modes_of_a_given_state(name: str) -> None:
    machine = robot(name)
    for mode in machine.assembly_modes(machine.reference)[:4]:
        there = machine.close(machine.reference + 0.01, near=mode.state)
        target = machine.forward_kinematics(there).position
        found = machine.inverse_kinematics(target, near=mode.state)
        assert found.status is IKStatus.SOLVED, found.message
        assert found.state is not None
        assert dict(found.branch) == dict(mode.branch)
        assert np.allclose(machine.forward_kinematics(found.state).position, target, atol=1e-8)


def test_the_other_mode_has_another_reach(forging: Robot) -> None:
    own = forging.close(forging.reference)
    other = next(m.state for m in forging.assembly_modes(forging.reference) if dict(m.branch) != dict(own.branch))
    target = forging.forward_kinematics(other).position
    found = forging.inverse_kinematics(target, near=other)
    assert found.u == pytest.approx(other.u, abs=1e-6)


@pytest.mark.parametrize("before", [1e-8, 1e-9])
def test_a_target_at_a_toggle_point_is_told_as_singular(forging: Robot, before: float) -> None:
    """That near to its toggle the loop closes, but what the cylinder says of the angle is lost in rounding."""
    u = np.array(forging.reference)
    u[1] = forging.closing_range[1, 1] - before
    found = forging.inverse_kinematics(forging.forward_kinematics(forging.close(u)).position)
    assert found.status is IKStatus.SINGULAR
    assert "theta_1" in found.message
    assert 1e-9 < found.residual < 1e-3


@pytest.mark.parametrize(("joint", "value"), [(0, np.pi), (1, 0.05), (1, 1.15), (2, 1.4), (3, 1.0)])
def test_the_very_limit_of_a_joint_is_reached(joint: int, value: float) -> None:
    machine = robot("excavator")
    u = np.array(machine.reference)
    u[joint] = value
    pose = machine.forward_kinematics(machine.close(u))
    for target in (pose, pose.position):
        found = machine.inverse_kinematics(target)
        assert found.status is IKStatus.SOLVED, found.message
        assert (machine.limits[:, 0] <= found.u).all()
        assert (found.u <= machine.limits[:, 1]).all()
