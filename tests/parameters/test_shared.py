"""Robots that differ in some numbers share code, and compute what each would with its own."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.kernels.run import VARIABLE
from hybrid_dynamics_core.robot.parameters.bound_kernel import BoundKernel
from tests.sampling import swept

NUMBERS = {
    "ankle": {"rod": 0.215, "links.foot.mass": 1.3},
    "delta": {"modules.delta.parameters.arm": 0.31, "joints.theta_A.offset": 0.01},
    "excavator": {"boom": 5.72, "loops.bucket_bars.pin.bucket": [-0.11, 0.4, 0.0]},
    "forging_chu2020": {"L2": 0.701},
    "gough": {"modules.hexapod.parameters.base_radius": 1.05},
    "type_c": {"links.jib.mass": 2.5, "stay_x": "-255*mm"},
}


@pytest.fixture(autouse=True)
def _without_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "python")


def scaled(values: dict, factor: float) -> dict:
    """Other values of the same numbers, near those of the description."""
    robot_values = {}
    for name, value in values.items():
        robot_values[name] = np.asarray(value) * factor if not isinstance(value, str) else value
    return robot_values


def results(robot: Robot) -> list[np.ndarray]:
    u = robot.reference + 0.01
    rates = 0.1 * np.ones(len(u))
    state = robot.close(u, rates)
    path = robot.close_path(np.linspace(robot.reference, u, 3))
    tau = robot.inverse_dynamics(state, rates)
    return [
        state.s,
        state.R,
        state.distances,
        path.s,
        tau,
        robot.forward_kinematics(state).position,
        robot.kernels.inverse_dynamics(u, rates, rates),
        robot.forward_dynamics(state, tau),
    ]


@pytest.mark.parametrize("name", swept(NUMBERS, ("excavator",)))
def test_shared_code_computes_what_code_of_its_own_does(name: str) -> None:
    robot = load(name)
    robot.with_parameters(NUMBERS[name]).close(robot.reference)
    near = scaled(NUMBERS[name], 1.001)
    second, third = (robot.with_parameters(near) for _ in range(2))
    alone = copy.deepcopy(robot).with_parameters(near)
    for shared, own in zip(results(second), results(alone), strict=True):
        size = np.abs(own).max(initial=1.0)
        assert np.allclose(shared, own, rtol=0.0, atol=1e-8 * size)
    results(third)
    kernel = second._kernels.kernels["close"]
    assert isinstance(kernel, BoundKernel)
    assert kernel._shared is third._kernels.kernels["close"]._shared
    assert not isinstance(alone._kernels.kernels["close"], BoundKernel)


def test_a_robot_of_another_structure_says_so_and_has_code_of_its_own() -> None:
    robot = load("ankle")
    name = "legs.push_L.joints[2].origin.xyz[2]"  # the axes of the universal joint no longer meet
    first, straight = (robot.with_parameters({name: value}) for value in (0.0, 1e-13))
    other = robot.with_parameters({name: 0.002})
    notes = [note for note in other.description.notes if "solved by iteration" in note]
    assert [note.split(":")[0] for note in notes] == ["push_L"]
    assert f"{name} = 0.002" in notes[0]
    assert not any("solved by iteration" in note for note in straight.description.notes)
    for machine in (first, straight, other):
        assert np.isfinite(machine.close(machine.reference).s).all()
    assert straight._kernels._shared is not None
    assert other._kernels._shared is None


def test_a_number_given_twice_is_refused() -> None:
    with pytest.raises(InputError, match="boom: given twice"):
        load("excavator").with_parameters({"boom": 5.7}, boom=5.9)


def test_terms_that_cancel_leave_zero() -> None:
    """With two live lengths, products of the efforts cancel: sums without terms."""
    robot = load("forging_chu2020")
    efforts = []
    for length in (0.7, 0.71):
        other = robot.with_parameters(L2=length, L3=0.81)
        state = other.close(other.reference)
        efforts.append(other.inverse_dynamics(state, np.zeros(4)))
    alone = load("forging_chu2020", parameters={"L2": 0.71, "L3": 0.81})
    expected = alone.inverse_dynamics(alone.close(alone.reference), np.zeros(4))
    assert np.allclose(efforts[1], expected, rtol=1e-9)
