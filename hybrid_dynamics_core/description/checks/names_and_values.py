"""What the schema cannot say: names that exist, one tree, values within their limits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ...ground.suggestions import did_you_mean, no_such_name, suggestion
from ...ground.units import coordinate_unit
from ..document import Document, Path_
from ..model import RobotDescription


def check_names(document: Document) -> None:
    """Raise a DescriptionError at the first name of an expanded document that does not fit the others."""
    _Names(document).check()


def check_values(document: Document, robot: RobotDescription) -> None:
    """Raise a DescriptionError at the first built value that contradicts another one."""
    for name, value in robot.reference.items():
        lower, upper = robot.joints[name].limits
        if (
            robot.active_set == "exact" and not lower <= value <= upper
        ):  # from motors a reference is looked for
            kind = coordinate_unit(robot.joints[name].type)
            raise document.error(
                ("reference", name),
                f"is {value:g} {kind}, outside the limits [{lower:g}, {upper:g}] {kind} of the"
                " joint",
            )
    for closure in robot.closures:
        if closure.link_a == closure.link_b:
            raise document.error(
                ("closures", closure.name),
                f"both ends are on the link '{closure.link_a}', which cannot move in itself",
            )


class _Names:
    def __init__(self, document: Document) -> None:
        self.document = document
        data: Mapping[str, Any] = document.data
        self.base: str = data.get("base", "base")
        self.links: dict[str, Any] = data.get("links", {})
        self.joints: dict[str, Any] = data.get("joints", {})
        self.frames: dict[str, Any] = data.get("frames", {})
        self.places = list(dict.fromkeys([self.base, *self.links, *self.frames]))
        self.parent_joint: dict[str, str] = {}

    def check(self) -> None:
        if not self.joints:
            raise self.document.error(
                (), "there are no joints; give joints, chain, legs, modules or urdf"
            )
        self._frames()
        self._joints()
        self._base()
        for link in self.links:
            self._reaches_base(link)
        self._closures()
        moving = [name for name, joint in self.joints.items() if joint["type"] != "fixed"]
        active = self.document.data["active"]
        for k, name in enumerate(active):
            self._active(name, moving, ("active", k))
            source = self.joints[name].get("mimic", {}).get("joint")
            if source in active:
                problem = f"'{name}' follows '{source}', which is active too; leave one out"
                raise self.document.error(("active", k), problem)
        for name, payload in self.document.data.get("payloads", {}).items():
            self._require(
                payload["on"],
                [*self.places, "end_effector"],
                ("payloads", name, "on"),
                "link or frame",
            )
        for name in self.document.data.get("reference", {}):
            self._require(name, moving, ("reference", name), "joint")

    def _active(self, name: str, moving: Iterable[str], path: Path_) -> None:
        """A joint that moves; a link's name is a slip of its own."""
        if name in self.links and name not in self.joints:
            joint = self.parent_joint.get(name)
            problem = f"'{name}' is a link; name the joint that moves it{did_you_mean(joint) if joint else ''}"
            raise self.document.error(path, problem)
        self._require(name, moving, path, "joint")

    def _require(self, name: str, known: Iterable[str], path: Path_, kind: str) -> None:
        known = list(known)
        if name not in known:
            raise self.document.error(path, no_such_name(kind, name, known))

    def _frames(self) -> None:
        for name, frame in self.frames.items():
            if (name in self.links or name == self.base) and name != frame["link"]:
                raise self.document.error(
                    ("frames", name),
                    f"'{name}' is also the name of a link; frames need names of their own",
                )
            self._require(frame["link"], self.places, ("frames", name, "link"), "link or frame")
        for name in self.frames:
            self._carrier(name)
        self._require(
            self.document.data["end_effector"]["link"],
            self.places,
            ("end_effector", "link"),
            "link",
        )

    def _joints(self) -> None:
        links = list(dict.fromkeys([self.base, *self.links]))
        for name, joint in self.joints.items():
            path: Path_ = ("joints", name)
            self._require(joint["parent"], self.places, (*path, "parent"), "link")
            child = joint["child"]
            self._require(child, links, (*path, "child"), "link")
            if child == self.base:
                raise self.document.error(
                    (*path, "child"),
                    f"the base '{self.base}' cannot be a child; swap parent and child",
                )
            if child in self.parent_joint:
                raise self.document.error(
                    (*path, "child"),
                    f"link '{child}' already hangs on joint '{self.parent_joint[child]}'; a link"
                    " has one joint to its parent: close the second connection with a loop or a"
                    " closure",
                )
            self.parent_joint[child] = name
            if "mimic" in joint:
                self._mimic(name, joint["mimic"]["joint"])

    def _mimic(self, name: str, source: str) -> None:
        path: Path_ = ("joints", name, "mimic", "joint")
        moving = [other for other, joint in self.joints.items() if joint["type"] != "fixed"]
        self._require(source, moving, path, "joint")
        seen = [name]
        while "mimic" in self.joints[source]:
            if source in seen:
                raise self.document.error(
                    path, f"'{name}' follows itself ({' -> '.join([*seen, source])})"
                )
            seen.append(source)
            source = self.joints[source]["mimic"]["joint"]
            if source not in self.joints:
                return

    def _carrier(self, name: str) -> str:
        """The link under a frame."""
        seen: list[str] = []
        while name in self.frames and self.frames[name]["link"] != name:
            if name in seen:
                problem = f"stands on itself: {' on '.join([*seen, name])}"
                raise self.document.error(("frames", name), problem)
            seen.append(name)
            name = self.frames[name]["link"]
        return name

    def _base(self) -> None:
        """One link that hangs on nothing, where no other is the base, is the base under another name."""
        named = "base" in self.document.data or self.base in self.links
        tied = {
            link
            for entry in self.document.data.get("closures", {}).values()
            for link in entry["between"]
        }
        hung = {joint["parent"] for joint in self.joints.values()} | {
            frame["link"] for frame in self.frames.values()
        }
        loose = [link for link in self.links if link not in self.parent_joint]
        if named and self.base not in {*self.links, *hung, *tied}:
            hint = suggestion(self.base, loose or self.links)
            hint = did_you_mean(loose[0]) if len(loose) == 1 else hint
            problem = f"there is no link '{self.base}'{hint}; known: {', '.join(self.links)}"
            raise self.document.error(("base",), problem)
        if not named and self.base not in hung and len(loose) == 1:
            problem = (
                f"hangs on no joint, and no link is called '{self.base}'; if it is what does not"
                " move, write"
            )
            raise self.document.error(
                ("links", loose[0]), f"{problem} `base: {loose[0]}`, or call it '{self.base}'"
            )

    def _reaches_base(self, link: str) -> None:
        if link != self.base and link not in self.parent_joint:
            raise self.document.error(
                ("links", link),
                "no joint has this link as its child; add the joint or remove the link",
            )
        seen = [link]
        while seen[-1] != self.base:
            parent = self._carrier(self.joints[self.parent_joint[seen[-1]]]["parent"])
            if parent in seen:
                chain = " -> ".join([*seen, parent])
                raise self.document.error(
                    ("joints", self.parent_joint[link]),
                    f"the joints form a cycle ({chain}) that never reaches the base '{self.base}'; "
                    "cut it at one joint and close it there with a loop or a closure",
                )
            seen.append(parent)

    def _closures(self) -> None:
        for name, closure in self.document.data.get("closures", {}).items():
            for link in closure["between"]:
                self._require(link, self.places, ("closures", name, "between", link), "link")
