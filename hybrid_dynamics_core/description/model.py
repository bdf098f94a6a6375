"""A robot as immutable data: links, joints of one degree of freedom, and loop closures.

SI units, radians, right-handed frames (REP 103). Arrays are read-only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..algebra.charts import FIRST, angles_in
from ..errors import DescriptionError
from ..ground.arrays import Array, Picklable, frozen
from ..ground.suggestions import with_warnings
from .actuators import EffortTable, HydraulicCylinder, Pump, Transmission
from .effects import JointEffect, Payload
from .elasticity import Elasticity

JointType = Literal["revolute", "prismatic"]
MultiDofType = Literal["universal", "cylindrical", "planar", "ball", "free", "screw"]
ClosureKind = Literal["planar", "point", "axis", "frame"]
ActiveSet = Literal["exact", "motors"]
VisualShape = Literal["box", "cylinder", "sphere", "capsule", "ellipsoid", "mesh"]
Colour = tuple[float, float, float, float]  # red, green, blue, opacity, from 0 to 1

END_EFFECTOR = "end_effector"  # the name of the end effector's frame in calls

_ROUNDING = 1e-12  # relative: of sums of places
_IDENTITY = frozen(np.eye(3))
_ZERO_VECTOR = frozen(np.zeros(3))
_ZERO_MATRIX = frozen(np.zeros((3, 3)))


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame fixed to a link.

    Attributes:
        link: name of the link.
        rotation: (3, 3) takes coordinates of the frame to those of the link.
        translation: (3,) [m] origin of the frame, in the link frame.
    """

    link: str
    rotation: Array = field(default_factory=lambda: _IDENTITY)
    translation: Array = field(default_factory=lambda: _ZERO_VECTOR)


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body.

    Attributes:
        name: name of the link.
        mass: [kg].
        com: (3,) [m] centre of mass, in the link frame.
        inertia: (3, 3) [kg m^2] about the centre of mass, in the axes of the link frame.
        compensated_mass: [kg] whose weight the robot does not feel.
        compensated_com: (3,) [m] centre of that mass, in the link frame.
    """

    name: str
    mass: float = 0.0
    com: Array = field(default_factory=lambda: _ZERO_VECTOR)
    inertia: Array = field(default_factory=lambda: _ZERO_MATRIX)
    compensated_mass: float = 0.0
    compensated_com: Array = field(default_factory=lambda: _ZERO_VECTOR)

    @property
    def gravity_compensation(self) -> float | None:
        """The compensated share of the weight; None if parts have different shares."""
        if not self.compensated_mass:
            return 0.0
        apart = float(np.abs(self.compensated_com - self.com).max())
        reach = max(float(np.abs(self.com).max()), float(np.abs(self.compensated_com).max()))
        if not self.mass or apart > _ROUNDING * reach:
            return None
        return self.compensated_mass / self.mass


@dataclass(frozen=True, eq=False)
class Visual:
    """A shape by which pictures show a link; it has no part in the mechanics.

    Its middle is the origin of its frame. Cylinders and capsules stand along z.

    Attributes:
        shape: kind of the shape.
        size: (k,) [m] box: lengths along x, y, z; cylinder: radius, length; sphere: radius;
            capsule: radius, length without its caps; ellipsoid: three radii. Of a mesh its scale
            along x, y, z, which multiplies what the file has.
        frame: pose on a moving link or the base.
        colour: colour; None if the description has none.
        uri: file of a mesh as in the description: a path, package:// or model://.
        file: path of a mesh file; None if no file may be read.
    """

    shape: VisualShape
    size: tuple[float, ...]
    frame: Frame
    colour: Colour | None = None
    uri: str = ""
    file: Path | None = None


@dataclass(frozen=True, eq=False)
class Joint:
    """One degree of freedom between two links.

    At zero the child frame stands at (`rotation`, `translation`) in the parent frame. The joint
    turns it about its axis, or moves it along that.

    Attributes:
        name: name of the joint.
        type: revolute or prismatic.
        parent: link that carries the joint.
        child: link that the joint moves.
        rotation: (3, 3) from the child frame to the parent frame, at zero.
        translation: (3,) [m] origin of the child frame in the parent frame, at zero.
        axis: (3,) unit vector in the child frame, which the joint leaves unchanged.
        limits: (lower, upper) [rad or m], infinite if none are given.
        effort_limit: largest effort of its drive [N m or N], infinite if none is given.
        velocity_limit: largest rate of the coordinate [rad/s or m/s], infinite if none is given.
        power_limit: largest power of its drive [W], infinite if none is given.
        acceleration_limit: largest acceleration [rad/s^2 or m/s^2], infinite if none is given.
        effort_table: largest effort over rate and position; None if none is given. `effort_limit`
            is not above its largest entry.
    """

    name: str
    type: JointType
    parent: str
    child: str
    rotation: Array
    translation: Array
    axis: Array
    limits: tuple[float, float] = (-math.inf, math.inf)
    effort_limit: float = math.inf
    velocity_limit: float = math.inf
    power_limit: float = math.inf
    acceleration_limit: float = math.inf
    effort_table: EffortTable | None = None


@dataclass(frozen=True, eq=False)
class MultiDofJoint:
    """A joint of several freedoms: a chain of joints of one freedom on massless links.

    The last three joints of a ball or free joint are intrinsic rotations about x, y and z of its
    frame.

    Attributes:
        name: name of the joint.
        type: type of the joint.
        parent: link that carries it.
        child: link that it moves.
        joints: names of the joints in the chain, from parent to child.
    """

    name: str
    type: MultiDofType
    parent: str
    child: str
    joints: tuple[str, ...]

    @property
    def turns(self) -> tuple[str, ...]:
        """The three angles of a ball or free joint; empty for other types."""
        if self.type in ("ball", "free"):
            return self.joints[-3:]
        return ()


@dataclass(frozen=True, eq=False)
class Mimic:
    """A joint that follows others: q = sum of multiplier * q_source + offset.

    Attributes:
        multipliers: by the name of each followed joint.
        offset: coordinate [rad or m] with the followed joints at zero.
    """

    multipliers: Mapping[str, float]
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Closure:
    """Ties a frame of `link_a` to a frame of `link_b`; `kind` says what coincides.

    planar: the two points, in the plane of the loop (2 equations, a pin of a planar loop).
    point: the two points (3, a spherical joint).
    axis: the points and the z axes (5, a revolute joint).
    frame: everything (6, a weld).
    Redundant equations are found by their rank. They must agree with the others.

    Attributes:
        name: name of the closure.
        link_a, link_b: the two links.
        point_a, point_b: (3,) [m] origins of the two frames, each in its link frame.
        kind: kind of the constraint.
        rotation_a, rotation_b: (3, 3) from the two frames to their link frames.
        assembly: name of an assembly mode; None for the one nearest the reference.
    """

    name: str
    link_a: str
    point_a: Array
    link_b: str
    point_b: Array
    kind: ClosureKind = "planar"
    rotation_a: Array = field(default_factory=lambda: _IDENTITY)
    rotation_b: Array = field(default_factory=lambda: _IDENTITY)
    assembly: str | None = None

    def frames(self) -> tuple[Frame, Frame]:
        """The two frames, each on its link."""
        frame_a = Frame(self.link_a, self.rotation_a, self.point_a)
        frame_b = Frame(self.link_b, self.rotation_b, self.point_b)
        return frame_a, frame_b


@dataclass(frozen=True, eq=False)
class Loop:
    """A four-bar loop of Type A to D, Chu et al. (2020), with the links l_(i-1), l_i, l_k1, l_k2.

    The parent of l_k1 is always the base. Type A: parents are the base for l_i and l_k1 for l_k2.
    The pin ties l_k2 to l_i. The arm continues on l_i. Type B: parents are the base for l_i and l_i
    for l_k2. The pin ties l_k1 to l_k2. The arm continues on l_k2. Type C is B, and type D is A,
    with l_i and l_k2 exchanged.

    Attributes:
        name: name of the loop, and of the closure that is its pin.
        type: "A" to "D".
        base: the link l_(i-1).
        arm: the link l_i.
        k1: the link l_k1.
        k2: the link l_k2.
    """

    name: str
    type: str
    base: str
    arm: str
    k1: str
    k2: str


@dataclass(frozen=True, eq=False)
class RobotDescription(Picklable):
    """The checked content of a robot file.

    The coordinates of the robot are those of `active`, then the others in the order of the file.

    Attributes:
        name: name of the robot.
        source: source of its numbers.
        gravity: (3,) [m/s^2] in the base frame.
        base: name of the base link.
        links: moving links by name; links fixed to them are merged into them.
        joints: joints by name.
        closures, loops: those that close the loops, and which of them are of Type A to D, by name.
        active: the independent coordinates u, in order: driven joints, then idle ones.
        end_effector: name of its frame.
        frames: frames by name, including those of fixed links and of the end effector.
        reference: coordinates of the reference configuration [rad or m], by joint.
        idle: those of `active` that have no drive.
        active_set: "motors" if the independent coordinates are found from the motors by rank.
        mimics: couplings by following joint.
        multi_dof: joints of several freedoms by name; `joints` has the joints of their chains.
        charts: chart of ball and free joints at the reference, +1 or -1; +1 for joints not listed.
        file: the file that the description was read from.
        lines, files: line of each entry, and file if it comes from another one, by dotted key.
        notes: sentences on assumptions and omissions of the loader.
        warnings: notes on entries that are allowed but likely wrong.
        impossible: problem of each inertia that no rigid body has, by dotted key; used as given.
        effects: friction, rotors and springs, by joint.
        payloads: frame and body by name.
        actuators: cylinders by joint.
        transmissions: drives that move several joints, by name.
        parts: links fixed to others, each in the frame of the body that it is merged into.
        alone: links before merging, for those of `links` that have parts.
        visuals: shapes for pictures, by the link or part that has them.
        pumps: pumps that feed several cylinders, by name.
        stiffness: what of it is elastic.
        written: the document that it was built from; None if it was made or changed by a program.
    """

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
    idle: tuple[str, ...] = ()
    active_set: ActiveSet = "exact"
    mimics: Mapping[str, Mimic] = field(default_factory=dict)
    multi_dof: Mapping[str, MultiDofJoint] = field(default_factory=dict)
    charts: Mapping[str, float] = field(default_factory=dict)
    file: str | Path | None = None
    lines: Mapping[str, int] = field(default_factory=dict)
    files: Mapping[str, str | Path | None] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    impossible: Mapping[str, str] = field(default_factory=dict)
    effects: Mapping[str, JointEffect] = field(default_factory=dict)
    payloads: Mapping[str, tuple[str, Payload]] = field(default_factory=dict)
    actuators: Mapping[str, HydraulicCylinder] = field(default_factory=dict)
    transmissions: Mapping[str, Transmission] = field(default_factory=dict)
    parts: Mapping[str, Link] = field(default_factory=dict)
    alone: Mapping[str, Link] = field(default_factory=dict)
    visuals: Mapping[str, tuple[Visual, ...]] = field(default_factory=dict)
    pumps: Mapping[str, Pump] = field(default_factory=dict)
    stiffness: Elasticity = field(default_factory=Elasticity)
    written: Any = field(default=None, init=False, repr=False)

    @property
    def freely_turning(self) -> tuple[MultiDofJoint, ...]:
        """All ball and free joints."""
        return tuple(joint for joint in self.multi_dof.values() if joint.turns)

    @property
    def angles_in_rows(self) -> frozenset[str]:
        """The three turning coordinates of each ball and free joint."""
        return frozenset(name for joint in self.freely_turning for name in joint.turns)

    @property
    def links_in_rows(self) -> frozenset[str]:
        """Massless links inside the chains of joints of several freedoms."""
        links: set[str] = set()
        for joint in self.multi_dof.values():
            links.update(self.joints[name].child for name in joint.joints[:-1])
        return frozenset(links)

    @property
    def plain_reference(self) -> Mapping[str, float]:
        """The reference with every ball and free joint in the chart +1, as in files."""
        reference = dict(self.reference)
        for joint in self.freely_turning:
            chart = self.charts.get(joint.name, FIRST)
            if chart != FIRST:
                angles = np.array([reference.get(name, 0.0) for name in joint.turns])
                plain = angles_in(angles, chart, FIRST).tolist()
                reference.update(zip(joint.turns, plain, strict=True))
        return reference

    @property
    def motors(self) -> tuple[str, ...]:
        """The driven coordinates among `active`."""
        return tuple(name for name in self.active if name not in self.idle)

    def joint_to(self) -> dict[str, Joint]:
        """The joint that moves each link, by the link."""
        return {joint.child: joint for joint in self.joints.values()}

    def body_of(self, part: str) -> str:
        """The link that a part is merged into; `frames` has its pose there."""
        return self.frames[part].link

    def visuals_on(self, body: str) -> tuple[Visual, ...]:
        """The shapes that move with a link: its own, and those of its parts."""
        everything = chain.from_iterable(self.visuals.values())
        return tuple(visual for visual in everything if visual.frame.link == body)

    def closure_key(self, closure: str) -> str:
        """The dotted key of a closure, loop or following joint in the file."""
        if closure in self.mimics and f"closures.{closure}" not in self.lines:
            return f"joints.{closure}.mimic"
        if closure in self.loops:
            return f"loops.{closure}"
        return f"closures.{closure}"

    def error(self, key: str, problem: str) -> DescriptionError:
        """A DescriptionError at an entry, or at the nearest enclosing one, with all warnings."""
        located_key = key
        while located_key and located_key not in self.lines:
            located_key = located_key.rpartition(".")[0]
        return DescriptionError(
            with_warnings(problem, self.warnings),
            key=key,
            file=self.files.get(located_key, self.file),
            line=self.lines.get(located_key),
        )


def effects_of(description: RobotDescription, joint: str) -> JointEffect:
    """Friction, rotor and spring of a joint; all zero if the description gives none."""
    return description.effects.get(joint, JointEffect())
