"""Mass matrix over joints and deformations."""

from __future__ import annotations

import numpy as np

from ..description.effects import Payload
from ..description.model import Link
from ..dynamics.loads import Loads
from ..ground.arrays import Array
from .attachments import MASS
from .posed_tree import Pose, skew
from .robot_interface import ElasticRobot
from .structure import Structure


def mass_matrix(robot: ElasticRobot, structure: Structure, loads: Loads) -> Array:
    """Mass matrix (n_s + n_e, n_s + n_e) over joints and deformations [kg, kg m, kg m^2].

    Rotors of locked drives stand still; those of other joints count.

    Args:
        robot: the robot.
        structure: its elastic structure.
        loads: only payloads and rotors count.
    """
    posed = structure.posed
    mass = np.zeros((structure.size, structure.size))
    for body, link in enumerate(posed.tree.bodies):
        data = posed.description.links[link.name]
        twists = structure.places[body, MASS]
        pose = posed.pose(body)
        mass += _of_body(data, twists, pose)
    for frame, payloads in loads.payloads.items():
        place, twists = structure.twists(frame)
        rotation = structure.frame_rotation(frame)
        pose = Pose(rotation, place.origin)
        for payload in payloads:
            mass += _of_body(payload, twists, pose)
    for k, name in enumerate(robot.coordinates):
        if name not in robot.all_drives:
            mass[k, k] += loads.effects.armature[k]
    return mass


def _of_body(body: Link | Payload, twists: Array, pose: Pose) -> Array:
    """Mass matrix of a body.

    Args:
        body: the body.
        twists: its twists about the base origin.
        pose: of the link or frame in which its inertia is given.
    """
    com = np.asarray(body.com, dtype=np.float64)
    place = pose.point(com)
    angular = twists[3:]
    carried = skew(place) @ angular
    linear = twists[:3] - carried
    to_base = pose.rotation
    local = np.asarray(body.inertia, dtype=np.float64)
    inertia = to_base @ local @ to_base.T
    moving = body.mass * linear.T @ linear
    turning = angular.T @ inertia @ angular
    sum_of_both: Array = moving + turning
    return sum_of_both
