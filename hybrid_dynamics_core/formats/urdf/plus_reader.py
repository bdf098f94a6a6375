"""What URDF+ adds to URDF: <loop> and <coupling> beside the tree, `independent` on its joints.

Chignoli et al. (2024), arXiv 2411.19753. A loop joins a frame of its predecessor to one of its
successor.
"""

from __future__ import annotations

from typing import Any

from ...description.defaults import driven_joints
from ...description.document import Document
from ...description.geometry import rotation_with_z_axis, rpy_of, unit_axis
from ...errors import DescriptionError
from ...ground.suggestions import suggestion
from ..extras_reader import TAG, extend
from ..xml.elements import XmlFile
from ..xml.tree import Element

SPHERICAL = "spherical"  # not in URDF+, which has no word for it
HINGES = ("revolute", "continuous")


def has_loops(root: Element) -> bool:
    """Whether a URDF is a URDF+."""
    return any(child.tag in ("loop", "coupling", TAG) for child in root.children)


def add_loops(document: Document, xml: XmlFile) -> None:
    """Closures and followers of a URDF+ whose links and joints the document has."""
    reader = _Loops(document, xml)
    for element in xml.root.all("loop"):
        reader.loop(element)
    for element in xml.root.all("coupling"):
        reader.coupling(element)


def add_rest(document: Document, xml: XmlFile) -> None:
    """Its active joints, and what else it says."""
    document.data["active"] = _Loops(document, xml).independent()
    document.data["active_set"] = "motors"  # no reference is given: one near zero is looked for
    for element in xml.root.all(TAG):
        extend(document, element.text, xml.file, element.line)


class _Loops:
    def __init__(self, document: Document, xml: XmlFile) -> None:
        self.document, self.xml = document, xml

    def error(self, element: Element, problem: str) -> DescriptionError:
        return self.xml.error(
            element, (f"{element.tag}s", element.attributes.get("name", "")), problem
        )

    def loop(self, element: Element) -> None:
        name, kind = self.xml.name(element, "loops"), element.attributes.get("type", "")
        if kind not in (*HINGES, SPHERICAL, "fixed"):
            problem = (
                f"is a loop of type '{kind}'; expected revolute, continuous, fixed or {SPHERICAL}"
            )
            raise self.error(element, f"{problem}; cut the loop at a joint of these types")
        entry: dict[str, Any] = {
            "kind": "axis" if kind in HINGES else "frame" if kind == "fixed" else "point"
        }
        axis = element.first("axis")
        z = (
            [1.0, 0.0, 0.0]
            if axis is None
            else self.xml.numbers(axis, "xyz", 3, ("loops", name, "axis"))
        )
        places: dict[str, Any] = {}
        for tag in ("predecessor", "successor"):
            end = self.end(element, tag)
            pose = self.xml.origin(end, ("loops", name, tag), self.document)
            place: Any = [pose, {"rpy": rpy_to(z)}] if entry["kind"] == "axis" else pose
            if end.attributes["link"] in places:
                raise self.error(element, "has both ends on one link")
            places[end.attributes["link"]] = place
        self.document.add_located(
            ("closures", name), {**entry, "between": places}, self.xml.file, element.line
        )

    def end(self, element: Element, tag: str) -> Element:
        end = element.first(tag)
        if end is None or not end.attributes.get("link"):
            raise self.error(element, f"has no <{tag} link=...>")
        known = list(self.document.section("links"))
        if end.attributes["link"] not in known:
            link = end.attributes["link"]
            raise self.error(end, f"<{tag}>: there is no link '{link}'{suggestion(link, known)}")
        return end

    def coupling(self, element: Element) -> None:
        """q_successor = ratio q_predecessor, each the one joint between its link and the last one they share."""
        name = self.xml.name(element, "couplings")
        ratio = element.first("ratio")
        if ratio is None:
            raise self.error(element, "has no <ratio value=...>")
        paths = [
            self.path(self.end(element, tag).attributes["link"])
            for tag in ("predecessor", "successor")
        ]
        shared = set(paths[0]) & set(paths[1])
        source, own = ([joint for joint in path if joint not in shared] for path in paths)
        if len(source) != 1 or len(own) != 1:
            told = f"couples {', '.join(source) or 'no joint'} to {', '.join(own) or 'no joint'}"
            raise self.error(element, f"{told}; one joint that follows one other is covered")
        value = self.xml.numbers(ratio, "value", 1, ("couplings", name, "ratio"))[0]
        mimic = {"joint": source[0], "multiplier": value, "offset": 0.0}
        self.document.section("joints")[own[0]].setdefault("mimic", mimic)

    def path(self, link: str) -> list[str]:
        """Moving joints from a link to the base."""
        above = {
            joint["child"]: (name, joint) for name, joint in self.document.section("joints").items()
        }
        path: list[str] = []
        while link in above and len(path) <= len(above):
            name, joint = above[link]
            path += [name] if joint["type"] != "fixed" else []
            link = joint["parent"]
        return path

    def independent(self) -> list[str]:
        told = {
            e.attributes.get("name", ""): e.attributes.get("independent", "true")
            for e in self.xml.root.all("joint")
        }
        active = [name for name in driven_joints(self.document) if told[name] in ("true", "True")]
        if not active:
            raise self.xml.error(
                self.xml.root,
                ("joints",),
                'no joint is independent="true"; name the driven joints so',
            )
        return active


def rpy_to(z: list[float]) -> list[float]:
    """Roll, pitch, yaw of a frame whose z axis is a vector of any length."""
    return [float(angle) for angle in rpy_of(rotation_with_z_axis(unit_axis(z)))]
