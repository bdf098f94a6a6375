"""A robot as URDF+: URDF with <loop> and <coupling> elements beside the tree.

Chignoli et al. (2024), arXiv 2411.19753. Joints say whether they are independent. Parsers that know
no URDF+ read the spanning tree.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from ...description.model import Closure, Frame, RobotDescription
from .. import shapes
from ..extras_reader import TAG
from ..extras_writer import extras_of, extras_summary, extras_text
from ..xml.writer import add_text, insert_comment, number_text, xml_text
from .plus_reader import SPHERICAL
from .writer import FEATURES, add_origin, tree_element

_LOOP_TYPES = {
    "planar": "revolute",
    "axis": "revolute",
    "point": SPHERICAL,
    "frame": "fixed",
}


def to_urdf_plus(robot: RobotDescription) -> str:
    """The whole robot as URDF+ text.

    What URDF+ has no words for is in an element that other programs pass over. A pin of a planar
    loop is a loop of type revolute. URDF+ has no type for a loop closed by a spherical joint:
    `spherical` is a word of this library's.

    Args:
        robot: that is written.
    """
    root = tree_element(robot)
    for element in root.findall("joint"):
        if element.get("type") != "fixed":
            is_active = element.get("name") in robot.active
            element.set("independent", "true" if is_active else "false")
    for closure in robot.closures:
        _add_loop(root, robot, closure)
    for follower in robot.mimics:
        _add_coupling(root, robot, follower)
    extras = extras_of(robot, FEATURES)
    insert_comment(
        root,
        f"<{TAG}> holds what URDF+ has no words for: {extras_summary(extras)}. Other programs pass"
        " it over.",
    )
    add_text(root, TAG, f"\n{extras_text(extras)}\n")
    return xml_text(root)


def _add_loop(root: Element, robot: RobotDescription, closure: Closure) -> None:
    loop_type = _LOOP_TYPES[closure.kind]
    element = SubElement(root, "loop", name=closure.name, type=loop_type)
    predecessor, successor = shapes.hinge_frames(robot, closure)
    _add_end(element, "predecessor", predecessor)
    _add_end(element, "successor", successor)
    if loop_type == "revolute":
        SubElement(element, "axis", xyz="0 0 1")


def _add_end(loop: Element, tag: str, frame: Frame) -> None:
    end = SubElement(loop, tag, link=frame.link)
    add_origin(end, frame.translation, frame.rotation)


def _add_coupling(root: Element, robot: RobotDescription, name: str) -> None:
    """Add a coupling of joints side by side without an offset; <mimic> says all couplings."""
    mimic = robot.mimics[name]
    follower = robot.joints[name]
    source = robot.joints[mimic.source]
    if follower.parent != source.parent or mimic.offset:
        return
    element = SubElement(root, "coupling", name=f"{name}_coupling")
    SubElement(element, "predecessor", link=source.child)
    SubElement(element, "successor", link=follower.child)
    SubElement(element, "ratio", value=number_text(mimic.multiplier))
