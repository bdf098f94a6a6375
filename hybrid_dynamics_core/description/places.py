"""Names that things are put on: links, and frames and fixed links that stand on them at a constant pose."""

from __future__ import annotations

from .document import Path_
from .geometry import Transform
from .model import Frame
from .values import Numbers


class Places:
    """Resolves a name to a moving link (or the base) and a constant pose on it.

    A frame with the name of its own link is where everything else about that link is given, in
    place of the frame at its joint: so Denavit-Hartenberg frames keep their meaning.
    """

    def __init__(self, numbers: Numbers) -> None:
        data = numbers.document.data
        self._own: dict[str, Transform] = {}
        self._on: dict[str, tuple[str, Transform]] = {}
        for name, entry in data.get("frames", {}).items():
            path: Path_ = ("frames", name)
            if name == entry["link"]:
                self._own[name] = numbers.pose(entry, path)
            else:
                self._on[name] = (entry["link"], numbers.pose(entry, path))
        for name, entry in data.get("joints", {}).items():
            if entry["type"] == "fixed":
                path = ("joints", name)
                pose = numbers.pose(entry.get("origin", {}), (*path, "origin"))
                self._on[entry["child"]] = (
                    entry["parent"],
                    pose @ self._own.pop(entry["child"], Transform()),
                )

    def is_fixed(self, link: str) -> bool:
        """Whether the name stands on another link at a constant pose."""
        return link in self._on

    def place(self, name: str) -> tuple[str, Transform]:
        """The moving link under a name and the pose on it."""
        pose = Transform()
        while name in self._on:
            name, outer = self._on[name]
            pose = outer @ pose
        return name, self._own.get(name, Transform()) @ pose

    def frame(self, name: str, pose: Transform | None = None) -> Frame:
        """The frame with this name, or one at a pose on it."""
        link, transform = self.place(name)
        if pose is not None:
            transform = transform @ pose
        return Frame(link, transform.rotation, transform.translation)
