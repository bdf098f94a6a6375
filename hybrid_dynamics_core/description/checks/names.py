"""What the schema cannot say of names: they exist, and links and joints form one tree."""

from __future__ import annotations

from ...ground.suggestions import did_you_mean, no_such_name
from ..document import Document, KeyPath
from ..model import END_EFFECTOR
from .link_tree import LinkTree


def check_names(document: Document) -> None:
    """Check the names of an expanded document against each other.

    Raises:
        DescriptionError: the first name that does not fit.
    """
    if not document.data.get("joints"):
        raise document.error((), "there are no joints; give joints, chain, legs, modules or urdf")
    names = _NameCheck(document)
    names.check_frames()
    names.check_joints()
    names.tree.check_base()
    names.tree.check_connected()
    names.check_closures()
    names.check_active()
    names.check_payloads()
    names.check_reference()


class _NameCheck:
    def __init__(self, document: Document) -> None:
        self.document = document
        self.tree = LinkTree(document)
        self.links = _without_repeats([self.tree.base, *self.tree.links])
        self.places = _without_repeats([*self.links, *self.tree.frames])
        joints = self.tree.joints.items()
        self.moving_joints = [name for name, joint in joints if joint["type"] != "fixed"]

    def check_frames(self) -> None:
        for name, frame in self.tree.frames.items():
            if name in self.links and name != frame["link"]:
                raise self.document.error(
                    ("frames", name),
                    f"'{name}' is also the name of a link; frames need names of their own",
                )
            self._require(frame["link"], self.places, ("frames", name, "link"), "link or frame")
        for name in self.tree.frames:
            self.tree.carrier(name)
        end_effector = self.document.data["end_effector"]
        self._require(end_effector["link"], self.places, ("end_effector", "link"), "link")

    def check_joints(self) -> None:
        for name, joint in self.tree.joints.items():
            path: KeyPath = ("joints", name)
            self._require(joint["parent"], self.places, (*path, "parent"), "link")
            self._require(joint["child"], self.links, (*path, "child"), "link")
            self.tree.hang(joint["child"], name)
            if "mimic" in joint:
                self._check_mimic(name, joint["mimic"]["joint"])

    def check_closures(self) -> None:
        for name, closure in self.document.entries("closures").items():
            for link in closure["between"]:
                self._require(link, self.places, ("closures", name, "between", link), "link")

    def check_active(self) -> None:
        active = self.document.data["active"]
        idle = self.document.data.get("idle", [])
        for k, name in enumerate(active):
            self._check_coordinate(name, ("active", k), active)
        for k, name in enumerate(idle):
            self._check_coordinate(name, ("idle", k), [*active, *idle])
            if name in active:
                raise self.document.error(
                    ("idle", k), f"'{name}' is active too; an idle joint is one that nobody drives"
                )

    def _check_coordinate(self, name: str, path: KeyPath, coordinates: list[str]) -> None:
        """Check one of the independent coordinates."""
        self._refuse_link(name, path)
        self._require(name, self.moving_joints, path, "joint")
        mimic = self.tree.joints[name].get("mimic", {})
        source = mimic.get("joint")
        if source in coordinates:
            raise self.document.error(
                path, f"'{name}' follows '{source}', which is active too; leave one out"
            )

    def check_payloads(self) -> None:
        places = [*self.places, END_EFFECTOR]
        for name, payload in self.document.entries("payloads").items():
            self._require(payload["on"], places, ("payloads", name, "on"), "link or frame")

    def check_reference(self) -> None:
        for name in self.document.entries("reference"):
            self._require(name, self.moving_joints, ("reference", name), "joint")

    def _require(self, name: str, existing: list[str], path: KeyPath, kind: str) -> None:
        if name not in existing:
            raise self.document.error(path, no_such_name(kind, name, existing))

    def _refuse_link(self, name: str, path: KeyPath) -> None:
        """A link among the active joints is a slip of its own."""
        if name not in self.tree.links or name in self.tree.joints:
            return
        hint = ""
        if name in self.tree.parent_joint:
            hint = did_you_mean(self.tree.parent_joint[name])
        raise self.document.error(path, f"'{name}' is a link; name the joint that moves it{hint}")

    def _check_mimic(self, name: str, source: str) -> None:
        path: KeyPath = ("joints", name, "mimic", "joint")
        joints = self.tree.joints
        self._require(source, self.moving_joints, path, "joint")
        followed = [name]
        while "mimic" in joints[source]:
            if source in followed:
                cycle = " -> ".join([*followed, source])
                raise self.document.error(path, f"'{name}' follows itself ({cycle})")
            followed.append(source)
            source = joints[source]["mimic"]["joint"]
            if source not in joints:
                return  # an error at that joint


def _without_repeats(names: list[str]) -> list[str]:
    return list(dict.fromkeys(names))
