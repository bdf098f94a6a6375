"""Axes that links with parallel joints have in common.

Links that turn about parallel axes, relative to one link that carries them all, need no axes of
their own. Their vectors are in axes of the carrier, with z along the joints. Each link is turned
about z by an absolute angle: the sum of the joint angles on the way to it. Linear equations of
parallelograms shorten this sum. A link that stays parallel to the carrier has an empty one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..algebra.vector import IDENTITY3, Rotation
from ..closure.blocks.angle_sum import AngleBlock
from ..closure.constraints.plane import normal_basis
from ..closure.plan import ClosurePlan
from ..ground.arrays import Array
from ..mechanism.tree import Body, Tree, rows

BASE = -1
LEAST = 2  # links that turn in common axes; a single one is better off with axes of its own
SYMMETRIC = 1e-15  # rounding of second moments, as a share of the largest
PARALLEL = 1e-13  # sine of the angle up to which two axes count as parallel

# coordinate and coefficient of each joint angle in an absolute angle, from the carrier outward
Angle = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Axes:
    """Axes in which the vectors of some links are expressed.

    Attributes:
        carrier: the link that they are fixed to, BASE for the base; for axes of a single link, its
            parent.
        link: the link, if the axes are those of a single one; otherwise None.
        rotation: from link axes of the carrier to these (3, 3), if they are fixed to it.
        is_common: whether links turn about their z.
    """

    carrier: int
    link: int | None = None
    rotation: Rotation = IDENTITY3
    is_common: bool = False


@dataclass(frozen=True)
class Place:
    """How a link is turned in its axes.

    Attributes:
        axes: index of its axes.
        angle: its angle about their z.
        zero: from link axes to these at angle zero, (3, 3).
        turns: whether the link's joint turns it about their z.
    """

    axes: int
    angle: Angle = ()
    zero: Rotation = IDENTITY3
    turns: bool = False


@dataclass(frozen=True)
class Layout:
    """The axes of a tree, carriers first, and the place of every body in them.

    Attributes:
        axes: all axes; the first ones are those of the base.
        places: places of the bodies.
    """

    axes: tuple[Axes, ...]
    places: tuple[Place, ...]

    def place(self, body: int) -> Place:
        """The place of a body, or of the base."""
        if body == BASE:
            return Place(0)
        return self.places[body]

    def seat(self, body: int, parent: int) -> Place:
        """The place of a body's parent in the axes of the body: as a member, or as the carrier."""
        axes = self.places[body].axes
        place = self.place(parent)
        if place.axes == axes:
            return place
        return Place(axes, zero=self.axes[axes].rotation)


@dataclass(frozen=True)
class _Group:
    """Links that turn about parallel axes.

    Attributes:
        carrier: the body that carries them, BASE for the base.
        normal: the direction of the axes (3,), in link axes of the carrier.
    """

    carrier: int
    normal: tuple[float, ...]

    def has(self, axis: Array) -> bool:
        """Whether an axis in link axes of the carrier is parallel to the others."""
        return float(np.linalg.norm(np.cross(self.normal, axis))) <= PARALLEL


def lay_out(tree: Tree, plan: ClosurePlan) -> Layout:
    """Choose axes: common ones for two or more links with parallel joints, else those of the link.

    The last link of a chain needs no angle if it is symmetric about its axis.

    Args:
        tree: the spanning tree, with the parameters that most states are computed with.
        plan: closure plan, whose linear equations shorten the angles.

    Returns:
        All axes, and the place of each body in them.
    """
    groups = _groups(tree)
    axes = [Axes(BASE)]
    indices: dict[_Group, int] = {}
    places: list[Place] = []
    angles = _AbsoluteAngles(tree, plan)
    for k, body in enumerate(tree.bodies):
        group = groups[k]
        if not body.is_revolute:
            of_parent = places[body.parent] if body.parent != BASE else Place(0)
            turned: Array = np.array(of_parent.zero) @ np.array(body.rotation)
            places.append(replace(of_parent, zero=rows(turned), turns=False))
        elif group is None or not _is_worth_common_axes(tree, groups, k):
            places.append(Place(len(axes)))
            axes.append(Axes(body.parent, link=k))
        else:
            basis = normal_basis(np.array(group.normal))
            if group not in indices:
                indices[group] = len(axes)
                axes.append(Axes(group.carrier, rotation=rows(basis), is_common=True))
            angle, offset = angles.of(k, group)
            rotation, _ = tree.zero_pose(k, group.carrier)
            turned = _about_z(offset) @ basis @ rotation
            places.append(Place(indices[group], angle, rows(turned), turns=True))
    return Layout(tuple(axes), tuple(places))


def _groups(tree: Tree) -> list[_Group | None]:
    """The group of each body: a slide has its parent's, the first body of a ball joint has none."""
    groups: list[_Group | None] = []
    for k, body in enumerate(tree.bodies):
        group = groups[body.parent] if body.parent >= 0 else None
        if body.chart is not None:
            groups.append(None)
        elif not body.is_revolute:
            groups.append(group)
        else:
            groups.append(_group_of(tree, k, group, groups))
    return groups


def _group_of(
    tree: Tree, k: int, of_parent: _Group | None, groups: Sequence[_Group | None]
) -> _Group:
    """The group of a revolute joint: its parent's, another one on its parent, or a new one."""
    parent = tree.bodies[k].parent
    if of_parent is not None and of_parent.has(_axis(tree, k, of_parent.carrier)):
        return of_parent
    axis = _axis(tree, k, parent)
    for group in groups:
        if group is not None and group.carrier == parent and group.has(axis):
            return group
    return _Group(parent, tuple(axis.tolist()))


def _axis(tree: Tree, k: int, carrier: int) -> Array:
    """The axis of a joint (3,) in link axes of a body before it."""
    rotation, _ = tree.zero_pose(k, carrier)
    axis: Array = rotation @ np.array(tree.bodies[k].axis)
    return axis


def _is_worth_common_axes(tree: Tree, groups: Sequence[_Group | None], k: int) -> bool:
    """Whether other links turn with link k in its group, or its angle has no effect."""
    turning = 0
    for body, group in zip(tree.bodies, groups, strict=True):
        if body.is_revolute and group == groups[k]:
            turning += 1
    carries = any(body.parent == k for body in tree.bodies)
    return turning >= LEAST or (not carries and _is_symmetric(tree.bodies[k]))


def _is_symmetric(body: Body) -> bool:
    """Whether a body's mass is distributed symmetrically about the axis of its joint."""
    basis = normal_basis(np.array(body.axis))
    second: Array = basis @ np.array(body.about_origin) @ basis.T
    across = basis[:2] @ np.array(body.first_moment)
    symmetric = np.diag([second[0, 0], second[0, 0], second[2, 2]])
    difference = max(np.abs(second - symmetric).max(), np.abs(across).max())
    size = max(np.abs(second).max(), np.abs(body.first_moment).max())
    return bool(difference <= SYMMETRIC * size)


class _AbsoluteAngles:
    """Angles of links about the normal of their group, less those that follow from others."""

    def __init__(self, tree: Tree, plan: ClosurePlan) -> None:
        self._tree = tree
        self._solved = [block for block in plan.blocks if isinstance(block, AngleBlock)]

    def of(self, k: int, group: _Group) -> tuple[Angle, float]:
        """The angle of a link, and a constant that belongs to it [rad]."""
        terms: dict[int, int] = {}
        while k != group.carrier:
            body = self._tree.bodies[k]
            if body.is_revolute:
                terms[body.coordinate] = self._sign(k, group)
            k = body.parent
        return self._reduced(dict(reversed(terms.items())))

    def _sign(self, k: int, group: _Group) -> int:
        """1 for a joint whose axis points along the normal of the group, -1 against it."""
        along = float(np.array(group.normal) @ _axis(self._tree, k, group.carrier))
        return 1 if along > 0.0 else -1

    def _reduced(self, terms: dict[int, int]) -> tuple[Angle, float]:
        """The angle without joint angles that linear equations give, and a constant [rad].

        Each of them is replaced by the other terms of its equation.
        """
        offset = 0.0
        for block in reversed(self._solved):
            sign = terms.pop(block.unknowns[0], 0)
            if sign:
                offset += sign * block.offset
                for k, coefficient in block.others:
                    terms[k] = terms.get(k, 0) + sign * round(coefficient)
        angle = tuple((k, sign) for k, sign in terms.items() if sign)
        return angle, offset


def _about_z(angle: float) -> Array:
    """The rotation (3, 3) about z by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
