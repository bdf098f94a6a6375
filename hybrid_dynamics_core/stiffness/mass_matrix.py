"""Mass matrix over joints and deformations."""

from __future__ import annotations

import numpy as np

from ..dynamics.loads import Loads
from ..ground.arrays import Array
from .attachments import MASS
from .machine import Machine
from .posed_tree import Pose, skew
from .structure import Structure


def mass_matrix(machine: Machine, structure: Structure, loads: Loads) -> Array:
    """Mass matrix (n_s + n_e, n_s + n_e) over joints and deformations [kg, kg m, kg m^2].

    Rotors of locked drives stand still; those of other joints count.

    Args:
        machine: the robot.
        structure: its elastic structure.
        loads: only payloads and rotors count.
    """
    tree = structure.tree
    mass = np.zeros((structure.size, structure.size))
    for body, link in enumerate(tree.tree.bodies):
        data = tree.robot.links[link.name]
        twists = structure.places[body, MASS]
        solid = _Body(data.mass, data.com, data.inertia)
        mass += solid.matrix(twists, tree.pose(body))
    for frame, payloads in loads.payloads.items():
        place, twists = structure.twists(frame)
        rotation = structure.frame_rotation(frame)
        pose = Pose(rotation, place.origin)
        for payload in payloads:
            com = np.asarray(payload.com)
            inertia = np.asarray(payload.inertia)
            mass += _Body(payload.mass, com, inertia).matrix(twists, pose)
    for k, name in enumerate(machine.coordinates):
        if name not in machine.all_drives:
            mass[k, k] += loads.effects.armature[k]
    return mass


class _Body:
    """A body with its inertia in the axes of a link or frame."""

    def __init__(self, mass: float, com: Array, inertia: Array) -> None:
        self.mass = mass
        self.com = com
        self.inertia = inertia

    def matrix(self, twists: Array, pose: Pose) -> Array:
        """Its mass matrix, from its twists about the base origin."""
        place = pose.point(self.com)
        angular = twists[3:]
        linear = twists[:3] - skew(place) @ angular
        inertia = pose.rotation @ self.inertia @ pose.rotation.T
        moving = self.mass * linear.T @ linear
        turning = angular.T @ inertia @ angular
        sum_of_both: Array = moving + turning
        return sum_of_both
