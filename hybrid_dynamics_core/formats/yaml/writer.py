"""Writer of description files of format 1, for people to read and edit.

Modules, legs, rows and parameters are expanded to links, joints and closures. Reading the file
gives the same robot.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...description.build import as_one_body
from ...description.document import Data
from ...description.geometry import Transform
from ...description.model import END_EFFECTOR, Closure, Frame, Joint, Link, RobotDescription
from ...ground.arrays import Array
from ...ground.wording import one_line
from ...robot.taken import AnyRobot, description_of
from ..extras_writer import compensation_entry, extras_of, without_empty
from ..stiffness_writer import stiffness_entry
from ..visual_elements import visual_entry
from .names import Names
from .poses import axis_entry, body_entry, place_entry, pose_entry
from .text import yaml_text

_STANDARD_GRAVITY = [0.0, 0.0, -9.81]
_ROUNDING = 1e-13  # relative rounding of masses that are merged again


def to_yaml(robot: AnyRobot, folder: str | Path | None = None) -> str:
    """The description file of a robot.

    Comments at the top list the loader's notes and changed names.

    Args:
        robot: the robot to write, or its description.
        folder: folder of the file. Meshes in it get relative paths, others absolute ones.

    Raises:
        InputError: `robot` is neither.
    """
    description = description_of(robot)
    writer = _Writer(description, None if folder is None else Path(folder))
    text = yaml_text(writer.data())
    return "".join(f"# {line}\n" for line in writer.comments()) + text


class _Writer:
    def __init__(self, robot: RobotDescription, folder: Path | None) -> None:
        self.robot = robot
        self.folder = folder
        self.names = Names(robot)
        self.extras = extras_of(robot, ())
        # Frames in which link data are given, if not those at their joints.
        self.link_frames: dict[str, Transform] = {}
        for name, frame in robot.frames.items():
            if name == frame.link and name != END_EFFECTOR:
                self.link_frames[name] = _transform(frame)

    def comments(self) -> Iterator[str]:
        """Lines of comments at the top of the file."""
        robot = self.robot
        source = f" from {Path(robot.file).name}" if robot.file else ""
        yield f"{one_line(robot.name)}: written by hybrid_dynamics{source}."
        yield "SI units and radians; every number may be an expression, such as pi/2 or 30*deg."
        for name, new_name in self.names.changed.items():
            yield f"'{one_line(name)}' is called {new_name} here: names have letters, digits, _-./"
        for note in robot.notes:
            yield f"note: {one_line(note)}"

    def data(self) -> Data:
        """The entries of the file."""
        robot = self.robot
        entries: Data = {"format": 1, "name": self.names[robot.name]}
        if robot.source:
            entries["source"] = robot.source
        gravity = robot.gravity.tolist()
        if gravity != _STANDARD_GRAVITY:
            entries["gravity"] = gravity
        if robot.base != "base":
            entries["base"] = self.names[robot.base]
        entries["links"] = {**self.links(), **self.parts()}
        entries["joints"] = {**self.joints(), **self.fixed_joints()}
        entries |= self.loops_and_closures()
        entries["active"] = self.names.list(robot.motors)
        if robot.idle:
            entries["idle"] = self.names.list(robot.idle)
        if robot.active_set != "exact":
            entries["active_set"] = robot.active_set
        entries["end_effector"] = self.frame(robot.frames[END_EFFECTOR])
        others: Data = {
            "frames": self.frames(),
            "payloads": self.payloads(),
            "actuators": self.by_joint("actuators"),
            "transmissions": self.transmissions(),
            "pumps": self.pumps(),
            "stiffness": stiffness_entry(robot.stiffness, self.names.__getitem__),
            "reference": self.by_joint("reference"),
            "multi_dof": self.multi_dof(),
        }
        return entries | without_empty(others)

    def loops_and_closures(self) -> Data:
        """Loops of Type A to D, and all other closures."""
        loops: Data = {}
        closures: Data = {}
        for closure in self.robot.closures:
            name = self.names[closure.name]
            if closure.name in self.robot.loops:
                loops[name] = self.loop(closure)
            else:
                closures[name] = self.closure(closure)
        return without_empty({"loops": loops, "closures": closures})

    def by_joint(self, section: str) -> Data:
        """Entries by joint, with only the names of joints replaced."""
        entries: Data = {}
        for name, entry in self.extras.get(section, {}).items():
            entries[self.names[name]] = entry
        return entries

    def transmissions(self) -> Data:
        """Drives that move several joints."""
        entries: Data = {}
        for name, entry in self.extras.get("transmissions", {}).items():
            multipliers = {self.names[joint]: value for joint, value in entry["joints"].items()}
            entries[self.names[name]] = {**entry, "joints": multipliers}
        return entries

    def pumps(self) -> Data:
        """Pumps that feed several cylinders."""
        entries: Data = {}
        for name, entry in self.extras.get("pumps", {}).items():
            entries[self.names[name]] = {**entry, "cylinders": self.names.list(entry["cylinders"])}
        return entries

    def multi_dof(self) -> Data:
        """Joints of several freedoms, with the joints of their chains."""
        entries: Data = {}
        for name, joint in self.robot.multi_dof.items():
            row = {"type": joint.type, "joints": self.names.list(list(joint.joints))}
            entries[self.names[name]] = row
        return entries

    # -- links

    def links(self) -> Data:
        entries: Data = {}
        bodies = self.robot.links
        if self.robot.base not in bodies:
            entries[self.names[self.robot.base]] = self.visuals(self.robot.base)
        for name, link in bodies.items():
            if self.keeps_parts(name):
                link = self.robot.alone.get(name, Link(name))  # noqa: PLW2901
            body = self.body(link, self.frame_of(name))
            entries[self.names[name]] = body | self.visuals(name)
        return entries

    def parts(self) -> Data:
        """Links that are fixed to others."""
        entries: Data = {}
        for name, part in self.robot.parts.items():
            place = self.robot.frames[name]
            entry: Data = {}
            if self.keeps_parts(place.link):
                entry = self.body(part, _transform(place))
            entries[self.names[name]] = entry | self.visuals(name)
        return entries

    def visuals(self, name: str) -> Data:
        """The visuals of a link or part, in the frame in which its data are given."""
        frame = self.frame_of(name)
        if name in self.robot.parts:
            frame = _transform(self.robot.frames[name])
        entries: list[Data] = []
        for visual in self.robot.visuals.get(name, ()):
            entry = visual_entry(visual, self.folder)
            origin = pose_entry(frame.inverse() @ _transform(visual.frame))
            entries.append(entry | without_empty({"origin": origin}))
        return without_empty({"visuals": entries})

    def keeps_parts(self, body: str) -> bool:
        """Whether a body still is the sum of its parts."""
        parts = self.parts_of(body)
        if not parts:
            return False
        total = self.robot.alone.get(body, Link(body))
        for part in parts:
            total = as_one_body(total, part)
        given = self.robot.links.get(body, Link(body))
        return bool(np.allclose(_numbers(total), _numbers(given), rtol=_ROUNDING, atol=1e-300))

    def parts_of(self, body: str) -> list[Link]:
        """Parts with a mass or inertia."""
        parts: list[Link] = []
        for name, part in self.robot.parts.items():
            has_inertia = part.mass or part.inertia.any()
            if has_inertia and self.robot.frames[name].link == body:
                parts.append(part)
        return parts

    def body(self, link: Link, frame: Transform) -> Data:
        """The entry of a body, with data in a frame relative to its joint's frame."""
        R = frame.rotation
        com: Array = link.com
        inertia: Array = link.inertia
        if not frame.is_identity():
            com = R.T @ (com - frame.translation)
            inertia = R.T @ inertia @ R
        if not link.mass:
            com = np.zeros(3)
        compensated_com = R.T @ (link.compensated_com - frame.translation)
        return {
            **body_entry(link.mass, com, inertia),
            **compensation_entry(link, compensated_com),
        }

    # -- poses

    def frame_of(self, link: str) -> Transform:
        """The frame of a link's data, relative to that at its joint."""
        return self.link_frames.get(link, Transform())

    def inside(self, frame: Frame) -> Transform:
        """A pose on a link, relative to the frame of the link's data."""
        return self.frame_of(frame.link).inverse() @ _transform(frame)

    def frame(self, frame: Frame) -> Data:
        return {"link": self.names[frame.link], **pose_entry(self.inside(frame))}

    def frames(self) -> Data:
        entries: Data = {}
        for name, frame in self.robot.frames.items():
            new_name = self.names[name]
            if name in self.link_frames:
                pose = pose_entry(self.link_frames[name])
                entries[new_name] = {"link": new_name, **pose}
            elif name != END_EFFECTOR and name not in self.robot.parts:
                entries[new_name] = self.frame(frame)
        return entries

    # -- joints

    def joints(self) -> Data:
        entries: Data = {}
        for name, joint in self.robot.joints.items():
            entries[self.names[name]] = self.joint(joint)
        return entries

    def joint(self, joint: Joint) -> Data:
        parent = Frame(joint.parent, joint.rotation, joint.translation)
        entry: Data = {
            "type": joint.type,
            "parent": self.names[joint.parent],
            "child": self.names[joint.child],
        }
        entry |= without_empty({"origin": pose_entry(self.inside(parent))})
        entry["axis"] = axis_entry(joint.axis)
        if any(map(math.isfinite, joint.limits)):
            entry["limits"] = list(joint.limits)
        extras = dict(self.extras.get("joints", {}).get(joint.name, {}))
        extras.pop("limits", None)
        if "mimic" in extras:
            extras["mimic"] = self.mimic(extras["mimic"])
        return entry | extras

    def mimic(self, entry: Data) -> Data:
        if "joint" in entry:
            return {**entry, "joint": self.names[entry["joint"]]}
        multipliers: Data = {}
        for name, multiplier in entry["joints"].items():
            multipliers[self.names[name]] = multiplier
        return {**entry, "joints": multipliers}

    def fixed_joints(self) -> Data:
        entries: Data = {}
        taken = {*self.robot.joints, *self.names.changed.values()}
        for part in self.robot.parts:
            place = self.robot.frames[part]
            name = f"{self.names[part]}_fixed"
            while name in taken:
                name += "_"
            origin = pose_entry(self.inside(place))
            entry: Data = {
                "type": "fixed",
                "parent": self.names[place.link],
                "child": self.names[part],
            }
            entries[name] = entry | without_empty({"origin": origin})
        return entries

    # -- loops

    def loop(self, closure: Closure) -> Data:
        entry = dict(self.extras["loops"][closure.name])
        for key in ("base", "arm", "k1", "k2"):
            entry[key] = self.names[entry[key]]
        ends = [self.inside(frame) for frame in closure.frames()]
        links = self.names.list([closure.link_a, closure.link_b])
        points = [end.translation.tolist() for end in ends]
        entry["pin"] = dict(zip(links, points, strict=True))
        return entry | without_empty({"assembly": closure.assembly})

    def closure(self, closure: Closure) -> Data:
        between: Data = {}
        for frame in closure.frames():
            between[self.names[frame.link]] = place_entry(closure.kind, self.inside(frame))
        entry: Data = {"kind": closure.kind, "between": between}
        return entry | without_empty({"assembly": closure.assembly})

    # -- loads

    def payloads(self) -> Data:
        entries: Data = {}
        for name, (place, payload) in self.robot.payloads.items():
            com = np.asarray(payload.com)
            inertia = np.asarray(payload.inertia)
            entry: Data = {"on": self.names[place], "mass": payload.mass}
            entry |= body_entry(payload.mass, com, inertia)
            entries[self.names[name]] = entry
        return entries


def _transform(frame: Frame) -> Transform:
    return Transform(frame.rotation, frame.translation)


def _numbers(link: Link) -> Array:
    """All numbers of a body, for comparison."""
    compensated = link.compensated_mass * link.compensated_com
    body = [link.mass, *link.com, *link.inertia.ravel()]
    return np.array([*body, link.compensated_mass, *compensated])
