"""Random MJCF in the styles that people write: classes, degrees, every orientation, shapes."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

SHAPES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
COMPOUND = ("ball", "free")


def numbers(values: Sequence[float]) -> str:
    """Every digit."""
    return " ".join(repr(float(value)) for value in values)


class RandomModel:
    """A random model.

    Args:
        seed: of the numbers.
        types: of joints.
        has_constraints: whether bodies and joints are tied.
    """

    def __init__(
        self,
        seed: int,
        types: Sequence[str] = ("hinge", "slide"),
        has_constraints: bool = True,
    ) -> None:
        self.rng = np.random.default_rng(seed)
        self.types = types
        self.root = Element("mujoco", model="random")
        self.is_degree = self.chance(0.6)
        self.sequence = "".join(self.rng.choice(list("xyzXYZ"), 3))
        self.joints: list[str] = []
        self.bodies: list[str] = []
        self.sites: list[str] = []
        self.add_settings()
        self.add_defaults()
        self.world = SubElement(self.root, "worldbody")
        SubElement(self.world, "geom", type="plane", size="1 1 .1")
        SubElement(self.world, "light", pos="0 0 3")
        parents = [self.world]
        for k in range(int(self.rng.integers(2, 6))):
            parent = parents[int(self.rng.integers(len(parents)))]
            parents.append(self.add_body(parent, k, parent is self.world))
        if has_constraints:
            self.add_equalities()
        self.add_actuators()

    def text(self) -> str:
        return tostring(self.root, encoding="unicode")

    # -- small things

    def chance(self, share: float = 0.5) -> bool:
        return bool(self.rng.random() < share)

    def pick(self, choices: Sequence[str]) -> str:
        return str(choices[int(self.rng.integers(len(choices)))])

    def vector(self, size: float = 1.0) -> np.ndarray:
        return self.rng.uniform(-size, size, 3)

    def angle(self, radians: float) -> float:
        return float(np.rad2deg(radians)) if self.is_degree else radians

    def orient(self, element: Element) -> None:
        """Turn an element in one of the five ways, or not."""
        angles = [self.angle(value) for value in self.vector(3.0)]
        ways = {
            "quat": self.rng.normal(size=4),
            "euler": angles,
            "axisangle": [*self.vector(), angles[0]],
            "xyaxes": [*self.vector(), *self.vector()],
            "zaxis": self.vector(),
        }
        way = self.pick([*ways, ""])
        if way:
            element.set(way, numbers(ways[way]))

    # -- head

    def add_settings(self) -> None:
        compiler = SubElement(self.root, "compiler", eulerseq=self.sequence)
        if not self.is_degree:
            compiler.set("angle", "radian")
        elif self.chance():
            compiler.set("angle", "degree")
        compiler.set("inertiafromgeom", self.pick(["auto", "auto", "true"]))
        compiler.set("balanceinertia", "true")
        if self.chance(0.3):
            compiler.set("inertiagrouprange", "0 2")
        if self.chance(0.3):
            compiler.set("boundmass", "0.3")
            compiler.set("boundinertia", "0.02")
        gravity = [*self.vector()[:2], -9.81]
        SubElement(self.root, "option", gravity=numbers(gravity), timestep="0.001")

    def add_defaults(self) -> None:
        main = SubElement(self.root, "default")
        # What a ball joint cannot have stands in a class of its own:
        plain = (
            {"damping": "0.4", "armature": "0.05"} if not set(self.types) & set(COMPOUND) else {}
        )
        SubElement(main, "joint", {"axis": "0 1 0", **plain})
        SubElement(main, "geom", density="700", type="capsule", size="0.04 0.1")
        SubElement(main, "position", kp="30")
        for name in ("one", "two"):
            inner = SubElement(main, "default", {"class": name})
            if name == "one":
                SubElement(inner, "joint", {**plain, "axis": numbers(self.vector())})
                nested = SubElement(inner, "default", {"class": "nested"})
                SubElement(nested, "geom", type="box", size="0.1 0.05 0.07", euler="10 0 0")
            SubElement(inner, "geom", density="400", group="1")
            SubElement(inner, "site", pos="0.1 0 0")

    # -- bodies

    def add_body(self, parent: Element, k: int, is_grounded: bool) -> Element:
        """A body, in a frame or two, with joints, masses and a site."""
        while self.chance(0.3):
            parent = SubElement(parent, "frame", pos=numbers(self.vector(0.3)))
            self.orient(parent)
        name = f"body-{k}"
        body = SubElement(parent, "body", name=name, pos=numbers(self.vector(0.6)))
        self.bodies.append(name)
        self.orient(body)
        if self.chance():
            body.set("childclass", self.pick(["one", "two", "nested"]))
        types = list(self.rng.choice(list(self.types), int(self.rng.integers(1, 4))))
        if "free" in self.types and is_grounded:
            types = ["free"]
        types = [kind for kind in types if kind != "free" or is_grounded]
        if types.count("ball") and len(types) > 1:
            types = ["ball"]
        for number, kind in enumerate(types):
            self.add_joint(body, f"q{k}_{number}", str(kind))
        self.add_mass(body)
        site = SubElement(body, "site", name=f"site{k}", pos=numbers(self.vector(0.5)))
        self.orient(site)
        self.sites.append(f"site{k}")
        return body

    def add_joint(self, body: Element, name: str, kind: str) -> None:
        if kind == "free" and self.chance():
            SubElement(body, "freejoint", name=name)
            return
        joint = SubElement(body, "joint", name=name)
        if kind != "hinge" or self.chance():
            joint.set("type", kind)
        joint.set("stiffness", self.pick(["0", "2.5"]))
        if kind == "free":
            return
        if self.chance():
            joint.set("pos", numbers(self.vector(0.3)))
        if kind == "ball":
            return
        unit = self.angle(1.0) if kind == "hinge" else 1.0
        self.joints.append(name)
        unitless = {"class": self.pick(["one", "two", "nested"]), "armature": "0.2"}
        attributes = {
            **unitless,
            "axis": numbers(self.vector()),
            "ref": repr(unit * self.rng.uniform(-1, 1)),
            "range": numbers([-2.0 * unit, 1.5 * unit]),
            "springref": repr(unit * self.rng.uniform(-1, 1)),
        }
        for attribute, value in attributes.items():
            if self.chance() or (attribute == "armature" and set(self.types) & set(COMPOUND)):
                joint.set(attribute, value)

    def add_mass(self, body: Element) -> None:
        if self.chance():
            moments = self.rng.uniform(0.02, 0.03, 3)
            inertial = SubElement(
                body, "inertial", pos=numbers(self.vector(0.2)), mass=repr(self.rng.uniform(0.1, 3))
            )
            if self.chance():
                inertial.set("fullinertia", numbers([*moments, *self.vector(0.002)]))
            else:
                inertial.set("diaginertia", numbers(moments))
                self.orient(inertial)
        for k in range(int(self.rng.integers(1, 4))):
            self.add_geom(body, k)

    def add_geom(self, body: Element, k: int) -> None:
        parent = body
        if self.chance(0.2):
            parent = SubElement(body, "frame", pos=numbers(self.vector(0.1)))
            self.orient(parent)
        geom = SubElement(parent, "geom")
        kind = self.pick(list(SHAPES))
        size = self.rng.uniform(0.05, 0.2, SHAPES[kind])
        if k == 0 or self.chance():
            geom.set("type", kind)
            geom.set("size", numbers(size))
        if kind != "sphere" and "type" in geom.attrib and self.chance(0.3):
            geom.set("fromto", numbers([*self.vector(0.2), *self.vector(0.2)]))
        else:
            geom.set("pos", numbers(self.vector(0.2)))
            if self.chance():
                geom.set("quat", numbers(self.rng.normal(size=4)))
        if k and self.chance(0.3):
            geom.set("mass", self.pick(["0", "0.7"]))
        if self.chance(0.3):
            geom.set("density", "200")
        if k and self.chance(0.3):
            geom.set("group", "4")

    # -- constraints and drives

    def add_equalities(self) -> None:
        equality = SubElement(self.root, "equality")
        for tag in ("connect", "weld", "connect", "weld"):
            one, other = self.rng.permutation(len(self.bodies))[:2]
            constraint = SubElement(equality, tag)
            if self.chance(0.3):
                constraint.set("site1", self.sites[one])
                constraint.set("site2", self.sites[other])
            else:
                self.tie_bodies(constraint, self.bodies[one], self.bodies[other])
        if len(self.joints) < 2:
            return
        for other in self.joints[1:-1][:2]:
            coupling = SubElement(equality, "joint", joint1=other, joint2=self.joints[0])
            if self.chance(0.7):
                count = int(self.rng.integers(1, 4))
                coupling.set("polycoef", numbers([0.2, -1.7, 0.0][:count]))

        tendons = SubElement(self.root, "tendon")
        tendon = SubElement(tendons, "fixed", name="sum")
        for name in self.joints[-3:]:
            SubElement(tendon, "joint", joint=name, coef=repr(self.rng.uniform(0.5, 2.0)))
        SubElement(equality, "tendon", tendon1="sum", polycoef="0.3")

    def tie_bodies(self, constraint: Element, one: str, other: str) -> None:
        constraint.set("body1", one)
        if self.chance(0.8):
            constraint.set("body2", other)
        if constraint.tag == "connect" or self.chance():
            constraint.set("anchor", numbers(self.vector(0.4)))
        if constraint.tag == "weld" and self.chance():
            quaternion = self.rng.normal(size=4)
            constraint.set("relpose", numbers([*self.vector(0.4), *quaternion]))

    def add_actuators(self) -> None:
        actuator = SubElement(self.root, "actuator")
        for name in self.joints[::2]:
            SubElement(actuator, self.pick(["motor", "position", "general"]), joint=name)
