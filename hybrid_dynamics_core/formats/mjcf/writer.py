"""Writer of MJCF: tree, equality constraints for closures, motors of active joints.

MuJoCo closes loops by stiff soft constraints, so it agrees with this library only approximately.
The keyframe `reference` is the closed reference configuration, with the motor efforts of its
statics.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...algebra.rotations import canonical, quaternion
from ...description.document import Data
from ...description.model import Closure, Frame, Joint, Link, Mimic, RobotDescription, effects_of
from ...description.rigid_body import nearest_possible
from ...ground.arrays import Array
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
from ..visual_elements import ROD
from ..xml.writer import insert_comment, number_text, numbers_text, xml_text
from .masses import NEGLIGIBLE
from .visual_writer import INVISIBLE_TO_CONTACTS, VisualWriter

_TIME_STEP = 5e-4  # [s] of MuJoCo's integrator
# The stiffest constraints that MuJoCo allows at this step:
_STIFF = {"solref": "0.001 1", "solimp": "0.9999 0.9999 0.001 0.5 2"}
_FEATURES = frozenset(
    {
        Feature.GRAVITY,
        Feature.WEIGHT_SHARES,
        Feature.FRICTION,
        Feature.MIMIC,
        Feature.MIMIC_OF_SEVERAL,
        Feature.EFFORT_LIMITS,
    }
)
# Rows and columns of xx, yy, zz, xy, xz, yz, MuJoCo's order:
_MOMENT_ROWS = (0, 1, 2, 0, 0, 1)
_MOMENT_COLUMNS = (0, 1, 2, 1, 2, 2)
_AXIS_ARM = 0.5  # distance of the two points that tie an axis, over the size of the robot
_ROUNDING = 1e-15  # relative, of moments


def to_mjcf(robot: AnyRobot, folder: str | Path | None = None) -> str:
    """MJCF text of a robot, with the same names of links and joints.

    Weight, masses, friction, drives and springs are the same. Coulomb friction is MuJoCo's, without
    smoothing. Hydraulic cylinders become motors with forces, without pressures.

    Args:
        robot: the robot to write, or its description.
        folder: folder of the file. Meshes in it get relative paths, others absolute ones.

    Raises:
        InputError: `robot` is neither.
    """
    return _MjcfWriter(robot_of(robot), None if folder is None else Path(folder)).text()


class _MjcfWriter:
    def __init__(self, robot: Robot, folder: Path | None) -> None:
        self.robot = robot
        self.description = robot.description
        self.visuals = VisualWriter(robot.description, folder)
        self.size = shapes.robot_size(robot.description)
        self.joints_on: dict[str, list[Joint]] = {}
        for joint in self.description.joints.values():
            self.joints_on.setdefault(joint.parent, []).append(joint)

    def text(self) -> str:
        root = Element("mujoco", model=self.robot.name)
        self.add_settings(root)
        self.visuals.add_meshes(root)
        world = SubElement(root, "worldbody")
        self.fill(world, self.description.base)
        self.add_equalities(root)
        actuator = SubElement(root, "actuator")
        for name in self.description.motors:
            SubElement(actuator, "motor", name=name, joint=name)
        self.add_keyframe(root, world)
        self.add_extras(root)
        return xml_text(root, declaration=False)

    def add_settings(self, root: Element) -> None:
        bound = number_text(NEGLIGIBLE)
        SubElement(root, "compiler", angle="radian", boundmass=bound, boundinertia=bound)
        option = SubElement(
            root,
            "option",
            timestep=number_text(_TIME_STEP),
            gravity=numbers_text(self.description.gravity),
            integrator="implicitfast",
        )
        SubElement(option, "flag", contact="disable")

    def add_extras(self, root: Element) -> None:
        """Add data that MJCF cannot express, as a text in <custom>."""
        robot = self.description
        extras: Data = {"base": robot.base, **extras_of(robot, _FEATURES)}
        extras.setdefault("links", {})
        for name, link in robot.links.items():
            if name == robot.base or _cannot_be_said(link):
                extras["links"][name] = link_entry(link)
        for name, entries in self.visuals.aside().items():
            link = robot.links.get(name, Link(name))
            extras["links"][name] = {**link_entry(link), "visuals": entries}
        extras = without_empty(extras)
        for closure in robot.closures:
            if closure.kind == "axis":
                extras["closures"][closure.name]["second"] = f"{closure.name}_axis"
        insert_comment(
            root,
            f"The text {TAG} holds what MJCF has no words for: {extras_summary(extras)}. MuJoCo"
            " passes it over.",
        )
        custom = SubElement(root, "custom")
        text = extras_text(extras, one_line=True)
        SubElement(custom, "text", name=TAG, data=text)

    # -- bodies

    def fill(self, body: Element, link: str) -> None:
        """Add shapes, sites, payloads and child bodies of a link."""
        if not self.visuals.add(body, link):
            self.add_rods(body, link)
        for closure in self.description.closures:
            self.add_closure_sites(body, link, closure)
        for name, frame in shapes.extra_frames(self.description):
            if frame.link == link:
                _add_placed(body, "site", name, frame)
        for payload, frame in shapes.payload_bodies(self.description, link):
            element = _add_placed(body, "body", payload.name, frame)
            _add_inertial(element, payload)
        for joint in self.joints_on.get(link, []):
            child = self.add_body(body, joint)
            self.fill(child, joint.child)

    def add_rods(self, body: Element, link: str) -> None:
        radius = number_text(shapes.ROD_RADIUS * self.size)
        for end in shapes.rods(shapes.attachment_points(self.description, link)):
            ends = numbers_text([0.0, 0.0, 0.0, *end])
            shape = {"type": "capsule", "fromto": ends, "size": radius, "mass": "0"}
            shape["name"] = f"{ROD}_{next(self.visuals.numbers)}"
            SubElement(body, "geom", {**shape, **INVISIBLE_TO_CONTACTS})

    def add_closure_sites(self, body: Element, link: str, closure: Closure) -> None:
        """Add sites at the ends of a closure on a link and, for an axis, a second site along it."""
        for letter, frame in zip("ab", closure.frames(), strict=True):
            if frame.link != link:
                continue
            name = f"{closure.name}_{letter}"
            _add_placed(body, "site", name, frame)
            if closure.kind == "axis":
                arm = _AXIS_ARM * self.size * frame.rotation[:, 2]
                shifted = replace(frame, translation=frame.translation + arm)
                _add_placed(body, "site", f"{name}_axis", shifted)

    def add_body(self, parent: Element, joint: Joint) -> Element:
        link = self.description.links[joint.child]
        frame = Frame(joint.parent, joint.rotation, joint.translation)
        element = _add_placed(parent, "body", link.name, frame)
        share = link.gravity_compensation
        if share:
            element.set("gravcomp", number_text(share))
        _add_inertial(element, link)
        attributes = {
            "name": joint.name,
            "type": "hinge" if joint.type == "revolute" else "slide",
            "axis": numbers_text(joint.axis),
            **_effect_attributes(self.description, joint.name),
        }
        if all(map(math.isfinite, joint.limits)):
            attributes["limited"] = "true"
            attributes["range"] = numbers_text(joint.limits)
        if math.isfinite(joint.effort_limit):
            effort_range = (-joint.effort_limit, joint.effort_limit)
            attributes["actuatorfrclimited"] = "true"
            attributes["actuatorfrcrange"] = numbers_text(effort_range)
        SubElement(element, "joint", attributes)
        return element

    # -- constraints and reference

    def add_equalities(self, root: Element) -> None:
        equality = SubElement(root, "equality")
        for closure in self.description.closures:
            _add_tie(equality, closure, "")
            if closure.kind == "axis":
                _add_tie(equality, closure, "_axis")
        for follower, mimic in self.description.mimics.items():
            if len(mimic.multipliers) == 1:
                _add_follower(equality, follower, mimic)
            else:
                self.add_tendon(root, equality, follower, mimic)

    def add_tendon(self, root: Element, equality: Element, follower: str, mimic: Mimic) -> None:
        """Add a follower of several joints, as an equality of a fixed tendon."""
        tendons = root.find("tendon")
        if tendons is None:
            tendons = SubElement(root, "tendon")
        name = f"{follower}_coupling"
        tendon = SubElement(tendons, "fixed", name=name)
        SubElement(tendon, "joint", joint=follower, coef="1")
        for source, multiplier in mimic.multipliers.items():
            SubElement(tendon, "joint", joint=source, coef=number_text(-multiplier))
        polynomial = f"{number_text(mimic.offset)} 0 0 0 0"
        SubElement(equality, "tendon", {"tendon1": name, "polycoef": polynomial, **_STIFF})

    def add_keyframe(self, root: Element, world: Element) -> None:
        """Add the closed reference as a keyframe, with the efforts of its statics."""
        state = self.robot.close(self.robot.reference)
        coordinates = dict(zip(self.robot.coordinates, state.s.tolist(), strict=True))
        order = [joint.get("name", "") for joint in world.iter("joint")]
        no_acceleration = np.zeros(len(self.robot.active))
        efforts = self.robot.inverse_dynamics(state, no_acceleration)
        motors = len(self.description.motors)  # idle coordinates come after them
        keyframe = SubElement(root, "keyframe")
        qpos = numbers_text(coordinates[name] for name in order)
        ctrl = numbers_text(efforts[:motors])
        SubElement(keyframe, "key", name="reference", qpos=qpos, ctrl=ctrl)


def _add_follower(equality: Element, follower: str, mimic: Mimic) -> None:
    """Add a follower of one joint."""
    ((source, multiplier),) = mimic.multipliers.items()
    polynomial = f"{number_text(mimic.offset)} {number_text(multiplier)} 0 0 0"
    joints = {"joint1": follower, "joint2": source}
    SubElement(equality, "joint", {**joints, "polycoef": polynomial, **_STIFF})


def _add_placed(parent: Element, tag: str, name: str, frame: Frame) -> Element:
    """Add an element with a name at a frame on its parent."""
    element = SubElement(parent, tag, name=name)
    element.set("pos", numbers_text(frame.translation))
    element.set("quat", _quaternion(frame.rotation))
    return element


def _cannot_be_said(link: Link) -> bool:
    """Whether MuJoCo would refuse a link, or change its inertia."""
    if not link.mass and link.inertia.any():
        return True
    return _possible(link.inertia) is not link.inertia


def _possible(inertia: Array) -> Array:
    """The tensor, or the nearest one within MuJoCo's strict tolerance."""
    moments = np.linalg.eigvalsh(inertia)
    least = max(moments[0], NEGLIGIBLE)
    if moments[0] >= -_ROUNDING and least + moments[1] >= moments[2] * (1.0 + _ROUNDING):
        return inertia
    return nearest_possible(inertia)


def _add_inertial(body: Element, link: Link) -> None:
    inertia = _possible(link.inertia)
    if link.mass == 0.0 and not inertia.any():
        inertia = NEGLIGIBLE * np.eye(3)
    element = SubElement(body, "inertial", pos=numbers_text(link.com))
    element.set("mass", number_text(max(link.mass, NEGLIGIBLE)))
    element.set("fullinertia", numbers_text(inertia[_MOMENT_ROWS, _MOMENT_COLUMNS]))


def _effect_attributes(robot: RobotDescription, joint: str) -> dict[str, str]:
    """Armature, friction and spring of a joint; a preload shifts the spring's rest position."""
    effect = effects_of(robot, joint)
    attributes: dict[str, str] = {}
    if effect.armature:
        attributes["armature"] = number_text(effect.armature)
    if effect.viscous:
        attributes["damping"] = number_text(effect.viscous)
    if effect.coulomb:
        attributes["frictionloss"] = number_text(effect.coulomb)
    if effect.stiffness and joint not in robot.angles_in_rows:
        rest = effect.rest - effect.preload / effect.stiffness
        attributes["stiffness"] = number_text(effect.stiffness)
        attributes["springref"] = number_text(rest)
    return attributes


def _add_tie(equality: Element, closure: Closure, suffix: str) -> None:
    """Add a constraint between two sites of a closure."""
    tag = "weld" if closure.kind == "frame" else "connect"
    attributes = {
        "name": f"{closure.name}{suffix}",
        "site1": f"{closure.name}_a{suffix}",
        "site2": f"{closure.name}_b{suffix}",
    }
    SubElement(equality, tag, {**attributes, **_STIFF})


def _quaternion(rotation: Array) -> str:
    """A quaternion w, x, y, z as text."""
    x, y, z, w = canonical(quaternion(rotation))
    return numbers_text([w, x, y, z])
