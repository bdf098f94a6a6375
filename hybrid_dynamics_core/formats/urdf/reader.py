"""URDF -> links and joints of a document. Fixed joints are merged later, like any others.

Visuals, collisions, materials, transmissions and what simulators add are omitted. Joints may be
replaced: a spherical joint becomes three revolute joints NAME_X, NAME_Y, NAME_Z whose axes meet, a
universal joint two.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...description.document import Document, KeyPath
from ...ground.suggestions import suggestion
from ..extras_reader import TAG
from ..xml.located_xml import LocatedElement, read_xml
from ..xml.reader import XmlReader
from .plus_reader import add_extras, add_loops, has_loops
from .replacements import add_replacement

JOINT_TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
_COVERED = frozenset({"link", "joint", "loop", "coupling", TAG})
_WITHOUT_EFFECT = frozenset({"material", "transmission", "gazebo"})
_INERTIA_KEYS = ("xx", "yy", "zz", "xy", "xz", "yz")
_X_AXIS = (1.0, 0.0, 0.0)
_MAX_LISTED = 8  # links in a message


def add_urdf(
    document: Document,
    file: Path,
    replacements: Mapping[str, str],
    replacements_path: KeyPath,
    is_alone: bool = False,
) -> str:
    """Add links, joints and loops of a URDF(+) to a document; its root link becomes the base.

    Args:
        document: to which they are added.
        file: the URDF.
        replacements: what joints become by name: SPHERICAL, FIXED, UJOINT_XY and the like.
        replacements_path: where these are written.
        is_alone: no other file says which joints are driven, and what else URDF has no words for.

    Returns:
        The name of the robot.

    Raises:
        DescriptionError: the file is wrong, or says what is not covered.
    """
    root = read_xml(file)
    xml = XmlReader(file, root)
    reader = _UrdfReader(document, xml)
    reader.check_root()
    joint_names = [element.get("name") for element in root.all("joint")]
    for joint in replacements:
        if joint not in joint_names:
            hint = suggestion(joint, joint_names)
            raise document.error(
                (*replacements_path, joint), f"there is no joint '{joint}' in {file.name}{hint}"
            )
    for element in root.all("link"):
        reader.add_link(element)
    for element in root.all("joint"):
        reader.add_joint(element, replacements, replacements_path)
    reader.add_base()
    add_loops(document, xml)
    if is_alone and has_loops(root):
        add_extras(document, xml)
    return root.get("name", file.stem)


def expand_urdf(document: Document, is_alone: bool = False) -> str:
    """Add the URDF file that a description names, from the folder of the description.

    Args:
        document: the description.
        is_alone: no other file says which joints are driven, and what else URDF has no words for.

    Returns:
        The name that the URDF gives the robot; empty where the description names none.

    Raises:
        DescriptionError: the file is not there or wrong, or says what is not covered.
    """
    entry = document.data.pop("urdf", None)
    if entry is None:
        return ""
    key: KeyPath = ("urdf", "file")
    if isinstance(entry, str):
        entry = {"file": entry}
        key = ("urdf",)
    folder = Path()
    if document.file:
        folder = Path(document.file).parent
    file = folder / entry["file"]
    if not file.is_file():
        raise document.error(
            key, f"there is no file {file}; the path starts at the folder of this file"
        )
    return add_urdf(document, file, entry.get("replace", {}), ("urdf", "replace"), is_alone)


class _UrdfReader:
    def __init__(self, document: Document, xml: XmlReader) -> None:
        self.document = document
        self.xml = xml
        self.children: set[str] = set()  # links that hang on a joint

    def check_root(self) -> None:
        """Refuse what is no URDF, and note what is omitted."""
        root = self.xml.root
        if root.tag == "sdf":
            raise self.xml.error(root, (), "is SDFormat, not URDF; load() reads it")
        if root.tag != "robot":
            raise self.xml.error(root, (), f"<{root.tag}> is not a URDF; its root is <robot>")
        if _is_xacro(root):
            raise self.xml.error(root, (), "is a xacro file; run it through xacro first")
        others: dict[str, LocatedElement] = {}
        for child in root.children:
            if child.tag not in _COVERED and child.tag not in _WITHOUT_EFFECT:
                others[child.tag] = child
        for tag, child in others.items():
            if tag == "loop_joint":
                raise self.xml.error(child, (tag,), "is not URDF; give the loop under closures")
            self.document.notes.append(f"{self.xml.file.name}: <{tag}> is left out")

    # -- links

    def add_link(self, element: LocatedElement) -> None:
        name = self.xml.name(element, "links")
        path = ("links", name)
        entry: dict[str, Any] = {}
        inertial = element.first("inertial")
        if inertial is not None:
            entry = self.body(inertial, path)
            for key in entry:
                self.locate((*path, key), inertial)
        self.document.add_located(path, entry, self.xml.file, element.line)
        self.document.rounded_links.add(name)

    def body(self, inertial: LocatedElement, path: KeyPath) -> dict[str, Any]:
        """Mass, centre of mass and inertia of a link."""
        mass = inertial.first("mass")
        if mass is None:
            raise self.xml.error(inertial, path, "<inertial> has no <mass>")
        origin = self.xml.origin(inertial, path, self.document)
        entry: dict[str, Any] = {
            "mass": self.xml.number(mass, "value", (*path, "mass")),
            "com": origin["xyz"],
        }
        inertia = inertial.first("inertia")
        if inertia is not None:
            tensor: dict[str, Any] = {}
            for key in _INERTIA_KEYS:
                tensor[key] = self.xml.number(inertia, f"i{key}", (*path, "inertia"), 0.0)
            tensor["frame"] = {"rpy": origin["rpy"]}
            entry["inertia"] = tensor
        return entry

    # -- joints

    def add_joint(
        self,
        element: LocatedElement,
        replacements: Mapping[str, str],
        replacements_path: KeyPath,
    ) -> None:
        name = self.xml.name(element, "joints")
        path = ("joints", name)
        urdf_type = self.joint_type(element, path)
        entry: dict[str, Any] = {
            "type": JOINT_TYPES[urdf_type],
            "parent": self.linked(element, "parent", path),
            "child": self.linked(element, "child", path),
            "origin": self.xml.origin(element, path, self.document),
        }
        self.children.add(entry["child"])
        if name in replacements:
            kind = replacements[name].upper()
            written = (*replacements_path, name)
            add_replacement(
                self.document, (self.xml.file, element.line), name, entry, kind, written
            )
            return
        if urdf_type != "fixed":
            self.add_motion(element, entry, urdf_type, path)
        self.document.add_located(path, entry, self.xml.file, element.line)

    def joint_type(self, element: LocatedElement, path: KeyPath) -> str:
        urdf_type = element.get("type")
        if urdf_type in JOINT_TYPES:
            return urdf_type
        hint = ""
        if urdf_type == "floating":
            hint = "; a base that moves freely is not covered: leave the joint out, or fix the base"
        raise self.xml.error(
            element,
            (*path, "type"),
            f"is '{urdf_type}'; expected one of {', '.join(JOINT_TYPES)}{hint}",
        )

    def add_motion(
        self, element: LocatedElement, entry: dict[str, Any], urdf_type: str, path: KeyPath
    ) -> None:
        """Add axis, limits, friction and mimic of a joint that moves."""
        self.add_axis(element, entry, path)
        if urdf_type != "continuous":
            self.add_limits(element, entry, path)
        self.add_friction(element, entry, path)
        self.add_mimic(element, entry, path)

    def add_axis(self, joint: LocatedElement, entry: dict[str, Any], path: KeyPath) -> None:
        entry["axis"] = list(_X_AXIS)
        axis = joint.first("axis")
        if axis is not None:
            key = (*path, "axis")
            entry["axis"] = self.xml.numbers(axis, "xyz", 3, key)
            self.locate(key, axis)

    def add_limits(self, joint: LocatedElement, entry: dict[str, Any], path: KeyPath) -> None:
        limit = joint.first("limit")
        if limit is None:
            return
        key = (*path, "limits")
        self.locate(key, limit)
        lower = self.xml.number(limit, "lower", key, 0.0)
        upper = self.xml.number(limit, "upper", key, 0.0)
        if lower or upper:  # both 0 is what exporters write for no limits
            entry["limits"] = [lower, upper]

    def add_friction(self, joint: LocatedElement, entry: dict[str, Any], path: KeyPath) -> None:
        dynamics = joint.first("dynamics")
        if dynamics is None:
            return
        key = (*path, "friction")
        self.locate(key, dynamics)
        entry["friction"] = {
            "viscous": self.xml.number(dynamics, "damping", key, 0.0),
            "coulomb": self.xml.number(dynamics, "friction", key, 0.0),
        }

    def add_mimic(self, joint: LocatedElement, entry: dict[str, Any], path: KeyPath) -> None:
        mimic = joint.first("mimic")
        if mimic is None:
            return
        key = (*path, "mimic")
        self.locate(key, mimic)
        entry["mimic"] = {
            "joint": mimic.get("joint"),
            "multiplier": self.xml.number(mimic, "multiplier", key, 1.0),
            "offset": self.xml.number(mimic, "offset", key, 0.0),
        }

    def linked(self, joint: LocatedElement, tag: str, path: KeyPath) -> str:
        """The parent or child link of a joint."""
        key = (*path, tag)
        end = joint.first(tag)
        if end is None or not end.get("link"):
            raise self.xml.error(joint, key, f"has no <{tag} link=...>")
        self.locate(key, end)
        return end.get("link")

    # -- base

    def add_base(self) -> None:
        """Make the one link that is no child the base."""
        links = [element.get("name") for element in self.xml.root.all("link")]
        roots = [name for name in links if name not in self.children]
        if len(roots) == 1:
            self.document.data.setdefault("base", roots[0])
            return
        listed = ", ".join(roots[:_MAX_LISTED])
        problem = f"{len(roots)} links are without a parent ({listed}); a robot has one"
        if links and not roots:
            problem = (
                "the joints form a cycle, no link is without a parent; cut it and give the loop"
                " under closures"
            )
        raise self.xml.error(self.xml.root, (), problem)

    def locate(self, path: KeyPath, element: LocatedElement) -> None:
        """Errors at a path point at an element."""
        self.document.set_location(path, self.xml.file, element.line)


def _is_xacro(root: LocatedElement) -> bool:
    has_namespace = any(name.startswith("xmlns:xacro") for name in root.attributes)
    has_elements = any(child.tag.startswith("xacro:") for child in root.children)
    return has_namespace and has_elements
