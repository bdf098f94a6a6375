"""The spanning tree: bodies in an order where parents come first, constants as plain floats."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..algebra.charts import FIRST
from ..algebra.live import kept
from ..algebra.scalar import Scalar
from ..algebra.transform import IDENTITY, RigidTransform, compose
from ..algebra.vector import ZERO3, Rotation, Vector, constant
from ..description.model import Frame, JointType, RobotDescription
from ..ground.arrays import Array
from ..ground.lazy import lazy
from ..ground.units import coordinate_unit
from .inertia import parallel_axis_term


@dataclass(frozen=True)
class Body:
    """A moving link with the joint that carries it.

    Attributes:
        name: name of the link.
        joint: name of the joint.
        coordinate: index of the joint in s.
        type: 'revolute' or 'prismatic'.
        parent: index of its parent body, -1 for the base.
        rotation: rotation of the body's frame in the parent's, at zero.
        translation: translation of the body's frame in the parent's, at zero [m].
        axis: unit axis of the joint, in the body's frame.
        mass: mass [kg].
        first_moment: first moment m c [kg m] about the link origin, in link axes.
        inertia: inertia [kg m^2] about the link origin, in link axes.
        limits: lower and upper limit of the joint [rad or m].
        chart: index in the tree's charts, if its orientation at zero depends on one.
        compensated_mass: mass with compensated weight [kg].
        compensated_moment: first moment of that mass [kg m], as `first_moment`.
        second_moments: exact values for `about_origin`; if None, it is computed from `inertia`.
    """

    name: str
    joint: str
    coordinate: int
    type: JointType
    parent: int
    rotation: Rotation
    translation: Vector
    axis: Vector
    mass: float
    first_moment: Vector
    inertia: Rotation
    limits: tuple[float, float]
    chart: int | None = None
    compensated_mass: float = 0.0
    compensated_moment: Vector = ZERO3
    second_moments: Rotation | None = None

    @property
    def about_origin(self) -> Rotation:
        """Second moments: the integral of p p^T over the mass about the link origin [kg m^2]."""
        if self.second_moments is not None:
            return self.second_moments
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = self.inertia
        half = 0.5 * (xx + yy + zz)
        return ((half - xx, -xy, -xz), (-xy, half - yy, -yz), (-xz, -yz, half - zz))

    @property
    def is_compensated(self) -> bool:
        """Whether some of its weight is compensated."""
        values = (self.compensated_mass, *self.compensated_moment)
        return any(not isinstance(value, float) or value for value in values)

    @property
    def is_revolute(self) -> bool:
        """Whether the joint turns; otherwise it slides."""
        return self.type == "revolute"


Turns = tuple[int, int, int]


@dataclass(frozen=True)
class Tree:
    """The spanning tree of a robot.

    Attributes:
        base: name of the base link.
        bodies: the moving links, parents first.
        coordinates: names of s, the active ones first.
        n_active: number of active coordinates.
        turns: the three turning coordinates of each ball or free joint.
        charts: the chart of each at the reference, +1 or -1.
    """

    base: str
    bodies: tuple[Body, ...]
    coordinates: tuple[str, ...]
    n_active: int
    turns: tuple[Turns, ...] = ()
    charts: tuple[float, ...] = ()

    def body_index(self, link: str) -> int:
        """Index of a link's body; -1 for the base."""
        if link == self.base:
            return -1
        return self._body_indices[link]

    @lazy
    def _body_indices(self) -> dict[str, int]:
        return {body.name: index for index, body in enumerate(self.bodies)}

    def is_revolute(self, coordinate: int) -> bool:
        """Whether a coordinate is an angle."""
        return self._types[coordinate] == "revolute"

    @lazy
    def _types(self) -> dict[int, JointType]:
        return {body.coordinate: body.type for body in self.bodies}

    def unit(self, coordinate: int) -> str:
        """Unit of a coordinate."""
        return coordinate_unit(self._types[coordinate])

    def value_text(self, coordinate: int, value: Scalar, digits: int) -> str:
        """Name, value and unit of a coordinate as text."""
        return f"{self.coordinates[coordinate]} = {float(value):.{digits}g} {self.unit(coordinate)}"

    def path(self, body: int) -> list[int]:
        """Bodies from the base to `body`, which is the last; the base is omitted."""
        chain = []
        while body >= 0:
            chain.append(body)
            body = self.bodies[body].parent
        return chain[::-1]

    def branches(self, a: int, b: int) -> tuple[list[int], list[int], int]:
        """The branches of the paths to two bodies, after their last common body.

        Returns:
            The bodies of both branches, and the last common body (-1 for the base).
        """
        path_a = self.path(a)
        path_b = self.path(b)
        shared = [x for x, y in zip(path_a, path_b, strict=False) if x == y]
        last = -1
        if shared:
            last = shared[-1]
        return path_a[len(shared) :], path_b[len(shared) :], last

    def zero_pose(self, body: int, ancestor: int = -1) -> tuple[Array, Array]:
        """The pose of a body in an ancestor's frame with every coordinate at zero.

        Args:
            body: index of the body, -1 for the base.
            ancestor: index of a body on the path to it, -1 for the base.

        Returns:
            Rotation (3, 3) and origin (3,) [m].
        """
        pose = IDENTITY
        while body != ancestor:
            link = self.bodies[body]
            pose = compose((link.rotation, link.translation), pose)
            body = link.parent
        rotation, origin = pose
        return np.array(rotation), np.array(origin)


def rows(matrix: Array) -> Rotation:
    """A (3, 3) array as tuples of floats."""
    x, y, z = (constant(row) for row in matrix)
    return x, y, z


def floats(vector: Array) -> Vector:
    """An array as a tuple of floats."""
    return tuple(map(kept, vector))


def build_tree(robot: RobotDescription) -> Tree:
    """Order the links depth first and number the coordinates.

    The active ones come first, the others as the file has them.
    """
    active = set(robot.active)
    passive = [name for name in robot.joints if name not in active]
    coordinates = (*robot.active, *passive)
    numbers = {name: number for number, name in enumerate(coordinates)}
    charts = {joint.turns[0]: chart for chart, joint in enumerate(robot.freely_turning)}
    children: dict[str, list[str]] = {}
    for name, joint in robot.joints.items():
        children.setdefault(joint.parent, []).append(name)
    bodies: list[Body] = []
    on_base = children.get(robot.base, [])
    stack = [(name, -1) for name in reversed(on_base)]
    while stack:
        name, parent = stack.pop()
        carried = children.get(robot.joints[name].child, [])
        stack += [(child, len(bodies)) for child in reversed(carried)]
        bodies.append(_body(robot, name, parent, numbers[name], charts.get(name)))
    return Tree(
        base=robot.base,
        bodies=tuple(bodies),
        coordinates=coordinates,
        n_active=len(robot.active),
        turns=tuple(_turns(joint.turns, numbers) for joint in robot.freely_turning),
        charts=tuple(robot.charts.get(joint.name, FIRST) for joint in robot.freely_turning),
    )


def _turns(joints: tuple[str, ...], numbers: Mapping[str, int]) -> Turns:
    x, y, z = (numbers[name] for name in joints)
    return x, y, z


def _body(
    robot: RobotDescription, name: str, parent: int, coordinate: int, chart: int | None
) -> Body:
    joint = robot.joints[name]
    link = robot.links[joint.child]
    about_origin = link.inertia + parallel_axis_term(link.mass, link.com)
    xx, yy, zz = (floats(row) for row in about_origin)
    return Body(
        name=joint.child,
        joint=name,
        coordinate=coordinate,
        type=joint.type,
        parent=parent,
        rotation=rows(joint.rotation),
        translation=floats(joint.translation),
        axis=constant(joint.axis),
        mass=link.mass,
        first_moment=floats(link.mass * link.com),
        inertia=(xx, yy, zz),
        limits=joint.limits,
        chart=chart,
        compensated_mass=link.compensated_mass,
        compensated_moment=floats(link.compensated_mass * link.compensated_com),
    )


def frame_offset(frame: Frame) -> RigidTransform:
    """Constants of a frame on its link."""
    return rows(frame.rotation), floats(frame.translation)
