"""The parameters in which tau is linear: inertias of links, friction and rotors of joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..description.model import Link, RobotDescription, effects_of
from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.suggestions import no_such_name
from .load_pattern import INERTIAL
from .pack_loads import inertial_vector

if TYPE_CHECKING:
    from .loads import JointEffects

COMPONENTS = ("m", "mx", "my", "mz", "Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz")


@dataclass(frozen=True)
class Parameters:
    """Which parameters are asked for, in order: ten a link, then one a joint for each kind.

    A link has m [kg], m c [kg m] and its inertia J about the link's origin [kg m^2], in link axes;
    a joint viscous friction, Coulomb friction and armature in the units of `JointEffects`.
    """

    links: tuple[str, ...]
    viscous: tuple[str, ...] = ()
    coulomb: tuple[str, ...] = ()
    armature: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """One name a parameter, such as 'l2.mx' or 'q1.viscous'."""
        inertial = [f"{link}.{part}" for link in self.links for part in COMPONENTS]
        return (
            *inertial,
            *(f"{joint}.{kind}" for kind in JOINT_KINDS for joint in getattr(self, kind)),
        )

    @property
    def inertial_size(self) -> int:
        """Number of inertial parameters; those of the joints come after."""
        return INERTIAL * len(self.links)

    def values(self, description: RobotDescription, effects: JointEffects | None = None) -> Array:
        """What the description says (for joints, other `effects` if given): (p,), SI units, in the order of `names`."""
        inertial = [
            inertial_vector(k.mass, k.com, k.inertia)
            for k in (description.links[name] for name in self.links)
        ]
        joints = [
            self._told(description, effects, kind, name)
            for kind in JOINT_KINDS
            for name in getattr(self, kind)
        ]
        return frozen(np.concatenate([*inertial, np.array(joints)]))

    def _told(
        self, description: RobotDescription, effects: JointEffects | None, kind: str, joint: str
    ) -> float:
        if effects is None:
            return float(getattr(effects_of(description, joint), kind))
        coordinates = (
            *description.active,
            *(name for name in description.joints if name not in description.active),
        )
        return float(getattr(effects, kind)[coordinates.index(joint)])

    def check(self, description: RobotDescription) -> None:
        """Raise InputError for names that the robot does not have."""
        for link in self.links:
            moving = [name for name in description.links if name != description.base]
            if link not in moving:
                raise InputError(no_such_name("moving link", link, moving))
        for kind in JOINT_KINDS:
            for joint in getattr(self, kind):
                if joint not in description.joints:
                    raise InputError(no_such_name("joint", joint, description.joints))


JOINT_KINDS = ("viscous", "coulomb", "armature")
_UNITS = {  # of a revolute joint, and of a prismatic one
    "viscous": ("N m s/rad", "N s/m"),
    "coulomb": ("N m", "N"),
    "armature": ("kg m^2", "kg"),
}


def parameter_unit(name: str, joint_types: Mapping[str, str]) -> str:
    """Unit of a parameter by its name, such as 'l2.mx', and of a combination that it leads."""
    joint, _, part = name.rpartition(".")
    if part in _UNITS:
        return _UNITS[part][joint_types[joint] != "revolute"]
    return "kg" if part == "m" else "kg m" if part.startswith("m") else "kg m^2"


def described_parameters(description: RobotDescription, friction: Sequence[str] = ()) -> Parameters:
    """Inertias of all links that have mass (of all, where none has), and friction of the joints named."""
    massive = tuple(
        name for name, link in description.links.items() if link.mass and name != description.base
    )
    links = massive or tuple(name for name in description.links if name != description.base)
    return Parameters(links, tuple(friction), tuple(friction))


def link_of(name: str, values: Array) -> Link:
    """A link from its ten parameters; a massless one where m is zero."""
    mass, moment = float(values[0]), np.asarray(values[1:4])
    about = np.zeros((3, 3))
    about[np.triu_indices(3)] = values[4:]
    about = about + np.triu(about, 1).T
    com = moment / mass if mass else np.zeros(3)
    inertia = about - mass * (com @ com * np.eye(3) - np.outer(com, com))
    return Link(name, mass, frozen(com), frozen((inertia + inertia.T) / 2.0))
