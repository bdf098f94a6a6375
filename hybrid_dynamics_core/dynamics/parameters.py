"""The parameters in which tau is linear: inertias of links, friction and rotors of joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..description.model import Link, RobotDescription, effects_of
from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.suggestions import no_such_name
from ..mechanism.inertia import parallel_axis_term
from .load_pattern import INERTIAL
from .loads import JointEffects
from .pack_loads import inertial_vector

COMPONENTS = ("m", "mx", "my", "mz", "Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz")
JOINT_KINDS = ("viscous", "coulomb", "armature")
_UNITS = {
    "viscous": {"revolute": "N m s/rad", "prismatic": "N s/m"},
    "coulomb": {"revolute": "N m", "prismatic": "N"},
    "armature": {"revolute": "kg m^2", "prismatic": "kg"},
}


@dataclass(frozen=True)
class Parameters:
    """The names of parameters, in order: ten for each link, then one for each joint and kind.

    A link has m [kg], m c [kg m] and its inertia J about the link's origin [kg m^2], in link axes.
    A joint has viscous friction, Coulomb friction and armature in the units of `JointEffects`.

    Attributes:
        links: names of links.
        viscous: names of joints whose viscous friction counts.
        coulomb: names of joints whose Coulomb friction counts.
        armature: names of joints whose rotor counts.
    """

    links: tuple[str, ...]
    viscous: tuple[str, ...] = ()
    coulomb: tuple[str, ...] = ()
    armature: tuple[str, ...] = ()

    @property
    def joints(self) -> list[tuple[str, str]]:
        """Kind and joint of the parameters of joints, in order."""
        pairs: list[tuple[str, str]] = []
        for kind in JOINT_KINDS:
            pairs += [(kind, joint) for joint in getattr(self, kind)]
        return pairs

    @property
    def names(self) -> tuple[str, ...]:
        """One name a parameter, such as 'l2.mx' or 'q1.viscous'."""
        names: list[str] = []
        for link in self.links:
            names += [f"{link}.{component}" for component in COMPONENTS]
        names += [f"{joint}.{kind}" for kind, joint in self.joints]
        return tuple(names)

    @property
    def inertial_size(self) -> int:
        """Number of inertial parameters; those of the joints come after."""
        return INERTIAL * len(self.links)

    def values(self, description: RobotDescription, effects: JointEffects | None = None) -> Array:
        """The values of the parameters in a description.

        Args:
            description: description of the robot.
            effects: friction and rotors of the joints; None for those of the description.

        Returns:
            (p,), SI units, in the order of `names`.
        """
        values: list[float] = []
        for name in self.links:
            link = description.links[name]
            values += inertial_vector(link.mass, link.com, link.inertia).tolist()
        for kind, joint in self.joints:
            if effects is None:
                values.append(float(getattr(effects_of(description, joint), kind)))
            else:
                k = _coordinates(description).index(joint)
                values.append(float(getattr(effects, kind)[k]))
        return frozen(values)

    def check(self, description: RobotDescription) -> None:
        """Raise InputError for names that the robot does not have."""
        moving = _moving_links(description)
        for link in self.links:
            if link not in moving:
                raise InputError(no_such_name("moving link", link, moving))
            if description.links[link].gravity_compensation is None:
                raise InputError(
                    f"links: gravity acts on some of the parts of '{link}' alone, so its weight"
                    " does not follow from its ten parameters; leave it out, or fix those parts by"
                    " joints of their own"
                )
        for _, joint in self.joints:
            if joint not in description.joints:
                raise InputError(no_such_name("joint", joint, description.joints))


def parameter_unit(name: str, joint_types: Mapping[str, str]) -> str:
    """Unit of a parameter by its name, such as 'l2.mx', and of a combination that it leads.

    Args:
        name: name of the parameter.
        joint_types: 'revolute' or 'prismatic' by the name of a joint.
    """
    joint, _, part = name.rpartition(".")
    if part in _UNITS:
        return _UNITS[part][joint_types[joint]]
    if part == "m":
        return "kg"
    if part.startswith("m"):
        return "kg m"
    return "kg m^2"


def described_parameters(description: RobotDescription, friction: Sequence[str] = ()) -> Parameters:
    """The inertias of all links that have mass, and the friction of some joints.

    Args:
        description: description of the robot. Where no link has mass, all links count.
        friction: names of the joints whose friction counts.
    """
    moving = _moving_links(description)
    massive = [name for name in moving if description.links[name].mass]
    return Parameters(tuple(massive or moving), tuple(friction), tuple(friction))


def link_of(name: str, values: Array) -> Link:
    """A link from its ten parameters (10,); a massless one where m is zero."""
    mass = float(values[0])
    com = np.zeros(3)
    if mass:
        com = np.asarray(values[1:4]) / mass
    about_origin = np.zeros((3, 3))
    about_origin[np.triu_indices(3)] = values[4:]
    about_origin = about_origin + np.triu(about_origin, 1).T
    inertia = about_origin - parallel_axis_term(mass, com)
    return Link(name, mass, frozen(com), frozen((inertia + inertia.T) / 2.0))


def _moving_links(description: RobotDescription) -> list[str]:
    return [name for name in description.links if name != description.base]


def _coordinates(description: RobotDescription) -> list[str]:
    """Names of all coordinates, the active ones first."""
    passive = [name for name in description.joints if name not in description.active]
    return [*description.active, *passive]
