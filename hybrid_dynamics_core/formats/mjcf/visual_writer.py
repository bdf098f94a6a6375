"""Visuals as geoms of MuJoCo, without mass and contacts.

MuJoCo refuses a model with missing meshes, and reads STL and OBJ only. For links with other meshes,
all visuals are written as extras, which only this library reads.
"""

from __future__ import annotations

from itertools import count
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from ...algebra.rotations import canonical, quaternion
from ...description.document import Data
from ...description.model import RobotDescription, Visual
from ..visual_elements import mesh_uri, visual_entries
from ..xml.writer import numbers_text

INVISIBLE_TO_CONTACTS = {"contype": "0", "conaffinity": "0"}
_MESHES = (".stl", ".obj")  # suffixes that MuJoCo reads
_SIZES = {  # by shape: factors from sizes of a visual to those of MuJoCo
    "box": (0.5, 0.5, 0.5),
    "cylinder": (1.0, 0.5),
    "sphere": (1.0,),
    "capsule": (1.0, 0.5),
    "ellipsoid": (1.0, 1.0, 1.0),
}
_Asset = tuple[str, tuple[float, ...]]  # file and scale


class VisualWriter:
    """Writer of the visuals of links.

    Args:
        robot: the robot.
        folder: folder of the file, to which paths of meshes are relative; None for absolute paths.

    Attributes:
        numbers: counter for unique names of rods.
    """

    def __init__(self, robot: RobotDescription, folder: Path | None) -> None:
        self.robot = robot
        self.folder = folder
        self.numbers = count()
        self._names: dict[_Asset, str] = {}  # names of meshes

    def add_meshes(self, root: Element) -> None:
        """Add every mesh that MuJoCo reads, once for each scale, to an <asset>."""
        for visuals in self.robot.visuals.values():
            for visual in visuals:
                if visual.uri and _is_read(visual):
                    self._names.setdefault(self._asset(visual), f"mesh_{len(self._names)}")
        if not self._names:
            return
        assets = SubElement(root, "asset")
        for (file, scale), name in self._names.items():
            # A shell may be open or flat; its mass is not used.
            attributes = {"name": name, "file": file, "inertia": "shell"}
            SubElement(assets, "mesh", attributes, scale=numbers_text(scale))

    def add(self, body: Element, link: str) -> bool:
        """Add all visuals that move with a link, and return whether there are any."""
        visuals = self.robot.visuals_on(link)
        for visual in visuals:
            if _is_read(visual):
                self._add_geom(body, visual)
        return bool(visuals)

    def aside(self) -> Data:
        """By link: its visuals, if it has a mesh that MuJoCo does not read."""
        entries: Data = {}
        for link in (self.robot.base, *self.robot.links):
            if not all(map(_is_read, self.robot.visuals_on(link))):
                entries[link] = visual_entries(self.robot, link, self.folder)
        return entries

    def _add_geom(self, body: Element, visual: Visual) -> None:
        attributes = {"type": visual.shape, "mass": "0", **INVISIBLE_TO_CONTACTS}
        geom = SubElement(body, "geom", attributes)
        if visual.uri:
            geom.set("mesh", self._names[self._asset(visual)])
        else:
            factors = _SIZES[visual.shape]
            sizes = [a * b for a, b in zip(factors, visual.size, strict=True)]
            geom.set("size", numbers_text(sizes))
        geom.set("pos", numbers_text(visual.frame.translation))
        x, y, z, w = canonical(quaternion(visual.frame.rotation))
        geom.set("quat", numbers_text([w, x, y, z]))
        if visual.colour is not None:
            geom.set("rgba", numbers_text(visual.colour))

    def _asset(self, visual: Visual) -> _Asset:
        return mesh_uri(visual, self.folder), visual.size


def _is_read(visual: Visual) -> bool:
    """Whether MuJoCo reads a visual."""
    if not visual.uri:
        return True
    return visual.file is not None and visual.file.suffix.lower() in _MESHES
