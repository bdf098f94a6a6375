"""The example: a URDF with a block of ros2_control, and the settings of its controllers."""

from __future__ import annotations

import json
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from ..urdf.writer import tree_element
from ..xml.writer import insert_comment, xml_text
from .sides import Sides

INTERFACES = ("position", "velocity", "effort")
RATE = 500  # [Hz]


def urdf_text(sides: Sides, package: str) -> str:
    """The robot's tree with a block of ros2_control on the joints, and the transmission."""
    robot = sides.drives
    root = tree_element(robot.description, None)
    insert_comment(root, f" The tree of the robot, for the plugins of {package}; loops are cut. ")
    root.append(_block(sides, package))
    return xml_text(root)


def _block(sides: Sides, package: str) -> ET.Element:
    block = ET.Element("ros2_control", {"name": package, "type": "system"})
    hardware = ET.SubElement(block, "hardware")
    # stands in for the drives; real hardware uses the transmission in its read and write
    ET.SubElement(hardware, "plugin").text = "mock_components/GenericSystem"
    state = sides.joints.close(sides.joints.reference)
    starts = dict(zip(sides.joints.active, state.u.tolist(), strict=True))
    for name in sides.joints.active:
        joint = ET.SubElement(block, "joint", {"name": name})
        for interface in INTERFACES:
            ET.SubElement(joint, "command_interface", {"name": interface})
        for interface in INTERFACES:
            element = ET.SubElement(joint, "state_interface", {"name": interface})
            value = starts[name] if interface == "position" else 0.0
            ET.SubElement(element, "param", {"name": "initial_value"}).text = repr(value)
    block.append(_transmission(sides, package))
    return block


def _transmission(sides: Sides, package: str) -> ET.Element:
    element = ET.Element("transmission", {"name": f"{package}_transmission"})
    ET.SubElement(element, "plugin").text = f"{package}/Transmission"
    for name in sides.joints.active:
        ET.SubElement(element, "joint", {"name": name, "role": name})
    for name in sides.drives.active:
        ET.SubElement(element, "actuator", {"name": f"{name}_drive", "role": name})
    ET.SubElement(element, "param", {"name": "limits"}).text = "true"
    return element


def controllers_text(sides: Sides, package: str, dynamics: bool) -> str:
    """The settings of the controller manager and of the controllers."""
    names = list(sides.joints.active)
    lines = [
        f"# Generated for the package {package}.",
        "controller_manager:",
        "  ros__parameters:",
        f"    update_rate: {RATE}  # [Hz]",
        "    joint_state_broadcaster:",
        "      type: joint_state_broadcaster/JointStateBroadcaster",
        "    trajectory:",
        "      type: joint_trajectory_controller/JointTrajectoryController",
    ]
    if not dynamics:
        return "\n".join([*lines, *_trajectory(names, names, ["position"]), ""])
    lines += ["    feed_forward:", f"      type: {package}/FeedForwardController"]
    inputs = [f"feed_forward/{name}" for name in names]
    lines += _trajectory(names, inputs, ["position", "velocity", "acceleration"])
    gravity = sides.drives.loads.gravity.tolist()
    lines += [
        "",
        "feed_forward:",
        "  ros__parameters:",
        "    side: joints  # or drives, where the hardware has those",
        f"    names: {json.dumps(names)}",
        f"    gravity: {json.dumps(gravity)}  # [m/s^2], base axes",
        "    limits: true  # of the efforts of drives",
        "",
    ]
    return "\n".join(lines)


def _trajectory(
    names: Sequence[str], commands: Sequence[str], interfaces: Sequence[str]
) -> list[str]:
    return [
        "",
        "trajectory:",
        "  ros__parameters:",
        f"    joints: {json.dumps(list(names))}",
        f"    command_joints: {json.dumps(list(commands))}",
        f"    command_interfaces: {json.dumps(list(interfaces))}",
        '    state_interfaces: ["position", "velocity"]',
    ]
