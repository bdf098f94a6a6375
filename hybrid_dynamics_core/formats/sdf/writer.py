"""Writer of SDFormat 1.11, for Gazebo Harmonic: a world with gravity and one model.

Loops are joints. In SDFormat all coordinates are zero in the drawn configuration. So the model is
drawn at the closed reference. Coordinates in loops have their zero there, all others that of the
robot.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...description.document import Data
from ...description.geometry import Transform, rotation_about, rotation_with_z_axis, rpy_of
from ...description.model import Closure, Frame, Joint, Link, Mimic, RobotDescription, effects_of
from ...description.rigid_body import impossibility, nearest_possible
from ...errors import InputError
from ...ground.arrays import Array, frozen
from ...mechanism.tree import build_tree
from ...robot.robot import Robot
from ...robot.taken import AnyRobot, robot_of
from .. import shapes
from ..extras_reader import TAG
from ..extras_writer import (
    Feature,
    extras_of,
    extras_summary,
    extras_text,
    link_entry,
    without_empty,
)
from ..visual_elements import ROD, visual_entries
from ..xml.writer import add_text, insert_comment, number_text, numbers_text, xml_text
from .poses import WORLD
from .visual_writer import VisualWriter

_VERSION = "1.11"
_NAMESPACE = f"urn:{TAG}"  # SDFormat requires a namespace for foreign elements
_SMALLEST_INERTIA = 1e-9  # [kg, kg m^2] since a link must have a mass
_ROUNDING = 1e-13  # relative, of moments
_LOOP_TYPES = {
    "planar": "revolute",
    "axis": "revolute",
    "point": "ball",
    "frame": "fixed",
}
_FEATURES = frozenset(Feature) - {Feature.MIMIC_OF_SEVERAL, Feature.WEIGHT_SHARES}
_Z_AXIS = frozen([0.0, 0.0, 1.0])


def to_sdf(robot: AnyRobot, folder: str | Path | None = None) -> str:
    """SDFormat text of a robot, with the same names of links and joints.

    Loops become joints between links of the tree.

    Args:
        robot: the robot to write, or its description.
        folder: folder of the file. Meshes in it get relative paths, others absolute ones.

    Raises:
        InputError: `robot` is neither, or a name is reserved in SDFormat or used twice.
    """
    return _SdfWriter(robot_of(robot), None if folder is None else Path(folder)).text()


class _SdfWriter:
    def __init__(self, robot: Robot, folder: Path | None) -> None:
        self.robot = robot.description
        self.folder = folder
        self.visuals = VisualWriter(self.robot, folder)
        self.zero = _drawn_coordinates(robot)
        self.size = shapes.robot_size(self.robot)
        self.links = shapes.all_links(self.robot)
        self.joint_to = self.robot.joint_to()

    def text(self) -> str:
        _check_names(self.robot)
        root = Element("sdf", {"version": _VERSION, f"xmlns:{TAG}": _NAMESPACE})
        world = SubElement(root, "world", name=f"{self.robot.name}_world")
        add_text(world, "gravity", numbers_text(self.robot.gravity))
        model = SubElement(world, "model", name=self.robot.name)
        self.add_tree(model)
        for closure in self.robot.closures:
            self.add_loop(model, closure)
        extras = self.extras()
        insert_comment(
            model,
            f"<{TAG}:{TAG}> holds what SDFormat has no words for: {extras_summary(extras)}. Other"
            " programs pass it over.",
        )
        add_text(model, f"{TAG}:{TAG}", f"\n{extras_text(extras)}\n")
        return xml_text(root)

    def extras(self) -> Data:
        extras = extras_of(self.robot, _FEATURES)
        others: Data = extras.setdefault("links", {})
        for name, link in self.links.items():
            is_plain = link.mass and _possible(link.inertia) is link.inertia
            if not is_plain and name != WORLD:
                others[name] = link_entry(link)
        visuals_of_world = visual_entries(self.robot, WORLD, self.folder)
        if visuals_of_world:  # which is no link
            others[WORLD] = {"visuals": visuals_of_world}
        extras["links"] = others
        extras["zero"] = without_empty(self.zero)
        return without_empty(extras)

    def add_tree(self, model: Element) -> None:
        """Add links, joints, frames and payloads."""
        base = self.robot.base
        for name, link in self.links.items():
            if name != WORLD:
                self.add_link(model, link)
        if base != WORLD:
            _add_joint(model, f"{base}_to_world", "fixed", WORLD, base)
        for joint in self.robot.joints.values():
            self.add_joint(model, joint)
        for name, frame in shapes.extra_frames(self.robot):
            _add_frame(model, name, frame)
        for link_name in self.links:
            for body, frame in shapes.payload_bodies(self.robot, link_name):
                _add_payload(model, body, frame)

    # -- links

    def add_link(self, model: Element, link: Link) -> None:
        element = SubElement(model, "link", name=link.name)
        joint = self.joint_to.get(link.name)
        if joint is not None:
            pose = _child_pose(joint, self.zero.get(joint.name, 0.0))
            _add_pose(element, pose.rotation, pose.translation, joint.parent)
        if link.gravity_compensation == 1.0:
            add_text(element, "gravity", "false")
        _add_inertial(element, link)
        if self.visuals.add(element, link.name):
            return
        for k, end in enumerate(shapes.attachment_points(self.robot, link.name)):
            if shapes.norm(end) > shapes.SHORTEST_ROD:
                self.add_rod(element, f"{ROD}_{k}", end)

    def add_rod(self, link: Element, name: str, end: Array) -> None:
        length = shapes.norm(end)
        visual = SubElement(link, "visual", name=name)
        _add_pose(visual, rotation_with_z_axis(end / length), 0.5 * end)
        geometry = SubElement(visual, "geometry")
        cylinder = SubElement(geometry, "cylinder")
        add_text(cylinder, "radius", number_text(shapes.ROD_RADIUS * self.size))
        add_text(cylinder, "length", number_text(length))

    # -- joints

    def add_joint(self, model: Element, joint: Joint) -> None:
        zero = self.zero.get(joint.name, 0.0)
        is_limited = any(map(math.isfinite, joint.limits))
        is_continuous = joint.type == "revolute" and not is_limited
        sdf_type = "continuous" if is_continuous else joint.type
        element = _add_joint(model, joint.name, sdf_type, joint.parent, joint.child)
        axis = _add_axis(element, joint.axis)
        limit = SubElement(axis, "limit")
        for tag, bound in zip(("lower", "upper"), joint.limits, strict=True):
            if math.isfinite(bound):
                add_text(limit, tag, number_text(bound - zero))
        bounds = {"effort": joint.effort_limit, "velocity": joint.velocity_limit}
        for tag, bound in bounds.items():
            if math.isfinite(bound):
                add_text(limit, tag, number_text(bound))
        self.add_dynamics(axis, joint.name, zero)
        mimic = self.robot.mimics.get(joint.name)
        if mimic is not None and len(mimic.multipliers) == 1:
            self.add_mimic(axis, mimic, zero)

    def add_dynamics(self, axis: Element, joint: str, zero: float) -> None:
        """Add friction and spring of a joint."""
        effect = effects_of(self.robot, joint)
        if not (effect.viscous or effect.coulomb or effect.stiffness):
            return
        dynamics = SubElement(axis, "dynamics")
        add_text(dynamics, "damping", number_text(effect.viscous))
        add_text(dynamics, "friction", number_text(effect.coulomb))
        if joint in self.robot.angles_in_rows:
            return
        add_text(dynamics, "spring_reference", number_text(effect.rest - zero))
        add_text(dynamics, "spring_stiffness", number_text(effect.stiffness))

    def add_mimic(self, axis: Element, mimic: Mimic, zero: float) -> None:
        ((source, multiplier),) = mimic.multipliers.items()
        offset = mimic.offset + multiplier * self.zero.get(source, 0.0) - zero
        element = SubElement(axis, "mimic", joint=source)
        add_text(element, "multiplier", number_text(multiplier))
        add_text(element, "offset", number_text(offset))
        add_text(element, "reference", number_text(0.0))

    def add_loop(self, model: Element, closure: Closure) -> None:
        """Add a loop joint between two links of the tree, with its frame relative to the child."""
        parent, child = shapes.hinge_frames(self.robot, closure)
        if child.link == WORLD:  # the world cannot be a child
            parent, child = child, parent
        sdf_type = _LOOP_TYPES[closure.kind]
        element = _add_joint(model, closure.name, sdf_type, parent.link, child.link)
        _add_pose(element, child.rotation, child.translation, child.link)
        if sdf_type == "revolute":
            _add_axis(element, _Z_AXIS)


def _drawn_coordinates(robot: Robot) -> dict[str, float]:
    """Coordinates of joints in loops at the closed reference [rad or m].

    They are zero there in SDFormat.
    """
    state = robot.close(robot.reference)
    coordinates = dict(zip(robot.coordinates, state.s.tolist(), strict=True))
    in_loops = _joints_in_loops(robot.description)
    return {name: coordinates[name] for name in robot.description.joints if name in in_loops}


def _joints_in_loops(robot: RobotDescription) -> set[str]:
    """Joints in loops, and joints that follow or lead others."""
    tree = build_tree(robot)
    joints: set[str] = set()
    for follower, mimic in robot.mimics.items():
        joints.update((follower, *mimic.multipliers))
    for closure in robot.closures:
        a = tree.body_index(closure.link_a)
        b = tree.body_index(closure.link_b)
        path_a, path_b, _ = tree.branches(a, b)
        joints.update(tree.bodies[body].joint for body in (*path_a, *path_b))
    return joints


def _check_names(robot: RobotDescription) -> None:
    """Refuse reserved and duplicate names."""
    names_by_kind: dict[str, list[str]] = {
        "link": list(robot.links),
        "joint": list(robot.joints),
        "closure": [closure.name for closure in robot.closures],
        "frame": [name for name, _ in shapes.extra_frames(robot)],
    }
    kinds: dict[str, list[str]] = {}
    for kind, names in names_by_kind.items():
        for name in names:
            kinds.setdefault(name, []).append(kind)
    for name in kinds:
        is_other_world = name == WORLD and name != robot.base
        if is_other_world or (name.startswith("__") and name.endswith("__")):
            raise InputError(
                f"'{name}' is a name that SDFormat keeps for itself; rename it in the robot"
            )
    for name, (kind, *others) in kinds.items():
        if others:
            raise InputError(
                f"'{name}' names two things, a {kind} and a {others[0]}, which SDFormat refuses;"
                " rename one of them in the robot"
            )


def _child_pose(joint: Joint, coordinate: float) -> Transform:
    """The child frame in the parent frame at a value of the coordinate [rad or m]."""
    at_zero = Transform(joint.rotation, joint.translation)
    if joint.type == "revolute":
        return at_zero @ Transform(rotation_about(joint.axis, coordinate))
    return at_zero @ Transform(translation=frozen(coordinate * joint.axis))


def _add_joint(model: Element, name: str, sdf_type: str, parent: str, child: str) -> Element:
    element = SubElement(model, "joint", name=name, type=sdf_type)
    add_text(element, "parent", parent)
    add_text(element, "child", child)
    return element


def _add_axis(joint: Element, direction: Array) -> Element:
    axis = SubElement(joint, "axis")
    add_text(axis, "xyz", numbers_text(direction))
    return axis


def _add_frame(model: Element, name: str, frame: Frame) -> None:
    element = SubElement(model, "frame", name=name)
    if frame.link != WORLD:
        element.set("attached_to", frame.link)
    _add_pose(element, frame.rotation, frame.translation)


def _add_payload(model: Element, body: Link, frame: Frame) -> None:
    element = SubElement(model, "link", name=body.name)
    _add_pose(element, frame.rotation, frame.translation, frame.link)
    _add_inertial(element, body)
    _add_joint(model, f"{body.name}_fixed", "fixed", frame.link, body.name)


def _possible(inertia: Array) -> Array:
    """The tensor, or the nearest one that SDFormat allows."""
    if impossibility(inertia, _ROUNDING):
        return nearest_possible(inertia)
    return inertia


def _add_inertial(element: Element, link: Link) -> None:
    mass = link.mass
    J = _possible(link.inertia)
    if not mass:
        mass = _SMALLEST_INERTIA
        if not J.any():
            J = _SMALLEST_INERTIA * np.eye(3)
    inertial = SubElement(element, "inertial")
    _add_pose(inertial, np.eye(3), link.com)
    add_text(inertial, "mass", number_text(mass))
    inertia = SubElement(inertial, "inertia")
    add_text(inertia, "ixx", number_text(J[0, 0]))
    add_text(inertia, "ixy", number_text(J[0, 1]))
    add_text(inertia, "ixz", number_text(J[0, 2]))
    add_text(inertia, "iyy", number_text(J[1, 1]))
    add_text(inertia, "iyz", number_text(J[1, 2]))
    add_text(inertia, "izz", number_text(J[2, 2]))


def _add_pose(
    element: Element, rotation: Array, translation: Array, relative_to: str = WORLD
) -> None:
    """Add a pose, with `relative_to` only where it differs from the element's default."""
    pose = add_text(
        element, "pose", f"{numbers_text(translation)} {numbers_text(rpy_of(rotation))}"
    )
    if relative_to != WORLD:
        pose.set("relative_to", relative_to)
