"""Loads as generalised forces along joints and deformations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..dynamics.loads import AppliedWrench, Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name
from .attachments import MASS
from .posed_tree import Pose
from .robot_interface import ElasticRobot
from .structure import Structure


@dataclass(frozen=True, eq=False)
class Acting:
    """A force and a moment on a place of a robot.

    Attributes:
        twists: (6, n_s + n_e) of the place, about the base origin.
        place: (3,) where the force acts [m].
        force: (3,) base axes [N].
        moment: (3,) base axes [N m].
        turns: whether both turn with the place.
    """

    twists: Array
    place: Array
    force: Array
    moment: Array
    turns: bool = False

    def column(self) -> Array:
        """Generalised forces (n_s + n_e,)."""
        moment = self.moment + np.cross(self.place, self.force)
        about_origin = np.concatenate([self.force, moment])
        work: Array = self.twists.T @ about_origin
        return work


def load_column(robot: ElasticRobot, structure: Structure, loads: Loads) -> Array:
    """Generalised forces (n_s + n_e,) of weights, payloads, wrenches and springs.

    Args:
        robot: the robot.
        structure: its elastic structure.
        loads: the loads.

    Raises:
        InputError: a wrench is a batch, or on a frame that is not there.
    """
    column = np.zeros(structure.size)
    for acting in acting_wrenches(robot, structure, loads):
        column += acting.column()
    effects = loads.effects
    stretch = structure.posed.s - effects.rest
    spring = effects.stiffness * stretch + effects.preload
    column[: len(spring)] -= spring
    return column


def acting_wrenches(robot: ElasticRobot, structure: Structure, loads: Loads) -> list[Acting]:
    """Weights, payloads and wrenches.

    Args:
        robot: the robot.
        structure: its elastic structure.
        loads: the loads.

    Raises:
        InputError: a wrench is a batch, or on a frame that is not there.
    """
    acting = _weights(structure, loads.gravity)
    for frame in loads.payloads:
        _require_frame(robot, frame)
        acting += _payloads(structure, loads, frame)
    for frame, wrench in loads.wrenches.items():
        _require_frame(robot, frame)
        acting.append(_wrench(structure, frame, wrench))
    return acting


def _require_frame(robot: ElasticRobot, frame: str) -> None:
    if frame not in robot.frames:
        raise InputError(no_such_name("frame", frame, robot.frames))


def _weights(structure: Structure, gravity: Array) -> list[Acting]:
    """Weights of the links, without what is compensated."""
    description = structure.posed.description
    acting: list[Acting] = []
    for body, link in enumerate(structure.posed.tree.bodies):
        data = description.links[link.name]
        pose = structure.posed.pose(body)
        twists = structure.places[body, MASS]
        acting.append(_force(twists, pose.point(data.com), data.mass * gravity))
        if data.compensated_mass:
            place = pose.point(data.compensated_com)
            acting.append(_force(twists, place, -data.compensated_mass * gravity))
    return acting


def _payloads(structure: Structure, loads: Loads, frame: str) -> list[Acting]:
    """Weights of the payloads on a frame."""
    place, twists = structure.twists(frame)
    pose = Pose(structure.frame_rotation(frame), place.origin)
    acting: list[Acting] = []
    for body in loads.payloads[frame]:
        com = pose.point(np.asarray(body.com))
        acting.append(_force(twists, com, body.mass * loads.gravity))
    return acting


def _wrench(structure: Structure, frame: str, wrench: AppliedWrench) -> Acting:
    """A wrench on a frame."""
    if wrench.values.shape != (6,):
        raise InputError(f"the wrench on '{frame}' is a batch; expected 6 numbers")
    force = wrench.values[:3]
    moment = wrench.values[3:]
    turns = wrench.axes == "frame"
    if turns:
        rotation = structure.frame_rotation(frame)
        force = rotation @ force
        moment = rotation @ moment
    pose, twists = structure.twists(frame)
    return Acting(twists, pose.origin, force, moment, turns)


def _force(twists: Array, place: Array, force: Array) -> Acting:
    """A force (3,) at a place (3,) that keeps its direction."""
    return Acting(twists, place, force, np.zeros(3))
