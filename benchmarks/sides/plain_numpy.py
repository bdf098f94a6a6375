"""Newton and Euler in plain NumPy, with vectors of six (Featherstone's notation) and the closure by hand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hybrid_dynamics_core import Robot

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
    """`place`: motions from the parent's axes to the joint's; `along`, `square`: for a turning joint, of its angle."""

    parent: int
    coordinate: int
    turns: bool
    place: Array
    axis: Array
    along: Array
    square: Array
    inertia: Array


class ByHand:
    """Bodies parents first; vectors in link axes."""

    def __init__(self, robot: Robot) -> None:
        d = robot.description
        self.base = np.concatenate([np.zeros(3), -np.array(d.gravity)])
        self.bodies: list[Body] = []
        index = {d.base: -1}

        def add(parent: str) -> None:
            for name, joint in d.joints.items():
                if joint.parent != parent:
                    continue
                index[joint.child] = len(self.bodies)
                turn, zero, link = (
                    np.array(joint.rotation).T,
                    np.zeros((3, 3)),
                    d.links[joint.child],
                )
                place = np.block([[turn, zero], [-turn @ skew(joint.translation), turn]])
                turns = joint.type == "revolute"
                axis = np.concatenate(
                    [joint.axis, np.zeros(3)] if turns else [np.zeros(3), joint.axis]
                )
                c = skew(link.com)
                about = np.array(link.inertia) + link.mass * c @ c.T
                inertia = np.block(
                    [[about, link.mass * c], [link.mass * c.T, link.mass * np.eye(3)]]
                )
                along = crm(axis)
                coordinate = COORDINATES.index(name)
                row = Body(
                    index[parent], coordinate, turns, place, axis, along, along @ along, inertia
                )
                self.bodies.append(row)
                add(joint.child)

        add(d.base)

    def inverse_dynamics(self, u: Array, du: Array, ddu: Array) -> Array:
        """tau of one state."""
        q = u.tolist()
        v = du.tolist()
        t1, t2 = triangles(q)
        s, ds = positions(q, t1, t2), linear(v, t1, t2)
        dds = [
            x + y for x, y in zip(linear(ddu.tolist(), t1, t2), quadratic(v, t1, t2), strict=True)
        ]
        return np.array(projected(self._tree(s, ds, dds), t1, t2))

    def _tree(self, s: list[float], ds: list[float], dds: list[float]) -> list[float]:
        motions: list[tuple[Array, Array]] = []
        forces, maps = [], []
        still = np.zeros(6)
        for parent, k, turns, place, axis, along, square, inertia in self.bodies:
            v, a = motions[parent] if parent >= 0 else (still, self.base)
            if turns:
                own = place - (np.sin(s[k]) * along - (1.0 - np.cos(s[k])) * square) @ place
            else:
                own = place - s[k] * (along @ place)
            v = own @ v
            a = own @ a - ds[k] * (along @ v) + dds[k] * axis
            v = v + ds[k] * axis
            motions.append((v, a))
            forces.append(
                inertia @ a - (inertia @ v) @ np.dot(v, CROSS.reshape(6, 36)).reshape(6, 6)
            )
            maps.append(own)
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
