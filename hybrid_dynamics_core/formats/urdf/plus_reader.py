"""Additions of URDF+ to URDF: <loop> and <coupling>, and `independent` of joints.

Chignoli et al. (2024), arXiv 2411.19753. A loop ties a frame on its predecessor to one on its
successor.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...description.defaults import driven_joints
from ...description.document import Data, Document
from ...description.followers import mimic_entry
from ...description.geometry import rpy_to_axis, unit_axis
from ...ground.arrays import Array
from ...ground.suggestions import suggestion
from ..extras_reader import TAG, read_extras
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .couplings import Hung, coupled_joints

SPHERICAL = "spherical"  # an extension of this library to URDF+
_LOOP_KINDS = {
    "revolute": "axis",
    "continuous": "axis",
    "fixed": "frame",
    SPHERICAL: "point",
}
_ENDS = ("predecessor", "successor")


def has_loops(root: LocatedElement) -> bool:
    """Whether a URDF is a URDF+."""
    return any(child.tag in ("loop", "coupling", TAG) for child in root.children)


def add_loops(xml: XmlReader) -> None:
    """Add closures and followers of a URDF+ whose links and joints the document has."""
    reader = _PlusReader(xml)
    for element in xml.root.all("loop"):
        reader.add_loop(element)
    for element in xml.root.all("coupling"):
        reader.add_coupling(element)


def note_untied(xml: XmlReader) -> None:
    """Note joints that are written as not independent, in a file without loops and couplings."""
    if not has_loops(xml.root) and not xml.document.section("closures"):
        _PlusReader(xml).note_untied()


def add_extras(xml: XmlReader) -> None:
    """Add the active joints of a URDF+, and its extras."""
    document = xml.document
    document.data["active"] = _PlusReader(xml).independent_joints()
    document.data["active_set"] = "motors"  # no reference is given: one near zero is searched for
    for element in xml.root.all(TAG):
        read_extras(document, element.text, xml.file, element.line)


def add_motors(document: Document, motors: Sequence[str]) -> None:
    """Make joints with transmissions active or, if there are none, all that follow no other.

    Args:
        document: document of a URDF with loops that does not say which joints are independent.
        motors: joints with a drive.
    """
    followers = document.section("joints")
    driven = [name for name in motors if "mimic" not in followers[name]]
    if not driven:
        driven = driven_joints(document)
        document.notes.append(
            "the file does not say what is driven; independent joints are taken in its order"
        )
    document.data["active"] = driven
    document.data["active_set"] = "motors"  # no reference is given: one near zero is searched for


class _PlusReader:
    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.document = xml.document

    def add_loop(self, element: LocatedElement) -> None:
        name = self.xml.name(element, "loops")
        loop_type = element.get("type")
        if loop_type not in _LOOP_KINDS:
            raise self.xml.error_at(
                element,
                f"is a loop of type '{loop_type}'; expected revolute, continuous, fixed or"
                f" {SPHERICAL}; cut the loop at a joint of these types",
            )
        kind = _LOOP_KINDS[loop_type]
        direction = self.axis(element, name)
        between: Data = {}
        for tag in _ENDS:
            end = self.end(element, tag)
            link = end.get("link")
            pose: Any = self.xml.origin(end, ("loops", name, tag))
            if kind == "axis":
                pose = [pose, {"rpy": rpy_to_axis(direction)}]
            if link in between:
                raise self.xml.error_at(element, "has both ends on one link")
            between[link] = pose
        entry = {"kind": kind, "between": between}
        self.xml.add(("closures", name), entry, element)

    def axis(self, element: LocatedElement, name: str) -> Array:
        """The unit vector (3,) along the axis of a loop."""
        axis = element.first("axis")
        if axis is None:
            return unit_axis("x")
        key = ("loops", name, "axis")
        direction = self.xml.numbers(axis, "xyz", 3, key)
        try:
            return unit_axis(direction)
        except ValueError as error:
            raise self.xml.error(axis, key, str(error)) from error

    def end(self, element: LocatedElement, tag: str) -> LocatedElement:
        end = element.first(tag)
        if end is None or not end.get("link"):
            raise self.xml.error_at(element, f"has no <{tag} link=...>")
        link = end.get("link")
        links = self.document.section("links")
        if link not in links:
            hint = suggestion(link, links)
            raise self.xml.error_at(end, f"<{tag}>: there is no link '{link}'{hint}")
        return end

    def add_coupling(self, element: LocatedElement) -> None:
        """Read a <coupling> as a follower."""
        name = self.xml.name(element, "couplings")
        ratio_element = element.first("ratio")
        if ratio_element is None:
            raise self.xml.error_at(element, "has no <ratio value=...>")
        ratio = self.xml.number(ratio_element, "value", ("couplings", name, "ratio"))
        predecessor, successor = (self.end(element, tag).get("link") for tag in _ENDS)
        if predecessor == successor:
            raise self.xml.error_at(element, "has both ends on one link")
        tied = coupled_joints(self.hung(), predecessor, successor)
        coefficients = dict.fromkeys(tied.predecessor, -ratio)
        for joint in tied.successor:
            coefficients[joint] = coefficients.get(joint, 0.0) + 1.0
        coefficients = {joint: value for joint, value in coefficients.items() if value}
        if len(coefficients) < 2:
            listed = ", ".join(coefficients) or "no joint"
            raise self.xml.error_at(element, f"ties {listed}; expected two joints or more")
        order = [*tied.successor, *tied.predecessor]
        self.add_follower(element, order, coefficients)

    def add_follower(
        self, element: LocatedElement, order: list[str], coefficients: Mapping[str, float]
    ) -> None:
        """Add a follower from the equation: sum of coefficient * coordinate = 0.

        It is the first joint in `order` that is not independent, otherwise the first that follows
        no other.
        """
        joints = self.document.section("joints")
        for follower in order:
            if joints[follower].get("mimic") == _solved_for(follower, coefficients):
                return  # <mimic> has it too
        leaders = [joint for joint in order if "mimic" not in joints[joint]]
        dependent = [joint for joint in leaders if self.is_dependent(joint)]
        for follower in [*dependent, *leaders]:
            joints[follower]["mimic"] = _solved_for(follower, coefficients)
            self.xml.locate(("joints", follower, "mimic"), element)
            return
        tied = ", ".join(coefficients)
        raise self.xml.error_at(element, f"ties {tied}, which all follow others already")

    def hung(self) -> dict[str, Hung]:
        """The joint above each link, by link."""
        hung: dict[str, Hung] = {}
        for name, joint in self.document.section("joints").items():
            moves = joint["type"] != "fixed"
            hung[joint["child"]] = Hung(name, joint["parent"], moves)
        return hung

    def note_untied(self) -> None:
        """Note joints that are not independent, and follow no other."""
        joints = self.document.section("joints")
        for element in self.xml.root.all("joint"):
            name = element.get("name")
            joint = joints.get(name, {"type": "fixed"})
            if joint["type"] == "fixed" or "mimic" in joint or not self.is_dependent(name):
                continue
            text = 'joints with independent="false" that nothing in the file ties; taken as free'
            self.xml.collect(element, name, text)

    def is_dependent(self, joint: str) -> bool:
        """Whether a joint has `independent="false"`."""
        for element in self.xml.root.all("joint"):
            if element.get("name") == joint:
                return element.get("independent", "true").lower() != "true"
        return False

    def independent_joints(self) -> list[str]:
        independent: set[str] = set()
        for element in self.xml.root.all("joint"):
            name = element.get("name")
            if not self.is_dependent(name):
                independent.add(name)
        active = [name for name in driven_joints(self.document) if name in independent]
        if not active:
            raise self.xml.error(
                self.xml.root,
                ("joints",),
                'no joint is independent="true"; name the driven joints so',
            )
        return active


def _solved_for(follower: str, coefficients: Mapping[str, float]) -> Data:
    """The entry of a follower, from the equation: sum of coefficient * coordinate = 0."""
    multipliers: dict[str, float] = {}
    for joint, coefficient in coefficients.items():
        if joint != follower:
            multipliers[joint] = -coefficient / coefficients[follower]
    return mimic_entry(multipliers, 0.0)
