"""Unknowns of weighing, with what is known of each before the measurement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..description.model import Frame, RobotDescription, effects_of
from ..dynamics.load_pattern import INERTIAL
from ..dynamics.parameters import COMPONENTS, Parameters, described_parameters
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot
from .tolerances import Tolerances

LOAD = tuple(f"load.{component}" for component in COMPONENTS)
SHARE_OF_REACH = 1.0 / 6.0  # default deviation of the load's centre of mass
LEAST_SIZE = 1e-300  # keeps divisions by zero finite
OPEN_MASS = 100.0  # times the rough mass of a load: a deviation that leaves its mass open
KINDS = (1, 3, 6)  # entries of a body: mass, first moment, inertia


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Unknowns with independent normal distributions before the measurement.

    Attributes:
        names: names of the p unknowns; the first ten are those of the load.
        deviation: (p,) standard deviations. Their means are zero, but perhaps those of the load.
    """

    names: tuple[str, ...]
    deviation: Array


class LoadFrame:
    """The frame that carries the load, and its inertial parameters in those of its link.

    Attributes:
        link: name of the link.
        to_link: (10, 10) parameters of the link = to_link @ parameters about the frame.
    """

    def __init__(self, description: RobotDescription, name: str) -> None:
        names = (*description.frames, *description.links)
        if name not in names:
            raise InputError(no_such_name("frame", name, names))
        frame = description.frames.get(name, Frame(name))
        if frame.link == description.base:
            raise InputError(f"frame: '{name}' is on the base, where no drive feels a load")
        self.link = frame.link
        self.to_link = _moved(np.asarray(frame.rotation), np.asarray(frame.translation))


def _moved(rotation: Array, place: Array) -> Array:
    """The map (10, 10) of inertial parameters about a frame to those about its link's origin.

    Args:
        rotation: (3, 3) of the frame on its link.
        place: origin (3,) of the frame in its link [m].
    """
    columns: list[Array] = []
    for unit in np.eye(INERTIAL):
        mass = float(unit[0])
        moment = rotation @ unit[1:4]
        about_frame = np.zeros((3, 3))
        about_frame[np.triu_indices(3)] = unit[4:]
        about_frame = about_frame + np.triu(about_frame, 1).T
        # what the place of the frame adds to second moments about the origin
        mixed = np.outer(place, moment) + np.outer(moment, place)
        moments = mass * np.outer(place, place) + mixed
        inertia = np.trace(moments) * np.eye(3) - moments
        inertia = inertia + rotation @ about_frame @ rotation.T
        first_moment = moment + mass * place
        columns.append(np.concatenate([[mass], first_moment, inertia[np.triu_indices(3)]]))
    return np.stack(columns, axis=1)


def parameters_of(robot: Robot, drives: tuple[str, ...]) -> Parameters:
    """The parameters that are unknown: those of links, and friction of drives and of joints."""
    description = robot.description
    links = list(described_parameters(description).links)
    joints: list[str] = []
    for name in robot.coordinates:
        effect = effects_of(description, name)
        if name in drives or effect.viscous or effect.coulomb:
            joints.append(name)
    return Parameters(tuple(links), tuple(joints), tuple(joints))


def link_deviations(parameters: Parameters, values: Array, share: float) -> Array:
    """Deviations (10 n_links,) of the inertial parameters of links [kg, kg m, kg m^2].

    Args:
        parameters: names of the parameters.
        values: (p,) their values.
        share: deviations of the parameters, as a share.
    """
    deviations: list[float] = []
    for k in range(0, parameters.inertial_size, INERTIAL):
        mass = float(np.abs(values[k]))
        moment = float(np.linalg.norm(values[k + 1 : k + 4]))
        inertia = float(np.abs(values[k + 4 : k + INERTIAL]).max())
        sizes = share * np.array([mass, moment, inertia])
        deviations += np.repeat(sizes, KINDS).tolist()
    return np.array(deviations)


def friction_deviations(
    robot: Robot, parameters: Parameters, sizes: Array, drives: tuple[str, ...], limits: Tolerances
) -> Array:
    """Deviations of viscous and Coulomb friction, in the order of `parameters.joints`.

    Args:
        robot: the robot.
        parameters: names of the parameters.
        sizes: (k, 2) mean effort of each drive [N m, N], and its mean rate [rad/s, m/s].
        drives: names of the k drives.
        limits: tolerances of the model.

    Returns:
        Deviations of Coulomb friction [N m, N] and of viscous friction [N m s/rad, N s/m].
    """
    deviations: list[float] = []
    for kind, joint in parameters.joints:
        effect = effects_of(robot.description, joint)
        deviation = limits.friction * float(getattr(effect, kind))
        if joint in drives and not effect.viscous and not effect.coulomb:
            effort, rate = sizes[drives.index(joint)]
            deviation = limits.unlisted_friction * effort
            if kind == "viscous":
                deviation /= max(rate, LEAST_SIZE)
        deviations.append(deviation)
    return np.array(deviations)


def share_deviations(robot: Robot, drives: tuple[str, ...], limits: Tolerances) -> Array:
    """Deviations (k,) of friction as a share of each drive's force; zero where the file has one."""
    deviations: list[float] = []
    for drive in drives:
        effect = effects_of(robot.description, drive)
        listed = effect.viscous or effect.coulomb
        deviations.append(0.0 if listed else limits.friction_share)
    return np.array(deviations)


def load_deviations(scale: float, com: float) -> Array:
    """Deviations (10,) of a load's parameters about its frame [kg, kg m, kg m^2].

    Args:
        scale: rough mass of the load [kg]; the mass itself is left open.
        com: deviation of the centre of mass [m].
    """
    mass = max(scale, LEAST_SIZE)
    inertia = mass * com**2
    return np.repeat([OPEN_MASS * mass, mass * com, inertia], KINDS)
