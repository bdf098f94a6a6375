"""The spanning tree: bodies in an order where parents come first, with constants as plain floats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..algebra.scalar import Scalar
from ..algebra.transform import IDENTITY, compose
from ..algebra.vector import Rotation, Vector, constant
from ..description.model import Frame, JointType, RobotDescription
from ..ground.arrays import Array
from ..ground.units import coordinate_unit


@dataclass(frozen=True)
class Body:
    """A moving link with the joint that carries it.

    `rotation`, `translation`: child frame in the parent frame at zero; `axis` in the child frame;
    `coordinate`: index in s; `parent`: index of a body, -1 for the base. Inertia: mass, first
    moment m c and inertia about the link origin, in link axes.
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

    @property
    def is_revolute(self) -> bool:
        """Whether the joint turns; otherwise it slides."""
        return self.type == "revolute"


@dataclass(frozen=True)
class Tree:
    """Bodies, parents first; `coordinates` are the names of s, of which the first `n_active` are u."""

    base: str
    bodies: tuple[Body, ...]
    coordinates: tuple[str, ...]
    n_active: int

    def body_index(self, link: str) -> int:
        """Index of a link's body; -1 for the base."""
        return (
            -1
            if link == self.base
            else next(i for i, b in enumerate(self.bodies) if b.name == link)
        )

    def is_revolute(self, coordinate: int) -> bool:
        """Whether a coordinate is an angle."""
        return next(b.type for b in self.bodies if b.coordinate == coordinate) == "revolute"

    def unit(self, coordinate: int) -> str:
        """Unit of a coordinate."""
        return coordinate_unit("revolute" if self.is_revolute(coordinate) else "prismatic")

    def value_text(self, coordinate: int, value: Scalar, digits: int) -> str:
        """Name, value and unit of a coordinate, for people."""
        return f"{self.coordinates[coordinate]} = {float(value):.{digits}g} {self.unit(coordinate)}"

    def path(self, body: int) -> list[int]:
        """Bodies from the base to `body`, both ends as they are (base left out)."""
        chain = []
        while body >= 0:
            chain.append(body)
            body = self.bodies[body].parent
        return chain[::-1]

    def branches(self, a: int, b: int) -> tuple[list[int], list[int], int]:
        """Bodies of both paths beyond the last body they share, and that body (-1 for the base)."""
        path_a, path_b = self.path(a), self.path(b)
        shared = sum(1 for x, y in zip(path_a, path_b, strict=False) if x == y)
        return path_a[shared:], path_b[shared:], path_a[shared - 1] if shared else -1

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
    return tuple(constant(row) for row in matrix)  # type: ignore[return-value]


def build_tree(robot: RobotDescription) -> Tree:
    """Order the links depth first and number the coordinates: active ones first, the rest as the file has them."""
    coordinates = (*robot.active, *(name for name in robot.joints if name not in robot.active))
    children: dict[str, list[str]] = {}
    for name, joint in robot.joints.items():
        children.setdefault(joint.parent, []).append(name)
    bodies: list[Body] = []
    stack = [(name, -1) for name in reversed(children.get(robot.base, []))]
    while stack:
        name, parent = stack.pop()
        bodies.append(_body(robot, name, parent, coordinates.index(name)))
        stack += [
            (n, len(bodies) - 1) for n in reversed(children.get(robot.joints[name].child, []))
        ]
    return Tree(robot.base, tuple(bodies), coordinates, len(robot.active))


def _body(robot: RobotDescription, name: str, parent: int, coordinate: int) -> Body:
    joint = robot.joints[name]
    link = robot.links[joint.child]
    c = link.com
    about_origin = link.inertia + link.mass * (c @ c * np.eye(3) - np.outer(c, c))
    return Body(
        name=joint.child,
        joint=name,
        coordinate=coordinate,
        type=joint.type,
        parent=parent,
        rotation=rows(joint.rotation),
        translation=tuple(map(float, joint.translation)),
        axis=constant(joint.axis),
        mass=link.mass,
        first_moment=tuple(float(v) for v in link.mass * c),
        inertia=tuple(tuple(map(float, row)) for row in about_origin),  # type: ignore[arg-type]
        limits=joint.limits,
    )


def frame_offset(frame: Frame) -> tuple[Rotation, Vector]:
    """Constants of a frame on its link."""
    return rows(frame.rotation), tuple(map(float, frame.translation))
