"""Recognition of planar loops, and their equations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...algebra.independence import norm
from ...algebra.scalar import atan2
from ...algebra.vector import constant
from ...description.model import Closure
from ...ground.arrays import Array
from ...mechanism.tree import Tree
from .angle_sum import AngleSum
from .equations import LoopEquations
from .planar import PlanarGeometry, PlanarJoint, PlanarPin
from .plane import PARALLEL, plane_basis

# [rad] error of angles with few digits, such as 1.57 and 3.14
ROUNDED_ANGLE = 5e-3
# [m] tolerance for the distance of the ends along the loop's axis, since numbers are rounded
APART = 1e-6


class _End(NamedTuple):
    """A frame on a body."""

    body: int
    point: Array
    rotation: Array


def planar_equations(tree: Tree, closure: Closure) -> list[LoopEquations]:
    """The equations of a closure whose loop is planar.

    Raises:
        ValueError: the loop is not planar. The message says why.
    """
    first, second = _ordered_ends(tree, closure)
    path_a, path_b, ancestor = tree.branches(first.body, second.body)
    basis = plane_basis(tree, path_a + path_b, ancestor)
    a = _in_plane(tree, first, ancestor, basis)
    b = _in_plane(tree, second, ancestor, basis)
    _require_one_plane(a, b)
    geometry = PlanarGeometry(
        tuple(_planar_joint(tree, i, ancestor, basis) for i in path_a),
        tuple(_planar_joint(tree, i, ancestor, basis) for i in path_b),
        constant(a.point[:2]),
        constant(b.point[:2]),
    )
    equations: list[LoopEquations] = [PlanarPin(closure.name, geometry)]
    if closure.kind == "axis":
        _require_parallel_axes(a, b)
    if closure.kind == "frame":
        equations.append(_parallel_frames(closure.name, geometry, a, b))
    return equations


def _ordered_ends(tree: Tree, closure: Closure) -> tuple[_End, _End]:
    """Both ends: first the one behind more joints or, of equal ones, the earlier coordinate.

    The first joint's axis and the order of the ends define what is counterclockwise. That must not
    depend on the order of keys in a file.
    """
    a = _End(tree.body_index(closure.link_a), closure.point_a, closure.rotation_a)
    b = _End(tree.body_index(closure.link_b), closure.point_b, closure.rotation_b)
    path_a, path_b, _ = tree.branches(a.body, b.body)

    if _precedence(tree, path_a) <= _precedence(tree, path_b):
        return a, b
    return b, a


def _precedence(tree: Tree, path: list[int]) -> tuple[int, int]:
    """The sort key of a chain: its number of joints, then its earliest coordinate."""
    coordinates = [tree.bodies[i].coordinate for i in path]
    return -len(path), min(coordinates, default=0)


def _in_plane(tree: Tree, end: _End, ancestor: int, basis: Array) -> _End:
    """The end at zero, in the axes of the plane."""
    rotation, origin = tree.zero_pose(end.body, ancestor)
    point = basis @ (rotation @ end.point + origin)
    return _End(end.body, point, basis @ rotation @ end.rotation)


def _require_one_plane(a: _End, b: _End) -> None:
    """Raise if the ends are apart along the normal."""
    gap = abs(float(a.point[2] - b.point[2]))
    if gap <= APART:
        return
    size = max(norm(a.point), norm(b.point))
    hint = ""
    if gap < ROUNDED_ANGLE * size:
        hint = " (angles of few digits do that: 1.57 in place of pi/2)"
    raise ValueError(f"its ends are {gap:.3g} m apart along the loop's axis{hint}")


def _require_parallel_axes(a: _End, b: _End) -> None:
    """Raise if the axes of the ends are not along the normal."""
    axis_a = a.rotation[:, 2]
    axis_b = b.rotation[:, 2]
    if norm(np.cross(axis_a, axis_b)) > PARALLEL:
        raise ValueError("its two axes are not parallel")
    if abs(a.rotation[2, 2]) < 1.0 - PARALLEL:
        raise ValueError("its axis is not the loop's")


def _parallel_frames(name: str, geometry: PlanarGeometry, a: _End, b: _End) -> AngleSum:
    """The equation that both end frames have the same orientation."""
    normal_a = a.rotation[2]
    normal_b = b.rotation[2]
    if norm(normal_a - normal_b) > PARALLEL:
        raise ValueError("its frames are tilted out of the loop's plane against each other")
    turn = a.rotation @ b.rotation.T  # about the normal
    offset = atan2(turn[1, 0], turn[0, 0])
    turns = [(j.coordinate, j.sign) for j in geometry.chain_a if j.revolute]
    turns += [(j.coordinate, -j.sign) for j in geometry.chain_b if j.revolute]
    return AngleSum(name, tuple(turns), offset)


def _planar_joint(tree: Tree, index: int, ancestor: int, basis: Array) -> PlanarJoint:
    body = tree.bodies[index]
    rotation, origin = tree.zero_pose(index, ancestor)
    axis = basis @ rotation @ np.array(body.axis)
    if not body.is_revolute:
        return PlanarJoint(body.coordinate, False, 1.0, constant(axis[:2]))
    sign = -1.0
    if axis[2] > 0:
        sign = 1.0
    pivot = basis @ origin
    return PlanarJoint(body.coordinate, True, sign, constant(pivot[:2]))
