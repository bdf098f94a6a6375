"""Poses of MJCF: pos, and one of quat, euler, axisangle, xyaxes, zaxis; or the ends of a rod."""

from __future__ import annotations

import math

import numpy as np

from ...description.document import KeyPath
from ...description.geometry import (
    IDENTITY,
    Transform,
    rotation_about,
    rotation_from_quaternion,
    snapped,
    unit_axis,
)
from ...ground.arrays import Array, frozen
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .settings import Settings
from .vocabulary import ORIENTATIONS

_ZERO_VECTOR = (0.0, 0.0, 0.0)
_SHORTEST = 1e-9  # of quaternions and axes
_Z_AXIS = frozen([0.0, 0.0, 1.0])


class PoseReader:
    """Reads where elements stand."""

    def __init__(self, xml: XmlReader, settings: Settings) -> None:
        self.xml = xml
        self.settings = settings

    def pose(self, element: LocatedElement, path: KeyPath) -> Transform:
        """The pose that an element gives, in the frame around it."""
        if "fromto" in element.attributes:
            start, end = self.ends(element, path)
            along = self._direction(element, (start - end).tolist(), path)
            return Transform(_turn_to(along), frozen((start + end) / 2.0))
        translation = self.xml.numbers(element, "pos", 3, path, _ZERO_VECTOR)
        return Transform(self.rotation(element, path), frozen(translation))

    def ends(self, element: LocatedElement, path: KeyPath) -> tuple[Array, Array]:
        """The two ends (3,) of a shape that is given by `fromto`."""
        values = self.xml.numbers(element, "fromto", 6, path)
        return np.array(values[:3]), np.array(values[3:])

    def rotation(self, element: LocatedElement, path: KeyPath) -> Array:
        """The rotation (3, 3) that an element gives; no turn where it gives none.

        Raises:
            DescriptionError: it gives several, or one without length.
        """
        given = [name for name in element.attributes if name in ORIENTATIONS]
        if len(given) > 1:
            problem = f"is turned by {' and by '.join(given)}; leave one"
            raise self.xml.error(element, path, problem)
        if not given:
            return IDENTITY
        readers = {
            "quat": self._quaternion,
            "euler": self._euler,
            "axisangle": self._axis_angle,
            "xyaxes": self._axes,
            "zaxis": self._z_axis,
        }
        return readers[given[0]](element, path)

    def _quaternion(self, element: LocatedElement, path: KeyPath) -> Array:
        values = self.xml.numbers(element, "quat", 4, path)
        if math.hypot(*values) < _SHORTEST:
            raise self.xml.error(element, path, "has a quat without length; 1 0 0 0 is no turn")
        return rotation_from_quaternion(np.array(values))

    def _euler(self, element: LocatedElement, path: KeyPath) -> Array:
        rotation: Array = IDENTITY
        angles = self.xml.numbers(element, "euler", 3, path)
        for letter, angle in zip(self.settings.euler_sequence, angles, strict=True):
            axis = unit_axis(letter.lower())
            turn = rotation_about(axis, angle * self.settings.angle_unit)
            rotation = rotation @ turn if letter.islower() else turn @ rotation
        return snapped(rotation)

    def _axis_angle(self, element: LocatedElement, path: KeyPath) -> Array:
        *direction, angle = self.xml.numbers(element, "axisangle", 4, path)
        axis = self._direction(element, direction, path)
        return rotation_about(axis, angle * self.settings.angle_unit)

    def _axes(self, element: LocatedElement, path: KeyPath) -> Array:
        values = self.xml.numbers(element, "xyaxes", 6, path)
        x = self._direction(element, values[:3], path)
        second = np.array(values[3:])
        y = self._direction(element, (second - (second @ x) * x).tolist(), path)
        return snapped(np.column_stack([x, y, np.cross(x, y)]))

    def _z_axis(self, element: LocatedElement, path: KeyPath) -> Array:
        values = self.xml.numbers(element, "zaxis", 3, path)
        return _turn_to(self._direction(element, values, path))

    def _direction(self, element: LocatedElement, vector: list[float], path: KeyPath) -> Array:
        if math.hypot(*vector) < _SHORTEST:
            raise self.xml.error(element, path, "is turned to an axis without length")
        return unit_axis(vector)


def _turn_to(axis: Array) -> Array:
    """The shortest rotation (3, 3) that takes z to a unit vector (3,)."""
    across = np.cross(_Z_AXIS, axis)
    sine = float(np.linalg.norm(across))
    angle = math.atan2(sine, axis[2])
    if sine < _SHORTEST:
        across = np.array([1.0, 0.0, 0.0])
        sine = 1.0
    return rotation_about(across / sine, angle)
