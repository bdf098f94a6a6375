"""Joints of SDFormat: their links, axis, limits, friction, spring, and the joint they follow."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from ...description.document import Data
from ...description.geometry import Transform, rotation_about, unit_axis
from ...ground.arrays import Array, frozen
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .poses import WORLD, ModelPoses

_UNLIMITED = 1e16  # [rad or m] SDFormat's value for no limit
_INFINITY = ("inf", "infinity")
_DRIVE_LIMITS = {"effort": "effort_limit", "velocity": "velocity_limit"}
_Z_AXIS = (0.0, 0.0, 1.0)
_SINGLE = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}
_UNIVERSAL = ("universal", "revolute2")
_EXPECTED = "fixed, revolute, continuous, prismatic, screw, universal, revolute2 or ball"
_BALL_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_ONE_TURN = 2.0 * math.pi  # [rad]
_ROTORS = {"drake:rotor_inertia": "rotor_inertia", "drake:gear_ratio": "gear_ratio"}
CLOSURE_KINDS = {
    "revolute": "axis",
    "continuous": "axis",
    "ball": "point",
    "fixed": "frame",
}
LIMITS = ("limits", "effort_limit", "velocity_limit")


@dataclass(frozen=True, eq=False)
class Freedom:
    """One hinge or slide of a joint.

    Attributes:
        name: its name.
        type: revolute or prismatic.
        axis: (3,) unit vector in the frame of the joint.
        constraints: limits, friction, spring and mimic.
    """

    name: str
    type: str
    axis: Array
    constraints: Data = field(default_factory=dict)

    def is_held(self) -> bool:
        """Whether its limits fix it at zero."""
        return bool(self.constraints.get("limits") == [0.0, 0.0])

    def reversed(self) -> Freedom:
        """The same coordinate with parent and child exchanged: about the opposite axis."""
        return replace(self, axis=frozen(-self.axis))


class JointReader:
    """Reads one <joint>.

    Attributes:
        element: the joint.
        name: its name.
        type: type of the joint, in SDFormat.
        path: path of its entry.
    """

    def __init__(self, xml: XmlReader, poses: ModelPoses, element: LocatedElement) -> None:
        self.xml = xml
        self.poses = poses
        self.element = element
        self.name = xml.name(element, "joints")
        self.type = element.get("type")
        self.path = ("joints", self.name)

    def is_grounded(self) -> bool:
        """Whether parent or child is the world."""
        return WORLD in (self.parent(), self.child())

    def parent(self) -> str:
        """The parent link, or the world."""
        return self.poses.link_of(self._end("parent"), self.element)

    def child(self) -> str:
        """The child link, or the world."""
        return self.poses.link_of(self._end("child"), self.element)

    def closure_kind(self) -> str:
        """The closure that can replace the joint; empty if it has friction or a spring."""
        if any(key not in LIMITS for key in self.constraints()):
            return ""
        if self.is_held():
            return "" if self._held() else "frame"
        return CLOSURE_KINDS.get(self.type, "")

    def has_limits(self) -> bool:
        """Whether the joint has limits of coordinate, effort or rate."""
        return self.type != "fixed" and not self.is_held() and bool(self.constraints())

    def is_held(self) -> bool:
        """Whether its limits fix the joint, and it follows no other."""
        if self.type not in _SINGLE:
            return False
        constraints = self.constraints()
        lower, upper = constraints.get("limits", (-1.0, 1.0))
        return lower == upper and "mimic" not in constraints

    def held_at(self) -> Transform:
        """The displacement of a fixed joint, in the joint frame."""
        place = self._held()
        if _SINGLE.get(self.type) == "revolute":
            return Transform(rotation_about(self.axis(), place))
        if place:
            return Transform(translation=frozen(place * self.axis()))
        return Transform()

    def _held(self) -> float:
        """The coordinate [rad or m] of a joint fixed by its limits; zero for type fixed."""
        if not self.is_held():
            return 0.0
        lower, _ = self.constraints()["limits"]
        return float(lower)

    def freedoms(self) -> list[Freedom]:
        """The hinges and slides of the joint in order; empty if it is fixed.

        Raises:
            DescriptionError: its type is not supported.
        """
        if self.is_held():
            self.xml.note(self.element, f"joint {self.name} is held by its limits; taken as fixed")
        if self.type == "fixed" or self.is_held():
            return []
        if self.type in _SINGLE:
            return [Freedom(self.name, _SINGLE[self.type], self.axis(), self.constraints())]
        if self.type in _UNIVERSAL:
            return self._universal()
        if self.type == "ball":
            return self._ball()
        if self.type == "screw":
            return self._screw()
        problem = f"is '{self.type}'; expected {_EXPECTED}"
        raise self.xml.error(self.element, (*self.path, "type"), problem)

    def note_unused(self) -> None:
        """Add notes on elements that a joint of this type does not use."""
        unused: list[str] = []
        if self.type not in _UNIVERSAL:
            unused.append("axis2")
        if self.type in ("fixed", "ball"):
            unused.append("axis")
        unused.extend(("gearbox_ratio", "gearbox_reference_body"))
        if self.type != "screw":
            unused.extend(("thread_pitch", "screw_thread_pitch"))
        if self.type == "continuous":
            self._note_limits()
        for child in self.element.children:
            if child.tag in unused:
                text = f"<{child.tag}> of joint {self.name} is left out: it is of type {self.type}"
                self.xml.note(child, text)

    def _note_limits(self) -> None:
        """Add a note if a continuous joint has limits, which are ignored."""
        limit = self._inside_axis("limit", "axis")
        if limit is None:
            return
        for tag, unlimited in (("lower", -math.inf), ("upper", math.inf)):
            bound = limit.first(tag)
            if bound is not None and self._bound(bound, unlimited) != unlimited:
                text = f"<{tag}> of joint {self.name} is left out: it is of type continuous"
                self.xml.note(bound, text)

    def _universal(self) -> list[Freedom]:
        """A hinge on an axis fixed in the parent, then one on an axis fixed in the child."""
        freedoms: list[Freedom] = []
        for number, tag in enumerate(("axis", "axis2"), start=1):
            if self.element.first(tag) is None:
                self.xml.note(self.element, f"joint {self.name} has no <{tag}>; taken: 0 0 1")
            name = f"{self.name}_{number}"
            freedoms.append(Freedom(name, "revolute", self.axis(tag), self.constraints(tag)))
        moving = [freedom for freedom in freedoms if not freedom.is_held()]
        if len(moving) < len(freedoms):
            self.xml.note(self.element, f"an axis of joint {self.name} is held by its limits")
        self._note_row(moving)
        return moving

    def _ball(self) -> list[Freedom]:
        """Hinges about x, y and z of the joint, whose axes meet."""
        constraints = self.constraints()
        friction = constraints.pop("friction", {})
        effects = [key for key in constraints if key not in LIMITS]
        if friction.get("coulomb"):
            effects.append("friction")
        if effects:
            listed = " and ".join(effects)
            problem = f"has {listed} on a ball joint, which has no axis; expected <damping> alone"
            raise self.xml.error(self.element, self.path, problem)
        along = {"friction": friction} if friction else {}
        freedoms: list[Freedom] = []
        for letter, axis in _BALL_AXES.items():
            name = f"{self.name}_{letter}"
            freedoms.append(Freedom(name, "revolute", frozen(axis), dict(along)))
        self._note_row(freedoms)
        return freedoms

    def _screw(self) -> list[Freedom]:
        """A hinge, and a slide that follows it."""
        hinge = Freedom(self.name, "revolute", self.axis(), self.constraints())
        mimic = {"joint": self.name, "multiplier": self._lead() / _ONE_TURN, "offset": 0.0}
        slide = Freedom(f"{self.name}_slide", "prismatic", self.axis(), {"mimic": mimic})
        self._note_row([hinge, slide])
        return [hinge, slide]

    def _lead(self) -> float:
        """The lead of a screw [m per turn]; the older element `thread_pitch` is its inverse."""
        pitch = self.element.first("screw_thread_pitch")
        if pitch is not None:
            return self.xml.text_number(pitch, self.path, 0.0)
        older = self.element.first("thread_pitch")
        if older is None:
            text = f"joint {self.name} has no <screw_thread_pitch>; taken: 1 m a turn"
            self.xml.note(self.element, text)
            return 1.0
        value = self.xml.text_number(older, self.path, 0.0)
        if not value:
            problem = "has a <thread_pitch> of 0; expected another number"
            raise self.xml.error(self.element, self.path, problem)
        return -_ONE_TURN / value

    def _note_row(self, freedoms: list[Freedom]) -> None:
        listed = ", ".join(freedom.name for freedom in freedoms)
        text = f"joint {self.name} is of type {self.type}; its coordinates: {listed}"
        self.xml.note(self.element, text)

    def axis(self, tag: str = "axis") -> Array:
        """The axis (3,) in the frame of the joint."""
        key = (*self.path, tag)
        xyz = self._inside_axis("xyz", tag)
        values = self.xml.text_numbers(xyz, 3, key, _Z_AXIS)
        try:
            axis = unit_axis(values)
        except ValueError as error:
            raise self.xml.error(self.element, key, str(error)) from error
        expressed_in = ""
        if xyz is not None:
            expressed_in = xyz.get("expressed_in")
        return self.poses.axis_in_joint(axis, expressed_in, self.element)

    def constraints(self, tag: str = "axis") -> Data:
        """Limits, friction, spring and mimic of an axis, if given."""
        entries: Data = {}
        limit = self._inside_axis("limit", tag)
        if limit is not None and self.type != "continuous":
            lower = self._bound(limit.first("lower"), -math.inf)
            upper = self._bound(limit.first("upper"), math.inf)
            if math.isfinite(lower) or math.isfinite(upper):
                entries["limits"] = [lower, upper]
        if limit is not None:
            entries |= self._drive_limits(limit)
        dynamics = self._inside_axis("dynamics", tag)
        if dynamics is not None:
            entries |= self._dynamics(dynamics)
        mimic = self._inside_axis("mimic", tag)
        if mimic is not None:
            entries["mimic"] = self._mimic(mimic)
        rotor = self._rotor()
        if rotor:
            entries["drive"] = rotor
        return entries

    def _end(self, tag: str) -> str:
        """The name in <parent> or <child>."""
        end = self.element.first(tag)
        if end is None or not end.text.strip():
            raise self.xml.error_at(self.element, f"has no <{tag}>")
        return end.text.strip()

    def _rotor(self) -> Data:
        """Rotor inertia and gear ratio in Drake's elements."""
        drive: Data = {}
        for tag, key in _ROTORS.items():
            element = self.element.first(tag)
            if element is not None:
                drive[key] = self.xml.text_number(element, self.path, 0.0)
        return drive

    def _inside_axis(self, tag: str, axis_tag: str) -> LocatedElement | None:
        """The first element with a tag in <axis> or <axis2>."""
        axis = self.element.first(axis_tag)
        if axis is None:
            return None
        return axis.first(tag)

    def _drive_limits(self, limit: LocatedElement) -> Data:
        """Limits of effort and rate; negative numbers mean none in SDFormat."""
        entries: Data = {}
        for tag, key in _DRIVE_LIMITS.items():
            value = self._bound(limit.first(tag), math.inf)
            if 0.0 < value < math.inf:
                entries[key] = value
        return entries

    def _bound(self, element: LocatedElement | None, unlimited: float) -> float:
        """A limit [rad or m], or infinity."""
        if element is None:
            return unlimited
        text = element.text.strip().lstrip("+-")
        if text.lower() in _INFINITY:
            return unlimited
        value = self.xml.text_number(element, (*self.path, "limits"), 0.0)
        if abs(value) >= _UNLIMITED:
            return unlimited
        return value

    def _dynamics(self, dynamics: LocatedElement) -> Data:
        """Friction and spring."""
        values: dict[str, float] = {}
        for child in dynamics.children:
            values[child.tag] = self.xml.text_number(child, self.path, 0.0)
        entries: Data = {}
        viscous = values.get("damping", 0.0)
        coulomb = values.get("friction", 0.0)
        if viscous or coulomb:
            entries["friction"] = {"viscous": viscous, "coulomb": coulomb}
        stiffness = values.get("spring_stiffness", 0.0)
        if stiffness:
            rest = values.get("spring_reference", 0.0)
            entries["spring"] = {"stiffness": stiffness, "rest": rest}
        return entries

    def _mimic(self, mimic: LocatedElement) -> Data:
        multiplier = self._number_in(mimic, "multiplier", 1.0)
        offset = self._number_in(mimic, "offset", 0.0)
        reference = self._number_in(mimic, "reference", 0.0)
        return {
            "joint": mimic.get("joint"),
            "multiplier": multiplier,
            "offset": offset - multiplier * reference,
        }

    def _number_in(self, element: LocatedElement, tag: str, default: float) -> float:
        return self.xml.text_number(element.first(tag), self.path, default)
