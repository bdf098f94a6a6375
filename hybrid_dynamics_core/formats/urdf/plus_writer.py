"""Writer of URDF+: URDF with <loop> and <coupling> elements.

Chignoli et al. (2024), arXiv 2411.19753. Joints have the attribute `independent`. Parsers of plain
URDF read the spanning tree.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from ...description.document import Data
from ...description.model import Closure, Frame, RobotDescription
from ...robot.taken import AnyRobot, description_of
from .. import shapes
from ..extras_reader import TAG
from ..extras_writer import extras_of, extras_summary, extras_text, without_empty
from ..xml.writer import add_text, insert_comment, number_text, xml_text
from .couplings import Hung, coupling_links
from .plus_reader import SPHERICAL
from .writer import FEATURES, add_origin, limits_text, tree_element

_LOOP_TYPES = {  # by kind of closure
    "planar": "revolute",
    "axis": "revolute",
    "point": SPHERICAL,
    "frame": "fixed",
}


def to_urdf_plus(robot: AnyRobot, folder: str | Path | None = None) -> str:
    """The whole robot as URDF+ text.

    Data that URDF+ cannot express are in an element that other programs ignore. A pin of a planar
    loop becomes a loop of type revolute. A loop closed by a spherical joint gets the type
    `spherical`, which is an extension of this library.

    Args:
        robot: the robot to write.
        folder: folder of the file. Meshes in it get relative paths, others absolute ones.
    """
    description = description_of(robot)
    root = tree_element(description, folder)
    for element in root.findall("joint"):
        if element.get("type") != "fixed":
            independent = "false"
            if element.get("name") in description.motors:
                independent = "true"
            element.set("independent", independent)
    for closure in description.closures:
        _add_loop(root, description, closure)
    coupled = _add_couplings(root, description)
    extras = _without_mimics(extras_of(description, FEATURES), coupled)
    aside = f"<{TAG}> holds what URDF+ has no words for: {extras_summary(extras)}."
    insert_comment(root, f"{aside} Other programs pass it over.{limits_text(description)}")
    add_text(root, TAG, f"\n{extras_text(extras)}\n")
    return xml_text(root)


def _without_mimics(extras: Data, followers: Iterable[str]) -> Data:
    """The extras without followers that are written as <coupling>."""
    joints = extras.get("joints", {})
    for name in followers:
        joints.get(name, {}).pop("mimic", None)
    return without_empty({**extras, "joints": without_empty(joints)})


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


def _add_couplings(root: Element, robot: RobotDescription) -> list[str]:
    """Add a <coupling> for every follower that URDF+ can express: those without offset.

    Returns:
        The names of these followers.
    """
    hung = {joint.child: Hung(joint.name, joint.parent) for joint in robot.joints.values()}
    coupled: list[str] = []
    for follower, mimic in robot.mimics.items():
        links = coupling_links(hung, follower, mimic.multipliers)
        if links is None or mimic.offset:
            continue
        predecessor, successor, ratio = links
        element = SubElement(root, "coupling", name=f"{follower}_coupling")
        SubElement(element, "predecessor", link=predecessor)
        SubElement(element, "successor", link=successor)
        SubElement(element, "ratio", value=number_text(ratio))
        coupled.append(follower)
    return coupled
