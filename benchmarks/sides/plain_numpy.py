"""Newton and Euler in plain NumPy, with the closure by hand.

Spatial vectors are those of Featherstone, angular part first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.model import Joint, Link

from ..closed_form import COORDINATES, linear, positions, projected, quadratic, triangles
from ..side import Side

Array = np.ndarray


def skew(a: Array) -> Array:
    """[a]x."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def crm(v: Array) -> Array:
    """v x on motions (angular part first)."""
    return np.block([[skew(v[:3]), np.zeros((3, 3))], [skew(v[3:]), skew(v[:3])]])


CROSS = np.array([crm(e) for e in np.eye(6)])  # crm(v) = sum of v_k CROSS[k]


class Body(NamedTuple):
    """A body and the joint that moves it.

    Attributes:
        parent: index of its parent, -1 for the base.
        coordinate: index of the joint's coordinate.
        turns: whether the joint is revolute.
        place: (6, 6) motions from the parent's axes to the joint's.
        axis: (6,) of the joint.
        along, square: (6, 6) crm(axis) and its square, for the joint's motion.
        inertia: (6, 6) of the body.
    """

    parent: int
    coordinate: int
    turns: bool
    place: Array
    axis: Array
    along: Array
    square: Array
    inertia: Array


def _body(joint: Joint, parent: int, link: Link) -> Body:
    turn = np.array(joint.rotation).T
    place = np.block([[turn, np.zeros((3, 3))], [-turn @ skew(joint.translation), turn]])
    turns = joint.type == "revolute"
    axis = np.zeros(6)
    if turns:
        axis[:3] = joint.axis
    else:
        axis[3:] = joint.axis
    along = crm(axis)
    return Body(
        parent=parent,
        coordinate=COORDINATES.index(joint.name),
        turns=turns,
        place=place,
        axis=axis,
        along=along,
        square=along @ along,
        inertia=_spatial_inertia(link),
    )


def _spatial_inertia(link: Link) -> Array:
    c = skew(link.com)
    about = np.array(link.inertia) + link.mass * c @ c.T
    return np.block([[about, link.mass * c], [link.mass * c.T, link.mass * np.eye(3)]])


class ByHand:
    """Bodies parents first; vectors in link axes."""

    def __init__(self, robot: Robot) -> None:
        d = robot.description
        self.base = np.concatenate([np.zeros(3), -np.array(d.gravity)])
        self.bodies: list[Body] = []
        index = {d.base: -1}

        def add(parent: str) -> None:
            for joint in d.joints.values():
                if joint.parent != parent:
                    continue
                index[joint.child] = len(self.bodies)
                self.bodies.append(_body(joint, index[parent], d.links[joint.child]))
                add(joint.child)

        add(d.base)

    def inverse_dynamics(self, u: Array, du: Array, ddu: Array) -> Array:
        """tau of one state."""
        q = u.tolist()
        v = du.tolist()
        t1, t2 = triangles(q)
        s = positions(q, t1, t2)
        ds = linear(v, t1, t2)
        a = linear(ddu.tolist(), t1, t2)
        dds = [x + y for x, y in zip(a, quadratic(v, t1, t2), strict=True)]
        return np.array(projected(self._tree(s, ds, dds), t1, t2))

    def _tree(self, s: list[float], ds: list[float], dds: list[float]) -> list[float]:
        motions: list[tuple[Array, Array]] = []
        forces = []
        maps = []
        still = np.zeros(6)
        for parent, k, turns, place, axis, along, square, inertia in self.bodies:
            v, a = still, self.base
            if parent >= 0:
                v, a = motions[parent]
            if turns:
                motion = place - (np.sin(s[k]) * along - (1.0 - np.cos(s[k])) * square) @ place
            else:
                motion = place - s[k] * (along @ place)
            v = motion @ v
            a = motion @ a - ds[k] * (along @ v) + dds[k] * axis
            v = v + ds[k] * axis
            motions.append((v, a))
            cross = np.dot(v, CROSS.reshape(6, 36)).reshape(6, 6)
            forces.append(inertia @ a - (inertia @ v) @ cross)
            maps.append(motion)
        result = [0.0] * len(s)
        for i in range(len(self.bodies) - 1, -1, -1):
            parent, k, *_ = self.bodies[i]
            result[k] = float(self.bodies[i].axis @ forces[i])
            if parent >= 0:
                forces[parent] = forces[parent] + forces[i] @ maps[i]
        return result


def sides(robot: Robot) -> list[Side]:
    """Plain NumPy."""
    return [Side("plain NumPy, closure by hand", {"id": ByHand(robot).inverse_dynamics})]
