"""Writer of visuals in SDFormat."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from ...description.geometry import rpy_of
from ...description.model import Colour, RobotDescription, Visual
from ..visual_elements import mesh_uri
from ..xml.writer import add_text, number_text, numbers_text


class VisualWriter:
    """Writer of the visuals of links.

    Args:
        robot: the robot.
        folder: folder of the file, to which paths of meshes are relative; None for absolute paths.
    """

    def __init__(self, robot: RobotDescription, folder: Path | None) -> None:
        self.robot = robot
        self.folder = folder

    def add(self, link: Element, name: str) -> bool:
        """Add all visuals that move with a link, and return whether there are any."""
        visuals = self.robot.visuals_on(name)
        for k, visual in enumerate(visuals):
            element = SubElement(link, "visual", name=f"{name}_visual_{k}")
            self.fill(element, visual)
        return bool(visuals)

    def fill(self, element: Element, visual: Visual) -> None:
        """Add pose, shape and colour to a <visual>."""
        frame = visual.frame
        numbers = [*frame.translation, *rpy_of(frame.rotation)]
        add_text(element, "pose", numbers_text(numbers))
        geometry = SubElement(element, "geometry")
        shape = SubElement(geometry, visual.shape)
        if visual.shape == "mesh":
            add_text(shape, "uri", self.uri(visual))
            add_text(shape, "scale", numbers_text(visual.size))
        elif len(visual.size) == 3:
            tag = "size" if visual.shape == "box" else "radii"
            add_text(shape, tag, numbers_text(visual.size))
        else:
            for tag, size in zip(("radius", "length"), visual.size, strict=False):
                add_text(shape, tag, number_text(size))
        if visual.colour is not None:
            _add_colour(element, visual.colour)

    def uri(self, visual: Visual) -> str:
        """The URI of a mesh, with package:// replaced by model:// for SDFormat."""
        uri = mesh_uri(visual, self.folder, ("package://", "model://"), "file://")
        if uri.startswith("package://"):
            return uri.replace("package://", "model://", 1)
        return uri


def _add_colour(visual: Element, colour: Colour) -> None:
    opacity = colour[3]
    if opacity < 1.0:
        add_text(visual, "transparency", number_text(1.0 - opacity))
    material = SubElement(visual, "material")
    add_text(material, "ambient", numbers_text(colour))
    add_text(material, "diffuse", numbers_text(colour))
