"""What URDF+ adds to URDF: <loop> and <coupling> beside the tree, `independent` on its joints.

Chignoli et al. (2024), arXiv 2411.19753. A loop joins a frame of its predecessor to one of its
successor.
"""

from __future__ import annotations

from typing import Any

from ...description.defaults import driven_joints
from ...description.document import Data
from ...description.geometry import rpy_to_axis, unit_axis
from ...ground.arrays import Array
from ...ground.suggestions import suggestion
from ..extras_reader import TAG, read_extras
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

SPHERICAL = "spherical"  # not in URDF+, which has no word for it
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


def add_extras(xml: XmlReader) -> None:
    """Add the active joints of a URDF+, and what it says beyond the format."""
    document = xml.document
    document.data["active"] = _PlusReader(xml).independent_joints()
    document.data["active_set"] = "motors"  # no reference is given: one near zero is searched for
    for element in xml.root.all(TAG):
        read_extras(document, element.text, xml.file, element.line)


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
        """Read q_successor = ratio q_predecessor as a follower.

        Each coordinate is that of the one joint between its link and the last link they share.
        """
        name = self.xml.name(element, "couplings")
        ratio = element.first("ratio")
        if ratio is None:
            raise self.xml.error_at(element, "has no <ratio value=...>")
        source_path, follower_path = (self.joints_below(self.end(element, tag)) for tag in _ENDS)
        sources = [joint for joint in source_path if joint not in follower_path]
        followers = [joint for joint in follower_path if joint not in source_path]
        if len(sources) != 1 or len(followers) != 1:
            one = ", ".join(sources) or "no joint"
            other = ", ".join(followers) or "no joint"
            raise self.xml.error_at(
                element, f"couples {one} to {other}; one joint that follows one other is covered"
            )
        multiplier = self.xml.number(ratio, "value", ("couplings", name, "ratio"))
        mimic = {"joint": sources[0], "multiplier": multiplier, "offset": 0.0}
        follower = self.document.section("joints")[followers[0]]
        follower.setdefault("mimic", mimic)

    def joints_below(self, end: LocatedElement) -> list[str]:
        """Moving joints from a link to the base."""
        link = end.get("link")
        joints = self.document.section("joints")
        joint_to = {joint["child"]: name for name, joint in joints.items()}
        path: list[str] = []
        while link in joint_to and len(path) <= len(joint_to):
            name = joint_to[link]
            if joints[name]["type"] != "fixed":
                path.append(name)
            link = joints[name]["parent"]
        return path

    def independent_joints(self) -> list[str]:
        independent: set[str] = set()
        for element in self.xml.root.all("joint"):
            if element.get("independent", "true") in ("true", "True"):
                independent.add(element.get("name"))
        active = [name for name in driven_joints(self.document) if name in independent]
        if not active:
            raise self.xml.error(
                self.xml.root,
                ("joints",),
                'no joint is independent="true"; name the driven joints so',
            )
        return active
