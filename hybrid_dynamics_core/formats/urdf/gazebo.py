"""<gazebo> elements of a URDF: loops, springs and followers are read, others are noted."""

from __future__ import annotations

from ...description.document import Data
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .gazebo_joints import GazeboJoints

_SPRING = {"springStiffness": "stiffness", "springReference": "rest"}
_MIMIC = "mimic"  # part of the file name of mimic plugins
_MIMIC_WORDS = frozenset(
    {"joint", "mimicJoint", "multiplier", "offset", "hasPID", "sensitiveness", "maxEffort"}
)
# Elements of a link that change its motion, and the values that do not:
_MECHANICAL = {
    "turnGravityOff": ("false", "0", "no"),
    "gravity": ("true", "1", "yes"),
    "dampingFactor": ("0", "0.0"),
    "velocity_decay": (),
    "kinematic": ("false", "0"),
    "static": ("false", "0"),
    "inertial": (),
    "pose": (),
    "joint": (),
    "axis": (),
}
_STILL = {"type": "fixed"}
_BODIES = ("link", "model", "include")


def read_gazebo(xml: XmlReader, joints: GazeboJoints) -> None:
    """Read all <gazebo> of a URDF whose links and joints the document has.

    Args:
        xml: the URDF.
        joints: adds the joints that close loops.

    Raises:
        DescriptionError: a block has unsupported content that changes the mechanics.
    """
    reader = _GazeboReader(xml, joints)
    for block in xml.root.all("gazebo"):
        reader.read(block)
    reader.note_omitted()


class _GazeboReader:
    def __init__(self, xml: XmlReader, joints: GazeboJoints) -> None:
        self.xml = xml
        self.document = xml.document
        self.gazebo_joints = joints
        self.counts: dict[str, int] = {}  # number of occurrences of words left out
        self.first_omitted: LocatedElement | None = None

    def read(self, block: LocatedElement) -> None:
        for name in block.attributes:
            if name != "reference":
                self.xml.note(block, f"{name} of <gazebo> is left out")
        reference = block.get("reference")
        if not reference:
            self.read_model(block)
            return
        names = {*self.document.section("links"), *self.document.section("joints")}
        if reference not in names:
            self.xml.note(block, f"<gazebo> refers to '{reference}', which is not there; left out")
            return
        self.read_referenced(block, reference)

    def omit(self, element: LocatedElement, words: str) -> None:
        """Count a word that does not change the robot's motion."""
        self.first_omitted = self.first_omitted or element
        self.counts[words] = self.counts.get(words, 0) + 1

    def note_omitted(self) -> None:
        """Add notes on the words left out, with their number of occurrences."""
        if self.first_omitted is None:
            return
        listed = ", ".join(f"{words} ({count})" for words, count in self.counts.items())
        self.xml.note(self.first_omitted, f"of <gazebo> is left out, from here on: {listed}")

    # -- of a link or joint

    def read_referenced(self, block: LocatedElement, name: str) -> None:
        spring: dict[str, float] = {}
        for child in block.children:
            if child.tag in _SPRING:
                key = ("joints", name, "spring")
                spring[_SPRING[child.tag]] = self.xml.text_number(child, key, 0.0)
            elif _changes_motion(child):
                effect = _WEIGHT if "gravity" in child.tag.lower() else _EFFECT
                self.xml.note(child, f"{name}: Gazebo's <{child.tag}> is left out: {effect}")
            else:
                self.omit(child, f"<{child.tag}>")
        if spring:
            self.add_spring(block, name, spring)

    def add_spring(self, block: LocatedElement, name: str, spring: Data) -> None:
        joint = self.document.section("joints").get(name, _STILL)
        if joint["type"] == "fixed":
            self.xml.note(block, f"{name} does not move; its spring is left out")
        elif spring.get("stiffness", 0.0):
            joint["spring"] = spring
            self.xml.locate(("joints", name, "spring"), block)
        else:
            self.omit(block, "a spring without stiffness")

    # -- of the model

    def read_model(self, block: LocatedElement) -> None:
        for child in block.children:
            if child.tag == "joint":
                self.gazebo_joints.add(child)
            elif child.tag == "plugin":
                self.read_plugin(child)
            elif child.tag in _BODIES:
                advice = "write them as <link> and <joint>, or take them out"
                problem = f"<{child.tag}> in <gazebo> adds bodies: {advice}"
                raise self.xml.error(child, ("gazebo", child.get("name")), problem)
            elif _changes_motion(child):
                self.xml.note(child, f"Gazebo's <{child.tag}> is left out: {_EFFECT}")
            else:
                self.omit(child, f"<{child.tag}>")

    def read_plugin(self, plugin: LocatedElement) -> None:
        """Read a plugin that makes a joint follow another one."""
        file = plugin.get("filename") or plugin.get("name")
        if _MIMIC not in file.lower():
            self.omit(plugin, f"<plugin> {file}")
            return
        names = [self.text_of(plugin, tag) for tag in ("joint", "mimicJoint")]
        joints = self.document.section("joints")
        missing = [name for name in names if joints.get(name, _STILL)["type"] == "fixed"]
        if missing:
            listed = " and ".join(f"'{name}'" for name in missing)
            self.xml.note(plugin, f"<plugin> {file} is left out: no joint {listed} moves here")
            return
        joint, follower = names
        key = ("joints", follower, "mimic")
        mimic = {
            "joint": joint,
            "multiplier": self.xml.text_number(plugin.first("multiplier"), key, 1.0),
            "offset": self.xml.text_number(plugin.first("offset"), key, 0.0),
        }
        self.follow(plugin, follower, mimic)
        for child in plugin.children:
            if child.tag not in _MIMIC_WORDS:
                self.omit(child, f"<{child.tag}> of <plugin> {file}")

    def text_of(self, plugin: LocatedElement, tag: str) -> str:
        """The text of a child element; empty if it is missing."""
        element = plugin.first(tag)
        return "" if element is None else element.text.strip()

    def follow(self, element: LocatedElement, follower: str, mimic: Data) -> None:
        """Make a joint follow another one, unless <mimic> does already."""
        joint = self.document.section("joints")[follower]
        given = joint.setdefault("mimic", mimic)
        if given != mimic:
            raise self.xml.error(
                element,
                ("joints", follower, "mimic"),
                f"follows '{mimic['joint']}' here and something else in <mimic>; leave one out",
            )


_EFFECT = "it changes the motion in Gazebo, and not here"
_WEIGHT = "it has its weight here"


def _changes_motion(element: LocatedElement) -> bool:
    neutral = _MECHANICAL.get(element.tag)
    return neutral is not None and element.text.strip().lower() not in neutral
