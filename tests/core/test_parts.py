"""Each part of a robot can be built from a description alone, and answers as the robot does."""

from __future__ import annotations

import inspect
from dataclasses import dataclass

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Payload, Robot
from hybrid_dynamics_core.kinematics.closed_kinematics import ClosedKinematics
from hybrid_dynamics_core.kinematics.workspace import margins_at
from hybrid_dynamics_core.robot.actuation import Actuation
from hybrid_dynamics_core.robot.closure import Closure
from hybrid_dynamics_core.robot.compiled_calls import RobotKernels
from hybrid_dynamics_core.robot.dynamics import Dynamics
from hybrid_dynamics_core.robot.joint_poses import JointPoses
from hybrid_dynamics_core.robot.kernel_store import KernelStore
from hybrid_dynamics_core.robot.kinematics import Kinematics
from hybrid_dynamics_core.robot.model import RobotModel
from hybrid_dynamics_core.robot.motion.motions import Motions
from hybrid_dynamics_core.robot.parameters import FreeParameters
from hybrid_dynamics_core.robot.proofs import Certification

PARTS = (
    RobotModel,
    KernelStore,
    Closure,
    Kinematics,
    JointPoses,
    Dynamics,
    Actuation,
    RobotKernels,
    FreeParameters,
    Certification,
    Motions,
)
U = np.array([0.3, 0.15, 0.175, 0.4])
DU = np.array([0.1, 0.02, -0.03, 0.2])
DDU = np.array([0.5, -0.1, 0.2, 0.3])


@dataclass
class Parts:
    """The parts of the forging robot, without the robot."""

    model: RobotModel
    kernels: KernelStore
    closure: Closure


@pytest.fixture(scope="module")
def parts(forging: Robot) -> Parts:
    model = RobotModel.from_description(forging.description)
    kernels = KernelStore(model)
    return Parts(model, kernels, Closure(model, kernels))


def test_no_part_knows_the_robot() -> None:
    for part in PARTS:
        assert "Robot" not in vars(inspect.getmodule(part))


FUNCTIONS = (  # of any robot
    "better_coordinates",
    "capability",
    "inverse_kinematics",
    "limit_margins",
    "point_to_point",
    "retime",
    "stiffness",
    "with_active",
    "with_parameters",
    "workspace",
)


def test_every_method_of_the_robot_is_one_of_a_part() -> None:
    """Signature and docstring are those of the part: they are written once."""
    for name, method in vars(Robot).items():
        if name.startswith("_") or not inspect.isfunction(method):
            continue
        if name in FUNCTIONS:
            continue
        origin = next(part for part in PARTS if method.__qualname__ == f"{part.__name__}.{name}")
        assert inspect.signature(method) == inspect.signature(getattr(origin, name))
        assert method.__doc__ == getattr(origin, name).__doc__


def test_model_has_the_names_and_limits(forging: Robot, parts: Parts) -> None:
    model = parts.model
    names = ("name", "active", "passive", "coordinates", "joint_types", "frames", "loops")
    for name in (*names, "redundant_equations", "mode_names", "follows", "idle"):
        assert getattr(model, name) == getattr(forging, name)
    for name in ("reference", "limits", "closing_range"):
        assert np.array_equal(getattr(model, name), getattr(forging, name))
        assert not getattr(model, name).flags.writeable
    assert model.reference_s[: len(U)] == pytest.approx(forging.reference)
    with pytest.raises(InputError, match="there is no frame 'nowhere'"):
        model.frame("nowhere")


def test_model_with_other_given_coordinates_is_made_once(parts: Parts) -> None:
    given = parts.model.active
    assert parts.model.program_model_from(given) is parts.model.program_model_from(given)
    assert parts.model.program_model_from(given).plan.given == parts.model.plan.given


def test_kernel_store_makes_a_kernel_once(parts: Parts) -> None:
    parts.closure.close(U)
    kernel = parts.kernels.kernels["close"]
    assert parts.kernels.kernel("close", None) is kernel  # type: ignore[arg-type]


def test_closure_closes_as_the_robot_does(forging: Robot, parts: Parts) -> None:
    state, expected = parts.closure.close(U, DU), forging.close(U, DU)
    for name in ("s", "ds", "R", "bias", "distances"):
        assert np.array_equal(getattr(state, name), getattr(expected, name))
    assert state.branch == expected.branch
    assert forging.owns(state)
    assert parts.closure.owns(expected)
    with pytest.raises(InputError, match="expected a ClosedState"):
        parts.closure.check_state(U)


def test_kinematics_and_dynamics_answer_as_the_robot_does(forging: Robot, parts: Parts) -> None:
    kinematics = Kinematics(parts.model, parts.kernels, parts.closure)
    dynamics = Dynamics(parts.model, parts.kernels, parts.closure)
    state = parts.closure.close(U, DU)
    assert np.array_equal(kinematics.jacobian(state), forging.jacobian(state))
    assert np.array_equal(
        kinematics.forward_kinematics(state, "l3").position,
        forging.forward_kinematics(state, "l3").position,
    )
    tau = dynamics.inverse_dynamics(state, DDU)
    assert np.array_equal(tau, forging.inverse_dynamics(state, DDU))
    assert dynamics.forward_dynamics(state, tau) == pytest.approx(DDU)


def test_actuation_answers_as_the_robot_does(forging: Robot, parts: Parts) -> None:
    actuation = Actuation(parts.model, parts.closure)
    state, tau = parts.closure.close(U, DU), np.array([1.0, 2.0, 3.0, 4.0])
    assert actuation.drives == forging.drives
    forces = actuation.drive_forces(state, tau)
    assert {name: float(force) for name, force in forces.items()} == {
        name: float(force) for name, force in forging.drive_forces(state, tau).items()
    }
    assert actuation.generalised_forces(state, forces) == pytest.approx(tau)


def test_compiled_calls_need_no_robot(forging: Robot, parts: Parts) -> None:
    dynamics = Dynamics(parts.model, parts.kernels, parts.closure)
    calls = RobotKernels(parts.kernels, parts.closure, dynamics, dynamics.loads)
    heavy = dynamics.loads.with_payload(Payload(10.0))
    tau = calls.under(heavy).inverse_dynamics(U, DU, DDU)
    assert np.array_equal(tau, forging.kernels.under(heavy).inverse_dynamics(U, DU, DDU))
    state = forging.close(U, DU)
    assert tau == pytest.approx(forging.inverse_dynamics(state, DDU, heavy), rel=1e-12)


def test_kinematics_takes_anything_that_closes(forging: Robot) -> None:
    """A workspace needs no Robot, only what `ClosedKinematics` lists."""
    names = [name for name in vars(ClosedKinematics) if not name.startswith("_")]

    class Alike:
        pass

    alike = Alike()
    for name in names:
        setattr(alike, name, getattr(forging, name))
    u = np.array([U, U + 0.01])
    margins = margins_at(alike, u)  # type: ignore[arg-type]
    assert np.array_equal(margins.position, margins_at(forging, u).position)
