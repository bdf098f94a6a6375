"""The tree of an MJCF file: bodies as links, with their joints, masses and sites."""

from __future__ import annotations

from dataclasses import dataclass

from ...description.document import Data
from ...description.geometry import Transform, rpy_of
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .joints import Freedom, JointReader, MjcfJoint
from .masses import MassReader, PlacedShape
from .poses import PoseReader

WORLD = "world"
_JOINTS = ("joint", "freejoint")

Placed = tuple[LocatedElement, Transform]  # with the frame around it, in its body


@dataclass(frozen=True)
class Site:
    """A site.

    Attributes:
        link: on which it stands.
        pose: on that link.
        element: that gives it.
    """

    link: str
    pose: Transform
    element: LocatedElement


class BodyReader:
    """Reads the bodies of a file.

    Attributes:
        drawn: pose of every link in the world, as the file draws it.
        joints: in the order in which MuJoCo numbers them.
        sites: by name.
    """

    def __init__(self, xml: XmlReader, poses: PoseReader) -> None:
        self.xml = xml
        self.poses = poses
        self.masses = MassReader(xml, poses)
        self.joint_reader = JointReader(xml, poses)
        self.drawn: dict[str, Transform] = {WORLD: Transform()}
        self.joints: list[MjcfJoint] = []
        self.sites: dict[str, Site] = {}
        self.names = _names_of(xml.root)
        self.unnamed: dict[str, list[str]] = {}  # names given here, by tag

    def read(self) -> None:
        """Add all bodies to the document."""
        for world in self.xml.root.all("worldbody"):
            self._add_content(self._content(world, Transform()), WORLD, is_static=True)
        for tag, names in self.unnamed.items():
            self.xml.document.notes.append(
                f"<{tag}> without a name, called here: {', '.join(names)}"
            )

    def _add_content(self, content: list[Placed], link: str, is_static: bool) -> None:
        for element, around in content:
            if element.tag == "site":
                self._add_site(element, around, link)
        for element, around in content:
            if element.tag == "body":
                self._add_body(element, around, link, is_static)

    def _add_body(
        self, element: LocatedElement, around: Transform, parent: str, is_static: bool
    ) -> None:
        """Add a body as a link on a chain of joints, and all that stands on it."""
        link = self._name(element, "body", f"body{len(self.drawn)}")
        path = ("links", link)
        pose = around @ self.poses.pose(element, path)
        self.drawn[link] = self.drawn[parent] @ pose
        content = self._content(element, Transform())
        joints = [placed for placed in content if placed[0].tag in _JOINTS]
        is_static = is_static and not joints
        self.xml.add(path, self._mass(element, content, path, is_static), element)
        self._add_joints(element, joints, (parent, link), pose)
        self._add_content(content, link, is_static)

    def _mass(
        self, element: LocatedElement, content: list[Placed], path: tuple[str, str], is_static: bool
    ) -> Data:
        geoms: list[PlacedShape] = []
        if not is_static:  # shapes of what stands still have no mass that matters
            geoms = [placed for placed in content if placed[0].tag == "geom"]
        return self.masses.entry(element, geoms, path)

    # -- joints

    def _add_joints(
        self, body: LocatedElement, joints: list[Placed], links: tuple[str, str], pose: Transform
    ) -> None:
        """Add the joints between two links in a row; massless links stand between them."""
        parent, link = links
        if not joints:
            entry = {"type": "fixed", "parent": parent, "child": link, "origin": pose_entry(pose)}
            self.xml.add(("joints", f"{link}_fixed"), entry, body)
            return
        chain: list[tuple[Freedom, LocatedElement]] = []
        start = pose
        for element, around in joints:
            joint = self._read_joint(element, around, pose)
            if joint.type == "free":
                self._check_free(element, parent, len(joints))
                start = Transform()
            chain.extend((freedom, element) for freedom in joint.freedoms)
        for freedom, element in chain[:-1]:
            massless = self._free_name("body", f"{freedom.name}_link")
            self.xml.add(("links", massless), {}, element)
            self._add_freedom(freedom, element, (parent, massless), start)
            start = freedom.after
            parent = massless
        last, element = chain[-1]
        self._add_freedom(last, element, (parent, link), start)
        if not last.after.is_identity():
            frames = self.xml.document.section("frames")
            frames[link] = {"link": link, **pose_entry(last.after)}

    def _read_joint(self, element: LocatedElement, around: Transform, pose: Transform) -> MjcfJoint:
        name = self._name(element, element.tag, f"joint{len(self.joints)}")
        joint = self.joint_reader.read(element, name, around, pose)
        self.joints.append(joint)
        return joint

    def _add_freedom(
        self,
        freedom: Freedom,
        element: LocatedElement,
        links: tuple[str, str],
        start: Transform,
    ) -> None:
        """Add one joint that begins at a frame of its parent link."""
        parent, child = links
        origin = pose_entry(start @ freedom.before)
        entry = {"parent": parent, "child": child, "origin": origin, **freedom.entry}
        self.xml.add(("joints", freedom.name), entry, element)

    def _check_free(self, joint: LocatedElement, parent: str, count: int) -> None:
        if parent != WORLD or count > 1:
            raise self.xml.error_at(
                joint, "is a free joint; expected it alone, in a body of <worldbody>"
            )

    # -- content

    def _content(self, body: LocatedElement, around: Transform) -> list[Placed]:
        """What stands on a body, with the frame around each; frames of the file are opened."""
        content: list[Placed] = []
        for child in body.children:
            if child.tag == "frame":
                pose = around @ self.poses.pose(child, ("frames", child.get("name")))
                content.extend(self._content(child, pose))
            else:
                content.append((child, around))
        return content

    def _add_site(self, element: LocatedElement, around: Transform, link: str) -> None:
        name = element.get("name")
        if not name:
            self.xml.note(element, "<site> without a name is left out")
            return
        path = ("sites", name)
        if name in self.sites:
            raise self.xml.error_at(element, "has the name of another site; rename one of them")
        pose = around @ self.poses.pose(element, path)
        self.sites[name] = Site(link, pose, element)

    def _name(self, element: LocatedElement, tag: str, default: str) -> str:
        """The name of an element, or one that no other has."""
        name = element.get("name")
        if name:
            return name
        name = self._free_name(tag, default)
        self.unnamed.setdefault(tag, []).append(name)
        return name

    def _free_name(self, tag: str, name: str) -> str:
        """A name that no other element has."""
        kind = "joint" if tag in _JOINTS else tag
        while name in self.names[kind]:
            name += "_"
        self.names[kind].add(name)
        return name


def pose_entry(pose: Transform) -> dict[str, list[float]]:
    """A pose as a description file has it."""
    return {"xyz": pose.translation.tolist(), "rpy": rpy_of(pose.rotation).tolist()}


def _names_of(root: LocatedElement) -> dict[str, set[str]]:
    """Names of bodies and joints anywhere in a file."""
    names: dict[str, set[str]] = {"body": {WORLD}, "joint": set()}
    elements = root.all("worldbody")
    while elements:
        element = elements.pop()
        elements.extend(element.children)
        kind = "joint" if element.tag in _JOINTS else element.tag
        if kind in names and element.get("name"):
            names[kind].add(element.get("name"))
    return names
