"""What the library says to the programs of C code that are written on request, for batches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.formats.c.calls import CALLS
from hybrid_dynamics_core.kinematics.pose import rotation_vector
from hybrid_dynamics_core.programs import HYDRAULICS
from hybrid_dynamics_core.programs.steps import DAMPING

Values = np.ndarray
Answers = Mapping[str, tuple[list[Values], list[Values]]]


def names_for(robot: Robot) -> list[str]:
    """The programs on request that a robot has."""
    return [call.name for call in CALLS if call.on_request and not call.lacks(robot)]


def requested(robot: Robot, state: ClosedState, seed: int) -> Answers:
    """Inputs (N, size) and outputs (N, ...) of the programs on request, by the library."""
    rng = np.random.default_rng(seed)
    ddu, tau = rng.uniform(-1.0, 1.0, (2, *state.u.shape))
    forces = rng.uniform(-1.0, 1.0, state.s.shape)
    g = np.tile(robot.loads.gravity, (len(state.u), 1))
    u, du = state.u, state.du
    efforts = np.einsum("nij,ni->nj", state.R, forces)
    inverse = robot.inverse_dynamics(state, ddu), *robot.inverse_dynamics_derivatives(state, ddu)
    answers = {
        "generalised_forces": ([u, forces], [efforts]),
        "inverse_dynamics_derivatives": ([u, du, ddu, g], list(inverse)),
        "ik_step": _steps(robot, state, rng),
    }
    if "reactions" in names_for(robot):
        moved = robot.forward_dynamics(state, tau)
        forward = moved, *robot.forward_dynamics_derivatives(state, tau)
        answers["forward_dynamics_derivatives"] = ([u, du, tau, g], list(forward))
        answers["reactions"] = ([u, du, ddu, g], _reactions(robot, state, ddu))
    if robot.cylinders:
        cylinders = robot.hydraulics(state, tau).values()
        columns = [np.stack([getattr(x, name) for x in cylinders], 1) for name in HYDRAULICS]
        answers["hydraulics"] = ([u, du, tau], columns)
    return answers


def _reactions(robot: Robot, state: ClosedState, ddu: Values) -> list[Values]:
    answer = robot.reactions(state, ddu)
    pins, joints = list(answer.pins.values()), list(answer.joints.values())
    parts = [answer.tau]
    if pins:
        parts += _side_by_side(pins, ("place", "force", "moment", "share"))
    parts += _side_by_side(joints, ("place", "force", "moment"))
    return [*parts, answer.base]


def _side_by_side(answers: Sequence[object], names: Sequence[str]) -> list[Values]:
    return [np.stack([getattr(x, name) for x in answers], axis=1) for name in names]


def _steps(
    robot: Robot, state: ClosedState, rng: np.random.Generator
) -> tuple[list[Values], list[Values]]:
    """Steps of damped least squares: the extended system, solved by the pseudoinverse."""
    pose, jacobian = robot.forward_kinematics(state), robot.jacobian(state)
    count = len(state.u)
    place = pose.position + rng.uniform(-0.1, 0.1, (count, 3))
    turned = np.linalg.qr(np.eye(3) + rng.uniform(-0.2, 0.2, (count, 3, 3)))[0]
    turned = turned * np.sign(np.einsum("nii->ni", turned))[:, None] @ pose.rotation
    weights = rng.uniform(0.0, 1.0, (count, 6))
    turns = rotation_vector(turned @ np.swapaxes(pose.rotation, -1, -2))
    error = np.concatenate([place - pose.position, turns], axis=1)
    moves = []
    for row, weight, wanted in zip(jacobian, weights, error, strict=True):
        system = weight[:, None] * row
        damping = np.sqrt(DAMPING * np.sum(system**2) / state.n)
        extended = np.vstack([system, damping * np.eye(state.n)])
        move = np.linalg.pinv(extended) @ np.concatenate([weight * wanted, np.zeros(state.n)])
        moves.append(move * min(1.0, 0.2 / np.linalg.norm(move)))
    inputs = [state.u, place, np.reshape(turned, (count, 9)), weights]
    return inputs, [state.u + np.array(moves), error]
