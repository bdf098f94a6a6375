"""Actuators of MJCF: which joints are driven. How they are controlled is left out."""

from __future__ import annotations

from ...ground.suggestions import suggestion
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .bodies import BodyReader
from .joints import largest_of, range_word
from .tendons import TendonReader

_JOINT_WORDS = ("joint", "jointinparent")
_OTHER_TRANSMISSIONS = ("site", "body", "cranksite", "slidersite", "refsite")
_BOUNDS = {"forcerange": "forcelimited", "ctrlrange": "ctrllimited"}


class ActuatorReader:
    """Reads <actuator>."""

    def __init__(self, xml: XmlReader, bodies: BodyReader, tendons: TendonReader) -> None:
        self.xml = xml
        self.tendons = tendons
        self.pulled: list[tuple[LocatedElement, list[str]]] = []  # joints of a tendon
        self.bodies = bodies
        self.on_joints: dict[str, list[LocatedElement]] = {}
        self.single: set[str] = set()  # hinges and slides
        for joint in bodies.joints:
            if any(freedom.name == joint.name for freedom in joint.freedoms):
                self.single.add(joint.name)

    def driven(self) -> dict[str, LocatedElement]:
        """The joints that are driven, in the order of the file.

        Raises:
            DescriptionError: an actuator drives something else than a hinge or slide.
        """
        driven: dict[str, LocatedElement] = {}
        for section in self.xml.root.all("actuator"):
            for element in section.children:
                joint = self._joint(element)
                driven.setdefault(joint, element)
                self.on_joints.setdefault(joint, []).append(element)
        return driven

    def _joint(self, element: LocatedElement) -> str:
        for word in _OTHER_TRANSMISSIONS:
            if element.get(word):
                raise self.xml.error_at(
                    element,
                    f"drives a {word}, which is not covered; expected joint=, a hinge or slide",
                )
        if element.get("tendon"):
            joints = list(self.tendons.coefficients(element, element.get("tendon")))
            self.pulled.append((element, joints))
            return joints[0]
        names = [element.get(word) for word in _JOINT_WORDS if element.get(word)]
        if len(names) != 1:
            raise self.xml.error_at(element, f"drives {len(names)} joints; expected one")
        (name,) = names
        if name in self.single:
            return name
        hint = suggestion(name, self.single)
        if any(joint.name == name for joint in self.bodies.joints):
            hint = ": a ball or free joint has three or six axes"
        raise self.xml.error_at(element, f"drives '{name}', which is no hinge and no slide{hint}")

    def check_tendons(self) -> None:
        """Check that a drive that pulls several joints moves one coordinate, as all are coupled.

        Raises:
            DescriptionError: it drives a sum of independent coordinates.
        """
        for element, joints in self.pulled:
            leading: set[str] = set()
            for joint in joints:
                coefficients, _ = self.tendons.of_leading_joints({joint: 1.0})
                leading.update(coefficients)
            if len(leading) > 1:
                raise self.xml.error_at(
                    element,
                    f"drives a tendon of {', '.join(joints)}, which no equality couples; expected"
                    " one coordinate: joint=, or a tendon of joints that follow one another",
                )

    def add_effort_limits(self) -> None:
        """Limit the efforts of joints to what their actuators give, where joints do not say."""
        joints = self.xml.document.section("joints")
        pulled = [element for element, _ in self.pulled]
        for name, elements in self.on_joints.items():
            limits: list[float] = []
            for element in elements:
                limits.extend(self._effort(element, name))
                if element in pulled:  # a tendon has another lever
                    self.xml.note(element, "the effort limit of a tendon's drive is left out")
                    limits = []
            if len(limits) == len(elements) and joints[name]["type"] != "fixed":
                joints[name].setdefault("effort_limit", sum(limits))

    def _effort(self, element: LocatedElement, name: str) -> list[float]:
        """The largest effort along a joint; none where it has no bound."""
        key = ("joints", name, "effort_limit")
        gear, *others = self.xml.leading_numbers(element, "gear", key) or [1.0]
        if gear != 1.0 or any(others):
            text = (
                f"gear of <{element.tag}> is {element.get('gear')}; efforts here are of the joint"
            )
            self.xml.note(element, text)
        bounds: list[float] = []
        for attribute, word in _BOUNDS.items():
            is_motor = element.tag == "motor"  # its control is its force
            if attribute == "ctrlrange" and not is_motor:
                continue
            limited = range_word(self.xml, element, word, key)
            bound = largest_of(self.xml, element, attribute, key)
            if bound is not None and limited == "false":
                self.xml.note(element, f'{attribute} is left out: {word}="false"')
            elif bound is not None:
                bounds.append(abs(gear) * bound)
        return [min(bounds)] if bounds else []
