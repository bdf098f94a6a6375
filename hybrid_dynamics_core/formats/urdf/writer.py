"""Writer of URDF: the spanning tree with all joints; loops are cut.

URDF has no loops. With the joint positions of `robot.close` the robot looks closed. Links without
visuals are drawn as thin rods to their joints, pins and frames.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from ...description.geometry import rotation_with_z_axis, rpy_of
from ...description.model import Frame, Joint, Link, Mimic, RobotDescription, effects_of
from ...ground.arrays import Array
from ...robot.taken import AnyRobot, description_of
from .. import shapes
from ..extras_writer import Feature, extras_of, extras_summary
from ..visual_elements import ROD
from ..xml.writer import insert_comment, number_text, numbers_text, xml_text
from .cut_loops import NONE, comment_of
from .joints import UNLIMITED
from .visual_writer import VisualWriter

FEATURES = frozenset(
    {Feature.FRICTION, Feature.MIMIC, Feature.EFFORT_LIMITS, Feature.VELOCITY_LIMITS}
)
_LONGEST_TRAVEL = 1e3  # [m] limit of slides without one, since URDF requires both


def to_urdf(robot: AnyRobot, folder: str | Path | None = None) -> str:
    """The spanning tree of a robot as URDF text, with the same link frames and joint names.

    Axes, masses, inertias and two-sided limits are the same too. Frames become massless links on
    fixed joints, payloads links with mass. A comment at the top lists the cut loops, other lost
    data, and the joints with changed limits.

    Args:
        robot: the robot that is written.
        folder: folder of the file. Meshes in it get relative paths, others absolute ones.
    """
    description = description_of(robot)
    root = tree_element(description, folder)
    cut = ", ".join(closure.name for closure in description.closures) or NONE
    omitted = extras_summary(extras_of(description, FEATURES))
    limits = limits_text(description)
    free = _free_followers(description)
    insert_comment(root, f"{comment_of(cut, omitted)}{limits}{free}")
    return xml_text(root)


def limits_text(robot: RobotDescription) -> str:
    """A sentence on the joints whose limits URDF cannot express; empty if there are none.

    They are revolute joints with one limit, and slides with one or none.
    """
    notes = map(_limits_note, robot.joints.values())
    changes = "; ".join(note for note in notes if note)
    if not changes:
        return ""
    return f" Limits that are written otherwise: {changes}."


def _free_followers(robot: RobotDescription) -> str:
    """A sentence on the joints that follow several others, which URDF cannot express."""
    names = [name for name, mimic in robot.mimics.items() if len(mimic.multipliers) > 1]
    if not names:
        return ""
    return f" Joints that follow several others, and are free in this file: {', '.join(names)}."


def tree_element(robot: RobotDescription, folder: str | Path | None = None) -> Element:
    """The <robot> element of the spanning tree, without a comment.

    Args:
        robot: the robot that is written.
        folder: folder of the file.
    """
    root = Element("robot", name=robot.name)
    links = shapes.all_links(robot)
    visuals = VisualWriter(robot, None if folder is None else Path(folder))
    radius = shapes.ROD_RADIUS * shapes.robot_size(robot)
    for name, link in links.items():
        element = _add_link(root, link)
        if visuals.add(element, name):
            continue
        for end in shapes.rods(shapes.attachment_points(robot, name)):
            _add_rod(element, end, radius, f"{ROD}_{next(visuals.numbers)}")
    for joint in robot.joints.values():
        _add_joint(root, joint, robot)
    for name, frame in shapes.extra_frames(robot):
        add_frame(root, name, frame)
    for link_name in links:
        for body, frame in shapes.payload_bodies(robot, link_name):
            _add_link(root, body)
            _add_fixed_joint(root, body.name, frame)
    return root


def add_frame(root: Element, name: str, frame: Frame) -> None:
    """Add a frame as a link without mass on a fixed joint.

    Args:
        root: the <robot> element.
        name: name of the new link.
        frame: pose of the frame in the link that carries it.
    """
    SubElement(root, "link", name=name)
    _add_fixed_joint(root, name, frame)


def add_origin(element: Element, translation: Array, rotation: Array) -> None:
    """Add an <origin>.

    Args:
        element: the joint, visual or loop end at this pose.
        translation: (3,) [m] in the parent's frame.
        rotation: (3, 3) from the element's frame to the parent's.
    """
    xyz = numbers_text(translation)
    rpy = numbers_text(rpy_of(rotation))
    SubElement(element, "origin", xyz=xyz, rpy=rpy)


def _add_link(root: Element, link: Link) -> Element:
    """Add a <link>, with an <inertial> about the centre of mass if it has mass."""
    element = SubElement(root, "link", name=link.name)
    if link.mass <= 0.0 and not link.inertia.any():
        return element
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "origin", xyz=numbers_text(link.com), rpy="0 0 0")
    SubElement(inertial, "mass", value=number_text(link.mass))
    J = link.inertia
    SubElement(
        inertial,
        "inertia",
        ixx=number_text(J[0, 0]),
        ixy=number_text(J[0, 1]),
        ixz=number_text(J[0, 2]),
        iyy=number_text(J[1, 1]),
        iyz=number_text(J[1, 2]),
        izz=number_text(J[2, 2]),
    )
    return element


def _add_rod(link: Element, end: Array, radius: float, name: str) -> None:
    """A rod from the origin of a link to a point of it."""
    length = shapes.norm(end)
    visual = SubElement(link, "visual", name=name)
    add_origin(visual, 0.5 * end, rotation_with_z_axis(end / length))
    geometry = SubElement(visual, "geometry")
    cylinder = SubElement(geometry, "cylinder")
    cylinder.set("radius", number_text(radius))
    cylinder.set("length", number_text(length))


def _add_joint(root: Element, joint: Joint, robot: RobotDescription) -> None:
    """Add a <joint> of the tree with limits, friction and the joint that it follows."""
    is_continuous = joint.type == "revolute" and not _has_both_limits(joint)
    urdf_type = "continuous" if is_continuous else joint.type
    element = SubElement(root, "joint", name=joint.name, type=urdf_type)
    add_origin(element, joint.translation, joint.rotation)
    SubElement(element, "parent", link=joint.parent)
    SubElement(element, "child", link=joint.child)
    SubElement(element, "axis", xyz=numbers_text(joint.axis))
    limit = {
        "effort": number_text(min(joint.effort_limit, UNLIMITED)),
        "velocity": number_text(min(joint.velocity_limit, UNLIMITED)),
    }
    if math.isfinite(joint.acceleration_limit):
        limit["acceleration"] = number_text(joint.acceleration_limit)
    if not is_continuous:
        lower, upper = _written_limits(joint)
        limit["lower"] = number_text(lower)
        limit["upper"] = number_text(upper)
    SubElement(element, "limit", limit)
    _add_friction(element, robot, joint.name)
    mimic = robot.mimics.get(joint.name)
    if mimic is not None and len(mimic.multipliers) == 1:
        _add_mimic(element, mimic)


def _limits_note(joint: Joint) -> str:
    """Text on limits that URDF cannot express; empty for others."""
    if _has_both_limits(joint):
        return ""
    lower, upper = joint.limits
    limits = f"{joint.name} has {lower:g} to {upper:g}"
    if joint.type == "prismatic":
        least, largest = _written_limits(joint)
        return f"{limits}, written as {least:g} to {largest:g} m"
    if lower == -math.inf and upper == math.inf:  # type continuous
        return ""
    return f"{limits}, written as continuous"


def _has_both_limits(joint: Joint) -> bool:
    return all(map(math.isfinite, joint.limits))


def _written_limits(joint: Joint) -> tuple[float, float]:
    """The limits of a joint [rad or m], with a substitute for each missing limit of a slide."""
    lower, upper = joint.limits
    if lower == -math.inf:
        lower = min(upper, 0.0) - _LONGEST_TRAVEL
    if upper == math.inf:
        upper = max(lower, 0.0) + _LONGEST_TRAVEL
    return lower, upper


def _add_friction(element: Element, robot: RobotDescription, name: str) -> None:
    """Add the <dynamics> of a joint that has friction."""
    effect = effects_of(robot, name)
    if not effect.viscous and not effect.coulomb:
        return
    damping = number_text(effect.viscous)
    friction = number_text(effect.coulomb)
    SubElement(element, "dynamics", damping=damping, friction=friction)


def _add_mimic(joint_element: Element, mimic: Mimic) -> None:
    ((source, multiplier),) = mimic.multipliers.items()
    element = SubElement(joint_element, "mimic", joint=source)
    element.set("multiplier", number_text(multiplier))
    element.set("offset", number_text(mimic.offset))


def _add_fixed_joint(root: Element, link: str, frame: Frame) -> None:
    """Add a fixed joint from the link of a frame to a link at that frame."""
    element = SubElement(root, "joint", name=f"{link}_fixed", type="fixed")
    add_origin(element, frame.translation, frame.rotation)
    SubElement(element, "parent", link=frame.link)
    SubElement(element, "child", link=link)
