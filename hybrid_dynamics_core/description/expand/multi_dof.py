"""Joints of several freedoms: each becomes a chain of joints of one freedom, on massless links.

Coordinates are named after the joint. A ball or free joint has three angles about x, y and z of its
frame, which `algebra.charts` keeps regular.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

from ...algebra.charts import angles_of, better_chart
from ...ground.arrays import Array
from ...ground.suggestions import no_such_name
from ..document import Data, Document, KeyPath
from ..geometry import IDENTITY, rotation_with_z_axis
from ..model import MultiDofJoint
from ..values import ValueReader

FLOATING = "floating_base"  # name of the joint of a floating base
WORLD = "world"  # name of the link that carries it

_SPECIAL_KEYS = ("axis2", "pitch", "each")
# effects that act along the components of the angular velocity
_OF_ANGULAR_VELOCITY = ("friction", "drive")
# effects of a ball or free joint, equal in all directions
_OF_ALL = (*_OF_ANGULAR_VELOCITY, "spring")
_LIMITS = (
    "limits",
    "effort_limit",
    "velocity_limit",
    "power_limit",
    "acceleration_limit",
    "effort_table",
)
_ALONG = (*_OF_ANGULAR_VELOCITY, "spring", *_LIMITS)


class _Row(NamedTuple):
    """One joint of the chain: suffix of its name, type and axis."""

    suffix: str
    type: str
    axis: str


_SLIDES = (_Row("_x", "prismatic", "x"), _Row("_y", "prismatic", "y"))
_TURNS = (
    _Row("_rx", "revolute", "x"),
    _Row("_ry", "revolute", "y"),
    _Row("_rz", "revolute", "z"),
)
_ROWS: dict[str, tuple[_Row, ...]] = {
    "universal": (_Row("_1", "revolute", "axis"), _Row("_2", "revolute", "axis2")),
    "cylindrical": (_Row("_turn", "revolute", "axis"), _Row("_slide", "prismatic", "axis")),
    "screw": (_Row("", "revolute", "axis"), _Row("_slide", "prismatic", "axis")),
    "planar": (*_SLIDES, _Row("_turn", "revolute", "z")),
    "ball": _TURNS,
    "free": (*_SLIDES, _Row("_z", "prismatic", "z"), *_TURNS),
}


def expand_multi_dof(document: Document) -> None:
    """Replace every joint of several freedoms, also where coordinates or references name it.

    Raises:
        DescriptionError: a key belongs to another type, or an orientation fits no such joint.
    """
    _add_floating_base(document)
    for name, entry in document.data.pop("multi_dof", {}).items():
        document.multi_dof[name] = _joined(document, name, entry)
    for name, entry in list(document.entries("joints").items()):
        _check_keys(document, name, entry)
        if entry["type"] in _ROWS:
            _Expansion(document, name, entry).run()
    for section in ("active", "idle"):
        _name_coordinates(document, section)


def _add_floating_base(document: Document) -> None:
    if not document.data.pop("floating", False):
        return
    base = document.data.get("base", "base")
    document.section("links").setdefault(base, {})
    document.data["base"] = WORLD
    joint = {"type": "free", "parent": WORLD, "child": base}
    document.add(("joints", FLOATING), joint, ("floating",), remedy=f"rename joint '{FLOATING}'")
    idle = document.data.setdefault("idle", [])
    if FLOATING not in (*idle, *document.data["active"]):
        idle.append(FLOATING)


def _check_keys(document: Document, name: str, entry: Data) -> None:
    """Raise for a key that a joint of this type does not have."""
    allowed = {"universal": ("axis2", "each"), "screw": ("pitch",)}
    special: Sequence[str] = allowed.get(entry["type"], ())
    if entry["type"] in _ROWS and entry["type"] != "screw":
        special = (*special, "each")
    for key in _SPECIAL_KEYS:
        if key in entry and key not in special:
            raise document.error(("joints", name, key), f"a {entry['type']} joint has no {key}")


def _joined(document: Document, name: str, entry: Data) -> MultiDofJoint:
    """A chain of joints that the file writes out, as one joint of several freedoms."""
    joints = document.entries("joints")
    path: KeyPath = ("multi_dof", name, "joints")
    rows = _ROWS[entry["type"]]
    types: list[str] = []
    for k, joint in enumerate(entry["joints"]):
        if joint not in joints:
            raise document.error((*path, k), no_such_name("joint", joint, list(joints)))
        types.append(joints[joint]["type"])
    if types != [row.type for row in rows]:
        expected = ", ".join(row.type for row in rows)
        problem = f"are {', '.join(types)}; a {entry['type']} joint is {expected}, in this order"
        raise document.error(path, problem)
    for before, after in pairwise(entry["joints"]):
        if joints[after]["parent"] != joints[before]["child"]:
            raise document.error(path, f"'{after}' does not stand on the child of '{before}'")
    parent = joints[entry["joints"][0]]["parent"]
    child = joints[entry["joints"][-1]]["child"]
    return MultiDofJoint(name, entry["type"], parent, child, tuple(entry["joints"]))


class _Expansion:
    """Expands one joint of several freedoms."""

    def __init__(self, document: Document, name: str, entry: Data) -> None:
        self.document = document
        self.values = ValueReader(document)
        self.name = name
        self.entry = entry
        self.path: KeyPath = ("joints", name)
        self.type = entry["type"]
        self.rows = _ROWS[self.type]
        self.joints = tuple(name + row.suffix for row in self.rows)
        self.turn = self._frame_turn()

    def run(self) -> None:
        document = self.document
        self._refuse_along()
        scope = document.scope(self.path, self.values.parameters)
        del document.section("joints")[self.name]
        parent = self.entry["parent"]
        for k, row in enumerate(self.rows):
            child = self.entry["child"]
            if k < len(self.rows) - 1:
                child = f"{self.name}_link{k + 1}"
                document.add(("links", child), {}, self.path)
            joint = {"type": row.type, "parent": parent, "child": child}
            joint |= self._pose(k) | self._along(self.joints[k])
            written = ("joints", self.joints[k])
            if written == self.path:  # the angle of a screw joint keeps the joint's name
                document.section("joints")[self.name] = joint
            else:
                document.add(written, joint, self.path, scope)
            parent = child
        multi_dof = MultiDofJoint(
            self.name, self.type, self.entry["parent"], self.entry["child"], self.joints
        )
        document.multi_dof[self.name] = multi_dof
        self._set_reference(multi_dof)

    # -- geometry

    def _frame_turn(self) -> Array:
        """The rotation (3, 3) that takes z to the axis of a planar, ball or free joint."""
        if "axis" not in self.entry or self.type in ("universal", "cylindrical", "screw"):
            return IDENTITY
        axis = self.values.axis(self.entry["axis"], (*self.path, "axis"))
        return rotation_with_z_axis(axis)

    def _pose(self, k: int) -> Data:
        """Origin and axis of a joint in the chain.

        All frames coincide with the child's at zero. Only the angles are about x, y and z of a
        frame whose z is the joint's axis.
        """
        row = self.rows[k]
        steps: list[Data] = [{}]
        if k == 0 and "origin" in self.entry:
            steps = _steps(self.entry["origin"])
        first, second, third = _TURNS
        if row == first:
            return {"origin": [*steps, {"matrix": self.turn.tolist()}], "axis": "x"}
        if row == second:
            return {"origin": steps, "axis": "y"}
        if row == third:
            back = {"matrix": self.turn.T.tolist()}
            return {"origin": back, "axis": self.turn[:, 2].tolist()}
        if row.axis in self.entry:
            return {"origin": steps, "axis": self.entry[row.axis]}
        direction = self.turn[:, "xyz".index(row.axis)]
        return {"origin": steps, "axis": direction.tolist()}

    # -- limits and effects

    def _refuse_along(self) -> None:
        """Raise for keys, such as limits, that apply to no single coordinate."""
        for key in _ALONG:
            if key in self.entry and key not in self._for_all():
                names = ", ".join(self.joints)
                raise self.document.error(
                    (*self.path, key),
                    f"a {self.type} joint has several coordinates; write {key} under"
                    f" `each: {{{self.joints[0]}: ...}}` (its coordinates: {names})",
                )
        if self.type in ("ball", "free"):
            self._require_stiffness_alone()
        for name, entry in self.entry.get("each", {}).items():
            path: KeyPath = (*self.path, "each", name)
            if name not in self.joints:
                raise self.document.error(path, no_such_name("coordinate", name, self.joints))
            if self.rows[self.joints.index(name)] in _TURNS:
                self._refuse_along_turn(entry, path)

    def _require_stiffness_alone(self) -> None:
        """Raise for a spring with more than a stiffness, which is at rest at zero."""
        for key in self.entry.get("spring", {}):
            if key != "stiffness":
                raise self.document.error(
                    (*self.path, "spring", key),
                    f"a {self.type} joint has several coordinates; its spring is at rest at zero"
                    " and has a stiffness alone",
                )

    def _refuse_along_turn(self, entry: Data, path: KeyPath) -> None:
        for key in entry:
            if key not in _OF_ANGULAR_VELOCITY:
                raise self.document.error(
                    (*path, key),
                    f"a {self.type} joint has no {key} along one of its three angles;"
                    " friction and drive act along components of its angular velocity",
                )

    def _for_all(self) -> Sequence[str]:
        """The keys that apply to every coordinate of the joint, or to its only free one."""
        if self.type == "screw":
            return _ALONG
        if self.type in ("ball", "free"):
            return _OF_ALL
        return ()

    def _along(self, joint: str) -> Data:
        """Limits, friction and other keys of one coordinate."""
        for_all = {key: self.entry[key] for key in self._for_all() if key in self.entry}
        if self.type != "screw":
            each: Data = self.entry.get("each", {}).get(joint, {})
            return for_all | each
        if joint == self.name:
            return for_all
        pitch = self.values.number(self.entry["pitch"], (*self.path, "pitch"))
        if pitch == 0.0:
            problem = "is 0 m a turn, so nothing slides; make the joint revolute"
            raise self.document.error((*self.path, "pitch"), problem)
        return {"mimic": {"joint": self.name, "multiplier": pitch / math.tau}}

    # -- reference

    def _set_reference(self, joint: MultiDofJoint) -> None:
        """Replace a pose in the reference by the joint's coordinates."""
        reference = self.document.entries("reference")
        entry = reference.get(self.name)
        if not isinstance(entry, dict):
            return
        path: KeyPath = ("reference", self.name)
        if not joint.turns:
            problem = f"is a pose; a {self.type} joint has the coordinates {', '.join(self.joints)}"
            raise self.document.error(path, problem)
        pose = self.values.pose(entry, path)
        if self.type == "ball" and pose.translation.any():
            raise self.document.error(path, "has xyz; a ball joint only turns")
        del reference[self.name]
        turned = self.turn.T @ pose.rotation @ self.turn
        chart = better_chart(turned)
        self.document.charts[self.name] = float(chart)
        along = self.turn.T @ pose.translation
        numbers = [*along, *angles_of(turned, chart)][-len(self.joints) :]
        for name, number in zip(self.joints, numbers, strict=True):
            reference[name] = float(number)
            self.document.alias(("reference", name), path)


def _steps(pose: Data | list[Data]) -> list[Data]:
    return list(pose) if isinstance(pose, list) else [pose]


def _name_coordinates(document: Document, section: str) -> None:
    """Replace names of joints of several freedoms by their coordinates."""
    if section not in document.data:
        return
    names: list[str] = []
    places: list[int] = []
    for k, name in enumerate(document.data[section]):
        joints: Iterable[str] = (name,)
        if name in document.multi_dof:
            joints = _free_coordinates(document.multi_dof[name])
        names += joints
        places += [k] * (len(names) - len(places))
    document.data[section] = names
    for k, place in enumerate(places):
        if k != place:
            document.alias((section, k), (section, place))


def _free_coordinates(joint: MultiDofJoint) -> tuple[str, ...]:
    """The coordinates of a joint that do not follow others."""
    return joint.joints[:1] if joint.type == "screw" else joint.joints
