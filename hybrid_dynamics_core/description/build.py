"""Checked plain data -> frozen objects: expressions become numbers, offsets and shapes are expanded."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from .actuators import read_actuators
from .effects import JointEffect, Payload, check_effects, read_effects, read_payloads
from .expressions import evaluate
from .geometry import check_inertia, rod_inertia, rotation_about, rotation_from_rpy, unit_axis
from .located_yaml import LocatedDocument, Path_
from .model import Array, Closure, Frame, Joint, Link, Loop, RobotDescription, frozen

T = TypeVar("T")
STANDARD_GRAVITY = [0, 0, -9.81]
_FLOAT_LIMIT = 1e12  # beyond this an SI value of a robot is a slip


def build_description(document: LocatedDocument) -> RobotDescription:
    """Build every part of a schema-checked document."""
    return _Builder(document).robot()


class _Builder:
    def __init__(self, document: LocatedDocument) -> None:
        self.document = document
        self.data: dict[str, Any] = document.data
        self.parameters: dict[str, float] = {}
        for name, value in self.data.get("parameters", {}).items():
            self.parameters[name] = self.number(value, ("parameters", name))

    def robot(self) -> RobotDescription:
        data = self.data
        return RobotDescription(
            name=data["name"],
            source=data.get("source", ""),
            gravity=self.vector(data.get("gravity", STANDARD_GRAVITY), ("gravity",)),
            base=data.get("base", "base"),
            links=self.each("links", self.link),
            joints=self.each("joints", self.joint),
            closures=tuple(self.closure(name, entry) for name, entry in data.get("loops", {}).items()),
            loops=self.each("loops", lambda name, entry, _: _loop(name, entry)),
            active=tuple(data["active"]),
            end_effector="end_effector",
            frames=MappingProxyType(
                {
                    **self.each("frames", self.frame),
                    "end_effector": self.frame("", data["end_effector"], ("end_effector",)),
                }
            ),
            reference=self.each("reference", lambda _, value, path: self.number(value, path)),
            file=self.document.file,
            lines=self.document.lines(),
            effects=self.effects(),
            payloads=self.payloads(),
            actuators=read_actuators(data.get("actuators", {}), data["joints"], self.number, self.document.error),
        )

    def effects(self) -> Mapping[str, JointEffect]:
        effects = read_effects(self.data["joints"], self.number)
        check_effects(effects, self.document.error)
        return effects

    def payloads(self) -> Mapping[str, tuple[str, Payload]]:
        return read_payloads(self.data.get("payloads", {}), self.number, self.inertia, self.document.error)

    def each(self, section: str, build: Callable[[str, Any, Path_], T]) -> Mapping[str, T]:
        entries = self.data.get(section, {})
        return MappingProxyType({name: build(name, value, (section, name)) for name, value in entries.items()})

    def number(self, value: float | str, path: Path_) -> float:
        try:
            number = evaluate(value, self.parameters) if isinstance(value, str) else float(value)
        except (ValueError, OverflowError) as error:
            raise self.document.error(path, str(error)) from error
        if not math.isfinite(number) or abs(number) > _FLOAT_LIMIT:
            raise self.document.error(path, f"is {value}; expected a finite number in SI units")
        return number

    def vector(self, values: list[Any], path: Path_) -> Array:
        return frozen([self.number(v, (*path, k)) for k, v in enumerate(values)])

    def pose(self, entry: Mapping[str, Any], path: Path_) -> tuple[Array, Array]:
        xyz = self.vector(entry.get("xyz", [0, 0, 0]), (*path, "xyz"))
        roll, pitch, yaw = self.vector(entry.get("rpy", [0, 0, 0]), (*path, "rpy"))
        return rotation_from_rpy(roll, pitch, yaw), xyz

    def frame(self, _: str, entry: Mapping[str, Any], path: Path_) -> Frame:
        rotation, translation = self.pose(entry, path)
        return Frame(entry["link"], rotation, translation)

    def link(self, name: str, entry: Mapping[str, Any] | None, path: Path_) -> Link:
        entry = entry or {}
        mass = self.number(entry.get("mass", 0), (*path, "mass"))
        if mass < 0.0:
            raise self.document.error((*path, "mass"), f"is {mass:g} kg; a mass is zero or positive")
        inertia = self.inertia(entry.get("inertia", {"xx": 0}), mass, (*path, "inertia"))
        if mass == 0.0 and np.any(inertia):
            raise self.document.error((*path, "inertia"), "the link has an inertia but no mass; give its mass")
        return Link(name, mass, self.vector(entry.get("com", [0, 0, 0]), (*path, "com")), inertia)

    def inertia(self, entry: Any, mass: float, path: Path_) -> Array:
        if isinstance(entry, list):
            inertia = frozen([self.vector(row, (*path, k)) for k, row in enumerate(entry)])
        elif "rod" in entry:
            rod = entry["rod"]
            inertia = rod_inertia(mass, rod["axis"], self.number(rod["length"], (*path, "rod", "length")))
        else:
            part = {key: self.number(value, (*path, key)) for key, value in entry.items()}
            xx, yy, zz, xy, xz, yz = (part.get(key, 0.0) for key in ("xx", "yy", "zz", "xy", "xz", "yz"))
            inertia = frozen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        try:
            check_inertia(inertia)
        except ValueError as error:
            raise self.document.error(path, str(error)) from error
        return inertia

    def joint(self, name: str, entry: Mapping[str, Any], path: Path_) -> Joint:
        rotation, translation = self.pose(entry.get("origin", {}), (*path, "origin"))
        axis = self.axis(entry["axis"], (*path, "axis"))
        offset = self.number(entry.get("offset", 0), (*path, "offset"))
        if offset and entry["type"] == "revolute":
            rotation = frozen(rotation @ rotation_about(axis, offset))
        elif offset:
            translation = frozen(translation + rotation @ (axis * offset))
        return Joint(
            name,
            entry["type"],
            entry["parent"],
            entry["child"],
            rotation,
            translation,
            axis,
            self.limits(entry.get("limits"), (*path, "limits")),
        )

    def axis(self, entry: str | list[Any], path: Path_) -> Array:
        try:
            return unit_axis(entry if isinstance(entry, str) else [float(v) for v in self.vector(entry, path)])
        except ValueError as error:
            raise self.document.error(path, str(error)) from error

    def limits(self, entry: list[Any] | None, path: Path_) -> tuple[float, float]:
        if entry is None:
            return -math.inf, math.inf
        lower, upper = (float(v) for v in self.vector(entry, path))
        if lower >= upper:
            raise self.document.error(path, f"the lower limit {lower:g} is not below the upper limit {upper:g}")
        return lower, upper

    def closure(self, name: str, entry: Mapping[str, Any]) -> Closure:
        path: Path_ = ("loops", name, "pin")
        (link_a, point_a), (link_b, point_b) = entry["pin"].items()
        return Closure(
            name,
            link_a,
            self.vector(point_a, (*path, link_a)),
            link_b,
            self.vector(point_b, (*path, link_b)),
            assembly=entry.get("assembly"),
        )


def _loop(name: str, entry: Mapping[str, Any]) -> Loop:
    return Loop(name, entry["type"], entry["base"], entry["arm"], entry["k1"], entry["k2"])
