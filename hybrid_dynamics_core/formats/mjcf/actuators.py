"""Actuators of MJCF: driven joints and effort limits. Control laws are ignored."""

from __future__ import annotations

from ..xml.located_xml import LocatedElement
from .bodies import BodyReader
from .compiler.compiled import Actuator
from .compiler.model import MjcfModel
from .joints import largest_of
from .settings import Settings
from .tendons import TendonReader

_ON_A_JOINT = ("joint", "jointinparent")
_WRENCHES = {
    "crank": "through a crank",
    "site": "a site, which is a wrench",
    "body": "a body, which is adhesion",
    "other": "what is no joint",
}
_RANGES = {"forcerange": "forcelimited", "ctrlrange": "ctrllimited"}


class ActuatorReader:
    """Reads <actuator>."""

    def __init__(self, model: MjcfModel, bodies: BodyReader, tendons: TendonReader) -> None:
        self.model = model
        self.xml = model.xml
        self.tendons = tendons
        self.names = bodies.single_joints()
        self.pulled: list[tuple[Actuator, list[str]]] = []  # (actuator, joints of its tendon)
        self.on_joints: dict[str, list[Actuator]] = {}

    def driven(self, settings: Settings) -> dict[str, LocatedElement]:
        """The joints that are driven, in the order of the file."""
        driven: dict[str, LocatedElement] = {}
        if not settings.has("actuation"):
            return driven
        for actuator in self.model.content.actuators:
            element = self.model.element(actuator.line)
            if actuator.group in self.model.content.disabled_groups:
                self._leave_out(element, f"its group {actuator.group} is disabled")
                continue
            joint = self._joint(actuator, element)
            if joint:
                driven.setdefault(joint, element)
                self.on_joints.setdefault(joint, []).append(actuator)
        return driven

    def _joint(self, actuator: Actuator, element: LocatedElement) -> str:
        """The first joint that an actuator drives; empty if it drives none."""
        if actuator.kind in _ON_A_JOINT:
            if actuator.target in self.names:
                return self.names[actuator.target]
            self._leave_out(element, "it drives a ball or free joint, which has several axes")
            return ""
        if actuator.kind != "tendon":
            self._leave_out(element, f"it drives {_WRENCHES[actuator.kind]}")
            return ""
        tendon = self.model.content.tendons[actuator.target]
        if not tendon.terms:
            self._leave_out(element, f"it pulls the spatial tendon {tendon.name}")
            return ""
        joints = list(self.tendons.coefficients(actuator.target, element))
        self.pulled.append((actuator, joints))
        return joints[0]

    def _leave_out(self, element: LocatedElement, reason: str) -> None:
        self.xml.note(element, f"<{element.tag}> is left out: {reason}")

    def add_pulled(self, driven: dict[str, LocatedElement]) -> None:
        """Make each joint of a tendon drive active if no equality couples them."""
        for actuator, joints in self.pulled:
            terms = dict.fromkeys(joints, 1.0)
            leading, _ = self.tendons.of_leading_joints(terms)
            if len(leading) < 2:
                continue
            element = self.model.element(actuator.line)
            for name in leading:
                driven.setdefault(name, element)
            self.xml.note(
                element,
                f"drives a tendon of {', '.join(joints)}, which no equality couples; each of them"
                " is taken as driven",
            )

    # -- effort limits

    def add_effort_limits(self) -> None:
        """Limit the efforts of joints to those of their actuators."""
        joints = self.xml.document.section("joints")
        pulling = [actuator for actuator, _ in self.pulled]
        for name, actuators in self.on_joints.items():
            limits: list[float] = []
            for actuator in actuators:
                limits.extend(self._effort(actuator))
                if actuator in pulling:  # a tendon has a lever of its own
                    element = self.model.element(actuator.line)
                    self.xml.note(element, "the effort limit of a tendon's drive is left out")
                    limits = []
            entry = joints[name]
            if len(limits) == len(actuators) and entry["type"] != "fixed":
                total = sum(limits)
                entry["effort_limit"] = min(total, entry.get("effort_limit", total))

    def _effort(self, actuator: Actuator) -> list[float]:
        """The largest effort along a joint; empty if it is unbounded."""
        element = self.model.element(actuator.line)
        gear, *others = actuator.gear
        if gear != 1.0 or any(others):
            shown = element.get("gear", f"{gear:g}")
            text = f"gear of <{element.tag}> is {shown}; efforts here are of the joint"
            self.xml.note(element, text)
        bounds: list[float] = []
        for word, limits in self._ranges(actuator, element).items():
            factor = abs(gear * actuator.gain) if word == "ctrlrange" else abs(gear)
            bounds.append(factor * largest_of(self.model, actuator.line, word, limits))
        return [min(bounds)] if bounds else []

    def _ranges(self, actuator: Actuator, element: LocatedElement) -> dict[str, list[float]]:
        """Ranges that bound the force of an actuator, by attribute name."""
        ranges = {"forcerange": actuator.force_range}
        if actuator.gain:  # the control is the force
            ranges["ctrlrange"] = actuator.control_range
        for word, limits in ranges.items():
            if not limits and word in element.attributes:
                text = f'{word} is left out: {_RANGES[word]}="false"'
                self.xml.note(element, text)
        return {word: limits for word, limits in ranges.items() if limits}
