"""Joints of MJCF: hinges and slides, with limits, friction, rotors and springs."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...description.document import Data
from ...description.geometry import Transform
from ...errors import DescriptionError
from ...ground.arrays import frozen
from .compiler.compiled import Actuator, Joint
from .compiler.model import MjcfModel
from .settings import Settings

TYPES = {"hinge": "revolute", "slide": "prismatic"}
_ON_A_JOINT = ("joint", "jointinparent")


@dataclass(frozen=True)
class Freedom:
    """One hinge or slide.

    Attributes:
        name: name of the joint.
        entry: type, axis, limits and effects, as an entry of a description.
        before: pose of its frame in the frame after the joint before.
        after: pose of the child body's frame in its own frame.
        ref: coordinate in the drawn configuration [rad or m].
    """

    name: str
    entry: Data
    before: Transform
    after: Transform = field(default_factory=Transform)
    ref: float = 0.0


class JointReader:
    """Reads hinges and slides."""

    def __init__(self, model: MjcfModel, settings: Settings) -> None:
        self.model = model
        self.xml = model.xml
        self.settings = settings
        self.armatures: dict[int, float] = {}  # armature of actuators, by joint number
        self.dampings: dict[int, float] = {}
        for actuator in model.content.actuators:
            self._add_rotor(actuator)

    def _add_rotor(self, actuator: Actuator) -> None:
        """Add the rotor and the damping of an actuator to its joint, through its gear."""
        if not (actuator.armature or actuator.damping or actuator.is_polynomial):
            return
        element = self.model.element(actuator.line)
        joints = self.model.content.joints
        is_on_joint = actuator.kind in _ON_A_JOINT and joints[actuator.target].kind in TYPES
        if actuator.is_polynomial or not is_on_joint:
            problem = (
                "has armature or damping, which is read of actuators of a hinge or slide alone,"
                " and as one number"
            )
            raise self.xml.error_at(element, problem)
        squared = actuator.gear[0] ** 2
        number = actuator.target
        self.armatures[number] = self.armatures.get(number, 0.0) + squared * actuator.armature
        self.dampings[number] = self.dampings.get(number, 0.0) + squared * actuator.damping

    def freedom(self, number: int, name: str) -> Freedom:
        """The freedom of a hinge or slide.

        Raises:
            DescriptionError: a spring or damper is not linear.
        """
        joint = self.model.content.joints[number]
        entry: Data = {
            "type": TYPES[joint.kind],
            "axis": list(joint.axis),
            **self._limits(joint, name),
            **self._effort_limit(joint),
            **self.effects(joint, name, number),
        }
        if joint.drawn:
            entry["offset"] = -joint.drawn
        place = Transform(translation=frozen(joint.pos))
        return Freedom(name, entry, place, place.inverse(), joint.drawn)

    def _limits(self, joint: Joint, name: str) -> Data:
        if not self.settings.has("limit"):
            return {}
        if joint.is_limited:
            return {"limits": list(joint.range)}
        element = self.model.joint_element(joint)
        if "range" in element.attributes:
            text = f"joint {name}: the range {element.get('range')} is no limit, as in MuJoCo"
            self.xml.note(element, text)
        return {}

    def _effort_limit(self, joint: Joint) -> Data:
        if not joint.has_effort_range:
            return {}
        largest = largest_of(self.model, joint.line, "actuatorfrcrange", joint.effort_range)
        return {"effort_limit": largest}

    def effects(self, joint: Joint, name: str, number: int = -1) -> Data:
        """Friction, drive and spring of a joint.

        Args:
            joint: a joint of any type.
            name: name of the joint.
            number: number of a hinge or slide, for the armature of its actuators.

        Raises:
            DescriptionError: a spring or damper is not linear.
        """
        self._require_linear(joint, name)
        viscous = 0.0
        coulomb = 0.0
        if self.settings.has("damper"):
            viscous = joint.damping + self.dampings.get(number, 0.0)
        if self.settings.has("frictionloss"):
            coulomb = joint.frictionloss
        entries: Data = {}
        if viscous or coulomb:
            entries["friction"] = {"viscous": viscous, "coulomb": coulomb}
        armature = joint.armature + self.armatures.get(number, 0.0)
        if armature:
            entries["drive"] = {"rotor_inertia": armature}
        if joint.stiffness and self.settings.has("spring"):
            entries["spring"] = {"stiffness": joint.stiffness, "rest": joint.spring_reference}
        return entries

    def _require_linear(self, joint: Joint, name: str) -> None:
        problem = ""
        if joint.is_polynomial:
            problem = "stiffness or damping is a polynomial; expected its first number alone"
        elif joint.spring_yield and joint.stiffness:
            problem = f"springyield is {joint.spring_yield:g}, beyond which a spring is no spring"
        if problem:
            raise self._error(joint, name, problem)

    def _error(self, joint: Joint, name: str, problem: str) -> DescriptionError:
        return self.xml.error(self.model.joint_element(joint), ("joints", name), problem)


def largest_of(model: MjcfModel, line: str, word: str, limits: list[float]) -> float:
    """The larger bound of a range of efforts, with a note if the bounds differ."""
    lower, upper = limits
    largest = max(-lower, upper)
    if lower != -upper:
        element = model.element(line)
        text = f"{word} of <{element.tag}> is {lower:g} to {upper:g}; kept: {largest:g}"
        model.xml.note(element, text)
    return largest
