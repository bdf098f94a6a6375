"""What the library answers to the arguments of a C function, for one state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ...closed_state.state import ClosedState
from ...description.effects import Payload
from ...dynamics.loads import Loads
from ...ground.arrays import Array
from ...kinematics.pose import rotation_vector
from ...programs import HYDRAULICS
from ...programs.steps import DAMPING, LONGEST
from ...robot.robot import Robot

Arguments = Mapping[str, Array]
Answers = dict[str, Array]


class Call(NamedTuple):
    """A call of a C function.

    Attributes:
        robot: the robot.
        state: closed state.
        x: arguments by name.
        loads: loads, with those among the arguments.
    """

    robot: Robot
    state: ClosedState
    x: Arguments
    loads: Loads


Function = Callable[[Call], Answers]


def random_arguments(
    robot: Robot, state: ClosedState, rng: np.random.Generator
) -> dict[str, Array]:
    """Arguments of all functions at a state."""
    n = state.n
    n_s = len(state.s)
    pose = robot.forward_kinematics(state)
    disturbance = rng.uniform(-1.0, 1.0, (3, 3))
    turn, _ = np.linalg.qr(np.eye(3) + 0.2 * disturbance)
    turn = turn * np.sign(np.diag(turn))
    return {
        "u": state.u,
        "du": state.du,
        "ddu": rng.uniform(-1.0, 1.0, n),
        "tau": rng.uniform(-1.0, 1.0, n),
        "gravity": robot.loads.gravity,
        "forces": rng.uniform(-1.0, 1.0, n_s),
        "position": pose.position + 0.1 * rng.uniform(-1.0, 1.0, 3),
        "rotation": np.ravel(turn @ pose.rotation),
        "weights": np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.0]),
        "payload": _random_payload(rng),
        "viscous": rng.uniform(0.0, 1.0, n_s),
        "coulomb": rng.uniform(0.0, 1.0, n_s),
    }


def _random_payload(rng: np.random.Generator) -> Array:
    root = rng.uniform(-0.3, 0.3, (3, 3))
    second_moments = root @ root.T
    inertia = np.trace(second_moments) * np.eye(3) - second_moments
    mass_and_centre = rng.uniform(0.0, 1.0, 4)
    return np.concatenate([mass_and_centre, inertia[np.triu_indices(3)]])


def answers(
    robot: Robot,
    name: str,
    state: ClosedState,
    x: Arguments,
    loaded: bool,
) -> Answers:
    """The results of a C function, by name.

    Args:
        robot: the robot.
        name: of the function.
        state: closed state.
        x: arguments by name.
        loaded: whether payload and friction are arguments.

    Raises:
        MassSingularityError: M-bar is singular.
    """
    loads = robot.loads.with_gravity(x["gravity"])
    if loaded:
        loads = loads.with_effects(viscous=x["viscous"], coulomb=x["coulomb"])
        loads = loads.with_payload(payload_of(x["payload"]), robot.end_effector)
    call = Call(robot, state, x, loads)
    return _FUNCTIONS[name](call)


def payload_of(values: Array) -> Payload:
    """The payload of ten numbers."""
    xx, xy, xz, yy, yz, zz = values[4:]
    inertia = [
        [xx, xy, xz],
        [xy, yy, yz],
        [xz, yz, zz],
    ]
    return Payload(float(values[0]), values[1:4], inertia)


def _close(call: Call) -> Answers:
    return {"s": call.state.s, "ds": call.state.ds}


def _inverse_dynamics(call: Call) -> Answers:
    tau = call.robot.inverse_dynamics(call.state, call.x["ddu"], call.loads)
    return {"tau": tau}


def _forward_dynamics(call: Call) -> Answers:
    ddu = call.robot.forward_dynamics(call.state, call.x["tau"], call.loads)
    return {"ddu": ddu}


def _minimal_form(call: Call) -> Answers:
    mass_matrix, bias, gravity = call.robot.minimal_form(call.state, call.loads)
    return {"M": mass_matrix, "h": bias, "g": gravity}


def _pose(call: Call) -> Answers:
    pose = call.robot.forward_kinematics(call.state)
    return {"position": pose.position, "rotation": pose.rotation}


def _jacobian(call: Call) -> Answers:
    return {"J": call.robot.jacobian(call.state)}


def _reactions(call: Call) -> Answers:
    reactions = call.robot.reactions(call.state, call.x["ddu"], call.loads)
    pins = reactions.pins.values()
    joints = reactions.joints.values()
    return {
        "tau": reactions.tau,
        "pin_places": np.array([pin.place for pin in pins]),
        "pin_forces": np.array([pin.force for pin in pins]),
        "pin_moments": np.array([pin.moment for pin in pins]),
        "pin_shares": np.array([pin.share for pin in pins]),
        "joint_places": np.array([joint.place for joint in joints]),
        "joint_forces": np.array([joint.force for joint in joints]),
        "joint_moments": np.array([joint.moment for joint in joints]),
        "base": reactions.base,
    }


def _inverse_derivatives(call: Call) -> Answers:
    values = call.robot.inverse_dynamics_derivatives(call.state, call.x["ddu"], call.loads)
    tau = call.robot.inverse_dynamics(call.state, call.x["ddu"], call.loads)
    d_u, d_du, d_ddu = values
    return {"tau": tau, "d_u": d_u, "d_du": d_du, "d_ddu": d_ddu}


def _forward_derivatives(call: Call) -> Answers:
    values = call.robot.forward_dynamics_derivatives(call.state, call.x["tau"], call.loads)
    ddu = call.robot.forward_dynamics(call.state, call.x["tau"], call.loads)
    d_u, d_du, d_tau = values
    return {"ddu": ddu, "d_u": d_u, "d_du": d_du, "d_tau": d_tau}


def _ik_step(call: Call) -> Answers:
    """A damped step by least squares of the extended system."""
    state = call.state
    weights = call.x["weights"]
    pose = call.robot.forward_kinematics(state)
    target = np.reshape(call.x["rotation"], (3, 3))
    turn = rotation_vector(target @ pose.rotation.T)
    error = np.concatenate([call.x["position"] - pose.position, turn])
    jacobian = weights[:, None] * call.robot.jacobian(state)
    damping = np.sqrt(DAMPING * np.sum(jacobian**2) / state.n)
    system = np.vstack([jacobian, damping * np.eye(state.n)])
    wanted = np.concatenate([weights * error, np.zeros(state.n)])
    move, *_ = np.linalg.lstsq(system, wanted, rcond=None)
    length = float(np.linalg.norm(move))
    share = min(1.0, LONGEST / max(length, LONGEST))
    return {"next": state.u + share * move, "error": error}


def _generalised(call: Call) -> Answers:
    return {"tau": call.state.R.T @ call.x["forces"]}


def _hydraulics(call: Call) -> Answers:
    readings = call.robot.hydraulics(call.state, call.x["tau"])
    cylinders = readings.values()
    columns: Answers = {}
    for name in HYDRAULICS:
        columns[name] = np.array([getattr(cylinder, name) for cylinder in cylinders])
    return columns


_FUNCTIONS: Mapping[str, Function] = {
    "close": _close,
    "inverse_dynamics": _inverse_dynamics,
    "forward_dynamics": _forward_dynamics,
    "minimal_form": _minimal_form,
    "forward_kinematics": _pose,
    "jacobian": _jacobian,
    "reactions": _reactions,
    "inverse_dynamics_derivatives": _inverse_derivatives,
    "forward_dynamics_derivatives": _forward_derivatives,
    "ik_step": _ik_step,
    "generalised_forces": _generalised,
    "hydraulics": _hydraulics,
}
