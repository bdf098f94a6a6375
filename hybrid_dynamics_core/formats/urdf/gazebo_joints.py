"""Loop joints that a URDF has in <gazebo>, in the words of SDFormat.

The pose of such a joint is relative to its child link, and the loop is closed with all joints at
zero. A slide, a screw, or a joint with friction or a spring becomes a joint of the tree. It moves a
massless link, which is welded to the child.
"""

from __future__ import annotations

import math

import numpy as np

from ...description.document import Data, KeyPath
from ...description.geometry import Transform, rotation_from_rpy, rpy_to_axis, unit_axis
from ...ground.arrays import Array, frozen
from ...ground.suggestions import suggestion
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .closing_joints import ClosingJoints
from .zero_poses import ZeroPoses

_WORLD = "world"
_MODEL = "__model__"
_SAME_AXIS = 1e-9
_UNLIMITED = 1e16
_Z_AXIS = (0.0, 0.0, 1.0)
_ZERO_POSE = (0.0,) * 6
_FRICTION = {"damping": "viscous", "friction": "coulomb"}
_SPRING = {"spring_stiffness": "stiffness", "spring_reference": "rest"}
_TREE_TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "screw": "revolute",
}
_READ = frozenset({"parent", "child", "pose", "axis", "thread_pitch", "screw_thread_pitch"})
_READ_OF_AXIS = frozenset({"xyz", "dynamics", "limit", "use_parent_model_frame"})
_READ_OF_LIMIT = frozenset({"lower", "upper"})
_ATTRIBUTES = frozenset({"name", "type"})


class GazeboJoints:
    """Adds closures for joints in <gazebo>.

    Args:
        xml: the URDF, whose links and joints the document has.
        closing: adds the closures.
    """

    def __init__(self, xml: XmlReader, closing: ClosingJoints) -> None:
        self.xml = xml
        self.document = xml.document
        self.closing = closing
        self.poses = ZeroPoses(xml.document)

    def add(self, element: LocatedElement) -> None:
        """Add one joint.

        Raises:
            DescriptionError: it is wrong, or its type is not supported.
        """
        name = self.xml.name(element, "joints")
        parent, child = (self._named(element, tag) for tag in ("parent", "child"))
        if _WORLD in (parent, child):
            self._check_ground(element, {parent, child})
            return
        self._note_words(element)
        pose = self._pose(element, child)
        axis = unit_axis(self._axis(element, pose).tolist())
        motion = self._motion(element)
        if element.get("type") in ("prismatic", "screw") or motion:
            self._add_moving(element, (parent, child), pose, {"axis": axis.tolist(), **motion})
            return
        kind = self.closing.kind(element)
        if kind == "axis":
            pose = pose @ Transform(rotation_from_rpy(*rpy_to_axis(axis)))
        between = {link: self.poses.in_link(link, pose) for link in (parent, child)}
        self.closing.add(element, name, kind, between)

    def _add_moving(
        self, element: LocatedElement, ends: tuple[str, str], pose: Transform, motion: Data
    ) -> None:
        """Add a joint of the tree with a massless link, and weld this link to the child."""
        name = element.get("name")
        joint_type = element.get("type")
        if joint_type not in _TREE_TYPES:
            self.closing.kind(element)  # refuses unknown types
            problem = f"has dynamics, which a joint of type '{joint_type}' cannot have here"
            raise self.xml.error_at(element, problem)
        parent, child = ends
        origin = self.poses.in_link(parent, pose)
        end = f"{name}_end"
        self._add_joint(element, name, _TREE_TYPES[joint_type], (parent, end), origin, motion)
        if joint_type == "screw":
            slide = f"{name}_slide"
            axis = {"axis": motion["axis"], "mimic": self._thread(element)}
            self._add_joint(element, slide, "prismatic", (end, slide), {}, axis)
            end = slide
        between = {end: {}, child: self.poses.in_link(child, pose)}
        self.closing.add(element, f"{name}_weld", "frame", between)

    def _add_joint(
        self,
        element: LocatedElement,
        name: str,
        joint_type: str,
        ends: tuple[str, str],
        origin: Data,
        motion: Data,
    ) -> None:
        """Add a joint, and the massless link that it carries."""
        parent, child = ends
        self.xml.add(("links", child), {}, element)
        entry = {"type": joint_type, "parent": parent, "child": child, "origin": origin, **motion}
        self.xml.add(("joints", name), entry, element)

    def _thread(self, element: LocatedElement) -> Data:
        """The coupling of a screw's slide to its rotation."""
        name = element.get("name")
        key = ("joints", name, "thread_pitch")
        pitch = self.xml.text_number(element.first("screw_thread_pitch"), key, 0.0)  # [m/turn]
        turns = self.xml.text_number(element.first("thread_pitch"), key, 0.0)  # [rad/m], other sign
        multiplier = pitch / math.tau
        if turns:
            multiplier = -1.0 / turns
        if not multiplier:
            raise self.xml.error_at(element, "is a screw without <screw_thread_pitch>")
        return {"joint": name, "multiplier": multiplier, "offset": 0.0}

    # -- links

    def _named(self, element: LocatedElement, tag: str) -> str:
        """The link in <parent> or <child>, or the world."""
        end = element.first(tag)
        if end is None or not end.text.strip():
            raise self.xml.error_at(element, f"has no <{tag}>LINK</{tag}>")
        _, _, name = end.text.strip().rpartition("::")
        links = self.document.section("links")
        if name == _WORLD and name not in links:
            return _WORLD
        return self.closing.link(end, name)

    def _check_ground(self, element: LocatedElement, ends: set[str]) -> None:
        """Refuse joints to the world, except a fixed joint of the base."""
        base = self.document.data["base"]
        link = next(iter(ends - {_WORLD}), base)
        if element.get("type") == "fixed" and self._is_part_of_base(link):
            self.xml.note(element, f"joins '{link}' to the world, where the base stands anyway")
            return
        problem = f"joins '{link}' to the world; here the base '{base}' alone stands on it"
        raise self.xml.error_at(element, problem)

    def _is_part_of_base(self, link: str) -> bool:
        base = self.document.data["base"]
        joints = self.document.section("joints").values()
        fixed = {joint["child"]: joint["parent"] for joint in joints if joint["type"] == "fixed"}
        while link in fixed:
            link = fixed[link]
        return bool(link == base)

    # -- words

    def _note_words(self, element: LocatedElement) -> None:
        """Add notes on elements of a joint that are left out."""
        name = element.get("name")
        for attribute in element.attributes:
            if attribute not in _ATTRIBUTES:
                self.xml.note(element, f"joint {name}: {attribute} is left out")
        axis = element.first("axis")
        limit = None if axis is None else axis.first("limit")
        unread = [child for child in element.children if child.tag not in _READ]
        if axis is not None:
            unread += [child for child in axis.children if child.tag not in _READ_OF_AXIS]
        if limit is not None:
            unread += [child for child in limit.children if child.tag not in _READ_OF_LIMIT]
        for child in unread:
            self.xml.note(child, f"joint {name} closes a loop; its <{child.tag}> is left out")

    def _motion(self, element: LocatedElement) -> Data:
        """Friction and spring of the joint; with them, or for a slide, also its limits."""
        axis = element.first("axis")
        entries: Data = {}
        if axis is None:
            return entries
        dynamics = axis.first("dynamics")
        if dynamics is not None:
            friction = self._numbers(element, dynamics, _FRICTION)
            spring = self._numbers(element, dynamics, _SPRING)
            if any(friction.values()):
                entries["friction"] = friction
            if spring.get("stiffness"):
                entries["spring"] = spring
        limits = self._limits(element, axis.first("limit"))
        if limits and (entries or element.get("type") in ("prismatic", "screw")):
            entries["limits"] = limits
        elif limits:
            name = element.get("name")
            self.xml.note(axis, f"joint {name} closes a loop; its limits are left out")
        return entries

    def _numbers(
        self, element: LocatedElement, parent: LocatedElement, keys: dict[str, str]
    ) -> dict[str, float]:
        """Numbers of child elements, with renamed keys."""
        path = ("joints", element.get("name"), parent.tag)
        values: dict[str, float] = {}
        for tag, key in keys.items():
            if parent.first(tag) is not None:
                values[key] = self.xml.text_number(parent.first(tag), path, 0.0)
        return values

    def _limits(self, element: LocatedElement, limit: LocatedElement | None) -> list[float]:
        """Lower and upper limit; empty if there are none."""
        if limit is None:
            return []
        key = ("joints", element.get("name"), "limits")
        lower = self.xml.text_number(limit.first("lower"), key, -_UNLIMITED)
        upper = self.xml.text_number(limit.first("upper"), key, _UNLIMITED)
        if lower <= -_UNLIMITED:
            lower = -math.inf
        if upper >= _UNLIMITED:
            upper = math.inf
        if lower == -math.inf and upper == math.inf:
            return []
        return [lower, upper]

    # -- places

    def _pose(self, element: LocatedElement, child: str) -> Transform:
        """Pose of the joint in the base frame with all joints at zero."""
        pose = element.first("pose")
        key = ("joints", element.get("name"), "pose")
        around = self.poses.link(child)
        if pose is None or not pose.text.strip():
            return around
        frame = pose.get("relative_to") or pose.get("frame")
        others = set(pose.attributes) - {"relative_to", "frame"}
        if others:
            raise self.xml.error(pose, key, f"has {', '.join(sorted(others))}, not covered here")
        if frame:
            around = self._frame(pose, frame, key)
        *xyz, roll, pitch, yaw = self.xml.text_numbers(pose, 6, key, _ZERO_POSE)
        return around @ Transform(rotation_from_rpy(roll, pitch, yaw), frozen(xyz))

    def _axis(self, element: LocatedElement, pose: Transform) -> Array:
        """The axis (3,) in the joint frame; `pose` is that of the joint in the base frame."""
        key: KeyPath = ("joints", element.get("name"), "axis")
        axis = element.first("axis")
        xyz = None if axis is None else axis.first("xyz")
        direction = np.array(self.xml.text_numbers(xyz, 3, key, _Z_AXIS))
        if not direction.any():
            raise self.xml.error(element, key, "the axis has no length")
        if axis is None or xyz is None:
            return direction
        frame = xyz.get("expressed_in")
        if frame:
            in_base = self._frame(xyz, frame, key).rotation @ direction
            return np.asarray(pose.rotation.T @ in_base)
        in_model = axis.first("use_parent_model_frame")
        if in_model is not None and in_model.text.strip() in ("1", "true"):
            in_joint = pose.rotation.T @ direction
            if np.abs(in_joint - direction).max() > _SAME_AXIS:
                problem = "use_parent_model_frame: programs differ; give the axis in the joint"
                raise self.xml.error(in_model, key, problem)
        return direction

    def _frame(self, element: LocatedElement, name: str, key: KeyPath) -> Transform:
        """Pose in the base frame of a frame that a pose or an axis names."""
        links = self.document.section("links")
        if name == _MODEL:
            return Transform()
        if name not in links:
            hint = suggestion(name, links)
            raise self.xml.error(element, key, f"there is no link '{name}'{hint}")
        return self.poses.link(name)
