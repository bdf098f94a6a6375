"""A robot as MJCF for MuJoCo: its tree, its closures as equality constraints, a motor on each active joint.

MuJoCo holds loops by stiff springs, so it agrees with this library as far as these are stiff. The
keyframe `reference` is the closed reference configuration, with the motors' efforts that hold it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from ...algebra.rotations import canonical, quaternion
from ...description.model import Closure, Joint, RobotDescription, effects_of
from ...ground.arrays import Array
from .. import shapes
from ..extras_reader import TAG
from ..extras_writer import as_text, comment, in_words, link_entry, rest_of
from ..shapes import number, numbers
from .reader import NOTHING

if TYPE_CHECKING:
    from ...robot.robot import Robot

STEP = 5e-4  # [s] of MuJoCo's integrator
STIFF = {
    "solref": "0.001 1",
    "solimp": "0.9999 0.9999 0.001 0.5 2",
}  # the stiffest that MuJoCo takes at this step
CARRIED = frozenset(
    {"gravity", "friction", "mimic"}
)  # what MJCF says of all that a format may not say
ARM = 0.5  # between the two points that tie an axis, over the size of the robot


def to_mjcf(robot: Robot) -> str:
    """MJCF text of a robot: the same names of links and joints.

    Weight, masses, friction, drives and springs are taken over; Coulomb friction is MuJoCo's, which
    needs no smoothing. Hydraulic pressures are not: motors give forces.
    """
    return _Writer(robot).text()


class _Writer:
    def __init__(self, robot: Robot) -> None:
        self.robot, self.description = robot, robot.description
        self.children: dict[str, list[Joint]] = {}
        for joint in self.description.joints.values():
            self.children.setdefault(joint.parent, []).append(joint)
        points = [
            mark
            for link in (self.description.base, *self.description.links)
            for mark in self.marks(link)
        ]
        self.size = max((float(np.linalg.norm(point)) for point in points), default=1.0)

    def text(self) -> str:
        root = Element("mujoco", model=self.robot.name)
        SubElement(
            root,
            "compiler",
            angle="radian",
            boundmass=number(NOTHING),
            boundinertia=number(NOTHING),
        )
        option = SubElement(
            root,
            "option",
            timestep=number(STEP),
            gravity=numbers(self.description.gravity),
            integrator="implicitfast",
        )
        SubElement(option, "flag", contact="disable")
        world = SubElement(root, "worldbody")
        self.fill(world, self.description.base)
        equality = SubElement(root, "equality")
        for closure in self.description.closures:
            _tie(equality, closure)
        for follower, mimic in self.description.mimics.items():
            polynomial = f"{number(mimic.offset)} {number(mimic.multiplier)} 0 0 0"
            SubElement(
                equality,
                "joint",
                {"joint1": follower, "joint2": mimic.source, "polycoef": polynomial, **STIFF},
            )
        actuator = SubElement(root, "actuator")
        for name in self.robot.active:
            SubElement(actuator, "motor", name=name, joint=name)
        self.keyframe(root, world)
        self.rest(root)
        indent(root)
        return tostring(root, encoding="unicode") + "\n"

    def rest(self, root: Element) -> None:
        """What MJCF has no words for, where MuJoCo keeps texts of users."""
        description = self.description
        rest: dict[str, Any] = {"base": description.base, **rest_of(description, CARRIED)}
        if description.base in description.links:
            rest["links"] = {description.base: link_entry(description.links[description.base])}
        for closure in description.closures:
            if closure.kind == "axis":
                rest["closures"][closure.name]["second"] = f"{closure.name}_axis"
        told = (
            f"The text {TAG} holds what MJCF has no words for: {in_words(rest)}. MuJoCo passes it"
            " over."
        )
        comment(root, told)
        SubElement(SubElement(root, "custom"), "text", name=TAG, data=as_text(rest, one_line=True))

    def marks(self, link: str) -> Iterator[Array]:
        return shapes.marks(self.description, link)

    def fill(self, body: Element, link: str) -> None:
        """Shapes, sites, payloads and the bodies that hang on a link."""
        self.rods(body, link)
        for closure in self.description.closures:
            for name, where, rotation in _ends(closure, link, ARM * self.size):
                SubElement(body, "site", name=name, pos=numbers(where), quat=_quaternion(rotation))
        for name, frame in shapes.frames(self.description):
            if frame.link == link:
                SubElement(
                    body,
                    "site",
                    name=name,
                    pos=numbers(frame.translation),
                    quat=_quaternion(frame.rotation),
                )
        for name, frame, payload in shapes.payloads(self.description, link):
            place = {"pos": numbers(frame.translation), "quat": _quaternion(frame.rotation)}
            load = SubElement(body, "body", {"name": name, **place})
            _inertial(load, payload.mass, np.asarray(payload.com), np.asarray(payload.inertia))
        for joint in self.children.get(link, []):
            self.fill(self.body(body, joint), joint.child)

    def rods(self, body: Element, link: str) -> None:
        radius = number(shapes.THICKNESS * self.size)
        for mark in self.marks(link):
            if float(np.linalg.norm(mark)) > shapes.SMALLEST:
                line = numbers(np.concatenate([np.zeros(3), mark]))
                seen = {"type": "capsule", "fromto": line, "size": radius, "mass": "0"}
                SubElement(body, "geom", {**seen, "contype": "0", "conaffinity": "0"})

    def body(self, parent: Element, joint: Joint) -> Element:
        link = self.description.links[joint.child]
        quaternion = _quaternion(joint.rotation)
        element = SubElement(
            parent, "body", name=link.name, pos=numbers(joint.translation), quat=quaternion
        )
        _inertial(element, link.mass, link.com, link.inertia)
        kind = "hinge" if joint.type == "revolute" else "slide"
        told = {
            "name": joint.name,
            "type": kind,
            "axis": numbers(joint.axis),
            **_effects(self.description, joint.name),
        }
        lower, upper = joint.limits
        if math.isfinite(lower) and math.isfinite(upper):
            told |= {"limited": "true", "range": f"{number(lower)} {number(upper)}"}
        SubElement(element, "joint", told)
        return element

    def keyframe(self, root: Element, world: Element) -> None:
        """The closed reference, coordinates in MuJoCo's order, and the efforts that hold it."""
        state = self.robot.close(self.robot.reference)
        values = dict(zip(self.robot.coordinates, state.s.tolist(), strict=True))
        order = [joint.get("name", "") for joint in world.iter("joint")]
        held = self.robot.inverse_dynamics(state, np.zeros(len(self.robot.active)))
        frame = SubElement(root, "keyframe")
        qpos = " ".join(number(values[name]) for name in order)
        SubElement(frame, "key", name="reference", qpos=qpos, ctrl=numbers(held))


def _inertial(element: Element, mass: float, com: Array, J: Array) -> None:
    if mass == 0.0 and not J.any():
        mass, J = NOTHING, NOTHING * np.eye(3)
    moments = numbers(np.array([J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]))
    SubElement(
        element, "inertial", pos=numbers(com), mass=number(max(mass, NOTHING)), fullinertia=moments
    )


def _effects(robot: RobotDescription, joint: str) -> dict[str, str]:
    effect = effects_of(robot, joint)
    told = {"armature": effect.armature, "damping": effect.viscous, "frictionloss": effect.coulomb}
    if effect.stiffness:
        told |= {
            "stiffness": effect.stiffness,
            "springref": effect.rest - effect.preload / effect.stiffness,
        }
    return {name: number(value) for name, value in told.items() if value or name == "springref"}


def _ends(closure: Closure, link: str, arm: float) -> Iterator[tuple[str, Array, Array]]:
    """Sites of a closure on a link: at its point, and for a tied axis another one along it."""
    for end, body, point, rotation in (
        ("a", closure.link_a, closure.point_a, closure.rotation_a),
        ("b", closure.link_b, closure.point_b, closure.rotation_b),
    ):
        if body == link:
            yield f"{closure.name}_{end}", point, rotation
            if closure.kind == "axis":
                yield f"{closure.name}_{end}_axis", point + arm * rotation[:, 2], rotation


def _tie(equality: Element, closure: Closure) -> None:
    kind = "weld" if closure.kind == "frame" else "connect"
    for suffix in ("", "_axis") if closure.kind == "axis" else ("",):
        sites = {"site1": f"{closure.name}_a{suffix}", "site2": f"{closure.name}_b{suffix}"}
        SubElement(equality, kind, {"name": f"{closure.name}{suffix}", **sites, **STIFF})


def _quaternion(rotation: Array) -> str:
    """w, x, y, z, as MuJoCo has it."""
    x, y, z, w = canonical(quaternion(rotation))
    return numbers(np.array([w, x, y, z]))
