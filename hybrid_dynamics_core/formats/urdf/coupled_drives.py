"""Transmissions of a URDF that couple two actuators with two joints.

n_a and n_j are the reductions, x the position of an actuator, d that of a joint from its offset:

* DifferentialTransmission: x_1 = n_a1 (n_j1 d_1 + n_j2 d_2), x_2 = n_a2 (n_j1 d_1 - n_j2 d_2).
* FourBarLinkageTransmission: x_1 = n_a1 n_j1 d_1, x_2 = n_a2 (d_1 + n_j2 d_2).

The equations are those of `transmission_interface` of ros2_control.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...description.document import KeyPath
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
        DescriptionError: a reduction is zero, or a name is already used.
    """
    kind = transmission_type(element)
    if kind not in (DIFFERENTIAL, FOUR_BAR):
        return []
    actuators = _sides(xml, element, "actuator")
    joints = _sides(xml, element, "joint")
    moving = [joint for joint in joints if _moves(xml, joint.name)]
    if len(actuators) != 2 or len(moving) != 2:
        return []
    first, second = joints
    if kind == DIFFERENTIAL:
        rows = [(first.reduction, second.reduction), (first.reduction, -second.reduction)]
    else:
        rows = [(first.reduction, 0.0), (1.0, second.reduction)]
    for actuator, row in zip(actuators, rows, strict=True):
        _add_drive(xml, element, actuator, joints, row)
    return [actuator.name for actuator in actuators]


def _add_drive(
    xml: XmlReader,
    element: LocatedElement,
    actuator: _Side,
    joints: Sequence[_Side],
    row: Sequence[float],
) -> None:
    """Add an actuator whose position is its reduction times a weighted sum of joint positions."""
    document = xml.document
    if actuator.name in (*document.section("joints"), *document.section("transmissions")):
        problem = f"the actuator '{actuator.name}' has the name of a joint or of another actuator"
        raise xml.error(element, ("transmissions", actuator.name), problem)
    multipliers: dict[str, float] = {}
    offset = 0.0
    for joint, factor in zip(joints, row, strict=True):
        if factor:
            multipliers[joint.name] = actuator.reduction * factor
            offset -= actuator.reduction * factor * joint.offset
    entry = {"joints": multipliers, "offset": offset}
    xml.add(("transmissions", actuator.name), entry, element)


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
