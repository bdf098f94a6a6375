"""The inner form of a robot: a tree of links on one-degree-of-freedom joints, tied by loop closures. Frozen data.

SI units, radians, right-handed frames (REP 103). Arrays are read-only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from ..errors import DescriptionError
from ..ground.arrays import Array, Picklable, frozen
from ..ground.suggestions import with_warnings
from .actuators import HydraulicCylinder
from .effects import JointEffect, Payload

JointType = Literal["revolute", "prismatic"]
ClosureKind = Literal["planar", "point", "axis", "frame"]
ActiveSet = Literal["exact", "motors"]


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame fixed to a link: `rotation` (3, 3) and `translation` (3,) [m] take its coordinates to the link's."""

    link: str
    rotation: Array = field(default_factory=lambda: frozen(np.eye(3)))
    translation: Array = field(default_factory=lambda: frozen(np.zeros(3)))


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body: mass [kg], centre of mass [m] and inertia about it [kg m^2], both in the link frame."""

    name: str
    mass: float = 0.0
    com: Array = field(default_factory=lambda: frozen(np.zeros(3)))
    inertia: Array = field(default_factory=lambda: frozen(np.zeros((3, 3))))


@dataclass(frozen=True, eq=False)
class Joint:
    """One degree of freedom between two links.

    At zero the child frame stands at (`rotation`, `translation`) in the parent frame; the joint
    turns it about, or moves it along, the unit `axis` (given in the child frame, which the joint
    leaves unchanged). `limits`: (lower, upper) [rad or m], infinite where the file gives none.
    """

    name: str
    type: JointType
    parent: str
    child: str
    rotation: Array
    translation: Array
    axis: Array
    limits: tuple[float, float] = (-math.inf, math.inf)


@dataclass(frozen=True, eq=False)
class Mimic:
    """A joint that follows another one: q = multiplier * q_source + offset, one equation between coordinates."""

    source: str
    multiplier: float = 1.0
    offset: float = 0.0  # [rad or m]


@dataclass(frozen=True, eq=False)
class Closure:
    """Ties a frame of `link_a` to a frame of `link_b`; what coincides is said by `kind`.

    planar: the two points, in the plane of the loop (2 equations, a pin of a planar loop); point:
    the two points (3, a spherical joint); axis: the points and the z axes (5, a revolute joint);
    frame: everything (6, a weld). More equations than the loop needs are found by rank, where they
    agree.
    """

    name: str
    link_a: str
    point_a: Array  # [m] in link_a
    link_b: str
    point_b: Array  # [m] in link_b
    kind: ClosureKind = "planar"
    rotation_a: Array = field(
        default_factory=lambda: frozen(np.eye(3))
    )  # (3, 3) closure frame to link_a
    rotation_b: Array = field(default_factory=lambda: frozen(np.eye(3)))
    assembly: str | None = None  # name of an assembly mode; None: the one nearest the reference


@dataclass(frozen=True, eq=False)
class Loop:
    """A four-bar loop as Chu et al. (2020) write it: links l_(i-1), l_i, l_k1, l_k2 and its type letter.

    Type A: l_i hangs on the base, l_k2 on l_k1; the pin ties l_k2 to l_i; the arm goes on from l_i.
    Type B: l_i hangs on the base, l_k2 on l_i; the pin ties l_k1 to l_k2; the arm goes on from
    l_k2. Type C is B, and D is A, with l_i and l_k2 exchanged. l_k1 always hangs on the base.
    """

    name: str
    type: str
    base: str
    arm: str
    k1: str
    k2: str


@dataclass(frozen=True, eq=False)
class RobotDescription(Picklable):
    """Everything a file says of a robot, checked; `coordinates` are `active` then the rest in file order."""

    name: str
    source: str
    gravity: Array
    base: str
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    closures: tuple[Closure, ...]
    loops: Mapping[str, Loop]
    active: tuple[str, ...]
    end_effector: str
    frames: Mapping[str, Frame]
    reference: Mapping[str, float] = field(default_factory=dict)
    active_set: ActiveSet = (
        "exact"  # "motors": independent coordinates are found from the motors by rank
    )
    mimics: Mapping[str, Mimic] = field(default_factory=dict)  # by the joint that follows
    file: str | Path | None = None
    lines: Mapping[str, int] = field(default_factory=dict)  # where each entry stands, by dotted key
    files: Mapping[str, str | Path | None] = field(
        default_factory=dict
    )  # of entries that stand in another file
    notes: tuple[str, ...] = ()  # what the loader assumed or left out, one sentence each
    warnings: tuple[
        str, ...
    ] = ()  # those of the notes that tell of what is allowed and hardly meant, with its place
    effects: Mapping[str, JointEffect] = field(
        default_factory=dict
    )  # by joint, where the file gives any
    payloads: Mapping[str, tuple[str, Payload]] = field(
        default_factory=dict
    )  # frame and body by name
    actuators: Mapping[str, HydraulicCylinder] = field(default_factory=dict)  # by joint
    parts: Mapping[str, Link] = field(
        default_factory=dict
    )  # links fixed to others, in whose frame and data they are

    def body_of(self, part: str) -> str:
        """The link of which a part is one; `frames` tells where on it."""
        return self.frames[part].link

    def closure_key(self, closure: str) -> str:
        """The key under which the file gives a closure: a loop of Type A to D, a closure of its own, or a follower."""
        if closure in self.mimics and f"closures.{closure}" not in self.lines:
            return f"joints.{closure}.mimic"
        return f"loops.{closure}" if closure in self.loops else f"closures.{closure}"

    def error(self, key: str, problem: str) -> DescriptionError:
        """A DescriptionError that points at an entry, or at the nearest one around it, and tells what was doubted."""
        near = key
        while near and near not in self.lines:
            near = near.rpartition(".")[0]
        file = self.files.get(near, self.file)
        return DescriptionError(
            with_warnings(problem, self.warnings), key=key, file=file, line=self.lines.get(near)
        )


def effects_of(description: RobotDescription, joint: str) -> JointEffect:
    """What the description says acts along a joint."""
    return description.effects.get(joint, JointEffect())
