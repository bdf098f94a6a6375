"""Transmissions of a URDF that couple two actuators with two joints.

n_a and n_j are the reductions, x the position of an actuator, d that of a joint from its offset:

* DifferentialTransmission: x_1 = n_a1 (n_j1 d_1 + n_j2 d_2), x_2 = n_a2 (n_j1 d_1 - n_j2 d_2).
* FourBarLinkageTransmission: x_1 = n_a1 n_j1 d_1, x_2 = n_a2 (d_1 + n_j2 d_2).

The equations are those of `transmission_interface` of ros2_control.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...description.document import Data, KeyPath
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

DIFFERENTIAL = "DifferentialTransmission"
FOUR_BAR = "FourBarLinkageTransmission"
_REDUCTIONS = ("mechanicalReduction", "mechanical_reduction")


class _Side(NamedTuple):
    """An actuator or joint of a transmission."""

    name: str
    reduction: float
    offset: float


def transmission_type(element: LocatedElement) -> str:
    """The type of a <transmission>, without its package."""
    written = element.get("type")
    for tag in ("type", "plugin"):
        child = element.first(tag)
        if child is not None:
            written = child.text
    return written.strip().rpartition("/")[2]


def add_coupled_drives(xml: XmlReader, element: LocatedElement) -> list[str]:
    """Add the actuators of a differential or four-bar linkage as drives of both joints.

    Args:
        xml: the URDF, with joints already in the document.
        element: the <transmission>.

    Returns:
        Names of the actuators; empty for other types of transmissions.

    Raises:
        DescriptionError: a reduction is zero.
    """
    kind = transmission_type(element)
    if kind not in (DIFFERENTIAL, FOUR_BAR):
        return []
    actuators = _sides(xml, element, "actuator")
    joints = _sides(xml, element, "joint")
    if len(actuators) != 2 or len(joints) != 2:
        return []
    if not all(_moves(xml, joint.name) for joint in joints):
        return []
    first, second = joints
    if kind == DIFFERENTIAL:
        rows = [(first.reduction, second.reduction), (first.reduction, -second.reduction)]
    else:
        rows = [(first.reduction, 0.0), (1.0, second.reduction)]
    names: list[str] = []
    drives = xml.document.section("transmissions")
    for actuator, row in zip(actuators, rows, strict=True):
        entry = _entry(actuator, joints, row)
        name = actuator.name
        if drives.get(name) != entry:  # else the file has the transmission twice
            name = _free_name(xml, element, name)
            xml.add(("transmissions", name), entry, element)
        names.append(name)
    return names


def _free_name(xml: XmlReader, element: LocatedElement, name: str) -> str:
    """The name of an actuator; another one, with a note, if it is already used or missing."""
    document = xml.document
    taken = ("", *document.section("joints"), *document.section("transmissions"))
    free_name = name
    while free_name in taken:
        free_name += "_motor"
    if free_name != name:
        reason = "it is the name of a joint or of another drive" if name else "no name is given"
        xml.note(element, f"the actuator '{name}' is called '{free_name}' here: {reason}")
    return free_name


def _entry(actuator: _Side, joints: Sequence[_Side], row: Sequence[float]) -> Data:
    """A drive whose position is its reduction times a weighted sum of joint positions."""
    multipliers: dict[str, float] = {}
    offset = 0.0
    for joint, factor in zip(joints, row, strict=True):
        if factor:
            multipliers[joint.name] = actuator.reduction * factor
            offset -= actuator.reduction * factor * joint.offset
    return {"joints": multipliers, "offset": offset}


def _moves(xml: XmlReader, name: str) -> bool:
    """Whether a joint has one degree of freedom."""
    joint = xml.document.section("joints").get(name, {})
    return joint.get("type") in ("revolute", "prismatic")


def _sides(xml: XmlReader, element: LocatedElement, tag: str) -> list[_Side]:
    """The actuators or joints of a transmission, in the order of their roles, if given."""
    children = element.all(tag)
    children.sort(key=_role)
    sides: list[_Side] = []
    for child in children:
        name = child.get("name")
        path: KeyPath = ("transmissions", element.get("name"), name)
        reduction = 1.0
        for word in _REDUCTIONS:
            reduction = xml.text_number(child.first(word), path, reduction)
        if not reduction:
            raise xml.error(child, path, "has the reduction 0; expected another number")
        sides.append(_Side(name, reduction, xml.text_number(child.first("offset"), path, 0.0)))
    return sides


def _role(element: LocatedElement) -> str:
    """The role of an actuator or joint; empty if it has none."""
    role = element.first("role")
    return element.get("role") if role is None else role.text.strip()
