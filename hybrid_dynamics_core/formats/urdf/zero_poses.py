"""Poses of the links of a URDF with all joints at zero, and places given there."""

from __future__ import annotations

from ...description.document import Data, Document
from ...description.geometry import Transform, rotation_from_rpy, rpy_of
from ...ground.arrays import frozen

_ZERO = (0.0, 0.0, 0.0)


class ZeroPoses:
    """Links of a document whose joints are read, and that has a base.

    Args:
        document: with links and joints.
    """

    def __init__(self, document: Document) -> None:
        self._joint_to: dict[str, Data] = {}
        for joint in document.section("joints").values():
            self._joint_to[joint["child"]] = joint
        self._poses: dict[str, Transform] = {document.data["base"]: Transform()}

    def link(self, name: str) -> Transform:
        """Pose of a link in the base."""
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
        """A pose in the base as a pose in a link, as a description file has it."""
        inside = self.link(name).inverse() @ pose
        return {"xyz": inside.translation.tolist(), "rpy": rpy_of(inside.rotation).tolist()}


def as_transform(origin: Data) -> Transform:
    """The pose of an origin as a description file has it, numbers only."""
    rotation = rotation_from_rpy(*origin.get("rpy", _ZERO))
    return Transform(rotation, frozen(origin.get("xyz", _ZERO)))
