"""Loads as generalised forces along joints and deformations."""

from __future__ import annotations

import numpy as np

from ..dynamics.loads import AppliedWrench, Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name
from .attachments import MASS
from .posed_tree import Pose
from .robot_interface import ElasticRobot
from .structure import Structure


def load_column(robot: ElasticRobot, structure: Structure, loads: Loads) -> Array:
    """Generalised forces (n_s + n_e,) of weights, payloads, wrenches and springs.

    Args:
        robot: the robot.
        structure: its elastic structure.
        loads: the loads.

    Raises:
        InputError: a wrench is a batch, or on a frame that is not there.
    """
    column = _weights(structure, loads.gravity)
    for frame in loads.payloads:
        _require_frame(robot, frame)
        column += _payloads(structure, loads, frame)
    for frame, wrench in loads.wrenches.items():
        _require_frame(robot, frame)
        column += _wrench(structure, frame, wrench)
    effects = loads.effects
    stretch = structure.posed.s - effects.rest
    spring = effects.stiffness * stretch + effects.preload
    column[: len(spring)] -= spring
    return column


def _require_frame(robot: ElasticRobot, frame: str) -> None:
    if frame not in robot.frames:
        raise InputError(no_such_name("frame", frame, robot.frames))


def _weights(structure: Structure, gravity: Array) -> Array:
    """Weights of the links, without what is compensated."""
    description = structure.posed.description
    column = np.zeros(structure.size)
    for body, link in enumerate(structure.posed.tree.bodies):
        data = description.links[link.name]
        pose = structure.posed.pose(body)
        twists = structure.places[body, MASS]
        weight = data.mass * gravity
        column += _force(twists, pose.point(data.com), weight)
        if data.compensated_mass:
            lift = -data.compensated_mass * gravity
            place = pose.point(data.compensated_com)
            column += _force(twists, place, lift)
    return column


def _payloads(structure: Structure, loads: Loads, frame: str) -> Array:
    """Weights of the payloads on a frame."""
    place, twists = structure.twists(frame)
    pose = Pose(structure.frame_rotation(frame), place.origin)
    column = np.zeros(structure.size)
    for body in loads.payloads[frame]:
        com = pose.point(np.asarray(body.com))
        column += _force(twists, com, body.mass * loads.gravity)
    return column


def _wrench(structure: Structure, frame: str, wrench: AppliedWrench) -> Array:
    """A wrench on a frame."""
    if wrench.values.shape != (6,):
        raise InputError(f"the wrench on '{frame}' is a batch; expected 6 numbers")
    force = wrench.values[:3]
    moment = wrench.values[3:]
    if wrench.axes == "frame":
        rotation = structure.frame_rotation(frame)
        force = rotation @ force
        moment = rotation @ moment
    pose, twists = structure.twists(frame)
    angular = twists[3:]
    turned: Array = angular.T @ moment
    return turned + _force(twists, pose.origin, force)


def _force(twists: Array, place: Array, force: Array) -> Array:
    """Generalised forces of a force (3,) at a place (3,), from twists about the base origin."""
    moment = np.cross(place, force)
    about_origin = np.concatenate([force, moment])
    work: Array = twists.T @ about_origin
    return work
