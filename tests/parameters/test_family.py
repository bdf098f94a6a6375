"""Numbers of a description as arguments: values of the robot built again, exact derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, InputError, Robot, load, shipped_robots
from hybrid_dynamics_core.algebra.live import live_numbers
from hybrid_dynamics_core.errors import UnknownNameError
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kernels.run import VARIABLE
from hybrid_dynamics_core.programs import CLOSE
from hybrid_dynamics_core.robot.parameters import RobotFamily
from tests.generated.class_three import class_three
from tests.generated.robots import as_text, examples
from tests.mechanisms import MECHANISMS, mechanism
from tests.parameters.differences import around, assert_slopes, closed, free_at_random
from tests.sampling import swept

LENGTHS = {
    "delta": ("modules.delta.parameters.arm", "modules.delta.parameters.rod"),
    "excavator": (
        "boom",
        "loops.bucket_bars.pin.bucket[0]",
        "links.boom.mass",
        "links.stick.com[1]",
    ),
    "five_bar": ("crank", "joints.q_L.offset", "links.tool.mass"),
    "forging_chu2020": ("L2", "L3", "links.l2.mass"),
}


@pytest.fixture(autouse=True)
def _without_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "python")


@pytest.fixture(name="excavator", scope="module")
def excavator_family() -> RobotFamily:
    return load("excavator").free(*LENGTHS["excavator"])


def law(robot: Robot, rng: np.random.Generator) -> None:
    """At moved parameters a family closes as the robot built with them, and has its slopes."""
    family = free_at_random(robot, rng)
    if family is None:
        return
    u = robot.reference + 0.01 * rng.standard_normal(len(robot.reference))
    result = family.close(u)
    if result.status:
        return
    assert_slopes(result, family.close(u, around(family), derivatives=False))
    moved = family.values + 1e-3 * rng.standard_normal(len(family.names))
    there = family.close(u, moved, derivatives=False)
    try:
        other = robot.with_parameters(dict(zip(family.names, moved, strict=True)))
    except DescriptionError:  # a mass below zero, for example
        return
    for name, value in zip(("s", "R", "distances"), closed(other, u, there["s"]), strict=True):
        size = 1.0 + np.abs(value).max(initial=0.0)
        assert np.allclose(there[name], value, rtol=0.0, atol=1e-8 * size), name


@pytest.mark.parametrize("name", swept(shipped_robots(), ("type_d",)))
def test_shipped_robots_as_functions_of_their_numbers(name: str) -> None:
    law(load(name), np.random.default_rng(4))


@pytest.mark.parametrize("name", swept(MECHANISMS, ("rssr",)))
def test_mechanisms_as_functions_of_their_numbers(name: str) -> None:
    robot = Robot(parse_description(as_text(mechanism(name).description)))
    law(robot, np.random.default_rng(5))


@examples(12)
@given(case=class_three(4, 2), seed=st.integers(0, 99))
def test_random_robots_as_functions_of_their_numbers(case: object, seed: int) -> None:
    law(Robot(parse_description(as_text(case.robot.description))), np.random.default_rng(seed))


@pytest.mark.parametrize("name", swept(LENGTHS, ("excavator",)))
def test_efforts_forces_and_poses_have_the_slopes_of_differences(name: str) -> None:
    robot = load(name)
    family = robot.free(*LENGTHS[name])
    rng = np.random.default_rng(1)
    n = len(robot.active)
    u = robot.reference + 0.01
    rates, accelerations = rng.standard_normal((2, n))
    beside = around(family)
    tau = family.inverse_dynamics(u, None, rates, accelerations)
    near = family.inverse_dynamics(u, beside, rates, accelerations, derivatives=False)
    assert_slopes(tau, near)
    pins = family.reactions(u, None, rates, accelerations)
    assert_slopes(pins, family.reactions(u, beside, rates, accelerations, derivatives=False))
    for call in (family.forward_kinematics, family.jacobian):
        assert_slopes(call(u), call(u, beside, derivatives=False))
    state = robot.close(u, rates)
    expected = robot.inverse_dynamics(state, accelerations)
    assert np.allclose(tau["tau"], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    by_u, _, _ = robot.inverse_dynamics_derivatives(state, accelerations)
    assert np.allclose(tau.by_u["tau"], by_u, rtol=1e-8, atol=1e-8 * np.abs(by_u).max())
    forces = [pin.force for pin in robot.reactions(state, accelerations).pins.values()]
    assert np.allclose(pins["pin_forces"], forces, atol=1e-8 * np.abs(forces).max())


def test_a_batch_of_parameters_gives_what_each_robot_gives(excavator: RobotFamily) -> None:
    robot = load("excavator")
    rng = np.random.default_rng(2)
    parameters = excavator.values * (1.0 + 1e-3 * rng.standard_normal((5, len(excavator.values))))
    u = robot.reference + 0.01 * rng.standard_normal((5, len(robot.active)))
    efforts = excavator.inverse_dynamics(u, parameters, derivatives=False)["tau"]
    other = robot.with_parameters(dict(zip(excavator.names, parameters[3], strict=True)))
    expected = other.inverse_dynamics(other.close(u[3]), np.zeros(len(robot.active)))
    assert np.allclose(efforts[3], expected, rtol=1e-9)
    alone = excavator.inverse_dynamics(u[3], parameters[3], derivatives=False)["tau"]
    assert np.allclose(efforts[3], alone, rtol=1e-12)


def test_the_jacobian_by_the_parameters_is_the_mixed_derivative(excavator: RobotFamily) -> None:
    u = load("excavator").reference
    of_jacobian = excavator.jacobian(u).by_parameters["jacobian"][:3]
    step = 1e-6
    for k in range(len(u)):
        moved = np.tile(u, (2, 1))
        moved[:, k] += (step, -step)
        above, below = excavator.forward_kinematics(moved).by_parameters["position"]
        assert np.allclose(of_jacobian[:, k], (above - below) / (2.0 * step), atol=1e-7)


def test_rows_that_do_not_close_are_nan_with_a_status(excavator: RobotFamily) -> None:
    parameters = np.tile(excavator.values, (2, 1))
    parameters[1, 0] = 20.0
    result = excavator.close(load("excavator").reference, parameters)
    assert result.status.tolist()[0] == 0
    assert result.status[1] != 0
    assert np.isnan(result["s"][1]).all()
    assert np.isfinite(result["s"][0]).all()


@pytest.mark.parametrize("name", ["delta", "excavator"])
def test_a_robot_without_free_numbers_has_none_in_its_model(name: str) -> None:
    robot = load(name)
    before = robot._kernels.kernel("close", CLOSE).trace.graph.nodes
    family = robot.free("links.gripper.mass" if name == "delta" else "boom")
    family.close(robot.reference)
    assert live_numbers(robot._model.program_model) == []
    assert len(live_numbers(family._live)) > 0
    assert load(name)._kernels.kernel("close", CLOSE).trace.graph.nodes == before


def test_closed_forms_stay_closed_forms() -> None:
    palletizer = load("palletizer")
    family = palletizer.free("L2")  # of both bars of each parallelogram
    assert all(not block.iterates for block in family._live.plan.blocks)
    with pytest.raises(InputError, match="is not a parallelogram: its opposite bars"):
        palletizer.free("joints.p5.origin.xyz[0]")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("joints.boom_barrel_pitch.origin.xyz[1]", "apart along the loop's axis"),
        ("joints.boom_barrel_pitch.origin.rpy[2]", "do not move in the plane|does not move in the"),
        ("joints.boom_cylinder.limits[0]", "has no effect"),
        ("reference.slew", "has no effect"),
    ],
)
def test_a_number_that_cannot_be_free_is_refused_in_one_line(name: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        load("excavator").free("boom", name)
    assert name in str(refused.value)
    assert "\n" not in str(refused.value)


def test_wrong_arguments_are_refused(excavator: RobotFamily) -> None:
    robot = load("excavator")
    with pytest.raises(UnknownNameError, match="did you mean 'boom'"):
        robot.free("booom")
    with pytest.raises(InputError, match="named twice"):
        robot.free("boom", "parameters.boom")
    with pytest.raises(InputError, match="at least one parameter"):
        robot.free()
    with pytest.raises(InputError, match="parameters"):
        excavator.close(robot.reference, [1.0])
    with pytest.raises(InputError, match="equally many rows"):
        excavator.close(np.tile(robot.reference, (2, 1)), np.tile(excavator.values, (3, 1)))
    with pytest.raises(InputError, match="there is no frame 'nowhere'"):
        excavator.jacobian(robot.reference, frame="nowhere")
    with pytest.raises(InputError, match="part of a load"):
        robot.free("gravity[2]").inverse_dynamics(robot.reference)
