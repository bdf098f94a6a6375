"""A robot.yaml beside its URDF: pairs of frames that close the loops, and the motors.

Keys: closed_loop (pairs), type (3d or 6d, one a pair), name_mot (motors), joint_name and joint_type
(joints to replace: SPHERICAL, UJOINT_XY and the like, FIXED). A pair names links, or joints for the
frame of their child.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...description.checks.schema import check_schema
from ...description.defaults import farthest_link, neutral_coordinate
from ...description.document import Data, Document, KeyPath
from ...description.followers import multipliers_of
from ...description.values import read_each
from ...ground.regular_files import may_be_file
from ...ground.suggestions import suggestion
from ...ground.wording import counted
from ..extras_reader import EXTRAS_DEFINITION, TAG, apply_extras
from ..urdf.reader import add_urdf

_KINDS = {"3d": "point", "6d": "frame"}
_KEYS = frozenset({"closed_loop", "type", "name_mot", "joint_name", "joint_type"})
_MAX_LISTED = 5  # files in a message


def is_gepetto(data: Any) -> bool:
    """Whether a YAML document is of this kind."""
    return isinstance(data, dict) and "format" not in data and not _KEYS.isdisjoint(data)


def gepetto_document(document: Document) -> Document:
    """The same robot as a document of format 1, with the lines of both files.

    Raises:
        DescriptionError: one of the files is wrong, or has unsupported content.
    """
    reader = _GepettoReader(document)
    reader.read()
    return document


class _GepettoReader:
    def __init__(self, document: Document) -> None:
        self.document = document
        self.given: Data = document.data  # the keys of the robot.yaml
        check_schema(document, "gepetto")
        self.extras = document.subdocument(TAG)
        check_schema(self.extras, EXTRAS_DEFINITION)

    def read(self) -> None:
        """Fill the document with the URDF, its closures and motors."""
        document = self.document
        for key in self.given:
            if key not in _KEYS and key != TAG:
                document.notes.append(f"{key}: not used")
        document.data = {"format": 1}
        urdf = self.urdf_file()
        replacements = self.replacements()
        document.data["name"] = add_urdf(document, urdf, replacements, ("joint_name",))
        document.data["source"] = f"{urdf.name} and its loops"
        self.add_closures()
        document.data["active"] = self.motors()
        document.data["active_set"] = "motors"
        if "end_effector" not in self.extras.data:
            document.data["end_effector"] = {"link": farthest_link(document)}
        for name, joint in document.section("joints").items():
            if joint["type"] != "fixed":
                coordinate = neutral_coordinate(joint)
                document.add(("reference", name), coordinate, ("joints", name))
        apply_extras(document, self.extras)

    def given_list(self, key: str) -> list[Any]:
        """The list of a key, which may be empty or missing."""
        return list(self.given.get(key) or [])

    def urdf_file(self) -> Path:
        """robot.urdf beside robot.yaml, or the only URDF of the folder."""
        if not self.document.file:
            raise self.document.error(
                (), "the URDF is looked for beside the file; give the file's path"
            )
        file = Path(self.document.file)
        beside = file.with_suffix(".urdf")
        if may_be_file(beside):
            return beside
        others = sorted(file.parent.glob("*.urdf"))
        if len(others) == 1:
            return others[0]
        existing = "no other"
        if others:
            listed = ", ".join(other.name for other in others[:_MAX_LISTED])
            existing = f"{len(others)} others ({listed})"
        raise self.document.error(
            (), f"there is no {beside.name} beside it, and {existing}; keep the two together"
        )

    def replacements(self) -> dict[str, str]:
        """The replacement of each joint, by name."""
        names = self.given_list("joint_name")
        kinds = self.given_list("joint_type")
        if len(names) != len(kinds):
            entries = counted(len(kinds), "entry", "entries")
            raise self.document.error(
                ("joint_type",), f"has {entries} for {len(names)} of joint_name"
            )
        for k, name in enumerate(names):
            if name in names[:k]:
                raise self.document.error(("joint_name", k), f"'{name}' is named twice")
            self.document.alias(("joint_name", name), ("joint_name", k))
        return dict(zip(names, kinds, strict=True))

    # -- closures

    def add_closures(self) -> None:
        pairs = self.given_list("closed_loop")
        names = self.extras.data.pop("pairs", [])
        kinds = self.kinds(len(pairs))
        for k, pair in enumerate(pairs):
            name = f"loop_{k + 1}"
            if k < len(names):
                name = names[k]
            self.add_closure(name, kinds[k], pair, ("closed_loop", k))

    def kinds(self, count: int) -> list[str]:
        """The kind of closure of each pair."""
        types = self.given_list("type")
        if count and not types:
            self.document.notes.append("type: not given; every pair is taken as 6d")
            types = ["6d"] * count
        if count and len(types) != count:
            entries = counted(len(types), "entry", "entries")
            raise self.document.error(
                ("type",), f"has {entries} for {counted(count, 'pair')} of closed_loop"
            )
        return [_KINDS[pair_type.lower()] for pair_type in types]

    def add_closure(self, name: str, kind: str, pair: list[str], path: KeyPath) -> None:
        a, b = read_each(self.link, pair, path)
        if a == b:
            raise self.document.error(path, "names one frame twice")
        between = {a: [0, 0, 0], b: [0, 0, 0]}
        entry = {"kind": kind, "between": between}
        self.document.add(("closures", name), entry, path)

    def link(self, name: str, path: KeyPath) -> str:
        """The link under a name; a joint stands for the frame of its child."""
        links = self.document.section("links")
        joints = self.document.section("joints")
        if name in links:
            return name
        if name in joints:
            self.document.notes.append(
                f"{name}: a joint where a frame is meant; taken as its child link"
            )
            return str(joints[name]["child"])
        hint = suggestion(name, [*links, *joints])
        raise self.document.error(path, f"there is no frame '{name}'{hint} in the URDF")

    # -- motors

    def motors(self) -> list[str]:
        joints = self.document.section("joints")
        moving = [name for name, joint in joints.items() if joint["type"] != "fixed"]
        motors: list[str] = self.given_list("name_mot")
        for k, name in enumerate(motors):
            path: KeyPath = ("name_mot", k)
            if name not in moving:
                raise self.document.error(path, self.no_motor(name, moving))
            if name in motors[:k]:
                raise self.document.error(path, f"'{name}' is named twice")
            self.document.alias(("active", k), path)
            if "mimic" in joints[name]:
                sources = multipliers_of(joints[name].pop("mimic"))
                self.document.notes.append(
                    f"{name}: named as a motor, so it does not follow '{', '.join(sources)}'"
                )
        return motors

    def no_motor(self, name: str, moving: list[str]) -> str:
        if name in self.document.section("joints"):
            return f"'{name}' is a fixed joint; a motor moves one"
        axes = (f"{name}_X", f"{name}_Y", f"{name}_Z")
        replaced_by = [joint for joint in moving if joint in axes]
        hint = suggestion(name, moving)
        if replaced_by:
            hint = f"; it is replaced by {', '.join(replaced_by)}"
        return f"there is no joint '{name}'{hint} in the URDF"
