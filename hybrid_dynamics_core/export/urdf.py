"""A robot as URDF: its spanning tree, loops cut. Every joint, passive ones too, is one that something has to drive.

URDF knows no loops: positions of all joints, as `robot.close` gives them, show the robot as it is. Links are drawn as
thin rods to their joints, pins and frames, since a description has no shapes.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from ..description.geometry import rotation_to_axis
from ..description.model import Array, Frame, Joint, Link, RobotDescription
from . import shapes
from .shapes import number, numbers

UNLIMITED = 1e3  # [m] travel of a prismatic joint without limits, which URDF does not know
EFFORT = 1e9  # [N m or N], RATE [rad/s or m/s]: limits that URDF wants and a description does not give
RATE = 1e3


def to_urdf(robot: RobotDescription) -> str:
    """The spanning tree of a robot as URDF text: the same link frames, joint names, axes, masses and inertias.

    Frames of the robot that are no links become links without mass on fixed joints.
    """
    root = Element("robot", name=robot.name)
    links = {robot.base: Link(robot.base), **robot.links}
    marks = {name: list(shapes.marks(robot, name)) for name in links}
    size = max((float(np.linalg.norm(point)) for points in marks.values() for point in points), default=1.0)
    for name, link in links.items():
        _add_link(root, link, marks[name], shapes.THICKNESS * size)
    for joint in robot.joints.values():
        _add_joint(root, joint)
    for name, frame in robot.frames.items():
        if name not in links:
            SubElement(root, "link", name=name)
            _add_fixed(root, name, frame)
    indent(root)
    return tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _add_link(root: Element, link: Link, marks: list[Array], radius: float) -> None:
    element = SubElement(root, "link", name=link.name)
    if link.mass > 0.0 or link.inertia.any():
        inertial = SubElement(element, "inertial")
        SubElement(inertial, "origin", xyz=numbers(link.com), rpy="0 0 0")
        SubElement(inertial, "mass", value=number(link.mass))
        J = link.inertia
        moments = {"ixx": J[0, 0], "ixy": J[0, 1], "ixz": J[0, 2], "iyy": J[1, 1], "iyz": J[1, 2], "izz": J[2, 2]}
        SubElement(inertial, "inertia", {name: number(value) for name, value in moments.items()})
    for mark in marks:
        length = float(np.linalg.norm(mark))
        if length > shapes.SMALLEST:
            visual = SubElement(element, "visual")
            _add_origin(visual, 0.5 * mark, rotation_to_axis(mark / length))
            geometry = SubElement(visual, "geometry")
            SubElement(geometry, "cylinder", radius=number(radius), length=number(length))


def _add_joint(root: Element, joint: Joint) -> None:
    lower, upper = joint.limits
    limited = math.isfinite(lower) and math.isfinite(upper)
    endless = joint.type == "revolute" and not limited
    element = SubElement(root, "joint", name=joint.name, type="continuous" if endless else joint.type)
    _add_origin(element, joint.translation, joint.rotation)
    SubElement(element, "parent", link=joint.parent)
    SubElement(element, "child", link=joint.child)
    SubElement(element, "axis", xyz=numbers(joint.axis))
    limit = {"effort": number(EFFORT), "velocity": number(RATE)}
    if not endless:
        lower, upper = max(lower, -UNLIMITED), min(upper, UNLIMITED)
        limit |= {"lower": number(lower), "upper": number(upper)}
    SubElement(element, "limit", limit)


def _add_fixed(root: Element, name: str, frame: Frame) -> None:
    element = SubElement(root, "joint", name=f"{name}_fixed", type="fixed")
    _add_origin(element, frame.translation, frame.rotation)
    SubElement(element, "parent", link=frame.link)
    SubElement(element, "child", link=name)


def _add_origin(element: Element, translation: Array, rotation: Array) -> None:
    SubElement(element, "origin", xyz=numbers(translation), rpy=numbers(rpy_of(rotation)))


def rpy_of(rotation: Array) -> Array:
    """Fixed-axis roll, pitch, yaw [rad] of a rotation matrix (3, 3): R = Rz(yaw) Ry(pitch) Rx(roll).

    Where the pitch is a right angle, only yaw - roll or yaw + roll is settled: the yaw is taken as zero.
    """
    level = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], level)
    if level < 1e-9:
        return np.array([math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0])
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    return np.array([roll, pitch, math.atan2(rotation[1, 0], rotation[0, 0])])
