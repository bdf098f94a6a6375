"""Shapes of MJCF as visuals: those of groups 0 to 2, which MuJoCo shows by default."""

from __future__ import annotations

import numpy as np

from ...description.document import Data
from ...description.geometry import Transform
from ..visual_elements import ROD, mesh_entry, sized
from ..xml.reader import XmlReader
from .compiler.compiled import Geom
from .compiler.model import MjcfModel
from .poses import pose_entry, pose_of

_LAST_SHOWN = 2  # largest group that is shown
_SIZES = {  # by shape: factors from sizes of MuJoCo to those of a description
    "box": (2.0, 2.0, 2.0),
    "cylinder": (1.0, 2.0),
    "sphere": (1.0,),
    "capsule": (1.0, 2.0),
    "ellipsoid": (1.0, 1.0, 1.0),
}


class VisualReader:
    """Adds the shapes of bodies to their links, with notes on shapes that are not shown."""

    def __init__(self, model: MjcfModel) -> None:
        self.model = model
        self.xml: XmlReader = model.xml

    def add(self, names: list[str]) -> None:
        """Add all shapes.

        Args:
            names: names of links by index of the body.
        """
        links = self.xml.document.section("links")
        for geom in self.model.content.geoms:
            if geom.name.startswith(ROD):
                continue
            element = self.model.element(geom.line)
            reason = self._reason_against(geom)
            if reason:
                self.xml.collect(element, "<geom>", f"not shown: {reason}")
                continue
            name = names[geom.body]
            visuals = links.setdefault(name, {}).setdefault("visuals", [])
            self.xml.locate(("links", name, "visuals", len(visuals)), element)
            visuals.append(self._entry(geom))
        self._note_contacts()
        self.xml.note_collected()

    def _note_contacts(self) -> None:
        touching = [geom for geom in self.model.content.geoms if geom.touches]
        if touching:
            times = f", here and {len(touching) - 1} times more" if len(touching) > 1 else ""
            element = self.model.element(touching[0].line)
            self.xml.note(element, f"contacts of <geom> are left out{times}")

    def _reason_against(self, geom: Geom) -> str:
        """The reason why a shape is not shown; empty if it is shown."""
        if geom.group > _LAST_SHOWN:
            return f"group {geom.group}, which MuJoCo hides"
        if geom.colour and geom.colour[3] == 0.0:
            return "invisible by its colour"
        if not geom.kind or (geom.kind == "mesh" and not (geom.mesh and geom.mesh["file"])):
            return "a plane, a height field or a mesh without a file"
        if geom.mesh and _is_skewed(geom.mesh):
            return "a mesh that is turned and scaled unevenly"
        return ""

    def _entry(self, geom: Geom) -> Data:
        pose = pose_of(geom.pos, geom.quat)
        if geom.mesh:
            scale = geom.mesh["scale"]
            entry = mesh_entry(self._file(geom), scale)
            pose = pose @ _reference(geom.mesh)
        else:
            factors = _SIZES[geom.kind]
            sizes = [a * b for a, b in zip(factors, geom.size, strict=False)]
            entry = {geom.kind: sized(geom.kind, sizes)}
        if not pose.is_identity():
            entry["origin"] = pose_entry(pose)
        if geom.colour:
            entry["colour"] = self._colour(geom)
        return entry

    def _file(self, geom: Geom) -> str:
        """The path of a mesh, in included files too relative to the main file, as in MuJoCo."""
        assert geom.mesh is not None  # noqa: S101
        path = self.model.mesh_path(geom.mesh["file"])
        element = self.model.element(geom.line)
        main = self.xml.file
        if self.xml.file_of(element) == main:
            return path
        return str(main.absolute().parent / path)

    def _colour(self, geom: Geom) -> list[float]:
        """The colour as in the file if the shape has one; MuJoCo rounds to seven digits."""
        words = self.model.element(geom.line).get("rgba").split()
        written = [float(word) for word in words]
        if np.allclose(written or [2.0], geom.colour, atol=1e-6):
            return [min(max(number, 0.0), 1.0) for number in written]
        return [min(max(number, 0.0), 1.0) for number in geom.colour]


def _is_skewed(mesh: Data) -> bool:
    is_turned = abs(mesh["refquat"][0]) != 1.0
    return is_turned and len(set(mesh["scale"])) > 1


def _reference(mesh: Data) -> Transform:
    """The pose of the frame of the file in that of the mesh, by `refpos` and `refquat`."""
    back = pose_of([0.0, 0.0, 0.0], mesh["refquat"]).inverse()
    point = back.point(np.array(mesh["refpos"]))
    shift = [-a * b for a, b in zip(mesh["scale"], point.tolist(), strict=True)]
    return pose_of(shift, [1.0, 0.0, 0.0, 0.0]) @ back
