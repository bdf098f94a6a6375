"""A robot as URDF: its spanning tree, loops cut. Every joint, passive ones too, is one that something has to drive.

URDF knows no loops: positions of all joints, as `robot.close` gives them, show the robot as it is.
Links are drawn as thin rods to their joints, pins and frames, since a description has no shapes.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from ...description.geometry import rotation_with_z_axis, rpy_of
from ...description.model import Frame, Joint, Link, RobotDescription, effects_of
from ...ground.arrays import Array
from .. import shapes
from ..extras_writer import comment, in_words, rest_of
from ..shapes import number, numbers

UNLIMITED = 1e3  # [m] travel of a prismatic joint without limits, which URDF does not know
CARRIED = frozenset({"friction", "mimic"})  # what a URDF says of all that it may not say
EFFORT = (
    1e9  # [N m or N], RATE [rad/s or m/s]: limits that URDF wants and a description does not give
)
RATE = 1e3


def to_urdf(robot: RobotDescription) -> str:
    """The spanning tree of a robot as URDF text: the same link frames, joint names, axes, limits, masses and inertias.

    Frames of the robot that are no links become links without mass on fixed joints, payloads links
    with mass. A comment at the top names the loops that are cut and whatever else a URDF has no
    words for.
    """
    root = tree_element(robot)
    cut = ", ".join(closure.name for closure in robot.closures) or "none"
    lost = in_words(rest_of(robot, CARRIED))
    comment(root, f"Loops that are cut: {cut}. Not in this file: {lost}.")
    return as_xml(root)


def tree_element(robot: RobotDescription) -> Element:
    """The <robot> element of the spanning tree."""
    root = Element("robot", name=robot.name)
    links = {robot.base: Link(robot.base), **robot.links}
    marks = {name: list(shapes.marks(robot, name)) for name in links}
    size = max(
        (float(np.linalg.norm(point)) for points in marks.values() for point in points), default=1.0
    )
    for name, link in links.items():
        _add_link(root, link, marks[name], shapes.THICKNESS * size)
    for joint in robot.joints.values():
        _add_joint(root, joint, robot)
    for name, frame in shapes.frames(robot):
        add_frame(root, name, frame)
    for link_name in links:
        for name, frame, payload in shapes.payloads(robot, link_name):
            body = Link(name, payload.mass, np.asarray(payload.com), np.asarray(payload.inertia))
            _add_link(root, body, [], 0.0)
            _add_fixed(root, name, frame)
    return root


def as_xml(root: Element) -> str:
    """The text of a file."""
    indent(root)
    return tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def add_frame(root: Element, name: str, frame: Frame) -> None:
    """A place on a link as a link without mass."""
    SubElement(root, "link", name=name)
    _add_fixed(root, name, frame)


def _add_link(root: Element, link: Link, marks: list[Array], radius: float) -> None:
    element = SubElement(root, "link", name=link.name)
    if link.mass > 0.0 or link.inertia.any():
        inertial = SubElement(element, "inertial")
        SubElement(inertial, "origin", xyz=numbers(link.com), rpy="0 0 0")
        SubElement(inertial, "mass", value=number(link.mass))
        J = link.inertia
        moments = {
            "ixx": J[0, 0],
            "ixy": J[0, 1],
            "ixz": J[0, 2],
            "iyy": J[1, 1],
            "iyz": J[1, 2],
            "izz": J[2, 2],
        }
        SubElement(inertial, "inertia", {name: number(value) for name, value in moments.items()})
    for mark in marks:
        length = float(np.linalg.norm(mark))
        if length > shapes.SMALLEST:
            visual = SubElement(element, "visual")
            add_origin(visual, 0.5 * mark, rotation_with_z_axis(mark / length))
            geometry = SubElement(visual, "geometry")
            SubElement(geometry, "cylinder", radius=number(radius), length=number(length))


def _add_joint(root: Element, joint: Joint, robot: RobotDescription) -> None:
    lower, upper = joint.limits
    limited = math.isfinite(lower) and math.isfinite(upper)
    endless = joint.type == "revolute" and not limited
    element = SubElement(
        root, "joint", name=joint.name, type="continuous" if endless else joint.type
    )
    add_origin(element, joint.translation, joint.rotation)
    SubElement(element, "parent", link=joint.parent)
    SubElement(element, "child", link=joint.child)
    SubElement(element, "axis", xyz=numbers(joint.axis))
    limit = {"effort": number(EFFORT), "velocity": number(RATE)}
    if not endless:
        lower, upper = max(lower, -UNLIMITED), min(upper, UNLIMITED)
        limit |= {"lower": number(lower), "upper": number(upper)}
    SubElement(element, "limit", limit)
    effect, mimic = effects_of(robot, joint.name), robot.mimics.get(joint.name)
    if effect.viscous or effect.coulomb:
        SubElement(
            element, "dynamics", damping=number(effect.viscous), friction=number(effect.coulomb)
        )
    if mimic is not None:
        follows = {"multiplier": number(mimic.multiplier), "offset": number(mimic.offset)}
        SubElement(element, "mimic", {"joint": mimic.source, **follows})


def _add_fixed(root: Element, name: str, frame: Frame) -> None:
    element = SubElement(root, "joint", name=f"{name}_fixed", type="fixed")
    add_origin(element, frame.translation, frame.rotation)
    SubElement(element, "parent", link=frame.link)
    SubElement(element, "child", link=name)


def add_origin(element: Element, translation: Array, rotation: Array) -> None:
    """A pose as URDF has it."""
    SubElement(element, "origin", xyz=numbers(translation), rpy=numbers(rpy_of(rotation)))
