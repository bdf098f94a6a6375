"""Inertia tensors of a description: components, principal moments or a uniform shape, in any frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..ground.arrays import Array, frozen
from .document import Path_
from .geometry import check_inertia
from .values import Numbers

COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def read_inertia(numbers: Numbers, entry: Any, mass: float, path: Path_, slack: float) -> Array:
    """The tensor (3, 3) about the centre of mass in link axes [kg m^2]; DescriptionError for an impossible one."""
    if isinstance(entry, list):
        inertia = frozen([numbers.vector(row, (*path, k)) for k, row in enumerate(entry)])
    else:
        inertia = _in_link_axes(numbers, entry, _tensor(numbers, entry, mass, path), path)
    try:
        check_inertia(inertia, slack)
    except ValueError as error:
        raise numbers.document.error(path, str(error)) from error
    return inertia


def _tensor(numbers: Numbers, entry: Mapping[str, Any], mass: float, path: Path_) -> Array:
    given = [key for key in entry if key not in ("frame", *COMPONENTS)]
    components = any(key in entry for key in COMPONENTS)
    if len(given) + components != 1:
        told = " and ".join([*given, *(["components"] if components else [])]) or "nothing"
        problem = f"gives {told}; give one of: components xx to yz, principal, {', '.join(_SHAPES)}"
        raise numbers.document.error(path, problem)
    if components:
        part = {key: numbers.number(entry[key], (*path, key)) for key in COMPONENTS if key in entry}
        xx, yy, zz, xy, xz, yz = (part.get(key, 0.0) for key in COMPONENTS)
        return frozen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if "principal" in entry:
        return frozen(np.diag(numbers.vector(entry["principal"], (*path, "principal"))))
    shape = given[0]
    return frozen(np.diag(_SHAPES[shape](numbers, entry[shape], mass, (*path, shape))))


def _in_link_axes(numbers: Numbers, entry: Mapping[str, Any], inertia: Array, path: Path_) -> Array:
    if "frame" not in entry:
        return inertia
    rotation = numbers.pose({"rpy": entry["frame"]["rpy"]}, (*path, "frame")).rotation
    turned = rotation @ inertia @ rotation.T
    return frozen((turned + turned.T) / 2.0)


def _rod(numbers: Numbers, entry: Mapping[str, Any], mass: float, path: Path_) -> list[float]:
    moment = mass * numbers.length(entry["length"], (*path, "length")) ** 2 / 12.0
    return [0.0 if axis == entry["axis"] else moment for axis in "xyz"]


def _cylinder(numbers: Numbers, entry: Mapping[str, Any], mass: float, path: Path_) -> list[float]:
    radius = numbers.length(entry["radius"], (*path, "radius"))
    inner = numbers.number(entry.get("inner", 0), (*path, "inner"))
    if not 0.0 <= inner < radius:
        raise numbers.document.error(
            (*path, "inner"), f"is {inner:g} m; expected 0 up to the radius, {radius:g} m"
        )
    squares = radius * radius + inner * inner
    length = numbers.length(entry["length"], (*path, "length"))
    across = mass * (3.0 * squares + length * length) / 12.0
    return [mass * squares / 2.0 if axis == entry["axis"] else across for axis in "xyz"]


def _box(numbers: Numbers, entry: Mapping[str, Any], mass: float, path: Path_) -> list[float]:
    x, y, z = (numbers.length(v, (*path, "size", k)) for k, v in enumerate(entry["size"]))
    return [mass * squares / 12.0 for squares in (y * y + z * z, x * x + z * z, x * x + y * y)]


def _sphere(numbers: Numbers, entry: Mapping[str, Any], mass: float, path: Path_) -> list[float]:
    return [0.4 * mass * numbers.length(entry["radius"], (*path, "radius")) ** 2] * 3


_SHAPES: dict[str, Callable[[Numbers, Mapping[str, Any], float, Path_], list[float]]] = {
    "rod": _rod,
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
}
