"""SDFormat -> a document: links and joints of one model; a joint whose child already has a parent closes a loop.

SDFormat draws the model in one configuration and counts every coordinate from there. Loop joints
are at rest in that configuration, so both ends of their frames are known. http://sdformat.org/spec,
versions 1.7 to 1.12.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ...description.defaults import farthest_link
from ...description.document import Document, KeyPath
from ...description.geometry import Transform, unit_axis
from ...errors import DescriptionError
from ...ground.arrays import Array
from ..extras_reader import TAG, extend
from ..urdf.plus_reader import rpy_to
from ..xml.elements import XmlFile
from ..xml.tree import Element
from .poses import Poses, as_entry
from .vocabulary import check_version, check_words

TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
LOOPS = {"revolute": "axis", "continuous": "axis", "ball": "point", "fixed": "frame"}
BOUND = 1e16  # [rad or m] what SDFormat takes for no limit
GRAVITY = [0.0, 0.0, -9.8]  # of a world that does not say


def sdf_document(root: Element, file: Path) -> Document:
    """The document of an SDFormat file; DescriptionError where it says what is not covered."""
    document = Document(
        {"format": 1, "name": file.stem, "links": {}, "joints": {}, "closures": {}}, file, {}
    )
    reader = _Sdf(document, XmlFile(file, root))
    reader.read()
    rest = [child for child in reader.model.children if child.tag.rpartition(":")[2] == TAG]
    for element in rest:
        extend(document, element.text, file, element.line)
    if not rest and document.data["closures"]:
        document.notes.append(
            "SDFormat does not say what is driven; independent joints are taken in its order"
        )
    if "end_effector" not in document.data:
        document.data["end_effector"] = {"link": farthest_link(document)}
    return document


class _Sdf:
    def __init__(self, document: Document, xml: XmlFile) -> None:
        self.document, self.xml = document, xml
        check_version(xml)
        self.model, self.world = self.find_model()
        check_words(xml, self.model, self.world)
        self.poses = Poses(xml, self.model)

    def find_model(self) -> tuple[Element, Element | None]:
        worlds = self.xml.root.all("world")
        found = [(model, None) for model in self.xml.root.all("model")]
        within = [
            (model, world) for world in worlds for model in world.all("model") if model.all("joint")
        ]
        if len(found) + len(within) != 1:
            problem = f"holds {len(found) + len(within)} models with joints; expected one"
            raise self.xml.error(self.xml.root, ("model",), problem)
        model, world = [*found, *within][0]
        for tag in ("include", "model"):
            if model.all(tag):
                raise self.xml.error(
                    model.all(tag)[0],
                    ("model",),
                    f"has <{tag}> in it, which is not covered; join them first",
                )
        return model, world

    def error(self, element: Element, problem: str) -> DescriptionError:
        return self.xml.error(
            element, (f"{element.tag}s", element.attributes.get("name", "")), problem
        )

    def read(self) -> None:
        data = self.document.data
        data["name"] = self.model.attributes.get("name", data["name"])
        data["source"] = str(self.xml.file.name)
        for link in self.model.all("link"):
            self.link(link)
        base, joints = self.base()
        hung: dict[str, str] = {base: ""}
        for joint in joints:
            child = self.poses.link_of(self.end(joint, "child"), joint)
            if child in hung:
                self.loop(joint)
            else:
                hung[child] = self.xml.name(joint, "joints")
                self.joint(joint)
        for frame in self.model.all("frame"):
            self.frame(frame)
        data["active"] = [
            n
            for n, joint in data["joints"].items()
            if joint["type"] != "fixed" and "mimic" not in joint
        ]
        data["active_set"] = "motors"

    # -- links

    def link(self, element: Element) -> None:
        name = self.xml.name(element, "links")
        path: KeyPath = ("links", name)
        inertial = element.first("inertial")
        entry: dict[str, Any] = {"mass": 1.0, "inertia": {"xx": 1.0, "yy": 1.0, "zz": 1.0}}
        if inertial is None:
            self.document.notes.append(
                f"{name}: no inertial given; SDFormat takes 1 kg and 1 kg m^2"
            )
        else:
            pose = self.poses.read(inertial.first("pose"), path)
            moments = inertial.first("inertia")
            values = {
                key: self.xml.inside(
                    moments and moments.first(f"i{key}"),
                    1,
                    path,
                    [1.0 if key[0] == key[1] else 0.0],
                )[0]
                for key in ("xx", "yy", "zz", "xy", "xz", "yz")
            }
            com = as_entry(pose)
            inertia = {**values, "frame": {"rpy": com["rpy"]}}
            mass = self.xml.inside(inertial.first("mass"), 1, (*path, "mass"), [1.0])[0]
            entry = {"mass": mass, "com": com["xyz"], "inertia": inertia}
        self.document.rounded_links.add(name)
        self.document.add_located(path, entry, self.xml.file, element.line)  # type: ignore[arg-type]

    def base(self) -> tuple[str, list[Element]]:
        """The link that does not move, and the other joints; gravity in its frame."""
        joints = self.model.all("joint")
        grounded = [joint for joint in joints if self.end(joint, "parent") == "world"]
        children = {self.poses.link_of(self.end(joint, "child"), joint) for joint in joints}
        roots = [link for link in self.document.section("links") if link not in children]
        rotation = np.eye(3)  # of the base in the world
        if grounded and (len(grounded) > 1 or self.kind(grounded[0]) != "fixed" or roots):
            base = "world"
            self.document.section("links").setdefault("world", {})
            rest = joints
        elif grounded:
            base = self.poses.link_of(self.end(grounded[0], "child"), grounded[0])
            rotation = self.poses.model.rotation @ self.poses.link(base).rotation
            rest = [joint for joint in joints if joint is not grounded[0]]
        elif len(roots) == 1:
            base, rest = roots[0], joints
            rotation = self.poses.model.rotation @ self.poses.link(base).rotation
            self.document.notes.append(
                f"{base}: not joined to the world; taken as what stands still"
            )
        else:
            problem = (
                f"{len(roots)} links are without a parent ({', '.join(roots[:8])}); a robot has one"
            )
            raise self.xml.error(self.model, ("links",), problem)
        self.document.data["base"] = base
        if self.world is not None:
            gravity = self.xml.inside(self.world.first("gravity"), 3, ("gravity",), GRAVITY)
            self.document.data["gravity"] = [float(v) + 0.0 for v in rotation.T @ gravity]
        return base, rest

    # -- joints

    def kind(self, joint: Element) -> str:
        return joint.attributes.get("type", "")

    def end(self, joint: Element, which: str) -> str:
        end = joint.first(which)
        if end is None or not end.text.strip():
            raise self.error(joint, f"has no <{which}>")
        return end.text.strip()

    def joint(self, element: Element) -> None:
        name, kind = element.attributes["name"], self.kind(element)
        path: tuple[str, str] = ("joints", name)
        if kind not in TYPES:
            raise self.xml.error(
                element, (*path, "type"), f"is '{kind}'; expected one of {', '.join(TYPES)}"
            )
        child = self.poses.link_of(self.end(element, "child"), element)
        parent = self.end(element, "parent")
        parent = "world" if parent == "world" else self.poses.link_of(parent, element)
        place = self.poses.joint(element)
        entry: dict[str, Any] = {"type": TYPES[kind], "parent": parent, "child": child}
        entry["origin"] = as_entry(self.poses.between(parent, place))
        own = self.poses.from_to(place, self.poses.link(child))
        if not own.is_identity():
            self.document.section("frames")[child] = {"link": child, **as_entry(own)}
        if kind != "fixed":
            entry |= self.moving(element, kind, path)
        self.document.add_located(path, entry, self.xml.file, element.line)

    def moving(self, element: Element, kind: str, path: KeyPath) -> dict[str, Any]:
        return {
            "axis": [float(v) for v in self.axis(element, path)],
            **self.held(element, kind, path),
        }

    def held(self, element: Element, kind: str, path: KeyPath) -> dict[str, Any]:
        """What holds a joint back: limits, friction, a spring, another joint that it follows."""
        entry: dict[str, Any] = {}
        axis = element.first("axis")
        limit = axis and axis.first("limit")
        if limit is not None and kind != "continuous":
            limits = [
                self.bound(limit.first(key), sign, path)
                for key, sign in (("lower", -1), ("upper", 1))
            ]
            if any(map(math.isfinite, limits)):
                entry["limits"] = limits
        told = axis and axis.first("dynamics")
        if told is not None:
            values = {
                child.tag: self.xml.inside(child, 1, path, [0.0])[0] for child in told.children
            }
            if values.get("damping") or values.get("friction"):
                entry["friction"] = {
                    "viscous": values.get("damping", 0.0),
                    "coulomb": values.get("friction", 0.0),
                }
            if values.get("spring_stiffness"):
                rest = values.get("spring_reference", 0.0)
                entry["spring"] = {"stiffness": values["spring_stiffness"], "rest": rest}
        mimic = axis and axis.first("mimic")
        if mimic is not None:
            factor, offset, zero = (
                self.xml.inside(mimic.first(key), 1, path, [default])[0]
                for key, default in (("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0))
            )
            source = mimic.attributes.get("joint", "")
            entry["mimic"] = {
                "joint": source,
                "multiplier": factor,
                "offset": offset - factor * zero,
            }
        return entry

    def axis(self, element: Element, path: KeyPath) -> Array:
        """The axis in the frame of the joint."""
        axis = element.first("axis")
        xyz = axis and axis.first("xyz")
        values = self.xml.inside(xyz, 3, (*path, "axis"), [0.0, 0.0, 1.0])
        try:
            unit = unit_axis(values)
        except ValueError as error:
            raise self.xml.error(element, (*path, "axis"), str(error)) from error
        named = xyz.attributes.get("expressed_in", "") if xyz is not None else ""
        return self.poses.turned(unit, named, self.poses.joint(element), element)

    def bound(self, element: Element | None, sign: int, path: KeyPath) -> float:
        text = "" if element is None else element.text.strip().lstrip("+-").lower()
        if element is None or text in ("inf", "infinity"):
            return sign * math.inf
        value = self.xml.inside(element, 1, (*path, "limits"), [0.0])[0]
        return value if abs(value) < BOUND else sign * math.inf

    def loop(self, element: Element) -> None:
        """A joint whose child hangs on another one already: the closure that holds where the model is drawn."""
        name, kind = self.xml.name(element, "joints"), self.kind(element)
        if kind not in LOOPS:
            problem = (
                f"closes a loop with a joint of type '{kind}'; expected one of {', '.join(LOOPS)}"
            )
            raise self.xml.error(
                element, ("joints", name), f"{problem}: cut the loop at such a joint"
            )
        held = self.held(element, kind, ("joints", name))
        if held.pop("limits", None):
            self.document.notes.append(f"{name}: closes a loop; its limits are not kept")
        if held:
            problem = f"has {' and '.join(held)}, which a joint that closes a loop cannot have here"
            raise self.xml.error(
                element, ("joints", name), f"{problem}; put another joint of the loop behind it"
            )
        place = self.poses.joint(element)
        turn = Transform()
        if LOOPS[kind] == "axis":
            turn = self.poses.turn(
                [float(v) for v in rpy_to([float(v) for v in self.axis(element, ("joints", name))])]
            )
        between = {}
        for which in ("parent", "child"):
            end = self.end(element, which)
            link = "world" if end == "world" else self.poses.link_of(end, element)
            link = self.document.data["base"] if link == "world" else link
            between[link] = as_entry(self.poses.between(link, place) @ turn)
        if len(between) < 2:
            raise self.error(element, "has both ends on one link")
        entry = {"kind": LOOPS[kind], "between": between}
        self.document.add_located(("closures", name), entry, self.xml.file, element.line)

    def frame(self, element: Element) -> None:
        name = self.xml.name(element, "frames")
        link = self.poses.link_of(name, element)
        pose = self.poses.between(link, self.poses.place(name, element))
        self.document.section("frames").setdefault(name, {"link": link, **as_entry(pose)})
