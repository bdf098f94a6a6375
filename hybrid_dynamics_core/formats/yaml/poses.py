"""Entries of poses, axes and bodies of a description file, in their most readable form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...description.document import Data
from ...description.geometry import (
    IDENTITY,
    Transform,
    rotation_from_rpy,
    rotation_with_z_axis,
    rpy_of,
)
from ...ground.arrays import Array
from .text import Expression

_SAME = 4e-16  # two units in the last place of a sine
_PARTS_OF_PI = 12  # multiples of 15 degrees, as in drawings
_LETTERS = dict(zip("xyz", np.eye(3), strict=True))


def pose_entry(pose: Transform) -> Data:
    """xyz and a rotation, each only if not zero."""
    entry: Data = {}
    if pose.translation.any():
        entry["xyz"] = pose.translation.tolist()
    return entry | rotation_entry(pose.rotation)


def rotation_entry(rotation: Array) -> Data:
    """A rotation as rpy, or as a matrix if angles would lose digits."""
    if np.array_equal(rotation, IDENTITY):
        return {}
    angles = rpy_of(rotation).tolist()
    for words in ([_nice(angle) for angle in angles], angles):
        values = [_value(word) for word in words]
        if np.abs(rotation_from_rpy(*values) - rotation).max() <= _SAME:
            return {"rpy": words}
    return {"matrix": rotation.tolist()}


def place_entry(kind: str, pose: Transform) -> list[float] | Data:
    """An end of a closure: a point, a point with an axis, or a pose."""
    if np.array_equal(pose.rotation, IDENTITY):
        return list(pose.translation.tolist())
    z_axis = pose.rotation[:, 2]
    if kind == "axis" and np.abs(rotation_with_z_axis(z_axis) - pose.rotation).max() <= _SAME:
        return {"xyz": pose.translation.tolist(), "axis": axis_entry(z_axis)}
    return pose_entry(pose)


def axis_entry(axis: Array) -> str | list[float]:
    """An axis as a letter if possible, otherwise as a vector."""
    for letter, direction in _LETTERS.items():
        if np.array_equal(axis, direction):
            return letter
        if np.array_equal(axis, -direction):
            return f"-{letter}"
    return list(axis.tolist())


def body_entry(mass: float, com: Array, inertia: Array) -> Data:
    """Mass, centre of mass and inertia, each only if not zero."""
    entry: Data = {}
    if mass or com.any() or inertia.any():
        entry["mass"] = mass
    if com.any():
        entry["com"] = com.tolist()
    if inertia.any():
        entry["inertia"] = _components(inertia)
    return entry


def _components(inertia: Array) -> Data:
    entry: Data = {}
    for row, column in ("xx", "yy", "zz", "xy", "xz", "yz"):
        value = inertia["xyz".index(row), "xyz".index(column)]
        if value or row == column:
            entry[row + column] = float(value)
    return entry


def _nice(angle: float) -> Any:
    """An angle as an expression if it is a multiple of pi/12, otherwise as a number."""
    count = round(angle * _PARTS_OF_PI / math.pi)
    if not count or abs(count * math.pi / _PARTS_OF_PI - angle) > _SAME * abs(count):
        return angle
    common = math.gcd(count, _PARTS_OF_PI)
    above, below = abs(count) // common, _PARTS_OF_PI // common
    sign = "-" if count < 0 else ""
    factor = "" if above == 1 else f"{above}*"
    divisor = "" if below == 1 else f"/{below}"
    return Expression(f"{sign}{factor}pi{divisor}")


def _value(word: Any) -> float:
    if not isinstance(word, Expression):
        return float(word)
    above, _, below = word.partition("/")
    factor, _, _ = above.rpartition("pi")
    count = {"": 1.0, "-": -1.0}.get(factor) or float(factor.rstrip("*"))
    return count * math.pi / float(below or 1)
