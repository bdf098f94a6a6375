"""A robot.yaml beside its URDF: pairs of frames that close the loops, and the motors. Read as people have it.

Keys: closed_loop (pairs), type (3d or 6d, one a pair), name_mot (motors), joint_name and joint_type
(joints to replace: SPHERICAL, UJOINT_XY and the like, FIXED). A pair names links, or joints for the
frame of their child.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...description.checks.schema import check_schema
from ...description.defaults import farthest_link, neutral_coordinate
from ...description.document import Document, KeyPath
from ...ground.suggestions import suggestion
from ...ground.wording import counted
from ..extras_reader import TAG, apply_rest
from ..urdf.reader import add_urdf

KINDS = {"3d": "point", "6d": "frame"}
PAIRS = frozenset({"closed_loop", "type", "name_mot", "joint_name", "joint_type"})
USED = PAIRS | {TAG}


def is_gepetto(data: Any) -> bool:
    """Whether a YAML document is of this kind."""
    return isinstance(data, dict) and "format" not in data and not PAIRS.isdisjoint(data)


def gepetto_document(document: Document) -> Document:
    """The same robot as a document of format 1, with the lines of both files."""
    return _Pair(document).read()


class _Pair:
    def __init__(self, document: Document) -> None:
        self.document = document
        self.told: dict[str, Any] = document.data
        check_schema(document, "gepetto")
        self.rest = document.subdocument(TAG)  # what the file says beyond pairs and motors
        check_schema(self.rest, "rest")

    def read(self) -> Document:
        document, told = self.document, self.told
        for key in told.keys() - USED:
            document.notes.append(f"{key}: not used")
        document.data = {"format": 1}
        urdf = self.urdf()
        document.data["name"] = add_urdf(document, urdf, self.replace(), ("joint_name",))
        document.data["source"] = f"{urdf.name} and its loops"
        names = self.rest.data.pop("pairs", [])
        for k, pair in enumerate(told.get("closed_loop") or []):
            self.closure(k, pair, names[k] if k < len(names) else f"loop_{k + 1}")
        document.data["active"] = self.motors()
        document.data["active_set"] = "motors"
        if "end_effector" not in self.rest.data:
            document.data["end_effector"] = {"link": farthest_link(document)}
        for name, joint in document.section("joints").items():
            if joint["type"] != "fixed":
                document.add(("reference", name), neutral_coordinate(joint), ("joints", name))
        apply_rest(document, self.rest)
        return document

    def urdf(self) -> Path:
        """robot.urdf beside robot.yaml, or the only URDF of the folder."""
        if not self.document.file:
            raise self.document.error(
                (), "the URDF is looked for beside the file; give the file's path"
            )
        file = Path(self.document.file)
        beside = file.with_suffix(".urdf")
        if beside.is_file():
            return beside
        others = sorted(file.parent.glob("*.urdf"))
        if len(others) != 1:
            told = (
                f"{len(others)} others ({', '.join(o.name for o in others[:5])})"
                if others
                else "no other"
            )
            raise self.document.error(
                (), f"there is no {beside.name} beside it, and {told}; keep the two together"
            )
        return others[0]

    def replace(self) -> dict[str, str]:
        names, kinds = (list(self.told.get(key) or []) for key in ("joint_name", "joint_type"))
        if len(names) != len(kinds):
            raise self.document.error(
                ("joint_type",),
                f"has {counted(len(kinds), 'entry', 'entries')} for {len(names)} of joint_name",
            )
        for k, name in enumerate(names):
            if name in names[:k]:
                raise self.document.error(("joint_name", k), f"'{name}' is named twice")
            self.document.alias(("joint_name", name), ("joint_name", k))
        return dict(zip(names, kinds, strict=True))

    def closure(self, k: int, pair: list[str], name: str) -> None:
        kinds = self.told.get("type") or []
        pairs = self.told["closed_loop"]
        if kinds and len(kinds) != len(pairs):
            raise self.document.error(
                ("type",),
                f"has {counted(len(kinds), 'entry', 'entries')} for {counted(len(pairs), 'pair')}"
                " of closed_loop",
            )
        if k == 0 and not kinds:
            self.document.notes.append("type: not given; every pair is taken as 6d")
        a, b = (self.frame(name, ("closed_loop", k, n)) for n, name in enumerate(pair))
        if a == b:
            raise self.document.error(("closed_loop", k), "names one frame twice")
        kind = KINDS[kinds[k].lower()] if kinds else "frame"
        entry = {"kind": kind, "between": {a: [0, 0, 0], b: [0, 0, 0]}}
        self.document.add(("closures", name), entry, ("closed_loop", k))

    def frame(self, name: str, path: KeyPath) -> str:
        """The link under a name; a joint stands for the frame of its child."""
        links, joints = self.document.section("links"), self.document.section("joints")
        if name in links:
            return name
        if name in joints:
            self.document.notes.append(
                f"{name}: a joint where a frame is meant; taken as its child link"
            )
            return str(joints[name]["child"])
        known = [*links, *joints]
        raise self.document.error(
            path, f"there is no frame '{name}'{suggestion(name, known)} in the URDF"
        )

    def motors(self) -> list[str]:
        joints = self.document.section("joints")
        moving = [name for name, joint in joints.items() if joint["type"] != "fixed"]
        motors: list[str] = list(self.told.get("name_mot") or [])
        for k, name in enumerate(motors):
            path: KeyPath = ("name_mot", k)
            if name not in moving:
                raise self.document.error(path, self.no_motor(name, moving))
            if name in motors[:k]:
                raise self.document.error(path, f"'{name}' is named twice")
            self.document.alias(("active", k), path)
            if "mimic" in joints[name]:
                source = joints[name].pop("mimic")["joint"]
                self.document.notes.append(
                    f"{name}: named as a motor, so it does not follow '{source}'"
                )
        return motors

    def no_motor(self, name: str, moving: list[str]) -> str:
        if name in self.document.section("joints"):
            return f"'{name}' is a fixed joint; a motor moves one"
        parts = [own for own in moving if own[:-2] == name and own[-2:] in ("_X", "_Y", "_Z")]
        hint = f"; it is replaced by {', '.join(parts)}" if parts else suggestion(name, moving)
        return f"there is no joint '{name}'{hint} in the URDF"
