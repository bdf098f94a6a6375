"""The plane in which the joints of a loop move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...algebra.independence import length, norm
from ...algebra.live import plain
from ...ground.arrays import Array
from ...mechanism.tree import Tree

PARALLEL = 1e-9  # sine of the angle up to which two constant axes count as parallel
ROUNDED = 1e-4  # [rad] deviation of axes that count as parallel, since files have few digits


class _JointAxis(NamedTuple):
    """A joint with its axis (3,) at zero, in the frame of the link where the chains start."""

    joint: str
    is_revolute: bool
    axis: Array

    def tilt(self, normal: Array) -> float:
        """Sine of the angle by which the joint moves its link out of the plane of this normal."""
        if self.is_revolute:
            return norm(np.cross(normal, self.axis))
        return abs(float(normal @ self.axis))

    def moves_in_plane(self, normal: Array) -> bool:
        """Whether the joint moves its link in the plane of this normal."""
        return not self.tilt(normal) > PARALLEL


def plane_basis(tree: Tree, bodies: Sequence[int], ancestor: int) -> Array:
    """Axes of the plane of a loop.

    Args:
        tree: the spanning tree.
        bodies: bodies of the loop's joints, one chain after the other.
        ancestor: the body where the chains begin, -1 for the base.

    Returns:
        (3, 3), rows in the frame of that body: two axes in the plane and its normal, which is the
        axis of the first revolute joint.

    Raises:
        ValueError: the loop is not planar. The message says why.
    """
    axes = [_joint_axis(tree, body, ancestor) for body in bodies]
    normals = [axis.axis for axis in axes if axis.is_revolute]
    if not normals:
        raise ValueError("it has no revolute joint")
    if not all(axis.moves_in_plane(normals[0]) for axis in axes):
        outside = _outside(axes, normals)
        _require_one_direction(axes, outside)
        raise ValueError(_not_planar(axes, normals, outside))
    return normal_basis(normals[0])


def normal_basis(normal: Array) -> Array:
    """Two axes across a unit vector, and the vector itself, as rows (3, 3)."""
    first = _some_axis_across(normal)
    return np.array([first, np.cross(normal, first), normal])


def _joint_axis(tree: Tree, index: int, ancestor: int) -> _JointAxis:
    body = tree.bodies[index]
    rotation, _ = tree.zero_pose(index, ancestor)
    return _JointAxis(body.joint, body.is_revolute, rotation @ body.axis)


def _some_axis_across(normal: Array) -> Array:
    """A unit vector at right angles to the normal."""
    # of a normal along an axis, always the same one of the two other axes
    if max(abs(normal)) < 1.0:
        flattest = int(np.argmin(np.abs(normal)))
        side = np.eye(3)[flattest]
    else:
        side = np.roll(np.abs(normal), 1)
    across: Array = side - (side @ normal) * normal
    unit: Array = across / length(across)
    return unit


def _outside(axes: Sequence[_JointAxis], normals: Sequence[Array]) -> list[list[str]]:
    """Joints that do not move in the plane of each normal."""
    directions = plain(np.array([axis.axis for axis in axes]))
    across = plain(np.array(normals))[:, None]
    turning = np.linalg.norm(np.cross(across, directions), axis=-1)
    sliding = np.abs((across * directions).sum(axis=-1))
    tilts = np.where([axis.is_revolute for axis in axes], turning, sliding)
    names = np.array([axis.joint for axis in axes], dtype=object)
    return [names[row].tolist() for row in tilts > PARALLEL]


def _require_one_direction(axes: Sequence[_JointAxis], outside: Sequence[Sequence[str]]) -> None:
    """Raise if two joints turn about different axes, and either may be the wrong one."""
    turning = [axis for axis in axes if axis.is_revolute]
    if len(turning) != 2:
        return
    first, second = turning
    if [*outside[0], *outside[1]] == [second.joint, first.joint]:
        listed = " and ".join(f"'{one.joint}' about [{_text(one.axis)}]" for one in turning)
        raise ValueError(
            f"joints turn about different axes, {listed}; mend the rpy of one's origin, or its axis"
        )


def _not_planar(
    axes: Sequence[_JointAxis], normals: Sequence[Array], outside: Sequence[Sequence[str]]
) -> str:
    """Error text: the joints that do not move in the plane of most others."""
    fewest, normal = min(zip(outside, normals, strict=True), key=_number_outside)
    inside = [axis.joint for axis in axes if axis.joint not in fewest]
    verb = "joints {} do"
    if len(fewest) == 1:
        verb = "joint {} does"
    tilts = [axis.tilt(normal) for axis in axes if axis.joint in fewest]
    angle = math.asin(min(max(tilts), 1.0))
    return (
        f"{verb.format(_listed(fewest))} not move in the plane of {_listed(inside)}, with axes"
        f" [{_text(normal)}]: off by {angle:.3g} rad, where {ROUNDED:g} rad would be taken as"
        " rounding; mend the rpy of its origin, or its axis"
    )


def _number_outside(plane: tuple[Sequence[str], Array]) -> int:
    outside, _ = plane
    return len(outside)


def _text(axis: Array) -> str:
    return ", ".join(f"{x + 0.0:.3g}" for x in plain(axis).round(12))


def _listed(names: Sequence[str]) -> str:
    return " and ".join(f"'{name}'" for name in names)
