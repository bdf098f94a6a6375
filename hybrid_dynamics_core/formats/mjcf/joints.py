"""Joints of MJCF: a chain of hinges and slides, with limits, friction, rotors and springs.

A ball joint is three hinges in a row, a free joint three slides and three hinges. Massless links
stand between the joints of one body.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...description.document import Data, KeyPath
from ...description.geometry import Transform
from ...ground.arrays import Array, frozen
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .poses import PoseReader
from .vocabulary import JOINT_NUMBERS

_TYPES = {"hinge": "revolute", "slide": "prismatic"}
_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_ZERO_VECTOR = (0.0, 0.0, 0.0)
_RANGE_WORDS = ("auto", "true", "false")


@dataclass(frozen=True)
class Freedom:
    """One hinge or slide.

    Attributes:
        name: of the joint.
        entry: type, axis, limits and effects, as a description has them.
        before: pose of its frame in the frame that the one before has reached.
        after: pose of the frame of the body behind it, in its own frame.
        ref: coordinate in the drawn pose [rad or m].
    """

    name: str
    entry: Data
    before: Transform
    after: Transform = field(default_factory=Transform)
    ref: float = 0.0


@dataclass(frozen=True)
class MjcfJoint:
    """A joint of the file.

    Attributes:
        name: of the joint.
        type: in MJCF.
        freedoms: its hinges and slides, in their order.
        drawn: pose of its body in the world, of a free joint.
    """

    name: str
    type: str
    freedoms: list[Freedom]
    drawn: Transform


class JointReader:
    """Reads the joints of a body."""

    def __init__(self, xml: XmlReader, poses: PoseReader) -> None:
        self.xml = xml
        self.settings = poses.settings

    def read(
        self, joint: LocatedElement, name: str, around: Transform, body: Transform
    ) -> MjcfJoint:
        """The hinges and slides of a joint.

        Args:
            joint: the element.
            name: of the joint.
            around: frame in which it is given, in the body.
            body: pose of the body, in the body around it.

        Raises:
            DescriptionError: it is of another type, or has what a ball or free joint cannot have.
        """
        mujoco_type = "free" if joint.tag == "freejoint" else joint.get("type", "hinge")
        if mujoco_type in _TYPES:
            freedoms = [self._single(joint, name, around, _TYPES[mujoco_type])]
        elif mujoco_type == "ball":
            freedoms = self._ball(joint, name, around)
        elif mujoco_type == "free":
            freedoms = self._free(joint, name, body)
        else:
            problem = f"is '{mujoco_type}'; expected hinge, slide, ball or free"
            raise self.xml.error(joint, ("joints", name, "type"), problem)
        return MjcfJoint(name, mujoco_type, freedoms, body)

    def _single(
        self, joint: LocatedElement, name: str, around: Transform, joint_type: str
    ) -> Freedom:
        path: KeyPath = ("joints", name)
        axis = self.xml.numbers(joint, "axis", 3, path, _AXES["Z"])
        unit = self.settings.angle_unit if joint_type == "revolute" else 1.0
        ref = unit * self.xml.number(joint, "ref", path, 0.0)
        entry: Data = {
            "type": joint_type,
            "axis": (around.rotation @ axis).tolist(),
            **self._limits(joint, unit, path),
            **self._effort_limit(joint, path),
            **self._effects(joint, unit, path),
        }
        if ref:
            entry["offset"] = -ref
        before, after = self._place(joint, around, path)
        return Freedom(name, entry, before, after, ref)

    def _place(
        self, joint: LocatedElement, around: Transform, path: KeyPath
    ) -> tuple[Transform, Transform]:
        """The way from the frame of the body to the joint, and back."""
        place = self.xml.numbers(joint, "pos", 3, path, _ZERO_VECTOR)
        before = Transform(translation=frozen(around.point(np.array(place))))
        return before, before.inverse()

    # -- joints of several degrees of freedom

    def _ball(self, joint: LocatedElement, name: str, around: Transform) -> list[Freedom]:
        path: KeyPath = ("joints", name)
        self._refuse_effects(joint, path)
        if self._is_limited(joint, path):
            self.xml.note(joint, f"joint {name}: the range of a ball joint is left out")
        before, after = self._place(joint, around, path)
        self.xml.note(joint, f"joint {name} is a ball; taken: hinges {_listed(name, '')} in a row")
        return _hinges(name, before, after)

    def _free(self, joint: LocatedElement, name: str, body: Transform) -> list[Freedom]:
        """Slides along the axes of the world, then hinges from the pose in which it is drawn."""
        path: KeyPath = ("joints", name)
        self._refuse_effects(joint, path)
        freedoms: list[Freedom] = []
        before = Transform(translation=body.translation)
        for letter, axis in _AXES.items():
            entry = {"type": "prismatic", "axis": list(axis)}
            freedoms.append(Freedom(f"{name}_along_{letter}", entry, before))
            before = Transform()
        turned = Transform(body.rotation)
        slides = _listed(name, "along_")
        hinges = _listed(name, "")
        self.xml.note(
            joint,
            f"joint {name} is free; taken: slides {slides} and hinges {hinges} in a row, zero as"
            " drawn",
        )
        return [*freedoms, *_hinges(name, turned, Transform())]

    def _refuse_effects(self, joint: LocatedElement, path: KeyPath) -> None:
        """Refuse what acts on the whole turn of a ball, which three hinges cannot say."""
        for attribute in sorted(JOINT_NUMBERS - {"springref"}):
            values = self.xml.leading_numbers(joint, attribute, path)
            if any(values):
                raise self.xml.error(
                    joint,
                    (*path, attribute),
                    f"{attribute} of a ball or free joint is '{joint.get(attribute)}', which acts"
                    " on its angular velocity, not on hinges in a row; expected 0: take it out, or"
                    " write three hinges" + _from_class(joint),
                )

    # -- limits and effects

    def _limits(self, joint: LocatedElement, unit: float, path: KeyPath) -> Data:
        if not self._is_limited(joint, path):
            return {}
        limits = self.xml.numbers(joint, "range", 2, (*path, "limits"))
        return {"limits": [unit * limit for limit in limits]}

    def _effort_limit(self, joint: LocatedElement, path: KeyPath) -> Data:
        """The largest effort."""
        key = (*path, "effort_limit")
        if range_word(self.xml, joint, "actuatorfrclimited", path) == "false":
            return {}
        largest = largest_of(self.xml, joint, "actuatorfrcrange", key)
        return {} if largest is None else {"effort_limit": largest}

    def _is_limited(self, joint: LocatedElement, path: KeyPath) -> bool:
        """Whether a joint has limits: what `limited` says, or else a range above zero."""
        limited = range_word(self.xml, joint, "limited", path)
        if limited != "auto":
            return limited == "true"
        if "range" not in joint.attributes:
            return False
        if not self.settings.are_limits_automatic:
            problem = 'has a range and autolimits="false"; say limited="true" or "false"'
            raise self.xml.error(joint, path, problem)
        lower, upper = self.xml.numbers(joint, "range", 2, (*path, "limits"))
        if lower < upper:
            return True
        _, name = path
        text = f"joint {name}: the range {lower:g} {upper:g} is no limit, as in MuJoCo"
        self.xml.note(joint, text)
        return False

    def _effects(self, joint: LocatedElement, unit: float, path: KeyPath) -> Data:
        """Friction, drive and spring of a joint."""
        numbers: dict[str, float] = {}
        for attribute in sorted(JOINT_NUMBERS.intersection(joint.attributes)):
            numbers[attribute] = self._first_degree(joint, attribute, path)
        entries: Data = {}
        if "damping" in numbers or "frictionloss" in numbers:
            viscous = numbers.get("damping", 0.0)
            coulomb = numbers.get("frictionloss", 0.0)
            entries["friction"] = {"viscous": viscous, "coulomb": coulomb}
        if "armature" in numbers:
            entries["drive"] = {"rotor_inertia": numbers["armature"]}
        if "stiffness" in numbers:
            rest = unit * numbers.get("springref", 0.0)
            entries["spring"] = {"stiffness": numbers["stiffness"], "rest": rest}
        return entries

    def _first_degree(self, joint: LocatedElement, attribute: str, path: KeyPath) -> float:
        """A number that may go on as a polynomial, whose higher terms have to be zero."""
        if len(joint.get(attribute).split()) < 2:
            return self.xml.number(joint, attribute, path)
        first, *higher = self.xml.leading_numbers(joint, attribute, path)
        if any(higher):
            problem = f"{attribute} is a polynomial; expected its first number alone"
            raise self.xml.error(joint, path, problem)
        return first


def _hinges(name: str, before: Transform, after: Transform) -> list[Freedom]:
    """Hinges about x, y and z, whose axes meet."""
    freedoms: list[Freedom] = []
    for letter, axis in _AXES.items():
        entry = {"type": "revolute", "axis": list(axis)}
        freedoms.append(Freedom(f"{name}_{letter}", entry, before))
        before = Transform()
    last = freedoms.pop()
    freedoms.append(Freedom(last.name, last.entry, last.before, after))
    return freedoms


def _listed(name: str, prefix: str) -> str:
    return ", ".join(f"{name}_{prefix}{letter}" for letter in _AXES)


def _from_class(joint: LocatedElement) -> str:
    if joint.tag == "joint" and joint.get("type") == "free":
        return " (a <freejoint> has no defaults)"
    return ""


def angles_of(rotation: Array) -> list[float]:
    """Angles [rad] of hinges about x, y and z in a row that make up a rotation (3, 3)."""
    pitch = float(np.arcsin(np.clip(rotation[0, 2], -1.0, 1.0)))
    roll = float(np.arctan2(-rotation[1, 2], rotation[2, 2]))
    yaw = float(np.arctan2(-rotation[0, 1], rotation[0, 0]))
    return [roll, pitch, yaw]


def largest_of(
    xml: XmlReader, element: LocatedElement, attribute: str, key: KeyPath
) -> float | None:
    """The larger end of a range of efforts, with a note where its ends differ."""
    if attribute not in element.attributes:
        return None
    lower, upper = xml.numbers(element, attribute, 2, key)
    largest = max(-lower, upper)
    if lower != -upper:
        text = f"{attribute} of <{element.tag}> is {lower:g} to {upper:g}; kept: {largest:g}"
        xml.note(element, text)
    return largest


def range_word(xml: XmlReader, element: LocatedElement, attribute: str, key: KeyPath) -> str:
    """Whether a range holds: auto, true or false."""
    word = element.get(attribute, "auto")
    if word not in _RANGE_WORDS:
        problem = f"{attribute} is '{word}'; expected {' or '.join(_RANGE_WORDS)}"
        raise xml.error(element, key, problem)
    return word
