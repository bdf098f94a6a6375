"""MJCF -> a document: bodies on hinges and slides, closures, followers, driven joints.

Defaults, degrees and every way to give an orientation are read as MuJoCo reads them. What would
change the robot and has no words here is refused with its line. All else is left out, with a note.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...description.defaults import driven_joints, farthest_link
from ...description.document import Document
from ...description.geometry import IDENTITY, rotation_from_quaternion
from ...ground.arrays import Array
from ..extras_reader import TAG, read_extras
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from ..xml.vocabulary import VocabularyCheck
from .actuators import ActuatorReader
from .bodies import WORLD, BodyReader, pose_entry
from .couplings import CouplingReader
from .defaults import apply_defaults
from .equalities import ClosureReader, is_active
from .includes import open_includes
from .joints import MjcfJoint, angles_of
from .poses import PoseReader
from .settings import SettingsReader
from .tendons import TendonReader
from .vocabulary import ADVICE, MJCF

_WIDTHS = {"free": 7, "ball": 4, "hinge": 1, "slide": 1}  # numbers in qpos


def mjcf_document(root: LocatedElement, file: Path) -> Document:
    """The document of an MJCF file.

    Raises:
        DescriptionError: the file says what is not covered.
    """
    data = {
        "format": 1,
        "name": root.get("model") or file.stem,
        "base": WORLD,
        "links": {},
        "joints": {},
        "closures": {},
        "source": file.name,
    }
    document = Document(data, file, {})
    xml = XmlReader(file, root, document)
    open_includes(xml)
    check = VocabularyCheck(xml, MJCF, ADVICE)
    check.check(root)
    check.add_notes()
    apply_defaults(xml)
    _MjcfReader(xml).read()
    if "end_effector" not in document.data:
        document.data["end_effector"] = {"link": farthest_link(document)}
    return document


class _MjcfReader:
    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.document = xml.document
        self.settings = SettingsReader(xml).read()
        poses = PoseReader(xml, self.settings)
        self.bodies = BodyReader(xml, poses)

    def read(self) -> None:
        """Fill the document."""
        self.document.data["gravity"] = self.settings.gravity
        self.bodies.read()
        for link in self.document.section("links"):
            self.document.rounded_links.add(link)  # saved files have six digits
        couplings = CouplingReader(self.xml, self.bodies)
        tendons = TendonReader(self.xml, couplings)
        actuators = ActuatorReader(self.xml, self.bodies, tendons)
        driven = actuators.driven()
        self.add_equalities(couplings, tendons)
        couplings.add(driven)
        tendons.add(driven)
        actuators.check_tendons()
        actuators.add_effort_limits()
        self.add_active(driven)
        self.add_reference()
        self.add_extras()

    def add_equalities(self, couplings: CouplingReader, tendons: TendonReader) -> None:
        """Add closures and read followers; sites that no closure ties become frames."""
        closures = ClosureReader(self.xml, self.bodies)
        for section in self.xml.root.all("equality"):
            for element in section.children:
                if not is_active(self.xml, element):
                    self.xml.note(element, f'<{element.tag}> is left out: active="false"')
                elif element.tag == "joint":
                    couplings.read(element)
                elif element.tag == "tendon":
                    tendons.read(element)
                else:
                    closures.add(element)
        self.add_sites(closures.tied_sites)

    def add_sites(self, tied: set[str]) -> None:
        """Make sites that no closure ties frames."""
        frames = self.document.section("frames")
        links = self.document.section("links")
        for name, site in self.bodies.sites.items():
            if name in tied:
                continue
            frame = name
            if name in links or name == WORLD:
                frame = f"{name}_site"
                self.xml.note(
                    site.element, f"site {name} has the name of a body; called here {frame}"
                )
            frames[frame] = {"link": site.link, **pose_entry(site.pose)}

    # -- drives and reference

    def add_active(self, driven: dict[str, LocatedElement]) -> None:
        """Make the joints with actuators active, but for those that follow others or are held."""
        joints = self.document.section("joints")
        active: list[str] = []
        for name, element in driven.items():
            if joints[name]["type"] == "fixed" or "mimic" in joints[name]:
                self.xml.note(
                    element, f"joint {name} is held or follows others; its actuator is left out"
                )
            else:
                active.append(name)
        if not active:
            self.document.notes.append(
                "no actuators are given; independent joints are taken as driven, in the order of"
                " the file"
            )
            active = driven_joints(self.document)
        self.document.data["active"] = active
        self.document.data["active_set"] = "motors"

    def add_reference(self) -> None:
        """Read the first keyframe with coordinates; without one, the robot is as drawn."""
        key = self.first_key()
        reference = self.drawn() if key is None else self.coordinates(key)
        for name, joint in self.document.section("joints").items():
            if joint["type"] == "fixed":
                reference.pop(name, None)
        self.document.data["reference"] = reference

    def first_key(self) -> LocatedElement | None:
        """The first keyframe with coordinates; all others are left out with a note."""
        first: LocatedElement | None = None
        for keyframe in self.xml.root.all("keyframe"):
            for key in keyframe.all("key"):
                if first is None and "qpos" in key.attributes:
                    first = key
                else:
                    self.xml.note(key, "<key> is left out; the first with qpos is the reference")
        return first

    def drawn(self) -> dict[str, float]:
        """The coordinates of all joints as the file draws them, within their limits."""
        joints = self.document.section("joints")
        coordinates: dict[str, float] = {}
        for joint in self.bodies.joints:
            for freedom in joint.freedoms:
                limits = joints[freedom.name].get("limits", (freedom.ref, freedom.ref))
                coordinates[freedom.name] = self.within(freedom.name, limits, freedom.ref)
        return coordinates

    def within(self, name: str, limits: Sequence[float], drawn: float) -> float:
        """The drawn coordinate of a joint, or the limit that is nearest to it."""
        lower, upper = limits
        nearest = min(max(drawn, lower), upper)
        if nearest != drawn:
            self.document.notes.append(
                f"{name}: drawn at {drawn:g}, beyond its limits; taken as reference: {nearest:g}"
            )
        return nearest

    def coordinates(self, key: LocatedElement) -> dict[str, float]:
        """The coordinates of all joints in a keyframe."""
        widths = [_WIDTHS[joint.type] for joint in self.bodies.joints]
        values = self.xml.numbers(key, "qpos", sum(widths), ("keyframe",))
        coordinates: dict[str, float] = {}
        start = 0
        for joint, width in zip(self.bodies.joints, widths, strict=True):
            numbers = _coordinates(joint, values[start : start + width])
            names = [freedom.name for freedom in joint.freedoms]
            coordinates.update(zip(names, numbers, strict=True))
            start += width
        return coordinates

    def add_extras(self) -> None:
        """Join what this library wrote into <custom>."""
        for custom in self.xml.root.all("custom"):
            for text in custom.all("text"):
                if text.get("name") == TAG:
                    file = self.xml.file_of(text)
                    read_extras(self.document, text.get("data"), file, text.line)
                else:
                    self.xml.note(text, "<text> is left out")


def _coordinates(joint: MjcfJoint, numbers: list[float]) -> list[float]:
    """Coordinates of the hinges and slides of a joint, from its numbers in qpos."""
    if joint.type == "ball":
        return angles_of(_turn(numbers))
    if joint.type == "free":
        position = np.array(numbers[:3]) - joint.drawn.translation
        turned = joint.drawn.rotation.T @ _turn(numbers[3:])
        return [*position.tolist(), *angles_of(turned)]
    return numbers


def _turn(quaternion: list[float]) -> Array:
    """The rotation (3, 3) of a quaternion in a keyframe; MuJoCo takes zeros for no turn."""
    if not any(quaternion):
        return IDENTITY
    return rotation_from_quaternion(np.array(quaternion))
