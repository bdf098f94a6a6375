"""A robot as SDFormat 1.11, which Gazebo Harmonic reads: a world with its gravity and one model, loops as joints.

SDFormat draws a model in one configuration and counts coordinates from there, and a loop joint is
at rest there. So the model is drawn at the closed reference: coordinates that are in loops count
from it, all others as the robot does.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...description.geometry import Transform, rotation_about, rotation_with_z_axis, rpy_of
from ...description.model import Closure, Frame, Joint, Link, RobotDescription, effects_of
from ...errors import InputError
from ...ground.arrays import Array, frozen
from ...mechanism.tree import build_tree
from .. import shapes
from ..extras_reader import TAG
from ..extras_writer import as_text, comment, in_words, link_entry, rest_of
from ..shapes import number, numbers
from ..urdf.writer import as_xml

if TYPE_CHECKING:
    from ...robot.robot import Robot

VERSION = "1.11"
SPACE = f"urn:{TAG}"  # SDFormat wants elements of others in a name space of their own
NOTHING = 1e-9  # [kg, kg m^2] a link needs some mass
TYPES = {"planar": "revolute", "axis": "revolute", "point": "ball", "frame": "fixed"}
CARRIED = frozenset({"gravity", "friction", "spring", "mimic", "one-sided", "unlimited"})
WORLD = "world"


def to_sdf(robot: Robot) -> str:
    """SDFormat text of a robot: the same names of links and joints, loops as joints between links that hang already.

    Raises InputError where a name is one that SDFormat keeps for itself.
    """
    return _Writer(robot).text()


class _Writer:
    def __init__(self, robot: Robot) -> None:
        self.description = robot.description
        state = robot.close(robot.reference)
        self.values = dict(zip(robot.coordinates, state.s.tolist(), strict=True))
        looped = _in_loops(self.description)
        self.zero = {name: self.values[name] for name in self.description.joints if name in looped}
        marks = [mark for link in self.links() for mark in shapes.marks(self.description, link)]
        self.size = max((float(np.linalg.norm(mark)) for mark in marks), default=1.0)

    def links(self) -> dict[str, Link]:
        return {self.description.base: Link(self.description.base), **self.description.links}

    def text(self) -> str:
        _check_names(self.description)
        root = Element("sdf", {"version": VERSION, f"xmlns:{TAG}": SPACE})
        world = SubElement(root, "world", name=f"{self.description.name}_world")
        _tell(world, "gravity", numbers(self.description.gravity))
        model = SubElement(world, "model", name=self.description.name)
        self.tree(model)
        for closure in self.description.closures:
            self.loop(model, closure)
        rest = self.rest()
        told = (
            f"<{TAG}:{TAG}> holds what SDFormat has no words for: {in_words(rest)}. Other programs"
            " pass it over."
        )
        comment(model, told)
        SubElement(model, f"{TAG}:{TAG}").text = f"\n{as_text(rest)}\n"
        return as_xml(root)

    def rest(self) -> dict[str, Any]:
        rest = rest_of(self.description, CARRIED)
        light = {
            name: link_entry(link)
            for name, link in self.links().items()
            if not link.mass and name != WORLD
        }
        rest["links"] = light
        rest["zero"] = {name: value for name, value in self.zero.items() if value}
        return {key: value for key, value in rest.items() if value}

    def tree(self, model: Element) -> None:
        base = self.description.base
        above = {joint.child: joint for joint in self.description.joints.values()}
        for name, link in self.links().items():
            if name != WORLD:
                self.link(model, link, above.get(name))
        if base != WORLD:
            _joint(model, f"{base}_to_world", "fixed", WORLD, base)
        for joint in self.description.joints.values():
            self.joint(model, joint)
        for name, frame in shapes.frames(self.description):
            attached = {"attached_to": frame.link} if frame.link != WORLD else {}
            _pose(
                SubElement(model, "frame", {"name": name, **attached}),
                frame.rotation,
                frame.translation,
            )
        for name in self.links():
            self.payloads(model, name)

    def link(self, model: Element, link: Link, joint: Joint | None) -> None:
        element = SubElement(model, "link", name=link.name)
        if joint is not None:
            pose = _placed(joint, self.zero.get(joint.name, 0.0))
            around = "" if joint.parent == WORLD else joint.parent
            _pose(element, pose.rotation, pose.translation, around)
        _inertial(element, link)
        for k, mark in enumerate(shapes.marks(self.description, link.name)):
            length = float(np.linalg.norm(mark))
            if length > shapes.SMALLEST:
                visual = SubElement(element, "visual", name=f"{link.name}_rod_{k}")
                _pose(visual, rotation_with_z_axis(mark / length), 0.5 * mark)
                cylinder = SubElement(SubElement(visual, "geometry"), "cylinder")
                _tell(cylinder, "radius", number(shapes.THICKNESS * self.size))
                _tell(cylinder, "length", number(length))

    def joint(self, model: Element, joint: Joint) -> None:
        zero = self.zero.get(joint.name, 0.0)
        lower, upper = (limit - zero for limit in joint.limits)
        endless = joint.type == "revolute" and not (math.isfinite(lower) or math.isfinite(upper))
        element = _joint(
            model, joint.name, "continuous" if endless else joint.type, joint.parent, joint.child
        )
        axis = _axis(element, joint.axis)
        limit = SubElement(axis, "limit")
        for key, value in (("lower", lower), ("upper", upper)):
            if math.isfinite(value):
                _tell(limit, key, number(value))
        self.effects(axis, joint.name, zero)
        mimic = self.description.mimics.get(joint.name)
        if mimic is not None:
            follows = SubElement(axis, "mimic", joint=mimic.source)
            shifted = mimic.offset + mimic.multiplier * self.zero.get(mimic.source, 0.0) - zero
            for key, value in (
                ("multiplier", mimic.multiplier),
                ("offset", shifted),
                ("reference", 0.0),
            ):
                _tell(follows, key, number(value))

    def effects(self, axis: Element, joint: str, zero: float) -> None:
        effect = effects_of(self.description, joint)
        if not (effect.viscous or effect.coulomb or effect.stiffness):
            return
        dynamics = SubElement(axis, "dynamics")
        _tell(dynamics, "damping", number(effect.viscous))
        _tell(dynamics, "friction", number(effect.coulomb))
        _tell(dynamics, "spring_reference", number(effect.rest - zero))
        _tell(dynamics, "spring_stiffness", number(effect.stiffness))

    def payloads(self, model: Element, link: str) -> None:
        for name, frame, payload in shapes.payloads(self.description, link):
            body = Link(name, payload.mass, frozen(payload.com), frozen(payload.inertia))
            element = SubElement(model, "link", name=name)
            _pose(element, frame.rotation, frame.translation, "" if link == WORLD else link)
            _inertial(element, body)
            _joint(model, f"{name}_fixed", "fixed", link, name)

    def loop(self, model: Element, closure: Closure) -> None:
        """A joint between two links that hang already, its frame given on the child."""
        on_a, on_b = shapes.hinge(self.description, closure)
        ends = [(closure.link_a, Frame(closure.link_a, on_a, closure.point_a))]
        ends.append((closure.link_b, Frame(closure.link_b, on_b, closure.point_b)))
        if closure.link_b == WORLD:  # which cannot be a child
            ends.reverse()
        (parent, _), (child, frame) = ends
        element = _joint(model, closure.name, TYPES[closure.kind], parent, child)
        _pose(element, frame.rotation, frame.translation, child)
        if TYPES[closure.kind] == "revolute":
            _axis(element, np.array([0.0, 0.0, 1.0]))


def _in_loops(robot: RobotDescription) -> set[str]:
    """Joints of loops, and those that follow or lead others."""
    tree = build_tree(robot)
    found = set(robot.mimics) | {mimic.source for mimic in robot.mimics.values()}
    for closure in robot.closures:
        one, other, _ = tree.branches(
            tree.body_index(closure.link_a), tree.body_index(closure.link_b)
        )
        found |= {tree.bodies[k].joint for k in (*one, *other)}
    return found


def _check_names(robot: RobotDescription) -> None:
    kinds: dict[str, list[str]] = {}
    for kind, names in (
        ("link", robot.links),
        ("joint", robot.joints),
        ("closure", [closure.name for closure in robot.closures]),
        ("frame", [name for name, _ in shapes.frames(robot)]),
    ):
        for name in names:
            kinds.setdefault(name, []).append(kind)
    for name in kinds:
        if (name == WORLD and name != robot.base) or (
            name.startswith("__") and name.endswith("__")
        ):
            raise InputError(
                f"'{name}' is a name that SDFormat keeps for itself; rename it in the robot"
            )
    for name, (kind, *others) in kinds.items():
        if others:
            told = f"'{name}' names two things, a {kind} and a {others[0]}, which SDFormat refuses"
            raise InputError(f"{told}; rename one of them in the robot")


def _placed(joint: Joint, value: float) -> Transform:
    """The child frame in the parent frame at a value of the coordinate."""
    place = Transform(joint.rotation, joint.translation)
    if joint.type == "revolute":
        return place @ Transform(rotation_about(joint.axis, value), frozen(np.zeros(3)))
    return place @ Transform(frozen(np.eye(3)), frozen(value * joint.axis))


def _joint(model: Element, name: str, kind: str, parent: str, child: str) -> Element:
    element = SubElement(model, "joint", name=name, type=kind)
    _tell(element, "parent", parent)
    _tell(element, "child", child)
    return element


def _axis(joint: Element, direction: Array) -> Element:
    axis = SubElement(joint, "axis")
    _tell(axis, "xyz", numbers(direction))
    return axis


def _inertial(element: Element, link: Link) -> None:
    mass, J = (link.mass, link.inertia) if link.mass else (NOTHING, NOTHING * np.eye(3))
    inertial = SubElement(element, "inertial")
    _pose(inertial, np.eye(3), link.com)
    _tell(inertial, "mass", number(mass))
    inertia = SubElement(inertial, "inertia")
    for key, value in (
        ("ixx", J[0, 0]),
        ("ixy", J[0, 1]),
        ("ixz", J[0, 2]),
        ("iyy", J[1, 1]),
        ("iyz", J[1, 2]),
        ("izz", J[2, 2]),
    ):
        _tell(inertia, key, number(value))


def _pose(element: Element, rotation: Array, translation: Array, relative_to: str = "") -> None:
    told = {"relative_to": relative_to} if relative_to else {}
    SubElement(element, "pose", told).text = f"{numbers(translation)} {numbers(rpy_of(rotation))}"


def _tell(element: Element, tag: str, text: str) -> None:
    SubElement(element, tag).text = text
