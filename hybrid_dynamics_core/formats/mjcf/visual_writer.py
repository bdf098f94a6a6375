"""Visuals as geoms of MuJoCo, without mass and contacts.

MuJoCo refuses a model whose meshes are not there, and reads STL and OBJ. Other meshes stand aside,
with all else on their link, for this library alone.
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
_MESHES = (".stl", ".obj")  # that MuJoCo reads
_SIZES = {  # of MuJoCo, over those of a visual
    "box": (0.5, 0.5, 0.5),
    "cylinder": (1.0, 0.5),
    "sphere": (1.0,),
    "capsule": (1.0, 0.5),
    "ellipsoid": (1.0, 1.0, 1.0),
}
_Asset = tuple[str, tuple[float, ...]]  # file and scale


class VisualWriter:
    """Writes the visuals of links.

    Args:
        robot: that is written.
        folder: of the file, from which paths of meshes start; None for whole paths.

    Attributes:
        numbers: of rods, so that no two have one name.
    """

    def __init__(self, robot: RobotDescription, folder: Path | None) -> None:
        self.robot = robot
        self.folder = folder
        self.numbers = count()
        self._names: dict[_Asset, str] = {}  # of meshes

    def add_meshes(self, root: Element) -> None:
        """Add every mesh that MuJoCo reads, once for each scale; no <asset> without any."""
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
        """Add all that moves with a link; whether there is anything."""
        visuals = self.robot.visuals_on(link)
        for visual in visuals:
            if _is_read(visual):
                self._add_geom(body, visual)
        return bool(visuals)

    def aside(self) -> Data:
        """The visuals of links with a mesh that MuJoCo does not read, by link."""
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
