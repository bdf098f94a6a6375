"""Poses of an SDFormat model in the model frame, with relative_to and attached_to resolved."""

from __future__ import annotations

import math

import numpy as np

from ...description.document import KeyPath
from ...description.geometry import Transform, rotation_from_quaternion, rotation_from_rpy, rpy_of
from ...errors import DescriptionError
from ...ground.arrays import Array, frozen
from ...ground.suggestions import suggestion
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .versions import MODEL

WORLD = "world"
SCOPE = "::"  # between the name of a model and a name in it
_DEGREE = math.pi / 180.0  # [rad]


class ModelPoses:
    """Poses of links, joints and frames of a model in its drawn configuration.

    Attributes:
        model: pose of the model in the world.
    """

    def __init__(self, xml: XmlReader, model: LocatedElement) -> None:
        self.xml = xml
        self._elements: dict[str, LocatedElement] = {}
        for tag in ("link", "frame", "joint"):
            for element in model.all(tag):
                self._elements.setdefault(element.get("name"), element)
        self.model = self.read(model.first("pose"), ("model",))
        self._canonical_link = model.get("canonical_link")
        first_link = model.first("link")
        if not self._canonical_link and first_link is not None:
            self._canonical_link = first_link.get("name")
        self._resolved: dict[str, Transform] = {MODEL: Transform(), "": Transform()}
        self._resolved[WORLD] = self.model.inverse()

    def link(self, name: str) -> Transform:
        """Pose of a link, or of the world, in the model frame."""
        if name == WORLD:
            return self._resolved[WORLD]
        return self.resolve(name, self._elements[name])

    def joint(self, element: LocatedElement) -> Transform:
        """Pose of a joint in the model frame; in older files it may share its name with a link."""
        name = element.get("name")
        if self._elements[name] is element:
            return self.resolve(name, element)
        return self._pose_of(element, ())

    def in_link(self, link: str, pose: Transform) -> Transform:
        """A pose in the model frame, converted to the frame of a link."""
        return self.link(link).inverse() @ pose

    def resolve(
        self, name: str, asking: LocatedElement, visited: tuple[str, ...] = ()
    ) -> Transform:
        """Pose of a link, joint or frame in the model frame.

        Args:
            name: its name.
            asking: element that names it, for messages.
            visited: names on the way here.

        Raises:
            DescriptionError: the name does not exist, or its pose refers to itself.
        """
        if name in self._resolved:
            return self._resolved[name]
        name = self._full_name(name)
        if name not in self._elements or name in visited:
            raise self._unresolved(name, asking, visited)
        resolved = self._pose_of(self._elements[name], (*visited, name))
        self._resolved[name] = resolved
        return resolved

    def _pose_of(self, element: LocatedElement, visited: tuple[str, ...]) -> Transform:
        """Pose of an element in the model frame."""
        pose = element.first("pose")
        relative_to = ""
        if pose is not None:
            relative_to = pose.get("relative_to")
        frame = relative_to or _default_frame(element)
        around = self.resolve(frame, element, visited)
        return around @ self.read(pose, (element.tag, element.get("name")))

    def _full_name(self, name: str) -> str:
        """The full name of an element; the name of a nested model refers to its frame."""
        of_model = f"{name}{SCOPE}{MODEL}"
        if name not in self._elements and of_model in self._elements:
            return of_model
        return name

    def link_of(self, name: str, asking: LocatedElement, visited: tuple[str, ...] = ()) -> str:
        """The link that carries a frame or joint, or the link of that name.

        Args:
            name: name of a link, joint or frame.
            asking: element that names it, for messages.
            visited: names on the way here.

        Raises:
            DescriptionError: the name does not exist, or its frame is attached to itself.
        """
        if name in (MODEL, ""):
            name = self._canonical_link
        if name == WORLD:
            return WORLD
        name = self._full_name(name)
        if name not in self._elements or name in visited:
            raise self._unresolved(name, asking, visited)
        element = self._elements[name]
        if element.tag == "link":
            return name
        return self.link_of(_default_frame(element), element, (*visited, name))

    def read(self, element: LocatedElement | None, path: KeyPath) -> Transform:
        """A <pose>: angles in radians or degrees, or a quaternion x, y, z, w."""
        if element is None or not element.text.strip():
            return Transform()
        if element.get("rotation_format", "euler_rpy") == "quat_xyzw":
            *xyz, x, y, z, w = self.xml.text_numbers(element, 7, path, ())
            quaternion = np.array([w, x, y, z])
            return Transform(rotation_from_quaternion(quaternion), frozen(xyz))
        *xyz, roll, pitch, yaw = self.xml.text_numbers(element, 6, path, ())
        unit = 1.0
        if element.get("degrees") in ("true", "1"):
            unit = _DEGREE
        rotation = rotation_from_rpy(unit * roll, unit * pitch, unit * yaw)
        return Transform(rotation, frozen(xyz))

    def axis_in_joint(self, axis: Array, expressed_in: str, joint: LocatedElement) -> Array:
        """An axis (3,) converted from the frame `expressed_in` to its joint frame."""
        joint_pose = self.joint(joint)
        if not expressed_in:
            return axis
        frame_pose = self.resolve(expressed_in, joint)
        return joint_pose.rotation.T @ frame_pose.rotation @ axis

    def _unresolved(
        self, name: str, asking: LocatedElement, visited: tuple[str, ...]
    ) -> DescriptionError:
        key: KeyPath = (f"{asking.tag}s", asking.get("name"))
        if name in visited:
            cycle = " -> ".join([*visited, name])
            return self.xml.error(asking, key, f"its pose goes round: {cycle}")
        hint = suggestion(name, [*self._elements, WORLD])
        return self.xml.error(asking, key, f"there is no link, joint or frame '{name}'{hint}")


def pose_entry(pose: Transform) -> dict[str, list[float]]:
    """The entry of a pose in a description file."""
    rpy = rpy_of(pose.rotation)
    return {"xyz": pose.translation.tolist(), "rpy": rpy.tolist()}


def _default_frame(element: LocatedElement) -> str:
    """The default frame of a pose."""
    if element.tag == "joint":
        child = element.first("child")
        return "" if child is None else child.text.strip()
    if element.tag == "frame":
        return element.get("attached_to")
    return ""
