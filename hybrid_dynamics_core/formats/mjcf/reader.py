"""MJCF as this library writes it -> a document: bodies on hinges and slides, closures as equality constraints, motors.

MuJoCo's format says much that has no meaning here (contacts, tendons, defaults, meshes that make up
masses). What would change the robot is refused with its line; what is only seen is left out.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ...description.defaults import driven_joints, farthest_link
from ...description.document import Document, KeyPath
from ...description.geometry import rotation_from_quaternion, rpy_of
from ...errors import DescriptionError
from ..extras_reader import TAG, extend
from ..xml.elements import XmlFile
from ..xml.tree import Element
from ..xml.vocabulary import WordCheck
from .vocabulary import MJCF, NUMBERS, ONLY

TYPES = {"hinge": "revolute", "slide": "prismatic"}
KINDS = {"connect": "point", "weld": "frame"}
NOTHING = 1e-9  # [kg, kg m^2] what stands for none, since MuJoCo wants some mass of what moves


def mjcf_document(root: Element, file: Path) -> Document:
    """The document of an MJCF file; DescriptionError where it says what is not covered."""
    document = Document({"format": 1, "name": root.attributes.get("model", file.stem)}, file, {})
    reader = _Mjcf(document, XmlFile(file, root))
    WordCheck(reader.xml, MJCF, ONLY).check(root)
    reader.settings()
    for world in root.all("worldbody"):
        reader.body(world, "world")
    reader.ties()
    reader.drives()
    reader.reference()
    for custom in root.all("custom"):
        for text in custom.all("text"):
            if text.attributes.get("name") == TAG:
                extend(document, text.attributes.get("data", ""), file, text.line)
    if "end_effector" not in document.data:
        document.data["end_effector"] = {"link": farthest_link(document)}
    return document


class _Mjcf:
    def __init__(self, document: Document, xml: XmlFile) -> None:
        self.document, self.xml = document, xml
        self.sites: dict[str, tuple[str, dict[str, Any]]] = {}
        self.order: list[str] = []  # joints as MuJoCo numbers them
        document.data.update(
            base="world", links={}, joints={}, closures={}, source=f"{xml.file.name}"
        )

    def error(self, element: Element, problem: str) -> DescriptionError:
        name = element.attributes.get("name", "")
        return self.xml.error(element, (element.tag, name) if name else (element.tag,), problem)

    def settings(self) -> None:
        """Angles, bounds and gravity; of an attribute that is given twice the last one holds, as in MuJoCo."""
        angle = "degree"
        for compiler in self.xml.root.all("compiler"):
            angle = compiler.attributes.get("angle", angle)
            self.bounds(compiler)
        if angle != "radian":
            raise self.xml.error(
                self.xml.root, ("compiler",), 'counts angles in degrees; expected angle="radian"'
            )
        gravity = [0.0, 0.0, -9.81]
        for option in self.xml.root.all("option"):
            gravity = self.xml.numbers(option, "gravity", 3, ("option",), gravity)
        self.document.data["gravity"] = gravity

    def bounds(self, compiler: Element) -> None:
        """MuJoCo raises lighter bodies to its bounds: refused where that is more than what stands for none."""
        for key in ("boundmass", "boundinertia"):
            bound = self.xml.numbers(compiler, key, 1, ("compiler",), [0.0])[0]
            if bound > NOTHING:
                problem = (
                    f"{key} is {bound:g}, to which MuJoCo raises lighter bodies; expected"
                    f" {NOTHING:g} at most"
                )
                raise self.xml.error(
                    compiler, ("compiler",), f"{problem}: give each body the mass that is meant"
                )

    # -- bodies

    def body(self, element: Element, link: str) -> None:
        for geom in element.all("geom"):
            if geom.attributes.get("mass") not in ("0", "0.0"):
                raise self.error(
                    geom, 'a <geom> makes up mass; give it mass="0" and the body an <inertial>'
                )
        for site in element.all("site"):
            name = self.xml.name(site, "sites")
            if name in self.sites:
                raise self.error(site, "has the name of another site; rename one of them")
            self.sites[name] = (link, self.pose(site, ("sites",)))
        for body in element.all("body"):
            self.hang(body, link)

    def hang(self, element: Element, parent: str) -> None:
        link = self.xml.name(element, "links")
        joints = element.all("joint")
        self.document.add_located(
            ("links", link), self.inertial(element, link), self.xml.file, element.line
        )
        entry: dict[str, Any] = {
            "parent": parent,
            "child": link,
            "origin": self.pose(element, ("links", link)),
        }
        if len(joints) > 1:
            raise self.error(
                joints[1],
                f"body '{link}' has {len(joints)} joints; expected one, or none where it is fixed",
            )
        name = self.xml.name(joints[0], "joints") if joints else f"{link}_fixed"
        entry |= self.joint(joints[0], name) if joints else {"type": "fixed"}
        line = joints[0].line if joints else element.line
        self.document.add_located(("joints", name), entry, self.xml.file, line)
        self.body(element, link)

    def inertial(self, element: Element, link: str) -> dict[str, Any]:
        inertial, path = element.first("inertial"), ("links", link)
        if inertial is None:
            return {}
        mass = self.xml.numbers(inertial, "mass", 1, (*path, "mass"))[0]
        pose = self.pose(inertial, path)
        if "fullinertia" in inertial.attributes:
            xx, yy, zz, xy, xz, yz = self.xml.numbers(
                inertial, "fullinertia", 6, (*path, "inertia")
            )
        else:
            xx, yy, zz = self.xml.numbers(inertial, "diaginertia", 3, (*path, "inertia"))
            xy = xz = yz = 0.0
        if mass <= NOTHING and max(xx, yy, zz) <= NOTHING:
            return {}
        moments = {"xx": xx, "yy": yy, "zz": zz, "xy": xy, "xz": xz, "yz": yz}
        return {
            "mass": mass,
            "com": pose["xyz"],
            "inertia": {**moments, "frame": {"rpy": pose["rpy"]}},
        }

    def joint(self, element: Element, name: str) -> dict[str, Any]:
        path: KeyPath = ("joints", name)
        kind = element.attributes.get("type", "hinge")
        if kind not in TYPES:
            raise self.xml.error(
                element, (*path, "type"), f"is '{kind}'; expected {' or '.join(TYPES)}"
            )
        self.order.append(name)
        number = {
            key: self.xml.numbers(element, key, 1, path, [0.0])[0]
            for key in sorted(NUMBERS & set(element.attributes))
        }
        entry: dict[str, Any] = {
            "type": TYPES[kind],
            "axis": self.xml.numbers(element, "axis", 3, path, [0.0, 0.0, 1.0]),
        }
        if "range" in element.attributes and element.attributes.get("limited", "auto") != "false":
            entry["limits"] = self.xml.numbers(element, "range", 2, (*path, "limits"))
        if "damping" in number or "frictionloss" in number:
            entry["friction"] = {
                "viscous": number.get("damping", 0.0),
                "coulomb": number.get("frictionloss", 0.0),
            }
        if "armature" in number:
            entry["drive"] = {"rotor_inertia": number["armature"]}
        if "stiffness" in number:
            entry["spring"] = {
                "stiffness": number["stiffness"],
                "rest": number.get("springref", 0.0),
            }
        return entry

    def pose(self, element: Element, path: KeyPath) -> dict[str, list[float]]:
        turned = [
            key for key in ("euler", "axisangle", "xyaxes", "zaxis") if key in element.attributes
        ]
        if turned:
            raise self.xml.error(element, path, f"is turned by {turned[0]}; expected quat")
        quaternion = self.xml.numbers(element, "quat", 4, path, [1.0, 0.0, 0.0, 0.0])
        if math.hypot(*quaternion) < 1e-9:
            raise self.xml.error(element, path, "has a quat without length; 1 0 0 0 is no turn")
        xyz = self.xml.numbers(element, "pos", 3, path, [0.0, 0.0, 0.0])
        return {
            "xyz": xyz,
            "rpy": [float(v) for v in rpy_of(rotation_from_quaternion(np.array(quaternion)))],
        }

    # -- the rest

    def ties(self) -> None:
        """Closures between sites, followers, and the sites that are left as frames."""
        tied: set[str] = set()
        for equality in self.xml.root.all("equality"):
            for element in equality.children:
                if element.tag == "joint":
                    self.follower(element)
                elif element.tag in KINDS:
                    tied |= self.tie(element)
                else:
                    raise self.error(
                        element, f"<{element.tag}> is not covered; expected connect, weld or joint"
                    )
        frames = self.document.section("frames")
        for name, (link, pose) in self.sites.items():
            if name not in tied:
                frames[name] = {"link": link, **pose}

    def tie(self, element: Element) -> set[str]:
        ends = [element.attributes.get(key, "") for key in ("site1", "site2")]
        for end in ends:
            if end not in self.sites:
                raise self.error(
                    element,
                    f"ties the site '{end}', which is not there; name two sites as site1 and site2",
                )
        between = {self.sites[end][0]: self.sites[end][1] for end in ends}
        if len(between) < 2:
            raise self.error(element, "ties two sites of one body")
        entry = {"kind": KINDS[element.tag], "between": between}
        self.document.add_located(
            ("closures", self.xml.name(element, "closures")), entry, self.xml.file, element.line
        )
        return set(ends)

    def follower(self, element: Element) -> None:
        own, source = (element.attributes.get(key, "") for key in ("joint1", "joint2"))
        offset, factor, *rest = self.xml.numbers(element, "polycoef", 5, ("joints", own, "mimic"))
        if own not in self.document.section("joints") or not source or any(rest):
            raise self.error(
                element, "expected joint1 that follows joint2 by a polynomial of first degree"
            )
        self.document.section("joints")[own]["mimic"] = {
            "joint": source,
            "multiplier": factor,
            "offset": offset,
        }

    def drives(self) -> None:
        active = []
        for actuator in self.xml.root.all("actuator"):
            for element in actuator.children:
                joint = element.attributes.get("joint", "")
                if element.tag != "motor" or joint not in self.order:
                    raise self.error(
                        element, f"<{element.tag}> is not covered; expected <motor joint=...>"
                    )
                active.append(joint)
        if not active and self.document.section("closures"):
            raise self.xml.error(
                self.xml.root,
                ("actuator",),
                "has no motors; with closures, name the driven joints so",
            )
        self.document.data["active"] = active or driven_joints(self.document)
        self.document.data["active_set"] = "motors"

    def reference(self) -> None:
        """The first keyframe, or where all coordinates are zero."""
        keys = [key for frame in self.xml.root.all("keyframe") for key in frame.all("key")]
        zero = [0.0] * len(self.order)
        values = (
            self.xml.numbers(keys[0], "qpos", len(self.order), ("keyframe",), zero)
            if keys
            else zero
        )
        self.document.data["reference"] = dict(zip(self.order, values, strict=True))
