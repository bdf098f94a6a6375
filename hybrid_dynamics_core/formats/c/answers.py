"""What the library answers to the arguments of a C function, for one state."""

from __future__ import annotations

from collections.abc import Callable, Mapping

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
Function = Callable[[Robot, ClosedState, Arguments, Loads], Answers]


def random_arguments(
    robot: Robot, state: ClosedState, rng: np.random.Generator
) -> dict[str, Array]:
    """Arguments of all functions at a state."""
    n, n_s = state.n, len(state.s)
    pose = robot.forward_kinematics(state)
    turn = np.linalg.qr(np.eye(3) + 0.2 * rng.uniform(-1.0, 1.0, (3, 3)))[0]
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


def answers(robot: Robot, name: str, state: ClosedState, x: Arguments, loaded: bool) -> Answers:
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
    return _FUNCTIONS[name](robot, state, x, loads)


def payload_of(values: Array) -> Payload:
    """The payload of ten numbers."""
    xx, xy, xz, yy, yz, zz = values[4:]
    inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    return Payload(float(values[0]), values[1:4], inertia)


def _close(_robot: Robot, state: ClosedState, _x: Arguments, _loads: Loads) -> Answers:
    return {"s": state.s, "ds": state.ds}


def _inverse_dynamics(robot: Robot, state: ClosedState, x: Arguments, loads: Loads) -> Answers:
    return {"tau": robot.inverse_dynamics(state, x["ddu"], loads)}


def _forward_dynamics(robot: Robot, state: ClosedState, x: Arguments, loads: Loads) -> Answers:
    return {"ddu": robot.forward_dynamics(state, x["tau"], loads)}


def _minimal_form(robot: Robot, state: ClosedState, _x: Arguments, loads: Loads) -> Answers:
    return dict(zip(("M", "h", "g"), robot.minimal_form(state, loads), strict=True))


def _pose(robot: Robot, state: ClosedState, _x: Arguments, _loads: Loads) -> Answers:
    pose = robot.forward_kinematics(state)
    return {"position": pose.position, "rotation": pose.rotation}


def _jacobian(robot: Robot, state: ClosedState, _x: Arguments, _loads: Loads) -> Answers:
    return {"J": robot.jacobian(state)}


def _reactions(robot: Robot, state: ClosedState, x: Arguments, loads: Loads) -> Answers:
    reactions = robot.reactions(state, x["ddu"], loads)
    pins, joints = reactions.pins.values(), reactions.joints.values()
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


def _inverse_derivatives(robot: Robot, state: ClosedState, x: Arguments, loads: Loads) -> Answers:
    values = robot.inverse_dynamics_derivatives(state, x["ddu"], loads)
    tau = robot.inverse_dynamics(state, x["ddu"], loads)
    return dict(zip(("tau", "d_u", "d_du", "d_ddu"), (tau, *values), strict=True))


def _forward_derivatives(robot: Robot, state: ClosedState, x: Arguments, loads: Loads) -> Answers:
    values = robot.forward_dynamics_derivatives(state, x["tau"], loads)
    ddu = robot.forward_dynamics(state, x["tau"], loads)
    return dict(zip(("ddu", "d_u", "d_du", "d_tau"), (ddu, *values), strict=True))


def _ik_step(robot: Robot, state: ClosedState, x: Arguments, _loads: Loads) -> Answers:
    """A damped step by least squares of the extended system."""
    pose = robot.forward_kinematics(state)
    turn = rotation_vector(np.reshape(x["rotation"], (3, 3)) @ pose.rotation.T)
    error = np.concatenate([x["position"] - pose.position, turn])
    jacobian = x["weights"][:, None] * robot.jacobian(state)
    damping = np.sqrt(DAMPING * np.sum(jacobian**2) / state.n)
    system = np.vstack([jacobian, damping * np.eye(state.n)])
    wanted = np.concatenate([x["weights"] * error, np.zeros(state.n)])
    move = np.linalg.lstsq(system, wanted, rcond=None)[0]
    share = min(1.0, LONGEST / max(float(np.linalg.norm(move)), LONGEST))
    return {"next": state.u + share * move, "error": error}


def _generalised(_robot: Robot, state: ClosedState, x: Arguments, _loads: Loads) -> Answers:
    return {"tau": state.R.T @ x["forces"]}


def _hydraulics(robot: Robot, state: ClosedState, x: Arguments, _loads: Loads) -> Answers:
    cylinders = robot.hydraulics(state, x["tau"]).values()
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
