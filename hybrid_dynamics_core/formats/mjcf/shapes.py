"""Masses of shapes, as MuJoCo computes them: volumes, moments and centres of primitive geoms."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...description.document import KeyPath
from ...ground.arrays import Array
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .poses import PoseReader

_DENSITY = 1000.0  # [kg/m^3] of a geom that does not say
_WITHOUT_MASS = ("plane", "hfield")
_ALONG_Z = ("capsule", "cylinder")  # given by a radius and half of their length
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body.

    Attributes:
        mass: [kg].
        com: (3,) [m] centre of mass.
        inertia: (3, 3) [kg m^2] about it.
    """

    mass: float
    com: Array
    inertia: Array


def joined(bodies: Sequence[Body]) -> Body:
    """Several bodies as one."""
    mass = sum(body.mass for body in bodies)
    com = sum((body.mass * body.com for body in bodies), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        arm = body.com - com
        steiner = arm @ arm * np.eye(3) - np.outer(arm, arm)
        inertia += body.inertia + body.mass * steiner
    return Body(mass, com, inertia)


class ShapeReader:
    """Reads the masses of <geom>."""

    def __init__(self, xml: XmlReader, poses: PoseReader) -> None:
        self.xml = xml
        self.poses = poses

    def body(self, geom: LocatedElement, path: KeyPath) -> Body | None:
        """The body that a shape makes up, in the frame around; None where it has no mass.

        Raises:
            DescriptionError: it is a mesh, or has no size.
        """
        shape = geom.get("type", "sphere")
        if shape in _WITHOUT_MASS or self._is_massless(geom, path):
            return None
        if shape not in _SIZES or "mesh" in geom.attributes:
            raise self.xml.error(
                geom,
                path,
                f"its mass is that of a shape of type '{shape}' from a file, which is not opened;"
                ' give the body an <inertial>, or the <geom> mass="0"',
            )
        size = self._size(geom, shape, path)
        volume, moments = _SHAPES[shape](*size)
        density = self.xml.number(geom, "density", path, _DENSITY)
        mass = self.xml.number(geom, "mass", path, density * volume)
        if mass == 0.0:
            return None
        pose = self.poses.pose(geom, path)
        turned = pose.rotation @ np.diag(moments) @ pose.rotation.T
        return Body(mass, pose.translation, mass * (turned + turned.T) / 2.0)

    def _is_massless(self, geom: LocatedElement, path: KeyPath) -> bool:
        first, last = self.poses.settings.groups
        group = self.xml.number(geom, "group", path, 0.0)
        if not first <= group <= last:
            return True
        if "mass" in geom.attributes:
            return self.xml.number(geom, "mass", path) == 0.0
        return self.xml.number(geom, "density", path, _DENSITY) == 0.0

    def _size(self, geom: LocatedElement, shape: str, path: KeyPath) -> list[float]:
        """Radius and half lengths of a shape [m]."""
        size = self.xml.leading_numbers(geom, "size", path)
        count = _SIZES[shape]
        if "fromto" in geom.attributes and shape != "sphere":
            start, end = self.poses.ends(geom, path)
            half_length = float(np.linalg.norm(end - start)) / 2.0
            size = [size[0], half_length] if shape in _ALONG_Z else [size[0], size[0], half_length]
        if len(size) < count or min(size[:count]) <= 0.0:
            problem = f"has the size {size}; expected {count} lengths of a {shape}"
            raise self.xml.error(geom, path, problem)
        return size[:count]


Moments = tuple[float, float, float]


def _sphere(radius: float) -> tuple[float, Moments]:
    moment = 0.4 * radius**2
    return 4.0 / 3.0 * math.pi * radius**3, (moment, moment, moment)


def _cylinder(radius: float, half_length: float) -> tuple[float, Moments]:
    across = radius**2 / 4.0 + half_length**2 / 3.0
    volume = 2.0 * math.pi * radius**2 * half_length
    return volume, (across, across, radius**2 / 2.0)


def _capsule(radius: float, half_length: float) -> tuple[float, Moments]:
    """A cylinder with a half sphere at each end."""
    middle_volume, middle = _cylinder(radius, half_length)
    ends_volume, (ends, _, _) = _sphere(radius)
    volume = middle_volume + ends_volume
    # Half a sphere has its centre of mass at 3/8 of its radius.
    steiner = half_length**2 + 0.75 * radius * half_length
    across = (middle_volume * middle[0] + ends_volume * (ends + steiner)) / volume
    along = (middle_volume * middle[2] + ends_volume * ends) / volume
    return volume, (across, across, along)


def _ellipsoid(a: float, b: float, c: float) -> tuple[float, Moments]:
    moments = ((b**2 + c**2) / 5.0, (a**2 + c**2) / 5.0, (a**2 + b**2) / 5.0)
    return 4.0 / 3.0 * math.pi * a * b * c, moments


def _box(a: float, b: float, c: float) -> tuple[float, Moments]:
    moments = ((b**2 + c**2) / 3.0, (a**2 + c**2) / 3.0, (a**2 + b**2) / 3.0)
    return 8.0 * a * b * c, moments


# Volume [m^3] and moments over mass [m^2] of each shape, from its sizes [m]:
_SHAPES: dict[str, Callable[..., tuple[float, Moments]]] = {
    "sphere": _sphere,
    "cylinder": _cylinder,
    "capsule": _capsule,
    "ellipsoid": _ellipsoid,
    "box": _box,
}
