"""URDF -> links and joints of a document. Fixed joints are merged later, like any others.

Visuals, collisions, materials, transmissions and what simulators add are left out. Joints may be
replaced on the way: a spherical joint is three revolute joints NAME_X, NAME_Y, NAME_Z whose axes
meet, a universal joint two.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...description.document import Document, KeyPath
from ...ground.suggestions import suggestion
from ..extras_reader import TAG
from ..xml.elements import XmlFile
from ..xml.tree import Element, read_xml
from .plus_reader import add_loops, add_rest, has_loops

JOINT_TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
SILENT = frozenset({"link", "joint", "material", "transmission", "gazebo", "loop", "coupling", TAG})
_AXES = re.compile(r"^U(?:JOINT|NIVERSAL)_([XYZ])([XYZ])$")
REPLACEMENTS = "SPHERICAL, FIXED, UJOINT_XY and the like"


def add_urdf(
    document: Document,
    file: Path,
    replace: Mapping[str, str],
    replace_path: KeyPath,
    alone: bool = False,
) -> str:
    """Add links, joints and loops of a URDF(+) to a document; its root link becomes the base. Returns the robot's name.

    `replace`: joint -> SPHERICAL, FIXED, UJOINT_XY, ...; `replace_path`: where that is written;
    `alone`: no other file says which joints are driven, and what else a URDF has no words for.
    """
    root = read_xml(file)
    reader = _Urdf(document, file, root)
    reader.check_root()
    for joint in replace:
        known = [element.attributes.get("name", "") for element in root.all("joint")]
        if joint not in known:
            problem = f"there is no joint '{joint}' in {file.name}{suggestion(joint, known)}"
            raise document.error((*replace_path, joint), problem)
    for link in root.all("link"):
        reader.link(link)
    for joint_element in root.all("joint"):
        reader.joint(joint_element, replace, replace_path)
    reader.base()
    add_loops(document, reader)
    if alone and has_loops(root):
        add_rest(document, reader)
    return root.attributes.get("name", file.stem)


class _Urdf(XmlFile):
    def __init__(self, document: Document, file: Path, root: Element) -> None:
        super().__init__(file, root)
        self.document = document
        self.children: dict[str, str] = {}

    def check_root(self) -> None:
        """Refuse what is no URDF, and note what is left out."""
        if self.root.tag == "sdf":
            raise self.error(self.root, (), "is SDFormat, not URDF; load() reads it")
        if self.root.tag != "robot":
            raise self.error(self.root, (), f"<{self.root.tag}> is not a URDF; its root is <robot>")
        if any(name.startswith("xmlns:xacro") for name in self.root.attributes) and any(
            child.tag.startswith("xacro:") for child in self.root.children
        ):
            raise self.error(self.root, (), "is a xacro file; run it through xacro first")
        others = {child.tag: child for child in self.root.children if child.tag not in SILENT}
        for tag, child in others.items():
            if tag == "loop_joint":
                raise self.error(child, (tag,), "is not URDF; give the loop under closures")
            self.document.notes.append(f"{self.file.name}: <{tag}> is left out")

    # -- links

    def link(self, element: Element) -> None:
        name = self.name(element, "links")
        path = ("links", name)
        entry: dict[str, Any] = {}
        inertial = element.first("inertial")
        if inertial is not None:
            entry = self.inertial(inertial, path)
            for key in entry:
                self.document.set_location((*path, key), self.file, inertial.line)
        self.document.add_located(path, entry, self.file, element.line)
        self.document.rounded_links.add(name)

    def inertial(self, element: Element, path: KeyPath) -> dict[str, Any]:
        mass = element.first("mass")
        if mass is None:
            raise self.error(element, path, "<inertial> has no <mass>")
        origin = self.origin(element, path, self.document)
        entry: dict[str, Any] = {
            "mass": self.numbers(mass, "value", 1, (*path, "mass"))[0],
            "com": origin["xyz"],
        }
        inertia = element.first("inertia")
        if inertia is not None:
            moments = {
                key: self.numbers(inertia, f"i{key}", 1, (*path, "inertia"), [0.0])[0]
                for key in ("xx", "yy", "zz", "xy", "xz", "yz")
            }
            entry["inertia"] = {**moments, "frame": {"rpy": origin["rpy"]}}
        return entry

    # -- joints

    def joint(self, element: Element, replace: Mapping[str, str], replace_path: KeyPath) -> None:
        name = self.name(element, "joints")
        path = ("joints", name)
        kind = element.attributes.get("type", "")
        if kind not in JOINT_TYPES:
            free = "; a base that moves freely is not covered: leave the joint out, or fix the base"
            hint = free if kind == "floating" else ""
            problem = f"is '{kind}'; expected one of {', '.join(JOINT_TYPES)}{hint}"
            raise self.error(element, (*path, "type"), problem)
        entry: dict[str, Any] = {
            "type": JOINT_TYPES[kind],
            "parent": self.end(element, "parent", path),
            "child": self.end(element, "child", path),
            "origin": self.origin(element, path, self.document),
        }
        self.children.setdefault(entry["child"], name)
        if name in replace:
            self.replaced(element, name, entry, replace[name].upper(), (*replace_path, name))
            return
        if kind != "fixed":
            self.moving(element, entry, kind, path)
        self.document.add_located(path, entry, self.file, element.line)

    def moving(self, element: Element, entry: dict[str, Any], kind: str, path: KeyPath) -> None:
        axis = element.first("axis")
        entry["axis"] = (
            [1.0, 0.0, 0.0] if axis is None else self.numbers(axis, "xyz", 3, (*path, "axis"))
        )
        if axis is not None:
            self.document.set_location((*path, "axis"), self.file, axis.line)
        limit = element.first("limit")
        if limit is not None and kind != "continuous":
            self.document.set_location((*path, "limits"), self.file, limit.line)
            lower, upper = (
                self.numbers(limit, key, 1, (*path, "limits"), [0.0])[0]
                for key in ("lower", "upper")
            )
            if lower or upper:  # both 0 is what exporters write for no limits
                entry["limits"] = [lower, upper]
        self.friction(element, entry, path)
        mimic = element.first("mimic")
        if mimic is not None:
            self.document.set_location((*path, "mimic"), self.file, mimic.line)
            factor, offset = (
                self.numbers(mimic, key, 1, (*path, "mimic"), [default])[0]
                for key, default in (("multiplier", 1.0), ("offset", 0.0))
            )
            source = mimic.attributes.get("joint", "")
            entry["mimic"] = {"joint": source, "multiplier": factor, "offset": offset}

    def friction(self, element: Element, entry: dict[str, Any], path: KeyPath) -> None:
        told = element.first("dynamics")
        if told is None:
            return
        self.document.set_location((*path, "friction"), self.file, told.line)
        keys = (("viscous", "damping"), ("coulomb", "friction"))
        values = {
            key: self.numbers(told, name, 1, (*path, "friction"), [0.0])[0] for key, name in keys
        }
        entry["friction"] = values

    def replaced(
        self, element: Element, name: str, entry: dict[str, Any], kind: str, written: KeyPath
    ) -> None:
        """Joints that stand in place of one: about the axes of its frame, massless links between."""
        universal = _AXES.match(kind)
        if kind == "FIXED":
            self.document.add_located(
                ("joints", name), {**entry, "type": "fixed"}, self.file, element.line
            )
            self.document.notes.append(f"{name}: fixed at its zero")
            return
        if kind != "SPHERICAL" and (universal is None or universal[1] == universal[2]):
            raise self.document.error(written, f"is '{kind}'; expected {REPLACEMENTS}")
        letters = "XYZ" if universal is None else f"{universal[1]}{universal[2]}"
        parent, origin = entry["parent"], entry["origin"]
        for letter in letters:
            own = f"{name}_{letter}"
            child = entry["child"] if letter == letters[-1] else own
            if child == own:
                self.document.add_located(("links", own), {}, self.file, element.line)
            joint = {
                "type": "revolute",
                "parent": parent,
                "child": child,
                "origin": origin,
                "axis": letter.lower(),
            }
            self.document.add_located(("joints", own), joint, self.file, element.line)
            parent, origin = child, {}

    def end(self, element: Element, which: str, path: KeyPath) -> str:
        child = element.first(which)
        link = "" if child is None else child.attributes.get("link", "")
        if child is None or not link:
            raise self.error(element, (*path, which), f"has no <{which} link=...>")
        self.document.set_location((*path, which), self.file, child.line)
        return link

    # -- values

    def base(self) -> None:
        """The one link that is no child is the base."""
        links = [element.attributes["name"] for element in self.root.all("link")]
        roots = [name for name in links if name not in self.children]
        if len(roots) != 1:
            problem = (
                "the joints form a cycle, no link is without a parent; cut it and give the loop"
                " under closures"
                if links and not roots
                else (
                    f"{len(roots)} links are without a parent ({', '.join(roots[:8])}); a robot"
                    " has one"
                )
            )
            raise self.error(self.root, (), problem)
        self.document.data.setdefault("base", roots[0])


def expand_urdf(document: Document, alone: bool = False) -> str:
    """The URDF file that a description names, from the folder of the description. Returns the name it gives.

    `alone`: as of `add_urdf`.
    """
    entry = document.data.pop("urdf", None)
    if entry is None:
        return ""
    told: dict[str, Any] = {"file": entry} if isinstance(entry, str) else entry
    key: KeyPath = ("urdf",) if isinstance(entry, str) else ("urdf", "file")
    file = (Path(document.file).parent if document.file else Path()) / told["file"]
    if not file.is_file():
        raise document.error(
            key, f"there is no file {file}; the path starts at the folder of this file"
        )
    return add_urdf(document, file, told.get("replace", {}), ("urdf", "replace"), alone)
