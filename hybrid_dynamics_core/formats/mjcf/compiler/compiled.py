"""A compiled model: bodies, joints, sites, constraints, tendons, actuators, settings.

Lengths and angles are in SI units, and poses in the frame of the parent body. `line` is a line of
the text given to MuJoCo.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Body:
    """A body; number 0 is the world.

    Attributes:
        com, inertia: centre of mass, and the tensor about it in the axes of the body.
        written: mass and principal moments of an <inertial> that is used; otherwise empty.
        joints: numbers of its joints, in their order.
    """

    name: str
    line: str
    parent: int
    pos: list[float]
    quat: list[float]
    mass: float
    com: list[float]
    inertia: list[list[float]]
    is_from_shapes: bool
    written: list[float]
    gravity_compensation: float
    is_mocap: bool
    joints: list[int]


@dataclass(frozen=True)
class Joint:
    """A joint; `drawn` is its coordinate in the drawn configuration [rad or m]."""

    name: str
    line: str
    body: int
    kind: str
    pos: list[float]
    axis: list[float]
    is_limited: bool
    range: list[float]
    stiffness: float
    is_polynomial: bool
    spring_yield: float
    has_effort_range: bool
    effort_range: list[float]
    is_held_by_drives: bool
    address: int
    drawn: float
    spring_reference: float
    armature: float
    damping: float
    frictionloss: float


@dataclass(frozen=True)
class Geom:
    """A shape on a body.

    Attributes:
        kind: box, cylinder, sphere, capsule, ellipsoid or mesh; empty for others.
        mesh: file, scale, refpos and refquat of its mesh.
        size: half lengths [m], as in MuJoCo.
        colour: red, green, blue and opacity; empty if not given.
        touches: whether it has contacts.
    """

    name: str
    line: str
    body: int
    kind: str
    mesh: dict[str, Any] | None
    size: list[float]
    pos: list[float]
    quat: list[float]
    colour: list[float]
    group: int
    touches: bool


@dataclass(frozen=True)
class Site:
    """A frame on a body."""

    name: str
    line: str
    body: int
    pos: list[float]
    quat: list[float]


@dataclass(frozen=True)
class Equality:
    """A constraint between two bodies, sites, joints or tendons; the second may be -1."""

    name: str
    line: str
    kind: str
    is_between_sites: bool
    ends: list[int]
    is_active: bool
    data: list[float]


WRAP_JOINT, WRAP_PULLEY, WRAP_SITE = 1, 2, 3  # codes of MuJoCo; others are shapes


@dataclass(frozen=True)
class Tendon:
    """A tendon of the model.

    Attributes:
        wraps: (kind, number, coefficient or divisor) of joints, pulleys, sites and shapes.
        length: length in the drawn configuration.
        rest: smallest and largest length at which its spring is slack.
        forces: its stiffness, damping, friction and armature, by attribute name.
    """

    name: str
    line: str
    wraps: list[tuple[int, int, float]]
    length: float
    rest: tuple[float, float]
    forces: dict[str, float]

    @property
    def terms(self) -> list[tuple[int, float]]:
        """(joint, coefficient) of a fixed tendon; empty for a spatial one."""
        return [(number, value) for kind, number, value in self.wraps if kind == WRAP_JOINT]


@dataclass(frozen=True)
class Actuator:
    """An actuator of the model.

    Attributes:
        gain: force over control if the control is a force; otherwise 0.
        control_range, force_range: lower and upper limit, or empty.
    """

    name: str
    line: str
    kind: str
    target: int
    gear: list[float]
    group: int
    gain: float
    control_range: list[float]
    force_range: list[float]
    armature: float
    damping: float
    is_polynomial: bool


@dataclass(frozen=True)
class CompiledModel:
    """A model; `key` has the coordinates of the first keyframe, or is empty."""

    name: str
    bodies: list[Body]
    joints: list[Joint]
    geoms: list[Geom]
    sites: list[Site]
    equalities: list[Equality]
    tendons: list[Tendon]
    actuators: list[Actuator]
    key: list[float]
    gravity: list[float]
    fluid: list[float]
    disabled: list[str]
    disabled_groups: list[int]


def compiled_model(data: dict[str, Any]) -> CompiledModel:
    """A model from plain data."""
    parts = dict(data)
    for name, kind in _PARTS.items():
        parts[name] = [kind(**entry) for entry in data[name]]
    return CompiledModel(**parts)


_PARTS: dict[str, type] = {
    "bodies": Body,
    "joints": Joint,
    "geoms": Geom,
    "sites": Site,
    "equalities": Equality,
    "tendons": Tendon,
    "actuators": Actuator,
}
