"""Joints of SDFormat: their links, axis, limits, friction, spring, and the joint they follow."""

from __future__ import annotations

import math

from ...description.document import Data
from ...description.geometry import unit_axis
from ...ground.arrays import Array
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .poses import WORLD, ModelPoses

_UNLIMITED = 1e16  # [rad or m] what SDFormat takes for no limit
_INFINITY = ("inf", "infinity")
_DRIVE_LIMITS = {"effort": "effort_limit", "velocity": "velocity_limit"}
_Z_AXIS = (0.0, 0.0, 1.0)


class JointReader:
    """Reads one <joint>.

    Attributes:
        element: the joint.
        type: of the joint, in SDFormat.
        path: of its entry.
    """

    def __init__(self, xml: XmlReader, poses: ModelPoses, element: LocatedElement) -> None:
        self.xml = xml
        self.poses = poses
        self.element = element
        self.type = element.get("type")
        self.path = ("joints", element.get("name"))

    def is_grounded(self) -> bool:
        """Whether the parent is the world."""
        return self._end("parent") == WORLD

    def parent(self) -> str:
        """The parent link, or the world."""
        name = self._end("parent")
        if name == WORLD:
            return WORLD
        return self.poses.link_of(name, self.element)

    def child(self) -> str:
        """The child link."""
        return self.poses.link_of(self._end("child"), self.element)

    def axis(self) -> Array:
        """The axis (3,) in the frame of the joint."""
        key = (*self.path, "axis")
        xyz = self._inside_axis("xyz")
        values = self.xml.text_numbers(xyz, 3, key, _Z_AXIS)
        try:
            axis = unit_axis(values)
        except ValueError as error:
            raise self.xml.error(self.element, key, str(error)) from error
        expressed_in = ""
        if xyz is not None:
            expressed_in = xyz.get("expressed_in")
        return self.poses.axis_in_joint(axis, expressed_in, self.element)

    def constraints(self) -> Data:
        """Limits, friction, spring and mimic of the joint, as far as it has them."""
        entries: Data = {}
        limit = self._inside_axis("limit")
        if limit is not None and self.type != "continuous":
            lower = self._bound(limit.first("lower"), -math.inf)
            upper = self._bound(limit.first("upper"), math.inf)
            if math.isfinite(lower) or math.isfinite(upper):
                entries["limits"] = [lower, upper]
        if limit is not None:
            entries |= self._drive_limits(limit)
        dynamics = self._inside_axis("dynamics")
        if dynamics is not None:
            entries |= self._dynamics(dynamics)
        mimic = self._inside_axis("mimic")
        if mimic is not None:
            entries["mimic"] = self._mimic(mimic)
        return entries

    def _end(self, tag: str) -> str:
        """The name in <parent> or <child>."""
        end = self.element.first(tag)
        if end is None or not end.text.strip():
            raise self.xml.error_at(self.element, f"has no <{tag}>")
        return end.text.strip()

    def _inside_axis(self, tag: str) -> LocatedElement | None:
        """The first element with a tag in <axis>."""
        axis = self.element.first("axis")
        if axis is None:
            return None
        return axis.first(tag)

    def _drive_limits(self, limit: LocatedElement) -> Data:
        """The largest effort and rate; SDFormat has negative numbers for none."""
        entries: Data = {}
        for tag, key in _DRIVE_LIMITS.items():
            value = self._bound(limit.first(tag), math.inf)
            if 0.0 < value < math.inf:
                entries[key] = value
        return entries

    def _bound(self, element: LocatedElement | None, unlimited: float) -> float:
        """A limit [rad or m], or infinity."""
        if element is None:
            return unlimited
        text = element.text.strip().lstrip("+-")
        if text.lower() in _INFINITY:
            return unlimited
        value = self.xml.text_number(element, (*self.path, "limits"), 0.0)
        if abs(value) >= _UNLIMITED:
            return unlimited
        return value

    def _dynamics(self, dynamics: LocatedElement) -> Data:
        """Friction and spring."""
        values: dict[str, float] = {}
        for child in dynamics.children:
            values[child.tag] = self.xml.text_number(child, self.path, 0.0)
        entries: Data = {}
        viscous = values.get("damping", 0.0)
        coulomb = values.get("friction", 0.0)
        if viscous or coulomb:
            entries["friction"] = {"viscous": viscous, "coulomb": coulomb}
        stiffness = values.get("spring_stiffness", 0.0)
        if stiffness:
            rest = values.get("spring_reference", 0.0)
            entries["spring"] = {"stiffness": stiffness, "rest": rest}
        return entries

    def _mimic(self, mimic: LocatedElement) -> Data:
        multiplier = self._number_in(mimic, "multiplier", 1.0)
        offset = self._number_in(mimic, "offset", 0.0)
        reference = self._number_in(mimic, "reference", 0.0)
        return {
            "joint": mimic.get("joint"),
            "multiplier": multiplier,
            "offset": offset - multiplier * reference,
        }

    def _number_in(self, element: LocatedElement, tag: str, default: float) -> float:
        return self.xml.text_number(element.first(tag), self.path, default)
