"""Checked and expanded plain data -> frozen objects: expressions become numbers, offsets and shapes are worked in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from ..ground.arrays import Array, frozen
from .actuators import read_actuators
from .checks.plausible_lengths import doubt_lengths
from .checks.plausible_masses import doubt_masses
from .defaults import END_EFFECTOR
from .document import Document, Path_
from .effects import JointEffect, Payload, check_effects, read_effects, read_payloads
from .geometry import TRIANGLE_SLACK, Transform, rotation_about
from .inertia import read_inertia
from .model import Closure, Frame, Joint, Link, Loop, Mimic, RobotDescription
from .places import Places
from .values import Numbers

T = TypeVar("T")
SAME_PLACE = 1e-12  # [m and of unit vectors] rounding of one place that is written twice
STANDARD_GRAVITY = [0, 0, -9.81]
PRINTED = 1e-3  # relative slack of inertias that a drawing program printed with few digits


def build_description(document: Document) -> RobotDescription:
    """Build every part of an expanded document whose names are checked."""
    return _Builder(document).robot()


class _Builder:
    def __init__(self, document: Document) -> None:
        self.document = document
        self.data: dict[str, Any] = document.data
        self.numbers = Numbers(document)
        self.places = Places(self.numbers)

    def robot(self) -> RobotDescription:
        data, numbers = self.data, self.numbers
        links, parts = self.links()
        told = RobotDescription(
            name=data["name"],
            source=data.get("source", ""),
            gravity=numbers.vector(data.get("gravity", STANDARD_GRAVITY), ("gravity",)),
            base=data.get("base", "base"),
            links=links,
            parts=parts,
            joints=self.joints(),
            closures=tuple(self.each("closures", self.closure).values()),
            loops=self.each("loops", self.loop),
            active=tuple(data["active"]),
            end_effector=END_EFFECTOR,
            frames=self.frames(),
            reference=self.references(),
            active_set=data.get("active_set", "exact"),
            mimics=self.mimics(),
            file=self.document.file,
            lines=self.document.lines(),
            files=self.document.files(),
            effects=self.effects(),
            payloads=self.payloads(),
            actuators=read_actuators(
                data.get("actuators", {}), data["joints"], numbers.number, self.document.error
            ),
        )
        doubt_lengths(self.document, told)
        doubt_masses(self.document, numbers, self.places, told.base)
        warnings = tuple(self.document.warnings)  # known when everything is read
        return replace(told, notes=(*self.document.notes, *warnings), warnings=warnings)

    def each(self, section: str, build: Callable[[str, Any, Path_], T]) -> Mapping[str, T]:
        entries = self.data.get(section, {})
        return MappingProxyType(
            {name: build(name, value, (section, name)) for name, value in entries.items()}
        )

    # -- links

    def links(self) -> tuple[Mapping[str, Link], Mapping[str, Link]]:
        """Moving links and the base, each with the links fixed to it as one body; and these, in that body's frame."""
        links: dict[str, Link] = {}
        parts: dict[str, Link] = {}
        for name, entry in self.data["links"].items():
            link = self.link(name, entry or {}, ("links", name))
            link = _moved(link, self.places.place(name)[1])
            (parts if self.places.is_fixed(name) else links)[name] = link
        for name, part in parts.items():
            if part.mass:
                carrier = self.places.place(name)[0]
                links[carrier] = _joined(links.get(carrier, Link(carrier)), part)
        return MappingProxyType(links), MappingProxyType(parts)

    def link(self, name: str, entry: Mapping[str, Any], path: Path_) -> Link:
        mass = self.numbers.number(entry.get("mass", 0), (*path, "mass"))
        if mass < 0.0:
            raise self.document.error(
                (*path, "mass"), f"is {mass:g} kg; a mass is zero or positive"
            )
        where = (*path, "inertia")
        slack = PRINTED if name in self.document.printed else TRIANGLE_SLACK
        inertia = read_inertia(self.numbers, entry.get("inertia", {"xx": 0}), mass, where, slack)
        if mass == 0.0 and np.any(inertia):
            raise self.document.error(where, "the link has an inertia but no mass; give its mass")
        if mass > 0.0 and "inertia" not in entry:
            self.document.notes.append(
                f"{name}: no inertia given; its {mass:g} kg are taken as a point at its com"
            )
        com = self.numbers.vector(entry.get("com", [0, 0, 0]), (*path, "com"))
        return Link(name, mass, com, inertia)

    # -- joints

    def joints(self) -> Mapping[str, Joint]:
        moving = {
            name: entry for name, entry in self.data["joints"].items() if entry["type"] != "fixed"
        }
        return MappingProxyType(
            {name: self.joint(name, entry, ("joints", name)) for name, entry in moving.items()}
        )

    def joint(self, name: str, entry: Mapping[str, Any], path: Path_) -> Joint:
        pose = self.numbers.pose(entry.get("origin", {}), (*path, "origin"))
        parent = self.places.frame(entry["parent"], pose)
        rotation, translation = parent.rotation, parent.translation
        axis = self.numbers.axis(entry["axis"], (*path, "axis"))
        number = self.numbers.angle if entry["type"] == "revolute" else self.numbers.number
        offset = number(entry.get("offset", 0), (*path, "offset"))
        if offset and entry["type"] == "revolute":
            rotation = frozen(rotation @ rotation_about(axis, offset))
        elif offset:
            translation = frozen(translation + rotation @ (axis * offset))
        limits = self.numbers.limits(entry.get("limits"), (*path, "limits"))
        if entry["type"] == "revolute":
            self.numbers.doubt_degrees(entry.get("limits") or [], limits, (*path, "limits"))
        return Joint(
            name, entry["type"], parent.link, entry["child"], rotation, translation, axis, limits
        )

    def reference(self, name: str, value: float | str, path: Path_) -> float:
        """A joint's value in the reference configuration [rad or m]."""
        revolute = self.data["joints"][name]["type"] == "revolute"
        return (self.numbers.angle if revolute else self.numbers.number)(value, path)

    def references(self) -> Mapping[str, float]:
        """What the file names; active joints that it leaves out where they cannot be at zero, at the nearest limit."""
        told = self.each("reference", self.reference)
        taken: dict[str, float] = {}
        for name in self.data["active"]:
            path = ("joints", name, "limits")
            lower, upper = self.numbers.limits(self.data["joints"][name].get("limits"), path)
            if name not in told and not lower <= 0.0 <= upper:
                taken[name] = lower if lower > 0.0 else upper
                self.document.notes.append(
                    f"{name}: no reference is given; taken: {taken[name]:g}, the limit nearest to"
                    " zero"
                )
        return MappingProxyType({**told, **taken})

    def mimics(self) -> Mapping[str, Mimic]:
        """Joints that follow others."""
        told = {
            name: entry["mimic"] for name, entry in self.data["joints"].items() if "mimic" in entry
        }
        return MappingProxyType(
            {name: self.mimic(entry, ("joints", name, "mimic")) for name, entry in told.items()}
        )

    def mimic(self, entry: Mapping[str, Any], path: Path_) -> Mimic:
        factor = self.numbers.number(entry.get("multiplier", 1), (*path, "multiplier"))
        if factor == 0.0:
            raise self.document.error(
                (*path, "multiplier"), "is 0, so the joint would not move; make it a fixed joint"
            )
        return Mimic(
            entry["joint"], factor, self.numbers.number(entry.get("offset", 0), (*path, "offset"))
        )

    # -- frames and closures

    def frames(self) -> Mapping[str, Frame]:
        """Named frames, the places of links fixed to others, and the end effector."""
        named = {name: self.places.frame(name) for name in self.data.get("frames", {})}
        fixed = {
            name: self.places.frame(name)
            for name in self.data["links"]
            if self.places.is_fixed(name)
        }
        end_effector = self.frame(END_EFFECTOR, self.data["end_effector"], ("end_effector",))
        self.check_end_effector(end_effector)
        return MappingProxyType({**named, **fixed, END_EFFECTOR: end_effector})

    def check_end_effector(self, told: Frame) -> None:
        """Refuse two places of that name: a link or frame that is called so has to be the end effector."""
        kinds = {
            "link": (self.data.get("base", "base"), *self.data["links"]),
            "frame": self.data.get("frames", {}),
        }
        kind = next((kind for kind, names in kinds.items() if END_EFFECTOR in names), None)
        if kind is None or _same_place(self.places.frame(END_EFFECTOR), told):
            return
        raise self.document.error(
            ("end_effector",),
            f"a {kind} called '{END_EFFECTOR}' stands at another place, and one name cannot mean"
            f" both; write `end_effector: {{link: {END_EFFECTOR}}}` if it is meant (other places"
            f" can be named under frames), or rename that {kind}",
        )

    def frame(self, _: str, entry: Mapping[str, Any], path: Path_) -> Frame:
        return self.places.frame(entry["link"], self.numbers.pose(entry, path))

    def closure(self, name: str, entry: Mapping[str, Any], path: Path_) -> Closure:
        a, b = (
            self.places.frame(link, self.numbers.place(place, (*path, "between", link)))
            for link, place in entry["between"].items()
        )
        return Closure(
            name,
            a.link,
            a.translation,
            b.link,
            b.translation,
            entry["kind"],
            a.rotation,
            b.rotation,
            assembly=entry.get("assembly"),
        )

    def loop(self, name: str, entry: Mapping[str, Any], _: Path_) -> Loop:
        base, arm, k1, k2 = (
            self.places.place(entry[role])[0] for role in ("base", "arm", "k1", "k2")
        )
        return Loop(name, entry["type"], base, arm, k1, k2)

    # -- forces

    def effects(self) -> Mapping[str, JointEffect]:
        effects = read_effects(self.data["joints"], self.numbers.number)
        check_effects(effects, self.document.error)
        return effects

    def payloads(self) -> Mapping[str, tuple[str, Payload]]:
        def inertia(entry: Any, mass: float, path: Path_) -> Array:
            return read_inertia(self.numbers, entry, mass, path, TRIANGLE_SLACK)

        entries = self.data.get("payloads", {})
        return read_payloads(entries, self.numbers.number, inertia, self.document.error)


def _moved(link: Link, pose: Transform) -> Link:
    """The link with its data in the frame in which `pose` stands."""
    if pose.is_identity():
        return link
    inertia = pose.rotation @ link.inertia @ pose.rotation.T
    return Link(link.name, link.mass, pose.point(link.com), frozen((inertia + inertia.T) / 2.0))


def _joined(a: Link, b: Link) -> Link:
    """Two bodies given in one frame as one."""
    mass = a.mass + b.mass
    com = frozen((a.mass * a.com + b.mass * b.com) / mass)
    inertia = a.inertia + b.inertia + a.mass * _spread(a.com - com) + b.mass * _spread(b.com - com)
    return Link(a.name, mass, com, frozen(inertia))


def _same_place(one: Frame, other: Frame) -> bool:
    apart = max(
        np.abs(one.translation - other.translation).max(),
        np.abs(one.rotation - other.rotation).max(),
    )
    return one.link == other.link and bool(apart <= SAME_PLACE)


def _spread(arm: Array) -> Array:
    """Steiner's term of a unit mass."""
    return np.asarray(arm @ arm * np.eye(3) - np.outer(arm, arm))
