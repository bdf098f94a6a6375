"""Writer of visuals in URDF.

URDF has no capsules and no ellipsoids, and parsers refuse a file with unknown shapes. So a capsule
is written as a cylinder with two spheres, and an ellipsoid as a sphere inside it. By their names
they are read back as the original shapes.
"""

from __future__ import annotations

from itertools import count
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from ...description.geometry import rpy_of
from ...description.model import RobotDescription, Visual
from ...ground.arrays import Array
from ..visual_elements import mesh_uri
from ..xml.writer import number_text, numbers_text
from .visuals import CAP, CAPSULE, ELLIPSOID


class VisualWriter:
    """Writer of the visuals of links.

    Args:
        robot: the robot.
        folder: folder of the file, to which paths of meshes are relative; None for absolute paths.
    """

    def __init__(self, robot: RobotDescription, folder: Path | None) -> None:
        self.robot = robot
        self.folder = folder
        self.numbers = count()  # counter for unique names

    def add(self, link: Element, name: str) -> bool:
        """Add all visuals that move with a link, and return whether there are any."""
        visuals = self.robot.visuals_on(name)
        for visual in visuals:
            self.add_visual(link, visual)
        return bool(visuals)

    def add_visual(self, link: Element, visual: Visual) -> None:
        """Add a visual as one shape, or as several substitute shapes."""
        if visual.shape == "capsule":
            self.add_capsule(link, visual)
        elif visual.shape == "ellipsoid":
            radii = numbers_text(visual.size)
            geometry = self.add_shape(link, visual, f"{ELLIPSOID} {radii} ")
            SubElement(geometry, "sphere", radius=number_text(min(visual.size)))
        elif visual.shape == "mesh":
            uri = mesh_uri(visual, self.folder, ("package://",), "file://")
            geometry = self.add_shape(link, visual, "")
            SubElement(geometry, "mesh", filename=uri, scale=numbers_text(visual.size))
        elif visual.shape == "box":
            geometry = self.add_shape(link, visual, "")
            SubElement(geometry, "box", size=numbers_text(visual.size))
        else:
            geometry = self.add_shape(link, visual, "")
            keys = ("radius", "length")[: len(visual.size)]
            sizes = dict(zip(keys, map(number_text, visual.size), strict=True))
            SubElement(geometry, visual.shape, sizes)

    def add_capsule(self, link: Element, visual: Visual) -> None:
        """Add a cylinder with a sphere at either end."""
        radius, length = visual.size
        geometry = self.add_shape(link, visual, f"{CAPSULE}_")
        SubElement(geometry, "cylinder", radius=number_text(radius), length=number_text(length))
        for half in (-0.5 * length, 0.5 * length):
            end = half * visual.frame.rotation[:, 2]
            cap = self.add_shape(link, visual, f"{CAP}_", end)
            SubElement(cap, "sphere", radius=number_text(radius))

    def add_shape(
        self, link: Element, visual: Visual, name: str, shift: Array | float = 0.0
    ) -> Element:
        """Add a <visual>, moved by a shift (3,) [m], and return its empty <geometry>."""
        element = SubElement(link, "visual")
        if name:
            element.set("name", f"{name}{next(self.numbers)}")
        origin = SubElement(element, "origin")
        origin.set("xyz", numbers_text(visual.frame.translation + shift))
        origin.set("rpy", numbers_text(rpy_of(visual.frame.rotation)))
        geometry = SubElement(element, "geometry")
        if visual.colour is not None:
            material = SubElement(element, "material", name=f"colour_{next(self.numbers)}")
            SubElement(material, "color", rgba=numbers_text(visual.colour))
        return geometry
