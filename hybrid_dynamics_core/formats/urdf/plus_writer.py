"""A robot as URDF+ (Chignoli et al. 2024, arXiv 2411.19753): URDF with <loop> and <coupling> elements beside the tree.

Joints say whether they are independent. Parsers that know no URDF+ read the spanning tree.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from ...description.model import Closure, RobotDescription
from ...ground.arrays import Array
from .. import shapes
from ..extras_reader import TAG
from ..extras_writer import as_text, comment, in_words, rest_of
from ..shapes import number
from .plus_reader import SPHERICAL
from .writer import CARRIED, add_origin, as_xml, tree_element

TYPES = {"planar": "revolute", "axis": "revolute", "point": SPHERICAL, "frame": "fixed"}


def to_urdf_plus(robot: RobotDescription) -> str:
    """The whole robot as URDF+ text; what URDF+ has no words for is in an element that other programs pass over.

    A pin of a planar loop is a loop of type revolute. URDF+ has no type for a loop closed by a
    spherical joint: `spherical` is a word of this library's.
    """
    root = tree_element(robot)
    for element in root.findall("joint"):
        if element.get("type") != "fixed":
            element.set("independent", "true" if element.get("name") in robot.active else "false")
    for closure in robot.closures:
        _add_loop(root, robot, closure)
    for follower in robot.mimics:
        _add_coupling(root, robot, follower)
    rest = rest_of(robot, CARRIED)
    told = (
        f"<{TAG}> holds what URDF+ has no words for: {in_words(rest)}. Other programs pass it over."
    )
    comment(root, told)
    SubElement(root, TAG).text = f"\n{as_text(rest)}\n"
    return as_xml(root)


def _add_loop(root: Element, robot: RobotDescription, closure: Closure) -> None:
    element = SubElement(root, "loop", name=closure.name, type=TYPES[closure.kind])
    on_a, on_b = shapes.hinge(robot, closure)
    _add_end(element, "predecessor", closure.link_a, closure.point_a, on_a)
    _add_end(element, "successor", closure.link_b, closure.point_b, on_b)
    if TYPES[closure.kind] == "revolute":
        SubElement(element, "axis", xyz="0 0 1")


def _add_end(element: Element, tag: str, link: str, point: Array, rotation: Array) -> None:
    add_origin(SubElement(element, tag, link=link), point, rotation)


def _add_coupling(root: Element, robot: RobotDescription, follower: str) -> None:
    """Of joints side by side without an offset; <mimic> says the others, and these too."""
    mimic = robot.mimics[follower]
    own, source = robot.joints[follower], robot.joints[mimic.source]
    if own.parent != source.parent or mimic.offset:
        return
    element = SubElement(root, "coupling", name=f"{follower}_coupling")
    SubElement(element, "predecessor", link=source.child)
    SubElement(element, "successor", link=own.child)
    SubElement(element, "ratio", value=number(mimic.multiplier))
