"""Checks beyond the schema: names exist, and links and joints form one tree."""

from __future__ import annotations

from ...ground.suggestions import did_you_mean, no_such_name
from ...ground.wording import singular_or_plural
from ..document import Data, Document, KeyPath
from ..followers import form_problem, multiplier_path, multipliers_of
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
                self._check_mimic(name, joint["mimic"])

    def check_closures(self) -> None:
        for name, closure in self.document.entries("closures").items():
            for link in closure["between"]:
                self._require(link, self.places, ("closures", name, "between", link), "link")

    def check_active(self) -> None:
        active = self.document.data["active"]
        idle = self.document.data.get("idle", [])
        is_exact = self.document.data.get("active_set") != "motors"  # others are found by rank
        if self.moving_joints and is_exact and not (active or idle):
            problem = "has 0 entries; expected 1 (the driven joints: the order of u)"
            raise self.document.error(("active",), problem)
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
        sources = self._sources(name)
        if sources and all(source in coordinates for source in sources):
            followed = "' and '".join(sources)
            verb = singular_or_plural(len(sources), "is", "are")
            raise self.document.error(
                path, f"'{name}' follows '{followed}', which {verb} active too; leave one out"
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
        """Raise if a link is listed among the active joints."""
        if name not in self.tree.links or name in self.tree.joints:
            return
        hint = ""
        if name in self.tree.parent_joint:
            hint = did_you_mean(self.tree.parent_joint[name])
        raise self.document.error(path, f"'{name}' is a link; name the joint that moves it{hint}")

    def _check_mimic(self, name: str, mimic: Data) -> None:
        path: KeyPath = ("joints", name, "mimic")
        problem = form_problem(mimic)
        if problem:
            raise self.document.error(path, problem)
        for source in multipliers_of(mimic):
            key = multiplier_path(mimic, path, source)
            if "joint" in mimic:
                key = (*path, "joint")
            self._require(source, self.moving_joints, key, "joint")

    def _sources(self, name: str) -> list[str]:
        """The joints that a joint follows; empty if its entry is wrong."""
        mimic = self.tree.joints.get(name, {}).get("mimic")
        if not mimic or form_problem(mimic):
            return []
        return list(multipliers_of(mimic))


def _without_repeats(names: list[str]) -> list[str]:
    return list(dict.fromkeys(names))
