"""Joints of URDF: their links, axis, limits, friction, and the joint they follow."""

from __future__ import annotations

import numpy as np

from ...description.document import Data, KeyPath
from ...description.geometry import Transform, rotation_about, rotation_from_rpy, rpy_of, unit_axis
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

_TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "planar": "planar",
    "floating": "free",
    "spherical": "ball",  # of Bullet
}
_ONE_FREEDOM = ("revolute", "prismatic")
_X_AXIS = (1.0, 0.0, 0.0)
UNLIMITED = 1e9  # [N m or N, rad/s or m/s] a common value for no limit
_INFINITY = ("inf", "infinity")
_BOUNDS = {
    "effort": "effort_limit",
    "velocity": "velocity_limit",
    "acceleration": "acceleration_limit",
}


class JointReader:
    """Reads one <joint>."""

    def __init__(self, xml: XmlReader, element: LocatedElement, name: str) -> None:
        self.xml = xml
        self.element = element
        self.path: KeyPath = ("joints", name)

    def connection(self) -> Data:
        """Type, links and origin of the joint; fixed if its limits hold it fast."""
        entry: Data = {
            "type": self._type(),
            "parent": self._link("parent"),
            "child": self._link("child"),
            "origin": self.xml.origin(self.element, self.path),
        }
        place = self._held_at(entry["type"])
        if place:
            entry["origin"] = self._moved(entry, place)
            entry["type"] = "fixed"
        return entry

    def motion(self) -> Data:
        """Axis, limits, friction and mimic of the joint, if given."""
        if self._type() not in _ONE_FREEDOM:
            return self._motion_of_several()
        entries: Data = {"axis": self._axis()}
        limit = self.element.first("limit")
        if limit is not None:
            entries |= self._limits(limit) | self._bounds(limit)
        elif self.element.get("type") != "continuous":
            self._note(self.element, "joints without <limit>, taken as without limits")
        dynamics = self.element.first("dynamics")
        if dynamics is not None:
            entries["friction"] = self._friction(dynamics)
        mimic = self.element.first("mimic")
        if mimic is not None:
            entries["mimic"] = self._mimic(mimic)
        return entries

    def _held_at(self, kind: str) -> float:
        """The coordinate [rad or m] at which equal limits hold a joint; zero if none do."""
        limit = self.element.first("limit")
        is_free = kind not in _ONE_FREEDOM or self.element.get("type") == "continuous"
        if limit is None or is_free or self.element.first("mimic") is not None:
            return 0.0
        key = (*self.path, "limits")
        lower = self.xml.number(limit, "lower", key, 0.0)
        upper = self.xml.number(limit, "upper", key, 0.0)
        if lower != upper or not lower:
            return 0.0
        self._note(limit, f"joints that their limits hold at {lower:g}; taken as fixed there")
        return lower

    def _moved(self, entry: Data, place: float) -> Data:
        """The origin of a joint that is fixed at a coordinate [rad or m]."""
        origin = entry["origin"]
        try:
            axis = unit_axis(self._axis())
        except ValueError as error:
            raise self.xml.error(self.element, (*self.path, "axis"), str(error)) from error
        moved = Transform(translation=place * axis)
        if entry["type"] == "revolute":
            moved = Transform(rotation_about(axis, place))
        turn = rotation_from_rpy(*origin["rpy"])
        pose = Transform(turn, np.array(origin["xyz"])) @ moved
        return {"xyz": pose.translation.tolist(), "rpy": rpy_of(pose.rotation).tolist()}

    def _motion_of_several(self) -> Data:
        """Axis of a planar joint, which is the normal of its plane; empty for the others."""
        for tag in ("limit", "dynamics", "mimic"):
            if self.element.first(tag) is not None:
                kind = self.element.get("type")
                text = f"<{tag}> of {kind} joints, for which URDF gives no meaning; left out"
                self._note(self.element.first(tag) or self.element, text)
        return {"axis": self._axis()} if self._type() == "planar" else {}

    def _type(self) -> str:
        urdf_type = self.element.get("type")
        if urdf_type in _TYPES:
            return _TYPES[urdf_type]
        raise self.xml.error(
            self.element,
            (*self.path, "type"),
            f"is '{urdf_type}'; expected one of {', '.join(_TYPES)}",
        )

    def _link(self, tag: str) -> str:
        """The parent or child link."""
        key = (*self.path, tag)
        end = self.element.first(tag)
        if end is None or not end.get("link"):
            raise self.xml.error(self.element, key, f"has no <{tag} link=...>")
        self.xml.locate(key, end)
        return end.get("link")

    def _axis(self) -> list[float]:
        axis = self.element.first("axis")
        if axis is None:
            return list(_X_AXIS)
        key = (*self.path, "axis")
        direction = self.xml.numbers(axis, "xyz", 3, key)
        self.xml.locate(key, axis)
        return direction

    def _limits(self, limit: LocatedElement) -> Data:
        """Lower and upper limit, if given."""
        key = (*self.path, "limits")
        self.xml.locate(key, limit)
        lower = self.xml.number(limit, "lower", key, 0.0)
        upper = self.xml.number(limit, "upper", key, 0.0)
        if self.element.get("type") == "continuous":
            if lower or upper:
                self._note(limit, "limits of continuous joints, which have none; left out")
            return {}
        if lower > upper:
            text = "joints with a lower limit above the upper one; taken as without, as in Bullet"
            self._note(limit, text)
            return {}
        if lower or upper:
            return {"limits": [lower, upper]}
        self._note(
            limit,
            "joints with the limits 0 and 0, as programs write where none are given; taken as"
            ' without limits (a joint that does not move is of type "fixed")',
        )
        return {}

    def _bounds(self, limit: LocatedElement) -> Data:
        """Limits of effort and rate, if given."""
        entries: Data = {}
        for attribute, key in _BOUNDS.items():
            path = (*self.path, key)
            self.xml.locate(path, limit)
            value = self._bound(limit, attribute, path)
            if value <= 0.0:
                self._note(limit, f"joints with the {attribute} {value:g}, taken as not given")
            elif value < UNLIMITED:
                entries[key] = value
        return entries

    def _bound(self, limit: LocatedElement, attribute: str, path: KeyPath) -> float:
        """A limit in SI units; `UNLIMITED` if none is given."""
        if limit.get(attribute).strip().lower().lstrip("+") in _INFINITY:
            return UNLIMITED
        return self.xml.number(limit, attribute, path, UNLIMITED)

    def _note(self, element: LocatedElement, text: str) -> None:
        self.xml.collect(element, self.element.get("name"), text)

    def _friction(self, dynamics: LocatedElement) -> Data:
        key = (*self.path, "friction")
        self.xml.locate(key, dynamics)
        return {
            "viscous": self.xml.number(dynamics, "damping", key, 0.0),
            "coulomb": self.xml.number(dynamics, "friction", key, 0.0),
        }

    def _mimic(self, mimic: LocatedElement) -> Data:
        key = (*self.path, "mimic")
        self.xml.locate(key, mimic)
        return {
            "joint": mimic.get("joint"),
            "multiplier": self.xml.number(mimic, "multiplier", key, 1.0),
            "offset": self.xml.number(mimic, "offset", key, 0.0),
        }
