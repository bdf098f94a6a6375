"""A problem as a tree of links with mass, ties that close its loops, and springs between points.

The descriptions have a massless sleeve and piston for each spring. Engines have springs of their
own instead, so that sleeves and pistons are left out here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.description.model import Closure, Joint, Link

from ..catalogue import Problem
from ..solve import Solver

Array = NDArray[np.float64]
Twists = dict[str, tuple[Array, Array]]  # angular rate and velocity of a link's origin


@dataclass(frozen=True)
class Spring:
    """A spring with a damper between two points of links."""

    link_a: str
    point_a: Array
    link_b: str
    point_b: Array
    stiffness: float  # [N/m]
    rest: float  # [m]
    damping: float  # [N s/m]


@dataclass(frozen=True)
class Model:
    """What every engine builds from.

    Attributes:
        problem: the problem.
        description: of its robot.
        links: that move, by name.
        joints: of the tree, parents first.
        closures: that are left.
        springs: between points.
        s, ds: the start, by joint.
        tau: constant efforts, by joint.
    """

    problem: Problem
    description: RobotDescription
    links: dict[str, Link]
    joints: dict[str, Joint]
    closures: tuple[Closure, ...]
    springs: tuple[Spring, ...]
    s: dict[str, float]
    ds: dict[str, float]
    tau: dict[str, float]

    @property
    def base(self) -> str:
        """The link that does not move."""
        return self.description.base

    @property
    def is_planar(self) -> bool:
        """Whether all of it moves in the plane of x and y."""
        axes = [joint.axis for joint in self.joints.values()]
        turned = [joint.rotation for joint in self.joints.values()]
        upright = all(np.allclose(np.abs(axis), [0, 0, 1]) for axis in axes)
        revolute = all(joint.type == "revolute" for joint in self.joints.values())
        return upright and revolute and all(np.allclose(R, np.eye(3)) for R in turned)

    def poses(self, s: dict[str, float]) -> dict[str, tuple[Array, Array]]:
        """Rotation and origin of every link."""
        poses = {self.base: (np.eye(3), np.zeros(3))}
        for name, joint in self.joints.items():
            R, p = poses[joint.parent]
            p = p + R @ joint.translation
            R = R @ joint.rotation
            if joint.type == "revolute":
                R = R @ turn(joint.axis, s[name])
            else:
                p = p + R @ joint.axis * s[name]
            poses[joint.child] = (R, p)
        return poses

    def twists(self, s: dict[str, float], ds: dict[str, float]) -> Twists:
        """Angular rate and velocity of the origin of every link, in world axes."""
        poses = self.poses(s)
        twists = {self.base: (np.zeros(3), np.zeros(3))}
        for name, joint in self.joints.items():
            omega, v = twists[joint.parent]
            R, p = poses[joint.child]
            v = v + np.cross(omega, p - poses[joint.parent][1])
            along = R @ joint.axis * ds[name]
            if joint.type == "revolute":
                omega = omega + along
            else:
                v = v + along
            twists[joint.child] = (omega, v)
        return twists

    def rows(self, s: Array, ds: Array) -> Array:
        """What is compared, from rows of the tree's coordinates and rates."""
        observed = self.problem.observed
        order = tuple(self.joints)
        if observed.names:
            return observed.of_coordinates(order, s, ds)
        frame = self.description.frames[self.description.end_effector]
        rows = []
        for values, rates in zip(s, ds, strict=True):
            at = dict(zip(order, values, strict=True))
            by = dict(zip(order, rates, strict=True))
            R, p = self.poses(at)[frame.link]
            omega, v = self.twists(at, by)[frame.link]
            arm = R @ frame.translation
            rows.append(self.observe(p + arm, v + np.cross(omega, arm)))
        return np.array(rows)

    def observe(self, place: Array, rate: Array) -> Array:
        """The axes that are compared."""
        axes = list(self.problem.observed.axes)
        return np.concatenate([place[axes], rate[axes]])


def turn(axis: Array, angle: float) -> Array:
    """(3, 3) by Rodrigues."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: Array = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return turned


def toward(axis: Array) -> Array:
    """(3, 3) a rotation whose z axis is `axis`."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def model_of(problem: Problem) -> Model:
    """The problem, as other engines take it."""
    solver = Solver(problem)
    robot = solver.robot
    description = robot.description
    springs, gone = _springs(description)
    links = {k: v for k, v in description.links.items() if k not in {*gone, description.base}}
    joints = {k: v for k, v in _ordered(description).items() if v.child not in gone}
    ends = [c for c in description.closures if not {c.link_a, c.link_b} & gone]
    at = dict(zip(robot.coordinates, solver.start.s.tolist(), strict=True))
    by = dict(zip(robot.coordinates, solver.start.ds.tolist(), strict=True))
    efforts = problem.tau or (0.0,) * len(robot.active)
    return Model(
        problem,
        description,
        links,
        joints,
        tuple(ends),
        springs,
        {name: at[name] for name in joints},
        {name: by[name] for name in joints},
        dict(zip(robot.active, efforts, strict=True)),
    )


def _ordered(description: RobotDescription) -> dict[str, Joint]:
    """Joints, parents first, each branch to its end."""
    ordered: dict[str, Joint] = {}

    def add(parent: str) -> None:
        for name, joint in description.joints.items():
            if joint.parent == parent:
                ordered[name] = joint
                add(joint.child)

    add(description.base)
    return ordered


def _springs(description: RobotDescription) -> tuple[tuple[Spring, ...], set[str]]:
    """Springs between points, and the massless links that stand for them."""
    springs = []
    gone: set[str] = set()
    parents = {joint.child: joint for joint in description.joints.values()}
    for closure in description.closures:
        slide = parents.get(closure.link_a)
        if slide is None or slide.type != "prismatic":
            continue
        sleeve = parents[slide.parent]
        if description.links[slide.child].mass or description.links[slide.parent].mass:
            continue
        effect = description.effects[slide.name]
        spring = Spring(
            sleeve.parent,
            np.array(sleeve.translation),
            closure.link_b,
            np.array(closure.point_b),
            effect.stiffness,
            effect.rest,
            effect.viscous,
        )
        springs.append(spring)
        gone |= {slide.child, slide.parent}
    return tuple(springs), gone
