"""Poses of an SDFormat model: what <pose>, relative_to and attached_to say, in the frame of the model."""

from __future__ import annotations

import math

import numpy as np

from ...description.document import KeyPath
from ...description.geometry import Transform, rotation_from_quaternion, rotation_from_rpy, rpy_of
from ...errors import DescriptionError
from ...ground.arrays import Array, frozen
from ...ground.suggestions import suggestion
from ..xml.elements import XmlFile
from ..xml.tree import Element

MODEL = "__model__"


class Poses:
    """Links, joints and frames of a model where it is drawn."""

    def __init__(self, xml: XmlFile, model: Element) -> None:
        self.xml = xml
        kinds = ("link", "joint", "frame")
        self.elements = {e.attributes.get("name", ""): e for kind in kinds for e in model.all(kind)}
        self.model = self.read(model.first("pose"), ("model",))
        first = next((e.attributes.get("name", "") for e in model.all("link")), "")
        self.root = model.attributes.get("canonical_link") or first
        self._known: dict[str, Transform] = {MODEL: Transform(), "": Transform()}

    def link(self, name: str) -> Transform:
        """Of a link, the world among them."""
        return (
            self.inverse(self.model) if name == "world" else self.place(name, self.elements[name])
        )

    def joint(self, element: Element) -> Transform:
        """Of a joint."""
        return self.place(element.attributes.get("name", ""), element)

    def place(self, name: str, asking: Element, seen: tuple[str, ...] = ()) -> Transform:
        """Of anything with a name."""
        if name in self._known:
            return self._known[name]
        if name not in self.elements or name in seen:
            raise self.unknown(name, asking, seen)
        element = self.elements[name]
        pose = element.first("pose")
        told = pose.attributes.get("relative_to", "") if pose is not None else ""
        around = self.place(told or self.around(element), element, (*seen, name))
        self._known[name] = around @ self.read(pose, (element.tag, name))
        return self._known[name]

    def around(self, element: Element) -> str:
        """What a pose is relative to where it does not say."""
        if element.tag == "joint":
            child = element.first("child")
            return "" if child is None else child.text.strip()
        return element.attributes.get("attached_to", "") if element.tag == "frame" else ""

    def link_of(self, name: str, asking: Element, seen: tuple[str, ...] = ()) -> str:
        """The link that carries a frame or joint, or has the name itself."""
        name = self.root if name in (MODEL, "") else name
        if name not in self.elements or name in seen:
            raise self.unknown(name, asking, seen)
        element = self.elements[name]
        if element.tag == "link":
            return name
        on = self.around(element)
        return self.link_of(on, element, (*seen, name))

    def unknown(self, name: str, asking: Element, seen: tuple[str, ...]) -> DescriptionError:
        """What is said of a name that leads nowhere."""
        key: KeyPath = (f"{asking.tag}s", asking.attributes.get("name", ""))
        if name in seen:
            return self.xml.error(asking, key, f"its pose goes round: {' -> '.join([*seen, name])}")
        known = [*self.elements, "world"]
        return self.xml.error(
            asking, key, f"there is no link, joint or frame '{name}'{suggestion(name, known)}"
        )

    def read(self, element: Element | None, path: KeyPath) -> Transform:
        """A <pose>: angles in radians or degrees, or a quaternion x, y, z, w."""
        if element is None or not element.text.strip():
            return Transform()
        if element.attributes.get("rotation_format", "euler_rpy") == "quat_xyzw":
            *xyz, x, y, z, w = self.xml.inside(element, 7, path, [])
            return Transform(rotation_from_quaternion(np.array([w, x, y, z])), frozen(xyz))
        values = self.xml.inside(element, 6, path, [])
        unit = (
            math.pi / 180.0 if element.attributes.get("degrees", "false") in ("true", "1") else 1.0
        )
        return Transform(
            rotation_from_rpy(*(unit * angle for angle in values[3:])), frozen(values[:3])
        )

    def turn(self, rpy: list[float]) -> Transform:
        """A turn alone."""
        return Transform(rotation_from_rpy(*rpy))

    def turned(self, axis: Array, expressed_in: str, joint: Transform, asking: Element) -> Array:
        """An axis in the frame of its joint, from the frame in which it is given."""
        if not expressed_in:
            return axis
        return joint.rotation.T @ self.place(expressed_in, asking).rotation @ axis

    def between(self, link: str, place: Transform) -> Transform:
        """A place of the model as seen from a link."""
        return self.from_to(self.link(link), place)

    def from_to(self, one: Transform, other: Transform) -> Transform:
        """One pose in the frame of another."""
        return self.inverse(one) @ other

    @staticmethod
    def inverse(pose: Transform) -> Transform:
        """The pose seen the other way."""
        return Transform(frozen(pose.rotation.T), frozen(-(pose.rotation.T @ pose.translation)))


def as_entry(pose: Transform) -> dict[str, list[float]]:
    """A pose as a description file has it."""
    return {"xyz": pose.translation.tolist(), "rpy": [float(v) for v in rpy_of(pose.rotation)]}
