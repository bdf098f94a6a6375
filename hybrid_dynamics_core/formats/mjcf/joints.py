"""Joints of MJCF: their type, axis, limits, friction, drive and spring."""

from __future__ import annotations

from ...description.document import Data, KeyPath
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .vocabulary import JOINT_NUMBERS

_TYPES = {"hinge": "revolute", "slide": "prismatic"}
_Z_AXIS = (0.0, 0.0, 1.0)


def read_joint(xml: XmlReader, joint: LocatedElement, name: str) -> Data:
    """Type, axis, limits and effects of a joint."""
    path: KeyPath = ("joints", name)
    mujoco_type = joint.get("type", "hinge")
    if mujoco_type not in _TYPES:
        problem = f"is '{mujoco_type}'; expected {' or '.join(_TYPES)}"
        raise xml.error(joint, (*path, "type"), problem)
    effects = _effects(xml, joint, path)
    entry: Data = {
        "type": _TYPES[mujoco_type],
        "axis": xml.numbers(joint, "axis", 3, path, _Z_AXIS),
    }
    if "range" in joint.attributes and joint.get("limited") != "false":
        limits_path = (*path, "limits")
        entry["limits"] = xml.numbers(joint, "range", 2, limits_path)
    return entry | _effort_limit(xml, joint, path) | effects


def _effort_limit(xml: XmlReader, joint: LocatedElement, path: KeyPath) -> Data:
    """The largest effort; of a range that is not the same both ways the larger end."""
    key = (*path, "effort_limit")
    if "actuatorfrcrange" not in joint.attributes or joint.get("actuatorfrclimited") == "false":
        return {}
    lower, upper = xml.numbers(joint, "actuatorfrcrange", 2, key)
    largest = max(-lower, upper)
    if lower != -upper:
        _, name = path
        xml.note(joint, f"joint {name} has efforts of {lower:g} to {upper:g}; kept: {largest:g}")
    return {"effort_limit": largest}


def _effects(xml: XmlReader, joint: LocatedElement, path: KeyPath) -> Data:
    """Friction, drive and spring of a joint."""
    numbers: dict[str, float] = {}
    for attribute in sorted(JOINT_NUMBERS.intersection(joint.attributes)):
        numbers[attribute] = xml.number(joint, attribute, path)
    entries: Data = {}
    if "damping" in numbers or "frictionloss" in numbers:
        viscous = numbers.get("damping", 0.0)
        coulomb = numbers.get("frictionloss", 0.0)
        entries["friction"] = {"viscous": viscous, "coulomb": coulomb}
    if "armature" in numbers:
        entries["drive"] = {"rotor_inertia": numbers["armature"]}
    if "stiffness" in numbers:
        rest = numbers.get("springref", 0.0)
        entries["spring"] = {"stiffness": numbers["stiffness"], "rest": rest}
    return entries
