"""Poses of the links of a URDF with all joints at zero."""

from __future__ import annotations

from ...description.document import Data, Document
from ...description.geometry import Transform, rotation_from_rpy, rpy_of
from ...ground.arrays import frozen

_ZERO = (0.0, 0.0, 0.0)


class ZeroPoses:
    """Zero poses of the links of a document that has joints and a base.

    Args:
        document: a document with links and joints.
    """

    def __init__(self, document: Document) -> None:
        self._joint_to: dict[str, Data] = {}
        for joint in document.section("joints").values():
            self._joint_to[joint["child"]] = joint
        self._poses: dict[str, Transform] = {document.data["base"]: Transform()}

    def link(self, name: str) -> Transform:
        """Pose of a link in the base frame."""
        chain: list[str] = []
        while name not in self._poses:
            chain.append(name)
            name = self._joint_to[name]["parent"]
        pose = self._poses[name]
        for link in reversed(chain):
            pose = pose @ as_transform(self._joint_to[link]["origin"])
            self._poses[link] = pose
        return pose

    def in_link(self, name: str, pose: Transform) -> Data:
        """The entry of a pose relative to a link, from a pose in the base frame."""
        inside = self.link(name).inverse() @ pose
        return {"xyz": inside.translation.tolist(), "rpy": rpy_of(inside.rotation).tolist()}


def as_transform(origin: Data) -> Transform:
    """The pose of an `origin` entry that has only numbers."""
    rotation = rotation_from_rpy(*origin.get("rpy", _ZERO))
    return Transform(rotation, frozen(origin.get("xyz", _ZERO)))
