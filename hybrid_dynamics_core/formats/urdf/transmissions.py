"""<transmission> and <ros2_control> of a URDF: drives, their limits, and followers."""

from __future__ import annotations

from collections.abc import Iterable

from ...description.document import Data
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .control_limits import add_control_limits
from .coupled_drives import add_coupled_drives

_ROTOR = {"drake:rotor_inertia": "rotor_inertia", "drake:gear_ratio": "gear_ratio"}
_OMITTED = "efforts here are those of the joints"


class Drives:
    """Reads the drives of a URDF whose links and joints are in the document.

    Attributes:
        motors: joints with a drive, in order.
    """

    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.joints = xml.document.section("joints")
        self.motors: list[str] = []

    def read(self) -> None:
        """Read motors, rotors and followers, and add notes on other elements."""
        transmissions = self.xml.root.all("transmission")
        for element in transmissions:
            self._read_transmission(element)
        if transmissions:
            self.xml.note(transmissions[0], f"<transmission>s are left out: {_OMITTED}")
        controls = self.xml.root.all("ros2_control")
        for element in controls:
            self._read_control(element)
        if controls:
            self.xml.note(
                controls[0],
                "<ros2_control> is left out, but for what it drives, limits and followers",
            )

    def _read_transmission(self, element: LocatedElement) -> None:
        driven = self._moving(joint.get("name") for joint in element.all("joint"))
        self._add_motors(driven)
        name = element.get("name")
        if len(driven) > 1:
            listed = " and ".join(driven)
            shares = _OMITTED
            actuators = add_coupled_drives(self.xml, element)
            if actuators:
                shares = f"{_OMITTED}, and distribute() gives those of {' and '.join(actuators)}"
            self.xml.note(element, f"transmission {name} drives {listed} together: {shares}")
        for actuator in element.all("actuator"):
            self._read_actuator(actuator, driven)

    def _read_actuator(self, actuator: LocatedElement, driven: list[str]) -> None:
        """Read rotor inertia and gear ratio, in Drake's elements."""
        drive: Data = {}
        for tag, key in _ROTOR.items():
            child = actuator.first(tag)
            if child is not None:
                drive[key] = self.xml.number(child, "value", ("joints", *driven[:1], "drive"))
        if not drive.get("rotor_inertia"):
            return
        if len(driven) != 1:
            problem = "has a rotor inertia, and drives several joints; one joint is covered"
            raise self.xml.error(actuator, ("transmission",), problem)
        self.joints[driven[0]]["drive"] = drive

    def _read_control(self, element: LocatedElement) -> None:
        for joint in element.all("joint"):
            names = self._moving([joint.get("name")])
            if not names:
                self.xml.note(
                    joint, f"there is no joint '{joint.get('name')}' that moves; left out"
                )
                continue
            self._add_follower(joint, names[0])
            if self.joints[names[0]]["type"] in ("revolute", "prismatic"):
                add_control_limits(self.xml, joint, names[0], self.joints[names[0]])
            if joint.all("command_interface"):
                self._add_motors(names)
        for transmission in element.all("transmission"):
            add_coupled_drives(self.xml, transmission)

    def _add_follower(self, element: LocatedElement, name: str) -> None:
        """Read <param name="mimic">, unless <mimic> has it already."""
        params = {param.get("name"): param for param in element.all("param")}
        source = params.get("mimic")
        if source is None or "mimic" in self.joints[name]:
            return
        key = ("joints", name, "mimic")
        self.joints[name]["mimic"] = {
            "joint": source.text.strip(),
            "multiplier": self.xml.text_number(params.get("multiplier"), key, 1.0),
            "offset": self.xml.text_number(params.get("offset"), key, 0.0),
        }
        self.xml.locate(key, element)

    def _add_motors(self, names: Iterable[str]) -> None:
        for name in names:
            if name not in self.motors:
                self.motors.append(name)

    def _moving(self, names: Iterable[str]) -> list[str]:
        """The moving joints among some names."""
        joints = self.joints
        return [name for name in names if joints.get(name, {"type": "fixed"})["type"] != "fixed"]
