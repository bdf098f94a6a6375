"""Inertia tensors of a description: components, principal moments or a uniform shape."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..ground.arrays import Array, frozen
from .entries import Entry
from .rigid_body import impossibility, symmetric_inertia
from .values import read_each

_COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
_POINT_MASS = {"xx": 0}
_ROUNDING = 1e-12  # share of the largest entry up to which asymmetry is rounding, without a note


def read_inertia(body: Entry, mass: float, slack: float) -> Array:
    """The inertia tensor of a link or payload.

    Args:
        body: entry whose key `inertia` is a matrix, components, principal moments or a shape.
        mass: mass of the body [kg], for shapes.
        slack: relative error of the printed numbers. A tensor that is impossible beyond this error
            gets a note.

    Returns:
        (3, 3) about the centre of mass in link axes [kg m^2], zero where no inertia is given.

    Raises:
        DescriptionError: the matrix is not symmetric, or a dimension is not positive.
    """
    given = body.get("inertia", _POINT_MASS)
    path = body.key_path("inertia")
    if isinstance(given, list):
        inertia = frozen(read_each(body.values.vector, given, path))
    else:
        entry = Entry(body.values, given, path)
        inertia = _in_link_axes(entry, _tensor(entry, mass))
    document = body.values.document
    try:
        inertia, apart = symmetric_inertia(inertia)
    except ValueError as error:
        raise body.error("inertia", str(error)) from error
    if apart > _ROUNDING * np.abs(inertia).max():
        document.note(
            path, f"mirrored entries differ by {apart:.3g} kg m^2; their mean is taken for both"
        )
    problem = impossibility(inertia, slack)
    if problem:
        document.warn_of_inertia(path, problem)
    return inertia


def _tensor(entry: Entry, mass: float) -> Array:
    """The tensor in the axes in which it is given."""
    forms = [key for key in entry if key not in ("frame", *_COMPONENTS)]
    if any(key in entry for key in _COMPONENTS):
        forms.append("components")
    if len(forms) != 1:
        given = " and ".join(forms) or "nothing"
        raise entry.values.document.error(
            entry.path,
            f"gives {given}; give one of: components xx to yz, principal, {', '.join(_SHAPES)}",
        )
    form = forms[0]
    if form == "components":
        return _from_components(entry)
    if form == "principal":
        return frozen(np.diag(entry.vector(form)))
    moments = _SHAPES[form](entry.sub(form), mass)
    return frozen(np.diag(moments))


def _from_components(entry: Entry) -> Array:
    xx = entry.number("xx")
    yy = entry.number("yy")
    zz = entry.number("zz")
    xy = entry.number("xy")
    xz = entry.number("xz")
    yz = entry.number("yz")
    return frozen(
        [
            [xx, xy, xz],
            [xy, yy, yz],
            [xz, yz, zz],
        ]
    )


def _in_link_axes(entry: Entry, inertia: Array) -> Array:
    if "frame" not in entry:
        return inertia
    rotation = entry.pose("frame").rotation
    turned = rotation @ inertia @ rotation.T
    return frozen((turned + turned.T) / 2.0)


def _rod(rod: Entry, mass: float) -> list[float]:
    across = mass * rod.length("length") ** 2 / 12.0
    return _about_axis(rod["axis"], 0.0, across)


def _cylinder(cylinder: Entry, mass: float) -> list[float]:
    radius = cylinder.length("radius")
    inner = cylinder.number("inner")
    if not 0.0 <= inner < radius:
        raise cylinder.error("inner", f"is {inner:g} m; expected 0 up to the radius, {radius:g} m")
    squares = radius * radius + inner * inner
    length = cylinder.length("length")
    along = mass * squares / 2.0
    across = mass * (3.0 * squares + length * length) / 12.0
    return _about_axis(cylinder["axis"], along, across)


def _box(box: Entry, mass: float) -> list[float]:
    x, y, z = read_each(box.values.length, box["size"], box.key_path("size"))
    about_x = mass * (y * y + z * z) / 12.0
    about_y = mass * (x * x + z * z) / 12.0
    about_z = mass * (x * x + y * y) / 12.0
    return [about_x, about_y, about_z]


def _sphere(sphere: Entry, mass: float) -> list[float]:
    return [0.4 * mass * sphere.length("radius") ** 2] * 3


def _about_axis(axis: str, along: float, across: float) -> list[float]:
    """Moments about x, y and z of a body that is round about one of these axes."""
    moments = dict.fromkeys("xyz", across)
    moments[axis] = along
    return list(moments.values())


_SHAPES: dict[str, Callable[[Entry, float], list[float]]] = {
    "rod": _rod,
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
}
