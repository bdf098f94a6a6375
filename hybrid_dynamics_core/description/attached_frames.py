"""Frames and fixed links, which stand on moving links at a constant pose."""

from __future__ import annotations

from .entries import section_entries
from .geometry import Transform
from .model import Frame
from .values import ValueReader


class AttachedFrames:
    """Resolves a name to a moving link (or the base) and a constant pose on it.

    A frame with the name of its link replaces the link frame at the joint. All data of that link
    are then given in it. So Denavit-Hartenberg frames keep their meaning.
    """

    def __init__(self, values: ValueReader) -> None:
        self._link_frames: dict[str, Transform] = {}  # frames that replace those at the joints
        self._attached: dict[str, tuple[str, Transform]] = {}  # (carrying link, pose on it)
        for name, frame in section_entries(values, "frames").items():
            if name == frame["link"]:
                self._link_frames[name] = frame.as_pose()
            else:
                self._attached[name] = (frame["link"], frame.as_pose())
        for joint in section_entries(values, "joints").values():
            if joint["type"] == "fixed":
                link = joint["child"]
                pose = joint.pose("origin")
                link_frame = self._link_frames.pop(link, Transform())
                self._attached[link] = (joint["parent"], pose @ link_frame)

    def is_fixed(self, name: str) -> bool:
        """Whether the name stands on another link at a constant pose."""
        return name in self._attached

    def resolve(self, name: str) -> tuple[str, Transform]:
        """The moving link under a name, and the pose on it."""
        pose = Transform()
        while name in self._attached:
            name, outer_pose = self._attached[name]
            pose = outer_pose @ pose
        return name, self._link_frames.get(name, Transform()) @ pose

    def link(self, name: str) -> str:
        """The moving link under a name."""
        return self.resolve(name)[0]

    def frame(self, name: str, pose: Transform | None = None) -> Frame:
        """The frame with this name, or one at a pose on it."""
        link, transform = self.resolve(name)
        if pose is not None:
            transform = transform @ pose
        return Frame(link, transform.rotation, transform.translation)
