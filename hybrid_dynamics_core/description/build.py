"""From checked and expanded plain data to a `RobotDescription`; expressions become numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ..ground.arrays import Array, frozen
from .attached_frames import AttachedFrames
from .checks.plausible_lengths import warn_of_lengths
from .checks.plausible_masses import warn_of_masses
from .document import Data, Document
from .drive_limits.read import read_effort_table, read_pumps
from .entries import Entry, section_entries, section_entry
from .followers import multiplier_path, multipliers_of
from .forces import read_actuators, read_effects, read_payloads, read_transmissions
from .geometry import Transform, rotation_about
from .inertia import read_inertia
from .model import (
    END_EFFECTOR,
    Closure,
    Frame,
    Joint,
    Link,
    Loop,
    Mimic,
    MultiDofJoint,
    RobotDescription,
)
from .rigid_body import TRIANGLE_SLACK
from .stiffness_section.read import read_stiffness
from .values import ValueReader
from .visuals.read import read_visuals

_SAME_PLACE = 1e-12  # [m, or of unit vectors] rounding between two texts for one place
_SAME_TURN = 1e-9  # [of unit vectors] rounding of axes in files of other formats
_NO_MULTIPLIER = "is 0, so the joint does not follow; make it a fixed joint, or leave this one out"
_STANDARD_GRAVITY = [0, 0, -9.81]
_ROUNDED_SLACK = 1e-3  # relative error of inertias that a CAD program printed with few digits


def build_description(document: Document) -> RobotDescription:
    """The description of an expanded document whose names are checked.

    Raises:
        DescriptionError: a value is impossible.
    """
    values = ValueReader(document)
    robot = _Builder(values).robot()
    warn_of_lengths(document, robot)
    warn_of_masses(values, robot)
    warnings = tuple(document.warnings)  # complete when everything is read
    notes = (*document.notes, *warnings)
    impossible = MappingProxyType(dict(document.impossible))
    return replace(robot, notes=notes, warnings=warnings, impossible=impossible)


def described_numbers(document: Document) -> RobotDescription:
    """The numbers of an expanded document that was checked before, without notes or warnings."""
    return _Builder(ValueReader(document)).robot()


class _Builder:
    def __init__(self, values: ValueReader) -> None:
        self.values = values
        self.document = values.document
        self.data: Data = values.document.data
        self.base: str = self.data.get("base", "base")
        self.attached = AttachedFrames(values)

    def robot(self) -> RobotDescription:
        data = self.data
        links, parts, alone = self.bodies()
        joints = self.joints()
        robot = RobotDescription(
            name=data["name"],
            source=data.get("source", ""),
            gravity=self.gravity(),
            base=self.base,
            links=links,
            parts=parts,
            alone=alone,
            joints=joints,
            closures=self.closures(),
            loops=self.loops(),
            active=(*data["active"], *data.get("idle", [])),
            end_effector=END_EFFECTOR,
            frames=self.frames(),
            reference=self.reference(),
            idle=tuple(data.get("idle", [])),
            active_set=data.get("active_set", "exact"),
            mimics=self.mimics(),
            multi_dof=self.multi_dof(joints),
            charts=MappingProxyType(dict(self.document.charts)),
            file=self.document.file,
            lines=MappingProxyType(self.document.lines()),
            files=MappingProxyType(self.document.files()),
            effects=read_effects(self.values),
            payloads=read_payloads(self.values),
            actuators=read_actuators(self.values),
            visuals=read_visuals(section_entries(self.values, "links"), self.attached),
            transmissions=read_transmissions(self.values),
            pumps=read_pumps(self.values),
        )
        return replace(robot, stiffness=read_stiffness(self.values, robot))

    def gravity(self) -> Array:
        gravity = self.data.get("gravity", _STANDARD_GRAVITY)
        return self.values.vector(gravity, ("gravity",))

    # -- links

    def bodies(self) -> tuple[Mapping[str, Link], ...]:
        """Bodies with their fixed parts merged, the fixed parts, and the bodies without them."""
        bodies: dict[str, Link] = {}
        parts: dict[str, Link] = {}
        for name, entry in section_entries(self.values, "links").items():
            link = self.link(name, entry)
            _, pose = self.attached.resolve(name)
            link = _in_frame_around(link, pose)
            if self.attached.is_fixed(name):
                parts[name] = link
            else:
                bodies[name] = link
        alone = dict(bodies)
        for name, part in parts.items():
            if part.mass or part.inertia.any():
                carrier = self.attached.link(name)
                body = bodies.get(carrier, Link(carrier))
                bodies[carrier] = as_one_body(body, part)
        return MappingProxyType(bodies), MappingProxyType(parts), MappingProxyType(alone)

    def link(self, name: str, entry: Entry) -> Link:
        mass = entry.number("mass")
        if mass < 0.0:
            raise entry.error("mass", f"is {mass:g} kg; a mass is zero or positive")
        cannot_move = self.attached.link(name) == self.base
        slack = TRIANGLE_SLACK
        if name in self.document.rounded_links:
            slack = _ROUNDED_SLACK
        if cannot_move:
            slack = np.inf  # its inertia does not matter
        inertia = read_inertia(entry, mass, slack)
        com = entry.vector("com")
        if cannot_move:
            return Link(name, mass, com, inertia)
        if mass == 0.0 and np.any(inertia):
            self.document.warn_of_inertia(
                entry.key_path("inertia"), "it belongs to a link without a mass"
            )
        if mass > 0.0 and "inertia" not in entry:
            self.document.notes.append(
                f"{name}: no inertia given; its {mass:g} kg are taken as a point at its com"
            )
        return Link(name, mass, com, inertia, *self.compensated(entry, mass, com))

    def compensated(self, entry: Entry, mass: float, com: Array) -> tuple[float, Array]:
        """The mass with compensated weight, and its centre (3,) [m]."""
        if isinstance(entry.get("gravity_compensation"), dict):
            part = entry.sub("gravity_compensation")
            return part.number("mass"), part.vector("com")
        share = entry.number("gravity_compensation")
        if not share:
            return 0.0, frozen(np.zeros(3))
        return share * mass, com

    # -- joints

    def joints(self) -> Mapping[str, Joint]:
        joints: dict[str, Joint] = {}
        for name, entry in section_entries(self.values, "joints").items():
            if entry["type"] != "fixed":
                joints[name] = self.joint(name, entry)
        return MappingProxyType(joints)

    def multi_dof(self, joints: Mapping[str, Joint]) -> Mapping[str, MultiDofJoint]:
        """Joints of several freedoms, with links in place of frames at their ends."""
        several: dict[str, MultiDofJoint] = {}
        for name, joint in self.document.multi_dof.items():
            several[name] = replace(joint, parent=self.attached.link(joint.parent))
            self.require_turns(several[name], joints)
        return MappingProxyType(several)

    def require_turns(self, joint: MultiDofJoint, joints: Mapping[str, Joint]) -> None:
        """Raise if the axes of a ball or free joint are not x, y and z of one frame."""
        for k, name in enumerate(joint.turns):
            row = joints[name]
            direction = np.eye(3)[k]
            if k == 2:  # the axis is given in the child's frame, which may be rotated
                direction = row.rotation.T @ direction
            moved = k > 0 and row.translation.any()
            turned = k == 1 and np.abs(row.rotation - np.eye(3)).max() > _SAME_PLACE
            if moved or turned or np.abs(row.axis - direction).max() > _SAME_TURN:
                problem = f"is no turn about {'xyz'[k]}, as a {joint.type} joint has it"
                raise self.document.error(("joints", name), problem)

    def joint(self, name: str, entry: Entry) -> Joint:
        joint_type = entry["type"]
        parent = self.attached.frame(entry["parent"], entry.pose("origin"))
        axis = entry.axis("axis")
        offset = entry.coordinate("offset", joint_type)
        zero = _moved_along(joint_type, axis, offset, parent)
        limits = entry.limits("limits")
        if joint_type == "revolute":
            written = entry.get("limits") or []
            self.values.warn_of_degrees(written, limits, entry.key_path("limits"))
        table = read_effort_table(entry.sub("effort_table"))
        effort = entry.bound("effort_limit")
        if table is not None:
            effort = min(effort, table.largest)
        return Joint(
            name=name,
            type=joint_type,
            parent=parent.link,
            child=entry["child"],
            rotation=zero.rotation,
            translation=zero.translation,
            axis=axis,
            limits=limits,
            effort_limit=effort,
            velocity_limit=entry.bound("velocity_limit"),
            power_limit=entry.bound("power_limit"),
            acceleration_limit=entry.bound("acceleration_limit"),
            effort_table=table,
        )

    def reference(self) -> Mapping[str, float]:
        """The file's reference; active joints whose limits exclude zero get the nearest limit."""
        reference: dict[str, float] = {}
        joints = section_entries(self.values, "joints")
        given = section_entry(self.values, "reference")
        for name in given:
            reference[name] = given.coordinate(name, joints[name]["type"])
        for name in (*self.data["active"], *self.data.get("idle", [])):
            lower, upper = joints[name].limits("limits")
            if name in reference or lower <= 0.0 <= upper:
                continue
            reference[name] = lower if lower > 0.0 else upper
            self.document.notes.append(
                f"{name}: no reference is given; taken: {reference[name]:g}, the limit nearest to"
                " zero"
            )
        return MappingProxyType(reference)

    def mimics(self) -> Mapping[str, Mimic]:
        mimics: dict[str, Mimic] = {}
        for name, joint in section_entries(self.values, "joints").items():
            if "mimic" in joint:
                mimics[name] = self.mimic(joint.sub("mimic"))
        return MappingProxyType(mimics)

    def mimic(self, entry: Entry) -> Mimic:
        multipliers: dict[str, float] = {}
        for source, value in multipliers_of(entry.data).items():
            path = multiplier_path(entry.data, entry.path, source)
            multipliers[source] = self.values.number(value, path)
            if multipliers[source] == 0.0:
                raise self.document.error(path, _NO_MULTIPLIER)
        return Mimic(MappingProxyType(multipliers), entry.number("offset"))

    # -- frames

    def frames(self) -> Mapping[str, Frame]:
        """Named frames, the places of links fixed to others, and the end effector."""
        frames: dict[str, Frame] = {}
        for name in self.document.entries("frames"):
            frames[name] = self.attached.frame(name)
        for name in self.data["links"]:
            if self.attached.is_fixed(name):
                frames[name] = self.attached.frame(name)
        frames[END_EFFECTOR] = self.end_effector()
        return MappingProxyType(frames)

    def end_effector(self) -> Frame:
        """The end effector; a link or frame of this name must be at the same place."""
        entry = section_entry(self.values, "end_effector")
        end_effector = self.attached.frame(entry["link"], entry.as_pose())
        kind = self.kind_of(END_EFFECTOR)
        if kind and not _same_place(self.attached.frame(END_EFFECTOR), end_effector):
            raise self.document.error(
                ("end_effector",),
                f"a {kind} called '{END_EFFECTOR}' stands at another place, and one name cannot"
                f" mean both; write `end_effector: {{link: {END_EFFECTOR}}}` if it is meant (other"
                f" places can be named under frames), or rename that {kind}",
            )
        return end_effector

    def kind_of(self, name: str) -> str:
        """Whether a name is that of a link or of a frame; empty for neither."""
        if name == self.base or name in self.data["links"]:
            return "link"
        if name in self.document.entries("frames"):
            return "frame"
        return ""

    # -- closures

    def closures(self) -> tuple[Closure, ...]:
        entries = section_entries(self.values, "closures")
        return tuple(self.closure(name, entry) for name, entry in entries.items())

    def closure(self, name: str, entry: Entry) -> Closure:
        between = entry.sub("between")
        a, b = (self.closure_frame(link, between) for link in between)
        return Closure(
            name=name,
            link_a=a.link,
            point_a=a.translation,
            link_b=b.link,
            point_b=b.translation,
            kind=entry["kind"],
            rotation_a=a.rotation,
            rotation_b=b.rotation,
            assembly=entry.get("assembly"),
        )

    def closure_frame(self, link: str, between: Entry) -> Frame:
        """One end of a closure."""
        path = between.key_path(link)
        pose = self.values.attachment(between[link], path)
        return self.attached.frame(link, pose)

    def loops(self) -> Mapping[str, Loop]:
        loops: dict[str, Loop] = {}
        for name, entry in self.document.entries("loops").items():
            loops[name] = Loop(
                name,
                entry["type"],
                base=self.attached.link(entry["base"]),
                arm=self.attached.link(entry["arm"]),
                k1=self.attached.link(entry["k1"]),
                k2=self.attached.link(entry["k2"]),
            )
        return MappingProxyType(loops)


def _moved_along(joint_type: str, axis: Array, offset: float, frame: Frame) -> Frame:
    """A frame moved along a joint's axis by the joint's offset."""
    if not offset:
        return frame
    if joint_type == "revolute":
        rotation = frozen(frame.rotation @ rotation_about(axis, offset))
        return replace(frame, rotation=rotation)
    translation = frozen(frame.translation + frame.rotation @ (axis * offset))
    return replace(frame, translation=translation)


def _in_frame_around(link: Link, pose: Transform) -> Link:
    """The link with its data in the parent frame of `pose`."""
    if pose.is_identity():
        return link
    inertia = pose.rotation @ link.inertia @ pose.rotation.T
    symmetric = frozen((inertia + inertia.T) / 2.0)
    compensated_com = link.compensated_com
    if link.compensated_mass:
        compensated_com = pose.point(compensated_com)
    return Link(
        link.name,
        link.mass,
        pose.point(link.com),
        symmetric,
        link.compensated_mass,
        compensated_com,
    )


def as_one_body(a: Link, b: Link) -> Link:
    """Two bodies in one frame, merged into one by Steiner's theorem."""
    mass, com = _centre(a.mass, a.com, b.mass, b.com)
    compensated = _centre(
        a.compensated_mass, a.compensated_com, b.compensated_mass, b.compensated_com
    )
    steiner_a = a.mass * _steiner_term(a.com - com)
    steiner_b = b.mass * _steiner_term(b.com - com)
    inertia = frozen(a.inertia + b.inertia + steiner_a + steiner_b)
    return Link(a.name, mass, com, inertia, *compensated)


def _centre(mass_a: float, com_a: Array, mass_b: float, com_b: Array) -> tuple[float, Array]:
    """The sum of two masses, and its centre."""
    mass = mass_a + mass_b
    if not mass:
        return mass, com_a
    return mass, frozen((mass_a * com_a + mass_b * com_b) / mass)


def _steiner_term(arm: Array) -> Array:
    """The inertia (3, 3) of a unit mass at the end of an arm (3,)."""
    return np.asarray(arm @ arm * np.eye(3) - np.outer(arm, arm))


def _same_place(one: Frame, other: Frame) -> bool:
    if one.link != other.link:
        return False
    translation_gap = np.abs(one.translation - other.translation).max()
    rotation_gap = np.abs(one.rotation - other.rotation).max()
    return bool(max(translation_gap, rotation_gap) <= _SAME_PLACE)
