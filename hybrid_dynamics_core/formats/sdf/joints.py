"""Joints of SDFormat: their ends, axis, limits, friction, spring, and the joint they follow."""

from __future__ import annotations

import math
from typing import Any

from ...description.document import KeyPath
from ...description.geometry import unit_axis
from ...ground.arrays import Array
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .poses import ModelPoses

_UNLIMITED = 1e16  # [rad or m] what SDFormat takes for no limit
_Z_AXIS = (0.0, 0.0, 1.0)


def end_name(xml: XmlReader, joint: LocatedElement, tag: str) -> str:
    """The name in <parent> or <child>.

    Raises:
        DescriptionError: there is none.
    """
    end = joint.first(tag)
    if end is None or not end.text.strip():
        raise xml.error_at(joint, f"has no <{tag}>")
    return end.text.strip()


class JointReader:
    """Reads what stands in <axis>."""

    def __init__(self, xml: XmlReader, poses: ModelPoses) -> None:
        self.xml = xml
        self.poses = poses

    def axis(self, joint: LocatedElement, path: KeyPath) -> Array:
        """The axis (3,) in the frame of the joint."""
        key = (*path, "axis")
        xyz = _inside_axis(joint, "xyz")
        values = self.xml.text_numbers(xyz, 3, key, _Z_AXIS)
        try:
            axis = unit_axis(values)
        except ValueError as error:
            raise self.xml.error(joint, key, str(error)) from error
        expressed_in = ""
        if xyz is not None:
            expressed_in = xyz.get("expressed_in")
        return self.poses.axis_in_joint(axis, expressed_in, joint)

    def constraints(self, joint: LocatedElement, path: KeyPath) -> dict[str, Any]:
        """Limits, friction, spring and mimic of a joint, as far as it has them."""
        entries: dict[str, Any] = {}
        limit = _inside_axis(joint, "limit")
        if limit is not None and joint.get("type") != "continuous":
            lower = self._bound(limit.first("lower"), -math.inf, path)
            upper = self._bound(limit.first("upper"), math.inf, path)
            if math.isfinite(lower) or math.isfinite(upper):
                entries["limits"] = [lower, upper]
        dynamics = _inside_axis(joint, "dynamics")
        if dynamics is not None:
            entries |= self._dynamics(dynamics, path)
        mimic = _inside_axis(joint, "mimic")
        if mimic is not None:
            entries["mimic"] = self._mimic(mimic, path)
        return entries

    def _bound(self, element: LocatedElement | None, unlimited: float, path: KeyPath) -> float:
        """A limit [rad or m], or infinity."""
        if element is None:
            return unlimited
        if element.text.strip().lstrip("+-").lower() in ("inf", "infinity"):
            return unlimited
        value = self.xml.text_number(element, (*path, "limits"), 0.0)
        if abs(value) >= _UNLIMITED:
            return unlimited
        return value

    def _dynamics(self, dynamics: LocatedElement, path: KeyPath) -> dict[str, Any]:
        """Friction and spring."""
        values: dict[str, float] = {}
        for child in dynamics.children:
            values[child.tag] = self.xml.text_number(child, path, 0.0)
        entries: dict[str, Any] = {}
        viscous = values.get("damping", 0.0)
        coulomb = values.get("friction", 0.0)
        if viscous or coulomb:
            entries["friction"] = {"viscous": viscous, "coulomb": coulomb}
        stiffness = values.get("spring_stiffness", 0.0)
        if stiffness:
            rest = values.get("spring_reference", 0.0)
            entries["spring"] = {"stiffness": stiffness, "rest": rest}
        return entries

    def _mimic(self, mimic: LocatedElement, path: KeyPath) -> dict[str, Any]:
        multiplier = self.xml.text_number(mimic.first("multiplier"), path, 1.0)
        offset = self.xml.text_number(mimic.first("offset"), path, 0.0)
        reference = self.xml.text_number(mimic.first("reference"), path, 0.0)
        return {
            "joint": mimic.get("joint"),
            "multiplier": multiplier,
            "offset": offset - multiplier * reference,
        }


def _inside_axis(joint: LocatedElement, tag: str) -> LocatedElement | None:
    """The first element with a tag in the <axis> of a joint."""
    axis = joint.first("axis")
    if axis is None:
        return None
    return axis.first(tag)
