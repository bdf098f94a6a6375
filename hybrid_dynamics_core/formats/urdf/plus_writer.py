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
from .writer import FEATURES, add_origin, limits_text, tree_element

_LOOP_TYPES = {  # by kind of closure
    "planar": "revolute",
    "axis": "revolute",
    "point": SPHERICAL,
    "frame": "fixed",
}


def to_urdf_plus(robot: RobotDescription) -> str:
    """The whole robot as URDF+ text.

    What URDF+ has no words for stands in an element that other programs ignore, and is read back
    from there. A pin of a planar loop becomes a loop of type revolute. A loop closed by a spherical
    joint gets the type `spherical`, which only this library reads: URDF+ has none.

    Args:
        robot: the robot that is written.
    """
    root = tree_element(robot)
    for element in root.findall("joint"):
        if element.get("type") != "fixed":
            independent = "false"
            if element.get("name") in robot.motors:
                independent = "true"
            element.set("independent", independent)
    for closure in robot.closures:
        _add_loop(root, robot, closure)
    for follower_name in robot.mimics:
        _add_coupling(root, robot, follower_name)
    extras = extras_of(robot, FEATURES)
    aside = f"<{TAG}> holds what URDF+ has no words for: {extras_summary(extras)}."
    insert_comment(root, f"{aside} Other programs pass it over.{limits_text(robot)}")
    add_text(root, TAG, f"\n{extras_text(extras)}\n")
    return xml_text(root)


def _add_loop(root: Element, robot: RobotDescription, closure: Closure) -> None:
    """Add a <loop> with frames on both links, z along the hinge."""
    loop_type = _LOOP_TYPES[closure.kind]
    element = SubElement(root, "loop", name=closure.name, type=loop_type)
    predecessor, successor = shapes.hinge_frames(robot, closure)
    _add_end(element, "predecessor", predecessor)
    _add_end(element, "successor", successor)
    if loop_type == "revolute":
        SubElement(element, "axis", xyz="0 0 1")


def _add_end(loop: Element, tag: str, frame: Frame) -> None:
    """Add the <predecessor> or <successor> of a loop: a link and a frame on it."""
    end = SubElement(loop, tag, link=frame.link)
    add_origin(end, frame.translation, frame.rotation)


def _add_coupling(root: Element, robot: RobotDescription, follower_name: str) -> None:
    """Add a <coupling> of two joints on one link, where there is no offset.

    It has no words for others. The <mimic> of the follower tells every coupling.
    """
    mimic = robot.mimics[follower_name]
    follower = robot.joints[follower_name]
    source = robot.joints[mimic.source]
    if follower.parent != source.parent or mimic.offset:
        return
    element = SubElement(root, "coupling", name=f"{follower_name}_coupling")
    SubElement(element, "predecessor", link=source.child)
    SubElement(element, "successor", link=follower.child)
    SubElement(element, "ratio", value=number_text(mimic.multiplier))
