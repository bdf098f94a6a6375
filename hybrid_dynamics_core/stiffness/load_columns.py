"""Loads as generalised forces along joints and deformations."""

from __future__ import annotations

import numpy as np

from ..dynamics.loads import AppliedWrench, Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name
from .attachments import MASS
from .machine import Machine
from .posed_tree import Pose
from .structure import Structure


def load_column(machine: Machine, structure: Structure, loads: Loads) -> Array:
    """Generalised forces (n_s + n_e,) of weights, payloads, wrenches and springs.

    Args:
        machine: the robot.
        structure: its elastic structure.
        loads: the loads.

    Raises:
        InputError: a wrench is a batch, or on a frame that is not there.
    """
    column = _weights(structure, loads.gravity)
    for frame, bodies in loads.payloads.items():
        pose, twists = _frame(machine, structure, frame)
        rotation = structure.frame_rotation(frame)
        for body in bodies:
            place = pose.origin + rotation @ np.asarray(body.com)
            column += _force(twists, place, body.mass * loads.gravity)
    for frame, wrench in loads.wrenches.items():
        pose, twists = _frame(machine, structure, frame)
        column += _wrench(structure, frame, wrench, pose, twists)
    effects = loads.effects
    spring = effects.stiffness * (structure.tree.s - effects.rest) + effects.preload
    column[: len(spring)] -= spring
    return column


def _weights(structure: Structure, gravity: Array) -> Array:
    """Weights of the links, without what is compensated."""
    robot = structure.tree.robot
    tree = structure.tree.tree
    size = structure.A_s.shape[1] + structure.A_e.shape[1]
    column = np.zeros(size)
    for body, link in enumerate(tree.bodies):
        data = robot.links[link.name]
        pose = structure.tree.pose(body)
        twists = structure.places[body, MASS]
        column += _force(twists, pose.point(data.com), data.mass * gravity)
        if data.compensated_mass:
            lifted = pose.point(data.compensated_com)
            column -= _force(twists, lifted, data.compensated_mass * gravity)
    return column


def _frame(machine: Machine, structure: Structure, frame: str) -> tuple[Pose, Array]:
    if frame not in machine.frames:
        raise InputError(no_such_name("frame", frame, machine.frames))
    return structure.twists(frame)


def _force(twists: Array, place: Array, force: Array) -> Array:
    """Generalised forces of a force (3,) at a place (3,), from twists about the base origin."""
    about_origin = np.concatenate([force, np.cross(place, force)])
    work: Array = twists.T @ about_origin
    return work


def _wrench(
    structure: Structure, frame: str, wrench: AppliedWrench, pose: Pose, twists: Array
) -> Array:
    values = wrench.values
    if values.shape != (6,):
        raise InputError(f"the wrench on '{frame}' is a batch; expected 6 numbers")
    force, moment = values[:3], values[3:]
    if wrench.axes == "frame":
        rotation = structure.frame_rotation(frame)
        force, moment = rotation @ force, rotation @ moment
    turn: Array = twists[3:].T @ moment
    return _force(twists, pose.origin, force) + turn
